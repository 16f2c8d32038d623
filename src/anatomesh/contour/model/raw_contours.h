// RawContours: contours as a file gave them, before anything was checked, repaired or grouped into slices.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/structure.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

enum class ContourKind : std::uint8_t {
    closed_planar,      // combined with others of its slice by even-odd nesting
    closed_planar_xor,  // DICOM CLOSEDPLANAR_XOR: combined by exclusive or
    open,               // an open polyline
    open_at_valve,      // a heart's chamber on a long axis: what is drawn ends at the valve
    point               // one marker, or unconnected markers
};

// The vertices are points[first_point, first_point + point_count).
struct RawContour {
    std::uint32_t structure = 0;  // index into structures
    ContourKind kind = ContourKind::closed_planar;
    std::uint32_t first_point = 0, point_count = 0;
    std::int32_t plane = -1;  // index into planes when the file gives planes; -1: to be fitted
    std::string name;         // where in the file: "ROI 3, contour 17", "planes[2].polygons[0]"; for messages
    // A number for each frame of reference that the file names; 0 where it names none. Contours of different
    // spaces cannot be put together without a registration.
    std::uint32_t space = 0;
    std::string slice = {};  // what the file calls its slice where it gives no plane; may be empty
    bool is_hole = false;  // the file itself calls it one; which contours are holes follows from how they lie
};

struct RawContours {
    std::vector<Structure> structures;
    std::vector<RawContour> contours;
    std::vector<Vec3> points;
    std::vector<Plane> planes;             // as the file gives them; may be empty
    std::vector<std::string> plane_names;  // parallel to planes
    Frame frame = Frame::lps;
    double pixel_mm = 0;            // in-plane pixel size, 0 when unknown
    double slice_thickness_mm = 0;  // as in ContourSet, and so is the next
    bool complete = false;
    bool exclusive = false;      // the file says that structures take no place of each other; it may be wrong
    bool unit_is_given = false;  // by the user: small numbers are no news then
    std::string source;          // the file, as the user named it
};

}  // namespace anatomesh
