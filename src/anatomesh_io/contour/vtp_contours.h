// Contours as VTK XML polydata (.vtp).
//
// Read: every polyline is a contour, closed when it ends where it begins and open otherwise; every polygon is
// a closed contour. Cell arrays, when there: `structure` or `label` (the structure's number), `slice` (index
// of a plane). Field arrays, when there: SPACE (LPS or RAS), unit (mm), pixel_mm,
// slice_thickness_mm; coverage (complete: a plane without a structure says that it is not there); exclusive (yes: structures take no place
// of each other); structure_number,
// structure_name, structure_color, in step; slice_origin, slice_normal, slice_name, in step; Segment_Name and
// Segment_DefaultColor, as 3D Slicer writes them for a file that is one structure.
// A file without structure numbers is one structure, named by Segment_Name or after the file.
// Written: all of that but the last two, with closed polylines.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh_io/contour/raw_builder.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

// Adds the contours of one file. `number` is that of its structure when the file gives none. `path` names the
// file in messages, `prefix` is put before the names of its contours.
// Errors: E-VTP-001 another unit than mm             E-VTP-004 a structure that two files of a folder hold
//         E-VTP-002 a surface, not contours          E-VTP-005 files of a folder in different frames
//         E-VTP-003 single segments, not polylines   E-VTP-006 arrays of structures or planes that do not fit
// and those of vtk_xml.h. Warning: W-VTP-001 cells of single points are left out.
Status read_vtp_contours(std::span<const std::byte> content, const std::string& path,
                         const std::string& prefix, std::int32_t number, const InputLimits& file_limits,
                         RawBuilder& builder);

// Adds the contours of all .vtp files of a folder, in natural order of their names ("a_2" before "a_10"),
// with numbers from 1. Error: E-VTP-007 no such file in it, or it cannot be listed.
Status read_vtp_folder(const std::string& folder, const InputLimits& file_limits, RawBuilder& builder);

// Requires and guarantees: those of format_contours (write_contours.h).
std::string format_vtp_contours(const ContourSet& set, int threads);

}  // namespace anatomesh
