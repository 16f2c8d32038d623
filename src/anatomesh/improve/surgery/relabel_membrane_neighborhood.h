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
inline constexpr std::array membrane_thicknesses{0.5, 0.3, 0.15};
// Share of what is drawn by which cuts may get worse for the sake of a chain or of a handle.
inline constexpr double most_worse_sections = 3e-4;

struct RelabelledNeighborhood {
    std::vector<std::uint32_t> changed;  // cells that were made or changed their region; rising
    double wrong_of_cuts = 0;            // that came of it, a share of what is drawn
    bool parts_cells = false;            // of the chain's region, at a vertex of the membrane
    std::vector<std::uint32_t> parted;  // structures that lose a handle or a tunnel by it, or fall into parts
    bool joins = false;                 // parts of where the cells go, or makes a handle or a tunnel there
};

// On which sides of a membrane cells go: of the two cells at its first facet that of the lower number, or the
// other one, tells which side is the first.
enum class MembraneSides { both, first, second };

// Of a membrane that is no chain's: of a patch in a slice's plane, or one across a hole or a bridge.
struct MembraneAcross {
    MembraneSides sides = MembraneSides::both;
    Vec3 normal;               // of the plane that it lies in, if cells go on both sides
    std::optional<Region> to;  // of the other side of the chain's structure; where the membrane goes
};

// How far what goes reaches along the structure's surface: as far as to all vertices of it beside the
// membrane; to those alone that edges of the surface join to all that a cell has of the membrane; or to where
// edges of the surface are cut too, but those of contours; that, and at vertices also cells of other regions.
enum class MembraneReach { wide, joined, near, others };

// The edges that lead off the membrane are cut, at `thickness` of their length from it, and what lies between
// the cuts goes to the other side: a regular neighbourhood of the membrane (Rourke and Sanderson,
// Introduction to Piecewise-Linear Topology, 1972, chapter 3) but for cells that have nothing of it but
// subsegments on its rim. `own`: the region in which the chain lies; cells of others stay. `areas`: those of
// a stack, or null. `across`: null where the membrane is a chain's. Else, on both sides, cells at subsegments
// on its rim go too, which lie between the membrane and the other side and not beyond the subsegment in the
// plane; on one side all cells do that facets at vertices of the membrane join there, so that what is on the
// membrane's rim stays on the surface. At vertices where what goes meets the other side in no facet, what is
// between them goes, so that all is in one part there; and the characteristic of the chain's structure may
// rise by two, and, on one side, those of others, and on both sides it may fall by two. Returns nothing where
// a cell would not be positive, a surface not one disc at each vertex concerned, that of a structure of
// another Euler characteristic, a contour vertex or subsegment off its surface, or the chain not on it. What
// was done to the mesh then is the caller's to take back. Complexity: O(cells at the membrane).
std::optional<RelabelledNeighborhood> relabel_membrane_neighborhood(
    EditContext& edit, const ContourOwners& owners, const Chain& chain, const Membrane& membrane, Region own,
    MembraneReach reach, double thickness, SectionAreas* areas, const MembraneAcross* across = nullptr);

}  // namespace anatomesh
