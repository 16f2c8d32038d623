#include "anatomesh/improve/surgery/relabel_membrane_neighborhood.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <set>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/cell_snapshot.h"
#include "anatomesh/improve/core/star_components.h"
#include "anatomesh/improve/core/surface_count.h"
#include "anatomesh/improve/core/surface_incidence.h"
#include "anatomesh/improve/surgery/resolve_pinches.h"

namespace anatomesh {

namespace {

constexpr double middle = 0.5;  // where an edge between two vertices of a membrane is cut [1; 0 to 1; D]

class MembraneNeighborhood {
  public:
    MembraneNeighborhood(EditContext& edit, const ContourOwners& owners,
                         const MembraneRelabelling& relabelling)
        : edit_(edit),
          owners_(owners),
          given_(relabelling),
          side_(edit.table->contains(relabelling.own, relabelling.chain.structure)),
          incidence_(edit),
          on_membrane_(relabelling.membrane.vertices()),
          first_new_(static_cast<std::uint32_t>(edit.mesh.point_count())) {}

    std::optional<RelabelledNeighborhood> run(SectionAreas* areas) {
        find_cells();
        if (!cut_edges()) return std::nullopt;
        std::vector<std::uint32_t> relabelled = cells_between_cuts();
        const std::optional<Region> to =
            given_.across && given_.across->to ? given_.across->to : region_across(relabelled);
        if (!to || relabelled.empty() || !leave_one_part(relabelled, *to)) return std::nullopt;
        if (given_.across) {
            auto joined =
                resolve_pinches(edit_,
                                {structure(), given_.own, *to, given_.reach == MembraneReach::others,
                                 given_.thickness, on_membrane_, first_new_},
                                std::move(relabelled));
            if (!joined) return std::nullopt;
            relabelled = std::move(*joined);
        }
        note_changed(relabelled);
        SurfaceCount count(edit_, owners_, relabelled, *to);
        const SurfaceCount::Figures before = count.figures();
        if (areas) made_.wrong_of_cuts -= areas->wrong(relabelled);
        for (const std::uint32_t c : relabelled) edit_.mesh.set_region(c, *to);
        if (areas) made_.wrong_of_cuts += areas->wrong(relabelled);
        const SurfaceCount::Figures after = count.figures();
        const bool sound = after.excess == 0 && may_become(count, before, after) && count.newly_lost() == 0 &&
                           incidence_.on_surface(given_.chain.vertices, structure());
        return sound ? std::optional(std::move(made_)) : std::nullopt;
    }

  private:
    std::uint32_t structure() const { return given_.chain.structure; }

    // A subsegment of the structure on the membrane's rim: of the chain, or of a contour that the surface has
    // already; or, there, of an edge of a contour that was cut since the owners were made. The context has
    // the edge's ring.
    bool is_rim_subsegment(std::uint32_t a, std::uint32_t b) const {
        if (!given_.membrane.has_on_rim(a, b)) return false;
        bool known = false;
        for (const ContourOwners::Subsegment& subsegment : owners_.subsegments_at(a)) {
            if (subsegment.other != b) continue;
            if (subsegment.structure == structure()) return true;
            known = true;
        }
        return !known && edit_.constraints.fixed_edge(a, b) && incidence_.ring_is_mixed(structure());
    }

    bool may_become(const SurfaceCount& count, const SurfaceCount::Figures& before,
                    const SurfaceCount::Figures& after) {
        const std::span<const int> was = count.of_structures(before), is = count.of_structures(after);
        for (std::size_t n = 0; n < was.size(); ++n) {
            if (is[n] == was[n]) continue;
            const bool of_chain = count.structures()[n] == structure();
            const bool both = given_.across && given_.across->sides == MembraneSides::both;
            if (both && of_chain && is[n] == was[n] - 2) {
                made_.joins = true;
                continue;
            }
            if (!given_.across || (both && !of_chain) || is[n] != was[n] + 2) return false;
            made_.parted.push_back(count.structures()[n]);
        }
        return true;
    }

    // Those of other regions stay, for the sake of the surfaces of other structures.
    bool may_go(std::uint32_t c) const { return edit_.mesh.region(c) == given_.own; }

