#include "anatomesh/measure/topology/topology_warnings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/improve/core/drawn_slices.h"
#include "anatomesh/improve/operations/segment_edges.h"
#include "anatomesh/mesh/check/spurious_handles.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/sample/sample_points.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

namespace {

// A structure this many sizes thick in the mean has no walls that tear. [sizes; > 0; M 2026-11, set not recorded]
constexpr double tears_below = 2;
// A warning advises this size. [sizes; 0 to 1; D the edge length of a finer run]
constexpr double finer = 0.7;

// By structure, whether a slice shows several contours of it: they follow one another.
std::vector<std::uint8_t> shown_in_several(const ContourSet& contours) {
    std::vector<std::uint8_t> several(contours.structures.size(), 0);
    for (std::size_t c = 1; c < contours.contours.size(); ++c) {
        const Contour &before = contours.contours[c - 1], &here = contours.contours[c];
        if (before.slice == here.slice && before.structure == here.structure) several[here.structure] = 1;
    }
    return several;
}

// The edges of all surfaces that lie along contours, and the segments where there are none.
struct ContourEdges {
    std::vector<VertexPair> found, missed;
};
ContourEdges edges_of_contours(const TopologyInput& model) {
    std::vector<VertexPair> segments;
    for (const Contour& contour : model.contours.contours) {
        // Over vertices that are lost.
        std::uint32_t first = no_cell, last = no_cell;
        for (std::uint32_t n = 0; n < contour.point_count; ++n) {
            const std::uint32_t v = model.vertex_of[contour.first_point + n];
            if (v == no_cell) continue;
            if (last != no_cell) segments.push_back({last, v});
            if (first == no_cell) first = v;
            last = v;
        }
        if (last != first) segments.push_back({last, first});
    }
    ContourEdges edges;
    edges.found = edges_along(model.mesh, model.neighbors, segments, &edges.missed);
    return edges;
}

// What is told of one structure.
struct Told {
    std::int64_t count = 0;
    std::uint32_t slice = 0;
    std::string where, hint;
};

Told told_of(std::span<const TopologyMismatch> tears, const ContourSet& contours) {
    const auto amiss = [](const TopologyMismatch& t) { return std::abs(t.euler - t.expected); };
    Told told;
    for (const TopologyMismatch& tear : tears) told.count += (amiss(tear) + 1) / 2;
    if (tears.empty()) return told;
    const TopologyMismatch& worst = *std::max_element(
        tears.begin(), tears.end(),
        [&](const TopologyMismatch& x, const TopologyMismatch& y) { return amiss(x) < amiss(y); });
    told.slice = worst.low_slice;
    told.where = worst.low_slice == worst.high_slice
                     ? "most of these places are beyond this slice, at the end of the structure"
                     : "most of these places are between this slice and slice " +
                           contours.slices[worst.high_slice].name;
    told.hint = worst.by_mesh ? "" : "a slice through the place or ";
    return told;
}

// To a tenth of a mm.
std::string text_of(Vec3 place) {
    const auto text = [](double value) { return brief(0.1 * std::round(10 * value) + 0.0); };
    return text(place.x) + " " + text(place.y) + " " + text(place.z);
}

Told told_of(std::span<const SpuriousJoint> joints) {
    Told told;
    for (const SpuriousJoint& joint : joints) told.count += joint.joints;
    if (joints.empty()) return told;
    const SpuriousJoint& worst =
        *std::max_element(joints.begin(), joints.end(),
                          [](const SpuriousJoint& x, const SpuriousJoint& y) { return x.joints < y.joints; });
    told.slice = worst.slice;
    told.where = "one of these places is near this slice at " + text_of(worst.place) + " mm";
    told.hint = "a slice through the place or ";
    return told;
}

// Those of one structure; all are in order of structure.
template <class Tear>
std::span<const Tear> of_structure(const std::vector<Tear>& all, std::uint32_t structure) {
    const auto first =
        std::find_if(all.begin(), all.end(), [&](const Tear& tear) { return tear.structure == structure; });
    const auto last =
        std::find_if(first, all.end(), [&](const Tear& tear) { return tear.structure != structure; });
    return {first, last};
}

// The slice of the structure's contour point that is nearest to a place.
std::uint32_t nearest_slice(const ContourSet& contours, std::uint32_t structure, Vec3 place) {
    std::uint32_t slice = 0;
    double least = std::numeric_limits<double>::infinity();
    for (const Contour& contour : contours.contours) {
        if (contour.structure != structure) continue;
        for (const Vec3& p : contours.points_of(contour)) {
            if (const double square = squared_length(p - place); square < least) {
                least = square;
                slice = contour.slice;
            }
        }
    }
    return slice;
}

std::vector<SpuriousJoint> small_ones(const TopologyInput& model,
                                      std::span<const std::vector<Triangle>> surfaces) {
    std::vector<SpuriousJoint> joints;
    for (std::uint32_t s = 0; s < surfaces.size(); ++s) {
        if (surfaces[s].empty() || model.structures[model.structure_of[s]].surface.genus <= 0) continue;
        for (const SmallHandles& part :
             spurious_handles(model.mesh.points, surfaces[s], s, {model.contours.contours, model.vertex_of},
                              spurious_handle_reach * model.size_mm)) {
            const Vec3 place = model.mesh.points[part.middle];
            joints.push_back({s, nearest_slice(model.contours, s, place), part.handles, place});
        }
    }
    return joints;
}

}  // namespace

