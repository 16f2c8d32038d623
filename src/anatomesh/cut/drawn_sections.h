// DrawnSections: how far the cross-section of a mesh by the slices' planes is from what is drawn, cell by cell.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "anatomesh/geom/plane.h"
#include "anatomesh/geom/plane_sections.h"
#include "anatomesh/mesh/stars/star.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

// The slices as relabel() wants them.
struct SlicePlanes {
    std::span<const std::uint32_t> slice_of;  // for every point of the mesh the slice in whose plane it lies
                                              // as a part of a contour, or no_slice; empty: no slices
    std::span<const Plane> planes;            // by slice
    const StructureField* field = nullptr;    // on a slice's plane it is what is drawn there
    std::uint32_t structures = 0;
    // In place of slice_of and planes, where planes cross: by slice; and at structure * slices + slice what
    // an area there counts, 0 where the slice does not say where the structure is.
    CrossingPlanes crossing = {};
    std::span<const double> weights = {};

    bool is_stack() const { return !slice_of.empty(); }
    bool cross() const { return !crossing.empty(); }
    bool any() const { return is_stack() || cross(); }

    static constexpr std::uint32_t no_slice = no_cell;
};

// Looks at cells with a vertex on a slice's contours, or, where planes cross, at all: at their facets in its
// plane, which belong to the structures on both sides (slice_sections.h), and at their sections where they pass
// through it. Keeps scratch space, and where planes cross what it found of each cell: one per thread. O(1) a
// cell, where planes cross at the first time O(planes).
class DrawnSections {
  public:
    DrawnSections(const std::vector<Vec3>& points, const std::vector<Cell>& cells,
                  const std::vector<CellNeighbors>& neighbors, const std::vector<Region>& regions,
                  const RegionTable& table, const SlicePlanes& slices);

    // By how much the area that is wrong, summed over structures, grows if the cells go to a region; mm^2,
    // or, where planes cross, as the weights have it.
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
    // A piece of a plane that belongs to a cell, or a facet's to it and the one beyond.
    struct Part {
        double area;
        Vec3 middle;
        std::uint32_t beyond;     // or no_cell
        std::uint32_t slice = 0;  // where planes cross, and the place of what is drawn in known_drawn_
        std::uint32_t first_drawn = 0, drawn_count = 0;
    };
    struct Range {
        std::uint32_t first = 0, count = 0;
    };

    void find_parts(std::uint32_t cell);
    void find_parts_of_stack(std::uint32_t cell);
    // Where planes cross. Cells stay as they are: what is drawn is found once.
    void look_up_parts(std::uint32_t cell);
    std::uint32_t beyond(std::uint32_t cell, const PlaneSection& section) const;
    // Valid until the next call.
    std::span<const std::uint32_t> drawn_at(const Part& part);
    std::uint32_t slice_of(std::uint32_t v) const {
        return v < slices_.slice_of.size() ? slices_.slice_of[v] : SlicePlanes::no_slice;
    }
    double wrong_share(Region one, Region other, std::span<const std::uint32_t> drawn, std::uint32_t slice);
    double weight_of(std::uint32_t structure, std::uint32_t slice) const {
        return slices_.cross() ? slices_.weights[structure * slices_.crossing.planes.size() + slice] : 1;
    }

    const std::vector<Vec3>& points_;
    const std::vector<Cell>& cells_;
    const std::vector<CellNeighbors>& neighbors_;
    const std::vector<Region>& regions_;
    const RegionTable& table_;
    SlicePlanes slices_;
    InterfaceProbe probe_;
    std::vector<Part> parts_;
    std::vector<std::uint32_t> both_, drawn_;
    std::unordered_map<std::uint32_t, Range> known_;  // by cell, of known_parts_
    std::vector<Part> known_parts_;
    std::vector<std::uint32_t> known_drawn_;
};

}  // namespace anatomesh
