// Stretches of contours, where they meet, and the slivers between them.
#include "anatomesh/contour/walls/sliver_between.h"

#include <gtest/gtest.h>

#include <vector>

#include "anatomesh/contour/walls/loop_meetings.h"

namespace anatomesh::sliver_between_test {
namespace {

// Two contours that have the vertices 0 and 1 in common. Between these, the first has vertex 2 in the middle and the
// second has vertex 3, `apart` below it and a little on.
struct TwoLoops {
    std::vector<Vec2> at;
    std::vector<ConflatedContour> loops;

    explicit TwoLoops(double apart)
        : at{{0, 0}, {10, 0}, {5, 0}, {6, -apart}, {10, 10}, {0, 10}, {10, -10}, {0, -10}} {
        add(0, {0, 2, 1, 4, 5});
        add(1, {1, 3, 0, 7, 6});
    }
    void add(std::uint32_t structure, std::vector<std::uint32_t> vertices) {
        loops.push_back({structure, vertices, vertices, vertices});
    }
};

TEST(LoopStretches, a_stretch_goes_on_over_the_start_of_its_loop) {
    const TwoLoops two(0.1);
    const LoopStretches stretches(two.loops, two.at);
    const Stretch over = stretches.between(0, 3.5, 1.25);
    EXPECT_EQ(over.start, 3u);
    EXPECT_EQ(over.segments, 4u);
    EXPECT_EQ(over.from, 0.5);
    EXPECT_EQ(over.to, 0.25);
    EXPECT_EQ(stretches.vertex(over, 0), 5u);
    EXPECT_EQ(stretches.vertex(over, 1), 0u);
    EXPECT_EQ(stretches.vertex(over, 2), 2u);
    // The segments between its vertices alone: from 5 to 0 and from 0 to 2.
    EXPECT_EQ(stretches.mean_segment(over), 7.5);
}

TEST(LoopMeetings, contours_meet_once_in_each_common_vertex) {
    TwoLoops two(0.1);
    std::vector<Meeting> all = find_meetings(two.loops, two.at);
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].vertex, 0u);
    EXPECT_EQ(all[0].along_second, 2);
    EXPECT_EQ(all[1].vertex, 1u);
    EXPECT_EQ(all[1].along_first, 2);
    EXPECT_EQ(all[1].along_second, 0);
    two.loops[1].structure = 0;
    EXPECT_TRUE(find_meetings(two.loops, two.at).empty());
}

TEST(LoopMeetings, a_crossing_lies_along_both_contours) {
    const std::vector<Vec2> at{{0, 0}, {10, 0}, {5, 10}, {4, -5}, {4, 5}, {-5, 0}};
    const std::vector<std::uint32_t> one{0, 1, 2}, other{3, 4, 5};
    const std::vector<ConflatedContour> loops{{0, one, one, one}, {1, other, other, other}};
    const std::vector<Meeting> all = find_meetings(loops, at);
    ASSERT_FALSE(all.empty());
    EXPECT_EQ(all[0].vertex, no_vertex);
    EXPECT_EQ(all[0].along_first, 0.4);
    EXPECT_EQ(all[0].along_second, 0.5);
}

TEST(SliverBetween, both_stretches_get_the_vertices_of_the_other) {
    const TwoLoops two(0.1);
    const LoopStretches stretches(two.loops, two.at);
    const auto sliver = sliver_between(stretches, stretches.between(0, 0, 2), stretches.between(1, 0, 2), {});
    ASSERT_TRUE(sliver);
    ASSERT_EQ(sliver->size(), 2u);
    // Vertex 3 comes between 2 and 1 of the first loop, and 2 between 3 and 0 of the second.
    EXPECT_EQ((*sliver)[0].vertex, 3u);
    EXPECT_EQ((*sliver)[0].loop, 0u);
    EXPECT_EQ((*sliver)[0].segment, 1u);
    EXPECT_EQ((*sliver)[1].vertex, 2u);
    EXPECT_EQ((*sliver)[1].loop, 1u);
    EXPECT_EQ((*sliver)[1].segment, 1u);
}

TEST(SliverBetween, what_is_wider_than_the_width_is_none) {
    const TwoLoops two(0.5);
    const LoopStretches stretches(two.loops, two.at);
    EXPECT_FALSE(sliver_between(stretches, stretches.between(0, 0, 2), stretches.between(1, 0, 2), {}));
}

}  // namespace
}  // namespace anatomesh::sliver_between_test
