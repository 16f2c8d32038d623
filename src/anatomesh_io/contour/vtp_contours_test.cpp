#include "anatomesh_io/contour/vtp_contours.h"

#include <gtest/gtest.h>

#include <fstream>

#include "anatomesh_io/contour/contour_test_support.h"
#include "anatomesh_io/contour/read_contours.h"

namespace anatomesh::vtp_contours_test {
namespace {

using namespace contour_test;

std::string array(const std::string& type, const std::string& name, int components,
                  const std::string& values) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
           std::to_string(components) + "\" format=\"ascii\">" + values + "</DataArray>";
}

std::string text_array(const std::string& name, const std::string& text) {
    std::string codes_of_text;
    for (const char c : text) codes_of_text += std::to_string(static_cast<unsigned char>(c)) + " ";
    return "<Array type=\"String\" Name=\"" + name + "\" NumberOfTuples=\"1\" format=\"ascii\">" +
           codes_of_text + "0</Array>";
}

// Six points; a closed line of three, an open line of two, a polygon of three.
struct TestVtp {
    std::string fields = {}, cell_data = {};
    std::string line_points = "0 1 2 0 3 4", line_offsets = "4 6";
    std::string polygon_points = "3 4 5", polygon_offsets = "3";
    std::string points = "0 0 1  9 0 1  0 9.5 1  1 1 1  5 1 1  1 5 1";

    std::string text() const {
        const auto count = [](const std::string& offsets) {
            return std::to_string(std::count(offsets.begin(), offsets.end(), ' ') +
                                  (offsets.empty() ? 0 : 1));
        };
        return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" "
               "byte_order=\"LittleEndian\">"
               "<PolyData><FieldData>" +
               fields +
               "</FieldData><Piece NumberOfPoints=\"6\" NumberOfVerts=\"0\" "
               "NumberOfLines=\"" +
               count(line_offsets) + "\" NumberOfStrips=\"0\" NumberOfPolys=\"" + count(polygon_offsets) +
               "\"><CellData>" + cell_data + "</CellData><Points>" + array("Float64", "Points", 3, points) +
               "</Points><Lines>" + array("Int64", "connectivity", 1, line_points) +
               array("Int64", "offsets", 1, line_offsets) + "</Lines><Polys>" +
               array("Int64", "connectivity", 1, polygon_points) +
               array("Int64", "offsets", 1, polygon_offsets) + "</Polys></Piece></PolyData></VTKFile>";
    }
};

Result<RawContours> read(const TestVtp& vtp, RunContext& context, const ContourLimits& limits = {}) {
    const std::string text = vtp.text();
    RawBuilder builder("input", limits, context);
    ANATOMESH_CHECK_STATUS(
        read_vtp_contours(std::as_bytes(std::span(text)), "some/liver.vtp", "", 1, {}, builder));
    return builder.finish(FileFrame::lps);
}

TEST(VtpContours, lines_and_polygons_of_one_structure) {
    RunContext context;
    const auto result = read({}, context);
    ASSERT_TRUE(result.ok()) << to_line(result.error());
    EXPECT_TRUE(context.warnings.empty());
    const RawContours& raw = result.value();
    ASSERT_EQ(raw.structures.size(), 1u);
    EXPECT_EQ(raw.structures[0].number, 1);
    EXPECT_EQ(raw.structures[0].name, "liver");
    ASSERT_EQ(raw.contours.size(), 3u);
    EXPECT_EQ(raw.contours[0].kind, ContourKind::closed_planar);
    EXPECT_EQ(raw.contours[0].point_count, 3u);
    EXPECT_EQ(raw.contours[1].kind, ContourKind::open);
    EXPECT_EQ(raw.contours[1].name, "line 1");
    EXPECT_EQ(raw.contours[2].kind, ContourKind::closed_planar);
    EXPECT_EQ(raw.contours[2].name, "polygon 0");
    EXPECT_EQ(raw.points[2], (Vec3{0, 9.5, 1}));
}

TEST(VtpContours, structures_by_a_cell_array) {
    for (const char* name : {"structure", "label", "labels"}) {
        RunContext context;
        const auto result = read({.cell_data = array("Float32", name, 1, "7 -2 7")}, context);
        ASSERT_TRUE(result.ok()) << to_line(result.error());
        ASSERT_EQ(result.value().structures.size(), 2u);
        EXPECT_EQ(result.value().structures[0].number, -2);
        EXPECT_EQ(result.value().contours[1].structure, 0u);
        EXPECT_EQ(result.value().contours[2].structure, 1u);
    }
}

TEST(VtpContours, name_and_colour_of_a_segment) {
    RunContext context;
    const auto result = read({.fields = text_array("Segment_Name", "BODY") +
                                        array("Float64", "Segment_DefaultColor", 3, "0.5 1 7")},
                             context);
    ASSERT_TRUE(result.ok()) << to_line(result.error());
    EXPECT_EQ(result.value().structures[0].name, "BODY");
    EXPECT_EQ(result.value().structures[0].color, (std::array<std::uint8_t, 3>{128, 255, 255}));
}

TEST(VtpContours, space_turns) {
    RunContext context;
    const auto result = read({.fields = text_array("SPACE", "RAS")}, context);
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(result.value().points[2], (Vec3{0, -9.5, 1}));
    EXPECT_EQ(codes(context), std::vector<std::string>{"W-CIO-002"});  // LPS was asked for
}

TEST(VtpContours, what_is_wrong_is_named) {
    RunContext context;
    EXPECT_TRUE(fails(read({.fields = text_array("unit", "m")}, context), "E-VTP-001", "some/liver.vtp"));
    EXPECT_TRUE(fails(read({.line_points = "",
                            .line_offsets = "",
                            .polygon_points = "0 1 2 1 2 3 2 3 4 3 4 5",
                            .polygon_offsets = "3 6 9 12"},
                           context),
                      "E-VTP-002"));
    EXPECT_TRUE(fails(read({.line_points = "0 1 1 2 2 0",
                            .line_offsets = "2 4 6",
                            .polygon_points = "",
                            .polygon_offsets = ""},
                           context),
                      "E-VTP-003", "3 lines"));
    EXPECT_TRUE(
        fails(read({.cell_data = array("Float32", "structure", 1, "7 1.5 7")}, context), "E-VTP-006", "1.5"));
    EXPECT_TRUE(
        fails(read({.cell_data = array("Float32", "structure", 1, "7 nan 7")}, context), "E-VTP-006"));
    const std::string twice = array("Int32", "structure_number", 1, "7 7"),
                      cells = array("Int32", "structure", 1, "7 7 7");
    EXPECT_TRUE(fails(read({.fields = twice, .cell_data = cells}, context), "E-VTP-004", "7"));
    const std::string colors =
        array("Int32", "structure_number", 1, "7") + array("UInt8", "structure_color", 3, "1 2 3 4 5 6");
    EXPECT_TRUE(
        fails(read({.fields = colors, .cell_data = cells}, context), "E-VTP-006", "have different lengths"));
    const std::string planes =
        array("Float64", "slice_origin", 3, "0 0 1") + array("Float64", "slice_normal", 3, "0 0 1");
    EXPECT_TRUE(fails(read({.fields = planes}, context), "E-VTP-006", "have different lengths"));
    EXPECT_TRUE(fails(read({.fields = planes, .cell_data = array("Int32", "slice", 1, "0 1 0")}, context),
                      "E-VTP-006"));
    EXPECT_TRUE(read({.fields = planes, .cell_data = array("Int32", "slice", 1, "0 0 0")}, context).ok());
    EXPECT_TRUE(fails(read({.points = "0 0 1  9 0 1  0 nan 1  1 1 1  5 1 1  1 5 1"}, context), "E-CIO-005",
                      "line 0, point 2"));
    EXPECT_TRUE(fails(read({.line_points = "0 1 2 0 3 6"}, context), "E-VTK-007"));
}

TEST(VtpContours, limits_hold) {
    RunContext context;
    EXPECT_TRUE(fails(read({}, context, {.contours = 2}), "E-CIO-002"));
    EXPECT_TRUE(fails(read({}, context, {.points_per_contour = 2}), "E-CIO-003"));
    EXPECT_TRUE(fails(read({}, context, {.points = 7}), "E-CIO-004"));
    EXPECT_TRUE(read({}, context, {.contours = 3, .points_per_contour = 3, .points = 8}).ok());
}

class VtpFolder : public testing::Test {
  protected:
    void put(const std::string& name, const TestVtp& vtp) { std::ofstream(folder_.file(name)) << vtp.text(); }
    Result<RawContours> read(const ContourLimits& limits = {}) {
        return read_contours(folder_.file(""), {.limits = limits}, context_);
    }

