#include "anatomesh/contour/trace/small_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace anatomesh::small_pieces_test {
namespace {

using Rows = std::vector<std::string>;

LabelGrid grid_of(const Rows& rows) {
    LabelGrid grid;
    grid.width = static_cast<std::uint32_t>(rows[0].size());
    grid.height = static_cast<std::uint32_t>(rows.size());
    grid.labels.assign(std::size_t{grid.row_length()} * (grid.height + 2), 0);
    for (std::size_t j = 0; j < rows.size(); ++j) {
        for (std::size_t i = 0; i < rows[j].size(); ++i) {
            grid.labels[(j + 1) * grid.row_length() + i + 1] = static_cast<std::uint16_t>(rows[j][i] - '0');
        }
    }
    return grid;
}

Rows rows_of(const LabelGrid& grid) {
    Rows rows(grid.height, std::string(grid.width, '?'));
    for (std::uint32_t j = 0; j < grid.height; ++j) {
        for (std::uint32_t i = 0; i < grid.width; ++i)
            rows[j][i] = static_cast<char>('0' + grid.at(i + 1, j + 1));
    }
    return rows;
}

Rows cleaned(const Rows& rows, double min_pixels) {
    LabelGrid grid = grid_of(rows);
    leave_out_small_pieces(grid, min_pixels);
    return rows_of(grid);
}

TEST(SmallPieces, nothing_is_below_one_pixel) {
    const Rows rows{"010", "101", "010"};
    EXPECT_EQ(cleaned(rows, 0), rows);
    EXPECT_EQ(cleaned(rows, 1), rows);
}

TEST(SmallPieces, islands_go_and_pieces_at_the_bound_stay) {
    EXPECT_EQ(cleaned({"11000", "11010", "00010"}, 4), (Rows{"11000", "11000", "00000"}));
    EXPECT_EQ(cleaned({"11000", "11010", "00010"}, 2), (Rows{"11000", "11010", "00010"}));
    EXPECT_EQ(cleaned({"11000", "11010", "00010"}, 4.5), (Rows{"00000", "00000", "00000"}));
}

TEST(SmallPieces, pieces_of_a_structure_are_4_connected_and_holes_8_connected) {
    EXPECT_EQ(cleaned({"1000", "0100", "0010"}, 2), (Rows{"0000", "0000", "0000"}));
    EXPECT_EQ(cleaned({"11111", "10111", "11011", "11101", "11111"}, 3),
              (Rows{"11111", "10111", "11011", "11101", "11111"}));
    EXPECT_EQ(cleaned({"11111", "11101", "11011", "10111", "11111"}, 3),
              (Rows{"11111", "11101", "11011", "10111", "11111"}));
    EXPECT_EQ(cleaned({"11111", "10111", "11011", "11101", "11111"}, 4),
              (Rows{"11111", "11111", "11111", "11111", "11111"}));
    // The outside reaches in across a corner.
    EXPECT_EQ(cleaned({"01111", "10111", "11011", "11111"}, 4), (Rows{"01111", "10111", "11011", "11111"}));
}

TEST(SmallPieces, a_piece_goes_to_the_label_around_most_of_it) {
    EXPECT_EQ(cleaned({"11222", "13222", "11222"}, 2), (Rows{"11222", "11222", "11222"}));
    EXPECT_EQ(cleaned({"11222", "11322", "11222"}, 2),
              (Rows{"11222", "11222", "11222"}));  // 2 wins: three edges
    EXPECT_EQ(cleaned({"1122", "1322", "1122"}, 2), (Rows{"1122", "1122", "1122"}));
}

TEST(SmallPieces, a_piece_inside_a_hole_fills_it_step_by_step) {
    EXPECT_EQ(cleaned({"11111", "10001", "10201", "10001", "11111"}, 10),
              (Rows{"11111", "11111", "11111", "11111", "11111"}));
    LabelGrid grid = grid_of({"11111", "10001", "10201", "10001", "11111"});
    const SmallPieces found = leave_out_small_pieces(grid, 10);
    EXPECT_EQ(found.islands, 1u);
    EXPECT_EQ(found.island_pixels, 1u);
    EXPECT_EQ(found.holes, 1u);
    EXPECT_EQ(found.hole_pixels, 9u);
}

TEST(SmallPieces, repainting_joins_what_it_connects) {
    // The right piece is small by itself and large enough once the smaller hole is filled.
    EXPECT_EQ(cleaned({"2222222", "2110112", "2111012", "2222222"}, 3),
              (Rows{"2222222", "2111112", "2111112", "2222222"}));
    EXPECT_EQ(cleaned({"222222", "211012", "211012", "222222"}, 3),
              (Rows{"222222", "211112", "211112", "222222"}));
}

// Sizes of the pieces that are left, found by flooding: 4-connected for structures, 8-connected for the
// outside.
std::size_t smallest_piece(const LabelGrid& grid) {
    const std::uint32_t length = grid.row_length(), rows = grid.height + 2;
    std::vector<std::uint8_t> seen(grid.labels.size(), 0);
    std::size_t smallest = grid.labels.size();
    for (std::uint32_t start = 0; start < grid.labels.size(); ++start) {
        if (seen[start]) continue;
        std::vector<std::uint32_t> piece{start};
        seen[start] = 1;
        for (std::size_t at = 0; at < piece.size(); ++at) {
            const int x = static_cast<int>(piece[at] % length), y = static_cast<int>(piece[at] / length);
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    if (dx != 0 && dy != 0 && grid.labels[start] != 0) continue;
                    const int nx = x + dx, ny = y + dy;
                    if (nx < 0 || ny < 0 || nx >= int(length) || ny >= int(rows)) continue;
                    const auto next =
                        static_cast<std::uint32_t>(ny) * length + static_cast<std::uint32_t>(nx);
                    if (seen[next] || grid.labels[next] != grid.labels[start]) continue;
                    seen[next] = 1;
                    piece.push_back(next);
                }
            }
        }
        if (start != 0) smallest = std::min(smallest, piece.size());
    }
    return smallest;
}

TEST(SmallPieces, L19_no_small_piece_is_left_of_noise) {
    std::mt19937 random(1);
    for (int labels = 2; labels <= 5; ++labels) {
        for (const double min_pixels : {2.0, 4.0, 11.0}) {
            Rows rows(60, std::string(70, '0'));
            for (auto& row : rows) {
                for (char& c : row) c = static_cast<char>('0' + random() % static_cast<unsigned>(labels));
            }
            LabelGrid grid = grid_of(rows);
            const SmallPieces found = leave_out_small_pieces(grid, min_pixels);
            EXPECT_GT(found.islands, 0u);
            EXPECT_GE(static_cast<double>(smallest_piece(grid)), min_pixels);
            const LabelGrid again = grid;
            leave_out_small_pieces(grid, min_pixels);
            EXPECT_EQ(grid.labels, again.labels);
        }
    }
}

}  // namespace
}  // namespace anatomesh::small_pieces_test
