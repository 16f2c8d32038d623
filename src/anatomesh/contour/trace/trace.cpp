#include "anatomesh/contour/trace/trace.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/model/area_change.h"
#include "anatomesh/contour/simplify/chains.h"
#include "anatomesh/contour/trace/restore_areas.h"
#include "anatomesh/contour/trace/small_pieces.h"
#include "anatomesh/contour/trace/sparse_structures.h"
#include "anatomesh/contour/trace/trace_slice.h"
#include "anatomesh/image/components.h"

namespace anatomesh {

namespace {

// Which axis of the patient (x, y, z) each voxel axis stands for: the assignment that fits all three best, so that
// each has its own, also where an image lies obliquely.
std::array<std::uint32_t, 3> patient_axes(const ImageGeometry& geometry) {
    std::array<std::uint32_t, 3> order{0, 1, 2}, best = order;
    double most = -1;
    do {
        double fit = 0;
        for (std::size_t a = 0; a < 3; ++a) {
            const Vec3 step = normalized(geometry.step[a]);
            fit += std::abs(std::array{step.x, step.y, step.z}[order[a]]);
        }
        if (fit > most + 1e-9) {
            most = fit;
            best = order;
        }
    } while (std::next_permutation(order.begin(), order.end()));
    return best;
}

// How the voxels of an image are walked slice by slice: i and j in the slice, k across.
struct SliceAxes {
    std::array<std::uint32_t, 3> axis{0, 1, 2};  // voxel axis of i, j, k
    std::array<std::uint32_t, 3> size{};
    std::array<std::size_t, 3> stride{};
    std::array<Vec3, 3> step;
    Vec3 normal;  // of the slices; its largest component is positive, so that it does not depend on the axes'
                  // signs

    SliceAxes(const ImageGeometry& geometry, const std::optional<std::uint32_t>& patient_axis) {
        std::uint32_t across = 0;
        for (std::uint32_t a = 1; a < 3; ++a) {
            // Equal but for rounding counts as equal.
            if (length(geometry.step[a]) >= length(geometry.step[across]) * (1 - 1e-6)) across = a;
        }
        if (patient_axis) {
            const std::array<std::uint32_t, 3> patient = patient_axes(geometry);
            across = static_cast<std::uint32_t>(std::find(patient.begin(), patient.end(), *patient_axis) -
                                                patient.begin());
        }
        axis = across == 2   ? std::array<std::uint32_t, 3>{0, 1, 2}
               : across == 1 ? std::array<std::uint32_t, 3>{0, 2, 1}
                             : std::array<std::uint32_t, 3>{1, 2, 0};
        const std::array<std::size_t, 3> strides{1, geometry.size[0],
                                                 std::size_t{geometry.size[0]} * geometry.size[1]};
        for (std::size_t a = 0; a < 3; ++a) {
            size[a] = geometry.size[axis[a]];
            stride[a] = strides[axis[a]];
            step[a] = geometry.step[axis[a]];
        }
        normal = normalized(cross(step[0], step[1]));
        const double x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
        const double largest = z >= x && z >= y ? normal.z : y >= x ? normal.y : normal.x;
        if (largest < 0) normal = -normal;
    }

    double pixel() const { return std::min(length(step[0]), length(step[1])); }
    double pixel_area() const { return length(cross(step[0], step[1])); }

