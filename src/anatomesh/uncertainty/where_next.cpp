#include "anatomesh/uncertainty/where_next.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "anatomesh/geom/numbers.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/uncertainty/gap_doubts.h"

namespace anatomesh {

namespace {

// The expected error is summed over so many points of the surface at most. [points; >= 1; B]
constexpr std::size_t most_samples = 40'000;
// Candidates lie half-way between a slice and so many of its nearest neighbours. [slices; >= 1; B]
constexpr std::size_t neighbors_of_a_slice = 4;
// A plane does not meet places for sure whose normals are nearer to its own. [sine of the angle; 0 to 1; M 2026-11, set not recorded]
constexpr double least_sine = 0.2;

// A place of a structure's surface.
struct Sample {
    Vec3 at, normal;
    double area = 0;
    double evidence = 0;  // mm to the nearest contour
    double rate = 0;      // expected error per mm of it
    std::uint32_t structure = 0;
};

void add_samples(const TetMesh& mesh, const std::vector<Triangle>& surface,
                 const SurfaceUncertainty& uncertainty, std::uint32_t structure,
                 std::vector<Sample>& samples) {
    std::vector<Vec3> normals(mesh.points.size());
    std::vector<double> areas(mesh.points.size(), 0);
    for (const Triangle& t : surface) {
        const Vec3 a = mesh.points[t[0]];
        const Vec3 normal = 0.5 * cross(mesh.points[t[1]] - a, mesh.points[t[2]] - a);
        for (const std::uint32_t v : t) {
            normals[v] += normal;
            areas[v] += length(normal) / 3;
        }
    }
    for (std::uint32_t v = 0; v < areas.size(); ++v) {
        if (!(areas[v] > 0) || !(uncertainty.evidence[v] > 0) || !(length(normals[v]) > 0)) continue;
        samples.push_back({mesh.points[v], normalized(normals[v]), areas[v], uncertainty.evidence[v],
                           uncertainty.expected[v] / static_cast<double>(uncertainty.evidence[v]),
                           structure});
    }
}

// Every n-th, with the area of those left out.
void thin(std::vector<Sample>& samples) {
    const std::size_t step = samples.size() / most_samples + 1;
    if (step == 1) return;
    std::size_t kept = 0;
    for (std::size_t n = 0; n < samples.size(); n += step) {
        samples[kept] = samples[n];
        samples[kept++].area *= static_cast<double>(step);
    }
    samples.resize(kept);
}

std::vector<PlaneBetween> candidates_of(const ContourSet& set) {
    const std::vector<PlanePatch> patches = plane_patches(set);
    const double spacing = all_parallel(set, parallel_tolerance_mm) && set.slices.size() > 1
                               ? median_spacing(set)
                               : plane_spacings(set, patches).median;
    std::vector<Vec3> centers;
    for (const PlanePatch& patch : patches)
        centers.push_back(patch.plane.to_space(0.5 * (patch.box.low + patch.box.high)));
    std::vector<PlaneBetween> candidates;
    std::set<std::pair<std::size_t, std::size_t>> paired;
    for (std::size_t i = 0; i < patches.size(); ++i) {
        if (patches[i].box.empty()) continue;
        const Plane& plane = patches[i].plane;
        std::vector<std::pair<double, std::size_t>> near;
        for (std::size_t j = 0; j < patches.size(); ++j) {
            if (j == i || patches[j].box.empty()) continue;
            if (std::abs(dot(plane.normal, patches[j].plane.normal)) < cos_of_about_30_degrees) continue;
            near.emplace_back(length(patches[j].offset_from(centers[i], 0)), j);
        }
        const std::size_t count = std::min(near.size(), neighbors_of_a_slice);
        std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
        for (std::size_t n = 0; n < count; ++n) {
            const std::size_t j = near[n].second;
            if (!paired.insert({std::min(i, j), std::max(i, j)}).second) continue;
            const Plane& other = patches[j].plane;
            const double same_way = dot(plane.normal, other.normal) < 0 ? -1 : 1;
            const Vec3 normal = plane.normal + same_way * other.normal;
            // Equally far from both planes, on either side.
            const double offset =
                dot(plane.normal, plane.origin) + same_way * dot(other.normal, other.origin);
            const Vec3 unit = normalized(normal);
            const Vec3 middle = 0.5 * (centers[i] + centers[j]);
            const double height = dot(middle, unit) - offset / length(normal);
            candidates.push_back({make_plane(middle - height * unit, unit),
                                  static_cast<std::int64_t>(std::min(i, j)),
                                  static_cast<std::int64_t>(std::max(i, j))});
        }
        for (const double side : {-0.5, 0.5}) {
            candidates.push_back({make_plane(centers[i] + (side * spacing) * plane.normal, plane.normal),
                                  static_cast<std::int64_t>(i), -1});
        }
    }
    return candidates;
}

// How far a sample will be from the contour on a plane.
double evidence_on(const Plane& plane, const Sample& sample) {
    const double sine = length(cross(plane.normal, sample.normal));
    if (sine < least_sine) return std::numeric_limits<double>::infinity();
    return std::abs(plane.signed_distance(sample.at)) / sine;
}

NextPlane gain_of(const PlaneBetween& candidate, const std::vector<Sample>& samples, const GapDoubts& doubts,
                  std::size_t structures) {
    NextPlane next{
        candidate.plane, candidate.slice_a, candidate.slice_b, 0, 0, 0, std::vector<double>(structures, 0)};
    next.gap_mm3 = doubts.gain(candidate.plane.origin, next.gain_by_structure);
    next.gain_mm3 = next.gap_mm3;
    double area = 0;
    for (const Sample& sample : samples) {
        if (std::abs(candidate.plane.signed_distance(sample.at)) >= sample.evidence) continue;
        const double nearer = evidence_on(candidate.plane, sample);
        if (nearer >= sample.evidence) continue;
        const double gain = sample.area * sample.rate * (sample.evidence - nearer);
        next.gain_mm3 += gain;
        next.gain_by_structure[sample.structure] += gain;
        next.expected_mm += sample.area * sample.rate * sample.evidence;
        area += sample.area;
    }
    if (area > 0) next.expected_mm /= area;
    return next;
}

}  // namespace

WhereNext where_next(const ContourSet& set, const SurfaceUncertainty& uncertainty, const TetMesh& mesh,
                     const RegionTable& regions, const WhereNextOptions& options) {
    std::vector<Sample> samples;
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    for (std::uint32_t s = 0; s < set.structures.size(); ++s)
        add_samples(mesh, structure_surface(mesh, neighbors, regions, s), uncertainty, s, samples);
    thin(samples);
    WhereNext result;
    for (const Sample& sample : samples) result.expected_mm3 += sample.area * sample.rate * sample.evidence;
    GapDoubts doubts(set, options.field);
    result.gaps_mm3 = doubts.volume();
    result.expected_mm3 += result.gaps_mm3;
    std::vector<PlaneBetween> candidates = candidates_of(set);
    std::erase_if(candidates, [&](const PlaneBetween& plane) { return doubts.is_across(plane); });
    while (result.planes.size() < options.count) {
        NextPlane best;
        const auto consider = [&](const PlaneBetween& candidate) {
            NextPlane next = gain_of(candidate, samples, doubts, set.structures.size());
            if (next.gain_mm3 > best.gain_mm3) best = std::move(next);
        };
        for (const PlaneBetween& middle : doubts.middles()) consider(middle);
        for (const PlaneBetween& candidate : candidates) consider(candidate);
        if (!(best.gain_mm3 > 0)) break;
        for (Sample& sample : samples)
            sample.evidence = std::min(sample.evidence, evidence_on(best.plane, sample));
        doubts.draw(best.plane.origin);
        result.planes.push_back(std::move(best));
    }
    return result;
}

}  // namespace anatomesh
