#include "anatomesh/improve/sections/section_areas.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/plane_sections.h"

namespace anatomesh {

namespace {

constexpr double rounding = 1 + 1e-9;
constexpr double least_share = 1e-6;  // of what is drawn, that a section counts from

}  // namespace

SectionAreas::SectionAreas(Workbench& bench, const DrawnSlices& drawn)
    : bench_(bench), drawn_(drawn), of_cuts_(drawn.weights.size(), 0) {
    if (!drawn.extents.empty()) return;
    const Vec3 axis = drawn.planes.front().normal;
    stack_.emplace().frame.normal = axis;
    order_.resize(drawn.planes.size());
    rank_.resize(drawn.planes.size());
    std::iota(order_.begin(), order_.end(), 0u);
    const auto at = [&](std::uint32_t k) { return dot(drawn.planes[k].origin, axis); };
    std::sort(order_.begin(), order_.end(), [&](std::uint32_t j, std::uint32_t k) { return at(j) < at(k); });
    for (std::uint32_t n = 0; n < order_.size(); ++n) {
        stack_->heights.push_back(at(order_[n]));
        rank_[order_[n]] = n;
    }
}

std::uint32_t SectionAreas::level(std::uint32_t v) const {
    if (slice_of(v) != no_slice) return 2 * rank_[slice_of(v)] + 1;
    return stack_->level(bench_.mesh.point(v), drawn_.on_plane_mm);
}

SectionAreas::Reach SectionAreas::reach_of(std::span<const std::uint32_t> vertices) const {
    Reach reach{bench_.mesh.point(vertices[0])};
    for (const std::uint32_t v : vertices) {
        reach.radius = std::max(reach.radius, length(bench_.mesh.point(v) - reach.from));
        reach.any_drawn = reach.any_drawn || slice_of(v) != no_slice;
    }
    // Rounding apart.
    reach.radius = rounding * reach.radius + 2 * drawn_.on_plane_mm;
    return reach;
}

int SectionAreas::side(std::uint32_t v, std::uint32_t k) const {
    if (stack_) {
        const std::uint32_t at = level(v), plane = 2 * rank_[k] + 1;
        return (at > plane) - (at < plane);
    }
    if (slice_of(v) == k) return 0;
    const double height = plane(k).signed_distance(bench_.mesh.point(v));
    return std::abs(height) <= drawn_.on_plane_mm ? 0 : height > 0 ? 1 : -1;
}

bool SectionAreas::passes_between(std::span<const std::uint32_t> vertices) const {
    return any_plane_at(vertices, [&](std::uint32_t k) {
        bool under = false, over = false;
        for (const std::uint32_t v : vertices) {
            const int at = side(v, k);
            under = under || at < 0;
            over = over || at > 0;
        }
        return under && over;
    });
}

std::uint32_t SectionAreas::plane_of(std::span<const std::uint32_t> vertices) const {
    std::uint32_t found = no_slice;
    any_plane_at(vertices, [&](std::uint32_t k) {
        if (!std::all_of(vertices.begin(), vertices.end(), [&](auto v) { return side(v, k) == 0; }))
            return false;
        found = k;
        return true;
    });
    return found;
}

// Structures that are in the regions and not drawn in the plane at p, or drawn there and in neither.
double SectionAreas::wrong_part(double area, Region here, Region there, std::uint32_t k, Vec3 p) {
    if (only_ != no_slice && k != only_) return 0;
    if (!speaks_of(k, p)) return 0;
    const std::vector<std::uint32_t>&one = drawn_.table->members[here], &other = drawn_.table->members[there],
          &seen = bench_.probe.members(p);
    both_.clear();
    std::set_union(one.begin(), one.end(), other.begin(), other.end(), std::back_inserter(both_));
    double sum = 0;
    const auto add = [&](const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
        for (const std::uint32_t s : a) {
            if (std::binary_search(b.begin(), b.end(), s)) continue;
            const std::size_t cut = s * drawn_.planes.size() + k;
            sum += area * drawn_.weights[cut];
            if (counts_) of_cuts_[cut] += share_ * area * drawn_.weights[cut];
            if (drawn_.weights[cut] > 0) largest_ = std::max(largest_, of_cuts_[cut]);
        }
    };
    add(both_, seen);
    add(seen, both_);
    return sum;
}

double SectionAreas::wrong_sections(std::uint32_t c) {
    double sum = 0;
    if (only_ != no_slice) return wrong_section(c, only_);
    any_plane_at(bench_.mesh.cell(c), [&](std::uint32_t k) {
        sum += wrong_section(c, k);
        return false;
    });
    return sum;
}

SectionAreas::Piece SectionAreas::section(std::uint32_t c, std::uint32_t k) const {
    const Cell& cell = bench_.mesh.cell(c);
    std::array<Vec3, 4> corners;
    std::array<double, 4> heights{};
    for (std::size_t i = 0; i < 4; ++i) {
        corners[i] = bench_.mesh.point(cell[i]);
        if (side(cell[i], k) != 0) heights[i] = plane(k).signed_distance(corners[i]);
    }
    const PlaneSection section = section_at(corners, heights);
    if (section.facet != PlaneSection::no_facet) return {};
    return {section.area, section.middle};
}

double SectionAreas::wrong_section(std::uint32_t c, std::uint32_t k) {
    const Piece piece = section(c, k);
    const Region region = bench_.mesh.region(c);
    return piece.area > 0 ? wrong_part(piece.area, region, region, k, piece.middle) : 0;
}

SectionAreas::Piece SectionAreas::facet_in(std::uint32_t k, std::uint32_t c, int i) const {
    const Cell& cell = bench_.mesh.cell(c);
    const auto& f = facet_vertices[i];
    if (bench_.mesh.neighbor(c, i) == no_cell) return {};
    for (const int n : f) {
        if (side(cell[n], k) != 0) return {};
    }
    const Vec3 p = bench_.mesh.point(cell[f[0]]), q = bench_.mesh.point(cell[f[1]]),
               r = bench_.mesh.point(cell[f[2]]);
    return {triangle_area(p, q, r), (1.0 / 3) * (p + q + r)};
}

std::vector<SectionAreas::Section> SectionAreas::wrong_sections_of(std::uint32_t structure, std::uint32_t k,
                                                                   std::span<const std::uint32_t> cells) {
    std::vector<Section> found;
    const double weight = drawn_.weights[structure * drawn_.planes.size() + k];
    const auto look = [&](const Piece& piece, std::uint32_t here, std::uint32_t there, int facet) {
        if (!(piece.area * weight > least_share) || !speaks_of(k, piece.middle)) return;
        const bool has = drawn_.table->contains(bench_.mesh.region(here), structure) ||
                         drawn_.table->contains(bench_.mesh.region(there), structure);
        const std::vector<std::uint32_t>& seen = bench_.probe.members(piece.middle);
        if (std::binary_search(seen.begin(), seen.end(), structure) != has)
            found.push_back({here, facet, piece.area * weight, piece.middle});
    };
    for (const std::uint32_t c : cells) {
        look(section(c, k), c, c, 4);
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t other = bench_.mesh.neighbor(c, i);
            if (c < other && other != no_cell) look(facet_in(k, c, i), c, other, i);
        }
    }
    return found;
}

