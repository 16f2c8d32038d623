#include "anatomesh/refine/missing_segments.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// So many subsegments are looked at in one task. [subsegments; >= 1; B]
constexpr std::size_t subsegments_at_once = 256;

// The subsegments by their lower vertex.
struct SubsegmentTable {
    std::vector<std::uint32_t> start, other,
        slot;                          // slot: of each subsegment in `other`, the subsegment's higher vertex
    std::vector<std::uint8_t> is_end;  // most cells and edges have fewer than two vertices that are

    SubsegmentTable(std::size_t point_count, const std::vector<Subsegment>& subsegments)
        : start(point_count + 1, 0),
          other(subsegments.size()),
          slot(subsegments.size()),
          is_end(point_count, 0) {
        for (const Subsegment& subsegment : subsegments) ++start[std::min(subsegment.a, subsegment.b) + 1];
        for (std::size_t v = 0; v < point_count; ++v) start[v + 1] += start[v];
        std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
        for (std::size_t n = 0; n < subsegments.size(); ++n) {
            slot[n] = next[std::min(subsegments[n].a, subsegments[n].b)]++;
            other[slot[n]] = std::max(subsegments[n].a, subsegments[n].b);
            is_end[subsegments[n].a] = is_end[subsegments[n].b] = 1;
        }
    }

    // Calls body(cell, slot) for every edge of a cell that is a subsegment, and collects what it appends.
    template <class Body>
    std::vector<std::uint32_t> collect(const std::vector<Cell>& cells, int threads, const Body& body) const {
        return parallel_collect<std::uint32_t>(
            cells.size(), 32768, threads,
            [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& out) {
                for (std::size_t c = first; c < last; ++c) {
                    const Cell& cell = cells[c];
                    const std::array<std::uint8_t, 4> end{is_end[cell[0]], is_end[cell[1]], is_end[cell[2]],
                                                          is_end[cell[3]]};
                    if (end[0] + end[1] + end[2] + end[3] < 2) continue;
                    for (const auto& [i, j] : cell_edges) {
                        if ((end[i] & end[j]) == 0) continue;
                        const std::uint32_t a = std::min(cell[i], cell[j]), b = std::max(cell[i], cell[j]);
                        for (std::uint32_t s = start[a]; s < start[a + 1]; ++s) {
                            if (other[s] == b) body(c, s, out);
                        }
                    }
                }
            });
    }
};

// Two unit vectors across a direction and across each other.
std::array<Vec3, 2> across(Vec3 direction) {
    const Vec3 size{std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)};
    const Vec3 other = size.x <= size.y && size.x <= size.z ? Vec3{1, 0, 0}
                       : size.y <= size.z                   ? Vec3{0, 1, 0}
                                                            : Vec3{0, 0, 1};
    const Vec3 u = cross(direction, other), v = cross(direction, u);
    return {(1 / length(u)) * u, (1 / length(v)) * v};
}

std::array<std::uint32_t, 2> ends(const Subsegment& subsegment) {
    return {std::min(subsegment.a, subsegment.b), std::max(subsegment.a, subsegment.b)};
}

// Walks the star of a vertex, from one cell at it, in search of another vertex.
class StarWalk {
  public:
    explicit StarWalk(const DelaunaySnapshot& mesh) : mesh_(mesh) {}

    bool meets(std::uint32_t vertex, std::uint32_t first, std::uint32_t wanted) {
        bool met = false;
        visit(vertex, first, wanted, [&](std::uint32_t) {
            met = true;
            return false;
        });
        return met;
    }

    // Calls body(cell) for those that have both vertices, until it says false.
    template <class Body>
    void visit(std::uint32_t vertex, std::uint32_t first, std::uint32_t wanted, const Body& body) {
        cells_.assign(1, first);
        for (std::size_t n = 0; n < cells_.size(); ++n) {
            const Cell& cell = mesh_.cells[cells_[n]];
            if (std::find(cell.begin(), cell.end(), wanted) != cell.end() && !body(cells_[n])) return;
            for (std::size_t i = 0; i < 4; ++i) {
                const std::uint32_t across = mesh_.neighbors[cells_[n]][i];
                if (cell[i] == vertex || across == no_cell) continue;
                if (std::find(cells_.begin(), cells_.end(), across) == cells_.end()) cells_.push_back(across);
            }
        }
    }

  private:
    const DelaunaySnapshot& mesh_;
    std::vector<std::uint32_t> cells_;
};

// For each vertex one of the cells at it, or no_cell.
std::vector<std::uint32_t> cell_of_each(const DelaunaySnapshot& mesh, std::size_t point_count,
                                        const std::vector<std::uint32_t>& cells) {
    std::vector<std::uint32_t> cell_of(point_count, no_cell);
    for (const std::uint32_t c : cells) {
        for (const std::uint32_t v : mesh.cells[c]) cell_of[v] = c;
    }
    return cell_of;
}

}  // namespace

