// How the field between slices and beyond the last one is made: --caps, --max-gap, --slice-thickness.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

void add_field_rule_options(CLI::App& verb, FieldOptions& options);

// --slice-thickness alone. `of_what`: what it is the thickness of, without a full stop.
void add_slice_thickness_option(CLI::App& verb, double& slice_mm, const std::string& of_what);
// Usage E-CMD-008: the option is given and has no use. `why`: a clause.
Error slice_thickness_without_use(const std::string& input, const std::string& why);
// That error where the set has several slices, and no structure on so few that they show no thickness.
Status check_slice_thickness(double slice_mm, const std::string& input, const ContourSet& kept);

}  // namespace anatomesh
