// What is asked of improve_dihedrals(), and what it did.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/improve/core/drawn_slices.h"

namespace anatomesh {

struct DihedralOptions {
    double target_degrees =
        15;  // cells inside with an angle below it (or above 180 less it) are worked on. [0, 40]
    double max_radius_edge = contract::
        max_radius_edge;  // no operation makes a ratio above it that is also above what it was. [1.2, 10]
    double tolerance_mm =
        0.05;  // vertices of an interface stay within this of the field's, or as near as they were. > 0
    double max_deviation_mm =
        0.1;  // of the middle of a changed interface facet from the field's, or as near as before. > 0
    double last_deviation =
        2;  // the bound grows by this factor for the cells that are still bad after all passes. [1, 10]
    // Instead of max_radius_edge, at last, where that leaves an angle below 10 degrees; if larger, cells
    // above it are worked on too. >= 1.2
    double last_radius_edge = contract::nearly_bad_radius_edge;
    double flip_gain_degrees = 2;  // edges of surfaces are flipped where that makes the angles at their
                                   // facets fall by more. (0, 900]
    // A vertex of a surface further from the field's is a spike (remove_spikes.h). > 0.
    double spike_mm = 1;
    int passes = 4;        // over the cells that are still bad. [0, 100]
    int ratio_passes = 4;  // over the cells above max_radius_edge, after those. [0, 100]
    // Handles of surfaces within so little along them are closed, where no contour of `drawn.routable` tells
    // of them (remove_spurious_handles.h); 0: none. >= 0
    double handle_mm = 0;
    // Whether cells between the bound and last_radius_edge may go to another side for their ratio, as those
    // above may: to the outside, it may leave pits.
    bool relabels_for_ratio = false;
};

struct DihedralStats {
    std::uint64_t bad_before = 0, bad_after = 0;                 // cells inside below the target
    double worst_before_degrees = 90, worst_after_degrees = 90;  // by the least sine
    // Operations that were applied.
    std::uint64_t vertices_moved = 0, surface_vertices_moved = 0, edges_removed = 0, facets_removed = 0,
                  surface_edges_flipped = 0, surface_edges_smoothed = 0, cells_relabelled = 0,
                  ears_dropped = 0, edges_collapsed = 0, vertices_inserted = 0, facets_detached = 0,
                  spikes_removed = 0, tries = 0;
    std::uint64_t cuts_found = 0,
                  sections_repaired =
                      0;  // visits and changes (repair_section_locally.h, repair_section_patch.h)
    // That came off where cuts were repaired.
    std::uint64_t spurious_components_removed = 0;
    std::uint64_t handles_found = 0, handles_removed = 0;  // that no contour tells of
    // Of contour segments (recover_on_surface.h)
    std::uint64_t subsegments_found = 0, subsegments_recovered = 0;
    std::uint64_t segments_missed = 0;  // of drawn.routable, before reroute_on_section()
    std::vector<RoutedContour> routed;
    std::uint64_t facets_left = 0;  // in slices, beside what is drawn there (detach_facets_from_plane.h)
    std::uint64_t cells_made = 0;   // by all operations, those taken back included
};

}  // namespace anatomesh
