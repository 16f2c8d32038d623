#include "anatomesh/recover/recover_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh/recover/cavity.h"
#include "anatomesh/recover/insert_keeping_segments.h"

namespace anatomesh::recover_segments_test {
namespace {

// A Delaunay mesh of random points in a box, and random segments between some of them that pass by others.
struct Drawn {
    TetMesh mesh;
    std::vector<std::uint32_t> neighbors;
    std::vector<Subsegment> subsegments;
    std::vector<std::uint8_t> fixed;

    explicit Drawn(std::uint32_t seed, int count = 600, int segments = 60) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> across(-4, 4);
        std::vector<Vec3> points;
        for (int corner = 0; corner < 8; ++corner)
            points.push_back(20 *
                             Vec3{corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0});
        for (int n = 0; n < count; ++n) points.push_back({across(random), across(random), across(random)});
        auto delaunay = Tetrahedralization::create(points).value();
        const DelaunaySnapshot& cells = delaunay.snapshot();
        mesh = {delaunay.points(), cells.cells, std::vector<Region>(cells.cells.size(), 1)};
        neighbors = cell_neighbors(mesh.cells, mesh.points.size());
        fixed.assign(mesh.points.size(), 0);
        std::fill_n(fixed.begin(), 8, 1);
        // No two share an end.
        std::uniform_int_distribution<std::uint32_t> any(8,
                                                         static_cast<std::uint32_t>(mesh.points.size()) - 1);
        std::set<std::uint32_t> used;
        for (int tries = 0; tries < 100000 && static_cast<int>(subsegments.size()) < segments; ++tries) {
            const std::uint32_t a = any(random), b = any(random);
            const double span = length(mesh.points[b] - mesh.points[a]);
            if (a == b || span < 0.5 || span > 2 || used.count(a) || used.count(b)) continue;
            used.insert({a, b});
            subsegments.push_back({a, b, 0, 0});
        }
    }
};

std::set<MeshEdge> edges_of(const TetMesh& mesh) {
    std::set<MeshEdge> edges;
    for (const Cell& c : mesh.cells) {
        for (const auto& [i, j] : cell_edges) edges.insert({std::min(c[i], c[j]), std::max(c[i], c[j])});
    }
    return edges;
}

bool is_edge(const std::set<MeshEdge>& edges, const Subsegment& subsegment) {
    return edges.count({std::min(subsegment.a, subsegment.b), std::max(subsegment.a, subsegment.b)}) > 0;
}

double volume_of(const TetMesh& mesh) {
    double volume = 0;
    for (const Cell& c : mesh.cells)
        volume += signed_volume(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]);
    return volume;
}

// Positive cells that match facet for facet and fill the same box fill it once.
void expect_same_domain(const TetMesh& before, const TetMesh& mesh,
                        const std::vector<std::uint32_t>& neighbors) {
    for (const Cell& c : mesh.cells)
        ASSERT_GT(orient3d(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]), 0);
    EXPECT_EQ(neighbors, cell_neighbors(mesh.cells, mesh.points.size()));
    EXPECT_EQ(std::count(neighbors.begin(), neighbors.end(), no_cell), 12);
    EXPECT_NEAR(volume_of(mesh), volume_of(before), 1e-9 * volume_of(before));
    for (std::size_t v = 0; v < before.points.size(); ++v) ASSERT_EQ(mesh.points[v], before.points[v]);
}

void expect_kept(const Drawn& drawn, const TetMesh& mesh) {
    std::vector<std::uint8_t> used(mesh.points.size(), 0);
    for (const Cell& c : mesh.cells) {
        for (const std::uint32_t v : c) used[v] = 1;
    }
    for (std::size_t v = 0; v < 8; ++v) EXPECT_TRUE(used[v]);
    for (const Subsegment& subsegment : drawn.subsegments)
        EXPECT_TRUE(used[subsegment.a] && used[subsegment.b]);
}

