#include "anatomesh/field/slice/distance_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "anatomesh/base/instruction_sets.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

// Longer lists become lists of strips of the next level, so that a query looks at few entries.
// [entries; >= 1; B]
constexpr std::uint32_t longest_list = 64;
// A strip has so many edges, or strips of the level below. [edges; >= 2; B]
constexpr std::uint32_t strip_size = 16;
// Strips have so many levels, so that the longest hold 16^3 edges. [levels; 1 to 3; B]
constexpr std::uint32_t strip_levels = 3;

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
        lines_.push_back({edge.a, along, squared, 1.0 / squared});
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
    shorten_lists();
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
    grid_.cell = std::max({cell, std::sqrt(width * height / most), std::max(width, height) / most});
    grid_.inverse = 1.0 / grid_.cell;
    grid_.nx = static_cast<std::uint32_t>(std::floor(width * grid_.inverse)) + 1;
    grid_.ny = static_cast<std::uint32_t>(std::floor(height * grid_.inverse)) + 1;
}

Vec2 DistanceMap::nearest_point(const Line& line, Vec2 q) const {
    return line.start + std::clamp(dot(q - line.start, line.along) * line.inverse, 0.0, 1.0) * line.along;
}

// Whether every point x of the cell is farther from `line` than from `best`, another edge. With n the
// direction from the nearest point of the line to the centre and d its distance, the distance of x from the
// line is at least d + n (x - centre); what the distance from `best` exceeds it by is convex, so the corners
// decide.
bool DistanceMap::is_never_nearest(const Line& line, Vec2 centre, const Line& best) const {
    const Vec2 from_line = centre - nearest_point(line, centre);
    const double d = length(from_line);
    if (d <= 1e-6 * grid_.cell) return false;
    const Vec2 n = (1 / d) * from_line;
    const double half = 0.5 * grid_.cell, slack = tie_ + 1e-9 * grid_.cell;
    for (const Vec2 step : {Vec2{-half, -half}, Vec2{half, -half}, Vec2{-half, half}, Vec2{half, half}}) {
        const double at_least = d + dot(n, step) - slack;
        if (at_least <= 0 || foot(best, centre + step).squared_distance >= at_least * at_least) return false;
    }
    return true;
}

// Of the points with these x and this y from a line.
ANATOMESH_CLONES void DistanceMap::squared_distances(const Line& line, std::span<const double> x, double y,
                                                     double* squared) {
    for (std::size_t i = 0; i < x.size(); ++i) squared[i] = foot(line, {x[i], y}).squared_distance;
}

// Calls body(edge, cell, its centre, squared distance) for every edge and every cell whose centre may be
// within reach of it: the limit and a half diagonal, and never less than what a cell on the boundary must
// see.
template <class Body>
void DistanceMap::each_cell_near_an_edge(Body body) const {
    const double half_diagonal = grid_.cell * std::sqrt(0.5);
    const double reach = std::max(limit_ + half_diagonal, 3 * half_diagonal) * (1 + 1e-12) + tie_;
    const PixelGrid grid = centres();
    const auto clipped = [](double v, std::uint32_t n) {
        return static_cast<std::uint32_t>(std::clamp(v, 0.0, static_cast<double>(n)));
    };
    std::vector<double> columns(grid_.nx), squared(grid_.nx);
    for (std::uint32_t i = 0; i < grid_.nx; ++i) columns[i] = grid.low.x + i * grid_.cell;
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
        const Edge2& edge = edges_[e];
        const Vec2 low = Vec2{std::min(edge.a.x, edge.b.x), std::min(edge.a.y, edge.b.y)} - grid.low;
        const Vec2 high = Vec2{std::max(edge.a.x, edge.b.x), std::max(edge.a.y, edge.b.y)} - grid.low;
        const std::uint32_t i0 = clipped(std::ceil((low.x - reach) * grid_.inverse), grid_.nx);
        const std::uint32_t i1 = clipped(std::floor((high.x + reach) * grid_.inverse) + 1, grid_.nx);
        const std::uint32_t j0 = clipped(std::ceil((low.y - reach) * grid_.inverse), grid_.ny);
        const std::uint32_t j1 = clipped(std::floor((high.y + reach) * grid_.inverse) + 1, grid_.ny);
        for (std::uint32_t j = j0; j < j1 && i0 < i1; ++j) {
            const double y = grid.low.y + j * grid_.cell;
            squared_distances(lines_[e], std::span(columns).subspan(i0, i1 - i0), y, squared.data());
            for (std::uint32_t i = i0; i < i1; ++i)
                body(e, static_cast<std::size_t>(j) * grid_.nx + i, Vec2{columns[i], y}, squared[i - i0]);
        }
    }
}

