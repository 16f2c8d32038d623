#include "anatomesh/contour/clean/crowded_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "anatomesh/contour/cleaned_for_test.h"

namespace anatomesh::crowded_points_test {
namespace {

using namespace fixtures;

// A polygon of `corners` with `crowd` points more after each, `apart` from each other on the edge and off it
// by `off` in turn.
Points crowded(int corners, double radius, int crowd, double apart, double off) {
    const Points plain = circle(0, 0, radius, corners);
    Points points;
    for (std::size_t n = 0; n < plain.size(); ++n) {
        const Vec3 along = plain[(n + 1) % plain.size()] - plain[n];
        const Vec3 unit = (1 / length(along)) * along, across{-unit.y, unit.x, 0};
        points.push_back(plain[n]);
        for (int k = 1; k <= crowd; ++k)
            points.push_back(plain[n] + (k * apart) * unit + (k % 2 == 0 ? off : -off) * across);
    }
    return points;
}

bool holds(const std::vector<Vec3>& points, Vec3 p) {
    return std::find(points.begin(), points.end(), p) != points.end();
}

TEST(CrowdedPoints, C14_go_where_the_line_stays_and_the_others_stay_as_drawn) {
    for (const int crowd : {1, 3, 20}) {
        for (const double apart : {1e-6, 1e-3, 0.008}) {
            for (const double off : {0.0, 1e-4}) {
                SCOPED_TRACE(std::to_string(crowd) + " " + std::to_string(apart) + " " + std::to_string(off));
                if (off > apart) continue;  // a zigzag with a width of its own
                const File file = File().add(crowded(12, 50, crowd, apart, off));
                const Cleaned run = clean(file);
                ASSERT_TRUE(run.ok());
                EXPECT_EQ(run.count("W-CON-032"), 1u);
                // One vertex a corner, or the last of the crowd beside it as well.
                EXPECT_GE(run.kept().points.size(), 12u);
                EXPECT_LE(run.kept().points.size(), 24u);
                for (const Vec3 p : run.kept().points) EXPECT_TRUE(holds(file.raw.points, p));
                const CleanResult& result = run.result.value();
                EXPECT_LE(result.stats.max_displacement_mm, 1e-3);
                EXPECT_EQ(result.log[0].points_kept, run.kept().points.size());
                EXPECT_NE(result.log[0].rule.find("crowded points left out"), std::string::npos);
                CleanOptions exact;
                exact.crowded_mm = 0;
                const Cleaned all = clean(file, exact);
                EXPECT_EQ(all.kept().points.size(), file.raw.points.size());
                EXPECT_NEAR(run.area(), all.area(), 1e-3 * 2 * M_PI * 50);
            }
        }
    }
}

TEST(CrowdedPoints, what_has_a_shape_of_its_own_stays) {
    // Teeth of 0.005 mm: crowded, and further off the line than they may be.
    const File teeth = File().add(crowded(12, 50, 20, 0.006, 0.005));
    const Cleaned run = clean(teeth);
    ASSERT_TRUE(run.ok());
    EXPECT_GT(run.kept().points.size(), teeth.raw.points.size() / 2);
    // Nothing crowded: nothing is left out, though every other point is on the line.
    const File wide = File().add(crowded(12, 50, 3, 0.02, 0));
    const Cleaned same = clean(wide);
    EXPECT_EQ(same.count("W-CON-032"), 0u);
    EXPECT_EQ(same.kept().points.size(), wide.raw.points.size());
}

// The wall of two structures stays one line.
TEST(CrowdedPoints, shared_lines_stay_shared) {
    Points left{{-20, 0, 10}, {0, 0, 10}}, right{{0, 0, 10}, {20, 0, 10}, {20, 20, 10}, {0, 20, 10}};
    for (int k = 1; k < 10000; ++k) {
        const double y = 0.002 * k;
        left.push_back({std::sin(0.3 * y), y, 10});
    }
    left.push_back({0, 20, 10});
    left.push_back({-20, 20, 10});
    for (std::size_t n = left.size() - 2; n-- > 2;) right.push_back(left[n]);
    const Cleaned run = clean(File().add(left, 0).add(right, 1));
    ASSERT_TRUE(run.ok());
    EXPECT_EQ(run.count("W-CON-032"), 1u);
    ASSERT_EQ(run.kept().contours.size(), 2u);
    std::size_t shared = 0;
    for (int s : {0, 1}) {
        const auto span = run.kept().points_of(run.kept().contours[static_cast<std::size_t>(s)]);
        const std::vector<Vec3> points(span.begin(), span.end());
        const auto on_wall = std::count_if(points.begin(), points.end(),
                                           [](Vec3 p) { return std::abs(p.x) < 2 && p.y > 0 && p.y < 20; });
        EXPECT_LT(on_wall, 500);
        if (s == 0) shared = static_cast<std::size_t>(on_wall);
        EXPECT_EQ(static_cast<std::size_t>(on_wall), shared);
    }
    EXPECT_NEAR(run.area(0, 0) + run.area(0, 1), 800, 1e-6);  // no gap and no overlap
}

TEST(CrowdedPoints, C13_a_million_points_become_a_contour_like_others) {
    const Cleaned run = clean(File().add(circle(0, 0, 50, 1'000'000)));
    ASSERT_TRUE(run.ok());
    EXPECT_LT(run.kept().points.size(), 10'000u);
    EXPECT_GT(run.kept().points.size(), 100u);
    EXPECT_NEAR(run.area(), M_PI * 2500, 1e-3 * 2 * M_PI * 50);
}

// The contour that has them is named, and its log counts them, though its points were moved onto the plane
// before.
TEST(CrowdedPoints, of_contours_off_their_plane_are_counted) {
    Points off = circle(0, 0, 50, 100'000, 8);
    for (std::size_t n = 0; n < off.size(); ++n) off[n].z += n % 2 == 0 ? 0.3 : 0.31;
    File file;
    file.raw.planes = {make_plane({0, 0, 5}, {0, 0, 1}), make_plane({0, 0, 8}, {0, 0, 1})};
    file.add(circle(0, 0, 50, 40, 5), 0, ContourKind::closed_planar, 0);
    file.add(off, 0, ContourKind::closed_planar, 1);
    file.raw.contours[0].name = "first";
    file.raw.contours[1].name = "second";
    const Cleaned run = clean(file);
    ASSERT_TRUE(run.ok());
    ASSERT_EQ(run.count("W-CON-032"), 1u);
    EXPECT_EQ(run.warning("W-CON-032").place.contour, "second");
    const std::vector<ContourLog>& log = run.result.value().log;
    EXPECT_EQ(log[0].points_kept, 40u);
    EXPECT_EQ(log[1].points_kept, run.kept().points.size() - 40);
    EXPECT_LT(log[1].points_kept, 2000u);
}

// What is drawn in metres has no points that crowd.
TEST(CrowdedPoints, C32_a_small_unit_is_no_crowd) {
    for (const double radius : {0.02, 0.3, 0.8, 5.0}) {  // an organ, a head, a body; and in centimetres
        const int count = 1500;
        const Cleaned run = clean(File().add(circle(0, 0, radius, count)));
        ASSERT_TRUE(run.ok());
        EXPECT_EQ(run.count("W-CON-032"), 0u) << radius;
        EXPECT_EQ(run.kept().points.size(), static_cast<std::size_t>(count)) << radius;
    }
}

}  // namespace
}  // namespace anatomesh::crowded_points_test
