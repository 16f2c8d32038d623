#include "anatomesh/improve/surgery/structure_components.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace anatomesh {

namespace {

constexpr int steps_a_turn = 16;  // of one group, before it is the next one's turn [cells; > 0; B]

}  // namespace

ComponentChange StructureComponents::change(std::uint32_t structure, bool inside, std::uint32_t first_new) {
    structure_ = structure;
    inside_ = inside;
    find_nodes();
    start_groups();
    grow_groups();
    DisjointSets sets_before = connected_by_groups(), sets_now = sets_before;
    connect_before(sets_before);
    connect_now(sets_now);
    const Components before = count(sets_before, before_, first_new);
    Components now = count(sets_now, now_, first_new);
    std::sort(now.spurious.begin(), now.spurious.end());
    return {now.all - before.all, now.bare - before.bare, std::move(now.spurious)};
}

bool StructureComponents::has_drawn_vertex(const Cell& cell) const {
    return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return owners_.has(v, structure_); });
}

void StructureComponents::find_nodes() {
    changed_ = edit_.mesh.changed_cells();
    before_.clear();
    now_.clear();
    for (const auto& [cell, region] : edit_.mesh.states_before(changed_))
        before_.push_back(node_of(cell, region));
    for (const std::uint32_t c : changed_) now_.push_back(node_of(edit_.mesh.cell(c), edit_.mesh.region(c)));
}

// One of each cell that is as it was: its facets are, so that what it shares them with stays too, or is one
// of the changed cells.
void StructureComponents::start_groups() {
    marks_.resize(edit_.mesh.cell_count());
    ++search_;
    groups_.clear();
    std::vector<std::uint32_t> rim;
    for (std::size_t n = 0; n < changed_.size(); ++n) {
        marks_[changed_[n]] = {search_, none};
        if (now_[n].is_in && now_[n] == before_[n]) rim.push_back(changed_[n]);
    }
    groups_.resize(rim.size());
    group_sets_ = DisjointSets(rim.size());
    for (std::uint32_t g = 0; g < rim.size(); ++g) reach(rim[g], g);
}

void StructureComponents::reach(std::uint32_t c, std::uint32_t group) {
    Group& of = groups_[group];
    marks_[c] = {search_, group};
    of.cells.push_back(c);
    of.front.push_back(c);
    of.has_drawn = of.has_drawn || has_drawn_vertex(edit_.mesh.cell(c));
}

// Until all but one are whole, and of that it is known whether it has a vertex of a contour.
void StructureComponents::grow_groups() {
    std::vector<std::uint32_t> growing(groups_.size());
    std::iota(growing.begin(), growing.end(), 0u);
    const auto may_step = [&](std::uint32_t g) { return group_sets_.root(g) == g && !groups_[g].is_whole(); };
    for (;;) {
        std::erase_if(growing, [&](std::uint32_t g) { return !may_step(g); });
        if (growing.empty() || (growing.size() == 1 && groups_[growing.front()].has_drawn)) return;
        for (const std::uint32_t g : growing) {
            for (int n = 0; n < steps_a_turn && may_step(g); ++n) step(g);
        }
    }
}

// To the neighbours of one cell.
void StructureComponents::step(std::uint32_t group) {
    const std::uint32_t from = groups_[group].front[groups_[group].next++];
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t c = edit_.mesh.neighbor(from, i);
        if (c == no_cell || !node_of(edit_.mesh.cell(c), edit_.mesh.region(c)).is_in) continue;
        if (marks_[c].search != search_) {
            reach(c, group_sets_.root(group));
        } else if (marks_[c].group != none) {
            join_groups(group, marks_[c].group);
        }
    }
}

// What is known of the smaller one goes to the larger one's.
void StructureComponents::join_groups(std::uint32_t one, std::uint32_t other) {
    one = group_sets_.root(one);
    other = group_sets_.root(other);
    if (one == other) return;
    group_sets_.join(one, other);
    if (group_sets_.root(one) != one) std::swap(one, other);
    if (groups_[one].cells.size() < groups_[other].cells.size()) std::swap(groups_[one], groups_[other]);
    Group& to = groups_[one];
    const Group from = std::exchange(groups_[other], {});
    to.cells.insert(to.cells.end(), from.cells.begin(), from.cells.end());
    to.front.insert(to.front.end(), from.front.begin() + static_cast<std::ptrdiff_t>(from.next),
                    from.front.end());
    to.has_drawn = to.has_drawn || from.has_drawn;
}

