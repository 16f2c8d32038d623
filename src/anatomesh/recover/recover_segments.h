// recover_segments: subsegments that no Delaunay cell has as an edge become edges, by exchanging cells.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/recover/cavity.h"
#include "anatomesh/sample/contour_segments.h"

namespace anatomesh {

struct RecoverOptions {
    // Of the cells made, as in cavity.h; a subsegment that asks for worse ones is left. (0, 1]
    double least_shape = 0.2;
    int most_splits = 5;         // of a subsegment, and of its halves, that is not recovered at once. [0, 20]
    int passes = 4;              // over the subsegments that are missing. [1, 100]
    int threads = 1;             // to find those with
    std::vector<MeshEdge> left;  // missing subsegments that are not to be tried; rising
};

struct RecoverStats {
    std::uint64_t missing_before = 0, missing_after = 0;  // edges
    std::uint64_t without_vertex = 0;                     // recovered by an exchange of cells alone
    std::uint64_t vertices_added = 0, vertices_dropped = 0;
};

struct RecoverResult {
    RecoverStats stats;
    std::vector<std::uint32_t> vertices;   // added; all lie on subsegments
    std::vector<std::uint32_t> undecided;  // cells that are new, rising: in undecided_region (cavity.h)
    std::vector<MeshEdge> made_for;        // for each of these the missing subsegment that it was made for
};

// The cells that a missing subsegment passes through are taken out, and more where the rest does not see the
// point or makes bad cells; the hole is filled from one of its ends, which makes the subsegment an edge, or
// from a new vertex on the subsegment, which makes both halves edges. Free vertices near the subsegment may
// go with the cells at them where that makes better ones. Of all these the way with the best worst cell is
// taken. Where none is good enough, the subsegment gets a vertex, and its halves are tried (up to most_splits
// times). `subsegments` become their halves. `fixed`: by vertex, those that must stay besides the ends of
// subsegments. Guarantees: cells positive (exactly) and neighbors theirs; the same domain; subsegments that
// were edges are, vertices that are fixed or ends of subsegments stay where they are. Points that went stay
// in mesh.points, without cells. The same result every time. Complexity: O(cells + subsegments log
// subsegments) beside the subsegments that are missing, some ms each. Follows: George, Hecht and Saltel,
// Automatic mesh generator with specified boundary, Comput. Methods Appl. Mech. Eng. 92, 1991; Weatherill and
// Hassan, Int. J. Numer. Methods Eng. 37, 1994; Si, TetGen, ACM Trans. Math. Softw. 41, 2015.
RecoverResult recover_segments(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                               std::vector<Subsegment>& subsegments, const std::vector<std::uint8_t>& fixed,
                               const RecoverOptions& options);

}  // namespace anatomesh
