#include "anatomesh/contour/clean/clean.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "anatomesh/contour/cleaned_for_test.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh::clean_test {
namespace {

using namespace fixtures;

TEST(Clean, keeps_an_ordinary_contour_bit_for_bit) {
    const Points drawn = circle(101.7, -33.3, 20.1, 97, 36);
    const Cleaned run = clean(File().add(drawn));
    ASSERT_TRUE(run.ok());
    EXPECT_TRUE(run.warnings.empty() || run.count("W-CON-001") == run.warnings.size());
    ASSERT_EQ(run.kept().contours.size(), 1u);
    EXPECT_EQ(run.kept().slices[0].name, "z = 36.0");
    Points a = drawn, b = run.kept().points;
    const auto less = [](Vec3 p, Vec3 q) { return lexicographic_less(p, q); };
    std::sort(a.begin(), a.end(), less);
    std::sort(b.begin(), b.end(), less);
    EXPECT_EQ(a, b);
    EXPECT_GT(run.area(), 0);
}

Points reversed(Points points) {
    std::reverse(points.begin(), points.end());
    return points;
}

Points rotated(Points points, std::size_t by) {
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(by % points.size()),
                points.end());
    return points;
}

TEST(Clean, RS14_hole_by_nesting) {
    const Cleaned run = clean(File().add(square(0, 0, 10)).add(square(2, 2, 6)).add(square(4, 4, 2)));
    ASSERT_TRUE(run.ok());
    EXPECT_EQ(run.area(), 100 - 36 + 4);
    EXPECT_EQ(run.result.value().log[1].rule, "hole of 0");
    EXPECT_EQ(run.result.value().log[2].rule, "island in hole 1");
    CleanOptions united;
    united.rings.holes = HoleRule::united;
    EXPECT_EQ(clean(File().add(square(0, 0, 10)).add(square(2, 2, 6)), united).area(), 100);
}

TEST(Clean, RS01_C36_no_contours) {
    const Cleaned empty = clean(File());
    EXPECT_EQ(empty.code(), "E-CON-001");
    EXPECT_NE(empty.result.error().message.find("liver, spleen"), std::string::npos);
    File nothing;
    nothing.raw.structures.clear();
    EXPECT_EQ(clean(nothing).code(), "E-CON-001");
}

TEST(Clean, RS02_structure_without_contours_is_skipped_by_name) {
    const Cleaned run = clean(File().add(square(0, 0, 1), 1));
    EXPECT_KEPT(run);
    EXPECT_EQ(run.count("W-CON-001"), 1u);
    EXPECT_EQ(run.warnings[0].place.structure, "liver");
    ASSERT_EQ(run.kept().structures.size(), 1u);
    EXPECT_EQ(run.kept().structures[0].name, "spleen");
}

TEST(Clean, RS04_equal_names_are_both_kept) {
    File file;
    file.raw.structures[1].name = "LI VER";
    const Cleaned run = clean(file.add(square(0, 0, 1)).add(square(5, 5, 1), 1));
    EXPECT_KEPT(run);
    EXPECT_EQ(run.count("W-CON-002"), 1u);
    EXPECT_EQ(run.kept().structures.size(), 2u);
}

TEST(Clean, RS07_C37_numbers_out_of_range_name_the_point) {
    for (double value :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e30, -2e7}) {
        Points points = square(0, 0, 5);
        points[2].y = value;
        const Cleaned run = clean(File().add(square(9, 9, 1)).add(points));
        EXPECT_EQ(run.code(), std::isfinite(value) ? "E-CON-003" : "E-CON-002");
        EXPECT_EQ(run.result.error().place.contour, "1, point 2");
        EXPECT_EQ(run.result.error().place.structure, "liver");
    }
}

TEST(Clean, RS08_points_and_open_contours_stay_out) {
    const Points far_apart{{0, 0, 10}, {20, 0, 10}, {20, 20, 10}};
    const Cleaned run = clean(File()
                                  .add(square(0, 0, 5))
                                  .add({{1, 1, 10}})
                                  .add({{1, 1, 10}, {2, 2, 10}})
                                  .add({{1, 1, 10}, {2, 2, 10}, {3, 1, 10}}, 0, ContourKind::point)
                                  .add(far_apart, 0, ContourKind::open));
    EXPECT_KEPT(run);
    EXPECT_EQ(run.kept().contours.size(), 1u);
    EXPECT_EQ(run.count("W-CON-003"), 2u);
    EXPECT_EQ(run.count("W-CON-004"), 1u);
    EXPECT_EQ(run.count("W-CON-005"), 1u);
    EXPECT_EQ(run.result.value().stats.dropped, 4u);
}

TEST(Clean, C12_open_contour_with_a_small_gap_is_closed_with_a_warning) {
    for (double gap : {0.01, 1.0, 20.0}) {
        const Points open{{0, gap, 10}, {0, 30, 10}, {30, 30, 10}, {30, 0, 10}, {0, 0, 10}};
        const Cleaned run = clean(File().add(square(100, 0, 5)).add(open, 0, ContourKind::open));
        EXPECT_KEPT(run);
        EXPECT_EQ(run.kept().contours.size(), gap < 2 ? 2u : 1u);
        EXPECT_EQ(run.count(gap < 2 ? "W-CON-006" : "W-CON-005"), 1u);
    }
}

