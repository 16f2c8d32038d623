#include "anatomesh/reconcile/resolve/nearest_arc.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::nearest_arc_test {
namespace {

using namespace crossing_fixtures;

// A slice in the plane y = 0 and the plane through the x axis at an angle to it. In the slice, x runs along
// the common line and z across it.
struct Crossed {
    ContourSet set;
    Plane other;
    Line line;
};

Crossed crossed(const std::vector<Ring>& drawn, double degrees) {
    Crossed result;
    const Plane own = make_plane({}, {0, 1, 0});
    for (const Ring& ring : drawn) {
        Ring placed;
        for (const Vec2 p : ring) placed.push_back(own.to_plane({p.x, 0, p.y}));
        if (result.set.slices.empty()) {
            add_slice(result.set, own, placed);
            continue;
        }
        Contour contour{0, 0, static_cast<std::uint32_t>(result.set.points.size()),
                        static_cast<std::uint32_t>(placed.size())};
        for (const Vec2 p : placed) result.set.points.push_back(own.to_space(p));
        result.set.contours.push_back(contour);
        ++result.set.slices[0].contour_count;
    }
    const double angle = degrees * std::numbers::pi / 180;
    result.other = make_plane({}, {0, std::cos(angle), std::sin(angle)});
    result.line = {{}, {1, 0, 0}};
    return result;
}

NearestArc stretch_of(const Crossed& c, double low, double high) {
    return nearest_arc(c.set, 0, 0, c.line, c.other, low, high);
}

// A box beside the line whose near side has vertices, the interval anywhere along it: the vertices beside the
// interval, their distances, and where the ends and the middle of the interval lie on the side.
TEST(NearestArc, is_what_lies_beside_the_interval) {
    for (const double degrees : {5.0, 40.0, 90.0}) {
        for (const double side : {1.0, -1.0}) {
            for (const double low : {-7.35, -2.15, 0.45}) {
                for (const double width : {0.36, 2.0, 5.5}) {
                    Ring box;
                    for (double x = -10; x <= 10; x += 1) box.push_back({x, side * (2 + 0.05 * x)});
                    box.push_back({10, side * 9});
                    box.push_back({-10, side * 9});
                    const Crossed c = crossed({box}, degrees);
                    const NearestArc stretch = stretch_of(c, low, low + width);
                    std::size_t beside = 0;
                    for (double x = -10; x <= 10; x += 1) beside += x > low && x < low + width;
                    ASSERT_EQ(stretch.points.size(), beside);
                    for (std::size_t n = 0; n < beside; ++n) {
                        const Vec3 p = c.set.points[stretch.points[n]];
                        EXPECT_NEAR(stretch.heights_mm[n], std::abs(p.z), 1e-9);
                        // Over the line by its distance it lies on the line.
                        const Plane& plane = c.set.slices[0].plane;
                        const Vec3 moved =
                            plane.to_space(plane.to_plane(p) + stretch.heights_mm[n] * stretch.back);
                        EXPECT_NEAR(moved.z, 0, 1e-9);
                        EXPECT_NEAR(moved.x, p.x, 1e-9);
                    }
                    EXPECT_NEAR(length(stretch.back), 1, 1e-9);
                    std::vector<double> places;
                    for (const IntervalEndpoint& place : stretch.places) {
                        EXPECT_NEAR(place.at.x, place.t, 1e-9);
                        EXPECT_NEAR(std::abs(place.at.z), 2 + 0.05 * place.t, 1e-9);
                        EXPECT_LE(std::abs(place.at.z), stretch.height_mm + 1e-9);
                        places.push_back(place.t);
                    }
                    std::sort(places.begin(), places.end());
                    ASSERT_EQ(places.size(), 3u);
                    EXPECT_DOUBLE_EQ(places[0], low);
                    EXPECT_DOUBLE_EQ(places[1], low + 0.5 * width);
                    EXPECT_DOUBLE_EQ(places[2], low + width);
                }
            }
        }
    }
}

TEST(NearestArc, is_of_the_nearest_contour_and_of_its_near_side) {
    const Ring far{{-5, 8}, {5, 8}, {5, 12}, {-5, 12}}, near{{-5, -3}, {-5, -6}, {5, -6}, {5, -3}, {0, -2}};
    const NearestArc stretch = stretch_of(crossed({far, near}, 60), -4, 4);
    ASSERT_EQ(stretch.points.size(), 1u);  // the near one's tip
    EXPECT_DOUBLE_EQ(stretch.heights_mm[0], 2);
    EXPECT_NEAR(stretch.height_mm, 2.8, 1e-9);  // at the interval's ends
}

TEST(NearestArc, ends_where_the_contour_turns_back_or_passes_the_line) {
    // Beside the whole interval runs an arm that turns back at x = 2.
    const Ring turned{{-9, 2}, {2, 3}, {1, 6}, {-9, 6}};
    const NearestArc half = stretch_of(crossed({turned}, 90), -4, 4);
    ASSERT_EQ(half.points.size(), 1u);
    EXPECT_DOUBLE_EQ(half.heights_mm[0], 3);
    EXPECT_EQ(half.places.size(), 2u);  // the interval's end is not beside it
    const Ring passing{{-9, 2}, {-1, 2}, {1, -2}, {9, -2}, {9, -8}, {20, -8}, {20, 9}, {-9, 9}};
    const NearestArc until = stretch_of(crossed({passing}, 90), -6, -0.5);
    ASSERT_EQ(until.points.size(), 1u);
    EXPECT_DOUBLE_EQ(until.heights_mm[0], 2);
}

TEST(NearestArc, is_not_there_where_nothing_lies_beside_the_interval) {
    const Ring box{{-5, 2}, {5, 2}, {5, 6}, {-5, 6}};
    EXPECT_TRUE(stretch_of(crossed({box}, 90), 6, 9).places.empty());
    EXPECT_TRUE(nearest_arc(crossed({box}, 90).set, 0, 1, {{}, {1, 0, 0}}, crossed({box}, 90).other, -1, 1)
                    .places.empty());  // of another structure
}

}  // namespace
}  // namespace anatomesh::nearest_arc_test
