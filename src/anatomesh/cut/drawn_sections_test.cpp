// Laws of the sections of a labelled mesh by slices' planes.
#include "anatomesh/cut/drawn_sections.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>

#include "anatomesh/cut/relabel.h"
#include "anatomesh/cut/resolve_nonmanifold.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::drawn_sections_test {
namespace {

using namespace fixtures;

constexpr std::uint32_t in_planes = 120;

// Random points in three planes and between them, in a large box; the cells are of the balls at their
// centroids, but for one in `astray`, which is of any region.
struct Case {
    AnalyticField field;
    TetMesh mesh;
    std::vector<CellNeighbors> neighbors;
    RegionRegistry registry;
    std::vector<std::uint32_t> slice_of;
    std::vector<Plane> planes;

    Case(std::uint32_t seed, bool exclusive, unsigned astray)
        : field({ball({-0.3, 0, 0}, 0.6), ball({0.3, 0, 0.1}, 0.5)}, 1, exclusive), registry(exclusive) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> coordinate(-1, 1);
        std::vector<Vec3> points;
        for (std::uint32_t n = 0; n < 2 * in_planes; ++n) {
            Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
            slice_of.push_back(n < in_planes ? n % 3 : SlicePlanes::no_slice);
            if (n < in_planes) p.z = 0.4 * (static_cast<double>(n % 3) - 1);
            points.push_back(p);
        }
        for (int k = -1; k <= 1; ++k) planes.push_back(make_plane({0, 0, 0.4 * k}, {0, 0, 1}));
        for (int corner = 0; corner < 8; ++corner)
            points.push_back({corner & 1 ? 9.0 : -9.0, corner & 2 ? 9.0 : -9.0, corner & 4 ? 9.0 : -9.0});
        auto made = Tetrahedralization::create(points);
        EXPECT_TRUE(made.ok());
        const DelaunaySnapshot& snapshot = made.value().snapshot();
        mesh.points = made.value().points();
        mesh.cells = snapshot.cells;
        neighbors = snapshot.neighbors;
        std::vector<std::uint32_t> members;
        for (const Cell& cell : mesh.cells) {
            Vec3 centre{};
            for (const std::uint32_t v : cell) centre = centre + 0.25 * mesh.points[v];
            field.members(centre, members);
            const bool outer =
                std::any_of(cell.begin(), cell.end(), [](std::uint32_t v) { return v >= 2 * in_planes; });
            if (!outer && random() % astray == 0)
                members = random() % 2 ? std::vector<std::uint32_t>{0} : std::vector<std::uint32_t>{};
            mesh.regions.push_back(outer ? Region{0} : registry.intern(members));
        }
    }

    SlicePlanes slices() const { return {slice_of, planes, &field, 2}; }

    // Two planes that cross each other, and one on which nothing is drawn of the second structure.
    std::vector<Plane> crossing_planes{make_plane({0, 0, 0.05}, {0.2, 0.1, 1}),
                                       make_plane({0.1, 0, 0}, {1, 0.3, 0.2})};
    std::vector<Box2> extents{{{-1, -1}, {1, 1}}, {{-0.4, -0.5}, {0.5, 0.6}}};
    std::vector<double> weights{1.5, 0.5, 2, 0};

    SlicePlanes crossing_slices() const {
        return {{}, {}, &field, 2, {crossing_planes, extents, 1e-12}, weights};
    }

