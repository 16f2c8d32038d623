// How the field between slices and beyond the last one is made: --caps, --max-gap, --slice-thickness.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

struct FieldRuleOptions {
    std::string caps = "half";
    double max_gap_spacings = FieldOptions{}.max_gap_spacings;
    double slice_thickness_mm = 0;  // 0: not stated

    FieldOptions field() const;
};

void add_field_rule_options(CLI::App& verb, FieldRuleOptions& options);

}  // namespace anatomesh
