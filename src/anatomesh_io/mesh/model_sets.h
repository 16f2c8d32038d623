// Sets that files for simulation carry: facets of interfaces and of structures, and the nodes on them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

// It stands for no facet. [index; 2^64 - 1; D]
inline constexpr std::uint64_t no_facet = ~std::uint64_t{0};

// A facet between two regions; `outer` may be 0, outside. Facets are 4 cell + i, opposite vertex i.
struct InterfaceFacet {
    Region inner = 0, outer = 0;     // inner is the smaller one that is not 0
    std::uint64_t facet = 0;         // of the cell in `inner`
    std::uint64_t other = no_facet;  // of the cell in `outer`; no_facet where there is none
    friend auto operator<=>(const InterfaceFacet&, const InterfaceFacet&) = default;
};

// All of them, by pair of regions, then by facet. O(n log n).
std::vector<InterfaceFacet> interface_facets(const TetMesh& mesh);

// A consecutive piece of these with one pair of regions.
struct Interface {
    Region inner = 0, outer = 0;
    std::span<const InterfaceFacet> facets;
    std::string name() const { return "INTERFACE_" + std::to_string(inner) + "_" + std::to_string(outer); }
};
std::vector<Interface> interfaces(std::span<const InterfaceFacet> facets);

// The boundary of a structure: facets of its own cells, towards what is not the structure; sorted.
std::vector<std::uint64_t> structure_facets(std::span<const InterfaceFacet> facets,
                                            const RegionTable& regions, std::uint32_t structure);

// Which regions occur in the mesh.
std::vector<bool> used_regions(const ModelFile& model);

// Nodes (quadratic_nodes.h) of the cells whose region contains the structure, and of facets; ascending.
std::vector<std::uint64_t> structure_nodes(const ModelFile& model, std::uint32_t structure);
std::vector<std::uint64_t> facet_nodes(const ModelFile& model, std::span<const std::uint64_t> facets);

// The corners of a facet, counter-clockwise from outside, then the nodes on its edges 01, 12, 20, if any.
std::vector<std::uint64_t> nodes_of_facet(const ModelFile& model, std::uint64_t facet);

// Cells with one of the facets, ascending.
std::vector<std::uint32_t> cells_of_facets(std::span<const std::uint64_t> facets);

// "STRUCTURE_5"; a number below 0 as "STRUCTURE_M5".
std::string structure_set_name(std::int32_t number);

// Cells of one region and one material (0 where the model has none), by region, then by material.
struct CellBlock {
    Region region = 0;
    std::uint32_t material = 0;
    std::vector<std::uint32_t> cells;
};
std::vector<CellBlock> cell_blocks(const ModelFile& model);

}  // namespace anatomesh
