// One set of points has one set of cells: CGAL's, whatever the order of the points, the batches and the
// threads.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>

#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh::same_cells_test {
namespace {

using Geometry = CGAL::Exact_predicates_inexact_constructions_kernel;
using Structure =
    CGAL::Triangulation_data_structure_3<CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Geometry>,
                                         CGAL::Delaunay_triangulation_cell_base_3<Geometry>>;
using Oracle = CGAL::Delaunay_triangulation_3<Geometry, Structure>;

// Tests that take minutes run with a million points and more when this is set.
bool thorough() {
    return std::getenv("ANATOMESH_THOROUGH") != nullptr;
}

// Each cell's vertices in order, the cells in order.
std::vector<Cell> sorted(std::vector<Cell> cells) {
    for (Cell& cell : cells) std::sort(cell.begin(), cell.end());
    std::sort(cells.begin(), cells.end());
    return cells;
}

std::vector<Cell> cells_by_cgal(const std::vector<Vec3>& points) {
    std::vector<std::pair<Geometry::Point_3, std::uint32_t>> given;
    for (std::uint32_t n = 0; n < points.size(); ++n)
        given.push_back({{points[n].x, points[n].y, points[n].z}, n});
    const Oracle oracle(given.begin(), given.end());
    std::vector<Cell> cells;
    for (const auto cell : oracle.finite_cell_handles()) {
        cells.push_back({cell->vertex(0)->info(), cell->vertex(1)->info(), cell->vertex(2)->info(),
                         cell->vertex(3)->info()});
    }
    return sorted(cells);
}

DelaunaySnapshot snapshot_of(const std::vector<Vec3>& points, int threads = 1) {
    auto made = Tetrahedralization::create(points, threads);
    EXPECT_TRUE(made.ok()) << to_line(made.error());
    return made.value().snapshot();
}

std::vector<Cell> cells_of(const std::vector<Vec3>& points) {
    return sorted(snapshot_of(points).cells);
}

std::vector<Vec3> without_equal(std::vector<Vec3> points, std::uint32_t seed) {
    std::sort(points.begin(), points.end(), LexicographicLess{});
    points.erase(std::unique(points.begin(), points.end()), points.end());
    std::shuffle(points.begin(), points.end(), std::mt19937(seed));
    return points;
}

std::vector<Vec3> cube(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(0, 200);
    std::vector<Vec3> points(count);
    for (Vec3& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
    return points;
}

// Clusters around clusters, the smallest a million millionth of the largest.
std::vector<Vec3> clusters(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_int_distribution<int> order(-12, 0);
    const std::vector<Vec3> middles = cube(5, seed + 1);
    std::vector<Vec3> points(count);
    for (Vec3& p : points) {
        p = middles[random() % 5] +
            std::pow(10.0, order(random)) * Vec3{normal(random), normal(random), normal(random)};
    }
    return without_equal(points, seed);
}

std::vector<Vec3> lattice(int n, bool centred) {
    std::vector<Vec3> points;
    for (int k = 0; k < n; ++k) {
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i < n; ++i) {
                points.push_back({0.7 * i, 0.7 * j, 3.0 * k});
                if (centred) points.push_back({0.7 * (i + 0.5), 0.7 * (j + 0.5), 3.0 * (k + 0.5)});
            }
        }
    }
    return without_equal(points, 1);
}

// Whole coordinates at one distance from the middle: exactly on a sphere.
std::vector<Vec3> sphere() {
    std::vector<Vec3> points;
    for (int i = -33; i <= 33; ++i) {
        for (int j = -33; j <= 33; ++j) {
            for (int k = -33; k <= 33; ++k) {
                if (i * i + j * j + k * k == 1001) points.push_back({double(i), double(j), double(k)});
            }
        }
    }
    return without_equal(points, 2);
}

// Contours of pixel corners on few parallel planes: many points on one line, circle, plane, sphere.
std::vector<Vec3> pixel_contours(int planes, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> jitter(0, 1);
    std::vector<Vec3> points;
    for (int k = 0; k < planes; ++k) {
        for (int n = 0; n < 400; ++n) {
            const double angle = 2 * std::numbers::pi * n / 400, radius = 60 + 8 * std::cos(5 * angle + k);
            points.push_back({0.4785 * (std::floor(radius * std::cos(angle)) + jitter(random)),
                              0.4785 * std::floor(radius * std::sin(angle)), 3.0 * k});
        }
    }
    return without_equal(points, seed);
}

