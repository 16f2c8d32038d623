#include "anatomesh_io/mesh/model_sets.h"

#include <algorithm>
#include <map>

#include "anatomesh_io/mesh/quadratic_nodes.h"

namespace anatomesh {

namespace {

// The place in a cell's six of the edge between its vertices a and b.
std::size_t edge_between(int a, int b) {
    std::size_t e = 0;
    while (cell_edges[e][0] != std::min(a, b) || cell_edges[e][1] != std::max(a, b)) ++e;
    return e;
}

template <class T>
void sort_unique(std::vector<T>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

std::vector<InterfaceFacet> interface_facets(const TetMesh& mesh) {
    struct Facet {
        std::array<std::uint32_t, 3> vertices;
        std::uint64_t id;
        auto operator<=>(const Facet&) const = default;
    };
    std::vector<Facet> facets;
    facets.reserve(4 * mesh.cells.size());
    for (std::uint64_t c = 0; c < mesh.cells.size(); ++c) {
        for (std::uint64_t i = 0; i < 4; ++i) {
            Facet facet{{}, 4 * c + i};
            for (std::size_t k = 0; k < 3; ++k) {
                facet.vertices[k] = mesh.cells[c][static_cast<std::size_t>(facet_vertices[i][k])];
            }
            std::sort(facet.vertices.begin(), facet.vertices.end());
            facets.push_back(facet);
        }
    }
    std::sort(facets.begin(), facets.end());
    std::vector<InterfaceFacet> result;
    const auto region_of = [&](const Facet& facet) { return mesh.regions[facet.id / 4]; };
    for (std::size_t begin = 0, end = 0; begin < facets.size(); begin = end) {
        end = begin + 1;
        while (end < facets.size() && facets[end].vertices == facets[begin].vertices) ++end;
        const Facet& first = facets[begin];
        if (end - begin == 1) {
            if (region_of(first) != 0) result.push_back({region_of(first), 0, first.id, no_facet});
        } else if (const Facet& second = facets[begin + 1]; region_of(first) != region_of(second)) {
            const bool first_inner =
                region_of(second) == 0 || (region_of(first) != 0 && region_of(first) < region_of(second));
            const Facet& inner = first_inner ? first : second;
            const Facet& outer = first_inner ? second : first;
            result.push_back({region_of(inner), region_of(outer), inner.id, outer.id});
        }
    }
    std::sort(result.begin(), result.end());
    return result;
}

std::vector<Interface> interfaces(std::span<const InterfaceFacet> facets) {
    std::vector<Interface> result;
    for (std::size_t begin = 0, end = 0; begin < facets.size(); begin = end) {
        const InterfaceFacet& first = facets[begin];
        while (end < facets.size() && facets[end].inner == first.inner && facets[end].outer == first.outer)
            ++end;
        result.push_back({first.inner, first.outer, facets.subspan(begin, end - begin)});
    }
    return result;
}

std::vector<std::uint64_t> structure_facets(std::span<const InterfaceFacet> facets,
                                            const RegionTable& regions, std::uint32_t structure) {
    std::vector<std::uint64_t> result;
    for (const InterfaceFacet& facet : facets) {
        const bool in = regions.contains(facet.inner, structure),
                   out = regions.contains(facet.outer, structure);
        if (in && !out) result.push_back(facet.facet);
        if (out && !in) result.push_back(facet.other);
    }
    std::sort(result.begin(), result.end());
    return result;
}

std::vector<bool> used_regions(const ModelFile& model) {
    std::vector<bool> used(model.description.regions.members.size(), false);
    for (const Region region : model.mesh.regions) used[region] = true;
    return used;
}

std::vector<std::uint64_t> structure_nodes(const ModelFile& model, std::uint32_t structure) {
    std::vector<bool> in(node_count(model), false);
    for (std::size_t c = 0; c < model.mesh.cells.size(); ++c) {
        if (!model.description.regions.contains(model.mesh.regions[c], structure)) continue;
        each_node(model, c, vtk_edge_order, [&](std::uint64_t n) { in[n] = true; });
    }
    std::vector<std::uint64_t> nodes;
    for (std::uint64_t n = 0; n < in.size(); ++n) {
        if (in[n]) nodes.push_back(n);
    }
    return nodes;
}

std::vector<std::uint64_t> nodes_of_facet(const ModelFile& model, std::uint64_t facet) {
    const std::size_t c = facet / 4;
    const auto& vertices = facet_vertices[facet % 4];
    std::vector<std::uint64_t> nodes;
    for (const int v : vertices) nodes.push_back(model.mesh.cells[c][static_cast<std::size_t>(v)]);
    if (model.mid_nodes.empty()) return nodes;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t edge = edge_between(vertices[k], vertices[(k + 1) % 3]);
        nodes.push_back(std::uint64_t{model.mesh.points.size()} + model.mid_nodes.cells[c][edge]);
    }
    return nodes;
}

std::vector<std::uint64_t> facet_nodes(const ModelFile& model, std::span<const std::uint64_t> facets) {
    std::vector<std::uint64_t> nodes;
    for (const std::uint64_t facet : facets) {
        const auto of_facet = nodes_of_facet(model, facet);
        nodes.insert(nodes.end(), of_facet.begin(), of_facet.end());
    }
    sort_unique(nodes);
    return nodes;
}

std::vector<std::uint32_t> cells_of_facets(std::span<const std::uint64_t> facets) {
    std::vector<std::uint32_t> cells;
    for (const std::uint64_t facet : facets) cells.push_back(static_cast<std::uint32_t>(facet / 4));
    sort_unique(cells);
    return cells;
}

std::string structure_set_name(std::int32_t number) {
    return number < 0 ? "STRUCTURE_M" + std::to_string(-static_cast<std::int64_t>(number))
                      : "STRUCTURE_" + std::to_string(number);
}

std::vector<CellBlock> cell_blocks(const ModelFile& model) {
    std::map<std::pair<Region, std::uint32_t>, std::size_t> place;
    std::vector<CellBlock> blocks;
    for (std::uint32_t c = 0; c < model.mesh.cells.size(); ++c) {
        const std::pair key{model.mesh.regions[c], model.material.empty() ? 0 : model.material[c]};
        const auto [found, is_new] = place.emplace(key, blocks.size());
        if (is_new) blocks.push_back({key.first, key.second, {}});
        blocks[found->second].cells.push_back(c);
    }
    std::sort(blocks.begin(), blocks.end(), [](const CellBlock& a, const CellBlock& b) {
        return a.region != b.region ? a.region < b.region : a.material < b.material;
    });
    return blocks;
}

}  // namespace anatomesh
