#include "anatomesh/improve/surgery/resolve_pinches.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <iterator>
#include <map>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/cell_snapshot.h"
#include "anatomesh/improve/core/star_components.h"
#include "anatomesh/improve/core/surface_incidence.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_rounds = 3;  // over the edges and vertices [passes; > 0; B]
// Price of a cell on a way between cells at a vertex, for each edge of a contour.
// [cells; > 0; M 2026-11 random solids]
constexpr std::size_t price_of_contours = 4;
// of a cell of another region [cells; > 1; M 2026-11 random solids]
constexpr std::size_t price_of_others = 3;

class PinchResolution {
  public:
    PinchResolution(EditContext& edit, const PinchedSides& joined)
        : edit_(edit), joined_(joined), incidence_(edit) {}

    std::optional<std::vector<std::uint32_t>> run(std::vector<std::uint32_t> relabelled) {
        for (const std::uint32_t c : relabelled) go(c);
        for (std::size_t round = 0, before = 0; round < most_rounds && gone_.size() > before; ++round) {
            before = gone_.size();
            if (!join_at_edges(relabelled)) return std::nullopt;
            relabelled = cells_gone();
            if (!join_at_vertices(relabelled)) return std::nullopt;
            relabelled = cells_gone();
        }
        for (const std::uint32_t c : relabelled)
            edit_.mesh.set_region(c, find_snapshot(gone_, edit_.mesh, c)->region);
        return relabelled;
    }

  private:
    bool is_own(std::uint32_t c) const { return edit_.mesh.region(c) == joined_.own; }
    bool is_across(std::uint32_t c) const { return edit_.mesh.region(c) == joined_.to; }
    bool has_gone(std::uint32_t c) const {
        return is_across(c) && find_snapshot(gone_, edit_.mesh, c) != nullptr;
    }

    void go(std::uint32_t c) {
        gone_.push_back(CellSnapshot::of(edit_.mesh, c));
        edit_.mesh.set_region(c, joined_.to);
    }

    // All of them, at vertices of the membrane, new ones, and those near which more went.
    std::vector<std::uint32_t> cells_gone() {
        std::vector<std::uint32_t> look(joined_.membrane.begin(), joined_.membrane.end()), found;
        for (auto v = joined_.first_new; v < edit_.mesh.point_count(); ++v) look.push_back(v);
        look.insert(look.end(), near_.begin(), near_.end());
        sort_distinct(look);
        for (const std::uint32_t v : look) {
            edit_.mesh.star(v, edit_.star);
            std::copy_if(edit_.star.begin(), edit_.star.end(), std::back_inserter(found),
                         [&](std::uint32_t c) { return is_across(c); });
        }
        sort_distinct(found);
        std::erase_if(found, [&](std::uint32_t c) { return !has_gone(c); });
        return found;
    }