TopologyFindings check_topology(const TopologyInput& model, int threads) {
    const ContourSet& contours = model.contours;
    std::vector<std::vector<Triangle>> surfaces(contours.structures.size());
    // Where walls do not tear only what goes on from end to end is sure to be amiss.
    std::vector<std::uint8_t> thick;
    for (const double t : mean_thickness(contours)) thick.push_back(t >= tears_below * model.size_mm);
    const std::vector<std::uint8_t> several = shown_in_several(contours);
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        if (model.structure_of[s] >= model.structures.size()) continue;
        // Without a handle no wall is torn, and where no slice shows two contours no gap is filled.
        const StructureReport& structure = model.structures[model.structure_of[s]];
        const bool one_shell = structure.surface.genus <= 0 && structure.surface.components <= 1;
        if (one_shell && !several[s]) continue;
        surfaces[s] = structure_surface(model.mesh, model.neighbors, model.regions,
                                        static_cast<std::uint32_t>(model.structure_of[s]), threads);
    }
    TopologyFindings tears;
    if (std::all_of(surfaces.begin(), surfaces.end(), [](const auto& surface) { return surface.empty(); }))
        return tears;
    // The model's contours may have been re-routed, and a file's lie elsewhere: it is another set than the
    // one that the model was made of.
    const SliceArrangement arrangement = arrangement_of(contours);
    tears.of_slices =
        topology_check(model.mesh.points, surfaces, contours, arrangement, model.vertex_of, thick, threads);
    // Where parts branch or vanish the field itself may join them, near the ends of the run.
    std::erase_if(tears.of_slices,
                  [](const TopologyMismatch& t) { return !t.whole && t.euler > t.expected; });
    if (!arrangement.is_stack()) {
        const ContourEdges edges = edges_of_contours(model);
        tears.between_planes = spurious_joints(model.mesh.points, surfaces, edges.found, edges.missed,
                                               contours, model.vertex_of);
        tears.small = small_ones(model, surfaces);
    }
    return tears;
}

std::size_t spurious_places(const TopologyFindings& tears) {
    std::map<std::uint32_t, std::array<std::size_t, 2>> by_structure;
    for (const SpuriousJoint& joint : tears.between_planes) by_structure[joint.structure][0] += joint.joints;
    for (const SpuriousJoint& joint : tears.small) by_structure[joint.structure][1] += joint.joints;
    std::size_t count = 0;
    for (const auto& [structure, seen] : by_structure) count += std::max(seen[0], seen[1]);
    return count;
}

void warn_of_topology(const TopologyFindings& tears, const ContourSet& contours, double size_mm,
                      RunContext& context) {
    for (std::uint32_t s = 0; s < contours.structures.size(); ++s) {
        // What sees more of them.
        Told told = told_of(of_structure(tears.of_slices, s), contours);
        if (Told other = told_of(of_structure(tears.between_planes, s)); other.count > told.count)
            told = std::move(other);
        if (Told other = told_of(of_structure(tears.small, s)); other.count > told.count)
            told = std::move(other);
        if (told.count == 0) continue;
        const Structure& structure = contours.structures[s];
        Place place;
        place.file = contours.source;
        place.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
        place.slice = contours.slices[told.slice].name;
        place.value = std::to_string(told.count) + (told.count == 1 ? " place" : " places");
        context.warn({"W-PIP-004",
                      "the surface is connected differently from the contours, by holes in a thin wall or "
                      "bridges over a narrow "
                      "gap; " +
                          told.where,
                      place,
                      "kept; check the components and holes of the surface; " + told.hint + "--size " +
                          brief(finer * size_mm) + " may resolve it"});
    }
}

}  // namespace anatomesh
