#include "anatomesh/field/distance_map.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

// Entries of cells_ below first_list: no edge within the limit of any point of the cell.
constexpr std::uint32_t far_outside = 0, far_inside = 1, first_list = 2;

// The head of a list: how many edges, and whether the boundary crosses the cell or leaves it on one side.
constexpr std::uint32_t crossed = 0, all_outside = 1, all_inside = 2, side_bits = 2;
constexpr std::uint32_t side_mask = (1u << side_bits) - 1, head_size = 2;

bool less(Vec2 a, Vec2 b) {
    return a.x != b.x ? a.x < b.x : a.y < b.y;
}

}  // namespace

DistanceMap::DistanceMap(std::vector<Edge2> edges, double limit, double cell)
    : edges_(std::move(edges)), limit_(limit) {
    assert(limit > 0);
    std::erase_if(edges_, [](const Edge2& edge) { return edge.a == edge.b; });
    assert(!edges_.empty());
    lines_.reserve(edges_.size());
    double twice_area = 0, scale = 0;
    const Vec2 origin = edges_.front().a;
    for (const Edge2& edge : edges_) {
        const Vec2 along = edge.b - edge.a;
        const double squared = squared_length(along);
        lines_.push_back({edge.a, edge.b, squared, 1.0 / squared});
        region_box_.extend(edge.a);
        twice_area += cross(edge.a - origin, edge.b - origin);
        scale = std::max({scale, std::abs(edge.a.x), std::abs(edge.a.y)});
    }
    area_ = 0.5 * twice_area;
    // Distances that differ by less than the rounding of the coordinates' differences count as a tie.
    tie_ = 64 * std::numeric_limits<double>::epsilon() * scale;
    box_ = region_box_.grown(limit);
    classify_corners();
    choose_grid(cell);
    list_candidates();
}

// An end with one edge in and one out is convex, reflex or straight; every other end (contours that share a
// vertex, an edge that turns back on itself) is `shared` and decided by counting crossings.
void DistanceMap::classify_corners() {
    const std::uint32_t count = static_cast<std::uint32_t>(edges_.size());
    std::vector<std::uint32_t> by_start(count), by_end(count);
    for (std::uint32_t e = 0; e < count; ++e) by_start[e] = by_end[e] = e;
    std::sort(by_start.begin(), by_start.end(), [&](auto i, auto j) {
        return edges_[i].a == edges_[j].a ? i < j : less(edges_[i].a, edges_[j].a);
    });
    std::sort(by_end.begin(), by_end.end(), [&](auto i, auto j) {
        return edges_[i].b == edges_[j].b ? i < j : less(edges_[i].b, edges_[j].b);
    });
    start_corner_.assign(count, Corner::shared);
    end_corner_.assign(count, Corner::shared);
    std::uint32_t in = 0;
    for (std::uint32_t out = 0; out < count; ++out) {
        const Vec2 vertex = edges_[by_start[out]].a;
        const bool alone = (out == 0 || !(edges_[by_start[out - 1]].a == vertex)) &&
                           (out + 1 == count || !(edges_[by_start[out + 1]].a == vertex));
        while (in < count && less(edges_[by_end[in]].b, vertex)) ++in;
        if (!alone || in == count || !(edges_[by_end[in]].b == vertex)) continue;
        if (in + 1 < count && edges_[by_end[in + 1]].b == vertex) continue;
        const Edge2 &before = edges_[by_end[in]], &after = edges_[by_start[out]];
        const int turn = orient2d(before.a, vertex, after.b);
        const bool turns_back = turn == 0 && dot(vertex - before.a, after.b - vertex) <= 0;
        const Corner corner = turns_back ? Corner::shared
                              : turn > 0 ? Corner::convex
                              : turn < 0 ? Corner::reflex
                                         : Corner::straight;
        end_corner_[by_end[in]] = start_corner_[by_start[out]] = corner;
    }
}

