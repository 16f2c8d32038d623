#include "anatomesh/field/planes/plane_trace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/overlay/boundary_loops.h"

namespace anatomesh {

namespace {

// A boundary point is found by so many halvings of a step, to a thousandth of it. [halvings; >= 1; D]
constexpr int halvings = 10;

class Lattice {
  public:
    Lattice(const std::function<double(Vec2)>& value, const Box2& box, double step, int threads)
        : value_(value), low_(box.low) {
        const Vec2 size = box.high - box.low;
        nx_ = static_cast<std::size_t>(std::ceil(size.x / step)) + 1;
        ny_ = static_cast<std::size_t>(std::ceil(size.y / step)) + 1;
        step_ = {size.x / static_cast<double>(nx_ - 1), size.y / static_cast<double>(ny_ - 1)};
        inside_.resize(nx_ * ny_);
        parallel_for(ny_, 8, threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin * nx_; n < end * nx_; ++n) inside_[n] = !is_rim(n) && value(at(n)) < 0;
        });
    }

    std::vector<Edge2> boundary() const {
        std::vector<Edge2> edges;
        for (std::size_t j = 0; j + 1 < ny_; ++j) {
            for (std::size_t i = 0; i + 1 < nx_; ++i) {
                const std::size_t n = j * nx_ + i;
                add({n, n + 1, n + nx_ + 1}, edges);
                add({n, n + nx_ + 1, n + nx_}, edges);
            }
        }
        return edges;
    }

  private:
    Vec2 at(std::size_t n) const {
        return {low_.x + static_cast<double>(n % nx_) * step_.x,
                low_.y + static_cast<double>(n / nx_) * step_.y};
    }
    bool is_inside(std::size_t n) const { return inside_[n] != 0; }

    // By halves: values may jump. The same bits from both sides.
    Vec2 crossing(std::size_t m, std::size_t n) const {
        if (m > n) std::swap(m, n);
        const Vec2 from = at(m), way = at(n) - at(m);
        double low = 0, high = 1;
        if (!is_rim(m) && !is_rim(n)) {
            for (int halving = 0; halving < halvings; ++halving) {
                const double middle = 0.5 * (low + high);
                ((value_(from + middle * way) < 0) == is_inside(m) ? low : high) = middle;
            }
        }
        return from + 0.5 * (low + high) * way;
    }
    bool is_rim(std::size_t n) const {
        const std::size_t i = n % nx_, j = n / nx_;
        return i == 0 || j == 0 || i + 1 == nx_ || j + 1 == ny_;
    }

    void add(std::array<std::size_t, 3> corners, std::vector<Edge2>& edges) const {
        const bool a = is_inside(corners[0]), b = is_inside(corners[1]), c = is_inside(corners[2]);
        if (a == b && b == c) return;
        // The corner that is alone comes first.
        const auto first = corners.begin() + (b != a && b != c ? 1 : c != a && c != b ? 2 : 0);
        std::rotate(corners.begin(), first, corners.end());
        Edge2 edge{crossing(corners[0], corners[1]), crossing(corners[0], corners[2])};
        if (!is_inside(corners[0])) std::swap(edge.a, edge.b);
        edges.push_back(edge);
    }

    const std::function<double(Vec2)>& value_;
    Vec2 low_, step_;
    std::size_t nx_ = 0, ny_ = 0;
    std::vector<std::uint8_t> inside_;
};

}  // namespace

std::vector<Edge2> trace_in_plane(const std::function<double(Vec2)>& value, const Box2& box, double step,
                                  int threads) {
    return Lattice(value, box, step, threads).boundary();
}

std::vector<std::vector<Vec3>> loops_in_plane(const std::vector<Edge2>& edges, const Plane& plane) {
    std::map<std::pair<double, double>, std::uint32_t> index;
    std::vector<Vec2> at;
    const auto number = [&](Vec2 p) {
        const auto [entry, is_new] = index.try_emplace({p.x, p.y}, static_cast<std::uint32_t>(at.size()));
        if (is_new) at.push_back(p);
        return entry->second;
    };
    std::vector<BoundaryEdge> graph;
    for (const Edge2& edge : edges) {
        const std::uint32_t from = number(edge.a), to = number(edge.b);
        if (from != to) graph.push_back({from, to});
    }
    std::vector<std::vector<Vec3>> loops;
    for (const std::vector<std::uint32_t>& loop : boundary_loops(at, graph)) {
        std::vector<Vec3>& points = loops.emplace_back();
        for (const std::uint32_t e : loop) points.push_back(plane.to_space(at[graph[e].from]));
        const auto first = std::min_element(points.begin(), points.end(), [](const Vec3& a, const Vec3& b) {
            return lexicographic_less(a, b);
        });
        std::rotate(points.begin(), first, points.end());
    }
    return loops;
}

}  // namespace anatomesh
