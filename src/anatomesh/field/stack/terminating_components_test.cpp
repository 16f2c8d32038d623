// Which parts of a region end before the next slice, on families of regions.
#include "anatomesh/field/stack/terminating_components.h"

#include <gtest/gtest.h>

#include "anatomesh/field/field_fixtures.h"

namespace anatomesh::terminating_components_test {
namespace {

using namespace fixtures;

constexpr double limit = 7.5;

void add(std::vector<Edge2>& edges, const Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) edges.push_back({ring[i], ring[(i + 1) % ring.size()]});
}
DistanceMap map_of(const std::vector<Ring>& rings) {
    std::vector<Edge2> edges;
    for (const Ring& ring : rings) add(edges, ring);
    return DistanceMap(std::move(edges), limit);
}
const Ring organ = circle({}, 14, 90);

TEST(TerminatingComponents, equal_regions_and_regions_that_overlap_have_none) {
    for (const double shift : {0.0, 3.0, 10.0, 20.0}) {
        const DistanceMap here = map_of({organ}), there = map_of({circle({shift, 0}, 14, 90)});
        for (const double gap : {1.0, 5.0, 10.0}) {
            EXPECT_TRUE(terminating_components(here, there, gap).empty()) << shift << " " << gap;
            EXPECT_TRUE(terminating_components(there, here, gap).empty()) << shift << " " << gap;
        }
    }
}

// A tube that leans by up to 67 degrees moves, though its sections share no point.
TEST(TerminatingComponents, what_moves_has_a_counterpart) {
    for (const double shift : {8.5, 10.0, 12.0}) {
        EXPECT_TRUE(
            terminating_components(map_of({circle({}, 4, 60)}), map_of({circle({shift, 0}, 4, 60)}), 5)
                .empty())
            << shift;
    }
}

TEST(TerminatingComponents, islands_and_cavities_of_one_slice) {
    for (const double radius : {0.8, 2.6, 5.0}) {
        const Ring island = circle({14 + radius + 1, 2}, radius, 40), cavity = circle({1, 2}, radius, 40);
        const DistanceMap here = map_of({organ, island, reversed(cavity)}), there = map_of({organ});
        const std::vector<TerminatingComponent> parts = terminating_components(here, there, 5);
        ASSERT_EQ(parts.size(), 2u) << radius;
        EXPECT_FALSE(parts[0].is_void);
        EXPECT_TRUE(parts[1].is_void);
        for (const TerminatingComponent& part : parts) {
            EXPECT_EQ(part.edges.size(), 40u);
            EXPECT_LT(
                DistanceMap(part.edges, limit).value(part.is_void ? Vec2{1, 2} : Vec2{14 + radius + 1, 2}),
                0);
        }
        EXPECT_TRUE(terminating_components(there, here, 5).empty()) << "what goes on does not end";
    }
}

// A hole over a disc of about its size is neither in it nor beside it; one that goes on, shrinks or opens is
// another matter.
TEST(TerminatingComponents, holes_that_the_next_slice_covers_mostly) {
    const Ring ring = circle({}, 30, 120);
    for (const double radius : {3.0, 4.5, 12.0}) {
        const DistanceMap here = map_of({ring, reversed(circle({}, radius, 40, 0.1))});
        for (const double share : {1.005, 1.01, 1.02}) {
            const auto parts = terminating_components(here, map_of({circle({}, share * radius, 11)}), 3);
            ASSERT_EQ(parts.size(), 1u) << radius << " " << share;
            EXPECT_TRUE(parts[0].is_void);
            EXPECT_FALSE(parts[0].is_sure) << radius << " " << share;
            EXPECT_EQ(parts[0].edges.size(), 40u);
        }
        const auto covered = terminating_components(here, map_of({circle({}, 1.3 * radius, 40)}), 3);
        ASSERT_EQ(covered.size(), 1u) << radius;
        // A small one may be taken for the opposite side of the disc.
        EXPECT_EQ(covered[0].is_sure, radius > 10) << radius;
        // Wholly beside the disc it is the ring round the hole that ends.
        const auto beside = terminating_components(here, map_of({circle({}, 0.8 * radius, 40)}), 3);
        ASSERT_EQ(beside.size(), 1u) << radius;
        EXPECT_FALSE(beside[0].is_void);
        for (const double share : {0.7, 1.0, 1.4})
            EXPECT_TRUE(
                terminating_components(here, map_of({ring, reversed(circle({}, share * radius, 40))}), 3)
                    .empty())
                << radius << " " << share;
    }
}

// What lies within an outline goes with it: the hole of a ring, an island in a cavity.
TEST(TerminatingComponents, keep_what_lies_within) {
    const Ring ring = circle({40, 0}, 5, 40), hole = circle({40, 0}, 2, 30);
    const std::vector<TerminatingComponent> rings =
        terminating_components(map_of({organ, ring, reversed(hole)}), map_of({organ}), 5);
    ASSERT_EQ(rings.size(), 1u);
    const DistanceMap ring_map(rings[0].edges, limit);
    EXPECT_GT(ring_map.value({40, 0}), 0);
    EXPECT_LT(ring_map.value({43, 0}), 0);

    const Ring cavity = circle({}, 6, 40), island = circle({}, 2, 30);
    const std::vector<TerminatingComponent> voids =
        terminating_components(map_of({organ, reversed(cavity), island}), map_of({organ}), 5);
    ASSERT_EQ(voids.size(), 1u);
    ASSERT_TRUE(voids[0].is_void);
    const DistanceMap void_map(voids[0].edges, limit);
    EXPECT_GT(void_map.value({0, 0}), 0);
    EXPECT_LT(void_map.value({4, 0}), 0);
}

TEST(TerminatingComponents, of_a_union_only_where_others_are_touched_and_nothing_goes_on) {
    const Ring box{{0, 0}, {10, 0}, {10, 4}, {10, 6}, {10, 10}, {0, 10}},
        lesion{{10, 4}, {13, 4}, {13, 6}, {10, 6}};
    const Ring both{{0, 0}, {10, 0}, {10, 4}, {13, 4}, {13, 6}, {10, 6}, {10, 10}, {0, 10}};
    const DistanceMap own = map_of({lesion}), all = map_of({both}), organ_alone = map_of({box});
    EXPECT_EQ(terminating_components_of_union(own, nullptr, all, organ_alone, 5).size(), 1u);
    EXPECT_TRUE(terminating_components_of_union(own, nullptr, all, all, 5).empty())
        << "another structure goes on there";
    EXPECT_TRUE(terminating_components_of_union(own, nullptr, own, organ_alone, 5).empty())
        << "it touches nothing";
    EXPECT_TRUE(terminating_components_of_union(own, &own, all, organ_alone, 5).empty())
        << "it goes on itself";
}

}  // namespace
}  // namespace anatomesh::terminating_components_test
