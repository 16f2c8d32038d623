// PointGrid: points in a hashed uniform grid, for "is there a point nearer than r" while points are being added.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Queries with a radius up to the grid's cell size look at 27 cells; larger ones at more, but at no more than there are
// points: where cells are more, the points are looked at one by one. Memory linear in the points, whatever the extent.
// The order of visits depends on the points alone.
class PointGrid {
  public:
    // Requires: cell_size > 0.
    PointGrid(double cell_size, std::size_t expected_points) : inverse_(1.0 / cell_size) {
        std::size_t capacity = 16;
        while (capacity < 2 * expected_points) capacity *= 2;
        heads_.assign(capacity, none);
        points_.reserve(expected_points);
        next_.reserve(expected_points);
    }

    std::size_t size() const { return points_.size(); }
    Vec3 point(std::uint32_t index) const { return points_[index]; }

    void add(Vec3 p) {
        if (points_.size() >= heads_.size()) grow();
        link(static_cast<std::uint32_t>(points_.size()), p);
        points_.push_back(p);
    }

    // Calls visit(index, squared_distance) for every point within radius of p.
    template <class Visit>
    void for_each_within(Vec3 p, double radius, Visit visit) const {
        find_within(p, radius, [&](std::uint32_t index, double squared) {
            visit(index, squared);
            return false;
        });
    }

    bool any_within(Vec3 p, double radius) const {
        return find_within(p, radius, [](std::uint32_t, double) { return true; });
    }

  private:
    // It ends the list of a bucket. [index; 2^32 - 1; D]
    static constexpr std::uint32_t none = 0xFFFFFFFFu;
    struct Key {
        std::int64_t i, j, k;
        friend bool operator==(const Key&, const Key&) = default;
    };

    static std::int64_t whole_below(double x) {
        const auto whole = static_cast<std::int64_t>(x);
        return whole - (static_cast<double>(whole) > x);
    }
    Key key(Vec3 p) const {
        return {whole_below(p.x * inverse_), whole_below(p.y * inverse_), whole_below(p.z * inverse_)};
    }
    // Cells of a row follow each other.
    std::size_t row(std::int64_t j, std::int64_t k) const {
        std::uint64_t hash = static_cast<std::uint64_t>(j) * 0xBF58476D1CE4E5B9ull;
        hash = (hash ^ (hash >> 31)) + static_cast<std::uint64_t>(k) * 0x94D049BB133111EBull;
        return (hash ^ (hash >> 30)) * 0x9E3779B97F4A7C15ull >> 20;
    }
    std::size_t bucket(std::size_t row, std::int64_t i) const {
        return (row + static_cast<std::uint64_t>(i)) & (heads_.size() - 1);
    }
    // Whether visit() said true, which ends the search.
    template <class Visit>
    bool find_within(Vec3 p, double radius, Visit visit) const {
        const double squared = radius * radius;
        const Key low = key({p.x - radius, p.y - radius, p.z - radius});
        const Key high = key({p.x + radius, p.y + radius, p.z + radius});
        if (more_cells_than_points(low, high)) {
            for (std::uint32_t index = 0; index < points_.size(); ++index) {
                const double distance = squared_length(points_[index] - p);
                if (distance <= squared && visit(index, distance)) return true;
            }
            return false;
        }
        for (std::int64_t k = low.k; k <= high.k; ++k) {
            for (std::int64_t j = low.j; j <= high.j; ++j) {
                const std::size_t cells = row(j, k);
                for (std::int64_t i = low.i; i <= high.i; ++i) {
                    for (std::uint32_t index = heads_[bucket(cells, i)]; index != none;
                         index = next_[index]) {
                        const double distance = squared_length(points_[index] - p);
                        if (distance <= squared && key(points_[index]) == Key{i, j, k} &&
                            visit(index, distance))
                            return true;
                    }
                }
            }
        }
        return false;
    }
    // Queries of the size that the grid is made for never are such.
    bool more_cells_than_points(const Key& low, const Key& high) const {
        const auto along = [](std::int64_t from, std::int64_t to) {
            return static_cast<double>(to - from) + 1;
        };
        const double rows = along(low.j, high.j) * along(low.k, high.k);
        return rows > 9 && rows * along(low.i, high.i) > static_cast<double>(points_.size());
    }
    void link(std::uint32_t index, Vec3 p) {
        const Key at = key(p);
        std::uint32_t& head = heads_[bucket(row(at.j, at.k), at.i)];
        if (index == next_.size()) {
            next_.push_back(head);
        } else {
            next_[index] = head;
        }
        head = index;
    }
    void grow() {
        heads_.assign(heads_.size() * 2, none);
        for (std::uint32_t index = 0; index < points_.size(); ++index) link(index, points_[index]);
    }

    double inverse_;
    std::vector<std::uint32_t> heads_, next_;
    std::vector<Vec3> points_;
};

}  // namespace anatomesh
