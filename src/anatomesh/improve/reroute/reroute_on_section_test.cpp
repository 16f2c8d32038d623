#include "anatomesh/improve/reroute/reroute_on_section.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::reroute_on_section_test {
namespace {

constexpr double any_sine = 0;

// A labelled mesh with vertices of its first structure's surface moved into planes through the z axis or at
// right angles to it, and a contour in each through these.
struct Drawn {
    fixtures::LabelledCase labelled;
    std::vector<std::uint32_t> neighbors;
    std::vector<Contour> contours;
    std::vector<std::uint32_t> vertices;
    std::vector<Plane> planes;
    std::vector<std::array<std::uint32_t, 2>> owned;
    ContourOwners owners;

    // A ball's surface in planes at these heights, by every so manieth of the vertices near each.
    Drawn(fixtures::LabelledCase made, const std::vector<Plane>& in, std::size_t every)
        : labelled(std::move(made)), planes(in) {
        TetMesh& mesh = labelled.mesh;
        neighbors = cell_neighbors(mesh.cells, mesh.points.size());
        for (std::uint32_t slice = 0; slice < planes.size(); ++slice) draw(slice, every);
        owners = ContourOwners(owned, mesh.points.size());
        labelled.fixed.assign(mesh.points.size(), 0);
        for (std::size_t f = 0; f < neighbors.size(); ++f) {
            if (neighbors[f] != no_cell) continue;
            for (const int k : facet_vertices[f % 4]) labelled.fixed[mesh.cells[f / 4][k]] = 1;
        }
        for (const std::uint32_t v : vertices) labelled.fixed[v] = 1;
    }

    // The nearest vertices of the surface in turn round the plane's origin, moved into it as far as cells
    // stay positive.
    void draw(std::uint32_t slice, std::size_t every) {
        TetMesh& mesh = labelled.mesh;
        const Plane& plane = planes[slice];
        const std::vector<std::uint8_t> on = fixtures::on_surface(mesh, labelled.regions, 0);
        std::map<int, std::pair<double, std::uint32_t>> by_turn;
        constexpr int turns = 48;
        for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
            if (!on[v]) continue;
            const Vec2 at = plane.to_plane(mesh.points[v]);
            const double turn = std::atan2(at.y, at.x) / (2 * std::numbers::pi) + 0.5;
            const std::pair<double, std::uint32_t> found{std::abs(plane.signed_distance(mesh.points[v])), v};
            const auto [place, is_new] = by_turn.try_emplace(static_cast<int>(turn * turns), found);
            if (!is_new) place->second = std::min(place->second, found);
        }
        const auto first = static_cast<std::uint32_t>(vertices.size());
        std::size_t count = 0;
        for (const auto& [turn, found] : by_turn) {
            if (count++ % every != 0 || !move(found.second, plane)) continue;
            vertices.push_back(found.second);
            owned.push_back({found.second, 0});
        }
        contours.push_back({0, slice, first, static_cast<std::uint32_t>(vertices.size()) - first});
    }

    bool move(std::uint32_t v, const Plane& plane) {
        TetMesh& mesh = labelled.mesh;
        const Vec3 from = mesh.points[v];
        mesh.points[v] = plane.to_space(plane.to_plane(from));
        for (const Cell& c : mesh.cells) {
            if (std::find(c.begin(), c.end(), v) == c.end()) continue;
            if (orient3d(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]) > 0)
                continue;
            mesh.points[v] = from;
            return false;
        }
        return true;
    }
};

struct Routed {
    TetMesh mesh;
    RerouteStats stats;
    std::vector<std::uint8_t> fixed;
};

Routed reroute(const Drawn& drawn, double most_mm, double least_sine = any_sine, double last_sine = 1) {
    Routed result;
    result.fixed = drawn.labelled.fixed;
    EditMesh mesh(drawn.labelled.mesh, drawn.neighbors);
    MeshImprovementOptions options;
    options.last_radius_edge = 1000;
    EditContext edit(mesh, result.fixed, {}, drawn.labelled.field, drawn.labelled.structures, options);
    edit.table = &drawn.labelled.regions;
    DrawnSlices slices;
    slices.table = &drawn.labelled.regions;
    slices.owners = &drawn.owners;
    slices.routable = {drawn.contours, drawn.vertices, drawn.planes, false, most_mm};
    std::vector<std::uint8_t> constraint_limited(drawn.labelled.mesh.points.size(), 0);
    slices.constraint_limited = constraint_limited;
    const auto as_they_are = [](const std::vector<std::uint32_t>&) { return std::vector<std::uint32_t>{}; };
    result.stats =
        reroute_on_section(edit, slices, constraint_limited, least_sine, last_sine, as_they_are, {});
    std::vector<std::uint32_t> neighbors = drawn.neighbors;
    result.mesh = std::move(mesh).take(neighbors);
    return result;
}

using Edges = std::set<std::array<std::uint32_t, 2>>;