void DistanceMap::list_candidates() {
    const std::size_t cell_count = grid_.size();
    std::vector<std::uint8_t> side(cell_count, all_outside);
    fill_even_odd(edges_, centres(), [&](std::uint32_t j, std::uint32_t first, std::uint32_t last) {
        const auto row = side.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(j) * grid_.nx);
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
    const double half_diagonal = grid_.cell * std::sqrt(0.5);
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
        const bool beaten = e != cell.nearest && is_never_nearest(lines_[e], centre, lines_[cell.nearest]);
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
        const double lower =
            std::min(limit_, std::sqrt(cells[c].squared) - half_diagonal) * (1 - 1e-6) - tie_;
        candidates_[cells_[c]] = ListHead::of(cells[c].count, 0, side[c]).bits;
        candidates_[cells_[c] + 1] = std::bit_cast<std::uint32_t>(static_cast<float>(std::max(lower, 0.0)));
    }
}

// Of the edges or strips from `first` up to `last`, given by the edges' numbers.
DistanceMap::Strip DistanceMap::make_strip(std::size_t first, std::size_t last) const {
    // Along the contour or against it, as the edges are numbered.
    const bool against = last - first > 1 && edges_[first].a == edges_[first + 1].b;
    const Vec2 start = against ? edges_[first].b : edges_[first].a,
               end = against ? edges_[last - 1].a : edges_[last - 1].b;
    Strip strip{{start, end - start}, end, 0};
    const double squared = squared_length(strip.chord.along);
    if (squared > 0) {
        strip.chord.squared = squared;
        strip.chord.inverse = 1 / squared;
    }
    for (std::size_t e = first; e < last; ++e) {
        for (const Vec2 p : {edges_[e].a, edges_[e].b}) {
            strip.reach = std::max(strip.reach, length(p - nearest_point(strip.chord, p)));
        }
    }
    strip.reach = padded(strip.reach);
    return strip;
}

void DistanceMap::make_strips() {
    std::size_t edges_each = strip_size;
    for (std::uint32_t level = 1; level <= strip_levels; ++level, edges_each *= strip_size) {
        strips_.emplace_back();
        for (std::size_t first = 0; first < edges_.size(); first += edges_each)
            strips_.back().push_back(make_strip(first, std::min(first + edges_each, edges_.size())));
    }
}

// Replaces the edges of long lists by their strips. Lists rise, so those of one strip stand together.
void DistanceMap::shorten_lists() {
    const auto is_long = [&](std::uint32_t entry) {
        return entry >= first_list && head_at(entry).count() > longest_list;
    };
    if (std::none_of(cells_.begin(), cells_.end(), is_long)) return;
    make_strips();
    std::size_t size = first_list;
    for (std::uint32_t& cell : cells_) {
        if (cell < first_list) continue;
        const ListHead before = head_at(cell);
        const auto head = candidates_.begin() + cell, first = head + head_size;
        auto last = first + before.count();
        std::uint32_t level = 0;
        for (; last - first > longest_list && level < strip_levels; ++level) {
            std::transform(first, last, first, [](std::uint32_t entry) { return entry / strip_size; });
            last = std::unique(first, last);
        }
        *head = ListHead::of(static_cast<std::size_t>(last - first), level, before.side()).bits;
        cell = static_cast<std::uint32_t>(size);
        size = static_cast<std::size_t>(
            std::copy(head, last, candidates_.begin() + static_cast<std::ptrdiff_t>(size)) -
            candidates_.begin());
    }
    candidates_.resize(size);
    candidates_.shrink_to_fit();
}

DistanceMap::List DistanceMap::list_at(std::uint32_t entry) const {
    const ListHead head = head_at(entry);
    return {{&candidates_[entry + head_size], head.count()}, head.level()};
}

