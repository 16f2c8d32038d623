#include "anatomesh/contour/overlay/separate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "anatomesh/contour/cleaned_for_test.h"

namespace anatomesh::separate_test {
namespace {

using namespace fixtures;

// Triangles side by side at one vertex: each gives way by as much as if it were alone.
TEST(SeparateRings, C05_many_that_touch_in_one_point_are_parted_alike) {
    for (const int count : {2, 5, 8}) {
        File file;
        for (int n = 0; n < count; ++n) {
            const double angle = 2 * M_PI * n / count, half = 0.3 * M_PI / count;
            const auto at = [&](double a) { return Vec3{20 * std::cos(a), 20 * std::sin(a), 10}; };
            file.add({{0, 0, 10}, at(angle - half), at(angle + half)});
        }
        const Cleaned run = clean(file);
        EXPECT_KEPT(run);
        ASSERT_EQ(run.kept().contours.size(), static_cast<std::size_t>(count));
        std::vector<double> from_middle;
        for (const Contour& contour : run.kept().contours) {
            double least = 100;
            for (const Vec3& p : run.kept().points_of(contour)) least = std::min(least, std::hypot(p.x, p.y));
            from_middle.push_back(least);
        }
        std::sort(from_middle.begin(), from_middle.end());
        EXPECT_EQ(from_middle[0], 0) << count;  // the largest stays
        for (std::size_t n = 1; n < from_middle.size(); ++n) EXPECT_GT(from_middle[n], 0.19) << count;
    }
}

// Vertices that lie as near to the common one as rounding or a fine drawing puts them leave the corner its room.
TEST(SeparateRings, C05_vertices_crowded_beside_the_common_one_take_no_room) {
    const Points large{{0, 0, 10}, {-20, -20, 10}, {20, -20, 10}};
    for (int exponent = -16; exponent <= -2; ++exponent) {
        for (const bool before : {true, false}) {
            for (const bool after : {true, false}) {
                const double near = std::pow(10, exponent);
                Points small{{0, 0, 10}};
                if (after) small.push_back({0.5 * near, near, 10});
                small.push_back({5, 10, 10});
                small.push_back({-5, 10, 10});
                if (before) small.push_back({-0.5 * near, near, 10});
                const Cleaned run = clean(File().add(large).add(small));
                EXPECT_KEPT(run);
                ASSERT_EQ(run.kept().contours.size(), 2u) << near;
                double least = 100;
                for (const Contour& contour : run.kept().contours) {
                    const auto points = run.kept().points_of(contour);
                    if (std::any_of(points.begin(), points.end(), [](const Vec3& p) { return p.y > 9; }))
                        for (const Vec3& p : points) least = std::min(least, std::hypot(p.x, p.y));
                }
                EXPECT_GT(least, 0.19) << near << before << after;
                EXPECT_LT(least, 0.3) << near << before << after;
            }
        }
    }
}

// A hole so small and so near to a corner that the whole of it would be cut off stays a hole.
TEST(SeparateRings, C08_no_corner_is_cut_off_beyond_a_ring_in_it) {
    const Points large{{0, 0, 10}, {-20, -20, 10}, {20, -20, 10}}, small{{0, 0, 10}, {4, 8, 10}, {-4, 8, 10}};
    for (const double up : {0.05, 0.1, 0.13}) {
        const double side = 0.1 * up;
        const Points hole{{-side, up, 10}, {side, up, 10}, {0, up + side, 10}};
        const Cleaned run = clean(File().add(large).add(small).add(hole));
        EXPECT_KEPT(run);
        ASSERT_EQ(run.kept().contours.size(), 3u) << up;
        int holes = 0;
        for (const Contour& contour : run.kept().contours) {
            std::vector<Vec2> at;
            for (const Vec3& p : run.kept().points_of(contour))
                at.push_back(run.kept().slices[0].plane.to_plane(p));
            holes += signed_area(at) < 0;
        }
        EXPECT_EQ(holes, 1) << up;
    }
}

}  // namespace
}  // namespace anatomesh::separate_test
