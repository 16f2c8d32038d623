#include <algorithm>
#include <array>

#include "anatomesh/improve/operations/operations.h"

namespace anatomesh {

namespace {

// The triangulation of a larger ring costs more than it gains. [vertices; >= 3; B]
constexpr int most_ring = 9;

// The best triangulation of a ring's polygon or of a part of it. Vertices i < j of the ring; piece (i, j) is
// the polygon i, i + 1, ..., j, in ring order from `first`.
class RingTriangulation {
  public:
    RingTriangulation(EditContext& edit, const QualityThreshold& threshold)
        : edit_(edit), threshold_(threshold) {}

    // Appends the cells of the best triangulation of the polygon of `count` ring vertices from `first`, in
    // `region`, to the context's cells. False if it has a cell that does not reach `needed`.
    bool append(int first, int count, Region region, double needed) {
        first_ = first;
        region_ = region;
        for (int i = 0; i + 1 < count; ++i) best_[i][i + 1] = 2;
        for (int span = 2; span < count; ++span) {
            for (int i = 0; i + span < count; ++i) {
                const int j = i + span;
                best_[i][j] = -2;
                for (int k = i + 1; k < j; ++k) {
                    const double bound = std::min(best_[i][k], best_[k][j]);
                    if (bound < needed || bound <= best_[i][j]) continue;
                    const double value = std::min(bound, triangle_value(i, k, j, needed));
                    if (value > best_[i][j]) {
                        best_[i][j] = value;
                        apex_[i][j] = k;
                    }
                }
            }
        }
        if (best_[0][count - 1] < needed) return false;
        emit(count);
        return true;
    }

    // Whether no triangle at the side between the first and the last vertex will do, whatever the rest.
    bool fails_at_base(int first, int count, Region region, double needed) {
        first_ = first;
        region_ = region;
        for (int k = 1; k + 1 < count; ++k) {
            if (triangle_value(0, k, count - 1, needed) >= needed) return false;
        }
        return true;
    }

  private:
    std::uint32_t vertex(int n) const {
        return edit_.ring.ring[static_cast<std::size_t>(first_ + n) % edit_.ring.ring.size()];
    }
    Cell upper(int i, int k, int j) const { return {vertex(i), vertex(k), vertex(j), edit_.ring.b}; }
    Cell lower(int i, int k, int j) const { return {vertex(i), vertex(j), vertex(k), edit_.ring.a}; }

    double triangle_value(int i, int k, int j, double needed) const {
        const double above = edit_.value(upper(i, k, j), region_, threshold_);
        if (above < needed) return above;
        return std::min(above, edit_.value(lower(i, k, j), region_, threshold_));
    }

    void emit(int count) {
        std::array<std::array<int, 2>, most_ring> stack;
        int height = 0;
        stack[height++] = {0, count - 1};
        while (height > 0) {
            const auto [i, j] = stack[--height];
            if (j - i < 2) continue;
            const int k = apex_[i][j];
            edit_.scratch.cells.push_back(upper(i, k, j));
            edit_.scratch.cells.push_back(lower(i, k, j));
            edit_.scratch.regions.insert(edit_.scratch.regions.end(), 2, region_);
            stack[height++] = {i, k};
            stack[height++] = {k, j};
        }
    }

