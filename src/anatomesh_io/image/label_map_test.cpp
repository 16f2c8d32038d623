#include <limits>

#include "anatomesh_io/image/image_fixtures.h"

namespace anatomesh::label_map_test {
namespace {

using namespace fixtures;

// A float64 image of the given size and values (short lists are filled with 0).
Outcome read_values(std::array<std::int64_t, 3> size, std::vector<double> values) {
    Nifti nifti;
    nifti.dim = {3, size[0], size[1], size[2], 1, 1, 1, 1};
    nifti.datatype = 64;
    nifti.bitpix = 64;
    values.resize(static_cast<std::size_t>(size[0] * size[1] * size[2]));
    nifti.data = values_as_bytes(values);
    return read_bytes(nifti.bytes());
}

struct Labelled {
    std::string code;
    Error error;
    LabelMap map;
    std::vector<Warning> warnings;
};

Labelled labelled(const Outcome& outcome) {
    EXPECT_TRUE(outcome.ok()) << to_line(outcome.error);
    RunContext context;
    auto result = to_label_map(outcome.loaded, context);
    Labelled labels;
    labels.warnings = context.warnings;
    if (result.ok()) {
        labels.map = std::move(result).value();
    } else {
        labels.error = result.error();
        labels.code = labels.error.code;
    }
    return labels;
}

TEST(LabelMap, numbers_are_the_values_of_the_file) {
    const Outcome outcome = read_values({4, 2, 1}, {0, 7, 7, 0, 70000, 2, 0, 7});
    EXPECT_TRUE(looks_like_label_map(outcome.loaded.facts));
    const Labelled labels = labelled(outcome);
    ASSERT_EQ(labels.code, "");
    ASSERT_EQ(labels.map.structures.size(), 3U);
    EXPECT_EQ(labels.map.structures[0].number, 2);
    EXPECT_EQ(labels.map.structures[1].number, 7);
    EXPECT_EQ(labels.map.structures[2].number, 70000);
    EXPECT_EQ(labels.map.voxels, (std::vector<std::uint16_t>{0, 2, 2, 0, 3, 1, 0, 2}));
}

TEST(LabelMap, L06_65535_labels) {
    std::vector<double> values;
    for (int n = 0; n < 65536; ++n) values.push_back(n);
    const Labelled labels = labelled(read_values({256, 256, 1}, values));
    ASSERT_EQ(labels.code, "");
    EXPECT_EQ(labels.map.structures.size(), 65535U);
    EXPECT_EQ(labels.map.voxels.back(), 65535);
    values.push_back(65536);
    EXPECT_EQ(labelled(read_values({257, 256, 1}, values)).code, "E-LBL-005");
}

TEST(LabelMap, L13_all_ones_is_cut_by_the_border) {
    const Labelled labels = labelled(read_values({3, 4, 5}, std::vector<double>(60, 1)));
    ASSERT_EQ(labels.code, "");
    ASSERT_EQ(labels.warnings.size(), 1U);
    EXPECT_EQ(labels.warnings[0].code, "W-LBL-002");
    EXPECT_EQ(labels.warnings[0].place.structure, "1");
}

TEST(LabelMap, L13_every_side_of_the_border_is_seen) {
    for (int side = 0; side < 6; ++side) {
        std::array<std::int64_t, 3> at = {2, 2, 2};
        at[static_cast<std::size_t>(side / 2)] = side % 2 == 0 ? 0 : 4;
        std::vector<double> values(125);
        values[static_cast<std::size_t>((at[2] * 5 + at[1]) * 5 + at[0])] = 1;
        EXPECT_EQ(labelled(read_values({5, 5, 5}, values)).warnings.size(), 1U) << side;
    }
    std::vector<double> inner(125);
    inner[62] = 1;
    EXPECT_TRUE(labelled(read_values({5, 5, 5}, inner)).warnings.empty());
}

TEST(LabelMap, L14_all_zeros) {
    const Labelled labels = labelled(read_values({3, 4, 5}, {}));
    EXPECT_EQ(labels.code, "E-LBL-006");
    EXPECT_NE(labels.error.message.find("empty"), std::string::npos);
}

TEST(LabelMap, L15_L16_no_voxel_is_lost) {
    std::vector<double> checkerboard;
    for (int n = 0; n < 125; ++n) checkerboard.push_back(n % 2);
    const Labelled labels = labelled(read_values({5, 5, 5}, checkerboard));
    ASSERT_EQ(labels.code, "");
    for (int n = 0; n < 125; ++n) EXPECT_EQ(labels.map.voxels[n], n % 2);
    std::vector<double> one(125);
    one[62] = 3;
    EXPECT_EQ(labelled(read_values({5, 5, 5}, one)).map.voxels[62], 1);
}

TEST(LabelMap, L17_flat_volumes) {
    for (const std::array<std::int64_t, 3> size :
         {std::array<std::int64_t, 3>{1, 1, 1}, {4, 4, 1}, {1, 4, 4}, {4, 1, 1}, {1, 1, 4}}) {
        const auto count = static_cast<std::size_t>(size[0] * size[1] * size[2]);
        const Labelled labels = labelled(read_values(size, std::vector<double>(count, 1)));
        ASSERT_EQ(labels.code, "");
        EXPECT_EQ(labels.map.voxels.size(), count);
    }
    // A NIfTI image of two axes is one layer.
    Nifti nifti;
    nifti.dim = {2, 3, 4, 0, 0, 0, 0, 0};
    nifti.pixdim[3] = 0;
    nifti.data = std::string(24, '\1');
    const Outcome outcome = read_bytes(nifti.bytes());
    ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
    EXPECT_EQ(outcome.loaded.image.geometry.size, (std::array<std::uint32_t, 3>{3, 4, 1}));
}

TEST(LabelMap, L18_labels_as_floating_point_numbers) {
    Labelled labels = labelled(read_values({2, 2, 2}, {0, 1.0000002, 2, 0.9995}));
    ASSERT_EQ(labels.code, "");
    ASSERT_FALSE(labels.warnings.empty());
    EXPECT_EQ(labels.warnings[0].code, "W-LBL-001");
    EXPECT_EQ(labels.map.structures.size(), 2U);
    EXPECT_EQ(labels.map.voxels[1], 1);
    EXPECT_EQ(labels.map.voxels[3], 1);

    labels = labelled(read_values({2, 2, 2}, {0, 1, 1.002}));
    EXPECT_EQ(labels.code, "E-LBL-003");
    EXPECT_EQ(labels.error.place.slice, "0 (voxel 0, 1, 0)");
    EXPECT_EQ(labelled(read_values({2, 2, 2}, {0, 1, -3})).code, "E-LBL-002");
    EXPECT_EQ(labelled(read_values({2, 2, 2}, {0, 1, 1e9})).code, "E-LBL-004");
    for (const double value :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
        const Outcome outcome = read_values({2, 2, 2}, {0, 1, 2, 3, 4, value});
        EXPECT_TRUE(outcome.warned("W-IMG-002"));
        EXPECT_EQ(outcome.loaded.image.voxels[5], 0);  // the lowest value
        EXPECT_FALSE(looks_like_label_map(outcome.loaded.facts));
        labels = labelled(outcome);
        EXPECT_EQ(labels.code, "E-LBL-001");
        EXPECT_EQ(labels.error.place.slice, "1 (voxel 1, 0, 1)");
    }
    // Nothing but NaN.
    EXPECT_EQ(labelled(read_values({1, 1, 1}, {std::numeric_limits<double>::quiet_NaN()})).code, "E-LBL-001");
}

TEST(LabelMap, L19_salt_and_pepper_is_still_a_label_map) {
    std::vector<double> values(std::size_t{64} * 64 * 64);
    std::uint64_t state = 1;
    std::size_t ones = 0;
    for (double& value : values) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        value = (state >> 40) % 3 == 0;
        ones += value == 1;
    }
    const Outcome outcome = read_values({64, 64, 64}, values);
    EXPECT_TRUE(looks_like_label_map(outcome.loaded.facts));
    const Labelled labels = labelled(outcome);
    std::size_t kept = 0;
    for (const std::uint16_t label : labels.map.voxels) kept += label;
    EXPECT_EQ(kept, ones);
}

TEST(LabelMap, grey_images_do_not_pass_for_label_maps) {
    // Eight-bit grey values: whole numbers from 0 to 255 that differ from voxel to voxel.
    std::vector<double> grey, labels, signed_values;
    for (int n = 0; n < 32 * 32 * 32; ++n) {
        grey.push_back((n * 37) % 251);
        labels.push_back(n / 512);
        signed_values.push_back(n / 512 - 1);
    }
    EXPECT_FALSE(looks_like_label_map(read_values({32, 32, 32}, grey).loaded.facts));
    EXPECT_TRUE(looks_like_label_map(read_values({32, 32, 32}, labels).loaded.facts));
    EXPECT_FALSE(looks_like_label_map(read_values({32, 32, 32}, signed_values).loaded.facts));
}

}  // namespace
}  // namespace anatomesh::label_map_test
