#include "anatomesh/sample/sample_points.h"

#include <gtest/gtest.h>

#include <set>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/sample/analytic_field_for_test.h"
#include "anatomesh/sample/drawing_for_test.h"
#include "anatomesh/sample/interface_probe.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"

namespace anatomesh::sample_points_test {
namespace {

using namespace fixtures;

ContourSet ball_with_a_long_bar() {
    Drawing drawing;
    drawing.add_ball(0, {}, 6, 1, 0.9);
    for (int z = 0; z < 3; ++z) drawing.add(0, z - 0.5, rectangle({9, -2}, {19, 2}));
    return kept(drawing.raw);
}

struct Case {
    ContourSet set;
    SliceArrangement arrangement;
    std::shared_ptr<const StructureField> field;
};

Case case_of(ContourSet set) {
    RunContext context;
    auto field = make_structure_field(set, {}, context);
    EXPECT_TRUE(field.ok());
    SliceArrangement arrangement = arrangement_of(set);
    return {std::move(set), std::move(arrangement), field.value()};
}

PointSample sample_of(const Case& given, double size, int threads = 1, double growth = 0.5) {
    RunContext context;
    context.threads = threads;
    SampleOptions options;
    options.size_mm = size;
    options.growth = growth;
    auto sample = sample_points(given.set, given.arrangement, *given.field, options, context);
    EXPECT_TRUE(sample.ok());
    return std::move(sample).value();
}

TEST(SamplePoints, contour_vertices_come_first_at_their_exact_coordinates) {
    const Case given = case_of(ball_with_a_long_bar());
    const PointSample sample = sample_of(given, 1);
    ASSERT_EQ(sample.contour_vertices.size(), given.set.points.size());
    std::uint32_t next = 0;
    for (std::size_t n = 0; n < given.set.points.size(); ++n) {
        ASSERT_LE(sample.contour_vertices[n], next);
        next += sample.contour_vertices[n] == next;
        EXPECT_EQ(sample.points[sample.contour_vertices[n]], given.set.points[n]);
    }
    EXPECT_EQ(sample.stats.contour_points, next);
}

TEST(SamplePoints, a_vertex_shared_by_two_structures_is_one_point) {
    Drawing drawing;
    for (int z = 0; z < 3; ++z) {
        drawing.add(0, z, rectangle({0, 0}, {4, 4}));
        drawing.add(1, z, rectangle({4, 0}, {8, 4}));
    }
    const Case given = case_of(kept(drawing.raw, true));
    const PointSample sample = sample_of(given, 1);
    EXPECT_EQ(given.set.points.size(), 24u);
    EXPECT_EQ(sample.stats.contour_points, 18u);
}

TEST(SamplePoints, contours_that_cross_share_the_point_however_near_to_a_vertex) {
    // Squares whose corners reach over each other by a share of the size.
    for (const double reach : {0.05, 0.1, 0.19, 0.3, 0.7}) {
        Drawing drawing;
        for (int z = 0; z < 3; ++z) {
            drawing.add(0, z, rectangle({0, 0}, {4, 4}));
            drawing.add(1, z, rectangle({4 - reach, 4 - reach}, {8, 8}));
        }
        const Case given = case_of(kept(drawing.raw));
        const PointSample sample = sample_of(given, 1);
        for (int z = 0; z < 3; ++z) {
            for (const Vec2 p : {Vec2{4, 4 - reach}, Vec2{4 - reach, 4}}) {
                const Vec3 at{p.x, p.y, static_cast<double>(z)};
                EXPECT_TRUE(std::any_of(sample.points.begin(), sample.points.end(),
                                        [&](Vec3 q) { return length(q - at) < 1e-9; }))
                    << reach << ' ' << z;
            }
        }
    }
}

TEST(SamplePoints, the_counts_add_up) {
    const PointSample sample = sample_of(case_of(ball_with_a_long_bar()), 1);
    const SampleStats& stats = sample.stats;
    EXPECT_EQ(stats.contour_points + stats.segment_points + stats.surface_points + stats.lattice_points +
                  stats.frame_points,
              sample.points.size());
    EXPECT_GT(stats.segment_points, 0u);
    EXPECT_GT(stats.surface_points, 0u);
    EXPECT_GT(stats.lattice_points, 0u);
    EXPECT_EQ(stats.frame_points, 8u);
}

// Segment points by the order of the sample; free points keep off contour points, segments and each other.
TEST(SamplePoints, free_points_keep_their_distances) {
    const Case given = case_of(ball_with_a_long_bar());
    for (const double size : {0.7, 1.0, 1.6}) {
        const PointSample sample = sample_of(given, size);
        // Thin walls may have points 8 times as close.
        const double local = sample.stats.thin_spots > 0 ? size / 8 : size;
        const std::size_t first_surface = sample.stats.contour_points + sample.stats.segment_points;
        const std::size_t first_lattice = first_surface + sample.stats.surface_points;
        const std::size_t end = sample.points.size() - 8;
        for (std::size_t n = first_surface; n < end; ++n) {
            const Vec3 p = sample.points[n];
            for (std::size_t c = 0; c < first_surface; ++c)
                ASSERT_GE(length(sample.points[c] - p), 0.5 * local);
            for (std::size_t s = first_surface; s < std::min(n, first_lattice); ++s) {
                ASSERT_GE(length(sample.points[s] - p),
                          (n < first_lattice ? 0.6 : 0.5) * local * (1 - 1e-12));
            }
        }
    }
}

TEST(SamplePoints, no_free_point_lies_in_the_diametral_ball_of_a_subsegment_of_a_segment) {
    const Case given = case_of(ball_with_a_long_bar());
    const double size = 1;
    const PointSample sample = sample_of(given, size);
    const std::size_t fixed = sample.stats.contour_points + sample.stats.segment_points;
    // The subsegments: every segment cut at the sample's points that lie on it.
    for (const Contour& contour : given.set.contours) {
        const auto points = given.set.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n) {
            const Vec3 a = points[n], b = points[(n + 1) % points.size()];
            std::vector<double> cuts{0, 1};
            for (std::size_t s = sample.stats.contour_points; s < fixed; ++s) {
                const double t = dot(sample.points[s] - a, b - a) / squared_length(b - a);
                if (t > 0 && t < 1 && length(a + t * (b - a) - sample.points[s]) < 1e-9) cuts.push_back(t);
            }
            std::sort(cuts.begin(), cuts.end());
            for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
                const Vec3 p = a + cuts[k] * (b - a), q = a + cuts[k + 1] * (b - a);
                EXPECT_LE(length(q - p), 1.2 * size * (1 + 1e-9));
                for (std::size_t s = fixed; s < sample.points.size(); ++s) {
                    ASSERT_GT(dot(sample.points[s] - p, sample.points[s] - q), -1e-9);
                }
            }
        }
    }
}

