#include "anatomesh/measure/topology/drawn_parts.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "anatomesh/contour/overlay/arrangement.h"
#include "anatomesh/contour/overlay/boundary_loops.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// An overlay of two slices with more edges is not made, and what they have in common counts as not in one
// piece. [edges; >= 1; B]
constexpr std::size_t most_edges = 10'000'000;

// All slices are seen along the normal of the first.
const Plane& common_plane(const ContourSet& contours) {
    return contours.slices.front().plane;
}

std::vector<Vec2> flat(const ContourSet& contours, std::uint32_t contour) {
    std::vector<Vec2> ring;
    for (const Vec3& p : contours.points_of(contours.contours[contour]))
        ring.push_back(common_plane(contours).to_plane(p));
    return ring;
}

bool apart(const Box2& a, const Box2& b) {
    return a.high.x < b.low.x || b.high.x < a.low.x || a.high.y < b.low.y || b.high.y < a.low.y;
}

// Whether a face of the arrangement, of which `first` rings are the one part's and the others the other's, is
// in both.
bool in_both(const Winding& winding, std::size_t first) {
    bool in_low = false, in_high = false;
    for (const RingTurns& turn : winding) {
        if (turn.turns % 2 == 0) continue;
        bool& in = turn.ring < first ? in_low : in_high;
        in = !in;
    }
    return in_low && in_high;
}

struct Intersection {
    std::size_t pieces = 0, holes = 0;
};

// Nothing where the two parts do not meet. A piece that only touches itself counts as two.
std::optional<Intersection> intersect(const ContourSet& contours, const DrawnPart& low,
                                      const DrawnPart& high) {
    if (apart(low.box, high.box)) return std::nullopt;
    std::vector<Ring> rings;
    for (const DrawnPart* part : {&low, &high}) {
        for (const std::uint32_t c : part->contours) {
            Ring ring;
            const auto points = contours.points_of(contours.contours[c]);
            const std::vector<Vec2> at = flat(contours, c);
            for (std::size_t n = 0; n < at.size(); ++n) ring.push_back(at[n], points[n]);
            rings.push_back(std::move(ring));
        }
    }
    const std::optional<Arrangement> plan = arrange(rings, common_plane(contours), most_edges);
    if (!plan) return Intersection{};  // as good as not in one piece
    std::vector<BoundaryEdge> edges;
    for (const Arrangement::Edge& edge : plan->edges) {
        const bool left = in_both(plan->windings[edge.left], low.contours.size());
        const bool right = in_both(plan->windings[edge.right], low.contours.size());
        if (left == right) continue;
        edges.push_back(left ? BoundaryEdge{edge.a, edge.b} : BoundaryEdge{edge.b, edge.a});
    }
    if (edges.empty()) return std::nullopt;
    Intersection found;
    for (const std::vector<std::uint32_t>& loop : boundary_loops(plan->at, edges)) {
        std::vector<Vec2> ring;
        for (const std::uint32_t e : loop) ring.push_back(plan->at[edges[e].from]);
        ++(signed_area(ring) > 0 ? found.pieces : found.holes);
    }
    return found;
}

}  // namespace

std::vector<DrawnPart> drawn_parts(const ContourSet& contours, std::uint32_t slice, std::uint32_t structure) {
    struct Drawn {
        std::uint32_t contour;
        std::vector<Vec2> ring;
        double area;
    };
    std::vector<Drawn> drawn;
    const Slice& on = contours.slices[slice];
    for (std::uint32_t c = on.first_contour; c < on.first_contour + on.contour_count; ++c) {
        if (contours.contours[c].structure != structure) continue;
        drawn.push_back({c, flat(contours, c), 0});
        drawn.back().area = signed_area(drawn.back().ring);
    }
    // The normals of parallel slices may be opposite: the largest contour is an outer one.
    double largest = 0;
    for (const Drawn& d : drawn) {
        if (std::abs(d.area) > std::abs(largest)) largest = d.area;
    }
    std::vector<DrawnPart> parts;
    std::vector<const Drawn*> outers;
    for (const Drawn& d : drawn) {
        if ((d.area > 0) != (largest > 0)) continue;
        outers.push_back(&d);
        parts.push_back({{d.contour}, {}});
        for (const Vec2 q : d.ring) parts.back().box.extend(q);
    }
    for (const Drawn& hole : drawn) {
        if ((hole.area > 0) == (largest > 0)) continue;
        std::size_t smallest = outers.size();
        for (std::size_t n = 0; n < outers.size(); ++n) {
            if (smallest < outers.size() && std::abs(outers[n]->area) >= std::abs(outers[smallest]->area))
                continue;
            if (std::abs(outers[n]->area) > std::abs(hole.area) && parts[n].box.contains(hole.ring[0]) &&
                side_of_polygon(outers[n]->ring, hole.ring[0]) != Side::outside) {
                smallest = n;
            }
        }
        if (smallest < outers.size()) parts[smallest].contours.push_back(hole.contour);
    }
    return parts;
}

std::vector<Continuation> continued_by(const ContourSet& contours, const std::vector<DrawnPart>& low,
                                       const std::vector<DrawnPart>& high) {
    // It stands for several parts, where only one can be named. [index; -2; D]
    constexpr std::int32_t several = -2;
    std::vector<Continuation> up(low.size());
    std::vector<std::int32_t> down(high.size(), -1);
    for (std::size_t a = 0; a < low.size(); ++a) {
        for (std::size_t b = 0; b < high.size(); ++b) {
            const std::optional<Intersection> common = intersect(contours, low[a], high[b]);
            if (!common) continue;
            const std::size_t fewer = std::min(low[a].holes(), high[b].holes()),
                              more = std::max(low[a].holes(), high[b].holes());
            const bool simply = common->pieces == 1 && common->holes == more && (fewer == more || fewer == 0);
            up[a].part = up[a].part == -1 && simply ? static_cast<std::int32_t>(b) : several;
            up[a].holes_closed = static_cast<std::uint32_t>(more - fewer);
            down[b] = down[b] == -1 && simply ? static_cast<std::int32_t>(a) : several;
        }
    }
    for (std::size_t a = 0; a < low.size(); ++a) {
        const std::int32_t b = up[a].part;
        if (b < 0 || down[static_cast<std::size_t>(b)] != static_cast<std::int32_t>(a)) up[a] = {};
    }
    return up;
}

}  // namespace anatomesh
