#include "anatomesh/pipeline/retry/attempts.h"

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
constexpr std::size_t most_tries = 6;        // before it is no luck any more

// Whether it is all that is promised, wherever its surface goes between contours.
bool meets_all(const TryOutcome& outcome) {
    return outcome.kept_contract && outcome.unmet == 0 && outcome.untold == 0 && !outcome.tore_walls;
}

bool lacks_fewer(const TryOutcome& one, const TryOutcome& other) {
    return one.missed <= fewer_missed * other.missed && one.missed <= other.missed - least_gain;
}

}  // namespace

NextTry Attempts::next(const TryOutcome& last, const TryOutcome* kept) {
    if (kept && last.kept_contract && has_more_contours(*kept, last)) return NextTry::none;
    const bool refused = !last.kept_contract && last.size_matters;
    const bool small = last.kept_contract && last.cells < again_below;
    const bool torn = small && last.tore_walls;
    const bool ill_shaped = small && !size_given_ && !last.spared_work && !finer_for_shape_ &&
                            last.over_bound > contract::share_over_bound;
    // What a finer size only made worse stays as it was.
    const bool conformed_badly = small && last.spared_work && last.conformed_badly;
    // One that met a limit, or else, with shorter edges: the length before had none.
    if (last.conformed && conforming_ > 0 && !last.kept_contract && !last.size_matters)
        return NextTry::same_size;
    if (!(refused || torn || ill_shaped || conformed_badly) || (refused && finer_for_shape_))
        return NextTry::none;
    if (last.conformed && (refused || conformed_badly) && !size_given_ && conforming_ < most_conforming &&
        last.cells < conforming_below && last.unforced <= most_unforced) {
        ++conforming_;
        return NextTry::slightly_finer;
    }
    if (last.spared_work && (refused || conformed_badly || !size_given_))
        return same_++ < most_same ? NextTry::same_size : NextTry::none;
    if (size_given_ || finer_ == most_finer) return NextTry::none;
    ++finer_;
    finer_for_shape_ = finer_for_shape_ || (ill_shaped && !torn);
    return NextTry::finer;
}

bool has_more_contours(const TryOutcome& kept, const TryOutcome& other) {
    if (!kept.conformed_badly || other.conformed || kept.tore_walls || !lacks_fewer(kept, other))
        return false;
    // As many times the components and handles as the other one lacks times the segments.
    const double times =
        other.missed < most_tangles * kept.missed ? other.missed / kept.missed : most_tangles;
    const double far = meets_all(kept) && !meets_all(other) ? bearable_distance : unwarned_distance;
    return static_cast<double>(kept.tangles) <= times * static_cast<double>(other.tangles) &&
           kept.bad <= some_bad && kept.farthest <= std::max(far, as_far * other.farthest);
}

bool is_hardly_bad(const TryOutcome& kept) {
    return kept.conformed_badly && !kept.tore_walls && kept.bad <= Attempts::few_bad &&
           (!kept.astray || kept.farthest <= unwarned_distance);
}

bool is_tangled(const TryOutcome& outcome) {
    return outcome.kept_contract && outcome.untold > 0 && outcome.cells < small_below;
}

bool may_meet_all_clauses(const TryOutcome& outcome, std::size_t tries) {
    return outcome.kept_contract && outcome.unmet > 0 && !outcome.contradicted &&
           outcome.cells < small_below && tries <= most_tries;
}

bool meets_more_clauses(const TryOutcome& later, const TryOutcome& kept) {
    const bool lacks_no_more = !later.lacks_contours || (kept.lacks_contours && later.missed <= kept.missed);
    const bool joined_no_worse = later.untold <= kept.untold || later.tangles < kept.tangles;
    const bool as_near = later.farthest <= std::max(unwarned_distance, twice_as_far * kept.farthest);
    return later.kept_contract && lacks_no_more && joined_no_worse && as_near &&
           (kept.tore_walls || !later.tore_walls) && later.unmet < kept.unmet;
}

bool is_less_tangled(const TryOutcome& later, const TryOutcome& kept) {
    return later.kept_contract && later.untold < kept.untold && later.unmet <= kept.unmet &&
           later.missed <= kept.missed + few_missed && (kept.astray || !later.astray);
}

bool is_worse(const TryOutcome& later, const TryOutcome& kept) {
    const auto is_whole = [](const TryOutcome& one) {
        return meets_all(one) && one.bad <= Attempts::few_bad && one.farthest <= unwarned_distance;
    };
    if (is_whole(later) != is_whole(kept)) return is_whole(kept);
    if (later.astray != kept.astray) return later.astray;
    if (later.astray) {
        const bool is_far = later.farthest > unwarned_distance;
        if (is_far != (kept.farthest > unwarned_distance)) return is_far;
        if (lacks_fewer(kept, later)) return true;
        if (!lacks_fewer(later, kept) && later.tangles > kept.tangles) return true;
    }
    return later.bad > Attempts::few_bad && later.bad >= kept.bad;
}

}  // namespace anatomesh
