// PathLink: a slice, or a part of one, as a link of a chain of slices along a path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/arrangement/slice_path.h"

namespace anatomesh {

// Slices of a branch and its parent that cross lean by 10 degrees at least: slices of a probe that cross lean less.
// [1, cosine; 0 to 1; C Sweep]
inline constexpr double cos_of_branch = 0.985;
// Slices that lean by 25 degrees at least, of which this is the cosine, are led by no hand, so that they may agree where
// they cross: the two legs of a Y do, where they are alike. [1, cosine; 0 to 1; C]
inline constexpr double cos_of_legs = 0.906;

// What is drawn on a slice, or a part of it.
struct DrawnPatch : PlanePatch {
    std::vector<Vec3> points;

    Vec3 middle() const { return plane.to_space(0.5 * (box.low + box.high)); }
};

struct PathLink {
    PathSlice part;
    DrawnPatch patch;
    std::vector<std::uint32_t> structures;  // rising
    std::vector<DrawnPatch> alone;          // of each contour where there are several
};

// O(points).
PathLink link_of(const ContourSet& set, PathSlice part);

// One of each slice with contours, in the order of the set. O(points).
std::vector<PathLink> links_of(const ContourSet& set);

// Whether two links draw one structure.
bool share(const PathLink& a, const PathLink& b);

// On which side of a slice what another one draws lies: 1 before it, -1 behind it, 0 on both. O(points).
int side_of(const PlanePatch& of, const DrawnPatch& other);

// How one slice sees another one.
struct Sight {
    bool side, its_side;  // on which each lies of the other: true before it
    double way;           // mm, along the path between them
};

// Nothing where they lie across each other, are turned by more than 110 degrees, or the boxes of their contours do not
// lie before each other. O(points).
std::optional<Sight> sight(const DrawnPatch& a, const DrawnPatch& b);

// Whether two slices that draw one structure lie before each other, lean by less than the angle of this cosine, and
// reach through each other. O(points).
bool reach_through(const PathLink& one, const PathLink& other, double least_cosine);

// Two links that draw one place, and how much of what they draw of their structures on their common line both draw.
struct DrawnTwice {
    std::uint32_t one, other;
    double agreement;  // above 0, to 1
};

// In rising order. Complexity: O(links log links + points of links that cross).
std::vector<DrawnTwice> drawn_twice(const ContourSet& set, const std::vector<PathLink>& links);

// Whether so many links draw places that others draw too that they are no paths with branches.
bool cross_everywhere(const std::vector<PathLink>& links, const std::vector<DrawnTwice>& twice);

// The same of so many of all.
bool are_too_many_crossing(std::size_t crossing, std::size_t all);

}  // namespace anatomesh