    bool is_on(std::uint32_t v) const {
        return std::binary_search(on_membrane_.begin(), on_membrane_.end(), v);
    }

    // Those that may go, and their edges that leave the membrane.
    void find_cells() {
        const bool both = !given_.across || given_.across->sides == MembraneSides::both;
        for (const std::uint32_t c : both ? cells_at_edges() : cells_on_side()) {
            const Cell& cell = edit_.mesh.cell(c);
            cells_.push_back(CellSnapshot::of(edit_.mesh, c));
            for (const std::uint32_t d : cell) {
                for (const std::uint32_t x : cell) {
                    if (is_on(d) && (!is_on(x) || (d < x && !given_.membrane.has_edge(d, x))))
                        edges_.push_back({d, x});
                }
            }
        }
        sort_distinct(edges_);
    }

    // Those with an edge of the membrane that is no subsegment of its rim.
    std::vector<std::uint32_t> cells_at_edges() {
        std::vector<std::uint32_t> cells;
        for (const auto& facet : given_.membrane.facets) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = facet[k], b = facet[(k + 1) % 3];
                if (!incidence_.find_ring(a, b)) continue;
                if (is_rim_subsegment(a, b)) {
                    if (given_.across) add_beside(facet[(k + 2) % 3], cells);
                    continue;
                }
                std::copy_if(edit_.ring.cells.begin(), edit_.ring.cells.end(), std::back_inserter(cells),
                             [&](std::uint32_t c) { return may_go(c); });
            }
        }
        sort_distinct(cells);
        return cells;
    }

    // Those that facets at vertices of the membrane, but none of it, join to one at its first facet; none,
    // where that leads round it.
    std::vector<std::uint32_t> cells_on_side() {
        std::vector<std::uint32_t> ends;
        const std::array<std::uint32_t, 3>& start = given_.membrane.facets.front();
        const std::uint32_t a = start[0], b = start[1], w = start[2];
        if (!incidence_.find_ring(a, b)) return {};
        std::copy_if(edit_.ring.cells.begin(), edit_.ring.cells.end(), std::back_inserter(ends),
                     [&](std::uint32_t c) {
                         const Cell& cell = edit_.mesh.cell(c);
                         return may_go(c) && std::find(cell.begin(), cell.end(), w) != cell.end();
                     });
        if (ends.size() != 2) return {};
        const auto [low, high] = std::minmax(ends[0], ends[1]);
        const bool first = given_.across->sides == MembraneSides::first;
        std::vector<std::uint32_t> cells{first ? low : high};
        std::set<std::uint32_t> known{cells[0]};
        for (std::size_t n = 0; n < cells.size(); ++n) {
            for (int i = 0; i < 4; ++i) {
                const Cell& cell = edit_.mesh.cell(cells[n]);
                const std::uint32_t next = edit_.mesh.neighbor(cells[n], i);
                if (next == no_cell || !may_go(next)) continue;
                std::array facet{cell[facet_vertices[i][0]], cell[facet_vertices[i][1]],
                                 cell[facet_vertices[i][2]]};
                if (std::none_of(facet.begin(), facet.end(), [&](std::uint32_t v) { return is_on(v); }))
                    continue;
                std::sort(facet.begin(), facet.end());
                if (std::binary_search(given_.membrane.facets.begin(), given_.membrane.facets.end(), facet))
                    continue;
                if (known.insert(next).second) cells.push_back(next);
            }
        }
        if (known.contains(first ? high : low)) return {};
        return cells;
    }

