#include "anatomesh/pipeline/improve_figures.h"

namespace anatomesh {

std::vector<std::pair<std::string, double>> improve_figures(const ImproveWork& work) {
    return {{"vertices_onto_interface", static_cast<double>(work.improved.vertices_onto_interface)},
            {"vertices_smoothed", static_cast<double>(work.improved.vertices_smoothed)},
            {"above_bound_before", static_cast<double>(work.improved.above_bound_before)},
            {"above_bound_after", static_cast<double>(work.improved.above_bound_after)},
            {"vertices_evened", static_cast<double>(work.smoothed.vertices_moved)},
            {"surface_vertices_evened", static_cast<double>(work.smoothed.surface_vertices_moved)},
            {"angles_below_target_before", static_cast<double>(work.dihedrals.bad_before)},
            {"angles_below_target_after", static_cast<double>(work.dihedrals.bad_after)},
            {"vertices_moved", static_cast<double>(work.dihedrals.operations.vertices_moved)},
            {"surface_vertices_moved", static_cast<double>(work.dihedrals.operations.surface_vertices_moved)},
            {"edges_removed", static_cast<double>(work.dihedrals.operations.edges_removed)},
            {"facets_removed", static_cast<double>(work.dihedrals.operations.facets_removed)},
            {"surface_edges_flipped", static_cast<double>(work.dihedrals.operations.surface_edges_flipped)},
            {"surface_edges_smoothed", static_cast<double>(work.dihedrals.operations.surface_edges_smoothed)},
            {"cells_given", static_cast<double>(work.dihedrals.operations.cells_relabelled)},
            {"ears_dropped", static_cast<double>(work.dihedrals.surgeries.cell_spikes_removed)},
            {"edges_collapsed", static_cast<double>(work.dihedrals.operations.edges_collapsed)},
            {"vertices_inserted", static_cast<double>(work.dihedrals.operations.vertices_inserted)},
            {"facets_lifted", static_cast<double>(work.dihedrals.sections.facets_detached)},
            {"pieces_off_surface", static_cast<double>(work.dihedrals.surgeries.subsegments_found)},
            {"pieces_brought", static_cast<double>(work.dihedrals.surgeries.subsegments_recovered)},
            {"apexes_lowered", static_cast<double>(work.dihedrals.surgeries.spikes_removed)},
            {"segments_missed", static_cast<double>(work.dihedrals.segments_missed)},
            {"contours_followed", static_cast<double>(work.contours_routed)},
            {"crumbs_given_away", static_cast<double>(work.spurious.components +
                                                      work.dihedrals.surgeries.spurious_components_removed)},
            {"small_handles", static_cast<double>(work.dihedrals.surgeries.handles_found)},
            {"small_handles_closed", static_cast<double>(work.dihedrals.surgeries.handles_removed)},
            {"facets_left_in_slices", static_cast<double>(work.dihedrals.sections.facets_left)},
            {"visits_of_wrong_cuts", static_cast<double>(work.dihedrals.sections.found)},
            {"changes_to_cuts", static_cast<double>(work.dihedrals.sections.repaired)},
            {"largest_volume_offset_mm", work.balanced.largest_offset_mm},
            {"flat_ends_held", work.balanced.ends_held ? 1.0 : 0.0},
            {"volume_difference_before", work.balanced.worst_before},
            {"volume_difference_after", work.balanced.worst_after}};
}

}  // namespace anatomesh
