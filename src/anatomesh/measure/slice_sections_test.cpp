#include "anatomesh/measure/slice_sections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "anatomesh/contour/overlay/even_odd_area.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh::slice_sections_test {
namespace {

constexpr double infinite = 1e12;
const Box2 everywhere{{-infinite, -infinite}, {infinite, infinite}};

void add_ring(std::vector<Segment2>& segments, const std::vector<Vec2>& ring) {
    for (std::size_t n = 0; n < ring.size(); ++n) segments.push_back({ring[n], ring[(n + 1) % ring.size()]});
}

std::vector<Vec2> polygon(Vec2 center, double radius, int count, double turn = 0) {
    std::vector<Vec2> ring;
    for (int n = 0; n < count; ++n) {
        const double t = turn + 2 * std::numbers::pi * n / count;
        ring.push_back(center + radius * Vec2{std::cos(t), std::sin(t)});
    }
    return ring;
}

double area_of(int count, double radius) {
    return 0.5 * count * radius * radius * std::sin(2 * std::numbers::pi / count);
}

TEST(EvenOddArea, rings_holes_and_overlaps_of_squares) {
    std::vector<Segment2> square, with_hole, overlapping;
    const std::vector<Vec2> outer{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, hole{{1, 1}, {1, 2}, {2, 2}, {2, 1}},
        moved{{1, 1}, {5, 1}, {5, 5}, {1, 5}};
    add_ring(square, outer);
    EXPECT_DOUBLE_EQ(even_odd_area(square, everywhere), 16);
    EXPECT_DOUBLE_EQ(even_odd_area(square, {{1, -9}, {9, 2}}), 6);
    with_hole = square;
    add_ring(with_hole, hole);
    EXPECT_DOUBLE_EQ(even_odd_area(with_hole, everywhere), 15);
    overlapping = square;
    add_ring(overlapping, moved);
    EXPECT_DOUBLE_EQ(even_odd_area(overlapping, everywhere), 14);
    EXPECT_DOUBLE_EQ(even_odd_area({}, everywhere), 0);
}

TEST(EvenOddArea, two_polygons_of_many_sides_at_any_turn) {
    std::mt19937 random(5);
    for (int n = 0; n < 50; ++n) {
        const int sides = 3 + static_cast<int>(random() % 40);
        const double turn = random() / 1e9, radius = 1 + random() % 7;
        std::vector<Segment2> segments;
        add_ring(segments, polygon({3, -2}, radius, sides, turn));
        EXPECT_NEAR(even_odd_area(segments, everywhere), area_of(sides, radius), 1e-9 * radius * radius);
        add_ring(segments, polygon({3, -2}, 10, sides, 2 * turn));
        EXPECT_NEAR(even_odd_area(segments, everywhere), area_of(sides, 10) - area_of(sides, radius), 1e-7);
        add_ring(segments, polygon({3, -2}, radius, sides, turn));
        EXPECT_NEAR(even_odd_area(segments, everywhere), area_of(sides, 10), 1e-7);
    }
}

TEST(EvenOddArea, a_slanted_segment_that_leaves_the_clip_sideways) {
    std::vector<Segment2> triangle, spike;
    add_ring(triangle, {{0, 0}, {4, 0}, {0, 4}});
    EXPECT_NEAR(even_odd_area(triangle, {{0, 0}, {2, 4}}), 6, 1e-12);
    add_ring(spike, {{1, 0}, {9, 4}, {9, -4}});
    EXPECT_NEAR(even_odd_area(spike, {{0, -9}, {2, 9}}), 0.5, 1e-12);
}

// A prism of a polygon from z = 0 to 2 with a ring of vertices at z = 1, whose normal and place are given.
struct Prism {
    std::vector<Vec3> points;
    std::vector<Triangle> surface;
    ContourSet contours;
    std::vector<std::uint32_t> vertex_of;

    Prism(const std::vector<Vec2>& ring, const Plane& frame) {
        const auto n = static_cast<std::uint32_t>(ring.size());
        for (int layer = 0; layer < 3; ++layer) {
            for (const Vec2& p : ring)
                points.push_back(frame.to_space(p) + static_cast<double>(layer) * frame.normal);
        }
        for (std::uint32_t layer = 0; layer < 2; ++layer) {
            for (std::uint32_t k = 0; k < n; ++k) {
                const std::uint32_t a = layer * n + k, b = layer * n + (k + 1) % n;
                surface.push_back({a, b, b + n});
                surface.push_back({a, b + n, a + n});
            }
        }
        for (std::uint32_t k = 1; k + 1 < n; ++k) {
            surface.push_back({0, k + 1, k});
            surface.push_back({2 * n, 2 * n + k, 2 * n + k + 1});
        }
        contours.structures = {{1, "prism", {}}};
        for (std::uint32_t layer = 0; layer < 3; ++layer) {
            Slice slice;
            slice.plane = make_plane(frame.origin + static_cast<double>(layer) * frame.normal, frame.normal);
            slice.first_contour = layer;
            slice.contour_count = 1;
            contours.slices.push_back(slice);
            contours.contours.push_back({0, layer, layer * n, n});
        }
        contours.points = points;
        for (std::uint32_t v = 0; v < 3 * n; ++v) vertex_of.push_back(v);
    }
    std::vector<SliceSection> sections() const {
        RunContext context;
        return slice_sections(points, std::vector<std::vector<Triangle>>{surface}, contours,
                              coverage_of(contours, arrangement_of(contours), context), vertex_of);
    }
};

TEST(SliceSections, a_solid_that_is_drawn_differs_nowhere_even_at_its_flat_ends) {
    const std::vector<Vec2> star = {{0, 0}, {9, 1}, {3, 3}, {8, 9}, {1, 4}};
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{0.3, -0.2, 0.9}, Vec3{1, 1, 1}}) {
        const Prism prism(star, make_plane({100, -50, 7}, normal));
        const std::vector<SliceSection> sections = prism.sections();
        ASSERT_EQ(sections.size(), 3u);
        for (const SliceSection& section : sections) {
            EXPECT_NEAR(section.drawn, 25, 1e-9);
            EXPECT_NEAR(section.difference, 0, 1e-9);
        }
    }
}

