#include "anatomesh/improve/smooth/vertex_mover.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "anatomesh/base/disjoint_sets.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// Six volumes of a cell next to flat: a move makes none, and keeps those there are. [cubes of the longest
// edge; > 0; M 2026-11, set not recorded]
constexpr double nearly_flat = 1e-3;
// A factor that rounding does not come near to. [1; > 1; D]
constexpr double clearly = 1 + 1e-9;

}  // namespace

// What the cells were is looked at only where they are not good after the move.
bool VertexMover::try_move(std::uint32_t v, Vec3 p) {
    const Vec3 from = mesh_.points[v];
    mesh_.points[v] = p;
    if (good_sine_ > 0 ? clearly_good<true>(v) : clearly_good<false>(v)) return true;
    const Shape now = shape(v);
    const double bound = max_radius_edge_ * max_radius_edge_;
    bool accepted = now.squared_ratio <= bound && now.flattest >= nearly_flat && now.sine >= good_sine_;
    if (!accepted) {
        mesh_.points[v] = from;
        const Shape before = shape(v);
        mesh_.points[v] = p;
        accepted = now.squared_ratio <= std::max(before.squared_ratio, bound) &&
                   now.flattest >= std::min(before.flattest, nearly_flat) &&
                   now.sine >= std::min(before.sine, good_sine_);
    }
    // Far from flat the sign of a volume is beyond doubt.
    if (accepted && (now.flattest >= nearly_flat || positive(v))) return true;
    mesh_.points[v] = from;
    return false;
}

bool VertexMover::try_better(std::uint32_t v, Vec3 p, Shape& worst) {
    const Vec3 from = mesh_.points[v];
    mesh_.points[v] = p;
    const Shape now = shape(v);
    if (now.squared_ratio < worst.squared_ratio && now.flattest >= std::min(worst.flattest, nearly_flat) &&
        now.sine >= std::min(worst.sine, good_sine_) && (now.flattest >= nearly_flat || positive(v))) {
        worst = now;
        return true;
    }
    mesh_.points[v] = from;
    return false;
}

// Groups of vertices that share no cell, each vertex in the first group that it may be in. The last group is
// for those that find all others taken: one after the other. Those of the first group move while others are
// grouped still.
void VertexMover::for_each_apart(std::span<const std::uint32_t> vertices, int threads,
                                 const std::function<void(std::uint32_t)>& move) const {
    constexpr std::size_t most_groups = 64;        // bits of a word [groups; 1 to 64; D]
    constexpr std::size_t grouped_at_once = 4096;  // vertices between two moves of a group [vertices; > 0; B]
    constexpr std::size_t ahead = 4;  // vertices whose cells are fetched early [vertices; > 0; B]
    std::vector<std::vector<std::uint32_t>> groups(most_groups);
    std::vector<std::uint64_t> bit_of(mesh_.points.size(), 0);  // of the group; none for the last
    const auto group_some = [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n) {
            if (n + ahead < last) fetch_cells(vertices[n + ahead]);
            const std::uint32_t v = vertices[n];
            std::uint64_t taken = 0;
            for (const std::uint32_t c : stars_.at(v)) {
                const Cell& cell = mesh_.cells[c];
                taken |= bit_of[cell[0]] | bit_of[cell[1]] | bit_of[cell[2]] | bit_of[cell[3]];
            }
            const std::size_t group =
                std::min(static_cast<std::size_t>(std::countr_one(taken)), most_groups - 1);
            if (group < most_groups - 1) bit_of[v] = std::uint64_t{1} << group;
            groups[group].push_back(v);
        }
    };
    std::vector<std::uint32_t> moving;  // of the first group
    for (std::size_t n = 0; n < vertices.size() || !groups[0].empty(); n += grouped_at_once) {
        moving.swap(groups[0]);
        groups[0].clear();
        parallel_tasks(threads, {[&] { group_some(n, std::min(n + grouped_at_once, vertices.size())); },
                                 [&] { move_group(moving, threads, move); }});
    }
    for (std::size_t g = 1; g < most_groups; ++g)
        move_group(groups[g], g + 1 < most_groups ? threads : 1, move);
}

void VertexMover::move_group(std::span<const std::uint32_t> group, int threads,
                             const std::function<void(std::uint32_t)>& move) const {
    parallel_for(group.size(), 32, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n) {
            if (n + 2 < last) fetch_cells(group[n + 2]);
            if (n + 1 < last) fetch_points(group[n + 1]);
            move(group[n]);
        }
    });
}

