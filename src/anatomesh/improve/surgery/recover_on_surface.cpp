#include "anatomesh/improve/surgery/recover_on_surface.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/surface_incidence.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/surgery/membrane_surgery.h"
#include "anatomesh/improve/surgery/spanning_membranes.h"

namespace anatomesh {

namespace {

// Where more chains are off their surface, the size does not fit the contours. [chains; > 0; B]
constexpr std::size_t most_chains = 40;
// Attempts for one chain whose cells are improved in vain. [attempts; > 0; B]
constexpr std::size_t most_improved = 12;
// The same where cells above the first bound may be added, and for all chains. [attempts; > 0; B]
constexpr std::size_t most_improved_at_last = 36;
// Attempts for all chains whose cells are improved in vain. [attempts; > 0; B]
constexpr std::size_t most_improved_in_all = 100;
constexpr std::size_t most_tried_in_all = 1000;  // attempts, sound or not [attempts; > 0; B]
// More cells than any attempt costs: no attempt was made yet. [cells; -; D]
constexpr std::size_t no_limit = static_cast<std::size_t>(-1);
constexpr int rounds = 4;  // over the chains: one may need that beside it [passes; > 0; B]
constexpr std::array chain_reaches{MembraneReach::wide, MembraneReach::joined};

struct TriedChain : Chain {
    std::vector<std::uint32_t> reach = {};  // vertices of it and its membranes at the last attempt; rising
    std::size_t changed_before = 0;         // changed cells before that
};

class SurfaceRecovery {
  public:
    SurfaceRecovery(EditContext& edit, const DrawnSlices& drawn, double least_sine, double most_more,
                    const ImproveCells& improve)
        : edit_(edit),
          drawn_(drawn),
          incidence_(edit),
          least_sine_(least_sine),
          most_more_share_(most_more),
          improve_(improve) {
        if (!drawn.planes.empty()) areas_.emplace(edit, drawn);
    }

    SurfaceRecoveryStats run(std::span<const std::array<std::uint32_t, 3>> subsegments) {
        std::vector<TriedChain> chains;
        for (Chain& chain : find_chains(edit_, *drawn_.owners, subsegments))
            chains.push_back({std::move(chain)});
        SurfaceRecoveryStats stats;
        for (const TriedChain& chain : chains) stats.found += chain.vertices.size() - 1;
        if (chains.size() > most_chains) return stats;
        stats.recovered = stats.found;
        if (chains.empty()) return stats;
        surgery_.emplace(edit_, drawn_, areas_ ? &*areas_ : nullptr, least_sine_, improve_);
        most_more_ = static_cast<std::size_t>(most_more_share_ *
                                              static_cast<double>(surgery_->budget().cells_inside()));
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
    // Whether cells at one of its membranes have changed since the chain was tried.
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

    // `most_more`: cells above the first bound that may be added where cells are parted.
    bool try_all(const Chain& chain, const std::vector<Membrane>& membranes, Region own,
                 std::size_t most_more) {
        const std::size_t improved_before = improved_,
                          most_here = most_more_ > 0 ? most_improved_at_last : most_improved;
        SurgeryProposal proposal;
        proposal.relabelling.chain = chain;
        proposal.relabelling.own = own;
        proposal.most_mm = edit_.options.spike_mm;
        proposal.most_more_where_parted = most_more;
        for (const Membrane& membrane : membranes) {
            proposal.relabelling.membrane = membrane;
            if (surgery_->attempt_each(proposal, chain_reaches, membrane_thicknesses,
                                       [&](const SurgeryResult& result) { return note(result); }))
                return true;
            if (improved_ - improved_before >= most_here || is_enough()) break;
        }
        return false;
    }

    // All reaches and thicknesses of a membrane are tried.
    bool note(const SurgeryResult& result) {
        ++tried_;
        improved_ += result.verdict == SurgeryVerdict::in_vain;
        if (result.more_above && result.parts_cells) least_more_ = std::min(least_more_, *result.more_above);
        if (result.verdict == SurgeryVerdict::done)
            changed_.insert(changed_.end(), result.changed.begin(), result.changed.end());
        return true;
    }

    EditContext& edit_;
    const DrawnSlices& drawn_;
    SurfaceIncidence incidence_;
    double least_sine_;
    std::optional<SectionAreas> areas_;
    std::optional<MembraneSurgery> surgery_;  // if there are chains
    std::size_t improved_ = 0;                // attempts whose cells were improved in vain
    std::size_t tried_ = 0;                   // attempts
    double most_more_share_;
    std::size_t most_more_ = 0;           // cells above the first bound that a chain may cost
    std::size_t least_more_ = no_limit;   // the fewest that an attempt at the chain cost
    std::vector<std::uint32_t> changed_;  // cells, for the chains that were recovered
    const ImproveCells& improve_;
};

}  // namespace

SurfaceRecoveryStats recover_on_surface(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                        double most_more, const ImproveCells& improve) {
    if (!drawn.table || !drawn.owners || drawn.subsegments_beside.empty()) return {};
    return SurfaceRecovery(edit, drawn, least_sine, most_more, improve).run(drawn.subsegments_beside);
}

}  // namespace anatomesh
