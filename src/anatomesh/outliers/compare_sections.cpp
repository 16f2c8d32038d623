#include "anatomesh/outliers/compare_sections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "anatomesh/field/slice/distance_raster.h"

namespace anatomesh {

namespace {

// The grid has so many cells along its longer side at most. [cells; >= 16; B]
constexpr double most_cells = 96;
// A section is so many cells wide, were it a square. [cells; >= 8; B]
constexpr double cells_across = 36;
// Parts are taken together where they are nearer than so many gaps between slices. [gaps; > 0; D a tube across the slices at 45 degrees moves by one]
constexpr double together_gaps = 1;
// Of the points that stand for a part or hole, so many tell where it lies. [1; 0.5 to 1; D a choice]
constexpr double most_samples = 0.5;
// A part or hole has gone on from one neighbour to the other where it lies so near the line between their middles, in
// radii of the circle of its area. [radii; > 0; D a choice]
constexpr double near_line_radii = 0.6;
// They go on aslant by no more. [mm across the slices per mm along them; > 0; D a choice: 45 degrees]
constexpr double most_slope = 1;
// The same where the section has one on the way, which tells more. [mm across the slices per mm along them; >= most_slope; D a choice]
constexpr double most_slope_between = 3;
// Parts and holes that go on into each other have areas that differ by no larger factor. [1; > 1; D a choice]
constexpr double most_alike = 2.5;

// What sections enclose is compared too, where it is as much of what they draw on all three within this factor: an outline
// that closes on one slice encloses much more with hardly another region. [1; > 1; M a skull's vault]
constexpr double alike_filled = 2;
// Neighbours hardly overlap where their difference is so much of their areas. [1; 0 to 1; D a choice]
constexpr double hardly_overlapping = 0.75;
// A motion explains how the neighbours differ where it leaves no more of their difference. [1; 0 to 1; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double explained_by_motion = 0.5;

enum Which : std::size_t { below_it, itself, above_it };
using Three = std::array<const Section*, 3>;

// The share of a cell that lies inside, by the distance of its middle.
double inside_share(double distance, double cell) {
    return std::clamp(0.5 - distance / cell, 0.0, 1.0);
}

struct Raster {
    PixelGrid grid;
    double cell = 0;

    std::size_t size() const { return static_cast<std::size_t>(grid.nx) * grid.ny; }
    Vec2 at(std::size_t n) const {
        return {grid.low.x + cell * static_cast<double>(n % grid.nx),
                grid.low.y + cell * static_cast<double>(n / grid.nx)};
    }
    // The cell of a point, which may lie outside by less than the margin.
    std::size_t place(Vec2 p) const {
        const auto index = [&](double x, double low, std::uint32_t count) {
            return static_cast<std::size_t>(
                std::clamp(std::round((x - low) / cell), 0.0, static_cast<double>(count - 1)));
        };
        return index(p.y, grid.low.y, grid.ny) * grid.nx + index(p.x, grid.low.x, grid.nx);
    }
};

Raster raster_over(const Box2& box, double cell) {
    const Box2 grown = box.grown(2 * cell);
    Raster raster;
    raster.cell = cell;
    raster.grid.low = grown.low;
    raster.grid.step = {cell, cell};
    raster.grid.nx = static_cast<std::uint32_t>((grown.high.x - grown.low.x) / cell) + 2;
    raster.grid.ny = static_cast<std::uint32_t>((grown.high.y - grown.low.y) / cell) + 2;
    return raster;
}

// Connected groups of cells within `reach` of a section: 0 for cells of none, else from 1 on.
std::vector<std::uint32_t> groups_of(const Raster& raster, const std::array<std::vector<double>, 3>& distance,
                                     double reach, std::uint32_t& count) {
    std::vector<std::uint32_t> group(raster.size(), 0);
    std::vector<std::size_t> open;
    count = 0;
    const auto is_near = [&](std::size_t n) {
        return distance[below_it][n] < reach || distance[itself][n] < reach || distance[above_it][n] < reach;
    };
    const std::size_t nx = raster.grid.nx, ny = raster.grid.ny;
    for (std::size_t start = 0; start < raster.size(); ++start) {
        if (group[start] != 0 || !is_near(start)) continue;
        group[start] = ++count;
        open.assign(1, start);
        while (!open.empty()) {
            const std::size_t n = open.back(), x = n % nx, y = n / nx;
            open.pop_back();
            for (std::size_t j = y > 0 ? y - 1 : 0; j <= std::min(y + 1, ny - 1); ++j) {
                for (std::size_t i = x > 0 ? x - 1 : 0; i <= std::min(x + 1, nx - 1); ++i) {
                    const std::size_t to = j * nx + i;
                    if (group[to] != 0 || !is_near(to)) continue;
                    group[to] = count;
                    open.push_back(to);
                }
            }
        }
    }
    return group;
}

// The loops of one group: those of each section.
struct Group {
    std::array<std::vector<const SectionLoop*>, 3> loops;
    Box2 box;

