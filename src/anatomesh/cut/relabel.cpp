#include "anatomesh/cut/relabel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/model/prefetch.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

constexpr int defect_weight = 256;  // against one end of a lost subsegment: a manifold comes first
constexpr int any_change = std::numeric_limits<int>::max();
constexpr std::size_t stars_ahead = 2;  // are fetched into the cache so many before they are looked at
constexpr int most_mends = 8;           // passes over the cells that are wrong in a slice's plane
// Moves of variable depth: how many of those that bring a subsegment back are followed, and how far.
constexpr std::size_t most_openings = 12;
constexpr int most_rounds_in_depth = 6, most_passes_in_depth = 4;
// Where planes cross, of what is drawn: there every move spoils some cut a little.
constexpr double least_spoiled_share = 1e-4;
constexpr double flat_share = 1e-6;  // six volumes in cubes of the longest edge

struct Move {
    std::vector<std::uint32_t> cells;
    Region region = 0;
    int change = 0;      // of the sum of defects; negative is better
    int lost = 0;        // change of the number of ends of subsegments that are lost
    int misplaced = 0;   // change of the number of vertices, cell by cell, that the field has on another side
    int spikes = 0;      // change of the number of vertices deep in a region that have a cell of another one
    double spoiled = 0;  // of the slices' cuts, by how much more is other than drawn: as DrawnCuts::change()
};

bool nearly_flat(const std::vector<Vec3>& points, const Cell& cell) {
    double longest = 0;
    for (const auto& [i, j] : cell_edges)
        longest = std::max(longest, squared_length(points[cell[i]] - points[cell[j]]));
    const double volume = signed_volume(points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]);
    return 6 * volume < flat_share * longest * std::sqrt(longest);
}

class Relabeler {
  public:
    Relabeler(const RelabelledMesh& mesh, const RelabelOptions& options, const SlicePlanes& slices)
        : cells_(mesh.cells),
          neighbors_(mesh.neighbors),
          stars_(mesh.stars),
          sides_(mesh.memberships),
          deep_mm_(options.deep_mm),
          near_mm_(options.near_mm),
          is_stack_(slices.is_stack()),
          least_spoiled_(slices.cross() ? least_spoiled_share : 0),
          regions_(mesh.regions),
          registry_(mesh.registry),
          owners_(mesh.owners),
          analyzer_(mesh.cells, mesh.neighbors, mesh.stars, mesh.regions, mesh.registry.table(), mesh.owners),
          known_(mesh.points.size()) {
        if (slices.any())
            cuts_.emplace(mesh.points, mesh.cells, mesh.neighbors, mesh.regions, mesh.registry.table(),
                          slices);
    }

    // Whether moves that bring a deep vertex onto a surface are made.
    void allow_spikes(bool allowed) { may_spike_ = allowed; }
    // Whether moves that make the slices' cuts less like what is drawn are made.
    void allow_spoiling(bool allowed) { may_spoil_ = allowed; }

    // Whether moves by which subsegments are lost are made.
    void allow_losses(bool allowed) { may_lose_ = allowed; }

    int defect(std::uint32_t vertex) { return figures_at(vertex).defect; }
    int lost_subsegments(std::uint32_t vertex) { return figures_at(vertex).lost_subsegments; }
    int total(std::uint32_t vertex) { return defect_weight * defect(vertex) + lost_subsegments(vertex); }

    bool lost(std::uint32_t vertex) {
        analyzer_.lost_structures(vertex, lost_);
        return !lost_.empty();
    }

    // The best move at the vertex that makes the sum fall; its cells are moved. Returns how many.
    std::size_t improve(std::uint32_t vertex, std::vector<std::uint32_t>& touched) {
        find_best(vertex);
        if (!best_) return 0;
        for (const std::uint32_t c : best_->cells) {
            relabel_cell(c, best_->region);
            touched.insert(touched.end(), cells_[c].begin(), cells_[c].end());
        }
        return best_->cells.size();
    }

