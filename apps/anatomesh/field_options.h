// How the field between slices and beyond the last one is made: --caps, --max-gap, --slice-thickness.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

void add_field_rule_options(CLI::App& verb, FieldOptions& options);

// --slice-thickness alone, and whether it applies: usage E-CMD-008 when there are several slices.
void add_slice_thickness_option(CLI::App& verb, double& slice_mm);
Status check_slice_thickness(double slice_mm, const std::string& input, const ContourSet& kept);

}  // namespace anatomesh