double SectionAreas::wrong_facet(Vec3 a, Vec3 b, Vec3 c, std::uint32_t k, Region here, Region there) {
    return wrong_part(triangle_area(a, b, c), here, there, k, (1.0 / 3) * (a + b + c));
}

double SectionAreas::wrong_in_plane(std::uint32_t c, int i) {
    const Cell& cell = bench_.mesh.cell(c);
    const auto& f = facet_vertices[i];
    const std::uint32_t other = bench_.mesh.neighbor(c, i);
    if (other == no_cell) return 0;
    const std::array facet{cell[f[0]], cell[f[1]], cell[f[2]]};
    const std::uint32_t k = plane_of(facet);
    if (k == no_slice) return 0;
    return wrong_facet(bench_.mesh.point(facet[0]), bench_.mesh.point(facet[1]), bench_.mesh.point(facet[2]),
                       k, bench_.mesh.region(c), bench_.mesh.region(other));
}

double SectionAreas::wrong(std::span<const std::uint32_t> cells) {
    double sum = 0;
    for (const std::uint32_t c : cells) {
        sum += wrong_sections(c);
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t other = bench_.mesh.neighbor(c, i);
            const bool both = std::find(cells.begin(), cells.end(), other) != cells.end();
            sum += (both ? 0.5 : 1) * wrong_in_plane(c, i);
        }
    }
    return sum;
}

double SectionAreas::wrong_round(std::uint32_t v, std::span<const std::uint32_t> star) {
    double sum = 0;
    for (const std::uint32_t c : star) {
        sum += wrong_sections(c);
        for (int i = 0; i < 4; ++i) {
            if (bench_.mesh.cell(c)[i] != v) sum += 0.5 * wrong_in_plane(c, i);
        }
    }
    return sum;
}

double SectionAreas::wrong_round(std::uint32_t v, std::span<const std::uint32_t> star, std::uint32_t k) {
    only_ = k;
    const double sum = wrong_round(v, star);
    only_ = no_slice;
    return sum;
}

void SectionAreas::sum_cuts(std::span<const std::uint32_t> cells) {
    std::fill(of_cuts_.begin(), of_cuts_.end(), 0);
    counts_ = true;
    for (const std::uint32_t c : cells) {
        share_ = 1;
        wrong_sections(c);
        share_ = 0.5;  // seen from both sides
        for (int i = 0; i < 4; ++i) wrong_in_plane(c, i);
    }
    counts_ = false;
}

void SectionAreas::sum_cuts_round(std::span<const std::uint32_t> cells) {
    std::vector<std::uint32_t> vertices, round;
    for (const std::uint32_t c : cells)
        vertices.insert(vertices.end(), bench_.mesh.cell(c).begin(), bench_.mesh.cell(c).end());
    sort_distinct(vertices, bench_.mesh.point_count());
    for (const std::uint32_t v : vertices) {
        bench_.mesh.star(v, bench_.star);
        round.insert(round.end(), bench_.star.begin(), bench_.star.end());
    }
    sort_distinct(round, bench_.mesh.cell_count());
    sum_cuts(round);
}

double SectionAreas::largest_cut_at(std::uint32_t c, int i) {
    largest_ = 0;
    wrong_at(c, i);
    return largest_;
}

double SectionAreas::wrong_at(std::uint32_t c, int i) {
    return wrong_sections(c) + wrong_sections(bench_.mesh.neighbor(c, i)) + wrong_in_plane(c, i);
}

}  // namespace anatomesh
