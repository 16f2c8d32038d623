// What is asked of improve_mesh(), and what it did.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/mesh/model/routed_contour.h"

namespace anatomesh {

struct MeshImprovementOptions {
    // Cells inside with an angle below it, or above 180 degrees less it, are worked on. [0, 40]
    double target_degrees = 15;
    // No operation makes a larger ratio that is also above what it was. [1.2, 10]
    double max_radius_edge = contract::max_radius_edge;
    // Vertices of an interface stay within this of the field's, mm, or as near as they were. > 0
    double tolerance_mm = 0.05;
    // The middle of a changed interface facet stays within this of the field's, mm, or as near as before. > 0
    double max_deviation_mm = 0.1;
    // That bound grows by this factor for the cells that are still bad after the first passes. [1, 10]
    double last_deviation = 2;
    // An angle below 10 degrees is worth ratios up to this bound; if it is larger than the first one, cells
    // above it are worked on too. >= 1.2
    double last_radius_edge = contract::nearly_bad_radius_edge;
    // Edges of surfaces are flipped where the angles at their facets fall by more, degrees. (0, 900]
    double flip_gain_degrees = 2;
    // Repairs leave no vertex of a surface further from the field's, mm, or as near as it was. > 0
    double spike_mm = 1;
    // A vertex of a surface further from the field's is the apex of a spike or a pit, mm (remove_spikes.h). > 0
    double least_spike_mm = 0.3;
    int passes = 4;        // over the cells that are still bad. [0, 100]
    int ratio_passes = 4;  // over the cells above max_radius_edge, after those. [0, 100]
    // Handles of surfaces no longer than this are removed where no contour of `drawn.routable` shows them, mm
    // (remove_spurious_handles.h); 0: none. >= 0
    double handle_mm = 0;
    // Whether cells between the bound and last_radius_edge may be relabelled for their ratio, as those above
    // may. Where planes cross, that leaves pits in surfaces.
    bool relabels_for_ratio = false;
};

// Changes that the local operations made and that stayed.
struct OperationCounts {
    std::uint64_t vertices_moved = 0, surface_vertices_moved = 0;
    std::uint64_t edges_removed = 0, facets_removed = 0;
    std::uint64_t surface_edges_flipped = 0;   // for angles of cells
    std::uint64_t surface_edges_smoothed = 0;  // for angles between facets (flip_surface_edges.h)
    std::uint64_t cells_relabelled = 0, edges_collapsed = 0, vertices_inserted = 0;
};

// Repairs of surfaces that single operations cannot make.
struct SurgeryCounts {
    std::uint64_t cell_spikes_removed = 0, spikes_removed = 0;       // remove_spikes.h
    std::uint64_t subsegments_found = 0, subsegments_recovered = 0;  // recover_on_surface.h
    std::uint64_t handles_found = 0, handles_removed = 0;            // remove_spurious_handles.h
    std::uint64_t spurious_components_removed = 0;                   // where sections were repaired
};

// Repairs of cross-sections.
struct SectionCounts {
    std::uint64_t facets_detached = 0, facets_left = 0;  // detach_facets_from_plane.h
    std::uint64_t found = 0;                             // visits of places with a wrong section
    std::uint64_t repaired = 0;  // changes (repair_section_locally.h, repair_section_patch.h)
};

struct MeshImprovementStats {
    std::uint64_t bad_before = 0, bad_after = 0;                 // cells inside below the target
    double worst_before_degrees = 90, worst_after_degrees = 90;  // by the least sine
    std::uint64_t tries = 0;                                     // bad cells that were taken from a queue
    OperationCounts operations;
    SurgeryCounts surgeries;
    SectionCounts sections;
    std::uint64_t segments_missed = 0;  // of drawn.routable, before reroute_on_section()
    std::vector<RoutedContour> routed;
    std::uint64_t cells_made = 0;  // by all operations, those taken back included
};

}  // namespace anatomesh
