#include "anatomesh/pipeline/build_model.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/contour/model/message_text.h"
#include "anatomesh/measure/certificate.h"
#include "anatomesh/pipeline/build_once.h"
#include "anatomesh/pipeline/model_warnings.h"
#include "anatomesh/pipeline/retry/attempts.h"
#include "anatomesh/pipeline/retry/even_out.h"
#include "anatomesh/pipeline/retry/thin_walls.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/arrangement/sweep.h"

namespace anatomesh {

namespace {

constexpr double finer = 0.7;  // a further try's edge length, in those of the one before
// Of slightly finer tries, in those of the first.
constexpr std::array<double, Attempts::most_conforming> slightly_finer{0.9, 0.8, 0.7, 0.56};

// Of a model with edges as short as walls between structures ask for, in place of one that is refused, and of
// one that misses clauses.
constexpr double most_cells_for_walls = 2.4e7, most_cells_for_better_walls = 4e6;
constexpr double same_size = 0.01, hardly_shorter = 0.975;  // of edge lengths
constexpr double most_of_all = 0.5;  // of what is drawn, by length, belongs to structures with such walls

struct Made {
    TryOutcome outcome;
    double size_mm = 0;
};

// A model that keeps the contract, while another one is tried.
struct KeptModel {
    Model model;
    Trial trial;
    std::vector<Warning> warnings;
    Made made;
    std::string sought;  // what another one was tried for
};

// Whether another model does not mend what it was tried for.
bool is_in_vain(const KeptModel& kept, const BuiltOnce& other, const Attempts& attempts) {
    if (!other.model.ok() || has_more_contours(kept.made.outcome, other.outcome)) return true;
    if (attempts.finer_for_shape() && other.outcome.over_bound >= kept.made.outcome.over_bound) return true;
    return kept.made.outcome.conformed_badly && !kept.made.outcome.astray && !kept.made.outcome.tore_walls &&
           other.outcome.bad > 0 &&
           kept.made.outcome.unforced <= std::max(other.outcome.unforced, contract::share_over_bound);
}

// Tries until a model is as good as it can be.
class Tries {
  public:
    Tries(const ContourSet& contours, const ModelOptions& options, RunContext& context,
          const StageObserver& observer)
        : contours_(contours), context_(context), observer_(observer) {
        trial_.options = options;
        trial_.size_given = options.size_mm > 0;
    }

    Result<Model> run() {
        const auto start = std::chrono::steady_clock::now();
        ANATOMESH_TRY(Model model, choose());
        if (!trial_.size_given) {
            ANATOMESH_TRY(model, slightly_shorter_one(std::move(model)));
        }
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        note_other_tries(model.report, seconds.count());
        model.drawn = contours_;
        ANATOMESH_CHECK_STATUS(show_again());
        model.report.work = work_;
        return model;
    }

  private:
    Result<Model> choose() {
        Attempts attempts(trial_.size_given);
        for (;;) {
            BuiltOnce built = build(observer_);
            if (!built.model.ok() && built.model.error().kind == ErrorKind::cancelled)
                return std::move(built.model);
            if (count_ == 1) {
                if (std::optional<Result<Model>> model = between_walls(built)) return std::move(*model);
            }
            const NextTry next = attempts.next(built.outcome, kept_ ? &kept_->made.outcome : nullptr);
            if (next == NextTry::none) {
                if (kept_ && is_in_vain(*kept_, built, attempts)) return before_it();
                taken_ = {built.outcome, built.size_mm};
                // Where planes cross, contours force cells more than those between them do.
                if (!built.model.ok() || !is_parallel(contours_)) return std::move(built.model);
                return evened(std::move(built));
            }
            const Warning again = prepare(next, attempts.slightly_finer(), std::move(built));
            if (!trial_.may_conform && kept_ && is_hardly_bad(kept_->made.outcome)) return conforming_one();
            context_.warn(again);
        }
    }

