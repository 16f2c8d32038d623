#include "anatomesh/cut/drawn_sections.h"

#include <algorithm>
#include <iterator>

namespace anatomesh {

namespace {

template <class Weight>
double sum_in_one(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b, const Weight& weight) {
    double sum = 0;
    for (const std::uint32_t s : a) sum += std::binary_search(b.begin(), b.end(), s) ? 0 : weight(s);
    for (const std::uint32_t s : b) sum += std::binary_search(a.begin(), a.end(), s) ? 0 : weight(s);
    return sum;
}

}  // namespace

DrawnSections::DrawnSections(const std::vector<Vec3>& points, const std::vector<Cell>& cells,
                             const std::vector<CellNeighbors>& neighbors, const std::vector<Region>& regions,
                             const RegionTable& table, const SlicePlanes& slices)
    : points_(points),
      cells_(cells),
      neighbors_(neighbors),
      regions_(regions),
      table_(table),
      slices_(slices),
      probe_(*slices.field, slices.structures) {}

void DrawnSections::find_parts(std::uint32_t c) {
    parts_.clear();
    slices_.cross() ? look_up_parts(c) : find_parts_of_stack(c);
}

void DrawnSections::find_parts_of_stack(std::uint32_t c) {
    const Cell& cell = cells_[c];
    for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t slice = slice_of(cell[i]);
        const auto is_in_slice = [&](std::uint32_t v) { return slice_of(v) == slice; };
        // Each slice once.
        if (slice == SlicePlanes::no_slice ||
            std::any_of(cell.begin(), cell.begin() + static_cast<std::ptrdiff_t>(i), is_in_slice))
            continue;
        std::array<Vec3, 4> corners;
        std::array<double, 4> heights{};
        for (std::size_t j = 0; j < 4; ++j) {
            corners[j] = points_[cell[j]];
            if (!is_in_slice(cell[j])) heights[j] = slices_.planes[slice].signed_distance(corners[j]);
        }
        // One with another vertex in the plane, by chance, tells nothing here.
        const auto in_plane = std::count(heights.begin(), heights.end(), 0.0);
        if (in_plane != std::count_if(cell.begin(), cell.end(), is_in_slice)) continue;
        const PlaneSection section = section_at(corners, heights);
        if (section.area > 0) parts_.push_back({section.area, section.middle, beyond(c, section)});
    }
}

// The cell on the other side of a facet in a plane.
std::uint32_t DrawnSections::beyond(std::uint32_t cell, const PlaneSection& section) const {
    return section.facet == PlaneSection::no_facet
               ? no_cell
               : neighbors_[cell][static_cast<std::size_t>(section.facet)];
}

void DrawnSections::look_up_parts(std::uint32_t c) {
    const auto [place, is_new] = known_.try_emplace(c);
    Range& known = place->second;
    if (!is_new) {
        const auto first = known_parts_.begin() + known.first;
        parts_.assign(first, first + known.count);
        return;
    }
    const Cell& cell = cells_[c];
    for_each_section({points_[cell[0]], points_[cell[1]], points_[cell[2]], points_[cell[3]]},
                     slices_.crossing, [&](std::uint32_t k, const PlaneSection& section) {
                         const std::vector<std::uint32_t>& drawn = probe_.members(section.middle);
                         parts_.push_back({section.area, section.middle, beyond(c, section), k,
                                           static_cast<std::uint32_t>(known_drawn_.size()),
                                           static_cast<std::uint32_t>(drawn.size())});
                         known_drawn_.insert(known_drawn_.end(), drawn.begin(), drawn.end());
                     });
    known = {static_cast<std::uint32_t>(known_parts_.size()), static_cast<std::uint32_t>(parts_.size())};
    known_parts_.insert(known_parts_.end(), parts_.begin(), parts_.end());
}

std::span<const std::uint32_t> DrawnSections::drawn_at(const Part& part) {
    if (slices_.cross()) return {known_drawn_.data() + part.first_drawn, part.drawn_count};
    return probe_.members(part.middle);
}

// How much structures count that are drawn there and in neither region, or in one of these and not drawn.
double DrawnSections::wrong_share(Region one, Region other, std::span<const std::uint32_t> drawn,
                                  std::uint32_t slice) {
    const auto weight = [&](std::uint32_t s) { return weight_of(s, slice); };
    if (one == other) return sum_in_one(table_.members[one], drawn, weight);
    both_.clear();
    std::set_union(table_.members[one].begin(), table_.members[one].end(), table_.members[other].begin(),
                   table_.members[other].end(), std::back_inserter(both_));
    return sum_in_one(both_, drawn, weight);
}

double DrawnSections::change(std::span<const std::uint32_t> moved, Region to) {
    double sum = 0;
    for (const std::uint32_t c : moved) {
        find_parts(c);
        for (const Part& part : parts_) {
            const std::span<const std::uint32_t> drawn = drawn_at(part);
            const std::uint32_t k = part.slice;
            if (part.beyond == no_cell) {
                sum += part.area *
                       (wrong_share(to, to, drawn, k) - wrong_share(regions_[c], regions_[c], drawn, k));
                continue;
            }
            const bool both = std::find(moved.begin(), moved.end(), part.beyond) != moved.end();
            const Region beyond = regions_[part.beyond];
            sum +=
                (both ? 0.5 : 1) * part.area *
                (wrong_share(to, both ? to : beyond, drawn, k) - wrong_share(regions_[c], beyond, drawn, k));
        }
    }
    return sum;
}

bool DrawnSections::protrudes(std::span<const std::uint32_t> cells) {
    for (const std::uint32_t c : cells) {
        find_parts(c);
        for (const Part& part : parts_) {
            const std::span<const std::uint32_t> drawn = drawn_at(part);
            const std::vector<std::uint32_t>& own = table_.members[regions_[c]];
            if (!std::includes(drawn.begin(), drawn.end(), own.begin(), own.end())) return true;
        }
    }
    return false;
}

bool DrawnSections::lies_beside(std::uint32_t c, std::uint32_t vertex, bool above) const {
    const std::uint32_t slice = slice_of(vertex);
    if (slice == SlicePlanes::no_slice) return true;
    std::size_t on = 0;
    for (const std::uint32_t v : cells_[c]) {
        if (slice_of(v) == slice) {
            ++on;
        } else if ((slices_.planes[slice].signed_distance(points_[v]) > 0) != above) {
            return false;
        }
    }
    return on < 3;
}

const std::vector<std::uint32_t>* DrawnSections::wanted(std::uint32_t c) {
    find_parts(c);
    double most = 0;
    for (const Part& part : parts_) {
        if (part.area <= most) continue;
        const std::span<const std::uint32_t> drawn = drawn_at(part);
        const auto is_drawn = [&](Region region) {
            return std::ranges::equal(table_.members[region], drawn);
        };
        if (is_drawn(regions_[c]) || (part.beyond != no_cell && is_drawn(regions_[part.beyond]))) continue;
        most = part.area;
        drawn_.assign(drawn.begin(), drawn.end());
    }
    return most > 0 ? &drawn_ : nullptr;
}

}  // namespace anatomesh
