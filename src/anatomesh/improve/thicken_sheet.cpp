#include "anatomesh/improve/thicken_sheet.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/improve/sides_at.h"
#include "anatomesh/improve/surface_count.h"

namespace anatomesh {

namespace {

constexpr double middle = 0.5;  // where an edge between two vertices of a sheet is cut

class Thickening {
  public:
    Thickening(Workbench& bench, const ContourOwners& owners, const Chain& chain, const Sheet& sheet,
               Region own, bool wide)
        : bench_(bench),
          owners_(owners),
          chain_(chain),
          sheet_(sheet),
          own_(own),
          side_(bench.table->contains(own, chain.structure)),
          wide_(wide),
          sides_(bench),
          on_sheet_(sheet.vertices()),
          first_new_(static_cast<std::uint32_t>(bench.mesh.point_count())) {}

    std::optional<ThickenedSheet> run(double thickness, SectionAreas* areas) {
        find_cells();
        if (!cut_edges(thickness)) return std::nullopt;
        std::vector<std::uint32_t> given = cells_between_cuts();
        const std::optional<Region> to = region_across(given);
        if (!to || !leave_one_part(given, *to, thickness)) return std::nullopt;
        note_changed(given);
        SurfaceCount count(bench_, owners_, given, *to);
        const SurfaceCount::Figures before = count.figures();
        if (areas) made_.wrong_of_cuts -= areas->wrong(given);
        for (const std::uint32_t c : given) bench_.mesh.set_region(c, *to);
        if (areas) made_.wrong_of_cuts += areas->wrong(given);
        const SurfaceCount::Figures after = count.figures();
        const bool sound = after.excess == 0 &&
                           std::ranges::equal(count.of_structures(after), count.of_structures(before)) &&
                           count.newly_lost() == 0 && sides_.on_surface(chain_.vertices, chain_.structure);
        return sound ? std::optional(std::move(made_)) : std::nullopt;
    }

  private:
    // As it was before edges were cut.
    struct CellBefore {
        Cell cell;
        std::array<Vec3, 4> corners;
    };

    // A piece of the structure on the sheet's rim: of the chain, or of a contour that the surface has
    // already.
    bool is_rim_piece(std::uint32_t a, std::uint32_t b) const {
        const auto pieces = owners_.pieces_at(a);
        const ContourOwners::Piece piece{b, chain_.structure};
        return sheet_.has_on_rim(a, b) && std::find(pieces.begin(), pieces.end(), piece) != pieces.end();
    }

    // Those of other regions stay, for the sake of the surfaces of other structures.
    bool may_go(std::uint32_t c) const { return bench_.mesh.region(c) == own_; }

    bool is_on(std::uint32_t v) const { return std::binary_search(on_sheet_.begin(), on_sheet_.end(), v); }

    // Those that may go with an edge of the sheet that is no piece of its rim, and their edges that leave it.
    void find_cells() {
        std::vector<std::uint32_t> cells;
        for (const auto& facet : sheet_.facets) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = facet[k], b = facet[(k + 1) % 3];
                if (is_rim_piece(a, b) || !sides_.find_ring(a, b)) continue;
                std::copy_if(bench_.ring.cells.begin(), bench_.ring.cells.end(), std::back_inserter(cells),
                             [&](std::uint32_t c) { return may_go(c); });
            }
        }
        sort_distinct(cells);
        for (const std::uint32_t c : cells) {
            const Cell& cell = bench_.mesh.cell(c);
            cells_.push_back({cell, {}});
            for (std::size_t i = 0; i < 4; ++i) cells_.back().corners[i] = bench_.mesh.point(cell[i]);
            for (const std::uint32_t d : cell) {
                for (const std::uint32_t x : cell) {
                    if (is_on(d) && (!is_on(x) || (d < x && !sheet_.has_edge(d, x))))
                        edges_.push_back({d, x});
                }
            }
        }
        sort_distinct(edges_);
    }

    // But for those on the surface. False where a cell would not be positive.
    bool cut_edges(double thickness) {
        for (const auto& [d, x] : edges_) {
            if (!sides_.find_ring(d, x)) return false;
            if (sides_.ring_is_mixed(chain_.structure)) {
                if (!is_on(x)) beside_.push_back(x);
                continue;
            }
            cut_.push_back({d, x});
            if (!cut(d, x, is_on(x) ? middle : thickness)) return false;
        }
        sort_distinct(beside_);
        return true;
    }

