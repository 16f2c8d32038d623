// For tests and benchmarks: the contours in which a plane cuts a solid given by a formula.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <vector>

#include "anatomesh/geom/plane.h"

namespace anatomesh::random_solids {

// How the contours are drawn: vertices where the boundary crosses a square grid, on the boundary within
// rounding; those much nearer to each other than the grid left out; of the others all, or half at random.
struct Sampling {
    double grid = 1;
    bool sparse = false;  // every other vertex, at random
    bool alike = true;    // where structures share a wall, they share its vertices
};

// The closed polygons in which a plane cuts a solid, within the ball of the radius about the origin. A solid
// has distance(p): negative inside, continuous.
class SectionTracer {
  public:
    SectionTracer(const Plane& plane, double radius, const Sampling& sampling)
        : plane_(plane), grid_(sampling.grid), sampling_(sampling) {
        const Vec2 middle = plane.to_plane({});
        count_ = static_cast<int>(2 * (radius + 2 * grid_) / grid_) + 2;
        low_ = middle - (radius + 2 * grid_) * Vec2{1, 1};
    }

    // `hand` decides which vertices are left out, where not all hands draw alike.
    template <class Solid>
    std::vector<std::vector<Vec3>> trace(const Solid& solid, std::uint32_t hand) {
        hand_ = sampling_.alike ? 0 : hand;
        values_.resize(static_cast<std::size_t>(count_) * count_);
        for (int j = 0; j < count_; ++j) {
            for (int i = 0; i < count_; ++i) values_[index(i, j)] = solid.distance(point(i, j));
        }
        link(solid);
        std::vector<std::vector<Vec3>> loops;
        while (!next_.empty()) {
            std::vector<Vec3> loop;
            for (auto at = next_.begin(); at != next_.end(); at = next_.find(loop_next_)) {
                loop.push_back(crossing(solid, at->first));
                loop_next_ = at->second;
                next_.erase(at);
            }
            thin(loop);
            if (loop.size() > 3) loops.push_back(std::move(loop));
        }
        return loops;
    }

  private:
    // An edge of the grid: its low node, and whether it runs along v.
    using Edge = std::array<int, 3>;

    std::size_t index(int i, int j) const { return static_cast<std::size_t>(j) * count_ + i; }
    Vec3 point(double i, double j) const { return plane_.to_space(low_ + grid_ * Vec2{i, j}); }
    bool inside(int i, int j) const { return values_[index(i, j)] < 0; }

    // Which edge follows which on the boundary, the inside on the left (marching squares).
    template <class Solid>
    void link(const Solid& solid) {
        next_.clear();
        for (int j = 0; j + 1 < count_; ++j) {
            for (int i = 0; i + 1 < count_; ++i) {
                const std::array<bool, 4> in{inside(i, j), inside(i + 1, j), inside(i + 1, j + 1),
                                             inside(i, j + 1)};
                const std::array<Edge, 4> edges{Edge{i, j, 0}, {i + 1, j, 1}, {i, j + 1, 0}, {i, j, 1}};
                const bool saddle = in[0] != in[1] && in[0] == in[2] && in[1] == in[3];
                const bool joined = saddle && solid.distance(point(i + 0.5, j + 0.5)) < 0;
                // A piece of boundary runs from where the way round the square leaves the inside to where it
                // enters it.
                for (int k = 0; k < 4; ++k) {
                    if (!in[k] || in[(k + 1) % 4]) continue;
                    int other = joined ? k + 1 : k + 3;
                    while (in[other % 4] || !in[(other + 1) % 4]) other += joined ? 1 : 3;
                    next_[edges[k]] = edges[other % 4];
                }
            }
        }
    }

    template <class Solid>
    Vec3 crossing(const Solid& solid, const Edge& edge) const {
        double low = 0, high = 1;
        const bool start = inside(edge[0], edge[1]);
        const auto at = [&](double t) {
            return point(edge[0] + (edge[2] ? 0 : t), edge[1] + (edge[2] ? t : 0));
        };
        for (int step = 0; step < 50; ++step) {
            const double half = 0.5 * (low + high);
            ((solid.distance(at(half)) < 0) == start ? low : high) = half;
        }
        return at(high);
    }

    // A number that depends on the vertex alone.
    std::uint64_t lot(Vec3 p) const {
        std::uint64_t h = 0x9E3779B97F4A7C15u + hand_;
        for (const double v : {p.x, p.y, p.z}) {
            h = (h ^ std::bit_cast<std::uint64_t>(v)) * 0xBF58476D1CE4E5B9u;
            h ^= h >> 29;
        }
        return h;
    }

    void thin(std::vector<Vec3>& loop) const {
        std::vector<Vec3> kept;
        const std::size_t n = loop.size();
        for (std::size_t k = 0; k < n; ++k) {
            const std::uint64_t own = lot(loop[k]);
            bool stays = !sampling_.sparse || own % 2 == 0;
            for (const std::size_t other : {(k + 1) % n, (k + n - 1) % n}) {
                const double apart = length(loop[other] - loop[k]);
                if (other != k && apart < 0.35 * grid_ && lot(loop[other]) > own) stays = false;
            }
            if (stays) kept.push_back(loop[k]);
        }
        loop = std::move(kept);
    }

    Plane plane_;
    double grid_;
    Sampling sampling_;
    std::uint32_t hand_ = 0;
    int count_ = 0;
    Vec2 low_;
    std::vector<double> values_;
    std::map<Edge, Edge> next_;
    Edge loop_next_{};
};

}  // namespace anatomesh::random_solids
