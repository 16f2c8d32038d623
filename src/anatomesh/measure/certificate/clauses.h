// The six clauses of the certificate, each with its state and its evidence, by what was measured.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/measure/certificate/contour_reports.h"
#include "anatomesh/measure/certificate/listed_cells.h"
#include "anatomesh/mesh/check/validity.h"

namespace anatomesh {

// `all`: of all structures. Warnings of the context that tell of vertices moved by cleaning stand in the evidence.
Clause clause_vertices(const CertificateInput& input, const StructureFidelity& all,
                       const RunContext& context);

// Requires: report.contours as measure_contours() fills it.
Clause clause_segments(const CertificateInput& input, const ContourFindings& findings,
                       const ModelReport& report);

// Requires: report.counts and report.structures.
Clause clause_validity(const MeshCheck& check, const ModelReport& report);

// Requires: report.counts, report.quality and report.listed_cells.
Clause clause_shape(const CertificateInput& input, const ShapeFindings& found, const ModelReport& report);

Clause clause_determinism(const CertificateInput& input);

// Requires: the volumes of report.structures.
Clause clause_volume(const CertificateInput& input, const ModelReport& report);

}  // namespace anatomesh