Edges edges_of_surface(const TetMesh& mesh, const RegionTable& regions) {
    Edges edges;
    for (const Triangle& f : structure_surface(mesh, regions, 0)) {
        for (int k = 0; k < 3; ++k) {
            edges.insert({f[k], f[(k + 1) % 3]});
            edges.insert({f[(k + 1) % 3], f[k]});
        }
    }
    return edges;
}

std::vector<Vec3> row_of(const TetMesh& mesh, std::span<const std::uint32_t> vertices) {
    std::vector<Vec3> row;
    for (const std::uint32_t v : vertices) row.push_back(mesh.points[v]);
    row.push_back(row.front());
    return row;
}

double farthest(const std::vector<Vec3>& row, const std::vector<Vec3>& other) {
    double most = 0;
    for (const Vec3 p : row) {
        double least = HUGE_VAL;
        for (std::size_t n = 1; n < other.size(); ++n) {
            const Vec3 a = other[n - 1], way = other[n] - a;
            const double along = std::clamp(dot(p - a, way) / squared_length(way), 0.0, 1.0);
            least = std::min(least, length(p - a - along * way));
        }
        most = std::max(most, least);
    }
    return most;
}

std::size_t missed_of(const Edges& edges, std::span<const std::uint32_t> vertices) {
    std::size_t missed = 0;
    for (std::size_t n = 0; n < vertices.size(); ++n)
        missed += !edges.contains({vertices[n], vertices[(n + 1) % vertices.size()]});
    return missed;
}

std::vector<Drawn> drawn_cases() {
    std::vector<Drawn> cases;
    const std::vector<Plane> stack{make_plane({0, 0, -2.1}, {0, 0, 1}), make_plane({0, 0, 0.3}, {0, 0, 1}),
                                   make_plane({0, 0, 2.6}, {0, 0, 1})};
    const std::vector<Plane> tilted{make_plane({0.2, 0.1, 0.4}, {1, 2, 3})};
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        for (const std::vector<Plane>& planes : {stack, tilted}) {
            for (const std::size_t every : {std::size_t{1}, std::size_t{3}}) {
                cases.emplace_back(fixtures::random_case(
                                       "ball", fixtures::AnalyticField({fixtures::ball({}, 7)}, 9), 1, seed),
                                   planes, every);
            }
        }
    }
    return cases;
}

TEST(RerouteOnSection, contours_are_edges_of_the_surface_in_their_planes) {
    std::size_t missed_before = 0, missed_after = 0, rerouted = 0;
    for (const Drawn& drawn : drawn_cases()) {
        const Routed routed = reroute(drawn, 3);
        fixtures::expect_sound_mesh(routed.mesh, drawn.labelled.mesh);
        fixtures::expect_same_surfaces(routed.mesh, drawn.labelled.mesh, drawn.labelled.regions, 1);
        const Edges before = edges_of_surface(drawn.labelled.mesh, drawn.labelled.regions),
                    after = edges_of_surface(routed.mesh, drawn.labelled.regions);
        std::map<std::uint32_t, const RoutedContour*> by_contour;
        for (const RoutedContour& contour : routed.stats.routed) by_contour[contour.contour] = &contour;
        std::size_t missed_here = 0;
        for (std::uint32_t c = 0; c < drawn.contours.size(); ++c) {
            const auto was = std::span(drawn.vertices)
                                 .subspan(drawn.contours[c].first_point, drawn.contours[c].point_count);
            missed_here += missed_of(before, was);
            const auto found = by_contour.find(c);
            if (found == by_contour.end()) {
                missed_after += missed_of(after, was);
                continue;
            }
            const RoutedContour& now = *found->second;
            missed_after += missed_of(after, now.vertices);
            rerouted += now.segments;
            EXPECT_GT(now.segments, 0u);
            // In the plane, near what was drawn - as near as is said - and never twice at one vertex.
            const std::vector<Vec3> row = row_of(routed.mesh, now.vertices),
                                    drawn_row = row_of(drawn.labelled.mesh, was);
            for (const Vec3 p : row) EXPECT_LT(std::abs(drawn.planes[c].signed_distance(p)), 1e-9);
            EXPECT_LE(now.farthest_mm, 3);
            EXPECT_LE(farthest(row, drawn_row), now.farthest_mm + 1e-9);
            EXPECT_LE(farthest(drawn_row, row), now.farthest_mm + 1e-9);
            std::vector<std::uint32_t> distinct = now.vertices;
            sort_distinct(distinct);
            EXPECT_EQ(distinct.size(), now.vertices.size());
            for (const std::uint32_t v : now.vertices) EXPECT_TRUE(routed.fixed[v]);
        }
        EXPECT_EQ(routed.stats.missed, missed_here);
        missed_before += missed_here;
    }
    EXPECT_GT(missed_before, 100u);
    // Shapes are not improved here: some would be too flat, and ways may cross others that are.
    EXPECT_LE(missed_after, missed_before / 3);
    EXPECT_EQ(rerouted, missed_before - missed_after);
}

