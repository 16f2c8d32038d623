#include "anatomesh/measure/field_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <tuple>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/model/buckets.h"

namespace anatomesh {

namespace {

// Up to so many facets the middle of each is measured; of more, some are left out evenly. [facets; >= 1; B]
constexpr std::size_t all_middles_up_to = 100'000;
// From this share of the clamp on the field may mean more. [1; 0 to 1; D]
constexpr double saturated = 0.95;
// The distance of so many points is found by looking round them. [points; >= 0; B]
constexpr std::size_t looked_at = 1000;
// A search round a point widens in so many steps up to the field's value. [steps; >= 1; B]
constexpr int steps = 8;

// A surface: of one of the model's structures, or, with their number, of all of them together.
struct Measured {
    Vec3 at;
    std::uint32_t surface = 0;
    double value = 0;  // of the field: no less than the distance, but for its clamp
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

class SurfaceDistances {
  public:
    SurfaceDistances(const TetMesh& mesh, const RegionTable& regions, std::span<const std::uint32_t> of_field,
                     const StructureField& field, Vec3 origin)
        : mesh_(mesh),
          of_field_(of_field),
          field_(field),
          origin_(origin),
          all_(static_cast<std::uint32_t>(of_field.size())),
          ways_(directions()) {
        for (const std::vector<std::uint32_t>& members : regions.members) {
            std::vector<std::uint32_t>& known = members_.emplace_back();
            std::copy_if(members.begin(), members.end(), std::back_inserter(known),
                         [&](std::uint32_t s) { return of_field[s] != no_cell; });
        }
        const auto known = std::count_if(of_field.begin(), of_field.end(),
                                         [](std::uint32_t structure) { return structure != no_cell; });
        one_alone_ = known == 1 && of_field.size() == 1;
        with_all_ = known > 1 && field.exclusive();
    }

    std::uint32_t surfaces() const { return all_ + 1; }
    bool is_all(std::uint32_t surface) const { return surface == all_; }

    // The surfaces on which the facet lies replace `out`.
    void surfaces_of(const RegionFacet& facet, std::vector<std::uint32_t>& out) const {
        const auto& inner = members_[mesh_.regions[facet.cell]];
        const auto& outer = members_[facet.other == no_cell ? Region{0} : mesh_.regions[facet.other]];
        out.clear();
        std::set_symmetric_difference(inner.begin(), inner.end(), outer.begin(), outer.end(),
                                      std::back_inserter(out));
        if (with_all_ && inner.empty() != outer.empty()) out.push_back(all_);
    }

    double value(std::uint32_t surface, Vec3 p) const {
        if (one_alone_) return field_.interface_distance(p - origin_);
        return std::abs(is_all(surface) ? field_.union_value(p - origin_)
                                        : field_.value(of_field_[surface], p - origin_));
    }

    // Where a structure ends between two slices, and on a slice, the field's value falls faster than the
    // distance. So the points round this one are asked, nearer ones first: the smallest step at which one is
    // on the other side, or is near to the surface itself, or the value. No further than to `enough`, below
    // which nobody wants to know.
    double distance(const Measured& point, double enough) const {
        const Vec3 p = point.at - origin_;
        const bool here = inside(point.surface, p);
        const double per_value = per_value_of(point.surface), farthest = farthest_distance(point);
        double nearest = farthest;
        const auto look_at = [&](double r) {
            for (const Vec3 way : ways_) {
                const Vec3 q = p + r * way;
                const double beyond =
                    inside(point.surface, q) != here ? 0 : per_value * value(point.surface, q + origin_);
                nearest = std::min(nearest, r + beyond);
                if (nearest <= enough) return;
            }
        };
        if (enough > 0) look_at(0.5 * enough);
        if (enough > 0 && nearest > enough) look_at(enough);
        for (int k = 1; k < steps && nearest > enough && nearest > farthest * k / steps; ++k)
            look_at(farthest * k / steps);
        return std::max(nearest, enough);
    }

    // No point is farther from its surface by what the field says there.
    double farthest_distance(const Measured& point) const {
        return per_value_of(point.surface) * point.value;
    }

  private:
    // Where structures exclude each other, half of what parts their own distances is their wall's.
    double per_value_of(std::uint32_t surface) const { return with_all_ && !is_all(surface) ? 2 : 1; }

    bool inside(std::uint32_t surface, Vec3 p) const {
        static thread_local std::vector<std::uint32_t> members;
        field_.members(p, members);
        if (is_all(surface)) return !members.empty();
        return std::find(members.begin(), members.end(), of_field_[surface]) != members.end();
    }