    // Of the ring of a subsegment, from the membrane's facet to this vertex on both ways round: cells up to
    // the other side of the structure, if that is reached before half a turn.
    void add_beside(std::uint32_t membrane_vertex, std::vector<std::uint32_t>& cells) const {
        const EdgeRing& ring = edit_.ring;
        const std::size_t count = ring.cells.size();
        const auto at = static_cast<std::size_t>(
            std::find(ring.ring.begin(), ring.ring.end(), membrane_vertex) - ring.ring.begin());
        if (at == count) return;
        const Vec3 from = edit_.mesh.point(ring.a);
        const Vec3 in = cross(given_.across->normal, edit_.mesh.point(ring.b) - from);
        const double inward = dot(in, edit_.mesh.point(membrane_vertex) - from);
        for (const bool onward : {true, false}) {
            std::vector<std::uint32_t> part;
            bool over = false;
            for (std::size_t n = 0; n < count; ++n) {
                const std::size_t i = onward ? (at + n) % count : (at + 2 * count - 1 - n) % count;
                const std::uint32_t c = ring.cells[i];
                if (!may_go(c)) {
                    if (incidence_.has(c, structure()) != side_)
                        cells.insert(cells.end(), part.begin(), part.end());
                    break;
                }
                part.push_back(c);
                // Beyond the subsegment, where the next vertex is on the other side of the plane than those
                // before.
                const Vec3 next = edit_.mesh.point(ring.ring[onward ? (i + 1) % count : i]) - from;
                const double height = dot(given_.across->normal, next);
                if (n > 0 && (height > 0) != over) break;
                over = height > 0;
                if (height == 0 && dot(in, next) * inward < 0) break;
            }
        }
    }

    // But for those on the surface. False where a cell would not be positive.
    bool cut_edges() {
        for (const auto& [d, x] : edges_) {
            if (!incidence_.find_ring(d, x)) return false;
            if (incidence_.ring_is_mixed(structure()) &&
                (given_.reach < MembraneReach::near || edit_.constraints.fixed_edge(d, x))) {
                if (!is_on(x)) beside_.push_back(x);
                continue;
            }
            cut_.push_back({d, x});
            if (!cut(d, x, is_on(x) ? middle : given_.thickness)) return false;
        }
        sort_distinct(beside_);
        return true;
    }

    // The edge whose ring the context has.
    bool cut(std::uint32_t a, std::uint32_t b, double share) {
        const Vec3 from = edit_.mesh.point(a);
        return edit_.split_ring(from + share * (edit_.mesh.point(b) - from)) != no_cell;
    }

    // Of all at vertices of the membrane and new ones.
    std::vector<std::uint32_t> cells_between_cuts() {
        std::vector<std::uint32_t> look = on_membrane_, relabelled;
        for (auto v = first_new_; v < edit_.mesh.point_count(); ++v) look.push_back(v);
        for (const std::uint32_t v : look) {
            edit_.mesh.star(v, edit_.star);
            std::copy_if(edit_.star.begin(), edit_.star.end(), std::back_inserter(relabelled),
                         [&](std::uint32_t c) { return may_go(c); });
        }
        sort_distinct(relabelled);
        std::erase_if(relabelled, [&](std::uint32_t c) { return !lies_between_cuts(c); });
        return relabelled;
    }

    // Where what is relabelled parts the cells left of the chain's region at a vertex of the membrane - on
    // its rim, between cells that have no edge of it -, one part stays there; near the vertex the others are
    // relabelled too. False where a cell would not be positive.
    bool leave_one_part(std::vector<std::uint32_t>& relabelled, Region to) {
        std::vector<Region> before;
        const auto relabel = [&](std::uint32_t c) {
            before.push_back(edit_.mesh.region(c));
            edit_.mesh.set_region(c, to);
        };
        std::for_each(relabelled.begin(), relabelled.end(), relabel);
        for (const std::uint32_t v : on_membrane_) {
            const auto parts = star_components(edit_, v, [&](std::uint32_t c) { return may_go(c); });
            if (parts.size() < 2) continue;
            made_.parts_cells = true;
            const auto stays = worthiest_at(edit_, v, parts);
            for (auto part = parts.begin(); part != parts.end(); ++part) {
                if (part != stays && !cut_near(v, *part)) return false;
            }
            for (const auto& part : star_components(edit_, v, [&](std::uint32_t c) { return may_go(c); })) {
                if (std::find(part.begin(), part.end(), stays->front()) != part.end()) continue;
                relabelled.insert(relabelled.end(), part.begin(), part.end());
                std::for_each(part.begin(), part.end(), relabel);
            }
        }
        for (std::size_t n = 0; n < relabelled.size(); ++n) edit_.mesh.set_region(relabelled[n], before[n]);
        return true;
    }

