#include "anatomesh/base/sort_distinct.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace anatomesh::sort_distinct_test {
namespace {

TEST(SortDistinct, GivesEveryNumberOnceRisingHoweverManyThereAre) {
    std::mt19937 random(7);
    for (const std::size_t bound : {1u, 63u, 64u, 65u, 1000u, 100000u}) {
        for (const std::size_t count : {0u, 1u, 2u, 40u, 700u, 30000u}) {
            std::uniform_int_distribution<std::uint32_t> any(0, static_cast<std::uint32_t>(bound - 1));
            std::vector<std::uint32_t> numbers(count);
            for (std::uint32_t& n : numbers) n = any(random);
            if (count > 1) numbers[1] = static_cast<std::uint32_t>(bound - 1);
            const std::set<std::uint32_t> expected(numbers.begin(), numbers.end());
            sort_distinct(numbers, bound);
            EXPECT_EQ(numbers, std::vector<std::uint32_t>(expected.begin(), expected.end()))
                << count << " below " << bound;
        }
    }
}

}  // namespace
}  // namespace anatomesh::sort_distinct_test