    const TetMesh& mesh_;
    std::span<const std::uint32_t> of_field_;
    const StructureField& field_;
    const Vec3 origin_;
    const std::uint32_t all_;
    const std::vector<Vec3> ways_;
    std::vector<std::vector<std::uint32_t>> members_;  // of the regions, those that the field has
    bool one_alone_ = false, with_all_ = false;
};

// The points with the largest values, at most looked_at of them, largest first.
std::vector<Measured> largest(std::vector<Measured> points) {
    const auto further = [](const Measured& a, const Measured& b) {
        return a.value != b.value ? a.value > b.value
                                  : std::tie(a.at.x, a.at.y, a.at.z, a.surface) <
                                        std::tie(b.at.x, b.at.y, b.at.z, b.surface);
    };
    const std::size_t count = std::min(looked_at, points.size());
    std::partial_sort(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count), points.end(),
                      further);
    points.resize(count);
    return points;
}

// The point that is farthest, with its distance as its value.
Measured farthest_of(const std::vector<Measured>& points, const SurfaceDistances& distances) {
    Measured worst = points.front();
    worst.value = 0;
    for (const Measured& point : points) {
        if (distances.farthest_distance(point) <= worst.value) continue;
        const double distance = distances.distance(point, worst.value);
        if (distance <= worst.value) continue;
        worst = point;
        worst.value = distance;
    }
    return worst;
}

std::array<double, 3> coordinates(Vec3 p) {
    return {p.x, p.y, p.z};
}

}  // namespace

FieldDistanceReport farthest_from_field(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                        const RegionTable& regions, std::span<const Structure> structures,
                                        std::span<const std::uint32_t> of_field, const StructureField& field,
                                        Vec3 origin, int threads) {
    const std::vector<RegionFacet> facets = region_facets(mesh, neighbors, threads);
    const SurfaceDistances distances(mesh, regions, of_field, field, origin);
    std::vector<std::vector<std::uint32_t>> facets_of(distances.surfaces());
    std::vector<std::uint8_t> on(facets.size());  // how many surfaces
    std::vector<std::uint32_t> surfaces;
    for (std::uint32_t n = 0; n < facets.size(); ++n) {
        distances.surfaces_of(facets[n], surfaces);
        on[n] = static_cast<std::uint8_t>(std::min<std::size_t>(surfaces.size(), 2));
        for (const std::uint32_t surface : surfaces) facets_of[surface].push_back(n);
    }
    const auto corners_of = [&](std::uint32_t n) {
        return facet_of(mesh.cells[facets[n].cell], facets[n].index);
    };
    const auto middle_of = [&](std::uint32_t n) {
        Vec3 sum;
        for (const std::uint32_t v : corners_of(n)) sum += mesh.points[v];
        return (1.0 / 3) * sum;
    };
    FieldDistanceReport report;
    std::vector<Measured> all, joined;
    std::vector<std::uint32_t> place(mesh.points.size(), no_cell);  // in `points`
    const std::size_t stride = facets.size() / all_middles_up_to + 1;
    for (std::uint32_t surface = 0; surface < distances.surfaces(); ++surface) {
        std::vector<Measured> points;
        std::vector<std::uint32_t> used;
        for (const std::uint32_t n : facets_of[surface]) {
            for (const std::uint32_t v : corners_of(n)) {
                if (place[v] != no_cell) continue;
                place[v] = static_cast<std::uint32_t>(points.size());
                points.push_back({mesh.points[v], surface, 0});
                used.push_back(v);
            }
        }
        for (const std::uint32_t n : facets_of[surface]) {
            if (n % stride == 0) points.push_back({middle_of(n), surface, 0});
        }
        parallel_for(points.size(), 4096, threads, [&](std::size_t first, std::size_t last) {
            for (std::size_t n = first; n < last; ++n)
                points[n].value = distances.value(surface, points[n].at);
        });
        for (const std::uint32_t n : facets_of[surface]) {
            if (on[n] < 2) continue;
            const Vec3 middle = middle_of(n);
            double gap = HUGE_VAL;
            for (const std::uint32_t v : corners_of(n)) gap = std::min(gap, points[place[v]].value);
            joined.push_back({middle, surface, gap});
        }
        for (const std::uint32_t v : used) place[v] = no_cell;
        report.points += points.size();
        all.insert(all.end(), points.begin(), points.end());
    }
    if (all.empty()) return report;
    const auto name_of = [&](std::uint32_t surface) {
        if (distances.is_all(surface)) return std::string("all structures together");
        const Structure& structure = structures[surface];
        return structure.name.empty() ? std::to_string(structure.number) : structure.name;
    };
    const Measured worst = farthest_of(largest(std::move(all)), distances);
    report.max_mm = worst.value;
    report.at_least = worst.value >= saturated * field.clamp();
    report.at = coordinates(worst.at);
    report.structure = name_of(worst.surface);
    if (joined.empty()) return report;
    joined = largest(std::move(joined));
    for (Measured& point : joined)
        point.value = std::min(point.value, distances.value(point.surface, point.at));
    const Measured hole = farthest_of(largest(std::move(joined)), distances);
    report.joined_mm = hole.value;
    report.joined_at = coordinates(hole.at);
    report.joined_structure = name_of(hole.surface);
    return report;
}

}  // namespace anatomesh
