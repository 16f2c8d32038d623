#include "anatomesh/improve/surgery/remove_spikes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// Length of the sum of a vertex's facet normals, as a share of the sum of their lengths: a vertex above it is
// no spike. [1; 0 to 1; M 2026-11 skull, its CSL, fetal brain, pelvis, spine, 61 labels]
constexpr double flat_enough = 0.93;
// Places that are tried, as shares of the way from the apex to the base.
// [1; 0 to 1; M 2026-11 skull, its CSL, fetal brain, pelvis, spine, 61 labels]
constexpr std::array<double, 7> shares{0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3};
// A way to the nearest place of the field's surface goes on beyond it, so that one of the shares is near that place.
// [ways to the surface; 1 to 3; M 2026-11 random cylinders, pelvis, spine]
constexpr double past_surface = 1.6;
// Share of the way to the base: there the field is asked what should take the place.
// [1; 0 to 1; M 2026-11 skull, its CSL, fetal brain, pelvis, spine, 61 labels]
constexpr double inwards = 0.25;
// Share of the apex's distance from the field's surface that the new vertex may have.
// [1; 0 to 1; M 2026-11 skull, its CSL, fetal brain, pelvis, spine, 61 labels]
constexpr double gain = 0.75;
constexpr int most_times = 3;  // a new vertex may be an apex again [passes; > 0; B]

using Rim = std::vector<std::array<std::uint32_t, 2>>;

struct SurfaceFacet {
    std::array<std::uint32_t, 3> v;
    std::array<Region, 2> regions;
};

std::vector<SurfaceFacet> surface_facets(const EditMesh& mesh, int threads) {
    return parallel_collect<SurfaceFacet>(
        mesh.cell_count(), 16384, threads,
        [&](std::size_t first, std::size_t last, std::vector<SurfaceFacet>& found) {
            for (std::size_t n = first; n < last; ++n) {
                const auto c = static_cast<std::uint32_t>(n);
                if (!mesh.alive(c)) continue;
                const Cell& cell = mesh.cell(c);
                for (int i = 0; i < 4; ++i) {
                    const std::uint32_t other = mesh.neighbor(c, i);
                    if (other == no_cell || mesh.region(other) >= mesh.region(c)) continue;
                    const auto& corner = facet_vertices[i];
                    found.push_back({{cell[corner[0]], cell[corner[1]], cell[corner[2]]},
                                     {mesh.region(other), mesh.region(c)}});
                }
            }
        });
}

// Free vertices between two regions with facets that lean against each other, and all where more regions
// meet, in rising order.
std::vector<std::uint32_t> suspects(const EditContext& edit, int threads) {
    const EditMesh& mesh = edit.mesh;
    std::vector<Vec3> sum(mesh.point_count());
    std::vector<double> lengths(mesh.point_count(), 0);
    std::vector<std::array<Region, 2>> between(mesh.point_count());
    std::vector<std::uint8_t> is_junction(mesh.point_count(), 0);
    for (const SurfaceFacet& facet : surface_facets(mesh, threads)) {
        const auto& [a, b, c] = facet.v;
        const Vec3 normal = cross(mesh.point(b) - mesh.point(a), mesh.point(c) - mesh.point(a));
        const double area = length(normal);
        for (const std::uint32_t v : facet.v) {
            if (lengths[v] > 0 && between[v] != facet.regions) is_junction[v] = 1;
            between[v] = facet.regions;
            sum[v] += normal;
            lengths[v] += area;
        }
    }
    std::vector<std::uint32_t> found;
    for (std::uint32_t v = 0; v < sum.size(); ++v) {
        const bool is_sharp = !edit.constraints.fixed(v) && length(sum[v]) < flat_enough * lengths[v];
        if (lengths[v] > 0 && (is_sharp || is_junction[v])) found.push_back(v);
    }
    return found;
}