TEST(SamplePoints, surface_points_lie_on_the_surface) {
    const Case given = case_of(ball_with_a_long_bar());
    const PointSample sample = sample_of(given, 1);
    const std::size_t first = sample.stats.contour_points + sample.stats.segment_points;
    for (std::size_t n = first; n < first + sample.stats.surface_points; ++n) {
        EXPECT_LT(given.field->interface_distance(sample.points[n]), 0.02);
    }
}

TEST(SamplePoints, same_points_for_any_number_of_threads) {
    const Case given = case_of(ball_with_a_long_bar());
    const PointSample one = sample_of(given, 0.8, 1);
    for (const int threads : {2, 5}) EXPECT_EQ(sample_of(given, 0.8, threads).points, one.points);
}

TEST(SamplePoints, depth_makes_the_lattice_coarser) {
    Drawing drawing;
    drawing.add_ball(0, {}, 12, 1, 1);
    const Case given = case_of(kept(drawing.raw));
    const PointSample even = sample_of(given, 1, 1, 0), graded = sample_of(given, 1, 1, 1);
    EXPECT_LT(1.25 * static_cast<double>(graded.stats.lattice_points),
              static_cast<double>(even.stats.lattice_points));
    EXPECT_EQ(graded.stats.surface_points, even.stats.surface_points);
}

