#include "anatomesh_io/project/project_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <functional>

#include "anatomesh_io/project/project_for_test.h"
#include "anatomesh_io/project/record_line.h"
#include "anatomesh_io/project/write_record.h"

namespace anatomesh::project_file_test {
namespace {

using namespace drawing_for_test;
using namespace project_for_test;

class Projects : public testing::TestWithParam<unsigned> {
  protected:
    Folder folder_;
    RunContext context_;
    std::string path_ = folder_.file("liver.project");
};

TEST_P(Projects, replay_gives_the_drawing_and_both_lists_of_steps) {
    RandomMoves moves(GetParam()), same_moves(GetParam());
    EditHistory history((Drawing(some_source)));
    ProjectFile project = created(path_);
    const unsigned count = 200 + GetParam() % 300;
    for (unsigned n = 1; n <= count; ++n) {
        good(moves.move(history));
        good(same_moves.move(project));
        ASSERT_EQ(project.records(), n + 1);
        if (n % 37 != 0) continue;
        const Project read = good(read_project(path_, {}, context_));
        ASSERT_TRUE(same_history(read.history, history)) << n;
        if (n % 2 == 0) {
            { const ProjectFile closed = std::move(project); }
            project = opened(path_, context_);
        }
    }
    { const ProjectFile closed = std::move(project); }
    const Project read = good(read_project(path_, {}, context_));
    EXPECT_TRUE(same_history(read.history, history));
    EXPECT_EQ(read.records, count + 1);
    EXPECT_EQ(read.whole_bytes, content_of(path_).size());
    EXPECT_FALSE(read.is_cut);
    EXPECT_TRUE(context_.warnings.empty());
    EXPECT_EQ(folder_.entries(), 1u);
    // The same moves give the same bytes.
    RandomMoves again(GetParam());
    {
        ProjectFile copy = created(folder_.file("copy"));
        for (unsigned n = 1; n <= count; ++n) good(again.move(copy));
    }
    EXPECT_EQ(content_of(folder_.file("copy")), content_of(path_));
    // All steps go back to the begin and to the end again.
    EditHistory replayed = read.history;
    while (replayed.undo().value()) {
    }
    EXPECT_TRUE(same_drawing(replayed.drawing(), Drawing(some_source)));
}

TEST_P(Projects, a_last_record_cut_at_any_byte_is_left_out_and_the_project_goes_on) {
    RandomMoves moves(GetParam());
    Project before;
    {
        ProjectFile project = created(path_);
        for (int n = 0; n < 30; ++n) {
            before.history = project.history();
            before.whole_bytes = project.bytes();
            good(moves.move(project));
        }
    }
    const std::string whole = content_of(path_);
    const std::size_t length = whole.size() - before.whole_bytes;
    for (std::size_t kept = 1; kept < length; kept += 1 + length / 60) {
        for (const bool with_zeros : {false, true}) {
            std::string torn = whole.substr(0, before.whole_bytes + kept);
            if (with_zeros) torn.resize(whole.size(), '\0');
            put(path_, torn);
            RunContext context;
            EXPECT_TRUE(good(read_project(path_, {}, context)).is_cut);
            ProjectFile project = opened(path_, context);
            ASSERT_EQ(context.warnings.size(), 2u);
            for (const Warning& warning : context.warnings) EXPECT_EQ(warning.code, "W-PRJ-001");
            ASSERT_TRUE(same_history(project.history(), before.history));
            ASSERT_EQ(content_of(path_).size(), before.whole_bytes);
            RandomMoves more(GetParam() + 1);
            good(more.move(project));
            EXPECT_TRUE(same_history(good(read_project(path_, {}, context)).history, project.history()));
            EXPECT_EQ(context.warnings.size(), 2u);
        }
    }
}

TEST_P(Projects, a_damaged_record_is_refused_with_its_number_and_what_is_before_it_can_be_saved) {
    RandomMoves moves(GetParam());
    std::vector<EditHistory> noted;
    std::vector<std::uint64_t> ends;
    {
        ProjectFile project = created(path_);
        for (int n = 0; n < 40; ++n) {
            noted.push_back(project.history());
            ends.push_back(project.bytes());
            good(moves.move(project));
        }
    }
    const std::string whole = content_of(path_);
    std::mt19937 random(GetParam());
    for (int n = 0; n < 40; ++n) {
        const std::size_t byte = random() % (ends.back() - 1);
        std::string changed = whole;
        changed[byte] = static_cast<char>(changed[byte] ^ (1 << random() % 8));
        put(path_, changed);
        const auto good_ones =
            static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), byte) - ends.begin());
        const auto open = ProjectFile::open(path_, {}, context_);
        ASSERT_FALSE(open.ok());
        ASSERT_EQ(content_of(path_), changed) << "nothing is cut off a damaged file";
        const std::string saved = folder_.file("saved");
        RunContext context;
        const auto rest = save_readable_part(path_, saved, {}, context);
        if (good_ones == 0) {
            EXPECT_EQ(open.error().code, "E-PRJ-001");
            EXPECT_FALSE(rest.ok());
            continue;
        }
        EXPECT_EQ(open.error().code, "E-PRJ-003");
        EXPECT_EQ(open.error().place.value,
                  "record " + std::to_string(good_ones) + ", byte " + std::to_string(ends[good_ones - 1]));
        EXPECT_NE(open.error().next_step.find("--recover"), std::string::npos);
        ASSERT_TRUE(rest.ok());
        ASSERT_EQ(context.warnings.size(), 1u);
        EXPECT_EQ(context.warnings[0].code, "W-PRJ-002");
        EXPECT_EQ(rest.value().records, good_ones);
        RunContext quiet;
        ASSERT_TRUE(same_history(good(read_project(saved, {}, quiet)).history, noted[good_ones - 1]));
        EXPECT_TRUE(quiet.warnings.empty());
    }
}

