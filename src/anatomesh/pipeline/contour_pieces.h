// ContourPieces: the pieces of contour segments in a growing mesh, split until they are edges of it.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/field/structure_field.h"
#include "anatomesh/pipeline/labelled_mesh.h"
#include "anatomesh/refine/missing_segments.h"
#include "anatomesh/sample/contour_segments.h"
#include "anatomesh/sample/segment_guard.h"

namespace anatomesh {

struct ContourPieceOptions {
    double size_mm = 0;  // the edge length aimed at: pieces are split to 0.3 of it, the last few further. > 0
    bool dense = false;  // the planes lie closer than the contours' vertices: the last few are left
};

// Every insertion into the mesh goes through it, since a point beside a piece may ask for its split. A piece
// is not split where another contour's vertex lies near its middle: that contour would have to be split in
// its turn, and so on. Pieces that meet at acute angles are split on concentric shells. Same result at any
// number of threads. Errors of all that inserts: cancelled; limit E-PIP-003, more regions than there is room
// for. Follows: Shewchuk, Delaunay refinement mesh generation, 1997, chapter 3.
class ContourPieces {
  public:
    // `pieces` between vertices of the mesh. Requires: mesh, guard and field outlive this.
    ContourPieces(LabelledMesh& mesh, SegmentGuard& guard, const StructureField& field,
                  std::vector<SegmentPiece> pieces, const ContourPieceOptions& options);

    // Inserts the points, and splits the pieces with these diametral balls (rising) that may be. With a scale
    // below 1 shorter pieces may, and nearer to other contours. Complexity: that of the insertions, and
    // linear in the pieces.
    Status grow(std::vector<Vec3> found, const std::vector<std::uint32_t>& balls, RunContext& context,
                double scale = 1);

    // Splits pieces that are no edges until all are, or, with a share above 0, fewer than one in so many is
    // missing. With a scale below 1: as long as fewer are missing from round to round, and not where many
    // are, which lie too close beside each other.
    Status recover(std::size_t share, RunContext& context, double scale = 1);

    // The last few: pieces that only shorter ones resolve, and pieces that are edges off their structure's
    // surface.
    Status finish(RunContext& context);

    // Puts points beside the pieces that are edges off their structure's surface, whose ends are appended to
    // `ends`. Says whether there were any.
    Result<bool> open_sides(RunContext& context, std::vector<std::uint32_t>* ends = nullptr);

    const std::vector<SegmentPiece>& pieces() const { return pieces_; }
    const std::vector<std::uint32_t>& vertices() const { return vertices_; }  // where pieces were split here
    std::size_t side_points() const {
        return side_points_;
    }  // put beside pieces off their structure's surface

  private:
    Vec3 split_point(const SegmentPiece& piece) const;
    void add_halves(const std::vector<SegmentPiece>& split, const std::vector<std::uint32_t>& middles);
    bool may_split(const SegmentPiece& piece, double scale) const;

    LabelledMesh& mesh_;
    SegmentGuard& guard_;
    const StructureField& field_;
    ContourPieceOptions options_;
    std::vector<SegmentPiece> pieces_;
    std::vector<std::uint32_t> acute_;  // vertices where some of them meet at acute angles; rising
    MissingPieces missing_;             // of them
    CellSearch search_;                 // the cells that missing_ has not seen
    std::vector<std::uint32_t> vertices_;
    std::size_t side_points_ = 0;
};

// Error limit E-PIP-003 where the mesh has as many regions as there is room for.
Status check_region_count(LabelledMesh& mesh);

}  // namespace anatomesh
