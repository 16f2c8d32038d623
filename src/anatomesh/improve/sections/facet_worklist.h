// suspect_cells, visit_facets: the worklist of repairs that look at facets one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// What came of a visit to a facet of a cell.
enum class FacetVisit {
    next_facet,  // nothing; the cell's other facets are visited
    next_cell,   // nothing, and its other facets need no visit
    changed      // the context's `changed` are new cells or reshaped ones
};

// A repair has three members:
//   bool is_suspect(std::uint32_t cell) const     whether the cell, which may be gone, is worth a look
//   int next_facet(std::uint32_t cell, int from)  the first facet from that on that is to be visited; 4: none
//   FacetVisit visit(std::uint32_t cell, int facet)

// All suspect cells, rising; the same for any `threads`. Requires: is_suspect() is safe in threads.
template <class Repair>
std::vector<std::uint32_t> suspect_cells(const EditMesh& mesh, const Repair& repair, int threads) {
    constexpr std::size_t cells_a_share = 16384;  // of one thread [cells; > 0; B]
    return parallel_collect<std::uint32_t>(
        mesh.cell_count(), cells_a_share, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& found) {
            for (std::size_t n = first; n < last; ++n) {
                const auto c = static_cast<std::uint32_t>(n);
                if (repair.is_suspect(c)) found.push_back(c);
            }
        });
}

// Visits the facets of cells in order, until one of a cell is changed. Changed cells that are suspect are
// appended, and visited too. Ends before a cell for which `goes_on()` is false.
template <class Repair, class GoesOn>
void visit_facets(const EditContext& edit, std::vector<std::uint32_t>& waiting, Repair& repair,
                  const GoesOn& goes_on) {
    for (std::size_t n = 0; n < waiting.size() && goes_on(); ++n) {
        const std::uint32_t c = waiting[n];
        for (int i = repair.next_facet(c, 0); i < 4; i = repair.next_facet(c, i + 1)) {
            const FacetVisit seen = repair.visit(c, i);
            if (seen == FacetVisit::next_facet) continue;
            if (seen == FacetVisit::changed) {
                for (const std::uint32_t changed : edit.changed) {
                    if (repair.is_suspect(changed)) waiting.push_back(changed);
                }
            }
            break;
        }
    }
}

}  // namespace anatomesh
