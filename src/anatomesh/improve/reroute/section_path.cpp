#include "anatomesh/improve/reroute/section_path.h"

#include <span>
#include <utility>

#include "anatomesh/geom/numbers.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_beside =
    6;                       // on either side of a missed one, that a way may replace [segments; >= 0; B]
constexpr double reach = 2;  // how far along them it may end, in most_mm [1; > 0; B]

}  // namespace

PathEnds SectionPathSearch::ends(const ReroutedContour& contour, std::size_t n, int step) {
    const std::size_t count = contour.loop.size(), most = std::min(most_beside, (count - 2) / 2);
    PathEnds found;
    // From the segment's other end on.
    LoopCorner x = contour.loop.corner(n);
    if (step < 0) x = contour.loop.beside(n, x.at, 1);
    for (std::size_t k = 0; k <= most && found.length <= reach * routable_.most_mm; ++k) {
        const LoopCorner y = contour.loop.beside(step > 0 ? n + k : n + 1 + count - k, x.at, step);
        add_row(contour.contour.structure, x, y, k > 0, found);
        x = y;
    }
    return found;
}

// Of the segment from x to y without x: all, or, where it is missed, what there is of it on y's side - and on
// x's, if `both`.
void SectionPathSearch::add_row(std::uint32_t structure, const LoopCorner& x, const LoopCorner& y, bool both,
                                PathEnds& ends) {
    std::vector<std::uint32_t> row = incidence_.row_from(y.vertex, x.vertex, structure);
    if (both && row.back() != x.vertex) {
        for (const std::uint32_t v : incidence_.row_from(x.vertex, y.vertex, structure)) add(x, y, v, ends);
    }
    std::reverse(row.begin(), row.end());
    for (const std::uint32_t v : row) add(x, y, v, ends);
}

void SectionPathSearch::add(const LoopCorner& x, const LoopCorner& y, std::uint32_t v, PathEnds& ends) const {
    if (v == x.vertex) return;
    const Vec3 p = edit_.mesh.point(v);
    if (!ends.corners.empty()) ends.length += length(p - edit_.mesh.point(ends.corners.back().vertex));
    const Vec3 a = edit_.mesh.point(x.vertex), b = edit_.mesh.point(y.vertex);
    ends.corners.push_back({v, x.at + length(p - a) / length(b - a) * (y.at - x.at)});
    if (v == y.vertex) ends.corners.back() = y;
    ends.ends.push_back({v, ends.length});
}

std::optional<SectionPath> SectionPathSearch::find(const ReroutedContour& rerouted, const PathEnds& here,
                                                   const PathEnds& there) {
    const Contour& contour = rerouted.contour;
    const std::vector<Vec3> drawn =
        rerouted.loop.drawn_between(here.corners.back().at, there.corners.back().at);
    double longest = 0;
    for (std::size_t n = 1; n < drawn.size(); ++n)
        longest = std::max(longest, length(drawn[n] - drawn[n - 1]));
    SurfaceSection section(edit_, routable_.planes[contour.slice], contour.structure,
                           on_segment_share * longest, contours_.of_slice(contour.slice));
    const std::span<const std::uint32_t> taken = contours_.of_drawing(contour);
    const auto is_end = [&](std::uint32_t v) {
        return std::any_of(there.ends.begin(), there.ends.end(),
                           [&](const WayEnd& end) { return end.vertex == v; });
    };
    std::optional<std::vector<SectionPoint>> points =
        section.shortest_way(here.ends, there.ends, [&](const SectionPoint& point) {
            if (point.node.is_vertex() && !is_end(point.node.p) &&
                std::binary_search(taken.begin(), taken.end(), point.node.p))
                return false;
            return length(point.place - nearest_on_row(drawn, point.place)) <= routable_.most_mm;
        });
    if (!points) return std::nullopt;
    SectionPath path{std::move(*points)};
    path.from = here.at(path.points.front().node.p);
    path.to = there.at(path.points.back().node.p);
    path.farthest_mm = distance_of_rows(path.places(), rerouted.loop.drawn_between(path.from, path.to));
    return path;
}

}  // namespace anatomesh