    // Of all sections by planes that cross.
    double wrong_weight() const {
        double sum = 0;
        for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
            std::array<Vec3, 4> corners;
            for (std::size_t i = 0; i < 4; ++i) corners[i] = mesh.points[mesh.cells[c][i]];
            for_each_section(corners, crossing_slices().crossing,
                             [&](std::uint32_t k, const PlaneSection& section) {
                                 std::vector<std::uint32_t> drawn;
                                 field.members(section.middle, drawn);
                                 for (std::uint32_t s = 0; s < 2; ++s) {
                                     const bool is = registry.table().contains(mesh.regions[c], s);
                                     if (is != std::binary_search(drawn.begin(), drawn.end(), s))
                                         sum += section.area * weights[2 * s + k];
                                 }
                             });
        }
        return sum;
    }

    std::size_t wrong_at(Vec3 p, std::vector<std::uint32_t> cut) const {
        std::vector<std::uint32_t> drawn, wrong;
        field.members(p, drawn);
        std::sort(cut.begin(), cut.end());
        cut.erase(std::unique(cut.begin(), cut.end()), cut.end());
        std::set_symmetric_difference(cut.begin(), cut.end(), drawn.begin(), drawn.end(),
                                      std::back_inserter(wrong));
        return wrong.size();
    }

    // Of all facets in planes, and of all sections with a vertex in theirs: the corners of a section are
    // those of the cell in the plane and the crossings of its edges, and its area is that of their hull, a
    // triangle.
    double wrong_area() const {
        double sum = 0;
        for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
            const Cell& cell = mesh.cells[c];
            for (std::uint32_t k = 0; k < 3; ++k) {
                std::vector<Vec3> corners;
                bool above = false, below = false;
                std::uint32_t on = 0, apex = 0;
                for (std::uint32_t i = 0; i < 4; ++i) {
                    const double height = mesh.points[cell[i]].z - planes[k].origin.z;
                    above |= height > 0;
                    below |= height < 0;
                    on += height == 0;
                    if (height == 0) corners.push_back(mesh.points[cell[i]]);
                    if (height != 0) apex = i;
                }
                if (on == 0 || on == 4) continue;
                std::vector<std::uint32_t> cut = registry.table().members[mesh.regions[c]];
                double share = 1;
                if (on == 3) {
                    const std::uint32_t beyond = neighbors[c][apex];
                    const auto& other = registry.table().members[mesh.regions[beyond]];
                    cut.insert(cut.end(), other.begin(), other.end());
                    share = 0.5;
                } else {
                    if (!above || !below) continue;
                    for (std::uint32_t i = 0; i < 4; ++i) {
                        for (std::uint32_t j = 0; j < i; ++j) {
                            const Vec3 p = mesh.points[cell[i]], q = mesh.points[cell[j]];
                            const double z = planes[k].origin.z;
                            if ((p.z - z) * (q.z - z) < 0)
                                corners.push_back(p + (z - p.z) / (q.z - p.z) * (q - p));
                        }
                    }
                }
                if (corners.size() != 3) {
                    ADD_FAILURE() << corners.size() << " corners";
                    continue;
                }
                const double area = 0.5 * length(cross(corners[1] - corners[0], corners[2] - corners[0]));
                const Vec3 middle = (1.0 / 3) * (corners[0] + corners[1] + corners[2]);
                sum += share * area * static_cast<double>(wrong_at(middle, cut));
            }
        }
        return sum;
    }
};

TEST(DrawnSections, where_planes_cross_the_change_is_that_of_the_whole_mesh_by_weight) {
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        Case random(seed, seed == 2, 4);
        DrawnSections sections(random.mesh.points, random.mesh.cells, random.neighbors, random.mesh.regions,
                               random.registry.table(), random.crossing_slices());
        std::mt19937 choose(seed);
        int changed = 0, mended = 0;
        for (int n = 0; n < 150; ++n) {
            std::vector<std::uint32_t> moved{static_cast<std::uint32_t>(choose() % random.mesh.cells.size())};
            const std::uint32_t beside = random.neighbors[moved[0]][choose() % 4];
            if (beside != no_cell && n % 2) moved.push_back(beside);
            const Region to =
                random.registry.intern(n % 3 ? std::vector<std::uint32_t>{0} : std::vector<std::uint32_t>{});
            const double before = random.wrong_weight(), told = sections.change(moved, to);
            for (const std::uint32_t c : moved) random.mesh.regions[c] = to;
            EXPECT_NEAR(random.wrong_weight() - before, told, 1e-12);
            changed += std::abs(told) > 1e-9;
            // What is wanted makes a cell's largest part right.
            if (const std::vector<std::uint32_t>* wanted = sections.wanted(moved[0])) {
                const Region drawn = random.registry.intern(*wanted);
                EXPECT_NE(drawn, random.mesh.regions[moved[0]]);
                mended += sections.change(std::span(moved).first(1), drawn) < 0;
            }
        }
        EXPECT_GT(changed, 20);
        EXPECT_GT(mended, 5);
    }
}

