#include "anatomesh/improve/reroute/neighbor_rings.h"

#include <algorithm>

#include "anatomesh/geom/predicates.h"

namespace anatomesh {

void NeighborRings::add(const RoutedRing& ring, std::uint32_t structure) {
    const RingWithWays whole = with_ways(ring);
    vertices_.insert(whole.vertices.begin(), whole.vertices.end());
    for (std::uint32_t k = 0; k < ring.size(); ++k)
        sharing_[ends(ring.vertex(k), ring.vertex(k + 1))].push_back(structure);
    for (const RingWay& way : ring.ways) {
        const std::uint32_t a = ring.vertices[way.first];
        if (way.count == 1) twins_[ends(a, ring.vertex(way.first + 1))] = {a, way.between};
    }
    PlaneRing& flat = rings_.emplace_back(PlaneRing{structure, {}});
    for (const std::uint32_t v : whole.vertices) flat.at.push_back(at(v));
}

std::optional<std::vector<std::uint32_t>> NeighborRings::way_between(std::uint32_t a, std::uint32_t b) const {
    const auto twin = twins_.find(ends(a, b));
    if (twin == twins_.end()) return std::nullopt;
    std::vector<std::uint32_t> between = twin->second.between;
    if (twin->second.from != a) std::reverse(between.begin(), between.end());
    return between;
}

bool NeighborRings::hold(const RoutedRing& ring, const RingWay& way) const {
    if (!way.between.empty() && vertices_.contains(way.between.front())) return false;  // a common wall
    std::vector<std::uint32_t> sharing;
    for (std::uint32_t k = 0; k < way.count; ++k) {
        const std::uint32_t n = (way.first + k) % ring.size();
        const auto found = sharing_.find(ends(ring.vertex(n), ring.vertex(n + 1)));
        if (found != sharing_.end())
            sharing.insert(sharing.end(), found->second.begin(), found->second.end());
    }
    const Vec2 a = at(ring.vertices[way.first]), b = at(ring.vertex(way.first + way.count));
    const Vec2 p = way.between.empty() ? 0.5 * (a + b) : at(way.between.front());
    std::map<std::uint32_t, bool> inside;  // by structure
    for (const PlaneRing& other : rings_) {
        if (std::find(sharing.begin(), sharing.end(), other.structure) != sharing.end()) continue;
        for (std::size_t n = 0; n < other.at.size(); ++n) {
            const Vec2 s = other.at[n], t = other.at[(n + 1) % other.at.size()];
            if ((s.y > p.y) != (t.y > p.y) && (orient2d(s, t, p) > 0) == (t.y > s.y))
                inside[other.structure] = !inside[other.structure];
        }
    }
    return std::any_of(inside.begin(), inside.end(), [](const auto& one) { return one.second; });
}

}  // namespace anatomesh
