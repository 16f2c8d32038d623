#include "anatomesh/cull/cull.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "anatomesh/base/parallel.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

namespace {

using Members = std::vector<std::uint32_t>;

struct Vote {
    Members members;
    double weight = 0;
};

// Adds weight to the vote with these members; the first one with them keeps its place.
void add_vote(std::vector<Vote>& votes, std::size_t& used, const Members& members, double weight) {
    for (std::size_t n = 0; n < used; ++n) {
        if (votes[n].members == members) {
            votes[n].weight += weight;
            return;
        }
    }
    if (used == votes.size()) votes.emplace_back();
    votes[used].members = members;
    votes[used++].weight = weight;
}

// A centroid as far from the interfaces is not outvoted, which is asked for once in 138,000 cells of a skull.
// [mean distances of the vertices from the centroid; 0 to 1; M 2026-11 skull]
constexpr double deep = 0.25;
constexpr double everywhere = std::numeric_limits<double>::infinity();  // as a reach

// Finds the regions of cells and points; keeps scratch space, one per thread.
class CellClassifier {
  public:
    CellClassifier(const StructureField& field, std::uint32_t structures)
        : field_(field), probe_(field, structures), single_(structures == 1), all_(structures) {
        std::iota(all_.begin(), all_.end(), 0u);
    }

    // Which side of every structure the point lies on, within the tolerance.
    struct Side {
        Members interior_of, closure_of;
        double depth = 0;
    };
    const Side& side(Vec3 p, double tolerance) {
        const InterfaceProbe::Look there = single_ ? probe_.look(p, tolerance) : probe_.look(p);
        side_.depth = there.distance;
        if (there.distance > tolerance) {
            side_.interior_of = side_.closure_of = there.members;
            return side_;
        }
        side_.interior_of.clear();
        side_.closure_of.clear();
        side_.depth = field_.clamp();
        if (single_) {
            side_.closure_of = all_;
            if (field_.exclusive()) side_.depth = 0;
            return side_;
        }
        near_.clear();
        field_.values_near(p, near_);
        for (const StructureField::Near& near : near_) {
            if (std::abs(near.value) > tolerance) side_.depth = std::min(side_.depth, std::abs(near.value));
            if (near.value < -tolerance) side_.interior_of.push_back(near.structure);
            if (near.value <= tolerance) side_.closure_of.push_back(near.structure);
        }
        if (field_.exclusive()) {
            // Their surfaces meet in walls: cells of those that have theirs there may, or of outside.
            side_.interior_of.clear();
            const double all = field_.union_value(p);
            if (std::abs(all) > tolerance) side_.depth = std::min(side_.depth, std::abs(all));
        }
        return side_;
    }

    // The winner is copied to `members`. `allowed`: whether all vertices may belong to a region.
    template <class Allowed>
    void classify(const std::array<Vec3, 4>& p, bool one_allowed, const Allowed& allowed, Members& members) {
        const Vec3 centroid = 0.25 * (p[0] + p[1] + p[2] + p[3]);
        if (one_allowed) {
            const Members& there = probe_.members(centroid);
            if (allowed(there)) {
                members = there;
                return;
            }
        }
        const bool may_be_deep = single_ && !one_allowed;
        const double at_depth = may_be_deep ? deep * spread(centroid, p) : everywhere;
        const InterfaceProbe::Look centre = probe_.look(centroid, at_depth);
        if (may_be_deep && centre.distance >= at_depth) {
            members = centre.members;
            return;
        }
        std::size_t used = 0;
        add_vote(votes_, used, centre.members, centre.distance);
        // Adds the vote of a point; whether it settles the matter.
        const auto settles = [&](Vec3 q) {
            const InterfaceProbe::Look there = probe_.look(q);
            if (one_allowed && allowed(there.members)) {
                members = there.members;
                return true;
            }
            add_vote(votes_, used, there.members, there.distance);
            return false;
        };
        for (const Vec3& q : p) {
            if (settles(0.5 * (centroid + q))) return;
        }
        std::size_t winner = used;
        for (const bool any : {false, true}) {
            for (std::size_t n = 0; n < used; ++n) {
                if (winner != used && !(votes_[n].weight > votes_[winner].weight)) continue;
                if (any || allowed(votes_[n].members)) winner = n;
            }
            if (winner != used) break;
        }
        members = votes_[winner].members;
    }

  private:
    // The mean distance of the vertices from the centroid.
    static double spread(Vec3 centroid, const std::array<Vec3, 4>& p) {
        double mean = 0;
        for (const Vec3& q : p) mean += 0.25 * length(q - centroid);
        return mean;
    }

    const StructureField& field_;
    InterfaceProbe probe_;
    bool single_;
    Members all_;
    std::vector<Vote> votes_;
    std::vector<StructureField::Near> near_;
    Side side_;
};

// A thread takes so many cells at a time; each piece numbers its own regions, so that numbers are the same
// for any number of threads. [cells; >= 1; B]
constexpr std::size_t grain = 512;

// Numbers of regions that are the same at any thread count: each piece of the work numbers the sets it meets, and the
// pieces' numbers are joined in order.
class PieceNumbers {
  public:
    explicit PieceNumbers(std::size_t count) : sets_((count + grain - 1) / grain), local_(count) {}