// Those of the vertices that are not near the field's surface. Where a mesh has one structure alone it is
// this surface that would move: the others, nearly all, need no look at their cells.
std::vector<std::uint32_t> far_ones(const EditContext& edit, const std::vector<std::uint32_t>& vertices,
                                    double spike_mm, int threads) {
    const auto& members = edit.table->members;
    if (members.size() != 2 || members[1].size() != 1) return vertices;
    return parallel_collect<std::uint32_t>(
        vertices.size(), 256, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& far) {
            InterfaceProbe probe = edit.probe;
            probe.focus(members[1]);
            for (std::size_t n = first; n < last; ++n) {
                if (probe.distance(edit.mesh.point(vertices[n]), spike_mm) > spike_mm)
                    far.push_back(vertices[n]);
            }
        });
}

// Whether the edges are one closed line that meets no vertex twice.
bool is_circle(const Rim& rim) {
    if (rim.size() < 3) return false;
    std::size_t met = 1;
    for (std::uint32_t at = rim[0][1]; at != rim[0][0]; ++met) {
        const auto next =
            std::find_if(rim.begin(), rim.end(), [&](const auto& edge) { return edge[0] == at; });
        if (next == rim.end() || met == rim.size()) return false;
        at = (*next)[1];
    }
    return met == rim.size();
}

class SpikeRemoval {
  public:
    SpikeRemoval(EditContext& edit, double spike_mm, double least_sine)
        : edit_(edit), apex_mm_(spike_mm), least_sine_(least_sine) {}

    // Lowers the cells of each region at the vertex that stand out there, and those at the new vertices.
    void lower(std::uint32_t vertex) {
        edit_.mesh.star(vertex, edit_.star);
        std::vector<Region> regions;
        for (const std::uint32_t c : edit_.star) regions.push_back(edit_.mesh.region(c));
        std::sort(regions.begin(), regions.end());
        regions.erase(std::unique(regions.begin(), regions.end()), regions.end());
        for (const Region receding : regions) {
            std::optional<std::uint32_t> apex = vertex;
            for (int n = 0; n < most_times && apex; ++n) apex = lower(*apex, receding);
        }
    }

    SpikeStats stats;

  private:
    // The new vertex in its place, if it is an apex of cells of that region and can be removed.
    std::optional<std::uint32_t> lower(std::uint32_t apex, Region receding) {
        if (!look_at(apex, receding)) return std::nullopt;
        ++stats.found;
        std::optional<Vec3> to;
        for (const double most : {edit_.options.max_radius_edge, edit_.options.last_radius_edge}) {
            if (!to) to = place_for(apex, most);
        }
        if (!to) return std::nullopt;
        const auto next = static_cast<std::uint32_t>(edit_.mesh.point_count());
        make_cells(apex, next);
        if (!keeps_regions_whole(apex)) return std::nullopt;
        const std::uint32_t v = edit_.add_point(*to);
        if (!edit_.commit(receding_, edit_.scratch.cells, edit_.scratch.regions)) return std::nullopt;
        ++stats.removed;
        return v;
    }

    // Fills what is known of the apex, and turns the probe to the surfaces that would move.
    bool look_at(std::uint32_t apex, Region receding) {
        edit_.mesh.star(apex, edit_.star);
        if (!find_rim(apex, receding) || !is_circle(rim_)) return false;
        const Vec3 p = edit_.mesh.point(apex);
        base_ = {};
        for (const std::uint32_t c : receding_)
            base_ = base_ + (1 / static_cast<double>(receding_.size())) * opposite(c, apex);
        const std::vector<std::uint32_t>& told = edit_.probe.members(p + inwards * (base_ - p));
        const auto taking = std::find_if(beyond_.begin(), beyond_.end(),
                                         [&](Region r) { return edit_.table->members[r] == told; });
        if (taking == beyond_.end()) return false;
        region_ = *taking;
        return surfaces_are_far(p, receding);
    }

    // Of the cells of a region in the star. False where the mesh ends.
    bool find_rim(std::uint32_t apex, Region receding) {
        receding_.clear();
        rim_.clear();
        beyond_.clear();
        for (const std::uint32_t c : edit_.star) {
            if (edit_.mesh.region(c) != receding) continue;
            receding_.push_back(c);
            const Cell& cell = edit_.mesh.cell(c);
            for (int i = 0; i < 4; ++i) {
                if (cell[i] == apex) continue;
                const std::uint32_t n = edit_.mesh.neighbor(c, i);
                if (n == no_cell) return false;
                if (edit_.mesh.region(n) == receding) continue;
                rim_.push_back(others_of_facet(cell, i, apex));
                beyond_.push_back(edit_.mesh.region(n));
            }
        }
        return true;
    }

