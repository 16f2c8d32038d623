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
    // Numbers of structures whose outlines here nobody drew: slices beside it tell them (outlines_between.h).
    std::vector<std::int32_t> interpolated = {};
};

// The vertices of a contour are points[first_point, first_point + point_count), without repeating the first.
struct Contour {
    std::uint32_t structure = 0;  // index into structures
    std::uint32_t slice = 0;      // index into slices
    std::uint32_t first_point = 0, point_count = 0;
};

struct OverlappingContours;

// In what axes the coordinates are. Millimetres in every case.
enum class Frame : std::uint8_t { lps, unknown };

// A slice that drew a structure and is not one of the set any more: left out by its name, or to see what it
// tells. That it is not there says nothing about the structure.
struct LeftOutSlice {
    std::int32_t structure = 0;  // number
    Plane plane;
};

// Invariants once clean_contours() has run (a *kept* contour set; see contour/clean/clean.h): every contour has at
// least three points and is simple; contours of one structure in one slice do not cross or overlap along an
// edge (they may share a vertex only where the source's did not allow otherwise); outer contours run counter-
// clockwise seen along -normal, holes clockwise; slices with equal plane are one slice; slices are in a fixed
// order (parallel ones by position along the common normal), the contours of a slice by structure, then by
// the lexicographically smallest vertex, which is also their first point.
struct ContourSet {
    std::vector<Structure> structures;
    std::vector<Slice> slices;
    std::vector<Contour> contours;
    std::vector<Vec3> points;

    Frame frame = Frame::lps;
    bool exclusive = false;  // true: regions of different structures never overlap (traced from a label map)
    bool drawn = true;       // true: somebody drew them (keep every vertex); false: traced from voxels
    double pixel_mm = 0;     // in-plane pixel size of the source image; 0 when unknown
    std::string source;      // the file, as the user named it
    std::vector<LeftOutSlice> left_out = {};  // of each structure that they drew
    // Where structures lie in others and overlaps were given to the first (overlaps/priority.h): what was
    // drawn, which tells what lies between the slices. Else null.
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

// Structures that overlap, of which the first keeps what it has in common with others: those that lie in
// none, those that lie in these, and so on.
struct OverlappingContours {
    std::vector<ContourSet> levels;                  // each of structures that exclude each other
    std::vector<std::vector<std::uint32_t>> slices;  // by level: which of the whole's its own are; rising
    std::vector<std::int32_t> order;                 // the numbers of all structures, the first first
};

// Whether the structure's outlines on the slice were not drawn.
bool is_interpolated(const ContourSet& set, std::uint32_t slice, std::uint32_t structure);
bool has_interpolated(const ContourSet& set);

// Neighbours of a point along its contour.
inline std::uint32_t point_after(const Contour& contour, std::uint32_t point) {
    return point + 1 == contour.first_point + contour.point_count ? contour.first_point : point + 1;
}
inline std::uint32_t point_before(const Contour& contour, std::uint32_t point) {
    return point == contour.first_point ? contour.first_point + contour.point_count - 1 : point - 1;
}

// Whether all planes have the same normal up to sign, within the angle that moves the outermost point of the
// set by less than `tolerance_mm` (and 0.57 degrees: a small set is moved by less).
bool all_parallel(const ContourSet& set, double tolerance_mm);
// The tolerance by which planes count as parallel wherever nothing finer is asked: what files round away, mm.
inline constexpr double parallel_tolerance_mm = 0.01;

// Distance between neighbouring slices of a parallel set: the median of the gaps; 0 with fewer than two slices.
double median_spacing(const ContourSet& set);

}  // namespace anatomesh