TEST(SamplePoints, the_default_size_is_about_the_side_of_a_square_a_contour_vertex) {
    const auto with_corners = [](double corner_spacing) {
        Drawing drawing;
        for (int z = 0; z < 4; ++z)
            drawing.add(0, 2 * z, divided(rectangle({0, 0}, {20, 20}), corner_spacing));
        return case_of(kept(drawing.raw));
    };
    const Case given = with_corners(4);
    EXPECT_NEAR(default_size(given.set, given.arrangement, *given.field), 1.05 * std::sqrt(8), 1e-12);
    EXPECT_EQ(sample_of(given, 0).stats.size_mm, default_size(given.set, given.arrangement, *given.field));
    // Bounded by the slice spacing.
    const Case sparse = with_corners(20), dense = with_corners(0.1);
    EXPECT_NEAR(default_size(sparse.set, sparse.arrangement, *sparse.field), 4, 1e-12);
    EXPECT_NEAR(default_size(dense.set, dense.arrangement, *dense.field), 1, 1e-12);
}

// Plates of several thicknesses, slices 2 mm apart, corners far apart.
TEST(SamplePoints, the_default_size_goes_twice_into_the_mean_thickness_or_is_a_spacing) {
    for (const double thickness : {1.0, 3.0, 5.0, 6.5, 40.0}) {
        Drawing drawing;
        for (int z = 0; z < 4; ++z) drawing.add(0, 2 * z, rectangle({0, 0}, {1000, thickness}));
        const Case given = case_of(kept(drawing.raw));
        const double mean = mean_thickness(given.set)[0];
        EXPECT_NEAR(default_size(given.set, given.arrangement, *given.field),
                    std::min({4.0, mean, std::max(2.0, 0.49 * mean)}), 1e-12)
            << thickness;
    }
}

TEST(SamplePoints, planes_that_cross_close_to_each_other_do_not_make_the_size_small) {
    // Planes turned a little against each other, vertices 2 mm apart.
    const auto with_planes = [](int count) {
        Drawing drawing;
        for (int k = 0; k < count; ++k) {
            const double at = -6 + 12.0 * k / (count - 1), turn = 0.02 * (k % 3 - 1);
            const Vec3 u{1, 0, turn}, v{0, 1, -turn}, origin{0, 0, at};
            RawContour contour;
            contour.first_point = static_cast<std::uint32_t>(drawing.raw.points.size());
            for (const Vec2 p : divided(rectangle({-10, -10}, {10, 10}), 2))
                drawing.raw.points.push_back(origin + p.x * u + p.y * v);
            contour.point_count = static_cast<std::uint32_t>(drawing.raw.points.size()) - contour.first_point;
            drawing.raw.contours.push_back(contour);
        }
        drawing.raw.structures.push_back({1, "block", {}});
        return case_of(kept(drawing.raw));
    };
    double size = 0;
    for (const int count : {7, 13, 25, 49}) {
        const Case given = with_planes(count);
        size = default_size(given.set, given.arrangement, *given.field);
        EXPECT_GT(size, 0.7 * 2) << count;
        EXPECT_LT(size, 1.35 * 2) << count;
    }
    EXPECT_GT(size, 1.2 * 2);
}

// Two structures 0.8 mm apart, on planes that lean a little from each to the next, or are parallel.
TEST(SamplePoints, contours_side_by_side_are_split_alike_on_parallel_planes_and_on_others_that_do_not_cross) {
    const auto segment_points = [](double turn, bool apart) {
        Drawing drawing;
        for (int k = 0; k < 6; ++k) {
            const Vec3 u{1, 0, turn * k}, v{0, 1, -turn * k}, origin{0, 0, 4.0 * k};
            for (std::uint32_t structure = 0; structure < 2; ++structure) {
                RawContour contour;
                contour.structure = structure;
                contour.first_point = static_cast<std::uint32_t>(drawing.raw.points.size());
                const std::vector<Vec2> ring = structure == 0 ? divided(rectangle({-10, -10}, {0, 10}), 5)
                                                              : divided(rectangle({0.8, -9}, {10, 9}), 4);
                for (const Vec2 p : ring) drawing.raw.points.push_back(origin + p.x * u + p.y * v);
                contour.point_count =
                    static_cast<std::uint32_t>(drawing.raw.points.size()) - contour.first_point;
                drawing.raw.contours.push_back(contour);
            }
        }
        drawing.raw.structures = {{1, "one", {}}, {2, "other", {}}};
        Case given = case_of(kept(drawing.raw));
        EXPECT_EQ(given.arrangement.is_parallel(), turn == 0);
        EXPECT_TRUE(given.arrangement.is_stack());
        if (turn != 0 && !apart) given.arrangement.kind = ArrangementKind::general;
        SampleOptions options;
        options.size_mm = 3;
        RunContext context;
        auto sample = sample_points(given.set, given.arrangement, *given.field, options, context);
        EXPECT_TRUE(sample.ok());
        EXPECT_EQ(sample.value().graded, turn == 0 || apart);
        return static_cast<double>(sample.value().stats.segment_points);
    };
    const double parallel = segment_points(0, false), leaning = segment_points(0.01, true),
                 as_if_they_crossed = segment_points(0.01, false);
    EXPECT_NEAR(leaning, parallel, 0.1 * parallel);
    EXPECT_GT(leaning, 1.5 * as_if_they_crossed);
}

