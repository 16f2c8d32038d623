#include "anatomesh/improve/reroute/snap_round_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/contour/overlay/even_odd_area.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/improve/reroute/routed_contours.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/pipeline/dense_planes_for_test.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh::snap_round_segments_test {
namespace {

using namespace fixtures;

using Edge = std::array<std::uint32_t, 2>;

std::set<Edge> edges_of(const std::vector<Triangle>& surface) {
    std::set<Edge> edges;
    for (const Triangle& f : surface) {
        for (std::size_t i = 0; i < 3; ++i) edges.insert({f[i], f[(i + 1) % 3]});
    }
    return edges;
}

double distance_from(Vec3 p, Vec3 a, Vec3 b) {
    const Vec3 way = b - a;
    return length(p - a - std::clamp(dot(p - a, way) / squared_length(way), 0.0, 1.0) * way);
}

// A contour as it is drawn and as it runs on the mesh.
struct Both {
    std::vector<Vec3> drawn;
    std::vector<std::uint32_t> rerouted;
};

class Routed {
  public:
    Routed(TetMesh mesh, RegionTable regions, ContourSet set, std::vector<std::uint32_t> vertex_of)
        : mesh_(std::move(mesh)),
          regions_(std::move(regions)),
          set_(std::move(set)),
          vertex_of_(std::move(vertex_of)),
          neighbors_(cell_neighbors(mesh_.cells, mesh_.points.size())) {}

    std::vector<RoutedContour> rerouted(double most_mm, int threads = 1) const {
        return snap_round_segments(mesh_, neighbors_, regions_, set_, vertex_of_, {}, {most_mm, threads});
    }

    const TetMesh& mesh() const { return mesh_; }
    const ContourSet& set() const { return set_; }

    // Segments of contours, re-routed or not, that are no chains of edges.
    std::size_t missed(const std::vector<RoutedContour>& routed) const {
        std::size_t missed = 0;
        for (std::uint32_t s = 0; s < set_.structures.size(); ++s) {
            const std::set<Edge> edges = edges_of(structure_surface(mesh_, regions_, s));
            for (std::uint32_t c = 0; c < set_.contours.size(); ++c) {
                if (set_.contours[c].structure != s) continue;
                const std::vector<std::uint32_t> ring = ring_of(routed, c);
                for (std::size_t n = 0; n < ring.size(); ++n)
                    missed += !is_chain(edges, ring[n], ring[(n + 1) % ring.size()]);
            }
        }
        return missed;
    }

    std::vector<std::uint32_t> ring_of(const std::vector<RoutedContour>& routed, std::uint32_t c) const {
        for (const RoutedContour& one : routed) {
            if (one.contour == c) return one.vertices;
        }
        const auto first = vertex_of_.begin() + set_.contours[c].first_point;
        return {first, first + set_.contours[c].point_count};
    }

    // Slices whose contours touch, cross or turn over, as they are re-routed.
    std::size_t unsound(const std::vector<RoutedContour>& routed) const {
        const ContourSet rerouted = route_contours(set_, vertex_of_, routed, mesh_.points).contours;
        return static_cast<std::size_t>(
            std::count_if(rerouted.slices.begin(), rerouted.slices.end(), [&](const Slice& slice) {
                return !slice_faults(plane_rings(rerouted, slice), rerouted.exclusive).empty();
            }));
    }

  private:
    // Brute force: edges one after the other, none of whose ends is off the line.
    bool is_chain(const std::set<Edge>& edges, std::uint32_t a, std::uint32_t b) const {
        const Vec3 p = mesh_.points[a], q = mesh_.points[b];
        for (std::uint32_t at = a; at != b;) {
            std::uint32_t next = no_cell;
            double reached = HUGE_VAL;
            for (auto e = edges.lower_bound({at, 0}); e != edges.end() && (*e)[0] == at; ++e) {
                const Vec3 v = mesh_.points[(*e)[1]];
                const double along = dot(v - mesh_.points[at], q - p);
                if (along <= 0 || along >= reached || distance_from(v, p, q) > 1e-6 * length(q - p)) continue;
                reached = along;
                next = (*e)[1];
            }
            if (next == no_cell) return false;
            at = next;
        }
        return true;
    }

