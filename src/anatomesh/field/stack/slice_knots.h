// Where a structure is known along the common normal of parallel slices: on its slices, and as empty beyond
// its ends.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"

namespace anatomesh {

// A position at which a structure is known: the region drawn on `slice`, or nothing (no_slice or not drawn
// there).
struct SliceKnot {
    double low = 0, high = 0;
    std::uint32_t slice = no_slice;
    // It stands for no slice. [index; 2^32 - 1; D]
    static constexpr std::uint32_t no_slice = 0xFFFFFFFFu;
};

// Between two slices that tell of a structure, along the normal; the slices by their index in the set.
struct SliceGap {
    double low = 0, high = 0;
    std::uint32_t below = 0, above = 0;
};

// The knots of a structure, rising; between two neighbours it is interpolated, before the first and after
// the last it is empty. Where a gap is not bridged, two empty knots stand in it.
struct StructureKnots {
    std::vector<SliceKnot> knots;
    // Flat ends: part i lives in [flat[i].low, flat[i].high] only (infinite where it ends half a slice
    // beyond), and the parts divide the axis at flat[i].until.
    struct Extent {
        double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
        double until = std::numeric_limits<double>::infinity();
    };
    std::vector<Extent> flat;
    bool flat_island = false;  // a part of one slice that got half ends although flat ones were asked
    // For warnings; gaps_by_groups: joined only since slices count in groups.
    std::vector<SliceGap> open_gaps, bridged_gaps, gaps_by_groups;
    std::vector<std::uint32_t> not_drawn;  // slices between its first and last on which it is empty
    std::vector<std::uint32_t> unknown;    // those between them that say nothing about it
};

// From the first slice of a part of a structure to its last, and how far the empty knots are from these.
struct StructurePart {
    double low = 0, high = 0;
    double below = 0, above = 0;
};

// What else tells whether a structure goes on through a gap.
struct GapEvidence {
    // Rising heights of slices of its own that `--without` left out; a gap that they part into usual ones is bridged.
    std::vector<double> left_out;
    // Of the drawn ones, rising: those that got their outlines from the others (outlines_between.h). They
    // part no gap, and so make no other one wide.
    std::vector<std::uint32_t> interpolated;
    // Of structures that exclude each other: where the parts of all reach. One that ends where others go on
    // does so half-way to the next slice; those that begin or end with one slice do so equally far from it,
    // as far as the nearest of them. All of them together (`of_all`) go on where one does.
    std::vector<StructurePart> parts;
    bool of_all = false;
    // How thick a slice is of a structure that too few slices draw to show a spacing (few_slices.h): so far do its
    // ends reach, and by it its one gap is wide. 0: its own gap, or the set's spacing.
    double thickness = 0;
};

// Knots of a structure drawn on the slices intervals[drawn[..]] (rising, at least one).
// `every_slice`: each slice of the set says something about it (label maps). Otherwise those between its own
// that covering_slices() names. `spacing`: of the set, for a structure whose own spacing cannot be told.
StructureKnots structure_knots(const std::vector<SliceInterval>& intervals,
                               const std::vector<std::uint32_t>& drawn, bool every_slice, double spacing,
                               const FieldOptions& options, const GapEvidence& evidence = {});

// Returns how thick a slice that draws it is in the mean: half-way to the knots beside it.
double mean_thickness(const StructureKnots& knots);

// Returns the parts between gaps that are not bridged.
std::vector<StructurePart> parts_of(const StructureKnots& knots);

}  // namespace anatomesh