TEST(RecoverSegments, become_edges_and_those_that_were_stay) {
    std::uint64_t before = 0, after = 0;
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        const Drawn drawn(seed);
        Drawn now = drawn;
        RecoverOptions options;
        options.least_shape = 0.01;
        const RecoverResult result =
            recover_segments(now.mesh, now.neighbors, now.subsegments, now.fixed, options);
        expect_same_domain(drawn.mesh, now.mesh, now.neighbors);
        expect_kept(drawn, now.mesh);
        const std::set<MeshEdge> old_edges = edges_of(drawn.mesh), edges = edges_of(now.mesh);
        const auto missing = [](const std::set<MeshEdge>& all, const std::vector<Subsegment>& subsegments) {
            return static_cast<std::uint64_t>(
                std::count_if(subsegments.begin(), subsegments.end(),
                              [&](const Subsegment& subsegment) { return !is_edge(all, subsegment); }));
        };
        EXPECT_EQ(result.stats.missing_before, missing(old_edges, drawn.subsegments));
        EXPECT_EQ(result.stats.missing_after, missing(edges, now.subsegments));
        EXPECT_EQ(now.subsegments.size(), drawn.subsegments.size() + result.vertices.size());
        for (std::size_t n = 0; n < drawn.subsegments.size(); ++n) {
            if (is_edge(old_edges, drawn.subsegments[n])) {
                EXPECT_TRUE(is_edge(edges, drawn.subsegments[n])) << n;
                EXPECT_EQ(now.subsegments[n], drawn.subsegments[n]);
            }
        }
        before += result.stats.missing_before;
        after += result.stats.missing_after;
    }
    EXPECT_GT(before, 500u);
    EXPECT_LT(after, before / 50);
}

TEST(RecoverSegments, with_new_vertices_are_chains_along_the_subsegment) {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE(seed);
        const Drawn drawn(seed);
        Drawn now = drawn;
        const RecoverResult result =
            recover_segments(now.mesh, now.neighbors, now.subsegments, now.fixed, {});
        for (const Subsegment& subsegment : drawn.subsegments) {
            const Vec3 a = now.mesh.points[subsegment.a], b = now.mesh.points[subsegment.b];
            std::uint32_t at = subsegment.a;
            for (double reached = 0; at != subsegment.b;) {
                const auto next = std::find_if(now.subsegments.begin(), now.subsegments.end(),
                                               [&](auto& p) { return p.a == at; });
                ASSERT_NE(next, now.subsegments.end());
                at = next->b;
                const Vec3 offset = now.mesh.points[at] - a;
                EXPECT_LT(length(cross(offset, b - a)), 1e-12 * squared_length(b - a));
                EXPECT_GT(dot(offset, b - a), reached);
                reached = dot(offset, b - a);
            }
        }
        // What was made is to be decided; what was not kept its region.
        EXPECT_TRUE(std::is_sorted(result.undecided.begin(), result.undecided.end()));
        for (std::uint32_t c = 0; c < now.mesh.cells.size(); ++c) {
            const bool listed = std::binary_search(result.undecided.begin(), result.undecided.end(), c);
            EXPECT_EQ(now.mesh.regions[c], listed ? undecided_region : Region{1});
        }
    }
}

// The segment that lies in the plane of cells, through their edges, as where all points lie on a lattice.
TEST(RecoverSegments, in_the_plane_of_facets_become_edges) {
    std::vector<Vec3> points;
    for (int k = 0; k < 5; ++k) {
        for (int j = 0; j < 5; ++j) {
            for (int i = 0; i < 5; ++i) points.push_back({double(i), double(j), double(k)});
        }
    }
    auto delaunay = Tetrahedralization::create(points).value();
    const auto at = [&](double x, double y, double z) {
        return static_cast<std::uint32_t>(
            std::find(delaunay.points().begin(), delaunay.points().end(), Vec3{x, y, z}) -
            delaunay.points().begin());
    };
    std::vector<Subsegment> subsegments{
        {at(1, 1, 2), at(2, 3, 2), 0, 0}, {at(2, 1, 2), at(1, 3, 3), 0, 0}, {at(3, 1, 1), at(3, 2, 3), 0, 0}};
    const DelaunaySnapshot& cells = delaunay.snapshot();
    TetMesh mesh{delaunay.points(), cells.cells, std::vector<Region>(cells.cells.size(), 1)};
    std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    const std::vector<std::uint8_t> fixed(points.size(), 1);
    RecoverOptions options;
    options.least_shape = 0.01;
    const RecoverResult result = recover_segments(mesh, neighbors, subsegments, fixed, options);
    EXPECT_GT(result.stats.missing_before, 0u);
    EXPECT_EQ(result.stats.missing_after, 0u);
    for (const Subsegment& subsegment : subsegments) EXPECT_TRUE(is_edge(edges_of(mesh), subsegment));
}