    TetMesh mesh_;
    RegionTable regions_;
    ContourSet set_;
    std::vector<std::uint32_t> vertex_of_;
    std::vector<std::uint32_t> neighbors_;
};

Routed built(const ContourSet& set, std::uint64_t spare_above, double size_mm = 0) {
    ModelOptions options;
    options.spare_dense_above = spare_above;
    options.size_mm = size_mm;
    RunContext context;
    Result<Model> made = build_model(set, options, context);
    EXPECT_TRUE(made.ok());
    Model& model = made.value();
    return {std::move(model.mesh), std::move(model.regions), set, std::move(model.contour_vertices)};
}

TEST(SnapRoundSegments, leaves_no_segment_of_dense_planes_missed) {
    struct Case {
        std::string name;
        ContourSet set;
        std::uint64_t spare_above;
    };
    constexpr std::uint64_t all_done = 1'000'000, spared = 0;
    const std::vector<Case> cases{{"a sweep", dense_plane_sets::sweep(30, 40), all_done},
                                  {"a spared sweep", dense_plane_sets::sweep(120, 60), spared},
                                  {"a dense spared sweep", dense_plane_sets::sweep(240, 60), spared},
                                  {"about an axis", dense_plane_sets::turned(20, 30), all_done},
                                  {"spared, about an axis", dense_plane_sets::turned(40, 60), spared}};
    std::size_t missed_in_all = 0;
    for (const auto& [name, set, spare_above] : cases) {
        SCOPED_TRACE(name);
        const Routed model = built(set, spare_above);
        const std::size_t missed = model.missed({});
        missed_in_all += missed;
        const double most_mm = 2;
        const std::vector<RoutedContour> routed = model.rerouted(most_mm, 2);
        EXPECT_EQ(model.missed(routed), 0u);
        EXPECT_EQ(model.unsound(routed), 0u);
        std::size_t segments = 0;
        for (const RoutedContour& one : routed) {
            segments += one.segments;
            EXPECT_LE(one.farthest_mm, most_mm);
            const std::vector<std::uint32_t> drawn = model.ring_of({}, one.contour);
            for (const std::uint32_t v : one.vertices) {
                double nearest = HUGE_VAL;
                for (std::size_t n = 0; n < drawn.size(); ++n)
                    nearest =
                        std::min(nearest, distance_from(model.mesh().points[v], model.mesh().points[drawn[n]],
                                                        model.mesh().points[drawn[(n + 1) % drawn.size()]]));
                EXPECT_LE(nearest, one.farthest_mm + 1e-12);
            }
        }
        EXPECT_EQ(segments, missed);
        const std::vector<RoutedContour> again = model.rerouted(most_mm, 1);
        ASSERT_EQ(again.size(), routed.size());
        for (std::size_t n = 0; n < again.size(); ++n) EXPECT_EQ(again[n].vertices, routed[n].vertices);
        // No way within a millionth, but where vertices lie on the line itself.
        EXPECT_EQ(model.missed(model.rerouted(1e-6)), missed);
    }
    EXPECT_GT(missed_in_all, 1000u);
}

// A slab of cubes, on whose top z = 1 contours are drawn by grid points; its squares have a diagonal from
// (i, j) to (i + 1, j + 1).
struct Slab {
    static constexpr int n = 8;
    std::vector<std::array<int, 2>> corners;

    static Vec3 point(int i, int j) { return {1.0 * i, 1.0 * j, 1}; }

