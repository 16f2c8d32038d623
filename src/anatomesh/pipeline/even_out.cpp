#include "anatomesh/pipeline/even_out.h"

#include <array>
#include <utility>
#include <vector>

#include "anatomesh/pipeline/compare_reports.h"

namespace anatomesh {

namespace {

constexpr double most_mean = 0.95;  // of the radius-edge ratio
constexpr std::array<double, 2> even_means{0.98, 0.965};
constexpr std::size_t small_model = 30000;  // cells: each try takes well below a second
constexpr double near_enough = 0.5;         // to the field, in sizes: farther off it is warned of

bool is_uneven(const Model& model) {
    return model.report.quality.radius_edge_mean > most_mean && model.mesh.cells.size() < small_model;
}

}  // namespace

Result<Model> even_out(Model model, double size_mm, const std::function<Result<Model>(double)>& build,
                       RunContext& context) {
    if (!is_uneven(model)) return model;
    CompareOptions options;
    options.near_mm = near_enough * size_mm;
    std::vector<Warning> warnings = context.warnings;
    for (const double mean : even_means) {
        if (!is_uneven(model)) break;
        Result<Model> even = build(mean);
        if (!even.ok() && even.error().kind == ErrorKind::cancelled) return even;
        if (!even.ok()) continue;
        const ComparedModel now{even.value().report, context.warnings}, before{model.report, warnings};
        if (!is_no_worse(now, before, options)) continue;
        model = std::move(even.value());
        warnings = context.warnings;
    }
    context.warnings = std::move(warnings);
    return model;
}

}  // namespace anatomesh