// Calls body(edge, squared distance), in the edges' order, for those of the listed edges or strips that can
// be within `bound`, which body may lower, and for some others. Returns how many edges and strips it looked
// at.
template <class At, class Body>
std::size_t DistanceMap::each_near(Vec2 q, std::uint32_t level, std::size_t count, At at, double& bound,
                                   const Body& body) const {
    if (level == 0) {
        for (std::size_t i = 0; i < count; ++i) body(at(i), foot(lines_[at(i)], q).squared_distance);
        return count;
    }
    const std::vector<Strip>& strips = strips_[level - 1];
    // The ends of chords are on the boundary themselves.
    double squared = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < count; ++i) {
        const Strip& strip = strips[at(i)];
        squared = std::min({squared, squared_length(q - strip.chord.start), squared_length(q - strip.end)});
    }
    bound = std::min(bound, padded(std::sqrt(squared)));
    std::size_t steps = count;
    const std::size_t all = level == 1 ? lines_.size() : strips_[level - 2].size();
    for (std::size_t i = 0; i < count; ++i) {
        const Strip& strip = strips[at(i)];
        const double reach = bound + strip.reach;
        if (foot(strip.chord, q).squared_distance > reach * reach) continue;
        const std::size_t first = std::size_t{strip_size} * at(i);
        steps +=
            each_near(q, level - 1, std::min<std::size_t>(strip_size, all - first), Run{first}, bound, body);
    }
    return steps;
}

DistanceMap::Nearest DistanceMap::nearest_by_strips(Vec2 q, const List& list, double bound) const {
    Nearest nearest{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), 0};
    const auto look = [&](std::uint32_t edge, double squared) {
        if (squared >= nearest.squared) {
            nearest.second = std::min(nearest.second, squared);
            return;
        }
        nearest = {squared, nearest.squared, edge};
        bound = std::min(bound, padded(std::sqrt(squared)));
    };
    nearest.steps = each_near(q, list.level, list.entries.size(), list, bound, look);
    return nearest;
}

// value(), where the cell has a list.
ANATOMESH_CLONES double DistanceMap::near_value(Vec2 q, std::uint32_t entry) const {
    const std::uint32_t* list = &candidates_[entry];
    const ListHead head{*list};
    const Side whole = head.side();
    if (head.level() != 0) return value_by_strips(q, entry);
    const std::uint32_t *edge = list + head_size, *const end = edge + head.count();
    const Line* const lines = lines_.data();
    if (whole != crossed) {
        double squared = limit_ * limit_;
        for (; edge != end; ++edge) squared = std::min(squared, foot(lines[*edge], q).squared_distance);
        return whole == all_inside ? -std::sqrt(squared) : std::sqrt(squared);
    }
    Nearest nearest{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), 0};
    for (; edge != end; ++edge) {
        const double squared = foot(lines[*edge], q).squared_distance;
        const bool nearer = squared < nearest.squared;
        nearest.second = std::min(nearest.second, nearer ? nearest.squared : squared);
        nearest.edge = nearer ? *edge : nearest.edge;
        nearest.squared = nearer ? squared : nearest.squared;
    }
    const double distance = std::sqrt(nearest.squared), tied = distance * (1 + 1e-12) + tie_;
    if (distance > tie_ && nearest.second > tied * tied) {
        // Alone the nearest. Where the foot is between the edge's ends the rounded cross product has the
        // right sign: it is off by less than 4 roundings of |along| |w|, |w| is at most the edge's length
        // plus the distance, and the tie is more than 16 roundings of any edge's length.
        const Line& line = lines[nearest.edge];
        const Vec2 w = q - line.start;
        const double projection = dot(w, line.along);
        if (projection > 0 && projection < line.squared) {
            const double size = std::min(distance, limit_);
            return cross(line.along, w) > 0 ? -size : size;
        }
    }
    return signed_value(q, entry, nearest);
}

double DistanceMap::value_by_strips(Vec2 q, std::uint32_t entry) const {
    const Side whole = head_at(entry).side();
    const List list = list_at(entry);
    if (whole == crossed)
        return signed_value(q, entry, nearest_by_strips(q, list, std::numeric_limits<double>::infinity()));
    const double squared = std::min(limit_ * limit_, nearest_by_strips(q, list, padded(limit_)).squared);
    return whole == all_inside ? -std::sqrt(squared) : std::sqrt(squared);
}

