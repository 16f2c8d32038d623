// SectionAreas: by how much the cuts of cells by the planes of a stack are not what is drawn there.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/parallel_planes.h"
#include "anatomesh/improve/workbench.h"

namespace anatomesh {

// The level of a vertex is that of ParallelPlanes; one that is in a slice as drawn lies in its plane.
class SectionAreas {
  public:
    // Requires: both outlive this; `drawn.planes` not empty.
    SectionAreas(Workbench& bench, const DrawnSlices& drawn);

    std::uint32_t level(std::uint32_t v) const;

    // Of a point over the plane of an odd level; mm.
    double height(std::uint32_t level, Vec3 p) const { return plane(level).signed_distance(p); }

    // Whether a facet or an edge of these levels passes through a plane or lies in it.
    template <std::size_t n>
    static bool meets(const std::array<std::uint32_t, n>& levels) {
        std::uint32_t low = levels[0], high = levels[0];
        for (const std::uint32_t level : levels) {
            low = std::min(low, level);
            high = std::max(high, level);
        }
        return low == high ? low % 2 == 1 : (low + 1) / 2 < high / 2;
    }

    // Areas of what is in a cut and not drawn, or drawn and not in it, as shares of what is drawn, summed
    // over structures and planes: of the cells' sections, and of their facets in planes, which belong to both
    // sides.
    double wrong(std::span<const std::uint32_t> cells);
    // The same of a vertex's star, without the facets that do not have it.
    double wrong_round(std::uint32_t v, std::span<const std::uint32_t> star);
    // Of the sections of the two cells at a facet, and of the facet.
    double wrong_at(std::uint32_t cell, int facet);
    // Of the facet alone, 0 where it lies in no plane.
    double wrong_in_plane(std::uint32_t cell, int facet);
    double wrong_facet(Vec3 a, Vec3 b, Vec3 c, std::uint32_t level, Region here, Region there);

    // Sums what is wrong by cuts, of structures by planes. Requires: of each facet in a plane that is wrong
    // both cells.
    void sum_cuts(std::span<const std::uint32_t> cells);
    // Of those that wrong_at() is about the largest sum.
    double largest_cut_at(std::uint32_t cell, int facet);

  private:
    const Plane& plane(std::uint32_t level) const { return drawn_.planes[order_[level / 2]]; }
    double wrong_sections(std::uint32_t cell);
    double wrong_part(double area, Region here, Region there, std::uint32_t level, Vec3 p);

    Workbench& bench_;
    const DrawnSlices& drawn_;
    std::vector<std::uint32_t> order_;  // of the planes, rising
    ParallelPlanes stack_;              // in that order, over (0, 0, 0)
    std::vector<std::uint32_t> rank_;   // of each plane
    std::vector<double> of_cuts_;       // by structure and slice
    bool counts_ = false;               // into these
    double share_ = 1, largest_ = 0;    // of a part that counts; of the cuts seen
    std::vector<std::uint32_t> both_;
};

}  // namespace anatomesh