TEST(SliceSections, a_vertex_drawn_elsewhere_shows_as_the_area_that_it_sweeps) {
    const std::vector<Vec2> square = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    Prism prism(square, make_plane({}, {0, 0, 1}));
    prism.contours.points[6] =
        prism.contours.points[6] + Vec3{1, 1, 0};  // the corner (4, 4) of the middle slice
    prism.vertex_of[6] = no_cell;
    const std::vector<SliceSection> sections = prism.sections();
    EXPECT_NEAR(sections[0].difference, 0, 1e-12);
    EXPECT_NEAR(sections[1].drawn, 20, 1e-12);
    EXPECT_NEAR(sections[1].difference, 4, 1e-12);
    EXPECT_NEAR(sections[2].difference, 0, 1e-12);
}

// To the surface alone: of 3 mm2, through the first two slices.
void add_triangle_beside(Prism& drawn) {
    const Prism other({{10, 0}, {12, 0}, {12, 3}}, make_plane({0, 0, -0.5}, {0, 0, 1}));
    const auto offset = static_cast<std::uint32_t>(drawn.points.size());
    drawn.points.insert(drawn.points.end(), other.points.begin(), other.points.end());
    for (const Triangle& t : other.surface)
        drawn.surface.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

TEST(SliceSections, a_part_that_nobody_drew_counts) {
    const std::vector<Vec2> square = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    Prism drawn(square, make_plane({}, {0, 0, 1}));
    add_triangle_beside(drawn);
    const std::vector<SliceSection> sections = drawn.sections();
    EXPECT_NEAR(sections[0].difference, 3, 1e-12);
    EXPECT_NEAR(sections[1].difference, 3, 1e-12);
    EXPECT_NEAR(sections[2].difference, 0, 1e-12);
}

// The triangle beside the square is drawn on the first of three slices alone and goes on to the second; a
// slice across the square makes the planes cross, so that each is compared as far as it tells.
TEST(SliceSections, a_part_beside_the_box_of_a_slice_counts_where_its_neighbours_draw_it) {
    const std::vector<Vec2> square = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    Prism drawn(square, make_plane({}, {0, 0, 1}));
    add_triangle_beside(drawn);
    ContourSet& set = drawn.contours;
    const auto add = [&](std::uint32_t slice, const std::vector<Vec3>& ring) {
        set.contours.push_back({0, slice, static_cast<std::uint32_t>(set.points.size()),
                                static_cast<std::uint32_t>(ring.size())});
        for (const Vec3& p : ring) {
            set.points.push_back(p);
            drawn.vertex_of.push_back(no_cell);
        }
    };
    // In the order of the slices: the first one's triangle comes after its square.
    std::vector<Contour> squares = set.contours;
    set.contours = {squares[0]};
    add(0, {{10, 0, 0}, {12, 0, 0}, {12, 3, 0}});
    set.contours.push_back(squares[1]);
    set.contours.push_back(squares[2]);
    set.slices.push_back({make_plane({2, 0, 0}, {1, 0, 0}), 4, 1, ""});
    add(3, {{2, 0, 0}, {2, 4, 0}, {2, 4, 2}, {2, 0, 2}});
    set.slices[0].contour_count = 2;
    set.slices[1].first_contour = 2;
    set.slices[2].first_contour = 3;
    const std::vector<SliceSection> sections = drawn.sections();
    ASSERT_EQ(sections.size(), 4u);
    EXPECT_NEAR(sections[0].difference, 0, 1e-12);
    EXPECT_NEAR(sections[1].difference, 3, 1e-12)
        << "what the first slice draws there the second one does not";
    EXPECT_NEAR(sections[2].difference, 0, 1e-12);
    EXPECT_NEAR(sections[3].difference, 0, 1e-12);
}

}  // namespace
}  // namespace anatomesh::slice_sections_test