    bool join_at_edges(const std::vector<std::uint32_t>& relabelled) {
        std::vector<std::array<std::uint32_t, 2>> edges;
        for (const std::uint32_t c : relabelled) {
            const Cell& cell = edit_.mesh.cell(c);
            for (const auto& [i, j] : cell_edges)
                edges.push_back({std::min(cell[i], cell[j]), std::max(cell[i], cell[j])});
        }
        sort_distinct(edges);
        return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
            if (!incidence_.find_ring(edge[0], edge[1])) return true;
            const std::vector<std::uint32_t> between = fewest_between();
            return between.empty() || relabel_near({edge[0], edge[1]}, between);
        });
    }

    // Of the context's ring, cells that may go, from what goes on to others of the other side; none, if it is
    // in one part.
    std::vector<std::uint32_t> fewest_between() const {
        const std::vector<std::uint32_t>& ring = edit_.ring.cells;
        const auto first =
            std::find_if(ring.begin(), ring.end(), [&](std::uint32_t c) { return is_across(c); });
        if (first == ring.end() ||
            std::none_of(ring.begin(), ring.end(), [&](std::uint32_t c) { return has_gone(c); }))
            return {};
        std::vector<std::vector<std::uint32_t>> runs;
        bool was_across = true;
        for (std::size_t n = 0; n < ring.size(); ++n) {
            const std::uint32_t c = ring[(static_cast<std::size_t>(first - ring.begin()) + n) % ring.size()];
            if (!is_across(c)) {
                if (was_across) runs.emplace_back();
                runs.back().push_back(c);
            }
            was_across = is_across(c);
        }
        if (runs.size() < 2) return {};
        std::erase_if(runs, [&](const auto& run) {
            return !std::all_of(run.begin(), run.end(), [&](std::uint32_t c) { return is_own(c); });
        });
        if (runs.empty()) return {};
        return *std::min_element(runs.begin(), runs.end(),
                                 [](const auto& x, const auto& y) { return x.size() < y.size(); });
    }

    bool join_at_vertices(const std::vector<std::uint32_t>& relabelled) {
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t c : relabelled)
            vertices.insert(vertices.end(), edit_.mesh.cell(c).begin(), edit_.mesh.cell(c).end());
        sort_distinct(vertices);
        return std::all_of(vertices.begin(), vertices.end(), [&](std::uint32_t v) { return join_at(v); });
    }

    bool join_at(std::uint32_t v) {
        const auto parts = star_components(edit_, v, [&](std::uint32_t c) { return is_across(c); });
        const auto first = std::find_if(parts.begin(), parts.end(), [&](const auto& part) {
            return std::any_of(part.begin(), part.end(), [&](std::uint32_t c) { return has_gone(c); });
        });
        if (first == parts.end()) return true;
        if (parts.size() > 1 && !relabel_near({v}, way_between(v, *first))) return false;
        for (const Region region : regions_at(v)) {
            const auto is_of = [&](std::uint32_t c) { return edit_.mesh.region(c) == region; };
            if (region != joined_.to && !leave_one_part(v, is_of)) return false;
        }
        const bool side = edit_.table->contains(joined_.own, joined_.structure);
        return leave_one_part(
                   v, [&](std::uint32_t c) { return incidence_.has(c, joined_.structure) == side; }) &&
               leave_one_part(v, [&](std::uint32_t c) { return !is_across(c); });
    }

    // Of the cells at the vertex that a way parts.
    template <class Is>
    bool leave_one_part(std::uint32_t v, const Is& is) {
        const std::vector<std::vector<std::uint32_t>> parts = star_components(edit_, v, is);
        const auto stays = worthiest_at(edit_, v, parts);
        for (auto part = parts.begin(); part != parts.end(); ++part) {
            if (part != stays && !relabel_near({v}, *part)) return false;
        }
        return true;
    }

    // What of the cells is near their vertex, or their edge. False where a cell would not be positive.
    bool relabel_near(std::initializer_list<std::uint32_t> vertices,
                      const std::vector<std::uint32_t>& cells) {
        std::vector<CellSnapshot> were;
        std::vector<std::uint32_t> ends, star;
        for (const std::uint32_t c : cells) {
            were.push_back(CellSnapshot::of(edit_.mesh, c));
            ends.insert(ends.end(), were.back().cell.begin(), were.back().cell.end());
        }
        sort_distinct(ends);
        for (const std::uint32_t v : vertices) std::erase(ends, v);
        for (const std::uint32_t v : vertices) {
            for (const std::uint32_t x : ends) {
                if (incidence_.find_ring(v, x) && !edit_.constraints.fixed_edge(v, x) && !cut(v, x))
                    return false;
            }
        }
        near_.insert(near_.end(), vertices.begin(), vertices.end());
        for (const std::uint32_t v : vertices) {
            edit_.mesh.star(v, star);
            for (const std::uint32_t c : star) {
                if (!is_across(c) && find_snapshot(were, edit_.mesh, c)) go(c);
            }
        }
        return true;
    }

    // The edge whose ring the context has.
    bool cut(std::uint32_t a, std::uint32_t b) {
        const Vec3 from = edit_.mesh.point(a);
        return edit_.split_ring(from + joined_.thickness * (edit_.mesh.point(b) - from)) != no_cell;
    }

    std::vector<Region> regions_at(std::uint32_t v) {
        std::vector<Region> regions;
        edit_.mesh.star(v, edit_.star);
        for (const std::uint32_t c : edit_.star) regions.push_back(edit_.mesh.region(c));
        sort_distinct(regions);
        return regions;
    }

    // Of cells at a vertex, those on the way from these to others of the other side: the cheapest one.
    std::vector<std::uint32_t> way_between(std::uint32_t v, const std::vector<std::uint32_t>& from) {
        // More cells than any way costs: no way is known. [cells; -; D]
        constexpr std::size_t never = static_cast<std::size_t>(-1);
        struct Step {
            std::size_t cost = never;
            std::uint32_t before = no_cell;
        };
        std::map<std::uint32_t, Step> steps;
        edit_.mesh.star(v, edit_.star);
        for (const std::uint32_t c : edit_.star) steps[c];
        for (const std::uint32_t c : from) steps[c].cost = 0;
        for (bool again = true; again;) {
            again = false;
            for (const auto& [c, step] : steps) {
                if (step.cost == never || (step.cost > 0 && is_across(c))) continue;
                for (int i = 0; i < 4; ++i) {
                    const auto next = steps.find(edit_.mesh.neighbor(c, i));
                    if (next == steps.end()) continue;
                    const std::size_t price = is_across(next->first) ? 1 : price_at(v, next->first);
                    if (price == 0 || step.cost + price >= next->second.cost) continue;
                    next->second = {step.cost + price, c};
                    again = true;
                }
            }
        }
        const std::pair<const std::uint32_t, Step>* end = nullptr;
        for (const auto& entry : steps) {
            const std::size_t cost = entry.second.cost;
            if (is_across(entry.first) && cost > 0 && cost != never && (!end || cost < end->second.cost))
                end = &entry;
        }
        std::vector<std::uint32_t> way;
        if (!end) return way;
        for (std::uint32_t c = end->second.before; !is_across(c); c = steps[c].before) way.push_back(c);
        return way;
    }

    // 0: it must not go.
    std::size_t price_at(std::uint32_t v, std::uint32_t c) const {
        if (!is_own(c) && !joined_.others_may_go) return 0;
        return (is_own(c) ? 1 : price_of_others) + price_of_contours * worth_at(edit_, v, {c})[0];
    }

    EditContext& edit_;
    const PinchedSides& joined_;
    SurfaceIncidence incidence_;
    std::vector<CellSnapshot> gone_;   // whatever they are cut into
    std::vector<std::uint32_t> near_;  // vertices
};

}  // namespace

std::optional<std::vector<std::uint32_t>> resolve_pinches(EditContext& edit, const PinchedSides& sides,
                                                          std::vector<std::uint32_t> relabelled) {
    return PinchResolution(edit, sides).run(std::move(relabelled));
}

}  // namespace anatomesh
