#include "anatomesh_io/dicom/read_series.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <numbers>
#include <random>

#include "anatomesh_io/dicom/dicom_fixtures.h"

namespace anatomesh::read_series_test {
namespace {

using fixtures::ct_series;
using fixtures::ct_slice;
using fixtures::numbers;
using fixtures::Reading;
using fixtures::short_bytes;
using fixtures::SliceFile;

void expect_near(Vec3 a, Vec3 b, double tolerance = 1e-9) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.z, b.z, tolerance);
}

float voxel(const LoadedImage& loaded, std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return loaded.image.voxels[loaded.image.geometry.index(i, j, k)];
}

TEST(DicomSeries, values_and_places) {
    Reading reading(ct_series(6));
    ASSERT_EQ(reading.code(), "") << reading.line();
    const LoadedImage& loaded = reading.image->value();
    const ImageGeometry& geometry = loaded.image.geometry;
    EXPECT_EQ(geometry.size, (std::array<std::uint32_t, 3>{5, 4, 6}));
    EXPECT_EQ(reading.warnings(), "");
    for (std::uint32_t k = 0; k < 6; ++k)
        for (std::uint32_t j = 0; j < 4; ++j)
            for (std::uint32_t i = 0; i < 5; ++i)
                EXPECT_EQ(voxel(loaded, i, j, k), static_cast<float>(100 * k + 10 * j + i) - 1000.0F);
    EXPECT_EQ(loaded.facts.voxel_type, "int16");
    EXPECT_EQ(loaded.facts.low, -1000.0F);
}

TEST(DicomSeries, G19_row_spacing_is_the_first_value) {
    Reading reading(ct_series(3));
    ASSERT_EQ(reading.code(), "");
    const ImageGeometry& geometry = reading.image->value().image.geometry;
    expect_near(geometry.origin, {-10, -20, 30});
    expect_near(geometry.step[0], {2, 0, 0});
    expect_near(geometry.step[1], {0, 0.5, 0});
    expect_near(geometry.step[2], {0, 0, 3});
}

TEST(DicomSeries, G01_order_names_and_numbers_do_not_matter) {
    std::mt19937 random(7);
    std::vector<float> expected;
    for (int round = 0; round < 50; ++round) {
        auto files = ct_series(7);
        for (std::size_t k = 0; k < files.size(); ++k) {
            if (round % 3 == 1) files[k].remove(tags::instance_number);
            if (round % 3 == 2) files[k].set(tags::instance_number, "IS", std::to_string(90 - k));
        }
        std::shuffle(files.begin(), files.end(), random);
        Reading reading(files);
        ASSERT_EQ(reading.code(), "") << reading.line();
        EXPECT_EQ(reading.warnings(), "");
        const auto& voxels = reading.image->value().image.voxels;
        if (round == 0) expected = voxels;
        ASSERT_EQ(voxels, expected);
    }
}

TEST(DicomSeries, G02_positions_win_over_numbers) {
    auto files = ct_series(5);
    files[1].set(tags::instance_number, "IS", "4");
    files[3].set(tags::instance_number, "IS", "2");
    Reading reading(files);
    ASSERT_EQ(reading.code(), "");
    EXPECT_TRUE(reading.warned("W-DCM-008"));
    EXPECT_EQ(voxel(reading.image->value(), 0, 0, 1), -900.0F);
}