    // The edge whose ring the bench has.
    bool cut(std::uint32_t a, std::uint32_t b, double share) {
        const Vec3 from = bench_.mesh.point(a);
        return bench_.split_ring(from + share * (bench_.mesh.point(b) - from)) != no_cell;
    }

    std::vector<std::uint32_t> cells_between_cuts() {
        std::vector<std::uint32_t> given, look = on_sheet_;
        for (auto v = first_new_; v < bench_.mesh.point_count(); ++v) look.push_back(v);
        for (const std::uint32_t v : look) {
            bench_.mesh.star(v, bench_.star);
            for (const std::uint32_t c : bench_.star) {
                if (may_go(c) && lies_between_cuts(c)) given.push_back(c);
            }
        }
        sort_distinct(given);
        return given;
    }

    // Where what is given parts the cells left of the chain's region at a vertex of the sheet - on its rim,
    // between cells that have no edge of it -, one part stays there; near the vertex the others are given
    // too. False where a cell would not be positive.
    bool leave_one_part(std::vector<std::uint32_t>& given, Region to, double thickness) {
        std::vector<Region> before;
        const auto give = [&](std::uint32_t c) {
            before.push_back(bench_.mesh.region(c));
            bench_.mesh.set_region(c, to);
        };
        std::for_each(given.begin(), given.end(), give);
        for (const std::uint32_t v : on_sheet_) {
            const std::vector<std::vector<std::uint32_t>> parts = parts_at(v);
            if (parts.size() < 2) continue;
            made_.parts_cells = true;
            const auto stays = std::max_element(
                parts.begin(), parts.end(),
                [&](const auto& x, const auto& y) { return worth_at(v, x) < worth_at(v, y); });
            for (auto part = parts.begin(); part != parts.end(); ++part) {
                if (part != stays && !cut_near(v, *part, thickness)) return false;
            }
            for (const std::vector<std::uint32_t>& part : parts_at(v)) {
                if (std::find(part.begin(), part.end(), stays->front()) != part.end()) continue;
                given.insert(given.end(), part.begin(), part.end());
                std::for_each(part.begin(), part.end(), give);
            }
        }
        for (std::size_t n = 0; n < given.size(); ++n) bench_.mesh.set_region(given[n], before[n]);
        return true;
    }

    // Of the edges from the vertex those within the cells.
    bool cut_near(std::uint32_t v, const std::vector<std::uint32_t>& cells, double thickness) {
        std::vector<std::uint32_t> ends;
        for (const std::uint32_t c : cells)
            ends.insert(ends.end(), bench_.mesh.cell(c).begin(), bench_.mesh.cell(c).end());
        sort_distinct(ends);
        std::erase(ends, v);
        return std::all_of(ends.begin(), ends.end(), [&](std::uint32_t x) {
            return sides_.find_ring(v, x) && (sides_.ring_is_mixed(chain_.structure) || cut(v, x, thickness));
        });
    }

    // Of a part of the cells at a vertex: contours there, then its size.
    std::array<std::size_t, 2> worth_at(std::uint32_t v, const std::vector<std::uint32_t>& cells) const {
        std::size_t fixed = 0;
        for (const std::uint32_t c : cells) {
            const Cell& cell = bench_.mesh.cell(c);
            fixed += static_cast<std::size_t>(std::count_if(
                cell.begin(), cell.end(), [&](std::uint32_t x) { return bench_.fixed_edge(v, x); }));
        }
        return {fixed, cells.size()};
    }

    // The cells at a vertex that may go, in parts that facets join.
    std::vector<std::vector<std::uint32_t>> parts_at(std::uint32_t v) {
        bench_.mesh.star(v, bench_.star);
        std::vector<std::uint32_t> left = bench_.star;
        std::erase_if(left, [&](std::uint32_t c) { return !may_go(c); });
        std::vector<std::vector<std::uint32_t>> parts;
        while (!left.empty()) {
            std::vector<std::uint32_t> part{left.back()};
            left.pop_back();
            for (std::size_t n = 0; n < part.size(); ++n) {
                for (int i = 0; i < 4; ++i) {
                    const auto next = std::find(left.begin(), left.end(), bench_.mesh.neighbor(part[n], i));
                    if (next == left.end()) continue;
                    part.push_back(*next);
                    left.erase(next);
                }
            }
            parts.push_back(std::move(part));
        }
        return parts;
    }

