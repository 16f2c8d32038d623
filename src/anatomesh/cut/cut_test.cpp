// Laws of the cut stage: whatever the labels, every structure's surface ends as a closed 2-manifold.
#include <gtest/gtest.h>

#include <random>

#include "anatomesh/cut/relabel.h"
#include "anatomesh/cut/resolve_nonmanifold.h"
#include "anatomesh/cut/spurious_components.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh::cut_test {
namespace {

struct Case {
    TetMesh mesh;
    std::vector<CellNeighbors> neighbors;
    RegionRegistry registry;
};

// Random points in a ball inside a large box; cells of the ball get random regions, the rest is outside.
Case random_case(std::uint32_t seed, std::size_t count, const std::vector<std::vector<std::uint32_t>>& sets,
                 bool exclusive = false) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-1, 1);
    std::vector<Vec3> points;
    while (points.size() < count) {
        const Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
        if (squared_length(p) < 1) points.push_back(p);
    }
    for (int corner = 0; corner < 8; ++corner) {
        points.push_back({corner & 1 ? 9.0 : -9.0, corner & 2 ? 9.0 : -9.0, corner & 4 ? 9.0 : -9.0});
    }
    auto made = Tetrahedralization::create(points);
    EXPECT_TRUE(made.ok());
    const DelaunaySnapshot& snapshot = made.value().snapshot();
    Case result;
    result.registry = RegionRegistry(exclusive);
    result.mesh.points = made.value().points();
    result.mesh.cells = snapshot.cells;
    result.neighbors = snapshot.neighbors;
    for (const Cell& cell : snapshot.cells) {
        const bool outer = std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return v >= count; });
        result.mesh.regions.push_back(outer ? Region{0}
                                            : result.registry.intern(sets[random() % sets.size()]));
    }
    return result;
}

double total_volume(const TetMesh& mesh) {
    double sum = 0;
    for (const Cell& c : mesh.cells) {
        sum += signed_volume(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]);
    }
    return sum;
}

void expect_manifold_surface(const TetMesh& mesh, const RegionTable& table, std::uint32_t structure) {
    const SurfaceTopology t = surface_topology(structure_surface(mesh, table, structure));
    EXPECT_EQ(t.open_edges, 0u);
    EXPECT_EQ(t.nonmanifold_edges, 0u);
    EXPECT_EQ(t.nonmanifold_vertices, 0u);
}

void expect_manifold(const Case& result, std::uint32_t structures) {
    for (const Cell& c : result.mesh.cells) {
        ASSERT_GT(orient3d(result.mesh.points[c[0]], result.mesh.points[c[1]], result.mesh.points[c[2]],
                           result.mesh.points[c[3]]),
                  0);
    }
    for (std::uint32_t structure = 0; structure < structures; ++structure) {
        expect_manifold_surface(result.mesh, result.registry.table(), structure);
    }
    // Every region by itself, and the union of all.
    const std::size_t regions = result.registry.table().members.size();
    RegionTable single{{{}}}, all{{{}}};
    for (std::size_t r = 1; r < regions; ++r) {
        single.members.push_back({static_cast<std::uint32_t>(r)});
        all.members.push_back({0});
    }
    for (std::uint32_t r = 1; r < regions; ++r) expect_manifold_surface(result.mesh, single, r);
    expect_manifold_surface(result.mesh, all, 0);
}

void cut_and_check(Case& random, std::uint32_t structures, const ContourOwners& owners, bool relabel_first) {
    const double volume = total_volume(random.mesh);
    std::vector<std::uint32_t> nonmanifold;
    if (relabel_first) {
        const VertexStars stars(random.mesh.cells, random.mesh.points.size());
        const RelabelStats stats = relabel({random.mesh.points,
                                            random.mesh.cells,
                                            random.neighbors,
                                            stars,
                                            owners,
                                            {},
                                            random.mesh.regions,
                                            random.registry},
                                           {}, nonmanifold);
        EXPECT_LT(stats.nonmanifold_after, stats.nonmanifold_before);
    } else {
        for (std::uint32_t v = 0; v + 8 < random.mesh.points.size(); ++v) nonmanifold.push_back(v);
    }
    const auto split = resolve_nonmanifold(random.mesh, nonmanifold, owners, random.registry, {});
    ASSERT_TRUE(split.ok()) << to_line(split.error());
    expect_manifold(random, structures);
    EXPECT_NEAR(total_volume(random.mesh), volume, 1e-9 * volume);
}

TEST(Cut, random_labels_of_one_structure_end_as_a_manifold) {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        Case random = random_case(seed, 60, {{}, {0}});
        cut_and_check(random, 1, {}, seed % 2 == 0);
    }
}

