// SectionAreas: by how much the cuts of cells by the planes of slices are not what is drawn there.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/geom/parallel_planes.h"
#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// Share of what is drawn of a structure in a slice that may be wrong in the cut. [1; 0 to 1; C]
inline constexpr double most_of_cut = 1e-3;
// From this share on a cut is so near to it that it is worth worse cells.
// [1; 0 to most_of_cut; M 2026-11 61 labels, spine, pelvis]
inline constexpr double much_of_cut = 7e-4;

// Planes have the numbers of their slices. A vertex that is in a slice as drawn lies in its plane.
class SectionAreas {
  public:
    // Requires: both outlive this; `drawn.planes` not empty.
    SectionAreas(EditContext& edit, const DrawnSlices& drawn);

    const Plane& plane(std::uint32_t k) const { return drawn_.planes[k]; }
    // Of a vertex: 0 in the plane, 1 over it, -1 under it.
    int side(std::uint32_t v, std::uint32_t k) const;

    // The planes that some of these vertices lie in, or that not all lie on the same side of: `visit` of the
    // number, until that says true. Whether one did. O(log planes) where they are parallel, else O(planes).
    template <class Visit>
    bool any_plane_at(std::span<const std::uint32_t> vertices, const Visit& visit) const {
        if (!stack_) {
            const Reach reach = reach_of(vertices);
            for (std::uint32_t k = 0; k < drawn_.planes.size(); ++k) {
                if (is_beyond(k, reach, vertices)) continue;
                const int first = side(vertices[0], k);
                const bool passes = first == 0 || std::any_of(vertices.begin() + 1, vertices.end(),
                                                              [&](auto v) { return side(v, k) != first; });
                if (passes && visit(k)) return true;
            }
            return false;
        }
        const LevelRange range = levels_of(vertices);
        for (std::uint32_t n = range.low / 2; 2 * n + 1 <= range.high; ++n) {
            if (visit(order_[n])) return true;
        }
        return false;
    }

    // Whether one passes between these vertices, some on either side.
    bool passes_between(std::span<const std::uint32_t> vertices) const;
    // The plane that they all lie in, or no_slice.
    std::uint32_t plane_of(std::span<const std::uint32_t> vertices) const;

    // Areas of what is in a cut and not drawn, or drawn and not in it, as shares of what is drawn, summed
    // over structures and planes: of the cells' sections, and of their facets in planes, which belong to both
    // sides.
    double wrong(std::span<const std::uint32_t> cells);
    // The same of a vertex's star, without the facets that do not have it; of all planes, or of one.
    double wrong_round(std::uint32_t v, std::span<const std::uint32_t> star);
    double wrong_round(std::uint32_t v, std::span<const std::uint32_t> star, std::uint32_t plane);
    // Of the sections of the two cells at a facet, and of the facet.
    double wrong_at(std::uint32_t cell, int facet);
    // Of the facet alone, 0 where it lies in no plane.
    double wrong_in_plane(std::uint32_t cell, int facet);
    double wrong_facet(Vec3 a, Vec3 b, Vec3 c, std::uint32_t plane, Region here, Region there);

    // A section of a cell by a plane, or, with a facet below 4, a facet in it.
    struct Section {
        std::uint32_t cell;
        int facet;
        double share;  // of what is drawn
        Vec3 middle;
    };
    // Of some cells those sections by a plane that a structure has and are not drawn as it, or the other way
    // round, rising; facets in the plane once. Those too small to count are left out. The same for any
    // `threads`.
    std::vector<Section> wrong_sections_of(std::uint32_t structure, std::uint32_t plane,
                                           std::span<const std::uint32_t> cells, int threads = 1) const;

    // What a cell has wrong of one cross-section, that of a structure by a plane: what lies in the cell, and
    // half of what lies in its facets, for the cells on both sides have that.
    struct CrossSectionError {
        std::uint32_t cell, cross_section;  // structure * planes + slice
        double share;                       // of what is drawn
        friend bool operator==(const CrossSectionError&, const CrossSectionError&) = default;
    };
    // Those of the cells, in the order of these; the same for any `threads`. Complexity: O(cells log planes),
    // where planes cross O(cells * planes), and the field's members at each section.
    std::vector<CrossSectionError> errors_of(std::span<const std::uint32_t> cells, int threads = 1) const;

