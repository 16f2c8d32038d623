#include "anatomesh/pipeline/retry/retry_for_mean_ratio.h"

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "anatomesh/pipeline/retry/compare_reports.h"

namespace anatomesh {

namespace {

// A model with a higher mean radius-edge ratio is built again. [ratio; > 0.6; M 2026-11, docs/experiments/2026-11-28-retries.md]
constexpr double most_mean = 0.95;
// A model that does not get there is taken if it gains so much. [ratio; > 0; M 2026-11, set not recorded]
constexpr double least_mean_gain = 0.005;
// What refinement aims at, from run to run. [ratio; 0.9 to 1; M 2026-11, docs/experiments/2026-11-28-retries.md]
constexpr std::array<double, 3> target_mean_ratios{0.99, 0.98, 0.965};
// A model of this size and more is not built again for its mean. [cells; > 0; B]
constexpr std::size_t small_model = 30000;
// A surface so near to the field's counts as on it; farther off it is warned of. [sizes; > 0; C]
constexpr double near_enough = 0.5;

bool exceeds_mean_ratio(const Model& model) {
    return model.report.quality.radius_edge.mean > most_mean;
}

// Bad cells without a reason.
std::uint64_t unforced(const Model& model) {
    return model.report.listed_cells.total - model.report.listed_cells.forced;
}

// The first of two that has a mean as is asked for, or one lower by something; of two that have it, the one
// with fewer bad cells.
bool is_more_even(const Model& model, const Model& other) {
    const double mean = model.report.quality.radius_edge.mean;
    const double before = other.report.quality.radius_edge.mean;
    if (before <= most_mean) return mean <= most_mean && unforced(model) < unforced(other);
    return mean <= most_mean || mean <= before - least_mean_gain;
}

}  // namespace

Result<RetriedModel> retry_for_mean_ratio(Model model, double size_mm,
                                          const std::function<Result<Model>(double)>& build,
                                          RunContext& context) {
    RetriedModel result;
    if (!exceeds_mean_ratio(model) || model.mesh.cells.size() >= small_model) {
        result.model = std::move(model);
        return result;
    }
    const std::vector<Warning> first_warnings = context.warnings;
    std::vector<Warning> warnings = first_warnings;
    const ComparedModel first{model.report, first_warnings};
    CompareOptions options;
    options.near_mm = near_enough * size_mm;
    std::optional<Model> taken;
    for (const double mean : target_mean_ratios) {
        const Model& best = taken ? *taken : model;
        if (!exceeds_mean_ratio(best) && unforced(best) <= unforced(model)) break;
        ++result.runs;
        Result<Model> even = build(mean);
        if (!even.ok() && even.error().kind == ErrorKind::cancelled) return even.error();
        if (!even.ok() || !is_no_worse({even.value().report, context.warnings}, first, options) ||
            !is_more_even(even.value(), best))
            continue;
        taken = std::move(even.value());
        warnings = context.warnings;
        result.target_mean_ratio = mean;
    }
    context.warnings = std::move(warnings);
    result.model = taken ? std::move(*taken) : std::move(model);
    return result;
}

}  // namespace anatomesh