    Routed made() const {
        TetMesh mesh = testing::brick_mesh(
            {n, n, 1}, [](int, int, int) { return Region{1}; },
            [](int i, int j, int k) {
                return Vec3{1.0 * i, 1.0 * j, 1.0 * k};
            });
        RawContours raw;
        raw.structures.push_back({1, "slab", {}});
        raw.planes.push_back(make_plane({0, 0, 1}, {0, 0, 1}));
        raw.plane_names.push_back("top");
        RawContour contour;
        contour.plane = 0;
        contour.point_count = static_cast<std::uint32_t>(corners.size());
        for (const auto& [i, j] : corners) raw.points.push_back(point(i, j));
        raw.contours.push_back(contour);
        ContourSet set = kept(raw);
        std::vector<std::uint32_t> vertex_of;
        for (const Vec3 p : set.points)
            vertex_of.push_back(static_cast<std::uint32_t>(
                std::find(mesh.points.begin(), mesh.points.end(), p) - mesh.points.begin()));
        return {std::move(mesh), RegionTable{{{}, {0}}}, std::move(set), std::move(vertex_of)};
    }
};

std::vector<Vec3> places(const Routed& model, const std::vector<std::uint32_t>& ring) {
    std::vector<Vec3> all;
    for (const std::uint32_t v : ring) all.push_back(model.mesh().points[v]);
    return all;
}

// From (4, 1) to (5, 2) there is an edge, from (1, 2) to (2, 1) none: the way is round one of the two
// corners.
TEST(SnapRoundSegments, goes_round_the_facets_that_a_segment_crosses) {
    const Routed model = Slab{{{2, 1}, {4, 1}, {5, 2}, {5, 5}, {1, 5}, {1, 2}}}.made();
    ASSERT_EQ(model.missed({}), 1u);
    const std::vector<RoutedContour> routed = model.rerouted(0.75);
    ASSERT_EQ(routed.size(), 1u);
    EXPECT_EQ(routed[0].segments, 1u);
    EXPECT_NEAR(routed[0].farthest_mm, std::sqrt(0.5), 1e-12);
    ASSERT_EQ(routed[0].vertices.size(), 7u);
    const std::vector<Vec3> ring = places(model, routed[0].vertices);
    EXPECT_TRUE(std::count(ring.begin(), ring.end(), Slab::point(1, 1)) == 1 ||
                std::count(ring.begin(), ring.end(), Slab::point(2, 2)) == 1);
    EXPECT_EQ(model.missed(routed), 0u);
    EXPECT_TRUE(model.rerouted(0.7).empty()) << "further than asked for";
}

// Both corners are the contour's own: (1, 1) and (2, 2). It leaves one of its vertices out.
TEST(SnapRoundSegments, passes_a_vertex_by_where_all_others_are_taken) {
    const Routed model = Slab{{{1, 1}, {2, 1}, {1, 2}, {2, 2}, {3, 3}, {1, 5}, {0, 5}, {0, 1}}}.made();
    ASSERT_GT(model.missed({}), 0u);
    const std::vector<RoutedContour> routed = model.rerouted(2);
    EXPECT_EQ(model.unsound(routed), 0u);
    EXPECT_EQ(model.missed(routed), 0u);
}

// What is re-routed must not cross what lies beside it: two rows of vertices side by side, with the segment
// between.
TEST(SnapRoundSegments, never_makes_contours_touch) {
    std::uint64_t rerouted = 0;
    for (int shape = 0; shape < 40; ++shape) {
        SCOPED_TRACE(shape);
        random_solids::Random random(static_cast<std::uint32_t>(shape));
        // A comb: teeth whose sides run across the diagonals.
        std::vector<std::array<int, 2>> corners{{0, 0}};
        for (int i = 1; i < Slab::n; ++i) corners.push_back({i, (i % 2) * (1 + random.below(4))});
        corners.push_back({Slab::n, 0});
        corners.push_back({Slab::n, 7});
        for (int i = Slab::n - 1; i > 0; --i) corners.push_back({i, 7 - (i % 2) * random.below(2)});
        corners.push_back({0, 7});
        const Routed model = Slab{corners}.made();
        const std::vector<RoutedContour> routed = model.rerouted(3);
        EXPECT_EQ(model.unsound(routed), 0u);
        EXPECT_LE(model.missed(routed), model.missed({}));
        std::uint64_t segments = 0;
        for (const RoutedContour& one : routed) segments += one.segments;
        EXPECT_EQ(model.missed(routed) + segments, model.missed({}));
        rerouted += segments;
    }
    EXPECT_GT(rerouted, 40u);
}

// A ball in two halves that share a wall, by dense planes.
ContourSet halves(int planes, int corners) {
    random_solids::Random random(9);
    constexpr double radius = dense_plane_sets::radius;
    RawContours raw;
    raw.structures = {{1, "left", {}}, {2, "right", {}}};
    for (int k = 0; k < planes; ++k) {
        const Plane plane =
            make_plane({0, 0, 0.9 * radius * ((2.0 * k + 1) / planes - 1)},
                       normalized(Vec3{random.between(-0.02, 0.02), random.between(-0.02, 0.02), 1}));
        raw.planes.push_back(plane);
        raw.plane_names.push_back("plane " + std::to_string(k));
        const double height = plane.origin.z * plane.normal.z,
                     reach = std::sqrt(radius * radius - height * height);
        for (const int side : {0, 1}) {
            RawContour contour;
            contour.structure = static_cast<std::uint32_t>(side);
            contour.plane = k;
            contour.first_point = static_cast<std::uint32_t>(raw.points.size());
            contour.point_count = static_cast<std::uint32_t>(2 * corners);
            // The wall from one end to the other, and the half circle back.
            for (int i = 0; i < corners; ++i)
                raw.points.push_back(plane.to_space({0, reach * (2.0 * i / corners - 1)}));
            for (int i = 0; i < corners; ++i) {
                const double angle = std::numbers::pi * i / corners;
                raw.points.push_back(plane.to_space(
                    {(side == 0 ? -1 : 1) * reach * std::sin(angle), reach * std::cos(angle)}));
            }
            raw.contours.push_back(contour);
        }
    }
    RunContext context;
    return std::move(reconcile_contours(kept(raw), {}, context).value().kept);
}

// What lies in both of two contours, projected along the normal of their slice.
double common_area(const Routed& model, const Slice& slice, const std::vector<std::uint32_t>& ring,
                   const std::vector<std::uint32_t>& other) {
    std::vector<Segment2> both;
    Box2 box;
    double sum = 0;
    for (const auto* const one : {&ring, &other}) {
        std::vector<Vec2> at;
        for (const std::uint32_t v : *one) at.push_back(slice.plane.to_plane(model.mesh().points[v]));
        for (std::size_t n = 0; n < at.size(); ++n) {
            both.push_back({at[n], at[(n + 1) % at.size()]});
            box.extend(at[n]);
        }
        sum += std::abs(signed_area(at));
    }
    return 0.5 * (sum - even_odd_area(std::move(both), box));
}

TEST(SnapRoundSegments, leads_structures_that_share_a_wall_along_it_together) {
    const Routed model = built(halves(36, 20), 0, 3.5);
    const std::size_t missed = model.missed({});
    EXPECT_GT(missed, 30u);
    const std::vector<RoutedContour> routed = model.rerouted(2, 2);
    EXPECT_EQ(model.unsound(routed), 0u);
    EXPECT_LT(model.missed(routed), missed / 20);
    std::size_t rerouted_walls = 0;
    for (const Slice& slice : model.set().slices) {
        ASSERT_EQ(slice.contour_count, 2u);
        const std::uint32_t c = slice.first_contour;
        const auto left = model.ring_of(routed, c), right = model.ring_of(routed, c + 1);
        EXPECT_LT(common_area(model, slice, left, right), 1e-3) << slice.name;
        rerouted_walls += left.size() > model.ring_of({}, c).size();
    }
    EXPECT_GT(rerouted_walls, 10u);
}

TEST(SnapRoundSegments, leaves_contours_alone_of_which_vertices_are_lost) {
    const Slab slab{{{2, 1}, {4, 1}, {5, 2}, {5, 5}, {1, 5}, {1, 2}}};
    const Routed model = slab.made();
    std::vector<std::uint32_t> lost = model.ring_of({}, 0);
    lost[3] = no_cell;
    const auto neighbors = cell_neighbors(model.mesh().cells, model.mesh().points.size());
    EXPECT_TRUE(
        snap_round_segments(model.mesh(), neighbors, RegionTable{{{}, {0}}}, model.set(), lost, {}, {0.75, 1})
            .empty());
}

}  // namespace
}  // namespace anatomesh::snap_round_segments_test
