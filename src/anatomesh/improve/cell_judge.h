// CellJudge: whether cells that a change at the end made are good enough to stay.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "anatomesh/improve/workbench.h"

namespace anatomesh {

// Of cells at vertices that contours crowd: within what the certificate allows there (100, 0.05 degrees).
inline constexpr double most_crowded_ratio = 50, least_crowded_sine = 0.01;

// Improves the shapes of these cells; returns the cells that it made or reshaped, some of which may be gone.
using ImproveCells = std::function<std::vector<std::uint32_t>(std::vector<std::uint32_t>)>;

class CellJudge {
  public:
    // `least_sine`: of cells inside, where contours do not crowd them. Requires: both outlive this.
    CellJudge(Workbench& bench, const DrawnSlices& drawn, double least_sine)
        : bench_(bench), drawn_(drawn), least_sine_(least_sine) {}

    // Whether a cell inside has no angle whose sine is below the least and no ratio above the workbench's
    // last bound; where contours crowd it, the bounds above. Others are.
    bool is_good(std::uint32_t c) const;
    // Whether what of the cell lies on interfaces lies within the workbench's `apex_mm` of the field's.
    bool is_near(std::uint32_t c);
    // Of the cells those inside above the workbench's first bound that contours do not crowd.
    std::vector<std::uint32_t> those_above_bound(std::vector<std::uint32_t> cells) const;

  private:
    Workbench& bench_;
    const DrawnSlices& drawn_;
    double least_sine_;
};

}  // namespace anatomesh