TEST(DrawnSections, the_change_is_that_of_the_whole_mesh) {
    double least = 0, most = 0;
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
        Case random(seed, seed % 2 == 0, 5);
        DrawnSections sections(random.mesh.points, random.mesh.cells, random.neighbors, random.mesh.regions,
                               random.registry.table(), random.slices());
        std::mt19937 choice(seed);
        for (int move = 0; move < 40; ++move) {
            const auto c = static_cast<std::uint32_t>(choice() % random.mesh.cells.size());
            std::vector<std::uint32_t> cells{c};
            if (const std::uint32_t n = random.neighbors[c][choice() % 4]; n != no_cell && move % 2)
                cells.push_back(n);
            const auto to = static_cast<Region>(choice() % random.registry.table().members.size());
            const double before = random.wrong_area(), change = sections.change(cells, to);
            for (const std::uint32_t moved : cells) random.mesh.regions[moved] = to;
            EXPECT_NEAR(random.wrong_area() - before, change, 1e-12) << seed;
            least = std::min(least, change);
            most = std::max(most, change);
        }
    }
    EXPECT_LT(least, 0);
    EXPECT_GT(most, 0);
}

// But for cells that several planes cut.
TEST(DrawnSections, what_is_wanted_makes_less_wrong) {
    std::size_t wanted = 0, less = 0;
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
        Case random(seed, true, 4);
        DrawnSections sections(random.mesh.points, random.mesh.cells, random.neighbors, random.mesh.regions,
                               random.registry.table(), random.slices());
        for (std::uint32_t c = 0; c < random.mesh.cells.size(); ++c) {
            const std::vector<std::uint32_t>* drawn = sections.wanted(c);
            if (!drawn) continue;
            ++wanted;
            EXPECT_NE(*drawn, random.registry.table().members[random.mesh.regions[c]]);
            const Region to = random.registry.intern(*drawn);
            less += sections.change(std::array{c}, to) < 0;
        }
    }
    EXPECT_GT(wanted, 100u);
    EXPECT_GT(10 * less, 9 * wanted);
}

// With slices to look at: as manifold as without, and sections that are nearer to what is drawn.
TEST(DrawnSections, relabelling_keeps_the_cuts) {
    double without = 0, with = 0;
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        for (const bool look : {false, true}) {
            Case random(seed, seed % 2 == 0, 12);
            const VertexStars stars(random.mesh.cells, random.mesh.points.size());
            std::vector<std::uint32_t> nonmanifold;
            const RelabelStats stats =
                relabel({random.mesh.points,
                         random.mesh.cells,
                         random.neighbors,
                         stars,
                         {},
                         {},
                         random.mesh.regions,
                         random.registry},
                        {}, nonmanifold, {}, 1, look ? random.slices() : SlicePlanes{});
            EXPECT_LT(stats.nonmanifold_after, stats.nonmanifold_before);
            (look ? with : without) += random.wrong_area();
            const auto split = resolve_nonmanifold(random.mesh, nonmanifold, {}, random.registry, {});
            ASSERT_TRUE(split.ok()) << to_line(split.error());
            for (std::uint32_t structure = 0; structure < 2; ++structure) {
                const SurfaceTopology t =
                    surface_topology(structure_surface(random.mesh, random.registry.table(), structure));
                EXPECT_EQ(t.open_edges + t.nonmanifold_edges + t.nonmanifold_vertices, 0u) << seed;
            }
        }
    }
    EXPECT_LT(with, 0.5 * without);
    RecordProperty("mm2", std::to_string(without) + " -> " + std::to_string(with));
}

}  // namespace
}  // namespace anatomesh::drawn_sections_test
