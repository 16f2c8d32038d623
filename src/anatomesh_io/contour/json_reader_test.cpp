#include "anatomesh_io/contour/json_reader.h"

#include <gtest/gtest.h>

#include "anatomesh_io/contour/contour_test_support.h"
#include "anatomesh_io/file/comma_locale_fixture.h"

namespace anatomesh::json_reader_test {
namespace {

using namespace contour_test;

const std::string good = R"({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
 "pixel_mm": 0.5,
 "structures": [{"number": 4, "name": "liver", "color": [1, 2, 255]}, {"number": -1}],
 "slices": [
  {"name": "z = 1", "contours": [
    {"structure": 4, "points": [[0, 0, 1], [1e1, 0, 1], [0, 0.1, 1]]},
    {"points": [[5, 5, 1], [6, 5, 1.0000000000000002]], "kind": "open", "structure": -1}],
   "plane": {"origin": [0, 0, 1], "normal": [0, 0, 1]}},
  {"contours": [{"structure": 4, "kind": "closed_xor", "points": [[0, 0, 2], [9, 0, 2], [0, 9, 2]]},
                {"structure": 4, "kind": "points", "points": [[0, 0, 2]]}]}]})";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), with);
}

testing::AssertionResult refused(const std::string& what, const std::string& with, const char* code,
                                 const char* text) {
    RunContext context;
    return fails(read_with(read_json_contours, replaced(good, what, with), context), code, text)
           << " for " << with;
}

TEST(Json, reads_everything_in_any_order) {
    RunContext context;
    const auto read = read_with(read_json_contours, good, context);
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_TRUE(context.warnings.empty());
    const RawContours& raw = read.value();
    EXPECT_EQ(raw.frame, Frame::lps);
    EXPECT_EQ(raw.pixel_mm, 0.5);
    ASSERT_EQ(raw.structures.size(), 2u);
    EXPECT_EQ(raw.structures[0].number, -1);
    EXPECT_EQ(raw.structures[1].name, "liver");
    EXPECT_EQ(raw.structures[1].color, (std::array<std::uint8_t, 3>{1, 2, 255}));
    ASSERT_EQ(raw.contours.size(), 4u);
    EXPECT_EQ(raw.contours[0].structure, 1u);
    EXPECT_EQ(raw.contours[0].kind, ContourKind::closed_planar);
    EXPECT_EQ(raw.contours[0].plane, 0);
    EXPECT_EQ(raw.contours[1].structure, 0u);
    EXPECT_EQ(raw.contours[1].kind, ContourKind::open);
    EXPECT_EQ(raw.contours[1].name, "slices[0].contours[1]");
    EXPECT_EQ(raw.contours[2].kind, ContourKind::closed_planar_xor);
    EXPECT_EQ(raw.contours[2].plane, -1);
    EXPECT_EQ(raw.contours[3].kind, ContourKind::point);
    ASSERT_EQ(raw.planes.size(), 1u);
    EXPECT_EQ(raw.planes[0].origin, (Vec3{0, 0, 1}));
    EXPECT_EQ(raw.plane_names[0], "z = 1");
    EXPECT_EQ(raw.points[4].z, 1.0000000000000002);
    EXPECT_EQ(raw.points[2].y, 0.1);
}

TEST(Json, structures_may_come_last) {
    RunContext context;
    const std::string structures =
        R"("structures": [{"number": 4, "name": "liver", "color": [1, 2, 255]}, {"number": -1}],)";
    std::string moved = replaced(good, structures, "");
    moved.insert(moved.size() - 1, ", " + structures.substr(0, structures.size() - 1));
    const auto read = read_with(read_json_contours, moved, context);
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_EQ(read.value().contours[0].structure, 1u);
}

TEST(Json, C37_numbers_that_are_none) {
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[NaN, 0, 1]", "E-JSN-001", "slices[0].contours[0].points[1]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[Infinity, 0, 1]", "E-JSN-001", "slices[0].contours[0].points[1]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[1e30, 0, 1]", "E-CIO-005", "slices[0].contours[0].points[1]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[1e400, 0, 1]", "E-JSN-004", "slices[0].contours[0].points[1]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[1" + std::string(400, '0') + ", 0, 1]", "E-JSN-004",
                        "slices[0].contours[0].points[1]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[null, 0, 1]", "E-JSN-003", "slices[0].contours[0].points[1][0]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[0, \"1\", 1]", "E-JSN-003", "slices[0].contours[0].points[1][1]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[0, true, 1]", "E-JSN-003", "slices[0].contours[0].points[1][1]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[0, [1], 1]", "E-JSN-003", "slices[0].contours[0].points[1][1]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[0, {}, 1]", "E-JSN-003", "slices[0].contours[0].points[1][1]"));
    EXPECT_TRUE(
        refused("[1e1, 0, 1]", "[0, 1]", "E-JSN-003", "slices[0].contours[0].points[1]: three numbers"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[0, 1, 2, 3]", "E-JSN-003", "4 numbers"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[]", "E-JSN-003", "0 numbers"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "null", "E-JSN-003", "slices[0].contours[0].points[1]"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[01, 0, 1]", "E-JSN-001", ""));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[1,5, 0, 1]", "E-JSN-003", "4 numbers"));
    EXPECT_TRUE(refused("[1e1, 0, 1]", "[+1, 0, 1]", "E-JSN-001", ""));
}

