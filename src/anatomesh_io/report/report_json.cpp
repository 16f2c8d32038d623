#include "anatomesh_io/report/report_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "anatomesh_io/report/options_json.h"

namespace anatomesh {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

// A volume of 0 means that it is not known.
Json known(double value) {
    return value > 0 ? number(value) : Json(nullptr);
}

const char* state_name(ClauseState state) {
    switch (state) {
        case ClauseState::kept:
            return "kept";
        case ClauseState::moved:
            return "moved";
        case ClauseState::broken:
            return "broken";
        case ClauseState::not_promised_yet:
            break;
    }
    return "not promised yet";
}

Json inputs_json(std::vector<InputReport> inputs) {
    // The order in which files were named does not matter to the model.
    std::sort(inputs.begin(), inputs.end(), [](const InputReport& a, const InputReport& b) {
        return std::tie(a.file, a.sha256) < std::tie(b.file, b.sha256);
    });
    Json list = Json::array();
    for (const InputReport& input : inputs) {
        list.push_back({{"file", input.file},
                        {"format", input.format},
                        {"bytes", input.bytes},
                        {"sha256", input.sha256}});
    }
    return list;
}

Json options_but_threads(const ModelReport& report) {
    Json options = options_json(report.provenance.options);
    options.erase("threads");
    return options;
}

Json structures_json(const ModelReport& report) {
    Json list = Json::array();
    for (const StructureReport& s : report.structures) {
        list.push_back({{"number", s.number},
                        {"name", s.name},
                        {"color", s.color},
                        {"tetrahedra", s.tetrahedra},
                        {"surface_triangles", s.surface.triangles},
                        {"surface_vertices", s.surface.vertices},
                        {"volume_mesh_mm3", number(s.volume.mesh_mm3)},
                        {"volume_field_mm3", known(s.volume.field_mm3)},
                        {"volume_slices_mm3", known(s.volume.slices_mm3)},
                        {"area_mm2", number(s.surface.area_mm2)},
                        {"components", s.surface.components},
                        {"pieces", s.pieces},
                        {"voids", s.shells.voids},
                        {"smallest_shell_mm3", number(s.shells.smallest_mm3)},
                        {"shells_without_contour", s.shells.without_contour},
                        {"shells_without_contour_mm3", number(s.shells.without_contour_mm3)},
                        {"contours_in_parts", s.shells.contours_in_parts},
                        {"parts_too_many", s.shells.parts_too_many},
                        {"genus", s.surface.genus},
                        {"open_edges", s.surface.open_edges},
                        {"nonmanifold_edges", s.surface.nonmanifold_edges},
                        {"nonmanifold_vertices", s.surface.nonmanifold_vertices},
                        {"contour_vertices", s.fidelity.vertices},
                        {"contour_vertices_on_surface", s.fidelity.vertices_on_surface},
                        {"contour_segments", s.fidelity.segments},
                        {"contour_segments_on_surface", s.fidelity.segments_on_surface},
                        {"contour_segments_contradicted", s.fidelity.segments_contradicted}});
    }
    return list;
}

Json histogram_json(const Histogram& histogram) {
    return {{"low", histogram.low}, {"high", histogram.high}, {"counts", histogram.counts}};
}

Json quality_json(const QualityReport& q) {
    return {
        {"radius_edge",
         {{"mean", number(q.radius_edge.mean)},
          {"p99", number(q.radius_edge.p99)},
          {"max", number(q.radius_edge.max)},
          {"share_over_2", number(q.radius_edge.share_over_2)},
          {"histogram", histogram_json(q.radius_edge.histogram)}}},
        {"dihedral_deg",
         {{"min", number(q.dihedral_deg.min)},
          {"p01_of_min", number(q.dihedral_deg.p01)},
          {"median_of_min", number(q.dihedral_deg.median_min)},
          {"max", number(q.dihedral_deg.max)},
          {"tetrahedra_below_10", q.dihedral_deg.below_10},
          {"tetrahedra_below_15", q.dihedral_deg.below_15},
          {"histogram_of_min", histogram_json(q.dihedral_deg.histogram)}}},
        {"edge_mm",
         {{"min", number(q.edge_mm.min)}, {"mean", number(q.edge_mm.mean)}, {"max", number(q.edge_mm.max)}}}};
}

Json certificate_json(const ModelReport& report) {
    Json list = Json::array();
    for (const Clause& clause : report.certificate) {
        list.push_back({{"clause", clause.number},
                        {"state", state_name(clause.state)},
                        {"statement", clause.statement},
                        {"evidence", clause.evidence}});
    }
    return list;
}

Json listed_cells_json(const ModelReport& report) {
    Json cells = Json::array();
    for (const ListedCell& cell : report.listed_cells.cells) {
        cells.push_back({{"cell", cell.cell},
                         {"radius_edge", number(cell.value)},
                         {"min_dihedral_deg", number(cell.min_dihedral_deg)},
                         {"at_mm", cell.at},
                         {"forced_by", cell.forced_by}});
    }
    return {{"radius_edge_above", 2.0},
            {"dihedral_deg_below", 10.0},
            {"total", report.listed_cells.total},
            {"forced_by_input", report.listed_cells.forced},
            {"cells", std::move(cells)}};
}

Json contour_log_json(const ModelReport& report) {
    Json list = Json::array();
    for (const ContourReport& entry : report.contours.log) {
        list.push_back({{"structure", entry.structure},
                        {"slice", entry.slice},
                        {"name", entry.name},
                        {"rule", entry.rule},
                        {"points_in", entry.points_in},
                        {"points_kept", entry.points_kept},
                        {"max_displacement_mm", number(entry.max_displacement_mm)},
                        {"area_change_mm2", number(entry.area_change_mm2)}});
    }
    return list;
}

Json cuts_json(const ModelReport& report) {
    Json cuts = Json::array();
    for (const SliceSectionReport& cut : report.contours.sections) {
        cuts.push_back({{"structure", cut.structure},
                        {"slice", cut.slice},
                        {"drawn_mm2", number(cut.drawn_mm2)},
                        {"difference_mm2", number(cut.difference_mm2)},
                        {"segments_missed", cut.segments_missed}});
    }
    return cuts;
}

Json routed_contours_json(const ModelReport& report) {
    Json routed = Json::array();
    for (const RoutedContourReport& contour : report.contours.routed) {
        routed.push_back({{"structure", contour.structure},
                          {"slice", contour.slice},
                          {"segments", contour.segments},
                          {"vertices_left", contour.vertices_left},
                          {"farthest_mm", number(contour.farthest_mm)},
                          {"difference_mm2", number(contour.difference_mm2)}});
    }
    return routed;
}

Json field_distance_json(const FieldDistanceReport& distance) {
    if (distance.points == 0) return nullptr;
    return {{"points", distance.points},          {"max_mm", number(distance.max_mm)},
            {"at_least", distance.at_least},      {"at_mm", distance.at},
            {"structure", distance.structure},    {"joined_mm", number(distance.joined_mm)},
            {"joined_at_mm", distance.joined_at}, {"joined_structure", distance.joined_structure}};
}

Json field_difference_json(const FieldDifferenceReport& difference) {
    if (difference.points == 0) return nullptr;
    return {{"points", difference.points},         {"differing", difference.differing},
            {"max_mm", number(difference.max_mm)}, {"at_mm", difference.at},
            {"structure", difference.structure},   {"missing", difference.missing}};
}

Json crossing_json(const CrossingReport& crossing) {
    Json pairs = Json::array(), slices = Json::array();
    for (const CrossingPairReport& pair : crossing.pairs) {
        pairs.push_back({{"slices", {pair.slice_a, pair.slice_b}},
                         {"ends", pair.ends},
                         {"unmatched", pair.unmatched},
                         {"median_mm", number(pair.median_mm)},
                         {"p95_mm", number(pair.p95_mm)},
                         {"max_mm", number(pair.max_mm)},
                         {"difference_mm", number(pair.difference_mm)},
                         {"difference_after_mm", number(pair.difference_after_mm)}});
    }
    for (const SliceMovementReport& slice : crossing.slices) {
        slices.push_back({{"slice", slice.slice},
                          {"mean_movement_mm", number(slice.mean_mm)},
                          {"max_movement_mm", number(slice.max_mm)},
                          {"shift_mm", slice.shift}});
    }
    return {{"reconciled", crossing.reconciled},
            {"ends", crossing.ends},
            {"unmatched", crossing.unmatched},
            {"shared_points", crossing.shared_points},
            {"median_mm", number(crossing.median_mm)},
            {"p95_mm", number(crossing.p95_mm)},
            {"max_mm", number(crossing.max_mm)},
            {"difference_mm", number(crossing.difference_mm)},
            {"difference_after_mm", number(crossing.difference_after_mm)},
            {"mean_movement_mm", number(crossing.mean_movement_mm)},
            {"max_movement_mm", number(crossing.max_movement_mm)},
            {"pairs", std::move(pairs)},
            {"slices", std::move(slices)}};
}

Json movement_json(const ContourMovementReport& movement) {
    return {{"bound_mm", number(movement.bound_mm)}, {"farthest_mm", number(movement.farthest_mm)},
            {"contours", movement.contours},         {"contours_moved", movement.contours_moved},
            {"vertices", movement.vertices},         {"vertices_moved", movement.vertices_moved},
            {"structure", movement.structure},       {"slice", movement.slice}};
}

Json stages_json(const ModelReport& report) {
    Json list = Json::array();
    for (const StageReport& stage : report.run.stages) {
        Json figures = Json::object();
        for (const auto& [name, value] : stage.figures) figures[name] = number(value);
        list.push_back({{"name", stage.name},
                        {"points", stage.points},
                        {"tetrahedra", stage.cells},
                        {"figures", std::move(figures)}});
    }
    return list;
}

Json warnings_json(const ModelReport& report) {
    Json list = Json::array();
    for (const Warning& warning : report.warnings) {
        list.push_back({{"code", warning.code},
                        {"message", warning.message},
                        {"file", warning.place.file},
                        {"slice", warning.place.slice},
                        {"structure", warning.place.structure},
                        {"contour", warning.place.contour},
                        {"value", warning.place.value},
                        {"what_was_done", warning.what_was_done}});
    }
    return list;
}

// Searches on several threads do what one thread would leave: the counts may differ with their number.
Json work_json(const WorkReport& work) {
    return {{"meshings", work.meshings},
            {"delaunay_cells", work.delaunay_cells},
            {"edited_cells", work.edited_cells},
            {"field_values", work.field_values > 0 ? Json(work.field_values) : Json(nullptr)}};
}

Json timing_json(const ModelReport& report) {
    Json stages = Json::array();
    double total = 0;
    for (const StageReport& stage : report.run.stages) {
        total += stage.seconds;
        stages.push_back({{"name", stage.name}, {"seconds", number(stage.seconds)}});
    }
    Json timing{{"command", report.provenance.command}};
    for (const auto& [name, value] : report.provenance.options) {
        if (name == "threads") timing["threads"] = value;
    }
    timing["total_seconds"] = number(total);
    timing["stages"] = std::move(stages);
    timing["work"] = work_json(report.run.work);
    return timing;
}

}  // namespace