TEST(Clean, C12_a_contour_open_at_a_valve_is_closed_across_it) {
    // Drawn: two sides and the apex, 30 mm each, or three quarters less of the sides.
    for (const double depth : {30.0, 7.0}) {
        const Points open{{0, depth, 10}, {0, 0, 10}, {30, 0, 10}, {30, depth, 10}};
        const Cleaned run = clean(File().add(square(100, 0, 5)).add(open, 0, ContourKind::open_at_valve));
        EXPECT_KEPT(run);
        const bool is_deep = depth > 20;
        EXPECT_EQ(run.kept().contours.size(), is_deep ? 2u : 1u);
        EXPECT_EQ(run.count(is_deep ? "W-CON-029" : "W-CON-005"), 1u);
        EXPECT_EQ(run.result.value().log[1].rule,
                  is_deep ? "open at the valve, closed over 30 mm; outer" : "dropped: open");
    }
}

TEST(Clean, RS09_points_off_the_plane) {
    for (double off : {0.01, 0.3, 5.0}) {
        for (int count : {4, 5, 60}) {
            Points points = circle(0, 0, 30, count);
            points[1].z += off;
            const Cleaned alone = clean(File().add(points));
            const Cleaned among =
                clean(File().add(points).add(square(-10, -10, 20, 13)).add(square(-10, -10, 20, 16)));
            for (const Cleaned* run : {&alone, &among}) {
                if (off > 1) {
                    ASSERT_FALSE(run->ok());
                    EXPECT_EQ(run->code(), "E-CON-005");
                    EXPECT_EQ(run->result.error().place.contour, "0, point 1");
                    continue;
                }
                EXPECT_KEPT(*run);
                EXPECT_EQ(run->kept().slices[0].name, "z = 10.0");
                EXPECT_EQ(run->count("W-CON-009"), off > 0.05 ? 1u : 0u);
                EXPECT_NEAR(run->result.value().stats.max_displacement_mm, off > 0.05 ? off : 0, 1e-12);
                const auto& kept = run->kept().points;
                EXPECT_EQ(std::count(kept.begin(), kept.end(), points[1]), off > 0.05 ? 0 : 1);
            }
        }
    }
}

TEST(Clean, RS11_nearly_equal_planes_are_one_slice) {
    const Cleaned run = clean(File().add(circle(0, 0, 10, 40, 10.0)).add(square(30, 0, 5, 10.0001)));
    EXPECT_KEPT(run);
    ASSERT_EQ(run.kept().slices.size(), 1u);
    EXPECT_EQ(run.kept().slices[0].plane.origin.z, 10.0);
    EXPECT_EQ(run.count("W-CON-010"), 1u);
    EXPECT_EQ(run.kept().points_of(run.kept().contours[1])[0], (Vec3{30, 0, 10.0001}));
}

TEST(Clean, RS12_C01_repeated_points) {
    Points closed = square(0, 0, 5);
    closed.push_back(closed.front());
    const Cleaned first_again = clean(File().add(closed).add(square(9, 9, 1), 1));
    EXPECT_KEPT(first_again);
    EXPECT_TRUE(first_again.warnings.empty());
    Points doubled;
    for (const Vec3& p : closed) doubled.insert(doubled.end(), 2, p);
    const Cleaned twice = clean(File().add(doubled).add(square(9, 9, 1), 1));
    EXPECT_KEPT(twice);
    EXPECT_EQ(twice.count("W-CON-007"), 1u);
    EXPECT_TRUE(same(first_again.kept(), twice.kept()));
    EXPECT_EQ(clean(File().add(Points(5, Vec3{1, 2, 3}))).code(), "E-CON-004");
}

TEST(Clean, RS13_C38_any_direction_start_and_order_give_the_same) {
    std::vector<Points> contours{circle(0, 0, 20, 50),     circle(1, 1, 8, 31),
                                 square(-2, -2, 3),        circle(40, 0, 9, 20, 13),
                                 circle(0, 0, 19, 44, 13), circle(3, 0, 19, 41, 13)};
    std::mt19937 random(1);
    const Cleaned first = [&] {
        File file;
        for (const Points& points : contours) file.add(points);
        return clean(file.add(square(0, 0, 5, 13), 1));
    }();
    EXPECT_KEPT(first);
    for (int trial = 0; trial < 50; ++trial) {
        File file;
        if (trial % 2) file.add(square(0, 0, 5, 13), 1);
        std::shuffle(contours.begin(), contours.end(), random);
        for (const Points& points : contours) {
            const Points turned = rotated(points, random());
            file.add(random() % 2 ? reversed(turned) : turned);
        }
        if (trial % 2 == 0) file.add(square(0, 0, 5, 13), 1);
        const Cleaned other = clean(file);
        EXPECT_KEPT(other);
        EXPECT_TRUE(same(first.kept(), other.kept()));
    }
}

