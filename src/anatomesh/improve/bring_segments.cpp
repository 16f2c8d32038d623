#include "anatomesh/improve/bring_segments.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <queue>
#include <set>
#include <span>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/improve/section_areas.h"
#include "anatomesh/improve/surface_count.h"
#include "anatomesh/mesh/cell_shape.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_chains =
    40;  // where more are off their surface, the size does not fit the contours
constexpr std::size_t most_pieces = 50;                         // of a chain
constexpr std::size_t most_facets = 8;                          // of a sheet, beside one for each piece
constexpr std::size_t most_looked_at = 4000, most_sheets = 16;  // sheets for a chain
constexpr std::size_t most_improved = 12;          // sheets and thicknesses whose cells are worked on
constexpr std::size_t most_improved_at_last = 36;  // where some of these may be above the first bound
constexpr std::size_t most_improved_in_all = 100;
constexpr std::size_t most_tried_in_all = 1000;  // sheets and thicknesses, sound or not
constexpr double edge_price = 0.43;  // of its square: the facets that an edge off the surface still needs
constexpr double wrong_side = 5;     // price of a facet where the field has the side of the chain
constexpr std::array thicknesses{0.5, 0.3, 0.15};  // of a sheet, as a share of the edges that lead off it
constexpr double middle = 0.5;                     // where an edge between two vertices of a sheet is cut
constexpr double most_of_cuts = 3e-4;  // share of what is drawn by which cuts may get worse for a chain
constexpr double on_line = 1e-9;       // of a piece: a vertex so near to it lies on it
constexpr std::size_t no_limit = static_cast<std::size_t>(-1);
constexpr int rounds = 4;  // over the chains: one may need that beside it

// Pieces one after the other, with vertices in between that are off the structure's surface as well.
struct Chain {
    std::vector<std::uint32_t> vertices;
    std::uint32_t structure;
    std::vector<std::uint32_t> reach = {};  // of those with its sheets, when it was tried last; rising
    std::size_t changed_before = 0;         // cells, then

    bool has(std::uint32_t v) const {
        return std::find(vertices.begin(), vertices.end(), v) != vertices.end();
    }
};

// Facets between a chain and its structure's surface.
struct Sheet {
    std::vector<std::array<std::uint32_t, 3>> facets;  // corners rising
    std::vector<std::uint32_t> path;                   // the rest of its rim, from end to end of the chain
    double price = 0, to_come = 0;

    bool has(std::uint32_t v) const {
        return std::any_of(facets.begin(), facets.end(), [&](const auto& facet) {
            return std::find(facet.begin(), facet.end(), v) != facet.end();
        });
    }
    bool has_edge(std::uint32_t a, std::uint32_t b) const { return facets_at(a, b) > 0; }
    bool has_on_rim(std::uint32_t a, std::uint32_t b) const { return facets_at(a, b) == 1; }
    std::ptrdiff_t facets_at(std::uint32_t a, std::uint32_t b) const {
        return std::count_if(facets.begin(), facets.end(), [&](const auto& facet) {
            return std::find(facet.begin(), facet.end(), a) != facet.end() &&
                   std::find(facet.begin(), facet.end(), b) != facet.end();
        });
    }
    std::vector<std::uint32_t> vertices() const {
        std::vector<std::uint32_t> found;
        for (const auto& facet : facets) found.insert(found.end(), facet.begin(), facet.end());
        std::sort(found.begin(), found.end());
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    }
};

struct Dearer {
    bool operator()(const Sheet& x, const Sheet& y) const {
        const double here = x.price + x.to_come, there = y.price + y.to_come;
        return here != there ? here > there : x.facets > y.facets;
    }
};

// What the mesh has at edges and vertices, seen from one structure.
class SidesAt {
  public:
    explicit SidesAt(Workbench& bench) : bench_(bench) {}

