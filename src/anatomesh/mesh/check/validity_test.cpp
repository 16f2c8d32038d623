#include "anatomesh/mesh/check/validity.h"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <random>

#include "anatomesh/mesh/check/triangles_meet.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::validity_test {
namespace {

using testing::brick_mesh;
using testing::rounded_mesh;

Region everywhere(int, int, int) {
    return 1;
}

// Adds a copy of `more`, scaled about the origin and moved.
void append(TetMesh& mesh, const TetMesh& more, double scale, Vec3 move) {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (const Vec3& p : more.points) mesh.points.push_back(scale * p + move);
    for (Cell cell : more.cells) {
        for (std::uint32_t& v : cell) v += first;
        mesh.cells.push_back(cell);
    }
    mesh.regions.insert(mesh.regions.end(), more.regions.begin(), more.regions.end());
}

TEST(Validity, sound_meshes_have_no_fault) {
    const auto hollow = [](int i, int j, int k) { return Region(i == 2 && j == 2 && k == 2 ? 0 : 1); };
    const auto pattern = [](int i, int j, int k) { return Region((i * 7 + j * 5 + k * 3) % 4 != 0); };
    const auto vertex = [](int i, int j, int k) { return Region(i == j && j == k ? 1 : 0); };
    for (const TetMesh& mesh :
         {brick_mesh({4, 3, 5}, everywhere), brick_mesh({5, 5, 5}, hollow), brick_mesh({6, 6, 6}, pattern),
          brick_mesh({2, 2, 2}, vertex), rounded_mesh(8, 40.0, everywhere), rounded_mesh(9, 40.0, pattern)}) {
        const MeshCheck check = check_mesh(mesh);
        EXPECT_TRUE(check.valid()) << to_line(check);
        EXPECT_TRUE(check.boundary_checked);
    }
    EXPECT_EQ(check_mesh(brick_mesh({5, 5, 5}, hollow)).shells, 2u);
    EXPECT_EQ(to_line(check_mesh(brick_mesh({1, 1, 1}, everywhere))), "no fault");
}

TEST(Validity, single_faults_are_named) {
    const TetMesh good = brick_mesh({3, 3, 3}, everywhere);
    const auto count_after = [&](MeshFault fault, const auto& spoil) {
        TetMesh bad = good;
        spoil(bad);
        const MeshCheck check = check_mesh(bad);
        EXPECT_EQ(check.valid(), fault == MeshFault::point_unused) << to_line(check);
        return check.count(fault);
    };
    EXPECT_EQ(count_after(MeshFault::point_not_finite,
                          [](TetMesh& m) { m.points[7].y = std::numeric_limits<double>::quiet_NaN(); }),
              1u);
    EXPECT_EQ(count_after(MeshFault::points_equal, [](TetMesh& m) { m.points.push_back(m.points[3]); }), 1u);
    EXPECT_EQ(count_after(MeshFault::point_unused, [](TetMesh& m) { m.points.push_back({9, 9, 9}); }), 1u);
    EXPECT_EQ(count_after(MeshFault::index_out_of_range, [](TetMesh& m) { m.cells[4][2] = 64; }), 1u);
    EXPECT_EQ(
        count_after(MeshFault::cell_inverted, [](TetMesh& m) { std::swap(m.cells[4][2], m.cells[4][3]); }),
        1u);
    EXPECT_EQ(count_after(MeshFault::cell_flat, [](TetMesh& m) { m.cells[4][2] = m.cells[4][3]; }), 1u);
    EXPECT_EQ(count_after(MeshFault::cells_equal,
                          [](TetMesh& m) {
                              const Cell cell = m.cells[10];
                              m.cells.push_back({cell[1], cell[2], cell[0], cell[3]});
                              m.regions.push_back(1);
                          }),
              1u);
    EXPECT_GE(count_after(MeshFault::facet_in_too_many_cells,
                          [](TetMesh& m) {
                              m.points.push_back({1.5, 1.5, 9});
                              const Cell cell = m.cells[80];
                              m.cells.push_back({cell[0], cell[2], cell[1], 64});
                              m.cells.push_back({cell[0], cell[1], cell[2], 64});
                              m.regions.insert(m.regions.end(), 2, 1);
                          }),
              1u);
}

TEST(Validity, overlapping_solids_are_found) {
    const TetMesh ball = rounded_mesh(6, 10.0, everywhere);
    TetMesh apart = ball;
    append(apart, ball, 1.0, {25, 0, 0});
    EXPECT_TRUE(check_mesh(apart).valid());

    TetMesh crossing = ball;
    append(crossing, ball, 1.0, {11, 3, 2});
    EXPECT_GT(check_mesh(crossing).count(MeshFault::boundary_crosses), 0u);

    TetMesh swallowed = ball;
    append(swallowed, ball, 0.25, {1, 2, 3});
    const MeshCheck inside = check_mesh(swallowed);
    EXPECT_EQ(inside.count(MeshFault::boundary_crosses), 0u);
    EXPECT_EQ(inside.count(MeshFault::shell_inside_a_solid), 1u);

    const auto hollow = [](int i, int j, int k) {
        return Region(i > 0 && i < 8 && j > 0 && j < 8 && k > 0 && k < 8 ? 0 : 1);
    };
    TetMesh nested = rounded_mesh(9, 10.0, hollow);
    append(nested, ball, 0.25, {1, 2, 1});
    const MeshCheck in_cavity = check_mesh(nested);
    EXPECT_TRUE(in_cavity.valid()) << to_line(in_cavity);
    EXPECT_EQ(in_cavity.shells, 3u);
}

TEST(Validity, a_strip_bent_through_itself_is_found) {
    // No cell is inverted and every facet matches: only the boundary tells.
    const auto bend = [](int i, int j, int k) {
        const double angle = 2.2 * 3.14159265358979 * i / 40, radius = 10.0 + k;
        return Vec3{radius * std::sin(angle), -radius * std::cos(angle), static_cast<double>(j)};
    };
    const MeshCheck check = check_mesh(brick_mesh({40, 2, 1}, everywhere, bend));
    EXPECT_EQ(check.count(MeshFault::cell_inverted), 0u);
    EXPECT_EQ(check.count(MeshFault::facet_on_one_side), 0u);
    EXPECT_GT(check.count(MeshFault::boundary_crosses), 0u);
}

TEST(Validity, a_vertex_that_only_touches_a_facet_is_found) {
    TetMesh mesh;
    mesh.points = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}, {1, 1, 0}, {1, 2, -3}, {2, 1, -3}, {1, 1, -4}};
    mesh.cells = {{0, 1, 2, 3}, {4, 5, 6, 7}};
    mesh.regions = {1, 1};
    EXPECT_GT(check_mesh(mesh).count(MeshFault::boundary_crosses), 0u);
    mesh.points[4].z = -0.5;
    EXPECT_TRUE(check_mesh(mesh).valid()) << to_line(check_mesh(mesh));
}

