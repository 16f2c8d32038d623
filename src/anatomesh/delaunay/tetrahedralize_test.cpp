// Laws of the Delaunay tetrahedralization, checked exactly on families of points that break inexact code.
#include "anatomesh/delaunay/tetrahedralize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <set>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh::tetrahedralize_test {
namespace {

Tetrahedralization made_of(const std::vector<Vec3>& points) {
    auto made = Tetrahedralization::create(points);
    EXPECT_TRUE(made.ok()) << to_line(made.error());
    return std::move(made).value();
}

DelaunaySnapshot cells_of(Tetrahedralization& delaunay) {
    return delaunay.snapshot();
}

double volume_of(const std::vector<Vec3>& points, const DelaunaySnapshot& mesh) {
    double sum = 0;
    for (const Cell& c : mesh.cells)
        sum += signed_volume(points[c[0]], points[c[1]], points[c[2]], points[c[3]]);
    return sum;
}

// Positive cells, symmetric neighbours that share their facet, every point used.
void expect_sound(const std::vector<Vec3>& points, const DelaunaySnapshot& mesh) {
    ASSERT_EQ(mesh.neighbors.size(), mesh.cells.size());
    std::vector<std::uint8_t> used(points.size(), 0);
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& cell = mesh.cells[c];
        ASSERT_EQ(orient3d(points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]), 1);
        for (int i = 0; i < 4; ++i) {
            used[cell[i]] = 1;
            const std::uint32_t n = mesh.neighbors[c][i];
            if (n == no_cell) continue;
            const auto back = std::find(mesh.neighbors[n].begin(), mesh.neighbors[n].end(), c);
            ASSERT_NE(back, mesh.neighbors[n].end());
            std::set<std::uint32_t> here(cell.begin(), cell.end()),
                there(mesh.cells[n].begin(), mesh.cells[n].end());
            here.erase(cell[i]);
            there.erase(mesh.cells[n][back - mesh.neighbors[n].begin()]);
            ASSERT_EQ(here, there);
        }
    }
    EXPECT_EQ(std::count(used.begin(), used.end(), 1), static_cast<std::ptrdiff_t>(points.size()));
}

// Locally Delaunay at every facet and convex outside: then Delaunay (Delaunay's lemma), at the price of one
// test a facet.
void expect_delaunay(const std::vector<Vec3>& points, const DelaunaySnapshot& mesh) {
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& cell = mesh.cells[c];
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t n = mesh.neighbors[c][i];
            if (n == no_cell || n < c) continue;
            for (const std::uint32_t v : mesh.cells[n]) {
                if (std::find(cell.begin(), cell.end(), v) != cell.end()) continue;
                ASSERT_LE(
                    in_sphere(points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]], points[v]),
                    0);
            }
        }
    }
}

// The law itself: no point in any cell's sphere, and none beyond a facet of the hull.
void expect_empty_spheres(const std::vector<Vec3>& points, const DelaunaySnapshot& mesh) {
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& cell = mesh.cells[c];
        for (const Vec3& p : points) {
            ASSERT_LE(in_sphere(points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]], p), 0);
        }
        for (int i = 0; i < 4; ++i) {
            if (mesh.neighbors[c][i] != no_cell) continue;
            const auto& f = facet_vertices[i];
            for (const Vec3& p : points) {
                ASSERT_LE(orient3d(points[cell[f[0]]], points[cell[f[1]]], points[cell[f[2]]], p), 0);
            }
        }
    }
}

// All laws for these points, which are distinct; the volume of their hull when it is known.
void expect_laws(const std::vector<Vec3>& points, double hull_volume = 0) {
    Tetrahedralization delaunay = made_of(points);
    ASSERT_EQ(delaunay.points(), points);
    const DelaunaySnapshot mesh = cells_of(delaunay);
    expect_sound(points, mesh);
    expect_delaunay(points, mesh);
    if (points.size() <= 400) expect_empty_spheres(points, mesh);
    if (hull_volume > 0) {
        EXPECT_NEAR(volume_of(points, mesh), hull_volume, 1e-12 * hull_volume);
    }
}

std::vector<Vec3> random_points(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-1, 1);
    std::vector<Vec3> points;
    for (std::size_t n = 0; n < count; ++n)
        points.push_back({coordinate(random), coordinate(random), coordinate(random)});
    return points;
}

std::vector<Vec3> grid(int n, const std::function<Vec3(int, int, int)>& place) {
    std::vector<Vec3> points;
    for (int k = 0; k < n; ++k) {
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i < n; ++i) points.push_back(place(i, j, k));
        }
    }
    return points;
}

Vec3 whole(int i, int j, int k) {
    return {double(i), double(j), double(k)};
}

