// DICOM objects made from contours and models: RT Structure Set, Segmentation, Encapsulated STL and OBJ.
//
// All are bytes of whole files, the same for the same input: UIDs are made from the content, dates and times
// come from the source or are left empty (where the standard wants one: 1 January 1970, midnight).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/image/image.h"
#include "anatomesh_io/dicom/dicom_source.h"

namespace anatomesh {

// Contours as CLOSED_PLANAR, holes as contours within contours, each with the image of its plane when the
// source has one within 0.01 mm. Implicit VR little endian, in which a list of points may be longer than 64
// KiB. Coordinates lose what 16 characters cannot hold: below 1e-9 mm for coordinates below 10 m. Requires: a
// set in LPS.
std::string format_rtstruct(const ContourSet& set, const DicomSource& source);

// A binary segmentation, one segment a structure. Structures may overlap: the voxels of structure s are those
// whose region's members hold s. Empty frames are left out.
struct VoxelModel {
    ImageGeometry geometry;
    std::vector<std::uint16_t> regions;  // per voxel; 0 is outside
    std::vector<Structure> structures;
    std::vector<std::vector<std::uint32_t>> members;  // of region r: members[r], indices into structures
};
// Requires: 1 to 65535 structures; orthogonal axes (a segmentation cannot be sheared). Error: that of
// check_value_length, for the pixels.
Result<std::string> format_segmentation(const VoxelModel& model, const DicomSource& source);

// A surface file as a DICOM object, with references to what it is derived from. Error: that of
// check_value_length, for the surface.
enum class SurfaceObject : std::uint8_t { stl, obj };
Result<std::string> format_encapsulated(SurfaceObject kind, std::string_view surface,
                                        const std::string& title, const DicomSource& source);

// Error (limit): E-DCM-045 an element of an object would have more bytes than its length of 32 bits can say.
Status check_value_length(const char* what, std::uint64_t bytes);

}  // namespace anatomesh
