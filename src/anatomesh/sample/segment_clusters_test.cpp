#include "anatomesh/sample/segment_clusters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace anatomesh::segment_clusters_test {
namespace {

struct Rays {
    std::vector<Vec3> points{{0, 0, 0}};
    std::vector<Subsegment> subsegments;

    // From the first point on, of subsegments of length 1 that bend downwards more and more.
    void add(double azimuth, int count, double bend) {
        Vec3 p;
        std::uint32_t from = 0;
        for (int n = 0; n < count; ++n) {
            const double dip = bend * n;
            p = p +
                Vec3{std::cos(dip) * std::cos(azimuth), std::cos(dip) * std::sin(azimuth), -std::sin(dip)};
            points.push_back(p);
            const auto to = static_cast<std::uint32_t>(points.size() - 1);
            subsegments.push_back({from, to, 0, static_cast<std::uint32_t>(subsegments.size())});
            from = to;
        }
    }
    SegmentClusters apexes() const {
        return SegmentClusters(points, subsegments, acute_vertices(points, subsegments));
    }
};

TEST(SegmentClusters, straight_subsegments_come_from_where_contours_cross_and_bent_ones_from_poles_too) {
    for (const int rays : {4, 16}) {
        for (const double bend : {0.0, 0.05, 0.9}) {
            Rays drawn;
            for (int k = 0; k < rays; ++k)
                drawn.add(k < rays / 2 ? 0.3 * k : std::numbers::pi + 0.3 * (k - rays / 2), 4, bend);
            const SegmentClusters apexes = drawn.apexes();
            for (std::size_t n = 0; n < drawn.subsegments.size(); ++n) {
                const bool comes = n % 4 == 0 || bend == 0 || (bend < 0.5 && rays >= 8);
                EXPECT_EQ(apexes.of(drawn.subsegments[n]).has_value(), comes)
                    << rays << ", " << bend << ", " << n % 4;
                EXPECT_EQ(apexes.of(drawn.subsegments[n]).value_or(0), 0u);
            }
        }
    }
}

// A contour between two poles: each has its half, and of a subsegment from one to the other each a half of
// that.
TEST(SegmentClusters, between_two_the_nearer_one_has_the_subsegments_and_halves_know_it) {
    for (const int between : {1, 5, 8}) {
        Rays drawn;
        drawn.add(0, between, 0);
        const auto far = static_cast<std::uint32_t>(between);
        for (const std::uint32_t end : {0u, far}) {
            for (const double y : {1.0, -1.0}) {
                drawn.points.push_back(drawn.points[end] + Vec3{end == 0 ? 0.5 : -0.5, y, 0});
                drawn.subsegments.push_back({end, static_cast<std::uint32_t>(drawn.points.size() - 1), 0,
                                             static_cast<std::uint32_t>(drawn.subsegments.size())});
            }
        }
        SegmentClusters apexes = drawn.apexes();
        for (int n = 0; n < between && between > 1; ++n) {
            const std::optional<std::uint32_t> apex =
                apexes.of(drawn.subsegments[static_cast<std::size_t>(n)]);
            ASSERT_TRUE(apex);
            if (2 * n + 1 == between) continue;  // the middle one
            EXPECT_EQ(*apex, 2 * n + 1 < between ? 0u : far) << n;
        }
        const Subsegment first = drawn.subsegments.front();
        const auto low = static_cast<std::uint32_t>(drawn.subsegments.size()), high = low + 1;
        apexes.pass_on(first, low, high);
        EXPECT_EQ(apexes.of({0, 99, 0, low}), 0u);
        EXPECT_EQ(apexes.of({99, 1, 0, high}), between == 1 ? far : 0u);
        EXPECT_EQ(apexes.of(first).has_value(), between > 1);
    }
}

TEST(SegmentClusters, of_none_there_is_none) {
    SegmentClusters none;
    none.pass_on({0, 1, 0, 0}, 1, 2);
    EXPECT_FALSE(none.of({0, 1, 0, 0}));
}

// Bent away from the way to it, a subsegment is split at the same distance as a straight one.
TEST(ShellPoint, is_on_the_subsegment_at_the_roundest_distance) {
    for (const double angle : {0.0, 0.2, 0.4}) {
        const std::vector<Vec3> points{{1.1, 0, 0}, {1.1 + 2 * std::cos(angle), 2 * std::sin(angle), 0}};
        for (const Subsegment& subsegment : {Subsegment{0, 1, 0, 0}, Subsegment{1, 0, 0, 0}}) {
            const Vec3 at = shell_point(points, subsegment, {});
            EXPECT_NEAR(length(at), 2, 1e-14);
            EXPECT_NEAR(length(at - points[0]) + length(points[1] - at), 2, 1e-14);
        }
    }
}

}  // namespace
}  // namespace anatomesh::segment_clusters_test
