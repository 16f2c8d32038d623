#include "anatomesh_io/image/write_image.h"

#include <gtest/gtest.h>

#include "anatomesh_io/image/image_fixtures.h"
#include "anatomesh_io/image/phantom_fixtures.h"

namespace anatomesh::write_image_test {
namespace {

using namespace fixtures;

constexpr std::array<const char*, 4> names = {"image.nrrd", "image.nii", "image.nii.gz", "IMAGE.NRRD"};

std::vector<ImageGeometry> geometries() {
    std::vector<ImageGeometry> list;
    for (const Phantom& phantom : {axis_phantom(), oblique_phantom()}) {
        ImageGeometry geometry;
        geometry.size = {3, 4, 5};
        geometry.origin = phantom.origin;
        geometry.step = phantom.step;
        list.push_back(geometry);
    }
    list.push_back(list[1]);
    list.back().step[2] = list.back().step[2] + 0.3 * list.back().step[1];  // sheared by a tilted gantry
    return list;
}

void expect_same_place(const ImageGeometry& read, const ImageGeometry& written, bool exactly) {
    ASSERT_EQ(read.size, written.size);
    for (const auto& [i, j, k] : {std::array{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 4}, {2, 3, 4}}) {
        const Vec3 a = read.position(i, j, k), b = written.position(i, j, k);
        EXPECT_LE(length(a - b), exactly ? 0 : 1e-4);
    }
}

TEST(WriteImage, values_and_positions_read_back) {
    Folder folder;
    for (const ImageGeometry& geometry : geometries()) {
        std::vector<float> values;
        for (int n = 0; n < 60; ++n) values.push_back(static_cast<float>(0.37 * n - 9));
        for (const std::string name : names) {
            const ImageFormat format = image_format_of(name).value();
            const std::string bytes = format_image(geometry, values, format).value();
            EXPECT_EQ(bytes, format_image(geometry, values, format).value());
            const Outcome outcome = read(folder.write(name, bytes));
            ASSERT_TRUE(outcome.ok()) << outcome.code;
            EXPECT_TRUE(outcome.warnings.empty());
            EXPECT_EQ(outcome.loaded.image.voxels, values);
            expect_same_place(outcome.loaded.image.geometry, geometry, format == ImageFormat::nrrd);
        }
    }
}

TEST(WriteImage, labels_read_back_with_numbers_names_and_colours) {
    Folder folder;
    for (const std::int32_t number : {3, 255, 256, 65535, 65536}) {
        LabelMap labels;
        labels.geometry = geometries()[1];
        labels.structures = {{1, "left kidney", {10, 128, 255}}, {number, "line\nbreak", {200, 80, 60}}};
        for (int n = 0; n < 60; ++n) labels.voxels.push_back(static_cast<std::uint16_t>(n % 20 / 7));
        for (const std::string name : names) {
            const ImageFormat format = image_format_of(name).value();
            const Outcome outcome = read(folder.write(name, format_label_map(labels, format).value()));
            ASSERT_TRUE(outcome.ok()) << outcome.code;
            RunContext context;
            const auto back = to_label_map(outcome.loaded, context);
            ASSERT_TRUE(back.ok());
            EXPECT_EQ(back.value().voxels, labels.voxels);
            ASSERT_EQ(back.value().structures.size(), 2u);
            EXPECT_EQ(back.value().structures[1].number, number);
            if (format != ImageFormat::nrrd) continue;
            EXPECT_EQ(back.value().structures[0].name, "left kidney");
            EXPECT_EQ(back.value().structures[1].name, "line break");
            EXPECT_EQ(back.value().structures[0].color, labels.structures[0].color);
        }
    }
}

TEST(WriteImage, other_extensions_and_axes_too_long_are_refused) {
    EXPECT_EQ(image_format_of("image.mha").error().code, "E-IMG-016");
    ImageGeometry geometry;
    geometry.size = {32768, 1, 1};
    const std::vector<float> values(32768, 1);
    EXPECT_EQ(format_image(geometry, values, ImageFormat::nifti).error().code, "E-IMG-017");
    EXPECT_TRUE(format_image(geometry, values, ImageFormat::nrrd).ok());
}

}  // namespace
}  // namespace anatomesh::write_image_test
