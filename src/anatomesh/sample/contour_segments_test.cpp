#include "anatomesh/sample/contour_segments.h"

#include <gtest/gtest.h>

#include <random>

#include "anatomesh/refine/missing_segments.h"
#include "anatomesh/sample/drawing_for_test.h"

namespace anatomesh::contour_segments_test {
namespace {

using namespace fixtures;

struct Given {
    ContourSet set;
    std::vector<std::uint32_t> vertices;  // of every point of the set
    std::vector<Vec3> points;             // distinct
};

Given given_by(const Drawing& drawing) {
    Given given{kept(drawing.raw), {}, {}};
    for (const Vec3& p : given.set.points) {
        const auto at = std::find(given.points.begin(), given.points.end(), p);
        given.vertices.push_back(static_cast<std::uint32_t>(at - given.points.begin()));
        if (at == given.points.end()) given.points.push_back(p);
    }
    return given;
}

TEST(ContourSegments, a_wall_drawn_by_two_structures_is_one_segment_of_both) {
    Drawing drawing;
    drawing.add(0, 0, rectangle({0, 0}, {4, 4}));
    drawing.add(1, 0, rectangle({4, 0}, {8, 4}));
    const Given given = given_by(drawing);
    const auto segments = distinct_segments(given.set, given.vertices);
    EXPECT_EQ(segments.size(), 7u);
    EXPECT_EQ(
        std::count_if(segments.begin(), segments.end(), [](auto& s) { return s.structures.size() == 2; }), 1);
}

TEST(ContourSegments, crossing_contours_share_a_new_point) {
    Drawing drawing;
    drawing.add(0, 1, rectangle({0, 0}, {4, 4}));
    drawing.add(1, 1, rectangle({2, 2}, {7, 6}));
    Given given = given_by(drawing);
    const std::size_t before = given.points.size();
    const auto segments = distinct_segments(given.set, given.vertices);
    const auto cuts = cuts_at_contacts(given.set, segments, 0.1, given.points);
    ASSERT_EQ(given.points.size(), before + 2);
    ASSERT_EQ(cuts.size(), 4u);
    EXPECT_TRUE(std::is_sorted(cuts.begin(), cuts.end()));
    for (const SegmentCut& cut : cuts) {
        const Vec3 a = given.points[segments[cut.segment].a], b = given.points[segments[cut.segment].b];
        EXPECT_LT(length(a + cut.share * (b - a) - given.points[cut.point]), 1e-12);
    }
}

TEST(ContourSegments, a_segment_is_cut_where_another_ends_on_it) {
    Drawing drawing;
    drawing.add(0, 0, rectangle({0, 0}, {8, 4}));
    drawing.add(1, 0, rectangle({2, 4}, {5, 7}));
    Given given = given_by(drawing);
    const auto segments = distinct_segments(given.set, given.vertices);
    const std::size_t before = given.points.size();
    const auto cuts = cuts_at_contacts(given.set, segments, 0.1, given.points);
    EXPECT_EQ(given.points.size(), before);
    ASSERT_EQ(cuts.size(), 2u);
    EXPECT_EQ(cuts[0].segment, cuts[1].segment);
    EXPECT_NEAR(cuts[1].share - cuts[0].share, 3.0 / 8, 1e-12);
    for (const SegmentCut& cut : cuts) EXPECT_EQ(given.points[cut.point].y, 4);
}

TEST(ContourSegments, an_end_on_a_segment_cuts_it_however_near_to_its_ends_and_but_for_rounding) {
    for (const double off : {0.0, 4e-7, -4e-7}) {
        Drawing drawing;
        drawing.add(0, 0, rectangle({0, 0}, {8, 4}));
        drawing.add(1, 0, {{0.05, 4 + off}, {5, 4}, {5, 7}});
        Given given = given_by(drawing);
        const auto segments = distinct_segments(given.set, given.vertices);
        const auto cuts = cuts_at_contacts(given.set, segments, 0.4, given.points);
        ASSERT_EQ(cuts.size(), 2u) << off;
        EXPECT_EQ(given.points.size(), 7u) << off;
        const auto parts = parts_between(segments, cuts);
        EXPECT_EQ(parts.size(), 8u) << off;
        EXPECT_EQ(std::count_if(parts.begin(), parts.end(),
                                [](auto& p) { return p.segment.structures.size() == 2; }),
                  1)
            << off;
    }
}

// Two edges that leave a common end in one direction would be split at the same places, twice.
TEST(ContourSegments, parts_of_contours_that_run_along_each_other_are_those_of_all) {
    std::mt19937 random(7);
    const auto corner = [&] {
        return Vec2{static_cast<double>(random() % 7), static_cast<double>(random() % 7)};
    };
    for (int round = 0; round < 200; ++round) {
        Drawing drawing;
        std::vector<double> around;
        for (std::uint32_t s = 0; s < 4; ++s) {
            const Vec2 low = corner(), size = corner() + Vec2{1, 1};
            drawing.add(s, 0, rectangle(low, low + size));
            around.push_back(2 * (size.x + size.y));
        }
        Given given = given_by(drawing);
        const auto segments = distinct_segments(given.set, given.vertices);
        const auto cuts = cuts_at_contacts(given.set, segments, 0.4, given.points);
        std::vector<ContourSegment> parts;
        for (const SegmentPart& part : parts_between(segments, cuts)) parts.push_back(part.segment);
        std::vector<double> kept(4, 0);
        for (const ContourSegment& part : parts) {
            EXPECT_LT(part.a, part.b);
            EXPECT_TRUE(std::is_sorted(part.structures.begin(), part.structures.end()));
            for (const std::uint32_t s : part.structures)
                kept[s] += length(given.points[part.b] - given.points[part.a]);
        }
        for (std::uint32_t s = 0; s < 4; ++s) EXPECT_NEAR(kept[s], around[s], 1e-9);
        // Points that are distinct differ by 1 here, so parts that overlap have a middle on one another.
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const Vec3 middle = 0.5 * (given.points[parts[i].a] + given.points[parts[i].b]);
            for (std::size_t j = 0; j < parts.size(); ++j) {
                const Vec3 a = given.points[parts[j].a], b = given.points[parts[j].b];
                const bool on = length(cross(b - a, middle - a)) < 1e-9 && dot(middle - a, middle - b) < 0;
                EXPECT_EQ(on, i == j);
            }
        }
    }
}

TEST(ContourSegments, contours_of_one_structure_are_left_alone) {
    Drawing drawing;
    drawing.add(0, 0, rectangle({0, 0}, {8, 8}));
    drawing.add(0, 0, rectangle({2, 2}, {5, 5}));
    Given given = given_by(drawing);
    EXPECT_TRUE(
        cuts_at_contacts(given.set, distinct_segments(given.set, given.vertices), 0.1, given.points).empty());
}

// On rays from one apex: the same for all that reach from one distance to another, away from their ends, and as
// round a number as there is between.
TEST(ShellPoint, is_at_one_distance_for_all_subsegments_that_hold_the_roundest_number) {
    std::mt19937 random(3);
    const auto unit = [&] { return std::ldexp(static_cast<double>(random()), -32); };
    for (int n = 0; n < 2000; ++n) {
        const Vec3 apex{10 * unit(), 10 * unit(), 10 * unit()};
        const double near = n % 4 == 0 ? 0 : 3 * unit(), far = near + 0.01 + 3 * unit();
        std::vector<double> shells;
        for (int ray = 0; ray < 3; ++ray) {
            Vec3 way{unit() - 0.5, unit() - 0.5, unit() - 0.5};
            way = (1 / length(way)) * way;
            std::vector<Vec3> points{apex + near * way, apex + far * way};
            if (ray == 1) std::swap(points[0], points[1]);
            const Vec3 at = shell_point(points, {0, 1, 0, 0}, apex);
            shells.push_back(length(at - apex));
            EXPECT_LT(length(cross(at - apex, way)), 1e-12);
            EXPECT_GE(shells.back(), near + 0.25 * (far - near) - 1e-12);
            EXPECT_LE(shells.back(), far - 0.25 * (far - near) + 1e-12);
        }
        EXPECT_NEAR(shells[0], shells[1], 1e-12);
        EXPECT_NEAR(shells[0], shells[2], 1e-12);
        // Of the numbers in the middle half none is a multiple of twice the unit of this one.
        int exponent = 0;
        double whole = shells[0];
        while (std::abs(whole - std::round(whole)) > 1e-9 * whole) whole *= 2, --exponent;
        while (std::abs(whole / 2 - std::round(whole / 2)) < 1e-9) whole /= 2, ++exponent;
        const double twice = std::exp2(exponent + 1), high = far - 0.25 * (far - near) - 1e-9;
        EXPECT_LT(std::floor(high / twice) * twice, near + 0.25 * (far - near) + 1e-9);
    }
}

TEST(MissingSubsegments, finds_those_that_are_no_edges) {
    const std::vector<Cell> cells{{0, 1, 2, 3}, {1, 2, 3, 4}};
    const std::vector<Subsegment> subsegments{
        {0, 4, 0, 0}, {4, 1, 0, 1}, {2, 0, 1, 2}, {4, 0, 1, 0}, {5, 3, 0, 3}};
    EXPECT_EQ(missing_subsegments(cells, 6, subsegments), (std::vector<std::uint32_t>{0, 3, 4}));
}

}  // namespace
}  // namespace anatomesh::contour_segments_test