    double area(Which which) const {
        double sum = 0;
        for (const SectionLoop* loop : loops[which]) sum += loop->area;
        return sum;
    }
    Vec2 centre(Which which) const {
        Vec2 moment;
        for (const SectionLoop* loop : loops[which]) moment = moment + loop->area * loop->centre;
        return (1 / area(which)) * moment;
    }
    bool has_holes() const {
        return std::any_of(loops.begin(), loops.end(), [](const auto& of_one) {
            return std::any_of(of_one.begin(), of_one.end(),
                               [](const SectionLoop* l) { return l->is_hole(); });
        });
    }
    // Walls that are thin and move a little have nothing in common, though what they enclose has.
    Group filled() const {
        Group parts = *this;
        for (auto& of_one : parts.loops)
            std::erase_if(of_one, [](const SectionLoop* l) { return l->is_hole(); });
        return parts;
    }
    double perimeter(Which which) const {
        double sum = 0;
        for (const SectionLoop* loop : loops[which]) {
            for (std::size_t n = 0; n < loop->points.size(); ++n)
                sum += length(loop->points[(n + 1) % loop->points.size()] - loop->points[n]);
        }
        return sum;
    }
    std::vector<Edge2> edges(Which which, Vec2 moved_by) const {
        std::vector<Edge2> all;
        for (const SectionLoop* loop : loops[which]) append_edges(*loop, moved_by, all);
        return all;
    }
};

struct Areas {
    double excess = 0, deficit = 0, beside = 0;
    double wrong() const { return excess + deficit; }
};

// With each section of the group moved.
Areas areas_of(const Group& group, const std::array<Vec2, 3>& moved_by, double cell) {
    Box2 box;
    std::array<std::vector<Edge2>, 3> edges;
    for (const Which which : {below_it, itself, above_it}) {
        edges[which] = group.edges(which, moved_by[which]);
        for (const Edge2& edge : edges[which]) box.extend(edge.a);
    }
    const Raster raster = raster_over(box, cell);
    std::array<std::vector<double>, 3> distance;
    for (const Which which : {below_it, itself, above_it})
        distance[which] = distance_raster(edges[which], raster.grid);
    Areas areas;
    for (std::size_t n = 0; n < raster.size(); ++n) {
        const double a = distance[below_it][n], b = distance[itself][n], c = distance[above_it][n];
        areas.excess += inside_share(std::max(b, -std::min(a, c)), cell);
        areas.deficit += inside_share(std::max(std::max(a, c), -b), cell);
        areas.beside += inside_share(std::max(a, -c), cell) + inside_share(std::max(c, -a), cell);
    }
    const double of_cell = cell * cell;
    return {areas.excess * of_cell, areas.deficit * of_cell, areas.beside * of_cell};
}

// `of_all`: the area of all groups.
ShapeDifference shape_of(const Group& group, double t, double of_all, double cell) {
    ShapeDifference shape;
    const Vec2 low = group.centre(below_it), high = group.centre(above_it), own = group.centre(itself);
    const Vec2 line = (1 - t) * low + t * high;
    Areas areas = areas_of(group, {}, cell);
    bool are_moved = false;
    const std::array<Vec2, 3> onto_line{line - low, Vec2{}, line - high};
    if (length(high - low) > cell) {
        const Areas moved = areas_of(group, onto_line, cell);
        const double both = group.area(below_it) + group.area(above_it);
        // Neighbours that hardly overlap have nothing in common that the section could lack.
        const bool is_motion =
            areas.beside > hardly_overlapping * both && moved.beside < explained_by_motion * areas.beside;
        are_moved = is_motion || moved.wrong() < areas.wrong();
        if (are_moved) areas = moved;
    }
    const double area = group.area(itself), mean = 0.5 * (group.area(below_it) + group.area(above_it));
    const double of = std::max(area, mean);
    const double perimeter =
        0.5 * (group.perimeter(itself) + 0.5 * (group.perimeter(below_it) + group.perimeter(above_it)));
    shape.excess_mm2 = areas.excess;
    shape.deficit_mm2 = areas.deficit;
    shape.beside_mm2 = areas.beside;
    shape.wide_mm2 = of;
    shape.share = areas.wrong() / of;
    shape.share_of_all = areas.wrong() / of_all;
    shape.mean_mm = areas.wrong() / perimeter;
    shape.contour =
        (*std::max_element(group.loops[itself].begin(), group.loops[itself].end(),
                           [](const SectionLoop* a, const SectionLoop* b) { return a->area < b->area; }))
            ->contour;
    shape.shift_mm = length(own - line);
    shape.unshifted_share = shape.share;
    if (shape.share > 0 && shape.shift_mm > cell) {
        std::array<Vec2, 3> back = are_moved ? onto_line : std::array<Vec2, 3>{};
        back[itself] = line - own;
        shape.unshifted_share = areas_of(group, back, cell).wrong() / of;
    }
    return shape;
}

ShapeDifference worst_shape(const Three& three, double t, double of_all) {
    Box2 box;
    double area = 0, gap = std::min(three[itself]->height - three[below_it]->height,
                                    three[above_it]->height - three[itself]->height);
    for (const Section* section : three) {
        box.extend(section->box.low);
        box.extend(section->box.high);
        area += section->area / 3;
    }
    const double side = std::max(box.high.x - box.low.x, box.high.y - box.low.y);
    const double cell = std::max(side / most_cells, std::sqrt(area) / cells_across);
    const Raster raster = raster_over(box, cell);
    std::array<std::vector<double>, 3> distance;
    for (const Which which : {below_it, itself, above_it}) {
        std::vector<Edge2> edges;
        // What holes are in counts as one: a section twice as wide may lie all round its neighbours.
        for (const SectionLoop& loop : three[which]->loops) {
            if (!loop.is_hole()) append_edges(loop, {}, edges);
        }
        distance[which] = distance_raster(edges, raster.grid);
    }
    std::uint32_t count = 0;
    const std::vector<std::uint32_t> group_at =
        groups_of(raster, distance, std::max(0.5 * together_gaps * gap, 1.5 * cell), count);
    std::vector<Group> groups(count + 1);
    for (const Which which : {below_it, itself, above_it}) {
        for (const SectionLoop& loop : three[which]->loops) {
            Group& group = groups[group_at[raster.place(loop.points.front())]];
            group.loops[which].push_back(&loop);
            group.box.extend(loop.box.low);
            group.box.extend(loop.box.high);
        }
    }
    ShapeDifference worst;
    for (std::uint32_t g = 1; g <= count; ++g) {
        const Group& group = groups[g];
        if (!(group.area(below_it) > 0) || !(group.area(itself) > 0) || !(group.area(above_it) > 0)) continue;
        const double own_side =
            std::max(group.box.high.x - group.box.low.x, group.box.high.y - group.box.low.y);
        const double mean = (group.area(below_it) + group.area(itself) + group.area(above_it)) / 3;
        const double own_cell = std::max(own_side / most_cells, std::sqrt(mean) / cells_across);
        const ShapeDifference shape = shape_of(group, t, of_all, own_cell);
        if (shape.share > worst.share) worst = shape;
        if (!group.has_holes()) continue;
        const Group parts = group.filled();
        const auto filled_share = [&](Which which) { return parts.area(which) / group.area(which); };
        const double own = filled_share(itself), low = filled_share(below_it), high = filled_share(above_it);
        if (std::max({own, low, high}) > alike_filled * std::min({own, low, high})) continue;
        const ShapeDifference filled = shape_of(parts, t, of_all, own_cell);
        if (filled.share > worst.share) worst = filled;
    }
    return worst;
}

template <class Is>
double share_of(const std::vector<Vec2>& samples, const Is& is) {
    if (samples.empty()) return 0;
    return static_cast<double>(std::count_if(samples.begin(), samples.end(), is)) /
           static_cast<double>(samples.size());
}

bool are_alike(const SectionLoop& a, const SectionLoop& b) {
    const double ratio = a.area / b.area;
    return ratio <= most_alike && ratio >= 1 / most_alike;
}

// Whether the loop lies on the way of one such of a neighbour to one of the other.
bool lies_between(const SectionLoop& loop, const Section& below, const Section& above, double t) {
    const double most = near_line_radii * circle_radius(loop.area);
    const double reach = most_slope_between * (above.height - below.height) + most;
    for (const SectionLoop& low : below.loops) {
        if (low.is_hole() != loop.is_hole() || !are_alike(low, loop) ||
            length(low.centre - loop.centre) > reach)
            continue;
        for (const SectionLoop& high : above.loops) {
            if (high.is_hole() != loop.is_hole() || !are_alike(high, loop)) continue;
            if (length((1 - t) * low.centre + t * high.centre - loop.centre) <= most) return true;
        }
    }
    return false;
}

// Holes that both neighbours fill, and parts that neither has.
void add_what_is_alone(const Three& three, double t, double of, std::vector<TopologyDifference>& found) {
    const Section &below = *three[below_it], &above = *three[above_it];
    for (const SectionLoop& loop : three[itself]->loops) {
        const std::vector<Vec2> samples = samples_of(loop);
        const bool wanted = loop.is_hole();
        const double share = share_of(
            samples, [&](Vec2 p) { return is_inside(below, p) == wanted && is_inside(above, p) == wanted; });
        if (share < (wanted ? most_samples : 1) || lies_between(loop, below, above, t)) continue;
        TopologyDifference difference;
        difference.kind = wanted ? TopologyDifferenceKind::hole_alone : TopologyDifferenceKind::part_alone;
        difference.contour = loop.contour;
        difference.area_mm2 = std::abs(loop.area);
        difference.share = difference.area_mm2 / of;
        double reach = length(below.box.high - below.box.low) + length(above.box.high - above.box.low) +
                       length(loop.box.high - loop.box.low) + length(loop.centre - below.box.low);
        for (const Vec2 p : samples) reach = std::min(reach, distance_to(below, p, reach));
        for (const Vec2 p : samples) reach = std::min(reach, distance_to(above, p, reach));
        difference.reach_mm = reach;
        found.push_back(difference);
    }
}

bool is_in_hole(const Section& section, Vec2 p) {
    return std::any_of(section.loops.begin(), section.loops.end(),
                       [&](const SectionLoop& loop) { return loop.is_hole() && is_inside(loop, p); });
}

// Whether a part or hole of the section lies within one of its neighbour: it is smaller there, not missing.
bool has_one_within(const Section& section, const SectionLoop& loop) {
    return std::any_of(section.loops.begin(), section.loops.end(), [&](const SectionLoop& own) {
        return own.is_hole() == loop.is_hole() &&
               std::all_of(own.points.begin(), own.points.end(), [&](Vec2 p) { return is_inside(loop, p); });
    });
}

// Parts and holes of one neighbour that the other one has too, at least as parts of larger ones.
void add_what_is_missing(const Three& three, double of, std::vector<TopologyDifference>& found) {
    const Section& one = *three[itself];
    for (const Which which : {below_it, above_it}) {
        const Section& other = *three[which == below_it ? above_it : below_it];
        for (const SectionLoop& loop : three[which]->loops) {
            const std::vector<Vec2> samples = samples_of(loop);
            // A part that is missing lies outside the section; a missing hole lies inside.
            const bool is_hole = loop.is_hole();
            if (share_of(samples, [&](Vec2 p) { return is_inside(one, p) == is_hole; }) < 1 ||
                share_of(samples,
                         [&](Vec2 p) { return is_hole ? is_in_hole(other, p) : is_inside(other, p); }) <
                    most_samples ||
                has_one_within(one, loop))
                continue;
            TopologyDifference difference;
            difference.kind =
                is_hole ? TopologyDifferenceKind::hole_missing : TopologyDifferenceKind::part_missing;
            difference.contour = loop.contour;
            difference.area_mm2 = std::abs(loop.area);
            difference.share = difference.area_mm2 / of;
            found.push_back(difference);
        }
    }
}

// Parts and holes that go on from one neighbour to the other aslant, where the section has none on the way.
void add_what_is_missing_aslant(const Three& three, double t, double of,
                                std::vector<TopologyDifference>& found) {
    const Section &below = *three[below_it], &one = *three[itself], &above = *three[above_it];
    const double reach = most_slope * (above.height - below.height);
    const auto is_missing = [&](const SectionLoop& loop) {
        const std::vector<Vec2> samples = samples_of(loop);
        return share_of(samples, [&](Vec2 p) { return is_inside(one, p) == loop.is_hole(); }) == 1;
    };
    for (const SectionLoop& low : below.loops) {
        if (!is_missing(low)) continue;
        for (const SectionLoop& high : above.loops) {
            if (high.is_hole() != low.is_hole() || !are_alike(low, high) ||
                length(high.centre - low.centre) > reach || !is_missing(high))
                continue;
            const Vec2 way = (1 - t) * low.centre + t * high.centre;
            const double most = circle_radius(low.area) + circle_radius(high.area);
            const bool goes_on = std::any_of(one.loops.begin(), one.loops.end(), [&](const SectionLoop& own) {
                return own.is_hole() == low.is_hole() &&
                       (is_inside(own, way) || length(own.centre - way) <= most);
            });
            if (goes_on) continue;
            const double area = 0.5 * std::abs(low.area + high.area);
            found.push_back(
                {low.is_hole() ? TopologyDifferenceKind::hole_missing : TopologyDifferenceKind::part_missing,
                 low.contour, area, area / of, 0});
        }
    }
}

}  // namespace

SectionComparison compare_sections(const Section& below, const Section& one, const Section& above) {
    const Three three{&below, &one, &above};
    const double t = (one.height - below.height) / (above.height - below.height);
    const double of = std::max(one.area, 0.5 * (below.area + above.area));
    SectionComparison comparison;
    comparison.shape = worst_shape(three, t, of);
    add_what_is_alone(three, t, of, comparison.topology);
    add_what_is_missing(three, of, comparison.topology);
    add_what_is_missing_aslant(three, t, of, comparison.topology);
    return comparison;
}

}  // namespace anatomesh