TEST(RecoverSegments, ask_for_no_worse_cells_than_allowed) {
    for (const double least : {0.2, 0.6}) {
        const Drawn drawn(3);
        Drawn now = drawn;
        RecoverOptions options;
        options.least_shape = least;
        options.most_splits = 0;
        const RecoverResult result =
            recover_segments(now.mesh, now.neighbors, now.subsegments, now.fixed, options);
        EXPECT_LT(result.stats.missing_after, result.stats.missing_before);
        for (const std::uint32_t c : result.undecided) {
            const Cell& v = now.mesh.cells[c];
            const Vec3 p = now.mesh.points[v[0]], q = now.mesh.points[v[1]], r = now.mesh.points[v[2]],
                       s = now.mesh.points[v[3]];
            EXPECT_LE(radius_edge_ratio(p, q, r, s), 2 / least * (1 + 1e-9));
        }
    }
}

// What was made for a subsegment is not made where it is left; subsegments not concerned become edges all the
// same.
TEST(RecoverSegments, that_are_left_out_cost_nothing) {
    for (std::uint32_t seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE(seed);
        const Drawn drawn(seed);
        RecoverOptions options;
        options.most_splits = 0;
        Drawn all = drawn;
        const RecoverResult first =
            recover_segments(all.mesh, all.neighbors, all.subsegments, all.fixed, options);
        ASSERT_EQ(first.made_for.size(), first.undecided.size());
        const std::set<MeshEdge> old_edges = edges_of(drawn.mesh);
        for (const MeshEdge& e : first.made_for) EXPECT_EQ(old_edges.count(e), 0u);
        // Every other subsegment for which cells were made.
        const std::set<MeshEdge> made(first.made_for.begin(), first.made_for.end());
        for (const MeshEdge& e : made) {
            if (options.left.empty() || made.size() > 2 * options.left.size()) options.left.push_back(e);
        }
        Drawn some = drawn;
        const RecoverResult then =
            recover_segments(some.mesh, some.neighbors, some.subsegments, some.fixed, options);
        expect_same_domain(drawn.mesh, some.mesh, some.neighbors);
        for (const MeshEdge& e : then.made_for)
            EXPECT_FALSE(std::binary_search(options.left.begin(), options.left.end(), e));
        const std::set<MeshEdge> edges = edges_of(some.mesh);
        const auto missing = [&](const std::vector<Subsegment>& subsegments) {
            return std::count_if(subsegments.begin(), subsegments.end(),
                                 [&](const Subsegment& subsegment) { return !is_edge(edges, subsegment); });
        };
        EXPECT_EQ(then.stats.missing_after, static_cast<std::uint64_t>(missing(some.subsegments)));
        EXPECT_LT(then.stats.missing_after, then.stats.missing_before);
        EXPECT_GT(then.stats.missing_after, first.stats.missing_after);
    }
}

TEST(InsertKeepingSegments, keeps_subsegments_and_the_domain) {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE(seed);
        const Drawn drawn(seed);
        Drawn now = drawn;
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> across(-0.2, 0.2);
        std::vector<Vec3> points;
        std::vector<std::uint32_t> beside;
        for (const Subsegment& subsegment : now.subsegments) {
            const Vec3 middle = 0.5 * (now.mesh.points[subsegment.a] + now.mesh.points[subsegment.b]);
            points.push_back(middle + Vec3{across(random), across(random), across(random)});
            beside.push_back(subsegment.a);
        }
        const std::vector<std::uint32_t> made = insert_keeping_segments(
            now.mesh, now.neighbors, points, beside, now.subsegments, now.fixed, 0.05);
        expect_same_domain(drawn.mesh, now.mesh, now.neighbors);
        expect_kept(drawn, now.mesh);
        EXPECT_GT(now.mesh.points.size(), drawn.mesh.points.size() + points.size() / 2);
        EXPECT_FALSE(made.empty());
        const std::set<MeshEdge> old_edges = edges_of(drawn.mesh), edges = edges_of(now.mesh);
        for (const Subsegment& subsegment : drawn.subsegments) {
            EXPECT_TRUE(is_edge(edges, subsegment) || !is_edge(old_edges, subsegment));
        }
    }
}

}  // namespace
}  // namespace anatomesh::recover_segments_test