TEST(Json, C37_duplicate_keys) {
    EXPECT_TRUE(refused("\"unit\": \"mm\",", "\"unit\": \"mm\", \"unit\": \"mm\",", "E-JSN-005", "unit"));
    EXPECT_TRUE(refused("\"kind\": \"open\",", "\"kind\": \"open\", \"points\": [],", "E-JSN-005",
                        "slices[0].contours[1].points"));
    EXPECT_TRUE(
        refused("\"unit\": \"mm\",", "\"unit\": \"mm\", \"x\": {\"a\": 1, \"a\": 1},", "E-JSN-005", "x.a"));
}

TEST(Json, C37_deep_nesting) {
    for (const int depth : {100, 100'000}) {
        const std::string deep = std::string(static_cast<std::size_t>(depth), '[');
        EXPECT_TRUE(refused("\"unit\": \"mm\",", "\"unit\": \"mm\", \"x\": " + deep, "E-JSN-002", "64"));
    }
    RunContext context;
    EXPECT_TRUE(
        fails(read_with(read_json_contours, std::string(100'000, '['), context), "E-JSN-003", "object"));
    const std::string allowed = std::string(63, '[') + std::string(63, ']');
    EXPECT_TRUE(
        read_with(read_json_contours, replaced(good, "\"unit\"", "\"x\": " + allowed + ", \"unit\""), context)
            .ok());
    EXPECT_EQ(codes(context), std::vector<std::string>{"W-JSN-001"});
}

TEST(Json, C37_long_text) {
    EXPECT_TRUE(refused("liver", std::string(std::size_t{3} << 20, 'x'), "E-JSN-008", "structures[0].name"));
    RunContext context;
    const auto read =
        read_with(read_json_contours, replaced(good, "liver", std::string(10'000, 'x')), context);
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(read.value().structures[1].name.size(), 10'000u);
}

TEST(Json, C37_byte_order_mark_and_encoding) {
    RunContext context;
    EXPECT_TRUE(
        fails(read_with(read_json_contours, "\xEF\xBB\xBF" + good, context), "E-JSN-001", "byte order mark"));
    EXPECT_TRUE(refused("liver", "liv\xFF", "E-JSN-001", "structures[0].name"));
    EXPECT_TRUE(refused("liver", "\\ud800", "E-JSN-001", "structures[0].name"));
}

TEST(Json, C37_truncated_anywhere) {
    for (std::size_t size = 0; size < good.size(); ++size) {
        RunContext context;
        ASSERT_TRUE(fails(read_with(read_json_contours, good.substr(0, size), context), "E-JSN-001")) << size;
    }
    RunContext context;
    EXPECT_TRUE(fails(read_with(read_json_contours, good + "x", context), "E-JSN-001"));
    EXPECT_TRUE(fails(read_with(read_json_contours, good + good, context), "E-JSN-001"));
}

TEST(Json, C36_no_contours) {
    RunContext context;
    const std::string head =
        R"({"format": "anatomesh-contours", "version": 1, "unit": "mm", "structures": [)";
    EXPECT_TRUE(fails(read_with(read_json_contours, head + R"(], "slices": []})", context), "E-CIO-006"));
    EXPECT_TRUE(
        fails(read_with(read_json_contours,
                        head + R"({"number": 1, "name": "bone"}], "slices": [{"contours": []}]})", context),
              "E-CIO-006", "bone"));
}

TEST(Json, wrong_members_are_named) {
    EXPECT_TRUE(refused("anatomesh-contours", "geojson", "E-JSN-004", "format"));
    EXPECT_TRUE(refused("\"version\": 1", "\"version\": 2", "E-JSN-004", "version"));
    EXPECT_TRUE(refused("\"mm\"", "\"cm\"", "E-JSN-004", "cm"));
    EXPECT_TRUE(refused("\"LPS\"", "\"LAS\"", "E-JSN-004", "space"));
    EXPECT_TRUE(refused("\"open\"", "\"OPEN\"", "E-JSN-004", "slices[0].contours[1].kind"));
    EXPECT_TRUE(refused("0.5", "-0.5", "E-JSN-004", "pixel_mm"));
    EXPECT_TRUE(
        refused("\"pixel_mm\": 0.5", "\"slice_thickness_mm\": -1", "E-JSN-004", "slice_thickness_mm"));
    EXPECT_TRUE(refused("\"pixel_mm\": 0.5", "\"coverage\": \"all\"", "E-JSN-004", "coverage"));
    EXPECT_TRUE(refused("\"unit\": \"mm\",", "", "E-JSN-006", "`unit`"));
    EXPECT_TRUE(refused(", \"normal\": [0, 0, 1]", "", "E-JSN-006", "slices[0].plane: `normal`"));
    EXPECT_TRUE(refused("\"normal\": [0, 0, 1]", "\"normal\": [0, 0, 0]", "E-CIO-007", "slices[0].plane"));
    EXPECT_TRUE(refused("\"number\": -1", "\"number\": 4", "E-JSN-007", "structures[1].number"));
    EXPECT_TRUE(refused("\"number\": -1", "\"number\": 1.5", "E-JSN-004", "structures[1].number"));
    EXPECT_TRUE(refused("\"number\": -1", "\"number\": 3000000000", "E-JSN-004", "structures[1].number"));
    EXPECT_TRUE(refused("\"number\": -1", "\"name\": \"a\"", "E-JSN-006", "structures[1]: `number`"));
    EXPECT_TRUE(refused("\"structure\": -1", "\"structure\": 9", "E-JSN-007", "slices[0].contours[1]"));
    EXPECT_TRUE(refused("\"structure\": -1", "\"structure\": \"liver\"", "E-JSN-003",
                        "slices[0].contours[1].structure"));
    EXPECT_TRUE(refused("[1, 2, 255]", "[1, 2, 256]", "E-JSN-004", "structures[0].color"));
    EXPECT_TRUE(refused("[1, 2, 255]", "\"#ff0000\"", "E-JSN-003", "structures[0].color"));
}

TEST(Json, unknown_members_are_said_once) {
    RunContext context;
    const std::string text =
        replaced(replaced(good, "\"number\": 4,", "\"number\": 4, \"note\": [1, {\"a\": null}],"),
                 "\"number\": -1", "\"number\": -1, \"note\": 2");
    ASSERT_TRUE(read_with(read_json_contours, text, context).ok());
    EXPECT_EQ(codes(context), std::vector<std::string>{"W-JSN-001"});
}

TEST(Json, space_as_the_file_or_the_user_says) {
    RunContext context;
    const auto ras = read_with(read_json_contours, replaced(good, "LPS", "RAS"), context);
    ASSERT_TRUE(ras.ok());
    EXPECT_EQ(ras.value().points[1], (Vec3{-10, 0, 1}));
    const auto none = read_with(read_json_contours, replaced(good, "\"space\": \"LPS\",", ""), context);
    ASSERT_TRUE(none.ok());
    EXPECT_EQ(none.value().frame, Frame::unknown);
    EXPECT_EQ(codes(context), std::vector<std::string>{"W-CIO-001"});
    context.warnings.clear();
    const auto against = read_with(read_json_contours, good, context, FileFrame::ras);
    ASSERT_TRUE(against.ok());
    EXPECT_EQ(against.value().points[1], (Vec3{10, 0, 1}));
    EXPECT_EQ(codes(context), std::vector<std::string>{"W-CIO-002"});
}

TEST(Json, limits_hold) {
    RunContext context;
    const auto read = [&](const ContourLimits& limits) {
        return read_with(read_json_contours, good, context, FileFrame::unknown, limits);
    };
    EXPECT_TRUE(fails(read({.structures = 1}), "E-CIO-001"));
    EXPECT_TRUE(fails(read({.contours = 3}), "E-CIO-002"));
    EXPECT_TRUE(fails(read({.points_per_contour = 2}), "E-CIO-003", "slices[0].contours[0].points[2]"));
    EXPECT_TRUE(fails(read({.points = 8}), "E-CIO-004"));
    EXPECT_TRUE(
        read({.structures = 2, .contours = 4, .points_per_contour = 3, .points = 9, .coordinate_mm = 10})
            .ok());
}

TEST(Json, same_numbers_in_a_locale_with_decimal_commas) {
    RunContext context;
    const auto plain = read_with(read_json_contours, good, context);
    const fixtures::CommaLocale locale;
    ASSERT_TRUE(locale.is_there()) << "localedef makes none (package locales)";
    const auto german = read_with(read_json_contours, good, context);
    ASSERT_TRUE(plain.ok() && german.ok());
    EXPECT_EQ(plain.value().points, german.value().points);
}

TEST(Json, mutations_never_crash) {
    std::mt19937 random(2);
    for (int i = 0; i < 5000; ++i) {
        std::string text = good;
        for (unsigned k = 0, n = 1 + random() % 3; k < n; ++k)
            text[random() % text.size()] = "{}[]\",:0129-+.e \\u\xFF\0"[random() % 20];
        RunContext context;
        const auto read = read_with(read_json_contours, text, context);
        if (!read.ok()) {
            EXPECT_FALSE(read.error().message.empty());
        }
    }
}

}  // namespace
}  // namespace anatomesh::json_reader_test
