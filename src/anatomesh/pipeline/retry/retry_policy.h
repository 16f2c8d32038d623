// RetryPolicy: whether a model is built again, and how, by what came of the last run and of the best one so far.
//
// A default edge length may be too coarse for the smallest parts, and the first runs spare work that most
// inputs do not need (dense planes, recovered subsegments, subsegments left short). So a model that breaks
// the contract is built again, first with all the work, then finer. One that keeps the contract is built
// again too, where walls came out torn, where segments were split for each other's sake and left bad cells, or
// where many cells are ill-shaped; but for the shapes only once, because contours near each other force such
// cells at any size.
//
// The policy is the table RetryPolicy::rules() in retry_policy.cpp: the first row that applies decides.
//
// Guarantees: at most `most_finer` finer runs and `most_slightly_finer` slightly finer ones; `most_same` of one size, and
// one more where a slightly finer run met a limit. O(rows).
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "anatomesh/pipeline/retry/run_score.h"

namespace anatomesh {

enum class NextRun { none, same_size, finer, slightly_finer };

// What a rule of the policy looks at.
struct RetrySituation {
    bool size_given = false;  // the edge length is the user's, and stays
    // Of the last run.
    bool refused = false;    // it broke the contract in a way that an edge length may mend
    bool met_limit = false;  // a slightly finer one broke it in another way
    bool torn = false;       // it is small enough to be built again, and a wall is torn
    // It is small enough, too many cells are above the radius-edge ratio, and that with a default size, nothing
    // more to do at this one, and no finer run made for shapes before.
    bool ill_shaped = false;
    bool conformed = false;        // it split contour segments for each other's sake
    bool conformed_badly = false;  // the same, more can be done, and that left bad cells or bumps
    bool can_do_more = false;      // the same size may be tried with more work
    bool few_unforced = false;     // it is small, and few ill-shaped cells are there that nothing forces
    // Of the best run so far, which split contour segments.
    bool best_split_segments = false;  // it is another one than the last, which did not split them
    bool best_hardly_bad = false;  // what is bad in it is less than a run would lose that does not split them
    // Runs that may still be made of each kind.
    bool may_slightly_finer = false, may_same = false, may_finer = false;
    bool was_finer_for_shape = false;  // an earlier one was made finer for the shape of cells alone
};

struct RetryRule {
    const char* when;
    NextRun next;
    bool (*applies)(const RetrySituation&);
};

class RetryPolicy {
  public:
    // So many runs may be finer. [runs; 0 to 10; B, each has about three times the cells of the one before]
    static constexpr std::size_t most_finer = 3;
    // So many runs may have the size of the one before and other work. [runs; 0 to 10; B]
    static constexpr std::size_t most_same = 4;
    // So many runs may be slightly finer. [runs; 0 to 10; B, one for each of slightly_finer_sizes]
    static constexpr std::size_t most_slightly_finer = 4;
    // A model that keeps the contract is built again below this. [cells; > 0; B, such a run takes about a minute]
    static constexpr std::size_t again_below = 800000;
    // One that split segments and is bad is built slightly finer below this. [cells; > 0; B]
    static constexpr std::size_t slightly_finer_below = 100000;

    // `size_given`: the edge length is the user's, and stays.
    explicit RetryPolicy(bool size_given) : size_given_(size_given) {}

    // The table: the last row always applies.
    static std::span<const RetryRule> rules();

    // `last`: of the latest run; `best`: of the best one that keeps the contract, the latest included, if there is one.
    NextRun next(const RunOutcome& last, const RunOutcome* best);

    // Of the slightly finer runs so far.
    std::size_t slightly_finer() const { return slightly_finer_; }

  private:
    RetrySituation situation(const RunOutcome& last, const RunOutcome* best) const;

    bool size_given_, finer_for_shape_ = false;
    std::size_t finer_ = 0, same_ = 0, slightly_finer_ = 0;
};

// Edge lengths of slightly finer runs, in those of the first that split segments: other luck at little cost.
// [edge lengths; 0 to 1; M 2026-11, docs/experiments/2026-11-28-retries.md]
inline constexpr std::array<double, RetryPolicy::most_slightly_finer> slightly_finer_sizes{0.9, 0.8, 0.7,
                                                                                           0.56};

// Whether a run split segments for each other's sake and that left bad cells, or bumps between dense planes.
bool conformed_badly(const RunOutcome& outcome);

// Where planes cross, it is luck, a few places in tens of thousands, where surfaces are joined otherwise than
// contours show, where segments are no edges, and which cells are bad. A small model with such places is built
// again with slightly shorter edges: with the first of these for either reason, with the others where a clause
// is not met; a very small one with all of them. The better one is taken (is_better()).
// [edge lengths; 0 to 1; M 2026-11, docs/experiments/2026-11-28-retries.md]
inline constexpr std::array<double, 8> slightly_shorter{0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6};
// So many of these are tried for a model that is not very small. [runs; 0 to 8; B]
inline constexpr std::size_t shorter_runs = 4;
// A model of fewer cells is very small: all of them may be tried. [cells; > 0; B]
inline constexpr std::size_t very_small_below = 25000;

bool is_tangled(const RunOutcome& outcome);

// `runs`: so far. Not after many, nor where slices contradict each other: no model has all of them.
bool may_meet_all_clauses(const RunOutcome& outcome, std::size_t runs);

}  // namespace anatomesh
