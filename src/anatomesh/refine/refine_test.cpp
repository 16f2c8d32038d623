#include "anatomesh/refine/refine.h"

#include <random>

#include "anatomesh/cull/culled_mesh_for_test.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh::refine_test {
namespace {

using namespace fixtures;

constexpr double size = 1;
const ProtectedSegments no_segments(size, 0);

std::vector<Vec3> refinement(const CulledMesh& mesh, const StructureField& field, RefineStats& stats,
                             int threads = 1) {
    RunContext context;
    context.threads = threads;
    std::vector<Vec3> found;
    std::vector<std::uint32_t> look = mesh.all_cells();
    stats = find_refinement_points(mesh.view(field), {mesh.grid, no_segments}, {}, look, found, context);
    return found;
}

// A ball with random points instead of a lattice: many bad cells.
CulledMesh random_ball(const StructureField& field, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<Vec3> points;
    for (int n = 0; n < 400; ++n) {
        const Vec3 direction = normalized({normal(random), normal(random), normal(random)});
        points.push_back((n % 2 ? 5.0 : 5.0 * std::cbrt(share(random))) * direction);
    }
    // A layer outside, so that no cell at the ball reaches far.
    for (int n = 0; n < 400; ++n) {
        points.push_back((6 + 2 * share(random)) *
                         normalized({normal(random), normal(random), normal(random)}));
    }
    return culled_mesh_of(std::move(points), field, size);
}

TEST(Refine, repeated_rounds_end_with_the_ratio_below_the_bound) {
    const AnalyticField field({ball({}, 5)}, 6);
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        CulledMesh mesh = random_ball(field, seed);
        RefineStats first, stats;
        std::vector<Vec3> found = refinement(mesh, field, first);
        EXPECT_GT(first.above_bound, 20u);
        const double volume = mesh.volume(0);
        stats = first;
        int round = 0;
        for (; round < 60 && !found.empty(); ++round) {
            mesh.delaunay.insert(found);
            mesh.update(field, 1, {0.02});
            found = refinement(mesh, field, stats);
        }
        EXPECT_LT(round, 60);
        EXPECT_LE(stats.above_bound * 200, mesh.cells.cells.size());
        EXPECT_LT(stats.radius_edge_mean, first.radius_edge_mean);
        EXPECT_NEAR(mesh.volume(0), volume, 0.15 * volume);
    }
}

TEST(Refine, the_counts_are_those_of_the_cells) {
    const AnalyticField field({ball({}, 5)}, 6);
    const CulledMesh mesh = random_ball(field, 4);
    RefineStats stats;
    const std::vector<Vec3> found = refinement(mesh, field, stats);
    std::uint64_t above = 0;
    for (std::size_t c = 0; c < mesh.regions.size(); ++c) {
        const Cell& cell = mesh.cells.cells[c];
        const Vec3 a = mesh.points()[cell[0]], b = mesh.points()[cell[1]], d = mesh.points()[cell[2]],
                   e = mesh.points()[cell[3]];
        above += mesh.regions[c] != 0 && radius_edge_ratio(a, b, d, e) > 2;
    }
    EXPECT_LE(stats.above_bound, above);
    EXPECT_GE(stats.above_bound + stats.flat, above);
    EXPECT_EQ(found.size(), stats.circumcenters + stats.surface_points);
}

TEST(Refine, points_found_are_inside_or_near_the_interface) {
    const AnalyticField field({ball({}, 5)}, 6);
    RefineStats stats;
    for (const Vec3& p : refinement(random_ball(field, 5), field, stats)) EXPECT_LT(length(p), 9);
}

TEST(Refine, same_points_for_any_number_of_threads) {
    const AnalyticField field({ball({}, 5)}, 6);
    const CulledMesh mesh = random_ball(field, 6);
    RefineStats stats;
    const std::vector<Vec3> one = refinement(mesh, field, stats);
    EXPECT_GT(one.size(), 10u);
    for (const int threads : {2, 4}) EXPECT_EQ(refinement(mesh, field, stats, threads), one);
}

