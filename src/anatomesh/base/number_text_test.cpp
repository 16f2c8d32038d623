#include "anatomesh/base/number_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace anatomesh::number_text_test {
namespace {

TEST(NumberText, reads_whole_texts_alone) {
    EXPECT_EQ(parse_number("1.5"), 1.5);
    EXPECT_EQ(parse_number("+2e3"), 2000.0);
    for (const char* text : {"", "+", "+-1", "1,5", "1.2.3", "nan", "inf", "1e400", "0x10", " 1", "1 "})
        EXPECT_FALSE(parse_number(text)) << text;
    EXPECT_EQ(parse_integer<int>("-7"), -7);
    EXPECT_EQ(parse_integer<unsigned>("+7"), 7u);
    EXPECT_FALSE(parse_integer<unsigned>("-7"));
    EXPECT_FALSE(parse_integer<std::uint8_t>("256"));
    EXPECT_FALSE(parse_integer<int>("7.0"));
}

TEST(NumberText, reads_back_as_the_same_number) {
    for (const double value : {0.0, 1.0, 0.1, 1.0 / 3, 1e-4, 12345678.9, 1e15, 1e16, 4.9e-324, 1.7e308}) {
        EXPECT_EQ(parse_number(number_text(value)), value);
        EXPECT_EQ(parse_number(plain_text(value)), value);
    }
}

TEST(NumberText, of_json_keeps_the_sign_of_zero_for_readers_of_integers) {
    const auto text = [](double value) {
        std::string out = "x";
        append_json_number(out, value);
        return out.substr(1);
    };
    EXPECT_EQ(text(-0.0), "-0.0");
    EXPECT_EQ(text(0.0), "0");
    EXPECT_EQ(text(-7), "-7");
    EXPECT_EQ(text(0.1), "0.1");
}

TEST(NumberText, has_no_exponent_where_people_write_none) {
    EXPECT_EQ(plain_text(0.4), "0.4");
    EXPECT_EQ(plain_text(10), "10");
    EXPECT_EQ(plain_text(0), "0");
    EXPECT_EQ(plain_text(0.0001), "0.0001");
    EXPECT_EQ(plain_text(0.00001), "1e-05");
    EXPECT_EQ(plain_text(1e15), "1000000000000000");
    EXPECT_EQ(plain_text(1e16), "1e+16");
    EXPECT_EQ(plain_text(-2.5), "-2.5");
    EXPECT_EQ(plain_text(std::numeric_limits<double>::infinity()), "inf");
}

TEST(NumberText, keeps_so_many_digits) {
    EXPECT_EQ(significant_text(0.012345, 3), "0.0123");
    EXPECT_EQ(significant_text(2, 3), "2");
    EXPECT_EQ(significant_text(123456, 2), "1.2e+05");
    EXPECT_EQ(brief(0.012345), "0.0123");
}

TEST(NumberText, shows_that_it_is_no_integer) {
    EXPECT_EQ(pointed_text(2), "2.0");
    EXPECT_EQ(pointed_text(-0.125), "-0.125");
    EXPECT_EQ(pointed_text(1e300), "1e+300");
}

TEST(NumberText, fixed_and_percent) {
    EXPECT_EQ(fixed_text(2.5, 2), "2.50");
    EXPECT_EQ(fixed_text(-0.125, 3), "-0.125");
    EXPECT_EQ(fixed_text(std::numeric_limits<double>::infinity(), 2), "inf");
    EXPECT_EQ(percent_text(1, 8, 1), "12.5 %");
    EXPECT_EQ(percent_text(0, 0, 1), "0 %");
}

}  // namespace
}  // namespace anatomesh::number_text_test