    // Through the image's own position(), so that a coordinate that is constant in the slice stays so
    // exactly.
    Vec3 position(const ImageGeometry& geometry, Vec2 pixel_point, std::uint32_t k) const {
        std::array<double, 3> voxel{};
        voxel[axis[0]] = pixel_point.x;
        voxel[axis[1]] = pixel_point.y;
        voxel[axis[2]] = k;
        return geometry.position(voxel[0], voxel[1], voxel[2]);
    }
};

struct Settings {
    double min_pixels = 0, epsilon = 0, spacing = 0, clearance = 0;
    double threshold = 0;
};

// The contours of one slice, in their final order.
struct SliceContours {
    struct Outline {
        std::uint32_t structure, first, count;
    };
    // What a structure has in the slice: as it is labelled, without small pieces, and within its outlines.
    struct Content {
        std::uint32_t structure;
        double labelled_mm2, used_mm2, outlined_mm2;
    };
    Plane plane;
    std::uint32_t k = 0;
    std::vector<Outline> outlines;
    std::vector<Vec3> points;
    std::vector<AreaChange> changes;
    std::vector<Content> contents;  // none where outlines follow grey values
    std::uint64_t points_traced = 0, points_kept = 0;
    double max_distance = 0, max_shift = 0;
    SmallPieces small;
    std::vector<std::uint16_t> cut_by_border;  // labels, sorted
};

LabelGrid label_grid(const LabelMap& labels, const SliceAxes& axes, std::uint32_t k) {
    LabelGrid grid;
    grid.width = axes.size[0];
    grid.height = axes.size[1];
    grid.labels.assign(std::size_t{grid.row_length()} * (grid.height + 2), 0);
    const std::uint16_t* voxels = labels.voxels.data() + k * axes.stride[2];
    for (std::uint32_t j = 0; j < grid.height; ++j) {
        std::uint16_t* row = grid.labels.data() + std::size_t{j + 1} * grid.row_length() + 1;
        const std::uint16_t* from = voxels + j * axes.stride[1];
        for (std::uint32_t i = 0; i < grid.width; ++i) row[i] = from[i * axes.stride[0]];
    }
    return grid;
}

// Which sides of a slice's grid the image ends at, and whether the slice itself is the image's first or last.
struct ImageEnds {
    std::array<bool, 2> across{true, true}, along{true, true};  // low and high column, low and high row
    bool is_last_slice = false;
};

ImageEnds image_ends(const LabelMap& labels, const SliceAxes& axes, std::uint32_t k) {
    ImageEnds ends;
    const auto of_axis = [&](int axis) {
        return axes.axis[axis] == 2 ? labels.ends_at_image : std::array<bool, 2>{true, true};
    };
    ends.across = of_axis(0);
    ends.along = of_axis(1);
    const auto [low, high] = of_axis(2);
    ends.is_last_slice = axes.size[2] > 1 && ((k == 0 && low) || (k + 1 == axes.size[2] && high));
    return ends;
}

std::vector<std::uint16_t> labels_at_border(const LabelGrid& grid, const ImageEnds& ends) {
    std::vector<std::uint16_t> found;
    const auto note = [&](std::uint32_t x, std::uint32_t y) {
        const std::uint16_t label = grid.at(x, y);
        if (label != 0 && (found.empty() || found.back() != label)) found.push_back(label);
    };
    for (std::uint32_t y = 1; y <= grid.height; ++y) {
        if (ends.is_last_slice || (y == 1 && ends.along[0]) || (y == grid.height && ends.along[1])) {
            for (std::uint32_t x = 1; x <= grid.width; ++x) note(x, y);
            continue;
        }
        if (ends.across[0]) note(1, y);
        if (ends.across[1]) note(grid.width, y);
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

// Starts every outline at its smallest vertex and puts the outlines in the order of a kept contour set.
void put_in_order(SliceContours& slice) {
    for (const auto& outline : slice.outlines) {
        const auto begin = slice.points.begin() + outline.first, end = begin + outline.count;
        std::rotate(begin, std::min_element(begin, end, LexicographicLess{}), end);
    }
    std::sort(slice.outlines.begin(), slice.outlines.end(), [&](const auto& a, const auto& b) {
        if (a.structure != b.structure) return a.structure < b.structure;
        return lexicographic_less(slice.points[a.first], slice.points[b.first]);
    });
}

void note_labelled(const LabelGrid& grid, double pixel_area, SliceContours& slice) {
    std::vector<std::uint64_t> pixels;
    for (const std::uint16_t label : grid.labels) {
        if (label == 0) continue;
        if (label >= pixels.size()) pixels.resize(label + std::size_t{1}, 0);
        ++pixels[label];
    }
    for (std::uint32_t label = 1; label < pixels.size(); ++label) {
        if (pixels[label] > 0)
            slice.contents.push_back({label - 1, static_cast<double>(pixels[label]) * pixel_area, 0, 0});
    }
}

// The outlines of the kept points. `placed`: the points of the network in space.
void add_outlines(const TracedGrid& traced, const std::vector<std::uint8_t>& kept,
                  const std::vector<Vec3>& placed, const SliceAxes& axes, bool has_grey,
                  SliceContours& slice) {
    const bool mirrored = dot(cross(axes.step[0], axes.step[1]), axes.normal) < 0;
    std::vector<std::uint32_t> ring_points;
    std::vector<Vec3> whole_ring;
    for (const TracedRing& ring : traced.rings) {
        ring_points.clear();
        append_ring_points(traced, ring, ring_points);
        if (mirrored) std::reverse(ring_points.begin(), ring_points.end());
        const auto first = static_cast<std::uint32_t>(slice.points.size());
        whole_ring.clear();
        for (const std::uint32_t index : ring_points) {
            whole_ring.push_back(placed[index]);
            if (kept[index]) slice.points.push_back(placed[index]);
        }
        const auto count = static_cast<std::uint32_t>(slice.points.size()) - first;
        const std::uint32_t structure = ring.label - 1u;
        const auto outline = std::span<const Vec3>(slice.points).subspan(first);
        slice.outlines.push_back({structure, first, count});
        if (has_grey) {
            slice.changes.push_back(area_change(structure, whole_ring, outline, slice.plane.normal));
            continue;
        }
        const double of_pixels = static_cast<double>(ring.pixels) * axes.pixel_area();
        const double outlined = area_in_plane(outline, slice.plane.normal);
        slice.contents.push_back({structure, 0, of_pixels, outlined});
        slice.changes.push_back({structure, of_pixels, std::abs(outlined - of_pixels)});
    }
}

SliceContours trace_slice(const LabelMap& labels, const GreyImage* grey, const SliceAxes& axes,
                          std::uint32_t k, const Settings& settings) {
    SliceContours slice;
    slice.k = k;
    slice.plane = make_plane(axes.position(labels.geometry, {0, 0}, k), axes.normal);
    LabelGrid grid = label_grid(labels, axes, k);
    if (!grey) note_labelled(grid, axes.pixel_area(), slice);
    slice.small = leave_out_small_pieces(grid, settings.min_pixels);
    slice.cut_by_border = labels_at_border(grid, image_ends(labels, axes, k));

    GreySlice values;
    if (grey) {
        values = {grey->voxels.data() + k * axes.stride[2], axes.stride[0], axes.stride[1],
                  settings.threshold};
    }
    TracedGrid traced = trace_label_grid(grid, values);

    // Simplify in the plane's own coordinates of the final points: what holds there holds in the model.
    std::vector<Vec2>& points = traced.network.points;
    const std::vector<Vec2> in_pixels = points;
    std::vector<Vec3> placed;
    placed.reserve(points.size());
    for (Vec2& point : points) {
        placed.push_back(axes.position(labels.geometry, point, k));
        point = slice.plane.to_plane(placed.back());
    }
    ThinResult thin{std::vector<std::uint8_t>(points.size(), 1), 0};
    if (settings.epsilon > 0) {
        thin = thin_chains(traced.network, {settings.epsilon, settings.spacing, settings.clearance});
    }
    slice.max_distance = thin.max_distance;
    slice.points_traced = points.size();
    slice.points_kept = static_cast<std::uint64_t>(std::count(thin.kept.begin(), thin.kept.end(), 1));

    if (!grey) {
        points = in_pixels;
        restore_areas(traced, thin.kept, settings.epsilon / axes.pixel());
        for (std::size_t p = 0; p < points.size(); ++p) {
            if (points[p] == in_pixels[p]) continue;
            const Vec3 before = placed[p];
            placed[p] = axes.position(labels.geometry, points[p], k);
            slice.max_shift = std::max(slice.max_shift, length(placed[p] - before));
        }
    }
    add_outlines(traced, thin.kept, placed, axes, grey != nullptr, slice);
    put_in_order(slice);
    return slice;
}

std::string name_of(const Structure& structure) {
    return structure.name.empty() ? std::to_string(structure.number) : structure.name;
}

std::string slice_name(const SliceAxes& axes, std::uint32_t k) {
    return std::string(1, "ijk"[axes.axis[2]]) + " = " + std::to_string(k);
}

// Appends the slices, from the first to the last one with a contour, in order of position along the normal.
void assemble(const std::vector<SliceContours>& slices, const SliceAxes& axes, ContourSet& set) {
    const auto filled = [](const SliceContours& slice) { return !slice.outlines.empty(); };
    const auto begin = std::find_if(slices.begin(), slices.end(), filled);
    const auto end = std::find_if(slices.rbegin(), slices.rend(), filled).base();
    for (auto it = begin; it < end; ++it) {
        const bool ascending = dot(axes.step[2], axes.normal) > 0;
        const SliceContours& slice = ascending ? *it : *(end - 1 - (it - begin));
        const auto index = static_cast<std::uint32_t>(set.slices.size());
        set.slices.push_back({slice.plane, static_cast<std::uint32_t>(set.contours.size()),
                              static_cast<std::uint32_t>(slice.outlines.size()), slice_name(axes, slice.k)});
        for (const auto& outline : slice.outlines) {
            set.contours.push_back(
                {outline.structure, index, static_cast<std::uint32_t>(set.points.size()), outline.count});
            const auto first = slice.points.begin() + outline.first;
            set.points.insert(set.points.end(), first, first + outline.count);
        }
    }
}

// Of the area labelled in the kept slices: thin parts may be torn. [1; 0 to 1; C W-TRC-005]
constexpr double much_left_out = 0.05;

void sum_up(const std::vector<SliceContours>& slices, double pixel_area, TraceStats& stats) {
    for (const SliceContours& slice : slices) {
        stats.points_traced += slice.points_traced;
        stats.points_kept += slice.points_kept;
        stats.max_distance_mm = std::max(stats.max_distance_mm, slice.max_distance);
        stats.max_shift_mm = std::max(stats.max_shift_mm, slice.max_shift);
        stats.islands_left_out += slice.small.islands;
        stats.holes_filled += slice.small.holes;
        stats.area_left_out_mm2 += static_cast<double>(slice.small.island_pixels) * pixel_area;
        stats.area_filled_mm2 += static_cast<double>(slice.small.hole_pixels) * pixel_area;
    }
}

void warn_about_pieces(const TraceStats& stats, const std::string& file, RunContext& context) {
    if (stats.islands_left_out > 0) {
        context.warn({"W-TRC-002",
                      std::to_string(stats.islands_left_out) + " islands are smaller than the minimum area",
                      {file, "", "", "", ""},
                      "they were left out; --min-area 0 keeps them"});
    }
    if (stats.holes_filled > 0) {
        context.warn({"W-TRC-003",
                      std::to_string(stats.holes_filled) + " holes are smaller than the minimum area",
                      {file, "", "", "", ""},
                      "they were filled; --min-area 0 keeps them"});
    }
}

// Of the volume of a structure's voxels: a larger difference is told. [1; 0 to 1; C W-TRC-009]
constexpr double told_difference = 0.005;

// Four digits or more, without an exponent from 1000 on.
std::string volume_text(double mm3) {
    return (mm3 < 1000 ? significant_text(mm3, 4) : fixed_text(mm3, 0)) + " mm3";
}

// Warns of structures whose outlines hold another volume than their voxels. `spacing`: of the slices that are used.
void warn_about_volumes(const std::vector<SliceContours>& slices, double spacing, bool wide_epsilon,
                        const LabelMap& labels, RunContext& context) {
    std::vector<SliceContours::Content> sums(labels.structures.size());
    for (const SliceContours& slice : slices) {
        for (const SliceContours::Content& of : slice.contents) {
            SliceContours::Content& sum = sums[of.structure];
            sum.labelled_mm2 += of.labelled_mm2;
            sum.used_mm2 += of.used_mm2;
            sum.outlined_mm2 += of.outlined_mm2;
        }
    }
    for (std::size_t s = 0; s < sums.size(); ++s) {
        const auto& [structure, labelled, used, outlined] = sums[s];
        // A structure without an outline is told by W-TRC-004.
        if (used == 0 || !(std::abs(outlined - labelled) > told_difference * labelled)) continue;
        const bool by_pieces = std::abs(labelled - used) > std::abs(outlined - used);
        context.warn(
            {"W-TRC-009",
             "the outlines of the structure hold another volume than its voxels",
             {labels.source, "", name_of(labels.structures[s]), "",
              volume_text(labelled * spacing) + " in voxels, " + volume_text(outlined * spacing) +
                  " within the outlines"},
             by_pieces ? "small islands and holes were given to what surrounds them; --min-area 0 keeps them"
             : wide_epsilon
                 ? "the model has the volume of the outlines; a smaller --epsilon keeps them closer "
                   "to the voxels"
                 : "the model has the volume of the outlines; smaller voxels leave them more room"});
    }
}

void warn_about_structures(const LabelMap& labels, const std::vector<SliceContours>& slices,
                           const ContourSet& set, RunContext& context) {
    std::vector<std::uint32_t> contours(labels.structures.size(), 0), cut(labels.structures.size(), 0);
    for (const Contour& contour : set.contours) ++contours[contour.structure];
    for (const SliceContours& slice : slices) {
        for (const std::uint16_t label : slice.cut_by_border) ++cut[label - 1u];
    }
    for (std::size_t s = 0; s < labels.structures.size(); ++s) {
        const Place place{labels.source, "", name_of(labels.structures[s]), "", ""};
        if (contours[s] == 0) {
            context.warn({"W-TRC-004", "the structure has no contour in the slices that are used", place,
                          "it is not in the model; a smaller --every uses more slices"});
        } else if (cut[s] > 0) {
            context.warn({"W-TRC-001",
                          "the structure reaches the image border in " + std::to_string(cut[s]) + " slices",
                          place, "it was closed half a pixel beyond the border"});
        }
    }
}

// A structure that has contours may still have pieces that the kept slices pass by.
void warn_about_missed_pieces(const LabelMap& labels, const SliceAxes& axes, const TraceOptions& options,
                              double least_voxels, const ContourSet& set, RunContext& context) {
    if (options.every == 1) return;
    const std::vector<MissedPieces> missed =
        pieces_between(labels, {axes.axis[2], options.every, options.offset},
                       static_cast<std::uint64_t>(std::ceil(least_voxels)));
    std::vector<std::uint8_t> drawn(labels.structures.size(), 0);
    for (const Contour& contour : set.contours) drawn[contour.structure] = 1;
    const auto& step = labels.geometry.step;
    const double voxel_mm3 = std::abs(dot(cross(step[0], step[1]), step[2]));
    for (std::size_t s = 0; s < missed.size(); ++s) {
        const MissedPieces& of = missed[s];
        if (of.pieces == 0 || !drawn[s]) continue;
        const bool one = of.pieces == 1;
        context.warn(
            {"W-TRC-006",
             std::to_string(of.pieces) +
                 (one ? " part of the structure lies" : " parts of the structure lie") +
                 " entirely between the slices that --every keeps",
             {labels.source, "", name_of(labels.structures[s]), "",
              brief(static_cast<double>(of.voxels) * voxel_mm3) + " mm3" +
                  (one ? ""
                       : ", the largest " + brief(static_cast<double>(of.largest) * voxel_mm3) + " mm3")},
             one ? "the model lacks it; a smaller --every keeps it"
                 : "the model lacks them; a smaller --every keeps them"});
    }
}

bool is_sparse_along(const std::vector<SparseStructure>& sparse, const SliceAxes& axes) {
    return std::any_of(sparse.begin(), sparse.end(),
                       [&](const SparseStructure& of) { return of.axis == axes.axis[2]; });
}

std::string patient_axis_of(const ImageGeometry& geometry, std::uint32_t axis) {
    return std::string(1, "xyz"[patient_axes(geometry)[axis]]);
}

// `joins`: what lies between the slices is interpolated.
void warn_about_sparse(const LabelMap& labels, const SliceAxes& axes,
                       const std::vector<SparseStructure>& sparse, bool joins, RunContext& context) {
    for (const SparseStructure& of : sparse) {
        const bool is_across = of.axis != axes.axis[2];
        const std::string axis_option =
            is_across ? "--axis " + patient_axis_of(labels.geometry, of.axis) + " " : "";
        context.warn(
            {"W-TRC-007",
             "the structure is painted on " + std::to_string(of.slices) + " slices along " +
                 patient_axis_of(labels.geometry, of.axis) + ", about " + std::to_string(of.step) +
                 " slices apart, with nothing between them",
             {labels.source, "", name_of(labels.structures[of.structure]), "",
              brief(of.painted_mm3) + " mm3 as painted, about " + brief(of.joined_mm3) +
                  " mm3 with what lies between"},
             joins && !is_across
                 ? "what lies between them was interpolated; --between-sparse nothing makes a plate of each"
                 : "the model has a separate plate for each; " + axis_option +
                       "--between-sparse interpolated joins them"});
    }
}

std::string list_of(const std::vector<Structure>& structures) {
    constexpr std::size_t most = 10;  // A message lists so many names. [names; >= 1; B]
    std::string list;
    for (std::size_t s = 0; s < std::min(structures.size(), most); ++s) {
        list += (s == 0 ? "" : ", ") + name_of(structures[s]);
    }
    return structures.size() > most ? list + " ..." : list;
}

// By default a vertex may be left out within this of the outline, about the error of a traced vertex itself. [pixels; > 0; C]
constexpr double default_epsilon = 0.15;

Settings settings_of(const TraceOptions& options, const SliceAxes& axes, double threshold) {
    Settings settings;
    settings.min_pixels = options.min_area_mm2 < 0 ? 4 : options.min_area_mm2 / axes.pixel_area();
    settings.epsilon = options.epsilon_mm < 0 ? default_epsilon * axes.pixel() : options.epsilon_mm;
    settings.spacing = axes.pixel() / 3;
    settings.clearance = axes.pixel() / 10;
    settings.threshold = threshold;
    return settings;
}

// Why nothing was traced on the slices that are used.
Error no_contours_error(const LabelMap& labels, const SliceAxes& axes, std::size_t slices,
                        const TraceStats& stats) {
    const bool too_small = stats.islands_left_out > 0;
    const bool elsewhere = !too_small && std::any_of(labels.voxels.begin(), labels.voxels.end(),
                                                     [](std::uint16_t label) { return label != 0; });
    return Error{ErrorKind::geometry,
                 "E-TRC-001",
                 too_small   ? "every part is smaller than the minimum area"
                 : elsewhere ? "no voxel belongs to a structure in the " + std::to_string(slices) + " of " +
                                   std::to_string(axes.size[2]) + " slices that are used"
                             : "no voxel belongs to a structure",
                 {labels.source, "", list_of(labels.structures), "", ""},
                 too_small   ? "give a smaller --min-area"
                 : elsewhere ? "give a smaller --every or another --offset"
                             : "check the labels or the threshold"};
}

// Warns of islands that were left out and are many, and of what simplification did to areas.
void warn_about_areas(const std::vector<SliceContours>& slices, const TraceStats& stats,
                      const ContourSet& set, RunContext& context) {
    std::vector<AreaChange> changes;
    for (const SliceContours& slice : slices) {
        changes.insert(changes.end(), slice.changes.begin(), slice.changes.end());
    }
    double area = 0;
    for (const AreaChange& change : changes) area += change.area_mm2;
    if (stats.area_left_out_mm2 > much_left_out * (area + stats.area_left_out_mm2)) {
        context.warn({"W-TRC-005",
                      "islands smaller than the minimum area are more than 5 % of the labelled area",
                      {set.source, "", "", "",
                       brief(100 * stats.area_left_out_mm2 / (area + stats.area_left_out_mm2)) + " %"},
                      "they were left out, so that thin parts may be missing; --min-area 0 keeps them"});
    }
    warn_of_area_changes(changes, set.structures, set.source, context);
}

}  // namespace

Result<TraceResult> trace_contours(const LabelMap& labels, const GreyImage* grey, double threshold,
                                   const TraceOptions& options, RunContext& context) {
    assert(options.every >= 1 && options.offset < options.every);
    assert(labels.voxels.size() == labels.geometry.voxel_count());
    assert(!grey || grey->geometry.size == labels.geometry.size);
    const SliceAxes axes(labels.geometry, options.axis);
    // Per slice, two 32-bit numbers per pixel.
    if ((std::uint64_t{axes.size[0]} + 2) * (std::uint64_t{axes.size[1]} + 2) > (1u << 30)) {
        return Error{ErrorKind::limit,
                     "E-TRC-003",
                     "a slice has more than 1,073,741,824 pixels",
                     {labels.source, "", "", "", ""},
                     "crop or resample the image"};
    }
    if (options.offset >= axes.size[2]) {
        return Error{ErrorKind::geometry,
                     "E-TRC-002",
                     "the image has " + std::to_string(axes.size[2]) + " slices, so that --offset keeps none",
                     {labels.source, "", "", "", ""},
                     "give a smaller --offset"};
    }

    const Settings settings = settings_of(options, axes, threshold);
    std::vector<SliceContours> slices((axes.size[2] - options.offset + options.every - 1) / options.every);
    context.report("contours", 0);
    parallel_for(slices.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end && !context.cancelled(); ++s) {
            const auto k = static_cast<std::uint32_t>(options.offset + s * options.every);
            slices[s] = trace_slice(labels, grey, axes, k, settings);
        }
    });
    if (context.cancelled()) return cancelled_error();
    context.report("contours", 1);

