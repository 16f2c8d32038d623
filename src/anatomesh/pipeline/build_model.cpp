#include "anatomesh/pipeline/build_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/number_text.h"
#include "anatomesh/base/standard_arithmetic.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/planes/path_field.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/pipeline/retry/retry_for_mean_ratio.h"
#include "anatomesh/pipeline/retry/retry_messages.h"
#include "anatomesh/pipeline/retry/retry_policy.h"
#include "anatomesh/pipeline/retry/thin_walls.h"
#include "anatomesh/pipeline/run/build_once.h"
#include "anatomesh/pipeline/run/contour_field.h"
#include "anatomesh/pipeline/run/effort.h"
#include "anatomesh/pipeline/run/prepare_run.h"

namespace anatomesh {

namespace {

// A finer run's edge length, in those of the one before: about three times the cells. [edge lengths; 0 to 1; M 2026-11, set not recorded]
constexpr double finer = 0.7;
// Of a model with edges as short as walls between structures ask for, in place of one that is refused.
// [cells; > 0; B]
constexpr double most_cells_for_walls = 2.4e7;
// The same, in place of one that misses clauses. [cells; > 0; B]
constexpr double most_cells_for_better_walls = 4e6;
// Edge lengths that differ by less are the same. [ratio; 0 to 1; D]
constexpr double same_size = 0.01;
// The next edge length, where one was tried already. [ratio; 0 to 1; D, more than same_size from 1]
constexpr double hardly_shorter = 0.975;
// Of what is drawn, by length, so much belongs to structures with such walls. [ratio; 0 to 1; M 2026-11, set not recorded]
constexpr double most_of_all = 0.5;

// With more cells of all runs together no further one is made for a better model than there is: on planes that cross they
// come at 2,000 to 10,000 a second. [cells; > 0; M 2026-12 the 8 slowest of 140 random solids]
constexpr std::size_t most_cells_of_tries = 200'000;

struct Made {
    RunOutcome outcome;
    double size_mm = 0;
};

// The best model so far, while another one is tried.
struct BestModel {
    Model model;
    RunConfig config;
    std::vector<Warning> warnings;
    Made made;
    std::size_t run = 0;  // how many runs were made when it became the best
};

// Tries until a model is as good as it can be.
class RetryDriver {
  public:
    // `known`: of the contours relative to the low corner of their box, as the stages see them.
    RetryDriver(const ContourSet& contours, FieldAndVolumes known, const ModelOptions& options,
                RunContext& context, const StageObserver& observer)
        : contours_(contours), context_(context), observer_(observer), known_(std::move(known)) {
        config_.options = options;
        config_.size_given = options.size_mm > 0;
    }

    Result<Model> run() {
        const auto start = std::chrono::steady_clock::now();
        ANATOMESH_TRY(Model model, choose());
        if (!config_.size_given) {
            ANATOMESH_TRY(model, slightly_shorter_one(std::move(model)));
        }
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        note_other_runs(model.report, seconds.count());
        model.drawn = contours_;
        ANATOMESH_CHECK_STATUS(show_again());
        model.report.run.work = work_;
        return model;
    }

  private:
    Result<Model> choose() {
        RetryPolicy policy(config_.size_given);
        for (;;) {
            BuiltOnce built = build(observer_);
            if (!built.model.ok() && built.model.error().kind == ErrorKind::cancelled)
                return std::move(built.model);
            if (count_ == 1) {
                if (std::optional<Result<Model>> model = between_walls(built)) return std::move(*model);
            }
            const NextRun next = policy.next(built.outcome, keep_the_better(built));
            if (next == NextRun::none || (best_ && was_enough())) {
                if (!best_) return std::move(built.model);
                ANATOMESH_TRY(Model model, best_model());
                // Where planes cross, contours force cells more than those between them do.
                if (!known_.slices->arrangement.is_parallel()) return model;
                return retried(std::move(model));
            }
            context_.warn(prepare(next, policy.slightly_finer(), built));
        }
    }

    // Returns the outcome of the best model so far, `built` included; it keeps that model.
    const RunOutcome* keep_the_better(BuiltOnce& built) {
        if (built.model.ok() && (!best_ || is_better(built.outcome.score, best_->made.outcome.score))) {
            best_.emplace(BestModel{std::move(built.model.value()),
                                    config_,
                                    context_.warnings,
                                    {built.outcome, built.size_mm},
                                    count_});
        }
        return best_ ? &best_->made.outcome : nullptr;
    }

