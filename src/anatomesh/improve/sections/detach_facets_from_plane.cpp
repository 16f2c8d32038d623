#include "anatomesh/improve/sections/detach_facets_from_plane.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/improve/sections/facet_worklist.h"
#include "anatomesh/improve/sections/refill_from_heights.h"

namespace anatomesh {

namespace {

// The first height of the new vertex, as a share of the cell's height. [1; 0 to 1; M 2026-11, set not
// recorded]
constexpr double first_height = 0.2;
constexpr double height_factor = 1.5;  // from one height to the next [1; > 1; M 2026-11, set not recorded]
constexpr std::array heights{first_height, first_height* height_factor,
                             first_height* height_factor* height_factor,
                             first_height* height_factor* height_factor* height_factor};
// Share of a facet's longest edge: nearer to an interface its middle lies on it.
// [1; 0 to 0.1; M 2026-11 15 ends of a pelvis]
constexpr double flat_end = 1e-3;
constexpr std::size_t most_round_edge = 12;  // between two facets that are detached together [cells; > 0; B]
// Ratio of cells for the sake of what is drawn. [1; > 0; C]
constexpr double last_radius_edge = contract::nearly_bad_radius_edge;

class FacetDetachment {
  public:
    FacetDetachment(EditContext& edit, const DrawnSlices& drawn, double least_sine)
        : edit_(edit), drawn_(drawn), least_sine_(least_sine) {}

    DetachmentStats run(int threads) {
        std::vector<std::uint32_t> waiting = suspect_cells(edit_.mesh, *this, threads);
        visit_facets(edit_, waiting, *this, [] { return true; });
        return std::move(stats_);
    }

    // Whether a facet of the cell lies in a slice.
    bool is_suspect(std::uint32_t c) const {
        if (!edit_.mesh.alive(c)) return false;
        for (int i = 0; i < 4; ++i) {
            if (in_slice(edit_.mesh.cell(c), i)) return true;
        }
        return false;
    }

    int next_facet(std::uint32_t c, int from) {
        if (!edit_.mesh.alive(c)) return 4;
        while (from < 4 && !rests(c, from)) ++from;
        return from;
    }

    FacetVisit visit(std::uint32_t c, int i) {
        const std::size_t detached = detach(c, i);
        stats_.facets_detached += detached;
        if (detached == 0) {
            ++stats_.facets_left;
            return FacetVisit::next_cell;
        }
        stats_.changed.insert(stats_.changed.end(), edit_.changed.begin(), edit_.changed.end());
        return FacetVisit::changed;
    }

  private:
    bool in_slice(const Cell& cell, int i) const {
        const auto slice = [&](int corner) {
            const std::uint32_t v = cell[facet_vertices[i][corner]];
            return v < drawn_.slice_of.size() ? drawn_.slice_of[v] : no_slice;
        };
        return slice(0) != no_slice && slice(1) == slice(0) && slice(2) == slice(0);
    }

    // Whether a facet lies in a slice between regions of which the cell's has a structure that is not drawn
    // there, and the other one what is.
    bool rests(std::uint32_t c, int i) {
        const std::uint32_t other = edit_.mesh.neighbor(c, i);
        if (other == no_cell || edit_.mesh.region(other) == edit_.mesh.region(c) ||
            !in_slice(edit_.mesh.cell(c), i))
            return false;
        // A facet of a flat end lies on the interface itself.
        const double on_interface = flat_end * longest_edge({c, i});
        const InterfaceProbe::Look look = edit_.probe.look(middle({c, i}), on_interface);
        if (look.distance < on_interface) return false;
        const std::vector<std::uint32_t>& there = look.members;
        const std::vector<std::uint32_t>& here = drawn_.table->members[edit_.mesh.region(c)];
        return drawn_.table->members[edit_.mesh.region(other)] == there &&
               !std::includes(there.begin(), there.end(), here.begin(), here.end());
    }