TEST(Clean, C38_holds_for_tilted_stacks_too) {
    const Plane plane = make_plane({3, 4, 5}, {0.02, -0.05, 1});
    std::vector<Points> contours;
    for (int k = 0; k < 8; ++k) {
        Points points;
        for (const Vec3& p : circle(2 * k, 3, 20 - k, 60 + k, 0)) {
            const Vec3 q = plane.to_space({p.x, p.y}) + 3.0 * k * plane.normal;
            // As a file gives it, with three decimals.
            points.push_back({std::round(q.x * 1000) / 1000, std::round(q.y * 1000) / 1000,
                              std::round(q.z * 1000) / 1000});
        }
        contours.push_back(points);
    }
    std::mt19937 random(2);
    std::vector<Vec3> points;
    std::vector<Plane> planes;
    for (int trial = 0; trial < 10; ++trial) {
        File file;
        for (const Points& contour : contours) file.add(rotated(contour, random()));
        const Cleaned run = clean(file);
        EXPECT_KEPT(run);
        ASSERT_EQ(run.kept().slices.size(), 8u);
        EXPECT_EQ(run.count("W-CON-010"), 0u);
        EXPECT_LT(length(cross(run.kept().slices[0].plane.normal, plane.normal)), 1e-4);
        if (trial == 0) points = run.kept().points;
        EXPECT_EQ(points, run.kept().points);
        for (std::size_t s = 0; s < 8; ++s) {
            if (trial == 0) planes.push_back(run.kept().slices[s].plane);
            EXPECT_EQ(planes[s].origin, run.kept().slices[s].plane.origin);
            EXPECT_EQ(planes[s].normal, run.kept().slices[s].plane.normal);
        }
        std::shuffle(contours.begin(), contours.end(), random);
    }
}

TEST(Clean, RS25_mixed_orientations_make_slices_of_their_own) {
    Points sagittal;
    for (const Vec3& p : circle(0, 0, 10, 30, 4)) sagittal.push_back({p.z, p.x, p.y});
    const Cleaned run = clean(File().add(circle(0, 0, 10, 30, 1)).add(circle(0, 0, 9, 30, 4)).add(sagittal));
    EXPECT_KEPT(run);
    ASSERT_EQ(run.kept().slices.size(), 3u);
    EXPECT_EQ(run.kept().slices[0].name, "z = 1.0");
    EXPECT_EQ(run.kept().slices[2].name, "x = 4.0");
}

TEST(Clean, RS15_exclusive_or_nested_and_crossing) {
    for (int depth = 1; depth <= 5; ++depth) {
        File file;
        double expected = 0;
        for (int k = 0; k < depth; ++k) {
            file.add(square(k, k, 20 - 2 * k), 0, ContourKind::closed_planar_xor);
            expected += (k % 2 ? -1 : 1) * (20.0 - 2 * k) * (20 - 2 * k);
        }
        const Cleaned run = clean(file);
        EXPECT_KEPT(run);
        EXPECT_EQ(run.area(), expected);
    }
    const Cleaned crossing = clean(File()
                                       .add(square(0, 0, 10), 0, ContourKind::closed_planar_xor)
                                       .add(square(5, 5, 10), 0, ContourKind::closed_planar_xor));
    EXPECT_KEPT(crossing);
    EXPECT_NEAR(crossing.area(), 150, 0.5);  // the two corners that would touch are moved apart
}

// An outer square with square holes joined to it by corridors of a width.
Points keyhole(double width, int holes) {
    Points points{{0, 0, 10}};
    for (int h = 0; h < holes; ++h) {
        const double x = 5 + 10 * h;
        points.insert(points.end(), {{x, 0, 10},
                                     {x, 3, 10},
                                     {x - 2, 3, 10},
                                     {x - 2, 7, 10},
                                     {x + 2 + width, 7, 10},
                                     {x + 2 + width, 3, 10},
                                     {x + width, 3, 10},
                                     {x + width, 0, 10}});
    }
    points.insert(points.end(), {{30, 0, 10}, {30, 20, 10}, {0, 20, 10}});
    return points;
}

TEST(Clean, RS16_keyholes_give_the_region_of_explicit_holes) {
    for (double width : {0.0, 1e-6, 0.01, 0.5}) {
        for (int holes : {1, 2}) {
            for (const bool backwards : {false, true}) {
                const Points points = keyhole(width, holes);
                const Cleaned run = clean(File().add(backwards ? reversed(points) : points));
                EXPECT_KEPT(run);
                const bool opened = width < 0.1;
                EXPECT_EQ(run.kept().contours.size(), opened ? 1u + holes : 1u);
                EXPECT_NEAR(run.area(), 600 - 16.0 * holes, 7.0 * width * holes + 1e-9);
                EXPECT_EQ(run.count("W-CON-013"), opened && width > 0 ? 1u : 0u);
                EXPECT_LE(run.result.value().stats.max_displacement_mm, 1.1 * width);
            }
        }
    }
}

