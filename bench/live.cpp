// How long an edit takes until its surface is there: field and preview after an edit of one contour, with what the edit
// does not touch taken over from before, and made anew; and the section of a structure on an oblique plane, 256 steps wide. Prints a row of a Markdown table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/input_options.h"
#include "anatomesh/live/preview/preview_surface.h"
#include "anatomesh/live/section/section_of_field.h"
#include "anatomesh/read_input.h"

namespace anatomesh {

namespace {

// An edit moves a stretch of a contour, of this share of its vertices, by this share of its size at most.
constexpr double edited_share = 0.25, moved_share = 0.03;
// So many steps of a section's lattice are as wide as the structure.
constexpr double section_lattice = 256;

double milliseconds(std::chrono::steady_clock::time_point from) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - from).count();
}

double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[std::min(values.size() - 1,
                           static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

// Pushes a stretch of a random contour out or in, about its middle.
void edit(ContourSet& set, std::mt19937& random) {
    const Contour& contour = set.contours[random() % set.contours.size()];
    Vec3* points = set.points.data() + contour.first_point;
    Vec3 middle;
    for (std::uint32_t n = 0; n < contour.point_count; ++n)
        middle = middle + (1.0 / contour.point_count) * points[n];
    const auto count =
        std::max<std::uint32_t>(1, static_cast<std::uint32_t>(edited_share * contour.point_count));
    const std::uint32_t first = random() % contour.point_count;
    const double most = moved_share * (random() % 2 ? 1 : -1);
    for (std::uint32_t n = 0; n < count; ++n) {
        Vec3& p = points[(first + n) % contour.point_count];
        const double share = std::sin(std::numbers::pi * (n + 0.5) / count);
        p = p + (most * share) * (p - middle);
    }
}

struct Times {
    std::vector<double> field, surface, both, anew, section;
};

Status run(const InputOptions& options, int edits, double step, int threads) {
    RunContext context;
    context.threads = threads;
    ANATOMESH_TRY(OpenedInput opened, open_input(options, context));
    ANATOMESH_TRY(const InputContours prepared, contours_of(std::move(opened), options, context));
    ContourSet set = prepared.kept;
    PreviewOptions preview;
    preview.step_mm = step;
    FieldOptions with_earlier;
    ANATOMESH_TRY(with_earlier.earlier, make_structure_field(set, {}, context));
    ANATOMESH_TRY(PreviewSurface surface, make_preview(set, *with_earlier.earlier, preview, context));
    std::mt19937 random(1);
    Times times;
    for (int n = 0; n < edits; ++n) {
        edit(set, random);
        const auto start = std::chrono::steady_clock::now();
        ANATOMESH_TRY(std::shared_ptr<const StructureField> field,
                      make_structure_field(set, with_earlier, context));
        times.field.push_back(milliseconds(start));
        const auto between = std::chrono::steady_clock::now();
        const auto unlike = stretches_unlike(*field, *with_earlier.earlier);
        std::vector<ChangedStretch> changed;
        if (unlike) {
            for (const FieldStretch& stretch : *unlike)
                changed.push_back({set.slices.front().plane, stretch.low, stretch.high});
        }
        ANATOMESH_TRY(surface, make_preview(set, *field, preview, context, nullptr,
                                            unlike ? &surface : nullptr, changed));
        times.surface.push_back(milliseconds(between));
        times.both.push_back(milliseconds(start));
        with_earlier.earlier = field;
        if (n % 20 > 0) continue;
        times.section.push_back(0);
        for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
            const Box3 box = field->box_of(s);
            const Plane plane = make_plane(0.5 * (box.low + box.high), {1, 2, 3});
            SectionOptions section;
            section.step_mm = (box.high.x - box.low.x) / section_lattice;
            const auto begin = std::chrono::steady_clock::now();
            ANATOMESH_TRY(const StructureRings rings, section_of_field(*field, s, plane, section, context));
            times.section.back() += milliseconds(begin) / static_cast<double>(set.structures.size());
        }
        const auto fresh = std::chrono::steady_clock::now();
        ANATOMESH_TRY(const auto anew, make_structure_field(set, {}, context));
        ANATOMESH_TRY(const PreviewSurface whole, make_preview(set, *anew, preview, context));
        times.anew.push_back(milliseconds(fresh));
    }
    fmt::print("| {} | {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.0f} | {:.1f} |\n",
               std::filesystem::path(options.input).filename().string(), set.slices.size(), set.points.size(),
               threads, quantile(times.field, 0.5), quantile(times.surface, 0.5), quantile(times.both, 0.5),
               quantile(times.both, 0.95), quantile(times.anew, 0.5), quantile(times.section, 0.5));
    return Nothing{};
}

}  // namespace
}  // namespace anatomesh

int main(int argc, char** argv) {
    using namespace anatomesh;
    CLI::App app("Time from an edit to its surface");
    InputOptions options;
    int edits = 200, threads = 2;
    double step = 2;
    bool header = false;
    app.add_option("--edits", edits, "So many")->check(CLI::Range(1, 100000));
    app.add_option("--step", step, "Of the preview, mm")->check(CLI::Range(0.05, 100.0));
    app.add_option("--threads", threads, "At most")->check(CLI::Range(1, 256));
    app.add_flag("--header", header, "Print the head of the table first");
    options.prepare.until = PrepareUntil::walls;
    add_reading_options(app, options);
    add_selection_options(app, options);
    CLI11_PARSE(app, argc, argv);
    if (header) {
        fmt::print(
            "| input | slices | points | threads | field, ms | surface, ms | both, ms | both p95, ms | both "
            "made "
            "anew, ms | section, ms |\n|---|---|---|---|---|---|---|---|---|---|\n");
    }
    const Status done = run(options, edits, step, threads);
    if (!done.ok()) fmt::print(stderr, "{}\n", to_line(done.error()));
    return done.ok() ? 0 : 1;
}
