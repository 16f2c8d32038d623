#include "anatomesh/live/draw/spline.h"

#include <gtest/gtest.h>

#include "anatomesh/live/draw/area/draw_fixtures.h"
#include "anatomesh/live/draw/stroke.h"

namespace anatomesh::spline_test {
namespace {

using namespace draw_fixtures;

Polygon random_controls(Random& random) {
    Polygon controls = circle({uniform(random, -50, 50), uniform(random, -50, 50)}, 20, whole(random, 3, 15));
    for (Vec2& p : controls) p = p + Vec2{uniform(random, -4, 4), uniform(random, -4, 4)};
    return controls;
}

// The centripetal curve at many points, by another form of its definition: the cubic with the tangents at its ends that
// its knots give (Hermite).
Vec2 hermite(Vec2 p0, Vec2 p1, Vec2 p2, Vec2 p3, double s) {
    const double d0 = std::sqrt(length(p1 - p0)), d1 = std::sqrt(length(p2 - p1)),
                 d2 = std::sqrt(length(p3 - p2));
    const auto tangent = [&](Vec2 a, Vec2 b, Vec2 c, double e, double f) {
        return (1 / e) * (b - a) - (1 / (e + f)) * (c - a) + (1 / f) * (c - b);
    };
    const Vec2 m1 = d1 * tangent(p0, p1, p2, d0, d1), m2 = d1 * tangent(p1, p2, p3, d1, d2);
    const double s2 = s * s, s3 = s2 * s;
    return (2 * s3 - 3 * s2 + 1) * p1 + (s3 - 2 * s2 + s) * m1 + (-2 * s3 + 3 * s2) * p2 + (s3 - s2) * m2;
}

TEST(Spline, is_the_curve_within_the_tolerance_and_has_each_control) {
    for (int seed = 0; seed < 200; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Polygon controls = random_controls(random);
        const double tolerance = std::exp(uniform(random, -6, 0));
        const Polygon polygon = closed_spline(controls, tolerance);
        EXPECT_EQ(polygon[0], controls[0]);
        std::size_t next = 0;
        for (const Vec2 p : polygon) next += next < controls.size() && p == controls[next];
        EXPECT_EQ(next, controls.size()) << "controls stand in their order, bit for bit";
        Ring ring;
        ring.at = polygon;
        const std::size_t n = controls.size();
        for (std::size_t i = 0; i < n; ++i) {
            for (double s = 0.02; s < 1; s += 0.02) {
                const Vec2 p = hermite(controls[(i + n - 1) % n], controls[i], controls[(i + 1) % n],
                                       controls[(i + 2) % n], s);
                ASSERT_LT(distance_to_rings(std::span(&ring, 1), p), 1.1 * tolerance) << seed;
            }
        }
    }
}

TEST(Spline, a_control_that_moves_leaves_what_is_beyond_two_controls) {
    for (int seed = 0; seed < 200; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Polygon controls = random_controls(random);
        const std::size_t n = controls.size();
        const std::size_t moved = random() % n;
        Polygon other = controls;
        other[moved] = other[moved] + Vec2{uniform(random, -3, 3), uniform(random, -3, 3)};
        const Polygon a = closed_spline(controls, 0.02), b = closed_spline(other, 0.02);
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t from_moved = (i + n - moved) % n;  // the stretch from control i on
            if (from_moved <= 1 || from_moved + 2 >= n) continue;
            const auto stretch = [&](const Polygon& polygon) {
                const auto begin = std::find(polygon.begin(), polygon.end(), controls[i]);
                const auto end =
                    i + 1 < n ? std::find(polygon.begin(), polygon.end(), controls[i + 1]) : polygon.end();
                return Polygon(begin, end);
            };
            EXPECT_EQ(stretch(a), stretch(b)) << seed;
            EXPECT_FALSE(stretch(a).empty());
        }
    }
}

TEST(Spline, closing_adds_no_point) {
    Random random(5);
    Polygon controls = random_controls(random);
    const Polygon open = closed_spline(controls, 0.02);
    controls.push_back(controls[0]);
    EXPECT_EQ(closed_spline(controls, 0.02), open);
    controls.insert(controls.begin() + 2, controls[1]);
    EXPECT_EQ(closed_spline(controls, 0.02), open);
    EXPECT_EQ(closed_spline(Polygon{{1, 2}, {3, 4}, {1, 2}}, 0.02), (Polygon{{1, 2}, {3, 4}}));
    EXPECT_TRUE(closed_spline({}, 0.02).empty());
}

TEST(Spline, of_points_on_a_circle_is_nearly_the_circle) {
    const DrawResult result = draw_spline({}, circle({0, 0}, 20, 12), {}).value();
    ASSERT_EQ(result.rings.rings.size(), 1u);
    EXPECT_EQ(result.effect, AreaEffect::new_part);
    for (const Vec2 p : result.rings.rings[0].at) EXPECT_NEAR(length(p), 20, 0.06);
    for (const Vec2 p : circle({0, 0}, 20, 12)) EXPECT_LT(distance_to_rings(result.rings.rings, p), 0.05);
}

TEST(Spline, that_crosses_itself_is_mended) {
    const DrawResult result = draw_spline({}, Polygon{{0, 0}, {30, 20}, {30, 0}, {0, 20}}, {}).value();
    EXPECT_EQ(result.mended_crossings, 1u);
    EXPECT_EQ(result.rings.rings.size(), 2u);
    expect_sound(result.rings);
    EXPECT_EQ(draw_spline({}, Polygon{{0, 0}, {30, 20}}, {}).value().reason, NothingDrawn::no_area);
    SplineOptions options;
    options.tolerance_mm = -1;
    EXPECT_EQ(draw_spline({}, Polygon{{0, 0}, {30, 20}}, options).error().code, "E-LIV-008");
}

TEST(Polygon, has_its_corners_as_vertices) {
    for (int seed = 0; seed < 100; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Plane plane = random_plane(random);
        const Polygon corners = random_star(random, {3, 4}, 20);
        const DrawResult result = draw_polygon({plane, {}}, corners, DrawMode::extend).value();
        ASSERT_EQ(result.rings.rings.size(), 1u);
        ASSERT_EQ(result.rings.rings[0].size(), corners.size());
        for (const Vec2 p : corners) {
            const Vec3 point = plane.to_space(p);
            EXPECT_TRUE(has_stretch(result.rings.rings[0].points, std::span(&point, 1)));
        }
    }
}

}  // namespace
}  // namespace anatomesh::spline_test
