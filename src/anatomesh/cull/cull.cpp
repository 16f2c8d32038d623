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

// Decides one cell; the winner is copied to `members`.
class CellJudge {
  public:
    CellJudge(const StructureField& field, std::uint32_t structures) : probe_(field, structures) {}

    void decide(const std::array<Vec3, 4>& p, Members& members) {
        const Vec3 centroid = 0.25 * (p[0] + p[1] + p[2] + p[3]);
        double reach = 0;
        for (const Vec3& q : p) reach = std::max(reach, squared_length(q - centroid));
        const double distance = probe_.distance(centroid);
        members = probe_.members(centroid);
        if (distance * distance > reach) return;

        std::size_t used = 0;
        add_vote(votes_, used, members, distance);
        for (const Vec3& q : p) {
            const Vec3 half_way = 0.5 * (centroid + q);
            const double weight = probe_.distance(half_way);
            add_vote(votes_, used, probe_.members(half_way), weight);
        }
        std::size_t winner = 0;
        for (std::size_t n = 1; n < used; ++n) {
            if (votes_[n].weight > votes_[winner].weight) winner = n;
        }
        members = votes_[winner].members;
    }

  private:
    InterfaceProbe probe_;
    std::vector<Vote> votes_;
};

constexpr std::size_t grain = 4096;

}  // namespace

CullStats cull(const std::vector<Vec3>& points, const std::vector<Cell>& cells, const StructureField& field,
               std::uint32_t structures, std::vector<Region>& regions, RegionRegistry& registry, RunContext& context) {
    assert(regions.size() == cells.size());
    CullStats stats;
    // Each piece numbers the sets it meets; the pieces' numbers are then joined in order, so that regions are
    // numbered the same way at any thread count.
    std::vector<std::vector<Members>> sets((cells.size() + grain - 1) / grain);
    std::vector<std::uint16_t> local(cells.size(), 0xFFFF);
    parallel_for(cells.size(), grain, context.threads, [&](std::size_t first, std::size_t last) {
        CellJudge judge(field, structures);
        std::vector<Members>& known = sets[first / grain];
        Members members;
        for (std::size_t c = first; c < last; ++c) {
            if (regions[c] != undecided_region) continue;
            judge.decide({points[cells[c][0]], points[cells[c][1]], points[cells[c][2]], points[cells[c][3]]}, members);
            auto place = std::find(known.begin(), known.end(), members);
            if (place == known.end()) place = known.insert(known.end(), members);
            local[c] = static_cast<std::uint16_t>(place - known.begin());
        }
    });
    std::vector<std::vector<Region>> numbers(sets.size());
    for (std::size_t piece = 0; piece < sets.size(); ++piece) {
        for (const Members& members : sets[piece]) numbers[piece].push_back(registry.intern(members));
    }
    for (std::size_t c = 0; c < cells.size(); ++c) {
        if (local[c] != 0xFFFF) {
            regions[c] = numbers[c / grain][local[c]];
            ++stats.decided;
        }
        stats.culled += regions[c] == 0;
    }
    return stats;
}

}  // namespace anatomesh
