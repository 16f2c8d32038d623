// DICOM files as bytes: damaged, foreign, in every transfer syntax, one frame or many.
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gdcmTrace.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "anatomesh_io/dicom/dicom_fixtures.h"
#include "anatomesh_io/dicom/jpeg2000_stream.h"
#include "anatomesh_io/dicom/pixels.h"
#include "anatomesh_io/dicom/read_series.h"
#include "anatomesh_io/file/comma_locale_fixture.h"

namespace anatomesh::dicom_files_test {
namespace {

using fixtures::ct_series;
using fixtures::ct_slice;
using fixtures::name_of_slice;
using fixtures::numbers;
using fixtures::Reading;
using fixtures::short_bytes;
using fixtures::SliceFile;

std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<float> voxels_of(const std::vector<SliceFile>& files) {
    Reading reading(files);
    EXPECT_EQ(reading.code(), "") << reading.line();
    return reading.image->value().image.voxels;
}

TEST(DicomFiles, D01_nothing_in_it) {
    for (const std::string& content :
         {std::string(), std::string(131, '\0'), std::string(128, '\0') + "DICM"}) {
        Reading reading(ct_series(3));
        reading.disk.write("folder/other", content);
        EXPECT_EQ(reading.code(), "") << reading.line();
        EXPECT_TRUE(reading.warned("W-DCM-001") || reading.warned("W-DCM-002")) << content.size();
        Reading alone;
        alone.disk.write("folder/other", content);
        alone.scan();
        EXPECT_TRUE(alone.folder->objects.empty());
    }
}

TEST(DicomFiles, D02_rubbish_among_the_slices) {
    Reading reading(ct_series(3));
    reading.disk.write("folder/a.jpg", "\xFF\xD8\xFF\xE0 some picture");
    reading.disk.write("folder/report.pdf", "%PDF-1.4");
    reading.disk.write("folder/.DS_Store", std::string("\0\0\0\1Bud1", 8));
    reading.disk.write("folder/deep/er/notes.txt", "notes");
    SliceFile directory;
    directory.set(tags::sop_class, "UI", "1.2.840.10008.1.3.10");
    directory.set(tags::sop_instance, "UI", "1.2.3");
    reading.disk.write("folder/DICOMDIR", directory.bytes());
    EXPECT_EQ(reading.code(), "") << reading.line();
    EXPECT_EQ(reading.folder->skipped, 5u);
    EXPECT_EQ(reading.folder->files, 8u);
    EXPECT_TRUE(reading.warned("W-DCM-001"));
}

TEST(DicomFiles, D03_cut_off_anywhere) {
    std::vector<SliceFile> files;
    for (int k = 0; k < 4; ++k) files.push_back(ct_slice(k, {0, 0, 3.0 * k}, 60, 60));
    const std::string whole = files[2].bytes();
    int named = 0, passed_over = 0;
    for (std::size_t size = 0; size + 1 < whole.size(); size += size < 1024 ? 16 : 64) {
        Reading reading(files);
        reading.disk.write(name_of_slice(2), whole.substr(0, size));
        const std::string code = reading.code();
        // Either the series is refused, or the file was cut before it said its series: then a slice is
        // missing, which is an error as well.
        EXPECT_TRUE(code == "E-DCL-004" || code == "E-DCM-014" || code == "E-DCL-006" || code == "E-DCM-004")
            << size << " " << reading.line();
        if (code == "E-DCL-004") {
            ++named;
            EXPECT_NE(reading.line().find("folder file 3"), std::string::npos) << reading.line();
            EXPECT_NE(reading.line().find("at byte"), std::string::npos) << reading.line();
        } else {
            ++passed_over;
        }
    }
    EXPECT_GT(named, 100);
    EXPECT_LT(passed_over, 60);
}

TEST(DicomFiles, D04_no_preamble_no_meta_header) {
    const auto expected = voxels_of(ct_series(3));
    for (const std::size_t skipped : {std::size_t{132}, std::size_t{0}})
        for (const auto syntax :
             {DicomWriter::Syntax::explicit_little, DicomWriter::Syntax::implicit_little}) {
            auto files = ct_series(3);
            Reading reading;
            for (std::size_t k = 0; k < 3; ++k) {
                files[k].syntax = syntax;
                const std::string bytes = files[k].bytes();
                const std::size_t meta = skipped ? skipped : bytes.find(std::string("\x08\x00\x16\x00", 4));
                reading.disk.write(name_of_slice(static_cast<int>(k)), bytes.substr(meta));
            }
            ASSERT_EQ(reading.code(), "") << reading.line();
            EXPECT_TRUE(reading.warned("W-DCL-001"));
            EXPECT_NE(reading.warnings().find("1.2.840.10008.1.2"), std::string::npos);
            EXPECT_EQ(reading.image->value().image.voxels, expected);
        }
}

TEST(DicomFiles, D06_preamble_of_another_kind) {
    auto files = ct_series(3);
    Reading reading;
    for (std::size_t k = 0; k < 3; ++k) {
        std::string bytes = files[k].bytes();
        bytes.replace(0, 4,
                      k == 0   ? "MZ\x90\x03"
                      : k == 1 ? "\x7F"
                                 "ELF"
                               : "II*\x01");
        reading.disk.write(name_of_slice(static_cast<int>(k)), bytes);
    }
    EXPECT_EQ(reading.code(), "") << reading.line();
}

TEST(DicomFiles, D11_sizes_that_cannot_be) {
    for (const auto& [tag, value] : {std::pair{tags::rows, std::string(4, '\1')},
                                     {tags::rows, std::string(2, '\0')},
                                     {tags::columns, std::string(2, '\0')},
                                     {tags::columns, std::string(4, '\1')}}) {
        auto files = ct_series(3);
        for (auto& file : files) file.set(tag, "US", value);
        const std::string code = Reading(files).code();
        EXPECT_TRUE(code == "E-DCM-002" || code == "E-DCM-010") << code;
    }
    auto files = ct_series(3);
    for (auto& file : files) {
        file.set_short(tags::rows, 65535);
        file.set_short(tags::columns, 65535);
    }
    EXPECT_EQ(Reading(files).code(), "E-DCM-022");
    files.resize(1);
    files[0].set(tags::number_of_frames, "IS", "65535");
    const std::string code = Reading(files).code();
    EXPECT_EQ(code, "E-DCM-007");
}

TEST(DicomFiles, D12_pixels_too_short_or_too_long) {
    const auto with = [](std::ptrdiff_t change) {
        auto files = ct_series(3);
        std::string& pixels = files[1].elements[tags::pixel_data].bytes;
        pixels.resize(static_cast<std::size_t>(static_cast<std::ptrdiff_t>(pixels.size()) + change));
        return files;
    };
    EXPECT_EQ(Reading(with(-2)).code(), "E-DCM-018");
    Reading longer(with(1'000'000));
    EXPECT_EQ(longer.code(), "");
    EXPECT_TRUE(longer.warned("W-DCM-016"));
    // Three pixels of 8 bits: one byte of padding is usual.
    std::vector<SliceFile> files;
    for (int k = 0; k < 3; ++k) {
        files.push_back(ct_slice(k, {0, 0, 1.0 * k}, 3, 1));
        files.back().set_short(tags::bits_allocated, 8);
        files.back().set_short(tags::bits_stored, 8);
        files.back().set_short(tags::high_bit, 7);
        files.back().set(tags::pixel_data, "OW", std::string("\1\2\3\0", 4));
    }
    Reading padded(files);
    EXPECT_EQ(padded.code(), "") << padded.line();
    EXPECT_FALSE(padded.warned("W-DCM-016"));
    auto without = ct_series(3);
    without[1].remove(tags::pixel_data);
    Reading reading(without);
    reading.scan();
    EXPECT_EQ(reading.folder->series.size(), 2u);  // an object without pixels is no image
}

TEST(DicomFiles, D13_numbers_of_frames) {
    for (const char* frames : {"abc", "-1", "0", "1000000000", "1.5"}) {
        auto files = ct_series(3);
        files[1].set(tags::number_of_frames, "IS", frames);
        const std::string code = Reading(files).code();
        EXPECT_TRUE(code == "E-DCM-007" || code == "E-DCM-002") << frames << " " << code;
    }
}

TEST(DicomFiles, D18_bits) {
    const auto with = [](std::uint16_t allocated, std::uint16_t stored, std::uint16_t high,
                         std::uint16_t sign, std::int32_t shift) {
        auto files = ct_series(3);
        for (auto& file : files) {
            file.set_short(tags::bits_allocated, allocated);
            file.set_short(tags::bits_stored, stored);
            file.set_short(tags::high_bit, high);
            file.set_short(tags::pixel_representation, sign);
            std::vector<std::int32_t> values;
            for (int n = 0; n < 20; ++n) values.push_back((sign ? n - 10 : n) * shift);
            file.set(tags::pixel_data, "OW", short_bytes(values, allocated / 8));
        }
        return files;
    };
    EXPECT_EQ(Reading(with(16, 17, 16, 0, 1)).code(), "E-DCM-010");
    EXPECT_EQ(Reading(with(64, 64, 63, 0, 1)).code(), "E-DCM-010");
    EXPECT_EQ(Reading(with(12, 12, 11, 0, 1)).code(), "E-DCM-010");
    for (const std::uint16_t bits : {8, 16, 32})
        for (const std::uint16_t sign : {0, 1}) {
            const auto files = with(bits, bits, static_cast<std::uint16_t>(bits - 1), sign, 1);
            EXPECT_EQ(voxels_of(files)[15], (sign ? 5 : 15) - 1000.0F);
        }
    // Twelve bits at the top of sixteen; and garbage above the stored bits.
    Reading shifted(with(16, 12, 15, 1, 16));
    EXPECT_EQ(shifted.code(), "");
    EXPECT_TRUE(shifted.warned("W-DCM-006"));
    EXPECT_EQ(shifted.image->value().image.voxels[3], -7.0F - 1000.0F);
    auto dirty = with(16, 12, 11, 1, 1);
    for (auto& file : dirty)
        for (std::size_t b = 1; b < 40; b += 2) file.elements[tags::pixel_data].bytes[b] ^= 0x50;
    EXPECT_EQ(voxels_of(dirty)[3], -7.0F - 1000.0F);
}

TEST(DicomFiles, D19_numbers_that_are_none) {
    for (const char* value : {"1,5", "NaN", "1e400", "1.2.3", "0x10", "1 2", "inf", "1\\2"}) {
        auto files = ct_series(3);
        files[1].set(tags::rescale_slope, "DS", value);
        Reading reading(files);
        EXPECT_EQ(reading.code(), "E-DCM-002") << value;
        EXPECT_NE(reading.line().find("(0028,1053)"), std::string::npos) << reading.line();
    }
    auto files = ct_series(3);
    for (auto& file : files) file.set(tags::rescale_slope, "DS", "  +1.50 ");
    EXPECT_EQ(voxels_of(files)[1], 1.5F - 1000.0F);
    files[0].set(tags::instance_number, "IS", "1.0");
    EXPECT_EQ(Reading(files).code(), "E-DCM-002");
}

TEST(DicomFiles, D20_decimal_comma_of_the_locale) {
    auto files = ct_series(3);
    for (auto& file : files) file.set(tags::rescale_slope, "DS", "1.5");
    const auto expected = voxels_of(files);
    const fixtures::CommaLocale locale;
    ASSERT_TRUE(locale.is_there()) << "localedef makes none (package locales)";
    EXPECT_EQ(voxels_of(files), expected);
}

TEST(DicomFiles, colours_are_refused) {
    auto files = ct_series(3);
    for (auto& file : files) file.set(tags::photometric, "CS", "RGB");
    EXPECT_EQ(Reading(files).code(), "E-DCM-010");
}

TEST(DicomFiles, D23_names_of_files) {
    const auto files = ct_series(4);
    Reading reading;
    reading.disk.write("folder/a\nb", files[0].bytes());
    reading.disk.write("folder/$(x)", files[1].bytes());
    reading.disk.write("folder/-rf", files[2].bytes());
    reading.disk.write("folder/%s%n\xFF\xFE", files[3].bytes());
    EXPECT_EQ(reading.code(), "") << reading.line();
}

TEST(DicomFiles, D24_things_that_are_no_files) {
    Reading reading(ct_series(3));
    ASSERT_EQ(::mkfifo(reading.disk.path("folder/pipe").c_str(), 0600), 0);
    std::filesystem::create_symlink("/dev/zero", reading.disk.path("folder/zero"));
    std::filesystem::create_directory_symlink(reading.disk.path("folder"), reading.disk.path("folder/loop"));
    std::filesystem::create_symlink("self", reading.disk.path("folder/self"));
    reading.disk.write("folder/hidden", ct_slice(7, {0, 0, 0}).bytes());
    std::filesystem::permissions(reading.disk.path("folder/hidden"), std::filesystem::perms::none);
    reading.scan();
    EXPECT_TRUE(reading.folder);
    EXPECT_GE(reading.folder->objects.size(), 3u);
}

TEST(DicomFiles, D25_changed_since_it_was_listed) {
    Reading reading(ct_series(3));
    reading.scan();
    reading.disk.write(name_of_slice(1), ct_slice(8, {-10, -20, 33}).bytes());
    const auto image =
        read_dicom_series(*reading.folder, reading.folder->series[0].objects, {}, reading.context);
    ASSERT_FALSE(image.ok());
    EXPECT_EQ(image.error().code, "E-DCM-027");
}

// ---- transfer syntaxes

// The files of a series in another transfer syntax, by GDCM.
std::vector<std::string> converted(const std::vector<SliceFile>& files, gdcm::TransferSyntax::TSType syntax) {
    gdcm::Trace::WarningOff();
    fixtures::Folder disk;
    std::vector<std::string> all;
    for (const SliceFile& file : files) {
        gdcm::ImageReader reader;
        const std::string from = disk.write("from", file.bytes());
        reader.SetFileName(from.c_str());
        EXPECT_TRUE(reader.Read());
        gdcm::ImageChangeTransferSyntax change;
        change.SetTransferSyntax(gdcm::TransferSyntax(syntax));
        change.SetInput(reader.GetImage());
        EXPECT_TRUE(change.Change());
        gdcm::ImageWriter writer;
        writer.SetCheckFileMetaInformation(true);
        const std::string to = disk.path("to");
        writer.SetFileName(to.c_str());
        writer.SetFile(reader.GetFile());
        writer.SetImage(change.GetOutput());
        EXPECT_TRUE(writer.Write());
        all.push_back(content_of(to));
    }
    return all;
}

std::vector<SliceFile> larger_series(std::uint16_t stored, bool is_signed) {
    std::vector<SliceFile> files;
    std::mt19937 random(5);
    for (int k = 0; k < 3; ++k) {
        files.push_back(ct_slice(k, {0, 0, 2.0 * k}, 32, 28));
        SliceFile& file = files.back();
        file.set_short(tags::bits_allocated, stored > 8 ? 16 : 8);
        file.set_short(tags::bits_stored, stored);
        file.set_short(tags::high_bit, static_cast<std::uint16_t>(stored - 1));
        file.set_short(tags::pixel_representation, is_signed);
        std::vector<std::int32_t> values;
        const int span = 1 << stored;
        for (int n = 0; n < 32 * 28; ++n)
            values.push_back(static_cast<int>(random() % 40) + (n * 7) % (span - 40) -
                             (is_signed ? span / 2 : 0));
        file.set(tags::pixel_data, "OW", short_bytes(values, stored > 8 ? 2 : 1));
    }
    return files;
}

constexpr std::pair<gdcm::TransferSyntax::TSType, const char*> lossless[] = {
    {gdcm::TransferSyntax::JPEGLosslessProcess14_1, "JPEG"},
    {gdcm::TransferSyntax::JPEGLSLossless, "JPEG-LS"},
    {gdcm::TransferSyntax::JPEG2000Lossless, "JPEG 2000"},
    {gdcm::TransferSyntax::RLELossless, "RLE"}};

TEST(DicomFiles, compressed_pixels_equal_plain_ones) {
    for (const auto& [syntax, name] : lossless)
        for (const auto& [stored, is_signed] : {std::pair{8, false}, {12, false}, {16, false}, {16, true}}) {
            const auto files = larger_series(static_cast<std::uint16_t>(stored), is_signed);
            const auto expected = voxels_of(files);
            Reading reading;
            const auto compressed = converted(files, syntax);
            for (int k = 0; k < 3; ++k)
                reading.disk.write(name_of_slice(k), compressed[static_cast<std::size_t>(k)]);
            ASSERT_EQ(reading.code(), "") << name << " " << stored << " " << reading.line();
            EXPECT_EQ(reading.image->value().image.voxels, expected) << name << " " << stored;
        }
}

TEST(DicomFiles, D14_uncompressed_syntaxes_give_the_same) {
    const auto expected = voxels_of(ct_series(3));
    auto files = ct_series(3);
    for (auto& file : files) file.syntax = DicomWriter::Syntax::implicit_little;
    EXPECT_EQ(voxels_of(files), expected);
    Reading big;
    const auto swapped = converted(ct_series(3), gdcm::TransferSyntax::ExplicitVRBigEndian);
    for (int k = 0; k < 3; ++k) big.disk.write(name_of_slice(k), swapped[static_cast<std::size_t>(k)]);
    ASSERT_EQ(big.code(), "") << big.line();
    EXPECT_EQ(big.image->value().image.voxels, expected);
}

TEST(DicomFiles, D16_compressed_in_a_way_that_is_not_read) {
    auto files = ct_series(3);
    Reading reading;
    for (std::size_t k = 0; k < 3; ++k) {
        std::string bytes = files[k].bytes();
        const std::string plain = "1.2.840.10008.1.2.1", video = "1.2.840.10008.1.2.4.102";
        const std::size_t at = bytes.find(plain);
        bytes.replace(at - 2, 2 + 20, short_bytes({24}) + video + std::string(1, '\0'));
        reading.disk.write(name_of_slice(static_cast<int>(k)), bytes);
    }
    EXPECT_EQ(reading.code(), "E-DCM-020");
    EXPECT_NE(reading.line().find("1.2.840.10008.1.2.4.102"), std::string::npos) << reading.line();
}

TEST(DicomFiles, D17_damaged_fragments_are_an_error_or_harmless) {
    std::mt19937 random(11);
    int refused = 0, read = 0;
    for (const auto& [syntax, name] : lossless) {
        const auto compressed = converted(larger_series(12, false), syntax);
        const std::size_t fragment = compressed[1].rfind(std::string("\xFE\xFF\x00\xE0", 4)) + 8;
        ASSERT_GT(fragment, 8u);
        for (int round = 0; round < 125; ++round) {
            std::string bytes = compressed[1];
            const std::size_t flips = 1 + random() % 16;
            const std::size_t span = round % 2 ? bytes.size() - fragment - 8 : 64;
            for (std::size_t f = 0; f < flips; ++f)
                bytes[fragment + random() % span] ^= static_cast<char>(1 + random() % 255);
            Reading reading;
            reading.disk.write(name_of_slice(0), compressed[0]);
            reading.disk.write(name_of_slice(1), bytes);
            reading.disk.write(name_of_slice(2), compressed[2]);
            const std::string code = reading.code();
            if (code.empty()) {
                ++read;
                continue;
            }
            ++refused;
            EXPECT_EQ(code, "E-DCM-021") << name;
            EXPECT_NE(reading.line().find("file 2"), std::string::npos) << reading.line();
        }
    }
    EXPECT_GT(refused, 50);
    RecordProperty("refused", refused);
    RecordProperty("read", read);
}

// Where the fragment of the only frame lies in a file.
std::pair<std::size_t, std::size_t> fragment_of(const std::string& bytes) {
    const std::size_t item = bytes.rfind(std::string("\xFE\xFF\x00\xE0", 4));
    std::uint32_t size = 0;
    for (std::size_t n = 4; n-- > 0;) size = size << 8 | static_cast<unsigned char>(bytes[item + 4 + n]);
    return {item + 8, size};
}

// A block of a file that a disk or a network lost is zero. Decoders go on after it, with other pixels.
TEST(DicomFiles, D17_lost_blocks_are_an_error) {
    std::mt19937 random(23);
    for (const auto& [syntax, name] : lossless) {
        if (syntax == gdcm::TransferSyntax::JPEGLSLossless || syntax == gdcm::TransferSyntax::RLELossless)
            continue;  // what they lose is found by their lengths
        const auto compressed = converted(larger_series(12, false), syntax);
        const auto [first, size] = fragment_of(compressed[1]);
        for (int round = 0; round < 50; ++round) {
            std::string bytes = compressed[1];
            const std::size_t length = 150 + random() % (size / 3),
                              from = first + size / 4 + random() % (size / 2 - length / 2);
            for (std::size_t at = from; at < std::min(from + length, first + size - 12); ++at) bytes[at] = 0;
            Reading reading;
            reading.disk.write(name_of_slice(0), compressed[0]);
            reading.disk.write(name_of_slice(1), bytes);
            reading.disk.write(name_of_slice(2), compressed[2]);
            ASSERT_EQ(reading.code(), "E-DCM-021")
                << name << " " << from - first << " " << length << " of " << size;
            EXPECT_NE(reading.line().find("file 2"), std::string::npos) << reading.line();
        }
    }
}

// libjpeg goes on with other pixels. It warns where codes and pixels do not end together: of one flipped bit in five here.
TEST(DicomFiles, D17_what_libjpeg_warns_of_is_an_error) {
    const auto compressed =
        converted(larger_series(12, false), gdcm::TransferSyntax::JPEGLosslessProcess14_1);
    const auto [first, size] = fragment_of(compressed[1]);
    std::mt19937 random(29);
    int told = 0;
    const int rounds = 100;
    for (int round = 0; round < rounds; ++round) {
        std::string bytes = compressed[1];
        bytes[first + size / 4 + random() % (size / 2)] ^= static_cast<char>(1 << random() % 8);
        Reading reading;
        reading.disk.write(name_of_slice(0), compressed[0]);
        reading.disk.write(name_of_slice(1), bytes);
        reading.disk.write(name_of_slice(2), compressed[2]);
        told += reading.code() == "E-DCM-021";
    }
    EXPECT_GE(told, rounds / 8);
    RecordProperty("told", told);
}

TEST(Jpeg2000Stream, lost_stretches_are_found_and_nothing_else) {
    for (const bool is_signed : {false, true}) {
        for (const auto& file :
             converted(larger_series(16, is_signed), gdcm::TransferSyntax::JPEG2000Lossless)) {
            const auto [first, size] = fragment_of(file);
            const std::string stream = file.substr(first, size);
            ASSERT_EQ(zeroed_stretch(stream), std::nullopt);
            EXPECT_EQ(zeroed_stretch(stream + std::string(500, '\0')), std::nullopt) << "padding";
            EXPECT_EQ(zeroed_stretch(stream.substr(1)), std::nullopt);
            for (const std::size_t length : {size_t{200}, size / 3}) {
                std::string lost = stream;
                lost.replace(size / 2, length, length, '\0');
                const auto found = zeroed_stretch(lost);
                ASSERT_TRUE(found.has_value());
                EXPECT_GE(*found, length);
                EXPECT_LE(*found, length + 8);
            }
            for (std::size_t end = 0; end < 200; ++end) zeroed_stretch(stream.substr(0, end));
        }
    }
}

TEST(DicomFiles, D22_flipped_bytes_never_crash) {
    const auto files = ct_series(3);
    const std::string whole = files[1].bytes();
    std::mt19937 random(13);
    for (int round = 0; round < 3000; ++round) {
        std::string bytes = whole;
        for (std::size_t f = 1 + random() % 16; f > 0; --f)
            bytes[128 + random() % (bytes.size() - 128)] ^= static_cast<char>(1u << random() % 8);
        RunContext context;
        DataSet partial;
        const auto set = DataSet::parse(bytes, "flipped", &partial);
        const DicomObject object = describe_object(set.ok() ? set.value() : partial, "flipped", "flipped");
        if (set.ok() && !object.image_error) {
            const auto pixels = find_pixel_data(set.value(), object.format, context);
            if (pixels.ok()) {
                EXPECT_EQ(pixels.value().values.size(), frame_bytes(object.format) * object.format.frames);
            }
        }
    }
}

// ---- many frames in a file

struct EnhancedFrame {
    Vec3 position;
    std::int32_t value;
};

// An enhanced multi-frame CT; `per_frame_orientation` puts the orientation into every frame instead of the
// shared groups.
std::string enhanced(const std::vector<EnhancedFrame>& frames, bool per_frame_orientation,
                     const char* shared_orientation = "1\\0\\0\\0\\1\\0", int uid = 1) {
    DicomWriter writer(DicomWriter::Syntax::explicit_little);
    const auto measures = [&] {
        writer.begin_sequence(tags::pixel_measures_sequence);
        writer.begin_item();
        writer.decimals(tags::slice_thickness, {9});
        writer.decimals(tags::pixel_spacing, {0.5, 2});
        writer.end_item();
        writer.end_sequence();
        writer.begin_sequence(tags::pixel_transformation_sequence);
        writer.begin_item();
        writer.decimals(tags::rescale_intercept, {-1000});
        writer.decimals(tags::rescale_slope, {1});
        writer.end_item();
        writer.end_sequence();
    };
    const auto orientation = [&](const char* value) {
        writer.begin_sequence(tags::plane_orientation_sequence);
        writer.begin_item();
        writer.element(tags::image_orientation, "DS", value);
        writer.end_item();
        writer.end_sequence();
    };
    writer.element(tags::sop_class, "UI", "1.2.840.10008.5.1.4.1.1.2.1");
    writer.element(tags::sop_instance, "UI", "1.2.3.77." + std::to_string(uid));
    writer.element(tags::modality, "CS", "CT");
    writer.element(tags::study_instance, "UI", "1.2.3.1");
    writer.element(tags::series_instance, "UI", "1.2.3.2");
    writer.element(tags::frame_of_reference, "UI", "1.2.3.3");
    writer.unsigned_short(tags::samples_per_pixel, {1});
    writer.element(tags::photometric, "CS", "MONOCHROME2");
    writer.whole_number(tags::number_of_frames, static_cast<std::int64_t>(frames.size()));
    writer.unsigned_short(tags::rows, {2});
    writer.unsigned_short(tags::columns, {3});
    writer.unsigned_short(tags::bits_allocated, {16});
    writer.unsigned_short(tags::bits_stored, {16});
    writer.unsigned_short(tags::high_bit, {15});
    writer.unsigned_short(tags::pixel_representation, {1});
    writer.begin_sequence(tags::shared_groups);
    writer.begin_item();
    if (shared_orientation && !per_frame_orientation) orientation(shared_orientation);
    measures();
    writer.end_item();
    writer.end_sequence();
    writer.begin_sequence(tags::per_frame_groups);
    std::vector<std::int32_t> values;
    for (const EnhancedFrame& frame : frames) {
        writer.begin_item();
        writer.begin_sequence(tags::plane_position_sequence);
        writer.begin_item();
        writer.decimals(tags::image_position, {frame.position.x, frame.position.y, frame.position.z});
        writer.end_item();
        writer.end_sequence();
        if (per_frame_orientation) orientation("1\\0\\0\\0\\1\\0");
        writer.end_item();
        for (int n = 0; n < 6; ++n) values.push_back(frame.value + n);
    }
    writer.end_sequence();
    writer.element(tags::pixel_data, "OW", short_bytes(values));
    return writer.file("1.2.840.10008.5.1.4.1.1.2.1", "1.2.3.77." + std::to_string(uid));
}

TEST(DicomFiles, G25_frames_of_one_file_in_any_order) {
    std::vector<EnhancedFrame> frames;
    for (int k = 0; k < 6; ++k) frames.push_back({{1, 2, 3 + 2.5 * k}, 10 * k});
    std::mt19937 random(2);
    for (int round = 0; round < 10; ++round)
        for (const bool per_frame : {false, true}) {
            Reading reading;
            reading.disk.write("folder/one", enhanced(frames, per_frame));
            ASSERT_EQ(reading.code(), "") << reading.line();
            const LoadedImage& loaded = reading.image->value();
            for (std::uint32_t k = 0; k < 6; ++k)
                EXPECT_EQ(loaded.image.voxels[6 * k + 5], static_cast<float>(10 * k + 5) - 1000.0F);
            EXPECT_EQ(loaded.image.geometry.step[2].z, 2.5);
            std::shuffle(frames.begin(), frames.end(), random);
        }
}

TEST(DicomFiles, G25_a_concatenation_in_three_files) {
    Reading reading;
    for (int part = 0; part < 3; ++part) {
        std::vector<EnhancedFrame> frames;
        for (int k = 0; k < 2; ++k) frames.push_back({{0, 0, 2.0 * (2 * part + k)}, 10 * (2 * part + k)});
        reading.disk.write(name_of_slice(2 - part), enhanced(frames, false, "1\\0\\0\\0\\1\\0", part));
    }
    ASSERT_EQ(reading.code(), "") << reading.line();
    for (std::uint32_t k = 0; k < 6; ++k)
        EXPECT_EQ(reading.image->value().image.voxels[6 * k], static_cast<float>(10 * k) - 1000.0F);
}

TEST(DicomFiles, frames_without_places_are_refused) {
    auto files = ct_series(1);
    files[0].set(tags::number_of_frames, "IS", "2");
    files[0].elements[tags::pixel_data].bytes += files[0].elements[tags::pixel_data].bytes;
    Reading first_alone(files);
    EXPECT_EQ(first_alone.code(), "E-DCM-040");
    EXPECT_NE(first_alone.line().find("--frame-step 5 when each frame lies further towards the head"),
              std::string::npos)
        << first_alone.line();
    files[0].remove(tags::image_position);
    EXPECT_EQ(Reading(files).code(), "E-DCM-007");
}

}  // namespace
}  // namespace anatomesh::dicom_files_test
