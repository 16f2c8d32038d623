#include "anatomesh_io/contour/csl_reader.h"

#include <gtest/gtest.h>

#include "anatomesh_io/contour/contour_test_support.h"

namespace anatomesh::csl_reader_test {
namespace {

using namespace contour_test;

// Two planes: a square with a square hole and a triangle of another label; then a triangle.
const std::string good =
    "CSLC\n2 99\n\n"
    "1 11 3 0 0 1 -5\n\n"
    "0 0 5\n10 0 5\n10 10 5\n0 10 5\n"
    "2 2 5\n2 8 5\n8 8 5\n8 2 5\n"
    "20 0 5\n30 0 5\n20 1.5e1 5\n\n"
    "4 2 0 1 2 3\n4h0 2 4 5 6 7\n3 7 8 9 10\n\n"
    "12 3 1 0 0 2 -16\n0 0 8\n1 0 8\n0 1 8\n3 2 0 1 2\n";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), with);
}

TEST(Csl, reads_planes_components_and_holes) {
    RunContext context;
    const auto read = read_with(read_csl, good, context);
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    const RawContours& raw = read.value();
    ASSERT_EQ(raw.structures.size(), 2u);
    EXPECT_EQ(raw.structures[0].number, 2);
    EXPECT_EQ(raw.structures[1].number, 7);
    ASSERT_EQ(raw.contours.size(), 4u);
    EXPECT_EQ(raw.contours[1].structure, 0u);
    EXPECT_TRUE(raw.contours[1].is_hole);
    EXPECT_FALSE(raw.contours[0].is_hole || raw.contours[2].is_hole);
    EXPECT_EQ(raw.contours[2].structure, 1u);
    EXPECT_EQ(raw.contours[2].point_count, 3u);
    EXPECT_EQ(raw.points[raw.contours[2].first_point + 2], (Vec3{20, 15, 5}));
    ASSERT_EQ(raw.planes.size(), 2u);
    EXPECT_EQ(raw.planes[0].origin, (Vec3{0, 0, 5}));
    EXPECT_EQ(raw.planes[1].origin, (Vec3{0, 0, 8}));
    EXPECT_EQ(raw.planes[1].normal, (Vec3{0, 0, 1}));
    EXPECT_EQ(raw.plane_names[1], "12");
    EXPECT_EQ(raw.contours[3].plane, 1);
    EXPECT_EQ(raw.frame, Frame::unknown);
    EXPECT_EQ(codes(context), std::vector<std::string>{"W-CIO-001"});
}

TEST(Csl, frame_is_turned_from_RAS_and_left_in_LPS) {
    RunContext context;
    const auto ras = read_with(read_csl, good, context, FileFrame::ras);
    const auto lps = read_with(read_csl, good, context, FileFrame::lps);
    ASSERT_TRUE(ras.ok() && lps.ok());
    EXPECT_TRUE(context.warnings.empty());
    EXPECT_EQ(ras.value().frame, Frame::lps);
    EXPECT_EQ(lps.value().frame, Frame::lps);
    for (std::size_t i = 0; i < lps.value().points.size(); ++i) {
        const Vec3 p = lps.value().points[i], q = ras.value().points[i];
        EXPECT_EQ(q, (Vec3{-p.x, -p.y, p.z}));
        EXPECT_FALSE(std::signbit(q.x) && q.x == 0);
    }
    EXPECT_EQ(ras.value().planes[0].origin, (Vec3{0, 0, 5}));
}

TEST(Csl, every_prefix_is_refused_or_lacks_the_last_digit_only) {
    for (std::size_t size = 0; size + 2 < good.size(); ++size) {
        RunContext context;
        const auto read = read_with(read_csl, good.substr(0, size), context);
        ASSERT_FALSE(read.ok()) << size;
    }
}

