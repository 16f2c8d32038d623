// What one run of the method carries from step to step: values with names, in the order in which they arise.
//
// The steps work relative to the low corner of the contours' box: far from (0, 0, 0) coordinates are coarse,
// and a model must not depend on where the patient lay.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/cut/relabel.h"
#include "anatomesh/cut/resolve_nonmanifold.h"
#include "anatomesh/cut/spurious_components.h"
#include "anatomesh/field/model/counted_field.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/improve/core/mesh_improvement_options.h"
#include "anatomesh/improve/smooth/balance_volumes.h"
#include "anatomesh/improve/smooth/improve.h"
#include "anatomesh/improve/smooth/smooth_vertices.h"
#include "anatomesh/mesh/model/routed_contour.h"
#include "anatomesh/pipeline/retry/run_config.h"
#include "anatomesh/pipeline/run/effort.h"
#include "anatomesh/recover/recover_segments.h"
#include "anatomesh/refine/contour_subsegments.h"
#include "anatomesh/refine/labelled_mesh.h"
#include "anatomesh/refine/refinement_rounds.h"
#include "anatomesh/refine/section_points.h"
#include "anatomesh/refine/segment_vertices.h"
#include "anatomesh/sample/sample_points.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// What does not depend on the size, so that all runs share it.
struct FieldAndVolumes {
    std::shared_ptr<const SliceFacts> slices;  // of the contours as the steps see them, relative_to()
    std::shared_ptr<const StructureField> field;
    std::vector<StructureVolume> volumes;  // of the field, by structure; empty: not found yet
    std::size_t warnings = 0;              // of the context, when the field was made
};

// After the step "field": what is drawn, and what is known of it.
struct PreparedRun {
    Vec3 origin;                                  // of the coordinates of all steps
    ContourSet contours;                          // relative to it
    FieldAndVolumes known;                        // the volumes from the step "improve" on
    std::shared_ptr<const StructureField> field;  // as the steps ask it
    std::shared_ptr<const CountedField> counted;  // the same, on one thread; else null
    SliceWeights slices;
    std::vector<ContradictedPlace> contradicted;  // where sections are fitted
    Effort effort;
    std::uint32_t structures = 0;

    const SliceArrangement& arrangement() const { return known.slices->arrangement; }
};

// From "delaunay" to "refine": the Delaunay mesh, growing by points. Its parts refer to each other.
struct GrowingMesh {
    // Requires: run and sample outlive this.
    GrowingMesh(Tetrahedralization delaunay, const PreparedRun& run, PointSample& sample);
    GrowingMesh(const GrowingMesh&) = delete;
    GrowingMesh& operator=(const GrowingMesh&) = delete;

    LabelledMesh mesh;
    std::vector<std::uint32_t> contour_vertices;            // of every point of the contours
    std::vector<std::array<std::uint32_t, 2>> owner_pairs;  // of these, with the contour's structure
    std::vector<std::uint8_t> given;                        // by vertex: one of a contour
    ContourSubsegments subsegments;
    std::optional<RefinementRounds> refinement;  // from "refine" on
};

// From "cut" to the model: the mesh without the means to insert points by Delaunay's rule.
struct WorkingMesh {
    TetMesh mesh;
    std::vector<std::uint32_t> neighbors;  // as cell_neighbors() gives them
    RegionTable regions;
    std::vector<Subsegment> subsegments;          // of contour segments
    std::vector<Subsegment> cut_subsegments;      // of those that resolve_nonmanifold() split further
    std::vector<std::uint32_t> segment_vertices;  // where segments were split after sampling
};

struct CutStats {
    RelabelStats relabelled;
    RecoverStats recovered;
    NonmanifoldStats split;
    SpuriousComponentStats spurious;
};

struct ImprovedStats {
    ImproveStats improved;
    SmoothStats smoothed;
    MeshImprovementStats dihedrals;  // without `routed`
    std::size_t contours_routed = 0;
    SpuriousComponentStats spurious;
    BalanceStats balanced;
};

// From "improve" to the model: contours that the surface does not run along as drawn.
struct RoutedRun {
    std::vector<RoutedContour> contours;
    std::uint64_t segments_missed = 0;  // before any was re-routed
    bool has_segments_beside = false;   // some have edges beside them in their place
};

// Points this near to an interface count as on it. [sizes; 0 to 0.1; M 2026-11, set not recorded]
inline constexpr double interface_tolerance = 0.02;

inline SurfaceTolerance tolerance_at_vertices(const Effort& effort, double size_mm) {
    return {interface_tolerance * size_mm, effort.tolerance_of_edge};
}

inline CrossingPlanes crossing_planes(const SliceWeights& slices) {
    return {slices.planes, slices.extents, slices.on_plane_mm};
}

// From the run's coordinates to the caller's.
inline void move_back(Vec3 origin, std::vector<Vec3>& points) {
    for (Vec3& p : points) p = p + origin;
}

// Which structures the surface must have at each vertex of contours and of `subsegments`. O(n log n)
ContourOwners owners_of(const GrowingMesh& growing, const std::vector<Subsegment>& subsegments,
                        std::size_t point_count);

}  // namespace anatomesh