// A plane full of points, of a grid and at random, and one apart.
std::vector<Vec3> plane_and_point() {
    std::vector<Vec3> points = lattice(15, false);
    for (Vec3& p : points) p.z = 0;
    for (Vec3 p : cube(500, 3)) points.push_back({0.05 * p.x, 0.05 * p.y, 0});
    points.push_back({5, 5, 9});
    return without_equal(points, 3);
}

std::vector<Vec3> scaled(std::vector<Vec3> points, double factor) {
    for (Vec3& p : points) p = factor * p;
    return points;
}

const std::vector<std::pair<const char*, std::function<std::vector<Vec3>()>>> families{
    {"cube", [] { return cube(20000, 1); }},
    {"few", [] { return cube(12, 2); }},
    {"clusters", [] { return clusters(6000, 4); }},
    {"lattice", [] { return lattice(12, false); }},
    {"centred lattice", [] { return lattice(9, true); }},
    {"sphere", sphere},
    {"two planes", [] { return pixel_contours(2, 5); }},
    {"five planes", [] { return pixel_contours(5, 6); }},
    {"forty planes", [] { return pixel_contours(40, 7); }},
    {"plane and point", plane_and_point},
    {"tiny", [] { return scaled(lattice(6, true), 0x1p-170); }},
    {"huge", [] { return scaled(lattice(6, true), 0x1p210); }},
};

TEST(SameCells, M13_as_cgal_cell_for_cell) {
    for (const auto& [name, make] : families) {
        const std::string family = name;
        if (family == "tiny" || family == "huge") continue;  // CGAL's range is smaller
        const std::vector<Vec3> points = make();
        EXPECT_TRUE(cells_of(points) == cells_by_cgal(points)) << name;
    }
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        const std::vector<Vec3> points = cube(5 + seed % 40, 100 + seed);
        ASSERT_TRUE(cells_of(points) == cells_by_cgal(points)) << seed;
    }
}

// What scaling by powers of two keeps exactly, the cells keep: where products leave the range of doubles as
// well.
TEST(SameCells, M04_at_any_scale) {
    const std::vector<Vec3> points = lattice(6, true), random = cube(150, 8);
    for (const int exponent : {-1000, -500, -250, -170, -100, 100, 210, 300, 600, 1000}) {
        const double factor = std::ldexp(1.0, exponent);
        EXPECT_TRUE(cells_of(scaled(points, factor)) == cells_of(points)) << exponent;
        if (exponent > -900) {
            EXPECT_TRUE(snapshot_of(scaled(random, factor)).cells == snapshot_of(random).cells) << exponent;
        }
    }
}

TEST(SameCells, M13_in_any_order) {
    for (const auto& [name, make] : families) {
        const std::vector<Vec3> points = make();
        const std::vector<Cell> expected = cells_of(points);
        for (std::uint32_t seed = 1; seed <= 3; ++seed) {
            std::vector<std::uint32_t> order(points.size());
            std::iota(order.begin(), order.end(), 0u);
            std::shuffle(order.begin(), order.end(), std::mt19937(seed));
            std::vector<Vec3> shuffled;
            for (const std::uint32_t n : order) shuffled.push_back(points[n]);
            std::vector<Cell> cells = snapshot_of(shuffled).cells;
            for (Cell& cell : cells) {
                for (std::uint32_t& v : cell) v = order[v];
            }
            ASSERT_TRUE(sorted(cells) == expected) << name;
        }
    }
}

