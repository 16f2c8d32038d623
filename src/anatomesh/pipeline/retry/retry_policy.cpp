#include "anatomesh/pipeline/retry/retry_policy.h"

#include <algorithm>

#include "anatomesh/base/contract.h"
#include "anatomesh/measure/certificate.h"

namespace anatomesh {

namespace {

// Of cells: such a model is no matter of luck.
constexpr double most_unforced = 2 * contract::share_over_bound;
// A model that lacks no more than this share of the segments that another one lacks has more contours.
constexpr double fewer_missed = 0.75;
constexpr double least_gain = 0.005;       // of the segments
constexpr double most_tangles = 4;         // times those of the other one
constexpr double some_bad = 1e-3;          // of cells
constexpr double unwarned_distance = 0.5;  // in edge lengths: warned of is what is further off (W-PIP-008)
constexpr double as_far = 1.25;            // times the other one's distance
// In edge lengths: of one that meets all clauses, in place of one that does not.
constexpr double bearable_distance = 0.75;
constexpr double twice_as_far = 2;           // the same, of one that meets more clauses
constexpr double few_missed = 5e-3;          // of the segments
constexpr std::size_t small_below = 100000;  // cells
constexpr std::size_t most_runs = 6;         // before it is no luck any more

// Whether it is all that is promised, wherever its surface goes between contours.
bool meets_all(const RunScore& score) {
    return score.kept_contract && score.unmet_clauses == 0 && score.spurious_joints == 0 && !score.torn;
}

bool lacks_fewer(const RunScore& one, const RunScore& other) {
    return one.missed <= fewer_missed * other.missed && one.missed <= other.missed - least_gain;
}

}  // namespace

NextRun RetryPolicy::next(const RunScore& last, const RunScore* kept) {
    if (kept && last.kept_contract && has_more_contours(*kept, last)) return NextRun::none;
    const bool refused = !last.kept_contract && last.size_matters;
    const bool small = last.kept_contract && last.cells < again_below;
    const bool torn = small && last.torn;
    const bool ill_shaped = small && !size_given_ && !last.reduced_effort && !finer_for_shape_ &&
                            last.over_bound > contract::share_over_bound;
    // What a finer size only made worse stays as it was.
    const bool conformed_badly = small && last.reduced_effort && last.conformed_badly;
    // One that met a limit, or else, with shorter edges: the length before had none.
    if (last.conformed && conforming_ > 0 && !last.kept_contract && !last.size_matters)
        return NextRun::same_size;
    if (!(refused || torn || ill_shaped || conformed_badly) || (refused && finer_for_shape_))
        return NextRun::none;
    if (last.conformed && (refused || conformed_badly) && !size_given_ && conforming_ < most_conforming &&
        last.cells < conforming_below && last.unforced <= most_unforced) {
        ++conforming_;
        return NextRun::slightly_finer;
    }
    if (last.reduced_effort && (refused || conformed_badly || !size_given_))
        return same_++ < most_same ? NextRun::same_size : NextRun::none;
    if (size_given_ || finer_ == most_finer) return NextRun::none;
    ++finer_;
    finer_for_shape_ = finer_for_shape_ || (ill_shaped && !torn);
    return NextRun::finer;
}

bool has_more_contours(const RunScore& kept, const RunScore& other) {
    if (!kept.conformed_badly || other.conformed || kept.torn || !lacks_fewer(kept, other)) return false;
    // As many times the components and handles as the other one lacks times the segments.
    const double times =
        other.missed < most_tangles * kept.missed ? other.missed / kept.missed : most_tangles;
    const double far = meets_all(kept) && !meets_all(other) ? bearable_distance : unwarned_distance;
    return static_cast<double>(kept.components_and_handles) <=
               times * static_cast<double>(other.components_and_handles) &&
           kept.bad <= some_bad && kept.farthest <= std::max(far, as_far * other.farthest);
}

bool is_hardly_bad(const RunScore& kept) {
    return kept.conformed_badly && !kept.torn && kept.bad <= RetryPolicy::few_bad &&
           (!kept.deviates || kept.farthest <= unwarned_distance);
}

bool is_tangled(const RunScore& score) {
    return score.kept_contract && score.spurious_joints > 0 && score.cells < small_below;
}

bool may_meet_all_clauses(const RunScore& score, std::size_t runs) {
    return score.kept_contract && score.unmet_clauses > 0 && !score.contradicted &&
           score.cells < small_below && runs <= most_runs;
}

bool meets_more_clauses(const RunScore& later, const RunScore& kept) {
    const bool lacks_no_more = !later.lacks_contours || (kept.lacks_contours && later.missed <= kept.missed);
    const bool joined_no_worse = later.spurious_joints <= kept.spurious_joints ||
                                 later.components_and_handles < kept.components_and_handles;
    const bool as_near = later.farthest <= std::max(unwarned_distance, twice_as_far * kept.farthest);
    return later.kept_contract && lacks_no_more && joined_no_worse && as_near && (kept.torn || !later.torn) &&
           later.unmet_clauses < kept.unmet_clauses;
}

bool is_less_tangled(const RunScore& later, const RunScore& kept) {
    return later.kept_contract && later.spurious_joints < kept.spurious_joints &&
           later.unmet_clauses <= kept.unmet_clauses && later.missed <= kept.missed + few_missed &&
           (kept.deviates || !later.deviates);
}

bool is_worse(const RunScore& later, const RunScore& kept) {
    const auto is_whole = [](const RunScore& one) {
        return meets_all(one) && one.bad <= RetryPolicy::few_bad && one.farthest <= unwarned_distance;
    };
    if (is_whole(later) != is_whole(kept)) return is_whole(kept);
    if (later.deviates != kept.deviates) return later.deviates;
    if (later.deviates) {
        const bool is_far = later.farthest > unwarned_distance;
        if (is_far != (kept.farthest > unwarned_distance)) return is_far;
        if (lacks_fewer(kept, later)) return true;
        if (!lacks_fewer(later, kept) && later.components_and_handles > kept.components_and_handles)
            return true;
    }
    return later.bad > RetryPolicy::few_bad && later.bad >= kept.bad;
}

}  // namespace anatomesh
