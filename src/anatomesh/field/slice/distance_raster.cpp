#include "anatomesh/field/slice/distance_raster.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

#include "anatomesh/geom/box.h"

namespace anatomesh {

namespace {

// So many pixels along each axis are a cell of the coarse grid of upper bounds. [pixels; >= 2; B]
constexpr std::uint32_t cell_pixels = 8;
// Neighbouring pieces of one edge or vertex overlap by this, so that rounding leaves no pixel between them.
// [pixels; 0 to 0.01; D rounding of doubles]
constexpr double shared_slack = 1e-6;
// An edge's strip passes the edge's ends by this, so that rounding loses no pixel beside a vertex.
// [pixels; 0 to shared_slack; D rounding of doubles]
constexpr double end_slack = 1e-10;
// A cut must take so much off a wedge's corner: smaller ones save no pixel. [pixels; > 0; B]
constexpr double worth_a_cut = 0.5;
// A wedge is cut no more often; what it keeps too much costs time alone. [cuts; >= 1; B]
constexpr int most_cuts = 24;
constexpr double infinity = std::numeric_limits<double>::infinity();

Vec2 unit_of(Vec2 v) {
    return (1 / length(v)) * v;
}

bool before(Vec2 a, Vec2 b) {
    return std::tie(a.x, a.y) < std::tie(b.x, b.y);
}

// An upper bound of the distance to the boundary anywhere: the distance to a point of the boundary known to
// be near. Points of the boundary a few pixels apart are spread over a coarse grid, each cell taking over the
// best of its neighbours'.
class UpperBound {
  public:
    UpperBound(std::span<const Edge2> edges, const PixelGrid& grid)
        : low_(grid.low),
          step_(cell_pixels * grid.step),
          inverse_step_{1 / step_.x, 1 / step_.y},
          nx_((grid.nx - 1) / cell_pixels + 1),
          ny_((grid.ny - 1) / cell_pixels + 1),
          samples_(std::size_t{nx_} * ny_, Vec2{infinity, 0}) {
        const double apart = std::min(step_.x, step_.y);
        for (const Edge2& edge : edges) {
            // Far beyond the grid a long edge needs no more of them than the grid has cells along it.
            const double pieces = std::min(std::ceil(length(edge.b - edge.a) / apart), 4.0 * (nx_ + ny_));
            for (double i = 0; i < pieces; ++i) {
                const Vec2 sample = edge.a + (i / pieces) * (edge.b - edge.a);
                offer(column(sample.x), row(sample.y), sample);
            }
        }
        spread();
    }

    Vec2 known_near(Vec2 q) const { return samples_[row(q.y) * nx_ + column(q.x)]; }
    double distance(Vec2 q) const { return length(q - known_near(q)); }

  private:
    static std::size_t index(double cell, std::uint32_t count) {
        return static_cast<std::size_t>(std::clamp(cell, 0.0, count - 1.0));
    }
    std::size_t column(double x) const { return index((x - low_.x) * inverse_step_.x, nx_); }
    std::size_t row(double y) const { return index((y - low_.y) * inverse_step_.y, ny_); }

    void offer(std::size_t i, std::size_t j, Vec2 sample) {
        const Vec2 centre =
            low_ + Vec2{(static_cast<double>(i) + 0.5) * step_.x, (static_cast<double>(j) + 0.5) * step_.y};
        Vec2& held = samples_[j * nx_ + i];
        if (squared_length(sample - centre) < squared_length(held - centre)) held = sample;
    }
    void take_from_row(std::size_t j, std::size_t other) {
        for (std::size_t i = 0; i < nx_; ++i) {
            if (i > 0) offer(i, j, samples_[other * nx_ + i - 1]);
            offer(i, j, samples_[other * nx_ + i]);
            if (i + 1 < nx_) offer(i, j, samples_[other * nx_ + i + 1]);
        }
        for (std::size_t i = 1; i < nx_; ++i) offer(i, j, samples_[j * nx_ + i - 1]);
        for (std::size_t i = nx_ - 1; i-- > 0;) offer(i, j, samples_[j * nx_ + i + 1]);
    }
    void spread() {
        for (std::size_t j = 0; j < ny_; ++j) take_from_row(j, j > 0 ? j - 1 : 0);
        for (std::size_t j = ny_; j-- > 0;) take_from_row(j, j + 1 < ny_ ? j + 1 : j);
    }

