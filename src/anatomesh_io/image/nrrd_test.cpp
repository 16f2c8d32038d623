#include "anatomesh_io/image/image_fixtures.h"

namespace anatomesh::nrrd_test {
namespace {

using namespace fixtures;

const std::string data = Nifti().default_data();

TEST(Nrrd, good_image_reads_with_each_encoding) {
    std::string text;
    for (int n = 0; n < 60; ++n) text += std::to_string(n % 7) + (n % 3 == 2 ? "\n" : " ");
    for (const auto& [encoding, content] :
         {std::pair<std::string, std::string>{"raw", data}, {"gzip", deflated(data)}, {"ascii", text}}) {
        const Outcome outcome = read_bytes(nrrd_header("", "space: LPS\n", encoding) + content);
        ASSERT_TRUE(outcome.ok()) << encoding << to_line(outcome.error);
        EXPECT_TRUE(outcome.warnings.empty());
        for (int n = 0; n < 60; ++n) EXPECT_EQ(outcome.loaded.image.voxels[n], n % 7);
        expect_position(outcome.loaded, 2, 3, 4, {11.5, 21.5, 38});
    }
    EXPECT_TRUE(read_bytes(deflated(nrrd_header() + data)).ok());
}

TEST(Nrrd, N17_data_file_stays_in_the_folder) {
    const Folder folder;
    folder.write("secret.raw", data);
    folder.write("set/data.raw", data);
    folder.write("set/below/data.raw", data);
    std::filesystem::create_symlink(folder.path("secret.raw"), folder.path("set/link.raw"));
    const auto with = [&](const std::string& name) {
        return read(folder.write("set/image.nhdr", nrrd_header("data file: " + name + "\n")));
    };
    const Outcome good = with("data.raw");
    ASSERT_TRUE(good.ok()) << to_line(good.error);
    EXPECT_EQ(good.loaded.inputs.size(), 2U);
    EXPECT_TRUE(with("below/data.raw").ok());
    for (const char* name : {"/etc/passwd", "../secret.raw", "below/../../secret.raw",
                             "http://example.org/data.raw", "image.nhdr", "./image.nhdr", "link.raw", ".."})
        EXPECT_EQ(with(name).code, "E-IMG-013") << name;
    for (const char* name : {"LIST", "LIST 2\ndata.raw", "data%03d.raw 1 1000000000 1"})
        EXPECT_EQ(with(name).code, "E-IMG-015") << name;
    EXPECT_EQ(with("absent.raw").code, "E-INP-001");
    EXPECT_EQ(with("below").code, "E-INP-003");
}

TEST(Nrrd, N18_sizes_and_encodings) {
    const auto with_sizes = [](const std::string& sizes, const std::string& encoding,
                               const std::string& content) {
        return read_bytes(
            "NRRD0004\ntype: short\ndimension: 3\nsizes: " + sizes +
            "\nendian: little\nencoding: " + encoding +
            "\nspace: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n\n" + content);
    };
    forget_peak_memory();
    const std::uint64_t before = memory_now();
    EXPECT_EQ(with_sizes("4294967295 4294967295 4294967295", "raw", data).code, "E-IMG-004");
    EXPECT_EQ(with_sizes("4294967296 4294967296 8", "raw", data).code, "E-IMG-003");
    EXPECT_EQ(with_sizes("1000 1000 1000", "raw", data).code, "E-IMG-005");
    EXPECT_EQ(with_sizes("1000 1000 1000", "ascii", "1 2 3").code, "E-IMG-005");
    EXPECT_FALSE(with_sizes("1000 1000 1000", "gzip", deflated(data)).ok());
    EXPECT_LE(peak_memory(), before + (std::uint64_t{16} << 20));
    EXPECT_EQ(with_sizes("3 4 5", "ascii", std::string(240, '1')).code, "E-IMG-005");
    EXPECT_EQ(with_sizes("1 1 2", "ascii", "1 x").code, "E-IMG-014");
    EXPECT_EQ(with_sizes("3 4 5", "bzip2", "BZh9" + data).code, "E-NRD-007");
    EXPECT_EQ(with_sizes("3 4 5", "hex", data).code, "E-NRD-007");
    for (const char* sizes : {"3 4", "3 4 5 6", "0 4 5", "-3 4 5", "3.5 4 5", "99999999999999999999 1 1", ""})
        EXPECT_FALSE(with_sizes(sizes, "raw", data).ok()) << sizes;
    // A bomb behind a modest header.
    EXPECT_EQ(with_sizes("3 4 5", "gzip", deflated(std::string(std::size_t{64} << 20, '\0'), 31, 1)).code,
              "E-INP-012");
}

TEST(Nrrd, N19_spaces) {
    const auto origin = [](const std::string& space) {
        const Outcome outcome = read_bytes(nrrd_header("", "space: " + space + "\n") + data);
        EXPECT_TRUE(outcome.ok()) << to_line(outcome.error);
        return outcome.loaded;
    };
    expect_position(origin("left-posterior-superior"), 1, 1, 1, {10.75, 20.5, 32});
    expect_position(origin("LPS"), 1, 1, 1, {10.75, 20.5, 32});
    expect_position(origin("right-anterior-superior"), 1, 1, 1, {-10.75, -20.5, 32});
    expect_position(origin("RAS"), 1, 1, 1, {-10.75, -20.5, 32});
    expect_position(origin("left-anterior-superior"), 1, 1, 1, {10.75, -20.5, 32});
    expect_position(origin("LAS"), 1, 1, 1, {10.75, -20.5, 32});
    // Spaces that do not tell the patient's axes, and none.
    for (const char* space :
         {"", "space: scanner-xyz\n", "space: 3D-right-handed\n", "space dimension: 3\n"}) {
        const std::string bytes = nrrd_header("", space) + data;
        const Outcome refused = read_bytes(bytes);
        EXPECT_EQ(refused.code, "E-NRD-009") << space;
        EXPECT_NE(refused.error.next_step.find("--frame"), std::string::npos);
        ReadImageOptions options;
        options.frame = ImageFrame::ras;
        const Outcome chosen = read_bytes(bytes, options);
        ASSERT_TRUE(chosen.ok());
        EXPECT_TRUE(chosen.warned("W-NRD-003"));
        expect_position(chosen.loaded, 1, 1, 1, {-10.75, -20.5, 32});
        options.frame = ImageFrame::lps;
        expect_position(read_bytes(bytes, options).loaded, 1, 1, 1, {10.75, 20.5, 32});
    }
}

TEST(Nrrd, N19_a_fourth_axis_before_or_behind_space) {
    std::vector<std::int16_t> values;
    for (int n = 0; n < 120; ++n) values.push_back(static_cast<std::int16_t>(n));
    const auto with = [&](const std::string& sizes, const std::string& directions, int volume) {
        ReadImageOptions options;
        if (volume >= 0) options.volume = static_cast<std::uint64_t>(volume);
        return read_bytes("NRRD0004\ntype: short\ndimension: 4\nsizes: " + sizes +
                              "\nendian: little\nencoding: raw\nspace: LPS\nspace directions: " + directions +
                              "\nspace origin: (0,0,0)\n\n" + values_as_bytes(values),
                          options);
    };
    const std::string before = "none (1,0,0) (0,1,0) (0,0,1)", behind = "(1,0,0) (0,1,0) (0,0,1) none";
    EXPECT_EQ(with("2 3 4 5", before, -1).code, "E-IMG-008");
    EXPECT_EQ(with("2 3 4 5", before, 2).code, "E-IMG-009");
    Outcome outcome = with("2 3 4 5", before, 1);
    ASSERT_TRUE(outcome.ok());
    EXPECT_EQ(outcome.loaded.image.voxels[0], 1);
    EXPECT_EQ(outcome.loaded.image.voxels[59], 119);
    outcome = with("3 4 5 2", behind, 1);
    ASSERT_TRUE(outcome.ok());
    EXPECT_EQ(outcome.loaded.image.voxels[0], 60);
    EXPECT_EQ(outcome.loaded.image.voxels[59], 119);
    // In the midst of space, or one too few.
    EXPECT_EQ(with("3 4 2 5", "(1,0,0) (0,1,0) none (0,0,1)", 0).code, "E-NRD-008");
    EXPECT_EQ(with("3 4 2 5", "(1,0,0) (0,1,0) none none", 0).code, "E-NRD-008");
    EXPECT_EQ(with("3 4 2 5", "(1,0,0) (0,1,0) (0,0,1)", 0).code, "E-NRD-005");
    // One volume is no choice.
    EXPECT_TRUE(with("1 3 4 5", before, -1).ok());
}

TEST(Nrrd, N20_skips_and_line_ends) {
    const auto with = [](const std::string& more, const std::string& content) {
        return read_bytes(nrrd_header(more) + content);
    };
    EXPECT_TRUE(with("byte skip: 5\n", "12345" + data).ok());
    EXPECT_TRUE(with("line skip: 2\n", "one\ntwo\n" + data).ok());
    const Outcome from_end = with("byte skip: -1\n", "anything before" + data);
    ASSERT_TRUE(from_end.ok());
    EXPECT_EQ(from_end.loaded.image.voxels[6], 6);
    EXPECT_EQ(with("byte skip: -2\n", data).code, "E-NRD-005");
    EXPECT_EQ(with("byte skip: 1000\n", data).code, "E-NRD-010");
    EXPECT_EQ(with("byte skip: 9223372036854775807\n", data).code, "E-NRD-010");
    EXPECT_EQ(with("byte skip: 99999999999999999999\n", data).code, "E-NRD-005");
    EXPECT_EQ(with("line skip: 1000000000000\n", data).code, "E-NRD-010");
    EXPECT_EQ(with("line skip: -1\n", data).code, "E-NRD-005");

    std::string windows = nrrd_header();
    for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2)
        windows.insert(at, "\r");
    EXPECT_TRUE(read_bytes(windows + data).ok());
    EXPECT_TRUE(with("# \x01\xff\x80 bytes\n", data).ok());
    EXPECT_EQ(with("# " + std::string(std::size_t{20} << 20, 'x') + "\n", data).code, "E-NRD-002");
    EXPECT_EQ(with("a line of no kind\n", data).code, "E-NRD-002");
    // Without the blank line the data is taken for header lines, or is missing.
    std::string unseparated = nrrd_header();
    unseparated.pop_back();
    EXPECT_FALSE(read_bytes(unseparated + data).ok());
    EXPECT_EQ(read_bytes(unseparated).code, "E-IMG-005");
}

TEST(Nrrd, N21_repeated_and_unknown_fields) {
    EXPECT_TRUE(read_bytes(nrrd_header("sizes: 3 4 5\n") + data).ok());
    EXPECT_EQ(read_bytes(nrrd_header("sizes: 3 4 4\n") + data).code, "E-NRD-003");
    EXPECT_EQ(read_bytes(nrrd_header("Space: RAS\n") + data).code, "E-NRD-003");
    const Outcome unknown = read_bytes(nrrd_header("flavour: sweet\n") + data);
    ASSERT_TRUE(unknown.ok());
    EXPECT_TRUE(unknown.warned("W-NRD-001"));
    EXPECT_TRUE(read_bytes(nrrd_header("key:=value\n") + data).warnings.empty());
}

TEST(Nrrd, N21_missing_and_unusable_fields) {
    for (const char* field : {"type: ", "dimension: ", "sizes: ", "encoding: ", "endian: "}) {
        std::string header = nrrd_header();
        const std::size_t at = header.find(field);
        header.erase(at, header.find('\n', at) + 1 - at);
        EXPECT_EQ(read_bytes(header + data).code, "E-NRD-004") << field;
    }
    const auto replaced = [](const std::string& from, const std::string& to) {
        std::string header = nrrd_header();
        header.replace(header.find(from), from.size(), to);
        return read_bytes(header + data).code;
    };
    EXPECT_EQ(replaced("short", "block"), "E-NRD-006");
    EXPECT_EQ(replaced("little", "middle"), "E-NRD-005");
    EXPECT_EQ(replaced("NRRD0004", "NRRD0009"), "E-NRD-001");
    EXPECT_EQ(replaced("(0,0.5,0)", "(0,0.5)"), "E-NRD-005");
    EXPECT_EQ(replaced("(0,0.5,0)", "(0,nan,0)"), "E-NRD-005");
    EXPECT_EQ(replaced("(0,0.5,0)", "(0,0,0)"), "E-IMG-007");
    EXPECT_EQ(replaced("(0,0.5,0)", "(0,0.003,0)"), "E-IMG-018");  // hundreds of times as long as wide
    EXPECT_EQ(replaced("(0,0.5,0)", "(0,0.02,0)"), "");
    EXPECT_EQ(replaced("(0,0.5,0)", "(0,1,5,0)"), "E-NRD-005");
    EXPECT_EQ(replaced("(10,20,30)", "(10,20,30) x"), "E-NRD-005");
    EXPECT_EQ(replaced("dimension: 3", "dimension: 300"), "E-NRD-005");
    EXPECT_EQ(replaced("space directions", "measurement frame"), "E-NRD-004");
}

TEST(Nrrd, units_of_the_space) {
    const Outcome metres = read_bytes(nrrd_header("space units: \"m\" \"m\" \"m\"\n") + data);
    ASSERT_TRUE(metres.ok());
    expect_position(metres.loaded, 0, 0, 0, {10000, 20000, 30000});
    EXPECT_TRUE(read_bytes(nrrd_header("space units: \"ell\" \"ell\" \"ell\"\n") + data).warned("W-NRD-002"));
    EXPECT_EQ(read_bytes(nrrd_header("space units: \"mm\" \"mm\" \"cm\"\n") + data).code, "E-NRD-005");
}

TEST(Nrrd, names_and_colours_of_segments) {
    const Outcome outcome =
        read_bytes(nrrd_header("Segment0_Name:=left kidney\nSegment0_LabelValue:=3\nSegment0_Color:=1 0.5 0\n"
                               "Segment1_Name:=spleen\nSegment1_LabelValue:=1\nSegmentX_Name:=nothing\n") +
                   data);
    ASSERT_TRUE(outcome.ok());
    RunContext context;
    const auto map = to_label_map(outcome.loaded, context);
    ASSERT_TRUE(map.ok());
    ASSERT_EQ(map.value().structures.size(), 6U);
    EXPECT_EQ(map.value().structures[0].name, "spleen");
    EXPECT_EQ(map.value().structures[1].name, "");
    EXPECT_EQ(map.value().structures[2].name, "left kidney");
    EXPECT_EQ(map.value().structures[2].color, (std::array<std::uint8_t, 3>{255, 128, 0}));
}

// Where segments overlap Slicer writes several volumes, in which one label has several meanings.
TEST(Nrrd, segments_are_those_of_the_volume_that_is_read) {
    const std::string header =
        "NRRD0004\ntype: short\ndimension: 4\nsizes: 2 3 4 5\nendian: little\nencoding: raw\nspace: LPS\n"
        "space directions: none (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n"
        "Segment0_Name:=one\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n"
        "Segment1_Name:=two\nSegment1_LabelValue:=1\nSegment1_Layer:=1\n"
        "Segment2_Name:=three\nSegment2_LabelValue:=2\nSegment2_Layer:=1\n\n";
    std::vector<std::int16_t> values;
    for (int n = 0; n < 120; ++n) values.push_back(static_cast<std::int16_t>(n % 3));
    for (const std::uint64_t volume : {0U, 1U}) {
        ReadImageOptions options;
        options.volume = volume;
        const Outcome outcome = read_bytes(header + values_as_bytes(values), options);
        ASSERT_TRUE(outcome.ok());
        RunContext context;
        const auto map = to_label_map(outcome.loaded, context);
        ASSERT_TRUE(map.ok());
        ASSERT_EQ(map.value().structures.size(), 2U);
        EXPECT_EQ(map.value().structures[0].name, volume == 0 ? "one" : "two");
        EXPECT_EQ(map.value().structures[1].name, volume == 0 ? "" : "three");
    }
}

}  // namespace
}  // namespace anatomesh::nrrd_test
