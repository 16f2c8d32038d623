#include "anatomesh/live/preview/node_lattice.h"

#include <cassert>
#include <cmath>
#include <string>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// So many values are a job of their own. [values; >= 1; B]
constexpr std::size_t values_in_a_job = 128;
// Cells are counted from the origin in 32 bits. [cells; 1e6 to 2e9; D]
constexpr double farthest_cell = 1e9;

std::array<double, 3> as_array(Vec3 p) {
    return {p.x, p.y, p.z};
}

}  // namespace

Cell cell_at(Vec3 p, double step) {
    const auto whole = [&](double x) { return static_cast<std::int32_t>(std::floor(x / step)); };
    return {whole(p.x), whole(p.y), whole(p.z)};
}

Status NodeLattice::check_size(const Box3& box, double step, std::uint64_t max_cells) {
    assert(step > 0 && !box.empty());
    const std::array<double, 3> low = as_array(box.low), high = as_array(box.high);
    double cells = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double first = std::floor(low[axis] / step) - 1, last = std::floor(high[axis] / step) + 1;
        cells *= last - first + 1;
        if (cells <= static_cast<double>(max_cells) && std::abs(first) <= farthest_cell &&
            std::abs(last) <= farthest_cell)
            continue;
        return Error{ErrorKind::limit,
                     "E-LIV-201",
                     "a preview with a step of " + brief(step) +
                         " mm would have more cells than the limit of " + std::to_string(max_cells),
                     {},
                     "take a larger step"};
    }
    return Nothing{};
}

Result<NodeLattice> NodeLattice::over(const Box3& box, double step, std::uint64_t max_cells) {
    ANATOMESH_CHECK_STATUS(check_size(box, step, max_cells));
    NodeLattice made;
    made.step_ = step;
    const Cell low = cell_at(box.low, step), high = cell_at(box.high, step);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        made.low_[axis] = low[axis] - 1;
        made.size_[axis] = static_cast<std::size_t>(high[axis] - low[axis]) + 3;
    }
    const std::size_t nodes = (made.size_[0] + 1) * (made.size_[1] + 1) * (made.size_[2] + 1);
    made.visited_.assign(made.size_[0] * made.size_[1] * made.size_[2], 0);
    made.asked_.assign(nodes, 0);
    made.values_.resize(nodes);
    return made;
}

std::size_t NodeLattice::cell_index(Cell cell) const {
    const auto at = [&](std::size_t axis) { return static_cast<std::size_t>(cell[axis] - low_[axis]); };
    return (at(2) * size_[1] + at(1)) * size_[0] + at(0);
}

std::size_t NodeLattice::node_index(Cell cell, unsigned corner) const {
    const auto at = [&](std::size_t axis) {
        return static_cast<std::size_t>(cell[axis] - low_[axis]) + (corner >> axis & 1u);
    };
    return (at(2) * (size_[1] + 1) + at(1)) * (size_[0] + 1) + at(0);
}

Vec3 NodeLattice::node_at(std::size_t node) const {
    const std::size_t nx = size_[0] + 1, ny = size_[1] + 1;
    const auto at = [&](std::size_t axis, std::size_t n) {
        return step_ * static_cast<double>(low_[axis] + static_cast<std::int64_t>(n));
    };
    return {at(0, node % nx), at(1, node / nx % ny), at(2, node / nx / ny)};
}

bool NodeLattice::visit(Cell cell) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t at = std::int64_t{cell[axis]} - low_[axis];
        if (at < 0 || at >= static_cast<std::int64_t>(size_[axis])) return false;
    }
    std::uint8_t& visited = visited_[cell_index(cell)];
    const bool is_new = visited == 0;
    visited = 1;
    return is_new;
}

void NodeLattice::ask(std::span<const Cell> cells, const StructureField& field, std::uint32_t structure,
                      int threads) {
    std::vector<std::size_t> nodes;
    for (const Cell& cell : cells) {
        for (unsigned corner = 0; corner < 8; ++corner) {
            const std::size_t node = node_index(cell, corner);
            if (asked_[node] != 0) continue;
            asked_[node] = 1;
            nodes.push_back(node);
        }
    }
    parallel_for(nodes.size(), values_in_a_job, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n)
            values_[nodes[n]] = field.value(structure, node_at(nodes[n]));
    });
    asked_count_ += nodes.size();
}

unsigned NodeLattice::inside_corners(Cell cell) const {
    unsigned inside = 0;
    for (unsigned corner = 0; corner < 8; ++corner)
        inside |= values_[node_index(cell, corner)] < 0 ? 1u << corner : 0u;
    return inside;
}

NodeLattice::Vertex NodeLattice::vertex(Cell cell, const StructureField& field, std::uint32_t structure) {
    ask(std::span(&cell, 1), field, structure, 1);
    std::array<double, 8> value;
    for (unsigned corner = 0; corner < 8; ++corner) value[corner] = values_[node_index(cell, corner)];
    const auto place = [](unsigned corner) {
        return Vec3{1.0 * (corner & 1u), 1.0 * (corner >> 1 & 1u), 1.0 * (corner >> 2)};
    };
    Vec3 sum, rise;
    int crossings = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            const unsigned next = corner | 1u << axis;
            if (next == corner) continue;
            const double low = value[corner], high = value[next];
            (axis == 0 ? rise.x : axis == 1 ? rise.y : rise.z) += high - low;
            if ((low < 0) == (high < 0)) continue;
            sum = sum + place(corner) + (low / (low - high)) * (place(next) - place(corner));
            ++crossings;
        }
    }
    assert(crossings > 0);
    const Vec3 corner{step_ * cell[0], step_ * cell[1], step_ * cell[2]};
    const double steep = length(rise);
    return {corner + (step_ / crossings) * sum, steep > 0 ? (1 / steep) * rise : Vec3{0, 0, 1}};
}

}  // namespace anatomesh
