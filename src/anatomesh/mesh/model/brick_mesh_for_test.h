// Meshes of known shape for tests: cubes of a grid, each cut into six tetrahedra (Kuhn), mapped into space.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh::testing {

// The cubes (i, j, k) of an n[0] x n[1] x n[2] grid whose region(i, j, k) is not 0. Grid point (i, j, k) goes
// to map(i, j, k), which must keep the orientation. Only used points are kept.
inline TetMesh brick_mesh(std::array<int, 3> n, const std::function<Region(int, int, int)>& region,
                          const std::function<Vec3(int, int, int)>& map) {
    constexpr std::array<std::array<int, 3>, 6> orders{
        {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    const auto index = [&](const std::array<int, 3>& p) {
        return static_cast<std::uint32_t>(p[0] + (n[0] + 1) * (p[1] + (n[1] + 1) * p[2]));
    };
    TetMesh mesh;
    for (int k = 0; k < n[2]; ++k) {
        for (int j = 0; j < n[1]; ++j) {
            for (int i = 0; i < n[0]; ++i) {
                const Region r = region(i, j, k);
                if (r == 0) continue;
                for (std::size_t o = 0; o < orders.size(); ++o) {
                    std::array<int, 3> p{i, j, k};
                    Cell cell{index(p), 0, 0, 0};
                    for (std::size_t step = 0; step < 3; ++step) {
                        ++p[static_cast<std::size_t>(orders[o][step])];
                        cell[step + 1] = index(p);
                    }
                    // Odd permutations of the axes give the mirrored cell.
                    if (o == 1 || o == 2 || o == 5) std::swap(cell[2], cell[3]);
                    mesh.cells.push_back(cell);
                    mesh.regions.push_back(r);
                }
            }
        }
    }
    std::vector<std::uint32_t> new_index(static_cast<std::size_t>((n[0] + 1) * (n[1] + 1) * (n[2] + 1)),
                                         no_cell);
    for (const Cell& cell : mesh.cells) {
        for (const std::uint32_t v : cell) new_index[v] = 0;
    }
    for (std::size_t v = 0; v < new_index.size(); ++v) {
        if (new_index[v] == no_cell) continue;
        new_index[v] = static_cast<std::uint32_t>(mesh.points.size());
        const int row = static_cast<int>(v) / (n[0] + 1);
        mesh.points.push_back(map(static_cast<int>(v) % (n[0] + 1), row % (n[1] + 1), row / (n[1] + 1)));
    }
    for (Cell& cell : mesh.cells) {
        for (std::uint32_t& v : cell) v = new_index[v];
    }
    return mesh;
}

// The same with unit cubes where they lie.
inline TetMesh brick_mesh(std::array<int, 3> n, const std::function<Region(int, int, int)>& region) {
    return brick_mesh(n, region, [](int i, int j, int k) {
        return Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
    });
}

// A rounded solid, nearly a ball of the given radius, of 6 n^3 cells.
inline TetMesh rounded_mesh(int n, double radius, const std::function<Region(int, int, int)>& region) {
    return brick_mesh({n, n, n}, region, [n, radius](int i, int j, int k) {
        const auto coordinate = [n](int index) { return 0.92 * (2.0 * index / n - 1.0); };
        const double x = coordinate(i), y = coordinate(j), z = coordinate(k);
        const auto bulge = [](double a, double b) {
            return std::sqrt(1.0 - a * a / 2 - b * b / 2 + a * a * b * b / 3);
        };
        return Vec3{radius * x * bulge(y, z), radius * y * bulge(z, x), radius * z * bulge(x, y)};
    });
}

}  // namespace anatomesh::testing
