#include "anatomesh/improve/sections/cross_section_errors.h"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace anatomesh {

CrossSectionErrors::CrossSectionErrors(const EditContext& edit, const SectionAreas& areas,
                                       std::span<const std::uint32_t> cells, int threads)
    : edit_(edit), areas_(areas) {
    assert(std::is_sorted(cells.begin(), cells.end()));
    kept_.errors = areas.errors_of(cells, threads);
    add_up(kept_);
}

void CrossSectionErrors::add_others(std::span<const std::uint32_t> cells, int threads) {
    const std::vector<std::uint32_t> all = edit_.mesh.alive_cells();
    std::vector<std::uint32_t> others;
    std::set_difference(all.begin(), all.end(), cells.begin(), cells.end(), std::back_inserter(others));
    kept_.errors = merged(kept_.errors, areas_.errors_of(others, threads));
    add_up(kept_);
    assert(is_up_to_date(kept_));
}

std::span<const double> CrossSectionErrors::sums_after(std::span<const std::uint32_t> changed) {
    assert(std::is_sorted(changed.begin(), changed.end()));
    std::vector<std::uint32_t> alive;
    std::copy_if(changed.begin(), changed.end(), std::back_inserter(alive),
                 [&](std::uint32_t c) { return edit_.mesh.alive(c); });
    CellErrors same;
    std::copy_if(kept_.errors.begin(), kept_.errors.end(), std::back_inserter(same), [&](const auto& error) {
        return !std::binary_search(changed.begin(), changed.end(), error.cell);
    });
    after_.errors = merged(same, areas_.errors_of(alive));
    add_up(after_);
    assert(is_up_to_date(after_));
    return after_.sums;
}

CrossSectionErrors::CellErrors CrossSectionErrors::merged(const CellErrors& some, const CellErrors& others) {
    CellErrors all;
    all.reserve(some.size() + others.size());
    std::merge(some.begin(), some.end(), others.begin(), others.end(), std::back_inserter(all),
               [](const auto& one, const auto& other) { return one.cell < other.cell; });
    return all;
}

void CrossSectionErrors::add_up(Table& table) const {
    table.sums.assign(areas_.sums().size(), 0);
    for (const SectionAreas::CrossSectionError& error : table.errors)
        table.sums[error.cross_section] += error.share;
}

bool CrossSectionErrors::is_up_to_date(const Table& table) const {
    return table.errors == areas_.errors_of(edit_.mesh.alive_cells());
}

}  // namespace anatomesh
