// BitVolume: inside or outside per voxel, one bit each, filled from the contours slice by slice.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/field/slice/scanline.h"

namespace anatomesh {

// The bit volume BV of Archip et al. (2006). Voxel (i, j, k) is the point (i, j) of the grid in slice k; it
// is set where the even-odd rule of the slice's contours says inside. Rows are padded to whole words.
class BitVolume {
  public:
    // Requires: grid.nx * grid.ny * slices fits in memory (one bit a voxel); the caller has checked it.
    BitVolume(const PixelGrid& grid, std::uint32_t slices);

    // Sets the voxels of slice k inside the region that the edges bound; others are left as they are.
    // A voxel centre on the boundary counts by the half-open rule of fill_even_odd().
    // Complexity: linear in the rows that the edges span, plus one step a word.
    void fill(std::uint32_t k, std::span<const Edge2> edges);

    bool inside(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
        return (words_[word(i, j, k)] >> (i & 63u)) & 1u;
    }
    std::uint64_t count() const;  // voxels inside
    const PixelGrid& grid() const { return grid_; }
    std::uint32_t slices() const { return slices_; }
    std::size_t bytes() const { return words_.size() * sizeof(std::uint64_t); }

  private:
    std::size_t word(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
        return (static_cast<std::size_t>(k) * grid_.ny + j) * words_per_row_ + (i >> 6u);
    }

    PixelGrid grid_;
    std::uint32_t slices_ = 0, words_per_row_ = 0;
    std::vector<std::uint64_t> words_;
};

}  // namespace anatomesh
