#include "anatomesh_io/dicom/write_objects.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <random>

#include "anatomesh_io/contour/read_contours.h"
#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/dicom_fixtures.h"
#include "anatomesh_io/dicom/lab_color.h"
#include "anatomesh_io/dicom/segmentation.h"
#include "anatomesh_io/dicom/sha256.h"

namespace anatomesh::write_objects_test {
namespace {

namespace fs = std::filesystem;
using fixtures::Folder;

std::string code_of(const Result<LoadedSegmentation>& result) {
    return result.ok() ? "" : result.error().code;
}

bool warned(const RunContext& context, const std::string& code) {
    return std::any_of(context.warnings.begin(), context.warnings.end(),
                       [&](const Warning& warning) { return warning.code == code; });
}

// Structures of random voxels; `overlap`: regions of two structures too. Some slices empty.
VoxelModel random_model(std::array<std::uint32_t, 3> size, std::uint32_t structures, bool overlap,
                        unsigned seed) {
    std::mt19937 random(seed);
    VoxelModel model;
    const double angle = seed % 3 == 0 ? 0.0 : 0.3 * seed;
    const Vec3 row{std::cos(angle), std::sin(angle), 0}, column{-std::sin(angle), std::cos(angle), 0};
    model.geometry = {size, {-30, 12.5, 7.25}, {0.75 * row, 1.25 * column, Vec3{0, 0, 2.5}}};
    model.members.push_back({});
    for (std::uint32_t s = 0; s < structures; ++s) {
        model.structures.push_back(
            {static_cast<std::int32_t>(s + 1), "part " + std::to_string(s), {200, 80, 60}});
        model.members.push_back({s});
    }
    if (overlap) model.members.push_back({0, 1});
    for (std::size_t n = 0; n < model.geometry.voxel_count(); ++n) {
        const std::size_t slice = n / (std::size_t{size[0]} * size[1]);
        const bool is_empty = slice % 4 == 2;
        model.regions.push_back(is_empty ? 0 : static_cast<std::uint16_t>(random() % model.members.size()));
    }
    return model;
}

// Whether a voxel of the model is in the structure, by what was read.
bool read_inside(const LoadedSegmentation& loaded, std::int32_t number, std::size_t voxel) {
    for (const LabelMap& layer : loaded.layers) {
        const std::uint16_t label = layer.voxels[voxel];
        if (label > 0 && layer.structures[label - 1u].number == number) return true;
    }
    return false;
}

TEST(DicomSegmentation, L01_L02_what_was_written_reads_back) {
    unsigned seed = 0;
    for (const std::array<std::uint32_t, 3> size :
         {std::array<std::uint32_t, 3>{7, 5, 9}, {8, 8, 5}, {13, 3, 6}, {1, 1, 2}, {33, 17, 12}})
        for (const bool overlap : {false, true}) {
            const VoxelModel model = random_model(size, 3, overlap, ++seed);
            const std::string file = format_segmentation(model, {}).value();
            RunContext context;
            const auto loaded = read_dicom_segmentation(file, "model.dcm", {}, context);
            if (!loaded.ok()) {
                EXPECT_EQ(loaded.error().code, "E-SEG-005") << to_line(loaded.error());
                continue;
            }
            const ImageGeometry& geometry = loaded.value().layers[0].geometry;
            // Empty slices at the ends are not stored.
            const double offset = dot(geometry.origin - model.geometry.origin, {0, 0, 1}) / 2.5;
            const auto first = static_cast<std::uint32_t>(std::lround(offset));
            EXPECT_NEAR(length(geometry.position(1, 2, 1) - model.geometry.position(1, 2, first + 1)), 0,
                        1e-6);
            for (std::uint32_t k = 0; k < geometry.size[2]; ++k)
                for (std::uint32_t j = 0; j < size[1]; ++j)
                    for (std::uint32_t i = 0; i < size[0]; ++i) {
                        const auto& members =
                            model.members[model.regions[model.geometry.index(i, j, k + first)]];
                        for (std::uint32_t s = 0; s < 3; ++s)
                            ASSERT_EQ(read_inside(loaded.value(), static_cast<std::int32_t>(s + 1),
                                                  geometry.index(i, j, k)),
                                      std::find(members.begin(), members.end(), s) != members.end());
                    }
            EXPECT_EQ(warned(context, "W-SEG-005"), loaded.value().layers.size() > 1);
            EXPECT_EQ(format_segmentation(model, {}).value(), file);
        }
}

TEST(DicomSegmentation, L04_overlapping_segments_are_layers) {
    const VoxelModel model = random_model({16, 16, 4}, 2, true, 3);
    RunContext context;
    const auto loaded =
        read_dicom_segmentation(format_segmentation(model, {}).value(), "model.dcm", {}, context);
    ASSERT_TRUE(loaded.ok());
    EXPECT_EQ(loaded.value().layers.size(), 2u);
    EXPECT_TRUE(warned(context, "W-SEG-005"));
    EXPECT_TRUE(warned(context, "W-SEG-004"));  // L-10: slice 2 is not stored
}

TEST(DicomSegmentation, L03_pixels_that_are_missing) {
    const std::string file = format_segmentation(random_model({16, 16, 4}, 2, false, 3), {}).value();
    RunContext context;
    // The last element is the pixels: shortened, with its length.
    const std::size_t at = file.rfind(std::string("\xE0\x7F\x10\x00OB\0\0", 8));
    ASSERT_NE(at, std::string::npos);
    std::string shorter = file.substr(0, at + 12) + file.substr(at + 12, 64);
    shorter.replace(at + 8, 4, std::string("\x40\0\0\0", 4));
    EXPECT_EQ(code_of(read_dicom_segmentation(shorter, "model.dcm", {}, context)), "E-DCM-018");
}

TEST(DicomSegmentation, L14_all_zeros) {
    VoxelModel model = random_model({8, 8, 4}, 1, false, 1);
    std::string file = format_segmentation(model, {}).value();
    const std::size_t at = file.rfind(std::string("\xE0\x7F\x10\x00OB\0\0", 8)) + 12;
    std::fill(file.begin() + static_cast<std::ptrdiff_t>(at), file.end(), '\0');
    RunContext context;
    EXPECT_EQ(code_of(read_dicom_segmentation(file, "model.dcm", {}, context)), "E-SEG-005");
    EXPECT_TRUE(warned(context, "W-SEG-002"));
}

TEST(DicomSegmentation, flipped_bytes_never_crash) {
    const std::string whole = format_segmentation(random_model({9, 7, 5}, 2, true, 2), {}).value();
    std::mt19937 random(1);
    for (int round = 0; round < 2000; ++round) {
        std::string bytes = whole;
        for (std::size_t f = 1 + random() % 8; f > 0; --f)
            bytes[132 + random() % (bytes.size() - 132)] ^= static_cast<char>(1u << random() % 8);
        RunContext context;
        const auto loaded = read_dicom_segmentation(bytes, "flipped", {}, context);
        if (loaded.ok()) {
            EXPECT_FALSE(loaded.value().layers.empty());
        }
    }
}

TEST(DicomSegmentation, colours_survive) {
    for (int r = 0; r < 256; r += 51)
        for (int g = 0; g < 256; g += 51)
            for (int b = 0; b < 256; b += 51) {
                const std::array<std::uint8_t, 3> color{
                    static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b)};
                const auto lab = lab_of_color(color);
                const std::string bytes = fixtures::short_bytes({lab[0], lab[1], lab[2]});
                EXPECT_EQ(color_of_lab(bytes, false), color);
            }
}

// ---- real segmentations beside their label maps

fs::path data_folder() {
    if (const char* set = std::getenv("ANATOMESH_DATA")) return set;
    return fs::path(ANATOMESH_SOURCE_DIR).parent_path() / "shared/data";
}

Result<LoadedSegmentation> read_real(const fs::path& path, RunContext& context) {
    const auto file = read_input_file(path.string(), {});
    if (!file.ok()) return file.error();
    const auto bytes = file.value().bytes();
    return read_dicom_segmentation({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "real", {},
                                   context);
}

TEST(DicomSegmentation, real_ones_equal_their_label_maps) {
    const fs::path folder = data_folder() / "dicom_seg";
    if (!fs::exists(folder)) GTEST_SKIP() << "no dicom_seg (set ANATOMESH_DATA)";
    for (const auto& [seg, nrrd] : {std::pair{"23x38x3/seg/label.seg", "23x38x3/nrrd/label.nrrd"},
                                    {"24x38x3/seg/label.seg", "24x38x3/nrrd/label.nrrd"},
                                    {"liver.dcm", "liver_seg.nrrd"},
                                    {"sparse-labelmap-noppv.dcm", "sparse_labelmap_noppv_seg.nrrd"},
                                    {"sparse-labelmap-ppv5.dcm", "sparse_labelmap_ppv5_seg.nrrd"}}) {
        RunContext context;
        const auto loaded = read_real(folder / seg, context);
        ASSERT_TRUE(loaded.ok()) << seg << " " << to_line(loaded.error());
        const auto truth = read_image((folder / nrrd).string(), {}, context);
        ASSERT_TRUE(truth.ok()) << nrrd << " " << to_line(truth.error());
        const ImageGeometry& own = loaded.value().layers[0].geometry;
        const ImageGeometry& other = truth.value().image.geometry;
        std::size_t inside = 0, inside_truth = 0, equal = 0;
        // 5 marks planes that are not stored.
        for (const float value : truth.value().image.voxels) inside_truth += value > 0 && value != 5;
        for (std::uint32_t k = 0; k < own.size[2]; ++k)
            for (std::uint32_t j = 0; j < own.size[1]; ++j)
                for (std::uint32_t i = 0; i < own.size[0]; ++i) {
                    if (loaded.value().layers[0].voxels[own.index(i, j, k)] == 0) continue;
                    ++inside;
                    const Vec3 p = own.position(i, j, k) - other.origin;
                    std::uint32_t at[3];
                    bool is_in = true;
                    for (int a = 0; a < 3; ++a) {
                        const double x = std::round(dot(p, other.step[a]) / squared_length(other.step[a]));
                        is_in = is_in && x >= 0 && x < other.size[a];
                        at[a] = is_in ? static_cast<std::uint32_t>(x) : 0;
                    }
                    equal += is_in && truth.value().image.voxels[other.index(at[0], at[1], at[2])] > 0;
                }
        EXPECT_GT(inside, 0u) << seg;
        EXPECT_EQ(inside, inside_truth) << seg;
        EXPECT_EQ(equal, inside) << seg;
    }
}

TEST(DicomSegmentation, L05_real_fractional_and_overlapping_ones) {
    const fs::path folder = data_folder();
    if (!fs::exists(folder / "breast_mr_seg")) GTEST_SKIP() << "no breast_mr_seg (set ANATOMESH_DATA)";
    RunContext context;
    const auto breast = read_real(folder / "breast_mr_seg/UCSF-BR-06/mask/1-1.dcm", context);
    ASSERT_TRUE(breast.ok()) << to_line(breast.error());
    EXPECT_EQ(breast.value().type, "FRACTIONAL");
    EXPECT_TRUE(warned(context, "W-SEG-001"));
    const auto overlaps = read_real(folder / "dicom_seg/partial_overlaps.dcm", context);
    ASSERT_TRUE(overlaps.ok()) << to_line(overlaps.error());
    EXPECT_EQ(overlaps.value().layers.size(), 3u);  // as many label maps as its source was written in
}

// ---- RT Structure Sets

ContourSet ring_set(int slices, std::uint32_t points, std::uint32_t structures) {
    ContourSet set;
    for (std::uint32_t s = 0; s < structures; ++s)
        set.structures.push_back(
            {static_cast<std::int32_t>(5 + 2 * s), s ? "Leber \xC3\xA4" : "liver", {1, 200, 30}});
    for (int k = 0; k < slices; ++k) {
        Slice slice{
            {{0, 0, 2.5 * k}, {0, 0, 1}}, static_cast<std::uint32_t>(set.contours.size()), structures, ""};
        for (std::uint32_t s = 0; s < structures; ++s) {
            set.contours.push_back(
                {s, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(set.points.size()), points});
            for (std::uint32_t p = 0; p < points; ++p) {
                const double a = 2 * std::numbers::pi * p / points;
                set.points.push_back({100.0 * s + 31.7 * std::cos(a), -71.3 + 31.7 * std::sin(a), 2.5 * k});
            }
        }
        set.slices.push_back(slice);
    }
    return set;
}

TEST(DicomRtstruct, RS27_what_was_written_reads_back_also_beyond_64_KiB) {
    for (const std::uint32_t points : {3u, 50u, 9000u}) {
        const ContourSet set = ring_set(3, points, 2);
        Folder disk;
        const std::string file = format_rtstruct(set, {});
        EXPECT_EQ(file, format_rtstruct(set, {}));
        RunContext context;
        const auto raw = read_contours(disk.write("rs.dcm", file), {}, context);
        ASSERT_TRUE(raw.ok()) << to_line(raw.error());
        EXPECT_TRUE(context.warnings.empty()) << to_line(context.warnings[0]);
        ASSERT_EQ(raw.value().structures.size(), 2u);
        EXPECT_EQ(raw.value().structures[1].name, "Leber \xC3\xA4");
        EXPECT_EQ(raw.value().structures[1].number, 7);
        EXPECT_EQ(raw.value().structures[0].color, set.structures[0].color);
        ASSERT_EQ(raw.value().points.size(), set.points.size());
        // The file holds structure after structure, the set slice after slice.
        std::size_t at = 0;
        for (std::uint32_t s = 0; s < 2; ++s)
            for (const Contour& contour : set.contours) {
                if (contour.structure != s) continue;
                for (const Vec3& point : set.points_of(contour)) {
                    EXPECT_NEAR(length(raw.value().points[at] - point), 0, 1e-9);
                    ++at;
                }
            }
    }
}

TEST(DicomRtstruct, planes_refer_to_their_images) {
    const auto slices = fixtures::ct_series(4, 2.5);
    fixtures::Reading reading(slices);
    reading.scan();
    const auto source = dicom_source(*reading.folder, reading.folder->series[0].objects, true);
    ASSERT_TRUE(source.ok());
    ContourSet set = ring_set(3, 20, 1);
    for (Slice& slice : set.slices) slice.plane.origin.z += 30;
    for (Vec3& point : set.points) point.z += 30;
    set.slices[2].plane.origin.z += 1;  // between two images
    const std::string file = format_rtstruct(set, source.value());
    const auto parsed = DataSet::parse(file, "rs");
    ASSERT_TRUE(parsed.ok()) << to_line(parsed.error());
    const DicomItem roi = *parsed.value().root().item(tags::roi_contour_sequence);
    const auto contours = roi.items(tags::contour_sequence);
    ASSERT_EQ(contours.size(), 3u);
    EXPECT_EQ(contours[1].item(tags::contour_image_sequence)->text(tags::referenced_sop_instance),
              "1.2.3.4.2");
    EXPECT_FALSE(contours[2].item(tags::contour_image_sequence));
    EXPECT_EQ(parsed.value().root().text(tags::study_instance), "1.2.3.1");
    EXPECT_EQ(parsed.value().root().text(tags::patient_name), "Planted^Name");
}

TEST(DicomObjects, O04_no_value_is_longer_than_its_length_can_say) {
    for (const std::uint64_t bytes : {std::uint64_t{0}, std::uint64_t{0xFFFFFFFD}, std::uint64_t{0xFFFFFFFE}})
        EXPECT_TRUE(check_value_length("the surface", bytes).ok()) << bytes;
    for (const std::uint64_t bytes : {std::uint64_t{0xFFFFFFFF}, std::uint64_t{1} << 32, ~std::uint64_t{0}}) {
        const Status status = check_value_length("the surface", bytes);
        ASSERT_FALSE(status.ok()) << bytes;
        EXPECT_EQ(status.error().kind, ErrorKind::limit);
    }
    // Refused before a byte of it is read: nothing is mapped behind this address space.
    const std::size_t size = std::size_t{1} << 32;
    void* reserved = ::mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    ASSERT_NE(reserved, MAP_FAILED);
    for (const SurfaceObject kind : {SurfaceObject::stl, SurfaceObject::obj}) {
        const auto made = format_encapsulated(kind, {static_cast<const char*>(reserved), size}, "model", {});
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, "E-DCM-045");
    }
    ::munmap(reserved, size);
}

TEST(DicomObjects, O05_nothing_of_the_patient_unless_asked) {
    auto slices = fixtures::ct_series(4);
    const std::string planted[] = {"Planted^Name",   "PLANTED-ID", "19991231",   "19421224",   "ACC-77",
                                   "Doctor^Planted", "1.9.8.77.1", "1.9.8.77.2", "1.9.8.77.3", "1.2.3.4."};
    for (auto& slice : slices) {
        slice.set(tags::study_instance, "UI", "1.9.8.77.1");
        slice.set(tags::series_instance, "UI", "1.9.8.77.2");
        slice.set(tags::frame_of_reference, "UI", "1.9.8.77.3");
        slice.set(tags::study_date, "DA", "19991231");
        slice.set(tags::patient_birth_date, "DA", "19421224");
        slice.set(tags::accession_number, "SH", "ACC-77");
        slice.set(tags::referring_physician, "PN", "Doctor^Planted");
    }
    fixtures::Reading reading(slices);
    reading.scan();
    const auto hidden = dicom_source(*reading.folder, reading.folder->series[0].objects, false);
    const auto kept = dicom_source(*reading.folder, reading.folder->series[0].objects, true);
    ASSERT_TRUE(hidden.ok() && kept.ok());
    const ContourSet set = ring_set(3, 20, 1);
    const VoxelModel model = random_model({8, 8, 4}, 1, false, 1);
    for (int kind = 0; kind < 4; ++kind) {
        const auto made = [&](const DicomSource& source) {
            if (kind == 0) return format_rtstruct(set, source);
            if (kind == 1) return format_segmentation(model, source).value();
            return format_encapsulated(kind == 2 ? SurfaceObject::stl : SurfaceObject::obj, "solid", "model",
                                       source)
                .value();
        };
        const std::string without = made(hidden.value()), with = made(kept.value());
        for (const std::string& text : planted)
            EXPECT_EQ(without.find(std::string(text)), std::string::npos) << kind << " " << text;
        for (int i = 0; i < 7; ++i)
            EXPECT_NE(with.find(planted[i]), std::string::npos) << kind << " " << planted[i];
        // All objects of one study stay together.
        EXPECT_NE(without.find(replaced_uid("1.9.8.77.1")), std::string::npos);
        EXPECT_NE(without.find(replaced_uid("1.9.8.77.3")), std::string::npos);
    }
}

TEST(DicomObjects, uids_are_valid_and_differ) {
    std::vector<std::string> uids;
    for (int n = 0; n < 1000; ++n) uids.push_back(derived_uid(std::to_string(n)));
    for (const std::string& uid : uids) {
        EXPECT_LE(uid.size(), 44u);
        EXPECT_TRUE(uid.starts_with("2.25.") && uid[5] != '0') << uid;
        EXPECT_EQ(uid.find_first_not_of("0123456789."), std::string::npos);
    }
    std::sort(uids.begin(), uids.end());
    EXPECT_EQ(std::unique(uids.begin(), uids.end()), uids.end());
}

TEST(DicomObjects, decimal_strings_fit_sixteen_characters) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> number(-2000, 2000);
    for (int n = 0; n < 20000; ++n) {
        const double value = n % 3 == 0   ? number(random)
                             : n % 3 == 1 ? number(random) * 1e-6
                                          : number(random) * 1e4;
        std::string text;
        append_decimal_string(text, value);
        EXPECT_LE(text.size(), 16u) << text;
        EXPECT_NEAR(std::strtod(text.c_str(), nullptr), value, 1e-9 + 1e-13 * std::abs(value)) << text;
    }
}

}  // namespace
}  // namespace anatomesh::write_objects_test
