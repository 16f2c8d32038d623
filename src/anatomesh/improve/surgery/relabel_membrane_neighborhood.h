// relabel_membrane_neighborhood: relabels the cells at a membrane to the other side of its structure, so that
// its chain comes to lie on the surface.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/surgery/spanning_membranes.h"

namespace anatomesh {

// Thicknesses that are tried, as shares of the edges that lead off a membrane.
// [1; 0 to 1; M 2026-11 fetal brain, body labels, abdomen]
inline constexpr std::array membrane_thicknesses{0.5, 0.3, 0.15};

// On which sides of a membrane cells are relabelled. Two cells meet at its first facet: the first side is
// that of the lower number.
enum class MembraneSides { both, first, second };

// A membrane that is no chain's: of a patch in a slice's plane, or one across a hole or a bridge.
struct MembraneAcross {
    MembraneSides sides = MembraneSides::both;
    Vec3 normal;               // of the plane that it lies in, if cells are relabelled on both sides
    std::optional<Region> to;  // the region that the cells get; none: as beside the chain's ends
};

// How far the relabelled neighbourhood extends along the surface of the structure, from the membrane on.
// - `wide`: to every vertex of the surface that an edge joins to the membrane.
// - `joined`: to such a vertex only if edges of the surface join it to all vertices that its cell has of the
//   membrane.
// - `near`: to no such vertex. Edges of the surface are cut too, but those of contours.
// - `others`: as `near`. Where a pinch is resolved at a vertex, cells of other regions are relabelled too.
enum class MembraneReach { wide, joined, near, others };

// Which cells are relabelled, and how far from the membrane.
struct MembraneRelabelling {
    Chain chain;  // its vertices come to lie on the structure's surface
    Membrane membrane;
    Region own = 0;  // in which the chain lies; cells of other regions stay
    MembraneReach reach = MembraneReach::wide;
    double thickness = 0.5;  // where edges that lead off the membrane are cut, as shares. (0, 1)
    std::optional<MembraneAcross> across;  // none: the membrane is the chain's
};

struct RelabelledNeighborhood {
    std::vector<std::uint32_t> changed;  // cells that were made or changed their region; rising
    double wrong_of_cuts = 0;            // by which sections got worse, as a share of what is drawn
    bool parts_cells = false;            // of the chain's region, at a vertex of the membrane
    std::vector<std::uint32_t> parted;   // structures that lose a handle or a tunnel, or fall into parts
    bool joins = false;  // joins parts of the side where cells go, or makes a handle or a tunnel there
};

// Relabels the regular neighbourhood of a membrane to the other side of its structure (Rourke and Sanderson,
// Introduction to Piecewise-Linear Topology, 1972, chapter 3): edges that lead off the membrane are cut, and
// the cells between the cuts change their region. Some cells are exceptions:
// - A chain's membrane: cells that have nothing of it but subsegments on its rim stay.
// - A membrane across, on both sides: cells at subsegments on its rim change too, if they lie between the
//   membrane and the other side, and not beyond the subsegment in the plane.
// - A membrane across, on one side: all cells change that facets at vertices of the membrane join there. So
//   what is on the membrane's rim stays on the surface.
// - Where changed cells meet the other side in no facet at a vertex, those between them change too (across
//   alone, resolve_pinches.h).
//
// The Euler characteristic of each structure concerned stays, with exceptions for a membrane across: that of
// the chain's structure may rise by two, or, on both sides, fall by two; that of others may rise by two, on
// one side. `areas`: sections are measured with it; null: they are not. Returns nothing, and leaves it to
// the caller to restore the mesh, where a cell would not be positive, a surface would not be one disc at
// each vertex concerned, a characteristic would be another one, a contour vertex or subsegment would leave
// its surface, or the chain would not lie on it. Complexity: O(cells at the membrane).
std::optional<RelabelledNeighborhood> relabel_membrane_neighborhood(EditContext& edit,
                                                                    const ContourOwners& owners,
                                                                    const MembraneRelabelling& relabelling,
                                                                    SectionAreas* areas);

}  // namespace anatomesh