    // A subsegment that is lost at the vertex comes back by a move that does not make the sum fall, if moves
    // after it at the vertices concerned, which leave its cells alone, make it fall in all, with fewer
    // subsegments lost, and no more vertices where the field does not have them. Returns how many cells
    // moved. Follows: Kernighan and Lin, Bell Syst. Tech. J. 49, 1970 (moves of variable depth).
    std::size_t improve_in_depth(std::uint32_t vertex, std::vector<std::uint32_t>& touched) {
        for (const Move& opening : openings_at(vertex)) {
            made_.clear();
            if (follow(opening)) {
                for (const auto& [c, before] : made_)
                    touched.insert(touched.end(), cells_[c].begin(), cells_[c].end());
                return made_.size();
            }
            for (auto made = made_.rbegin(); made != made_.rend(); ++made)
                relabel_cell(made->first, made->second);
        }
        return 0;
    }

    // Relabels a cell to a region beside it with which it shares two facets or more, if no defect rises.
    bool peel(std::uint32_t cell) {
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t n = neighbors_[cell][i];
            if (n == no_cell || regions_[n] == regions_[cell]) continue;
            int shared = 0;
            for (const std::uint32_t m : neighbors_[cell])
                shared += m != no_cell && regions_[m] == regions_[n];
            Move move{{cell}, regions_[n]};
            if (shared < 2 || change_of(move, 1) > 0) continue;
            relabel_cell(cell, regions_[n]);
            return true;
        }
        return false;
    }

    // Relabels a cell that is wrong in a slice's plane to what is drawn there, if no defect rises.
    // Its vertices are added to `touched`.
    bool mend(std::uint32_t cell, std::vector<std::uint32_t>& touched) {
        const std::vector<std::uint32_t>* drawn = cuts_ ? cuts_->wanted(cell) : nullptr;
        if (!drawn) return false;
        Move move{{cell}, registry_.intern(*drawn)};
        if (cuts_->change(move.cells, move.region) >= 0 || change_of(move, 1) > 0) return false;
        if (misplaced(cell, move.region) > misplaced(cell, regions_[cell]) || spikes(move) > 0) return false;
        relabel_cell(cell, move.region);
        touched.insert(touched.end(), cells_[cell].begin(), cells_[cell].end());
        return true;
    }

  private:
    struct Figures {
        int defect = -1, lost_subsegments = 0;  // defect below 0: not known
    };

    // Of a vertex, as regions are: most are asked for again and again by moves that are not made.
    const Figures& figures_at(std::uint32_t vertex) {
        Figures& known = known_[vertex];
        if (known.defect < 0) known = {analyzer_.defect(vertex), analyzer_.lost_subsegment_count(vertex)};
        return known;
    }

    void relabel_cell(std::uint32_t cell, Region region) {
        regions_[cell] = region;
        for (const std::uint32_t v : cells_[cell]) known_[v].defect = -1;
    }

    // The best move at the vertex that makes the sum fall, if any.
    void find_best(std::uint32_t vertex) {
        best_.reset();
        analyzer_.excess_components(vertex, components_);
        for (const StarComponent& component : components_) {
            if (!component.largest || components_.size() == 2) try_component(component);
        }
        if (may_bridge(vertex)) {
            // There the other ways lose a corner of a cut.
            may_bridge_deep_ = may_lose_ && touches_in_point(vertex);
            for (const StarComponent& component : components_) try_bridges(vertex, component);
            may_bridge_deep_ = false;
        }
        if (!best_) {
            for (const StarComponent& component : components_) try_single_cells(component);
        }
        analyzer_.lost_structures(vertex, lost_);
        const std::vector<std::uint32_t> lost = lost_;
        for (const std::uint32_t structure : lost) try_regain(vertex, structure);
        analyzer_.lost_subsegments(vertex, lost_subsegments_);
        const std::vector<ContourOwners::Subsegment> lost_edges = lost_subsegments_;
        for (const ContourOwners::Subsegment& subsegment : lost_edges)
            try_regain_subsegment(vertex, subsegment);
    }

    // Moves by which subsegments that are lost at the vertex come back and the sum does not fall, the
    // cheapest first, each once.
    std::vector<Move> openings_at(std::uint32_t vertex) {
        openings_.emplace();
        analyzer_.lost_subsegments(vertex, lost_subsegments_);
        const std::vector<ContourOwners::Subsegment> lost_edges = lost_subsegments_;
        for (const ContourOwners::Subsegment& subsegment : lost_edges)
            try_regain_subsegment(vertex, subsegment);
        std::vector<Move> openings = std::move(*openings_);
        openings_.reset();
        const auto key = [](const Move& m) { return std::tie(m.change, m.cells, m.region); };
        for (Move& opening : openings) std::sort(opening.cells.begin(), opening.cells.end());
        std::sort(openings.begin(), openings.end(),
                  [&](const Move& x, const Move& y) { return key(x) < key(y); });
        openings.erase(std::unique(openings.begin(), openings.end(),
                                   [&](const Move& x, const Move& y) { return key(x) == key(y); }),
                       openings.end());
        if (openings.size() > most_openings) openings.resize(most_openings);
        return openings;
    }

    // Makes this move and those after it, and says whether they serve. `made_`: the cells, and their regions
    // before.
    bool follow(const Move& opening) {
        held_ = opening.cells;
        std::vector<std::uint32_t> queue;
        make(opening, queue);
        Move all = opening;
        const auto serves = [&] {
            return all.change < 0 && all.lost < 0 && all.misplaced <= 0 && all.spikes <= 0;
        };
        for (int round = 0; round < most_rounds_in_depth && !serves(); ++round) {
            std::sort(queue.begin(), queue.end());
            queue.erase(std::unique(queue.begin(), queue.end()), queue.end());
            std::vector<std::uint32_t> next = queue;
            const std::size_t before = made_.size();
            for (const std::uint32_t v : queue) {
                if (total(v) == 0) continue;
                find_best(v);
                if (!best_) continue;
                all.change += best_->change;
                all.lost += best_->lost;
                all.misplaced += best_->misplaced;
                all.spikes += best_->spikes;
                make(*best_, next);
            }
            if (made_.size() == before) break;
            queue = std::move(next);
        }
        held_.clear();
        return serves();
    }

    void make(const Move& move, std::vector<std::uint32_t>& touched) {
        for (const std::uint32_t c : move.cells) {
            made_.emplace_back(c, regions_[c]);
            relabel_cell(c, move.region);
            touched.insert(touched.end(), cells_[c].begin(), cells_[c].end());
        }
    }

    bool is_held(std::uint32_t cell) const {
        return std::find(held_.begin(), held_.end(), cell) != held_.end();
    }

    // Gives a whole component to the region with which it shares most facets of the star across its cut.
    void try_component(const StarComponent& component) {
        if (const std::optional<Region> region =
                region_beside(component.cells, component.body, component.inside)) {
            consider({component.cells, *region});
        }
    }

    // Where components may be joined: where what is drawn touches itself in a point, and, sooner than a cut
    // is spoiled, where it is right.
    bool may_bridge(std::uint32_t vertex) {
        if (!is_stack_) return false;
        return touches_in_point(vertex) ||
               (may_spoil_ && cuts_->in_slice(vertex) && !cuts_->protrudes(stars_.at(vertex)));
    }

    // Whether four contour segments or more end there.
    bool touches_in_point(std::uint32_t vertex) const {
        const auto subsegments = owners_.subsegments_at(vertex);  // by their other ends
        std::size_t ends = 0;
        for (std::size_t n = 0; n < subsegments.size(); ++n)
            ends += n == 0 || subsegments[n].other != subsegments[n - 1].other;
        return ends >= 4;
    }

    // The other way to have one component less: cells of the star join it to the nearest other one of its
    // side. Where a structure touches itself in a point of a slice, this leaves the cut as it is drawn if
    // they lie above the plane or below it; so both are tried.
    void try_bridges(std::uint32_t vertex, const StarComponent& component) {
        for (const bool above : {false, true}) try_bridge(vertex, component, above);
    }

    void try_bridge(std::uint32_t vertex, const StarComponent& component, bool above) {
        const auto star = stars_.at(vertex);
        const auto position = [&](std::uint32_t c) {
            return static_cast<std::size_t>(std::lower_bound(star.begin(), star.end(), c) - star.begin());
        };
        constexpr std::uint32_t unseen = 0xFFFFFFFEu;
        from_.assign(star.size(), unseen);
        queue_ = component.cells;
        for (const std::uint32_t c : component.cells) from_[position(c)] = no_cell;
        for (std::size_t head = 0; head < queue_.size(); ++head) {
            const std::uint32_t c = queue_[head];
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t n = neighbors_[c][i];
                if (cells_[c][i] == vertex || n == no_cell || from_[position(n)] != unseen) continue;
                if (component.body.holds(registry_.table(), regions_[n]) == component.inside) {
                    if (from_[position(c)] == no_cell) continue;  // none between
                    Move move;
                    std::uint32_t step = c;
                    for (; from_[position(step)] != no_cell; step = from_[position(step)])
                        move.cells.push_back(step);
                    move.region = regions_[step];
                    consider(move);
                    if (regions_[n] != move.region) {
                        move.region = regions_[n];
                        consider(std::move(move));
                    }
                    return;
                }
                if (!cuts_->lies_beside(n, vertex, above)) continue;
                from_[position(n)] = c;
                queue_.push_back(n);
            }
        }
    }

    void try_single_cells(const StarComponent& component) {
        if (component.cells.size() < 2) return;
        for (const std::uint32_t c : component.cells) {
            if (const auto region = region_beside({c}, component.body, component.inside))
                consider({{c}, *region});
        }
    }

    // One cell at the vertex, or it and the one behind it, changes sides, joined to cells of that side.
    void try_regain(std::uint32_t vertex, std::uint32_t structure) {
        const bool was_inside = registry_.table().contains(regions_[stars_.at(vertex)[0]], structure);
        for (const std::uint32_t c : stars_.at(vertex)) {
            const Region region = registry_.with_other_side(regions_[c], structure);
            const int own =
                static_cast<int>(std::find(cells_[c].begin(), cells_[c].end(), vertex) - cells_[c].begin());
            const std::uint32_t behind = neighbors_[c][own];
            if (behind == no_cell) continue;
            if (inside(behind, structure) != was_inside) {
                consider({{c}, regions_[behind]});
                consider({{c}, region});
            } else {
                for (const std::uint32_t next : neighbors_[behind]) {
                    if (next == no_cell || inside(next, structure) == was_inside) continue;
                    consider({{c, behind}, regions_[next]});
                    break;
                }
            }
        }
    }

    // A cell at the edge, or it and one of those beside or behind it, changes sides, joined to cells of that
    // side.
    void try_regain_subsegment(std::uint32_t vertex, ContourOwners::Subsegment subsegment) {
        for (const std::uint32_t c : stars_.at(vertex)) {
            if (std::find(cells_[c].begin(), cells_[c].end(), subsegment.other) == cells_[c].end()) continue;
            const bool was_inside = inside(c, subsegment.structure);
            consider({{c}, registry_.with_other_side(regions_[c], subsegment.structure)});
            for (const std::uint32_t next : neighbors_[c]) {
                if (next == no_cell) continue;
                if (inside(next, subsegment.structure) != was_inside) {
                    consider({{c}, regions_[next]});
                    continue;
                }
                for (const std::uint32_t far : neighbors_[next]) {
                    if (far == no_cell || inside(far, subsegment.structure) == was_inside) continue;
                    consider({{c, next}, regions_[far]});
                }
            }
        }
    }

    bool inside(std::uint32_t cell, std::uint32_t structure) const {
        return registry_.table().contains(regions_[cell], structure);
    }

    std::optional<Region> region_beside(const std::vector<std::uint32_t>& component, Body body,
                                        bool is_inside) {
        std::vector<std::pair<Region, int>> contacts;
        for (const std::uint32_t c : component) {
            for (const std::uint32_t n : neighbors_[c]) {
                if (n == no_cell || body.holds(registry_.table(), regions_[n]) == is_inside) continue;
                auto place = std::find_if(contacts.begin(), contacts.end(),
                                          [&](auto& x) { return x.first == regions_[n]; });
                if (place == contacts.end()) place = contacts.insert(contacts.end(), {regions_[n], 0});
                ++place->second;
            }
        }
        if (contacts.empty()) return std::nullopt;
        return std::max_element(contacts.begin(), contacts.end(),
                                [](auto& a, auto& b) {
                                    return a.second != b.second ? a.second < b.second : a.first > b.first;
                                })
            ->first;
    }

    // How the sum of defects would change, which the move is told; or, where that is `enough` or more, a part
    // of it that is.
    int change_of(Move& move, int enough) {
        around_.clear();
        for (const std::uint32_t c : move.cells)
            around_.insert(around_.end(), cells_[c].begin(), cells_[c].end());
        std::sort(around_.begin(), around_.end());
        around_.erase(std::unique(around_.begin(), around_.end()), around_.end());
        move.change = move.lost = 0;
        const auto add = [&](int defect, int lost, int times) {
            move.lost += times * lost;
            move.change += times * (defect_weight * defect + lost);
        };
        for (const std::uint32_t v : around_) add(figures_at(v).defect, figures_at(v).lost_subsegments, -1);
        before_.clear();
        for (const std::uint32_t c : move.cells) {
            before_.push_back(regions_[c]);
            regions_[c] = move.region;
        }
        for (const std::uint32_t v : around_) {
            if (move.change >= enough) break;  // it only rises from here on
            add(analyzer_.defect(v), analyzer_.lost_subsegment_count(v), 1);
        }
        for (std::size_t n = 0; n < move.cells.size(); ++n) regions_[move.cells[n]] = before_[n];
        return move.change;
    }

    int misplaced(std::uint32_t cell, Region region) const {
        if (sides_.empty()) return 0;
        return static_cast<int>(std::count_if(cells_[cell].begin(), cells_[cell].end(), [&](std::uint32_t v) {
            return !(sides_[v].depth_mm < near_mm_) && !allows(registry_.table(), sides_[v], region);
        }));
    }

    // Of the vertices of its cells that lie deep in a region: those with a cell that they do not allow, after
    // the move less before it.
    int spikes(const Move& move) {
        if (sides_.empty()) return 0;
        int sum = 0;
        around_.clear();
        for (const std::uint32_t c : move.cells)
            around_.insert(around_.end(), cells_[c].begin(), cells_[c].end());
        std::sort(around_.begin(), around_.end());
        around_.erase(std::unique(around_.begin(), around_.end()), around_.end());
        for (const std::uint32_t v : around_) {
            if (!(sides_[v].depth_mm > deep_mm_)) continue;
            bool was = false, is = false;
            for (const std::uint32_t c : stars_.at(v)) {
                const bool moved = std::find(move.cells.begin(), move.cells.end(), c) != move.cells.end();
                was = was || !allows(registry_.table(), sides_[v], regions_[c]);
                is = is || !allows(registry_.table(), sides_[v], moved ? move.region : regions_[c]);
            }
            sum += is - was;
        }
        return sum;
    }

    void consider(Move move) {
        if (std::any_of(move.cells.begin(), move.cells.end(), [&](std::uint32_t c) { return is_held(c); }))
            return;
        // Openings are compared by it.
        const bool falls = change_of(move, openings_ ? any_change : 0) < 0;
        if (falls == openings_.has_value() || (move.lost > 0 && !may_lose_)) return;
        for (const std::uint32_t c : move.cells)
            move.misplaced += misplaced(c, move.region) - misplaced(c, regions_[c]);
        if (move.misplaced > 0 && move.change > -defect_weight / 2) return;
        move.spikes = spikes(move);
        if (openings_) {
            if (move.spikes <= 0) openings_->push_back(std::move(move));
            return;
        }
        if (move.spikes > 0 && !may_spike_ && !may_bridge_deep_) return;
        if (cuts_) move.spoiled = cuts_->change(move.cells, move.region);
        if (move.spoiled > least_spoiled_ && !may_spoil_) return;
        const auto key = [&](const Move& m) {
            return std::make_tuple(std::max(m.lost, 0), m.change, m.spikes, m.spoiled > least_spoiled_,
                                   m.misplaced, m.cells.size(), m.spoiled);
        };
        if (!best_ || key(move) < key(*best_)) best_ = std::move(move);
    }

    const std::vector<Cell>& cells_;
    const std::vector<CellNeighbors>& neighbors_;
    const VertexStars& stars_;
    const std::vector<VertexMembership>& sides_;
    const double deep_mm_, near_mm_;
    std::optional<DrawnCuts> cuts_;
    const bool is_stack_;
    const double least_spoiled_;  // that counts: as Move::spoiled
    bool may_spike_ = false, may_spoil_ = false, may_lose_ = false;
    bool may_bridge_deep_ = false;  // as may_spike_, of the move that is considered
    std::vector<Region>& regions_;
    RegionRegistry& registry_;
    const ContourOwners& owners_;
    StarAnalyzer analyzer_;
    std::vector<Figures> known_;  // by vertex
    std::optional<Move> best_;
    std::optional<std::vector<Move>> openings_;  // while they are sought
    std::vector<std::uint32_t> held_;            // cells that no move takes
    std::vector<std::pair<std::uint32_t, Region>> made_;
    std::vector<StarComponent> components_;
    std::vector<std::uint32_t> lost_, around_, from_, queue_;
    std::vector<ContourOwners::Subsegment> lost_subsegments_;
    std::vector<Region> before_;
};

