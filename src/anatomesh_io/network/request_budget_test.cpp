#include "anatomesh_io/network/request_budget.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace anatomesh::request_budget_test {
namespace {

TEST(RequestBudget, as_much_as_the_limits_say_and_no_more) {
    std::mt19937_64 random(7);
    for (int trial = 0; trial < 2000; ++trial) {
        RequestLimits limits;
        limits.bytes = random() >> random() % 64;
        limits.answers = random() % 20;
        RequestBudget budget(limits, "PEER");
        std::uint64_t left = limits.bytes;
        bool fits = true;
        for (int i = 0; i < 10 && fits; ++i) {
            const std::uint64_t count = random() >> random() % 64;
            fits = count <= left;
            left -= fits ? count : 0;
            const Status status = budget.spend_bytes(count);
            ASSERT_EQ(status.ok(), fits);
            EXPECT_EQ(fits ? "E-NET-026" : status.error().code, "E-NET-026");
        }
        for (std::uint64_t i = 0; i < limits.answers; ++i) ASSERT_TRUE(budget.spend_answer().ok());
        const Status beyond = budget.spend_answer();
        ASSERT_FALSE(beyond.ok());
        EXPECT_EQ(beyond.error().code, "E-NET-027");
        EXPECT_EQ(beyond.error().kind, ErrorKind::limit);
        EXPECT_EQ(beyond.error().place.value, "PEER");
    }
}

TEST(RequestBudget, the_largest_numbers_do_not_overflow) {
    RequestLimits limits;
    limits.bytes = std::numeric_limits<std::uint64_t>::max();
    RequestBudget budget(limits, "");
    EXPECT_TRUE(budget.spend_bytes(limits.bytes).ok());
    EXPECT_FALSE(budget.spend_bytes(1).ok());
    EXPECT_FALSE(budget.spend_bytes(limits.bytes).ok());
}

TEST(RequestBudget, a_part_of_a_request_has_the_clock_of_the_whole) {
    RequestLimits limits;
    EXPECT_TRUE(RequestBudget(limits, "").check_time().ok());
    limits.begun = std::chrono::steady_clock::now() - std::chrono::seconds(3599);
    EXPECT_TRUE(RequestBudget(limits, "").check_time().ok());
    limits.begun = std::chrono::steady_clock::now() - std::chrono::seconds(3601);
    const Status status = RequestBudget(limits, "").check_time();
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, "E-NET-025");
    EXPECT_NE(status.error().message.find("3600 s"), std::string::npos);
}

}  // namespace
}  // namespace anatomesh::request_budget_test