// Cells about as large as the edges are long keep both the grid and the lists short; the bounds from `limit`
// and from the box keep construction and memory linear in the number of edges.
void DistanceMap::choose_grid(double cell) {
    const double width = box_.high.x - box_.low.x, height = box_.high.y - box_.low.y;
    if (cell <= 0) {
        double total = 0;
        for (const Line& line : lines_) total += std::sqrt(line.squared);
        cell = std::max(0.5 * total / static_cast<double>(lines_.size()), limit_ / 4);
    }
    const double most = 48.0 * static_cast<double>(lines_.size()) + 4096;
    cell_ = std::max({cell, std::sqrt(width * height / most), std::max(width, height) / most});
    inverse_cell_ = 1.0 / cell_;
    nx_ = static_cast<std::uint32_t>(std::floor(width * inverse_cell_)) + 1;
    ny_ = static_cast<std::uint32_t>(std::floor(height * inverse_cell_)) + 1;
}

Vec2 DistanceMap::nearest_point(const Line& line, Vec2 q) const {
    const Vec2 along = line.end - line.start;
    return line.start + std::clamp(dot(q - line.start, along) * line.inverse, 0.0, 1.0) * along;
}

// Whether every point x of the cell is farther from `line` than from `best_foot`, a point of another edge.
// With n the direction from the nearest point of the line to the centre and d its distance, the distance of x
// from the line is at least d + n (x - centre); what |x - best_foot| exceeds it by is convex, so the corners
// decide.
bool DistanceMap::is_never_nearest(const Line& line, Vec2 centre, Vec2 best_foot) const {
    const Vec2 from_line = centre - nearest_point(line, centre);
    const double d = length(from_line);
    if (d <= 1e-6 * cell_) return false;
    const Vec2 n = (1 / d) * from_line;
    const double half = 0.5 * cell_, slack = tie_ + 1e-9 * cell_;
    for (const Vec2 step : {Vec2{-half, -half}, Vec2{half, -half}, Vec2{-half, half}, Vec2{half, half}}) {
        const double at_least = d + dot(n, step) - slack;
        if (at_least <= 0 || squared_length(centre + step - best_foot) >= at_least * at_least) return false;
    }
    return true;
}

// Calls body(edge, cell, its centre, squared distance) for every edge and every cell whose centre may be
// within reach of it: the limit and a half diagonal, and never less than what a cell on the boundary must
// see.
template <class Body>
void DistanceMap::each_cell_near_an_edge(Body body) const {
    const double half_diagonal = cell_ * std::sqrt(0.5);
    const double reach = std::max(limit_ + half_diagonal, 3 * half_diagonal) * (1 + 1e-12) + tie_;
    const PixelGrid grid = centres();
    const auto clipped = [](double v, std::uint32_t n) {
        return static_cast<std::uint32_t>(std::clamp(v, 0.0, static_cast<double>(n)));
    };
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
        const Edge2& edge = edges_[e];
        const Vec2 low = Vec2{std::min(edge.a.x, edge.b.x), std::min(edge.a.y, edge.b.y)} - grid.low;
        const Vec2 high = Vec2{std::max(edge.a.x, edge.b.x), std::max(edge.a.y, edge.b.y)} - grid.low;
        const std::uint32_t i0 = clipped(std::ceil((low.x - reach) * inverse_cell_), nx_);
        const std::uint32_t i1 = clipped(std::floor((high.x + reach) * inverse_cell_) + 1, nx_);
        const std::uint32_t j0 = clipped(std::ceil((low.y - reach) * inverse_cell_), ny_);
        const std::uint32_t j1 = clipped(std::floor((high.y + reach) * inverse_cell_) + 1, ny_);
        for (std::uint32_t j = j0; j < j1; ++j) {
            for (std::uint32_t i = i0; i < i1; ++i) {
                const Vec2 centre = grid.low + Vec2{i * cell_, j * cell_};
                body(e, static_cast<std::size_t>(j) * nx_ + i, centre,
                     foot(lines_[e], centre).squared_distance);
            }
        }
    }
}

