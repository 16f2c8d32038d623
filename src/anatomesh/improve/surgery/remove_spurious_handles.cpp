#include "anatomesh/improve/surgery/remove_spurious_handles.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/surgery/membrane_surgery.h"
#include "anatomesh/improve/surgery/spanning_membranes.h"
#include "anatomesh/mesh/check/topology.h"

namespace anatomesh {

namespace {

// Attempts whose cells are improved in vain. [attempts; > 0; B]
constexpr std::size_t most_closed_in_vain = 60;
constexpr std::size_t most_handles =
    200;  // where more are found, cells do not fit the contours [handles; > 0; B]
constexpr std::array handle_reaches{MembraneReach::near, MembraneReach::joined, MembraneReach::wide};

// What lies on the two sides of loops of edges on a closed oriented surface.
class SurfaceSides {
  public:
    explicit SurfaceSides(std::span<const Triangle> triangles) : triangles_(triangles) {
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k)
                sides_.push_back({triangles[t][k], triangles[t][(k + 1) % 3], t});
        }
        std::sort(sides_.begin(), sides_.end());
    }

    // Whether a simple loop has different parts of the surface on its two sides. Linear in the smaller one.
    bool are_parted_by(std::span<const std::uint32_t> loop) const {
        std::set<Edge> rim;
        for (std::size_t n = 0; n < loop.size(); ++n)
            rim.insert(std::minmax(loop[n], loop[(n + 1) % loop.size()]));
        std::array<std::vector<std::uint32_t>, 2> seen{std::vector{triangle_at(loop[0], loop[1])},
                                                       std::vector{triangle_at(loop[1], loop[0])}};
        std::array<std::set<std::uint32_t>, 2> known;
        for (std::size_t side = 0; side < 2; ++side) known[side].insert(seen[side][0]);
        for (std::size_t n = 0;; ++n) {  // in turn from either side
            for (std::size_t side = 0; side < 2; ++side) {
                if (n == seen[side].size()) return true;
                const Triangle& from = triangles_[seen[side][n]];
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t a = from[k], b = from[(k + 1) % 3];
                    if (rim.contains(std::minmax(a, b))) continue;
                    const std::uint32_t next = triangle_at(b, a);
                    if (known[1 - side].contains(next)) return false;
                    if (known[side].insert(next).second) seen[side].push_back(next);
                }
            }
        }
    }

    // Of a way from one vertex over another to a third: whether edges that `must_stay` lead off there on
    // either side.
    template <class MustStay>
    std::array<bool, 2> taken_at(std::uint32_t before, std::uint32_t v, std::uint32_t next,
                                 const MustStay& must_stay) const {
        return {any_between(v, next, before, must_stay), any_between(v, before, next, must_stay)};
    }

  private:
    using Edge = std::pair<std::uint32_t, std::uint32_t>;

    std::uint32_t triangle_at(std::uint32_t a, std::uint32_t b) const {
        return (*std::lower_bound(sides_.begin(), sides_.end(), std::array{a, b, 0u}))[2];
    }

    // Of the edges at a vertex those from one to another, round it.
    template <class MustStay>
    bool any_between(std::uint32_t v, std::uint32_t first, std::uint32_t last,
                     const MustStay& must_stay) const {
        for (std::uint32_t at = first;;) {
            Triangle t = triangles_[triangle_at(v, at)];
            while (t[0] != v) t = {t[1], t[2], t[0]};
            at = t[2];
            if (at == last) return false;
            if (must_stay(v, at)) return true;
        }
    }

    std::span<const Triangle> triangles_;
    std::vector<std::array<std::uint32_t, 3>> sides_;  // of every triangle: from, to, and itself
};

class HandleRemoval {
  public:
    HandleRemoval(EditContext& edit, const DrawnSlices& drawn, double reach_mm, double least_sine,
                  const ImproveCells& improve, const RunContext& context)
        : edit_(edit), drawn_(drawn), reach_mm_(reach_mm), context_(context) {
        if (!drawn.planes.empty()) areas_.emplace(edit, drawn);
        surgery_.emplace(edit, drawn, areas_ ? &*areas_ : nullptr, least_sine, improve);
    }

    HandleRemovalStats run() {
        for (const std::vector<std::uint32_t>& members : edit_.table->members) {
            if (!members.empty()) structures_ = std::max(structures_, members.back() + 1);
        }
        for (structure_ = 0; structure_ < structures_; ++structure_) close_all();
        sort_distinct(stats_.changed);
        return std::move(stats_);
    }

  private:
    bool has(std::uint32_t c, std::uint32_t structure) const {
        return edit_.table->contains(edit_.mesh.region(c), structure);
    }
    bool is_enough() const { return context_.cancelled() || improved_ >= most_closed_in_vain; }

