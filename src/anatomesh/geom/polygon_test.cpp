#include "anatomesh/geom/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace anatomesh::polygon_test {
namespace {

TEST(Polygon, area_is_signed_and_does_not_depend_on_the_place) {
    const std::vector<Vec2> square{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
    EXPECT_EQ(signed_area(square), 4);
    EXPECT_EQ(signed_area(std::vector<Vec2>(square.rbegin(), square.rend())), -4);
    EXPECT_EQ(perimeter(square), 8);
    std::vector<Vec2> far;
    for (Vec2 p : square) far.push_back(p + Vec2{1e7, -1e7});
    EXPECT_EQ(signed_area(far), 4);
    EXPECT_EQ(signed_area(std::vector<Vec2>{{0, 0}, {1, 1}}), 0);
}

TEST(Polygon, side_on_a_lattice_against_the_formula) {
    // A diamond |x| + |y| <= 4: vertices, edges through lattice points, all exact.
    const std::vector<Vec2> diamond{{4, 0}, {0, 4}, {-4, 0}, {0, -4}};
    for (int x = -6; x <= 6; ++x) {
        for (int y = -6; y <= 6; ++y) {
            const int r = std::abs(x) + std::abs(y);
            const Side expected = r < 4 ? Side::inside : r == 4 ? Side::on_boundary : Side::outside;
            EXPECT_EQ(side_of_polygon(diamond, {1.0 * x, 1.0 * y}), expected) << x << " " << y;
        }
    }
}

TEST(Polygon, side_tells_neighbouring_doubles_apart) {
    const std::vector<Vec2> triangle{{0, 0}, {3, 1}, {0, 1}};
    const double x = 1.5, y = 0.5;
    EXPECT_EQ(side_of_polygon(triangle, {x, y}), Side::on_boundary);
    EXPECT_EQ(side_of_polygon(triangle, {x, std::nextafter(y, 1.0)}), Side::inside);
    EXPECT_EQ(side_of_polygon(triangle, {x, std::nextafter(y, 0.0)}), Side::outside);
}

TEST(Polygon, contact_of_segments) {
    using enum SegmentContact;
    EXPECT_EQ(segment_contact({0, 0}, {2, 2}, {0, 2}, {2, 0}), cross);
    EXPECT_EQ(segment_contact({0, 0}, {2, 2}, {1, 1}, {2, 0}), touch);
    EXPECT_EQ(segment_contact({0, 0}, {2, 2}, {2, 2}, {3, 0}), touch);
    EXPECT_EQ(segment_contact({0, 0}, {2, 2}, {2, 2}, {3, 3}), touch);
    EXPECT_EQ(segment_contact({0, 0}, {2, 2}, {1, 1}, {3, 3}), overlap);
    EXPECT_EQ(segment_contact({0, 0}, {2, 2}, {3, 3}, {4, 4}), none);
    EXPECT_EQ(segment_contact({0, 0}, {2, 2}, {0, 1}, {2, 3}), none);
    EXPECT_EQ(segment_contact({0, 0}, {2, 2}, {3, 0}, {3, 9}), none);
    EXPECT_EQ(segment_contact({0, 0}, {0, 2}, {0, 2}, {0, 1}), overlap);
}

TEST(Polygon, contact_is_symmetric) {
    std::mt19937 random(3);
    std::uniform_int_distribution<int> coordinate(0, 4);
    const auto point = [&] { return Vec2{1.0 * coordinate(random), 1.0 * coordinate(random)}; };
    for (int trial = 0; trial < 5000; ++trial) {
        const Vec2 a = point(), b = point(), c = point(), d = point();
        if (a == b || c == d) continue;
        const SegmentContact contact = segment_contact(a, b, c, d);
        EXPECT_EQ(contact, segment_contact(b, a, c, d));
        EXPECT_EQ(contact, segment_contact(c, d, a, b));
        EXPECT_EQ(contact == SegmentContact::none, segment_contact(d, c, b, a) == SegmentContact::none);
        EXPECT_FALSE(on_segment(a, b, c) && contact == SegmentContact::none);
    }
}

}  // namespace
}  // namespace anatomesh::polygon_test
