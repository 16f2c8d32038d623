// make_preview: the surface of each structure straight from the field, fast enough to follow a stroke.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

struct PreviewOptions {
    double step_mm = 2;  // of the lattice that the field is asked on. mm, [0.05, 100]
    std::uint64_t max_cells =
        100'000'000;  // of the lattice over the field's box of a structure. cells, [1, 1e9]
};

// A brick of the lattice: brick_cells along each axis, from brick_cells x (i, j, k) on.
using BrickPlace = std::array<std::int32_t, 3>;

// The surface of one structure in one brick.
struct PreviewPatch {
    std::vector<Vec3> points;                             // mm
    std::vector<Vec3> normals;                            // units, outward, one a point
    std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
    std::vector<std::array<std::int32_t, 3>> cells;       // of the lattice that the surface crosses, rising
};

// By structure of the set, then by brick; bricks that the surface does not cross are not there. Patches never change, so
// that surfaces after an edit share what is as it was, and whoever shows them sees by their addresses what is new.
struct PreviewSurface {
    using Patches = std::map<BrickPlace, std::shared_ptr<const PreviewPatch>>;
    std::vector<Patches> structures;
    double step_mm = 0;
};

struct PreviewStats {
    std::uint64_t values = 0;                         // that the field was asked for
    std::uint64_t bricks_made = 0, bricks_taken = 0;  // with a surface
};

// Places whose heights over `plane` lie in [low, high], mm: where a field may differ from an earlier one.
struct ChangedStretch {
    Plane plane;
    double low = 0, high = 0;
};

// The surface by surface nets: a vertex in each cell of the lattice that the surface crosses, in the mean of where it
// crosses the cell's edges, and a quadrilateral around each edge that it crosses. The lattice lies along the axes of space,
// with a node at the origin. The surface is followed from the contours' vertices on from cell to cell, so that the cost is that
// of the surface, not of the volume. `earlier`, where it is given: the surface of a field that differs within `changed`
// alone, of the same structures and step; bricks that do not reach there are taken over. Without it `changed` is not looked at.
// Guarantees: the same bits with an earlier surface and without (of structures that exclude each other, where the step is
// below the field's clamp), wherever the surface hangs together with a contour in the
// bricks that are made anew, and for any number of threads; patches of neighbouring bricks have common points at the same
// coordinates, and each edge of the whole is in an even number of triangles. A part thinner than a step may have holes or be missing:
// it is a preview, and no certificate stands for it. Requires: options within their ranges; the field of `set`.
// Errors: limit E-LIV-201 the lattice would have more cells; cancelled. Complexity: O(cells that the surface crosses) values, and memory of
// the box of what is made anew. Source: surface nets, Gibson, MICCAI 1998, without relaxation.
Result<PreviewSurface> make_preview(const ContourSet& set, const StructureField& field,
                                    const PreviewOptions& options, RunContext& context,
                                    PreviewStats* stats = nullptr, const PreviewSurface* earlier = nullptr,
                                    std::span<const ChangedStretch> changed = {});

}  // namespace anatomesh