    double longest_edge(Hole::CellFacet facet) const {
        double longest = 0;
        for (int n = 0; n < 3; ++n) {
            const Cell& cell = edit_.mesh.cell(facet.first);
            const auto& f = facet_vertices[facet.second];
            longest = std::max(longest,
                               length(edit_.mesh.point(cell[f[n]]) - edit_.mesh.point(cell[f[(n + 1) % 3]])));
        }
        return longest;
    }

    Vec3 middle(Hole::CellFacet facet) const {
        Vec3 sum{};
        for (const int n : facet_vertices[facet.second])
            sum = sum + (1.0 / 3) * edit_.mesh.point(edit_.mesh.cell(facet.first)[n]);
        return sum;
    }

    // The next facet of the surface round an edge of a resting one - that without its corner n -, seen from
    // inside; `cells`: those between the two.
    std::optional<Hole::CellFacet> beside(Hole::CellFacet facet, int n,
                                          std::vector<std::uint32_t>& cells) const {
        const auto [first, i] = facet;
        std::uint32_t c = first;
        std::uint32_t leave = edit_.mesh.cell(c)[facet_vertices[i][n]], keep = edit_.mesh.cell(c)[i];
        cells.assign(1, c);
        while (cells.size() < most_round_edge) {
            const Cell& cell = edit_.mesh.cell(c);
            const int across = static_cast<int>(std::find(cell.begin(), cell.end(), leave) - cell.begin());
            const std::uint32_t next = edit_.mesh.neighbor(c, across);
            if (next == no_cell) return std::nullopt;
            if (edit_.mesh.region(next) != edit_.mesh.region(c)) return Hole::CellFacet{c, across};
            const Cell& entered = edit_.mesh.cell(next);
            for (const std::uint32_t v : entered) {
                if (std::find(cell.begin(), cell.end(), v) == cell.end()) leave = std::exchange(keep, v);
            }
            cells.push_back(c = next);
        }
        return std::nullopt;
    }

    // Lifts it with another one beside it if there is one, else, or if that can't be done, alone. How many
    // then.
    std::size_t detach(std::uint32_t c, int i) {
        const Hole::CellFacet facet{c, i};
        std::vector<std::uint32_t> cells;
        for (int n = 0; n < 3; ++n) {
            const Cell& cell = edit_.mesh.cell(c);
            const std::optional<Hole::CellFacet> other = beside(facet, n, cells);
            if (!other || !rests(other->first, other->second) ||
                edit_.constraints.fixed_edge(cell[facet_vertices[i][(n + 1) % 3]],
                                             cell[facet_vertices[i][(n + 2) % 3]]) ||
                edit_.mesh.region(edit_.mesh.neighbor(c, i)) !=
                    edit_.mesh.region(edit_.mesh.neighbor(other->first, other->second)))
                continue;
            if (fill(cells, std::array{facet, *other})) return 2;
        }
        return fill({c}, std::array{facet}) ? 1 : 0;
    }

    // From several heights over the facets.
    bool fill(std::vector<std::uint32_t> cells, std::span<const Hole::CellFacet> facets) {
        Refill refill{std::move(cells), facets, {}, {}};
        const double share = 1 / static_cast<double>(facets.size());
        for (const Hole::CellFacet& facet : facets) {
            refill.foot = refill.foot + share * middle(facet);
            refill.top = refill.top + share * edit_.mesh.point(edit_.mesh.cell(facet.first)[facet.second]);
        }
        const auto anywhere = [](Vec3&) { return true; };
        return std::any_of(ratios_.begin(), ratios_.end(), [&](double most) {
            return refill_from_heights(edit_, refill, heights, {least_sine_, most}, anywhere) != no_cell;
        });
    }

    EditContext& edit_;
    const DrawnSlices& drawn_;
    double least_sine_;
    std::array<double, 2> ratios_{edit_.options.max_radius_edge, last_radius_edge};
    DetachmentStats stats_;
};

}  // namespace

DetachmentStats detach_facets_from_plane(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                         int threads) {
    if (!drawn.table || drawn.slice_of.empty()) return {};
    return FacetDetachment(edit, drawn, least_sine).run(threads);
}

}  // namespace anatomesh