std::vector<std::uint32_t> missing_subsegments(const std::vector<Cell>& cells, std::size_t point_count,
                                               const std::vector<Subsegment>& subsegments, int threads) {
    const SubsegmentTable table(point_count, subsegments);
    const std::vector<std::uint32_t> found = table.collect(
        cells, threads,
        [](std::size_t, std::uint32_t s, std::vector<std::uint32_t>& out) { out.push_back(s); });
    std::vector<std::uint8_t> present(subsegments.size(), 0);
    for (const std::uint32_t s : found) present[s] = 1;
    std::vector<std::uint32_t> missing;
    for (std::uint32_t n = 0; n < subsegments.size(); ++n) {
        if (!present[table.slot[n]]) missing.push_back(n);
    }
    return missing;
}

std::vector<std::uint32_t> MissingSubsegments::find(const DelaunaySnapshot& mesh, std::size_t point_count,
                                                    const std::vector<Subsegment>& subsegments,
                                                    const std::vector<std::uint32_t>& look, int threads) {
    std::vector<std::uint32_t> missing;
    if (4 * look.size() > mesh.cells.size() ||
        !find_changed(mesh, point_count, subsegments, look, threads, missing)) {
        missing = missing_subsegments(mesh.cells, point_count, subsegments, threads);
    }
    missing_.clear();
    for (const std::uint32_t n : missing) missing_.push_back(ends(subsegments[n]));
    std::sort(missing_.begin(), missing_.end());
    for (const Subsegment& subsegment : subsegments) balls_ = std::max(balls_, subsegment.ball + 1);
    return missing;
}

bool MissingSubsegments::find_changed(const DelaunaySnapshot& mesh, std::size_t point_count,
                                      const std::vector<Subsegment>& subsegments,
                                      const std::vector<std::uint32_t>& look, int threads,
                                      std::vector<std::uint32_t>& missing) const {
    const std::vector<std::uint32_t> new_cell = cell_of_each(mesh, point_count, look);
    std::atomic<bool> can_tell = true;
    missing = parallel_collect<std::uint32_t>(
        subsegments.size(), subsegments_at_once, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& out) {
            StarWalk walk(mesh);
            for (std::size_t n = first; n < last; ++n) {
                const Subsegment& subsegment = subsegments[n];
                const bool at_a = new_cell[subsegment.a] != no_cell, at_b = new_cell[subsegment.b] != no_cell,
                           is_new = subsegment.ball >= balls_;
                bool is_missing = false;
                if ((at_a && at_b) || (is_new && (at_a || at_b))) {
                    // An edge that came or went had both ends in a cell that came.
                    is_missing = at_a ? !walk.meets(subsegment.a, new_cell[subsegment.a], subsegment.b)
                                      : !walk.meets(subsegment.b, new_cell[subsegment.b], subsegment.a);
                } else if (is_new) {
                    can_tell = false;  // between two vertices that were there before
                } else {
                    is_missing = std::binary_search(missing_.begin(), missing_.end(), ends(subsegment));
                }
                if (is_missing) out.push_back(static_cast<std::uint32_t>(n));
            }
        });
    return can_tell;
}

std::vector<SubsegmentSides> subsegment_sides(const std::vector<Cell>& cells,
                                              const std::vector<Region>& regions,
                                              const RegionTable& region_table, std::size_t point_count,
                                              const std::vector<Subsegment>& subsegments, int threads) {
    assert(subsegments.size() < 0x80000000u);
    const SubsegmentTable table(point_count, subsegments);
    std::vector<std::uint32_t> structure(subsegments.size());
    for (std::size_t n = 0; n < subsegments.size(); ++n) structure[table.slot[n]] = subsegments[n].structure;
    const std::vector<std::uint32_t> found =
        table.collect(cells, threads, [&](std::size_t c, std::uint32_t s, std::vector<std::uint32_t>& out) {
            out.push_back(2 * s + region_table.contains(regions[c], structure[s]));
        });
    std::vector<SubsegmentSides> by_slot(subsegments.size(), SubsegmentSides{0, 0}),
        sides(subsegments.size());
    for (const std::uint32_t entry : found) {
        SubsegmentSides& here = by_slot[entry / 2];
        if (entry % 2) {
            here.inside = 1;
        } else {
            here.outside = 1;
        }
    }
    for (std::size_t n = 0; n < subsegments.size(); ++n) sides[n] = by_slot[table.slot[n]];
    return sides;
}

