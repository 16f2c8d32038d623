#include "anatomesh/field/slice/bit_volume.h"

#include <cassert>

namespace anatomesh {

BitVolume::BitVolume(const PixelGrid& grid, std::uint32_t slices)
    : grid_(grid), slices_(slices), words_per_row_(grid.nx / 64 + (grid.nx % 64 != 0)) {
    words_.assign(static_cast<std::size_t>(slices) * grid.ny * words_per_row_, 0);
}

void BitVolume::fill(std::uint32_t k, std::span<const Edge2> edges) {
    assert(k < slices_);
    fill_even_odd(edges, grid_, [&](std::uint32_t j, std::uint32_t first, std::uint32_t last) {
        const std::uint64_t head = ~std::uint64_t{0} << (first & 63u);
        const std::uint64_t tail = ~std::uint64_t{0} >> (63u - ((last - 1) & 63u));
        const std::size_t from = word(first, j, k), to = word(last - 1, j, k);
        if (from == to) {
            words_[from] |= head & tail;
            return;
        }
        words_[from] |= head;
        for (std::size_t w = from + 1; w < to; ++w) words_[w] = ~std::uint64_t{0};
        words_[to] |= tail;
    });
}

std::uint64_t BitVolume::count() const {
    std::uint64_t total = 0;
    for (const std::uint64_t w : words_) total += static_cast<std::uint64_t>(std::popcount(w));
    return total;
}

}  // namespace anatomesh
