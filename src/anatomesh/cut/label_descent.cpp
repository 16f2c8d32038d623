#include "anatomesh/cut/label_descent.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "anatomesh/base/sort_distinct.h"

namespace anatomesh {

namespace {

constexpr int any_change = std::numeric_limits<int>::max();
// So many moves that bring a subsegment back are followed, the cheapest first, [moves; >= 0; B]
constexpr std::size_t most_openings = 12;
constexpr int most_rounds_in_depth = 6;  // by so many rounds of moves. [rounds; >= 0; B]
// Where planes cross, a move spoils a cross-section if it is more of what is drawn than this: there every move spoils
// some a little. [1; 0 to 1e-3; M 2026-11 random sets of crossing planes]
constexpr double least_spoiled_share = 1e-4;

}  // namespace

int MovedMemberships::misplaced(std::uint32_t cell, Region region) const {
    const std::vector<VertexMembership>& of = mesh_.memberships;
    if (of.empty()) return 0;
    const Cell& vertices = mesh_.cells[cell];
    return static_cast<int>(std::count_if(vertices.begin(), vertices.end(), [&](std::uint32_t v) {
        return !(of[v].depth_mm < near_mm_) && !allows(mesh_.registry.table(), of[v], region);
    }));
}

int MovedMemberships::spikes(const LabelMove& move) {
    const std::vector<VertexMembership>& of = mesh_.memberships;
    if (of.empty()) return 0;
    const RegionTable& table = mesh_.registry.table();
    int sum = 0;
    vertices_of_cells(mesh_.cells, move.cells, around_);
    for (const std::uint32_t v : around_) {
        if (!(of[v].depth_mm > deep_mm_)) continue;
        bool was = false, is = false;
        for (const std::uint32_t c : mesh_.stars.at(v)) {
            const bool moved = std::find(move.cells.begin(), move.cells.end(), c) != move.cells.end();
            was = was || !allows(table, of[v], mesh_.regions[c]);
            is = is || !allows(table, of[v], moved ? move.region : mesh_.regions[c]);
        }
        sum += is - was;
    }
    return sum;
}

LabelDescent::LabelDescent(const RelabelledMesh& mesh, const RelabelOptions& options,
                           const SlicePlanes& slices)
    : mesh_(mesh), slices_(slices), singularities_(mesh), moves_(mesh), memberships_(mesh, options) {
    if (slices.any()) {
        sections_.emplace(mesh.points, mesh.cells, mesh.neighbors, mesh.regions, mesh.registry.table(),
                          slices);
    }
}

bool LabelDescent::is_lost(std::uint32_t vertex) {
    singularities_.analyzer().lost_structures(vertex, lost_);
    return !lost_.empty();
}

std::size_t LabelDescent::improve(std::uint32_t vertex, std::vector<std::uint32_t>& touched) {
    find_best(vertex);
    if (!best_) return 0;
    for (const std::uint32_t c : best_->cells) {
        singularities_.relabel_cell(c, best_->region);
        touched.insert(touched.end(), mesh_.cells[c].begin(), mesh_.cells[c].end());
    }
    return best_->cells.size();
}

std::size_t LabelDescent::improve_in_depth(std::uint32_t vertex, std::vector<std::uint32_t>& touched) {
    for (const LabelMove& opening : openings_at(vertex)) {
        made_.clear();
        if (follow(opening)) {
            for (const auto& [c, before] : made_)
                touched.insert(touched.end(), mesh_.cells[c].begin(), mesh_.cells[c].end());
            return made_.size();
        }
        for (auto made = made_.rbegin(); made != made_.rend(); ++made)
            singularities_.relabel_cell(made->first, made->second);
    }
    return 0;
}

bool LabelDescent::peel(std::uint32_t cell) {
    const std::vector<Region>& regions = mesh_.regions;
    for (const std::uint32_t n : mesh_.neighbors[cell]) {
        if (n == no_cell || regions[n] == regions[cell]) continue;
        int shared = 0;
        for (const std::uint32_t m : mesh_.neighbors[cell])
            shared += m != no_cell && regions[m] == regions[n];
        LabelMove move{{cell}, regions[n]};
        if (shared < 2 || singularities_.change_of(move, 1) > 0) continue;
        singularities_.relabel_cell(cell, regions[n]);
        return true;
    }
    return false;
}

bool LabelDescent::mend(std::uint32_t cell, std::vector<std::uint32_t>& touched) {
    const std::vector<std::uint32_t>* drawn = sections_ ? sections_->wanted(cell) : nullptr;
    if (!drawn) return false;
    LabelMove move{{cell}, mesh_.registry.intern(*drawn)};
    if (sections_->change(move.cells, move.region) >= 0 || singularities_.change_of(move, 1) > 0)
        return false;
    if (memberships_.misplaced(cell, move.region) > memberships_.misplaced(cell, mesh_.regions[cell]) ||
        memberships_.spikes(move) > 0)
        return false;
    singularities_.relabel_cell(cell, move.region);
    touched.insert(touched.end(), mesh_.cells[cell].begin(), mesh_.cells[cell].end());
    return true;
}

// The best move at the vertex that makes the sum fall, if any.
void LabelDescent::find_best(std::uint32_t vertex) {
    best_.reset();
    StarAnalyzer& analyzer = singularities_.analyzer();
    analyzer.surplus_components(vertex, components_);
    for (const StarComponent& component : components_) {
        if (!component.largest || components_.size() == 2) moves_.add_component(component, candidates_);
    }
    consider_candidates();
    if (may_bridge(vertex)) {
        for (const StarComponent& component : components_)
            moves_.add_bridges(vertex, component, *sections_, candidates_);
        // Where a structure touches itself in a point the other ways lose a corner of a cross-section.
        consider_candidates(allowed_.losses && moves_.touches_in_point(vertex));
    }
    if (!best_) {
        for (const StarComponent& component : components_) moves_.add_single_cells(component, candidates_);
        consider_candidates();
    }
    analyzer.lost_structures(vertex, lost_);
    for (const std::uint32_t structure : lost_) moves_.add_regaining(vertex, structure, candidates_);
    find_regaining(vertex);
}

// Considers the moves that bring back subsegments lost at the vertex, and other candidates before them.
void LabelDescent::find_regaining(std::uint32_t vertex) {
    singularities_.analyzer().lost_subsegments(vertex, lost_subsegments_);
    for (const ContourOwners::Subsegment& subsegment : lost_subsegments_)
        moves_.add_regaining(vertex, subsegment, candidates_);
    consider_candidates();
}

// Moves by which subsegments that are lost at the vertex come back and the sum does not fall, the
// cheapest first, each once.
std::vector<LabelMove> LabelDescent::openings_at(std::uint32_t vertex) {
    openings_.emplace();
    find_regaining(vertex);
    std::vector<LabelMove> openings = std::move(*openings_);
    openings_.reset();
    const auto key = [](const LabelMove& m) { return std::tie(m.change, m.cells, m.region); };
    for (LabelMove& opening : openings) std::sort(opening.cells.begin(), opening.cells.end());
    std::sort(openings.begin(), openings.end(),
              [&](const LabelMove& x, const LabelMove& y) { return key(x) < key(y); });
    openings.erase(std::unique(openings.begin(), openings.end(),
                               [&](const LabelMove& x, const LabelMove& y) { return key(x) == key(y); }),
                   openings.end());
    if (openings.size() > most_openings) openings.resize(most_openings);
    return openings;
}

// Makes this move and those after it, and says whether they serve.
bool LabelDescent::follow(const LabelMove& opening) {
    held_ = opening.cells;
    std::vector<std::uint32_t> queue;
    make(opening, queue);
    LabelMove all = opening;
    const auto serves = [&] {
        return all.change < 0 && all.lost < 0 && all.misplaced <= 0 && all.spikes <= 0;
    };
    for (int round = 0; round < most_rounds_in_depth && !serves(); ++round) {
        sort_distinct(queue);
        std::vector<std::uint32_t> next = queue;
        const std::size_t before = made_.size();
        for (const std::uint32_t v : queue) {
            if (singularities_.total(v) == 0) continue;
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

void LabelDescent::make(const LabelMove& move, std::vector<std::uint32_t>& touched) {
    for (const std::uint32_t c : move.cells) {
        made_.emplace_back(c, mesh_.regions[c]);
        singularities_.relabel_cell(c, move.region);
        touched.insert(touched.end(), mesh_.cells[c].begin(), mesh_.cells[c].end());
    }
}

// Where components may be joined: where what is drawn touches itself in a point, and, sooner than a cross-section
// is spoiled, where it is right.
bool LabelDescent::may_bridge(std::uint32_t vertex) {
    if (!slices_.is_stack()) return false;
    return moves_.touches_in_point(vertex) || (allowed_.spoiling && sections_->in_slice(vertex) &&
                                               !sections_->protrudes(mesh_.stars.at(vertex)));
}

void LabelDescent::consider_candidates(bool may_bridge_deep) {
    for (LabelMove& move : candidates_) consider(std::move(move), may_bridge_deep);
    candidates_.clear();
}

// Keeps the move if it is better than the best one so far, or is an opening while these are sought.
// `may_bridge_deep`: it may bring a deep vertex onto a surface though others may not yet.
void LabelDescent::consider(LabelMove move, bool may_bridge_deep) {
    if (std::any_of(move.cells.begin(), move.cells.end(), [&](std::uint32_t c) { return is_held(c); }))
        return;
    // Openings are compared by their change, so it has to be the whole one.
    const bool falls = singularities_.change_of(move, openings_ ? any_change : 0) < 0;
    if (falls == openings_.has_value() || (move.lost > 0 && !allowed_.losses)) return;
    for (const std::uint32_t c : move.cells) {
        move.misplaced +=
            memberships_.misplaced(c, move.region) - memberships_.misplaced(c, mesh_.regions[c]);
    }
    if (move.misplaced > 0 && move.change > -LabelSingularities::weight / 2) return;
    move.spikes = memberships_.spikes(move);
    if (openings_) {
        if (move.spikes <= 0) openings_->push_back(std::move(move));
        return;
    }
    if (move.spikes > 0 && !allowed_.spikes && !may_bridge_deep) return;
    if (sections_) move.spoiled = sections_->change(move.cells, move.region);
    const double least_spoiled = slices_.cross() ? least_spoiled_share : 0;
    if (move.spoiled > least_spoiled && !allowed_.spoiling) return;
    const auto key = [&](const LabelMove& m) {
        return std::make_tuple(std::max(m.lost, 0), m.change, m.spikes, m.spoiled > least_spoiled,
                               m.misplaced, m.cells.size(), m.spoiled);
    };
    if (!best_ || key(move) < key(*best_)) best_ = std::move(move);
}

bool LabelDescent::is_held(std::uint32_t cell) const {
    return std::find(held_.begin(), held_.end(), cell) != held_.end();
}

}  // namespace anatomesh
