#include "anatomesh/measure/field_distance.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/buckets.h"
#include "anatomesh/mesh/topology.h"

namespace anatomesh {

namespace {

constexpr std::size_t all_middles_up_to = 100'000;  // facets
constexpr double saturated = 0.95;                  // of the clamp: the field may mean more

constexpr std::size_t looked_at = 1000;  // points whose distance is found by looking round them
constexpr int steps = 8;                 // on the way to the value

struct Measured {
    Vec3 at;
    std::uint32_t cell;  // on whose side
    double value = 0;    // of the field: no less than the distance, but for its clamp
};

// The directions to the neighbours of a cube in a lattice of cubes.
std::vector<Vec3> directions() {
    std::vector<Vec3> all;
    for (int x = -1; x <= 1; ++x) {
        for (int y = -1; y <= 1; ++y) {
            for (int z = -1; z <= 1; ++z) {
                const Vec3 way{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
                if (x != 0 || y != 0 || z != 0) all.push_back((1 / length(way)) * way);
            }
        }
    }
    return all;
}

// Where a region ends between two slices the field's value falls faster than the distance. So the regions
// round the point are asked, nearer ones first: the smallest step at which one differs, or the value. No
// further than to `enough`, below which nobody wants to know.
double distance_round(const StructureField& field, Vec3 p, double value, double enough,
                      const std::vector<Vec3>& ways) {
    std::vector<std::uint32_t> here, there;
    field.members(p, here);
    const auto differs_at = [&](double r) {
        return std::any_of(ways.begin(), ways.end(), [&](Vec3 way) {
            field.members(p + r * way, there);
            return there != here;
        });
    };
    if (enough > 0 && differs_at(enough)) return enough;
    for (int k = 1; k < steps; ++k) {
        if (const double r = value * k / steps; r > enough && differs_at(r)) return r;
    }
    return value;
}

}  // namespace

FieldDistanceReport farthest_from_field(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                        const RegionTable& regions, std::span<const Structure> structures,
                                        const StructureField& field, Vec3 origin, int threads) {
    const std::vector<RegionFacet> facets = region_facets(mesh, neighbors, threads);
    std::vector<Measured> points;
    std::vector<std::uint8_t> seen(mesh.points.size(), 0);
    const std::size_t stride = facets.size() / all_middles_up_to + 1;
    for (std::size_t n = 0; n < facets.size(); ++n) {
        const auto corners = facet_of(mesh.cells[facets[n].cell], facets[n].index);
        Vec3 sum;
        for (const std::uint32_t v : corners) {
            sum += mesh.points[v];
            if (!seen[v]) points.push_back({mesh.points[v], facets[n].cell, 0});
            seen[v] = 1;
        }
        if (n % stride == 0) points.push_back({(1.0 / 3) * sum, facets[n].cell, 0});
    }
    FieldDistanceReport report;
    report.points = points.size();
    if (points.empty()) return report;
    parallel_for(points.size(), 4096, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n)
            points[n].value = field.interface_distance(points[n].at - origin);
    });
    const std::size_t count = std::min(looked_at, points.size());
    const auto further = [](const Measured& a, const Measured& b) {
        return a.value != b.value ? a.value > b.value
                                  : std::tie(a.at.x, a.at.y, a.at.z) < std::tie(b.at.x, b.at.y, b.at.z);
    };
    std::partial_sort(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count), points.end(),
                      further);
    const std::vector<Vec3> ways = directions();
    double most = 0;
    std::size_t farthest = 0;
    for (std::size_t n = 0; n < count && points[n].value > most; ++n) {
        const double distance = distance_round(field, points[n].at - origin, points[n].value, most, ways);
        if (distance <= most) continue;
        most = distance;
        farthest = n;
    }
    const Measured& worst = points[farthest];
    report.max_mm = most;
    report.at_least = most >= saturated * field.clamp();
    report.at = {worst.at.x, worst.at.y, worst.at.z};
    if (const auto& members = regions.members[mesh.regions[worst.cell]]; !members.empty()) {
        const Structure& structure = structures[members.front()];
        report.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
    }
    return report;
}

}  // namespace anatomesh
