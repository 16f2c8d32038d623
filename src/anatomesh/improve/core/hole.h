// Hole: cells taken out of a mesh, to be replaced by those that one new vertex makes with the facets round
// them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// Grows over cells of one region where that makes the cells with the new vertex better (Klingner and
// Shewchuk, Proc. 16th International Meshing Roundtable, 2007). Nothing of the mesh changes but by fill().
class Hole {
  public:
    struct Facet {
        std::array<std::uint32_t, 3> v;  // counter-clockwise seen from outside the hole
        Region region;                   // of the cell that it will make
        std::uint32_t beyond;            // the cell behind it; no_cell where the hole must not grow
    };

    // The cells round an edge.
    Hole(EditContext& edit, const EdgeRing& ring);
    // Cells of one region. Those of their facets that are `given` - a cell and an index - make cells of the
    // region that lies across them.
    using CellFacet = std::pair<std::uint32_t, int>;
    Hole(EditContext& edit, std::vector<std::uint32_t> cells, std::span<const CellFacet> given);

    const std::vector<std::uint32_t>& cells() const { return cells_; }

    // Takes in the cells round another edge too, all of them of one region. False, and then it is no hole to
    // be filled, where they are of several, or would take a facet of an interface with them.
    bool add(const EdgeRing& ring);

    // The mean of its facets' corners.
    Vec3 centre() const;

    // Puts a new vertex where the worst of the cells is best, from p on. Commits them if they reach
    // `needed_sine(threshold)`, with the threshold of the cells before, and no ratio is above
    // `max_radius_edge` and above theirs. `adjust`, `normal`: as LocalStar::ascend() wants them.
    template <class NeededSine, class Adjust>
    bool fill(Vec3 p, Vec3 normal, double max_radius_edge, NeededSine&& needed_sine, Adjust&& adjust) {
        if (!adjust(p)) return false;
        const auto ascend = [&](double here) {
            return edit_.scratch.local.ascend(p, here, edit_.goal, normal, adjust);
        };
        return fill(p, max_radius_edge, needed_sine, ascend);
    }

    // The same with the vertex at p.
    template <class NeededSine>
    bool fill_from(Vec3 p, double max_radius_edge, NeededSine&& needed_sine) {
        return fill(p, max_radius_edge, needed_sine, [](double here) { return here; });
    }

  private:
    template <class NeededSine, class Ascend>
    bool fill(Vec3& p, double max_radius_edge, NeededSine& needed_sine, const Ascend& ascend) {
        QualityThreshold threshold;
        double reached = 0;
        bool allowed = false;
        for (int round = 0;; ++round) {
            threshold = edit_.threshold_of(cells_);
            squared_ratio_ = edit_.rule.allowed_squared_ratio(threshold, max_radius_edge);
            reached = ascend(begin_round(p, threshold));
            allowed = edit_.scratch.local.worst(p, reached) >= reached;
            if ((allowed && reached >= edit_.goal) || round == rounds || !grow(p)) break;
        }
        return allowed && reached >= needed_sine(threshold) && keeps_vertices() && commit(p);
    }

    // A larger hole is not worth its time. [facets; > 0; B]
    static constexpr std::size_t most_facets = 60;
    // The hole grows and the vertex climbs again so many times. [rounds; >= 0; B]
    static constexpr int rounds = 3;

    Facet facet(std::uint32_t c, int i) const;
    bool holds(std::uint32_t c) const { return std::find(cells_.begin(), cells_.end(), c) != cells_.end(); }
    double value(const Facet& f, Vec3 p) const;
    double begin_round(Vec3 p, const QualityThreshold& threshold);
    bool grow(Vec3 p);
    bool take(std::uint32_t c, Vec3 p, double own);
    bool may_take(std::uint32_t c) const;
    void take(std::uint32_t c);
    bool keeps_vertices() const;
    bool commit(Vec3 p);

    EditContext& edit_;
    std::vector<std::uint32_t> cells_;
    std::vector<Facet> facets_;
    double squared_ratio_ = 0;  // that new cells may have
};

}  // namespace anatomesh
