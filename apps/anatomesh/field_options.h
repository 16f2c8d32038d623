// How the field between slices and beyond the last one is made: --caps, --max-gap, --slice-thickness.
#pragma once

#include <CLI/CLI.hpp>

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

void add_field_rule_options(CLI::App& verb, FieldOptions& options);

}  // namespace anatomesh
