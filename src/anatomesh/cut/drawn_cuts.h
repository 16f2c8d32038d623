// DrawnCuts: how far the cut of a mesh by the slices' planes is from what is drawn, cell by cell.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/cut/star.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

// The slices as relabel() wants them.
struct SlicePlanes {
    std::span<const std::uint32_t> slice_of;  // for every point of the mesh the slice in whose plane it lies
                                              // as a part of a contour, or no_slice; empty: no slices
    std::span<const Plane> planes;            // by slice
    const StructureField* field = nullptr;    // on a slice's plane it is what is drawn there
    std::uint32_t structures = 0;

    static constexpr std::uint32_t no_slice = no_cell;
};

// Looks at cells with a vertex on a slice's contours: at their facets in its plane, which belong to the
// structures on both sides (slice_cuts.h), and at their sections where they pass through it. Keeps scratch
// space: one per thread.
class DrawnCuts {
  public:
    DrawnCuts(const std::vector<Vec3>& points, const std::vector<Cell>& cells,
              const std::vector<CellNeighbors>& neighbors, const std::vector<Region>& regions,
              const RegionTable& table, const SlicePlanes& slices);

    // By how much the area that is wrong, summed over structures, grows if the cells go to a region; mm^2.
    double change(std::span<const std::uint32_t> moved, Region to);

    // The structures drawn where the cell passes through a plane, or has a facet in it of which neither side
    // is what is drawn, if those of the cell are wrong there; else nothing. Of several the largest; valid
    // until the next call.
    const std::vector<std::uint32_t>* wanted(std::uint32_t cell);

    bool in_slice(std::uint32_t vertex) const { return slice_of(vertex) != SlicePlanes::no_slice; }

    // Whether the cell, at a vertex of a slice, has all others above its plane, or below it, or in it without
    // a facet there; any cell where the vertex is of no slice.
    bool lies_beside(std::uint32_t cell, std::uint32_t vertex, bool above) const;

    // Whether a plane cuts one of the cells, or a facet of it lies in a plane, where not all of its
    // structures are drawn.
    bool protrudes(std::span<const std::uint32_t> cells);

  private:
    // A triangle of a plane that belongs to a cell, or a facet's to it and the one beyond.
    struct Part {
        double area;
        Vec3 middle;
        std::uint32_t beyond;  // or no_cell
    };

    void find_parts(std::uint32_t cell);
    void add_section(const Cell& cell, std::uint32_t slice);
    std::uint32_t slice_of(std::uint32_t v) const {
        return v < slices_.slice_of.size() ? slices_.slice_of[v] : SlicePlanes::no_slice;
    }
    double wrong_share(Region one, Region other, const std::vector<std::uint32_t>& drawn);

    const std::vector<Vec3>& points_;
    const std::vector<Cell>& cells_;
    const std::vector<CellNeighbors>& neighbors_;
    const std::vector<Region>& regions_;
    const RegionTable& table_;
    SlicePlanes slices_;
    InterfaceProbe probe_;
    std::vector<Part> parts_;
    std::vector<std::uint32_t> both_, drawn_;
};

}  // namespace anatomesh
