// detect: what kind of file an input is, by its content; its name is not looked at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "anatomesh/base/result.h"

namespace anatomesh {

enum class FileKind : std::uint8_t {
    unknown,
    // images; each of them also gzip-compressed as a whole
    nifti,  // NIfTI-1 or -2, single file or header of a pair
    nrrd,
    metaimage,
    invesalius,  // a tar archive, as InVesalius saves projects
    // DICOM
    dicom,               // any other SOP class
    dicom_rtstruct,      // RT Structure Set Storage
    dicom_segmentation,  // Segmentation, Label Map Segmentation or Surface Segmentation Storage
    // contours
    contour_json,
    csl,
    guide_points,
    vtk_polydata,  // XML, PolyData: polylines or a surface
    // tetrahedral meshes
    vtk_unstructured_grid,  // XML
    gmsh,
    medit,
    abaqus,
    // surfaces
    stl,
    ply,
    obj
};

// "NIfTI image", for messages.
const char* name_of(FileKind kind);

// The kind by the first bytes of a file; `start` need not be more than its first 64 KiB.
FileKind detect_bytes(std::span<const std::byte> start);

// Reads the start of the file. A file that cannot be read is an error (E-INP-001 ... 006), a file of no known
// kind is FileKind::unknown. Never reads more than 64 KiB.
Result<FileKind> detect(const std::string& path);

// The SOP class UID of a DICOM file, with or without preamble and meta header; empty when it is none or does
// not say.
std::string dicom_sop_class(std::span<const std::byte> start);

// "Segmentation Storage" for the classes this product meets, else empty.
const char* dicom_sop_class_name(const std::string& uid);

}  // namespace anatomesh
