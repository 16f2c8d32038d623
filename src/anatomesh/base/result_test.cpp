#include "anatomesh/base/result.h"

#include <gtest/gtest.h>

#include <memory>

namespace anatomesh::result_test {
namespace {

Error wrong(const std::string& code) {
    return {ErrorKind::input, code, "it is wrong", {}, ""};
}

Result<int> half(int n) {
    if (n % 2) return wrong("E-TST-001");
    return n / 2;
}

Result<int> quarter(int n) {
    ANATOMESH_TRY(const int once, half(n));
    ANATOMESH_TRY(const int twice, half(once));
    return twice;
}

Status even(int n) {
    ANATOMESH_CHECK_STATUS(half(n));
    return Nothing{};
}

TEST(Result, holds_a_value_or_an_error) {
    EXPECT_TRUE(half(4).ok());
    EXPECT_EQ(half(4).value(), 2);
    EXPECT_FALSE(half(3));
    EXPECT_EQ(half(3).error().code, "E-TST-001");
}

TEST(Result, try_gives_the_value_or_returns_the_error) {
    EXPECT_EQ(quarter(12).value(), 3);
    EXPECT_EQ(quarter(3).error().code, "E-TST-001");
    EXPECT_EQ(quarter(6).error().code, "E-TST-001");
}

TEST(Result, check_status_returns_the_error) {
    EXPECT_TRUE(even(2).ok());
    EXPECT_EQ(even(1).error().kind, ErrorKind::input);
}

TEST(Result, carries_values_that_cannot_be_copied) {
    const auto make = []() -> Result<std::unique_ptr<int>> { return std::make_unique<int>(7); };
    const auto take = [&]() -> Result<int> {
        ANATOMESH_TRY(const std::unique_ptr<int> taken, make());
        return *taken;
    };
    EXPECT_EQ(take().value(), 7);
}

TEST(Result, an_error_is_one_line_with_its_place_and_the_next_step) {
    Error error = wrong("E-TST-002");
    EXPECT_EQ(to_line(error), "E-TST-002: it is wrong");
    error.place = {"a.json", "z = 3 mm", "liver", "17, point 2", "1e400"};
    error.next_step = "mend it";
    EXPECT_EQ(
        to_line(error),
        "E-TST-002 a.json, structure liver, slice z = 3 mm, contour 17, point 2, value 1e400: it is wrong "
        "(next: mend it)");
}

TEST(Result, a_warning_says_what_was_done) {
    EXPECT_EQ(to_line(Warning{"W-TST-001", "two points are equal", {"", "4", "", "", ""}, "one was dropped"}),
              "W-TST-001 slice 4: two points are equal (one was dropped)");
}

}  // namespace
}  // namespace anatomesh::result_test
