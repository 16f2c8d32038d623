#include "anatomesh/pipeline/run/prepare_run.h"

#include <algorithm>
#include <string>
#include <utility>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/pipeline/run/contour_field.h"
#include "anatomesh/pipeline/run/contradicted_places.h"

namespace anatomesh {

namespace {

// A Delaunay mesh of points in space has about so many cells a point. [cells; > 0; B]
constexpr std::size_t cells_per_point = 6;

}  // namespace

FieldOptions field_options(const ModelOptions& options) {
    FieldOptions field;
    field.caps = options.caps;
    field.max_gap_spacings = options.max_gap_spacings;
    field.single_slice_mm = options.single_slice_mm;
    return field;
}

Result<PreparedRun> prepare_run(const ContourSet& source, const RunConfig& config, FieldAndVolumes known,
                                RunContext& context) {
    PreparedRun run;
    if (!source.points.empty()) run.origin = source.box().low;
    run.contours = relative_to(run.origin, source);
    run.structures = static_cast<std::uint32_t>(source.structures.size());
    run.known = std::move(known);
    if (!run.known.field) {
        ANATOMESH_TRY(run.known.field, make_structure_field(run.contours, *run.known.slices,
                                                            field_options(config.options), context));
    }
    run.known.warnings = context.warnings.size();
    run.field = run.known.field;
    if (context.threads == 1) run.field = run.counted = std::make_shared<CountedField>(run.known.field);
    run.effort = effort_of(run.contours, run.arrangement(), *run.field, config);
    run.slices = weigh_slices(run.contours, *run.known.slices, run.field->flat_ends());
    if (run.effort.fits_sections)
        run.contradicted = contradicted_places(run.contours, run.slices.weights, context);
    return run;
}

Result<PointSample> sample_run(const PreparedRun& run, double size_mm, RunContext& context) {
    SampleOptions options;
    options.size_mm = size_mm;
    options.conforming = run.effort.conforming;
    options.growth = run.effort.growth;
    return sample_points(run.contours, run.arrangement(), *run.field, options, context);
}

Status check_cell_count(const PointSample& sample, std::uint64_t max_tetrahedra) {
    const std::size_t cells = cells_per_point * sample.points.size();
    if (cells <= max_tetrahedra && cells < no_cell) return Nothing{};
    return Error{ErrorKind::limit,
                 "E-PIP-001",
                 "the model would need about " + std::to_string(cells) + " tetrahedra, more than " +
                     std::to_string(std::min<std::uint64_t>(max_tetrahedra, no_cell)),
                 {},
                 "give a larger --size"};
}

}  // namespace anatomesh