// A square of 40 with a square hole of 8, and a corridor between them, crossing its own sides where the width
// is negative.
TEST(Clean, RS16_corridors_drawn_with_a_width_are_closed) {
    for (const double width : {-0.04, -0.01, 0.06, 0.1, 0.3, 0.5, 0.6, 1.2}) {
        for (int turn = 0; turn < 4; ++turn) {
            Points points{{-20, -20, 10}, {-width / 2, -20, 10}, {-width / 2, -4, 10},
                          {-4, -4, 10},   {-4, 4, 10},           {4, 4, 10},
                          {4, -4, 10},    {width / 2, -4, 10},   {width / 2, -20, 10},
                          {20, -20, 10},  {20, 20, 10},          {-20, 20, 10}};
            for (Vec3& p : points) {
                for (int n = 0; n < turn; ++n) p = {-p.y, p.x, p.z};
            }
            for (const bool backwards : {false, true}) {
                const Cleaned run =
                    clean(File().add(rotated(backwards ? reversed(points) : points, 3 * turn)));
                EXPECT_KEPT(run);
                const bool closed = width <= 0.5;
                EXPECT_EQ(run.kept().contours.size(), closed ? 2u : 1u) << width;
                EXPECT_EQ(run.count("W-CON-013"), closed ? 1u : 0u);
                EXPECT_NEAR(run.area(), 1600 - 64 - (closed ? 0 : 16 * width), 17 * std::abs(width));
            }
        }
    }
}

// Necks and clefts are no corridors to a hole, however narrow.
TEST(Clean, RS16_necks_and_clefts_stay) {
    const Points dumb_bell{{0, 0, 10},    {10, 0, 10},   {10, 4.8, 10}, {20, 4.8, 10},
                           {20, 0, 10},   {30, 0, 10},   {30, 10, 10},  {20, 10, 10},
                           {20, 5.2, 10}, {10, 5.2, 10}, {10, 10, 10},  {0, 10, 10}};
    const Points cleft{{0, 0, 10},    {9.8, 0, 10}, {9.8, 15, 10}, {10.2, 15, 10},
                       {10.2, 0, 10}, {20, 0, 10},  {20, 20, 10},  {0, 20, 10}};
    for (const Points& points : {dumb_bell, cleft}) {
        for (const bool backwards : {false, true}) {
            const Cleaned run = clean(File().add(backwards ? reversed(points) : points));
            EXPECT_KEPT(run);
            EXPECT_EQ(run.kept().contours.size(), 1u);
            EXPECT_EQ(run.kept().points.size(), points.size());
            EXPECT_EQ(run.count("W-CON-013"), 0u);
        }
    }
}

TEST(Clean, RS16_two_holes_by_one_keyhole) {
    // Out along x = 5, around the first hole half way, on to the second one, and all the way back.
    const Points points{{0, 0, 10}, {5, 0, 10}, {5, 2, 10},  {3, 2, 10},   {3, 6, 10},
                        {5, 6, 10}, {5, 8, 10}, {3, 8, 10},  {3, 12, 10},  {7, 12, 10},
                        {7, 8, 10}, {5, 8, 10}, {5, 6, 10},  {7, 6, 10},   {7, 2, 10},
                        {5, 2, 10}, {5, 0, 10}, {20, 0, 10}, {20, 20, 10}, {0, 20, 10}};
    const Cleaned run = clean(File().add(points));
    EXPECT_KEPT(run);
    EXPECT_EQ(run.kept().contours.size(), 3u);
    EXPECT_EQ(run.area(), 400 - 32);
    EXPECT_NE(run.result.value().log[0].rule.find("keyhole"), std::string::npos);
}

TEST(Clean, RS17_partial_overlaps_are_united) {
    const Cleaned run = clean(File().add(square(0, 0, 10)).add(square(5, 5, 10)));
    EXPECT_KEPT(run);
    ASSERT_EQ(run.kept().contours.size(), 1u);
    EXPECT_DOUBLE_EQ(run.area(), 175);
    ASSERT_EQ(run.count("W-CON-019"), 1u);
    EXPECT_EQ(run.warnings[0].place.value, "25 mm2");
    EXPECT_EQ(run.kept().points.size(), 8u);
}

TEST(Clean, RS29_C23_repeats_are_dropped) {
    File file;
    for (int k = 0; k < 10; ++k) file.add(rotated(circle(0, 0, 10, 30), 3 * k));
    const Cleaned run = clean(file);
    EXPECT_KEPT(run);
    EXPECT_EQ(run.kept().contours.size(), 1u);
    EXPECT_EQ(run.count("W-CON-011"), 9u);
    EXPECT_EQ(run.result.value().log[7].rule, "repeat of 0");
}

TEST(Clean, C23_plane_given_twice) {
    const auto twice = [](const Points& first, const Points& second) {
        File file;
        file.raw.planes = {make_plane({0, 0, 10}, {0, 0, 1}), make_plane({7, 7, 10.001}, {0, 0, -1})};
        return file.add(first, 0, ContourKind::closed_planar, 0)
            .add(second, 0, ContourKind::closed_planar, 1);
    };
    const Cleaned near_same = clean(twice(circle(0, 0, 10, 50, 10), circle(0.01, 0, 10, 49, 10.001)));
    EXPECT_KEPT(near_same);
    EXPECT_EQ(near_same.kept().contours.size(), 1u);
    EXPECT_EQ(near_same.count("W-CON-018"), 1u);
    const File contradiction = twice(circle(0, 0, 10, 50, 10), circle(5, 0, 10, 49, 10.001));
    EXPECT_EQ(clean(contradiction).code(), "E-CON-007");
    CleanOptions united;
    united.rings.unite_repeated_planes = true;
    const Cleaned run = clean(contradiction, united);
    EXPECT_KEPT(run);
    EXPECT_EQ(run.count("W-CON-019"), 1u);
    // One inside the other: a hole, or two drawings of one outline.
    const File nested = twice(circle(0, 0, 10, 50, 10), circle(0, 0, 5, 49, 10.001));
    const Cleaned question = clean(nested);
    ASSERT_EQ(question.code(), "E-CON-007");
    EXPECT_EQ(question.result.error().place.contour, "1");
    EXPECT_NE(question.result.error().message.find("lies inside contour 0 of the other drawing"),
              std::string::npos);
    const Cleaned whole = clean(nested, united);
    EXPECT_KEPT(whole);
    ASSERT_EQ(whole.kept().contours.size(), 1u);
    EXPECT_EQ(whole.kept().contours[0].point_count, 50u);
    EXPECT_EQ(whole.count("W-CON-022"), 1u);
    // Drawn on one plane, it is a hole like any other.
    const Cleaned hole = clean(File().add(circle(0, 0, 10, 50, 10)).add(circle(0, 0, 5, 49, 10)));
    EXPECT_KEPT(hole);
    EXPECT_EQ(hole.kept().contours.size(), 2u);
}