std::string report_json(const ModelReport& report) {
    Json versions{{"anatomesh", report.provenance.version}};
    for (const auto& [name, version] : report.provenance.libraries) versions[name] = version;
    Json json{
        {"format", "anatomesh-report"},
        {"format_version", 1},
        {"versions", std::move(versions)},
        {"inputs", inputs_json(report.provenance.inputs)},
        {"options", options_but_threads(report)},
        {"space", report.conventions.space},
        {"unit", report.conventions.unit},
        {"rules", {{"holes", report.conventions.hole_rule}, {"end_caps", report.conventions.end_caps}}},
        {"counts",
         {{"tetrahedra", report.counts.tetrahedra},
          {"vertices", report.counts.vertices},
          {"surface_triangles", report.counts.surface_triangles},
          {"slices", report.counts.slices},
          {"contours", report.counts.contours},
          {"contour_vertices", report.counts.contour_vertices},
          {"traced_points", report.counts.traced_points},
          {"islands_left_out", report.counts.islands_left_out}}},
        {"sizes",
         {{"epsilon_mm", number(report.lengths.epsilon_mm)},
          {"size_mm", number(report.lengths.size_mm)},
          {"slice_spacing_mm", number(report.lengths.slice_spacing_mm)}}},
        {"share_culled", number(report.meshing.share_culled)},
        {"radius_edge_mean_before_refinement", number(report.meshing.radius_edge_mean_before_refinement)},
        {"structures", structures_json(report)},
        {"regions", report.regions},
        {"quality", quality_json(report.quality)},
        {"certificate", certificate_json(report)},
        {"listed_cells", listed_cells_json(report)},
        {"warnings", warnings_json(report)},
        {"contour_log", contour_log_json(report)},
        {"cuts", cuts_json(report)},
        {"followed_contours", routed_contours_json(report)},
        {"field_distance", field_distance_json(report.field.distance)},
        {"field_difference", field_difference_json(report.field.difference)},
        {"stages", stages_json(report)},
        {"timing", timing_json(report)},
    };
    if (!report.crossing.pairs.empty()) json["crossing_slices"] = crossing_json(report.crossing);
    if (report.crossing.movement.bound_mm > 0)
        json["contour_movement"] = movement_json(report.crossing.movement);
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace anatomesh