void VertexMover::for_each_in_order(std::span<const std::uint32_t> vertices, int threads,
                                    const std::function<void(std::uint32_t)>& move) const {
    std::vector<std::uint32_t> place_of(mesh_.points.size(), no_cell);
    for (std::size_t n = 0; n < vertices.size(); ++n) place_of[vertices[n]] = static_cast<std::uint32_t>(n);
    DisjointSets sets(vertices.size());
    for (std::uint32_t n = 0; n < vertices.size(); ++n) {
        for (const std::uint32_t c : stars_.at(vertices[n])) {
            for (const std::uint32_t u : mesh_.cells[c]) {
                if (place_of[u] != no_cell) sets.join(n, place_of[u]);
            }
        }
    }
    // The sets one after the other, by their first vertices.
    std::vector<std::array<std::uint32_t, 2>> sorted(vertices.size());
    for (std::uint32_t n = 0; n < vertices.size(); ++n) sorted[n] = {sets.root(n), n};
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::size_t> begins;
    for (std::size_t n = 0; n < sorted.size(); ++n) {
        if (n == 0 || sorted[n][0] != sorted[n - 1][0]) begins.push_back(n);
    }
    begins.push_back(sorted.size());
    parallel_for(begins.size() - 1, 4, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = begins[first]; n < begins[last]; ++n) move(vertices[sorted[n][1]]);
    });
}

// Vertices of a group lie far apart: what is at the next ones is fetched into the cache meanwhile.
void VertexMover::fetch_cells(std::uint32_t v) const {
    for (const std::uint32_t c : stars_.at(v)) {
        __builtin_prefetch(&mesh_.cells[c]);
        __builtin_prefetch(&mesh_.regions[c]);
    }
}

void VertexMover::fetch_points(std::uint32_t v) const {
    for (const std::uint32_t c : stars_.at(v)) {
        for (const std::uint32_t u : mesh_.cells[c]) __builtin_prefetch(&mesh_.points[u]);
    }
}

double VertexMover::squared_ratio(std::uint32_t cell) const {
    const Cell& c = mesh_.cells[cell];
    return squared_radius_edge(mesh_.points[c[0]], mesh_.points[c[1]], mesh_.points[c[2]],
                               mesh_.points[c[3]]);
}

double VertexMover::shortest_edge(std::uint32_t v) const {
    double squared = INFINITY;
    for (const std::uint32_t c : stars_.at(v)) {
        for (const std::uint32_t u : mesh_.cells[c]) {
            if (u != v) squared = std::min(squared, squared_length(mesh_.points[u] - mesh_.points[v]));
        }
    }
    return std::sqrt(squared);
}

VertexMover::Shape VertexMover::shape(std::uint32_t v) const {
    Shape worst{0, INFINITY, INFINITY};
    for (const std::uint32_t cell : stars_.at(v)) {
        const Cell& c = mesh_.cells[cell];
        const Vec3 p0 = mesh_.points[c[0]], p1 = mesh_.points[c[1]], p2 = mesh_.points[c[2]],
                   p3 = mesh_.points[c[3]];
        const CellMeasures m =
            good_sine_ > 0 ? measure_cell(p0, p1, p2, p3) : measure_cell<false, true>(p0, p1, p2, p3);
        worst.flattest =
            std::min(worst.flattest, m.volume6 / (m.squared_longest * std::sqrt(m.squared_longest)));
        if (mesh_.regions[cell] == 0) continue;
        worst.squared_ratio = std::max(worst.squared_ratio, m.squared_ratio);
        if (good_sine_ > 0) worst.sine = std::min(worst.sine, m.least_sine());
    }
    return worst;
}

template <bool sines>
bool VertexMover::clearly_good(std::uint32_t v) const {
    const double most = max_radius_edge_ * max_radius_edge_, least = good_sine_ * good_sine_;
    const auto flat = [](const CellTerms& t) {
        const double longest = t.squared_longest;
        return !(t.volume6 > 0 &&
                 t.volume6 * t.volume6 > clearly * nearly_flat * nearly_flat * longest * longest * longest);
    };
    for (const std::uint32_t cell : stars_.at(v)) {
        const Cell& c = mesh_.cells[cell];
        const Vec3 p0 = mesh_.points[c[0]], p1 = mesh_.points[c[1]], p2 = mesh_.points[c[2]],
                   p3 = mesh_.points[c[3]];
        if (mesh_.regions[cell] == 0) {
            if (flat(cell_terms<false, false>(p0, p1, p2, p3))) return false;
            continue;
        }
        const CellTerms t = cell_terms<sines, true>(p0, p1, p2, p3);
        const double squared = t.volume6 * t.volume6;
        if (flat(t) || !(clearly * t.radius < most * 4 * squared * t.shortest)) return false;
        if (sines && !(squared * t.sine > clearly * least * t.facets)) return false;
    }
    return true;
}

bool VertexMover::positive(std::uint32_t v) const {
    return std::all_of(stars_.at(v).begin(), stars_.at(v).end(), [&](std::uint32_t cell) {
        const Cell& c = mesh_.cells[cell];
        return orient3d(mesh_.points[c[0]], mesh_.points[c[1]], mesh_.points[c[2]], mesh_.points[c[3]]) > 0;
    });
}

}  // namespace anatomesh