// Fails the n-th call with an errno; writes are cut to half of their bytes once, before.
class FailingCalls : public SystemCalls {
  public:
    FailingCalls(int n, int why) : n_(n), why_(why) {}
    bool has_failed() const { return count_ >= n_; }
    ssize_t write(int descriptor, const void* data, std::size_t size) override {
        if (count_ + 2 == n_) return ++count_, SystemCalls::write(descriptor, data, (size + 1) / 2);
        return fails() ? -1 : SystemCalls::write(descriptor, data, size);
    }
    int fsync(int descriptor) override { return fails() ? -1 : SystemCalls::fsync(descriptor); }
    int truncate(int descriptor, off_t size) override {
        return fails() ? -1 : SystemCalls::truncate(descriptor, size);
    }
    int open(const char* path, int flags, mode_t mode) override {
        return fails() ? -1 : SystemCalls::open(path, flags, mode);
    }

  private:
    bool fails() {
        if (++count_ != n_) return false;
        errno = why_;
        return true;
    }
    int n_, why_, count_ = 0;
};

TEST_P(Projects, a_call_that_fails_takes_nothing_that_was_acknowledged_and_leaves_nothing_torn) {
    for (int n = 1; n <= 34; ++n) {
        const std::string path = folder_.file("p" + std::to_string(n));
        RandomMoves moves(GetParam());
        FailingCalls calls(n, n % 2 == 0 ? ENOSPC : EIO);
        auto project = ProjectFile::create(path, some_source, calls);
        if (!project.ok()) {
            EXPECT_TRUE(calls.has_failed()) << to_line(project.error());
            continue;
        }
        int failures = 0;
        for (int move = 0; move < 16; ++move) {
            const EditHistory before = project.value().history();
            const Status status = moves.move(project.value());
            if (!status.ok()) {
                ++failures;
                EXPECT_TRUE(status.error().code == "E-PRJ-007" || status.error().code == "E-PRJ-008")
                    << to_line(status.error());
                ASSERT_TRUE(same_history(project.value().history(), before));
            }
            RunContext context;
            const Project read = good(read_project(path, {}, context));
            ASSERT_TRUE(same_history(read.history, project.value().history())) << n << ", " << move;
            if (failures == 0) {
                EXPECT_FALSE(read.is_cut);
            }
        }
        EXPECT_EQ(failures > 0, calls.has_failed());
        const EditHistory acknowledged = project.value().history();
        { const ProjectFile closed = std::move(project).value(); }
        RunContext context;
        EXPECT_TRUE(same_history(opened(path, context).history(), acknowledged));
    }
}

INSTANTIATE_TEST_SUITE_P(seeds, Projects, testing::Range(0u, 8u));

// A project with one structure, one plane and a ring.
ProjectFile with_a_ring(const std::string& path, SystemCalls& calls = SystemCalls::real()) {
    ProjectFile project = created(path, calls);
    std::mt19937 random(1);
    const Plane plane = make_plane({0, 0, 5}, {0, 0, 1});
    good(project.apply(add_structure(project.drawing(), {{1, "liver", {1, 2, 3}}, false}, "Add liver")));
    good(project.apply(add_plane(project.drawing(), 7, {plane, "k = 5", 0, false}, "Add k = 5")));
    good(project.apply(
        set_rings(project.drawing(), {7, 1}, star_rings(plane, random), "Draw liver on k = 5")));
    return project;
}

