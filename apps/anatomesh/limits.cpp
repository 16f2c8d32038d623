#include "limits.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <limits>
#include <vector>

#include "anatomesh/geom/numbers.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/image/read_image.h"

namespace anatomesh {

namespace {

constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t most_32 = std::numeric_limits<std::uint32_t>::max();

// A request is not given longer. [s; 31536000; D]
constexpr std::uint64_t seconds_a_year = 365 * 86400;

struct LimitEntry {
    const char* name;
    const char* unit;
    const char* meaning;
    std::uint64_t high;
    std::function<std::uint64_t(const Limits&)> get;
    std::function<void(Limits&, std::uint64_t)> set;
};

template <class Member>
LimitEntry entry(const char* name, const char* unit, const char* meaning, std::uint64_t high, Member member) {
    return {name,
            unit,
            meaning,
            high,
            [member](const Limits& limits) { return static_cast<std::uint64_t>(member(limits)); },
            [member](Limits& limits, std::uint64_t value) {
                auto& field = member(limits);
                field = static_cast<std::remove_reference_t<decltype(field)>>(value);
            }};
}

#define ANATOMESH_FIELD(field)  \
    [](auto& limits) -> auto& { \
        return limits.field;    \
    }

const std::vector<LimitEntry>& entries() {
    static const std::vector<LimitEntry> all{
        entry("file-bytes", "bytes", "size of an input file", most, ANATOMESH_FIELD(input.max_file_bytes)),
        entry("inflated-bytes", "bytes", "size of compressed content once inflated", most,
              ANATOMESH_FIELD(input.max_inflated_bytes)),
        entry("inflate-ratio", "times", "inflated size over compressed size", most_32,
              ANATOMESH_FIELD(input.max_inflate_ratio)),
        entry("inflate-free-bytes", "bytes", "inflated size up to which inflate-ratio does not count", most,
              ANATOMESH_FIELD(input.free_inflated_bytes)),
        entry("voxels", "", "voxels of an image", most, ANATOMESH_FIELD(voxels)),
        entry("structures", "", "structures of a contour file", (std::uint64_t{1} << 31) - 1,
              ANATOMESH_FIELD(contour.structures)),
        entry("contours", "", "contours of a file", most_32, ANATOMESH_FIELD(contour.contours)),
        entry("contour-points", "", "points of a contour", most_32,
              ANATOMESH_FIELD(contour.points_per_contour)),
        entry("points", "", "points of all contours of a file", most_32, ANATOMESH_FIELD(contour.points)),
        entry("coordinate", "mm", "largest coordinate of a contour file",
              static_cast<std::uint64_t>(coordinate_bound_mm), ANATOMESH_FIELD(contour.coordinate_mm)),
        entry("project-points", "", "points of all steps of a project, also of those undone", most_32,
              ANATOMESH_FIELD(project_points)),
        entry("tetrahedra", "", "tetrahedra of a model, as estimated before it is built", most,
              ANATOMESH_FIELD(tetrahedra)),
        entry("memory-bytes", "bytes",
              "memory for a model, as estimated before it is built; 0: 80 % of what there is", most,
              ANATOMESH_FIELD(memory_bytes)),
        entry("request-seconds", "s", "time of a request to an archive in all", seconds_a_year,
              ANATOMESH_FIELD(request.seconds)),
        entry("request-bytes", "bytes", "what an archive sends in answer to a request", most,
              ANATOMESH_FIELD(request.bytes)),
        entry("request-answers", "", "answers, reports of progress and objects in answer to a request", most,
              ANATOMESH_FIELD(request.answers)),
    };
    return all;
}

#undef ANATOMESH_FIELD

void set_limit(Limits& limits, const std::string& text) {
    const std::size_t equals = text.find('=');
    const std::string name = text.substr(0, equals);
    std::vector<std::string> names;
    const LimitEntry* found = nullptr;
    for (const LimitEntry& each : entries()) {
        names.emplace_back(each.name);
        if (name == each.name) found = &each;
    }
    if (!found) {
        throw CLI::ValidationError("--limit", fmt::format("'{}' is not NAME=VALUE with one of the names {}",
                                                          text.substr(0, 60), fmt::join(names, ", ")));
    }
    const std::string number = equals == std::string::npos ? "" : text.substr(equals + 1);
    const std::uint64_t low = name == "memory-bytes" ? 0 : 1;
    const auto value = number.starts_with('+') ? std::nullopt : parse_integer<std::uint64_t>(number);
    if (!value || *value < low || *value > found->high) {
        throw CLI::ValidationError(
            "--limit", fmt::format("'{}' is not {}=N with a whole number from {} to {}", text.substr(0, 80),
                                   name, low, found->high));
    }
    found->set(limits, *value);
}

// The number that a file of the system begins with; `most` when there is none.
std::uint64_t number_in(const char* path) {
    std::ifstream file(path);
    std::string word;
    if (!(file >> word)) return most;
    return parse_integer<std::uint64_t>(word).value_or(most);
}

}  // namespace

Limits::Limits() : voxels(ReadImageOptions{}.max_voxels), tetrahedra(ModelOptions{}.max_tetrahedra) {}

std::string limits_text() {
    const Limits limits;
    std::string text =
        "The program refuses inputs and models beyond these limits.\nSet a limit by --limit NAME=VALUE.\n";
    for (const LimitEntry& each : entries()) {
        text +=
            fmt::format("{:<19} {:>12} {:<5}  {}\n", each.name, each.get(limits), each.unit, each.meaning);
    }
    return text;
}

void add_limit_option(CLI::App& verb, Limits& limits) {
    verb.add_option_function<std::vector<std::string>>(
            "--limit",
            [&limits](const std::vector<std::string>& texts) {
                for (const std::string& text : texts) set_limit(limits, text);
            },
            "Set one of the limits that --limits lists. Repeatable.")
        ->type_name("NAME=N")
        ->allow_extra_args(false);
}

std::uint64_t allowed_memory(const Limits& limits) {
    if (limits.memory_bytes > 0) return limits.memory_bytes;
    const long pages = ::sysconf(_SC_PHYS_PAGES), page = ::sysconf(_SC_PAGESIZE);
    std::uint64_t bytes = most;
    if (pages > 0 && page > 0) bytes = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page);
    // Control groups, version 2 and 1.
    bytes = std::min({bytes, number_in("/sys/fs/cgroup/memory.max"),
                      number_in("/sys/fs/cgroup/memory/memory.limit_in_bytes")});
    return bytes == most ? 0 : bytes / 5 * 4;
}

}  // namespace anatomesh
