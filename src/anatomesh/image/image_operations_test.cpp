#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "anatomesh/image/components.h"
#include "anatomesh/image/select.h"
#include "anatomesh/image/threshold.h"

namespace anatomesh::image_operations_test {
namespace {

LabelMap label_map(std::array<std::uint32_t, 3> size, std::uint16_t structures) {
    LabelMap map;
    map.geometry.size = size;
    map.voxels.assign(map.geometry.voxel_count(), 0);
    for (std::uint16_t s = 1; s <= structures; ++s) map.structures.push_back({s * 10, "", {}});
    return map;
}

GreyImage row(const std::vector<float>& values) {
    GreyImage image;
    image.geometry.size = {static_cast<std::uint32_t>(values.size()), 1, 1};
    image.voxels = values;
    image.source = "scan.nii";
    return image;
}

TEST(Threshold, both_bounds_belong_to_the_range) {
    RunContext context;
    const GreyImage image = row({-5, 225.5, 226, 300, 1000, 1000.5, std::nanf("")});
    auto labels = threshold_image(image, {226, 1000}, context);
    ASSERT_TRUE(labels.ok());
    EXPECT_EQ(labels.value().voxels, (std::vector<std::uint16_t>{0, 0, 1, 1, 1, 0, 0}));
    ASSERT_EQ(labels.value().structures.size(), 1u);
    EXPECT_EQ(labels.value().structures[0].name, "threshold 226:1000");
    EXPECT_EQ(labels.value().structures[0].number, 1);
    EXPECT_EQ(labels.value().source, "scan.nii");

    labels = threshold_image(image, {225.5}, context);
    ASSERT_TRUE(labels.ok());
    EXPECT_EQ(labels.value().voxels, (std::vector<std::uint16_t>{0, 1, 1, 1, 1, 1, 0}));
    EXPECT_EQ(labels.value().structures[0].name, "threshold 225.5");
}

TEST(Threshold, nothing_in_the_range_names_the_range_of_the_image) {
    RunContext context;
    const auto labels = threshold_image(row({-5, std::nanf(""), 20}), {21}, context);
    ASSERT_FALSE(labels.ok());
    EXPECT_EQ(labels.error().code, "E-THR-001");
    EXPECT_EQ(labels.error().place.file, "scan.nii");
    EXPECT_NE(labels.error().next_step.find("-5:20"), std::string::npos);
    EXPECT_FALSE(threshold_image(row({std::nanf("")}), {0}, context).ok());
    EXPECT_FALSE(threshold_image(row({}), {0}, context).ok());
}

// Pieces by flooding over all 26 neighbours; the label of each voxel's piece is its first voxel.
std::vector<std::size_t> flooded(const LabelMap& map) {
    const auto& size = map.geometry.size;
    std::vector<std::size_t> piece(map.voxels.size(), map.voxels.size());
    for (std::size_t start = 0; start < map.voxels.size(); ++start) {
        if (map.voxels[start] == 0 || piece[start] != map.voxels.size()) continue;
        std::vector<std::size_t> front{start};
        piece[start] = start;
        while (!front.empty()) {
            const std::size_t v = front.back();
            front.pop_back();
            const int i = int(v % size[0]), j = int(v / size[0] % size[1]), k = int(v / size[0] / size[1]);
            for (int n = 0; n < 27; ++n) {
                const int a = i + n % 3 - 1, b = j + n / 3 % 3 - 1, c = k + n / 9 - 1;
                if (a < 0 || b < 0 || c < 0 || a >= int(size[0]) || b >= int(size[1]) || c >= int(size[2]))
                    continue;
                const std::size_t w =
                    map.geometry.index(std::uint32_t(a), std::uint32_t(b), std::uint32_t(c));
                if (map.voxels[w] != map.voxels[start] || piece[w] != map.voxels.size()) continue;
                piece[w] = start;
                front.push_back(w);
            }
        }
    }
    return piece;
}

TEST(Components, agree_with_flooding_on_noise) {
    std::mt19937 random(11);
    for (const std::array<std::uint32_t, 3> size :
         {std::array<std::uint32_t, 3>{17, 13, 9}, {40, 1, 6}, {1, 1, 30}, {1, 25, 7}, {31, 30, 1}}) {
        for (const unsigned density : {3u, 8u, 20u}) {
            LabelMap map = label_map(size, 2);
            for (auto& voxel : map.voxels) {
                const unsigned n = random() % density;
                voxel = static_cast<std::uint16_t>(n < 3 ? n : 0);
            }
            const std::vector<std::size_t> piece = flooded(map);
            std::vector<std::uint64_t> voxels(map.voxels.size(), 0);
            std::array<std::uint32_t, 3> pieces{};
            for (std::size_t v = 0; v < piece.size(); ++v) {
                if (map.voxels[v] == 0) continue;
                ++voxels[piece[v]];
                pieces[map.voxels[v]] += piece[v] == v;
            }
            for (const std::uint32_t count : {1u, 2u, 5u}) {
                LabelMap kept = map;
                const ComponentStats stats = keep_largest(kept, count);
                for (std::uint16_t label = 1; label <= 2; ++label) {
                    EXPECT_EQ(stats.structures[label - 1u].pieces, pieces[label]);
                    // The pieces in order of size, then of their first voxel.
                    std::vector<std::size_t> order;
                    for (std::size_t v = 0; v < piece.size(); ++v) {
                        if (piece[v] == v && map.voxels[v] == label) order.push_back(v);
                    }
                    std::stable_sort(order.begin(), order.end(),
                                     [&](std::size_t a, std::size_t b) { return voxels[a] > voxels[b]; });
                    order.resize(std::min<std::size_t>(order.size(), count));
                    for (std::size_t v = 0; v < piece.size(); ++v) {
                        if (map.voxels[v] != label) continue;
                        const bool expected = std::find(order.begin(), order.end(), piece[v]) != order.end();
                        ASSERT_EQ(kept.voxels[v], expected ? label : 0);
                    }
                }
            }
        }
    }
}

TEST(Components, pieces_between_kept_slices_agree_with_flooding_on_noise) {
    std::mt19937 random(12);
    LabelMap map = label_map({11, 10, 12}, 2);
    std::uint32_t missed_in_all = 0;
    for (const unsigned density : {6u, 12u, 40u}) {
        for (auto& voxel : map.voxels) {
            const unsigned n = random() % density;
            voxel = static_cast<std::uint16_t>(n < 3 ? n : 0);
        }
        const std::vector<std::size_t> piece = flooded(map);
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            for (const KeptSlices kept :
                 {KeptSlices{axis, 1, 0}, {axis, 2, 0}, {axis, 2, 1}, {axis, 5, 3}, {axis, 20, 19}}) {
                std::vector<std::uint64_t> voxels(map.voxels.size(), 0);
                std::vector<char> met(map.voxels.size(), 0);
                for (std::size_t v = 0; v < piece.size(); ++v) {
                    if (map.voxels[v] == 0) continue;
                    ++voxels[piece[v]];
                    const std::array<std::size_t, 3> at{v % 11, v / 11 % 10, v / 110};
                    met[piece[v]] |= at[axis] % kept.every == kept.offset;
                }
                for (const std::uint64_t least : {0u, 1u, 3u}) {
                    std::array<MissedPieces, 2> expected;
                    for (std::size_t v = 0; v < piece.size(); ++v) {
                        if (piece[v] != v || map.voxels[v] == 0 || met[v] || voxels[v] < least) continue;
                        MissedPieces& of = expected[map.voxels[v] - 1u];
                        ++of.pieces;
                        of.voxels += voxels[v];
                        of.largest = std::max(of.largest, voxels[v]);
                    }
                    const std::vector<MissedPieces> missed = pieces_between(map, kept, least);
                    ASSERT_EQ(missed.size(), 2u);
                    for (int s = 0; s < 2; ++s) {
                        EXPECT_EQ(missed[s].pieces, expected[s].pieces);
                        EXPECT_EQ(missed[s].voxels, expected[s].voxels);
                        EXPECT_EQ(missed[s].largest, expected[s].largest);
                        missed_in_all += missed[s].pieces;
                    }
                }
            }
        }
    }
    EXPECT_GT(missed_in_all, 100u);
}

TEST(Components, L15_voxels_that_share_a_corner_are_one_piece) {
    LabelMap map = label_map({4, 4, 4}, 1);
    for (std::uint32_t n = 0; n < 4; ++n) map.voxels[map.geometry.index(n, 3 - n, n)] = 1;
    const ComponentStats stats = keep_largest(map, 1);
    EXPECT_EQ(stats.structures[0].pieces, 1u);
    EXPECT_EQ(stats.structures[0].voxels_kept, 4u);
}

TEST(Components, of_equal_pieces_the_first_is_kept) {
    LabelMap map = label_map({5, 1, 1}, 1);
    map.voxels = {1, 0, 1, 0, 1};
    const ComponentStats stats = keep_largest(map, 2);
    EXPECT_EQ(map.voxels, (std::vector<std::uint16_t>{1, 0, 1, 0, 0}));
    EXPECT_EQ(stats.structures[0].voxels, 3u);
    EXPECT_EQ(stats.structures[0].pieces_kept, 2u);
}

TEST(Components, nothing_labelled) {
    LabelMap map = label_map({3, 3, 3}, 1);
    EXPECT_EQ(keep_largest(map, 1).structures[0].pieces, 0u);
    LabelMap none = label_map({0, 0, 0}, 0);
    EXPECT_TRUE(keep_largest(none, 1).structures.empty());
}

TEST(Select, keeps_structures_in_their_order_and_renumbers) {
    LabelMap map = label_map({6, 1, 1}, 4);
    map.voxels = {0, 1, 2, 3, 4, 2};
    EXPECT_EQ(count_voxels(map), (std::vector<std::uint64_t>{1, 2, 1, 1}));
    const std::vector<std::uint32_t> keep{3, 1, 3};
    select_structures(map, keep);
    EXPECT_EQ(map.voxels, (std::vector<std::uint16_t>{0, 0, 1, 0, 2, 1}));
    ASSERT_EQ(map.structures.size(), 2u);
    EXPECT_EQ(map.structures[0].number, 20);
    EXPECT_EQ(map.structures[1].number, 40);
}

TEST(Select, L14_structures_without_a_voxel_have_none) {
    LabelMap map = label_map({3, 1, 1}, 3);
    map.voxels = {0, 2, 2};
    EXPECT_EQ(count_voxels(map), (std::vector<std::uint64_t>{0, 2, 0}));
}

}  // namespace
}  // namespace anatomesh::image_operations_test
