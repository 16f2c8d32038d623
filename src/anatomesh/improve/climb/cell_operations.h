// The local operations on a bad cell in the order in which the hill climber tries them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

enum class CellOperation : std::uint8_t {
    remove_edge,
    remove_facet,
    move_vertex,
    relabel,
    collapse_edge,
    insert_vertex,
    split_edge,
    split_facet,
    split_cell,
    insert_beside
};

// A set of kinds of operations. O(1)
class OperationSet {
  public:
    constexpr OperationSet with(CellOperation kind) const { return OperationSet(bits_ | bit(kind)); }
    constexpr OperationSet without(CellOperation kind) const { return OperationSet(bits_ & ~bit(kind)); }
    constexpr bool has(CellOperation kind) const { return (bits_ & bit(kind)) != 0; }
    friend bool operator==(OperationSet, OperationSet) = default;

    constexpr OperationSet() = default;

  private:
    constexpr explicit OperationSet(std::uint32_t bits) : bits_(bits) {}
    static constexpr std::uint32_t bit(CellOperation kind) { return 1u << static_cast<unsigned>(kind); }
    std::uint32_t bits_ = 0;
};

// What helps most cells, at a low price.
inline constexpr OperationSet ordinary_operations = OperationSet()
                                                        .with(CellOperation::remove_edge)
                                                        .with(CellOperation::remove_facet)
                                                        .with(CellOperation::move_vertex)
                                                        .with(CellOperation::relabel)
                                                        .with(CellOperation::collapse_edge)
                                                        .with(CellOperation::insert_vertex);
// These put vertices on interfaces and try many places, so that only the few cells that nothing else helps
// are worth them.
inline constexpr OperationSet thorough_operations = ordinary_operations.with(CellOperation::split_edge)
                                                        .with(CellOperation::split_facet)
                                                        .with(CellOperation::split_cell)
                                                        .with(CellOperation::insert_beside);

// An operation on one edge, facet or vertex of a cell.
struct OperationAttempt {
    CellOperation kind;
    int place;  // index of the edge, facet or vertex; of a collapse, twice the edge's plus one for its direction
};

// All attempts on a cell, the cheapest first: six edges, four facets, four vertices, the cell, twelve
// directed edges, six edges, then the splits.
inline constexpr auto operation_attempts = [] {
    struct Row {
        CellOperation kind;
        int places;
    };
    constexpr std::array<Row, 10> rows{{{CellOperation::remove_edge, 6},
                                        {CellOperation::remove_facet, 4},
                                        {CellOperation::move_vertex, 4},
                                        {CellOperation::relabel, 1},
                                        {CellOperation::collapse_edge, 12},
                                        {CellOperation::insert_vertex, 6},
                                        {CellOperation::split_edge, 6},
                                        {CellOperation::split_facet, 4},
                                        {CellOperation::split_cell, 1},
                                        {CellOperation::insert_beside, 1}}};
    std::array<OperationAttempt, 45> attempts{};
    std::size_t n = 0;
    for (const Row& row : rows) {
        for (int place = 0; place < row.places; ++place) attempts[n++] = {row.kind, place};
    }
    return attempts;
}();

// The first attempts can be evaluated on a speculative context (edit_context.h). [attempts; 0 to 45; D]
inline constexpr std::size_t speculative_attempts = 14;

// Applies an operation if it gains; says whether it did (operations.h).
bool attempt_operation(EditContext& edit, std::uint32_t cell, OperationAttempt attempt);

}  // namespace anatomesh