    // Of the structure: those that cannot be closed are not tried again.
    void close_all() {
        std::set<std::vector<std::uint32_t>> in_vain;
        for (bool first = true;; first = false) {
            const std::vector<Triangle> surface = surface_of_structure();
            if (surface.empty() || surface_topology(surface).genus <= 0) return;
            std::vector<Vec3> points(edit_.mesh.point_count());
            for (const Triangle& t : surface) {
                for (const std::uint32_t v : t) points[v] = edit_.mesh.point(v);
            }
            const std::vector<SmallHandles> parts = spurious_handles(
                points, surface, structure_, {drawn_.routable.contours, drawn_.routable.vertices}, reach_mm_);
            std::uint64_t found = 0;
            for (const SmallHandles& part : parts) found += part.handles;
            if (first) stats_.found += found;
            if (found > most_handles) return;
            const SurfaceSides sides(surface);
            const bool removed = std::any_of(parts.begin(), parts.end(), [&](const SmallHandles& part) {
                return !is_enough() && in_vain.insert(part.vertices).second && close(part.vertices, sides);
            });
            if (!removed) return;
            ++stats_.removed;
        }
    }

    std::vector<Triangle> surface_of_structure() const {
        std::vector<Triangle> surface;
        for (const std::uint32_t c : edit_.mesh.alive_cells()) {
            if (!has(c, structure_)) continue;
            const Cell& cell = edit_.mesh.cell(c);
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t other = edit_.mesh.neighbor(c, i);
                if (other != no_cell && has(other, structure_)) continue;
                const auto& f = facet_vertices[i];
                surface.push_back({cell[f[0]], cell[f[1]], cell[f[2]]});
            }
        }
        return surface;
    }

    // One handle among the vertices, by the cheapest membrane that does it.
    bool close(const std::vector<std::uint32_t>& vertices, const SurfaceSides& sides) {
        const auto is_subsegment = [&](std::uint32_t a, std::uint32_t b) {
            return edit_.constraints.fixed_edge(a, b);
        };
        const RimSides rim_sides = [&](std::uint32_t before, std::uint32_t v, std::uint32_t next) {
            return sides.taken_at(before, v, next, is_subsegment);
        };
        const auto closes_a_handle = [&](const Membrane& membrane) {
            return membrane.path.size() > 2 && !sides.are_parted_by(membrane.path);
        };
        std::vector<std::pair<Membrane, Region>> membranes;
        for (const bool side : {false, true}) {
            for (Membrane& membrane :
                 find_membranes_across(edit_, structure_, side, vertices, rim_sides, closes_a_handle)) {
                if (const std::optional<Region> own = region_of(membrane))
                    membranes.push_back({std::move(membrane), *own});
            }
        }
        std::stable_sort(membranes.begin(), membranes.end(),
                         [](const auto& x, const auto& y) { return x.first.price < y.first.price; });
        return std::any_of(membranes.begin(), membranes.end(),
                           [&](const auto& membrane) { return relabel(membrane.first, membrane.second); });
    }

    // Of the cells at the membrane's first facet, if it is one.
    std::optional<Region> region_of(const Membrane& membrane) {
        const auto& [a, b, c] = membrane.facets.front();
        edit_.mesh.star(a, edit_.star);
        std::optional<Region> found;
        for (const std::uint32_t cell : edit_.star) {
            const Cell& v = edit_.mesh.cell(cell);
            if (std::find(v.begin(), v.end(), b) == v.end() || std::find(v.begin(), v.end(), c) == v.end())
                continue;
            if (found && *found != edit_.mesh.region(cell)) return std::nullopt;
            found = edit_.mesh.region(cell);
        }
        return found;
    }

    bool relabel(const Membrane& membrane, Region own) {
        SurgeryProposal proposal;
        const std::uint32_t end = contour_vertex_or_first(*drawn_.owners, membrane.path, structure_);
        proposal.relabelling.chain = {{end}, structure_};
        proposal.relabelling.membrane = membrane;
        proposal.relabelling.own = own;
        proposal.topology = TopologyChange::handle_goes;
        proposal.most_mm = edit_.options.spike_mm;
        for (const MembraneSides side : {MembraneSides::first, MembraneSides::second}) {
            proposal.relabelling.across = MembraneAcross{side, {}, {}};
            if (is_enough()) return false;
            if (surgery_->attempt_each(proposal, handle_reaches, membrane_thicknesses,
                                       [&](const SurgeryResult& result) { return note(result); }))
                return true;
        }
        return false;
    }

    bool note(const SurgeryResult& result) {
        improved_ += result.verdict == SurgeryVerdict::in_vain;
        if (result.verdict == SurgeryVerdict::done)
            stats_.changed.insert(stats_.changed.end(), result.changed.begin(), result.changed.end());
        return !is_enough();
    }

    EditContext& edit_;
    const DrawnSlices& drawn_;
    double reach_mm_;
    const RunContext& context_;
    std::optional<SectionAreas> areas_;
    std::optional<MembraneSurgery> surgery_;
    std::uint32_t structures_ = 0, structure_ = 0;
    std::size_t improved_ = 0;  // attempts whose cells were improved in vain
    HandleRemovalStats stats_;
};

}  // namespace

HandleRemovalStats remove_spurious_handles(EditContext& edit, const DrawnSlices& drawn, double reach_mm,
                                           double least_sine, const ImproveCells& improve,
                                           const RunContext& context) {
    if (!drawn.table || !drawn.owners) return {};
    return HandleRemoval(edit, drawn, reach_mm, least_sine, improve, context).run();
}

}  // namespace anatomesh