    void note_changed(const std::vector<std::uint32_t>& given) {
        made_.changed = given;
        for (auto v = first_new_; v < bench_.mesh.point_count(); ++v) {
            bench_.mesh.star(v, bench_.star);
            made_.changed.insert(made_.changed.end(), bench_.star.begin(), bench_.star.end());
        }
        sort_distinct(made_.changed);
    }

    bool lies_between_cuts(std::uint32_t c) const {
        const Cell& cell = bench_.mesh.cell(c);
        if (std::none_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return is_on(v); })) return false;
        const CellBefore* was = cell_before(c);
        return was && std::all_of(cell.begin(), cell.end(), [&](std::uint32_t v) {
                   return v >= first_new_ || is_on(v) || stays(*was, v);
               });
    }

    // That in which a cell lies.
    const CellBefore* cell_before(std::uint32_t c) const {
        Vec3 p{};
        for (const std::uint32_t v : bench_.mesh.cell(c)) p = p + 0.25 * bench_.mesh.point(v);
        const auto at = std::find_if(cells_.begin(), cells_.end(), [&](const CellBefore& was) {
            const auto& q = was.corners;
            return orient3d(p, q[1], q[2], q[3]) > 0 && orient3d(q[0], p, q[2], q[3]) > 0 &&
                   orient3d(q[0], q[1], p, q[3]) > 0 && orient3d(q[0], q[1], q[2], p) > 0;
        });
        return at == cells_.end() ? nullptr : &*at;
    }

    // Whether what is given reaches to a vertex beside the sheet.
    bool stays(const CellBefore& was, std::uint32_t v) const {
        if (!std::binary_search(beside_.begin(), beside_.end(), v)) return false;
        return wide_ || std::none_of(was.cell.begin(), was.cell.end(), [&](std::uint32_t d) {
                   return is_on(d) && std::binary_search(cut_.begin(), cut_.end(), std::array{d, v});
               });
    }

    // Of those at the chain's ends on the other side the one most like that of the cells.
    std::optional<Region> region_across(const std::vector<std::uint32_t>& given) {
        if (given.empty()) return std::nullopt;
        const std::vector<std::uint32_t>& here = bench_.table->members[bench_.mesh.region(given.front())];
        std::optional<std::pair<std::size_t, Region>> best;
        for (const std::uint32_t end : {chain_.vertices.front(), chain_.vertices.back()}) {
            bench_.mesh.star(end, bench_.star);
            for (const std::uint32_t c : bench_.star) {
                if (sides_.has(c, chain_.structure) == side_) continue;
                const std::vector<std::uint32_t>& there = bench_.table->members[bench_.mesh.region(c)];
                std::vector<std::uint32_t> differ;
                std::set_symmetric_difference(here.begin(), here.end(), there.begin(), there.end(),
                                              std::back_inserter(differ));
                const std::pair<std::size_t, Region> offer{differ.size(), bench_.mesh.region(c)};
                if (!best || offer < *best) best = offer;
            }
        }
        if (!best) return std::nullopt;
        return best->second;
    }

    Workbench& bench_;
    const ContourOwners& owners_;
    const Chain& chain_;
    const Sheet& sheet_;
    Region own_;
    bool side_, wide_;
    SidesAt sides_;
    std::vector<std::uint32_t> on_sheet_, beside_;           // vertices
    std::vector<std::array<std::uint32_t, 2>> edges_, cut_;  // from a vertex of the sheet on
    std::vector<CellBefore> cells_;
    std::uint32_t first_new_;  // vertex
    ThickenedSheet made_;
};

}  // namespace

std::optional<ThickenedSheet> thicken_sheet(Workbench& bench, const ContourOwners& owners, const Chain& chain,
                                            const Sheet& sheet, Region own, bool wide, double thickness,
                                            SectionAreas* areas) {
    return Thickening(bench, owners, chain, sheet, own, wide).run(thickness, areas);
}

}  // namespace anatomesh
