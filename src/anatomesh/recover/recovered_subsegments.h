// RecoveredSubsegments: subsegments that the Delaunay mesh does not have as edges of their structure's
// surface, made such by exchanging cells.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/cull/cull.h"
#include "anatomesh/cut/relabel.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/recover/recover_segments.h"
#include "anatomesh/refine/labelled_mesh.h"
#include "anatomesh/sample/contour_segments.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

// What is drawn, and where it is in the mesh.
struct DrawnInMesh {
    const ContourSet& contours;
    const SliceArrangement& arrangement;                      // of their slices
    std::vector<std::uint32_t> vertex_of;                     // by point of the contours
    const std::vector<std::array<std::uint32_t, 2>>& owners;  // as ContourOwners wants them
    std::vector<Subsegment> subsegments;
    std::vector<std::uint8_t> held;  // by vertex: must stay, besides ends of subsegments
};

struct RecoveryOptions {
    double size_mm = 0;          // the edge length aimed at. > 0
    SurfaceTolerance tolerance;  // as of the cells so far
    double max_radius_edge = 2;  // as in RefineOptions
    double most_more_bad =
        0.003;  // cells above it that nothing forces may become more by so many of those inside. [0, 1]
    // Of cells, as in cavity.h: subsegments that ask for worse ones are left. [0, 1]
    double least_shape = 0;
    // So many may have the worst shapes, whatever part of the subsegments they are.
    std::size_t few_missing = 0;
    double near_mm = 0;       // as in RelabelOptions
    bool losses_wait = true;  // the same
};

// After the first relabelling. Subsegments that are no edges become edges (recover_segments()), those that
// leave the best cells first, as long as cells above the bound stay few, of those that the contours do not
// force above all: subsegments that cost too many are left, and the others tried again, a few times; then
// those that are off their surface get vertices beside them (find_side_points()). New cells get their regions
// as others do (cull()), and are relabelled. Same result at any number of threads.
class RecoveredSubsegments {
  public:
    // `mesh`: the cells of `delaunay` with their regions, `neighbors` theirs. Requires: all outlive this.
    RecoveredSubsegments(TetMesh& mesh, std::vector<std::uint32_t>& neighbors, LabelledMesh& delaunay,
                         const StructureField& field, DrawnInMesh drawn, const RecoveryOptions& options);

    // `nonmanifold`, `relabelled`: of the relabelling before, then of the last one.
    void run(std::vector<std::uint32_t>& nonmanifold, RelabelStats& relabelled, RunContext& context);

    const std::vector<Subsegment>& subsegments() const { return drawn_.subsegments; }
    // Where subsegments were split here.
    const std::vector<std::uint32_t>& vertices() const { return vertices_; }
    const RecoverStats& stats() const { return stats_; }

  private:
    void recover(std::vector<std::uint32_t>& look, RunContext& context);
    // Of the cells inside those above the bound that nothing is known to force, of these those above that of
    // clause 4 for single ones, and those that the contours force.
    struct BadCells {
        std::vector<std::uint32_t> unforced, far, forced;
        std::size_t inside = 0;
    };
    BadCells find_bad(int threads) const;
    // Of some of them by how many they are more than they may be; above 0: too many.
    struct Excess {
        const std::vector<std::uint32_t>* cells;
        double count;
    };
    std::array<Excess, 3> excesses(const BadCells& bad, const BadCells& before) const;
    bool is_too_bad(const BadCells& bad, const BadCells& before) const;
    std::vector<MeshEdge> too_dear(const BadCells& bad, const BadCells& before,
                                   const RecoverResult& recovered) const;
    bool open_sides(std::vector<std::uint32_t>& look, RunContext& context);
    void decide(const std::vector<std::uint32_t>& undecided, std::vector<std::uint32_t>& look,
                RunContext& context);
    void relabel_at(std::vector<std::uint32_t>& look, std::vector<std::uint32_t>& nonmanifold,
                    RelabelStats& relabelled, RunContext& context);

    TetMesh& mesh_;
    std::vector<std::uint32_t>& neighbors_;
    RegionRegistry& registry_;
    const StructureField& field_;
    DrawnInMesh drawn_;
    RecoveryOptions options_;
    std::uint32_t structures_;
    std::vector<VertexMembership> memberships_;  // by vertex
    std::vector<std::uint32_t> vertices_;
    RecoverStats stats_;
};

}  // namespace anatomesh
