// Which subsegments are not edges of the tetrahedralization, or not of their structure's
// surface.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/sample/contour_segments.h"

namespace anatomesh {

// Indices of the subsegments that are not edges, in rising order. Their ends are vertices of the cells. A
// subsegment that is missing is split at its middle: the diametral balls of the halves are smaller, and hold
// no other vertex in the end (Shewchuk, Delaunay refinement mesh generation, 1997, chapter 4). Complexity:
// O(cells + subsegments). Same result at any thread count.
std::vector<std::uint32_t> missing_subsegments(const std::vector<Cell>& cells, std::size_t point_count,
                                               const std::vector<Subsegment>& subsegments, int threads = 1);

// The same from round to round, where only some cells change.
class MissingSubsegments {
  public:
    // `look`: the cells new since the last call, at first all of them; subsegments may have gone too, and
    // others have come, with balls of larger numbers than those before. Result: missing_subsegments().
    // Complexity: O(look + subsegments) beside the stars of the ends of subsegments there.
    std::vector<std::uint32_t> find(const DelaunaySnapshot& mesh, std::size_t point_count,
                                    const std::vector<Subsegment>& subsegments,
                                    const std::vector<std::uint32_t>& look, int threads = 1);

  private:
    bool find_changed(const DelaunaySnapshot& mesh, std::size_t point_count,
                      const std::vector<Subsegment>& subsegments, const std::vector<std::uint32_t>& look,
                      int threads, std::vector<std::uint32_t>& missing) const;

    std::vector<std::array<std::uint32_t, 2>> missing_;  // those of the last call, by their ends; sorted
    std::uint32_t balls_ = 0;                            // known then
};

// For each subsegment, whether it is an edge of a cell inside its structure, and of one outside: with both it
// lies on the structure's surface, with neither it is missing.
struct SubsegmentSides {
    std::uint8_t inside : 1, outside : 1;
};
std::vector<SubsegmentSides> subsegment_sides(const std::vector<Cell>& cells,
                                              const std::vector<Region>& regions, const RegionTable& table,
                                              std::size_t point_count,
                                              const std::vector<Subsegment>& subsegments, int threads = 1);

// The same from round to round, where only some cells change.
class SidesOfSubsegments {
  public:
    // `look`, `subsegments` and the result: as for MissingSubsegments, and subsegment_sides(). Requires:
    // cells that stay keep their regions. Complexity: O(look + subsegments log subsegments) beside the stars
    // of the ends of subsegments there.
    std::vector<SubsegmentSides> find(const DelaunaySnapshot& mesh, const std::vector<Region>& regions,
                                      const RegionTable& table, std::size_t point_count,
                                      const std::vector<Subsegment>& subsegments,
                                      const std::vector<std::uint32_t>& look, int threads = 1);

  private:
    // A subsegment by its ball and its structure.
    struct Known {
        std::uint32_t ball, structure;
        SubsegmentSides sides;
        friend bool operator<(const Known& a, const Known& b) {
            return a.ball != b.ball ? a.ball < b.ball : a.structure < b.structure;
        }
    };

    bool find_changed(const DelaunaySnapshot& mesh, const std::vector<Region>& regions,
                      const RegionTable& table, std::size_t point_count,
                      const std::vector<Subsegment>& subsegments, const std::vector<std::uint32_t>& look,
                      int threads, std::vector<SubsegmentSides>& sides) const;

    std::vector<Known> known_;  // since the last call; sorted
};

struct SidePointOptions {
    double min_spacing = 0.15;  // to other points, in lengths of the subsegment. (0, 0.5]
    int directions = 12;        // round the middle of the subsegment, at each of three distances. [4, 64]
};

// For every subsegment with cells on one side of its structure alone, a point beside its middle on the other
// side, as far from it and from the interfaces as there is one: where the field has a gap or a wall that is
// thinner than the cells, its vertex gives the other side a cell there. Appended to `found` in the order of
// the subsegments. Requires: `all_points` holds `points`. Same result at any thread count.
void find_side_points(const std::vector<Vec3>& points, const std::vector<Subsegment>& subsegments,
                      const std::vector<SubsegmentSides>& sides, const StructureField& field,
                      const PointGrid& all_points, const SidePointOptions& options, std::vector<Vec3>& found,
                      RunContext& context);

}  // namespace anatomesh
