#include "anatomesh/mesh/edit/facets.h"

#include <algorithm>
#include <cassert>
#include <memory>
#include <utility>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// So many facets are a task of one thread. [facets; >= 1; B]
constexpr std::size_t facets_per_task = 262144;

// A cell's vertices in rising order, where each comes from, and whether the order is an odd permutation.
struct SortedCell {
    Cell vertex;
    std::array<std::uint8_t, 4> index{0, 1, 2, 3};
    bool odd = false;

    explicit SortedCell(const Cell& cell) : vertex(cell) {
        order(0, 1);
        order(2, 3);
        order(0, 2);
        order(1, 3);
        order(1, 2);
    }

  private:
    void order(std::size_t i, std::size_t j) {
        if (vertex[i] <= vertex[j]) return;
        std::swap(vertex[i], vertex[j]);
        std::swap(index[i], index[j]);
        odd = !odd;
    }
};

// A facet filed under its smallest vertex: the other two, whose facet it is, and which way it turns.
struct Filed {
    std::uint64_t key;
    std::uint32_t id;
    bool odd;
};

// The two larger vertices of the facet opposite the k-th in rising order; the smallest is the second one for
// k = 0, else the first.
constexpr std::array<std::array<std::size_t, 2>, 4> larger_two{{{2, 3}, {2, 3}, {1, 3}, {1, 2}}};

}  // namespace

FacetPairs match_facets(std::span<const Cell> cells, std::size_t point_count, int threads) {
    assert(cells.size() < no_cell / 4);
    // Count and scan; then each facet looks among those filed under its vertex before it.
    std::vector<std::uint32_t> start(point_count + 1, 0);
    for (const Cell& cell : cells) {
        const SortedCell sorted(cell);
        start[sorted.vertex[0] + 1] += 3;
        start[sorted.vertex[1] + 1] += 1;
    }
    for (std::size_t v = 0; v < point_count; ++v) start[v + 1] += start[v];
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
    const auto filed = std::make_unique_for_overwrite<Filed[]>(4 * cells.size());
    FacetPairs pairs;
    pairs.other.assign(4 * cells.size(), no_cell);
    const auto file = [&](std::uint32_t v, const Filed& facet, FacetPairs& faults) {
        const Filed* same = filed.get() + start[v];
        const Filed* const end = filed.get() + next[v];
        while (same != end && same->key != facet.key) ++same;
        if (same == end) {
            filed[next[v]++] = facet;
        } else if (pairs.other[same->id] != no_cell) {
            faults.surplus.push_back({same->id, facet.id});
        } else {
            pairs.other[same->id] = facet.id;
            pairs.other[facet.id] = same->id;
            if (same->odd == facet.odd) faults.on_one_side.push_back({same->id, facet.id});
        }
    };
    // Each piece of the work files the facets of its vertices.
    const auto shares = static_cast<std::size_t>(std::max(threads, 1));
    std::vector<FacetPairs> faults(shares);
    parallel_for(shares, 1, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const auto bound = [&](std::size_t share) {
                const auto least = static_cast<std::uint32_t>(4 * cells.size() * share / shares);
                return static_cast<std::uint32_t>(std::lower_bound(start.begin(), start.end() - 1, least) -
                                                  start.begin());
            };
            const std::uint32_t first = n == 0 ? 0 : bound(n);
            const auto last = n + 1 == shares ? static_cast<std::uint32_t>(point_count) : bound(n + 1);
            for (std::uint32_t c = 0; c < cells.size(); ++c) {
                const SortedCell sorted(cells[c]);
                for (std::size_t k = 0; k < 4; ++k) {
                    const std::uint32_t v = sorted.vertex[k == 0];
                    if (v < first || v >= last) continue;
                    const auto& [b, d] = larger_two[k];
                    file(v,
                         {std::uint64_t{sorted.vertex[b]} << 32 | sorted.vertex[d], 4 * c + sorted.index[k],
                          sorted.odd != (k % 2 == 1)},
                         faults[n]);
                }
            }
        }
    });
    for (const FacetPairs& share : faults) {
        pairs.on_one_side.insert(pairs.on_one_side.end(), share.on_one_side.begin(), share.on_one_side.end());
        pairs.surplus.insert(pairs.surplus.end(), share.surplus.begin(), share.surplus.end());
    }
    std::sort(pairs.on_one_side.begin(), pairs.on_one_side.end());
    std::sort(pairs.surplus.begin(), pairs.surplus.end());
    return pairs;
}

std::vector<std::uint32_t> cell_neighbors(std::span<const Cell> cells, std::size_t point_count, int threads) {
    std::vector<std::uint32_t> neighbors = match_facets(cells, point_count, threads).other;
    parallel_for(neighbors.size(), facets_per_task, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n) {
            if (neighbors[n] != no_cell) neighbors[n] /= 4;
        }
    });
    return neighbors;
}

}  // namespace anatomesh