TEST(DicomSeries, G03_a_missing_slice) {
    auto files = ct_series(9);
    files.erase(files.begin() + 4);
    {
        Reading reading(files);
        EXPECT_EQ(reading.code(), "E-DCM-014");
        EXPECT_NE(reading.line().find("6 mm from 39 to 45"), std::string::npos) << reading.line();
        EXPECT_NE(reading.line().find("--allow-gaps"), std::string::npos);
    }
    Reading reading(files);
    ReadSeriesOptions options;
    options.allow_gaps = true;
    ASSERT_EQ(reading.code(options), "") << reading.line();
    EXPECT_TRUE(reading.warned("W-DCM-014"));
    const LoadedImage& loaded = reading.image->value();
    EXPECT_EQ(loaded.image.geometry.size[2], 9u);
    // What lies above the gap keeps its place; the missing slice is the mean of its neighbours.
    for (std::uint32_t k = 0; k < 9; ++k) {
        expect_near(loaded.image.geometry.position(0, 0, k), {-10, -20, 30 + 3.0 * k}, 1e-6);
        EXPECT_EQ(voxel(loaded, 2, 1, k), static_cast<float>(100 * k + 12) - 1000.0F);
    }
}

TEST(DicomSeries, G04_a_slice_missing_at_the_end) {
    auto files = ct_series(4);
    for (auto& file : files) file.set(tags::images_in_acquisition, "IS", "5");
    Reading reading(files);
    ASSERT_EQ(reading.code(), "");
    EXPECT_TRUE(reading.warned("W-DCM-015"));
}

TEST(DicomSeries, G06_a_file_that_is_there_twice) {
    auto files = ct_series(4);
    files.push_back(files[2]);
    Reading reading(files);
    ASSERT_EQ(reading.code(), "");
    EXPECT_TRUE(reading.warned("W-DCM-003"));
    EXPECT_EQ(reading.image->value().image.geometry.size[2], 4u);
}

TEST(DicomSeries, G07_two_volumes_at_the_same_places) {
    auto files = ct_series(4);
    for (int k = 0; k < 4; ++k) {
        files.push_back(ct_slice(10 + k, {-10, -20, 30 + 3.0 * k}));
        files[static_cast<std::size_t>(k)].set(tags::acquisition_number, "IS", "2");
        files.back().set(tags::acquisition_number, "IS", "11");
    }
    Reading refused(files);
    EXPECT_EQ(refused.code(), "E-DCM-013");
    EXPECT_NE(refused.line().find("AcquisitionNumber 2"), std::string::npos) << refused.line();
    EXPECT_NE(refused.line().find("AcquisitionNumber 11"), std::string::npos) << refused.line();
    for (const std::uint64_t volume : {0, 1}) {
        Reading reading(files);
        ReadSeriesOptions options;
        options.volume = volume;
        ASSERT_EQ(reading.code(options), "") << reading.line();
        for (std::uint32_t k = 0; k < 4; ++k)
            EXPECT_EQ(voxel(reading.image->value(), 0, 0, k),
                      static_cast<float>(100 * (k + 10 * volume)) - 1000.0F);
    }
    Reading none(files);
    ReadSeriesOptions options;
    options.volume = 2;
    EXPECT_EQ(none.code(options), "E-DCM-015");
}

TEST(DicomSeries, G26_ten_time_points) {
    std::vector<SliceFile> files;
    for (int t = 0; t < 10; ++t)
        for (int k = 0; k < 3; ++k) {
            files.push_back(ct_slice(3 * t + k, {0, 0, 2.0 * k}));
            files.back().set(tags::temporal_position, "IS", std::to_string(t + 1));
            files.back().set(tags::instance_number, "IS", "1");
        }
    std::reverse(files.begin(), files.end());
    EXPECT_EQ(Reading(files).code(), "E-DCM-013");
    Reading reading(files);
    ReadSeriesOptions options;
    options.volume = 9;
    ASSERT_EQ(reading.code(options), "") << reading.line();
    EXPECT_EQ(voxel(reading.image->value(), 0, 0, 0), 1700.0F);
}

TEST(DicomSeries, G08_one_uid_two_contents) {
    auto files = ct_series(4);
    files[2].set(tags::sop_instance, "UI", files[1].uid());
    EXPECT_EQ(Reading(files).code(), "E-DCM-024");
}