TEST(Clean, C23_the_union_of_rings_drawn_twice_keeps_what_is_a_hole_in_both) {
    // Radii on the first and second plane, and those that bound the union.
    const struct {
        std::vector<double> first, second, expected;
    } cases[] = {{{14, 5}, {10}, {14}},
                 {{14}, {10, 5}, {14}},
                 {{14, 5}, {10, 4}, {14, 4}},
                 {{14, 8}, {6}, {14, 8, 6}},
                 {{14, 4}, {13.9, 9}, {14, 4}},
                 {{14, 10}, {7, 5}, {14, 10, 7, 5}},
                 {{14, 10, 3}, {12, 6}, {14, 6, 3}}};
    CleanOptions united;
    united.rings.unite_repeated_planes = true;
    for (const auto& each : cases) {
        File file;
        file.raw.planes = {make_plane({0, 0, 10}, {0, 0, 1}), make_plane({0, 0, 10}, {0, 0, 1})};
        for (const double radius : each.first)
            file.add(circle(0, 0, radius, 60, 10), 0, ContourKind::closed_planar, 0);
        for (const double radius : each.second)
            file.add(circle(0, 0, radius, 60, 10), 0, ContourKind::closed_planar, 1);
        const Cleaned run = clean(file, united);
        EXPECT_KEPT(run);
        std::vector<double> radii;
        for (const Contour& contour : run.kept().contours) {
            const Vec3 p = run.kept().points_of(contour)[0];
            radii.push_back(std::round(10 * std::hypot(p.x, p.y)) / 10);
        }
        std::sort(radii.rbegin(), radii.rend());
        EXPECT_EQ(radii, each.expected);
    }
}

TEST(Clean, G30_a_stack_of_fine_slices_keeps_them_all) {
    for (const double spacing : {0.0099, 0.008, 0.004, 0.0001}) {
        for (const double radius : {10 * spacing, 100 * spacing}) {
            File file;
            for (int k = 0; k < 8; ++k)
                file.add(circle(0, 0, radius + 0.5 * spacing * k, 24, 5 + spacing * k));
            const Cleaned run = clean(file);
            EXPECT_KEPT(run);
            EXPECT_EQ(run.kept().slices.size(), 8u) << spacing;
            EXPECT_EQ(run.count("W-CON-010"), 0u);
        }
    }
}

TEST(Clean, RS30_contours_larger_than_a_patient_are_told_of) {
    for (const double scale : {1.0, 10.0, 100.0, 1e5}) {
        File file;
        for (int k = 0; k < 8; ++k) {
            Points points = circle(0, 0, 25, 40, 5.0 * k);
            for (Vec3& p : points) p = scale * p;
            file.add(points);
        }
        const Cleaned run = clean(file);
        EXPECT_EQ(run.code(), scale * 79 > 10000 ? "E-CON-013" : "") << scale;
        EXPECT_EQ(run.count("W-CON-035"), scale * 79 > 3000 && run.code().empty() ? 1u : 0u) << scale;
        file.raw.unit_is_given = true;
        EXPECT_EQ(clean(file).count("W-CON-035"), 0u) << "the user says that they are so large";
    }
}

// A digit too many in one of many numbers: the message names the point that has it.
TEST(Clean, RS30_a_vertex_metres_away_is_named) {
    std::mt19937 random(3);
    for (int member = 0; member < 50; ++member) {
        File file;
        for (int k = 0; k < 8; ++k) file.add(circle(0, 0, 25, 40, 5.0 * k));
        Vec3& wrong = file.raw.points[random() % file.raw.points.size()];
        (member % 2 ? wrong.x : wrong.y) = member % 3 ? 17000 : -17000;
        const Cleaned run = clean(file);
        ASSERT_EQ(run.code(), "E-CON-013");
        EXPECT_NE(run.result.error().place.value.find("17000"), std::string::npos)
            << run.result.error().place.value;
        EXPECT_FALSE(run.result.error().place.contour.empty());
    }
}

