// Building blocks of mesh bookkeeping without hashing: things filed under their smallest vertex, and disjoint
// sets.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// A facet or an edge filed under its smallest vertex: the rest of its vertices as one number, and whose it
// is.
struct Entry {
    std::uint64_t key;
    std::uint32_t id;

    friend bool operator<(const Entry& a, const Entry& b) {
        return a.key != b.key ? a.key < b.key : a.id < b.id;
    }
};

// Entries in buckets: those of vertex v are entries[start[v], start[v + 1]), sorted.
struct Buckets {
    std::vector<std::size_t> start;
    std::vector<Entry> entries;
};

// Count, scan, fill, then sort every bucket. visit(emit) must call emit(vertex, key, id) for the same
// sequence each time it is called.
template <class Visit>
Buckets fill_buckets(std::size_t vertex_count, const Visit& visit) {
    Buckets buckets;
    buckets.start.assign(vertex_count + 1, 0);
    visit([&](std::uint32_t vertex, std::uint64_t, std::uint32_t) { ++buckets.start[vertex + 1]; });
    for (std::size_t v = 0; v < vertex_count; ++v) buckets.start[v + 1] += buckets.start[v];
    buckets.entries.resize(buckets.start[vertex_count]);
    std::vector<std::size_t> next(buckets.start.begin(), buckets.start.end() - 1);
    visit([&](std::uint32_t vertex, std::uint64_t key, std::uint32_t id) {
        buckets.entries[next[vertex]++] = {key, id};
    });
    for (std::size_t v = 0; v < vertex_count; ++v) {
        std::sort(buckets.entries.begin() + static_cast<std::ptrdiff_t>(buckets.start[v]),
                  buckets.entries.begin() + static_cast<std::ptrdiff_t>(buckets.start[v + 1]));
    }
    return buckets;
}

// The vertices of a facet, counter-clockwise seen from outside the cell.
inline std::array<std::uint32_t, 3> facet_of(const Cell& cell, std::size_t facet) {
    const auto& f = facet_vertices[facet];
    return {cell[static_cast<std::size_t>(f[0])], cell[static_cast<std::size_t>(f[1])],
            cell[static_cast<std::size_t>(f[2])]};
}

}  // namespace anatomesh
