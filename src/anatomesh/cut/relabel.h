// relabel: relabels cells until the surface of every structure is a manifold through its
// contours.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/cut/drawn_sections.h"
#include "anatomesh/mesh/model/region_registry.h"
#include "anatomesh/mesh/model/vertex_membership.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

// A vertex so far from interfaces would be a spike. [sizes; > 0; M 2026-11 22 random label maps]
inline constexpr double spike_share = 0.3;

struct RelabelStats {
    std::uint64_t nonmanifold_before = 0, nonmanifold_after = 0;  // vertices
    std::uint64_t lost_before = 0, lost_after = 0;  // contour vertices off their structure's surface
    std::uint64_t lost_subsegments_before = 0, lost_subsegments_after = 0;  // off their structure's surface
    std::uint64_t cells_moved = 0;
    std::uint64_t cells_mended = 0;       // relabelled to what is drawn where a slice's plane cuts them
    std::uint64_t flat_cells_peeled = 0;  // nearly flat cells relabelled to the region beside them

    // A call after this one: what is left is what that left.
    void add(const RelabelStats& later) {
        cells_moved += later.cells_moved;
        cells_mended += later.cells_mended;
        flat_cells_peeled += later.flat_cells_peeled;
        nonmanifold_after = later.nonmanifold_after;
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

// Greedy descent on a weighted sum over all vertices: singularity counts (StarAnalyzer::singularity_count) and, with
// less weight, subsegments off their structure's surface. Moves are made whenever the sum falls:
// - At a non-manifold vertex a component too many goes to the region beside it.
// - Where a contour vertex is off its surface, one or two cells at it change sides.
// - Where a subsegment is, one or two cells at that edge do.
// Vertices are taken in rising order, round by round. Among several moves those come first that lose fewest
// subsegments, then those by which the sum falls most, then those that leave fewest vertices on a side where the field
// does not have them. A subsegment is not brought back at the price of such a vertex, which would be a spike, but for
// one less deep than near_mm.
//
// Some moves wait until no others are left: those by which subsegments are lost, with losses_wait; those that bring a
// deep vertex onto a surface, with several structures; those that make cross-sections less like what is drawn, with
// `slices` (drawn_sections.h; where planes cross, by more than a ten-thousandth of it).
//
// In a stack two components of a side are joined, besides, by cells of the star that lie all above the slice's plane,
// or all below it: where what is drawn touches itself in a point, only that leads to a manifold with the drawn section.
// Elsewhere a subsegment is brought back also by moves of variable depth: up to twelve that do not make the sum fall,
// each with up to six rounds of moves after it (Kernighan and Lin, Bell Syst. Tech. J. 49, 1970); four times.
//
// At the end two kinds of cells change sides where no singularity count rises: nearly flat ones at an interface (six
// volumes below a millionth of the cube of the longest edge), which moves the surface by less than a millionth of an
// edge; and those that are wrong where a slice's plane cuts them.
//
// `look`: the vertices that may have a share in the sum, those of cells new since the last call among them; empty: all.
// The figures before are of these alone. `nonmanifold` receives the vertices left, in rising order, for
// resolve_nonmanifold(). Guarantees: the sum never rises; the same result at any number of threads.
RelabelStats relabel(const RelabelledMesh& mesh, const RelabelOptions& options,
                     std::vector<std::uint32_t>& nonmanifold, const std::vector<std::uint32_t>& look = {},
                     int threads = 1, const SlicePlanes& slices = {});

}  // namespace anatomesh
