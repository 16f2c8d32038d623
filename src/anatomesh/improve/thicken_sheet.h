// thicken_sheet: gives the cells at a sheet to the other side of its structure, so that its chain comes to
// lie on the surface.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/improve/section_areas.h"
#include "anatomesh/improve/surface_sheets.h"
#include "anatomesh/improve/workbench.h"

namespace anatomesh {

struct ThickenedSheet {
    std::vector<std::uint32_t> changed;  // cells that were made or changed their region; rising
    double wrong_of_cuts = 0;            // that came of it, a share of what is drawn
    bool parts_cells = false;            // of the chain's region, at a vertex of the sheet
};

// The edges that lead off the sheet are cut, at `thickness` of their length from it, and what lies between
// the cuts goes to the other side: a regular neighbourhood of the sheet (Rourke and Sanderson, Introduction
// to Piecewise-Linear Topology, 1972, chapter 3) but for cells that have nothing of it but pieces on its rim.
// `own`: the region in which the chain lies; cells of others stay. `wide`: as far as to all vertices of the
// surface beside the sheet; else to those alone that edges of the surface join to all that a cell has of the
// sheet. `areas`: those of a stack, or null.
// Returns nothing where a cell would not be positive, a surface not one disc at each vertex concerned, that
// of a structure of another Euler characteristic, a contour vertex or piece off its surface, or the chain not
// on it. What was done to the mesh then is the caller's to take back. Complexity: O(cells at the sheet).
std::optional<ThickenedSheet> thicken_sheet(Workbench& bench, const ContourOwners& owners, const Chain& chain,
                                            const Sheet& sheet, Region own, bool wide, double thickness,
                                            SectionAreas* areas);

}  // namespace anatomesh
