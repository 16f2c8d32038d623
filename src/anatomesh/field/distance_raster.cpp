#include "anatomesh/field/distance_raster.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

namespace anatomesh {

namespace {

// The half-plane of the points q with dot(q - at, normal) >= 0, made ready to be cut with the rows of a grid.
// Requires: a unit normal.
class HalfPlane {
  public:
    HalfPlane(Vec2 at, Vec2 normal, const PixelGrid& grid) : at_y_(at.y), normal_y_(normal.y) {
        // A line this close to the rows' direction leaves them by less than rounding within any grid.
        if (std::abs(normal.x) < 1e-15) return;
        slope_ = -normal.y / normal.x / grid.step.x;
        column_ = (at.x - grid.low.x) / grid.step.x;
        side_ = normal.x > 0 ? 1 : -1;
    }

    // Narrows the columns [low, high] to those of the row at `y` that lie in the half-plane.
    void cut(double y, double& low, double& high) const {
        if (side_ == 0) {
            if (normal_y_ * (y - at_y_) < 0) high = low - 1e9;
            return;
        }
        const double column = column_ + slope_ * (y - at_y_);
        if (side_ > 0)
            low = std::max(low, column);
        else
            high = std::min(high, column);
    }

  private:
    double at_y_, normal_y_, slope_ = 0, column_ = 0;
    int side_ = 0;
};

class Raster {
  public:
    explicit Raster(const PixelGrid& grid)
        : grid_(grid),
          squared_(static_cast<std::size_t>(grid.nx) * grid.ny, std::numeric_limits<double>::infinity()) {}

    // The strip of the points whose nearest point on the edge's line lies on the edge.
    void add_edge(const Edge2& edge) {
        const Vec2 along = edge.b - edge.a, unit = (1 / length(along)) * along;
        const HalfPlane after(edge.a, unit, grid_), before(edge.b, -1.0 * unit, grid_);
        const double step = -unit.y * grid_.step.x;
        each_row(after, before, slack, [&](double* row, double y, std::uint32_t first, std::uint32_t last) {
            const double start = unit.x * (y - edge.a.y) - unit.y * (grid_.low.x - edge.a.x);
            for (std::uint32_t i = first; i < last; ++i) {
                const double across = start + i * step;
                row[i] = std::min(row[i], across * across);
            }
        });
    }

    // The wedge of the points beyond the end of the edge that comes in and before the start of the one that
    // goes out. A pixel more on both sides does no harm and leaves no gap to the strips.
    void add_vertex(Vec2 vertex, Vec2 in, Vec2 out) {
        const HalfPlane beyond(vertex, (1 / length(in)) * in, grid_),
            before(vertex, (-1 / length(out)) * out, grid_);
        each_row(beyond, before, 1, [&](double* row, double y, std::uint32_t first, std::uint32_t last) {
            const double up = (y - vertex.y) * (y - vertex.y);
            for (std::uint32_t i = first; i < last; ++i) {
                const double right = grid_.low.x + i * grid_.step.x - vertex.x;
                row[i] = std::min(row[i], right * right + up);
            }
        });
    }

    std::vector<double> take() && { return std::move(squared_); }

  private:
    static constexpr double slack = 1e-10;  // columns

    template <class Body>
    void each_row(const HalfPlane& one, const HalfPlane& other, double margin, Body&& body) {
        for (std::uint32_t j = 0; j < grid_.ny; ++j) {
            const double y = grid_.low.y + j * grid_.step.y;
            double low = 0, high = grid_.nx - 1.0;
            one.cut(y, low, high);
            other.cut(y, low, high);
            if (!(low <= high + 2 * margin)) continue;
            low = std::max(low - margin, 0.0);
            high = std::min(high + margin, grid_.nx - 1.0);
            if (low > high) continue;
            // Rounded up and down; conversions are much faster than the library's functions.
            const auto cut_off = static_cast<std::int32_t>(low);
            const std::int32_t first = cut_off + (cut_off < low), last = static_cast<std::int32_t>(high) + 1;
            if (first >= last) continue;
            body(squared_.data() + static_cast<std::size_t>(j) * grid_.nx, y,
                 static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last));
        }
    }

    PixelGrid grid_;
    std::vector<double> squared_;
};

bool before(Vec2 a, Vec2 b) {
    return std::tie(a.x, a.y) < std::tie(b.x, b.y);
}

}  // namespace

std::vector<double> distance_raster(std::span<const Edge2> edges, const PixelGrid& grid) {
    std::vector<Edge2> sorted(edges.begin(), edges.end());
    std::erase_if(sorted, [](const Edge2& edge) { return edge.a == edge.b; });
    assert(!sorted.empty());
    std::sort(sorted.begin(), sorted.end(), [](const Edge2& e, const Edge2& f) {
        return e.a == f.a ? before(e.b, f.b) : before(e.a, f.a);
    });
    Raster raster(grid);
    for (const Edge2& edge : sorted) {
        raster.add_edge(edge);
        // Any edge that goes out of the vertex will do: the wedge with it holds all points whose nearest
        // boundary point is the vertex.
        const auto next = std::lower_bound(sorted.begin(), sorted.end(), edge.b,
                                           [](const Edge2& e, Vec2 point) { return before(e.a, point); });
        assert(next != sorted.end() && next->a == edge.b);
        raster.add_vertex(edge.b, edge.b - edge.a, next->b - next->a);
    }
    std::vector<double> distance = std::move(raster).take();
    for (double& value : distance) value = std::sqrt(value);
    fill_even_odd(edges, grid, [&](std::uint32_t j, std::uint32_t first, std::uint32_t last) {
        double* row = distance.data() + static_cast<std::size_t>(j) * grid.nx;
        for (std::uint32_t i = first; i < last; ++i) row[i] = 0.0 - row[i];
    });
    return distance;
}

}  // namespace anatomesh
