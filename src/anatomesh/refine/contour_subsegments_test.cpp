#include "anatomesh/refine/contour_subsegments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "anatomesh/pipeline/random_solids_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::contour_subsegments_test {
namespace {

using random_solids::Random;

constexpr double size = 1;
constexpr double clearance = 0.05;  // of what splits a subsegment from the points of others, in sizes

double distance_of_segments(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    double least = HUGE_VAL;
    constexpr int steps = 64;
    for (int i = 0; i <= steps; ++i) {
        const Vec3 p = a + (static_cast<double>(i) / steps) * (b - a), way = d - c;
        const double t = std::clamp(dot(p - c, way) / dot(way, way), 0.0, 1.0);
        least = std::min(least, length(p - (c + t * way)));
    }
    return least;
}

// Segments that keep a distance from each other, with vertices close beside most of them.
struct Drawn {
    std::vector<Vec3> points;
    std::vector<Subsegment> subsegments;
    ProtectedSegments protected_segments{size, 1000};

    Drawn(std::uint32_t seed, double apart, double beside) {
        Random random(seed);
        std::vector<std::array<Vec3, 2>> segments;
        const auto in_box = [&] {
            return Vec3{random.between(-4, 4), random.between(-4, 4), random.between(-4, 4)};
        };
        for (int tries = 0; tries < 4000 && segments.size() < 150; ++tries) {
            const Vec3 a = in_box(), b = a + random.between(0.3, 1.2) * random.direction();
            const bool free = std::all_of(segments.begin(), segments.end(), [&](const auto& s) {
                return distance_of_segments(a, b, s[0], s[1]) > apart;
            });
            if (free) segments.push_back({a, b});
        }
        for (const auto& [a, b] : segments) {
            const auto first = static_cast<std::uint32_t>(points.size());
            points.insert(points.end(), {a, b});
            protected_segments.add_point(a);
            protected_segments.add_point(b);
            subsegments.push_back({first, first + 1, 0, protected_segments.add_segment(a, b)});
        }
        for (const auto& [a, b] : segments) {
            // Rings round it.
            for (int k = 0; k < 3; ++k) {
                const Vec3 middle = a + random.between(0.1, 0.9) * (b - a);
                const Vec3 u = normalized(cross(b - a, random.direction())), v = normalized(cross(b - a, u));
                for (const Vec3& way : {u, v, -1.0 * u, -1.0 * v}) points.push_back(middle + beside * way);
            }
        }
        for (int corner = 0; corner < 8; ++corner) {
            points.push_back(30 *
                             Vec3{corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0});
        }
    }
};

LabelledMesh labelled(const Drawn& drawn, const StructureField& field, RunContext& context) {
    LabelledMesh mesh(Tetrahedralization::create(drawn.points).value(), field, 1, size, {0.02 * size});
    mesh.update(context);
    return mesh;
}

// However many are missing: with no other subsegment nearer than their own lengths come to, all become edges.
TEST(ContourSubsegments, that_are_well_apart_all_become_edges_beside_any_vertices) {
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Drawn drawn(seed, 0.2 * size, 0.05 * size);
        const fixtures::AnalyticField field({fixtures::ball({}, 3)}, 30);
        RunContext context;
        LabelledMesh mesh = labelled(drawn, field, context);
        const std::size_t missing =
            missing_subsegments(mesh.cells().cells, mesh.points().size(), drawn.subsegments).size();
        EXPECT_GT(missing, 10u);
        ContourSubsegments subsegments(mesh, drawn.protected_segments, field, drawn.subsegments,
                                       {size, false});
        ASSERT_TRUE(subsegments.finish(context).ok());
        EXPECT_TRUE(subsegments.are_short());
        EXPECT_TRUE(
            missing_subsegments(mesh.cells().cells, mesh.points().size(), subsegments.subsegments()).empty());
    }
}

