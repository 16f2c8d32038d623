// StarRatios: the radius-edge ratios of the cells round a vertex, as a function of its place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "anatomesh/geom/vec.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// The star of a vertex made ready for trying many places. Each cell is kept as its facet opposite to the
// vertex: the circumcentre lies on the axis of the facet, t above the facet's own, and its squared radius is
// t^2 more than the facet's. Places are given as movements from where the vertex is, in mean edges. In single
// precision, several cells at a time; the same results on every machine. Allocates nothing.
class StarRatios {
  public:
    static constexpr std::size_t most_cells = 96;  // a larger star is not held [cells; > 0; B]

    // Requires: at most most_cells cells in the star; v is a vertex of all of them.
    StarRatios(const TetMesh& mesh, std::span<const std::uint32_t> star, std::uint32_t v);

    double mean_edge() const { return mean_edge_; }  // from the vertex to those beside it inside; 0 without

    // The sum of the ratios of the cells inside, to five figures; infinite where one of them is not positive.
    double sum(Vec3 move) const;

    // The sum and its gradient, where all of them are positive.
    double sum(Vec3 move, Vec3& gradient) const;

    // What VertexMover says of the movement: good if all cells are positive and none nearly flat (six volumes
    // below 0.001 of the cube of the longest edge), no ratio inside is above both max_ratio and the worst
    // before, and no sine of a dihedral angle inside below both min_sine and the least before. `unsure` where
    // it is a close thing or a cell is nearly flat.
    enum class Verdict : std::uint8_t { good, bad, unsure };
    Verdict judge(Vec3 move, double max_ratio, double min_sine) const;

  private:
    static constexpr std::size_t lanes = 4;  // cells that are worked on at a time [cells; > 0; D]
    using Row = std::array<float, most_cells + lanes>;
    struct Rows {  // a vector to a cell
        Row x, y, z;
    };

    struct Worst {
        float squared_ratio, flattest, squared_sine;  // ratio and sine of those inside
    };

    Worst worst(Vec3 move) const;
    void add(std::size_t n, const TetMesh& mesh, std::uint32_t cell, std::uint32_t v);
    void prepare();
    void fill_up(std::size_t first, std::size_t last);

    // Cells inside are numbered from 0 to `inside`, filled up to whole lanes; those outside from `outside` to
    // `end`.
    struct {
        std::size_t inside = 0, outside = 0, end = 0;
    } count_;
    double mean_edge_ = 0;
    Rows p_, q_, r_, center_, normal_;  // the facet; its normal of length 1 looks to the vertex
    Row height_;                        // of the vertex above the facet where it is
    Row squared_radius_, squared_shortest_, squared_longest_, twice_area_;
};

}  // namespace anatomesh
