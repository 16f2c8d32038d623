#include "anatomesh/cull/cull.h"

#include <algorithm>
#include <array>
#include <cassert>

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

// Of the mean distance of a cell's vertices from its centroid: a centroid as far from the interfaces is not
// outvoted (once in 138,000 cells of a skull).
constexpr double deep = 0.25;

// Finds the regions of cells and points; keeps scratch space, one per thread.
class Judge {
  public:
    Judge(const StructureField& field, std::uint32_t structures)
        : probe_(field, structures), single_(structures == 1) {}

    // The members at p; nullptr when p lies within tolerance of an interface.
    const Members* side(Vec3 p, double tolerance) {
        const InterfaceProbe::Look there = probe_.look(p, tolerance);
        return there.distance <= tolerance ? nullptr : &there.members;
    }

    // The winner is copied to `members`. `preferred` is the one region of the vertices off the interfaces, or null.
    void decide(const std::array<Vec3, 4>& p, const Members* preferred, Members& members) {
        const Vec3 centroid = 0.25 * (p[0] + p[1] + p[2] + p[3]);
        if (preferred && probe_.members(centroid) == *preferred) {
            members = *preferred;
            return;
        }
        const InterfaceProbe::Look centre = probe_.look(centroid);
        if (single_ && !preferred && is_deep(centre.distance, centroid, p)) {
            members = centre.members;
            return;
        }
        std::size_t used = 0;
        add_vote(votes_, used, centre.members, centre.distance);
        // Adds the vote of a point; whether it settles the matter.
        const auto settles = [&](Vec3 q) {
            const InterfaceProbe::Look there = probe_.look(q);
            if (preferred && there.members == *preferred) {
                members = *preferred;
                return true;
            }
            add_vote(votes_, used, there.members, there.distance);
            return false;
        };
        for (const Vec3& q : p) {
            if (settles(0.5 * (centroid + q))) return;
        }
        std::size_t winner = 0;
        for (std::size_t n = 1; n < used; ++n) {
            if (votes_[n].weight > votes_[winner].weight) winner = n;
        }
        members = votes_[winner].members;
    }

  private:
    static bool is_deep(double distance, Vec3 centroid, const std::array<Vec3, 4>& p) {
        double spread = 0;
        for (const Vec3& q : p) spread += 0.25 * length(q - centroid);
        return distance >= deep * spread;
    }

    InterfaceProbe probe_;
    bool single_;
    std::vector<Vote> votes_;
};

constexpr std::size_t grain = 4096;
constexpr std::uint16_t unset = 0xFFFF;

// Numbers of regions that are the same at any thread count: each piece of the work numbers the sets it meets, and the
// pieces' numbers are joined in order.
class PieceNumbers {
  public:
    explicit PieceNumbers(std::size_t count) : sets_((count + grain - 1) / grain), local_(count, unset) {}

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
    bool known(std::size_t index) const { return local_[index] != unset; }
    Region region(std::size_t index) const { return numbers_[index / grain][local_[index]]; }

  private:
    std::vector<std::vector<Members>> sets_;
    std::vector<std::uint16_t> local_;
    std::vector<std::vector<Region>> numbers_;
};

constexpr Region no_region = 0xFFFF;

// The one region of the vertices off the interfaces; no_region when there is none, or more than one.
Region common_side(const Cell& cell, const std::vector<Region>& sides) {
    Region common = no_region;
    for (const std::uint32_t v : cell) {
        if (sides[v] == on_interface || sides[v] == common) continue;
        if (common != no_region) return no_region;
        common = sides[v];
    }
    return common;
}

}  // namespace

void find_sides(const std::vector<Vec3>& points, const StructureField& field, std::uint32_t structures, double tolerance,
                std::vector<Region>& sides, RegionRegistry& registry, RunContext& context) {
    const std::size_t first_new = sides.size(), count = points.size() - first_new;
    PieceNumbers numbers(count);
    parallel_for(count, grain, context.threads, [&](std::size_t first, std::size_t last) {
        Judge judge(field, structures);
        for (std::size_t n = first; n < last; ++n) {
            if (const Members* members = judge.side(points[first_new + n], tolerance)) numbers.set(n, *members);
        }
    });
    numbers.join(registry);
    for (std::size_t n = 0; n < count; ++n) sides.push_back(numbers.known(n) ? numbers.region(n) : on_interface);
}

CullStats cull(const std::vector<Vec3>& points, const std::vector<Cell>& cells, std::span<const std::uint32_t> chosen,
               const std::vector<Region>& sides, const StructureField& field, std::uint32_t structures,
               std::vector<Region>& regions, RegionRegistry& registry, RunContext& context) {
    assert(regions.size() == cells.size() && sides.size() == points.size());
    CullStats stats;
    PieceNumbers numbers(chosen.size());
    const RegionTable& table = registry.table();
    parallel_for(chosen.size(), grain, context.threads, [&](std::size_t first, std::size_t last) {
        Judge judge(field, structures);
        Members members;
        for (std::size_t n = first; n < last; ++n) {
            const Cell& cell = cells[chosen[n]];
            const Region side = common_side(cell, sides);
            const bool all_off = std::none_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return sides[v] == on_interface; });
            if (all_off && side != no_region) {
                numbers.set(n, table.members[side]);
                continue;
            }
            judge.decide({points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]},
                         side == no_region ? nullptr : &table.members[side], members);
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
