// The mean of weighted motions round the nodes of a lattice in the plane of the slices.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include "anatomesh/base/instruction_sets.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

// A radius of averaging is four steps of a lattice at most, so it covers no more columns. [columns; 12; D]
inline constexpr std::uint32_t most_columns = 12;

// Nodes at multiples of `step` that cover a box. `most` bounds their number.
struct MotionLattice {
    Vec2 low;
    double step = 1;
    std::uint32_t nx = 0, ny = 0;

    MotionLattice(const Box2& box, double wanted, double most) {
        const Vec2 size = box.high - box.low;
        step = std::max({wanted, std::sqrt(size.x * size.y / most), std::max(size.x, size.y) / most});
        low = {std::floor(box.low.x / step) * step, std::floor(box.low.y / step) * step};
        nx = static_cast<std::uint32_t>((box.high.x - low.x) / step) + 2;
        ny = static_cast<std::uint32_t>((box.high.y - low.y) / step) + 2;
    }
    Vec2 node(std::uint32_t i, std::uint32_t j) const { return low + step * Vec2{double(i), double(j)}; }
    std::size_t count() const { return static_cast<std::size_t>(nx) * ny; }
};

// The mean of weighted vectors within a radius of every node, and of `at_rest` of no motion.
class MotionAverage {
  public:
    MotionAverage(const MotionLattice& lattice, double radius, double at_rest)
        : lattice_(lattice),
          radius_(radius),
          at_rest_(at_rest),
          moves_x_(lattice.count()),
          moves_y_(lattice.count()),
          weights_(lattice.count()) {}

    ANATOMESH_CLONES void add(Vec2 middle, Vec2 move, double weight) {
        const auto index = [&](double x, double low, std::uint32_t n) {
            return static_cast<std::uint32_t>(std::clamp((x - low) / lattice_.step, 0.0, n - 1.0));
        };
        const std::uint32_t i0 = index(middle.x - radius_, lattice_.low.x, lattice_.nx),
                            i1 = index(middle.x + radius_, lattice_.low.x, lattice_.nx),
                            j0 = index(middle.y - radius_, lattice_.low.y, lattice_.ny),
                            j1 = index(middle.y + radius_, lattice_.low.y, lattice_.ny);
        const double inverse = 1 / (radius_ * radius_);
        std::array<double, most_columns> across;  // squared distances of the columns
        assert(i1 - i0 < most_columns);
        for (std::uint32_t i = i0; i <= i1; ++i) {
            const double x = lattice_.node(i, j0).x - middle.x;
            across[i - i0] = x * x;
        }
        for (std::uint32_t j = j0; j <= j1; ++j) {
            const double y = lattice_.node(i0, j).y - middle.y;
            const std::size_t row = static_cast<std::size_t>(j) * lattice_.nx + i0;
            std::array<double, most_columns> parts;
            for (std::uint32_t i = 0; i <= i1 - i0; ++i) {
                const double share = std::max(0.0, 1 - (across[i] + y * y) * inverse);
                parts[i] = weight * share * share;
            }
            add_row(&moves_x_[row], parts, i1 - i0 + 1, move.x);
            add_row(&moves_y_[row], parts, i1 - i0 + 1, move.y);
            add_row(&weights_[row], parts, i1 - i0 + 1, 1);
        }
    }

    // Adds a motion from `start` at the middle of its way; a long one all along its way, so that it is found
    // there.
    void add_along(Vec2 start, Vec2 move, double sign, double weight) {
        const auto halves = static_cast<int>(std::floor(length(move) / radius_));
        for (int k = -halves; k <= halves; ++k) {
            const double share = halves == 0 ? 0.5 : 0.5 + 0.5 * k / halves;
            add(start + share * move, sign * move, weight / (2 * halves + 1));
        }
    }

    Vec2 mean(std::uint32_t i, std::uint32_t j) const {
        const std::size_t n = static_cast<std::size_t>(j) * lattice_.nx + i;
        return (1 / (weights_[n] + at_rest_)) * Vec2{moves_x_[n], moves_y_[n]};
    }

    // How much of a mean comes from boundaries: 0 away from them.
    double moved_share(std::uint32_t i, std::uint32_t j) const {
        const double weight = weights_[static_cast<std::size_t>(j) * lattice_.nx + i];
        return weight / (weight + at_rest_);
    }

    Vec2 at(Vec2 q) const {
        const double x = (q.x - lattice_.low.x) / lattice_.step, y = (q.y - lattice_.low.y) / lattice_.step;
        if (!(x >= 0 && y >= 0 && x < lattice_.nx - 1.0 && y < lattice_.ny - 1.0)) return {};
        const auto i = static_cast<std::uint32_t>(x), j = static_cast<std::uint32_t>(y);
        const double u = x - i, v = y - j;
        return (1 - v) * ((1 - u) * mean(i, j) + u * mean(i + 1, j)) +
               v * ((1 - u) * mean(i, j + 1) + u * mean(i + 1, j + 1));
    }

    const MotionLattice& lattice() const { return lattice_; }

  private:
    static void add_row(double* sums, const std::array<double, most_columns>& parts, std::uint32_t count,
                        double factor) {
        for (std::uint32_t i = 0; i < count; ++i) sums[i] += parts[i] * factor;
    }
    MotionLattice lattice_;
    double radius_, at_rest_;
    std::vector<double> moves_x_, moves_y_, weights_;  // sums of weighted moves, and of the weights; by node
};

}  // namespace anatomesh