    Vec2 low_, step_, inverse_step_;
    std::uint32_t nx_, ny_;
    std::vector<Vec2> samples_;
};

// The grid points of a convex piece of the plane, row by row: a box cut by half-planes.
class Piece {
  public:
    Piece(const PixelGrid& grid, const Box2& box) : grid_(grid) {
        low_[0] = {(box.low.x - grid.low.x) / grid.step.x, 0};
        high_[0] = {(box.high.x - grid.low.x) / grid.step.x, 0};
        first_row_ = (box.low.y - grid.low.y) / grid.step.y;
        last_row_ = (box.high.y - grid.low.y) / grid.step.y;
    }

    // Keeps the points q with dot(q - at, normal) >= 0. Requires: a unit normal.
    void cut(Vec2 at, Vec2 normal) {
        const double row = (at.y - grid_.low.y) / grid_.step.y;
        // A line this close to the rows' direction leaves them by less than rounding within any grid.
        if (std::abs(normal.x) < 1e-15) {
            if (normal.y > 0)
                first_row_ = std::max(first_row_, row);
            else
                last_row_ = std::min(last_row_, row);
            return;
        }
        const double slope = -normal.y * grid_.step.y / (normal.x * grid_.step.x);
        const Bound bound{(at.x - grid_.low.x) / grid_.step.x - slope * row, slope};
        if (normal.x > 0)
            low_[++lows_] = bound;
        else
            high_[++highs_] = bound;
    }

    // Calls body(j, first, last) for the points first <= i < last of every row j.
    template <class Body>
    void each_row(Body&& body) const {
        if (!(last_row_ >= 0) || !(first_row_ <= grid_.ny - 1.0)) return;
        const auto from = static_cast<std::uint32_t>(std::ceil(std::max(first_row_, 0.0)));
        const auto to = static_cast<std::uint32_t>(std::min(last_row_, grid_.ny - 1.0));
        const double last_column = grid_.nx - 1.0;
        for (std::uint32_t j = from; j <= to; ++j) {
            double low = 0, high = last_column;
            for (int b = 0; b <= lows_; ++b) low = std::max(low, low_[b].column + low_[b].slope * j);
            for (int b = 0; b <= highs_; ++b) high = std::min(high, high_[b].column + high_[b].slope * j);
            if (!(low <= high)) continue;
            // Rounded up and down; conversions are much faster than the library's functions.
            const auto cut_off = static_cast<std::int32_t>(low);
            const std::int32_t first = cut_off + (cut_off < low), last = static_cast<std::int32_t>(high) + 1;
            if (first < last) body(j, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last));
        }
    }

  private:
    struct Bound {
        double column = 0, slope = 0;  // at row 0, and from row to row
    };
    const PixelGrid& grid_;
    std::array<Bound, 3> low_, high_;
    int lows_ = 0, highs_ = 0;
    double first_row_, last_row_;
};

// A convex polygon, counter-clockwise, that begins as a box and is cut by half-planes. Cuts are rounded by
// some 1e-13 of its size: whoever needs the points on a line moves the line outwards.
class Polygon {
  public:
    void begin(const Box2& box) {
        corners_[0] = box.low;
        corners_[1] = {box.high.x, box.low.y};
        corners_[2] = box.high;
        corners_[3] = {box.low.x, box.high.y};
        count_ = 4;
    }

    std::span<const Vec2> corners() const { return {corners_.data(), static_cast<std::size_t>(count_)}; }

    // Keeps the points q with dot(q - at, normal) >= 0. Requires: at most most_cuts + 2 calls.
    void cut(Vec2 at, Vec2 normal) {
        if (count_ == 0) return;
        int kept = 0;
        Vec2 last = corners_[static_cast<std::size_t>(count_ - 1)];
        double height_of_last = dot(last - at, normal);
        for (const Vec2 corner : corners()) {
            const double height = dot(corner - at, normal);
            // A convex polygon crosses a line twice; rounding may not make it more.
            if ((height < 0) != (height_of_last < 0) && kept < capacity)
                spare_[kept++] = last + (height_of_last / (height_of_last - height)) * (corner - last);
            if (height >= 0 && kept < capacity) spare_[kept++] = corner;
            last = corner;
            height_of_last = height;
        }
        std::copy(spare_.begin(), spare_.begin() + kept, corners_.begin());
        count_ = kept;
    }