    // Where structures are nested or drawn twice, walls between them all round, longer edges only cost tries:
    // the model that walls ask for, if the first one is refused, misses segments or two clauses, and it is
    // better. Where both are refused, or that would have too many cells, that is the end of it, if most of
    // what is drawn has such walls.
    std::optional<Result<Model>> between_walls(BuiltOnce& first) {
        const TryOutcome& was = first.outcome;
        const bool refused = !first.model.ok();
        const bool may_be_better = refused ? was.size_matters : was.unmet > 1 || was.missed > 0;
        if (!may_be_better || trial_.size_given || contours_.structures.size() < 2 || !known_.field)
            return std::nullopt;
        const std::optional<WallSize> walls =
            wall_size(contours_, first.size_mm, known_.field->slice_spacing());
        if (!walls) return std::nullopt;
        if (walls->cells > (refused ? most_cells_for_walls : most_cells_for_better_walls)) {
            if (!refused || walls->share < most_of_all) return std::nullopt;
            Error error = first.model.error();
            error.next_step = "structures run about " + brief(walls->thickness_mm) +
                              " mm beside each other nearly everywhere: --close-gaps gives them one wall, or "
                              "build them one by one (--separate)";
            return Result<Model>(std::move(error));
        }
        return with_walls(first, *walls);
    }

    std::optional<Result<Model>> with_walls(const BuiltOnce& first, const WallSize& walls) {
        std::vector<Warning> warnings = context_.warnings;
        const Trial before = trial_;
        trial_.options.size_mm = walls.size_mm;
        context_.warnings.resize(known_.warnings);
        BuiltOnce other = build(observer_);
        const bool is_cancelled = !other.model.ok() && other.model.error().kind == ErrorKind::cancelled;
        const bool is_better = first.model.ok()
                                   ? other.model.ok() && other.outcome.unmet < first.outcome.unmet
                                   : other.model.ok() || walls.share >= most_of_all;
        if (!is_better && !is_cancelled) {
            trial_ = before;
            context_.warnings = std::move(warnings);
            shown_is_another_ = true;
            return std::nullopt;
        }
        taken_ = {other.outcome, other.size_mm};
        context_.warn({"W-PIP-001",
                       "structures run about " + brief(walls.thickness_mm) +
                           " mm beside each other nearly everywhere, and edges of " + brief(first.size_mm) +
                           " mm are too long for what lies between",
                       {},
                       "built again with " + brief(walls.size_mm) + " mm"});
        return std::move(other.model);
    }

    BuiltOnce build(const StageObserver& observer) {
        BuiltOnce built = build_once(contours_, trial_, context_, observer, known_);
        known_ = built.known;
        work_.add(built.work);
        sizes_.push_back(built.size_mm);
        ++count_;
        return built;
    }

    // Of the next try. Slightly finer ones, and what comes after them, go by the first that conformed.
    double next_size(NextTry next, std::size_t slightly_finer_tries, const BuiltOnce& built) {
        if (!built.outcome.conformed || first_size_mm_ == 0) first_size_mm_ = built.size_mm;
        switch (next) {
            case NextTry::slightly_finer:
                return slightly_finer[slightly_finer_tries - 1] * first_size_mm_;
            case NextTry::finer:
                first_size_mm_ = 0;
                return finer * built.size_mm;
            default:
                return first_size_mm_;
        }
    }

    // Returns what is to be said of the next try.
    Warning prepare(NextTry next, std::size_t slightly_finer_tries, BuiltOnce built) {
        const bool conformed = built.outcome.conformed;
        const double size_mm = next_size(next, slightly_finer_tries, built);
        const bool ill_shaped =
            !built.outcome.kept_contract || built.outcome.over_bound > contract::share_over_bound;
        const std::string error = built.model.ok() ? "" : built.model.error().message;
        const Warning again = built_again(next, built.outcome, error, size_mm);
        if (built.model.ok() &&
            !(kept_ && built.outcome.conformed_badly && is_worse(built.outcome, kept_->made.outcome))) {
            kept_.emplace(KeptModel{std::move(built.model.value()),
                                    trial_,
                                    context_.warnings,
                                    {built.outcome, built.size_mm},
                                    sought_by(next, built.outcome)});
        }
        if (conformed && next == NextTry::same_size) trial_.may_conform = false;
        trial_.options.size_mm = size_mm;
        if (!conformed) {
            ++trial_.before;
            trial_.ill_shaped_before += ill_shaped;
        }
        if (!warnings_before_) warnings_before_ = known_.warnings;
        context_.warnings.resize(*warnings_before_);
        return again;
    }

    // Of those tried that split contour segments for each other's sake the least bad.
    Result<Model> conforming_one() {
        context_.warnings = std::move(kept_->warnings);
        trial_ = kept_->trial;
        taken_ = kept_->made;
        shown_is_another_ = count_ > 1;
        return std::move(kept_->model);
    }

