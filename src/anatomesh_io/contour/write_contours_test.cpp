#include "anatomesh_io/contour/write_contours.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "anatomesh_io/contour/contour_test_support.h"
#include "anatomesh_io/contour/read_contours.h"

namespace anatomesh::write_contours_test {
namespace {

using namespace contour_test;

std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream content;
    content << file.rdbuf();
    return content.str();
}

void put(const std::string& path, std::string_view content) {
    std::ofstream(path, std::ios::binary) << content;
}

class WriteContours : public testing::TestWithParam<const char*> {
  protected:
    std::string path(const char* name) const { return folder_.file(name + std::string(GetParam())); }
    bool is_csl() const { return std::string_view(GetParam()) == ".csl"; }
    RawContours read(const std::string& path) {
        auto result = read_contours(path, {.frame = FrameChoice::lps}, context_);
        EXPECT_TRUE(result.ok()) << to_line(result.error());
        return result.ok() ? std::move(result).value() : RawContours{};
    }
    void write(const ContourSet& set, const std::string& path) {
        const Status status = write_contours(set, path, context_);
        EXPECT_TRUE(status.ok()) << to_line(status.error());
    }

    Folder folder_;
    RunContext context_;
};

TEST_P(WriteContours, O01_written_read_and_written_again) {
    for (const unsigned seed : {1u, 2u, 3u}) {
        const ContourSet set = tilted_rings(seed, 40);
        write(set, path("one"));
        const RawContours raw = read(path("one"));
        ASSERT_EQ(raw.points.size(), set.points.size());
        for (std::size_t i = 0; i < set.points.size(); ++i) ASSERT_EQ(raw.points[i], set.points[i]) << i;
        ASSERT_EQ(raw.contours.size(), set.contours.size());
        for (std::size_t i = 0; i < set.contours.size(); ++i) {
            EXPECT_EQ(raw.contours[i].kind, ContourKind::closed_planar);
            EXPECT_EQ(raw.contours[i].plane, static_cast<std::int32_t>(set.contours[i].slice));
            EXPECT_EQ(raw.structures[raw.contours[i].structure].number,
                      set.structures[set.contours[i].structure].number);
        }
        ASSERT_EQ(raw.planes.size(), set.slices.size());
        for (std::size_t i = 0; i < set.slices.size(); ++i) {
            EXPECT_EQ(raw.planes[i].normal, set.slices[i].plane.normal);
            EXPECT_NEAR(set.slices[i].plane.signed_distance(raw.planes[i].origin), 0, 1e-12);
        }
        write(set_of(raw), path("two"));
        EXPECT_EQ(content_of(path("one")), content_of(path("two")));
        write(set_of(read(path("two"))), path("three"));
        EXPECT_EQ(content_of(path("one")), content_of(path("three")));
    }
}

TEST_P(WriteContours, names_colours_frame_and_pixel_come_back) {
    if (is_csl()) GTEST_SKIP() << "CSL does not hold them";
    ContourSet set = tilted_rings(4, 3);
    write(set, path("one"));
    const RawContours raw = read(path("one"));
    ASSERT_EQ(raw.structures.size(), 3u);  // by number; the one without contours is left out
    EXPECT_EQ(raw.structures[0].number, -3);
    EXPECT_EQ(raw.structures[0].name, "");
    EXPECT_EQ(raw.structures[1].number, 2);
    EXPECT_EQ(raw.structures[1].name, set.structures[3].name);
    EXPECT_EQ(raw.structures[2].name, set.structures[0].name);
    EXPECT_EQ(raw.structures[2].color, set.structures[0].color);
    EXPECT_EQ(raw.pixel_mm, set.pixel_mm);
    EXPECT_EQ(raw.slice_thickness_mm, 0) << "nothing says it";
    EXPECT_FALSE(raw.complete);
    EXPECT_FALSE(raw.exclusive);
    EXPECT_EQ(raw.frame, Frame::lps);
    EXPECT_EQ(raw.plane_names[2], "slice 2");
    EXPECT_TRUE(context_.warnings.empty());
    for (std::size_t i = 0; i < set.slices.size(); ++i)
        EXPECT_EQ(raw.planes[i].origin, set.slices[i].plane.origin);

    set.slice_thickness_mm = 2.5;
    set.complete = true;
    write(set, path("complete"));
    EXPECT_EQ(read(path("complete")).slice_thickness_mm, 2.5);
    EXPECT_TRUE(read(path("complete")).complete);
    EXPECT_FALSE(read(path("complete")).exclusive);
    set.exclusive = true;
    write(set, path("exclusive"));
    EXPECT_TRUE(read(path("exclusive")).complete);
    EXPECT_TRUE(read(path("exclusive")).exclusive);
    set.exclusive = set.complete = false;

    set.frame = Frame::unknown;
    write(set, path("unknown"));
    const auto unknown = read_contours(path("unknown"), {}, context_);
    ASSERT_TRUE(unknown.ok());
    EXPECT_EQ(unknown.value().frame, Frame::unknown);
    EXPECT_EQ(codes(context_), std::vector<std::string>{"W-CIO-001"});
}

TEST_P(WriteContours, planes_across_an_axis_stay_exact) {
    ContourSet set;
    set.structures = {{1, "a", {1, 1, 1}}};
    for (int k = 0; k < 50; ++k) {
        const double z = 0.1 * k - 1.7;
        const auto first = static_cast<std::uint32_t>(set.points.size());
        set.points.insert(set.points.end(), {{0, 0, z}, {1.0 / 3, 0, z}, {0, 1e-3, z}});
        set.slices.push_back({make_plane({7, -9, z}, {0, 0, 1}), static_cast<std::uint32_t>(k), 1, ""});
        set.contours.push_back({0, static_cast<std::uint32_t>(k), first, 3});
    }
    write(set, path("axial"));
    const RawContours raw = read(path("axial"));
    ASSERT_EQ(raw.planes.size(), 50u);
    for (std::size_t k = 0; k < 50; ++k) EXPECT_EQ(raw.planes[k].origin.z, set.slices[k].plane.origin.z);
}

TEST_P(WriteContours, mutations_never_crash) {
    ContourSet set = tilted_rings(5, 2);
    const std::string whole = format_contours(set, contour_format_of(path("x")).value(), context_);
    std::mt19937 random(3);
    for (int i = 0; i < 300; ++i) {
        std::string text = whole.substr(0, i % 3 ? whole.size() : random() % whole.size());
        for (unsigned k = 0; k < 3 && !text.empty(); ++k)
            text[random() % text.size()] = static_cast<char>(random());
        put(path("mutant"), text);
        RunContext context;
        const auto read = read_contours(path("mutant"), {}, context);
        if (!read.ok()) {
            EXPECT_FALSE(read.error().code.empty());
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, WriteContours, testing::Values(".json", ".vtp", ".csl"),
                         [](const auto& format) { return std::string(format.param + 1); });

TEST(WriteContoursTo, P04_unknown_extension_lists_the_known_ones) {
    Folder folder;
    RunContext context;
    const ContourSet set = tilted_rings(1, 1);
    for (const char* name : {"a.dcm", "a", "a.json.gz", ".hidden/vtp", "a."}) {
        const Status status = write_contours(set, folder.file(name), context);
        ASSERT_FALSE(status.ok()) << name;
        EXPECT_EQ(status.error().code, "E-CIO-009");
        EXPECT_EQ(status.error().kind, ErrorKind::usage);
        EXPECT_NE(status.error().next_step.find(".json, .vtp or .csl"), std::string::npos);
        EXPECT_FALSE(std::filesystem::exists(folder.file(name)));
    }
    EXPECT_EQ(contour_format_of("x/y.z/A.VTP").value(), ContourFormat::vtp);
}

TEST(WriteContoursTo, csl_says_what_it_cannot_hold_and_marks_holes) {
    RunContext context;
    ContourSet set = tilted_rings(1, 1);
    const std::string csl = format_contours(set, ContourFormat::csl, context);
    EXPECT_EQ(codes(context), std::vector<std::string>{"W-CIO-006"});
    EXPECT_NE(csl.find("\n9h0 2 "), std::string::npos) << csl;
    EXPECT_NE(csl.find("\n9h2 -3 "), std::string::npos);
    EXPECT_NE(csl.find("\n9h4 7 "), std::string::npos);
}

TEST(ReadContours, content_decides_and_not_the_name) {
    Folder folder;
    RunContext context;
    const ContourSet set = tilted_rings(1, 2);
    for (const ContourFormat format : {ContourFormat::json, ContourFormat::vtp, ContourFormat::csl}) {
        put(folder.file("contours.dat"), format_contours(set, format, context));
        const auto read = read_contours(folder.file("contours.dat"), {}, context);
        ASSERT_TRUE(read.ok()) << to_line(read.error());
        EXPECT_EQ(read.value().points, set.points);
        EXPECT_EQ(read.value().source, folder.file("contours.dat"));
    }
    put(folder.file("empty"), "");
    put(folder.file("text"), "hello");
    EXPECT_TRUE(fails(read_contours(folder.file("empty"), {}, context), "E-CIO-008", "empty"));
    EXPECT_TRUE(fails(read_contours(folder.file("text"), {}, context), "E-CIO-008", "CSL"));
    EXPECT_TRUE(fails(read_contours(folder.file("absent"), {}, context), "E-INP-001"));
    EXPECT_TRUE(fails(read_contours(folder.file(""), {}, context), "E-VTP-007"));
}

}  // namespace
}  // namespace anatomesh::write_contours_test
