#include "anatomesh/cut/label_moves.h"

#include <algorithm>
#include <utility>

namespace anatomesh {

void LabelMoves::add_component(const StarComponent& component, std::vector<LabelMove>& moves) {
    if (const std::optional<Region> region =
            region_beside(component.cells, component.body, component.inside)) {
        moves.push_back({component.cells, *region});
    }
}

void LabelMoves::add_bridges(std::uint32_t vertex, const StarComponent& component,
                             const DrawnSections& sections, std::vector<LabelMove>& moves) {
    for (const bool above : {false, true}) add_bridge(vertex, component, sections, above, moves);
}

void LabelMoves::add_bridge(std::uint32_t vertex, const StarComponent& component,
                            const DrawnSections& sections, bool above, std::vector<LabelMove>& moves) {
    const auto star = mesh_.stars.at(vertex);
    const auto position = [&](std::uint32_t c) {
        return static_cast<std::size_t>(std::lower_bound(star.begin(), star.end(), c) - star.begin());
    };
    // It marks a cell that the search has not reached. [index that no cell has; 0xFFFFFFFE; D]
    constexpr std::uint32_t unseen = 0xFFFFFFFEu;
    from_.assign(star.size(), unseen);
    queue_ = component.cells;
    for (const std::uint32_t c : component.cells) from_[position(c)] = no_cell;
    for (std::size_t head = 0; head < queue_.size(); ++head) {
        const std::uint32_t c = queue_[head];
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t n = mesh_.neighbors[c][i];
            if (mesh_.cells[c][i] == vertex || n == no_cell || from_[position(n)] != unseen) continue;
            if (component.body.holds(mesh_.registry.table(), mesh_.regions[n]) == component.inside) {
                if (from_[position(c)] == no_cell) continue;  // none between
                LabelMove move;
                std::uint32_t step = c;
                for (; from_[position(step)] != no_cell; step = from_[position(step)])
                    move.cells.push_back(step);
                move.region = mesh_.regions[step];
                moves.push_back(move);
                if (mesh_.regions[n] != move.region) {
                    move.region = mesh_.regions[n];
                    moves.push_back(std::move(move));
                }
                return;
            }
            if (!sections.lies_beside(n, vertex, above)) continue;
            from_[position(n)] = c;
            queue_.push_back(n);
        }
    }
}

void LabelMoves::add_single_cells(const StarComponent& component, std::vector<LabelMove>& moves) {
    if (component.cells.size() < 2) return;
    for (const std::uint32_t c : component.cells) {
        if (const auto region = region_beside({c}, component.body, component.inside))
            moves.push_back({{c}, *region});
    }
}

void LabelMoves::add_regaining(std::uint32_t vertex, std::uint32_t structure, std::vector<LabelMove>& moves) {
    const bool was_inside = inside(mesh_.stars.at(vertex)[0], structure);
    for (const std::uint32_t c : mesh_.stars.at(vertex)) {
        const Region region = mesh_.registry.with_other_side(mesh_.regions[c], structure);
        const Cell& cell = mesh_.cells[c];
        const auto own = static_cast<std::size_t>(std::find(cell.begin(), cell.end(), vertex) - cell.begin());
        const std::uint32_t behind = mesh_.neighbors[c][own];
        if (behind == no_cell) continue;
        if (inside(behind, structure) != was_inside) {
            moves.push_back({{c}, mesh_.regions[behind]});
            moves.push_back({{c}, region});
        } else {
            for (const std::uint32_t next : mesh_.neighbors[behind]) {
                if (next == no_cell || inside(next, structure) == was_inside) continue;
                moves.push_back({{c, behind}, mesh_.regions[next]});
                break;
            }
        }
    }
}

void LabelMoves::add_regaining(std::uint32_t vertex, ContourOwners::Subsegment subsegment,
                               std::vector<LabelMove>& moves) {
    for (const std::uint32_t c : mesh_.stars.at(vertex)) {
        const Cell& cell = mesh_.cells[c];
        if (std::find(cell.begin(), cell.end(), subsegment.other) == cell.end()) continue;
        const bool was_inside = inside(c, subsegment.structure);
        moves.push_back({{c}, mesh_.registry.with_other_side(mesh_.regions[c], subsegment.structure)});
        for (const std::uint32_t next : mesh_.neighbors[c]) {
            if (next == no_cell) continue;
            if (inside(next, subsegment.structure) != was_inside) {
                moves.push_back({{c}, mesh_.regions[next]});
                continue;
            }
            for (const std::uint32_t far : mesh_.neighbors[next]) {
                if (far == no_cell || inside(far, subsegment.structure) == was_inside) continue;
                moves.push_back({{c, next}, mesh_.regions[far]});
            }
        }
    }
}

bool LabelMoves::touches_in_point(std::uint32_t vertex) const {
    const auto subsegments = mesh_.owners.subsegments_at(vertex);  // by their other ends
    std::size_t ends = 0;
    for (std::size_t n = 0; n < subsegments.size(); ++n)
        ends += n == 0 || subsegments[n].other != subsegments[n - 1].other;
    return ends >= 4;
}

std::optional<Region> LabelMoves::region_beside(const std::vector<std::uint32_t>& component, Body body,
                                                bool is_inside) const {
    std::vector<std::pair<Region, int>> contacts;
    for (const std::uint32_t c : component) {
        for (const std::uint32_t n : mesh_.neighbors[c]) {
            if (n == no_cell || body.holds(mesh_.registry.table(), mesh_.regions[n]) == is_inside) continue;
            const Region region = mesh_.regions[n];
            auto place = std::find_if(contacts.begin(), contacts.end(),
                                      [&](const auto& contact) { return contact.first == region; });
            if (place == contacts.end()) place = contacts.insert(contacts.end(), {region, 0});
            ++place->second;
        }
    }
    if (contacts.empty()) return std::nullopt;
    return std::max_element(contacts.begin(), contacts.end(),
                            [](const auto& a, const auto& b) {
                                return a.second != b.second ? a.second < b.second : a.first > b.first;
                            })
        ->first;
}

}  // namespace anatomesh