// A vertex with a defect.
struct Suspect {
    std::uint32_t vertex;
    int lost_subsegments;
    bool unsound, lost;
};

// Those of `look`, or of all vertices where it is empty; in their order.
std::vector<Suspect> find_suspects(const RelabelledMesh& mesh, const std::vector<std::uint32_t>& look,
                                   int threads) {
    const VertexStars& stars = mesh.stars;
    const std::size_t count = look.empty() ? mesh.points.size() : look.size();
    // Only vertices of an interface, or of a contour, can have one.
    const auto can_be = [&](std::uint32_t v) {
        const auto star = stars.at(v);
        return std::any_of(star.begin(), star.end(),
                           [&](std::uint32_t c) { return mesh.regions[c] != mesh.regions[star[0]]; }) ||
               !mesh.owners.at(v).empty() || !mesh.owners.subsegments_at(v).empty();
    };
    // Few pieces: an analyzer has scratch space for all cells.
    const std::size_t grain = std::max<std::size_t>(4096, count / 8 + 1);
    return parallel_collect<Suspect>(
        count, grain, threads, [&](std::size_t first, std::size_t last, std::vector<Suspect>& found) {
            StarAnalyzer analyzer(mesh.cells, mesh.neighbors, stars, mesh.regions, mesh.registry.table(),
                                  mesh.owners);
            std::vector<std::uint32_t> lost, vertices;
            for (std::size_t n = first; n < last; ++n) {
                const std::uint32_t v = look.empty() ? static_cast<std::uint32_t>(n) : look[n];
                if (!look.empty() || can_be(v)) vertices.push_back(v);
            }
            for (std::size_t n = 0; n < vertices.size(); ++n) {
                const std::uint32_t v = vertices[n];
                if (n + stars_ahead < vertices.size()) {
                    for (const std::uint32_t c : stars.at(vertices[n + stars_ahead])) {
                        __builtin_prefetch(&mesh.cells[c]);
                        __builtin_prefetch(&mesh.neighbors[c]);
                    }
                }
                Suspect suspect{v, analyzer.lost_subsegment_count(v), analyzer.defect(v) > 0, false};
                if (!suspect.unsound && suspect.lost_subsegments == 0) continue;
                analyzer.lost_structures(v, lost);
                suspect.lost = suspect.unsound && !lost.empty();
                found.push_back(suspect);
            }
        });
}