TEST(DicomSeries, G09_uneven_spacing_is_refused_or_interpolated_at_true_places) {
    std::vector<SliceFile> files;
    const std::vector<double> heights{0, 1.25, 2.5, 5, 10};
    for (std::size_t k = 0; k < heights.size(); ++k)
        files.push_back(ct_slice(static_cast<int>(k), {0, 0, heights[k]}));
    EXPECT_EQ(Reading(files).code(), "E-DCM-014");
    Reading reading(files);
    ReadSeriesOptions options;
    options.allow_gaps = true;
    ASSERT_EQ(reading.code(options), "") << reading.line();
    const LoadedImage& loaded = reading.image->value();
    for (std::size_t k = 0; k < heights.size(); ++k) {
        const auto slice = static_cast<std::uint32_t>(std::lround(heights[k] / 1.25));
        EXPECT_EQ(voxel(loaded, 0, 0, slice), static_cast<float>(100 * k) - 1000.0F);
        EXPECT_NEAR(loaded.image.geometry.position(0, 0, slice).z, heights[k], 1e-6);
    }
}

TEST(DicomSeries, G10_jitter) {
    const auto with = [](double jitter) {
        auto files = ct_series(8);
        files[4].set(tags::image_position, "DS", numbers({-10, -20, 30 + 3 * (4 + jitter)}));
        return files;
    };
    Reading exact(with(1e-5)), slight(with(1e-3));
    EXPECT_EQ(exact.code(), "");
    EXPECT_EQ(exact.warnings(), "");
    EXPECT_EQ(slight.code(), "");
    EXPECT_TRUE(slight.warned("W-DCM-009"));
    EXPECT_EQ(Reading(with(0.05)).code(), "E-DCM-014");
}

TEST(DicomSeries, G11_thickness_and_stated_spacing_do_not_place_slices) {
    for (const char* stated : {"6.5", "-3", "0"}) {
        auto files = ct_series(4);
        for (auto& file : files) {
            file.set(tags::spacing_between_slices, "DS", stated);
            file.set(tags::slice_thickness, "DS", "7");
        }
        Reading reading(files);
        ASSERT_EQ(reading.code(), "");
        EXPECT_TRUE(reading.warned("W-DCM-010")) << stated;
        expect_near(reading.image->value().image.geometry.step[2], {0, 0, 3});
    }
}

TEST(DicomSeries, G12_gantry_tilt_shears_the_volume) {
    for (const double degrees : {-25.0, -10.0, -1.0, 5.0, 25.0})
        for (const bool tagged : {false, true}) {
            const double angle = degrees * std::numbers::pi / 180;
            std::vector<SliceFile> files;
            const Vec3 column{0, std::cos(angle), std::sin(angle)};
            for (int k = 0; k < 12; ++k) {
                files.push_back(ct_slice(k, {-10, -20, 30 + 3.0 * k}, 5, 4, {1, 0, 0}, column));
                if (tagged) files.back().set(tags::gantry_tilt, "DS", numbers({degrees}));
            }
            Reading reading(files);
            ASSERT_EQ(reading.code(), "") << reading.line();
            const ImageGeometry& geometry = reading.image->value().image.geometry;
            const Vec3 corner = Vec3{-10, -20, 30 + 33} + 8 * Vec3{1, 0, 0} + 1.5 * column;
            expect_near(geometry.position(4, 3, 11), corner, 1e-6);
        }
}

TEST(DicomSeries, G13_a_tilt_that_is_not_there) {
    auto files = ct_series(4);
    for (auto& file : files) file.set(tags::gantry_tilt, "DS", "12");
    Reading reading(files);
    ASSERT_EQ(reading.code(), "");
    EXPECT_TRUE(reading.warned("W-DCM-011"));
}

TEST(DicomSeries, G14_one_slice_with_another_orientation_is_named) {
    auto files = ct_series(5);
    files.push_back(ct_slice(9, {-10, -20, 45}, 5, 4, {0, 1, 0}, {0, 0, -1}));
    Reading reading(files);
    EXPECT_EQ(reading.code(), "E-DCM-012");
    EXPECT_NE(reading.line().find("folder file 6"), std::string::npos) << reading.line();
}

