#include "anatomesh_io/dicom/segmentation.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <string>

#include "anatomesh_io/dicom/segmentation_fixtures.h"

namespace anatomesh::segmentation_test {
namespace {

using fixtures::SegFile;
using fixtures::SegFrame;

struct Read {
    RunContext context;
    std::optional<Result<LoadedSegmentation>> result;

    explicit Read(const std::string& file, const ReadSegmentationOptions& options = {}) {
        result.emplace(read_dicom_segmentation(file, "seg.dcm", options, context));
    }
    std::string code() const { return result->ok() ? "" : result->error().code; }
    std::string line() const { return result->ok() ? "" : to_line(result->error()); }
    const LabelMap& layer() const { return result->value().layers[0]; }
    std::uint16_t at(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
        return layer().voxels[layer().geometry.index(i, j, k)];
    }
    bool warned(const std::string& code) const {
        return std::any_of(context.warnings.begin(), context.warnings.end(),
                           [&](const Warning& warning) { return warning.code == code; });
    }
};

TEST(DicomSegmentation, L02_L10_frames_in_any_order_and_empty_ones_not_stored) {
    SegFile file = SegFile::stack(6);
    for (std::size_t k = 0; k < 6; ++k) file.frames[k].pixels.assign(15, 0), file.frames[k].pixels[k] = 1;
    file.frames.erase(file.frames.begin() + 2);
    const Read whole(file.bytes());
    ASSERT_EQ(whole.code(), "") << whole.line();
    std::mt19937 random(1);
    for (int round = 0; round < 10; ++round) {
        std::shuffle(file.frames.begin(), file.frames.end(), random);
        const Read shuffled(file.bytes());
        ASSERT_EQ(shuffled.code(), "") << shuffled.line();
        EXPECT_EQ(shuffled.layer().voxels, whole.layer().voxels);
        EXPECT_EQ(shuffled.layer().geometry.size, (std::array<std::uint32_t, 3>{5, 3, 6}));
    }
    for (std::uint32_t k = 0; k < 6; ++k) EXPECT_EQ(whole.at(k % 5, k / 5, k), k == 2 ? 0 : 1);
    EXPECT_TRUE(whole.warned("W-SEG-004"));
}

// The format leaves out frames that are empty, so that the last stored one says nothing of the image's end.
TEST(DicomSegmentation, TheImageEndsWhereImagesBesideItEnd) {
    const std::string file = SegFile::stack(4).bytes();
    EXPECT_EQ(Read(file).layer().ends_at_image, (std::array{false, false}));
    ReadSegmentationOptions options;
    for (int k = 0; k < 9; ++k) options.image_positions.push_back({0, 0, 3.0 * k});
    EXPECT_EQ(Read(file, options).layer().ends_at_image, (std::array{true, false}));
    options.image_positions.resize(4);
    EXPECT_EQ(Read(file, options).layer().ends_at_image, (std::array{true, true}));
}

// Two lesions are not one because nothing is stored between them.
TEST(DicomSegmentation, FramesFarApartAreAsThickAsStated) {
    SegFile file = SegFile::stack(9);
    file.frames = {file.frames[0], file.frames[8]};
    const Read read(file.bytes());
    ASSERT_EQ(read.code(), "") << read.line();
    EXPECT_EQ(read.layer().geometry.size[2], 9u);
    EXPECT_NEAR(length(read.layer().geometry.step[2]), 3, 1e-12);
    for (std::uint32_t k = 0; k < 9; ++k) EXPECT_EQ(read.at(0, 0, k), k % 8 == 0 ? 1 : 0);
    EXPECT_TRUE(read.warned("W-SEG-004"));
}

TEST(DicomSegmentation, L05_fractional_at_half_of_the_maximum) {
    SegFile file = SegFile::stack(1);
    file.type = "FRACTIONAL";
    file.bits = 8;
    file.frames[0].pixels = {0, 1, 100, 127, 128, 200, 255, 0, 0, 0, 0, 0, 0, 0, 0};
    const Read read(file.bytes());
    ASSERT_EQ(read.code(), "") << read.line();
    EXPECT_TRUE(read.warned("W-SEG-001"));
    for (std::uint32_t i = 0; i < 15; ++i) EXPECT_EQ(read.at(i % 5, i / 5, 0), i >= 4 && i <= 6 ? 1 : 0) << i;
}

TEST(DicomSegmentation, L06_numbers_with_gaps_many_labels_and_label_0) {
    // Numbers need not follow each other; what is declared and has no frame is said.
    SegFile gaps = SegFile::stack(3);
    gaps.segments = {2, 7, 65535};
    gaps.frames[0].segment = 2;
    gaps.frames[1].segment = 65535;
    gaps.frames[2].segment = 4;  // not declared
    const Read read(gaps.bytes());
    ASSERT_EQ(read.code(), "") << read.line();
    std::vector<std::int32_t> numbers;
    for (const Structure& structure : read.layer().structures) numbers.push_back(structure.number);
    EXPECT_EQ(numbers, (std::vector<std::int32_t>{2, 4, 65535}));
    EXPECT_TRUE(read.warned("W-SEG-002"));
    EXPECT_TRUE(read.warned("W-SEG-003"));

    SegFile zero = SegFile::stack(2);
    zero.segments = {0, 3};
    zero.frames[0].segment = 0;
    zero.frames[1].segment = 3;
    const Read renumbered(zero.bytes());
    ASSERT_EQ(renumbered.code(), "") << renumbered.line();
    EXPECT_TRUE(renumbered.warned("W-SEG-006"));
    EXPECT_EQ(renumbered.layer().structures[1].number, 4);

    SegFile twice = SegFile::stack(2);
    twice.segments = {1, 1};
    EXPECT_EQ(Read(twice.bytes()).code(), "E-SEG-002");

    // Every label there can be, in one object.
    SegFile many;
    many.type = "LABELMAP";
    many.bits = 16;
    many.columns = many.rows = 256;
    many.segments = {};
    SegFrame frame{{0, 0, 0}, 1, std::vector<std::uint16_t>(65536)};
    for (std::size_t n = 0; n < 65536; ++n) frame.pixels[n] = static_cast<std::uint16_t>(n);
    many.frames = {frame};
    const Read all(many.bytes());
    ASSERT_EQ(all.code(), "") << all.line();
    ASSERT_EQ(all.layer().structures.size(), 65535u);
    EXPECT_EQ(all.layer().structures.back().number, 65535);
    EXPECT_EQ(all.at(0, 0, 0), 0);
    EXPECT_EQ(all.at(255, 255, 0), 65535);
}

TEST(DicomSegmentation, L07_label_map_segmentations) {
    SegFile file = SegFile::stack(2);
    file.type = "LABELMAP";
    file.segments = {1, 9};
    for (const std::uint16_t bits : {8, 16}) {
        file.bits = bits;
        file.frames[0].pixels = {0, 1, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
        const Read read(file.bytes());
        ASSERT_EQ(read.code(), "") << read.line();
        EXPECT_EQ(read.result->value().type, "LABELMAP");
        EXPECT_EQ(read.at(0, 0, 0), 0);
        EXPECT_EQ(read.at(1, 0, 0), 1);
        EXPECT_EQ(read.layer().structures[read.at(2, 0, 0) - 1u].number, 9);
    }
    file.bits = 1;
    EXPECT_EQ(Read(file.bytes()).code(), "E-SEG-006");
    file.type = "SURFACE";
    EXPECT_EQ(Read(file.bytes()).code(), "E-SEG-006");
}

TEST(DicomSegmentation, L08_planes_of_their_own) {
    // Turned by 30 degrees about x, pixels of 0.5 x 2 mm, and sheared as by a gantry tilt.
    const double c = std::cos(0.5), s = std::sin(0.5);
    const Vec3 row{1, 0, 0}, column{0, c, s};
    for (const Vec3 step : {3.0 * cross(row, column), Vec3{0, 0, 3}, Vec3{0.5, 0, 3}}) {
        SegFile file = SegFile::stack(4);
        file.shared_axes = std::pair{row, column};
        for (std::size_t k = 0; k < 4; ++k) {
            file.frames[k].position = Vec3{-40, 7, 11} + static_cast<double>(k) * step;
            file.frames[k].pixels.assign(15, 0);
            file.frames[k].pixels[7] = 1;
        }
        const Read read(file.bytes());
        ASSERT_EQ(read.code(), "") << read.line();
        const Vec3 found = read.layer().geometry.position(2, 1, 3);
        const Vec3 wanted = Vec3{-40, 7, 11} + 3.0 * step + 2 * 2.0 * row + 0.5 * column;
        EXPECT_NEAR(length(found - wanted), 0, 1e-9);
        EXPECT_EQ(read.at(2, 1, 3), 1);
    }
}

TEST(DicomSegmentation, L09_orientation_that_differs_between_shared_and_own) {
    SegFile file = SegFile::stack(3);
    file.frames[2].axes = std::pair{Vec3{-1, 0, 0}, Vec3{0, 1, 0}};
    const Read read(file.bytes());
    EXPECT_EQ(read.code(), "E-DCM-009");
    EXPECT_NE(read.line().find("frame 3"), std::string::npos) << read.line();
    // The same in both is no contradiction.
    file.frames[2].axes = file.shared_axes;
    EXPECT_EQ(Read(file.bytes()).code(), "");
}

TEST(DicomSegmentation, L11_frames_in_planes_that_are_not_parallel) {
    SegFile file = SegFile::stack(5);
    file.shared_axes.reset();
    for (std::size_t k = 0; k < 5; ++k) {
        const double angle = 0.1 * static_cast<double>(k);
        file.frames[k].axes = std::pair{Vec3{1, 0, 0}, Vec3{0, std::cos(angle), std::sin(angle)}};
    }
    const Read read(file.bytes());
    EXPECT_EQ(read.code(), "E-SEG-003");
    EXPECT_NE(read.line().find("frame 2"), std::string::npos) << read.line();
}

std::string deflated(const std::string& bytes) {
    z_stream stream{};
    EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
    std::string out(deflateBound(&stream, bytes.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

TEST(DicomSegmentation, L12_bombs) {
    // A deflated data set of 64 MB of zeros in 64 KB.
    DicomWriter writer(DicomWriter::Syntax::explicit_little);
    writer.element(tags::pixel_data, "OB", std::string(std::size_t{64} << 20, '\0'));
    DicomWriter syntax(DicomWriter::Syntax::explicit_little);
    syntax.element(tags::transfer_syntax, "UI", "1.2.840.10008.1.2.1.99");
    const Read bomb(std::string(128, '\0') + "DICM" + syntax.bytes() + deflated(writer.bytes()));
    EXPECT_EQ(bomb.code(), "E-DCL-009");

    // Run lengths that claim far more pixels than they hold: refused before memory is taken.
    SegFile runs = SegFile::stack(1);
    runs.type = "FRACTIONAL";
    runs.bits = 8;
    runs.columns = runs.rows = 65535;
    runs.frames[0].pixels = {};
    const std::string fragment = std::string("\xFE\xFF\x00\xE0\0\0\0\0\xFE\xFF\x00\xE0\x10\0\0\0", 16) +
                                 std::string(16, '\0') + std::string("\xFE\xFF\xDD\xE0\0\0\0\0", 8);
    runs.pixel_data = fragment;
    std::string file = runs.bytes("1.2.840.10008.1.2.5");
    const std::size_t at = file.rfind(std::string("\xE0\x7F\x10\x00OB\0\0", 8));
    ASSERT_NE(at, std::string::npos);
    file.replace(at + 8, 4, "\xFF\xFF\xFF\xFF");
    const Read run(file);
    EXPECT_EQ(run.code(), "E-SEG-009") << run.line();
}

}  // namespace
}  // namespace anatomesh::segmentation_test