    // Sums the errors of the cells by cross-sections, in the order of the cells; the same for any `threads`.
    // Requires: of each facet in a plane that is wrong both cells.
    void sum_cuts(std::span<const std::uint32_t> cells, int threads = 1);
    // The same of all cells that share a vertex with one of these, without that.
    void sum_cuts_round(std::span<const std::uint32_t> cells, int threads = 1);
    // These cells, rising.
    std::vector<std::uint32_t> cells_round(std::span<const std::uint32_t> cells) const;
    // By structure and slice, as the weights of what is drawn.
    std::span<const double> sums() const { return of_cuts_; }
    // Of those that wrong_at() is about the largest sum.
    double largest_cut_at(std::uint32_t cell, int facet);

  private:
    // The first of some vertices, how far the others are from it, and whether one is in a slice as drawn.
    struct Reach {
        Vec3 from;
        double radius = 0;
        bool any_drawn = false;
    };
    Reach reach_of(std::span<const std::uint32_t> vertices) const;
    // Whether they are all on one side of it, and further from it than what lies in it is.
    bool is_beyond(std::uint32_t k, const Reach& reach, std::span<const std::uint32_t> vertices) const {
        if (std::abs(plane(k).signed_distance(reach.from)) <= reach.radius) return false;
        return !reach.any_drawn || std::none_of(vertices.begin(), vertices.end(),
                                                [&](std::uint32_t v) { return slice_of(v) == k; });
    }
    std::uint32_t slice_of(std::uint32_t v) const {
        return v < drawn_.slice_of.size() ? drawn_.slice_of[v] : no_slice;
    }

    // As ParallelPlanes has it.
    std::uint32_t level(std::uint32_t v) const;
    std::vector<std::uint32_t> levels_of_all(int threads) const;
    struct LevelRange {
        std::uint32_t low, high;
    };
    LevelRange levels_of(std::span<const std::uint32_t> vertices) const {
        LevelRange range{level(vertices[0]), 0};
        range.high = range.low;
        for (const std::uint32_t v : vertices.subspan(1)) {
            const std::uint32_t at = level(v);
            range.low = std::min(range.low, at);
            range.high = std::max(range.high, at);
        }
        return range;
    }
    using CellLevels = std::array<std::uint32_t, 4>;  // of a cell's vertices
    CellLevels levels_at(std::uint32_t cell) const;
    struct Piece {  // of a plane
        double area = 0;
        Vec3 middle;
    };
    // A section of a cell, or a facet in a plane: what the mesh has on its two sides.
    struct Part {
        Piece piece;
        std::uint32_t plane;
        Region here, there;
    };
    // Calls visit(part) for the section of the cell by each plane that passes through it. `levels`: of a
    // stack, the cell's.
    template <class Visit>
    void for_each_section(std::uint32_t cell, const CellLevels& levels, const Visit& visit) const;
    // Of a facet that lies in a plane, with a cell on both sides.
    std::optional<Part> facet_part(std::uint32_t cell, int facet) const;
    // Calls visit(cross-section, share) for each that has the part and must not, or must have it and has not.
    template <class Visit>
    void for_each_wrong(const Part& part, InterfaceProbe& probe, const Visit& visit) const;
    double wrong_part(const Part& part);
    // `levels`: of a stack those of all vertices, or none.
    void find_errors(std::span<const std::uint32_t> cells, std::span<const std::uint32_t> levels,
                     std::vector<CrossSectionError>& errors) const;
    void find_wrong_sections(std::uint32_t structure, std::uint32_t plane,
                             std::span<const std::uint32_t> cells, std::vector<Section>& found) const;
    // Whether the cell has a vertex in the plane, or some on either side.
    bool reaches(std::uint32_t cell, std::uint32_t plane) const;
    double wrong_sections(std::uint32_t cell);
    bool speaks_of(std::uint32_t plane, Vec3 p) const {
        return drawn_.extents.empty() || drawn_.extents[plane].contains(drawn_.planes[plane].to_plane(p));
    }

    // Area 0 where the plane does not pass through the cell. is_in(i): whether the cell's i-th vertex lies in
    // the plane.
    template <class IsIn>
    Piece section(std::uint32_t cell, std::uint32_t plane, const IsIn& is_in) const;
    Piece section(std::uint32_t cell, std::uint32_t plane) const;
    // Area 0 where the facet does not lie in the plane, or the mesh ends there.
    Piece facet_in(std::uint32_t plane, std::uint32_t cell, int facet) const;

    EditContext& edit_;
    const DrawnSlices& drawn_;
    std::optional<ParallelPlanes> stack_;  // where planes are parallel, over (0, 0, 0)
    std::vector<std::uint32_t> order_;     // of its planes, rising
    std::vector<std::uint32_t> rank_;      // of each plane in it
    std::vector<double> of_cuts_;          // by structure and slice
    std::uint32_t only_ = no_slice;        // if any: the plane that is looked at
    double largest_ = 0;                   // of the cuts seen
};

}  // namespace anatomesh