TEST(Clean, RS30_contours_in_metres_are_kept_whole_and_told_of) {
    File millimetres, metres;
    // A tilted stack, with one slice given twice.
    for (const double height : {0.0, 3.0, 6.0, 6.001, 9.0, 12.0}) {
        Points points = circle(0, 0, 20 + (height == 6.001 ? 0.0 : 0.1 * height), 40, 0);
        if (height == 6.001) points = circle(0, 0, 20.6, 39, 0);
        for (Vec3& p : points) p = {p.x, 0.8 * p.y - 0.6 * height, 0.6 * p.y + 0.8 * height};
        millimetres.add(points);
        for (Vec3& p : points) p = 0.001 * p;
        metres.add(points);
    }
    const Cleaned right = clean(millimetres), small = clean(metres);
    EXPECT_KEPT(right);
    EXPECT_KEPT(small);
    metres.raw.unit_is_given = true;
    EXPECT_EQ(clean(metres).count("W-CON-023"), 0u) << "the user says that they are so small";
    EXPECT_EQ(right.count("W-CON-023"), 0u);
    EXPECT_EQ(small.count("W-CON-023"), 1u);
    ASSERT_EQ(small.kept().slices.size(), right.kept().slices.size());
    EXPECT_EQ(small.kept().slices.size(), 5u);
    for (std::size_t s = 0; s < 5; ++s)
        EXPECT_LT(length(cross(small.kept().slices[s].plane.normal, Vec3{0, -0.6, 0.8})), 1e-6);
}

TEST(Clean, C23_the_warning_of_planes_made_one_names_them_and_what_became_of_contours) {
    File file;
    file.raw.planes = {make_plane({0, 0, 10}, {0, 0, 1}), make_plane({0, 0, 10.01}, {0, 0, 1})};
    file.raw.plane_names = {"slices[3]", "slices[4]"};
    file.add(circle(0, 0, 10, 50, 10), 0, ContourKind::closed_planar, 0)
        .add(circle(40, 0, 10, 49, 10.01), 0, ContourKind::closed_planar, 1);
    const Cleaned refused = clean(file);
    ASSERT_EQ(refused.count("W-CON-010"), 1u);
    const Warning& merged = refused.warning("W-CON-010");
    EXPECT_EQ(merged.message,
              "planes are so close to each other that they were read as one slice: slices[3] and slices[4]");
    EXPECT_EQ(merged.place.value, "0.01 mm");
    EXPECT_NE(merged.what_was_done.find("contradicting ones are refused"), std::string::npos);
    CleanOptions united;
    united.rings.unite_repeated_planes = true;
    EXPECT_NE(clean(file, united).warning("W-CON-010").what_was_done.find("contradicting ones are united"),
              std::string::npos);
}

TEST(Clean, C02_contours_without_area_are_dropped) {
    const Cleaned run = clean(File()
                                  .add(square(20, 0, 5))
                                  .add({{0, 0, 10}, {1, 1, 10}, {2, 2, 10}})
                                  .add({{0, 0, 10}, {5, 1, 10}, {9, 0, 10}, {5, 1, 10}})
                                  .add({{0, 0, 10}, {5, 1e-9, 10}, {10, 0, 10}}));
    EXPECT_KEPT(run);
    EXPECT_EQ(run.kept().contours.size(), 1u);
    EXPECT_EQ(run.count("W-CON-008"), 3u);
}

TEST(Clean, C03_spikes_and_hairs_go_and_nothing_else_moves) {
    const Points plain{{0, 0, 10}, {10, 0, 10}, {10, 10, 10}, {0, 10, 10}};
    const Cleaned expected = clean(File().add(plain));
    const Points spike{{0, 0, 10}, {10, 0, 10}, {20, -5, 10}, {10, 0, 10}, {10, 10, 10}, {0, 10, 10}};
    const Points beyond{{0, 0, 10}, {17, 0, 10}, {10, 0, 10}, {10, 10, 10}, {0, 10, 10}};
    for (const Points& points : {spike, rotated(spike, 2), rotated(spike, 3), beyond, rotated(beyond, 1)}) {
        const Cleaned run = clean(File().add(points));
        EXPECT_KEPT(run);
        EXPECT_TRUE(same(run.kept(), expected.kept()));
        EXPECT_EQ(run.count("W-CON-012"), 1u);
        EXPECT_EQ(run.result.value().stats.max_displacement_mm, 0);
    }
    const Cleaned hair = clean(File().add(
        {{0, 0, 10}, {10, 0, 10}, {10, 4, 10}, {15, 4, 10}, {10, 4 + 1e-9, 10}, {10, 10, 10}, {0, 10, 10}}));
    EXPECT_KEPT(hair);
    EXPECT_EQ(hair.kept().points.size(), 5u);
    EXPECT_LE(hair.result.value().stats.max_displacement_mm, 1.1e-9);
    EXPECT_EQ(hair.count("W-CON-013"), 1u);
}