    TraceResult result;
    ContourSet& set = result.kept;
    set.structures = labels.structures;
    set.drawn = false;
    const std::vector<SparseStructure> sparse =
        options.every == 1 || options.between_sparse == BetweenSparse::interpolated
            ? find_sparse_structures(labels)
            : std::vector<SparseStructure>();
    const bool joins = options.between_sparse == BetweenSparse::interpolated && is_sparse_along(sparse, axes);
    set.exclusive = set.complete = !joins;
    set.pixel_mm = axes.pixel();
    const double voxel_mm = std::abs(dot(axes.step[2], axes.normal));
    set.source = labels.source;
    assemble(slices, axes, set);
    // Slices that are joined as if drawn by hand stand for more than their voxels.
    set.slice_thickness_mm = joins && set.slices.size() > 1 ? 0 : voxel_mm;

    TraceStats& stats = result.stats;
    sum_up(slices, axes.pixel_area(), stats);
    stats.slices = static_cast<std::uint32_t>(set.slices.size());
    stats.contours = static_cast<std::uint32_t>(set.contours.size());
    stats.epsilon_mm = settings.epsilon;
    stats.slice_axis = axes.axis[2];
    if (set.contours.empty()) return no_contours_error(labels, axes, slices.size(), stats);
    warn_about_pieces(stats, labels.source, context);
    warn_about_areas(slices, stats, set, context);
    warn_about_volumes(slices, voxel_mm * options.every, settings.epsilon > default_epsilon * axes.pixel(),
                       labels, context);
    warn_about_structures(labels, slices, set, context);
    warn_about_missed_pieces(labels, axes, options, settings.min_pixels, set, context);
    warn_about_sparse(labels, axes, sparse, joins, context);
    if (options.between_sparse == BetweenSparse::interpolated && sparse.empty()) {
        context.warn({"W-TRC-008",
                      "no structure is painted on single slices with nothing between them",
                      {labels.source, "", "", "", ""},
                      "nothing was interpolated; leave out --between-sparse"});
    }
    return result;
}

}  // namespace anatomesh