    // Whether all surfaces between the two regions are, and none that also goes elsewhere from the apex
    // would have to stay there.
    bool surfaces_are_far(Vec3 p, Region receding) {
        const std::vector<std::uint32_t>&here = edit_.table->members[receding],
              &there = edit_.table->members[region_];
        std::vector<std::uint32_t> moving;
        std::set_symmetric_difference(here.begin(), here.end(), there.begin(), there.end(),
                                      std::back_inserter(moving));
        for (const std::uint32_t s : moving) {
            const bool leaves = std::binary_search(here.begin(), here.end(), s);
            const auto stays = [&](Region beyond) { return edit_.table->contains(beyond, s) == leaves; };
            if (std::any_of(beyond_.begin(), beyond_.end(), stays)) return false;
            edit_.probe.focus({&s, 1});
            if (edit_.probe.distance(p) <= apex_mm_) return false;
        }
        edit_.probe.focus(moving);
        return true;
    }

    // On the ways to the middles of the base of the cells that recede, and of the rim, and past the nearest place of
    // the field's surface.
    std::optional<Vec3> place_for(std::uint32_t apex, double most_ratio) {
        const Vec3 from = edit_.mesh.point(apex);
        Vec3 rim{};
        for (const auto& edge : rim_)
            rim = rim + (1 / static_cast<double>(rim_.size())) * edit_.mesh.point(edge[0]);
        const double depth = edit_.probe.distance(from);
        const double most_distance = gain * depth, most_far = farthest(from);
        const Vec3 nearest = edit_.probe.project(from, 2 * depth, edit_.options.tolerance_mm).value_or(from);
        double best = HUGE_VAL;
        std::optional<Vec3> to;
        for (const Vec3 foot : {base_, rim, from + past_surface * (nearest - from)}) {
            for (const double share : shares) {
                const Vec3 q = from + share * (foot - from);
                const double distance = edit_.probe.distance(q);
                if (distance > most_distance) continue;
                const double far = farthest(q);
                if (far > most_far || distance + far >= best || !may_be(apex, q, most_ratio)) continue;
                best = distance + far;
                to = q;
            }
        }
        return to;
    }

    Vec3 opposite(std::uint32_t c, std::uint32_t apex) const {
        Vec3 sum{};
        for (const std::uint32_t v : edit_.mesh.cell(c)) {
            if (v != apex) sum = sum + (1.0 / 3) * edit_.mesh.point(v);
        }
        return sum;
    }

    // Of the vertex at q and the middles of its facets from the field's surface.
    double farthest(Vec3 q) {
        double distance = edit_.probe.distance(q);
        for (const auto& [a, b] : rim_)
            distance = std::max(distance, edit_.facet_distance(q, edit_.mesh.point(a), edit_.mesh.point(b)));
        return distance;
    }

    bool is_good(const std::array<Vec3, 4>& p, Region region, const QualityThreshold& threshold,
                 double most_ratio) const {
        if (orient3d(p[0], p[1], p[2], p[3]) <= 0) return false;
        const CellMeasures m = measure_cell(p[0], p[1], p[2], p[3]);
        if (region == 0) return m.least_sine() >= edit_.rule.needed_outside_sine(threshold);
        return m.least_sine() >= least_sine_ && m.squared_ratio <= most_ratio * most_ratio;
    }

    // With the new vertex at q.
    bool may_be(std::uint32_t apex, Vec3 q, double most_ratio) const {
        const QualityThreshold threshold = edit_.threshold_of(receding_);
        const Vec3 p = edit_.mesh.point(apex);
        for (const auto& [a, b] : rim_) {
            if (!is_good({q, p, edit_.mesh.point(a), edit_.mesh.point(b)}, region_, threshold, most_ratio))
                return false;
        }
        return std::all_of(receding_.begin(), receding_.end(), [&](std::uint32_t c) {
            std::array<Vec3, 4> corners;
            for (std::size_t i = 0; i < 4; ++i) {
                const std::uint32_t v = edit_.mesh.cell(c)[i];
                corners[i] = v == apex ? q : edit_.mesh.point(v);
            }
            return is_good(corners, edit_.mesh.region(c), threshold, most_ratio);
        });
    }

