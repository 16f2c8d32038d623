#include "anatomesh/reconcile/reconcile_arcs.h"

#include <gtest/gtest.h>

namespace anatomesh::reconcile_arcs_test {
namespace {

LineComparison comparison(std::uint32_t a, std::uint32_t b, std::uint32_t structure, double difference_mm) {
    LineComparison one;
    one.a = a;
    one.b = b;
    one.structure = structure;
    one.difference_mm = difference_mm;
    return one;
}

TEST(ArcsOverLines, what_keeps_more_than_half_of_its_difference_has_failed) {
    const std::vector<ArcOverLine> taken{
        {{1, 2, 0}, {1, 0, 1}}, {{0, 1, 0}, {0, 0, 1}}, {{0, 1, 0}, {0, 0, 2}}, {{0, 2, 1}, {2, 1, 3}}};
    const std::vector<LineComparison> before{comparison(0, 1, 0, 4), comparison(0, 2, 1, 4),
                                             comparison(1, 2, 0, 4)};
    const std::vector<LineComparison> after{comparison(0, 1, 0, 2.1), comparison(1, 2, 0, 2)};
    EXPECT_EQ(still_differing(taken, before, after), (std::vector<ComparisonKey>{{0, 1, 0}}));
    EXPECT_TRUE(still_differing({}, before, after).empty());
    EXPECT_EQ(still_differing(taken, before, before),
              (std::vector<ComparisonKey>{{0, 1, 0}, {0, 2, 1}, {1, 2, 0}}));
}

TEST(ArcsOverLines, the_farthest_of_a_slice_and_structure_is_noted) {
    std::vector<TakenOver> all{{2, 0, 5}};
    const std::vector<ArcOverLine> taken{
        {{0, 2, 0}, {2, 0, 3}}, {{0, 1, 0}, {1, 0, 1}}, {{0, 1, 0}, {1, 0, 2}}};
    note_taken_over(taken, all);
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].slice, 1u);
    EXPECT_EQ(all[0].farthest_mm, 2);
    EXPECT_EQ(all[1].slice, 2u);
    EXPECT_EQ(all[1].farthest_mm, 5);
}

}  // namespace
}  // namespace anatomesh::reconcile_arcs_test