void DistanceMap::list_candidates() {
    const std::size_t cell_count = static_cast<std::size_t>(nx_) * ny_;
    std::vector<std::uint8_t> side(cell_count, all_outside);
    fill_even_odd(edges_, centres(), [&](std::uint32_t j, std::uint32_t first, std::uint32_t last) {
        const auto row = side.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(j) * nx_);
        std::fill(row + first, row + last, all_inside);
    });

    struct Cell {
        double squared =
            std::numeric_limits<double>::infinity();  // distance of the nearest edge from the centre
        double bound =
            -1;  // how far an edge may be to be listed, squared; negative: the cell is far from all edges
        std::uint32_t nearest = 0, count = 0;
    };
    std::vector<Cell> cells(cell_count);
    each_cell_near_an_edge([&](std::uint32_t e, std::size_t c, Vec2, double squared) {
        if (squared >= cells[c].squared) return;
        cells[c].squared = squared;
        cells[c].nearest = e;
    });
    // Where the boundary does not cross a cell, its sign is that of the centre, and edges beyond the limit
    // are of no use.
    const double half_diagonal = cell_ * std::sqrt(0.5);
    for (std::size_t c = 0; c < cell_count; ++c) {
        const double d = std::sqrt(cells[c].squared);
        const bool is_crossed = d <= half_diagonal * (1 + 1e-9) + tie_;
        if (is_crossed) side[c] = crossed;
        const double most =
            is_crossed ? d + 2 * half_diagonal : std::min(d + 2 * half_diagonal, limit_ + half_diagonal);
        const double padded = most * (1 + 1e-12) + tie_;
        if (d <= padded) cells[c].bound = padded * padded;
    }

    struct Listed {
        std::uint32_t cell, edge;
    };
    std::vector<Listed> listed;
    each_cell_near_an_edge([&](std::uint32_t e, std::size_t c, Vec2 centre, double squared) {
        Cell& cell = cells[c];
        if (squared > cell.bound) return;
        const bool beaten = e != cell.nearest &&
                            is_never_nearest(lines_[e], centre, nearest_point(lines_[cell.nearest], centre));
        if (beaten) return;
        listed.push_back({static_cast<std::uint32_t>(c), e});
        ++cell.count;
    });

    cells_.resize(cell_count);
    std::size_t size = first_list;
    for (std::size_t c = 0; c < cell_count; ++c) {
        const std::uint32_t far = side[c] == all_inside ? far_inside : far_outside;
        cells_[c] = cells[c].count > 0 ? static_cast<std::uint32_t>(size) : far;
        if (cells[c].count > 0) size += cells[c].count + head_size;
    }
    assert(size < std::numeric_limits<std::uint32_t>::max());
    candidates_.assign(size, 0);
    for (const Listed& entry : listed) {
        std::uint32_t* list = &candidates_[cells_[entry.cell]];
        list[head_size + list[0]++] = entry.edge;
    }
    for (std::size_t c = 0; c < cell_count; ++c) {
        if (cells[c].count == 0) continue;
        const double lower = std::min(limit_, std::sqrt(cells[c].squared) - half_diagonal) * (1 - 1e-6) - tie_;
        candidates_[cells_[c]] = (cells[c].count << side_bits) | side[c];
        candidates_[cells_[c] + 1] = std::bit_cast<std::uint32_t>(static_cast<float>(std::max(lower, 0.0)));
    }
}

// The entry of the cell that holds q; far_outside beyond the box.
std::uint32_t DistanceMap::place(Vec2 q) const {
    const double x = (q.x - box_.low.x) * inverse_cell_, y = (q.y - box_.low.y) * inverse_cell_;
    if (!(x >= 0 && y >= 0 && x < nx_ && y < ny_)) return far_outside;
    return cells_[static_cast<std::size_t>(static_cast<std::uint32_t>(y)) * nx_ + static_cast<std::uint32_t>(x)];
}