// Laws of the triangle test: the order of triangles and of vertices does not matter, and on a lattice, where
// everything degenerate happens, it agrees with dense sampling of rational points.
TEST(TrianglesMeet, laws_on_a_small_lattice) {
    std::mt19937 random(11);
    const auto coordinate = [&] { return static_cast<double>(random() % 4); };
    int met = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        std::vector<Vec3> p(6);
        for (Vec3& point : p) point = {coordinate(), coordinate(), coordinate()};
        const auto degenerate = [&](std::size_t i) {
            return squared_length(cross(p[i + 1] - p[i], p[i + 2] - p[i])) == 0;
        };
        if (degenerate(0) || degenerate(3)) continue;
        Triangle a{0, 1, 2}, b{3, 4, 5};
        const std::uint32_t shared = static_cast<std::uint32_t>(random() % 3);
        for (std::uint32_t i = 0; i < shared; ++i) {
            p[3 + i] = p[i];
            b[i] = i;
        }
        if (degenerate(3)) continue;
        const bool meet = triangles_meet(p, a, b);
        met += meet;
        EXPECT_EQ(meet, triangles_meet(p, b, a));
        EXPECT_EQ(meet, triangles_meet(p, {a[1], a[2], a[0]}, {b[1], b[0], b[2]}));
        // Mirrored and sheared by an integer map of determinant -1.
        std::vector<Vec3> q(6);
        for (std::size_t i = 0; i < 6; ++i) q[i] = {p[i].y + 2 * p[i].z, p[i].x - p[i].y, p[i].z};
        EXPECT_EQ(meet, triangles_meet(q, a, b));
        // A point inside b (not on what is shared) that lies in a proves that they meet.
        bool witness = false;
        for (int u = 0; u <= 6; ++u) {
            for (int v = 0; v <= 6 - u; ++v) {
                const int w = 6 - u - v;
                if ((shared == 1 && u == 6) || (shared == 2 && w == 0)) continue;
                const Vec3 x = u * p[3] + v * p[4] + w * p[5];  // six times the point
                const Vec3 normal = cross(p[1] - p[0], p[2] - p[0]);
                if (dot(normal, x - 6.0 * p[0]) != 0) continue;
                bool inside = true;
                for (std::size_t e = 0; e < 3; ++e) {
                    const Vec3 from = p[e], to = p[(e + 1) % 3];
                    inside = inside && dot(normal, cross(to - from, x - 6.0 * from)) >= 0;
                }
                witness = witness || inside;
            }
        }
        if (witness) {
            EXPECT_TRUE(meet) << trial;
        }
    }
    EXPECT_GT(met, 1000);
}

TEST(Validity, is_quick_enough_for_every_run) {
    const auto sponge = [](int i, int j, int k) {
        return Region(i % 4 == 1 && j % 4 == 1 && k % 4 != 1 ? 0 : 1);
    };
    const TetMesh mesh = rounded_mesh(36, 100.0, sponge);
    const auto start = std::chrono::steady_clock::now();
    const MeshCheck check = check_mesh(mesh);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    RecordProperty("check_ms", std::to_string(took.count()));
    RecordProperty("cells", static_cast<int>(mesh.cells.size()));
    RecordProperty("boundary", static_cast<int>(check.boundary_triangles));
    EXPECT_TRUE(check.valid()) << to_line(check);
    EXPECT_LT(took.count(), 10000.0) << mesh.cells.size() << " cells";
}

}  // namespace
}  // namespace anatomesh::validity_test
