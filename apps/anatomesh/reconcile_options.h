// How slices that cross are made to agree: --max-disagreement, --reconcile, --align.
#pragma once

#include <CLI/CLI.hpp>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/contour_set.h"
#include "input_options.h"

namespace anatomesh {

// Into options.prepare.reconcile; what was given is noted in options.reconcile_given.
void add_reconcile_options(CLI::App& verb, InputOptions& options);

// Error: usage E-CMD-008 one of these options was given and the slices are parallel, so that none cross.
Status check_reconcile_options(const ContourSet& kept, const InputOptions& options);

}  // namespace anatomesh
