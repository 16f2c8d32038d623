#include "anatomesh_io/dicom/segmentation_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace anatomesh::segmentation_grid_test {
namespace {

// Some planes of a grid, the frames that a segmentation of small parts stores.
std::vector<double> some_planes(std::mt19937& random, double spacing, std::size_t count) {
    std::set<int> planes;
    while (planes.size() < count) planes.insert(static_cast<int>(random() % 60));
    std::vector<double> heights;
    for (const int plane : planes) heights.push_back(-17.3 + plane * spacing);
    return heights;
}

// Whatever frames are stored, the spacing is the one that the images, the file's spacing or its thickness says.
TEST(SegmentationGrid, WhatIsStatedHoldsWhateverFramesAreStored) {
    std::mt19937 random(1);
    std::size_t farther = 0;
    for (int round = 0; round < 400; ++round) {
        const double spacing = 0.3 + 0.1 * static_cast<double>(random() % 60);
        const std::vector<double> frames = some_planes(random, spacing, 1 + random() % 8);
        std::vector<double> images;
        for (int plane = 0; plane < 60; ++plane) images.push_back(-17.3 + plane * spacing);
        double least = 1e9;
        for (std::size_t n = 1; n < frames.size(); ++n) least = std::min(least, frames[n] - frames[n - 1]);
        farther += least > 1.5 * spacing;
        FrameHeights by_images{frames, images};
        by_images.thickness_mm = 2 * spacing;
        EXPECT_NEAR(grid_spacing(by_images).mm, spacing, 1e-9);
        EXPECT_EQ(grid_spacing(by_images).source, GridSource::images);
        FrameHeights by_spacing{frames};
        by_spacing.stated_mm = spacing;
        by_spacing.thickness_mm = spacing / 2;
        EXPECT_NEAR(grid_spacing(by_spacing).mm, spacing, 1e-9);
        by_spacing.stated_mm = -spacing;
        const std::vector<double> finer{-17.3, -17.3 + spacing / 2};
        by_spacing.images = finer;
        EXPECT_NEAR(grid_spacing(by_spacing).mm, spacing, 1e-9) << "what the file states comes first";
        FrameHeights by_thickness{frames};
        by_thickness.thickness_mm = spacing;
        const GridSpacing grid = grid_spacing(by_thickness);
        if (grid.skips_a_thickness) {
            EXPECT_NEAR(grid.mm, 2 * spacing, 1e-9);
            EXPECT_GE(frames.size(), 3u);
            continue;
        }
        EXPECT_NEAR(grid.mm, spacing, 1e-9);
    }
    EXPECT_GT(farther, 150u) << "in most sets no two frames are neighbours";
}

TEST(SegmentationGrid, WithoutAWordTheFramesSayIt) {
    const auto spacing_of = [](std::vector<double> frames) { return grid_spacing({frames}).mm; };
    EXPECT_NEAR(spacing_of({0, 15, 36}), 3, 1e-9) << "the largest that fits";
    EXPECT_NEAR(spacing_of({0, 2, 4, 10}), 2, 1e-9);
    EXPECT_NEAR(spacing_of({0, 24}), 24, 1e-9);
    EXPECT_NEAR(spacing_of({0, 0, 24, 24}), 24, 1e-9) << "two segments in each plane";
    EXPECT_EQ(spacing_of({0, 1, 2.37}), 0) << "nothing fits";
    EXPECT_EQ(spacing_of({5}), 0) << "one plane says nothing";
}

TEST(SegmentationGrid, WhatContradictsTheFramesIsPassedOver) {
    std::vector<double> frames{0, 2.5, 5, 10};
    FrameHeights overlapping{frames};
    overlapping.thickness_mm = 5;  // slices that overlap: a thickness is no spacing there
    EXPECT_NEAR(grid_spacing(overlapping).mm, 2.5, 1e-9);
    overlapping.stated_mm = 3;
    EXPECT_NEAR(grid_spacing(overlapping).mm, 2.5, 1e-9);
    const std::vector<double> images{0.9, 3.4, 5.9};
    overlapping.images = images;
    EXPECT_NEAR(grid_spacing(overlapping).mm, 2.5, 1e-9) << "they are images of other planes";
    EXPECT_EQ(grid_spacing(overlapping).source, GridSource::frames);
    frames = {0, 3, 6, 9.5, 12};
    FrameHeights one_is_off{frames};
    EXPECT_NEAR(grid_spacing(one_is_off).mm, 0.5, 1e-9);
    one_is_off.stated_mm = 3;
    EXPECT_EQ(grid_spacing(one_is_off).source, GridSource::none)
        << "no spacing is made up beside a stated one";
}

// Files round places to some decimals, so that the distances of frames are no multiples of anything.
TEST(SegmentationGrid, PlacesThatFilesRoundLieOnThePlanesThatAreStated) {
    std::mt19937 random(3);
    const auto share = [&] { return static_cast<double>(random()) / 4294967296.0; };
    int rounded = 0;
    for (int round = 0; round < 400; ++round) {
        const double unit = std::array{1.0, 0.1, 0.01, 0.001}[static_cast<std::size_t>(round % 4)];
        const double spacing = unit * (2.5 + 8 * share()), first = 100 * share();
        std::vector<double> frames;
        for (int k = 0; k < 40; ++k)
            if (share() < 0.7) frames.push_back(std::round((first + k * spacing) / unit) * unit);
        if (frames.size() < 2) continue;
        FrameHeights heights{frames};
        heights.rounding_mm = unit / 2;
        (round % 8 < 4 ? heights.stated_mm : heights.thickness_mm) = spacing;
        const GridSpacing grid = grid_spacing(heights);
        EXPECT_NEAR(grid.mm, spacing, 1e-9) << unit << " " << spacing;
        rounded += grid.is_rounded;
        // Frames of planes half as far apart again are none of these.
        std::vector<double> others;
        for (int k = 0; k < 12; ++k) others.push_back(std::round((first + 1.5 * k * spacing) / unit) * unit);
        heights.frames = others;
        EXPECT_FALSE(grid_spacing(heights).is_rounded) << unit << " " << spacing;
    }
    EXPECT_GT(rounded, 300);
}

// A table that is set to a hundredth of a millimetre moves frames by as much, also three times as far.
TEST(SegmentationGrid, FramesThatATableJittersLieOnThePlanesThatAreStated) {
    std::mt19937 random(8);
    const auto share = [&] { return static_cast<double>(random()) / 4294967296.0; };
    for (int round = 0; round < 200; ++round) {
        const double spacing = 2.5 + 4 * share();
        std::vector<double> frames;
        for (int k = 0; k < 20; ++k)
            if (k == 0 || share() < 0.5) frames.push_back(k * spacing + 0.025 * (2 * share() - 1));
        if (frames.size() < 3) continue;
        FrameHeights heights{frames};
        (round % 2 == 0 ? heights.stated_mm : heights.thickness_mm) = spacing;
        EXPECT_NEAR(grid_spacing(heights).mm, spacing, 0.03 * spacing) << round;
    }
}

// Slices 2 mm thick with gaps of 2 mm are usual; of two frames nobody knows.
TEST(SegmentationGrid, FramesThatAreAllTwoThicknessesApartAreNeighbours) {
    std::vector<double> frames{0, 4, 8, 12};
    FrameHeights heights{frames};
    heights.thickness_mm = 2;
    EXPECT_NEAR(grid_spacing(heights).mm, 4, 1e-9);
    EXPECT_TRUE(grid_spacing(heights).skips_a_thickness);
    frames = {0, 4};
    heights.frames = frames;
    EXPECT_NEAR(grid_spacing(heights).mm, 2, 1e-9);
    frames = {0, 4, 10};
    heights.frames = frames;
    EXPECT_NEAR(grid_spacing(heights).mm, 2, 1e-9);
    EXPECT_FALSE(grid_spacing(heights).skips_a_thickness);
}

TEST(SegmentationGrid, ValuesThatNoSliceHasAreNoWord) {
    for (const double mm : {0.0, 1e-9, -1e6, 1e6, std::nan("")}) {
        std::vector<double> frames{0};
        FrameHeights heights{frames};
        heights.thickness_mm = heights.stated_mm = mm;
        EXPECT_EQ(grid_spacing(heights).source, GridSource::none) << mm;
    }
}

}  // namespace
}  // namespace anatomesh::segmentation_grid_test