TEST(Cut, random_labels_of_three_exclusive_structures_end_as_manifolds) {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        Case random = random_case(seed, 60, {{}, {0}, {1}, {2}});
        cut_and_check(random, 3, {}, true);
    }
}

TEST(Cut, random_labels_of_overlapping_structures_end_as_manifolds) {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        Case random = random_case(seed, 60, {{}, {0}, {0, 1}, {1}});
        cut_and_check(random, 2, {}, true);
    }
}

// Every vertex of the ball is a contour vertex: none may be lost, with labels that lose many at first.
TEST(Cut, contour_vertices_are_brought_onto_the_surface) {
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
        Case random = random_case(seed, 40,
                                  seed % 2 ? std::vector<std::vector<std::uint32_t>>{{}, {}, {}, {0}}
                                           : std::vector<std::vector<std::uint32_t>>{{}, {0}, {0}, {0}});
        std::vector<std::array<std::uint32_t, 2>> pairs;
        for (std::uint32_t v = 0; v < 40; v += 2) pairs.push_back({v, 0});
        const ContourOwners owners(pairs, random.mesh.points.size());
        cut_and_check(random, 1, owners, true);
        std::vector<std::uint8_t> on_surface(random.mesh.points.size(), 0);
        for (const Triangle& t : structure_surface(random.mesh, random.registry.table(), 0)) {
            for (const std::uint32_t v : t) on_surface[v] = 1;
        }
        for (const auto& pair : pairs) EXPECT_TRUE(on_surface[pair[0]]);
    }
}

// Contour vertices and subsegments that labels lose are brought back without a cell in both.
TEST(Cut, structures_that_exclude_each_other_never_share_a_cell) {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        Case random = random_case(seed, 60, {{}, {}, {0}, {1}}, true);
        std::vector<std::array<std::uint32_t, 2>> pairs;
        for (std::uint32_t v = 0; v < 40; v += 2) pairs.push_back({v, v / 2 % 2});
        std::vector<std::array<std::uint32_t, 3>> subsegments;
        for (std::size_t c = 0; c < random.mesh.cells.size(); c += 9) {
            const auto [low, high] = std::minmax(random.mesh.cells[c][0], random.mesh.cells[c][1]);
            if (high < 60) subsegments.push_back({low, high, static_cast<std::uint32_t>(c % 2)});
        }
        cut_and_check(random, 2, ContourOwners(pairs, random.mesh.points.size(), subsegments), true);
        for (const auto& members : random.registry.table().members) EXPECT_LE(members.size(), 1u) << seed;
    }
}

TEST(Cut, the_other_side_of_a_structure) {
    RegionRegistry overlapping, exclusive(true);
    for (RegionRegistry* registry : {&overlapping, &exclusive}) {
        const Region first = registry->with_other_side(0, 3);
        EXPECT_EQ(registry->table().members[first], (std::vector<std::uint32_t>{3}));
        EXPECT_EQ(registry->with_other_side(first, 3), 0);
    }
    const Region both = overlapping.with_other_side(overlapping.intern({3}), 1);
    EXPECT_EQ(overlapping.table().members[both], (std::vector<std::uint32_t>{1, 3}));
    EXPECT_EQ(exclusive.with_other_side(exclusive.intern({3}), 1), exclusive.intern({1}));
}

// Edges near a ball's surface, all of it inside: relabelling brings some onto the surface and never loses the manifold for it.
TEST(Cut, subsegments_are_brought_onto_the_surface) {
    std::uint64_t before = 0, after = 0;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        Case random = random_case(seed, 200, {{0}});
        std::vector<std::array<std::uint32_t, 3>> subsegments;
        for (const Cell& cell : random.mesh.cells) {
            if (cell[0] >= 200 || cell[1] >= 200 || subsegments.size() >= 60) continue;
            const Vec3 middle = 0.5 * (random.mesh.points[cell[0]] + random.mesh.points[cell[1]]);
            if (length(middle) > 0.75)
                subsegments.push_back({std::min(cell[0], cell[1]), std::max(cell[0], cell[1]), 0});
        }
        const ContourOwners owners({}, random.mesh.points.size(), subsegments);
        const VertexStars stars(random.mesh.cells, random.mesh.points.size());
        std::vector<std::uint32_t> nonmanifold;
        const RelabelStats stats = relabel({random.mesh.points,
                                            random.mesh.cells,
                                            random.neighbors,
                                            stars,
                                            owners,
                                            {},
                                            random.mesh.regions,
                                            random.registry},
                                           {}, nonmanifold);
        before += stats.lost_subsegments_before;
        after += stats.lost_subsegments_after;
        // Counted anew from the regions.
        std::uint64_t lost = 0;
        std::sort(subsegments.begin(), subsegments.end());
        subsegments.erase(std::unique(subsegments.begin(), subsegments.end()), subsegments.end());
        for (const auto& [a, b, structure] : subsegments) {
            bool in = false, out = false;
            for (std::size_t c = 0; c < random.mesh.cells.size(); ++c) {
                const Cell& cell = random.mesh.cells[c];
                if (std::count(cell.begin(), cell.end(), a) + std::count(cell.begin(), cell.end(), b) < 2)
                    continue;
                (random.mesh.regions[c] == 0 ? out : in) = true;
            }
            lost += in != out;
        }
        EXPECT_EQ(stats.lost_subsegments_after, lost);
        EXPECT_LE(stats.nonmanifold_after, stats.nonmanifold_before);
    }
    EXPECT_GT(before, 10u);
    EXPECT_LT(2 * after, before);
}

