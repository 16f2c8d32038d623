#include "anatomesh/improve/sides_at.h"

#include <algorithm>

namespace anatomesh {

namespace {

constexpr double on_line = 1e-9;  // of a piece: a vertex so near to it lies on it

}  // namespace

bool SidesAt::find_ring(std::uint32_t a, std::uint32_t b) {
    bench_.mesh.star(a, bench_.star);
    for (const std::uint32_t c : bench_.star) {
        const Cell& cell = bench_.mesh.cell(c);
        for (int e = 0; e < 6; ++e) {
            const std::uint32_t p = cell[cell_edges[e][0]], q = cell[cell_edges[e][1]];
            if ((p != a || q != b) && (p != b || q != a)) continue;
            bench_.mesh.ring(c, e, bench_.ring);
            return bench_.ring.closed;
        }
    }
    return false;
}

bool SidesAt::on_surface(std::span<const std::uint32_t> chain, std::uint32_t structure) {
    for (std::size_t n = 1; n < chain.size(); ++n) {
        if (!row_on_surface(chain[n - 1], chain[n], structure)) return false;
    }
    return true;
}

bool SidesAt::row_on_surface(std::uint32_t a, std::uint32_t b, std::uint32_t structure) {
    for (std::uint32_t at = a; at != b;) {
        const std::uint32_t next = next_in_row(at, a, b);
        if (next == no_cell || !on_surface(at, next, structure)) return false;
        at = next;
    }
    return true;
}

// On the way from a to b the nearest vertex beyond one that a fixed edge joins to it, or b; no_cell if there
// is none.
std::uint32_t SidesAt::next_in_row(std::uint32_t at, std::uint32_t a, std::uint32_t b) {
    const Vec3 from = bench_.mesh.point(at), way = bench_.mesh.point(b) - bench_.mesh.point(a);
    std::uint32_t next = no_cell;
    double least = 0;
    bench_.mesh.star(at, bench_.star);
    for (const std::uint32_t c : bench_.star) {
        for (const std::uint32_t v : bench_.mesh.cell(c)) {
            if (v == at || (v != b && !bench_.fixed_edge(at, v))) continue;
            const Vec3 step = bench_.mesh.point(v) - from;
            const double along = dot(step, way);
            if (along <= 0 || (next != no_cell && along >= least)) continue;
            if (v != b && length(cross(step, way)) > on_line * squared_length(way)) continue;
            next = v;
            least = along;
        }
    }
    return next;
}

bool SidesAt::is_mixed(const std::vector<std::uint32_t>& cells, std::uint32_t structure) const {
    return std::any_of(cells.begin(), cells.end(),
                       [&](std::uint32_t c) { return has(c, structure) != has(cells.front(), structure); });
}

}  // namespace anatomesh
