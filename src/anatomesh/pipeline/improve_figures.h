// improve_figures: what the stage "improve" counted, as the report lists it.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/cut/spurious_components.h"
#include "anatomesh/improve/core/mesh_improvement_options.h"
#include "anatomesh/improve/smooth/balance_volumes.h"
#include "anatomesh/improve/smooth/improve.h"
#include "anatomesh/improve/smooth/smooth_vertices.h"

namespace anatomesh {

// What the steps of the stage returned.
struct ImproveWork {
    const ImproveStats& improved;
    const SmoothStats& smoothed;
    const MeshImprovementStats& dihedrals;
    std::size_t contours_routed;
    const SpuriousComponentStats& spurious;
    const BalanceStats& balanced;
};

// Names and values, in the order of the report. O(1).
std::vector<std::pair<std::string, double>> improve_figures(const ImproveWork& work);

}  // namespace anatomesh
