#include "anatomesh/mesh/check/validity.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "anatomesh/base/disjoint_sets.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/check/triangles_meet.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/box_tree.h"
#include "anatomesh/mesh/model/buckets.h"

namespace anatomesh {

namespace {

// A check keeps so many places of each kind of fault: more tell nobody more. [places; >= 1; B]
constexpr std::uint64_t examples_of_each = 10;

constexpr std::array<const char*, 11> fault_names{
    "points not finite",
    "points at the place of another",
    "points in no cell",
    "cells with an index out of range",
    "cells inverted",
    "cells flat",
    "cells equal to another",
    "facets in more than two cells",
    "facets with both cells on one side",
    "crossings of the boundary",
    "shells inside a solid",
};

void add(MeshCheck& check, MeshFault fault, std::uint32_t first, std::uint32_t second = no_cell) {
    if (++check.counts[static_cast<std::size_t>(fault)] <= examples_of_each) {
        check.examples.push_back({fault, first, second});
    }
}

void check_points(const TetMesh& mesh, MeshCheck& check) {
    std::vector<std::uint32_t> order;
    order.reserve(mesh.points.size());
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
        const Vec3 p = mesh.points[v];
        if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) {
            order.push_back(v);
        } else {
            add(check, MeshFault::point_not_finite, v);
        }
    }
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        if (mesh.points[a] == mesh.points[b]) return a < b;
        return lexicographic_less(mesh.points[a], mesh.points[b]);
    });
    for (std::size_t i = 0; i + 1 < order.size(); ++i) {
        if (mesh.points[order[i]] == mesh.points[order[i + 1]]) {
            add(check, MeshFault::points_equal, order[i], order[i + 1]);
        }
    }
    std::vector<std::uint8_t> used(mesh.points.size(), 0);
    for (const Cell& cell : mesh.cells) {
        for (const std::uint32_t v : cell) {
            if (v < used.size()) used[v] = 1;
        }
    }
    for (std::uint32_t v = 0; v < used.size(); ++v) {
        if (!used[v]) add(check, MeshFault::point_unused, v);
    }
}

bool in_range(const TetMesh& mesh) {
    return std::all_of(mesh.cells.begin(), mesh.cells.end(), [&](const Cell& cell) {
        return *std::max_element(cell.begin(), cell.end()) < mesh.points.size();
    });
}

void check_indices(const TetMesh& mesh, MeshCheck& check) {
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& cell = mesh.cells[c];
        if (*std::max_element(cell.begin(), cell.end()) >= mesh.points.size()) {
            add(check, MeshFault::index_out_of_range, c);
        }
    }
}

void check_orientation(const TetMesh& mesh, int threads, MeshCheck& check) {
    std::vector<std::int8_t> signs(mesh.cells.size());
    parallel_for(signs.size(), 16384, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) {
            const auto& [i, j, k, l] = mesh.cells[c];
            signs[c] = static_cast<std::int8_t>(
                orient3d(mesh.points[i], mesh.points[j], mesh.points[k], mesh.points[l]));
        }
    });
    for (std::uint32_t c = 0; c < signs.size(); ++c) {
        if (signs[c] < 0) add(check, MeshFault::cell_inverted, c);
        if (signs[c] == 0) add(check, MeshFault::cell_flat, c);
    }
}

void check_duplicates(const TetMesh& mesh, MeshCheck& check) {
    // Equal cells share all their facets, so without a facet that lies in too many cells or in two on one
    // side there are none.
    if (check.count(MeshFault::facet_in_too_many_cells) + check.count(MeshFault::facet_on_one_side) +
            check.count(MeshFault::cell_inverted) ==
        0) {
        return;
    }
    std::vector<std::pair<Cell, std::uint32_t>> cells(mesh.cells.size());
    for (std::uint32_t c = 0; c < cells.size(); ++c) {
        cells[c] = {mesh.cells[c], c};
        std::sort(cells[c].first.begin(), cells[c].first.end());
    }
    std::sort(cells.begin(), cells.end());
    for (std::size_t i = 0; i + 1 < cells.size(); ++i) {
        if (cells[i].first == cells[i + 1].first) {
            add(check, MeshFault::cells_equal, cells[i].second, cells[i + 1].second);
        }
    }
}

// The facets in one cell only, outward, and their cells.
struct Boundary {
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> cells;
};

Boundary check_facets(const TetMesh& mesh, const FacetPairs& pairs, int threads, MeshCheck& check) {
    std::vector<std::uint8_t> crowded(4 * mesh.cells.size(), 0);
    for (const auto& [first, third] : pairs.surplus) {
        if (!crowded[first])
            add(check, MeshFault::facet_in_too_many_cells, first / 4, pairs.other[first] / 4);
        crowded[first] = crowded[third] = 1;
    }
    for (const auto& [first, second] : pairs.on_one_side) {
        if (!crowded[first]) add(check, MeshFault::facet_on_one_side, first / 4, second / 4);
    }
    Boundary boundary;
    const std::vector<std::uint32_t> outer = parallel_collect<std::uint32_t>(
        pairs.other.size(), 65536, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& ids) {
            for (std::size_t id = first; id < last; ++id) {
                if (pairs.other[id] == no_cell && !crowded[id]) ids.push_back(static_cast<std::uint32_t>(id));
            }
        });
    for (const std::uint32_t id : outer) {
        boundary.triangles.push_back(facet_of(mesh.cells[id / 4], id % 4));
        boundary.cells.push_back(id / 4);
    }
    check.boundary_triangles = boundary.triangles.size();
    return boundary;
}