    Result<Model> before_it() {
        context_.warnings = std::move(kept_->warnings);
        context_.warn({"W-PIP-001",
                       kept_->sought + " was tried, and was no better",
                       {},
                       "the model before it was kept"});
        trial_ = kept_->trial;
        taken_ = kept_->made;
        shown_is_another_ = true;
        return std::move(kept_->model);
    }

    Result<Model> evened(BuiltOnce built) {
        const std::size_t warnings = built.known.warnings;
        const auto build_even = [&](double even_mean) {
            context_.warnings.resize(warnings);
            trial_.even_mean = even_mean;
            return build({}).model;
        };
        const double first = trial_.even_mean;
        ANATOMESH_TRY(EvenedModel even,
                      even_out(std::move(built.model.value()), built.size_mm, build_even, context_));
        trial_.even_mean = even.even_mean.value_or(first);
        shown_is_another_ = even.even_mean.has_value();
        return std::move(even.model);
    }

    // Another one in its place, with slightly shorter edges, if that is joined more as drawn, or has the
    // contours that it lacks; until all clauses are met.
    Result<Model> slightly_shorter_one(Model model) {
        const bool tangled = is_tangled(taken_.outcome);
        const std::size_t tries = count_;
        const double first_mm = taken_.size_mm;
        KeptModel best{std::move(model), trial_, context_.warnings, taken_, ""};
        for (std::size_t n = 0; n < slightly_shorter.size(); ++n) {
            const double share = slightly_shorter[n];
            const bool is_worth_it = n < shorter_tries || best.made.outcome.cells < very_small_below;
            const bool lacks_clauses = is_worth_it && may_meet_all_clauses(best.made.outcome, tries);
            const bool untangles = tangled && n == 0;
            if (!lacks_clauses && !untangles) break;
            trial_.options.size_mm = untried(share * first_mm);
            context_.warnings.resize(warnings_before_.value_or(known_.warnings));
            BuiltOnce other = build({});
            if (!other.model.ok() && other.model.error().kind == ErrorKind::cancelled)
                return std::move(other.model);
            const bool is_untangled = untangles && is_less_tangled(other.outcome, best.made.outcome);
            if (!is_untangled && !(lacks_clauses && meets_more_clauses(other.outcome, best.made.outcome)))
                continue;
            context_.warn(
                {"W-PIP-001",
                 "with " + brief(first_mm) +
                     (is_untangled ? " mm the surface was joined otherwise than the contours show"
                                   : " mm single contour segments, cuts or cells were not as they may be"),
                 {},
                 "built again with " + brief(trial_.options.size_mm) + " mm"});
            shown_is_another_ = true;
            taken_ = {other.outcome, other.size_mm};
            best = {std::move(other.model.value()), trial_, context_.warnings, taken_, ""};
        }
        trial_ = best.trial;
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

    // So that the stages tell the time of all tries.
    void note_other_tries(ModelReport& report, double seconds_of_all) const {
        if (count_ < 2) return;
        for (const StageReport& stage : report.stages) seconds_of_all -= stage.seconds;
        StageReport others;
        others.name = "other tries";
        others.seconds = std::max(0.0, seconds_of_all);
        others.points = report.vertices;
        others.cells = report.tetrahedra;
        others.figures = {{"tries", static_cast<double>(count_ - 1)}};
        report.stages.push_back(std::move(others));
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
    Trial trial_;
    FieldAndVolumes known_;
    std::optional<std::size_t> warnings_before_;  // of the contours and their field
    std::optional<KeptModel> kept_;
    Made taken_;  // of the model to be returned
    std::size_t count_ = 0;
    WorkReport work_;            // of all tries
    std::vector<double> sizes_;  // of all tries
    double first_size_mm_ = 0;   // of tries that conform, before slightly finer ones
    bool shown_is_another_ = false;
};

}  // namespace

Result<Model> build_model(const ContourSet& contours, const ModelOptions& options, RunContext& context,
                          const StageObserver& observer) {
    if (options.caps == EndCaps::flat && !contours.contours.empty() && !is_parallel(contours) &&
        !Sweep::of(contours)) {
        return Error{
            ErrorKind::usage,
            "E-PIP-004",
            "slices that cross where something is drawn have no last ones on which it could end flat",
            {contours.source, "", "", "", ""},
            "give --caps half or rounded"};
    }
    return Tries(contours, options, context, observer).run();
}

}  // namespace anatomesh