TEST(DicomSeries, G15_three_plane_localizer) {
    std::vector<SliceFile> files;
    const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int a = 0; a < 3; ++a)
        for (int k = 0; k < 3; ++k)
            files.push_back(ct_slice(3 * a + k, 4.0 * k * cross(axes[a], axes[(a + 1) % 3]), 5, 4, axes[a],
                                     axes[(a + 1) % 3]));
    Reading refused(files);
    EXPECT_EQ(refused.code(), "E-DCM-012");
    EXPECT_NE(refused.line().find("2: 3 slices"), std::string::npos) << refused.line();
    Reading reading(files);
    ReadSeriesOptions options;
    options.volume = 1;
    EXPECT_EQ(reading.code(options), "") << reading.line();
}

TEST(DicomSeries, G16_orientation_that_is_not_orthonormal) {
    const auto with = [](double error, bool scale) {
        auto files = ct_series(3);
        for (auto& file : files)
            file.set(tags::image_orientation, "DS",
                     scale ? numbers({1 + error, 0, 0, 0, 1, 0}) : numbers({1, 0, 0, error, 1, 0}));
        return files;
    };
    for (const bool scale : {false, true}) {
        Reading exact(with(1e-5, scale)), slight(with(1e-3, scale)), wrong(with(0.1, scale));
        EXPECT_EQ(exact.code(), "");
        EXPECT_EQ(exact.warnings(), "");
        EXPECT_EQ(slight.code(), "");
        EXPECT_TRUE(slight.warned("W-DCM-005"));
        expect_near(slight.image->value().image.geometry.step[1], {0, 0.5, 0});
        EXPECT_EQ(wrong.code(), "E-DCM-005");
    }
    auto files = ct_series(3);
    files[1].set(tags::image_orientation, "DS", numbers({0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(Reading(files).code(), "E-DCM-005");
}

TEST(DicomSeries, G17_no_place_in_space) {
    for (const DicomTag tag : {tags::image_position, tags::image_orientation}) {
        auto files = ct_series(3);
        files[1].remove(tag);
        Reading reading(files);
        EXPECT_EQ(reading.code(), "E-DCM-004");
        EXPECT_NE(reading.line().find("file 2"), std::string::npos) << reading.line();
    }
}

TEST(DicomSeries, G18_pixel_spacing_that_is_none) {
    for (const char* spacing : {"", "0\\1", "-1\\1", "1\\0", "1e9\\1"}) {
        auto files = ct_series(3);
        for (auto& file : files) file.set(tags::pixel_spacing, "DS", spacing);
        EXPECT_EQ(Reading(files).code(), "E-DCM-006") << spacing;
    }
    auto files = ct_series(3);
    for (auto& file : files) {
        file.remove(tags::pixel_spacing);
        file.set(tags::imager_pixel_spacing, "DS", "1\\1");
    }
    Reading reading(files);
    EXPECT_EQ(reading.code(), "E-DCM-006");
    EXPECT_NE(reading.line().find("ImagerPixelSpacing"), std::string::npos);
}

// A region of an ultrasound image: its kind, unit (3: cm) and size of a pixel.
struct Region {
    std::uint16_t format = 1, unit = 3;
    double x = 0.01, y = 0.02;
};
std::string double_bytes(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    std::string bytes;
    for (int b = 0; b < 8; ++b) bytes += static_cast<char>(bits >> (8 * b));
    return bytes;
}
std::string regions_bytes(const std::vector<Region>& regions) {
    DicomWriter writer(DicomWriter::Syntax::explicit_little);
    for (const Region& region : regions) {
        writer.begin_item();
        writer.unsigned_short(tags::region_spatial_format, {region.format});
        writer.unsigned_short(tags::region_units_x, {region.unit});
        writer.unsigned_short(tags::region_units_y, {region.unit});
        writer.element(tags::region_delta_x, "FD", double_bytes(region.x));
        writer.element(tags::region_delta_y, "FD", double_bytes(region.y));
        writer.end_item();
    }
    return writer.bytes();
}

TEST(DicomSeries, G20_ultrasound_regions) {
    const auto series = [](const std::vector<Region>& regions) {
        auto files = ct_series(4);
        for (auto& file : files) {
            file.remove(tags::pixel_spacing);
            file.set(tags::modality, "CS", "US");
            file.set(tags::ultrasound_regions, "SQ", regions_bytes(regions));
        }
        return files;
    };
    const auto spacing_of = [](Reading& reading, std::optional<std::uint32_t> region) -> std::string {
        DicomFolderOptions options;
        options.frames.ultrasound_region = region;
        const auto folder = read_dicom_folder(reading.disk.path("folder"), options, reading.context);
        const auto image =
            read_dicom_series(folder.value(), folder.value().series[0].objects, {}, reading.context);
        if (!image.ok()) return image.error().code;
        const auto& step = image.value().image.geometry.step;
        return fmt::format("{:.6g} {:.6g}", length(step[0]), length(step[1]));
    };
    const Region tissue, doppler{3, 4, 0.001, 2}, other{1, 3, 0.03, 0.03}, pixels{1, 0, 1, 1},
        upwards{1, 3, 0.01, -0.02};
    struct Case {
        std::vector<Region> regions;
        std::optional<std::uint32_t> chosen;
        std::string found;
    };
    for (const auto& [regions, chosen, found] : {Case{{tissue}, {}, "0.1 0.2"},  // cm to mm
                                                 {{upwards}, {}, "0.1 0.2"},
                                                 {{doppler, tissue}, {}, "0.1 0.2"},
                                                 {{tissue, tissue}, {}, "0.1 0.2"},
                                                 {{tissue, other}, {}, "E-DCM-034"},
                                                 {{tissue, other}, 1, "0.3 0.3"},
                                                 {{tissue, doppler}, 1, "E-DCM-034"},
                                                 {{tissue}, 7, "E-DCM-034"},
                                                 {{pixels}, {}, "E-DCM-006"},
                                                 {{doppler}, {}, "E-DCM-006"},
                                                 {{}, {}, "E-DCM-006"}}) {
        Reading reading(series(regions));
        EXPECT_EQ(spacing_of(reading, chosen), found);
    }
    // PixelSpacing counts, and is compared.
    auto files = series({tissue});
    for (auto& file : files) file.set(tags::pixel_spacing, "DS", "0.5\\0.5");
    Reading reading(files);
    EXPECT_EQ(reading.code(), "");
    EXPECT_TRUE(reading.warned("W-DCM-021"));
}

TEST(DicomSeries, G32_twenty_thousand_slices) {
    // Headers are kept, pixels are not: what a folder takes does not grow with its images.
    constexpr int count = 20'000;
    Reading reading;
    for (int k = 0; k < count; ++k)
        reading.disk.write("folder/" + std::to_string(k), fixtures::ct_slice(k, {-10, -20, 0.5 * k}).bytes());
    reading.scan();
    ASSERT_EQ(reading.folder->series.size(), 1u);
    EXPECT_EQ(reading.folder->series[0].objects.size(), std::size_t{count});
    const auto image =
        read_dicom_series(*reading.folder, reading.folder->series[0].objects, {}, reading.context);
    ASSERT_TRUE(image.ok()) << to_line(image.error());
    EXPECT_EQ(image.value().image.geometry.size[2], std::uint32_t{count});
    EXPECT_NEAR(image.value().image.geometry.position(0, 0, count - 1).z, 0.5 * (count - 1), 1e-6);
}

TEST(DicomSeries, G21_frames_of_reference) {
    auto files = ct_series(4);
    files[2].set(tags::frame_of_reference, "UI", "9.9.9");
    EXPECT_EQ(Reading(files).code(), "E-DCM-023");
    files[2].remove(tags::frame_of_reference);
    Reading reading(files);
    EXPECT_EQ(reading.code(), "");
    EXPECT_TRUE(reading.warned("W-DCM-004"));
}

TEST(DicomSeries, G22_sizes_or_spacings_that_differ) {
    auto files = ct_series(4);
    files[2] = ct_slice(2, {-10, -20, 36}, 4, 4);
    Reading sizes(files);
    EXPECT_EQ(sizes.code(), "E-DCM-011");
    EXPECT_NE(sizes.line().find("file 3"), std::string::npos) << sizes.line();
    files = ct_series(4);
    files[3].set(tags::pixel_spacing, "DS", "0.6\\2");
    EXPECT_EQ(Reading(files).code(), "E-DCM-011");
}

TEST(DicomSeries, G23_series_studies_and_patients_are_never_merged) {
    auto files = ct_series(6);
    files[1].set(tags::series_instance, "UI", "1.2.3.99");
    files[2].set(tags::study_instance, "UI", "1.2.3.98");
    files[3].set(tags::patient_id, "LO", "another");
    Reading reading(files);
    reading.scan();
    EXPECT_EQ(reading.folder->series.size(), 4u);
}

TEST(DicomSeries, G27_all_orientations_place_voxels_alike) {
    // The value tells the position: every orientation must put the same value at the same place.
    std::vector<std::pair<Vec3, Vec3>> axes;
    const Vec3 units[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (const Vec3 a : units)
        for (const Vec3 b : units)
            if (dot(a, b) == 0) axes.emplace_back(a, b);
    ASSERT_EQ(axes.size(), 24u);
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (int n = 0; n < 10; ++n) {
        const Vec3 a = normalized({normal(random), normal(random), normal(random)});
        const Vec3 r{normal(random), normal(random), normal(random)};
        axes.emplace_back(a, normalized(cross(a, r)));
    }
    for (const auto& [row, column] : axes)
        for (const int direction : {1, -1}) {
            const Vec3 along = cross(row, column);
            const auto value = [](Vec3 p) {
                return static_cast<int>(std::lround(1000 + 7 * p.x + 5 * p.y + 3 * p.z));
            };
            std::vector<SliceFile> files;
            for (int k = 0; k < 5; ++k) {
                const Vec3 origin = 2.5 * direction * k * along;
                files.push_back(ct_slice(k, origin, 5, 4, row, column));
                std::vector<std::int32_t> values;
                for (int j = 0; j < 4; ++j)
                    for (int i = 0; i < 5; ++i)
                        values.push_back(value(origin + 2.0 * i * row + 0.5 * j * column));
                files.back().set(tags::pixel_data, "OW", short_bytes(values));
                files.back().set(tags::rescale_intercept, "DS", "0");
            }
            Reading reading(files);
            ASSERT_EQ(reading.code(), "") << reading.line();
            const LoadedImage& loaded = reading.image->value();
            const ImageGeometry& geometry = loaded.image.geometry;
            EXPECT_GT(dot(cross(geometry.step[0], geometry.step[1]), geometry.step[2]), 0);  // G28
            for (std::uint32_t k = 0; k < 5; ++k)
                for (std::uint32_t j = 0; j < 4; ++j)
                    for (std::uint32_t i = 0; i < 5; ++i)
                        EXPECT_NEAR(voxel(loaded, i, j, k), value(geometry.position(i, j, k)), 1);
        }
}

TEST(DicomSeries, G28_positions_against_the_normal) {
    Reading reading(ct_series(4, -3));
    ASSERT_EQ(reading.code(), "");
    const LoadedImage& loaded = reading.image->value();
    expect_near(loaded.image.geometry.origin, {-10, -20, 21});
    expect_near(loaded.image.geometry.step[2], {0, 0, 3});
    EXPECT_EQ(voxel(loaded, 0, 0, 0), -700.0F);
}

TEST(DicomSeries, G29_one_slice_and_two) {
    Reading one(ct_series(1)), two(ct_series(2));
    EXPECT_EQ(one.code(), "");
    EXPECT_TRUE(one.warned("W-DCM-013"));
    expect_near(one.image->value().image.geometry.step[2], {0, 0, 5});
    EXPECT_EQ(two.code(), "");
    auto files = ct_series(1);
    files[0].remove(tags::slice_thickness);
    EXPECT_EQ(Reading(files).code(), "E-DCM-016");
}

TEST(DicomSeries, G30_unusual_extents) {
    Reading large(ct_series(30, 90)), usual(ct_series(4)), elongated(ct_series(4, 900));
    EXPECT_EQ(large.code(), "");
    EXPECT_TRUE(large.warned("W-DCM-012"));
    EXPECT_EQ(usual.code(), "");
    EXPECT_FALSE(usual.warned("W-DCM-012"));
    EXPECT_EQ(elongated.code(), "E-IMG-018");  // pixels are 0.5 mm wide
}

TEST(DicomSeries, G35_mosaics_and_localizers) {
    auto files = ct_series(3);
    for (auto& file : files) file.set(tags::image_type, "CS", "ORIGINAL\\PRIMARY\\M\\MOSAIC");
    EXPECT_EQ(Reading(files).code(), "E-DCM-026");
    files = ct_series(3);
    files[0].set(tags::image_type, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
    Reading reading(files);
    EXPECT_EQ(reading.code(), "");
    EXPECT_TRUE(reading.warned("W-DCM-017"));
}

TEST(DicomSeries, G36_extreme_coordinates) {
    for (const char* position : {"0\\0\\1e30", "0\\0\\1.7e308", "0\\1.1e7\\0"}) {
        auto files = ct_series(3);
        files[1].set(tags::image_position, "DS", position);
        EXPECT_EQ(Reading(files).code(), "E-DCM-008") << position;
    }
    auto files = ct_series(3);
    files[0].set(tags::image_position, "DS", "-10\\-20\\3e1");
    files[1].set(tags::image_position, "DS", "-1.0e1\\-20.\\33");
    EXPECT_EQ(Reading(files).code(), "");
}

TEST(DicomSeries, slopes_of_every_slice_count) {
    auto files = ct_series(3);
    files[1].set(tags::rescale_slope, "DS", "0.5");
    files[2].set(tags::rescale_intercept, "DS", "10");
    Reading reading(files);
    ASSERT_EQ(reading.code(), "");
    const LoadedImage& loaded = reading.image->value();
    EXPECT_EQ(voxel(loaded, 1, 2, 0), 21.0F - 1000.0F);
    EXPECT_EQ(voxel(loaded, 1, 2, 1), 60.5F - 1000.0F);
    EXPECT_EQ(voxel(loaded, 1, 2, 2), 231.0F);
    files[1].set(tags::rescale_slope, "DS", "0");
    EXPECT_EQ(Reading(files).code(), "E-DCM-002");
}

// Hidden to all but --keep-patient-ids: nothing that was planted in texts shows in messages.
TEST(DicomSeries, O05_no_name_in_messages) {
    auto files = ct_series(5);
    files.erase(files.begin() + 2);
    for (auto& file : files) {
        file.set(tags::series_description, "LO", "Planted^Name");
        file.set(tags::study_date, "DA", "19991231");
    }
    Reading reading(files);
    EXPECT_EQ(reading.code(), "E-DCM-014");
    EXPECT_EQ(reading.line().find("lanted"), std::string::npos);
    EXPECT_EQ(reading.warnings().find("lanted"), std::string::npos);
}

}  // namespace
}  // namespace anatomesh::read_series_test
