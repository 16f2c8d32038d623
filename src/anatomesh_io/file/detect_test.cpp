#include "anatomesh_io/file/detect.h"

#include <gtest/gtest.h>

#include <string>

#include "anatomesh_io/file/input_file.h"

namespace anatomesh::detect_test {
namespace {

FileKind kind_of(const std::string& text) {
    return detect_bytes(std::as_bytes(std::span(text)));
}

TEST(Detect, text_formats) {
    EXPECT_EQ(kind_of("NRRD0005\n"), FileKind::nrrd);
    EXPECT_EQ(kind_of("ObjectType = Image\nNDims = 3\n"), FileKind::metaimage);
    EXPECT_EQ(kind_of("NDims=3\nDimSize = 1 1 1\n"), FileKind::metaimage);
    EXPECT_EQ(kind_of("CSLC\n10 2\n"), FileKind::csl);
    EXPECT_EQ(kind_of("{\"format\": \"contours\"}"), FileKind::contour_json);
    EXPECT_EQ(kind_of("\xef\xbb\xbf\n {}"), FileKind::contour_json);
    EXPECT_EQ(kind_of("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">"), FileKind::vtk_polydata);
    EXPECT_EQ(kind_of("<VTKFile type=\"UnstructuredGrid\" version=\"1.0\">"),
              FileKind::vtk_unstructured_grid);
    EXPECT_EQ(kind_of("<VTKFile type=\"ImageData\">"), FileKind::unknown);
    EXPECT_EQ(kind_of("<html>"), FileKind::unknown);
    EXPECT_EQ(kind_of("$MeshFormat\n4.1 0 8\n"), FileKind::gmsh);
    EXPECT_EQ(kind_of("MeshVersionFormatted 2\nDimension 3\n"), FileKind::medit);
    EXPECT_EQ(kind_of("*HEADING\nmodel\n*NODE\n"), FileKind::abaqus);
    EXPECT_EQ(kind_of("** a comment\n** another\n*Node\n"), FileKind::abaqus);
    EXPECT_EQ(kind_of("*something else\n"), FileKind::unknown);
    EXPECT_EQ(kind_of("ply\nformat ascii 1.0\n"), FileKind::ply);
    EXPECT_EQ(kind_of("solid x\n facet normal 0 0 1\n"), FileKind::stl);
    EXPECT_EQ(kind_of("# a comment\no thing\nv 0 0 0\n"), FileKind::obj);
    EXPECT_EQ(kind_of("very plain text\n"), FileKind::unknown);
    EXPECT_EQ(kind_of(""), FileKind::unknown);
}

TEST(Detect, binary_formats) {
    std::string nifti(352, '\0');
    nifti.replace(344, 3, "n+1");
    EXPECT_EQ(kind_of(nifti), FileKind::nifti);
    EXPECT_EQ(kind_of(std::string("\x1c\2\0\0n+2\0\r\n\032\n", 12)), FileKind::nifti);
    std::string tar(1024, '\0');
    tar.replace(257, 5, "ustar");
    EXPECT_EQ(kind_of(tar), FileKind::invesalius);
    std::string stl(84 + 50, '\0');
    stl[80] = 1;
    EXPECT_EQ(kind_of(stl), FileKind::stl);
    // A binary STL whose 80 bytes begin with the word of the text form.
    stl.replace(0, 5, "solid");
    EXPECT_EQ(kind_of(stl), FileKind::stl);
}

std::string dicom(const std::string& uid, bool preamble) {
    const std::string start = preamble ? std::string(128, '\0') + "DICM" : "";
    const std::string element = preamble ? std::string("\2\0\2\0UI", 6) : std::string("\10\0\26\0UI", 6);
    return start + element + static_cast<char>(uid.size()) + '\0' + uid;
}

TEST(Detect, dicom_by_its_class) {
    for (const bool preamble : {true, false}) {
        EXPECT_EQ(kind_of(dicom(std::string("1.2.840.10008.5.1.4.1.1.481.3\0", 30), preamble)),
                  FileKind::dicom_rtstruct);
        EXPECT_EQ(kind_of(dicom("1.2.840.10008.5.1.4.1.1.66.4", preamble)), FileKind::dicom_segmentation);
        EXPECT_EQ(kind_of(dicom("1.2.840.10008.5.1.4.1.1.66.7", preamble)), FileKind::dicom_segmentation);
        EXPECT_EQ(kind_of(dicom("1.2.840.10008.5.1.4.1.1.2", preamble)), FileKind::dicom);
    }
    // Elements that pass the end say nothing.
    EXPECT_EQ(kind_of(dicom("1.2.840.10008.5.1.4.1.1.66.4", true).substr(0, 150)), FileKind::dicom);
    EXPECT_EQ(kind_of(std::string(128, '\0') + "DICM"), FileKind::dicom);
}

TEST(Detect, every_kind_has_a_name) {
    for (int kind = 0; kind <= static_cast<int>(FileKind::obj); ++kind)
        EXPECT_GT(std::string(name_of(static_cast<FileKind>(kind))).size(), 2U);
}

TEST(Detect, D24_a_folder_is_an_error) {
    const auto result = detect("/");
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, "E-INP-003");
}

}  // namespace
}  // namespace anatomesh::detect_test
