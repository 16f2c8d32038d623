#include "anatomesh/live/draw/area/combine_area.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/live/draw/area/ring_overlay.h"

namespace anatomesh {

namespace {

Box2 box_of(const Ring& ring) {
    Box2 box;
    for (const Vec2 p : ring.at) box.extend(p);
    return box;
}

bool meet(const Box2& p, const Box2& q) {
    return p.low.x <= q.high.x && q.low.x <= p.high.x && p.low.y <= q.high.y && q.low.y <= p.high.y;
}

// The rings whose boxes the area meets. A ring around one of them, or around the area, is among them.
std::vector<std::uint32_t> near_rings(const StructureRings& before, std::span<const Ring> area) {
    Box2 reach;
    for (const Ring& ring : area) {
        for (const Vec2 p : ring.at) reach.extend(p);
    }
    std::vector<std::uint32_t> found;
    for (std::uint32_t r = 0; r < before.rings.size(); ++r) {
        if (meet(box_of(before.rings[r]), reach)) found.push_back(r);
    }
    return found;
}

AreaEffect effect_of(AreaRule rule, bool overlaps) {
    if (rule == AreaRule::subtract) return AreaEffect::cut;
    if (rule == AreaRule::subtract_or_add && overlaps) return AreaEffect::cut;
    return overlaps ? AreaEffect::extended : AreaEffect::new_part;
}

// Which faces belong to the result.
std::vector<char> chosen_faces(const RingOverlay& overlay, AreaEffect effect) {
    std::vector<char> inside;
    for (const FaceSides& face : overlay.faces()) {
        inside.push_back(effect == AreaEffect::cut ? face.in_structure && !face.in_area
                                                   : face.in_structure || face.in_area);
    }
    return inside;
}

// The rings of the parts that the area does not overlap.
std::vector<std::int32_t> rings_of_other_parts(const StructureRings& before, const RingOverlay& overlay) {
    std::vector<char> goes(before.rings.size(), 0);
    for (const FaceSides& face : overlay.faces()) {
        if (face.in_structure && face.in_area) goes[static_cast<std::size_t>(face.innermost)] = 1;
    }
    const std::vector<std::int32_t> parents = overlay.parents();
    std::vector<std::int32_t> rest;
    for (std::size_t r = 0; r < before.rings.size(); ++r) {
        // Only outer rings are marked, so a ring whose parent is marked is a hole.
        const bool is_hole_of_it = parents[r] >= 0 && goes[static_cast<std::size_t>(parents[r])];
        if (!goes[r] && !is_hole_of_it) rest.push_back(static_cast<std::int32_t>(r));
    }
    return rest;
}

// Puts the rings of the region in the place of the rings `near`.
void merge(const StructureRings& before, const std::vector<std::uint32_t>& near, Region region,
           CombinedArea& to) {
    to.rings.rings.clear();
    to.came_from.clear();
    const auto add = [&](Ring ring, std::int32_t from) {
        to.rings.rings.push_back(std::move(ring));
        to.came_from.push_back(from);
    };
    auto next = region.rings.begin();
    std::size_t k = 0;
    for (std::uint32_t r = 0; r < before.rings.size(); ++r) {
        if (k == near.size() || near[k] != r) {
            add(before.rings[r], static_cast<std::int32_t>(r));
            continue;
        }
        for (; next != region.rings.end() && next->owner == static_cast<std::int32_t>(k); ++next) {
            add(std::move(next->ring), static_cast<std::int32_t>(r));
        }
        ++k;
    }
    for (; next != region.rings.end(); ++next) add(std::move(next->ring), -1);
}

bool are_unchanged(const Region& region, std::size_t rings) {
    return region.rings.size() == rings && std::all_of(region.rings.begin(), region.rings.end(),
                                                       [](const RegionRing& r) { return r.is_unchanged; });
}

Result<CombinedArea> replace_parts(const StructureRings& before, std::span<const Ring> area) {
    const std::optional<RingOverlay> overlay = RingOverlay::make(before.rings, area, before.plane);
    if (!overlay) return crosses_too_often();
    const std::vector<std::int32_t> others = rings_of_other_parts(before, *overlay);
    StructureRings rest{before.plane, {}};
    for (const std::int32_t r : others) rest.rings.push_back(before.rings[static_cast<std::size_t>(r)]);
    ANATOMESH_TRY(CombinedArea result, combine_area(rest, area, AreaRule::unite));
    for (std::int32_t& from : result.came_from) {
        if (from >= 0) from = others[static_cast<std::size_t>(from)];
    }
    if (overlay->overlaps()) result.effect = AreaEffect::replaced;
    if (are_same(before.rings, result.rings.rings)) result.effect = AreaEffect::nothing;
    return result;
}

}  // namespace

Result<CombinedArea> combine_area(const StructureRings& before, std::span<const Ring> area, AreaRule rule) {
    if (rule == AreaRule::replace) return replace_parts(before, area);
    CombinedArea result;
    result.rings = before;
    result.came_from.resize(before.rings.size());
    std::iota(result.came_from.begin(), result.came_from.end(), 0);
    const std::vector<std::uint32_t> near = near_rings(before, area);
    std::vector<Ring> own;
    for (const std::uint32_t r : near) own.push_back(before.rings[r]);
    const std::optional<RingOverlay> overlay = RingOverlay::make(own, area, before.plane);
    if (!overlay) return crosses_too_often();
    result.mended_crossings = overlay->crossings_of_area();
    result.is_area_empty = std::none_of(overlay->faces().begin(), overlay->faces().end(),
                                        [](const FaceSides& face) { return face.in_area; });
    const AreaEffect effect = effect_of(rule, overlay->overlaps());
    Region region = overlay->region(chosen_faces(*overlay, effect));
    result.sliver_area_mm2 = region.sliver_area_mm2;
    if (are_unchanged(region, own.size())) return result;
    result.effect = effect;
    merge(before, near, std::move(region), result);
    return result;
}

}  // namespace anatomesh
