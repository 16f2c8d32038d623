#include "anatomesh/improve/sections/section_areas.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/plane_sections.h"
#include "anatomesh/mesh/model/prefetch.h"

namespace anatomesh {

namespace {

constexpr double rounding = 1 + 1e-9;  // of a distance, upwards [1; > 1; D]
// Share of what is drawn, that a section counts from. [1; 0 to 0.001; M 2026-11 random solids]
constexpr double least_share = 1e-6;
constexpr std::size_t cells_a_piece = 8192;  // that one thread looks at one after the other [cells; > 0; B]

// Whether a level (ParallelPlanes) is that of a plane, not of what is between two.
constexpr bool is_in_plane(std::uint32_t level) {
    return level % 2 == 1;
}

}  // namespace

SectionAreas::SectionAreas(EditContext& edit, const DrawnSlices& drawn)
    : edit_(edit), drawn_(drawn), of_cuts_(drawn.weights.size(), 0) {
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
    return stack_->level(edit_.mesh.point(v), drawn_.on_plane_mm);
}

std::vector<std::uint32_t> SectionAreas::levels_of_all(int threads) const {
    std::vector<std::uint32_t> levels(edit_.mesh.point_count());
    parallel_for(levels.size(), cells_a_piece, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t v = first; v < last; ++v) levels[v] = level(static_cast<std::uint32_t>(v));
    });
    return levels;
}

SectionAreas::Reach SectionAreas::reach_of(std::span<const std::uint32_t> vertices) const {
    Reach reach{edit_.mesh.point(vertices[0])};
    for (const std::uint32_t v : vertices) {
        reach.radius = std::max(reach.radius, length(edit_.mesh.point(v) - reach.from));
        reach.any_drawn = reach.any_drawn || slice_of(v) != no_slice;
    }
    // Rounding apart.
    reach.radius = rounding * reach.radius + 2 * drawn_.on_plane_mm;
    return reach;
}

int SectionAreas::side(std::uint32_t v, std::uint32_t k) const {
    if (stack_) {
        if (slice_of(v) == no_slice) {
            const double height =
                stack_->frame.signed_distance(edit_.mesh.point(v)) - stack_->heights[rank_[k]];
            if (std::abs(height) > drawn_.on_plane_mm) return height > 0 ? 1 : -1;
        }
        // Planes may be so near that a vertex is within the tolerance of two: it lies in that of its level.
        const std::uint32_t at = level(v), plane = 2 * rank_[k] + 1;
        return (at > plane) - (at < plane);
    }
    if (slice_of(v) == k) return 0;
    const double height = plane(k).signed_distance(edit_.mesh.point(v));
    return std::abs(height) <= drawn_.on_plane_mm ? 0 : height > 0 ? 1 : -1;
}

bool SectionAreas::passes_between(std::span<const std::uint32_t> vertices) const {
    if (stack_) {
        const LevelRange range = levels_of(vertices);
        const std::uint32_t plane_over_lowest = (range.low + 1) / 2 * 2 + 1;
        return plane_over_lowest < range.high;
    }
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
    if (stack_) {
        const LevelRange range = levels_of(vertices);
        return range.low == range.high && is_in_plane(range.low) ? order_[range.low / 2] : no_slice;
    }
    std::uint32_t found = no_slice;
    any_plane_at(vertices, [&](std::uint32_t k) {
        if (!std::all_of(vertices.begin(), vertices.end(), [&](auto v) { return side(v, k) == 0; }))
            return false;
        found = k;
        return true;
    });
    return found;
}

