#include <array>
#include <span>

#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/improve/sections/section_operations.h"

namespace anatomesh {

namespace {

// Gives the cells the region, and takes it back unless their sections gain enough.
bool set_regions(SectionEdit& section, std::span<const std::uint32_t> cells, Region to, double before) {
    EditMesh& mesh = section.edit.mesh;
    const Region own = mesh.region(cells[0]);
    for (const std::uint32_t c : cells) mesh.set_region(c, to);
    if (!SectionEdit::is_enough(section.areas.wrong(cells), before)) {
        for (const std::uint32_t c : cells) mesh.set_region(c, own);
        return false;
    }
    section.edit.changed.assign(cells.begin(), cells.end());
    for (const std::uint32_t c : cells) {
        for (int i = 0; i < 4; ++i) section.edit.changed.push_back(mesh.neighbor(c, i));
    }
    return true;
}

}  // namespace

bool relabel_at_section(SectionEdit& section, std::uint32_t cell, Region to, const CellBounds& bounds) {
    const std::array cells{cell};
    const double before = section.areas.wrong(cells);
    return before > 0 && may_relabel(section.edit, cell, to, section.owners, bounds.sine, bounds.ratio) &&
           set_regions(section, cells, to, before);
}

bool relabel_both_at_section(SectionEdit& section, const std::array<std::uint32_t, 2>& cells,
                             const CellBounds& bounds) {
    const EditMesh& mesh = section.edit.mesh;
    const Region own = mesh.region(cells[0]);
    const double before = section.areas.wrong(cells);
    for (const std::uint32_t side : cells) {
        for (int i = 0; i < 4; ++i) {
            if (mesh.neighbor(side, i) == no_cell) return false;
            const Region to = mesh.region(mesh.neighbor(side, i));
            if (to != own &&
                may_relabel_all(section.edit, cells, to, section.owners, bounds.sine, bounds.ratio) &&
                set_regions(section, cells, to, before))
                return true;
        }
    }
    return false;
}

}  // namespace anatomesh
