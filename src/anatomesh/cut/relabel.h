// relabel: relabels cells until the surface of every structure is a manifold through its
// contours.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/cut/drawn_cuts.h"
#include "anatomesh/mesh/model/region_registry.h"
#include "anatomesh/mesh/model/vertex_membership.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

inline constexpr double spike_share = 0.3;  // of a size: a vertex so far from interfaces would be a spike

struct RelabelStats {
    std::uint64_t unsound_before = 0, unsound_after = 0;  // vertices
    std::uint64_t lost_before = 0, lost_after = 0;        // contour vertices off their structure's surface
    std::uint64_t lost_subsegments_before = 0,
                  lost_subsegments_after = 0;  // of contour segments, off their structure's surface
    std::uint64_t cells_moved = 0;
    std::uint64_t cells_mended = 0;       // relabelled to what is drawn where a slice's plane cuts them
    std::uint64_t flat_cells_peeled = 0;  // nearly flat cells relabelled to the region beside them

    // A call after this one: what is left is what that left.
    void add(const RelabelStats& later) {
        cells_moved += later.cells_moved;
        cells_mended += later.cells_mended;
        flat_cells_peeled += later.flat_cells_peeled;
        unsound_after = later.unsound_after;
        lost_after = later.lost_after;
        lost_subsegments_after = later.lost_subsegments_after;
    }
};

struct RelabelOptions {
    // Vertices deeper than this in a region would be spikes on a surface, in mm. [0, inf)
    double deep_mm = 0;
    // Vertices less deep than this, in mm, count as where the field has them, whatever side they come to:
    // they speak against no move. [0, inf)
    double near_mm = 0;
    // Moves by which subsegments are lost wait until no others are left. About an axis that
    // costs handles.
    bool losses_wait = true;
};

// The mesh that is relabelled: its cells stay, their regions change.
struct RelabelledMesh {
    const std::vector<Vec3>& points;
    const std::vector<Cell>& cells;
    const std::vector<CellNeighbors>& neighbors;
    const VertexStars& stars;
    const ContourOwners& owners;
    // By point, as find_memberships() (cull/cull.h) gives them; empty: not looked at.
    const std::vector<VertexMembership>& memberships;
    std::vector<Region>& regions;
    RegionRegistry& registry;
};

// Greedy descent on the sum of defects over all vertices (StarAnalyzer::defect, and the subsegments of
// contour segments off their surface): at an unsound vertex a component too many is relabelled to the region
// beside it, or, where a contour vertex is off its surface, one or two cells at it change sides, or, where a
// subsegment of a contour segment is, one or two cells at that edge, whenever the sum falls. Of several moves
// one that loses the fewest subsegments is made, then one by which the sum falls most: what else is amiss
// beside it is mended by moves of its own. Vertices are taken in rising order, round by round, until nothing
// falls. Among moves of one effect that with the fewest vertices left on a side where the field does not have
// them (`memberships`). A subsegment is not brought back at
// the price of such a vertex, but for one less deep than near_mm: that would be a spike. With several
// structures, moves that bring a deep vertex onto a surface are made only when no others are left. Where
// `slices` are no stack, then, four times, a subsegment is brought back also by one of up to twelve moves
// that do not make the sum fall, if up to six rounds of moves at the vertices concerned make it fall below
// what it was, with fewer subsegments lost and no more vertices on a side where the field does not have them
// (Kernighan and Lin, Bell Syst. Tech. J. 49, 1970). Guarantees: the sum never rises; same result every time,
// at any number of threads. Does not always reach 0: what is left is for split_unsound(). `unsound` receives
// the vertices left, in rising order. Last, nearly flat cells at an interface (six volumes below a millionth
// of the cube of the longest edge: four vertices of two contours one above the other) go to the other side
// where no defect rises: that moves the surface by less than a millionth of an edge. `look`: the vertices
// that may have a defect, those of cells new since the last call among them; empty: all. The figures before
// are of these alone. With `slices`: moves that make cuts less like what is drawn (drawn_cuts.h; where planes
// cross, by more than a ten-thousandth of it) wait until no others are left, as do, meanwhile, of a stack,
// those that bring a deep vertex onto a surface; then one that does neither is taken sooner. Of a stack two
// components of a side are joined, besides, by cells of the star that lie all above the slice's plane, or all
// below it: where what is drawn touches itself in a point of the slice, that is the only way to a manifold
// with the drawn cut, and is gone, through deep vertices too, before a cut is spoiled. At the end cells that
// are wrong where a plane cuts them are relabelled to what is drawn there if no defect rises.
RelabelStats relabel(const RelabelledMesh& mesh, const RelabelOptions& options,
                     std::vector<std::uint32_t>& unsound, const std::vector<std::uint32_t>& look = {},
                     int threads = 1, const SlicePlanes& slices = {});

}  // namespace anatomesh
