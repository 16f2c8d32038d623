// RerouteAttempt: the changes of mesh and context by which a contour comes to run along a way on its surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/core/quality_gate.h"
#include "anatomesh/improve/core/surface_incidence.h"
#include "anatomesh/improve/reroute/rerouted_contours.h"
#include "anatomesh/improve/reroute/section_path.h"

namespace anatomesh {

// One attempt, between EditMesh's begin_attempt() and end_attempt(). Its steps are, in this order,
// move_near() as often as it finds another way, make_edges() and settle(); then keep(), or take_back() if
// one of the last two returned false.
class RerouteAttempt {
  public:
    // `constraint_limited`: what `drawn` looks at. `least_sine`: of cells inside that no contour forces.
    // Requires: all outlive this.
    RerouteAttempt(EditContext& edit, const DrawnSlices& drawn, std::span<std::uint8_t> constraint_limited,
                   ReroutedContours& contours, double least_sine, const ImproveCells& improve)
        : edit_(edit),
          drawn_(drawn),
          constraint_limited_(constraint_limited),
          contours_(contours),
          least_sine_(least_sine),
          improve_(improve),
          incidence_(edit) {}

    // Moves the free end of each edge that the way crosses nearer to it than `near` of the edge onto the way.
    // Returns whether there was any: then the way is another one.
    bool move_near(const SectionPath& path, double near);
    // Puts vertices on the edges that the way crosses; false if it is not edges of the surface then.
    bool make_edges(const SectionPath& path, std::uint32_t structure);
    // Draws the way near to what is drawn, and improves the shapes. False if cells are bad then, if the way
    // went too far, or if the slice's contours are none of a kept set.
    bool settle(const ReroutedContour& contour, SectionPath& path);

    // The context as it was before, once the mesh is. Its fixed edges keep their points.
    void take_back();
    // Notes the way with the contours; what moved for an earlier way and is not on this one is free again.
    void keep(const Contour& contour);

    const std::vector<std::uint32_t>& vertices() const { return vertices_; }  // of the way
    const std::vector<std::uint32_t>& changed() const {
        return changed_;
    }  // cells, some of which may be gone

  private:
    void draw_near(const std::vector<Vec3>& drawn);
    bool move_towards(std::uint32_t v, const std::vector<Vec3>& drawn);
    double worst_in_star() const;
    bool is_way_on_surface(std::uint32_t structure);
    void improve_cells();
    bool is_good(std::uint32_t c) const;
    bool shortest_is_drawn(const Cell& v) const;

    // What of a contour a way takes the place of: vertices, and edges that are subsegments.
    struct ReplacedRow {
        std::vector<std::uint32_t> vertices;
        std::vector<VertexPair> edges;
    };
    ReplacedRow replaced_row(const ReroutedContour& contour, const SectionPath& path) const;
    void release(const ReroutedContour& contour, const SectionPath& path);
    std::uint32_t end_of_subsegment(std::uint32_t v, std::uint32_t a, std::uint32_t b,
                                    std::uint32_t structure) const;
    bool is_free_without(const std::vector<std::uint32_t>& own, std::uint32_t structure,
                         std::uint32_t v) const;
    void free(std::uint32_t v);

    EditContext& edit_;
    const DrawnSlices& drawn_;
    std::span<std::uint8_t> constraint_limited_;
    ReroutedContours& contours_;
    double least_sine_;
    const ImproveCells& improve_;
    SurfaceIncidence incidence_;
    std::vector<std::uint32_t> vertices_, changed_;
    // What was done to the context.
    std::vector<std::uint32_t> moved_;         // vertices that were free, or new ones on no other contour
    std::vector<std::uint32_t> released_;      // vertices that were fixed
    std::vector<std::uint8_t> limits_before_;  // of these, whether contours limited them
    std::vector<VertexPair> let_go_, fixed_;   // edges that were kept; edges
};

}  // namespace anatomesh
