#include "anatomesh/sample/contour_segments.h"

#include <gtest/gtest.h>

#include "anatomesh/refine/missing_segments.h"
#include "anatomesh/sample/drawing_for_test.h"

namespace anatomesh {
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
    EXPECT_EQ(std::count_if(segments.begin(), segments.end(), [](auto& s) { return s.structures.size() == 2; }), 1);
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

TEST(ContourSegments, contours_of_one_structure_are_left_alone) {
    Drawing drawing;
    drawing.add(0, 0, rectangle({0, 0}, {8, 8}));
    drawing.add(0, 0, rectangle({2, 2}, {5, 5}));
    Given given = given_by(drawing);
    EXPECT_TRUE(cuts_at_contacts(given.set, distinct_segments(given.set, given.vertices), 0.1, given.points).empty());
}

TEST(MissingPieces, finds_those_that_are_no_edges) {
    const std::vector<Cell> cells{{0, 1, 2, 3}, {1, 2, 3, 4}};
    const std::vector<SegmentPiece> pieces{{0, 4, 0, 0}, {4, 1, 0, 1}, {2, 0, 1, 2}, {4, 0, 1, 0}, {5, 3, 0, 3}};
    EXPECT_EQ(missing_pieces(cells, 6, pieces), (std::vector<std::uint32_t>{0, 3, 4}));
}

}  // namespace
}  // namespace anatomesh