TEST(Tetrahedralize, random_points) {
    for (const std::size_t count : {4, 5, 10, 50, 300}) {
        for (std::uint32_t seed = 1; seed <= 5; ++seed) expect_laws(random_points(count, seed));
    }
    expect_laws(random_points(20000, 9));
}

TEST(Tetrahedralize, M01_points_that_span_no_volume_are_refused) {
    const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0}, d{1, 1, 0};
    std::vector<Vec3> line, equal(100, Vec3{3, 4, 5}), plane = random_points(500, 1);
    for (int n = 0; n < 100; ++n) line.push_back({1.0 * n, 2.0 * n, 3.0 * n});
    for (Vec3& p : plane) p.z = 7;
    for (const std::vector<Vec3>& points : {std::vector<Vec3>{},
                                            {a},
                                            {a, b},
                                            {a, b, c},
                                            {a, b, c, d},
                                            {a, b, c, c, b, a},
                                            line,
                                            equal,
                                            plane}) {
        const auto made = Tetrahedralization::create(points);
        ASSERT_FALSE(made.ok()) << points.size() << " points";
        EXPECT_EQ(made.error().code, "E-DEL-001");
        EXPECT_EQ(made.error().kind, ErrorKind::geometry);
    }
}

TEST(Tetrahedralize, M02_regular_grids_fill_their_cube) {
    for (int n = 2; n <= 10; ++n) expect_laws(grid(n, whole), std::pow(n - 1, 3));
    expect_laws(grid(20, whole), 6859);
}

TEST(Tetrahedralize, M02_body_centred_grids) {
    for (int n = 2; n <= 8; ++n) {
        std::vector<Vec3> points = grid(n, whole);
        for (const Vec3& p : grid(n - 1, whole)) points.push_back(p + Vec3{0.5, 0.5, 0.5});
        expect_laws(points, std::pow(n - 1, 3));
    }
}

TEST(Tetrahedralize, M02_hexagonal_grids) {
    const double height = std::sqrt(3) / 2;
    for (int n = 2; n <= 8; ++n) {
        expect_laws(grid(n, [&](int i, int j, int k) {
            return Vec3{i + 0.5 * (j % 2), height * j, 0.8 * k};
        }));
    }
}

// Rounded to doubles the points lie on the sphere but for the last place.
TEST(Tetrahedralize, M03_points_on_one_sphere) {
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    std::vector<Vec3> points;
    for (int n = 0; n < 10000; ++n)
        points.push_back(10.0 * normalized({normal(random), normal(random), normal(random)}));
    expect_laws(points);
    // Exactly on one sphere: all points with whole coordinates at the same distance, and the centre.
    std::vector<Vec3> exact{{0, 0, 0}};
    for (int i = -33; i <= 33; ++i) {
        for (int j = -33; j <= 33; ++j) {
            for (int k = -33; k <= 33; ++k) {
                if (i * i + j * j + k * k == 1001) exact.push_back(whole(i, j, k));
            }
        }
    }
    EXPECT_GT(exact.size(), 300u);
    expect_laws(exact);
}

TEST(Tetrahedralize, M03_one_plane_and_one_point) {
    std::vector<Vec3> points = random_points(3000, 5);
    for (Vec3& p : points) p.z = 0;
    points.push_back({0.1, 0.2, 1});
    expect_laws(points);
    std::vector<Vec3> lattice;
    for (int i = 0; i < 30; ++i) {
        for (int j = 0; j < 30; ++j) lattice.push_back(whole(i, j, 0));
    }
    lattice.push_back({14, 14, 9});
    expect_laws(lattice, 29 * 29 * 9 / 3.0);
}

TEST(Tetrahedralize, M03_two_parallel_circles) {
    for (const int corners : {3, 4, 6, 64, 500}) {
        std::vector<Vec3> points;
        for (const double z : {0.0, 2.0}) {
            for (int n = 0; n < corners; ++n) {
                const double angle = 2 * std::numbers::pi * n / corners;
                points.push_back({5 * std::cos(angle), 5 * std::sin(angle), z});
            }
        }
        expect_laws(points);
    }
}

TEST(Tetrahedralize, M05_equal_points_share_a_vertex) {
    const std::vector<Vec3> distinct = random_points(200, 6);
    std::vector<Vec3> points;
    std::vector<std::uint32_t> expected;
    std::mt19937 random(7);
    for (std::uint32_t n = 0; n < distinct.size(); ++n) {
        points.push_back(distinct[n]);
        expected.push_back(n);
        for (int repeat = random() % 4; repeat > 0; --repeat) {
            const std::uint32_t again = random() % (n + 1);
            points.push_back(distinct[again]);
            expected.push_back(again);
        }
    }
    Tetrahedralization delaunay = made_of(points);
    EXPECT_EQ(delaunay.points(), distinct);
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), delaunay.first_vertices().begin(),
                           delaunay.first_vertices().end()));
    expect_empty_spheres(distinct, cells_of(delaunay));
    EXPECT_EQ(delaunay.insert(points), expected);
}

