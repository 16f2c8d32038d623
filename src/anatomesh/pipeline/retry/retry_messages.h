// What is said of models that are built again.
#pragma once

#include <string>

#include "anatomesh/base/run_context.h"
#include "anatomesh/pipeline/retry/retry_policy.h"

namespace anatomesh {

// Of a model that is built again, W-PIP-001: why, and with what edge length. `error`: its message where there
// is no model, else empty. Requires: next is not none.
Warning built_again(NextRun next, const RunOutcome& outcome, const std::string& error, double size_mm);

// What is tried next and for what sake.
std::string sought_by(NextRun next, const RunOutcome& outcome);

}  // namespace anatomesh