    // Where structures are nested or drawn twice, walls between them all round, longer edges only cost runs:
    // the model that walls ask for, if the first one is refused, misses segments or two clauses, and it is
    // better. Where both are refused, or that would have too many cells, that is the end of it, if most of
    // what is drawn has such walls.
    std::optional<Result<Model>> between_walls(BuiltOnce& first) {
        const RunScore& was = first.outcome.score;
        const bool refused = !first.model.ok();
        const bool may_be_better =
            refused ? first.outcome.course.size_matters : was.unmet_clauses > 1 || was.missed > 0;
        if (!may_be_better || config_.size_given || contours_.structures.size() < 2 || !known_.field)
            return std::nullopt;
        const std::optional<WallSize> walls =
            wall_size(contours_, first.size_mm, known_.field->slice_spacing());
        if (!walls) return std::nullopt;
        if (walls->cells > (refused ? most_cells_for_walls : most_cells_for_better_walls)) {
            if (!refused || walls->share < most_of_all) return std::nullopt;
            Error error = first.model.error();
            error.next_step =
                "structures run about " + brief(walls->thickness_mm) +
                " mm beside each other nearly everywhere: give them a common boundary with --close-gaps, or "
                "build them one by one with --separate";
            return Result<Model>(std::move(error));
        }
        return with_walls(first, *walls);
    }

    std::optional<Result<Model>> with_walls(const BuiltOnce& first, const WallSize& walls) {
        std::vector<Warning> warnings = context_.warnings;
        const RunConfig before = config_;
        config_.options.size_mm = walls.size_mm;
        context_.warnings.resize(known_.warnings);
        BuiltOnce other = build(observer_);
        const bool is_cancelled = !other.model.ok() && other.model.error().kind == ErrorKind::cancelled;
        const bool is_taken = first.model.ok() ? is_better(other.outcome.score, first.outcome.score)
                                               : other.model.ok() || walls.share >= most_of_all;
        if (!is_taken && !is_cancelled) {
            config_ = before;
            context_.warnings = std::move(warnings);
            shown_is_another_ = true;
            return std::nullopt;
        }
        taken_ = {other.outcome, other.size_mm};
        context_.warn({"W-PIP-001",
                       "structures run about " + brief(walls.thickness_mm) +
                           " mm beside each other nearly everywhere, and edges of " + brief(first.size_mm) +
                           " mm are too long for the space between them",
                       {},
                       "the model was built again with edges of " + brief(walls.size_mm) + " mm"});
        return std::move(other.model);
    }

    bool was_enough() const { return cells_ > most_cells_of_tries; }

    BuiltOnce build(const StageObserver& observer) {
        BuiltOnce built = build_once(contours_, config_, context_, observer, known_);
        if (observer) shown_is_another_ = false;
        known_ = built.known;
        work_.add(built.work);
        sizes_.push_back(built.size_mm);
        cells_ += built.outcome.course.cells;
        ++count_;
        return built;
    }

    // Of the next run. Slightly finer ones, and what comes after them, go by the first that conformed.
    double next_size(NextRun next, std::size_t slightly_finer_runs, const BuiltOnce& built) {
        if (!built.outcome.course.conformed || first_size_mm_ == 0) first_size_mm_ = built.size_mm;
        switch (next) {
            case NextRun::slightly_finer:
                return slightly_finer_sizes[slightly_finer_runs - 1] * first_size_mm_;
            case NextRun::finer:
                first_size_mm_ = 0;
                return finer * built.size_mm;
            default:
                return first_size_mm_;
        }
    }

    // Returns what is to be said of the next run.
    Warning prepare(NextRun next, std::size_t slightly_finer_runs, const BuiltOnce& built) {
        const RunScore& score = built.outcome.score;
        const bool conformed = built.outcome.course.conformed;
        const double size_mm = next_size(next, slightly_finer_runs, built);
        const bool ill_shaped = !score.kept_contract || score.over_bound > contract::share_over_bound;
        const std::string error = built.model.ok() ? "" : built.model.error().message;
        sought_ = sought_by(next, built.outcome);
        if (conformed && next == NextRun::same_size) config_.may_conform = false;
        config_.options.size_mm = size_mm;
        if (!conformed) {
            ++config_.runs_before;
            config_.ill_shaped_before += ill_shaped;
            // Where less recovery changed nothing, the runs between this one and the one without would be the same again.
            const WorkReport before = std::exchange(last_work_, built.work);
            const bool is_the_same = before.delaunay_cells == built.work.delaunay_cells &&
                                     before.edited_cells == built.work.edited_cells;
            if (is_the_same && ill_shaped) config_.ill_shaped_before = runs_without_recovery;
        }
        if (!warnings_before_) warnings_before_ = known_.warnings;
        context_.warnings.resize(*warnings_before_);
        return built_again(next, built.outcome, error, size_mm);
    }

