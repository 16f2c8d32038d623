// SliceArrangement: how the slices of a set lie, and the charts in which those that lean or turn are parallel.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/paths_of_slices.h"
#include "anatomesh/slices/arrangement/rotation_axis.h"
#include "anatomesh/slices/arrangement/rotational_sweep.h"
#include "anatomesh/slices/arrangement/stack_and_crossing.h"
#include "anatomesh/slices/arrangement/sweep.h"

namespace anatomesh {

// The first in this order that a set is decides which field it gets.
enum class ArrangementKind : std::uint8_t {
    parallel,            // parallel slices, or a single one, or none (parallel_slices.h)
    sweep,               // side by side, neighbours lean a little (sweep.h)
    along_paths,         // across the paths of tubes (paths_of_slices.h)
    about_axis,          // turned about an axis (rotational_sweep.h)
    stack_and_crossing,  // a stack or sweep, and a few slices across it (stack_and_crossing.h)
    general              // planes in any position
};

// How the slices of one set lie. It holds for that set alone: when slices move, are chosen or get another
// origin, arrangement_of() is asked again.
struct SliceArrangement {
    ArrangementKind kind = ArrangementKind::parallel;

    // The chart of a sweep; empty for all other kinds.
    std::optional<Sweep> sweep;
    // The axis nearest to all planes. It means nothing for parallel slices and sweeps.
    Axis axis;
    // The chart about the axis where there is one. Some sweeps have one as well: those of a fan.
    std::optional<RotationalSweep> rotation;
    // The paths that slices follow; empty for all other kinds.
    std::vector<SlicePath> paths;
    // The stack and the slices across it where there are such. Slices about an axis may have them as well.
    std::optional<StackAndCrossing> parts;

    bool is_parallel() const { return kind == ArrangementKind::parallel; }
    bool is_along_paths() const { return kind == ArrangementKind::along_paths; }
    // Whether the slices lie side by side, so that no two of them cross where something is drawn.
    bool is_stack() const { return is_parallel() || kind == ArrangementKind::sweep; }
};

// Gaps of that many usual angles are joined by default: one slice left out is no gap. [usual angles; >= 1; C]
inline constexpr double default_max_gap = 2;

// Says how the slices of a set lie. `max_gap`: usual angles about an axis that are joined, at least 1; it
// changes the chart, but no kind. A set without contours gets its kind alone: parallel, or general.
// Complexity: O(points log slices) for parallel slices, else O(points + slices^2).
SliceArrangement arrangement_of(const ContourSet& set, double max_gap = default_max_gap);

}  // namespace anatomesh
