#include "anatomesh_io/image/image_fixtures.h"

namespace anatomesh::metaimage_test {
namespace {

using namespace fixtures;

const std::string data = Nifti().default_data();

std::string replaced(std::string header, const std::string& from, const std::string& to) {
    header.replace(header.find(from), from.size(), to);
    return header;
}

TEST(MetaImage, good_image_reads_plain_compressed_and_as_text) {
    std::string text;
    for (int n = 0; n < 60; ++n) text += std::to_string(n % 7) + " ";
    const std::string header = metaimage_header();
    const std::string compressed = replaced(header, "CompressedData = False", "CompressedData = True");
    const std::string as_text = replaced(header, "BinaryData = True", "BinaryData = False");
    const std::string big = replaced(header, "OrderMSB = False", "OrderMSB = True");
    Nifti big_endian;
    big_endian.order = std::endian::big;
    for (const std::string& bytes :
         {header + data, compressed + deflated(data, 15), compressed + deflated(data, 31), as_text + text,
          big + big_endian.default_data()}) {
        const Outcome outcome = read_bytes(bytes);
        ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
        EXPECT_TRUE(outcome.warnings.empty());
        for (int n = 0; n < 60; ++n) EXPECT_EQ(outcome.loaded.image.voxels[n], n % 7);
        expect_position(outcome.loaded, 2, 3, 4, {11.5, 21.5, 38});
    }
}

TEST(MetaImage, rows_of_the_matrix_are_the_directions_of_the_axes) {
    const std::string header = replaced(metaimage_header(), "TransformMatrix = 1 0 0 0 1 0 0 0 1",
                                        "TransformMatrix = 0 1 0 0 0 -1 -1 0 0");
    const Outcome outcome = read_bytes(header + data);
    ASSERT_TRUE(outcome.ok());
    expect_position(outcome.loaded, 1, 0, 0, {10, 20.75, 30});
    expect_position(outcome.loaded, 0, 1, 0, {10, 20, 29.5});
    expect_position(outcome.loaded, 0, 0, 1, {8, 20, 30});
}

TEST(MetaImage, N03_claims_more_voxels_than_it_has) {
    forget_peak_memory();
    const std::uint64_t before = memory_now();
    const auto sized = [](const std::string& sizes) {
        return read_bytes(replaced(metaimage_header(), "DimSize = 3 4 5", "DimSize = " + sizes) + data).code;
    };
    EXPECT_EQ(sized("1000 1000 1000"), "E-IMG-005");
    EXPECT_EQ(sized("4294967295 4294967295 4294967295"), "E-IMG-004");
    EXPECT_EQ(sized("4294967296 1 1"), "E-IMG-003");
    for (const char* sizes : {"0 4 5", "-3 4 5", "3 4", "3 4 5 6", "3 4 x", ""})
        EXPECT_EQ(sized(sizes), "E-MTI-003");
    EXPECT_LE(peak_memory(), before + (std::uint64_t{16} << 20));
}

TEST(MetaImage, N09_units) {
    const Outcome outcome = read_bytes(metaimage_header("DistanceUnits = cm\n") + data);
    ASSERT_TRUE(outcome.ok());
    expect_position(outcome.loaded, 1, 0, 0, {107.5, 200, 300});
    EXPECT_EQ(read_bytes(metaimage_header("DistanceUnits = ell\n") + data).code, "E-MTI-003");
}

TEST(MetaImage, N11_damaged_compression) {
    const std::string header =
        replaced(metaimage_header(), "CompressedData = False", "CompressedData = True");
    const std::string good = deflated(data, 15);
    for (std::size_t size = 0; size < good.size(); ++size)
        EXPECT_FALSE(read_bytes(header + good.substr(0, size)).ok()) << size;
    std::string wrong = good;
    wrong.back() ^= 1;
    EXPECT_EQ(read_bytes(header + wrong).code, "E-INP-011");
    EXPECT_EQ(read_bytes(header + deflated(std::string(std::size_t{64} << 20, '\0'), 15, 1)).code,
              "E-INP-012");
}

TEST(MetaImage, N14_volumes_and_channels) {
    std::vector<std::int16_t> values;
    for (int n = 0; n < 120; ++n) values.push_back(static_cast<std::int16_t>(n));
    const std::string bytes = metaimage_header("ElementNumberOfChannels = 2\n") + values_as_bytes(values);
    EXPECT_EQ(read_bytes(bytes).code, "E-IMG-008");
    ReadImageOptions options;
    options.volume = 1;
    const Outcome outcome = read_bytes(bytes, options);
    ASSERT_TRUE(outcome.ok());
    EXPECT_EQ(outcome.loaded.image.voxels[0], 1);
    EXPECT_EQ(outcome.loaded.image.voxels[59], 119);
    EXPECT_EQ(read_bytes(replaced(metaimage_header(), "MET_SHORT", "MET_STRING") + data).code, "E-MTI-006");
}

TEST(MetaImage, N16_data_shorter_than_the_header_says) {
    EXPECT_EQ(read_bytes(metaimage_header() + data.substr(1)).code, "E-IMG-005");
    EXPECT_TRUE(read_bytes(metaimage_header() + data + "x").warned("W-IMG-001"));
}

TEST(MetaImage, N17_data_file_stays_in_the_folder) {
    const Folder folder;
    folder.write("set/data.raw", data);
    folder.write("secret.raw", data);
    const auto with = [&](const std::string& name) {
        return read(folder.write("set/image.mhd", replaced(metaimage_header(), "LOCAL", name)));
    };
    const Outcome good = with("data.raw");
    ASSERT_TRUE(good.ok()) << to_line(good.error);
    EXPECT_EQ(good.loaded.inputs.size(), 2U);
    for (const char* name : {"/etc/passwd", "../secret.raw", "image.mhd", "file:///etc/passwd"})
        EXPECT_EQ(with(name).code, "E-IMG-013") << name;
    for (const char* name : {"LIST", "slice%03d.raw 1 1000000000 1"})
        EXPECT_EQ(with(name).code, "E-IMG-015") << name;
}

TEST(MetaImage, N20_header_size) {
    EXPECT_TRUE(read_bytes(metaimage_header("HeaderSize = 7\n") + "1234567" + data).ok());
    EXPECT_TRUE(read_bytes(metaimage_header("HeaderSize = -1\n") + "anything" + data).ok());
    for (const char* size : {"-2", "100000", "abc", "99999999999999999999"})
        EXPECT_EQ(read_bytes(metaimage_header(std::string("HeaderSize = ") + size + "\n") + data).code,
                  "E-MTI-003");
}

TEST(MetaImage, N21_repeated_unknown_and_missing_keys) {
    EXPECT_EQ(read_bytes(metaimage_header("DimSize = 3 4 4\n") + data).code, "E-MTI-004");
    EXPECT_EQ(read_bytes(metaimage_header("Position = 0 0 0\n") + data).code, "E-MTI-004");
    EXPECT_TRUE(read_bytes(metaimage_header("Flavour = sweet\n") + data).warned("W-MTI-001"));
    EXPECT_EQ(read_bytes(metaimage_header("no equals sign\n") + data).code, "E-MTI-001");
    const std::string header = metaimage_header();
    EXPECT_EQ(read_bytes(header.substr(0, header.find("ElementDataFile"))).code, "E-MTI-002");
    EXPECT_EQ(read_bytes(replaced(header, "ElementSpacing = 0.75 0.5 2\n", "") + data).code, "E-MTI-002");
    const Outcome placed = read_bytes(replaced(header, "Offset = 10 20 30\n", "") + data);
    ASSERT_TRUE(placed.ok());
    EXPECT_TRUE(placed.warned("W-MTI-002"));
    EXPECT_TRUE(read_bytes(replaced(header, "= RAI", "= LPS") + data).warned("W-MTI-003"));
    for (const char* spacing : {"0 1 1", "-1 1 1", "nan 1 1", "1,5 1 1", "1 1"})
        EXPECT_EQ(read_bytes(replaced(header, "0.75 0.5 2", spacing) + data).code, "E-MTI-003") << spacing;
    EXPECT_EQ(read_bytes(replaced(header, "= Image", "= Mesh") + data).code, "E-MTI-005");
}

TEST(MetaImage, frame_is_for_files_that_say_nothing) {
    ReadImageOptions options;
    options.frame = ImageFrame::ras;
    expect_position(read_bytes(metaimage_header() + data, options).loaded, 0, 0, 0, {10, 20, 30});
    std::string silent = replaced(metaimage_header(), "TransformMatrix = 1 0 0 0 1 0 0 0 1\n", "");
    silent = replaced(silent, "AnatomicalOrientation = RAI\n", "");
    expect_position(read_bytes(silent + data, options).loaded, 0, 0, 0, {-10, -20, 30});
}

}  // namespace
}  // namespace anatomesh::metaimage_test
