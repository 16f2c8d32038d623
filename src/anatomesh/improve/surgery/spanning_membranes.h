// find_chains, find_membranes: subsegments that run beside their structure's surface, and facets between them
// and it; find_membranes_across: facets between parts of a surface.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// Subsegments one after the other, with vertices in between that are off the structure's surface as well.
struct Chain {
    std::vector<std::uint32_t> vertices;
    std::uint32_t structure;

    bool has(std::uint32_t v) const {
        return std::find(vertices.begin(), vertices.end(), v) != vertices.end();
    }
};

// Facets between a chain and its structure's surface.
struct Membrane {
    std::vector<std::array<std::uint32_t, 3>> facets;  // corners rising
    // The rest of its rim, from end to end of the chain; without one all but the edge from end to end.
    std::vector<std::uint32_t> path;
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

// All chains of these subsegments (two vertices and a structure) that begin and end on their structures'
// surface, of 50 subsegments at most. Complexity: O(subsegments x stars).
std::vector<Chain> find_chains(EditContext& edit, const ContourOwners& owners,
                               std::span<const std::array<std::uint32_t, 3>> subsegments);

// Up to 16 membranes of a chain, grown facet by facet, the cheapest first, until the rest of the rim lies on
// the surface: by area, more where the field has the side that the chain is on. None has more than 8 facets
// beside one for each subsegment, none meets itself or touches a surface within its rim. `side`: of the
// structure, on which the chain lies. Same result every time. Complexity: O(4,000 membranes) at most.
std::vector<Membrane> find_membranes(EditContext& edit, const Chain& chain, bool side);

// Of a rim that runs over a surface from one vertex to the next and on to a third: on which of its two sides
// there is something that must stay there.
using RimSides = std::function<std::array<bool, 2>(std::uint32_t, std::uint32_t, std::uint32_t)>;

// The same among some vertices (rising) alone and without a chain: up to 6 membranes on one side of a
// structure, all of the rim of which lies on its surface, with a side on which nothing must stay, and which
// are `wanted`.
std::vector<Membrane> find_membranes_across(EditContext& edit, std::uint32_t structure, bool side,
                                            std::span<const std::uint32_t> vertices,
                                            const RimSides& rim_sides,
                                            const std::function<bool(const Membrane&)>& wanted);

}  // namespace anatomesh