DistanceMap::Bound DistanceMap::bound(std::uint32_t entry) const {
    if (entry < first_list) return {entry == far_inside ? -1 : 1, limit_};
    const std::uint32_t whole = candidates_[entry] & side_mask;
    if (whole == crossed) return {0, 0};
    return {whole == all_inside ? -1 : 1, std::bit_cast<float>(candidates_[entry + 1])};
}

double DistanceMap::value(Vec2 q, std::uint32_t entry) const {
    if (entry < first_list) return entry == far_inside ? -limit_ : limit_;

    const std::uint32_t whole = candidates_[entry] & side_mask;
    const std::span<const std::uint32_t> candidates(&candidates_[entry + head_size], candidates_[entry] >> side_bits);
    if (whole != crossed) {
        double squared = limit_ * limit_;
        for (const std::uint32_t edge : candidates) squared = std::min(squared, foot(lines_[edge], q).squared_distance);
        return whole == all_inside ? -std::sqrt(squared) : std::sqrt(squared);
    }
    double best = std::numeric_limits<double>::infinity(), second = best;
    std::uint32_t nearest = 0;
    for (const std::uint32_t edge : candidates) {
        const double squared = foot(lines_[edge], q).squared_distance;
        const bool nearer = squared < best;
        second = std::min(second, nearer ? best : squared);
        nearest = nearer ? edge : nearest;
        best = nearer ? squared : best;
    }
    const int end = foot(lines_[nearest], q).end;
    if (q == (end < 0 ? lines_[nearest].start : lines_[nearest].end)) return 0;
    const double distance = std::sqrt(best);
    const double tied = distance * (1 + 1e-12) + tie_;
    const int sign = distance <= tie_        ? side_by_parity(q)
                     : second <= tied * tied ? side_of_nearest(q, candidates, tied * tied)
                                             : side(nearest, end, q);
    if (sign == 0) return 0;
    // A point off the boundary never gets 0, even where its distance underflows.
    return sign * std::clamp(distance, std::numeric_limits<double>::min(), limit_);
}

// On which side of the boundary q lies as its nearest edge says: -1 inside, 1 outside, 0 on it.
int DistanceMap::side(std::uint32_t edge, int end, Vec2 q) const {
    if (end != 0) {
        const Corner corner = end < 0 ? start_corner_[edge] : end_corner_[edge];
        if (corner == Corner::convex) return 1;
        if (corner == Corner::reflex) return -1;
        if (corner == Corner::shared) return side_by_parity(q);
    }
    return -orient2d(edges_[edge].a, edges_[edge].b, q);
}

// Several edges are nearest within rounding: their word counts if it is the same.
int DistanceMap::side_of_nearest(Vec2 q, std::span<const std::uint32_t> candidates, double squared) const {
    int common = 2;
    for (const std::uint32_t edge : candidates) {
        const Foot f = foot(lines_[edge], q);
        if (f.squared_distance > squared) continue;
        const int sign = side(edge, f.end, q);
        if (common != 2 && sign != common) return side_by_parity(q);
        common = sign;
    }
    return common;
}

// Exact: counts the edges that the ray from q towards +x crosses.
int DistanceMap::side_by_parity(Vec2 q) const {
    bool inside = false;
    for (const Edge2& edge : edges_) {
        const Vec2 lower = edge.a.y <= edge.b.y ? edge.a : edge.b,
                   upper = edge.a.y <= edge.b.y ? edge.b : edge.a;
        if (q.y < lower.y || q.y > upper.y) continue;
        const int turn = orient2d(lower, upper, q);
        if (turn == 0 && q.x >= std::min(lower.x, upper.x) && q.x <= std::max(lower.x, upper.x)) return 0;
        if (q.y < upper.y && turn > 0) inside = !inside;
    }
    return inside ? -1 : 1;
}

std::size_t DistanceMap::bytes() const {
    return edges_.size() * (sizeof(Edge2) + sizeof(Line) + 2) + 4 * (cells_.size() + candidates_.size());
}

}  // namespace anatomesh
