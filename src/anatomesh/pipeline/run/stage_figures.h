// stage_figures: what each step of a run counted, as the report lists it.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/pipeline/run/run_state.h"

namespace anatomesh {

// Names and values, in the order of the report.
using StageFigures = std::vector<std::pair<std::string, double>>;

StageFigures sample_figures(const SampleStats& stats);
StageFigures cull_figures(std::uint64_t cells, const CullStats& stats);
StageFigures refine_figures(const RefinementStats& stats, const ContourSubsegments& subsegments);
StageFigures cut_figures(const CutStats& stats);
StageFigures improve_figures(const ImprovedStats& stats);

}  // namespace anatomesh
