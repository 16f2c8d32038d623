#include "anatomesh/uncertainty/left_out.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/uncertainty/evidence.h"

namespace anatomesh {

namespace {

// So many points of a slice say how far it is from others. [points; >= 1; B]
constexpr std::uint32_t samples_per_slice = 16;
constexpr int steps_to_clamp = 12;  // A search along a line takes so many. [steps; >= 1; B]
// Slices farther away do not count as near. [slice spacings; > 1; M 2026-11, set not recorded]
constexpr double spacings_of_reach = 4;

bool draws(const ContourSet& set, std::uint32_t slice, std::uint32_t structure) {
    const auto contours = set.contours_of(set.slices[slice]);
    return std::any_of(contours.begin(), contours.end(),
                       [&](const Contour& contour) { return contour.structure == structure; });
}

// The `count` slices nearest to slice k, k itself left out, in order; and so many that draw each of its
// structures, where these may have slices of their own.
std::vector<std::uint32_t> neighbors_of(const ContourSet& set, const std::vector<PlanePatch>& patches,
                                        std::uint32_t k, std::size_t count) {
    std::vector<Vec3> samples;
    for (const Contour& contour : set.contours_of(set.slices[k])) {
        const auto points = set.points_of(contour);
        samples.insert(samples.end(), points.begin(), points.end());
    }
    const std::size_t step = samples.size() / samples_per_slice + 1;
    std::vector<std::pair<double, std::uint32_t>> order;
    for (std::uint32_t j = 0; j < patches.size(); ++j) {
        if (j == k || patches[j].box.empty()) continue;
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t n = 0; n < samples.size(); n += step)
            nearest = std::min(nearest, squared_length(patches[j].offset_from(samples[n], 0)));
        order.emplace_back(nearest, j);
    }
    std::sort(order.begin(), order.end());
    std::vector<std::uint32_t> chosen;
    for (std::size_t n = 0; n < std::min(order.size(), count); ++n) chosen.push_back(order[n].second);
    std::vector<std::uint32_t> structures;
    for (const Contour& contour : set.contours_of(set.slices[k])) structures.push_back(contour.structure);
    sort_distinct(structures);
    if (says_all(set)) structures.clear();  // there every slice tells
    for (const std::uint32_t structure : structures) {
        std::size_t found = 0;
        for (std::size_t n = 0; n < order.size() && found < count; ++n) {
            if (!draws(set, order[n].second, structure)) continue;
            chosen.push_back(order[n].second);
            ++found;
        }
    }
    sort_distinct(chosen);
    return chosen;
}

// How far the field's surface is from p along +-n; nothing within the clamp: the clamp.
double distance_along(const StructureField& field, std::uint32_t structure, Vec3 p, Vec3 n) {
    const auto inside = [&](double at) { return field.value(structure, p + at * n) < 0; };
    const bool start = inside(0);
    const double step = field.clamp() / steps_to_clamp;
    for (int k = 1; k <= steps_to_clamp; ++k) {
        for (const double way : {-1.0, 1.0}) {
            if (inside(way * k * step) == start) continue;
            double near = (k - 1) * step, far = k * step;
            for (int halving = 0; halving < 8; ++halving) {
                const double half = 0.5 * (near + far);
                (inside(way * half) == start ? near : far) = half;
            }
            return near;
        }
    }
    return field.clamp();
}

// Across the contour at its n-th point, in the slice's plane.
Vec3 across(const ContourSet& set, const Contour& contour, std::uint32_t n) {
    const auto points = set.points_of(contour);
    const Vec3 along = points[(n + 1) % points.size()] - points[(n + points.size() - 1) % points.size()];
    const Vec3 normal = cross(set.slices[contour.slice].plane.normal, along);
    return length(normal) > 0 ? normalized(normal) : set.slices[contour.slice].plane.u;
}

SliceError summary_of(std::vector<float> errors) {
    SliceError summary;
    if (errors.empty()) return summary;
    std::sort(errors.begin(), errors.end());
    double sum = 0;
    for (const float error : errors) sum += error;
    summary.points = static_cast<std::uint32_t>(errors.size());
    summary.mean_mm = sum / static_cast<double>(errors.size());
    summary.p95_mm = errors[errors.size() * 95 / 100];
    summary.max_mm = errors.back();
    return summary;
}

}  // namespace

Result<LeftOut> leave_slices_out(const ContourSet& set, const LeftOutOptions& options, RunContext& context) {
    const std::vector<PlanePatch> patches = plane_patches(set);
    const auto drawn =
        std::count_if(patches.begin(), patches.end(), [](const PlanePatch& p) { return !p.box.empty(); });
    if (drawn < 2) {
        return Error{ErrorKind::geometry,
                     "E-UNC-001",
                     "a single slice cannot be compared with others",
                     {set.source, "", "", "", std::to_string(drawn) + " slices with contours"},
                     "draw the structure on two slices or more"};
    }
    const bool is_stack = all_parallel(set, parallel_tolerance_mm);
    const double spacing = is_stack ? median_spacing(set) : plane_spacings(set, patches).median;
    FieldOptions field_options = options.field;
    if (field_options.clamp_mm <= 0) field_options.clamp_mm = 1.5 * spacing;
    // The gap that a slice leaves is twice as wide, and is to be bridged all the same.
    field_options.max_gap_spacings *= 1.2;
    if (field_options.single_slice_mm <= 0) field_options.single_slice_mm = spacing;

    LeftOut result;
    result.reach_mm = spacings_of_reach * spacing;
    result.points.resize(set.points.size());
    result.slices.resize(set.slices.size());
    parallel_for(set.slices.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (auto k = static_cast<std::uint32_t>(begin); k < end && !context.cancelled(); ++k) {
            if (patches[k].box.empty()) continue;
            const ContourSet others = chosen_slices(
                set,
                neighbors_of(set, patches, k, is_stack ? options.parallel_neighbors : options.neighbors));
            RunContext quiet;
            const auto field = make_structure_field(others, field_options, quiet);
            if (!field.ok()) continue;
            std::vector<float> errors;
            std::optional<ContourEvidence> evidence;
            std::uint32_t structure = 0;  // of the evidence; the contours of a slice come by structure
            for (const Contour& contour : set.contours_of(set.slices[k])) {
                if (!evidence || contour.structure != structure) evidence.emplace(others, contour.structure);
                structure = contour.structure;
                for (std::uint32_t n = 0; n < contour.point_count; ++n) {
                    const Vec3 p = set.points_of(contour)[n];
                    double error =
                        distance_along(*field.value(), contour.structure, p, across(set, contour, n));
                    const bool is_end = error >= field.value()->clamp();
                    const double gap = evidence->distance(p, result.reach_mm);
                    if (is_end) error = std::min(error, 0.5 * gap);  // half caps end half-way
                    LeftOutPoint& point = result.points[contour.first_point + n];
                    point = {static_cast<float>(error), static_cast<float>(gap), is_end};
                    errors.push_back(point.error_mm);
                }
            }
            result.slices[k] = summary_of(std::move(errors));
        }
    });
    if (context.cancelled()) return cancelled_error();
    return result;
}

}  // namespace anatomesh