TEST(Clean, C04_self_crossings_are_read_even_odd_below_the_bound) {
    CleanOptions any;
    any.rings.max_repair_area_share = 1;
    const Points bow_tie{{0, 0, 10}, {10, 10, 10}, {10, 0, 10}, {0, 10, 10}};
    EXPECT_EQ(clean(File().add(bow_tie)).code(), "E-CON-006");
    const Cleaned bow = clean(File().add(bow_tie), any);
    EXPECT_KEPT(bow);
    EXPECT_EQ(bow.kept().contours.size(), 2u);
    EXPECT_NEAR(bow.area(), 50, 0.5);
    Points star;
    for (int k = 0; k < 5; ++k) {
        star.push_back({10 * std::cos(0.8 * M_PI * k), 10 * std::sin(0.8 * M_PI * k), 10});
    }
    EXPECT_EQ(clean(File().add(star)).code(), "E-CON-006");
    const Cleaned points = clean(File().add(star), any);
    EXPECT_KEPT(points);
    EXPECT_EQ(points.kept().contours.size(), 5u);
    // A small loop where the pen crossed its own beginning.
    Points loop = circle(0, 0, 20, 60);
    loop.push_back({loop[0].x + 1.5, loop[0].y + 1, 10});
    loop.push_back({loop[0].x + 1.5, loop[0].y - 4.5, 10});
    const Cleaned small = clean(File().add(loop));
    EXPECT_KEPT(small);
    EXPECT_EQ(small.count("W-CON-014"), 1u);
    EXPECT_EQ(small.count("W-CON-030"), 0u);  // too large for a slip of the pen
    EXPECT_GT(small.result.value().log[0].area_change_mm2, 0);
}

TEST(Clean, C04_a_speck_that_crosses_itself_is_no_reason_to_refuse) {
    const Points bow_tie{{0, 0, 10}, {1e-4, 1e-4, 10}, {1e-4, 0, 10}, {0, 1e-4, 10}};
    const Cleaned run = clean(File().add(circle(20, 0, 5, 40)).add(bow_tie));
    EXPECT_KEPT(run);
    EXPECT_EQ(run.kept().contours.size(), 1u);
    EXPECT_EQ(run.count("W-CON-008"), 1u);
    const Points small{{0, 0, 10}, {0.1, 0, 10}, {0.1, 0.1, 10}, {0, 0.1, 10}};
    EXPECT_EQ(clean(File().add(small).add(circle(20, 0, 5, 40))).kept().contours.size(), 2u);
}

TEST(Clean, C04_random_scribbles_never_break_the_invariants) {
    CleanOptions any;
    any.rings.max_repair_area_share = 1;
    std::mt19937 random(7);
    int refused = 0;
    for (int trial = 0; trial < 60; ++trial) {
        // On a coarse lattice, so that vertices meet, edges overlap and run through vertices.
        std::uniform_int_distribution<int> coordinate(0, trial % 3 == 0 ? 1000000 : 12);
        File file;
        for (int c = 0; c < 3; ++c) {
            Points points;
            for (int i = 0; i < (trial < 50 ? 15 : 150); ++i) {
                points.push_back({coordinate(random) * 1e-3 + 0.1, coordinate(random) * 1e-3, 10});
            }
            for (Vec3& p : points) p = {p.x * 1000, p.y * 1000, 10};
            file.add(points);
        }
        file.raw.unit_is_given = true;  // a third of them span a kilometre
        const Cleaned run = clean(file, any);
        if (run.ok()) {
            EXPECT_KEPT(run);
        } else {
            EXPECT_EQ(run.code(), "E-CON-009") << to_line(run.result.error());
            ++refused;
        }
    }
    EXPECT_EQ(refused, 0);
}

TEST(Clean, C05_contour_touching_itself_is_split) {
    const Points pinch{{0, 0, 10}, {5, 5, 10}, {10, 0, 10}, {10, 10, 10}, {5, 5, 10}, {0, 10, 10}};
    const Cleaned run = clean(File().add(pinch));
    EXPECT_KEPT(run);
    EXPECT_EQ(run.kept().contours.size(), 2u);
    EXPECT_EQ(run.count("W-CON-015"), 1u);
    EXPECT_EQ(run.count("W-CON-020"), 1u);
    EXPECT_LE(run.result.value().stats.max_displacement_mm, CleanOptions().rings.separation_mm);
    const Points along_edge{{0, 0, 10}, {10, 0, 10}, {10, 4, 10}, {6, 4, 10}, {6, 2, 10},
                            {4, 2, 10}, {4, 4, 10},  {8, 4, 10},  {8, 9, 10}, {0, 9, 10}};
    const Cleaned edge = clean(File().add(along_edge));
    EXPECT_KEPT(edge);
}

TEST(Clean, C06_near_touches_stay_as_drawn) {
    for (double gap : {1e-12, 1e-6}) {
        const Points points{{0, 0, 10}, {5, 5 - gap, 10}, {10, 0, 10}, {10, 10, 10}, {5, 5, 10}, {0, 10, 10}};
        const Cleaned run = clean(File().add(points).add(square(50, 0, 1), 1));
        EXPECT_KEPT(run);
        EXPECT_TRUE(run.warnings.empty());
        EXPECT_EQ(run.kept().points.size(), 10u);
    }
}

TEST(Clean, C07_nested_holes) {
    for (int depth = 1; depth <= 10; ++depth) {
        File file;
        double expected = 0;
        for (int k = 0; k < depth; ++k) {
            file.add(square(k, k, 30 - 2 * k));
            expected += (k % 2 ? -1 : 1) * (30.0 - 2 * k) * (30 - 2 * k);
        }
        const Cleaned run = clean(file);
        EXPECT_KEPT(run);
        EXPECT_EQ(run.area(), expected);
    }
}