// What the searches leave out need not be looked at: they find the same as when they look at everything.
TEST(Refine, a_second_look_goes_to_what_is_bad_or_has_changed) {
    const AnalyticField field({ball({}, 5)}, 6);
    CulledMesh mesh = random_ball(field, 9);
    RunContext context;
    const auto search = [&](int kind, std::vector<std::uint32_t>& look) {
        std::vector<Vec3> found;
        if (kind == 0) {
            find_refinement_points(mesh.view(field), {mesh.grid, no_segments}, {}, look, found, context);
        } else if (kind == 1) {
            find_crossing_points(mesh.view(field), {mesh.grid, no_segments}, {}, look, found, context);
        } else {
            find_deviation_points(mesh.view(field), {mesh.grid, no_segments}, {}, look, found, context);
        }
        return found;
    };
    std::array<std::vector<std::uint32_t>, 3> again{mesh.all_cells(), mesh.all_cells(), mesh.all_cells()};
    for (int round = 0; round < 6; ++round) {
        std::vector<Vec3> all;
        for (int kind = 0; kind < 3; ++kind) {
            std::vector<std::uint32_t> everything = mesh.all_cells(), look = again[kind];
            EXPECT_TRUE(std::is_sorted(look.begin(), look.end()));
            const std::vector<Vec3> found = search(kind, look);
            EXPECT_EQ(found, search(kind, everything));
            EXPECT_EQ(look, everything);
            if (round > 0) {
                EXPECT_LT(again[kind].size(), mesh.cells.cells.size());
            }
            again[kind] = look;
            all.insert(all.end(), found.begin(), found.end());
        }
        mesh.delaunay.insert(
            std::vector<Vec3>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2)));
        mesh.update(field, 1, {0.02});
        for (auto& look : again) {
            look.insert(look.end(), mesh.cells.changed.begin(), mesh.cells.changed.end());
            std::sort(look.begin(), look.end());
            look.erase(std::unique(look.begin(), look.end()), look.end());
            std::erase_if(look, [&](std::uint32_t c) { return c >= mesh.cells.cells.size(); });
        }
    }
}

TEST(Refine, crossing_points_lie_on_the_interface_and_apart) {
    const AnalyticField field({ball({}, 5)}, 6);
    // A coarse lattice that knows nothing of the ball.
    std::vector<Vec3> points;
    for (double x = -9; x < 10; x += 3) {
        for (double y = -9; y < 10; y += 3) {
            for (double z = -9; z < 10; z += 3) points.push_back({x + 0.1 * y, y + 0.1 * z, z});
        }
    }
    CulledMesh mesh{Tetrahedralization::create(points).value(), {}, {}, {}, {}, {}, PointGrid(size, 1000)};
    mesh.update(field, 1, {0.02});
    RunContext context;
    std::uint64_t first = 0, last = 0;
    for (int round = 0; round < 4; ++round) {
        std::vector<Vec3> found;
        std::vector<std::uint32_t> look = mesh.all_cells();
        const CrossingStats stats =
            find_crossing_points(mesh.view(field), {mesh.grid, no_segments}, {}, look, found, context);
        if (round == 0) {
            first = stats.crossing_edges;
            EXPECT_GT(found.size(), 20u);
        }
        last = stats.crossing_edges;
        for (std::size_t n = 0; n < found.size(); ++n) {
            EXPECT_NEAR(length(found[n]), 5, 0.01);
            for (std::size_t m = 0; m < n; ++m) EXPECT_GT(length(found[n] - found[m]), 0.1);
        }
        mesh.delaunay.insert(found);
        mesh.update(field, 1, {0.02});
    }
    EXPECT_LT(2 * last, first);
}