    void set(std::size_t index, const Members& members) {
        std::vector<Members>& known = sets_[index / grain];
        auto place = std::find(known.begin(), known.end(), members);
        if (place == known.end()) place = known.insert(known.end(), members);
        local_[index] = static_cast<std::uint16_t>(place - known.begin());
    }
    void join(RegionRegistry& registry) {
        for (const std::vector<Members>& piece : sets_) {
            numbers_.emplace_back();
            for (const Members& members : piece) numbers_.back().push_back(registry.intern(members));
        }
    }
    Region region(std::size_t index) const { return numbers_[index / grain][local_[index]]; }

  private:
    std::vector<std::vector<Members>> sets_;
    std::vector<std::uint16_t> local_;
    std::vector<std::vector<Region>> numbers_;
};

// How the sides of a cell's vertices bind its region.
struct Bounds {
    bool settled = false;      // all vertices are off the interfaces and lie in one region
    bool one_allowed = false;  // those off the interfaces do, and there are some
    Region region = 0;         // which
};

Bounds bounds_of(const Cell& cell, const std::vector<VertexMembership>& sides) {
    Bounds bounds;
    int off = 0;
    for (const std::uint32_t v : cell) {
        if (!sides[v].off_interfaces()) continue;
        if (off > 0 && sides[v].interior_of != bounds.region) return {};
        bounds.region = sides[v].interior_of;
        ++off;
    }
    bounds.one_allowed = off > 0;
    bounds.settled = off == 4;
    return bounds;
}

// Of the points from `first_new` on.
std::vector<double> tolerances_of(const ChosenCells& mesh, std::size_t first_new,
                                  const SurfaceTolerance& tolerance) {
    const std::vector<Vec3>& points = mesh.points;
    if (tolerance.of_edge == 0) return std::vector<double>(points.size() - first_new, tolerance.mm);
    const double far = tolerance.mm / tolerance.of_edge;
    std::vector<double> squared(points.size() - first_new, far * far);
    for (const std::uint32_t c : mesh.chosen) {
        for (const auto& [i, j] : cell_edges) {
            const std::uint32_t a = mesh.cells[c][i], b = mesh.cells[c][j];
            if (a < first_new && b < first_new) continue;
            const double edge = squared_length(points[a] - points[b]);
            for (const std::uint32_t v : {a, b}) {
                if (v >= first_new) squared[v - first_new] = std::min(squared[v - first_new], edge);
            }
        }
    }
    for (double& s : squared) s = std::min(tolerance.mm, tolerance.of_edge * std::sqrt(s));
    return squared;
}

}  // namespace

void find_memberships(const ChosenCells& mesh, const StructureField& field, std::uint32_t structures,
                      const SurfaceTolerance& tolerance, std::vector<VertexMembership>& memberships,
                      RegionRegistry& registry, RunContext& context) {
    const std::size_t first_new = memberships.size(), count = mesh.points.size() - first_new;
    const std::vector<double> tolerances = tolerances_of(mesh, first_new, tolerance);
    PieceNumbers interior_of(count), closure_of(count);
    std::vector<double> depth(count);
    parallel_for(count, grain, context.threads, [&](std::size_t first, std::size_t last) {
        CellClassifier classifier(field, structures);
        for (std::size_t n = first; n < last; ++n) {
            const CellClassifier::Side& side = classifier.side(mesh.points[first_new + n], tolerances[n]);
            interior_of.set(n, side.interior_of);
            closure_of.set(n, side.closure_of);
            depth[n] = side.depth;
        }
    });
    interior_of.join(registry);
    closure_of.join(registry);
    for (std::size_t n = 0; n < count; ++n)
        memberships.push_back({interior_of.region(n), closure_of.region(n), depth[n]});
}

CullStats cull(const ChosenCells& mesh, const std::vector<VertexMembership>& memberships,
               const StructureField& field, std::uint32_t structures, std::vector<Region>& regions,
               RegionRegistry& registry, RunContext& context) {
    assert(regions.size() == mesh.cells.size() && memberships.size() == mesh.points.size());
    const std::vector<Vec3>& points = mesh.points;
    const std::span<const std::uint32_t> chosen = mesh.chosen;
    CullStats stats;
    PieceNumbers numbers(chosen.size());
    const RegionTable& table = registry.table();
    parallel_for(chosen.size(), grain, context.threads, [&](std::size_t first, std::size_t last) {
        CellClassifier classifier(field, structures);
        Members members;
        for (std::size_t n = first; n < last; ++n) {
            const Cell& cell = mesh.cells[chosen[n]];
            const Bounds bounds = bounds_of(cell, memberships);
            if (bounds.settled) {
                numbers.set(n, table.members[bounds.region]);
                continue;
            }
            const auto allowed = [&](const Members& there) {
                return std::all_of(cell.begin(), cell.end(),
                                   [&](std::uint32_t v) { return allows(table, memberships[v], there); });
            };
            classifier.classify({points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]},
                                bounds.one_allowed, allowed, members);
            numbers.set(n, members);
        }
    });
    numbers.join(registry);
    for (std::size_t n = 0; n < chosen.size(); ++n) {
        regions[chosen[n]] = numbers.region(n);
        stats.culled += numbers.region(n) == 0;
    }
    stats.decided = chosen.size();
    return stats;
}

}  // namespace anatomesh