    bool has(std::uint32_t c, std::uint32_t structure) const {
        return bench_.table->contains(bench_.mesh.region(c), structure);
    }
    // Finds the cells round an edge, for the bench's ring; false where it is none, or on the hull.
    bool find_ring(std::uint32_t a, std::uint32_t b) {
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
    // Of the cells of the bench's ring.
    bool ring_is_mixed(std::uint32_t structure) const { return is_mixed(bench_.ring.cells, structure); }
    bool on_surface(std::uint32_t a, std::uint32_t b, std::uint32_t structure) {
        return find_ring(a, b) && ring_is_mixed(structure);
    }
    bool on_surface(std::uint32_t v, std::uint32_t structure) {
        bench_.mesh.star(v, bench_.star);
        return is_mixed(bench_.star, structure);
    }
    // An edge with cells of one side alone.
    bool beside_surface(std::uint32_t a, std::uint32_t b, std::uint32_t structure) {
        return find_ring(a, b) && !ring_is_mixed(structure);
    }
    // Its pieces, each an edge or what fixed edges became of it.
    bool on_surface(const Chain& chain) {
        for (std::size_t n = 1; n < chain.vertices.size(); ++n) {
            if (!row_on_surface(chain.vertices[n - 1], chain.vertices[n], chain.structure)) return false;
        }
        return true;
    }

  private:
    bool row_on_surface(std::uint32_t a, std::uint32_t b, std::uint32_t structure) {
        for (std::uint32_t at = a; at != b;) {
            const std::uint32_t next = next_in_row(at, a, b);
            if (next == no_cell || !on_surface(at, next, structure)) return false;
            at = next;
        }
        return true;
    }
    // On the way from a to b the nearest vertex beyond one that a fixed edge joins to it, or b; no_cell if
    // there is none.
    std::uint32_t next_in_row(std::uint32_t at, std::uint32_t a, std::uint32_t b) {
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
    bool is_mixed(const std::vector<std::uint32_t>& cells, std::uint32_t structure) const {
        return std::any_of(cells.begin(), cells.end(), [&](std::uint32_t c) {
            return has(c, structure) != has(cells.front(), structure);
        });
    }

    Workbench& bench_;
};

// All chains of pieces beside their surfaces that begin and end on them.
class ChainSearch {
  public:
    ChainSearch(Workbench& bench, const ContourOwners& owners) : owners_(owners), sides_(bench) {}

    // `pieces`: those that may be.
    std::vector<Chain> run(std::span<const std::array<std::uint32_t, 3>> pieces) {
        std::vector<std::array<std::uint32_t, 3>> ends;
        for (const auto& [a, b, structure] : pieces) {
            ends.push_back({a, b, structure});
            ends.push_back({b, a, structure});
        }
        sort_distinct(ends);
        for (const auto& [v, other, structure] : ends) {
            if (sides_.beside_surface(v, other, structure) && sides_.on_surface(v, structure))
                follow(v, {other, structure});
        }
        return std::move(chains_);
    }

  private:
    void follow(std::uint32_t first, ContourOwners::Piece piece) {
        Chain chain{{first, piece.other}, piece.structure};
        while (!sides_.on_surface(chain.vertices.back(), piece.structure)) {
            const std::uint32_t at = chain.vertices.back(), from = chain.vertices[chain.vertices.size() - 2];
            const auto pieces = owners_.pieces_at(at);
            const auto next =
                std::find_if(pieces.begin(), pieces.end(), [&](const ContourOwners::Piece& other) {
                    return other.structure == piece.structure && other.other != from &&
                           sides_.beside_surface(at, other.other, piece.structure);
                });
            if (next == pieces.end() || chain.vertices.size() > most_pieces) return;
            chain.vertices.push_back(next->other);
        }
        // From the other end it is found too.
        if (chain.vertices.front() < chain.vertices.back()) chains_.push_back(std::move(chain));
    }

    const ContourOwners& owners_;
    SidesAt sides_;
    std::vector<Chain> chains_;
};

// Sheets grown facet by facet from a chain, the cheapest first, until the rest of the rim lies on the
// surface.
class SheetSearch {
  public:
    SheetSearch(Workbench& bench, const Chain& chain, bool side)
        : bench_(bench), chain_(chain), side_(side), sides_(bench) {}

    std::vector<Sheet> run() {
        std::vector<Sheet> found;
        std::set<std::vector<std::array<std::uint32_t, 3>>> seen;
        std::priority_queue<Sheet, std::vector<Sheet>, Dearer> waiting;
        waiting.push({{}, chain_.vertices, 0, 0});
        for (std::size_t n = 0; n < most_looked_at && !waiting.empty() && found.size() < most_sheets; ++n) {
            Sheet sheet = waiting.top();
            waiting.pop();
            const std::size_t open = first_off_surface(sheet);
            if (open + 1 == sheet.path.size()) {
                found.push_back(std::move(sheet));
                continue;
            }
            if (sheet.facets.size() == most_facets + chain_.vertices.size()) continue;
            const EdgeRing& edge = ring_of(sheet.path[open], sheet.path[open + 1]);
            if (!edge.closed) continue;
            const auto push = [&](std::optional<Sheet> more) {
                if (!more || !seen.insert(more->facets).second) return;
                more->to_come = to_come(*more);
                waiting.push(std::move(*more));
            };
            for (const std::uint32_t w : edge.vertices) push(grown(sheet, open, w));
            // Elsewhere facets between two edges of the path alone: they may be all that the others wait for.
            for (std::size_t k = open + 1; k + 2 < sheet.path.size(); ++k) {
                if (is_facet(sheet.path[k], sheet.path[k + 1], sheet.path[k + 2]))
                    push(grown(sheet, k, sheet.path[k + 2]));
            }
        }
        return found;
    }

  private:
    // What is round an edge: asked for again and again, of few edges.
    struct EdgeRing {
        bool closed = false, on_surface = false;
        std::vector<std::uint32_t> vertices;
    };
    const EdgeRing& ring_of(std::uint32_t a, std::uint32_t b) {
        const auto [place, is_new] = rings_.try_emplace(std::minmax(a, b));
        EdgeRing& edge = place->second;
        if (is_new && sides_.find_ring(a, b)) {
            edge = {true, sides_.ring_is_mixed(chain_.structure), bench_.ring.ring};
        }
        return edge;
    }
    bool on_surface(std::uint32_t a, std::uint32_t b) { return ring_of(a, b).on_surface; }

    // The first edge of the path that is off the surface.
    std::size_t first_off_surface(const Sheet& sheet) {
        std::size_t n = 0;
        while (n + 1 < sheet.path.size() && on_surface(sheet.path[n], sheet.path[n + 1])) ++n;
        return n;
    }

    // By the facet at the path's edge n and a vertex; nothing where the sheet would meet itself, or touch a
    // surface within its rim.
    std::optional<Sheet> grown(const Sheet& sheet, std::size_t n, std::uint32_t w) {
        const std::uint32_t u = sheet.path[n], v = sheet.path[n + 1];
        std::array facet{u, v, w};
        std::sort(facet.begin(), facet.end());
        if (std::find(sheet.facets.begin(), sheet.facets.end(), facet) != sheet.facets.end())
            return std::nullopt;
        Sheet more = sheet;
        const auto at = more.path.begin() + static_cast<std::ptrdiff_t>(n);
        if (n > 0 && sheet.path[n - 1] == w) {
            if (!may_be_within(u)) return std::nullopt;
            more.path.erase(at);
        } else if (n + 2 < sheet.path.size() && sheet.path[n + 2] == w) {
            if (!may_be_within(v)) return std::nullopt;
            more.path.erase(at + 1);
        } else if (sheet.has(w) || chain_.has(w)) {
            return std::nullopt;
        } else {
            more.path.insert(at + 1, w);
        }
        more.facets.insert(std::upper_bound(more.facets.begin(), more.facets.end(), facet), facet);
        more.price += price(facet);
        return more;
    }

    bool is_facet(std::uint32_t u, std::uint32_t v, std::uint32_t w) {
        const EdgeRing& edge = ring_of(u, v);
        return std::find(edge.vertices.begin(), edge.vertices.end(), w) != edge.vertices.end();
    }

    bool may_be_within(std::uint32_t v) { return chain_.has(v) || !bench_.mesh.vertex_on_interface(v); }

    double price(const std::array<std::uint32_t, 3>& facet) {
        const auto [place, is_new] = prices_.try_emplace(facet);
        if (!is_new) return place->second;
        const Vec3 a = bench_.mesh.point(facet[0]), b = bench_.mesh.point(facet[1]),
                   c = bench_.mesh.point(facet[2]);
        const std::vector<std::uint32_t>& there = bench_.probe.members((1.0 / 3) * (a + b + c));
        const bool wrong = std::binary_search(there.begin(), there.end(), chain_.structure) == side_;
        return place->second = 0.5 * length(cross(b - a, c - a)) * (wrong ? wrong_side : 1);
    }

    double to_come(const Sheet& sheet) {
        double sum = 0;
        for (std::size_t n = 1; n < sheet.path.size(); ++n) {
            const std::uint32_t a = sheet.path[n - 1], b = sheet.path[n];
            if (!on_surface(a, b))
                sum += edge_price * squared_length(bench_.mesh.point(b) - bench_.mesh.point(a));
        }
        return sum;
    }

    Workbench& bench_;
    const Chain& chain_;
    bool side_;  // of the structure on which the chain lies
    SidesAt sides_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, EdgeRing> rings_;
    std::map<std::array<std::uint32_t, 3>, double> prices_;
};

// Thickens a sheet. What is done to the mesh is the caller's to take back where that fails.
class Thickening {
  public:
    // `own`: the region in which the chain lies. `wide`: as far as to all vertices of the surface beside the
    // sheet; else to those alone that edges of the surface join to all that a cell has of the sheet.
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

    std::vector<std::uint32_t> changed;  // cells that were made
    double wrong_of_cuts = 0;            // that came of it, a share of what is drawn
    bool parts_cells = false;            // at a vertex of the sheet (leave_one_part())

    // `areas`: those of a stack, or null.
    bool run(double thickness, SectionAreas* areas) {
        find_cells();
        if (!cut_edges(thickness)) return false;
        std::vector<std::uint32_t> given = cells_between_cuts();
        const std::optional<Region> to = region_across(given);
        if (!to || !leave_one_part(given, *to, thickness)) return false;
        note_changed(given);
        SurfaceCount count(bench_, owners_, given, *to);
        const SurfaceCount::Figures before = count.figures();
        if (areas) wrong_of_cuts -= areas->wrong(given);
        for (const std::uint32_t c : given) bench_.mesh.set_region(c, *to);
        if (areas) wrong_of_cuts += areas->wrong(given);
        const SurfaceCount::Figures after = count.figures();
        return after.excess == 0 &&
               std::ranges::equal(count.of_structures(after), count.of_structures(before)) &&
               count.newly_lost() == 0 && sides_.on_surface(chain_);
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
        const bool fixed = bench_.fixed_edge(a, b);
        const std::uint32_t v = bench_.add_point(from + share * (bench_.mesh.point(b) - from));
        bench_.cells.clear();
        bench_.regions.clear();
        for (const std::uint32_t c : bench_.ring.cells) {
            for (const std::uint32_t end : {a, b}) {
                bench_.cells.push_back(bench_.mesh.cell(c));
                std::replace(bench_.cells.back().begin(), bench_.cells.back().end(), end, v);
                bench_.regions.push_back(bench_.mesh.region(c));
            }
        }
        if (!bench_.commit(bench_.ring.cells, bench_.cells, bench_.regions)) return false;
        if (fixed) bench_.fix_on_edge(v, a, b);
        return true;
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
            parts_cells = true;
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
        changed = given;
        for (auto v = first_new_; v < bench_.mesh.point_count(); ++v) {
            bench_.mesh.star(v, bench_.star);
            changed.insert(changed.end(), bench_.star.begin(), bench_.star.end());
        }
        sort_distinct(changed);
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
};

class Bringer {
  public:
    Bringer(Workbench& bench, const DrawnSlices& drawn, double least_sine, double most_more,
            const ImproveCells& improve)
        : bench_(bench),
          owners_(*drawn.owners),
          drawn_(drawn),
          sides_(bench),
          most_more_share_(most_more),
          least_sine_(least_sine),
          improve_(improve) {
        if (!drawn.planes.empty()) areas_.emplace(bench, drawn);
    }

    BringStats run(std::span<const std::array<std::uint32_t, 3>> pieces) {
        std::vector<Chain> chains = ChainSearch(bench_, owners_).run(pieces);
        BringStats stats;
        for (const Chain& chain : chains) stats.found += chain.vertices.size() - 1;
        if (chains.size() > most_chains) return stats;
        stats.brought = stats.found;
        if (chains.empty()) return stats;
        std::vector<std::uint32_t> all(bench_.mesh.cell_count());
        std::iota(all.begin(), all.end(), 0u);
        std::erase_if(all,
                      [&](std::uint32_t c) { return !bench_.mesh.alive(c) || bench_.mesh.region(c) == 0; });
        most_more_ = static_cast<std::size_t>(most_more_share_ * static_cast<double>(all.size()));
        above_bound_ = those_above_bound(std::move(all));
        for (int round = 0; round < rounds && !chains.empty(); ++round) {
            const std::size_t before = chains.size();
            std::erase_if(chains, [&](Chain& chain) {
                if (sides_.on_surface(chain)) return true;
                if (is_enough() || (round > 0 && !has_changed(chain))) return false;
                chain.changed_before = changed_.size();
                return bring(chain);
            });
            if (chains.size() == before) break;
        }
        for (const Chain& chain : chains) stats.brought -= chain.vertices.size() - 1;
        stats.changed = std::move(changed_);
        return stats;
    }

  private:
    enum class Outcome { done, unsound, bad_cut, bad_cells };

    // Whether cells at one of its sheets have, since it was tried.
    bool has_changed(const Chain& chain) const {
        return std::any_of(changed_.begin() + static_cast<std::ptrdiff_t>(chain.changed_before),
                           changed_.end(), [&](std::uint32_t c) {
                               const Cell& cell = bench_.mesh.cell(c);
                               return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) {
                                   return std::binary_search(chain.reach.begin(), chain.reach.end(), v);
                               });
                           });
    }

    bool bring(Chain& chain) {
        for (std::size_t n = chain.vertices.size() - 1; n > 0; --n) {
            if (!sides_.beside_surface(chain.vertices[n - 1], chain.vertices[n], chain.structure))
                return false;
        }
        // The ring is now that of the first piece.
        const Region own = bench_.mesh.region(bench_.ring.cells.front());
        const std::vector<Sheet> sheets =
            SheetSearch(bench_, chain, bench_.table->contains(own, chain.structure)).run();
        chain.reach = chain.vertices;
        for (const Sheet& sheet : sheets) {
            const std::vector<std::uint32_t> more = sheet.vertices();
            chain.reach.insert(chain.reach.end(), more.begin(), more.end());
        }
        sort_distinct(chain.reach);
        least_more_ = no_limit;
        if (try_all(chain, sheets, own, 0)) return true;
        const std::size_t least = least_more_;
        return least <= most_more_ && try_all(chain, sheets, own, least);
    }

    bool is_enough() const { return improved_ >= most_improved_in_all || tried_ >= most_tried_in_all; }

    // `most_more`: cells above the first bound that may come of it where cells are parted.
    bool try_all(const Chain& chain, const std::vector<Sheet>& sheets, Region own, std::size_t most_more) {
        const std::size_t improved_before = improved_,
                          most_here = most_more_ > 0 ? most_improved_at_last : most_improved;
        for (const Sheet& sheet : sheets) {
            for (const bool wide : {true, false}) {
                for (const double thickness : thicknesses) {
                    const Outcome outcome = attempt(
                        chain, Thickening(bench_, owners_, chain, sheet, own, wide), thickness, most_more);
                    ++tried_;
                    if (outcome == Outcome::done) return true;
                    if (outcome == Outcome::unsound) break;
                    improved_ += outcome == Outcome::bad_cells;
                }
            }
            if (improved_ - improved_before >= most_here || is_enough()) break;
        }
        return false;
    }

    Outcome attempt(const Chain& chain, Thickening thickening, double thickness, std::size_t most_more) {
        const DihedralStats stats = bench_.stats;
        bench_.mesh.begin_attempt();
        const bool sound = thickening.run(thickness, areas_ ? &*areas_ : nullptr);
        if (!sound || thickening.wrong_of_cuts > most_of_cuts) {
            bench_.mesh.end_attempt(false);
            return sound ? Outcome::bad_cut : Outcome::unsound;
        }
        for (std::size_t n = 1; n < chain.vertices.size(); ++n) {
            bench_.fix_edge(chain.vertices[n - 1], chain.vertices[n]);
            bench_.release_edge(chain.vertices[n - 1], chain.vertices[n]);
        }
        std::vector<std::uint32_t> changed = std::move(thickening.changed);
        const std::vector<std::uint32_t> improved = improve_(changed);
        changed.insert(changed.end(), improved.begin(), improved.end());
        sort_distinct(changed);
        std::vector<std::uint32_t> above_bound = above_bound_;
        above_bound.insert(above_bound.end(), changed.begin(), changed.end());
        sort_distinct(above_bound);
        above_bound = those_above_bound(std::move(above_bound));
        const std::size_t more = above_bound.size() - std::min(above_bound.size(), above_bound_.size());
        bool good = sides_.on_surface(chain) &&
                    std::all_of(changed.begin(), changed.end(),
                                [&](std::uint32_t c) { return is_good(c) && is_near(c); });
        if (good && thickening.parts_cells) {
            least_more_ = std::min(least_more_, more);
            good = more <= most_more;
        }
        bench_.mesh.end_attempt(good);
        if (good) {
            above_bound_ = std::move(above_bound);
            changed_.insert(changed_.end(), changed.begin(), changed.end());
        } else {
            for (std::size_t n = 1; n < chain.vertices.size(); ++n)
                bench_.keep_edge(chain.vertices[n - 1], chain.vertices[n]);
            bench_.stats = stats;
        }
        return good ? Outcome::done : Outcome::bad_cells;
    }

    std::vector<std::uint32_t> those_above_bound(std::vector<std::uint32_t> cells) const {
        const double most = bench_.options.max_radius_edge;
        std::erase_if(cells, [&](std::uint32_t c) {
            if (!bench_.mesh.alive(c) || bench_.mesh.region(c) == 0) return true;
            const Cell& v = bench_.mesh.cell(c);
            return drawn_.are_crowded(v) ||
                   !(squared_radius_edge(bench_.mesh.point(v[0]), bench_.mesh.point(v[1]),
                                         bench_.mesh.point(v[2]), bench_.mesh.point(v[3])) > most * most);
        });
        return cells;
    }

    bool is_good(std::uint32_t c) const {
        if (!bench_.mesh.alive(c) || bench_.mesh.region(c) == 0) return true;
        const Cell& v = bench_.mesh.cell(c);
        const bool crowded = drawn_.are_crowded(v);
        const CellMeasures m = measure_cell(bench_.mesh.point(v[0]), bench_.mesh.point(v[1]),
                                            bench_.mesh.point(v[2]), bench_.mesh.point(v[3]));
        const double most = crowded ? most_crowded_ratio : bench_.options.last_radius_edge;
        return m.least_sine() >= (crowded ? least_crowded_sine : least_sine_) &&
               m.squared_ratio <= most * most;
    }

    // What of the cell lies on interfaces lies near the field's.
    bool is_near(std::uint32_t c) {
        if (!bench_.mesh.alive(c)) return true;
        const Cell& cell = bench_.mesh.cell(c);
        const double most = bench_.options.apex_mm;
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t other = bench_.mesh.neighbor(c, i);
            if (other == no_cell || bench_.mesh.region(other) == bench_.mesh.region(c)) continue;
            bench_.look_between(bench_.mesh.region(c), bench_.mesh.region(other));
            const auto& f = facet_vertices[i];
            if (bench_.facet_distance(bench_.mesh.point(cell[f[0]]), bench_.mesh.point(cell[f[1]]),
                                      bench_.mesh.point(cell[f[2]])) > most)
                return false;
            for (const int k : f) {
                if (!bench_.fixed(cell[k]) && bench_.probe.distance(bench_.mesh.point(cell[k]), most) > most)
                    return false;
            }
        }
        return true;
    }

    Workbench& bench_;
    const ContourOwners& owners_;
    const DrawnSlices& drawn_;
    SidesAt sides_;
    std::optional<SectionAreas> areas_;
    std::size_t improved_ = 0;  // in vain
    std::size_t tried_ = 0;
    double most_more_share_;
    std::size_t most_more_ = 0;               // cells above the first bound that a chain may cost
    std::size_t least_more_ = no_limit;       // that it did
    std::vector<std::uint32_t> above_bound_;  // cells inside; rising
    std::vector<std::uint32_t> changed_;      // cells, for the chains that were brought
    double least_sine_;
    const ImproveCells& improve_;
};

}  // namespace

BringStats bring_segments(Workbench& bench, const DrawnSlices& drawn, double least_sine, double most_more,
                          const ImproveCells& improve) {
    if (!drawn.table || !drawn.owners || drawn.pieces_beside.empty()) return {};
    return Bringer(bench, drawn, least_sine, most_more, improve).run(drawn.pieces_beside);
}

}  // namespace anatomesh
