#include "anatomesh/improve/sections/repair_section_locally.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/improve/core/failed_attempt_cache.h"
#include "anatomesh/improve/sections/facet_worklist.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/sections/section_operations.h"

namespace anatomesh {

namespace {

// Places in vain: so many are of slices that contradict each other. [places; > 0; B]
constexpr std::uint64_t most_vain = 10'000;
// Share of what is drawn: less is not repaired where planes cross. [1; 0 to 1; M 2026-11 labels of a body]
constexpr double least_wrong_of_crossing = 1e-6;

class LocalSectionRepair {
  public:
    LocalSectionRepair(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                       const RunContext& context)
        : edit_(edit),
          context_(context),
          areas_(edit, drawn),
          section_{edit, areas_, *drawn.owners, drawn.extents.empty() ? 0 : least_wrong_of_crossing},
          bounds_{{{std::sin(edit.options.target_degrees * radians_per_degree), edit.options.max_radius_edge},
                   {least_sine, edit.options.max_radius_edge},
                   {least_sine, edit.options.last_radius_edge}}} {}

    // From these cells on, rising.
    LocalRepairStats run(std::vector<std::uint32_t> waiting) {
        repair_all(waiting, 1);
        // Sections that still are further from what is drawn are worth worse cells. What a surface that just
        // passes through a plane makes wrong may lie in any cell that has a vertex of it.
        std::vector<std::uint32_t> passed = waiting;
        std::erase_if(passed, [&](std::uint32_t c) { return !is_suspect(c); });
        areas_.sum_cuts_round(passed, context_.threads);
        repair_all(waiting, bounds_.size());
        std::erase_if(waiting, [&](std::uint32_t c) { return !is_suspect(c); });
        stats_.left = std::move(waiting);
        return stats_;
    }

    bool is_suspect(std::uint32_t c) const { return next_facet(c, 0) < 4; }

    // The first facet of the cell from that on that passes through a plane or lies in it, and is between
    // regions, or, in it, in one beside others; 4: none.
    int next_facet(std::uint32_t c, int from) const {
        if (!edit_.mesh.alive(c)) return 4;
        std::array<bool, 4> between{};
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t other = edit_.mesh.neighbor(c, i);
            between[i] = other != no_cell && edit_.mesh.region(other) != edit_.mesh.region(c);
        }
        if (std::find(between.begin(), between.end(), true) == between.end()) return 4;
        const Cell& cell = edit_.mesh.cell(c);
        for (int i = from; i < 4; ++i) {
            if (edit_.mesh.neighbor(c, i) == no_cell) continue;
            const auto& f = facet_vertices[i];
            const std::array facet{cell[f[0]], cell[f[1]], cell[f[2]]};
            if ((between[i] && areas_.passes_between(facet)) || areas_.plane_of(facet) != no_slice) return i;
        }
        return 4;
    }

    FacetVisit visit(std::uint32_t c, int i) {
        if (!section_.is_worth_it(wrong_at(c, i))) return FacetVisit::next_facet;
        ++stats_.places_found;
        if (count_ > 1 && areas_.largest_cut_at(c, i) < much_of_cut) return FacetVisit::next_facet;
        if (!repair(c, i)) {
            ++vain_;
            return FacetVisit::next_facet;
        }
        stats_.changed.insert(stats_.changed.end(), edit_.changed.begin(), edit_.changed.end());
        failed_.note_change(edit_.mesh, edit_.changed);
        return FacetVisit::changed;
    }

  private:
    // Within the first so many bounds; `waiting` grows by the cells to be looked at again.
    void repair_all(std::vector<std::uint32_t>& waiting, std::size_t count) {
        count_ = count;
        vain_ = 0;
        visit_facets(edit_, waiting, *this, [&] { return vain_ < most_vain && !context_.cancelled(); });
    }

    // Of the facet alone where it lies in one region: what cells beside it have wrong is found at others.
    double wrong_at(std::uint32_t c, int i) {
        const std::uint32_t other = edit_.mesh.neighbor(c, i);
        return edit_.mesh.region(other) == edit_.mesh.region(c) ? areas_.wrong_in_plane(c, i)
                                                                : areas_.wrong_at(c, i);
    }

    // By the first operation that halves what is wrong, within the first bounds that allow one.
    bool repair(std::uint32_t c, int i) {
        const std::uint32_t other = edit_.mesh.neighbor(c, i);
        const Region here = edit_.mesh.region(c), there = edit_.mesh.region(other);
        const auto last = bounds_.begin() + static_cast<std::ptrdiff_t>(count_);
        if (here == there) {
            return std::any_of(bounds_.begin(), last, [&](const CellBounds& bounds) {
                if (!relabel_both_at_section(section_, {c, other}, bounds)) return false;
                stats_.cells_relabelled += 2;
                return true;
            });
        }
        std::vector<std::uint32_t> vertices(edit_.mesh.cell(c).begin(), edit_.mesh.cell(c).end());
        for (const std::uint32_t v : edit_.mesh.cell(other)) {
            if (std::find(vertices.begin(), vertices.end(), v) == vertices.end()) vertices.push_back(v);
        }
        return std::any_of(bounds_.begin(), last, [&](const CellBounds& bounds) {
            return std::any_of(vertices.begin(), vertices.end(),
                               [&](std::uint32_t v) { return move(v, bounds); }) ||
                   relabel(c, there, bounds) || relabel(other, here, bounds) || flip(c, i, bounds) ||
                   collapse(c, i, bounds) || refill(c, i, bounds) ||
                   (count_ > 1 && (leave_vertex(c, there, bounds) || leave_vertex(other, here, bounds)));
        });
    }

