#include "anatomesh/refine/missing_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::missing_segments_test {
namespace {

using namespace fixtures;

TEST(MissingSubsegments, only_what_changed_is_looked_at_with_the_same_result) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-10, 10);
    const auto anywhere = [&] { return Vec3{place(random), place(random), place(random)}; };
    std::vector<Vec3> first;
    for (int n = 0; n < 3000; ++n) first.push_back(anywhere());
    Tetrahedralization delaunay = Tetrahedralization::create(first).value();
    std::vector<Subsegment> subsegments;
    for (std::uint32_t n = 0; n < 600; ++n) {
        // Short ones are edges more often than long ones.
        const std::uint32_t a = n;
        std::uint32_t nearest = a + 1;
        for (std::uint32_t b = 0; b < 3000; ++b) {
            const double far = length(delaunay.points()[b] - delaunay.points()[a]);
            if (b != a && (n % 3 != 0 || far > 3) &&
                far < length(delaunay.points()[nearest] - delaunay.points()[a]))
                nearest = b;
        }
        subsegments.push_back({a, nearest, n % 2, n});
    }
    MissingSubsegments search;
    SidesOfSubsegments sides_search;
    const RegionTable table{{{}, {0}, {1}}};
    std::vector<Region> regions;
    std::size_t on_surface = 0;
    std::uint32_t balls = 600;
    std::vector<std::uint32_t> look;
    for (int round = 0; round < 12; ++round) {
        const DelaunaySnapshot& mesh = delaunay.snapshot();
        if (round == 0) {
            for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) look.push_back(c);
        } else {
            look = mesh.changed;
            ASSERT_LT(4 * look.size(), mesh.cells.size()) << "the short way must be tried";
        }
        const std::vector<std::uint32_t> missing =
            search.find(mesh, delaunay.points().size(), subsegments, look, 1 + round % 3);
        ASSERT_EQ(missing, missing_subsegments(mesh.cells, delaunay.points().size(), subsegments))
            << "round " << round;
        ASSERT_GT(missing.size(), 0u);
        regions.resize(mesh.cells.size());
        for (const std::uint32_t c : look) regions[c] = static_cast<Region>(random() % 3);
        const std::vector<SubsegmentSides> sides = sides_search.find(
            mesh, regions, table, delaunay.points().size(), subsegments, look, 1 + round % 3);
        const std::vector<SubsegmentSides> anew =
            subsegment_sides(mesh.cells, regions, table, delaunay.points().size(), subsegments);
        for (std::size_t n = 0; n < subsegments.size(); ++n) {
            ASSERT_EQ(sides[n].inside, anew[n].inside) << "round " << round << ", piece " << n;
            ASSERT_EQ(sides[n].outside, anew[n].outside) << "round " << round << ", piece " << n;
            on_surface += sides[n].inside && sides[n].outside;
        }
        // Some of them are split, and a few points come elsewhere; one middle is a vertex that is there already.
        std::vector<Vec3> found;
        for (std::size_t n = 0; n < std::min<std::size_t>(10, missing.size()); ++n) {
            const Subsegment& subsegment = subsegments[missing[n]];
            found.push_back(0.5 * (delaunay.points()[subsegment.a] + delaunay.points()[subsegment.b]));
        }
        if (round == 5) found[0] = delaunay.points()[17];
        const std::size_t middles = found.size();
        for (int n = 0; n < 20; ++n) found.push_back(anywhere());
        const std::vector<std::uint32_t> vertices = delaunay.insert(found);
        for (std::size_t n = 0; n < middles; ++n) {
            Subsegment& subsegment = subsegments[missing[n]];
            const std::uint32_t end = subsegment.b;
            subsegment = {subsegment.a, vertices[n], subsegment.structure, balls++};
            subsegments.push_back({vertices[n], end, subsegment.structure, balls++});
        }
    }
    EXPECT_GT(on_surface, 1000u);
}

TEST(SubsegmentSides, say_on_which_sides_of_its_structure_a_subsegment_has_cells) {
    // Two cells share the facet (1, 2, 3); the first is in structure 0, the second in none.
    const std::vector<Cell> cells{{0, 1, 2, 3}, {1, 2, 3, 4}};
    const RegionTable table{{{}, {0}}};
    const std::vector<Subsegment> subsegments{
        {1, 2, 0, 0}, {0, 1, 0, 1}, {3, 4, 0, 2}, {0, 4, 0, 3}, {2, 1, 1, 4}};
    const std::vector<SubsegmentSides> sides = subsegment_sides(cells, {1, 0}, table, 5, subsegments);
    const std::vector<std::array<int, 2>> expected{{1, 1}, {1, 0}, {0, 1}, {0, 0}, {0, 1}};
    for (std::size_t n = 0; n < subsegments.size(); ++n) {
        EXPECT_EQ(sides[n].inside, expected[n][0]) << n;
        EXPECT_EQ(sides[n].outside, expected[n][1]) << n;
    }
}

TEST(SidePoints, lie_on_the_side_that_has_no_cell) {
    const AnalyticField field({ball({}, 5)}, 6);
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::vector<Vec3> points;
    std::vector<Subsegment> subsegments;
    std::vector<SubsegmentSides> sides;
    for (std::uint32_t n = 0; n < 60; ++n) {
        const Vec3 a = 5.0 * normalized({normal(random), normal(random), normal(random)});
        const Vec3 b = 5.0 * normalized(a + 0.5 * Vec3{normal(random), normal(random), normal(random)});
        points.push_back(a);
        points.push_back(b);
        subsegments.push_back({2 * n, 2 * n + 1, 0, n});
        sides.push_back(n % 3 == 0   ? SubsegmentSides{1, 1}
                        : n % 3 == 1 ? SubsegmentSides{1, 0}
                                     : SubsegmentSides{0, 1});
    }
    PointGrid grid(1, points.size());
    for (const Vec3& p : points) grid.add(p);
    RunContext context;
    std::vector<Vec3> found;
    find_side_points(points, subsegments, sides, field, grid, {}, found, context);
    EXPECT_GE(found.size(), 30u) << "of 40 asked for";
    std::size_t inside = 0;
    for (const Vec3& p : found) {
        inside += length(p) < 5;
        EXPECT_FALSE(grid.any_within(p, 1e-3));
    }
    EXPECT_GT(inside, 10u);
    EXPECT_GT(found.size() - inside, 10u);
    std::vector<Vec3> again;
    context.threads = 2;
    find_side_points(points, subsegments, sides, field, grid, {}, again, context);
    EXPECT_EQ(found, again);
}

}  // namespace
}  // namespace anatomesh::missing_segments_test