template <class Visit>
void SectionAreas::for_each_wrong(const Part& part, InterfaceProbe& probe, const Visit& visit) const {
    if (!speaks_of(part.plane, part.piece.middle)) return;
    const std::vector<std::uint32_t>&here = drawn_.table->members[part.here],
          &there = drawn_.table->members[part.there], &seen = probe.members(part.piece.middle);
    if (part.here == part.there && here == seen) return;
    std::vector<std::uint32_t> both;
    std::set_union(here.begin(), here.end(), there.begin(), there.end(), std::back_inserter(both));
    const auto visit_those_missing = [&](const std::vector<std::uint32_t>& from,
                                         const std::vector<std::uint32_t>& in) {
        for (const std::uint32_t s : from) {
            if (std::binary_search(in.begin(), in.end(), s)) continue;
            const std::size_t cross_section = s * drawn_.planes.size() + part.plane;
            visit(static_cast<std::uint32_t>(cross_section), part.piece.area * drawn_.weights[cross_section]);
        }
    };
    visit_those_missing(both, seen);
    visit_those_missing(seen, both);
}

double SectionAreas::wrong_part(const Part& part) {
    if (only_ != no_slice && part.plane != only_) return 0;
    double sum = 0;
    for_each_wrong(part, edit_.probe, [&](std::uint32_t cross_section, double share) {
        sum += share;
        if (drawn_.weights[cross_section] > 0) largest_ = std::max(largest_, of_cuts_[cross_section]);
    });
    return sum;
}

SectionAreas::CellLevels SectionAreas::levels_at(std::uint32_t c) const {
    const Cell& cell = edit_.mesh.cell(c);
    return {level(cell[0]), level(cell[1]), level(cell[2]), level(cell[3])};
}

template <class Visit>
void SectionAreas::for_each_section(std::uint32_t c, const CellLevels& levels, const Visit& visit) const {
    const Region region = edit_.mesh.region(c);
    const auto visit_if_any = [&](const Piece& piece, std::uint32_t k) {
        if (piece.area > 0) visit(Part{piece, k, region, region});
    };
    if (!stack_) {
        any_plane_at(edit_.mesh.cell(c), [&](std::uint32_t k) {
            visit_if_any(section(c, k), k);
            return false;
        });
        return;
    }
    const auto [low, high] = std::minmax_element(levels.begin(), levels.end());
    for (std::uint32_t n = *low / 2; 2 * n + 1 <= *high; ++n) {
        const auto is_in = [&](std::size_t i) { return levels[i] == 2 * n + 1; };
        visit_if_any(section(c, order_[n], is_in), order_[n]);
    }
}

double SectionAreas::wrong_sections(std::uint32_t c) {
    double sum = 0;
    const auto add = [&](const Part& part) { sum += wrong_part(part); };
    if (only_ == no_slice) {
        for_each_section(c, stack_ ? levels_at(c) : CellLevels{}, add);
    } else if (const Piece piece = section(c, only_); piece.area > 0) {
        add({piece, only_, edit_.mesh.region(c), edit_.mesh.region(c)});
    }
    return sum;
}

template <class IsIn>
SectionAreas::Piece SectionAreas::section(std::uint32_t c, std::uint32_t k, const IsIn& is_in) const {
    const Cell& cell = edit_.mesh.cell(c);
    std::array<Vec3, 4> corners;
    std::array<double, 4> heights{};
    for (std::size_t i = 0; i < 4; ++i) {
        corners[i] = edit_.mesh.point(cell[i]);
        if (!is_in(i)) heights[i] = plane(k).signed_distance(corners[i]);
    }
    const PlaneSection section = section_at(corners, heights);
    if (section.facet != PlaneSection::no_facet) return {};
    return {section.area, section.middle};
}

SectionAreas::Piece SectionAreas::section(std::uint32_t c, std::uint32_t k) const {
    const Cell& cell = edit_.mesh.cell(c);
    return section(c, k, [&](std::size_t i) { return side(cell[i], k) == 0; });
}