  private:
    // A wedge has four corners, and gets one more for each of two sides and of its cuts, and two for
    // rounding. [corners; most_cuts + 8; D]
    static constexpr int capacity = 4 + 2 + most_cuts + 2;
    std::array<Vec2, capacity> corners_, spare_;
    int count_ = 0;
};

class Raster {
  public:
    Raster(std::span<const Edge2> edges, const PixelGrid& grid)
        : grid_(grid),
          bound_(edges, grid),
          box_{grid.low, grid.low + Vec2{(grid.nx - 1) * grid.step.x, (grid.ny - 1) * grid.step.y}},
          pixel_(std::min(grid.step.x, grid.step.y)),
          squared_(static_cast<std::size_t>(grid.nx) * grid.ny, infinity),
          left_(grid.ny),
          right_(grid.ny) {}

    // The strip of the points whose nearest point on the edge's line lies on the edge, in pieces some pixels
    // wide, as far out as the edge may be what is nearest.
    void add_edge(const Edge2& edge) {
        const double full = length(edge.b - edge.a);
        const Vec2 unit = (1 / full) * (edge.b - edge.a), normal{-unit.y, unit.x};
        const int pieces =
            static_cast<int>(std::min(std::ceil(full / (cell_pixels * pixel_)), 1.0 * (grid_.nx + grid_.ny)));
        const double width = full / pieces;
        for (int piece = 0; piece < pieces; ++piece) {
            const Vec2 middle = edge.a + ((piece + 0.5) * width) * unit;
            const double left = reach(middle, normal, width / 2),
                         right = reach(middle, -1.0 * normal, width / 2);
            if (left < 0 && right < 0) continue;
            Box2 box;
            for (const double along : {-width / 2, width / 2})
                for (const double across : {std::max(left, 0.0), -std::max(right, 0.0)})
                    box.extend(middle + along * unit + across * normal);
            const double start = piece == 0 ? -end_slack * pixel_ : piece * width - shared_slack * pixel_,
                         end = piece + 1 == pieces ? full + end_slack * pixel_
                                                   : (piece + 1) * width + shared_slack * pixel_;
            fill_strip(edge.a, unit, start, end, grown(box));
        }
    }

    // The wedge of the points beyond the end of the edge that comes in and before the start of the one that
    // goes out, cut down to where no other boundary point is known to be nearer. That it is a little too wide
    // does no harm and leaves no gap to the strips. Directions are unit vectors.
    void add_vertex(Vec2 vertex, Vec2 in, Vec2 out) {
        if (cross(in, out) == 0 && dot(in, out) > 0) return;
        const double slack = shared_slack * pixel_;
        wedge_.begin(grown(box_));
        wedge_.cut(vertex - slack * in, in);
        wedge_.cut(vertex + slack * out, -1.0 * out);
        cut_to_nearest(wedge_, vertex);
        fill_polygon(wedge_.corners(), vertex);
    }

    std::vector<double> take() && { return std::move(squared_); }

  private:
    struct Rows {
        std::uint32_t first = 0, end = 0;
    };

    Box2 grown(Box2 box) const {
        const Vec2 by{shared_slack * pixel_, shared_slack * pixel_};
        return {box.low - by, box.high + by};
    }

    // What is nearer to a boundary point known near one of the corners is cut off, until no corner loses much
    // that way.
    void cut_to_nearest(Polygon& wedge, Vec2 apex) const {
        for (int cuts = 0; cuts < most_cuts; ++cuts) {
            double deepest = worth_a_cut * pixel_;
            Vec2 at, normal;
            for (const Vec2 corner : wedge.corners()) {
                const Vec2 known = bound_.known_near(corner), across = apex - known;
                // How far behind the bisector the corner lies.
                const double gain = squared_length(corner - apex) - squared_length(corner - known);
                if (gain <= 0 || gain * gain <= 4 * deepest * deepest * squared_length(across)) continue;
                const double apart = length(across);
                deepest = 0.5 * gain / apart;
                normal = (1 / apart) * across;
                at = 0.5 * (apex + known) - (shared_slack * pixel_) * normal;
            }
            if (normal == Vec2{}) return;
            wedge.cut(at, normal);
        }
    }

