// Charts of the report as inline SVG.
#pragma once

#include <string>

#include "anatomesh/measure/report.h"

namespace anatomesh {

struct ChartOptions {
    double bound = 0;       // a dashed line; bars beyond it on the bad side are marked
    bool bad_above = true;  // false: below the bound is bad
    double tick = 1;        // between the labels of the horizontal axis
    int tick_decimals = 0;
    const char* label = "";  // of the horizontal axis; trusted
};

// Bars of a histogram; the vertical axis counts tetrahedra.
std::string histogram_svg(const Histogram& histogram, const ChartOptions& options);

}  // namespace anatomesh
