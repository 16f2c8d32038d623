// Whether a model is built again: by what came of it, and of those before.
//
// A default edge length may be too coarse for the smallest parts, and the first runs spare work that most
// inputs do not need (dense planes, recovered subsegments, subsegments left short). So a model that breaks
// the contract is built again, first with all the work, then finer. One that keeps the contract is built
// again too, where walls came out torn that a finer edge length may keep whole, where contour segments were
// split for each other's sake and left ill-shaped cells, or where many cells are ill-shaped; but for the
// shapes only once: where two contours lie a hundredth of an edge from each other, any size has such cells,
// and each run costs three times the one before it.
//
// Where contour segments were split for each other's sake (planes that cross) and that broke the contract or
// left ill-shaped cells, it is luck which, a few in tens of thousands: it is done again with a slightly finer
// size first, and given up only then; at once where more than a hundredth of the cells are ill-shaped though
// nothing forces them. One of the models so made is taken after all where the one without lacks far more
// segments (has_more_contours()): then none finer is tried.
//
// Guarantees: at most `most_finer` finer runs, `most_same` of one size, and `most_conforming` slightly
// finer ones. O(1).
#pragma once

#include <array>
#include <cstddef>

#include "anatomesh/pipeline/retry/run_score.h"

namespace anatomesh {

enum class NextRun { none, same_size, finer, slightly_finer };

class RetryPolicy {
  public:
    static constexpr std::size_t most_finer = 3, most_same = 4, most_conforming = 4;
    static constexpr std::size_t again_below = 800000;       // cells of a model that keeps the contract
    static constexpr std::size_t conforming_below = 100000;  // of one that conformed badly
    // Of cells: so few for which clause 4 is not kept are less than the contour segments that would be lost.
    static constexpr double few_bad = 1e-4;

    // `size_given`: the edge length is the user's, and stays.
    explicit RetryPolicy(bool size_given) : size_given_(size_given) {}

    // `last`: of the latest run; `kept`: of the model kept of those before, if there is one.
    NextRun next(const RunScore& last, const RunScore* kept = nullptr);

    // Of the slightly finer runs so far.
    std::size_t slightly_finer() const { return conforming_; }

    // Whether a model of too many ill-shaped cells is why the latest run was finer.
    bool finer_for_shape() const { return finer_for_shape_; }

  private:
    bool size_given_, finer_for_shape_ = false;
    std::size_t finer_ = 0, same_ = 0, conforming_ = 0;
};

// Whether a model that conformed badly has so many more of its contours than another one, which did not
// conform, that this is worth more than what is bad in it: single ill-shaped cells, and a surface off the
// field's by half an edge length (three quarters where it meets all clauses and the other one does not), or a
// quarter further than the other's. Not where its surfaces have more times the components and handles in all
// than the other one lacks times the segments, or more than four times.
bool has_more_contours(const RunScore& kept, const RunScore& other);

// Whether a model that conformed badly is hardly bad: with few bad cells, no torn walls, and a surface off
// the field's by half an edge length at most. One that does not conform lacks a tenth of the segments and
// more where planes are dense, and takes several runs: none is made for this.
bool is_hardly_bad(const RunScore& kept);

// Where planes cross it is luck, a few places in tens of thousands, where surfaces are joined otherwise than
// contours show, and where contour segments are no edges of the surface, a cut is not what is drawn or cells
// are ill-shaped. A small model with such places is built again with slightly shorter edges: with the first
// of these, in its edge lengths, for either reason, with the others where a clause is not met: a very small
// one with all of them.
inline constexpr std::array<double, 8> slightly_shorter{0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6};
inline constexpr std::size_t shorter_runs = 4;
inline constexpr std::size_t very_small_below = 25000;  // cells
bool is_tangled(const RunScore& score);
// `runs`: so far. Not after many, nor where slices contradict each other: no model has all of them.
bool may_meet_all_clauses(const RunScore& score, std::size_t runs);
// Whether a later model than one that may meet all clauses meets more, has all contours, or, if that lacks
// some, no fewer, and is joined as much as drawn, or has fewer components and handles; and its walls are not
// torn, nor is its surface off the field's by more than half an edge length and twice the other one's
// distance.
bool meets_more_clauses(const RunScore& later, const RunScore& kept);

// Whether a later model has fewer such places than one that is tangled, and is no worse: it meets as many
// clauses, lacks no more contour segments, or 5 in 1,000, and its surface does not deviate where the
// other's does not.
bool is_less_tangled(const RunScore& later, const RunScore& kept);

// Whether of two that conformed badly the later one is worse. If one alone meets all clauses, with few bad
// cells and a surface off the field's by half an edge length at most, the other one is. Of those with few bad
// cells it is not, for it is finer, unless both deviate and it alone by more than half an edge length, or
// both or none so far and the first has more contours, or as many and fewer components and handles.
bool is_worse(const RunScore& later, const RunScore& kept);

}  // namespace anatomesh