TEST(Csl, wrong_content_is_named) {
    RunContext context;
    const auto expect = [&](const std::string& what, const std::string& with, const char* code,
                            const char* text) {
        EXPECT_TRUE(fails(read_with(read_csl, replaced(good, what, with), context), code, text)) << with;
    };
    expect("CSLC", "CSLX", "E-CSL-001", "");
    expect("10 0 5\n", "10 nan 5\n", "E-CSL-003", "line 7");
    expect("10 0 5\n", "10 1,5 5\n", "E-CSL-003", "1,5");
    expect("10 0 5\n", "10 1e400 5\n", "E-CSL-003", "1e400");
    expect("10 0 5\n", "10 1e30 5\n", "E-CIO-005", "plane 1, component 0, point 1");
    expect("0 0 1 -5", "0 0 0 -5", "E-CIO-007", "slice 1");
    expect("4 2 0 1 2 3", "4 2 0 1 2 11", "E-CSL-005", "component 0");
    expect("4 2 0 1 2 3", "4 2 0 1 2 -1", "E-CSL-005", "-1");
    expect("4 2 0 1 2 3", "0 2", "E-CSL-004", "");
    expect("4 2 0 1 2 3", "4 2.5 0 1 2 3", "E-CSL-003", "label");
    expect("1 11 3", "1 4000000000 3", "E-CSL-004", "number of vertices");
    expect("1 11 3", "1 11 99999999999999999999", "E-CSL-003", "");
    expect("1 11 3", "1 11 2", "E-CSL-002", "");
    expect("2 99", "1 99", "E-CSL-006", "");
    expect("2 99", "3 99", "E-CSL-002", "");
    expect("4h0 2", "4h 2", "E-CSL-003", "");
    expect("4h0 2", "4h9 2", "E-CSL-007", "9");
}

TEST(Csl, C36_only_holes_and_no_components) {
    RunContext context;
    EXPECT_TRUE(
        fails(read_with(read_csl, replaced(good, "4 2 0 1 2 3", "4h1 2 0 1 2 3"), context), "E-CSL-007"));
    EXPECT_TRUE(
        fails(read_with(read_csl, replaced(good, "4 2 0 1 2 3", "4h0 2 0 1 2 3"), context), "E-CSL-007"));
    EXPECT_TRUE(fails(read_with(read_csl, "CSLC\n0 0\n", context), "E-CIO-006"));
    EXPECT_TRUE(fails(read_with(read_csl, "CSLC\n1 1\n1 0 0 0 0 1 0\n", context), "E-CIO-006"));
}

TEST(Csl, hole_of_another_label_goes_to_its_parent) {
    RunContext context;
    const auto read = read_with(read_csl, replaced(good, "4h0 2", "4h0 7"), context, FileFrame::lps);
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(codes(context), std::vector<std::string>{"W-CSL-002"});
    EXPECT_EQ(read.value().contours[1].structure, 0u);
}

TEST(Csl, unused_vertices_are_said) {
    RunContext context;
    ASSERT_TRUE(read_with(read_csl, replaced(good, "3 7 8 9 10", "3 7 8 9 9"), context, FileFrame::lps).ok());
    EXPECT_EQ(codes(context), std::vector<std::string>{"W-CSL-001"});
}

TEST(Csl, limits_hold) {
    RunContext context;
    EXPECT_TRUE(fails(read_with(read_csl, good, context, FileFrame::lps, {.structures = 1}), "E-CIO-001"));
    EXPECT_TRUE(fails(read_with(read_csl, good, context, FileFrame::lps, {.contours = 3}), "E-CIO-002"));
    EXPECT_TRUE(
        fails(read_with(read_csl, good, context, FileFrame::lps, {.points_per_contour = 3}), "E-CIO-003"));
    EXPECT_TRUE(fails(read_with(read_csl, good, context, FileFrame::lps, {.points = 13}), "E-CIO-004"));
    EXPECT_TRUE(
        fails(read_with(read_csl, good, context, FileFrame::lps, {.coordinate_mm = 29}), "E-CIO-005"));
    EXPECT_TRUE(
        read_with(
            read_csl, good, context, FileFrame::lps,
            {.structures = 2, .contours = 4, .points_per_contour = 4, .points = 14, .coordinate_mm = 30})
            .ok());
}

TEST(Csl, line_ends_of_other_systems) {
    std::string crlf;
    for (const char c : good) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
    RunContext context;
    const auto one = read_with(read_csl, good, context), other = read_with(read_csl, crlf, context);
    ASSERT_TRUE(one.ok() && other.ok());
    EXPECT_EQ(one.value().points, other.value().points);
}

TEST(Csl, mutations_never_crash) {
    std::mt19937 random(1);
    for (int i = 0; i < 5000; ++i) {
        std::string text = good;
        for (unsigned k = 0, n = 1 + random() % 4; k < n; ++k)
            text[random() % text.size()] = "0129-+.eh \n\xFF"[random() % 12];
        RunContext context;
        const auto read = read_with(read_csl, text, context);
        if (!read.ok()) {
            EXPECT_FALSE(read.error().code.empty());
        }
    }
}

}  // namespace
}  // namespace anatomesh::csl_reader_test