// Shells: boundary triangles joined across the edges that exactly two of them share. By triangle, the
// smallest triangle of its shell.
std::vector<std::uint32_t> shells_of(const Boundary& boundary, std::size_t point_count) {
    const std::vector<Triangle>& triangles = boundary.triangles;
    const Buckets edges = fill_buckets(point_count, [&](const auto& emit) {
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t a = triangles[t][i], b = triangles[t][(i + 1) % 3];
                emit(std::min(a, b), std::max(a, b), t);
            }
        }
    });
    DisjointSets shells(triangles.size());
    for (std::size_t v = 0; v < point_count; ++v) {
        std::size_t e = edges.start[v];
        while (e < edges.start[v + 1]) {
            std::size_t last = e + 1;
            while (last < edges.start[v + 1] && edges.entries[last].key == edges.entries[e].key) ++last;
            if (last - e == 2) shells.join(edges.entries[e].id, edges.entries[e + 1].id);
            e = last;
        }
    }
    std::vector<std::uint32_t> shell_of(triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) shell_of[t] = shells.root(t);
    return shell_of;
}

Vec2 along_x(Vec3 p) {
    return {p.y, p.z};
}

// Side of q on the line a -> b in the plane, q moved by (e, e^2) for a vanishing e: 0 only when a equals b.
int perturbed_side(Vec2 a, Vec2 b, Vec2 q) {
    if (const int side = orient2d(a, b, q)) return side;
    if (a.y != b.y) return a.y > b.y ? 1 : -1;
    if (a.x != b.x) return b.x > a.x ? 1 : -1;
    return 0;
}

// How often the boundary winds about the point just outside triangle `start`, counted along the line through
// the triangle's centroid in direction x, away from the triangle.
class ShellRay {
  public:
    ShellRay(const TetMesh& mesh, const Boundary& boundary, const BoxTree& tree)
        : points_(mesh.points), triangles_(boundary.triangles), tree_(tree) {}

    int winding_outside(std::uint32_t start) {
        const Triangle& f = triangles_[start];
        const Vec3 q = (1.0 / 3.0) * (points_[f[0]] + points_[f[1]] + points_[f[2]]);
        const int direction =
            orient2d(along_x(points_[f[0]]), along_x(points_[f[1]]), along_x(points_[f[2]]));
        int winding = 0;
        stack_.assign(1, 0);
        while (!stack_.empty()) {
            const BoxTree::Node& node = tree_.nodes[stack_.back()];
            stack_.pop_back();
            if (!ray_meets(node.box, q, direction)) continue;
            if (node.count == 0) {
                stack_.push_back(node.first);
                stack_.push_back(node.first + 1);
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                if (tree_.order[i] != start) winding += crossing(triangles_[tree_.order[i]], q, direction);
            }
        }
        return winding;
    }

  private:
    static bool ray_meets(const Box3& box, Vec3 q, int direction) {
        return box.low.y <= q.y && q.y <= box.high.y && box.low.z <= q.z && q.z <= box.high.z &&
               (direction > 0 ? box.high.x >= q.x : box.low.x <= q.x);
    }

    // +1 where the ray leaves the solid through the triangle, -1 where it enters, 0 where it misses.
    int crossing(const Triangle& f, Vec3 q, int direction) const {
        const Vec3 a = points_[f[0]], b = points_[f[1]], c = points_[f[2]];
        const int turn = perturbed_side(along_x(a), along_x(b), along_x(q));
        if (turn == 0 || perturbed_side(along_x(b), along_x(c), along_x(q)) != turn ||
            perturbed_side(along_x(c), along_x(a), along_x(q)) != turn) {
            return 0;
        }
        // The normal has the sign of `turn` along x: q is before the triangle, seen along +x, when it lies on
        // the negative side of a triangle with turn > 0.
        const int before = -orient3d(a, b, c, q) * turn;
        return before * direction > 0 ? turn * direction : 0;
    }

    const std::vector<Vec3>& points_;
    const std::vector<Triangle>& triangles_;
    const BoxTree& tree_;
    std::vector<std::uint32_t> stack_;
};

