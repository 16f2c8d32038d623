// For tests: solids of unit cubes and their surfaces.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "anatomesh/geom/vec.h"
#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh::fixtures {

using Cube = std::array<int, 3>;  // its low corner

// A set of cubes, of which no two meet in an edge or corner alone.
class CubeSolid {
  public:
    void add(Cube low, Cube high) {
        for_each(low, high, [&](const Cube& cube) { cubes_.insert(cube); });
    }
    void remove(Cube low, Cube high) {
        for_each(low, high, [&](const Cube& cube) { cubes_.erase(cube); });
    }

    // Two triangles a face, counter-clockwise seen from outside; their vertices are points().
    std::vector<Triangle> surface() {
        std::vector<Triangle> triangles;
        for (const Cube& cube : cubes_) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                for (const int side : {0, 1}) {
                    Cube beyond = cube;
                    beyond[axis] += side ? 1 : -1;
                    if (!cubes_.count(beyond)) add_face(cube, axis, side, triangles);
                }
            }
        }
        return triangles;
    }
    const std::vector<Vec3>& points() const { return points_; }

  private:
    template <class Visit>
    static void for_each(Cube low, Cube high, Visit&& visit) {
        for (int k = low[2]; k < high[2]; ++k) {
            for (int j = low[1]; j < high[1]; ++j) {
                for (int i = low[0]; i < high[0]; ++i) visit(Cube{i, j, k});
            }
        }
    }
    std::uint32_t vertex(Cube at) {
        const auto [place, fresh] = vertices_.try_emplace(at, static_cast<std::uint32_t>(points_.size()));
        if (fresh)
            points_.push_back(
                {static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2])});
        return place->second;
    }
    void add_face(Cube cube, std::size_t axis, int side, std::vector<Triangle>& triangles) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        cube[axis] += side;
        std::array<std::uint32_t, 4> corner{};
        corner[0] = vertex(cube);
        ++cube[u];
        corner[1] = vertex(cube);
        ++cube[v];
        corner[2] = vertex(cube);
        --cube[u];
        corner[3] = vertex(cube);
        if (side == 0) std::swap(corner[1], corner[3]);
        triangles.push_back({corner[0], corner[1], corner[2]});
        triangles.push_back({corner[0], corner[2], corner[3]});
    }

    std::set<Cube> cubes_;
    std::map<Cube, std::uint32_t> vertices_;
    std::vector<Vec3> points_;
};

}  // namespace anatomesh::fixtures