TEST(ProjectFile, a_full_disk_is_told_and_the_project_goes_on_where_there_is_space_again) {
    const Folder folder;
    const std::string path = folder.file("p");
    const pid_t child = ::fork();
    if (child == 0) {
        ProjectFile project = with_a_ring(path);
        const rlimit small{project.bytes() + 300, RLIM_INFINITY};
        ::setrlimit(RLIMIT_FSIZE, &small);
        RandomSteps steps(1);
        const EditHistory before = project.history();
        const auto rename = [&](std::size_t length) {
            return change_structure(project.drawing(), {{1, std::string(length, 'x'), {}}, false}, "Rename");
        };
        const Status full = project.apply(rename(500));
        if (full.ok() || full.error().code != "E-PRJ-007") ::_exit(1);
        if (!same_history(project.history(), before)) ::_exit(2);
        if (content_of(path).size() != project.bytes()) ::_exit(3);
        if (!project.apply(rename(5)).ok()) ::_exit(4);
        const rlimit large{RLIM_INFINITY, RLIM_INFINITY};
        ::setrlimit(RLIMIT_FSIZE, &large);
        if (!project.apply(rename(500)).ok()) ::_exit(5);
        ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
    EXPECT_EQ(WEXITSTATUS(status), 0);
    RunContext context;
    const Project read = good(read_project(path, {}, context));
    EXPECT_EQ(read.history.drawing().structure(1)->structure.name, std::string(500, 'x'));
    EXPECT_EQ(read.records, 6u);
    EXPECT_TRUE(context.warnings.empty());
}

TEST(ProjectFile, a_second_process_is_refused_until_the_first_closes_it) {
    const Folder folder;
    RunContext context;
    {
        const ProjectFile project = with_a_ring(folder.file("p"));
        const auto second = ProjectFile::open(folder.file("p"), {}, context);
        ASSERT_FALSE(second.ok());
        EXPECT_EQ(second.error().code, "E-PRJ-005");
        EXPECT_EQ(good(read_project(folder.file("p"), {}, context)).records, 4u) << "reading needs no lock";
    }
    EXPECT_EQ(opened(folder.file("p"), context).records(), 4u);
}

TEST(ProjectFile, names_that_cannot_be_opened_or_created) {
    const Folder folder;
    RunContext context;
    const auto code = [&](const std::string& path) {
        const auto project = ProjectFile::open(path, {}, context);
        return project.ok() ? std::string() : project.error().code;
    };
    EXPECT_EQ(code(folder.file("none")), "E-INP-001");
    EXPECT_EQ(code(folder.file("")), "E-INP-003");
    put(folder.file("empty"), "");
    EXPECT_EQ(code(folder.file("empty")), "E-PRJ-001");
    put(folder.file("text"), "{\"format\": \"anatomesh-contours\"}\n");
    EXPECT_EQ(code(folder.file("text")), "E-PRJ-001");
    EXPECT_EQ(content_of(folder.file("text")).size(), 33u) << "a file of others stays as it is";
    put(folder.file("contours"), record_line("{\"format\":\"anatomesh-contours\",\"version\":1}"));
    EXPECT_EQ(code(folder.file("contours")), "E-PRJ-001");
    EXPECT_EQ(ProjectFile::create(folder.file("text"), {}).error().code, "E-PRJ-010");
    EXPECT_EQ(ProjectFile::create(folder.file("none/p"), {}).error().code, "E-FILE-001");
}

TEST(ProjectFile, a_newer_version_is_refused) {
    const Folder folder;
    RunContext context;
    std::string head = head_record(some_source);
    head.replace(head.find("\"version\":1"), 11, "\"version\":2,\"news\":[]");
    put(folder.file("p"), record_line(head) + record_line("{\"n\":1,\"do\":\"something new\"}"));
    for (const bool readable_part : {false, true}) {
        const auto read = read_project(folder.file("p"), {{}, readable_part}, context);
        ASSERT_FALSE(read.ok());
        EXPECT_EQ(read.error().code, "E-PRJ-002");
        EXPECT_EQ(read.error().place.file, folder.file("p"));
    }
}

TEST(ProjectFile, a_file_that_others_change_or_remove_is_told_before_anything_is_acknowledged) {
    const Folder folder;
    RunContext context;
    const auto step = [](const ProjectFile& project) {
        return set_rings(project.drawing(), {7, 1}, {}, "Delete");
    };
    for (const bool removed : {false, true}) {
        const std::string path = folder.file(removed ? "removed" : "changed");
        ProjectFile project = with_a_ring(path);
        if (removed)
            std::filesystem::remove(path);
        else
            std::ofstream(path, std::ios::app) << "hello\n";
        const Status status = project.apply(step(project));
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().code, "E-PRJ-009");
        EXPECT_EQ(project.undo().error().code, "E-PRJ-009");
        EXPECT_EQ(project.records(), 4u);
        EXPECT_TRUE(project.drawing().rings({7, 1}));
    }
}

