#include <algorithm>
#include <array>

#include "anatomesh/improve/core/hole.h"
#include "anatomesh/improve/operations/operations.h"

namespace anatomesh {

namespace {

// A new vertex stands at one of these shares of an edge.
// [1; 0 to 1; M 2026-11 pelvis, spine, skull, 61 labels, fetal brain]
constexpr std::array<double, 5> shares{0.5, 0.4, 0.6, 0.3, 0.7};
// A new vertex stands over a cell at one of these heights, in longest edges of its largest facet. [1; 0 to 1;
// M 2026-11, set not recorded]
constexpr std::array<double, 4> heights{0.25, 0.4, 0.15, 0.55};

// The vector across the largest facet of a cell, as long as the longest edge of that.
Vec3 across_largest_facet(const EditContext& edit, std::uint32_t cell) {
    Vec3 normal{};
    double longest = 0;
    for (const auto& f : facet_vertices) {
        const Cell& c = edit.mesh.cell(cell);
        const Vec3 p = edit.mesh.point(c[f[0]]), q = edit.mesh.point(c[f[1]]), r = edit.mesh.point(c[f[2]]);
        const Vec3 n = cross(q - p, r - p);
        if (squared_length(n) <= squared_length(normal)) continue;
        normal = n;
        longest = std::max({length(q - p), length(r - q), length(p - r)});
    }
    return longest * normalized(normal);
}

}  // namespace

bool split_edge(EditContext& edit, std::uint32_t cell, int e) {
    if (!edit.mesh.edge_on_interface(cell, e)) return false;
    edit.mesh.ring(cell, e, edit.ring);
    if (!edit.ring.closed) return false;
    const std::uint32_t a = edit.ring.a, b = edit.ring.b;
    const bool fixed = edit.constraints.fixed_edge(a, b);
    const Vec3 from = edit.mesh.point(a), way = edit.mesh.point(b) - from;
    const auto better = [&](const QualityThreshold& threshold) { return edit.rule.needed_sine(threshold); };
    const auto fill = [&](Hole hole) {
        for (const double share : shares) {
            Hole tried = hole;
            if (!tried.fill_from(from + share * way, edit.rule.max_radius_edge, better)) continue;
            if (fixed) edit.fix_on_edge(static_cast<std::uint32_t>(edit.mesh.point_count() - 1), a, b);
            ++edit.stats.operations.vertices_inserted;
            return true;
        }
        return false;
    };
    Hole hole(edit, edit.ring);
    if (fill(hole)) return true;
    // In a flat cell the opposite edge passes close to this one: where it stays, the cells with it are flat
    // too.
    EdgeRing opposite;
    edit.mesh.ring(cell, 5 - e, opposite);
    return hole.add(opposite) && fill(hole);
}

bool split_facet(EditContext& edit, std::uint32_t cell, int facet) {
    const std::uint32_t beyond = edit.mesh.neighbor(cell, facet);
    if (beyond == no_cell) return false;
    Vec3 middle{};
    for (const int n : facet_vertices[facet])
        middle = middle + (1.0 / 3) * edit.mesh.point(edit.mesh.cell(cell)[n]);
    const auto better = [&](const QualityThreshold& threshold) { return edit.rule.needed_sine(threshold); };
    const double most = edit.rule.max_radius_edge;
    Hole hole(edit, {cell, beyond}, {});
    const bool inside = edit.mesh.region(cell) == edit.mesh.region(beyond);
    const bool done = inside ? hole.fill(middle, {}, most, better, [](Vec3&) { return true; })
                             : hole.fill_from(middle, most, better);
    edit.stats.operations.vertices_inserted += done;
    return done;
}

bool split_cell(EditContext& edit, std::uint32_t cell) {
    Hole hole(edit, {cell}, {});
    const auto better = [&](const QualityThreshold& threshold) { return edit.rule.needed_sine(threshold); };
    const bool done =
        hole.fill(hole.centre(), {}, edit.rule.max_radius_edge, better, [](Vec3&) { return true; });
    edit.stats.operations.vertices_inserted += done;
    return done;
}

bool insert_beside(EditContext& edit, std::uint32_t cell) {
    const Vec3 across = across_largest_facet(edit, cell);
    Vec3 middle{};
    for (const std::uint32_t v : edit.mesh.cell(cell)) middle += 0.25 * edit.mesh.point(v);
    const auto better = [&](const QualityThreshold& threshold) { return edit.rule.needed_sine(threshold); };
    const auto anywhere = [](Vec3&) { return true; };
    for (const double height : heights) {
        for (const double side : {1.0, -1.0}) {
            const Vec3 p = middle + (side * height) * across;
            // The hole grows to where the vertex is.
            if (!Hole(edit, {cell}, {}).fill(p, {}, edit.rule.max_radius_edge, better, anywhere)) continue;
            ++edit.stats.operations.vertices_inserted;
            return true;
        }
    }
    return false;
}

}  // namespace anatomesh