// A plane surface through the ball, every edge of it a subsegment, and single cells on the wrong side: these
// are relabelled back, and not, where that mends more vertices at once, the cells between whose loss takes
// subsegments along.
TEST(Cut, labels_that_are_wrong_here_and_there_cost_few_subsegments) {
    std::uint64_t all_subsegments = 0, lost = 0, lost_with_sides = 0, lost_at_once = 0, lost_for_hairs = 0,
                  lost_with_hairs = 0;
    int wrong = 0, wrong_with_sides = 0;
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        Case random = random_case(seed, 300, {{}, {0}});
        const TetMesh& mesh = random.mesh;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const Cell& v = mesh.cells[c];
            const double height =
                mesh.points[v[0]].z + mesh.points[v[1]].z + mesh.points[v[2]].z + mesh.points[v[3]].z;
            const bool outer = std::any_of(v.begin(), v.end(), [](std::uint32_t n) { return n >= 300; });
            random.mesh.regions[c] = !outer && height < 0 ? 1 : 0;
        }
        std::vector<std::uint32_t> nonmanifold;
        const VertexStars stars(mesh.cells, mesh.points.size());
        relabel(
            {mesh.points, mesh.cells, random.neighbors, stars, {}, {}, random.mesh.regions, random.registry},
            {}, nonmanifold);
        std::vector<std::array<std::uint32_t, 3>> subsegments;
        for (const Triangle& t : structure_surface(mesh, random.registry.table(), 0)) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k], b = t[(k + 1) % 3];
                if (std::max(length(mesh.points[a]), length(mesh.points[b])) < 0.8)
                    subsegments.push_back({std::min(a, b), std::max(a, b), 0});
            }
        }
        std::sort(subsegments.begin(), subsegments.end());
        subsegments.erase(std::unique(subsegments.begin(), subsegments.end()), subsegments.end());
        // Vertices of the surface may be on either side, the others on that of their cells.
        std::vector<VertexMembership> sides(mesh.points.size(), {1, 0, 1});
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            for (const std::uint32_t v : mesh.cells[c]) {
                sides[v].interior_of = std::min(sides[v].interior_of, mesh.regions[c]);
                sides[v].closure_of = std::max(sides[v].closure_of, mesh.regions[c]);
            }
        }
        const auto count_wrong = [&] {
            int sum = 0;
            for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
                for (const std::uint32_t v : mesh.cells[c])
                    sum += !allows(random.registry.table(), sides[v], mesh.regions[c]);
            }
            return sum;
        };
        std::mt19937 chance(seed);
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const Cell& v = mesh.cells[c];
            if (std::all_of(v.begin(), v.end(),
                            [&](std::uint32_t n) { return n < 300 && length(mesh.points[n]) < 0.8; }) &&
                chance() % 8 == 0)
                random.mesh.regions[c] = 1 - random.mesh.regions[c];
        }
        const std::vector<Region> noisy = mesh.regions;
        const auto lost_by = [&](const std::vector<VertexMembership>& known, const RelabelOptions& options) {
            random.mesh.regions = noisy;
            return relabel({mesh.points,
                            mesh.cells,
                            random.neighbors,
                            stars,
                            {{}, mesh.points.size(), subsegments},
                            known,
                            random.mesh.regions,
                            random.registry},
                           options, nonmanifold)
                .lost_subsegments_after;
        };
        all_subsegments += subsegments.size();
        lost_at_once += lost_by({}, {0, 0, false});
        lost += lost_by({}, {});
        wrong += count_wrong();
        lost_with_sides += lost_by(sides, {0.1, 0, true});
        wrong_with_sides += count_wrong();
        // Outside by no more than a hair, all of them: that is no reason against a subsegment where hairs do
        // not count.
        const std::vector<VertexMembership> hardly_outside(mesh.points.size(), {0, 0, 0.05});
        lost_for_hairs += lost_by(hardly_outside, {0.1, 0.04, true});
        lost_with_hairs += lost_by(hardly_outside, {0.1, 0.06, true});
    }
    EXPECT_GT(all_subsegments, 1000u);
    EXPECT_EQ(lost, 0u);  // 7 without moves of variable depth
    EXPECT_EQ(lost_at_once, 0u);
    EXPECT_EQ(lost_with_sides, 0u);
    EXPECT_GT(lost_for_hairs, 0u);
    EXPECT_EQ(lost_with_hairs, 0u);
    EXPECT_LT(wrong_with_sides, wrong);
}

