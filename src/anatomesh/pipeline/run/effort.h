// Effort: what one run of the method does for contours and for the shape of cells, and what it leaves out.
//
// Work that most inputs do not need is not done for all. How the slices lie, how dense their planes are, and
// what came of the runs before decide it once, in one table (effort.cpp); every stage gets its part as a value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/pipeline/retry/run_config.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

enum class PlaneDensity : std::uint8_t {
    sparse,
    dense,             // planes lie closer than two thirds of the spacing of the contours' vertices
    dense_about_axis,  // the same, of many vertices, where all planes come together at an axis
    crammed            // so close, or so many, that all that can be done would take several times as long
};

// Which cross-sections by the slices' planes improvement makes what is drawn there.
enum class SectionRepair : std::uint8_t {
    none,
    worst_at_last,  // those that differ by more than the contract allows, after all else
    all
};

// The middle of an interface facet lies at most so far from the interface. [sizes; > 0; M 2026-11, set not recorded]
inline constexpr double surface_deviation = 0.06;

// A surface so high over the field's is a spike. [sizes; > 0; M 2026-11 skull, its CSL, fetal brain, pelvis, spine, 61 labels]
inline constexpr double spike_height = 0.35;

// Lengths "in sizes" are shares of the edge length aimed at.
struct RefinementEffort {
    double deviation_sizes = surface_deviation;  // > 0
    double crowded_sizes = 0;    // contour vertices nearer to each other may spoil cells. >= 0
    bool to_short = true;        // ContourSubsegmentOptions::to_short
    std::size_t last_few = 300;  // ContourSubsegmentOptions::last_few. >= 1
};

// Of segments that the Delaunay mesh does not have: see RecoveryOptions.
struct RecoveryEffort {
    double most_more_bad = 0;
    double least_shape = 0;
    std::size_t few_missing = 0;
};

// After so many runs that were ill-shaped, segments are not recovered. [runs; > 0; D one for each row of effort.cpp]
inline constexpr std::size_t runs_without_recovery = 3;

struct ImprovementEffort {
    SectionRepair sections = SectionRepair::all;
    // More of the subsegments than this share are not brought onto the surface. 0 to 1
    double most_off_surface = 1;
    double least_spike_sizes = spike_height;  // MeshImprovementOptions::least_spike_mm. > 0
    bool relabels_for_ratio = false;          // MeshImprovementOptions::relabels_for_ratio
    bool closes_handles = false;              // those that no contour shows are looked for
    double most_rerouted_sizes = 0;  // a contour segment leaves its place by no more, on the surface. >= 0
    double most_snapped_sizes = 0;   // the same, over edges beside it. >= 0
};

struct Effort {
    // As SliceArrangement has it; slices about an axis that have a stack count as stack_and_crossing.
    ArrangementKind arrangement = ArrangementKind::parallel;
    PlaneDensity density = PlaneDensity::sparse;
    double plane_density = 0;  // plane_density()

    bool reduced = false;        // shapes of cells and single segments stay as they come first
    bool conforming = false;     // SampleOptions::conforming
    bool fits_sections = false;  // cells are refined and relabelled to what is drawn on planes that cross
    bool losses_wait = true;     // RelabelOptions::losses_wait
    double growth = 0.5;         // SampleOptions::growth

    // What counts as on an interface where contours come near to each other: a share of the shortest edge
    // at a vertex (SurfaceTolerance), and RelabelOptions::near_mm in sizes.
    double tolerance_of_edge = 0;
    double near_sizes = 0;

    RefinementEffort refinement;
    std::optional<RecoveryEffort> recovery;  // none: segments are not recovered by exchanging cells
    ImprovementEffort improvement;

    bool is_parallel() const { return arrangement == ArrangementKind::parallel; }
    // No two planes cross where something is drawn.
    bool is_apart() const {
        return is_parallel() || arrangement == ArrangementKind::sweep ||
               arrangement == ArrangementKind::along_paths;
    }
    bool is_dense() const { return density != PlaneDensity::sparse; }
    // Planes are dense, and all the same is done that is done anywhere.
    bool is_dense_in_full() const { return is_dense() && density != PlaneDensity::crammed; }
};

// Requires: a kept contour set, its arrangement and its field. O(points)
Effort effort_of(const ContourSet& contours, const SliceArrangement& arrangement, const StructureField& field,
                 const RunConfig& config);

// The effort where contours of four planes or more meet in one vertex, which the sampling finds
// (PointSample::has_pole).
Effort effort_at_pole(Effort effort);

}  // namespace anatomesh