    // Of the edges from the vertex those within the cells.
    bool cut_near(std::uint32_t v, const std::vector<std::uint32_t>& cells) {
        std::vector<std::uint32_t> ends;
        for (const std::uint32_t c : cells)
            ends.insert(ends.end(), edit_.mesh.cell(c).begin(), edit_.mesh.cell(c).end());
        sort_distinct(ends);
        std::erase(ends, v);
        return std::all_of(ends.begin(), ends.end(), [&](std::uint32_t x) {
            return incidence_.find_ring(v, x) &&
                   (incidence_.ring_is_mixed(structure()) || cut(v, x, given_.thickness));
        });
    }

    void note_changed(const std::vector<std::uint32_t>& relabelled) {
        made_.changed = relabelled;
        for (auto v = first_new_; v < edit_.mesh.point_count(); ++v) {
            edit_.mesh.star(v, edit_.star);
            made_.changed.insert(made_.changed.end(), edit_.star.begin(), edit_.star.end());
        }
        sort_distinct(made_.changed);
    }

    bool lies_between_cuts(std::uint32_t c) const {
        const Cell& cell = edit_.mesh.cell(c);
        if (std::none_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return is_on(v); })) return false;
        const CellSnapshot* was = cell_before(c);
        return was && std::all_of(cell.begin(), cell.end(), [&](std::uint32_t v) {
                   return v >= first_new_ || is_on(v) || stays(*was, v);
               });
    }

    // That in which a cell lies.
    const CellSnapshot* cell_before(std::uint32_t c) const { return find_snapshot(cells_, edit_.mesh, c); }

    // Whether what is relabelled reaches to a vertex beside the membrane.
    bool stays(const CellSnapshot& was, std::uint32_t v) const {
        if (!std::binary_search(beside_.begin(), beside_.end(), v)) return false;
        return given_.reach != MembraneReach::joined ||
               std::none_of(was.cell.begin(), was.cell.end(), [&](std::uint32_t d) {
                   return is_on(d) && std::binary_search(cut_.begin(), cut_.end(), std::array{d, v});
               });
    }

    // Of those at the chain's ends on the other side the one most like that of the cells.
    std::optional<Region> region_across(const std::vector<std::uint32_t>& relabelled) {
        if (relabelled.empty()) return std::nullopt;
        const std::vector<std::uint32_t>& here = edit_.table->members[edit_.mesh.region(relabelled.front())];
        std::optional<std::pair<std::size_t, Region>> best;
        for (const std::uint32_t end : {given_.chain.vertices.front(), given_.chain.vertices.back()}) {
            edit_.mesh.star(end, edit_.star);
            for (const std::uint32_t c : edit_.star) {
                if (incidence_.has(c, structure()) == side_) continue;
                const std::vector<std::uint32_t>& there = edit_.table->members[edit_.mesh.region(c)];
                std::vector<std::uint32_t> differ;
                std::set_symmetric_difference(here.begin(), here.end(), there.begin(), there.end(),
                                              std::back_inserter(differ));
                const std::pair<std::size_t, Region> offer{differ.size(), edit_.mesh.region(c)};
                if (!best || offer < *best) best = offer;
            }
        }
        if (!best) return std::nullopt;
        return best->second;
    }

    EditContext& edit_;
    const ContourOwners& owners_;
    const MembraneRelabelling& given_;
    bool side_;  // of the structure, on which the chain lies
    SurfaceIncidence incidence_;
    std::vector<std::uint32_t> on_membrane_, beside_;        // vertices
    std::vector<std::array<std::uint32_t, 2>> edges_, cut_;  // from a vertex of the membrane on
    std::vector<CellSnapshot> cells_;
    std::uint32_t first_new_;  // vertex
    RelabelledNeighborhood made_;
};

}  // namespace

std::optional<RelabelledNeighborhood> relabel_membrane_neighborhood(EditContext& edit,
                                                                    const ContourOwners& owners,
                                                                    const MembraneRelabelling& relabelling,
                                                                    SectionAreas* areas) {
    return MembraneNeighborhood(edit, owners, relabelling).run(areas);
}

}  // namespace anatomesh
