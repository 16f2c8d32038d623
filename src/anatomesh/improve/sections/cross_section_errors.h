// CrossSectionErrors: what is wrong in the cross-sections of a mesh, kept up to date while cells change.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/sections/section_areas.h"

namespace anatomesh {

// A table of what each cell has wrong, of the few cells that have something wrong. After an attempt at
// changing the mesh only the cells that changed are looked at again. The table is summed in the order of the
// cells, so its sums equal those of SectionAreas::sum_cuts() over all cells to the last bit (asserted).
class CrossSectionErrors {
  public:
    // Of cells of the mesh, rising: all, or the first that are looked at. The same for any `threads`.
    // Requires: context and areas outlive this. Complexity: as SectionAreas::errors_of().
    CrossSectionErrors(const EditContext& edit, const SectionAreas& areas,
                       std::span<const std::uint32_t> cells, int threads = 1);
    // Adds all cells but these first ones. Requires: the mesh is as it was. Complexity: as
    // SectionAreas::errors_of() of the others.
    void add_others(std::span<const std::uint32_t> cells, int threads = 1);

    // By structure and slice, as the weights of what is drawn. Of the mesh as it was when the table was made
    // or kept last.
    std::span<const double> sums() const { return kept_.sums; }

    // The same of the mesh as it is. Requires: the table is of all cells; no cells but those of `changed`,
    // rising, differ in shape, region or neighbours from what they were then, as EditMesh::changed_cells()
    // has it; those may be gone. Complexity: linear in the table, and as SectionAreas::errors_of() in the
    // cells that changed.
    std::span<const double> sums_after(std::span<const std::uint32_t> changed);

    // The mesh of the last sums_after() is the one that others are compared with from now on.
    void keep() { kept_ = after_; }

  private:
    struct Table {
        std::vector<SectionAreas::CrossSectionError> errors;  // by cell, rising
        std::vector<double> sums;
    };
    using CellErrors = std::vector<SectionAreas::CrossSectionError>;
    // Of cells that are all different ones.
    static CellErrors merged(const CellErrors& some, const CellErrors& others);
    void add_up(Table& table) const;
    bool is_up_to_date(const Table& table) const;

    const EditContext& edit_;
    const SectionAreas& areas_;
    Table kept_, after_;
};

}  // namespace anatomesh
