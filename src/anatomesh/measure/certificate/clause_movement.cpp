#include <algorithm>
#include <cstdint>
#include <string>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/number_text.h"
#include "anatomesh/base/plural.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/measure/certificate/count_text.h"

namespace anatomesh {

namespace {

// What moved less is the same to rounding. [mm; > 0; D]
constexpr double least_stated_mm = 1e-6;

std::string movement_text(const ContourMovementReport& movement, std::uint64_t rerouted, double bound_mm,
                          double farthest_mm) {
    const std::string farthest = "by at most " + fixed_text(farthest_mm, 3) + " mm";
    if (movement.contours_moved + rerouted == 0)
        return "; contours were moved from where they are drawn, " + farthest;
    const std::string bound = " by more than " + fixed_text(bound_mm, 3) + " mm, half a slice spacing";
    std::string text;
    if (movement.contours_moved > 0) {
        text = "; " + count_of(movement.contours_moved, movement.contours) + " contours (" +
               count_of(movement.vertices_moved, movement.vertices) +
               " vertices) were moved from where they are drawn" + bound + ", " + farthest +
               (movement.slice.empty() ? "" : " (" + movement.structure + ", slice " + movement.slice + ")");
    }
    if (rerouted > 0)
        text += "; " + counted(rerouted, "contour") + " to edges of the surface" + bound + ", " + farthest;
    return text;
}

}  // namespace

void state_movement(ModelReport& report) {
    const ContourMovementReport& movement = report.crossing.movement;
    const double bound_mm = movement.bound_mm > 0
                                ? movement.bound_mm
                                : contract::moved_share_of_spacing * report.lengths.slice_spacing_mm;
    double farthest_mm = movement.farthest_mm;
    std::uint64_t rerouted = 0;
    for (const RoutedContourReport& contour : report.contours.routed) {
        const bool is_far = bound_mm > 0 && contour.farthest_mm > bound_mm;
        rerouted += is_far;
        if (is_far) farthest_mm = std::max(farthest_mm, contour.farthest_mm);
    }
    const bool is_moved = movement.contours_moved + rerouted > 0;
    if (!is_moved && farthest_mm <= least_stated_mm) return;
    for (Clause& clause : report.certificate) {
        if (clause.number > 2) continue;
        if (is_moved && clause.state == ClauseState::kept) clause.state = ClauseState::moved;
        if (clause.number == 1) clause.evidence += movement_text(movement, rerouted, bound_mm, farthest_mm);
        if (clause.number == 2 && clause.state == ClauseState::moved)
            clause.evidence += "; of contours as they were moved (clause 1)";
    }
}

}  // namespace anatomesh