TEST(Refine, deviation_points_bring_the_surface_to_the_interface) {
    const AnalyticField field({ball({}, 5)}, 6);
    CulledMesh mesh = random_ball(field, 7);
    RunContext context;
    DeviationOptions options;
    options.max_deviation_mm = 0.1;
    std::uint64_t first = 0, last = 0;
    for (int round = 0; round < 8; ++round) {
        std::vector<Vec3> found;
        std::vector<std::uint32_t> look = mesh.all_cells();
        const DeviationStats stats = find_deviation_points(
            mesh.view(field), {mesh.grid, ProtectedSegments(size, 0)}, options, look, found, context);
        if (round == 0) first = stats.deviating;
        last = stats.deviating;
        for (const Vec3& p : found) EXPECT_NEAR(length(p), 5, 0.01);
        if (found.empty()) break;
        mesh.delaunay.insert(found);
        mesh.update(field, 1, {0.02});
    }
    EXPECT_GT(first, 50u);
    EXPECT_LT(last * 4, first);
    EXPECT_NEAR(mesh.volume(0), 4 / 3.0 * 3.14159265 * 125, 0.03 * 523);
}

TEST(Refine, deviation_points_stay_out_of_the_balls_of_contour_segments) {
    const AnalyticField field({ball({}, 5)}, 6);
    const CulledMesh mesh = random_ball(field, 8);
    ProtectedSegments protected_segments(size, 10);
    protected_segments.add_segment({-6, 0, 0}, {6, 0, 0});
    RunContext context;
    for (const double share : {1.0, 0.9}) {  // the surface lies at 5 / 6 of the ball's radius
        DeviationOptions options;
        options.protected_share = share;
        std::vector<Vec3> found;
        std::vector<std::uint32_t> look = mesh.all_cells();
        const DeviationStats stats = find_deviation_points(mesh.view(field), {mesh.grid, protected_segments},
                                                           options, look, found, context);
        EXPECT_TRUE(found.empty());
        EXPECT_GT(stats.deviating, 0u);
        EXPECT_EQ(stats.refused, stats.deviating);
    }
}

// A pocket of the outside in a half ball's flat side: its ceiling is a facet in that plane, whose own middle
// has its nearest interface at the pocket's rim, where vertices are.
TEST(Refine, deviation_points_open_a_pocket_whose_facets_lie_in_its_rims_plane) {
    const AnalyticField field({[](Vec3 p) {
                                  const double pocket = std::min(3 - std::hypot(p.x, p.y), 2 - p.z);
                                  return std::max({length(p) - 9, -p.z, pocket});
                              }},
                              10);
    std::vector<Vec3> points;
    for (int k = 0; k < 12; ++k) {
        const double t = k * 3.14159265358979 / 6;
        points.push_back({3 * std::cos(t), 3 * std::sin(t), 0});
        points.push_back({6 * std::cos(t), 6 * std::sin(t), 0});
    }
    for (const double z : {-6.0, 6.0}) {
        for (int k = 0; k < 6; ++k) points.push_back({5 * std::cos(k + 0.1), 5 * std::sin(k + 0.1), z});
        points.push_back({0, 0, z});
    }
    for (int n = 0; n < 8; ++n)
        points.push_back({n & 1 ? 30.0 : -30.0, n & 2 ? 31.0 : -32.0, n & 4 ? 33.0 : -30.0});
    CulledMesh mesh{Tetrahedralization::create(points).value(), {}, {}, {}, {}, {}, PointGrid(size, 1000)};
    mesh.update(field, 1, {0.02});
    RunContext context;
    std::vector<Vec3> found;
    std::vector<std::uint32_t> look = mesh.all_cells();
    find_deviation_points(mesh.view(field), {mesh.grid, ProtectedSegments(size, 0)}, {}, look, found,
                          context);
    EXPECT_TRUE(std::any_of(found.begin(), found.end(),
                            [](Vec3 p) { return std::hypot(p.x, p.y) < 2.9 && p.z > 0.5; }));
}

}  // namespace
}  // namespace anatomesh::refine_test
