#include "anatomesh/cut/drawn_cuts.h"

#include <algorithm>
#include <iterator>

namespace anatomesh {

namespace {

double area(Vec3 a, Vec3 b, Vec3 c) {
    return 0.5 * length(cross(b - a, c - a));
}

template <class Weight>
double sum_in_one(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b, const Weight& weight) {
    double sum = 0;
    for (const std::uint32_t s : a) sum += std::binary_search(b.begin(), b.end(), s) ? 0 : weight(s);
    for (const std::uint32_t s : b) sum += std::binary_search(a.begin(), a.end(), s) ? 0 : weight(s);
    return sum;
}

}  // namespace

DrawnCuts::DrawnCuts(const std::vector<Vec3>& points, const std::vector<Cell>& cells,
                     const std::vector<CellNeighbors>& neighbors, const std::vector<Region>& regions,
                     const RegionTable& table, const SlicePlanes& slices)
    : points_(points),
      cells_(cells),
      neighbors_(neighbors),
      regions_(regions),
      table_(table),
      slices_(slices),
      probe_(*slices.field, slices.structures) {}

void DrawnCuts::find_parts(std::uint32_t c) {
    parts_.clear();
    slices_.cross() ? look_up_parts(c) : find_parts_of_stack(c);
}

void DrawnCuts::find_parts_of_stack(std::uint32_t c) {
    const Cell& cell = cells_[c];
    for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t slice = slice_of(cell[i]);
        if (slice == SlicePlanes::no_slice) continue;
        std::size_t on = 0;
        bool first = true;
        for (std::size_t j = 0; j < 4; ++j) {
            const bool same = slice_of(cell[j]) == slice;
            on += same;
            first = first && !(same && j < i);
        }
        if (!first) continue;
        if (on < 3) add_section(cell, slice);
        if (on != 3) continue;
        const std::size_t apex = static_cast<std::size_t>(
            std::find_if(cell.begin(), cell.end(), [&](std::uint32_t v) { return slice_of(v) != slice; }) -
            cell.begin());
        const auto& f = facet_vertices[apex];
        const Vec3 p = points_[cell[f[0]]], q = points_[cell[f[1]]], r = points_[cell[f[2]]];
        parts_.push_back({area(p, q, r), (1.0 / 3) * (p + q + r), neighbors_[c][apex]});
    }
}

void DrawnCuts::look_up_parts(std::uint32_t c) {
    const auto [place, is_new] = known_.try_emplace(c);
    Range& known = place->second;
    if (!is_new) {
        const auto first = known_parts_.begin() + known.first;
        parts_.assign(first, first + known.count);
        return;
    }
    const Cell& cell = cells_[c];
    for_each_section({points_[cell[0]], points_[cell[1]], points_[cell[2]], points_[cell[3]]}, slices_.crossing,
                     [&](std::uint32_t k, const PlaneSection& section) {
                         const bool is_facet = section.facet != PlaneSection::no_facet;
                         const std::uint32_t beyond =
                             is_facet ? neighbors_[c][static_cast<std::size_t>(section.facet)] : no_cell;
                         if (is_facet && beyond == no_cell) return;  // there the mesh ends
                         const std::vector<std::uint32_t>& drawn = probe_.members(section.middle);
                         parts_.push_back({section.area, section.middle, beyond, k,
                                           static_cast<std::uint32_t>(known_drawn_.size()),
                                           static_cast<std::uint32_t>(drawn.size())});
                         known_drawn_.insert(known_drawn_.end(), drawn.begin(), drawn.end());
                     });
    known = {static_cast<std::uint32_t>(known_parts_.size()), static_cast<std::uint32_t>(parts_.size())};
    known_parts_.insert(known_parts_.end(), parts_.begin(), parts_.end());
}

std::span<const std::uint32_t> DrawnCuts::drawn_at(const Part& part) {
    if (slices_.cross()) return {known_drawn_.data() + part.first_drawn, part.drawn_count};
    return probe_.members(part.middle);
}

// The section of a cell with one or two vertices in the plane is a triangle.
void DrawnCuts::add_section(const Cell& cell, std::uint32_t slice) {
    const Plane& plane = slices_.planes[slice];
    std::array<Vec3, 4> corners;
    std::array<double, 4> height{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        if (slice_of(cell[i]) == slice) {
            corners[count++] = points_[cell[i]];
        } else {
            height[i] = plane.signed_distance(points_[cell[i]]);
        }
    }
    for (const auto& [i, j] : cell_edges) {
        if (!(height[i] * height[j] < 0) || count == 4) continue;
        corners[count++] =
            points_[cell[i]] + height[i] / (height[i] - height[j]) * (points_[cell[j]] - points_[cell[i]]);
    }
    if (count != 3) return;
    parts_.push_back({area(corners[0], corners[1], corners[2]),
                      (1.0 / 3) * (corners[0] + corners[1] + corners[2]), no_cell});
}

// How many structures are drawn there and in neither region, or in one of these and not drawn.
double DrawnCuts::wrong_share(Region one, Region other, std::span<const std::uint32_t> drawn,
                              std::uint32_t slice) {
    const auto weight = [&](std::uint32_t s) { return weight_of(s, slice); };
    if (one == other) return sum_in_one(table_.members[one], drawn, weight);
    both_.clear();
    std::set_union(table_.members[one].begin(), table_.members[one].end(), table_.members[other].begin(),
                   table_.members[other].end(), std::back_inserter(both_));
    return sum_in_one(both_, drawn, weight);
}

double DrawnCuts::change(std::span<const std::uint32_t> moved, Region to) {
    double sum = 0;
    for (const std::uint32_t c : moved) {
        find_parts(c);
        for (const Part& part : parts_) {
            const std::span<const std::uint32_t> drawn = drawn_at(part);
            const std::uint32_t k = part.slice;
            if (part.beyond == no_cell) {
                sum +=
                    part.area * (wrong_share(to, to, drawn, k) - wrong_share(regions_[c], regions_[c], drawn, k));
                continue;
            }
            const bool both = std::find(moved.begin(), moved.end(), part.beyond) != moved.end();
            const Region beyond = regions_[part.beyond];
            sum += (both ? 0.5 : 1) * part.area *
                   (wrong_share(to, both ? to : beyond, drawn, k) - wrong_share(regions_[c], beyond, drawn, k));
        }
    }
    return sum;
}

bool DrawnCuts::protrudes(std::span<const std::uint32_t> cells) {
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

bool DrawnCuts::lies_beside(std::uint32_t c, std::uint32_t vertex, bool above) const {
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

const std::vector<std::uint32_t>* DrawnCuts::wanted(std::uint32_t c) {
    find_parts(c);
    double most = 0;
    for (const Part& part : parts_) {
        if (part.area <= most) continue;
        const std::span<const std::uint32_t> drawn = drawn_at(part);
        const auto is_drawn = [&](Region region) { return std::ranges::equal(table_.members[region], drawn); };
        if (is_drawn(regions_[c]) || (part.beyond != no_cell && is_drawn(regions_[part.beyond]))) continue;
        most = part.area;
        drawn_.assign(drawn.begin(), drawn.end());
    }
    return most > 0 ? &drawn_ : nullptr;
}

}  // namespace anatomesh