void check_shells(const TetMesh& mesh, const Boundary& boundary, const BoxTree& tree,
                  std::span<const std::uint32_t> shell_of, MeshCheck& check) {
    // The ray of a shell starts from its triangle of the largest extent across x.
    std::vector<double> best(shell_of.size(), -1.0);
    std::vector<std::uint32_t> start(shell_of.size(), 0);
    for (std::uint32_t t = 0; t < shell_of.size(); ++t) {
        const Triangle& f = boundary.triangles[t];
        const Vec2 a = along_x(mesh.points[f[0]]);
        const double extent = std::abs(cross(along_x(mesh.points[f[1]]) - a, along_x(mesh.points[f[2]]) - a));
        if (extent <= best[shell_of[t]]) continue;
        best[shell_of[t]] = extent;
        start[shell_of[t]] = t;
    }
    ShellRay ray(mesh, boundary, tree);
    for (std::uint32_t t = 0; t < shell_of.size(); ++t) {
        if (shell_of[t] != t) continue;
        ++check.shells;
        if (ray.winding_outside(start[t]) != 0) {
            add(check, MeshFault::shell_inside_a_solid, boundary.cells[start[t]]);
        }
    }
}

void check_boundary(const TetMesh& mesh, const Boundary& boundary, int threads, MeshCheck& check) {
    BoxTree tree;
    std::vector<std::vector<std::array<std::uint32_t, 2>>> found;
    const auto find_crossings = [&] {
        tree = make_box_tree(mesh.points, boundary.triangles, threads);
        const MeetingPairs pairs(tree, mesh.points, boundary.triangles);
        // The search for pairs that overlap is parted into so many pieces, enough for every thread to have
        // some until the end. [pieces; >= 1; B]
        constexpr std::size_t pieces_wanted = 512;
        const std::vector<NodePair> pieces = pairs.pieces(pieces_wanted);
        found.resize(pieces.size());
        parallel_for(pieces.size(), 1, threads, [&](std::size_t first, std::size_t last) {
            for (std::size_t n = first; n < last; ++n) {
                pairs.for_each(pieces[n], [&](std::uint32_t a, std::uint32_t b) {
                    if (triangles_meet(mesh.points, boundary.triangles[a], boundary.triangles[b]))
                        found[n].push_back({a, b});
                });
            }
        });
    };
    // The shells, of use where none crosses another, are found by one thread.
    std::vector<std::uint32_t> shell_of;
    parallel_tasks(threads, {find_crossings, [&] { shell_of = shells_of(boundary, mesh.points.size()); }});
    for (const auto& piece : found) {
        for (const auto& [a, b] : piece) {
            add(check, MeshFault::boundary_crosses, boundary.cells[std::min(a, b)],
                boundary.cells[std::max(a, b)]);
        }
    }
    check.boundary_checked = true;
    if (check.count(MeshFault::boundary_crosses) == 0) check_shells(mesh, boundary, tree, shell_of, check);
}

}  // namespace

bool MeshCheck::valid() const {
    const std::uint64_t all = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    return boundary_checked && all == count(MeshFault::point_unused);
}

std::string to_line(const MeshCheck& check) {
    std::string line;
    for (std::size_t fault = 0; fault < check.counts.size(); ++fault) {
        if (check.counts[fault] == 0) continue;
        if (!line.empty()) line += ", ";
        line += std::to_string(check.counts[fault]) + " " + fault_names[fault];
        for (const MeshFinding& finding : check.examples) {
            if (static_cast<std::size_t>(finding.fault) != fault) continue;
            line += " (first: " + std::to_string(finding.first);
            if (finding.second != no_cell) line += " and " + std::to_string(finding.second);
            line += ")";
            break;
        }
    }
    return line.empty() ? "no fault" : line;
}

MeshCheck check_mesh(const TetMesh& mesh, int threads, std::vector<std::uint32_t>* neighbors) {
    assert(mesh.cells.size() < no_cell / 4);
    MeshCheck check;
    FacetPairs pairs;
    parallel_tasks(threads, {[&] { check_points(mesh, check); },
                             [&] {
                                 if (!in_range(mesh)) return;
                                 pairs = match_facets(mesh.cells, mesh.points.size(), threads);
                             }});
    check_indices(mesh, check);
    if (check.count(MeshFault::index_out_of_range) > 0 || check.count(MeshFault::point_not_finite) > 0)
        return check;
    check_orientation(mesh, threads, check);
    const Boundary boundary = check_facets(mesh, pairs, threads, check);
    check_duplicates(mesh, check);
    const bool sound = check.count(MeshFault::cell_inverted) == 0 && check.count(MeshFault::cell_flat) == 0 &&
                       check.count(MeshFault::facet_in_too_many_cells) == 0 &&
                       check.count(MeshFault::facet_on_one_side) == 0;
    if (sound) check_boundary(mesh, boundary, threads, check);
    if (neighbors) {
        *neighbors = std::move(pairs.other);
        parallel_for(neighbors->size(), 65536, threads, [&](std::size_t first, std::size_t last) {
            for (std::size_t n = first; n < last; ++n) {
                if ((*neighbors)[n] != no_cell) (*neighbors)[n] /= 4;
            }
        });
    }
    return check;
}

}  // namespace anatomesh
