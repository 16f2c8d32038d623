#include "anatomesh/improve/surgery/recover_on_surface.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/quality_gate.h"
#include "anatomesh/improve/core/surface_incidence.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/surgery/relabel_membrane_neighborhood.h"
#include "anatomesh/improve/surgery/spanning_membranes.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_chains =
    40;  // where more are off their surface, the size does not fit the contours
constexpr std::size_t most_improved = 12;          // membranes and thicknesses whose cells are worked on
constexpr std::size_t most_improved_at_last = 36;  // where some of these may be above the first bound
constexpr std::size_t most_improved_in_all = 100;
constexpr std::size_t most_tried_in_all = 1000;  // membranes and thicknesses, sound or not
constexpr std::size_t no_limit = static_cast<std::size_t>(-1);
constexpr int rounds = 4;  // over the chains: one may need that beside it

struct TriedChain : Chain {
    // When it was tried last:
    std::vector<std::uint32_t> reach = {};  // its vertices and those of its membranes; rising
    std::size_t changed_before = 0;         // cells, before it
};

class SurfaceRecovery {
  public:
    SurfaceRecovery(EditContext& edit, const DrawnSlices& drawn, double least_sine, double most_more,
                    const ImproveCells& improve)
        : edit_(edit),
          owners_(*drawn.owners),
          incidence_(edit),
          gate_(edit, drawn, least_sine),
          most_more_share_(most_more),
          improve_(improve) {
        if (!drawn.planes.empty()) areas_.emplace(edit, drawn);
    }

    SurfaceRecoveryStats run(std::span<const std::array<std::uint32_t, 3>> subsegments) {
        std::vector<TriedChain> chains;
        for (Chain& chain : find_chains(edit_, owners_, subsegments)) chains.push_back({std::move(chain)});
        SurfaceRecoveryStats stats;
        for (const TriedChain& chain : chains) stats.found += chain.vertices.size() - 1;
        if (chains.size() > most_chains) return stats;
        stats.recovered = stats.found;
        if (chains.empty()) return stats;
        std::vector<std::uint32_t> all = edit_.mesh.alive_cells();
        std::erase_if(all, [&](std::uint32_t c) { return edit_.mesh.region(c) == 0; });
        most_more_ = static_cast<std::size_t>(most_more_share_ * static_cast<double>(all.size()));
        above_bound_ = gate_.those_above_bound(std::move(all));
        for (int round = 0; round < rounds && !chains.empty(); ++round) {
            const std::size_t before = chains.size();
            std::erase_if(chains, [&](TriedChain& chain) {
                if (incidence_.on_surface(chain.vertices, chain.structure)) return true;
                if (is_enough() || (round > 0 && !has_changed(chain))) return false;
                chain.changed_before = changed_.size();
                return recover(chain);
            });
            if (chains.size() == before) break;
        }
        for (const TriedChain& chain : chains) stats.recovered -= chain.vertices.size() - 1;
        stats.changed = std::move(changed_);
        return stats;
    }

  private:
    enum class Outcome { done, unsound, bad_cut, bad_cells };

