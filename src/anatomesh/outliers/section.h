// Section: what a slice of a stack draws of one structure, ready to be compared with the slices beside it.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/slice/scanline.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// A contour in the plane of its slice. Its area is positive round a part and negative round a hole.
struct SectionLoop {
    std::uint32_t contour = 0;  // of the stack
    std::vector<Vec2> points;
    double area = 0;
    Vec2 centre;  // of the area that it encloses
    Box2 box;

    bool is_hole() const { return area < 0; }
};

struct Section {
    std::uint32_t place = 0;  // of the slice in the stack
    double height = 0;        // along the stack, mm
    std::vector<SectionLoop> loops;
    double area = 0;       // of the region, mm2
    double perimeter = 0;  // of all loops, mm
    Box2 box;
};

// Returns the sections of a structure in a stack whose slices have their heights as the z of their points, in the order
// of the stack. Slices that do not draw it, and those whose contours nobody drew, have none. Complexity: O(points).
std::vector<Section> sections_of(const ContourSet& stack, std::uint32_t structure);

// Returns the radius of the circle of an area.
inline double circle_radius(double area) {
    return std::sqrt(std::abs(area) / std::numbers::pi);
}

// Whether a point lies inside a loop. Complexity: O(points).
bool is_inside(const SectionLoop& loop, Vec2 p);
// Whether it lies inside the region of a section (even-odd). Complexity: O(points) of loops whose box holds p.
bool is_inside(const Section& section, Vec2 p);
// Returns the distance of a point from the nearest edge of the section; `most` where that is larger. O(points).
double distance_to(const Section& section, Vec2 p, double most);

// Returns points that stand for the area that a loop encloses: some of its vertices, drawn inwards. May be none of a loop
// that is narrow everywhere. Complexity: O(points).
std::vector<Vec2> samples_of(const SectionLoop& loop);

// Returns the edges of some loops, moved. Complexity: O(points).
void append_edges(const SectionLoop& loop, Vec2 moved_by, std::vector<Edge2>& edges);

}  // namespace anatomesh
