// ContourSet: the contours of one or many structures on planes anywhere in space, as flat arrays.
//
// Terms. A *contour* is a closed planar polygon. A *slice* is a plane with the contours drawn in it. A
// *structure* is what a set of contours bounds (an organ, a bone). The drawn region of a structure in a slice
// is the even-odd interior of its contours there (holes by nesting).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/base/structure.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

// The contours of a slice are contours[first_contour, first_contour + contour_count).
struct Slice {
    Plane plane;
    std::uint32_t first_contour = 0, contour_count = 0;
    std::string name;  // how the source calls it: "k = 12", "z = 36.0", an id; for messages
    // Numbers of structures whose outlines here nobody drew; they are interpolated (outlines_between.h).
    std::vector<std::int32_t> interpolated = {};
};

// The vertices of a contour are points[first_point, first_point + point_count); the first is not repeated.
struct Contour {
    std::uint32_t structure = 0;  // index into structures
    std::uint32_t slice = 0;      // index into slices
    std::uint32_t first_point = 0, point_count = 0;
};

struct OverlappingContours;

// The axes of the coordinates, which are in millimetres in every case.
enum class Frame : std::uint8_t { lps, unknown };

// A slice that drew a structure and does not belong to the set any more: the user named it, or it is left out to
// see what it says. Its absence says nothing about the structure.
struct LeftOutSlice {
    std::int32_t structure = 0;  // number
    Plane plane;
};

// A set is *kept* once clean_contours() has run (contour/clean/clean.h). These are the invariants of a kept set:
// - Every contour has three points or more and is simple.
// - Contours of one structure on one slice do not cross and share no edge. They share a vertex only where the
//   source did not allow otherwise.
// - Outer contours run counter-clockwise seen along -normal, holes clockwise.
// - Slices with equal planes are one slice. Slices have a fixed order; parallel ones are ordered by position along
//   the common normal.
// - The contours of a slice are ordered by structure, then by their lexicographically smallest vertex, which is
//   also their first point.
struct ContourSet {
    std::vector<Structure> structures;
    std::vector<Slice> slices;
    std::vector<Contour> contours;
    std::vector<Vec3> points;

    Frame frame = Frame::lps;
    // true: regions of different structures never overlap (traced from a label map, or read from a file that says
    // so, where find_overlap() finds none)
    bool exclusive = false;
    bool drawn = true;  // true: somebody drew them (keep every vertex); false: traced from voxels
    // true: every slice says all of every structure, so that one without a structure says that it is not there
    // (a label map). false: the structure may not have been drawn there (SliceCoverage).
    bool complete = false;
    double pixel_mm = 0;                      // in-plane pixel size of the source image; 0 when unknown
    double slice_thickness_mm = 0;            // of a slice, as the source states it; 0 when unknown
    std::string source;                       // the file, as the user named it
    std::vector<LeftOutSlice> left_out = {};  // of each structure that they drew
    // What was drawn, where structures lie in others and overlaps were given to the first of them
    // (overlaps/priority.h); it decides what lies between the slices. Else null.
    std::shared_ptr<const OverlappingContours> overlapping = nullptr;

    std::span<const Vec3> points_of(const Contour& contour) const {
        return {points.data() + contour.first_point, contour.point_count};
    }
    std::span<const Contour> contours_of(const Slice& slice) const {
        return {contours.data() + slice.first_contour, slice.contour_count};
    }
    Box3 box() const {
        Box3 all;
        for (const Vec3& point : points) all.extend(point);
        return all;
    }
};

// Structures that overlap; the first keeps what it has in common with others. Level 0 has the structures that lie
// in no other, level 1 those that lie in these, and so on.
struct OverlappingContours {
    std::vector<ContourSet> levels;                  // each has structures that exclude each other
    std::vector<std::vector<std::uint32_t>> slices;  // by level: the slices of the whole that it has, rising
    std::vector<std::int32_t> order;                 // the numbers of all structures, the first first
};

// Whether a slice without a structure says that the structure is not there. Structures that exclude each other
// leave no place unsaid on a slice.
inline bool says_all(const ContourSet& set) {
    return set.complete || set.exclusive;
}

// Whether nobody drew the structure's outlines on the slice.
bool is_interpolated(const ContourSet& set, std::uint32_t slice, std::uint32_t structure);
bool has_interpolated(const ContourSet& set);

// The neighbours of a point along its contour.
inline std::uint32_t point_after(const Contour& contour, std::uint32_t point) {
    return point + 1 == contour.first_point + contour.point_count ? contour.first_point : point + 1;
}
inline std::uint32_t point_before(const Contour& contour, std::uint32_t point) {
    return point == contour.first_point ? contour.first_point + contour.point_count - 1 : point - 1;
}

// Whether all planes have the same normal up to sign. Their angle may move the outermost point of the set by
// less than `tolerance_mm`, and is at most 0.57 degrees, because a small set is moved by less. O(points + slices).
bool all_parallel(const ContourSet& set, double tolerance_mm);
// Files round normals; planes that move no point by more than this are parallel. [mm; > 0; D digits of files]
inline constexpr double parallel_tolerance_mm = 0.01;

// Returns the distance between neighbouring slices of a parallel set, which is the median of the gaps, in mm; 0 for
// fewer than two slices. O(slices log slices).
double median_spacing(const ContourSet& set);

}  // namespace anatomesh