    enum class Operation : std::uint32_t { move, leave_vertex, collapse, relabel, flip };

    // Not if it was in vain, and no cell at these vertices has changed since: cells at several facets share
    // vertices, edges and cells. What is done is counted.
    template <class Operate>
    bool try_anew(Operation operation, const CellBounds& bounds, std::array<std::uint32_t, 3> of,
                  std::span<const std::uint32_t> vertices, const Operate& operate) {
        const auto bound = static_cast<std::uint32_t>(&bounds - bounds_.data());
        const FailedAttemptCache::Name name{static_cast<std::uint32_t>(operation) * 16 + bound, of[0], of[1],
                                            of[2]};
        if (failed_.contains(name, vertices)) return false;
        if (operate()) {
            ++counter_of(operation);
            return true;
        }
        failed_.add(name);
        return false;
    }

    std::uint64_t& counter_of(Operation operation) {
        switch (operation) {
            case Operation::move:
                return stats_.vertices_moved;
            case Operation::relabel:
                return stats_.cells_relabelled;
            case Operation::flip:
                return stats_.edges_flipped;
            case Operation::collapse:
                return stats_.edges_collapsed;
            case Operation::leave_vertex:
                break;
        }
        return stats_.vertices_inserted;
    }

    bool move(std::uint32_t v, const CellBounds& bounds) {
        return try_anew(Operation::move, bounds, {v, 0, 0}, std::array{v},
                        [&] { return move_across_plane(section_, v, bounds); });
    }

    bool relabel(std::uint32_t c, Region to, const CellBounds& bounds) {
        return try_anew(Operation::relabel, bounds, {c, to, 0}, edit_.mesh.cell(c),
                        [&] { return relabel_at_section(section_, c, to, bounds); });
    }

    // The ends of a cell's edge, if it is one of the facet and between vertices on both sides of a plane;
    // else no_cell.
    std::array<std::uint32_t, 2> edge_across(std::uint32_t c, int i, int e) const {
        const auto [a, b] = cell_edges[static_cast<std::size_t>(e)];
        const Cell& cell = edit_.mesh.cell(c);
        const std::array ends{cell[a], cell[b]};
        if (a == i || b == i || !areas_.passes_between(ends)) return {no_cell, no_cell};
        return ends;
    }

    // The facet's edge between vertices on both sides of a plane.
    bool flip(std::uint32_t c, int i, const CellBounds& bounds) {
        for (int e = 0; e < 6; ++e) {
            const auto [a, b] = edge_across(c, i, e);
            if (a == no_cell || edit_.constraints.fixed_edge(a, b)) continue;
            const std::array ends{std::min(a, b), std::max(a, b)};
            if (try_anew(Operation::flip, bounds, {ends[0], ends[1], 0}, ends,
                         [&] { return flip_across_plane(section_, c, e, bounds); }))
                return true;
        }
        return false;
    }

    // A free vertex of the facet goes along an edge that passes through a plane.
    bool collapse(std::uint32_t c, int i, const CellBounds& bounds) {
        for (int e = 0; e < 6; ++e) {
            const auto [a, b] = edge_across(c, i, e);
            if (a == no_cell) continue;
            for (const bool first_onto_second : {true, false}) {
                const std::uint32_t from = first_onto_second ? a : b, to = first_onto_second ? b : a;
                if (edit_.constraints.fixed(from)) continue;
                const std::array ends{from, to};
                if (try_anew(Operation::collapse, bounds, {from, to, 0}, ends, [&] {
                        return collapse_across_plane(section_, c, e, first_onto_second, bounds);
                    }))
                    return true;
            }
        }
        return false;
    }

    bool refill(std::uint32_t c, int i, const CellBounds& bounds) {
        if (!refill_beside_plane(section_, c, i, bounds)) return false;
        ++stats_.vertices_inserted;
        return true;
    }

    // The surface between the cell's region and `to` leaves a free vertex of the cell that lies beyond a
    // plane.
    bool leave_vertex(std::uint32_t c, Region to, const CellBounds& bounds) {
        const Cell cell = edit_.mesh.cell(c);
        return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) {
            const Region own = edit_.mesh.region(c);
            return (!edit_.constraints.fixed(v) || edit_.constraints.settled(v)) &&
                   try_anew(Operation::leave_vertex, bounds, {v, own, to}, std::array{v},
                            [&] { return leave_vertex_beyond_plane(section_, v, own, to, bounds); });
        });
    }

    EditContext& edit_;
    const RunContext& context_;
    SectionAreas areas_;
    SectionEdit section_;
    std::array<CellBounds, 3> bounds_;
    std::size_t count_ = 1;   // of the bounds, the first that are tried
    std::uint64_t vain_ = 0;  // places, in this pass
    LocalRepairStats stats_;
    FailedAttemptCache failed_;
};

}  // namespace

LocalRepairStats repair_section_locally(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                        const RunContext& context, const std::vector<std::uint32_t>* look) {
    if (!drawn.table || !drawn.owners || drawn.planes.empty()) return {};
    LocalSectionRepair repair(edit, drawn, least_sine, context);
    if (!look) return repair.run(suspect_cells(edit.mesh, repair, context.threads));
    std::vector<std::uint32_t> cells = *look;
    sort_distinct(cells);
    return repair.run(std::move(cells));
}

}  // namespace anatomesh