// Facet-connected pieces of one region: their volumes, and whether a vertex of theirs is marked.
struct Piece {
    double volume = 0;
    bool marked = false;
};
std::vector<Piece> pieces_of(const TetMesh& mesh, const std::vector<std::uint8_t>& marks) {
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    std::vector<std::uint8_t> seen(mesh.cells.size(), 0);
    std::vector<Piece> pieces;
    for (std::uint32_t first = 0; first < mesh.cells.size(); ++first) {
        if (seen[first]) continue;
        Piece piece;
        std::vector<std::uint32_t> stack{first};
        seen[first] = 1;
        while (!stack.empty()) {
            const std::uint32_t c = stack.back();
            stack.pop_back();
            const Cell& v = mesh.cells[c];
            piece.volume +=
                signed_volume(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
            for (int i = 0; i < 4; ++i) {
                piece.marked |= marks[v[i]] != 0;
                const std::uint32_t next = neighbors[4 * std::size_t{c} + i];
                if (next == no_cell || seen[next] || mesh.regions[next] != mesh.regions[c]) continue;
                seen[next] = 1;
                stack.push_back(next);
            }
        }
        pieces.push_back(piece);
    }
    return pieces;
}

// Specks and cavities of no contour go to what is round them; manifolds stay, and marked vertices keep
// theirs.
TEST(Cut, spurious_components_are_removed) {
    std::uint64_t spurious = 0, marked_components = 0, between_several = 0;
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        const bool two = seed % 2 == 0;
        Case random = two ? random_case(seed, 80, {{}, {}, {}, {0}, {0}, {0}, {0, 1}, {1}})
                          : random_case(seed, 80, {{}, {}, {}, {0}});
        cut_and_check(random, two ? 2 : 1, {}, true);
        std::vector<std::uint8_t> marks(random.mesh.points.size(), 0);
        for (std::uint32_t v = 0; v < 80; v += 10) marks[v] = 1;
        for (std::uint32_t corner = 80; corner < 88; ++corner) marks[corner] = 1;
        const double most = 0.02;
        const auto small = [&](bool marked) {
            const std::vector<Piece> pieces = pieces_of(random.mesh, marks);
            return std::count_if(pieces.begin(), pieces.end(), [&](const Piece& piece) {
                return piece.volume <= most && piece.marked == marked;
            });
        };
        const auto before = small(false), marked_before = small(true);
        const std::vector<std::uint32_t> neighbors =
            cell_neighbors(random.mesh.cells, random.mesh.points.size());
        TetMesh by_threads = random.mesh;
        remove_spurious_components(by_threads, neighbors, marks, {most}, 3);
        const SpuriousComponentStats stats =
            remove_spurious_components(random.mesh, neighbors, marks, {most});
        EXPECT_EQ(by_threads.regions, random.mesh.regions) << seed;
        expect_manifold(random, two ? 2 : 1);
        if (!two) {
            EXPECT_EQ(small(false), 0) << seed;
            EXPECT_EQ(stats.components, static_cast<std::uint64_t>(before)) << seed;
        }
        EXPECT_EQ(small(true), marked_before) << seed;
        if (two) {  // those between several regions
            const auto left = small(false);
            const SpuriousComponentStats more = remove_spurious_components(
                random.mesh, neighbors, marks, {most}, 1, &random.registry.table());
            expect_manifold(random, 2);
            EXPECT_LE(small(false), left - static_cast<std::ptrdiff_t>(more.components)) << seed;
            EXPECT_EQ(small(true), marked_before) << seed;
            between_several += more.components;
        }
        spurious += stats.components;
        marked_components += static_cast<std::uint64_t>(marked_before);
    }
    EXPECT_GT(spurious, 20u);
    EXPECT_GT(between_several, 5u);
    EXPECT_GT(marked_components, 5u);
}

}  // namespace
}  // namespace anatomesh::cut_test