TEST(RerouteOnSection, only_free_vertices_of_the_surface_move_and_not_far) {
    constexpr double most_mm = 1;
    for (const Drawn& drawn : drawn_cases()) {
        const Routed routed = reroute(drawn, most_mm);
        const TetMesh& before = drawn.labelled.mesh;
        std::vector<double> longest(before.points.size(), 0);
        for (const auto& [a, b] : edges_of_surface(before, drawn.labelled.regions))
            longest[a] = std::max(longest[a], length(before.points[b] - before.points[a]));
        // Along an edge, and then towards what is drawn.
        for (std::size_t v = 0; v < before.points.size(); ++v) {
            const double moved = length(routed.mesh.points[v] - before.points[v]);
            const bool may_move = !drawn.labelled.fixed[v] && longest[v] > 0;
            EXPECT_LE(moved, may_move ? longest[v] + most_mm : 0.0);
        }
    }
}

TEST(RerouteOnSection, none_goes_further_than_it_may) {
    const Drawn drawn = std::move(drawn_cases()[1]);
    std::uint64_t rerouted = 0;
    for (const double most_mm : {0.05, 0.2, 0.5, 1.0, 3.0}) {
        const Routed routed = reroute(drawn, most_mm);
        std::uint64_t segments = 0;
        for (const RoutedContour& contour : routed.stats.routed) {
            EXPECT_LE(contour.farthest_mm, most_mm);
            segments += contour.segments;
        }
        EXPECT_GE(segments + 2, rerouted) << most_mm;  // more room, more ways
        rerouted = segments;
    }
    EXPECT_GT(rerouted, 0u);
    // Where nothing may move nothing does.
    const Routed none = reroute(drawn, 0);
    EXPECT_TRUE(none.stats.routed.empty());
    EXPECT_EQ(none.mesh.cells, drawn.labelled.mesh.cells);
}

TEST(RerouteOnSection, cells_that_come_out_flat_are_taken_back) {
    for (const Drawn& drawn : drawn_cases()) {
        const double least = 0.02;
        const Routed routed = reroute(drawn, 3, least);
        std::vector<std::uint32_t> changed = routed.stats.changed;
        sort_distinct(changed);
        if (routed.stats.routed.empty()) {
            EXPECT_EQ(fixtures::worst_sine(routed.mesh), fixtures::worst_sine(drawn.labelled.mesh));
            continue;
        }
        // Forced ones may be as flat as recover_on_surface.h has it.
        EXPECT_GE(fixtures::worst_sine(routed.mesh),
                  std::min(fixtures::worst_sine(drawn.labelled.mesh), least_limited_sine));
    }
}

// No more than ten segments are left by these contours: what strict shapes refuse is re-routed at last by
// others.
TEST(RerouteOnSection, the_last_segments_may_ask_for_worse_shapes) {
    constexpr double strict = 0.3;
    std::size_t gained = 0, few = 0;
    for (Drawn& drawn : drawn_cases()) {
        if (drawn.contours.size() > 1) continue;
        const auto missed_after = [&](double last_sine) {
            const Routed routed = reroute(drawn, 3, strict, last_sine);
            const Edges edges = edges_of_surface(routed.mesh, drawn.labelled.regions);
            return routed.stats.routed.empty() ? missed_of(edges, drawn.vertices)
                                               : missed_of(edges, routed.stats.routed[0].vertices);
        };
        const std::size_t kept = missed_after(1), at_last = missed_after(any_sine);
        EXPECT_LE(at_last, kept);
        if (kept > 10) {
            EXPECT_EQ(at_last, kept);  // too many
            continue;
        }
        ++few;
        gained += kept - at_last;
    }
    EXPECT_GT(few, 0u);
    EXPECT_GT(gained, 0u);
}

TEST(RerouteOnSection, contours_that_are_edges_already_stay_as_they_are) {
    // What came of one run, as far as it is whole, is given to the next.
    std::size_t whole = 0;
    for (Drawn& drawn : drawn_cases()) {
        Routed routed = reroute(drawn, 3);
        const Edges edges = edges_of_surface(routed.mesh, drawn.labelled.regions);
        std::vector<Contour> contours;
        std::vector<std::uint32_t> vertices;
        for (const RoutedContour& contour : routed.stats.routed) {
            if (missed_of(edges, contour.vertices) > 0) continue;
            const Contour& was = drawn.contours[contour.contour];
            contours.push_back({was.structure, was.slice, static_cast<std::uint32_t>(vertices.size()),
                                static_cast<std::uint32_t>(contour.vertices.size())});
            vertices.insert(vertices.end(), contour.vertices.begin(), contour.vertices.end());
        }
        whole += contours.size();
        drawn.labelled.mesh = routed.mesh;
        drawn.labelled.fixed = routed.fixed;
        drawn.neighbors = cell_neighbors(routed.mesh.cells, routed.mesh.points.size());
        drawn.contours = contours;
        drawn.vertices = vertices;
        const Routed again = reroute(drawn, 3);
        EXPECT_EQ(again.stats.missed, 0u);
        EXPECT_TRUE(again.stats.routed.empty());
        EXPECT_EQ(again.mesh.points, routed.mesh.points);
        EXPECT_EQ(again.mesh.cells, routed.mesh.cells);
    }
    EXPECT_GT(whole, 2u);
}

}  // namespace
}  // namespace anatomesh::reroute_on_section_test
