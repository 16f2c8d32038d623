#include "anatomesh/slices/lines/match_intervals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace anatomesh::match_intervals_test {
namespace {

std::vector<double> random_ends(std::mt19937& random, std::size_t most_intervals) {
    std::uniform_real_distribution<double> place(0, 100);
    std::vector<double> ends(2 * (random() % (most_intervals + 1)));
    for (double& end : ends) end = place(random);
    std::sort(ends.begin(), ends.end());
    return ends;
}

// All order-preserving matchings, by recursion on the short lists of the test.
double cheapest(const std::vector<double>& a, const std::vector<double>& b, std::size_t i, std::size_t j) {
    if (i == a.size() && j == b.size()) return 0;
    double best = 1e9;
    if (i < a.size() && j < b.size()) best = std::abs(a[i] - b[j]) + cheapest(a, b, i + 1, j + 1);
    if (i + 1 < a.size()) best = std::min(best, a[i + 1] - a[i] + cheapest(a, b, i + 2, j));
    if (j + 1 < b.size()) best = std::min(best, b[j + 1] - b[j] + cheapest(a, b, i, j + 2));
    return best;
}

TEST(MatchEnds, no_matching_that_keeps_the_order_is_cheaper) {
    std::mt19937 random(5);
    for (int n = 0; n < 300; ++n) {
        const std::vector<double> a = random_ends(random, 4), b = random_ends(random, 4);
        const IntervalMatching matching = match_intervals(a, b);
        EXPECT_NEAR(matching.cost, cheapest(a, b, 0, 0), 1e-9);
        EXPECT_NEAR(matching.cost, match_intervals(b, a).cost, 1e-9);
    }
}

TEST(MatchEnds, joins_ends_of_one_kind_and_uses_every_end_once) {
    std::mt19937 random(6);
    for (int n = 0; n < 300; ++n) {
        const std::vector<double> a = random_ends(random, 6), b = random_ends(random, 6);
        const IntervalMatching matching = match_intervals(a, b);
        std::vector<int> used_a(a.size(), 0), used_b(b.size(), 0);
        double cost = 0;
        for (const auto& [i, j] : matching.matched) {
            EXPECT_EQ(i % 2, j % 2);
            ++used_a[i], ++used_b[j];
            cost += std::abs(a[i] - b[j]);
        }
        for (const std::uint32_t i : matching.only_first) {
            ++used_a[i], ++used_a[i + 1];
            cost += a[i + 1] - a[i];
        }
        for (const std::uint32_t j : matching.only_second) {
            ++used_b[j], ++used_b[j + 1];
            cost += b[j + 1] - b[j];
        }
        EXPECT_TRUE(std::all_of(used_a.begin(), used_a.end(), [](int uses) { return uses == 1; }));
        EXPECT_TRUE(std::all_of(used_b.begin(), used_b.end(), [](int uses) { return uses == 1; }));
        EXPECT_NEAR(cost, matching.cost, 1e-9);
        EXPECT_LE(symmetric_difference(a, b), matching.cost + 1e-9);
    }
}

TEST(MatchEnds, C25_the_nearer_reading_wins) {
    const IntervalMatching moved = match_intervals(std::vector<double>{0, 10}, std::vector<double>{4, 14});
    EXPECT_EQ(moved.matched.size(), 2u);
    const IntervalMatching apart = match_intervals(std::vector<double>{0, 10}, std::vector<double>{20, 30});
    EXPECT_TRUE(apart.matched.empty());
    const IntervalMatching gap =
        match_intervals(std::vector<double>{0, 10, 12, 20}, std::vector<double>{0, 20});
    EXPECT_EQ(gap.matched.size(), 2u);
    EXPECT_EQ(gap.only_first, std::vector<std::uint32_t>{1});
    EXPECT_NEAR(symmetric_difference(std::vector<double>{0, 10, 12, 20}, std::vector<double>{0, 20}), 2,
                1e-12);
}

}  // namespace
}  // namespace anatomesh::match_intervals_test
