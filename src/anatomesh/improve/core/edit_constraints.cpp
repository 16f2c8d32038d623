#include "anatomesh/improve/core/edit_constraints.h"

#include <algorithm>
#include <cassert>

namespace anatomesh {

namespace {

VertexPair sorted(std::uint32_t a, std::uint32_t b) {
    return {std::min(a, b), std::max(a, b)};
}

bool has_edge(const Cell& cell, VertexPair edge) {
    return std::find(cell.begin(), cell.end(), edge[0]) != cell.end() &&
           std::find(cell.begin(), cell.end(), edge[1]) != cell.end();
}

}  // namespace

EditConstraints::EditConstraints(std::vector<std::uint8_t>& fixed, std::span<const VertexPair> fixed_edges)
    : fixed_(fixed), fixed_edges_(fixed_edges) {
    assert(std::is_sorted(fixed_edges.begin(), fixed_edges.end()));
}

bool EditConstraints::fixed_edge(std::uint32_t a, std::uint32_t b) const {
    if (!fixed(a) || !fixed(b)) return false;
    const VertexPair edge = sorted(a, b);
    return std::binary_search(fixed_edges_.begin(), fixed_edges_.end(), edge) ||
           std::binary_search(split_edges_.begin(), split_edges_.end(), edge);
}

void EditConstraints::fix_edge(std::uint32_t a, std::uint32_t b) {
    const VertexPair edge = sorted(a, b);
    split_edges_.insert(std::upper_bound(split_edges_.begin(), split_edges_.end(), edge), edge);
}

void EditConstraints::unfix_edge(std::uint32_t a, std::uint32_t b) {
    const VertexPair edge = sorted(a, b);
    const auto at = std::lower_bound(split_edges_.begin(), split_edges_.end(), edge);
    if (at != split_edges_.end() && *at == edge) split_edges_.erase(at);
}

void EditConstraints::keep_edge(std::uint32_t a, std::uint32_t b) {
    const VertexPair edge = sorted(a, b);
    const auto at = std::lower_bound(kept_edges_.begin(), kept_edges_.end(), edge);
    if (at == kept_edges_.end() || *at != edge) kept_edges_.insert(at, edge);
}

void EditConstraints::release_edge(std::uint32_t a, std::uint32_t b) {
    std::erase(kept_edges_, sorted(a, b));
}

bool EditConstraints::keeps_edge(std::uint32_t a, std::uint32_t b) const {
    return std::binary_search(kept_edges_.begin(), kept_edges_.end(), sorted(a, b));
}

bool EditConstraints::loses_kept_edge(const Cell& removed, std::span<const Cell> added) const {
    return std::any_of(cell_edges.begin(), cell_edges.end(), [&](const auto& e) {
        const std::uint32_t a = removed[e[0]], b = removed[e[1]];
        return fixed(a) && fixed(b) && keeps_edge(a, b) &&
               std::none_of(added.begin(), added.end(), [&](const Cell& cell) {
                   return has_edge(cell, {a, b});
               });
    });
}

std::uint32_t SliceVertices::slice_of(std::uint32_t v, std::span<const std::uint32_t> drawn) const {
    if (v < drawn.size()) return drawn[v];
    const auto found = std::lower_bound(added_.begin(), added_.end(), VertexPair{v, 0});
    return found != added_.end() && (*found)[0] == v ? (*found)[1] : no_slice;
}

}  // namespace anatomesh