    // Where the cells that recede border on several regions, the one that takes their place might come to be
    // in two pieces at a vertex, or round another region.
    bool keeps_regions_whole(std::uint32_t apex) {
        if (std::all_of(beyond_.begin(), beyond_.end(), [&](Region r) { return r == region_; })) return true;
        return is_whole_at(apex) &&
               std::all_of(rim_.begin(), rim_.end(), [&](const auto& edge) { return is_whole_at(edge[0]); });
    }

    // Whether with the new cells the region that grows, and all the others together, are in one piece each at
    // a vertex: then its surface is a disc there, for what the cells at a vertex cut out of a small sphere is
    // bounded by one circle if it and the rest are connected.
    bool is_whole_at(std::uint32_t v) {
        around_.clear();
        const auto has_it = [&](const Cell& cell) {
            return std::find(cell.begin(), cell.end(), v) != cell.end();
        };
        edit_.mesh.star(v, edit_.star);
        for (const std::uint32_t c : edit_.star) {
            if (std::find(receding_.begin(), receding_.end(), c) == receding_.end())
                around_.push_back({edit_.mesh.cell(c), edit_.mesh.region(c) == region_});
        }
        for (std::size_t n = 0; n < edit_.scratch.cells.size(); ++n) {
            if (has_it(edit_.scratch.cells[n]))
                around_.push_back({edit_.scratch.cells[n], edit_.scratch.regions[n] == region_});
        }
        return is_connected(true) && is_connected(false);
    }

    // Across facets at the vertex that all have.
    bool is_connected(bool in_region) {
        const auto shared = [](const Cell& a, const Cell& b) {
            return std::count_if(a.begin(), a.end(), [&](std::uint32_t v) {
                return std::find(b.begin(), b.end(), v) != b.end();
            });
        };
        std::vector<Cell> waiting, reached;
        for (const auto& [cell, in] : around_) {
            if (in == in_region) waiting.push_back(cell);
        }
        if (waiting.empty()) return true;
        reached.push_back(waiting.back());
        waiting.pop_back();
        for (std::size_t n = 0; n < reached.size(); ++n) {
            const auto apart = std::partition(waiting.begin(), waiting.end(), [&](const Cell& cell) {
                return shared(cell, reached[n]) != 3;
            });
            reached.insert(reached.end(), apart, waiting.end());
            waiting.erase(apart, waiting.end());
        }
        return waiting.empty();
    }

    void make_cells(std::uint32_t apex, std::uint32_t v) {
        edit_.scratch.cells.clear();
        edit_.scratch.regions.clear();
        for (const std::uint32_t c : receding_) {
            edit_.scratch.cells.push_back(edit_.mesh.cell(c));
            std::replace(edit_.scratch.cells.back().begin(), edit_.scratch.cells.back().end(), apex, v);
            edit_.scratch.regions.push_back(edit_.mesh.region(c));
        }
        for (const auto& [a, b] : rim_) {
            edit_.scratch.cells.push_back({v, apex, a, b});
            edit_.scratch.regions.push_back(region_);
        }
    }

    EditContext& edit_;
    double apex_mm_, least_sine_;
    std::vector<std::uint32_t> receding_;        // cells at the apex in a region that the field is not in
    Vec3 base_;                                  // the middle of their facets opposite the apex
    Rim rim_;                                    // of their other facets, seen from without
    std::vector<Region> beyond_;                 // those facets, one for each edge of the rim
    Region region_ = 0;                          // what takes their place: the one the field is in
    std::vector<std::pair<Cell, bool>> around_;  // cells at a vertex, and whether they are in it
};

}  // namespace

SpikeStats remove_spikes(EditContext& edit, double spike_mm, double least_sine, int threads) {
    if (!edit.table) return {};
    SpikeRemoval lowering(edit, spike_mm, least_sine);
    for (const std::uint32_t v : far_ones(edit, suspects(edit, threads), spike_mm, threads))
        lowering.lower(v);
    return lowering.stats;
}

}  // namespace anatomesh
