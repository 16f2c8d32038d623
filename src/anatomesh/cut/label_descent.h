// LabelDescent: moves of cells between regions by which the sum of singularity counts falls.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "anatomesh/cut/drawn_sections.h"
#include "anatomesh/cut/label_moves.h"
#include "anatomesh/cut/label_singularities.h"

namespace anatomesh {

// Which moves are made by now; the others wait until no more are left.
struct AllowedMoves {
    bool spikes = false;    // that bring a deep vertex onto a surface
    bool spoiling = false;  // that make cross-sections less like what is drawn
    bool losses = false;    // by which subsegments are lost
};

// What a move does to vertices whose membership the field gives.
class MovedMemberships {
  public:
    MovedMemberships(const RelabelledMesh& mesh, const RelabelOptions& options)
        : mesh_(mesh), deep_mm_(options.deep_mm), near_mm_(options.near_mm) {}

    // How many of the cell's vertices the field would have on another side if the cell were in the region.
    int misplaced(std::uint32_t cell, Region region) const;

    // Among the vertices of the move's cells that lie deep in a region: those with a cell that they do not allow, after
    // the move less before it.
    int spikes(const LabelMove& move);

  private:
    const RelabelledMesh& mesh_;
    const double deep_mm_, near_mm_;
    std::vector<std::uint32_t> around_;  // scratch
};

// One vertex at a time; which vertices, and when, is relabel()'s. Requires: mesh and slices outlive this. Not
// thread-safe.
class LabelDescent {
  public:
    LabelDescent(const RelabelledMesh& mesh, const RelabelOptions& options, const SlicePlanes& slices);

    AllowedMoves& allowed() { return allowed_; }
    LabelSingularities& singularities() { return singularities_; }

    // Whether a structure with a contour vertex there does not have it on its surface.
    bool is_lost(std::uint32_t vertex);

    // Makes the best move at the vertex by which the sum falls. Appends the vertices of its cells to `touched` and
    // returns how many cells moved.
    std::size_t improve(std::uint32_t vertex, std::vector<std::uint32_t>& touched);

    // A subsegment that is lost at the vertex comes back by a move that does not make the sum fall, if moves
    // after it at the vertices concerned, which leave its cells alone, make it fall in all, with fewer
    // subsegments lost, and no more vertices where the field does not have them. Returns as improve().
    // Follows: Kernighan and Lin, Bell Syst. Tech. J. 49, 1970 (moves of variable depth).
    std::size_t improve_in_depth(std::uint32_t vertex, std::vector<std::uint32_t>& touched);

    // Relabels a cell to a region beside it with which it shares two facets or more, if no singularity count rises.
    bool peel(std::uint32_t cell);

    // Relabels a cell that is wrong in a slice's plane to what is drawn there, if no singularity count rises.
    // Its vertices are added to `touched`.
    bool mend(std::uint32_t cell, std::vector<std::uint32_t>& touched);

  private:
    void find_best(std::uint32_t vertex);
    std::vector<LabelMove> openings_at(std::uint32_t vertex);
    bool follow(const LabelMove& opening);
    void make(const LabelMove& move, std::vector<std::uint32_t>& touched);
    bool may_bridge(std::uint32_t vertex);
    void find_regaining(std::uint32_t vertex);
    void consider_candidates(bool may_bridge_deep = false);
    void consider(LabelMove move, bool may_bridge_deep);
    bool is_held(std::uint32_t cell) const;

    const RelabelledMesh& mesh_;
    const SlicePlanes& slices_;
    std::optional<DrawnSections> sections_;  // with slices
    AllowedMoves allowed_;
    LabelSingularities singularities_;
    LabelMoves moves_;
    MovedMemberships memberships_;
    std::vector<LabelMove> candidates_;
    std::optional<LabelMove> best_;
    std::optional<std::vector<LabelMove>> openings_;      // while they are sought
    std::vector<std::uint32_t> held_;                     // cells that no move takes
    std::vector<std::pair<std::uint32_t, Region>> made_;  // in depth: the cells, and their regions before
    std::vector<StarComponent> components_;               // scratch, as the next two
    std::vector<std::uint32_t> lost_;
    std::vector<ContourOwners::Subsegment> lost_subsegments_;
};

}  // namespace anatomesh
