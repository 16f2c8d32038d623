// check_model: the certificate of a model that was made before, with all that its user should hear of it.
#pragma once

#include <string>

#include "anatomesh/base/run_context.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/mid_nodes.h"

namespace anatomesh {

struct CheckModelOptions {
    double size_mm = 0;                     // the edge length that the model was made with. mm; 0: not known
    const MidNodes* mid_nodes = nullptr;    // of quadratic elements; null or empty: linear ones
    std::string contours_file, model_file;  // what warnings name
};

// Measures the model by measure_model(), then warns of what was measured (model_warnings.h), with contours of
// surfaces that are joined otherwise than drawn (topology_warnings.h), and of quadratic elements that may be
// folded. Fills of the report what measure_model() fills, and size_mm. Requires: as measure_model(). Warnings:
// W-PIP-003 to W-PIP-015; W-ELM-002 elements whose Jacobian may not be positive everywhere. Guarantees: the same
// at any thread count. Complexity: that of measure_model() and check_topology().
void check_model(const CertificateInput& model, const CheckModelOptions& options, RunContext& context,
                 ModelReport& report);

}  // namespace anatomesh
