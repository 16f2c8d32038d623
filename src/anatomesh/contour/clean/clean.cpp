#include "anatomesh/contour/clean/clean.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/text.h"
#include "anatomesh/contour/clean/candidate_slices.h"
#include "anatomesh/contour/clean/candidates.h"
#include "anatomesh/contour/clean/complete_slices.h"
#include "anatomesh/contour/clean/finish_set.h"
#include "anatomesh/contour/clean/reading_log.h"
#include "anatomesh/contour/clean/resolved_slices.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

namespace {

// Where all contours span less, the unit is most likely not the millimetre. [mm; > 0; C W-CON-023]
constexpr double least_span_mm = 1;
// Crowded points lie no farther apart than this share of the span of all contours, whatever the unit.
// [1; 0 to 0.01; M 2026-11 contours of 100,000 and a million points]
constexpr double crowded_span = 1e-4;

// Two structures of nearly the same name are most likely one by mistake, but only the user can tell.
Status compare_names(const RawContours& raw, RunContext& context) {
    std::map<std::string, const Structure*> seen;
    for (const Structure& structure : raw.structures) {
        if (structure.name.empty()) continue;
        const auto [entry, is_new] = seen.try_emplace(lowered_without_blanks(structure.name), &structure);
        if (is_new) continue;
        context.warn({"W-CON-002",
                      "two structures have the same name, apart from case and blanks: numbers " +
                          std::to_string(entry->second->number) + " and " + std::to_string(structure.number),
                      {raw.source, "", structure.name, "", ""},
                      "both were kept; use their numbers to choose one"});
    }
    return Nothing{};
}

// Contours that span more are not those of one patient in mm. [mm; > 0; C W-CON-035]
constexpr double most_span_mm = 3000;
// No scanner holds so much. Unless the user says that they are mm, numbers that span more are in another unit, or one of
// them is wrong. [mm; > most_span_mm; C E-CON-013]
constexpr double refused_span_mm = 10000;

// The vertex farthest from where most contours lie, the middle of their boxes' middles.
Place farthest_vertex(const RawContours& raw, const std::vector<Candidate>& candidates) {
    std::array<std::vector<double>, 3> middles;
    for (const Candidate& candidate : candidates) {
        Box3 box;
        for (const Vec3& p : candidate.points) box.extend(p);
        const Vec3 middle = 0.5 * (box.low + box.high);
        middles[0].push_back(middle.x);
        middles[1].push_back(middle.y);
        middles[2].push_back(middle.z);
    }
    for (std::vector<double>& values : middles)
        std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
    const auto median = [&](std::size_t axis) { return middles[axis][middles[axis].size() / 2]; };
    const Vec3 usual{median(0), median(1), median(2)};
    std::uint32_t contour = candidates.front().raw;
    Vec3 farthest = usual;
    for (const Candidate& candidate : candidates) {
        for (const Vec3& p : candidate.points) {
            if (!(length(p - usual) > length(farthest - usual))) continue;
            farthest = p;
            contour = candidate.raw;
        }
    }
    Place place = place_of_contour(raw, contour);
    place.value = "(" + significant_text(farthest.x, 5) + ", " + significant_text(farthest.y, 5) + ", " +
                  significant_text(farthest.z, 5) + ") mm";
    return place;
}

// Shrinks the tolerances with the span of all contours: those in mm would swallow contours in metres.
Result<CleanOptions> fitted_to_span(const RawContours& raw, const std::vector<Candidate>& candidates,
                                    CleanOptions options, RunContext& context) {
    Box3 box;
    for (const Candidate& candidate : candidates) {
        for (const Vec3& p : candidate.points) box.extend(p);
    }
    if (!candidates.empty() && box.diagonal() > refused_span_mm && !raw.unit_is_given) {
        return Error{
            ErrorKind::input, "E-CON-013",
            "all contours together span " + brief(box.diagonal() / 1000) +
                " m, so the numbers are not mm, or one is wrong; the point named is farthest from most "
                "contours",
            farthest_vertex(raw, candidates),
            "scale the numbers in the file, correct the contour, or say with --unit mm that all are right"};
    }
    options.crowded_mm = std::min(options.crowded_mm, crowded_span * box.diagonal());
    if (!candidates.empty() && box.diagonal() > most_span_mm && !raw.unit_is_given)
        context.warn({"W-CON-035",
                      "all contours together span more than a patient does; the numbers may not be mm",
                      {raw.source, "", "", "", brief(box.diagonal() / 1000) + " m"},
                      "the numbers were read as mm; if they are not, scale them in the file, or say with "
                      "--unit mm that they are"});
    if (candidates.empty() || box.diagonal() >= least_span_mm) return options;
    const double scale = box.diagonal() / least_span_mm;
    for (double* tolerance :
         {&options.planes.plane_tolerance_mm, &options.planes.group_tolerance_mm, &options.rings.corridor_mm,
          &options.rings.keyhole_mm, &options.rings.repeat_mm, &options.rings.doubtful_wall_mm,
          &options.rings.separation_mm, &options.weld_mm})
        *tolerance *= scale;
    options.rings.loop_mm2 *= scale * scale;
    if (!raw.unit_is_given)
        context.warn(
            {"W-CON-023",
             "all contours together are smaller than 1 mm; the file may be in metres or centimetres",
             {raw.source, "", "", "", brief(box.diagonal()) + " mm"},
             "the numbers were read as mm; if they are not, multiply them by 1000 or 10 in the file"});
    return options;
}

// Copies what the file says of all contours.
void describe(const RawContours& raw, std::vector<LeftOutSlice> left_out, ContourSet& set) {
    set.frame = raw.frame;
    set.pixel_mm = raw.pixel_mm;
    set.slice_thickness_mm = raw.slice_thickness_mm;
    set.complete = raw.complete;
    set.source = raw.source;
    set.left_out = std::move(left_out);
}

// The values that pass from step to step.
struct Cleaning {
    const RawContours& raw;
    CleanOptions options;
    RunContext& context;
    ReadingLog log;
    std::vector<Candidate> candidates = {};
    CandidateSlices slices = {};
    std::vector<LeftOutSlice> left_out = {};
    ResolvedSlices resolved = {};
    double welded_mm = 0;
};

// Puts the value of a step into its place.
template <class T>
Status store(std::type_identity_t<Result<T>> result, T& place) {
    ANATOMESH_TRY(place, std::move(result));
    return Nothing{};
}

using CleaningStep = Status (*)(Cleaning&);

// Every step reads some values of a Cleaning and sets others. The order matters: warnings come in this order,
// and slices are left out before anything on them can be refused.
constexpr std::array<CleaningStep, 16> cleaning_steps{
    // Names are compared: most likely two structures of one name are one.
    [](Cleaning& c) { return compare_names(c.raw, c.context); },
    // Coordinates are checked, because all that follows computes with them.
    [](Cleaning& c) { return check_coordinates(c.raw); },
    // Candidates are gathered: what may bound something, closed, and in an order that no file decides.
    [](Cleaning& c) {
        return store(gather_candidates(c.raw, c.options.closing_gap_mm, c.log), c.candidates);
    },
    // Exact repeats are dropped.
    [](Cleaning& c) { return drop_repeats(c.raw, c.candidates, c.log); },
    // Tolerances are fitted to the span of all candidates.
    [](Cleaning& c) {
        return store<CleanOptions>(fitted_to_span(c.raw, c.candidates, c.options, c.context), c.options);
    },
    // Candidates are grouped by slice.
    [](Cleaning& c) { return store(group_candidates(c.raw, c.candidates, c.options.planes), c.slices); },
    // Slices that the user names are left out.
    [](Cleaning& c) {
        return store(leave_out_slices(c.raw, c.candidates, c.options.without, c.slices, c.log), c.left_out);
    },
    // Each structure on each slice is resolved.
    [](Cleaning& c) {
        return store(
            resolve_slices(c.raw, std::move(c.candidates), c.slices.slices, c.options, c.log, c.context),
            c.resolved);
    },
    // Warnings of contours come out, in the order of the input.
    [](Cleaning& c) {
        c.log.warn(c.context);
        return Status(Nothing{});
    },
    // Structures with contours are kept.
    [](Cleaning& c) { return keep_structures(c.raw, c.resolved.set, c.context); },
    // The set is told what it is of.
    [](Cleaning& c) {
        describe(c.raw, std::move(c.left_out), c.resolved.set);
        return Status(Nothing{});
    },
    // Vertices of different structures are welded.
    [](Cleaning& c) {
        return store(weld_structures(c.resolved.set, c.options.weld_mm, c.context), c.welded_mm);
    },
    // Crowded points are left out.
    [](Cleaning& c) {
        return thin_crowded_points(c.raw, c.options.crowded_mm, c.resolved, c.log, c.context);
    },
    // Planes without contours become empty slices.
    [](Cleaning& c) {
        add_empty_slices(std::move(c.slices.empty_planes), c.options.without,
                         c.options.planes.group_tolerance_mm, c.resolved.set, c.context);
        return Status(Nothing{});
    },
    // Whether structures exclude each other is seen once all vertices are where they stay.
    [](Cleaning& c) {
        settle_exclusive(c.raw, c.resolved.set, c.context);
        return Status(Nothing{});
    },
    // What the file calls complete is told of where that is doubtful.
    [](Cleaning& c) {
        warn_about_complete_slices(c.resolved.set, c.context);
        return Status(Nothing{});
    },
};

CleanResult result_of(Cleaning cleaning) {
    CleanResult result{std::move(cleaning.resolved.set), cleaning.log.entries(), cleaning.log.stats()};
    CleanStats& stats = result.stats;
    stats.points_kept = result.kept.points.size();
    stats.contours_kept = static_cast<std::uint32_t>(result.kept.contours.size());
    stats.max_displacement_mm = std::max(stats.max_displacement_mm, cleaning.welded_mm);
    return result;
}

}  // namespace

Result<CleanResult> clean_contours(const RawContours& raw, const CleanOptions& options, RunContext& context) {
    assert(options.planes.plane_tolerance_mm >= 0);
    assert(options.planes.plane_repair_mm >= options.planes.plane_tolerance_mm);
    assert(options.planes.group_tolerance_mm >= 0 && options.closing_gap_mm >= 0);
    assert(options.rings.loop_mm2 >= 0 && options.rings.keyhole_mm >= 0);
    assert(options.rings.max_repair_area_share >= 0 && options.rings.max_repair_area_share <= 1);
    Cleaning cleaning{raw, options, context, ReadingLog(raw)};
    for (const CleaningStep step : cleaning_steps) {
        ANATOMESH_CHECK_STATUS(step(cleaning));
    }
    context.report("clean", 1);
    return result_of(std::move(cleaning));
}

}  // namespace anatomesh