TEST(SameCells, M13_in_any_batches) {
    for (const auto& [name, make] : families) {
        const std::vector<Vec3> points = make();
        const std::vector<Cell> expected = cells_of(points);
        std::mt19937 random(9);
        std::size_t done = points.size() / 2;
        auto delaunay = Tetrahedralization::create(std::span(points).first(done));
        if (!delaunay.ok()) continue;  // a flat half
        DelaunaySnapshot snapshot;
        while (done < points.size()) {
            const std::size_t count = std::min(points.size() - done, 1 + random() % (points.size() / 5 + 1));
            // Points that are there already change nothing.
            std::vector<Vec3> batch(points.begin() + done, points.begin() + done + count);
            batch.push_back(points[random() % done]);
            delaunay.value().insert(batch);
            done += count;
            snapshot = delaunay.value().snapshot();
        }
        ASSERT_EQ(delaunay.value().points(), points) << name;
        ASSERT_TRUE(sorted(snapshot.cells) == expected) << name;
    }
}

void expect_same_bytes_for_threads(const std::vector<Vec3>& points, std::size_t first, const char* name) {
    DelaunaySnapshot expected;
    for (const int threads : {1, 2, 4, 7}) {
        auto delaunay = Tetrahedralization::create(std::span(points).first(first), threads);
        ASSERT_TRUE(delaunay.ok()) << name;
        delaunay.value().snapshot(threads);
        delaunay.value().insert(std::span(points).subspan(first), threads);
        const DelaunaySnapshot& snapshot = delaunay.value().snapshot(threads);
        if (threads == 1) {
            expected = snapshot;
        } else {
            ASSERT_TRUE(snapshot.cells == expected.cells) << name << ", " << threads << " threads";
            ASSERT_TRUE(snapshot.neighbors == expected.neighbors) << name << ", " << threads << " threads";
            ASSERT_TRUE(snapshot.changed == expected.changed) << name << ", " << threads << " threads";
        }
    }
}

TEST(SameCells, M13_same_bytes_for_any_number_of_threads) {
    std::vector<Vec3> repeated = cube(15000, 11);
    for (std::size_t n = 0; n < 15000; n += 2) repeated.push_back(repeated[n]);
    std::shuffle(repeated.begin(), repeated.end(), std::mt19937(12));
    const std::vector<std::pair<const char*, std::vector<Vec3>>> sets{
        {"cube", cube(thorough() ? 1000000 : 40000, 10)},
        {"equal points", repeated},
        {"clusters", clusters(20000, 13)},
        {"lattice", lattice(20, true)},
        {"planes", pixel_contours(40, 14)}};
    for (const auto& [name, points] : sets) {
        ASSERT_GT(points.size(), 5000u) << name;  // the last 300 come into a fine mesh
        for (const std::size_t first : {points.size() / 3, points.size() - 300, points.size()})
            expect_same_bytes_for_threads(points, first, name);
    }
}

// Adjacency and the empty spheres, at the price of one test a facet.
TEST(SameCells, many_points_are_delaunay) {
    const std::vector<Vec3> points = cube(thorough() ? 1000000 : 60000, 15);
    const DelaunaySnapshot mesh = snapshot_of(points, 2);
    std::size_t outside = 0;
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& cell = mesh.cells[c];
        ASSERT_EQ(orient3d(points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]), 1);
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t n = mesh.neighbors[c][i];
            if (n == no_cell) {
                ++outside;
                continue;
            }
            const auto& back = mesh.neighbors[n];
            const auto at = std::find(back.begin(), back.end(), c) - back.begin();
            ASSERT_LT(at, 4);
            const std::uint32_t apex = mesh.cells[n][at];
            ASSERT_EQ(std::count(cell.begin(), cell.end(), apex), 0);
            int shared = 0;
            for (const std::uint32_t v : mesh.cells[n])
                shared += std::count(cell.begin(), cell.end(), v) > 0 && v != cell[i];
            ASSERT_EQ(shared, 3);
            ASSERT_LT(in_perturbed_sphere(points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]],
                                          points[apex]),
                      0);
        }
    }
    EXPECT_GT(outside, 100u);
    EXPECT_LT(outside, mesh.cells.size() / 50);
}

TEST(SameCells, coordinates_that_are_not_finite_are_refused) {
    for (const double bad : {std::nan(""), double(INFINITY), -double(INFINITY)}) {
        std::vector<Vec3> points = cube(20, 16);
        points[7].y = bad;
        const auto made = Tetrahedralization::create(points);
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, "E-DEL-002");
        EXPECT_NE(made.error().message.find("point 7"), std::string::npos);
    }
}

}  // namespace
}  // namespace anatomesh::same_cells_test