    EditContext& edit_;
    const QualityThreshold& threshold_;
    int first_ = 0;
    Region region_ = 0;
    std::array<std::array<double, most_ring>, most_ring> best_{};
    std::array<std::array<int, most_ring>, most_ring> apex_{};
};

// Where the region changes round a ring: ring[n] for the facets (a, b, ring[n]) between two regions.
struct RingFacets {
    int count = 0;
    std::array<int, 2> at{};
};

RingFacets interface_facets(const EditContext& edit) {
    RingFacets facets;
    const auto& cells = edit.ring.cells;
    for (std::size_t n = 0; n < cells.size(); ++n) {
        const std::size_t before = n == 0 ? cells.size() - 1 : n - 1;
        if (edit.mesh.region(cells[n]) == edit.mesh.region(cells[before])) continue;
        if (facets.count < 2) facets.at[facets.count] = static_cast<int>(n);
        ++facets.count;
    }
    return facets;
}

// Edge of a cell that joins two of its vertices.
int edge_between(const Cell& cell, std::uint32_t u, std::uint32_t v) {
    for (int e = 0; e < 6; ++e) {
        const std::uint32_t a = cell[cell_edges[e][0]], b = cell[cell_edges[e][1]];
        if ((a == u && b == v) || (a == v && b == u)) return e;
    }
    return 6;
}

// The facets abc, abd of an interface become acd, bcd: near enough to the field's interface, and not folded?
bool may_flip(EditContext& edit, std::uint32_t c, std::uint32_t d, Region above, Region below) {
    const std::uint32_t a = edit.ring.a, b = edit.ring.b;
    if (edit.constraints.fixed_edge(a, b) || edit.spoils_section(a, c, d, above, below) ||
        edit.spoils_section(b, c, d, above, below))
        return false;
    const Vec3 pa = edit.mesh.point(a), pb = edit.mesh.point(b), pc = edit.mesh.point(c),
               pd = edit.mesh.point(d);
    const Vec3 old_1 = cross(pb - pa, pc - pa), old_2 = cross(pd - pa, pb - pa);
    const Vec3 new_1 = cross(pd - pa, pc - pa), new_2 = cross(pc - pb, pd - pb);
    const Vec3 mean = old_1 + old_2;
    if (!(dot(new_1, mean) > 0.5 * length(new_1) * length(mean)) ||
        !(dot(new_2, mean) > 0.5 * length(new_2) * length(mean))) {
        return false;
    }
    edit.look_between(above, below);
    const double now = std::max(edit.facet_distance(pa, pd, pc), edit.facet_distance(pd, pb, pc));
    if (now <= edit.options.max_deviation_mm) return true;
    return now <= edit.facet_distance(pa, pb, pc) || now <= edit.facet_distance(pa, pb, pd);
}

bool remove_surface_edge(EditContext& edit, const RingFacets& facets, const QualityThreshold& threshold,
                         double needed) {
    const auto size = static_cast<int>(edit.ring.ring.size());
    const int from = facets.at[0], to = facets.at[1];
    const std::uint32_t c = edit.ring.ring[static_cast<std::size_t>(from)],
                        d = edit.ring.ring[static_cast<std::size_t>(to)];
    const Region between = edit.mesh.region(edit.ring.cells[static_cast<std::size_t>(from)]);
    const Region beyond = edit.mesh.region(edit.ring.cells[static_cast<std::size_t>(to)]);
    const int arc = to - from;
    RingTriangulation triangulation(edit, threshold);
    // An arc of one cell has the diagonal as an edge already: then it must not be an edge of an interface.
    if (arc == 1 || arc == size - 1) {
        const std::uint32_t lone = edit.ring.cells[static_cast<std::size_t>(arc == 1 ? from : to)];
        const int edge = edge_between(edit.mesh.cell(lone), c, d);
        if (edit.speculation.local_only) {
            edit.speculation.proposal.lone = lone;
            edit.speculation.proposal.lone_edge = edge;
        } else if (edit.mesh.edge_on_interface(lone, edge)) {
            return false;
        }
        if (!triangulation.append(0, size, arc == 1 ? beyond : between, needed)) return false;
    } else if (triangulation.fails_at_base(from, arc + 1, between, needed) ||
               triangulation.fails_at_base(to, size - arc + 1, beyond, needed) ||
               !triangulation.append(from, arc + 1, between, needed) ||
               !triangulation.append(to, size - arc + 1, beyond, needed)) {
        return false;
    }
    return may_flip(edit, c, d, between, beyond) &&
           edit.commit(edit.ring.cells, edit.scratch.cells, edit.scratch.regions);
}

}  // namespace

bool remove_edge(EditContext& edit, std::uint32_t cell, int e) {
    edit.mesh.ring(cell, e, edit.ring);
    const auto size = static_cast<int>(edit.ring.ring.size());
    if (!edit.ring.closed || size < 3 || size > most_ring) return false;
    const RingFacets facets = interface_facets(edit);
    if (facets.count > 2) return false;
    const QualityThreshold threshold = edit.threshold_of(edit.ring.cells);
    edit.scratch.cells.clear();
    edit.scratch.regions.clear();
    if (facets.count == 2) {
        if (!remove_surface_edge(edit, facets, threshold, edit.rule.needed_sine(threshold))) return false;
        edit.count(&OperationCounts::surface_edges_flipped);
        return true;
    }
    if (!RingTriangulation(edit, threshold)
             .append(0, size, edit.mesh.region(cell), edit.rule.needed_sine(threshold)))
        return false;
    if (!edit.commit(edit.ring.cells, edit.scratch.cells, edit.scratch.regions)) return false;
    edit.count(&OperationCounts::edges_removed);
    return true;
}

bool flip_edge(EditContext& edit, std::uint32_t cell, int e, double good_sine) {
    edit.mesh.ring(cell, e, edit.ring);
    const auto size = static_cast<int>(edit.ring.ring.size());
    if (!edit.ring.closed || size < 3 || size > most_ring) return false;
    const RingFacets facets = interface_facets(edit);
    if (facets.count != 2) return false;
    const QualityThreshold threshold = edit.threshold_of(edit.ring.cells);
    edit.scratch.cells.clear();
    edit.scratch.regions.clear();
    if (!remove_surface_edge(edit, facets, threshold, std::min(threshold.sine, good_sine))) return false;
    edit.count(&OperationCounts::surface_edges_smoothed);
    return true;
}

}  // namespace anatomesh