    // Whether cells at one of its membranes have, since it was tried.
    bool has_changed(const TriedChain& chain) const {
        return std::any_of(changed_.begin() + static_cast<std::ptrdiff_t>(chain.changed_before),
                           changed_.end(), [&](std::uint32_t c) {
                               const Cell& cell = edit_.mesh.cell(c);
                               return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) {
                                   return std::binary_search(chain.reach.begin(), chain.reach.end(), v);
                               });
                           });
    }

    bool recover(TriedChain& chain) {
        for (std::size_t n = chain.vertices.size() - 1; n > 0; --n) {
            if (!incidence_.beside_surface(chain.vertices[n - 1], chain.vertices[n], chain.structure))
                return false;
        }
        // The ring is now that of the first subsegment.
        const Region own = edit_.mesh.region(edit_.ring.cells.front());
        const std::vector<Membrane> membranes =
            find_membranes(edit_, chain, edit_.table->contains(own, chain.structure));
        chain.reach = chain.vertices;
        for (const Membrane& membrane : membranes) {
            const std::vector<std::uint32_t> more = membrane.vertices();
            chain.reach.insert(chain.reach.end(), more.begin(), more.end());
        }
        sort_distinct(chain.reach);
        least_more_ = no_limit;
        if (try_all(chain, membranes, own, 0)) return true;
        const std::size_t least = least_more_;
        return least <= most_more_ && try_all(chain, membranes, own, least);
    }

    bool is_enough() const { return improved_ >= most_improved_in_all || tried_ >= most_tried_in_all; }

    // `most_more`: cells above the first bound that may come of it where cells are parted.
    bool try_all(const Chain& chain, const std::vector<Membrane>& membranes, Region own,
                 std::size_t most_more) {
        const std::size_t improved_before = improved_,
                          most_here = most_more_ > 0 ? most_improved_at_last : most_improved;
        for (const Membrane& membrane : membranes) {
            for (const MembraneReach reach : {MembraneReach::wide, MembraneReach::joined}) {
                for (const double thickness : membrane_thicknesses) {
                    const Outcome outcome = attempt(chain, membrane, own, reach, thickness, most_more);
                    ++tried_;
                    if (outcome == Outcome::done) return true;
                    if (outcome == Outcome::unsound) break;
                    improved_ += outcome == Outcome::bad_cells;
                }
            }
            if (improved_ - improved_before >= most_here || is_enough()) break;
        }
        return false;
    }

    Outcome attempt(const Chain& chain, const Membrane& membrane, Region own, MembraneReach reach,
                    double thickness, std::size_t most_more) {
        const MeshImprovementStats stats = edit_.stats;
        edit_.mesh.begin_attempt();
        std::optional<RelabelledNeighborhood> made = relabel_membrane_neighborhood(
            edit_, owners_, chain, membrane, own, reach, thickness, areas_ ? &*areas_ : nullptr);
        if (!made || made->wrong_of_cuts > most_worse_sections) {
            edit_.mesh.end_attempt(false);
            return made ? Outcome::bad_cut : Outcome::unsound;
        }
        for (std::size_t n = 1; n < chain.vertices.size(); ++n) {
            edit_.constraints.fix_edge(chain.vertices[n - 1], chain.vertices[n]);
            edit_.constraints.release_edge(chain.vertices[n - 1], chain.vertices[n]);
        }
        std::vector<std::uint32_t> changed = std::move(made->changed);
        const std::vector<std::uint32_t> improved = improve_(changed);
        changed.insert(changed.end(), improved.begin(), improved.end());
        sort_distinct(changed);
        std::vector<std::uint32_t> above_bound = above_bound_;
        above_bound.insert(above_bound.end(), changed.begin(), changed.end());
        sort_distinct(above_bound);
        above_bound = gate_.those_above_bound(std::move(above_bound));
        const std::size_t more = above_bound.size() - std::min(above_bound.size(), above_bound_.size());
        bool good = incidence_.on_surface(chain.vertices, chain.structure) &&
                    std::all_of(changed.begin(), changed.end(),
                                [&](std::uint32_t c) { return gate_.is_good(c) && gate_.is_near(c); });
        if (good && made->parts_cells) {
            least_more_ = std::min(least_more_, more);
            good = more <= most_more;
        }
        edit_.mesh.end_attempt(good);
        if (good) {
            above_bound_ = std::move(above_bound);
            changed_.insert(changed_.end(), changed.begin(), changed.end());
        } else {
            for (std::size_t n = 1; n < chain.vertices.size(); ++n)
                edit_.constraints.keep_edge(chain.vertices[n - 1], chain.vertices[n]);
            edit_.stats = stats;
        }
        return good ? Outcome::done : Outcome::bad_cells;
    }

    EditContext& edit_;
    const ContourOwners& owners_;
    SurfaceIncidence incidence_;
    QualityGate gate_;
    std::optional<SectionAreas> areas_;
    std::size_t improved_ = 0;  // in vain
    std::size_t tried_ = 0;
    double most_more_share_;
    std::size_t most_more_ = 0;               // cells above the first bound that a chain may cost
    std::size_t least_more_ = no_limit;       // that it did
    std::vector<std::uint32_t> above_bound_;  // cells inside; rising
    std::vector<std::uint32_t> changed_;      // cells, for the chains that were recovered
    const ImproveCells& improve_;
};

}  // namespace

SurfaceRecoveryStats recover_on_surface(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                        double most_more, const ImproveCells& improve) {
    if (!drawn.table || !drawn.owners || drawn.subsegments_beside.empty()) return {};
    return SurfaceRecovery(edit, drawn, least_sine, most_more, improve).run(drawn.subsegments_beside);
}

}  // namespace anatomesh