    // Row by row the points between the polygon's left and right sides, by their distance from `apex`.
    void fill_polygon(std::span<const Vec2> corners, Vec2 apex) {
        if (corners.empty()) return;
        double lowest = infinity, highest = -infinity;
        Vec2 from = on_grid(corners.back());
        for (const Vec2 corner : corners) {
            const Vec2 to = on_grid(corner);
            lowest = std::min(lowest, to.y);
            highest = std::max(highest, to.y);
            std::vector<double>& side = to.y < from.y ? left_ : right_;
            const Vec2 low = to.y < from.y ? to : from, high = to.y < from.y ? from : to;
            from = to;
            if (low.y == high.y) continue;
            const double slope = (high.x - low.x) / (high.y - low.y);
            const auto [first, end] = rows_between(low.y, high.y);
            for (std::uint32_t j = first; j < end; ++j) side[j] = low.x + slope * (j - low.y);
        }
        const auto [first, end] = rows_between(lowest, highest);
        for (std::uint32_t j = first; j < end; ++j) {
            each_column(
                left_[j] - shared_slack, right_[j] + shared_slack,
                [&](std::uint32_t begin, std::uint32_t last) { fill_distance(apex, j, begin, last); });
        }
    }
    Vec2 on_grid(Vec2 q) const {
        return {(q.x - grid_.low.x) / grid_.step.x, (q.y - grid_.low.y) / grid_.step.y};
    }
    void fill_distance(Vec2 apex, std::uint32_t j, std::uint32_t first, std::uint32_t last) {
        double* row = squared_.data() + static_cast<std::size_t>(j) * grid_.nx;
        const double y = grid_.low.y + j * grid_.step.y - apex.y, up = y * y;
        for (std::uint32_t i = first; i < last; ++i) {
            const double right = grid_.low.x + i * grid_.step.x - apex.x;
            row[i] = std::min(row[i], right * right + up);
        }
    }

    // The points that lie between `start` and `end` along the line from a, within the box, by their distance
    // from the line.
    void fill_strip(Vec2 a, Vec2 unit, double start, double end, const Box2& box) {
        const double columns = (end - start) / std::abs(unit.x) / grid_.step.x;
        // Strips of fewer columns are filled row by row. [columns; >= 1; B]
        constexpr double few = 6;
        if (columns < few) return fill_narrow_strip(a, unit, start, end, columns, rows_of(box));
        Piece strip(grid_, box);
        strip.cut(a + start * unit, unit);
        strip.cut(a + end * unit, -1.0 * unit);
        strip.each_row([&](std::uint32_t j, std::uint32_t first, std::uint32_t last) {
            fill_across(a, unit, j, first, last);
        });
    }
    void fill_across(Vec2 a, Vec2 unit, std::uint32_t j, std::uint32_t first, std::uint32_t last) {
        double* row = squared_.data() + static_cast<std::size_t>(j) * grid_.nx;
        const double from = unit.x * (grid_.low.y + j * grid_.step.y - a.y) - unit.y * (grid_.low.x - a.x);
        const double step = -unit.y * grid_.step.x;
        for (std::uint32_t i = first; i < last; ++i) {
            const double across = from + i * step;
            row[i] = std::min(row[i], across * across);
        }
    }
    // A strip that is at most a few columns wide, the same number in every row but for one: that one is
    // looked at and left out without a branch.
    void fill_narrow_strip(Vec2 a, Vec2 unit, double start, double end, double columns, const Rows& rows) {
        const Vec2 at = a + (unit.x > 0 ? start : end) * unit;
        const double slope = -unit.y * grid_.step.y / (unit.x * grid_.step.x);
        const double column = (at.x - grid_.low.x) / grid_.step.x,
                     row_of_at = (at.y - grid_.low.y) / grid_.step.y;
        const auto count = static_cast<std::int32_t>(columns) + 1;
        const double step = -unit.y * grid_.step.x, last_low = grid_.nx - 1.0 - count;
        for (std::uint32_t j = rows.first; j < rows.end; ++j) {
            const double low = column + slope * (j - row_of_at), high = low + columns;
            if (!(low >= 0 && low <= last_low)) {
                each_column(low, high, [&](std::uint32_t first, std::uint32_t last) {
                    fill_across(a, unit, j, first, last);
                });
                continue;
            }
            const std::int32_t first = rounded_up(low);
            double* row = squared_.data() + static_cast<std::size_t>(j) * grid_.nx + first;
            const double from =
                unit.x * (grid_.low.y + j * grid_.step.y - a.y) - unit.y * (grid_.low.x - a.x) + first * step;
            for (std::int32_t i = 0; i < count; ++i) {
                const double across = from + i * step;
                const double squared = first + i <= high ? across * across : infinity;
                row[i] = std::min(row[i], squared);
            }
        }
    }

