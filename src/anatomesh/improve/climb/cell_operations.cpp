#include "anatomesh/improve/climb/cell_operations.h"

#include "anatomesh/improve/operations/operations.h"

namespace anatomesh {

bool attempt_operation(EditContext& edit, std::uint32_t cell, OperationAttempt attempt) {
    const int n = attempt.place;
    switch (attempt.kind) {
        case CellOperation::remove_edge:
            return remove_edge(edit, cell, n);
        case CellOperation::remove_facet:
            return remove_facet(edit, cell, n);
        case CellOperation::move_vertex:
            return move_vertex(edit, edit.mesh.cell(cell)[static_cast<std::size_t>(n)]);
        case CellOperation::relabel:
            return relabel_cell(edit, cell);
        case CellOperation::collapse_edge:
            return collapse_edge(edit, cell, n / 2, n % 2 == 0);
        case CellOperation::insert_vertex:
            return insert_vertex(edit, cell, n);
        case CellOperation::split_edge:
            return split_edge(edit, cell, n);
        case CellOperation::split_facet:
            return split_facet(edit, cell, n);
        case CellOperation::split_cell:
            return split_cell(edit, cell);
        case CellOperation::insert_beside:
            return insert_beside(edit, cell);
    }
    return false;
}

}  // namespace anatomesh