SectionAreas::Piece SectionAreas::facet_in(std::uint32_t k, std::uint32_t c, int i) const {
    const Cell& cell = edit_.mesh.cell(c);
    const auto& f = facet_vertices[i];
    if (edit_.mesh.neighbor(c, i) == no_cell) return {};
    for (const int n : f) {
        if (side(cell[n], k) != 0) return {};
    }
    const Vec3 p = edit_.mesh.point(cell[f[0]]), q = edit_.mesh.point(cell[f[1]]),
               r = edit_.mesh.point(cell[f[2]]);
    return {triangle_area(p, q, r), (1.0 / 3) * (p + q + r)};
}

bool SectionAreas::reaches(std::uint32_t c, std::uint32_t k) const {
    const Cell& cell = edit_.mesh.cell(c);
    const int first = side(cell[0], k);
    return first == 0 ||
           std::any_of(cell.begin() + 1, cell.end(), [&](std::uint32_t v) { return side(v, k) != first; });
}

std::vector<SectionAreas::Section> SectionAreas::wrong_sections_of(std::uint32_t structure, std::uint32_t k,
                                                                   std::span<const std::uint32_t> cells,
                                                                   int threads) const {
    return parallel_collect<Section>(cells.size(), cells_a_piece, threads,
                                     [&](std::size_t first, std::size_t last, std::vector<Section>& found) {
                                         find_wrong_sections(structure, k, cells.subspan(first, last - first),
                                                             found);
                                     });
}

void SectionAreas::find_wrong_sections(std::uint32_t structure, std::uint32_t k,
                                       std::span<const std::uint32_t> cells,
                                       std::vector<Section>& found) const {
    InterfaceProbe probe = edit_.probe;
    const double weight = drawn_.weights[structure * drawn_.planes.size() + k];
    const auto look = [&](const Piece& piece, std::uint32_t here, std::uint32_t there, int facet) {
        if (!(piece.area * weight > least_share) || !speaks_of(k, piece.middle)) return;
        const bool has = drawn_.table->contains(edit_.mesh.region(here), structure) ||
                         drawn_.table->contains(edit_.mesh.region(there), structure);
        const std::vector<std::uint32_t>& seen = probe.members(piece.middle);
        if (std::binary_search(seen.begin(), seen.end(), structure) != has)
            found.push_back({here, facet, piece.area * weight, piece.middle});
    };
    for (std::size_t n = 0; n < cells.size(); ++n) {
        if (n + cells_ahead < cells.size()) edit_.mesh.prefetch_points(cells[n + cells_ahead]);
        const std::uint32_t c = cells[n];
        if (!reaches(c, k)) continue;
        look(section(c, k), c, c, 4);
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t other = edit_.mesh.neighbor(c, i);
            if (c < other && other != no_cell) look(facet_in(k, c, i), c, other, i);
        }
    }
}

double SectionAreas::wrong_facet(Vec3 a, Vec3 b, Vec3 c, std::uint32_t k, Region here, Region there) {
    return wrong_part({{triangle_area(a, b, c), (1.0 / 3) * (a + b + c)}, k, here, there});
}

std::optional<SectionAreas::Part> SectionAreas::facet_part(std::uint32_t c, int i) const {
    const Cell& cell = edit_.mesh.cell(c);
    const auto& f = facet_vertices[i];
    const std::uint32_t other = edit_.mesh.neighbor(c, i);
    if (other == no_cell) return std::nullopt;
    const std::uint32_t k = plane_of(std::array{cell[f[0]], cell[f[1]], cell[f[2]]});
    if (k == no_slice) return std::nullopt;
    const Vec3 p = edit_.mesh.point(cell[f[0]]), q = edit_.mesh.point(cell[f[1]]),
               r = edit_.mesh.point(cell[f[2]]);
    return Part{
        {triangle_area(p, q, r), (1.0 / 3) * (p + q + r)}, k, edit_.mesh.region(c), edit_.mesh.region(other)};
}

double SectionAreas::wrong_in_plane(std::uint32_t c, int i) {
    const std::optional<Part> part = facet_part(c, i);
    return part ? wrong_part(*part) : 0;
}

