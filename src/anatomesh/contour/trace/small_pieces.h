// leave_out_small_pieces: a label slice without the islands and holes that are too small to model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace anatomesh {

// The labels of one slice inside a border of zeros, one pixel wide: pixel (i, j) is at(i + 1, j + 1).
struct LabelGrid {
    std::uint32_t width = 0, height = 0;  // without the border
    std::vector<std::uint16_t> labels;    // (width + 2) x (height + 2), row by row

    std::uint32_t row_length() const { return width + 2; }
    std::uint16_t at(std::uint32_t x, std::uint32_t y) const {
        return labels[std::size_t{y} * row_length() + x];
    }
};

struct SmallPieces {
    std::uint32_t islands = 0, holes = 0;  // pieces of a structure, pieces of the outside
    std::uint64_t island_pixels = 0, hole_pixels = 0;
};

// Relabels every piece of fewer than `min_pixels` pixels with the label with which it shares most pixel edges; of
// equal ones, the lower label. The smallest piece comes first, until no such piece is left. Pieces of a structure are
// 4-connected and pieces of the outside 8-connected, as they are traced. The outside that reaches the border of the
// grid is never small. A piece that grew by another's pixels counts once for each.
// Complexity: linear in the pixels when the pieces are few, O(n log n) in the small pieces.
SmallPieces leave_out_small_pieces(LabelGrid& grid, double min_pixels);

}  // namespace anatomesh
