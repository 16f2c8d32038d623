// star_components, worth_at: cells at a vertex, in parts that facets join.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// The components of those cells at the vertex that `is` accepts. Uses the context's star. O(cells there,
// squared).
template <class Is>
std::vector<std::vector<std::uint32_t>> star_components(EditContext& edit, std::uint32_t vertex,
                                                        const Is& is) {
    edit.mesh.star(vertex, edit.star);
    std::vector<std::uint32_t> left = edit.star;
    std::erase_if(left, [&](std::uint32_t c) { return !is(c); });
    std::vector<std::vector<std::uint32_t>> parts;
    while (!left.empty()) {
        std::vector<std::uint32_t> part{left.back()};
        left.pop_back();
        for (std::size_t n = 0; n < part.size(); ++n) {
            for (int i = 0; i < 4; ++i) {
                const auto next = std::find(left.begin(), left.end(), edit.mesh.neighbor(part[n], i));
                if (next == left.end()) continue;
                part.push_back(*next);
                left.erase(next);
            }
        }
        parts.push_back(std::move(part));
    }
    return parts;
}

// How much a component of the star is worth: the number of fixed edges there, then its size.
inline std::array<std::size_t, 2> worth_at(const EditContext& edit, std::uint32_t vertex,
                                           const std::vector<std::uint32_t>& cells) {
    std::size_t fixed = 0;
    for (const std::uint32_t c : cells) {
        const Cell& cell = edit.mesh.cell(c);
        fixed += static_cast<std::size_t>(std::count_if(cell.begin(), cell.end(), [&](std::uint32_t x) {
            return edit.constraints.fixed_edge(vertex, x);
        }));
    }
    return {fixed, cells.size()};
}

// The component of the greatest worth.
inline auto worthiest_at(const EditContext& edit, std::uint32_t vertex,
                         const std::vector<std::vector<std::uint32_t>>& parts) {
    return std::max_element(parts.begin(), parts.end(), [&](const auto& x, const auto& y) {
        return worth_at(edit, vertex, x) < worth_at(edit, vertex, y);
    });
}

}  // namespace anatomesh