// Lines that cross at a small angle, with vertices in the balls of both: where one is split, so is the other.
TEST(ContourSubsegments, that_cross_at_small_angles_all_become_edges) {
    for (const double degrees : {0.4, 0.7, 1.2, 2.0, 3.3}) {
        for (std::uint32_t seed = 1; seed <= 6; ++seed) {
            SCOPED_TRACE(testing::Message() << degrees << " degrees, seed " << seed);
            Drawn drawn(seed, 0.2 * size, 0.05 * size);
            drawn.subsegments.clear();
            drawn.protected_segments = ProtectedSegments(size, 1000);
            Random random(seed);
            const Vec3 u = random.direction(), v = normalized(cross(u, random.direction()));
            const double angle = degrees * std::numbers::pi / 180;
            const auto add = [&](Vec3 p) {
                drawn.protected_segments.add_point(p);
                drawn.points.push_back(p);
                return static_cast<std::uint32_t>(drawn.points.size() - 1);
            };
            const std::uint32_t centre = add({0.01, 0.02, 0.03});
            for (const double along : {0.5, -0.45, 0.4, -0.55}) {
                const bool first = along == 0.5 || along == -0.45;
                const Vec3 way = first ? u : std::cos(angle) * u + std::sin(angle) * v;
                const std::uint32_t end = add(drawn.points[centre] + along * way);
                const std::uint32_t ball =
                    drawn.protected_segments.add_segment(drawn.points[centre], drawn.points[end]);
                drawn.subsegments.push_back({centre, end, first ? 0u : 1u, ball});
                const Vec3 beside = 0.12 * normalized(cross(u, random.direction()));
                drawn.points.push_back(drawn.points[centre] + 0.6 * along * way + beside);
            }
            const fixtures::AnalyticField field({fixtures::ball({}, 3), fixtures::ball({1, 0, 0}, 3)}, 30);
            RunContext context;
            LabelledMesh mesh(Tetrahedralization::create(drawn.points).value(), field, 2, size,
                              {0.02 * size});
            mesh.update(context);
            ContourSubsegmentOptions options;
            options.size_mm = size;
            options.graded = true;
            ContourSubsegments subsegments(mesh, drawn.protected_segments, field, drawn.subsegments, options);
            ASSERT_TRUE(subsegments.finish(context).ok());
            EXPECT_TRUE(
                missing_subsegments(mesh.cells().cells, mesh.points().size(), subsegments.subsegments())
                    .empty());
        }
    }
}

// As at the pole of planes about an axis: subsegments of one length all round a vertex, a few degrees apart,
// each with a vertex in its ball somewhere. Where one is split, so are those beside it, at the same distance.
TEST(ContourSubsegments, that_meet_at_a_pole_all_become_edges) {
    for (const int count : {16, 24, 40, 64}) {
        for (std::uint32_t seed = 1; seed <= 4; ++seed) {
            SCOPED_TRACE(testing::Message() << count << " pieces, seed " << seed);
            Drawn drawn(seed, 0.2 * size, 0.05 * size);
            drawn.subsegments.clear();
            drawn.protected_segments = ProtectedSegments(size, 1000);
            Random random(seed);
            const Plane plane = make_plane({0.01, 0.02, 0.03}, random.direction());
            const auto add = [&](Vec3 p) {
                drawn.protected_segments.add_point(p);
                drawn.points.push_back(p);
                return static_cast<std::uint32_t>(drawn.points.size() - 1);
            };
            const std::uint32_t pole = add(plane.origin);
            const double span = random.between(0.8, 1.6);
            const double apart = 2 * std::numbers::pi / count;
            for (int n = 0; n < count; ++n) {
                const double angle = apart * n;
                const Vec3 way = std::cos(angle) * plane.u + std::sin(angle) * plane.v;
                const std::uint32_t end = add(drawn.points[pole] + span * way);
                const std::uint32_t ball =
                    drawn.protected_segments.add_segment(drawn.points[pole], drawn.points[end]);
                drawn.subsegments.push_back({pole, end, 0, ball});
                const double along = span * random.between(0.3, 0.9);
                drawn.points.push_back(drawn.points[pole] + along * way + 0.2 * along * apart * plane.normal);
            }
            const fixtures::AnalyticField field({fixtures::ball({}, 3)}, 30);
            RunContext context;
            LabelledMesh mesh = labelled(drawn, field, context);
            const std::size_t missing =
                missing_subsegments(mesh.cells().cells, mesh.points().size(), drawn.subsegments).size();
            EXPECT_GT(missing, 2u);
            ContourSubsegmentOptions options;
            options.size_mm = size;
            options.conforming = true;
            ContourSubsegments subsegments(mesh, drawn.protected_segments, field, drawn.subsegments, options);
            ASSERT_TRUE(subsegments.finish(context).ok());
            EXPECT_TRUE(
                missing_subsegments(mesh.cells().cells, mesh.points().size(), subsegments.subsegments())
                    .empty());
        }
    }
}

// Nothing is split to crumbs where subsegments lie too close to each other: it ends, and what is made keeps
// its distance.
TEST(ContourSubsegments, that_crowd_each_other_are_not_split_to_crumbs) {
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Drawn drawn(seed, 1e-4 * size, 1e-4 * size);
        const fixtures::AnalyticField field({fixtures::ball({}, 3)}, 30);
        RunContext context;
        LabelledMesh mesh = labelled(drawn, field, context);
        ContourSubsegments subsegments(mesh, drawn.protected_segments, field, drawn.subsegments,
                                       {size, false});
        ASSERT_TRUE(subsegments.recover(0, context, SplitLimits::beside_short()).ok());
        for (const Subsegment& subsegment : subsegments.subsegments()) {
            const double span = length(mesh.points()[subsegment.b] - mesh.points()[subsegment.a]);
            EXPECT_GE(span, clearance * size * (1 - 1e-12));
        }
    }
}

}  // namespace
}  // namespace anatomesh::contour_subsegments_test