// In a cell that the boundary crosses.
double DistanceMap::signed_value(Vec2 q, std::uint32_t entry, const Nearest& nearest) const {
    const int end = foot(lines_[nearest.edge], q).end;
    const Edge2& edge = edges_[nearest.edge];
    if (q == (end < 0 ? edge.a : edge.b)) return 0;
    const double distance = std::sqrt(nearest.squared);
    const double tied = distance * (1 + 1e-12) + tie_;
    const int sign = distance <= tie_                ? side_by_parity(q)
                     : nearest.second <= tied * tied ? side_of_nearest(q, list_at(entry), tied)
                                                     : side(nearest.edge, end, q);
    if (sign == 0) return 0;
    // A point off the boundary never gets 0, even where its distance underflows.
    return sign * std::clamp(distance, std::numeric_limits<double>::min(), limit_);
}

std::size_t DistanceMap::steps(Vec2 q) const {
    const std::uint32_t entry = place(q);
    if (entry < first_list) return 0;
    const List list = list_at(entry);
    const bool is_crossed = head_at(entry).side() == crossed;
    return list.level == 0
               ? list.entries.size()
               : nearest_by_strips(q, list,
                                   is_crossed ? std::numeric_limits<double>::infinity() : padded(limit_))
                     .steps;
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
int DistanceMap::side_of_nearest(Vec2 q, const List& list, double tied) const {
    int common = 2;
    bool agree = true;
    double bound = tied;
    each_near(q, list.level, list.entries.size(), list, bound, [&](std::uint32_t edge, double squared) {
        if (squared > tied * tied || !agree) return;
        const int sign = side(edge, foot(lines_[edge], q).end, q);
        agree = common == 2 || sign == common;
        common = sign;
    });
    return agree ? common : side_by_parity(q);
}

// Exact: counts the edges that the ray from q towards +x crosses.
int DistanceMap::side_by_parity(Vec2 q) const {
    bool inside = false, on_edge = false;
    each_beside(q, [&](std::size_t first, std::size_t last) {
        for (std::size_t e = first; e < last && !on_edge; ++e) {
            const Edge2& edge = edges_[e];
            const Vec2 lower = edge.a.y <= edge.b.y ? edge.a : edge.b,
                       upper = edge.a.y <= edge.b.y ? edge.b : edge.a;
            if (q.y < lower.y || q.y > upper.y) continue;
            const int turn = orient2d(lower, upper, q);
            on_edge = turn == 0 && q.x >= std::min(lower.x, upper.x) && q.x <= std::max(lower.x, upper.x);
            if (q.y < upper.y && turn > 0) inside = !inside;
        }
    });
    return on_edge ? 0 : inside ? -1 : 1;
}

// Calls body(first edge, last) for runs of edges that hold all those that the ray from q towards +x meets.
template <class Body>
void DistanceMap::each_beside(Vec2 q, const Body& body) const {
    const auto is_beside = [q](const Strip& strip) {
        const auto& [start, end] = std::pair(strip.chord.start, strip.end);
        return q.y >= std::min(start.y, end.y) - strip.reach &&
               q.y <= std::max(start.y, end.y) + strip.reach && q.x <= std::max(start.x, end.x) + strip.reach;
    };
    if (strips_.empty()) return body(0, edges_.size());
    const std::vector<Strip>&large = strips_[1], &small = strips_[0];
    for (std::size_t n = 0; n < large.size(); ++n) {
        if (!is_beside(large[n])) continue;
        for (std::size_t k = strip_size * n; k < std::min(strip_size * (n + 1), small.size()); ++k) {
            if (is_beside(small[k])) body(strip_size * k, std::min(strip_size * (k + 1), edges_.size()));
        }
    }
}

std::size_t DistanceMap::bytes() const {
    return edges_.size() * (sizeof(Edge2) + sizeof(Line) + 2) + 4 * (cells_.size() + candidates_.size()) +
           sizeof(Strip) *
               std::accumulate(strips_.begin(), strips_.end(), std::size_t{0},
                               [](std::size_t sum, const auto& level) { return sum + level.size(); });
}

}  // namespace anatomesh