DisjointSets StructureComponents::connected_by_groups() {
    const auto count = static_cast<std::uint32_t>(changed_.size());
    DisjointSets sets(count + groups_.size());
    for (std::uint32_t n = 0; n < count; ++n) {
        const std::uint32_t group = marks_[changed_[n]].group;
        if (group != none) sets.join(n, count + group_sets_.root(group));
    }
    return sets;
}

void StructureComponents::connect_now(DisjointSets& sets) const {
    for (std::uint32_t n = 0; n < changed_.size(); ++n) {
        for (int i = 0; i < 4 && now_[n].is_in; ++i) {
            const std::uint32_t c = edit_.mesh.neighbor(changed_[n], i);
            const auto at = std::lower_bound(changed_.begin(), changed_.end(), c);
            if (at == changed_.end() || *at != c) continue;
            const auto other = static_cast<std::uint32_t>(at - changed_.begin());
            if (now_[other].is_in) sets.join(n, other);
        }
    }
}

// By their facets: neighbours are not what they were.
void StructureComponents::connect_before(DisjointSets& sets) const {
    struct Facet {
        std::array<std::uint32_t, 3> vertices;
        std::uint32_t node;
    };
    std::vector<Facet> facets;
    for (std::uint32_t n = 0; n < before_.size(); ++n) {
        if (!before_[n].is_in) continue;
        for (const auto& [a, b, d] : facet_vertices) {
            Facet facet{{before_[n].cell[a], before_[n].cell[b], before_[n].cell[d]}, n};
            std::sort(facet.vertices.begin(), facet.vertices.end());
            facets.push_back(facet);
        }
    }
    std::sort(facets.begin(), facets.end(),
              [](const Facet& one, const Facet& other) { return one.vertices < other.vertices; });
    for (std::size_t n = 1; n < facets.size(); ++n) {
        if (facets[n].vertices == facets[n - 1].vertices) sets.join(facets[n].node, facets[n - 1].node);
    }
}

StructureComponents::Components StructureComponents::count(DisjointSets& sets, const std::vector<Node>& nodes,
                                                           std::uint32_t first_new) const {
    struct Component {
        bool is_any = false, has_drawn = false, has_new = false;
        std::vector<std::uint32_t> cells;
    };
    const auto node_count = static_cast<std::uint32_t>(nodes.size());
    std::vector<Component> components(nodes.size() + groups_.size());
    for (std::uint32_t g = 0; g < groups_.size(); ++g) {
        Component& of = components[sets.root(node_count + g)];
        of.has_drawn = of.has_drawn || groups_[g].has_drawn;
        // One more than a spurious component has is enough.
        const std::size_t taken = std::min(groups_[g].cells.size(), most_of_component_ + 1);
        of.cells.insert(of.cells.end(), groups_[g].cells.begin(),
                        groups_[g].cells.begin() + static_cast<std::ptrdiff_t>(taken));
    }
    for (std::uint32_t n = 0; n < node_count; ++n) {
        if (!nodes[n].is_in) continue;
        const Cell& cell = nodes[n].cell;
        Component& of = components[sets.root(n)];
        of.is_any = true;
        of.has_drawn = of.has_drawn || has_drawn_vertex(cell);
        of.has_new = of.has_new ||
                     std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return v >= first_new; });
        if (marks_[changed_[n]].group == none) of.cells.push_back(changed_[n]);
    }
    Components found;
    for (Component& component : components) {
        found.all += component.is_any;
        if (!component.is_any || component.has_drawn) continue;
        ++found.bare;
        if (!component.has_new || component.cells.size() > most_of_component_) continue;
        std::sort(component.cells.begin(), component.cells.end());
        found.spurious.push_back(std::move(component.cells));
    }
    return found;
}

}  // namespace anatomesh
