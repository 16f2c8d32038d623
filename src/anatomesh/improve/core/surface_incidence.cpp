#include "anatomesh/improve/core/surface_incidence.h"

#include <algorithm>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/numbers.h"

namespace anatomesh {

namespace {

// A vertex nearer to a subsegment than this share of it lies on it: it was put there. [1; 0 to 0.01; D]
constexpr double on_line = 1e-9;

}  // namespace

bool SurfaceIncidence::find_ring(std::uint32_t a, std::uint32_t b) {
    edit_.mesh.star(a, edit_.star);
    for (const std::uint32_t c : edit_.star) {
        const Cell& cell = edit_.mesh.cell(c);
        for (int e = 0; e < 6; ++e) {
            const std::uint32_t p = cell[cell_edges[e][0]], q = cell[cell_edges[e][1]];
            if ((p != a || q != b) && (p != b || q != a)) continue;
            edit_.mesh.ring(c, e, edit_.ring);
            return edit_.ring.closed;
        }
    }
    return false;
}

std::optional<double> SurfaceIncidence::onward(Vec3 step, Vec3 way) {
    const double along = dot(step, way), whole = squared_length(way);
    if (along <= 0 || length(cross(step, way)) > on_segment_share * whole) return std::nullopt;
    return along;
}

std::vector<std::uint32_t> SurfaceIncidence::row_from(std::uint32_t first, std::uint32_t last,
                                                      std::uint32_t structure) {
    std::vector<std::uint32_t> row{first};
    while (row.back() != last) {
        const std::uint32_t next = next_on_surface(row.back(), first, last, structure);
        if (next == no_cell) break;
        row.push_back(next);
    }
    return row;
}

// The nearest vertex on the way to the end that an edge of the surface joins to this one.
std::uint32_t SurfaceIncidence::next_on_surface(std::uint32_t at, std::uint32_t first, std::uint32_t last,
                                                std::uint32_t structure) {
    const Vec3 here = edit_.mesh.point(at), way = edit_.mesh.point(last) - edit_.mesh.point(first);
    edit_.mesh.star(at, edit_.star);
    std::vector<std::pair<double, std::uint32_t>> found;
    for (const std::uint32_t c : edit_.star) {
        for (const std::uint32_t v : edit_.mesh.cell(c)) {
            const std::optional<double> along = onward(edit_.mesh.point(v) - here, way);
            if (v != at && along && *along <= (1 + on_segment_share) * squared_length(way))
                found.emplace_back(*along, v);
        }
    }
    sort_distinct(found);
    for (const auto& [along, v] : found) {
        if (on_surface(at, v, structure)) return v;
    }
    return no_cell;
}

bool SurfaceIncidence::on_surface(std::span<const std::uint32_t> chain, std::uint32_t structure) {
    for (std::size_t n = 1; n < chain.size(); ++n) {
        if (!row_on_surface(chain[n - 1], chain[n], structure)) return false;
    }
    return true;
}

bool SurfaceIncidence::row_on_surface(std::uint32_t a, std::uint32_t b, std::uint32_t structure) {
    for (std::uint32_t at = a; at != b;) {
        const std::uint32_t next = next_in_row(at, a, b);
        if (next == no_cell || !on_surface(at, next, structure)) return false;
        at = next;
    }
    return true;
}

// On the way from a to b the nearest vertex beyond one that a fixed edge joins to it, or b; no_cell if there
// is none.
std::uint32_t SurfaceIncidence::next_in_row(std::uint32_t at, std::uint32_t a, std::uint32_t b) {
    const Vec3 from = edit_.mesh.point(at), way = edit_.mesh.point(b) - edit_.mesh.point(a);
    std::uint32_t next = no_cell;
    double least = 0;
    edit_.mesh.star(at, edit_.star);
    for (const std::uint32_t c : edit_.star) {
        for (const std::uint32_t v : edit_.mesh.cell(c)) {
            if (v == at || (v != b && !edit_.constraints.fixed_edge(at, v))) continue;
            const Vec3 step = edit_.mesh.point(v) - from;
            const double along = dot(step, way);
            if (along <= 0 || (next != no_cell && along >= least)) continue;
            if (v != b && length(cross(step, way)) > on_line * squared_length(way)) continue;
            next = v;
            least = along;
        }
    }
    return next;
}

bool SurfaceIncidence::is_mixed(const std::vector<std::uint32_t>& cells, std::uint32_t structure) const {
    return std::any_of(cells.begin(), cells.end(),
                       [&](std::uint32_t c) { return has(c, structure) != has(cells.front(), structure); });
}

}  // namespace anatomesh
