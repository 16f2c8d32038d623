#include "anatomesh/improve/reroute/rerouted_contours.h"

#include <algorithm>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/contour/overlay/slice_soundness.h"

namespace anatomesh {

ReroutedContours::ReroutedContours(EditContext& edit, const RoutableContours& routable)
    : edit_(edit), routable_(routable), incidence_(edit) {
    for (std::uint32_t n = 0; n < routable_.contours.size(); ++n) {
        ReroutedContour contour = as_drawn(n);
        const std::size_t missed = count_missed(contour);
        missed_at_first_ += missed;
        if (missed > 0) contours_.push_back(std::move(contour));
    }
}

ReroutedContour ReroutedContours::as_drawn(std::uint32_t number) const {
    const Contour& contour = routable_.contours[number];
    const auto vertices = routable_.vertices.subspan(contour.first_point, contour.point_count);
    std::vector<Vec3> places;
    for (const std::uint32_t v : vertices) places.push_back(edit_.mesh.point(v));
    return {number, contour, {vertices, std::move(places)}};
}

bool ReroutedContours::is_as_drawn(const ReroutedContour& contour) {
    const ReroutedContour drawn = as_drawn(contour.number);
    return count_missed(drawn) == 0;
}

bool ReroutedContours::is_missed(const ReroutedContour& contour, std::size_t n) {
    const std::uint32_t a = contour.loop.corner(n).vertex, b = contour.loop.corner(n + 1).vertex;
    return incidence_.row_from(a, b, contour.contour.structure).back() != b;
}

std::size_t ReroutedContours::count_missed(const ReroutedContour& contour) {
    std::size_t missed = 0;
    for (std::size_t n = 0; n < contour.loop.size(); ++n) missed += is_missed(contour, n);
    return missed;
}

void ReroutedContours::find_vertices() {
    for (const Contour& contour : routable_.contours) {
        for (std::uint32_t n = 0; n < contour.point_count; ++n)
            note(contour, routable_.vertices[contour.first_point + n]);
    }
    for (auto& [key, vertices] : of_drawing_) sort_distinct(vertices);
    for (auto& [slice, vertices] : of_slice_) sort_distinct(vertices);
    drawn_.assign(routable_.vertices.begin(), routable_.vertices.end());
    sort_distinct(drawn_);
}

void ReroutedContours::note(const Contour& contour, std::uint32_t v) {
    of_drawing_[drawing(contour)].push_back(v);
    of_slice_[contour.slice].push_back(v);
}

void ReroutedContours::note_way(const Contour& contour, const std::vector<std::uint32_t>& way) {
    for (const std::uint32_t v : way) note(contour, v);
    on_ways_.insert(on_ways_.end(), way.begin(), way.end());
    sort_distinct(on_ways_);
    sort_distinct(of_drawing_[drawing(contour)]);
    sort_distinct(of_slice_[contour.slice]);
}

bool ReroutedContours::is_drawn(std::uint32_t v) const {
    return std::binary_search(drawn_.begin(), drawn_.end(), v);
}

bool ReroutedContours::is_on_way(std::uint32_t v) const {
    return std::binary_search(on_ways_.begin(), on_ways_.end(), v);
}

bool ReroutedContours::replace(const ReroutedContour& contour, const LoopStretch& stretch,
                               ContourLoop& loop) const {
    return loop.replace(stretch) && is_sound(contour, loop);
}

bool ReroutedContours::is_sound(const ReroutedContour& changed_contour, const ContourLoop& changed) const {
    const Plane& plane = routable_.planes[changed_contour.contour.slice];
    std::vector<PlaneRing> rings;
    for (std::uint32_t n = 0; n < routable_.contours.size(); ++n) {
        const Contour& contour = routable_.contours[n];
        if (contour.slice != changed_contour.contour.slice) continue;
        PlaneRing& ring = rings.emplace_back(PlaneRing{contour.structure, {}});
        const auto found = std::find_if(contours_.begin(), contours_.end(),
                                        [&](const ReroutedContour& other) { return other.number == n; });
        const ContourLoop* const loop = n == changed_contour.number ? &changed
                                        : found != contours_.end()  ? &found->loop
                                                                    : nullptr;
        const std::size_t count = loop ? loop->size() : contour.point_count;
        for (std::size_t k = 0; k < count; ++k) {
            const std::uint32_t v =
                loop ? loop->corner(k).vertex : routable_.vertices[contour.first_point + k];
            ring.at.push_back(plane.to_plane(edit_.mesh.point(v)));
        }
    }
    return slice_faults(rings, routable_.exclusive).empty();
}

}  // namespace anatomesh