TEST(Tetrahedralize, M05_points_1e_15_apart) {
    std::vector<Vec3> points;
    std::mt19937 random(8);
    for (const Vec3& p : random_points(60, 9)) {
        points.push_back(p);
        points.push_back(p + Vec3{1e-15, 0, 0});
        points.push_back(p + Vec3{0, -1e-15, 1e-15});
    }
    std::sort(points.begin(), points.end(), [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); });
    points.erase(std::unique(points.begin(), points.end()), points.end());
    std::shuffle(points.begin(), points.end(), random);
    EXPECT_GT(points.size(), 150u);
    expect_laws(points);
}

TEST(Tetrahedralize, M13_same_points_same_cells) {
    for (const std::vector<Vec3>& points : {grid(9, whole), random_points(3000, 10)}) {
        Tetrahedralization one = made_of(points), two = made_of(points);
        const DelaunaySnapshot a = cells_of(one), b = cells_of(two);
        EXPECT_EQ(a.cells, b.cells);
        EXPECT_EQ(a.neighbors, b.neighbors);
    }
}

// A cell keeps its place, and what was computed for it there, exactly as long as it is the same cell.
TEST(Tetrahedralize, cells_that_did_not_change_are_the_same_cells) {
    for (const bool regular : {false, true}) {
        Tetrahedralization delaunay = made_of(regular ? grid(6, whole) : random_points(200, 11));
        DelaunaySnapshot mesh = cells_of(delaunay);
        EXPECT_EQ(mesh.changed.size(), mesh.cells.size());
        for (std::uint32_t round = 0; round < 8; ++round) {
            const DelaunaySnapshot before = mesh;
            std::vector<Vec3> added = random_points(round == 3 ? 0 : 20, 20 + round);
            // Inside, outside and far outside the hull.
            for (Vec3& p : added) p = (round % 3 == 0 ? 1.0 : round % 3 == 1 ? 3.0 : 50.0) * p;
            delaunay.insert(added);
            mesh = cells_of(delaunay);
            const std::vector<Vec3>& points = delaunay.points();
            expect_sound(points, mesh);
            expect_delaunay(points, mesh);
            std::set<std::set<std::uint32_t>> known;
            for (const Cell& cell : before.cells) known.emplace(cell.begin(), cell.end());
            EXPECT_TRUE(std::is_sorted(mesh.changed.begin(), mesh.changed.end()));
            std::vector<std::uint8_t> changed(mesh.cells.size(), 0);
            for (const std::uint32_t c : mesh.changed) changed[c] = 1;
            std::size_t kept = 0;
            for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
                if (changed[c]) {
                    ASSERT_EQ(known.count({mesh.cells[c].begin(), mesh.cells[c].end()}), 0u);
                } else {
                    ASSERT_EQ(mesh.cells[c], before.cells[c]);
                    ++kept;
                }
            }
            if (added.empty()) {
                EXPECT_EQ(kept, before.cells.size());
            } else {
                EXPECT_LT(kept, mesh.cells.size());
            }
        }
    }
}

// Two rings that link have a cell for each pair of their edges; a point in the middle takes most of them away.
TEST(Tetrahedralize, fewer_cells_than_before_leave_no_holes) {
    std::vector<Vec3> points;
    constexpr int count = 24;
    for (int n = 0; n < count; ++n) {
        const double share = (n + 0.5) / count - 0.5;
        points.push_back({share, 1, 0.01 * share * share});
        points.push_back({0.01 * share * share, -1, share});
    }
    Tetrahedralization delaunay = made_of(points);
    const DelaunaySnapshot before = cells_of(delaunay);
    EXPECT_GT(before.cells.size(), static_cast<std::size_t>(count * count / 2));
    delaunay.insert(std::vector<Vec3>{{0.01, 0, 0.02}});
    const DelaunaySnapshot after = cells_of(delaunay);
    ASSERT_LT(after.cells.size(), before.cells.size());
    expect_sound(delaunay.points(), after);
    expect_delaunay(delaunay.points(), after);
    std::vector<std::uint8_t> changed(after.cells.size(), 0);
    for (const std::uint32_t c : after.changed) changed[c] = 1;
    for (std::size_t c = 0; c < after.cells.size(); ++c) {
        if (!changed[c]) {
            EXPECT_EQ(after.cells[c], before.cells[c]);
        }
    }
}

}  // namespace
}  // namespace anatomesh::tetrahedralize_test