std::vector<std::uint32_t> nearly_flat_cells(const std::vector<Vec3>& points, const std::vector<Cell>& cells,
                                             int threads) {
    return parallel_collect<std::uint32_t>(
        cells.size(), 16384, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& found) {
            for (std::size_t c = first; c < last; ++c) {
                if (c + cells_ahead < last) prefetch_points(points, cells[c + cells_ahead]);
                if (nearly_flat(points, cells[c])) found.push_back(static_cast<std::uint32_t>(c));
            }
        });
}

// Those of the vertices, rising.
std::vector<std::uint32_t> with_defects(Relabeler& relabeler, std::vector<std::uint32_t> vertices) {
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    std::erase_if(vertices, [&](std::uint32_t v) { return relabeler.total(v) == 0; });
    return vertices;
}

// Those at the vertices of `look`, or of all where it is empty, that are other than what is drawn where a
// plane cuts them; rising.
std::vector<std::uint32_t> wrong_cells(const RelabelledMesh& mesh, const SlicePlanes& slices,
                                       const std::vector<std::uint32_t>& look, int threads) {
    std::vector<std::uint32_t> among;
    for (const std::uint32_t v : look)
        among.insert(among.end(), mesh.stars.at(v).begin(), mesh.stars.at(v).end());
    std::sort(among.begin(), among.end());
    among.erase(std::unique(among.begin(), among.end()), among.end());
    const auto on_interface = [&](std::uint32_t c) {
        return std::any_of(mesh.neighbors[c].begin(), mesh.neighbors[c].end(), [&](std::uint32_t n) {
            return n != no_cell && mesh.regions[n] != mesh.regions[c];
        });
    };
    return parallel_collect<std::uint32_t>(
        look.empty() ? mesh.cells.size() : among.size(), 16384, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& found) {
            DrawnCuts cuts(mesh.points, mesh.cells, mesh.neighbors, mesh.regions, mesh.registry.table(),
                           slices);
            for (std::size_t n = first; n < last; ++n) {
                const std::uint32_t c = look.empty() ? static_cast<std::uint32_t>(n) : among[n];
                if (on_interface(c) && cuts.wanted(c)) found.push_back(c);
            }
        });
}

}  // namespace

