#include "anatomesh_io/contour/guide_points_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "anatomesh_io/contour/contour_test_support.h"
#include "anatomesh_io/contour/read_contours.h"

namespace anatomesh::guide_points_reader_test {
namespace {

using namespace contour_test;

const std::string columns = "x\ty\tz\tcontour type\tsliceID\tweight\ttime frame\n";

std::string line(Vec3 p, const std::string& type, int slice, int time = 0) {
    return std::to_string(p.x) + "\t" + std::to_string(p.y) + "\t" + std::to_string(p.z) + "\t" + type +
           "\t" + std::to_string(slice) + "\t1.0\t" + std::to_string(time) + "\n";
}

// Points of an arc of a circle in the plane of the slice, in any order.
std::string arc(const std::string& type, int slice, double from, double to, double radius = 20,
                int time = 0) {
    std::vector<std::string> lines;
    for (double a = from; a < to - 1e-9; a += 0.05)
        lines.push_back(line({radius * std::cos(a), radius * std::sin(a), 8.0 * slice}, type, slice, time));
    std::mt19937 random(1);
    std::shuffle(lines.begin(), lines.end(), random);
    std::string all;
    for (const std::string& each : lines) all += each;
    return all;
}

Result<RawContours> read(const std::string& text, RunContext& context,
                         std::optional<std::uint64_t> time = {}) {
    RawBuilder builder("guide points", {}, context);
    ANATOMESH_CHECK_STATUS(read_guide_points(text, time, builder));
    return builder.finish(FileFrame::unknown);
}

constexpr double turn = 2 * std::numbers::pi;

TEST(GuidePoints, curves_come_back_in_order_and_long_axes_are_open_at_their_valve) {
    RunContext context;
    const auto raw =
        read(columns + arc("SAX_LV_ENDOCARDIAL", 1, 0, turn) + arc("LAX_LV_ENDOCARDIAL", 2, 0.5, turn - 0.5) +
                 line({17, 9, 16}, "MITRAL_VALVE", 2) + line({17, -9, 16}, "MITRAL_VALVE", 2),
             context);
    ASSERT_TRUE(raw.ok()) << to_line(raw.error());
    ASSERT_EQ(raw.value().structures.size(), 2u);
    EXPECT_EQ(raw.value().structures[0].name, "LV_ENDOCARDIAL");
    ASSERT_EQ(raw.value().contours.size(), 3u);
    EXPECT_EQ(raw.value().contours[0].kind, ContourKind::closed_planar);
    EXPECT_EQ(raw.value().contours[1].kind, ContourKind::open_at_valve);
    EXPECT_EQ(raw.value().contours[2].kind, ContourKind::point);
    for (const std::size_t c : {0u, 1u}) {
        const RawContour& contour = raw.value().contours[c];
        for (std::uint32_t p = 1; p < contour.point_count; ++p)
            EXPECT_LT(length(raw.value().points[contour.first_point + p] -
                             raw.value().points[contour.first_point + p - 1]),
                      1.1);
    }
    EXPECT_TRUE(context.warnings.empty());
}

TEST(GuidePoints, the_septum_belongs_to_both_ventricles) {
    RunContext context;
    const auto raw =
        read(columns + arc("SAX_LV_EPICARDIAL", 1, 1, turn - 1) + arc("SAX_RV_SEPTUM", 1, -1, 1), context);
    ASSERT_TRUE(raw.ok()) << to_line(raw.error());
    ASSERT_EQ(raw.value().structures[0].name, "LV_EPICARDIAL");
    EXPECT_EQ(raw.value().contours[0].kind, ContourKind::closed_planar);
    EXPECT_EQ(raw.value().contours[0].point_count, raw.value().contours[1].point_count + 86);
    EXPECT_EQ(raw.value().structures[1].name, "RV_ENDOCARDIAL");
}

// At the base of a heart: the outline of the aorta's root, and the septum far from it.
TEST(GuidePoints, a_closed_outline_has_no_use_for_the_septum) {
    RunContext context;
    const auto raw = read(
        columns + arc("SAX_LV_EPICARDIAL", 1, 0, turn, 8) + arc("SAX_RV_SEPTUM", 1, -0.3, 0.3, 60), context);
    ASSERT_TRUE(raw.ok()) << to_line(raw.error());
    ASSERT_EQ(raw.value().structures[0].name, "LV_EPICARDIAL");
    EXPECT_EQ(raw.value().contours[0].point_count, 126u);
    EXPECT_EQ(raw.value().structures[1].name, "RV_ENDOCARDIAL");
    EXPECT_EQ(raw.value().contours[1].point_count, 12u);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-GPT-002");
}

// A four-chamber view: the free wall from the valve to the apex, the septum back, between the two the valve.
TEST(GuidePoints, a_long_axis_takes_the_septum_and_stays_open_at_the_valve) {
    RunContext context;
    const double valve = 1.0;
    for (const bool marked : {false, true}) {
        std::string text = columns + arc("LAX_LV_EPICARDIAL", 2, valve, 3.6, 40) +
                           arc("LAX_RV_SEPTUM", 2, 3.6, turn, 40) + arc("SAX_LV_EPICARDIAL", 1, 0, turn);
        if (marked)
            text += line({40 * std::cos(valve), 40 * std::sin(valve), 16}, "MITRAL_VALVE", 2) +
                    line({40, 0, 16}, "MITRAL_VALVE", 2);
        const auto raw = read(text, context);
        ASSERT_TRUE(raw.ok()) << to_line(raw.error());
        ASSERT_EQ(raw.value().structures[0].name, "LV_EPICARDIAL");
        const auto long_axis =
            std::find_if(raw.value().contours.begin(), raw.value().contours.end(),
                         [](const RawContour& c) { return c.structure == 0 && c.name == "slice 2"; });
        ASSERT_NE(long_axis, raw.value().contours.end());
        EXPECT_EQ(long_axis->kind, ContourKind::open_at_valve);
        EXPECT_EQ(long_axis->point_count, 52u + 54u);
    }
    EXPECT_TRUE(context.warnings.empty());
}

// Beside their valve, or walls alone, they are not closed.
TEST(GuidePoints, what_does_not_end_at_a_valve_or_is_a_wall_alone_stays_open) {
    RunContext context;
    const auto raw = read(columns + arc("LAX_LV_ENDOCARDIAL", 2, 1, turn, 40) +
                              line({-40, 0, 16}, "MITRAL_VALVE", 2) + line({-35, 9, 16}, "MITRAL_VALVE", 2) +
                              arc("LAX_RV_FREEWALL", 3, 1, turn, 40) + arc("SAX_RV_SEPTUM", 4, 0, 2, 40),
                          context);
    ASSERT_TRUE(raw.ok()) << to_line(raw.error());
    std::size_t open = 0;
    for (const RawContour& contour : raw.value().contours) {
        open += contour.kind == ContourKind::open;
        EXPECT_TRUE(contour.kind == ContourKind::open || contour.kind == ContourKind::point);
    }
    EXPECT_EQ(open, 4u);
}

TEST(GuidePoints, G26_time_frames_are_chosen) {
    RunContext context;
    const std::string text =
        columns + arc("SAX_LV_ENDOCARDIAL", 1, 0, turn) + arc("SAX_LV_ENDOCARDIAL", 1, 0, turn, 15, 3);
    EXPECT_TRUE(fails(read(text, context), "E-GPT-003", "0 (126 points), 3 (126 points)"));
    EXPECT_TRUE(fails(read(text, context, 1), "E-GPT-003", "0 (126 points), 3 (126 points)"));
    const auto raw = read(text, context, 3);
    ASSERT_TRUE(raw.ok());
    for (const Vec3& p : raw.value().points) EXPECT_NEAR(std::hypot(p.x, p.y), 15, 1e-4);
}

TEST(GuidePoints, wrong_tables_are_refused_with_their_line) {
    RunContext context;
    EXPECT_TRUE(
        fails(read(columns + "1\t2\t3\tSAX_LV_ENDOCARDIAL\t1\t1.0\n", context), "E-GPT-001", "line 2"));
    EXPECT_TRUE(fails(read(columns + "1\t2\t3\tSAX\t1\t1.0\t0\t9\n", context), "E-GPT-001"));
    EXPECT_TRUE(
        fails(read(columns + "1\tnan\t3\tSAX_LV_ENDOCARDIAL\t1\t1.0\t0\n", context), "E-GPT-002", "nan"));
    EXPECT_TRUE(fails(read(columns + "1\t2\t3\tSAX_LV_ENDOCARDIAL\t1\t1.0\tx\n", context), "E-GPT-002"));
    EXPECT_TRUE(fails(read(columns, context), "E-CIO-006"));
    std::string many = columns;
    for (int p = 0; p < 5001; ++p) many += line({1.0 * p, 0, 0}, "SAX_LV_ENDOCARDIAL", 1);
    EXPECT_TRUE(fails(read(many, context), "E-GPT-004"));
}

TEST(GuidePoints, real_heart) {
    const char* set = std::getenv("ANATOMESH_DATA");
    const std::filesystem::path path =
        (set ? std::filesystem::path(set)
             : std::filesystem::path(ANATOMESH_SOURCE_DIR).parent_path() / "shared/data") /
        "heart_cmr/GPFile_000.txt";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no heart_cmr (set ANATOMESH_DATA)";
    RunContext context;
    ReadContoursOptions options;
    EXPECT_EQ(read_contours(path.string(), options, context).error().code, "E-GPT-003");
    options.time_frame = 0;
    const auto raw = read_contours(path.string(), options, context);
    ASSERT_TRUE(raw.ok()) << to_line(raw.error());
    std::size_t closed = 0, open = 0;
    for (const RawContour& contour : raw.value().contours) {
        closed += contour.kind == ContourKind::closed_planar;
        open += contour.kind == ContourKind::open_at_valve;
    }
    EXPECT_GT(closed, 40u);
    EXPECT_GT(open, 0u);
    EXPECT_TRUE(context.warnings.empty() || context.warnings[0].code == "W-GPT-001");
}

}  // namespace
}  // namespace anatomesh::guide_points_reader_test