// Another file under the name, of equal size, or the same file under another name.
TEST(ProjectFile, a_file_that_is_no_longer_at_its_name_gets_no_step) {
    const Folder folder;
    for (const bool has_link : {false, true}) {
        const std::string path = folder.file(has_link ? "linked" : "copied"), old = path + ".old";
        ProjectFile project = with_a_ring(path);
        if (has_link) {
            std::filesystem::create_hard_link(path, old);
            std::filesystem::remove(path);
        } else {
            std::filesystem::rename(path, old);
            std::filesystem::copy_file(old, path);
        }
        const Status status = project.apply(set_rings(project.drawing(), {7, 1}, {}, "Delete"));
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().code, "E-PRJ-009");
    }
}

TEST(ProjectFile, of_many_that_create_one_name_at_once_one_does) {
    const Folder folder;
    for (int round = 0; round < 10; ++round) {
        const std::string path = folder.file("p" + std::to_string(round));
        std::vector<pid_t> children;
        for (int n = 0; n < 8; ++n) {
            children.push_back(::fork());
            if (children.back() != 0) continue;
            const auto made = ProjectFile::create(path, some_source);
            ::_exit(made.ok() ? 0 : made.error().code == "E-PRJ-010" ? 10 : 20);
        }
        int created = 0;
        for (const pid_t child : children) {
            int status = 0;
            ::waitpid(child, &status, 0);
            created += WEXITSTATUS(status) == 0;
            EXPECT_TRUE(WEXITSTATUS(status) == 0 || WEXITSTATUS(status) == 10) << WEXITSTATUS(status);
        }
        EXPECT_EQ(created, 1);
        EXPECT_EQ(folder.entries(), static_cast<std::size_t>(round) + 1) << "drafts are left";
    }
}

TEST(ProjectFile, a_head_that_no_reader_takes_leaves_no_file) {
    const Folder folder;
    DrawingSource source = some_source;
    source.pixel_mm = -1;
    EXPECT_FALSE(ProjectFile::create(folder.file("p"), source).ok());
    EXPECT_FALSE(std::filesystem::exists(folder.file("p")));
}

TEST(ProjectFile, after_a_sync_that_failed_nothing_is_acknowledged_any_more) {
    class NoSync : public SystemCalls {
      public:
        bool fails = false;
        int fsync(int descriptor) override {
            errno = EIO;
            return fails ? -1 : SystemCalls::fsync(descriptor);
        }
    };
    const Folder folder;
    NoSync calls;
    ProjectFile project = with_a_ring(folder.file("p"), calls);
    calls.fails = true;
    EXPECT_EQ(project.undo().error().code, "E-PRJ-007");
    calls.fails = false;
    EXPECT_EQ(project.undo().error().code, "E-PRJ-008");
    EXPECT_EQ(project.history().done().size(), 3u);
}

TEST(ProjectFile, nothing_to_undo_or_redo_writes_nothing) {
    const Folder folder;
    ProjectFile project = created(folder.file("p"));
    EXPECT_FALSE(good(project.undo()));
    EXPECT_FALSE(good(project.redo()));
    EXPECT_FALSE(project.apply({"Look", {}}).ok());
    EXPECT_EQ(project.records(), 1u);
    EXPECT_EQ(content_of(folder.file("p")), record_line(head_record(some_source)));
}

TEST(ProjectFile, steps_that_were_undone_and_dropped_stay_in_the_file) {
    const Folder folder;
    ProjectFile project = with_a_ring(folder.file("p"));
    EXPECT_TRUE(good(project.undo()));
    good(project.apply(change_structure(project.drawing(), {{1, "Leber", {}}, false}, "Rename")));
    EXPECT_FALSE(good(project.redo()));
    const std::string text = content_of(folder.file("p"));
    EXPECT_NE(text.find("\"do\":\"apply\",\"name\":\"Draw liver on k = 5\""), std::string::npos);
    EXPECT_NE(text.find("\"do\":\"undo\",\"name\":\"Draw liver on k = 5\""), std::string::npos);
}

TEST(ProjectFile, a_vertex_that_moves_is_written_alone) {
    const Folder folder;
    ProjectFile project = with_a_ring(folder.file("p"));
    std::mt19937 random(2);
    const Plane plane = project.drawing().plane(7)->plane;
    good(project.apply(set_rings(project.drawing(), {7, 1}, star_rings(plane, random, 3, 500), "Draw")));
    const std::uint64_t before = project.bytes();
    DrawnRings moved = *project.drawing().rings({7, 1});
    moved.points[700].x += 1e-9;
    good(project.apply(set_rings(project.drawing(), {7, 1}, moved, "Move a vertex")));
    EXPECT_LT(project.bytes() - before, 400u);
    RunContext context;
    EXPECT_TRUE(
        same_bits(*good(read_project(folder.file("p"), {}, context)).history.drawing().rings({7, 1}), moved));
}

}  // namespace
}  // namespace anatomesh::project_file_test
