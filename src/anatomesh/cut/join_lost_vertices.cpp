#include "anatomesh/cut/join_lost_vertices.h"

#include <algorithm>
#include <map>

#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

// Nothing of the other side is near: the largest cell at the vertex starts a component of it.
bool start_component(NonmanifoldPatch& patch, const VertexStars& stars, std::uint32_t vertex,
                     std::uint32_t structure) {
    std::uint32_t largest = no_cell;
    double most = 0;
    for (const std::uint32_t c : stars.at(vertex)) {
        const Cell& cell = patch.cells[c];
        const double volume = signed_volume(patch.points[cell[0]], patch.points[cell[1]],
                                            patch.points[cell[2]], patch.points[cell[3]]);
        if (volume <= most) continue;
        most = volume;
        largest = c;
    }
    if (largest == no_cell) return false;
    patch.regions[largest] = patch.registry.with_other_side(patch.regions[largest], structure);
    return true;
}

// Breadth-first from the cells at the vertex to the nearest cell on the other side; the path changes side.
bool join(NonmanifoldPatch& patch, const VertexStars& stars, std::uint32_t vertex, std::uint32_t structure) {
    // It marks a cell that the search has not reached. [index that no cell has; 0xFFFFFFFE; D]
    constexpr std::uint32_t unseen = 0xFFFFFFFEu;
    std::vector<std::uint32_t> from(patch.cells.size(), unseen), queue;
    const bool was_inside = patch.table().contains(patch.regions[stars.at(vertex)[0]], structure);
    for (const std::uint32_t c : stars.at(vertex)) {
        from[c] = no_cell;
        queue.push_back(c);
    }
    for (std::size_t head = 0; head < queue.size(); ++head) {
        const std::uint32_t c = queue[head];
        for (const std::uint32_t n : patch.neighbors[c]) {
            if (n == no_cell || from[n] != unseen) continue;
            from[n] = c;
            queue.push_back(n);
            if (patch.table().contains(patch.regions[n], structure) == was_inside) continue;
            for (std::uint32_t step = c; step != no_cell; step = from[step])
                patch.regions[step] = patch.regions[n];
            return true;
        }
    }
    return start_component(patch, stars, vertex, structure);
}

// To the region with which the component shares the most facets at the vertex across its body's surface.
bool relabel_to_other_side(NonmanifoldPatch& patch, std::uint32_t vertex, const StarComponent& component) {
    std::map<Region, int> facets;
    for (const std::uint32_t c : component.cells) {
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t n = patch.neighbors[c][i];
            if (patch.cells[c][i] != vertex && n != no_cell &&
                component.body.holds(patch.table(), patch.regions[n]) != component.inside)
                ++facets[patch.regions[n]];
        }
    }
    if (facets.empty()) return false;
    const Region region = std::max_element(facets.begin(), facets.end(), [](const auto& x, const auto& y) {
                              return x.second < y.second;
                          })->first;
    for (const std::uint32_t c : component.cells) patch.regions[c] = region;
    return true;
}

}  // namespace

std::uint64_t join_lost_vertices(NonmanifoldPatch& patch, PatchStars& stars) {
    std::uint64_t joined = 0;
    std::vector<std::uint32_t> lost;
    for (const std::uint32_t v : stars.nonmanifold) {
        stars.analyzer.lost_structures(v, lost);
        for (const std::uint32_t structure : lost) joined += join(patch, stars.stars, v, structure);
    }
    return joined;
}

std::uint64_t relabel_components(NonmanifoldPatch& patch, PatchStars& stars) {
    std::uint64_t relabelled = 0;
    std::vector<StarComponent> components;
    for (const std::uint32_t v : stars.nonmanifold) {
        stars.analyzer.surplus_components(v, components);
        std::erase_if(components, [](const StarComponent& component) { return component.largest; });
        if (components.empty()) continue;
        const StarComponent& least = *std::min_element(
            components.begin(), components.end(),
            [](const StarComponent& x, const StarComponent& y) { return x.cells.size() < y.cells.size(); });
        relabelled += relabel_to_other_side(patch, v, least);
    }
    return relabelled;
}

}  // namespace anatomesh
