// What the tests of project files share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "anatomesh/live/edit/drawing_for_test.h"
#include "anatomesh_io/project/project_file.h"

namespace anatomesh::project_for_test {

// A folder of its own, removed at the end.
class Folder {
  public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "anatomesh-project-XXXXXX").string();
        path_ = mkdtemp(name.data());
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::string file(const std::string& name) const { return (path_ / name).string(); }
    std::size_t entries() const {
        return static_cast<std::size_t>(
            std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator()));
    }

  private:
    std::filesystem::path path_;
};

inline std::string content_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

inline void put(const std::string& path, std::string_view content) {
    std::ofstream(path, std::ios::binary) << content;
}

inline bool same_change(const Change& a, const Change& b) {
    return a.key == b.key && same_value(a.before, b.before) && same_value(a.after, b.after);
}

inline bool same_steps(std::span<const Edit> a, std::span<const Edit> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Edit& p, const Edit& q) {
        return p.name == q.name && std::equal(p.changes.begin(), p.changes.end(), q.changes.begin(),
                                              q.changes.end(), same_change);
    });
}

// The drawing and both lists of steps are the same, bit for bit, and so are the revisions.
inline bool same_history(const EditHistory& a, const EditHistory& b) {
    return same_drawing(a.drawing(), b.drawing()) && a.drawing().revision() == b.drawing().revision() &&
           same_steps(a.done(), b.done()) && same_steps(a.undone(), b.undone());
}

inline const DrawingSource some_source{Frame::lps, 0.1 + 1.0 / 3, 2.5};

// The value of a result; the test fails where it has none.
template <class T>
T good(Result<T> result) {
    if (!result.ok()) {
        ADD_FAILURE() << to_line(result.error());
        std::abort();
    }
    return std::move(result).value();
}

inline ProjectFile created(const std::string& path, SystemCalls& calls = SystemCalls::real()) {
    return good(ProjectFile::create(path, some_source, calls));
}

inline ProjectFile opened(const std::string& path, RunContext& context,
                          SystemCalls& calls = SystemCalls::real()) {
    return good(ProjectFile::open(path, {}, context, calls));
}

// One random move: mostly a step, else undo or redo. Any drawing of the dice gives the same moves.
class RandomMoves {
  public:
    explicit RandomMoves(unsigned seed) : steps_(seed) {}

    // `Target` is an EditHistory or a ProjectFile.
    template <class Target>
    Status move(Target& target) {
        const std::uint32_t what = steps_.below(5);
        if (what == 0 || what == 1) {
            const Result<bool> moved = what == 0 ? target.undo() : target.redo();
            if (!moved.ok()) return moved.error();
            if (moved.value()) return Nothing{};
        }
        return target.apply(steps_.step(target.drawing()));
    }

  private:
    drawing_for_test::RandomSteps steps_;
};

}  // namespace anatomesh::project_for_test
