#include "anatomesh/pipeline/retry/retry_policy.h"

#include <algorithm>

#include "anatomesh/base/contract.h"

namespace anatomesh {

namespace {

// With more ill-shaped cells that nothing forces, a model that split segments is no matter of luck.
// [share of the cells; 0 to 1; M 2026-11, docs/experiments/2026-11-28-retries.md]
constexpr double most_unforced = 2 * contract::share_over_bound;
// A model is built with slightly shorter edges below this. [cells; > 0; B]
constexpr std::size_t small_below = 100000;
// After so many runs it is no luck any more. [runs; 1 to 20; B]
constexpr std::size_t most_runs = 6;

bool wants_another_run(const RetrySituation& is) {
    return is.refused || is.met_limit || is.torn || is.ill_shaped || is.conformed_badly;
}

constexpr std::array<RetryRule, 9> table{{
    {"the best run split segments, and one without that is no better", NextRun::none,
     [](const RetrySituation& is) { return is.best_split_segments; }},
    {"nothing is there that another run may mend", NextRun::none,
     [](const RetrySituation& is) { return !wants_another_run(is); }},
    {"a run that was finer for the shape of cells alone is refused", NextRun::none,
     [](const RetrySituation& is) { return is.refused && is.was_finer_for_shape; }},
    {"segments were split, and by luck that left a few bad cells", NextRun::slightly_finer,
     [](const RetrySituation& is) {
         return is.conformed && (is.refused || is.conformed_badly) && !is.size_given && is.few_unforced &&
                is.may_slightly_finer;
     }},
    {"segments were split, and the best model is hardly bad", NextRun::none,
     [](const RetrySituation& is) {
         return is.conformed && is.best_hardly_bad && (is.met_limit || is.can_do_more);
     }},
    {"a slightly finer run met a limit, so that segments are not to be split", NextRun::same_size,
     [](const RetrySituation& is) { return is.met_limit; }},
    {"the same size may be tried with more work", NextRun::same_size,
     [](const RetrySituation& is) {
         return is.can_do_more && is.may_same && (is.refused || is.conformed_badly || !is.size_given);
     }},
    {"all that can be done was done, and the size is free", NextRun::finer,
     [](const RetrySituation& is) { return !is.can_do_more && !is.size_given && is.may_finer; }},
    {"anything else", NextRun::none, [](const RetrySituation&) { return true; }},
}};

}  // namespace

std::span<const RetryRule> RetryPolicy::rules() {
    return table;
}

RetrySituation RetryPolicy::situation(const RunOutcome& last, const RunOutcome* best) const {
    const RunScore& score = last.score;
    const RunCourse& course = last.course;
    const bool small = score.kept_contract && course.cells < again_below;
    RetrySituation is;
    is.size_given = size_given_;
    is.refused = !score.kept_contract && course.size_matters;
    is.met_limit = course.conformed && slightly_finer_ > 0 && !score.kept_contract && !course.size_matters;
    is.torn = small && score.torn;
    is.ill_shaped = small && !size_given_ && !course.can_do_more && !finer_for_shape_ &&
                    score.over_bound > contract::share_over_bound;
    is.conformed = course.conformed;
    is.conformed_badly = small && course.can_do_more && conformed_badly(last);
    is.can_do_more = course.can_do_more;
    is.few_unforced = course.cells < slightly_finer_below && course.unforced <= most_unforced;
    is.best_split_segments = best && best->course.conformed && score.kept_contract && !course.conformed &&
                             !is_better(score, best->score);
    is.best_hardly_bad = best && conformed_badly(*best) && !best->score.torn && best->score.bad <= few_bad &&
                         (!best->score.deviates || best->score.farthest <= warned_distance);
    is.may_slightly_finer = slightly_finer_ < most_slightly_finer;
    is.may_same = same_ < most_same;
    is.may_finer = finer_ < most_finer;
    is.was_finer_for_shape = finer_for_shape_;
    return is;
}

NextRun RetryPolicy::next(const RunOutcome& last, const RunOutcome* best) {
    const RetrySituation is = situation(last, best);
    const NextRun next = std::find_if(table.begin(), table.end(), [&](const RetryRule& rule) {
                             return rule.applies(is);
                         })->next;
    slightly_finer_ += next == NextRun::slightly_finer;
    same_ += next == NextRun::same_size && !is.met_limit;
    finer_ += next == NextRun::finer;
    finer_for_shape_ = finer_for_shape_ || (next == NextRun::finer && is.ill_shaped && !is.torn);
    return next;
}

bool conformed_badly(const RunOutcome& outcome) {
    return outcome.course.conformed && (outcome.score.bad > 0 || outcome.score.deviates);
}

bool is_tangled(const RunOutcome& outcome) {
    return outcome.score.kept_contract && outcome.score.spurious_joints > 0 &&
           outcome.course.cells < small_below;
}

bool may_meet_all_clauses(const RunOutcome& outcome, std::size_t runs) {
    return outcome.score.kept_contract && outcome.score.unmet_clauses > 0 && !outcome.course.contradicted &&
           outcome.course.cells < small_below && runs <= most_runs;
}

}  // namespace anatomesh
