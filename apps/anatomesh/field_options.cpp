#include "field_options.h"

#include "option_values.h"

namespace anatomesh {

FieldOptions FieldRuleOptions::field() const {
    FieldOptions field;
    field.caps = caps == "flat" ? EndCaps::flat : caps == "rounded" ? EndCaps::rounded : EndCaps::half;
    field.max_gap_spacings = max_gap_spacings;
    field.single_slice_mm = slice_thickness_mm;
    return field;
}

void add_field_rule_options(CLI::App& verb, FieldRuleOptions& options) {
    add_choice(verb, "--caps", options.caps, {"half", "flat", "rounded"},
               "Where a structure ends beyond its last contour: half a slice further (default), at it, or "
               "half a slice further with a rounded rim");
    add_number(
        verb, "--max-gap", options.max_gap_spacings, 1, 1e6, "SPACINGS",
        "Join contours of a structure over a gap of up to so many slice spacings, 1 to 1000000 (default 2)");
    add_number(verb, "--slice-thickness", options.slice_thickness_mm, 0.001, 1000, "MM",
               "How thick a slice is when there is only one, 0.001 to 1000");
}

}  // namespace anatomesh
