#include "anatomesh/reconcile/move/original_positions.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>

#include "anatomesh/reconcile/move/contour_graph.h"

namespace anatomesh {

namespace {

// Returns the points of a contour in the order of their places.
std::vector<std::uint32_t> by_place(const ContourSet& set, const Contour& contour) {
    std::vector<std::uint32_t> order(contour.point_count);
    for (std::uint32_t n = 0; n < contour.point_count; ++n) order[n] = contour.first_point + n;
    std::sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) {
        return lexicographic_less(set.points[p], set.points[q]);
    });
    return order;
}

// Interpolates the displacements of points between those that have one, linearly along the contour.
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

// Matches points that came in the place of others between the same two points that stay. `old_of` gets the
// others, each once.
void find_moved(const ContourSet& before, const Contour& old, const ContourSet& after, const Contour& contour,
                double reach, std::vector<std::uint32_t>& old_of) {
    for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
        if (old_of[k] == no_node || old_of[point_after(contour, k)] != no_node) continue;
        std::uint32_t next = point_after(old, old_of[k]), end = point_after(contour, k);
        while (old_of[end] == no_node) end = point_after(contour, end);
        const std::uint32_t stop = old_of[end];
        for (std::uint32_t m = point_after(contour, k); m != end; m = point_after(contour, m)) {
            std::uint32_t nearest = no_node;
            for (std::uint32_t n = next; n != stop; n = point_after(old, n)) {
                const double distance = length(before.points[n] - after.points[m]);
                if (distance <=
                    (nearest == no_node ? reach : length(before.points[nearest] - after.points[m])))
                    nearest = n;
            }
            if (nearest == no_node) continue;
            old_of[m] = nearest;
            next = point_after(old, nearest);
        }
        // What was found belongs to this stretch, so the search goes on after it.
        k = end <= k ? contour.first_point + contour.point_count - 1 : end - 1;
    }
}

}  // namespace

OriginalPositions original_positions(const ContourSet& set) {
    return {set.points, std::vector<bool>(set.points.size(), true)};
}

OriginalPositions carry_over(const ContourSet& before, const OriginalPositions& drawn,
                             const ContourSet& after, double reach_mm) {
    assert(before.contours.size() == after.contours.size() && drawn.at.size() == before.points.size());
    std::vector<std::uint32_t> old_of(after.points.size(), no_node);
    std::vector<bool> is_known(after.points.size(), false);
    std::vector<Vec3> displacement(after.points.size());
    OriginalPositions result{after.points, std::vector<bool>(after.points.size(), false)};
    for (std::size_t c = 0; c < after.contours.size(); ++c) {
        const Contour& contour = after.contours[c];
        const std::vector<std::uint32_t> old = by_place(before, before.contours[c]);
        const std::uint32_t end = contour.first_point + contour.point_count;
        for (std::uint32_t k = contour.first_point; k < end; ++k) {
            const auto found = std::lower_bound(
                old.begin(), old.end(), after.points[k],
                [&](std::uint32_t p, Vec3 q) { return lexicographic_less(before.points[p], q); });
            if (found != old.end() && before.points[*found] == after.points[k]) old_of[k] = *found;
        }
        find_moved(before, before.contours[c], after, contour, reach_mm, old_of);
        for (std::uint32_t k = contour.first_point; k < end; ++k) {
            if (old_of[k] == no_node) continue;
            is_known[k] = true;
            result.at[k] = drawn.at[old_of[k]];
            result.is_drawn[k] = drawn.is_drawn[old_of[k]];
            displacement[k] = after.points[k] - result.at[k];
        }
        interpolate(after, contour, is_known, displacement);
    }
    for (std::size_t k = 0; k < after.points.size(); ++k) {
        if (!is_known[k]) result.at[k] = after.points[k] - displacement[k];
    }
    return result;
}

}  // namespace anatomesh