std::vector<SubsegmentSides> SidesOfSubsegments::find(const DelaunaySnapshot& mesh,
                                                      const std::vector<Region>& regions,
                                                      const RegionTable& table, std::size_t point_count,
                                                      const std::vector<Subsegment>& subsegments,
                                                      const std::vector<std::uint32_t>& look, int threads) {
    std::vector<SubsegmentSides> sides(subsegments.size());
    if (4 * look.size() > mesh.cells.size() ||
        !find_changed(mesh, regions, table, point_count, subsegments, look, threads, sides)) {
        sides = subsegment_sides(mesh.cells, regions, table, point_count, subsegments, threads);
    }
    known_.clear();
    known_.reserve(subsegments.size());
    for (std::size_t n = 0; n < subsegments.size(); ++n)
        known_.push_back({subsegments[n].ball, subsegments[n].structure, sides[n]});
    // Subsegments that were split stand last, with balls of larger numbers.
    if (!std::is_sorted(known_.begin(), known_.end())) std::sort(known_.begin(), known_.end());
    return sides;
}

bool SidesOfSubsegments::find_changed(const DelaunaySnapshot& mesh, const std::vector<Region>& regions,
                                      const RegionTable& table, std::size_t point_count,
                                      const std::vector<Subsegment>& subsegments,
                                      const std::vector<std::uint32_t>& look, int threads,
                                      std::vector<SubsegmentSides>& sides) const {
    const std::vector<std::uint32_t> new_cell = cell_of_each(mesh, point_count, look);
    std::atomic<bool> can_tell = true;
    parallel_for(subsegments.size(), subsegments_at_once, threads, [&](std::size_t first, std::size_t last) {
        StarWalk walk(mesh);
        for (std::size_t n = first; n < last; ++n) {
            const Subsegment& subsegment = subsegments[n];
            const Known wanted{subsegment.ball, subsegment.structure, {}};
            const auto known = std::lower_bound(known_.begin(), known_.end(), wanted);
            const bool is_new = known == known_.end() || wanted < *known,
                       at_a = new_cell[subsegment.a] != no_cell, at_b = new_cell[subsegment.b] != no_cell;
            if (!is_new && !(at_a && at_b)) {
                sides[n] = known->sides;
                continue;
            }
            if (!at_a && !at_b) {
                can_tell = false;  // between two vertices that were there before
                return;
            }
            // A cell that came or went with the edge had both ends in a cell that came.
            const std::uint32_t end = at_a ? subsegment.a : subsegment.b,
                                other = at_a ? subsegment.b : subsegment.a;
            sides[n] = {0, 0};
            walk.visit(end, new_cell[end], other, [&](std::uint32_t c) {
                const bool inside = table.contains(regions[c], subsegment.structure);
                if (inside) sides[n].inside = 1;
                if (!inside) sides[n].outside = 1;
                return !(sides[n].inside && sides[n].outside);
            });
        }
    });
    return can_tell;
}

void find_side_points(const std::vector<Vec3>& points, const std::vector<Subsegment>& subsegments,
                      const std::vector<SubsegmentSides>& sides, const StructureField& field,
                      const PointGrid& all_points, const SidePointOptions& options, std::vector<Vec3>& found,
                      RunContext& context) {
    assert(sides.size() == subsegments.size());
    std::vector<std::uint32_t> covered;
    for (std::uint32_t n = 0; n < subsegments.size(); ++n) {
        if (sides[n].inside != sides[n].outside) covered.push_back(n);
    }
    std::vector<std::optional<Vec3>> chosen(covered.size());
    parallel_for(covered.size(), 16, context.threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            const Subsegment& subsegment = subsegments[covered[k]];
            const double wanted = sides[covered[k]].inside ? 1 : -1;
            const Vec3 a = points[subsegment.a], b = points[subsegment.b], middle = 0.5 * (a + b);
            const double span = length(b - a);
            const auto [u, v] = across(b - a);
            double best = 0;
            // Outside the subsegment's diametral ball it keeps the subsegment an edge.
            for (const double reach : {0.52, 0.36, 0.2}) {
                for (int d = 0; d < options.directions; ++d) {
                    const double angle = 2 * std::numbers::pi * d / options.directions;
                    const Vec3 p =
                        middle + (reach * span * std::cos(angle)) * u + (reach * span * std::sin(angle)) * v;
                    const double clearance = wanted * field.value(subsegment.structure, p);
                    if (clearance <= best || all_points.any_within(p, options.min_spacing * span)) continue;
                    best = clearance;
                    chosen[k] = p;
                }
                if (chosen[k]) break;
            }
        }
    });
    // Two structures' subsegments along one line may want the same point.
    for (const std::optional<Vec3>& p : chosen) {
        if (p && std::find(found.begin(), found.end(), *p) == found.end()) found.push_back(*p);
    }
}

}  // namespace anatomesh
