#include "anatomesh/contour/planes/plane_grouping.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "anatomesh/contour/planes/adjust_orientations.h"
#include "anatomesh/contour/planes/coplanar_clusters.h"
#include "anatomesh/contour/planes/find_orientations.h"
#include "anatomesh/contour/planes/near_planes.h"
#include "anatomesh/contour/planes/plane_fit.h"
#include "anatomesh/contour/planes/plane_stacks.h"
#include "anatomesh/geom/point_scatter.h"

namespace anatomesh {

namespace {

// Contours that share a plane are grouped as one contour, which has the points of all of them.
struct MergedContours {
    std::vector<ContourToPlace> contours;
    std::vector<double> area;                         // per contour
    std::vector<std::vector<std::uint32_t>> members;  // per contour: of the contours of the input
    std::vector<std::vector<Vec3>> points;            // what contours with several members refer to
};

// The contours of each declared plane, and the coplanar clusters of the others. Where `are_known`, each contour
// without a plane shows its own and makes a cluster alone.
std::vector<std::vector<std::uint32_t>> members_of_clusters(std::span<const ContourToPlace> contours,
                                                            std::size_t declared, bool are_known,
                                                            const PlaneTolerance& tolerance) {
    std::vector<std::vector<std::uint32_t>> clusters(declared);
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        if (contours[c].plane >= 0) {
            clusters[static_cast<std::size_t>(contours[c].plane)].push_back(c);
        } else if (are_known) {
            clusters.push_back({c});
        }
    }
    if (!are_known) {
        for (CoplanarCluster& cluster :
             find_coplanar_clusters(contours, tolerance.off_plane_mm(), tolerance.rounding_mm)) {
            std::sort(cluster.contours.begin(), cluster.contours.end());
            clusters.push_back(std::move(cluster.contours));
        }
    }
    std::erase_if(clusters, [](const auto& cluster) { return cluster.empty(); });
    std::sort(clusters.begin(), clusters.end());
    return clusters;
}

MergedContours merge_clusters(std::span<const ContourToPlace> contours,
                              std::vector<std::vector<std::uint32_t>> clusters) {
    MergedContours merged;
    merged.points.resize(clusters.size());
    for (std::size_t s = 0; s < clusters.size(); ++s) {
        const ContourToPlace& first = contours[clusters[s][0]];
        std::vector<Vec3>& points = merged.points[s];
        double area = 0;
        for (const std::uint32_t c : clusters[s]) {
            area += vector_area(contours[c].points);
            if (clusters[s].size() > 1)
                points.insert(points.end(), contours[c].points.begin(), contours[c].points.end());
        }
        merged.area.push_back(area);
        merged.contours.push_back({clusters[s].size() > 1 ? points : first.points, first.plane});
    }
    merged.members = std::move(clusters);
    return merged;
}

// A stack's merged contours as clusters at their heights.
struct ClusteredStack {
    std::vector<PositionedCluster> clusters;
    std::vector<std::size_t> first;  // of each cluster in the stack, and the stack's end
};

ClusteredStack clustered(const PlaneStack& stack, const MergedContours& merged, double same_mm) {
    ClusteredStack result;
    for (std::size_t i = 0; i < stack.contours.size(); ++i) {
        const PositionedContour& here = stack.contours[i];
        if (result.clusters.empty() || here.offset - result.clusters.back().offset > same_mm) {
            result.first.push_back(i);
            result.clusters.push_back({here.offset, 0, false, {}});
        }
        PositionedCluster& cluster = result.clusters.back();
        const ContourToPlace& contour = merged.contours[here.contour];
        cluster.noise = std::max(cluster.noise, noise_off_own_plane(contour.points));
        cluster.is_declared |= contour.plane >= 0;
        const std::vector<std::uint32_t>& members = merged.members[here.contour];
        cluster.contours.insert(cluster.contours.end(), members.begin(), members.end());
    }
    result.first.push_back(stack.contours.size());
    return result;
}

// What grouping is about: the contours of the input and as merged, and the declared planes.
struct GroupingInput {
    std::span<const ContourToPlace> contours;
    std::span<const Plane> declared;
    const PlaneGroupingOptions& options;
    const MergedContours& merged;
    double extent_mm = 0;  // of all contours

