// What a person wants to read about a model after it was made or checked: a few lines.
#pragma once

#include <string>

#include "anatomesh/measure/report.h"

namespace anatomesh {

// Counts, structures and quality, one line each.
std::string report_summary(const ModelReport& report);

// The certificate in one line: which clauses are in which state.
std::string certificate_line(const ModelReport& report);

// Every clause with its state and what was measured.
std::string certificate_text(const ModelReport& report);

}  // namespace anatomesh
