// RingOverlay: the rings of a structure with an area drawn over them, split at their crossings, and rings of any
// region that is made of their faces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/contour/model/ring.h"
#include "anatomesh/contour/overlay/arrangement.h"

namespace anatomesh {

// What a face of the overlay lies in.
struct FaceSides {
    bool in_structure = false, in_area = false;  // by the even-odd rule of the rings of each
    std::int32_t innermost = -1;                 // the smallest of the structure's rings around it
};

// A ring of a region. Its owner is the first of the structure's rings of which it has a piece of an edge.
struct RegionRing {
    Ring ring;
    std::int32_t owner = -1;    // index into the structure's rings, or -1: of the area alone
    std::uint32_t place = 0;    // where it begins along the owner's cycle; without an owner its number
    bool is_unchanged = false;  // it is its owner, bit for bit
};

struct Region {
    std::vector<RegionRing> rings;  // by owner and place; those without an owner come last
    double sliver_area_mm2 = 0;  // of rings narrower than sliver_width_mm that only rounding made; left out
};

// One overlay answers for any region. Complexity: that of arrange().
class RingOverlay {
  public:
    // Returns nothing where arrange() does. Requires: closed polygons without an edge of zero length, which may cross
    // themselves and each other; for innermost rings and parents a structure's rings are sound. Both outlive the overlay.
    static std::optional<RingOverlay> make(std::span<const Ring> structure, std::span<const Ring> area,
                                           const Plane& plane);

    const std::vector<FaceSides>& faces() const { return faces_; }

    // Whether the face lies in the even-odd interior of one ring: the structure's come first, then the area's.
    bool is_in(std::uint32_t face, std::uint32_t ring) const;

    // Whether some face lies in the structure and in the area.
    bool overlaps() const;

    // Per ring of the structure: the smallest other one around it, or -1. The structure's rings have an edge each.
    std::vector<std::int32_t> parents() const;

    // How often the area's rings pass a point again that they have passed.
    std::uint32_t crossings_of_area() const;

    // The rings that bound the faces marked, by index into faces(). They are simple; two may touch in points. Vertices
    // are vertices of the rings, bit for bit, or crossings. A ring with an owner runs in its direction and begins at
    // the first of the owner's vertices that it has; others run counter-clockwise around the region.
    Region region(const std::vector<char>& inside) const;

  private:
    // An edge that a ring of the structure runs from place `place` of its cycle on; a < b as vertices.
    struct RunEdge {
        std::uint32_t a = 0, b = 0, ring = 0, place = 0;
        bool forward = true;  // from a to b
    };

    RingOverlay(Arrangement graph, std::span<const Ring> structure, std::span<const Ring> area);
    void read_faces();
    void read_cycles();
    const RunEdge* run_of(std::uint32_t from, std::uint32_t to) const;
    std::int32_t own_vertex(const RunEdge& run, std::uint32_t vertex) const;
    RegionRing ring_of_loop(std::span<const std::uint32_t> loop) const;
    Ring traced(std::span<const std::uint32_t> loop) const;

    Arrangement graph_;
    std::span<const Ring> structure_, area_;
    std::vector<FaceSides> faces_;
    std::vector<RunEdge> runs_;  // ascending by a, b, ring
    // Per ring of the structure and place along its cycle: the ring's own vertex there, or -1.
    std::vector<std::vector<std::int32_t>> own_vertices_;
};

}  // namespace anatomesh