TEST(SamplePoints, a_size_beyond_the_reach_of_the_fields_distances_fills_the_inside) {
    Drawing drawing;
    drawing.add_ball(0, {}, 8, 0.2, 1);
    const Case given = case_of(kept(drawing.raw));
    ASSERT_LT(given.field->clamp(), 0.45);
    EXPECT_GT(sample_of(given, 1, 1, 0).stats.lattice_points, 1.5 * 4.19 * 6.5 * 6.5 * 6.5);
}

TEST(SamplePoints, M09_a_size_that_needs_too_many_points_is_refused_at_once) {
    const Case given = case_of(ball_with_a_long_bar());
    RunContext context;
    for (const double size : {0.01, 1e-4, 1e-9}) {
        SampleOptions options;
        options.size_mm = size;
        options.max_points = 1'000'000;
        const auto sample = sample_points(given.set, given.arrangement, *given.field, options, context);
        ASSERT_FALSE(sample.ok()) << size;
        EXPECT_EQ(sample.error().code, "E-SMP-001");
        EXPECT_EQ(sample.error().kind, ErrorKind::limit);
    }
}

TEST(InterfaceProbe, projects_onto_the_nearest_interface) {
    const AnalyticField field({ball({}, 5)}, 6);
    InterfaceProbe probe(field, 1);
    for (const Vec3 p : {Vec3{4.2, 0, 0}, Vec3{3, 3, 3}, Vec3{0, -3, 4.5}}) {
        const auto q = probe.project(p, 2, 1e-4);
        ASSERT_TRUE(q);
        EXPECT_NEAR(length(*q), 5, 2e-4);
        EXPECT_LT(length(*q - (5 / length(p)) * p), 0.05);
    }
    EXPECT_FALSE(probe.project({2, 0, 0}, 1, 1e-4));
}

TEST(InterfaceProbe, finds_the_first_crossing_only) {
    const AnalyticField field({shell({}, 6, 4)}, 8);
    InterfaceProbe probe(field, 1);
    const auto out = probe.first_crossing({0, 0, 0}, {9, 0, 0}, 0.5, 1e-5);
    ASSERT_TRUE(out);
    EXPECT_NEAR(out->x, 4, 1e-4);
    const auto in = probe.first_crossing({9, 0, 0}, {0, 0, 0}, 0.5, 1e-5);
    ASSERT_TRUE(in);
    EXPECT_NEAR(in->x, 6, 1e-4);
    EXPECT_FALSE(probe.first_crossing({0, 0, 0}, {3, 0, 0}, 0.5, 1e-5));
}

TEST(InterfaceProbe, finds_the_wall_between_two_structures) {
    const AnalyticField field({ball({-3, 0, 0}, 4), ball({3, 0, 0}, 4)}, 8, true);
    InterfaceProbe probe(field, 2);
    const auto wall = probe.first_crossing({-3, 0.5, 0}, {3, 0.5, 0}, 0.5, 1e-5);
    ASSERT_TRUE(wall);
    EXPECT_NEAR(wall->x, 0, 1e-4);
    const auto projected = probe.project({-0.8, 0.5, 0}, 2, 1e-4);
    ASSERT_TRUE(projected);
    EXPECT_NEAR(projected->x, 0, 2e-4);
}

}  // namespace
}  // namespace anatomesh::sample_points_test