    // The best of those made. Where later ones were made in vain, it is said.
    Result<Model> best_model() {
        taken_ = best_->made;
        if (best_->run == count_) return std::move(best_->model);
        config_ = best_->config;
        context_.warnings = std::move(best_->warnings);
        context_.warn({"W-PIP-001",
                       "a further run was no better: " + sought_,
                       {},
                       "the model of the earlier run was kept"});
        shown_is_another_ = true;
        return std::move(best_->model);
    }

    Result<Model> retried(Model model) {
        const std::size_t warnings = known_.warnings;
        std::map<double, Made> made;  // by target mean ratio
        const auto build_again = [&](double target_mean_ratio) {
            context_.warnings.resize(warnings);
            config_.target_mean_ratio = target_mean_ratio;
            BuiltOnce built = build({});
            made[target_mean_ratio] = {built.outcome, built.size_mm};
            return std::move(built.model);
        };
        const double first = config_.target_mean_ratio;
        ANATOMESH_TRY(RetriedModel even,
                      retry_for_mean_ratio(std::move(model), taken_.size_mm, build_again, context_));
        config_.target_mean_ratio = even.target_mean_ratio.value_or(first);
        if (even.target_mean_ratio) {
            taken_ = made.at(*even.target_mean_ratio);
            shown_is_another_ = true;
        }
        return std::move(even.model);
    }

    // A better one in its place, with slightly shorter edges; until all clauses are met.
    Result<Model> slightly_shorter_one(Model model) {
        const bool tangled = is_tangled(taken_.outcome);
        const std::size_t runs = count_;
        const double first_mm = taken_.size_mm;
        BestModel best{std::move(model), config_, context_.warnings, taken_, count_};
        for (std::size_t n = 0; n < slightly_shorter.size(); ++n) {
            const bool is_worth_it = n < shorter_runs || best.made.outcome.course.cells < very_small_below;
            const bool lacks_clauses = is_worth_it && may_meet_all_clauses(best.made.outcome, runs);
            const bool untangles = tangled && n == 0;
            if ((!lacks_clauses && !untangles) || was_enough()) break;
            config_.options.size_mm = untried(slightly_shorter[n] * first_mm);
            context_.warnings.resize(warnings_before_.value_or(known_.warnings));
            BuiltOnce other = build({});
            if (!other.model.ok() && other.model.error().kind == ErrorKind::cancelled)
                return std::move(other.model);
            if (!is_better(other.outcome.score, best.made.outcome.score)) continue;
            const bool is_untangled =
                other.outcome.score.spurious_joints < best.made.outcome.score.spurious_joints;
            context_.warn(
                {"W-PIP-001",
                 "with edges of " + brief(first_mm) +
                     (is_untangled
                          ? " mm the surface was connected differently from the contours"
                          : " mm some contour segments, cross-sections or tetrahedra were not good enough"),
                 {},
                 "the model was built again with edges of " + brief(config_.options.size_mm) + " mm"});
            shown_is_another_ = true;
            taken_ = {other.outcome, other.size_mm};
            best = {std::move(other.model.value()), config_, context_.warnings, taken_, count_};
        }
        config_ = best.config;
        context_.warnings = std::move(best.warnings);
        return std::move(best.model);
    }

    // An edge length like this with which no model was built yet.
    double untried(double size_mm) const {
        const auto was_tried = [&](double size) {
            return std::any_of(sizes_.begin(), sizes_.end(),
                               [&](double tried) { return std::abs(tried - size) < same_size * size; });
        };
        while (was_tried(size_mm)) size_mm *= hardly_shorter;
        return size_mm;
    }

    // So that the stages tell the time of all runs.
    void note_other_runs(ModelReport& report, double seconds_of_all) const {
        if (count_ < 2) return;
        for (const StageReport& stage : report.run.stages) seconds_of_all -= stage.seconds;
        StageReport others;
        others.name = "other tries";
        others.seconds = std::max(0.0, seconds_of_all);
        others.points = report.counts.vertices;
        others.cells = report.counts.tetrahedra;
        others.figures = {{"tries", static_cast<double>(count_ - 1)}};
        report.run.stages.push_back(std::move(others));
    }

    // The stages that were shown last were of another model than the one that is taken.
    Status show_again() {
        if (!observer_ || !shown_is_another_) return Nothing{};
        const std::vector<Warning> warnings = context_.warnings;
        const BuiltOnce again = build(observer_);
        context_.warnings = warnings;
        if (!again.model.ok()) return again.model.error();
        return Nothing{};
    }