    Rows rows_of(const Box2& box) const {
        return rows_between((box.low.y - grid_.low.y) / grid_.step.y,
                            (box.high.y - grid_.low.y) / grid_.step.y);
    }
    Rows rows_between(double low, double high) const {
        if (!(high >= 0) || !(low <= grid_.ny - 1.0)) return {};
        return {static_cast<std::uint32_t>(std::ceil(std::max(low, 0.0))),
                static_cast<std::uint32_t>(std::min(high, grid_.ny - 1.0)) + 1};
    }
    // Conversions are much faster than the library's functions. Requires: x > -1, within 32 bits.
    static std::int32_t rounded_up(double x) {
        const auto cut_off = static_cast<std::int32_t>(x);
        return cut_off + (cut_off < x);
    }
    template <class Body>
    void each_column(double low, double high, Body&& body) const {
        low = std::max(low, 0.0);
        high = std::min(high, grid_.nx - 1.0);
        if (!(low <= high)) return;
        const auto first = static_cast<std::uint32_t>(rounded_up(low));
        body(first, static_cast<std::uint32_t>(high) + 1);
    }

    // How far from the boundary point `from` along a direction square to the boundary there it, or a boundary
    // point beside it whose parallel ray is at most `beside` away, may be the nearest one of points of the
    // grid; negative when for none. Once another point of the boundary is nearer it stays so along the ray,
    // which is what ends the search.
    double reach(Vec2 from, Vec2 along, double beside) const {
        const Vec2 size{std::max(from.x - box_.low.x, box_.high.x - from.x),
                        std::max(from.y - box_.low.y, box_.high.y - from.y)};
        const double margin = beside + shared_slack * pixel_;
        double enter = 0, leave = length(size) + margin;
        for (const auto& [at, speed, low, high] : {std::tuple{from.x, along.x, box_.low.x, box_.high.x},
                                                   {from.y, along.y, box_.low.y, box_.high.y}}) {
            const double to_low = low - margin - at, to_high = high + margin - at;
            if (std::abs(speed) < 1e-12) {
                if (to_low > 0 || to_high < 0) return -1;
                continue;
            }
            enter = std::max(enter, std::min(to_low / speed, to_high / speed));
            leave = std::min(leave, std::max(to_low / speed, to_high / speed));
        }
        if (enter > leave) return -1;
        const auto is_beyond = [&](double far) {
            return bound_.distance(from + far * along) + beside + shared_slack * pixel_ < far;
        };
        // Outwards in growing steps, then back to within an eighth.
        double near = enter, far = std::min(enter + cell_pixels * pixel_, leave);
        while (!is_beyond(far)) {
            if (far == leave) return leave;
            near = far;
            far = std::min(enter + 2 * (far - enter), leave);
        }
        while (far - near > std::max(0.125 * far, 2 * pixel_)) {
            const double middle = (near + far) / 2;
            (is_beyond(middle) ? far : near) = middle;
        }
        return far;
    }

    const PixelGrid grid_;
    UpperBound bound_;
    Box2 box_;
    double pixel_;
    std::vector<double> squared_;
    Polygon wedge_;
    std::vector<double> left_, right_;  // per row, of the wedge
};

// Finds an edge that goes out of a point.
class Starts {
  public:
    explicit Starts(std::span<const Edge2> edges) : edges_(edges) {}
    // Mostly the edge after the one that comes in.
    Vec2 out_of(std::size_t in) {
        const Vec2 point = edges_[in].b;
        if (in + 1 < edges_.size() && edges_[in + 1].a == point) return direction(in + 1);
        if (order_.empty()) sort();
        const auto next = std::lower_bound(order_.begin(), order_.end(), point,
                                           [&](std::size_t e, Vec2 p) { return before(edges_[e].a, p); });
        assert(next != order_.end() && edges_[*next].a == point);
        return direction(*next);
    }

  private:
    Vec2 direction(std::size_t e) const { return edges_[e].b - edges_[e].a; }
    void sort() {
        order_.resize(edges_.size());
        for (std::size_t e = 0; e < order_.size(); ++e) order_[e] = e;
        std::sort(order_.begin(), order_.end(),
                  [&](std::size_t e, std::size_t f) { return before(edges_[e].a, edges_[f].a); });
    }

    std::span<const Edge2> edges_;
    std::vector<std::size_t> order_;
};

}  // namespace

std::vector<double> distance_raster(std::span<const Edge2> all, const PixelGrid& grid) {
    std::vector<Edge2> edges(all.begin(), all.end());
    std::erase_if(edges, [](const Edge2& edge) { return edge.a == edge.b; });
    assert(!edges.empty());
    if (grid.nx == 0 || grid.ny == 0) return {};
    Raster raster(edges, grid);
    Starts starts(edges);
    for (std::size_t e = 0; e < edges.size(); ++e) {
        raster.add_edge(edges[e]);
        raster.add_vertex(edges[e].b, unit_of(edges[e].b - edges[e].a), unit_of(starts.out_of(e)));
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