RelabelStats relabel(const RelabelledMesh& mesh, const RelabelOptions& options,
                     std::vector<std::uint32_t>& unsound, const std::vector<std::uint32_t>& look, int threads,
                     const SlicePlanes& slices) {
    RelabelStats stats;
    std::vector<std::uint32_t> queue;
    for (const Suspect& suspect : find_suspects(mesh, look, threads)) {
        queue.push_back(suspect.vertex);
        stats.unsound_before += suspect.unsound;
        stats.lost_before += suspect.lost;
        stats.lost_subsegments_before += static_cast<std::uint64_t>(suspect.lost_subsegments);
    }
    stats.lost_subsegments_before /= 2;

    Relabeler relabeler(mesh, options, slices);
    // Of one structure the subsegments that waiting would cost are worth more than a spike;
    // but a spike is no way round a cut that is spoiled.
    const bool one_structure = mesh.registry.table().members.size() <= 2;
    bool spoiling = !slices.any(), spikes = one_structure && !slices.is_stack(),
         losses = !options.losses_wait;
    relabeler.allow_spikes(spikes);
    relabeler.allow_spoiling(spoiling);
    relabeler.allow_losses(losses);
    const auto work_through = [&] {
        while (!queue.empty()) {
            std::vector<std::uint32_t> next;
            bool moved = false;
            for (const std::uint32_t v : queue) {
                if (relabeler.total(v) == 0) continue;
                const std::size_t count = relabeler.improve(v, next);
                stats.cells_moved += count;
                moved = moved || count > 0;
                next.push_back(v);
            }
            queue = with_defects(relabeler, std::move(next));
            if (!moved && !losses) {
                losses = true;
                relabeler.allow_losses(true);
            } else if (!moved) {
                if (spikes && spoiling) break;
                spikes = spikes || spoiling || one_structure;
                spoiling = true;
                relabeler.allow_spikes(spikes);
                relabeler.allow_spoiling(spoiling);
            }
        }
    };
    const auto work_in_depth = [&] {
        for (int pass = 0; pass < most_passes_in_depth && !queue.empty(); ++pass) {
            std::vector<std::uint32_t> next;
            for (const std::uint32_t v : queue) {
                if (relabeler.lost_subsegments(v) > 0)
                    stats.cells_moved += relabeler.improve_in_depth(v, next);
            }
            if (next.empty()) break;
            next.insert(next.end(), queue.begin(), queue.end());
            queue = with_defects(relabeler, std::move(next));
            work_through();
        }
    };
    const auto work = [&] {
        work_through();
        if (!slices.is_stack()) work_in_depth();
    };
    std::vector<std::uint32_t> flat;
    parallel_tasks(threads, {work, [&] { flat = nearly_flat_cells(mesh.points, mesh.cells, threads); }});
    for (const std::uint32_t c : flat) stats.flat_cells_peeled += relabeler.peel(c);
    if (slices.any()) {
        const std::vector<std::uint32_t> wrong = wrong_cells(mesh, slices, look, threads);
        std::vector<std::uint32_t> touched = std::move(queue);
        for (int pass = 0; pass < most_mends; ++pass) {
            const std::uint64_t before = stats.cells_mended;
            for (const std::uint32_t c : wrong) stats.cells_mended += relabeler.mend(c, touched);
            if (stats.cells_mended == before) break;
        }
        queue = with_defects(relabeler, std::move(touched));
    }
    unsound.clear();
    for (const std::uint32_t v : queue) {
        if (relabeler.defect(v) > 0) unsound.push_back(v);
        stats.lost_subsegments_after += static_cast<std::uint64_t>(relabeler.lost_subsegments(v));
    }
    stats.lost_subsegments_after /= 2;
    stats.unsound_after = unsound.size();
    for (const std::uint32_t v : unsound) stats.lost_after += relabeler.lost(v);
    return stats;
}

}  // namespace anatomesh
