#include "anatomesh/reconcile/drawn_places.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>

#include "anatomesh/reconcile/contour_graph.h"

namespace anatomesh {

namespace {

// The points of a contour, by place.
std::vector<std::uint32_t> by_place(const ContourSet& set, const Contour& contour) {
    std::vector<std::uint32_t> order(contour.point_count);
    for (std::uint32_t n = 0; n < contour.point_count; ++n) order[n] = contour.first_point + n;
    std::sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) {
        return lexicographic_less(set.points[p], set.points[q]);
    });
    return order;
}

// Displacements of the points between those that have one, linear along the contour.
void interpolate(const ContourSet& set, const Contour& contour, const std::vector<bool>& is_known,
                 std::vector<Vec3>& displacement) {
    std::uint32_t first = no_node;
    for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
        if (is_known[k]) {
            first = k;
            break;
        }
    }
    if (first == no_node) return;
    std::uint32_t start = first;
    do {
        std::vector<std::uint32_t> between;
        std::vector<double> reached;
        double walked = 0;
        std::uint32_t last = start, k = point_after(contour, start);
        for (; !is_known[k]; k = point_after(contour, k)) {
            walked += length(set.points[k] - set.points[last]);
            between.push_back(k);
            reached.push_back(walked);
            last = k;
        }
        walked += length(set.points[k] - set.points[last]);
        for (std::size_t n = 0; n < between.size(); ++n) {
            const double share = walked > 0 ? reached[n] / walked : 0;
            displacement[between[n]] = displacement[start] + share * (displacement[k] - displacement[start]);
        }
        start = k;
    } while (start != first);
}

}  // namespace

DrawnPlaces drawn_places(const ContourSet& set) {
    return {set.points, std::vector<bool>(set.points.size(), true)};
}

DrawnPlaces carry_over(const ContourSet& before, const DrawnPlaces& drawn, const ContourSet& after) {
    assert(before.contours.size() == after.contours.size() && drawn.at.size() == before.points.size());
    std::vector<bool> is_known(after.points.size(), false);
    std::vector<Vec3> displacement(after.points.size());
    DrawnPlaces result{after.points, std::vector<bool>(after.points.size(), false)};
    for (std::size_t c = 0; c < after.contours.size(); ++c) {
        const Contour& contour = after.contours[c];
        const std::vector<std::uint32_t> old = by_place(before, before.contours[c]);
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            const auto found = std::lower_bound(
                old.begin(), old.end(), after.points[k],
                [&](std::uint32_t p, Vec3 q) { return lexicographic_less(before.points[p], q); });
            if (found == old.end() || before.points[*found] != after.points[k]) continue;
            is_known[k] = true;
            displacement[k] = after.points[k] - drawn.at[*found];
            result.at[k] = drawn.at[*found];
            result.is_drawn[k] = drawn.is_drawn[*found];
        }
        interpolate(after, contour, is_known, displacement);
    }
    for (std::size_t k = 0; k < after.points.size(); ++k) {
        if (!is_known[k]) result.at[k] = after.points[k] - displacement[k];
    }
    return result;
}

}  // namespace anatomesh
