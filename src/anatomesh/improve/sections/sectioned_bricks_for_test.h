// For tests: a mesh with cells of random regions, parallel slices through it, and random changes to it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::fixtures {

// Bricks whose vertices are shaken, but for those of the hull and some that lie in slices, as drawn or not.
// Nothing is as drawn: two balls are, and regions are random.
struct SectionedBricks {
    static constexpr int width = 5, height = 6;
    std::mt19937 random;
    TetMesh mesh = testing::brick_mesh({width, width, height}, [](int, int, int) { return Region{1}; });
    RegionTable table{{{}, {0}, {1}, {0, 1}}};
    std::vector<std::uint32_t> slice_of;
    std::vector<std::uint8_t> fixed;
    std::vector<Plane> planes;
    std::vector<Box2> extents;  // empty: the planes are known to be parallel
    std::vector<double> weights;
    ContourOwners owners;
    AnalyticField field{{ball({2, 2, 2}, 1.7), ball({3, 3, 4}, 1.9)}, 10};

    explicit SectionedBricks(unsigned seed) : random(seed) {
        for (const double z : {4.0, 1.5, 2.0, 3.25, 5.0, 3.0})
            planes.push_back(make_plane({0, 0, z}, {0, 0, 1}));
        for (Region& region : mesh.regions) region = static_cast<Region>(random() % 4);
        std::uniform_real_distribution<double> shift(-0.2, 0.2), weight(0, 1);
        for (Vec3& p : mesh.points) {
            fixed.push_back(p.x == 0 || p.x == width || p.y == 0 || p.y == width || p.z == 0 ||
                            p.z == height);
            slice_of.push_back(no_slice);
            if (fixed.back()) continue;
            p.x += shift(random);
            p.y += shift(random);
            if (random() % 3 == 0) {
                p.z += shift(random);
            } else if (random() % 2 == 0) {
                const auto at = std::find_if(planes.begin(), planes.end(),
                                             [&](const Plane& plane) { return plane.origin.z == p.z; });
                if (at != planes.end()) slice_of.back() = static_cast<std::uint32_t>(at - planes.begin());
            }
        }
        for (std::size_t n = 0; n < 2 * planes.size(); ++n)
            weights.push_back(random() % 5 == 0 ? 0 : weight(random));
        owners = ContourOwners({}, mesh.points.size());
    }

    DrawnSlices drawn() const { return {&table, slice_of, &owners, planes, extents, weights, 1e-9}; }
    // As if the planes lay in any position, with more of each than the mesh has.
    void give_extents() { extents.assign(planes.size(), Box2{{-100, -100}, {100, 100}}); }
    EditMesh editable() const { return {mesh, cell_neighbors(mesh.cells, mesh.points.size())}; }

    // One of: a vertex moves, a cell goes to another region, an edge is split, three cells become two.
    void change(EditContext& edit) {
        EditMesh& edited = edit.mesh;
        std::uint32_t c = static_cast<std::uint32_t>(random() % edited.cell_count());
        while (!edited.alive(c)) c = static_cast<std::uint32_t>(random() % edited.cell_count());
        const auto kind = random() % 4;
        if (kind == 0) {
            const std::uint32_t v = edited.cell(c)[random() % 4];
            std::uniform_real_distribution<double> shift(-0.05, 0.05);
            edited.move_point(v, edited.point(v) + Vec3{shift(random), shift(random), shift(random)});
        } else if (kind == 1) {
            edited.set_region(c, static_cast<Region>(random() % 4));
        } else if (kind == 2) {
            edited.ring(c, static_cast<int>(random() % 6), edit.ring);
            if (edit.ring.closed)
                edit.split_ring(0.5 * (edited.point(edit.ring.a) + edited.point(edit.ring.b)));
        } else {
            remove_edge_of_three(edited);
        }
    }

  private:
    // The first edge of three cells from a random cell on.
    void remove_edge_of_three(EditMesh& edited) {
        const std::size_t count = edited.cell_count(), from = random() % count;
        EdgeRing ring;
        std::vector<std::uint32_t> slots;
        for (std::size_t n = 0; n < count; ++n) {
            const auto c = static_cast<std::uint32_t>((from + n) % count);
            for (int e = 0; e < 6 && edited.alive(c); ++e) {
                edited.ring(c, e, ring);
                if (!ring.closed || ring.cells.size() != 3) continue;
                const auto& r = ring.ring;
                const std::array<Cell, 2> added{Cell{r[0], r[1], r[2], ring.b},
                                                Cell{r[0], r[2], r[1], ring.a}};
                const bool positive = std::all_of(added.begin(), added.end(), [&](const Cell& v) {
                    return orient3d(edited.point(v[0]), edited.point(v[1]), edited.point(v[2]),
                                    edited.point(v[3])) > 0;
                });
                if (!positive) continue;
                const std::array regions{edited.region(c), static_cast<Region>(random() % 4)};
                edited.replace(ring.cells, added, regions, slots);
                return;
            }
        }
    }
};

}  // namespace anatomesh::fixtures
