// For tests: what a model must be, found from its points, cells and regions alone. Shares no code with the
// certificate.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh::independent {

using Corners = std::array<std::uint32_t, 3>;

struct Surface {
    std::vector<Corners> triangles;  // counter-clockwise seen from outside
};

// The boundary of the cells that `within` accepts.
template <class Within>
Surface boundary_of(const TetMesh& mesh, Within within) {
    static constexpr int facets[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    std::vector<std::array<Corners, 2>>
        sides;  // a facet's vertices sorted, and as seen from outside its cell
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        if (!within(mesh.regions[c])) continue;
        for (const auto& facet : facets) {
            const Corners out{mesh.cells[c][facet[0]], mesh.cells[c][facet[1]], mesh.cells[c][facet[2]]};
            Corners key = out;
            std::sort(key.begin(), key.end());
            sides.push_back({key, out});
        }
    }
    std::sort(sides.begin(), sides.end());
    Surface surface;
    for (std::size_t f = 0; f < sides.size(); ++f) {
        const bool first = f == 0 || sides[f - 1][0] != sides[f][0];
        const bool last = f + 1 == sides.size() || sides[f + 1][0] != sides[f][0];
        if (first && last) surface.triangles.push_back(sides[f][1]);
    }
    return surface;
}

// What is wrong with the cells: "" when all are positive and no facet has more than two.
inline std::string fault_of_cells(const TetMesh& mesh) {
    std::vector<Corners> facets;
    for (const Cell& cell : mesh.cells) {
        const Vec3 a = mesh.points[cell[0]];
        const double six =
            dot(cross(mesh.points[cell[1]] - a, mesh.points[cell[2]] - a), mesh.points[cell[3]] - a);
        if (!(six > 0)) return "a cell of volume " + std::to_string(six / 6);
        for (int skip = 0; skip < 4; ++skip) {
            Corners key{};
            for (int i = 0, n = 0; i < 4; ++i) {
                if (i != skip) key[n++] = cell[i];
            }
            std::sort(key.begin(), key.end());
            facets.push_back(key);
        }
    }
    std::sort(facets.begin(), facets.end());
    for (std::size_t f = 2; f < facets.size(); ++f) {
        if (facets[f] == facets[f - 2]) return "a facet of three cells";
    }
    return "";
}

// What keeps a set of triangles from being a closed oriented 2-manifold: "" when nothing does.
inline std::string fault_of_surface(const Surface& surface) {
    std::map<std::array<std::uint32_t, 2>, int> uses;
    std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> links;  // per vertex: the next round it
    for (const Corners& t : surface.triangles) {
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
            if (++uses[{a, b}] > 1) return "an edge that two triangles run along the same way";
            links[a][b] = c;
        }
    }
    for (const auto& [edge, count] : uses) {
        if (uses.count({edge[1], edge[0]}) == 0) return "an open edge";
    }
    for (const auto& [vertex, next] : links) {
        std::size_t steps = 0;
        const std::uint32_t first = next.begin()->first;
        std::uint32_t at = first;
        do {
            const auto found = next.find(at);
            if (found == next.end()) return "an open fan";
            at = found->second;
        } while (++steps < next.size() && at != first);
        if (at != first || steps != next.size()) return "a vertex of several fans";
    }
    return "";
}

inline double volume_of(const TetMesh& mesh, const Surface& surface) {
    double six = 0;
    for (const Corners& t : surface.triangles)
        six += dot(cross(mesh.points[t[0]], mesh.points[t[1]]), mesh.points[t[2]]);
    return six / 6;
}

inline double area_of(const TetMesh& mesh, const Corners& t) {
    return 0.5 * length(cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]]));
}

