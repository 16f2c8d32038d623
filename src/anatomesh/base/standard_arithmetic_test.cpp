#include "anatomesh/base/standard_arithmetic.h"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>

#include "anatomesh/base/parallel.h"

namespace anatomesh::standard_arithmetic_test {
namespace {

// One third rounded as the mode says. The values are volatile so that the processor divides, not the compiler.
double third() {
    volatile double one = 1, three = 3;
    return one / three;
}

TEST(StandardArithmetic, holds_while_it_lives_and_gives_the_modes_back) {
    const double nearest = third();
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO, FE_TONEAREST}) {
        std::fesetround(mode);
        const double before = third();
        {
            const StandardArithmetic arithmetic;
            EXPECT_EQ(std::fegetround(), FE_TONEAREST);
            EXPECT_EQ(third(), nearest);
            volatile double small = std::numeric_limits<double>::min();
            EXPECT_GT(small / 2, 0);
        }
        EXPECT_EQ(std::fegetround(), mode);
        EXPECT_EQ(third(), before);
    }
    std::fesetround(FE_TONEAREST);
}

TEST(StandardArithmetic, every_piece_of_a_parallel_loop_has_it) {
    const double nearest = third();
    std::fesetround(FE_UPWARD);
    for (const int threads : {2, 3, 8}) {
        std::atomic<int> other = 0;
        parallel_for(1000, 1, threads, [&](std::size_t, std::size_t) { other += third() != nearest; });
        EXPECT_EQ(other, 0) << threads;
    }
    EXPECT_EQ(std::fegetround(), FE_UPWARD);
    std::fesetround(FE_TONEAREST);
}

}  // namespace
}  // namespace anatomesh::standard_arithmetic_test
