// read_guide_points: guide points of a heart (short- and long-axis images of cardiac MR) as contours.
//
// A table of tabs: x, y, z, contour type, sliceID or frameID, weight, time frame; LPS mm. Points of a curve
// stand in no order. SAX_ and LAX_ say the view, what follows the surface; SAX_RV_SEPTUM is a part of both
// the right ventricle's inside and the left ventricle's outside (where it fills a gap in that),
// SAX_RV_FREEWALL of the former. Valves, apex and inserts are markers.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "anatomesh_io/contour/raw_builder.h"

namespace anatomesh {

// Whether `text` begins as such a table does.
bool is_guide_points(std::string_view text);

// The points of a surface in a slice are joined to one curve by the longest way through their minimum
// spanning tree; points beside it are left out and counted. The curve is closed in a short-axis slice, or
// where its ends are no farther apart than four of its steps; else it is open, a long-axis contour at its
// valve, where clean_contours() closes it: if its ends lie at markers of a valve, where the slice has any.
// The septum alone, and on a long axis the free wall alone, is no outline. `time_frame` (--volume): which of
// several. Errors: E-GPT-001 a line without seven fields; E-GPT-002 a value that is no number; E-GPT-003
// several time frames and none chosen, or no such one, with those there are; E-GPT-004 more than 5000 points
// of a surface in a slice (limit). Warnings: W-GPT-001 points beside their curve were left out; W-GPT-002
// points of the septum fill no gap. Requires: an empty builder. Complexity: linear, and quadratic in the
// points of a curve. Follows: Prim 1957.
Status read_guide_points(std::string_view text, std::optional<std::uint64_t> time_frame, RawBuilder& builder);

}  // namespace anatomesh