    Folder folder_;
    RunContext context_;
};

TEST_F(VtpFolder, one_structure_a_file_in_natural_order) {
    for (const char* name : {"s_10.vtp", "s_9.vtp", "s_1.vtp", "notes.txt"}) put(name, {});
    const auto result = read();
    ASSERT_TRUE(result.ok()) << to_line(result.error());
    const RawContours& raw = result.value();
    ASSERT_EQ(raw.structures.size(), 3u);
    EXPECT_EQ(raw.structures[0].name, "s_1");
    EXPECT_EQ(raw.structures[1].name, "s_9");
    EXPECT_EQ(raw.structures[2].name, "s_10");
    EXPECT_EQ(raw.structures[2].number, 3);
    EXPECT_EQ(raw.contours[3].name, "s_9.vtp, line 0");
    EXPECT_EQ(codes(context_), std::vector<std::string>{"W-CIO-001"});
    EXPECT_TRUE(fails(read({.structures = 2}), "E-CIO-001"));
}

TEST_F(VtpFolder, files_that_do_not_go_together) {
    EXPECT_TRUE(fails(read(), "E-VTP-007"));
    put("a.vtp", {.fields = text_array("SPACE", "LPS")});
    put("b.vtp", {});
    EXPECT_TRUE(fails(read(), "E-VTP-005", "b.vtp"));
    put("b.vtp", {.fields = text_array("SPACE", "LPS") + array("Int32", "structure_number", 1, "1"),
                  .cell_data = array("Int32", "structure", 1, "1 1 1")});
    EXPECT_TRUE(fails(read(), "E-VTP-004", "b.vtp"));
}

}  // namespace
}  // namespace anatomesh::vtp_contours_test
