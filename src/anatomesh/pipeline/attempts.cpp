#include "anatomesh/pipeline/attempts.h"

#include "anatomesh/measure/certificate.h"

namespace anatomesh {

namespace {

// Of cells: such a model is no matter of luck.
constexpr double most_unforced = 2 * certificate_share_over_bound;

}  // namespace

NextTry Attempts::next(const TryOutcome& last) {
    const bool refused = !last.kept_contract && last.size_matters;
    const bool small = last.kept_contract && last.cells < again_below;
    const bool torn = small && last.tore_walls;
    const bool ill_shaped = small && !size_given_ && !last.spared_work && !finer_for_shape_ &&
                            last.over_bound > certificate_share_over_bound;
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

}  // namespace anatomesh
