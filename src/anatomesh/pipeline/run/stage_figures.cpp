#include "anatomesh/pipeline/run/stage_figures.h"

namespace anatomesh {

StageFigures sample_figures(const SampleStats& stats) {
    return {{"contour_points", static_cast<double>(stats.contour_points)},
            {"segment_points", static_cast<double>(stats.segment_points)},
            {"thin_spots", static_cast<double>(stats.thin_spots)},
            {"surface_points", static_cast<double>(stats.surface_points)},
            {"lattice_points", static_cast<double>(stats.lattice_points)}};
}

StageFigures cull_figures(std::uint64_t cells, const CullStats& stats) {
    return {{"cells", static_cast<double>(cells)},
            {"culled", static_cast<double>(stats.culled)},
            {"culled_share", static_cast<double>(stats.culled) / static_cast<double>(cells)}};
}

StageFigures refine_figures(const RefinementStats& stats, const ContourSubsegments& subsegments) {
    return {{"crossing_points", static_cast<double>(stats.crossing_points)},
            {"deviation_points", static_cast<double>(stats.deviation_points)},
            {"cut_points", static_cast<double>(stats.section_points)},
            {"circumcenters", static_cast<double>(stats.circumcenters)},
            {"surface_points", static_cast<double>(stats.surface_points)},
            {"side_points", static_cast<double>(subsegments.side_points())},
            {"segment_points", static_cast<double>(subsegments.vertices().size())}};
}

StageFigures cut_figures(const CutStats& stats) {
    const RelabelStats& relabelled = stats.relabelled;
    return {{"unsound_vertices", static_cast<double>(relabelled.nonmanifold_before)},
            {"cells_moved", static_cast<double>(relabelled.cells_moved)},
            {"cells_mended", static_cast<double>(relabelled.cells_mended)},
            {"flat_cells_peeled", static_cast<double>(relabelled.flat_cells_peeled)},
            {"lost_pieces", static_cast<double>(relabelled.lost_subsegments_before)},
            {"lost_pieces_after_relabelling", static_cast<double>(relabelled.lost_subsegments_after)},
            {"missing_pieces", static_cast<double>(stats.recovered.missing_before)},
            {"missing_pieces_after", static_cast<double>(stats.recovered.missing_after)},
            {"recovered_by_vertices", static_cast<double>(stats.recovered.vertices_added)},
            {"unsound_after_relabelling", static_cast<double>(relabelled.nonmanifold_after)},
            {"edges_split", static_cast<double>(stats.split.edges_split)},
            {"vertices_split", static_cast<double>(stats.split.vertices_split)},
            {"vertices_joined", static_cast<double>(stats.split.vertices_joined)},
            {"pieces_given", static_cast<double>(stats.split.components_relabelled)},
            {"crumbs_given_away", static_cast<double>(stats.spurious.components)}};
}

StageFigures improve_figures(const ImprovedStats& stats) {
    return {
        {"vertices_onto_interface", static_cast<double>(stats.improved.vertices_onto_interface)},
        {"vertices_smoothed", static_cast<double>(stats.improved.vertices_smoothed)},
        {"above_bound_before", static_cast<double>(stats.improved.above_bound_before)},
        {"above_bound_after", static_cast<double>(stats.improved.above_bound_after)},
        {"vertices_evened", static_cast<double>(stats.smoothed.vertices_moved)},
        {"surface_vertices_evened", static_cast<double>(stats.smoothed.surface_vertices_moved)},
        {"angles_below_target_before", static_cast<double>(stats.dihedrals.bad_before)},
        {"angles_below_target_after", static_cast<double>(stats.dihedrals.bad_after)},
        {"vertices_moved", static_cast<double>(stats.dihedrals.operations.vertices_moved)},
        {"surface_vertices_moved", static_cast<double>(stats.dihedrals.operations.surface_vertices_moved)},
        {"edges_removed", static_cast<double>(stats.dihedrals.operations.edges_removed)},
        {"facets_removed", static_cast<double>(stats.dihedrals.operations.facets_removed)},
        {"surface_edges_flipped", static_cast<double>(stats.dihedrals.operations.surface_edges_flipped)},
        {"surface_edges_smoothed", static_cast<double>(stats.dihedrals.operations.surface_edges_smoothed)},
        {"cells_given", static_cast<double>(stats.dihedrals.operations.cells_relabelled)},
        {"ears_dropped", static_cast<double>(stats.dihedrals.surgeries.cell_spikes_removed)},
        {"edges_collapsed", static_cast<double>(stats.dihedrals.operations.edges_collapsed)},
        {"vertices_inserted", static_cast<double>(stats.dihedrals.operations.vertices_inserted)},
        {"facets_lifted", static_cast<double>(stats.dihedrals.sections.facets_detached)},
        {"pieces_off_surface", static_cast<double>(stats.dihedrals.surgeries.subsegments_found)},
        {"pieces_brought", static_cast<double>(stats.dihedrals.surgeries.subsegments_recovered)},
        {"apexes_lowered", static_cast<double>(stats.dihedrals.surgeries.spikes_removed)},
        {"segments_missed", static_cast<double>(stats.dihedrals.segments_missed)},
        {"contours_followed", static_cast<double>(stats.contours_routed)},
        {"crumbs_given_away", static_cast<double>(stats.spurious.components +
                                                  stats.dihedrals.surgeries.spurious_components_removed)},
        {"small_handles", static_cast<double>(stats.dihedrals.surgeries.handles_found)},
        {"small_handles_closed", static_cast<double>(stats.dihedrals.surgeries.handles_removed)},
        {"facets_left_in_slices", static_cast<double>(stats.dihedrals.sections.facets_left)},
        {"visits_of_wrong_cuts", static_cast<double>(stats.dihedrals.sections.found)},
        {"changes_to_cuts", static_cast<double>(stats.dihedrals.sections.repaired)},
        {"largest_volume_offset_mm", stats.balanced.largest_offset_mm},
        {"flat_ends_held", stats.balanced.ends_held ? 1.0 : 0.0},
        {"volume_difference_before", stats.balanced.worst_before},
        {"volume_difference_after", stats.balanced.worst_after}};
}

}  // namespace anatomesh