    const ContourSet& contours_;
    RunContext& context_;
    const StageObserver& observer_;
    RunConfig config_;
    FieldAndVolumes known_;
    std::optional<std::size_t> warnings_before_;  // of the contours and their field
    std::optional<BestModel> best_;
    std::string sought_;  // what the last run was made for
    Made taken_;          // of the model to be returned
    std::size_t count_ = 0;
    std::size_t cells_ = 0;          // of all runs
    WorkReport work_;                // of all runs
    WorkReport last_work_;           // of the last run that did not conform
    std::vector<double> sizes_;      // of all runs
    double first_size_mm_ = 0;       // of runs that conform, before slightly finer ones
    bool shown_is_another_ = false;  // the run that was shown last is not the one that is taken
};

// The contours that the surface follows, and what is known of them: where tubes of one structure meet, those inside
// another one shape the field and are left out, and so are those of slices that their path skips.
struct FollowedContours {
    ContourSet contours;
    FieldAndVolumes known;
};

void warn_of_roots(const ContourSet& contours, std::span<const std::uint8_t> inside, RunContext& context) {
    const auto first = std::find(inside.begin(), inside.end(), 1);
    const Contour& contour = contours.contours[static_cast<std::size_t>(first - inside.begin())];
    const Structure& structure = contours.structures[contour.structure];
    context.warn(
        {"W-FLD-016",
         "tubes of the structure meet, and contours of each lie inside the other one there",
         {contours.source, contours.slices[contour.slice].name,
          structure.name.empty() ? std::to_string(structure.number) : structure.name, "",
          std::to_string(std::count(inside.begin(), inside.end(), 1)) + " contours"},
         "the tubes are united; the surface does not follow these contours, which lie at the branch; the "
         "first one is named"});
}

Result<FollowedContours> followed_contours(const ContourSet& contours,
                                           std::shared_ptr<const SliceFacts> slices,
                                           const ModelOptions& options, RunContext& context) {
    FollowedContours followed{contours, {}};
    followed.known.slices = std::move(slices);
    const SliceArrangement& arrangement = followed.known.slices->arrangement;
    if (!arrangement.is_along_paths() || contours.overlapping) return followed;
    const FieldOptions field = field_options(options);
    ANATOMESH_TRY(const std::vector<std::uint8_t> inside,
                  contours_inside_other_paths(relative_to(contours.box().low, contours),
                                              *followed.known.slices, field, context));
    std::vector<std::uint8_t> not_followed = contours_off_paths(contours, *followed.known.slices);
    std::transform(inside.begin(), inside.end(), not_followed.begin(), not_followed.begin(), std::bit_or<>());
    if (std::find(not_followed.begin(), not_followed.end(), 1) == not_followed.end()) return followed;
    followed.contours = without_contours(contours, not_followed);
    if (followed.contours.contours.empty()) return FollowedContours{contours, std::move(followed.known)};
    if (std::find(inside.begin(), inside.end(), 1) != inside.end()) warn_of_roots(contours, inside, context);
    const ContourSet all = relative_to(followed.contours.box().low, contours);
    auto facts = std::make_shared<const SliceFacts>(slice_facts_of(all, options.max_gap_spacings, context));
    ANATOMESH_TRY(followed.known.field, make_structure_field(all, *facts, field, context));
    followed.known.slices = std::move(facts);
    return followed;
}

}  // namespace

Result<Model> build_model(const ContourSet& contours, const ModelOptions& options, RunContext& context,
                          const StageObserver& observer) {
    const StandardArithmetic arithmetic;
    // Once for all runs, of the set that they work on.
    const Vec3 origin = contours.points.empty() ? Vec3{} : contours.box().low;
    auto slices = std::make_shared<const SliceFacts>(
        slice_facts_of(relative_to(origin, contours), options.max_gap_spacings, context));
    if (options.caps == EndCaps::flat && !contours.contours.empty() && !slices->arrangement.is_stack() &&
        !slices->arrangement.is_along_paths()) {
        return Error{
            ErrorKind::usage,
            "E-PIP-004",
            "--caps flat does not apply: the slices cross inside the structure, so that none is the last one",
            {contours.source, "", "", "", ""},
            "give --caps half or rounded"};
    }
    ANATOMESH_TRY(FollowedContours followed,
                  followed_contours(contours, std::move(slices), options, context));
    return RetryDriver(followed.contours, std::move(followed.known), options, context, observer).run();
}

}  // namespace anatomesh