TEST(Clean, C08_hole_touching_its_outer) {
    // At a vertex on an edge, at a common vertex, along an edge.
    const Points on_edge{{5, 0, 10}, {7, 4, 10}, {3, 4, 10}};
    const Points at_corner{{0, 0, 10}, {4, 2, 10}, {2, 4, 10}};
    for (const Points& hole : {on_edge, at_corner}) {
        const Cleaned run = clean(File().add(square(0, 0, 10)).add(hole));
        EXPECT_KEPT(run);
        EXPECT_EQ(run.kept().contours.size(), 2u);
        EXPECT_NEAR(run.area(), hole == on_edge ? 92 : 94, 0.2);
        EXPECT_EQ(run.count("W-CON-020"), 1u);
    }
    const Cleaned notch = clean(File().add(square(0, 0, 10)).add(square(4, 0, 2)));
    EXPECT_KEPT(notch);
    EXPECT_EQ(notch.kept().contours.size(), 1u);
    EXPECT_EQ(notch.area(), 96);
    EXPECT_EQ(notch.count("W-CON-016"), 2u);
}

TEST(Clean, C09_contour_beside_another_is_a_part_of_its_own) {
    const Cleaned run = clean(File().add(square(0, 0, 10)).add(square(20, 0, 5)));
    EXPECT_KEPT(run);
    EXPECT_EQ(run.area(), 125);
}

TEST(Clean, C09_what_the_file_calls_a_hole_lies_in_an_outline) {
    File in, out, same, near, across;
    for (File* file : {&in, &out, &same, &near, &across}) file->add(circle(0, 0, 10, 40));
    in.add(circle(2, 0, 4, 20));
    out.add(circle(30, 0, 4, 20));
    same.add(circle(0, 0, 10, 40));
    near.add(circle(0, 0, 9.97, 40));
    across.add(circle(9, 0, 4, 20));
    const auto told = [](File& file) {
        file.raw.contours[1].is_hole = true;
        return clean(file);
    };
    EXPECT_EQ(told(in).count("W-CON-033"), 0u);
    for (File* file : {&out, &across}) {
        const Cleaned plain = clean(*file), run = told(*file);
        ASSERT_TRUE(run.ok());
        EXPECT_EQ(plain.count("W-CON-033"), 0u);
        EXPECT_EQ(run.count("W-CON-033"), 1u);
        EXPECT_EQ(run.area(), plain.area());  // part of the structure
    }
    for (File* file : {&same, &near}) {
        EXPECT_TRUE(clean(*file).ok());  // drawn twice
        const Cleaned run = told(*file);
        EXPECT_EQ(run.code(), "E-CON-012");
        EXPECT_FALSE(run.result.error().next_step.empty());
    }
}

// The wall of a ring whose plane is given twice: its hole is near the other drawing's outline.
TEST(Clean, C09_holes_on_a_plane_given_twice_are_not_its_outlines) {
    File file;
    file.raw.planes = {make_plane({0, 0, 10}, {0, 0, 1}), make_plane({0, 0, 10}, {0, 0, 1})};
    for (const std::int32_t plane : {0, 1}) {
        file.add(circle(0.1 * plane, 0, 20, 60), 0, ContourKind::closed_planar, plane);
        file.add(circle(0.1 * plane, 0, 19.6, 60), 0, ContourKind::closed_planar, plane);
        file.raw.contours.back().is_hole = true;
    }
    EXPECT_NE(clean(file).code(), "E-CON-012");
}

TEST(Clean, C10_structures_that_share_a_wall_or_cross_stay_as_they_are) {
    for (double x : {10.0, 5.0, 0.0}) {
        const Cleaned run = clean(File().add(square(0, 0, 10)).add(square(x, 0, 10), 1));
        EXPECT_KEPT(run);
        EXPECT_TRUE(run.warnings.empty());
        EXPECT_EQ(run.area(0, 0), 100);
        EXPECT_EQ(run.area(0, 1), 100);
        EXPECT_EQ(run.kept().points.size(), 8u);
    }
}

TEST(Clean, C13_C14_C15_any_number_and_spacing_of_points) {
    Points uneven = square(0, 0, 10);
    uneven.insert(uneven.begin() + 1, {1e-6, 0, 10});
    Points stairs{{0, 0, 10}};
    for (int k = 0; k < 50; ++k) {
        stairs.push_back({k + 1.0, 1.0 * k, 10});
        stairs.push_back({k + 1.0, k + 1.0, 10});
    }
    stairs.push_back({0, 50, 10});
    CleanOptions all;
    all.crowded_mm = 0;  // crowded points: see crowded_points_test.cpp
    for (const Points& points : {Points{{0, 0, 10}, {1, 0, 10}, {0, 1, 10}}, square(0, 0, 1), uneven, stairs,
                                 circle(0, 0, 50, 100000)}) {
        const Cleaned run = clean(File().add(points).add(square(500, 0, 1), 1), all);
        EXPECT_KEPT(run);
        EXPECT_TRUE(run.warnings.empty());
        EXPECT_EQ(run.kept().points.size(), points.size() + 4);
    }
}

TEST(Clean, cancelled_run_says_so) {
    File file;
    file.add(square(0, 0, 1));
    std::atomic<bool> cancel = true;
    RunContext context;
    context.cancel = &cancel;
    EXPECT_EQ(clean_contours(file.raw, {}, context).error().code, "E-RUN-001");
}

}  // namespace
}  // namespace anatomesh::clean_test
