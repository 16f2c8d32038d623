// RefinementRounds: the mesh refined between contours, round by round, until its cells are fit to be cut.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/refine/contour_subsegments.h"
#include "anatomesh/refine/labelled_mesh.h"
#include "anatomesh/refine/refine.h"
#include "anatomesh/refine/section_points.h"
#include "anatomesh/sample/protected_segments.h"

namespace anatomesh {

struct RefinementOptions {
    double size_mm = 0;          // the edge length aimed at. > 0
    double max_radius_edge = 2;  // as in RefineOptions, and crowded_mm
    double crowded_mm = 0;
    double max_deviation_mm = 0;  // as in DeviationOptions. > 0
    bool spared =
        false;  // fewer rounds for what lies between the contours; what they crowd is met beside them
    // Subsegments were split beforehand as far as other contours ask, and are further.
    bool conforming = false;
    bool graded = false;  // they were in their slices alone
    // Where the mean ratio of the cells inside, each at most the bound, is above this after the rounds for
    // their shape, further ones go on with lower bounds. What follows takes a twentieth off. [0.9, 2]
    double target_mean_ratio = 1;
    CrossedSlices slices;  // whose planes cross; or none
};

struct RefinementStats {
    // Points inserted: where edges cross an interface, at facets off it, where cross-sections are wrong, for the shape of
    // cells (those that were moved onto an interface by themselves).
    std::uint64_t crossing_points = 0, deviation_points = 0, section_points = 0, circumcenters = 0,
                  surface_points = 0;
    double radius_edge_mean_before = 0;  // of the cells inside, before the rounds for their shape
};

// Each round searches the cells that changed since its last one (refine.h) and inserts by way of
// ContourSubsegments, which splits the subsegments that points come too near to. Same result at any number
// of threads. Errors: those of ContourSubsegments::grow().
class RefinementRounds {
  public:
    // `given`: by vertex, as in RefineOptions. Requires: all outlive this.
    RefinementRounds(LabelledMesh& mesh, ContourSubsegments& subsegments,
                     const ProtectedSegments& protected_segments, std::span<const std::uint8_t> given,
                     const RefinementOptions& options);

    // First the surface: points where edges cross an interface, then where facets deviate from it. Then the
    // shape of cells, with bounds below the given one where their mean is above 1, and, up to three times, the
    // cross-sections by planes that cross, the subsegments that are still no edges (ContourSubsegments::finish()), and
    // the shapes that these spoiled. Every loop ends after a bounded
    // number of rounds, the longer ones when next to nothing is left.
    Status run(RunContext& context);

    // A few more rounds for the shape of the cells that the search has not seen: points put beside
    // subsegments later on, far nearer to them than the size asks for, leave long ones.
    Status refine_changed(CellSearch search, RunContext& context);

    const RefinementStats& stats() const { return stats_; }

  private:
    Status meet_crossings(const CrossingOptions& options, RunContext& context);
    Status meet_deviations(RunContext& context);
    // Whether there were cross-sections to meet.
    Result<bool> meet_sections(const CrossingOptions& options, RunContext& context);
    Status improve_shapes(RunContext& context);
    Status mend_shapes(CellSearch& search, bool finishing, RunContext& context);
    Status even_shapes(RunContext& context);
    RefineStats find_shape_points(double bound, double protected_share, CellSearch& search,
                                  std::vector<Vec3>& found, RunContext& context) const;
    OccupiedSpace occupied() const { return {mesh_.grid(), protected_segments_}; }
    int rounds_in_small_meshes(int otherwise) const;
    bool not_worth_a_round(std::size_t count, std::size_t share) const;

    LabelledMesh& mesh_;
    ContourSubsegments& subsegments_;
    const ProtectedSegments& protected_segments_;
    const std::span<const std::uint8_t> given_;
    const RefinementOptions options_;
    CellSearch crossings_, sections_, shapes_;
    RefinementStats stats_;
};

}  // namespace anatomesh
