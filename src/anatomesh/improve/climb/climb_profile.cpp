#include "anatomesh/improve/climb/climb_profile.h"

#include <algorithm>

#include "anatomesh/base/contract.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/improve/core/quality_gate.h"

namespace anatomesh {

namespace {

// From the first bound of ratios to the last one, so that angles are paid for with as little as will do.
// [steps; >= 1; M 2026-11 pelvis, spine, skull, 61 labels, fetal brain]
constexpr int ratio_steps = 3;

// A surgery may change so many cells for its shapes. Of ten thousand subsegments none that could be recovered
// took more than 1,800; others went on for ever. [cells; > 0; B]
constexpr std::size_t most_for_surgery = 2000;

// A sine below which a cell is flat: 0.06 degrees, a little above what the contract allows of forced cells.
// [1; 0 to 1; M 2026-11 sets about an axis]
constexpr double flat_sine = 1e-3;

// The bound of ratios after so many of `ratio_steps`.
double ratio_of_step(const MeshImprovementOptions& options, int step) {
    const double first = options.max_radius_edge, last = options.last_radius_edge;
    return first + step * (last - first) / ratio_steps;
}

AcceptanceRule rule_of(double max_radius_edge, double least_sine) {
    AcceptanceRule rule;
    rule.max_radius_edge = max_radius_edge;
    rule.least_sine = least_sine;
    return rule;
}

// The rule of passes that come late: few cells are left, so that they may use all room there is.
AcceptanceRule late_rule_of(double max_radius_edge, double least_sine) {
    AcceptanceRule rule = rule_of(max_radius_edge, least_sine);
    rule.moves_junctions = rule.guards_sections = true;
    return rule;
}

AcceptanceRule sparing(AcceptanceRule rule) {
    rule.spares_limited = true;
    return rule;
}

// No new cell is below the sine or above the ratio, whatever the cells were before.
AcceptanceRule strictly(AcceptanceRule rule, double least_sine, double max_ratio) {
    rule.strict_least_sine = least_sine;
    rule.strict_max_ratio = max_ratio;
    return rule;
}

// An angle that would be listed is worth a ratio above the bound, but no larger a ratio than it takes.
ClimbProfile listed_angles(const MeshImprovementOptions& options, int step) {
    return {.target_sine = listed_sine(),
            .rule = late_rule_of(ratio_of_step(options, step), listed_sine()),
            .operations = thorough_operations,
            .lists_changes = true};
}

std::array<ClimbProfile, 3> surgery_rows(const MeshImprovementOptions& options) {
    const double bound = options.max_radius_edge, last = options.last_radius_edge, listed = listed_sine();
    return {{
        // Angles of a surgery. The surgery leaves thin cells. What contours force to be ill-shaped is not
        // worked on for its sake alone.
        {.target_sine = target_sine(options),
         .exempt = Exempt::limited_in_bounds,
         .rule = late_rule_of(bound, 0),
         .operations = thorough_operations,
         .most_changed = most_for_surgery,
         .lists_changes = true},
        // Listed angles of a surgery. Angles that would undo the surgery are worth ratios up to the last
        // bound.
        {.target_sine = listed,
         .exempt = Exempt::limited_in_bounds,
         .rule = late_rule_of(last, listed),
         .operations = thorough_operations,
         .most_changed = most_for_surgery,
         .lists_changes = true},
        // Ratios of a surgery. Ratios that were given for angles are taken back where no angle becomes
        // listed.
        {.target_ratio = bound,
         .exempt = Exempt::limited,
         .rule = late_rule_of(bound, listed),
         .operations = thorough_operations,
         .revisit = Revisit::all,
         .most_changed = most_for_surgery},
    }};
}

std::array<ClimbProfile, 5> angle_rows(const MeshImprovementOptions& options) {
    const double target = target_sine(options), bound = options.max_radius_edge;
    return {{
        // Angles. This pass helps nearly all cells, at the lowest price.
        {.target_sine = target, .rule = rule_of(bound, 0)},
        // Last angles. The few cells that nothing else helps are worth vertices on interfaces and moved
        // junctions.
        {.target_sine = target,
         .rule = late_rule_of(bound, 0),
         .operations = thorough_operations,
         .lists_changes = true},
        listed_angles(options, 1),
        listed_angles(options, 2),
        listed_angles(options, ratio_steps),
    }};
}

std::array<ClimbProfile, 4> ratio_and_last_rows(const MeshImprovementOptions& options) {
    const double bound = options.max_radius_edge, last = options.last_radius_edge, listed = listed_sine();
    // Relabelling for a ratio leaves pits in surfaces where the caller says so; cells above the last bound
    // are worth one.
    const double relabels_above = options.relabels_for_ratio ? 0 : last;
    const double relabels_flat_above = options.relabels_for_ratio ? 0 : HUGE_VAL;
    return {{
        // High ratios. The few cells above the last bound are worth angles down to those listed.
        {.target_ratio = last,
         .rule = late_rule_of(last, listed),
         .operations = thorough_operations,
         .relabels_above = relabels_above,
         .revisit = Revisit::bad},
        // Ratios. Cells that contours force must not come of it elsewhere, so the bounds are strict.
        {.target_ratio = bound,
         .rule = strictly(late_rule_of(bound, std::max(target_sine(options), listed)), listed, last),
         .operations = thorough_operations,
         .relabels_above = relabels_above,
         .revisit = Revisit::bad},
        // Blemishes. Clause 4 allows an ill-shaped cell where contours force it: forced cells beside one
        // that is not forced pay for it within their bounds.
        {.target_sine = listed,
         .target_ratio = last,
         .exempt = Exempt::limited,
         .rule = sparing(late_rule_of(last, listed)),
         .operations = thorough_operations,
         .condition = Condition::limited_in_bounds,
         .revisit = Revisit::bad},
        // Flat cells. Two segments that are split alike make flat cells between them; others there are as
        // good as forced cells must be.
        {.target_sine = flat_sine,
         .rule = late_rule_of(most_limited_ratio, 0),
         .relabels_above = relabels_flat_above,
         .condition = Condition::all_good},
    }};
}

}  // namespace

double listed_sine() {
    return std::sin(contract::bad_dihedral_degrees * radians_per_degree);
}

double target_sine(const MeshImprovementOptions& options) {
    return std::sin(options.target_degrees * radians_per_degree);
}

ClimbProfiles::ClimbProfiles(const MeshImprovementOptions& options) {
    auto next = rows_.begin();
    const auto append = [&](const auto& rows) { next = std::copy(rows.begin(), rows.end(), next); };
    append(surgery_rows(options));
    append(angle_rows(options));
    append(ratio_and_last_rows(options));
}

}  // namespace anatomesh