    std::vector<PlaneStack> stacks(const ContourOrientations& orientations) const {
        return plane_stacks(merged.contours, declared, orientations);
    }
    double same_mm(const PlaneStack& stack) const {
        return same_plane_mm(stack.contours, extent_mm, options.group_tolerance_mm);
    }
};

// A number per merged contour: of the run of planes near each other that are one slice, as the contours on them show.
std::vector<std::uint32_t> run_of_each(const GroupingInput& input, const ContourOrientations& orientations) {
    std::vector<std::uint32_t> run_of(input.merged.contours.size());
    std::iota(run_of.begin(), run_of.end(), 0u);
    const std::vector<PlaneStack> stacks = input.stacks(orientations);
    for (const PlaneStack& stack : stacks) {
        const auto [clusters, first_of] = clustered(stack, input.merged, input.same_mm(stack));
        for (const auto& [first, last] : runs_of_one_slice(
                 clusters, input.contours, stack.normal, input.options.plane_repair_mm, stacks.size() == 1)) {
            const std::uint32_t run = run_of[stack.contours[first_of[first]].contour];
            for (std::size_t i = first_of[first]; i < first_of[last]; ++i)
                run_of[stack.contours[i].contour] = run;
        }
    }
    return run_of;
}

// Which contours share a run with others: these keep their orientation.
std::vector<bool> in_runs(const std::vector<std::uint32_t>& run_of) {
    std::vector<std::size_t> in_run(run_of.size() + 1, 0);
    for (const std::uint32_t run : run_of) ++in_run[run];
    std::vector<bool> shared;
    for (const std::uint32_t run : run_of) shared.push_back(in_run[run] > 1);
    return shared;
}

// Slices per merged contour.
PlaneGroups grouped(const GroupingInput& input, const ContourOrientations& orientations,
                    const std::vector<std::uint32_t>& run_of) {
    PlaneGroups groups;
    groups.slice_of.resize(input.merged.contours.size());
    for (const PlaneStack& stack : input.stacks(orientations)) {
        const std::span<const PositionedContour> all = stack.contours;
        const double same = input.same_mm(stack);
        for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
            while (end < all.size() && (all[end].offset - all[begin].offset <= same ||
                                        run_of[all[end].contour] == run_of[all[end - 1].contour])) {
                groups.slice_of[all[end].contour] = static_cast<std::uint32_t>(groups.slices.size());
                ++end;
            }
            const std::span<const PositionedContour> run = all.subspan(begin, end - begin);
            groups.slices.push_back(common_plane(run, stack.normal));
            groups.spread_mm.push_back(run.back().offset - run.front().offset);
        }
    }
    return groups;
}

double extent_of(std::span<const ContourToPlace> contours) {
    Box3 box;
    for (const ContourToPlace& contour : contours) {
        for (const Vec3& p : contour.points) box.extend(p);
    }
    return box.diagonal();
}

}  // namespace

int axis_of(const Plane& plane) {
    for (const int axis : axial_first) {
        if (plane.normal == coordinate_axes[axis]) return axis;
    }
    return -1;
}

PlaneGroups group_planes(std::span<const ContourToPlace> contours, std::span<const Plane> declared,
                         const PlaneGroupingOptions& options) {
    const bool are_known = std::all_of(contours.begin(), contours.end(), [&](const ContourToPlace& contour) {
        return contour.plane >= 0 || axis_at_one_coordinate(contour.points, options.plane_repair_mm) >= 0;
    });
    const PlaneTolerance tolerance{options.plane_tolerance_mm, options.plane_repair_mm,
                                   are_known ? 0 : coordinate_rounding(contours)};
    const MergedContours merged_contours =
        merge_clusters(contours, members_of_clusters(contours, declared.size(), are_known, tolerance));
    const GroupingInput input{contours, declared, options, merged_contours, extent_of(contours)};

    const std::span<const ContourToPlace> to_place = merged_contours.contours;
    ContourOrientations orientations =
        find_orientations(to_place, merged_contours.area, tolerance,
                          declared_orientations(to_place, declared, options.group_tolerance_mm));
    refine_normals(to_place, options.plane_tolerance_mm, orientations);
    const std::vector<std::uint32_t> run_of = run_of_each(input, orientations);
    // Clusters that were not put together lie on planes of their own exactly, so planes that cross are told apart.
    if (!are_known) separate_crossing_planes(to_place, tolerance, in_runs(run_of), orientations);

    PlaneGroups groups = grouped(input, orientations, run_of);
    std::vector<std::uint32_t> slice_of(contours.size());
    for (std::size_t s = 0; s < merged_contours.members.size(); ++s) {
        for (const std::uint32_t c : merged_contours.members[s]) slice_of[c] = groups.slice_of[s];
    }
    groups.slice_of = std::move(slice_of);
    return groups;
}

}  // namespace anatomesh
