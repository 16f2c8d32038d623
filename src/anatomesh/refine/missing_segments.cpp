#include "anatomesh/refine/missing_segments.h"

#include <algorithm>
#include <array>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

std::vector<std::uint32_t> missing_pieces(const std::vector<Cell>& cells, std::size_t point_count,
                                          const std::vector<SegmentPiece>& pieces, int threads) {
    // For every vertex the other ends of the pieces at it, each pair at the lower vertex.
    std::vector<std::uint32_t> start(point_count + 1, 0);
    for (const SegmentPiece& piece : pieces) ++start[std::min(piece.a, piece.b) + 1];
    for (std::size_t v = 0; v < point_count; ++v) start[v + 1] += start[v];
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1), slot(pieces.size());
    std::vector<std::uint32_t> other(pieces.size());
    for (std::size_t n = 0; n < pieces.size(); ++n) {
        slot[n] = next[std::min(pieces[n].a, pieces[n].b)]++;
        other[slot[n]] = std::max(pieces[n].a, pieces[n].b);
    }
    // Most cells have fewer than two vertices that are ends of pieces.
    std::vector<std::uint8_t> is_end(point_count, 0);
    for (const SegmentPiece& piece : pieces) is_end[piece.a] = is_end[piece.b] = 1;
    const std::vector<std::uint32_t> found = parallel_collect<std::uint32_t>(
        cells.size(), 32768, threads, [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& slots) {
            for (std::size_t c = first; c < last; ++c) {
                const Cell& cell = cells[c];
                if (is_end[cell[0]] + is_end[cell[1]] + is_end[cell[2]] + is_end[cell[3]] < 2) continue;
                for (const auto& [i, j] : cell_edges) {
                    const std::uint32_t a = std::min(cell[i], cell[j]), b = std::max(cell[i], cell[j]);
                    for (std::uint32_t s = start[a]; s < start[a + 1]; ++s) {
                        if (other[s] == b) slots.push_back(s);
                    }
                }
            }
        });
    std::vector<std::uint8_t> present(pieces.size(), 0);
    for (const std::uint32_t s : found) present[s] = 1;
    std::vector<std::uint32_t> missing;
    for (std::uint32_t n = 0; n < pieces.size(); ++n) {
        if (!present[slot[n]]) missing.push_back(n);
    }
    return missing;
}

}  // namespace anatomesh