// How often the surface winds round p (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30, 1983).
inline double winding(const TetMesh& mesh, const Surface& surface, Vec3 p) {
    double angle = 0;
    for (const Corners& t : surface.triangles) {
        const Vec3 a = mesh.points[t[0]] - p, b = mesh.points[t[1]] - p, c = mesh.points[t[2]] - p;
        const double la = length(a), lb = length(b), lc = length(c);
        angle += 2 * std::atan2(dot(a, cross(b, c)),
                                la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return angle / (4 * std::numbers::pi);
}

// Points spread over the triangles by area, about `count` of them.
inline std::vector<Vec3> samples_of(const TetMesh& mesh, const Surface& surface, int count) {
    double total = 0;
    for (const Corners& t : surface.triangles) total += area_of(mesh, t);
    std::vector<Vec3> samples;
    double due = 0.5;
    std::uint32_t lot = 1;
    for (const Corners& t : surface.triangles) {
        for (due += count * area_of(mesh, t) / total; due >= 1; due -= 1) {
            const auto next = [&] {
                return std::ldexp(static_cast<double>(lot = lot * 1664525u + 1013904223u), -32);
            };
            double u = next(), v = next();
            if (u + v > 1) u = 1 - u, v = 1 - v;
            samples.push_back(mesh.points[t[0]] + u * (mesh.points[t[1]] - mesh.points[t[0]]) +
                              v * (mesh.points[t[2]] - mesh.points[t[0]]));
        }
    }
    return samples;
}

inline double distance_to(const TetMesh& mesh, const Corners& t, Vec3 p) {
    const Vec3 a = mesh.points[t[0]], b = mesh.points[t[1]], c = mesh.points[t[2]];
    const Vec3 n = cross(b - a, c - a);
    const auto beside = [&](Vec3 from, Vec3 to) { return dot(cross(n, to - from), p - from) < 0; };
    const auto to_edge = [&](Vec3 from, Vec3 to) {
        const Vec3 way = to - from;
        const double t01 = std::clamp(dot(p - from, way) / dot(way, way), 0.0, 1.0);
        return length(p - from - t01 * way);
    };
    if (!beside(a, b) && !beside(b, c) && !beside(c, a)) return std::abs(dot(p - a, n)) / length(n);
    return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

// The distance of points from a surface, by the triangles in cubes of a side about them.
class Nearest {
  public:
    Nearest(const TetMesh& mesh, const Surface& surface, double side) : mesh_(mesh), side_(side) {
        for (const Corners& t : surface.triangles) {
            std::array<int, 3> low{}, high{};
            for (int axis = 0; axis < 3; ++axis) {
                double least = 1e300, most = -1e300;
                for (const std::uint32_t v : t) {
                    const std::array<double, 3> x{mesh.points[v].x, mesh.points[v].y, mesh.points[v].z};
                    least = std::min(least, x[axis]);
                    most = std::max(most, x[axis]);
                }
                low[axis] = cell(least);
                high[axis] = cell(most);
            }
            for (int i = low[0]; i <= high[0]; ++i) {
                for (int j = low[1]; j <= high[1]; ++j) {
                    for (int k = low[2]; k <= high[2]; ++k) cubes_[{i, j, k}].push_back(t);
                }
            }
        }
    }

    // Not more than `reach`.
    double distance(Vec3 p, double reach) const {
        double nearest = reach;
        for (int ring = 0; (ring - 1) * side_ < nearest; ++ring) {
            for (int i = -ring; i <= ring; ++i) {
                for (int j = -ring; j <= ring; ++j) {
                    const int step = std::max(std::abs(i), std::abs(j)) == ring ? 1 : std::max(2 * ring, 1);
                    for (int k = -ring; k <= ring; k += step) {
                        const auto found = cubes_.find({cell(p.x) + i, cell(p.y) + j, cell(p.z) + k});
                        if (found == cubes_.end()) continue;
                        for (const Corners& t : found->second)
                            nearest = std::min(nearest, distance_to(mesh_, t, p));
                    }
                }
            }
        }
        return nearest;
    }

  private:
    int cell(double x) const { return static_cast<int>(std::floor(x / side_)); }
    const TetMesh& mesh_;
    double side_;
    std::map<std::array<int, 3>, std::vector<Corners>> cubes_;
};

}  // namespace anatomesh::independent