double SectionAreas::wrong(std::span<const std::uint32_t> cells) {
    double sum = 0;
    for (const std::uint32_t c : cells) {
        sum += wrong_sections(c);
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t other = edit_.mesh.neighbor(c, i);
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
            if (edit_.mesh.cell(c)[i] != v) sum += 0.5 * wrong_in_plane(c, i);
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

std::vector<SectionAreas::CrossSectionError> SectionAreas::errors_of(std::span<const std::uint32_t> cells,
                                                                     int threads) const {
    // Most vertices are those of many cells: where these are many, their levels are found beforehand.
    std::vector<std::uint32_t> levels;
    if (stack_ && cells.size() > edit_.mesh.point_count()) levels = levels_of_all(threads);
    return parallel_collect<CrossSectionError>(
        cells.size(), cells_a_piece, threads,
        [&](std::size_t first, std::size_t last, std::vector<CrossSectionError>& errors) {
            find_errors(cells.subspan(first, last - first), levels, errors);
        });
}

void SectionAreas::find_errors(std::span<const std::uint32_t> cells, std::span<const std::uint32_t> levels,
                               std::vector<CrossSectionError>& errors) const {
    InterfaceProbe probe = edit_.probe;
    for (std::size_t n = 0; n < cells.size(); ++n) {
        if (n + cells_ahead < cells.size()) edit_.mesh.prefetch_points(cells[n + cells_ahead]);
        const std::uint32_t c = cells[n];
        const auto add = [&](const Part& part, double share_of_cell) {
            for_each_wrong(part, probe, [&](std::uint32_t cross_section, double share) {
                if (share != 0) errors.push_back({c, cross_section, share_of_cell * share});
            });
        };
        // In a stack the level of each vertex is found once, for the sections and for the facets.
        CellLevels at{};
        if (!levels.empty()) {
            const Cell& cell = edit_.mesh.cell(c);
            at = {levels[cell[0]], levels[cell[1]], levels[cell[2]], levels[cell[3]]};
        } else if (stack_) {
            at = levels_at(c);
        }
        for_each_section(c, at, [&](const Part& part) { add(part, 1); });
        for (int i = 0; i < 4; ++i) {
            const auto [a, b, d] = facet_vertices[i];
            const bool lies_in_plane = is_in_plane(at[a]) && at[a] == at[b] && at[a] == at[d];
            if (stack_ && !lies_in_plane) continue;
            if (const std::optional<Part> part = facet_part(c, i)) add(*part, 0.5);
        }
    }
}

void SectionAreas::sum_cuts(std::span<const std::uint32_t> cells, int threads) {
    std::fill(of_cuts_.begin(), of_cuts_.end(), 0);
    for (const CrossSectionError& error : errors_of(cells, threads))
        of_cuts_[error.cross_section] += error.share;
}

std::vector<std::uint32_t> SectionAreas::cells_round(std::span<const std::uint32_t> cells) const {
    std::vector<std::uint32_t> vertices, round;
    for (const std::uint32_t c : cells)
        vertices.insert(vertices.end(), edit_.mesh.cell(c).begin(), edit_.mesh.cell(c).end());
    sort_distinct(vertices, edit_.mesh.point_count());
    for (const std::uint32_t v : vertices) {
        edit_.mesh.star(v, edit_.star);
        round.insert(round.end(), edit_.star.begin(), edit_.star.end());
    }
    sort_distinct(round, edit_.mesh.cell_count());
    return round;
}

void SectionAreas::sum_cuts_round(std::span<const std::uint32_t> cells, int threads) {
    sum_cuts(cells_round(cells), threads);
}

double SectionAreas::largest_cut_at(std::uint32_t c, int i) {
    largest_ = 0;
    wrong_at(c, i);
    return largest_;
}

double SectionAreas::wrong_at(std::uint32_t c, int i) {
    return wrong_sections(c) + wrong_sections(edit_.mesh.neighbor(c, i)) + wrong_in_plane(c, i);
}

}  // namespace anatomesh
