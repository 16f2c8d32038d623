#include "anatomesh/pipeline/make_model.h"

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/version.h"
#include "anatomesh/field/end_caps.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/pipeline/estimate.h"

namespace anatomesh {

namespace {

// How thick the source says that its one slice is; 0 where there are several or it does not say.
double stated_thickness(const ContourSet& kept) {
    return kept.slices.size() == 1 ? kept.slice_thickness_mm : 0;
}

void warn_of_one_slice(const ContourSet& kept, double chosen_mm, RunContext& context) {
    const double thickness = stated_thickness(kept);
    if (thickness <= 0 || chosen_mm > 0) return;
    context.warn({"W-FLD-013",
                  "everything is drawn on one slice, so that nothing shows how it goes on above and below",
                  {kept.source, kept.slices[0].name, "", "", brief(thickness) + " mm"},
                  "the model is as thick as the source says that a slice is; --slice-thickness gives another "
                  "thickness"});
}

std::vector<std::pair<std::string, std::string>> options_told(const PreparedContours& prepared,
                                                              const MakeModelOptions& options,
                                                              double size_mm) {
    const FieldOptions& field = options.prepare.field;
    std::vector<std::pair<std::string, std::string>> told = prepared.options;
    told.emplace_back("size_mm", number_text(size_mm));
    told.emplace_back("caps", name_of(field.caps));
    if (!prepared.crossing.pairs.empty()) {
        const ReconcileOptions& reconcile = options.prepare.reconcile;
        told.emplace_back("max_disagreement_mm", number_text(reconcile.max_disagreement_mm));
        told.emplace_back("reconcile", reconcile.reconcile ? "1" : "0");
        told.emplace_back("align", reconcile.align ? "yes" : "no");
    }
    told.insert(told.end(), options.report_options.begin(), options.report_options.end());
    told.emplace_back("max_gap_spacings", number_text(field.max_gap_spacings));
    const double thickness =
        field.single_slice_mm > 0 ? field.single_slice_mm : stated_thickness(prepared.kept);
    if (thickness > 0) told.emplace_back("slice_thickness_mm", number_text(thickness));
    return told;
}

// What the report of a model tells of its contours, which build_model() does not know.
void complete_report(const PreparedContours& prepared, const MakeModelOptions& options,
                     const RunContext& context, ModelReport& report) {
    report.provenance.version = library_version();
    report.contours.log = prepared.log;
    report.conventions.hole_rule = prepared.hole_rule;
    report.conventions.end_caps = name_of(options.prepare.field.caps);
    report.conventions.space = prepared.kept.frame == Frame::unknown ? "unknown" : "LPS";
    report.counts.traced_points = prepared.traced_points;
    report.counts.islands_left_out = prepared.islands_left_out;
    report.lengths.epsilon_mm = prepared.epsilon_mm;
    report.run.stages.insert(report.run.stages.begin(), prepared.stages.begin(), prepared.stages.end());
    report.crossing = prepared.crossing;
    state_movement(report);
    report.provenance.options = options_told(prepared, options, report.lengths.size_mm);
    report.warnings = context.warnings;
}

}  // namespace

ModelOptions model_options(const MakeModelOptions& options) {
    const PrepareOptions& prepare = options.prepare;
    ModelOptions building;
    building.size_mm = options.size_mm;
    building.caps = prepare.field.caps;
    building.max_gap_spacings = prepare.field.max_gap_spacings;
    building.single_slice_mm = prepare.field.single_slice_mm;
    building.max_radius_edge = options.max_radius_edge;
    building.max_tetrahedra = options.max_tetrahedra;
    building.spare_dense_above = options.spare_dense_above;
    building.max_reroute_mm = prepare.reconcile.reconcile ? prepare.reconcile.max_disagreement_mm : 0;
    return building;
}

Result<Model> make_model(const PreparedContours& prepared, const MakeModelOptions& options,
                         RunContext& context, const StageObserver& observer) {
    const ContourSet& kept = prepared.kept;
    if (options.size_mm > 0) {
        ANATOMESH_CHECK_STATUS(
            check_size(kept, options.size_mm, {options.max_tetrahedra, options.max_memory_bytes}));
    } else {
        ANATOMESH_CHECK_STATUS(check_default_size(kept));
    }
    warn_of_one_slice(kept, options.prepare.field.single_slice_mm, context);
    ANATOMESH_TRY(Model model, build_model(kept, model_options(options), context, observer));
    complete_report(prepared, options, context, model.report);
    return model;
}

Result<Model> make_model(const RawContours& raw, const MakeModelOptions& options, RunContext& context,
                         const StageObserver& observer) {
    ANATOMESH_TRY(const PreparedContours prepared, prepare_contours(raw, options.prepare, context));
    return make_model(prepared, options, context, observer);
}

Result<Model> make_model(ContourSet kept, const MakeModelOptions& options, RunContext& context,
                         const StageObserver& observer) {
    ANATOMESH_TRY(const PreparedContours prepared,
                  prepare_contours(std::move(kept), options.prepare, context));
    return make_model(prepared, options, context, observer);
}

}  // namespace anatomesh
