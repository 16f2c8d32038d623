// Even-odd filling of rows of a grid from directed edges: shared by the bit volume and the distance map.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// An edge of a drawn region in the coordinates of its plane. Directed: the region lies on its left.
struct Edge2 {
    Vec2 a, b;
    friend bool operator==(const Edge2&, const Edge2&) = default;
};

// Points (low.x + i step.x, low.y + j step.y), 0 <= i < nx, 0 <= j < ny.
struct PixelGrid {
    Vec2 low, step{1, 1};
    std::uint32_t nx = 0, ny = 0;
};

// Calls fill(j, first, last) for every run first <= i < last of grid points inside the even-odd region of
// `edges`, rows and runs in rising order. A point on the boundary counts by the half-open rule: inside where
// the region begins in +x direction, outside where it ends. Complexity: O(edges x rows they span, sorted by
// row).
template <class Fill>
void fill_even_odd(std::span<const Edge2> edges, const PixelGrid& grid, Fill&& fill) {
    std::vector<std::uint32_t> row_begin(grid.ny + 1, 0);
    const auto row_of = [&](double y) {  // the first row at or above y
        const double row = std::ceil((y - grid.low.y) / grid.step.y);
        return static_cast<std::uint32_t>(std::clamp(row, 0.0, static_cast<double>(grid.ny)));
    };
    const auto each_crossing = [&](auto&& body) {
        for (const Edge2& edge : edges) {
            const Vec2 lower = edge.a.y <= edge.b.y ? edge.a : edge.b,
                       upper = edge.a.y <= edge.b.y ? edge.b : edge.a;
            const std::uint32_t first = row_of(lower.y), last = row_of(upper.y);
            for (std::uint32_t row = first; row < last; ++row) {
                const double y = grid.low.y + row * grid.step.y;
                const double share = std::clamp((y - lower.y) / (upper.y - lower.y), 0.0, 1.0);
                body(row, lower.x + share * (upper.x - lower.x));
            }
        }
    };
    each_crossing([&](std::uint32_t row, double) { ++row_begin[row + 1]; });
    for (std::uint32_t row = 0; row < grid.ny; ++row) row_begin[row + 1] += row_begin[row];
    std::vector<double> crossings(row_begin[grid.ny]);
    std::vector<std::uint32_t> next(row_begin.begin(), row_begin.end() - 1);
    each_crossing([&](std::uint32_t row, double x) { crossings[next[row]++] = x; });

    const auto column_of = [&](double x) {  // the first column at or right of x
        const double column = std::ceil((x - grid.low.x) / grid.step.x);
        return static_cast<std::uint32_t>(std::clamp(column, 0.0, static_cast<double>(grid.nx)));
    };
    for (std::uint32_t row = 0; row < grid.ny; ++row) {
        std::sort(crossings.begin() + row_begin[row], crossings.begin() + row_begin[row + 1]);
        for (std::uint32_t i = row_begin[row]; i + 1 < row_begin[row + 1]; i += 2) {
            const std::uint32_t first = column_of(crossings[i]), last = column_of(crossings[i + 1]);
            if (first < last) fill(row, first, last);
        }
    }
}

}  // namespace anatomesh
