#include "anatomesh/reconcile/compare/reconcile_warnings.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "anatomesh/base/number_text.h"

namespace anatomesh {

namespace {

// So many pairs of slices are named one by one, the worst first; of the others the number is told.
// [warnings; >= 1; B]
constexpr std::size_t most_named_pairs = 10;
// Pairs of slices are named that differ by more than this. [working units; >= 0; C W-RCN-003]
constexpr double named_gap = 0.5;
// They also differ by more than this share of the bound. [1; 0 to 1; C W-RCN-003]
constexpr double named_share = 0.05;
// A smaller change of a contour that moving did not bring to agree is not named.
// [working units; >= 0; M 2026-11, set not recorded]
constexpr double least_named_change = 0.1;
// A slice is an outlier if its median disagreement is above this. [working units; > 0; M 2026-11, set not recorded]
constexpr double outlier_gap = 2;
// It is also above this multiple of the median of all slices. [1; > 1; M 2026-11, set not recorded]
constexpr double outlier_factor = 4;

class ReconcileWarnings {
  public:
    ReconcileWarnings(const ContourSet& set, const ReconcileOptions& options, const ReconcileStats& stats,
                      std::span<const UndrawnStructure> undrawn, std::span<const IsolatedSlice> isolated,
                      double unit_mm, RunContext& context)
        : set_(set),
          unit_mm_(unit_mm),
          options_(options),
          stats_(stats),
          undrawn_(undrawn),
          isolated_(isolated),
          context_(context) {}

    void warn() {
        warn_of_shifts();
        warn_of_disagreement();
        warn_of_pairs();
        warn_of_folds();
        warn_of_regularized_contours();
        warn_of_parting();
        warn_of_taken_over();
        warn_of_resolved();
        warn_of_walls();
        warn_of_rest();
        warn_of_outliers();
        warn_of_undrawn();
        warn_of_isolated();
    }

  private:
    // Returns the pairs whose figure is above `least`, the largest first.
    template <class Figure>
    std::vector<const PairDisagreement*> largest(Figure figure, double least) const {
        std::vector<const PairDisagreement*> named;
        for (const PairDisagreement& pair : stats_.pairs) {
            if (figure(pair) > least) named.push_back(&pair);
        }
        std::stable_sort(
            named.begin(), named.end(),
            [&](const PairDisagreement* p, const PairDisagreement* q) { return figure(*p) > figure(*q); });
        return named;
    }

    void warn_of_isolated() {
        std::vector<IsolatedSlice> named(isolated_.begin(), isolated_.end());
        std::stable_sort(named.begin(), named.end(),
                         [](const IsolatedSlice& p, const IsolatedSlice& q) { return p.others > q.others; });
        for (std::size_t n = 0; n < std::min(named.size(), most_named_pairs); ++n) {
            const IsolatedSlice& isolated = named[n];
            context_.warn(
                {"W-RCN-008",
                 "the slice draws the structure elsewhere than the " + std::to_string(isolated.others) +
                     (isolated.others == 1 ? " slice" : " slices") +
                     " that it crosses; the nearest is slice " + set_.slices[isolated.nearest].name +
                     (named.size() > most_named_pairs && n == 0
                          ? "; " + std::to_string(named.size()) + " such slices"
                          : ""),
                 place_of_slice(set_, isolated.slice, isolated.gap_mm),
                 "kept as a separate part; check the position of the slice"});
        }
    }

    void warn_of_undrawn() {
        std::vector<UndrawnStructure> named(undrawn_.begin(), undrawn_.end());
        std::stable_sort(
            named.begin(), named.end(),
            [](const UndrawnStructure& p, const UndrawnStructure& q) { return p.shown_mm > q.shown_mm; });
        for (std::size_t n = 0; n < std::min(named.size(), most_named_pairs); ++n) {
            const Structure& structure = set_.structures[named[n].structure];
            Place place = place_of_slice(set_, named[n].slice, named[n].shown_mm);
            place.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
            context_.warn({"W-RCN-007",
                           "the structure is not drawn on this slice, but slice " +
                               set_.slices[named[n].shown_by].name + " shows it where their planes cross" +
                               (named.size() > most_named_pairs && n == 0
                                    ? "; " + std::to_string(named.size()) + " such slices and structures"
                                    : ""),
                           std::move(place),
                           "the slice was not used for the structure; draw it there, or leave the slice out "
                           "with --without"});
        }
    }

    void warn_of_folds() {
        const FoldStats& folds = stats_.folds;
        if (folds.vertices == 0) return;
        const auto counted = [](std::uint64_t count, const std::string& noun) {
            return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
        };
        context_.warn({"W-RCN-006",
                       counted(folds.folds, "narrow fold") + " and " + counted(folds.spikes, "spike") +
                           ", up to " + brief(folds.highest_mm) +
                           " mm high, arose where contours were moved to agree",
                       {set_.source, "", "", "", ""},
                       "they were cut off, with " + std::to_string(folds.vertices) + " drawn vertices"});
    }

    void warn_of_regularized_contours() {
        const FanStats& fans = stats_.fans;
        const AlongAxisStats& along_axis = stats_.along_axis;
        if (fans.fans + along_axis.points == 0) return;
        const double highest = std::max(fans.highest_mm, along_axis.farthest_mm);
        context_.warn({"W-RCN-009",
                       "contours differ from plane to plane near a line where four or more planes meet, or "
                       "run steeply along it, at " +
                           std::to_string(fans.fans) + (fans.fans == 1 ? " place" : " places") +
                           " on it and " + std::to_string(along_axis.points) +
                           (along_axis.points == 1 ? " point" : " points") + " beside it",
                       {set_.source, "", "", "", brief(highest) + " mm"},
                       "they were turned and moved there, by " + brief(highest) + " mm at most"});
    }

    void warn_of_parting() {
        const ClearanceStats& apart = stats_.clearance;
        if (apart.places == 0) return;
        context_.warn({"W-RCN-013",
                       "contours that were moved to agree nearly touch each other, at " +
                           std::to_string(apart.places) + (apart.places == 1 ? " place" : " places"),
                       {set_.source, "", "", "", brief(apart.farthest_mm) + " mm"},
                       "they were moved apart, by " + brief(apart.farthest_mm) + " mm at most"});
    }

    void warn_of_taken_over() {
        std::vector<TakenOver> named = stats_.taken_over;
        std::stable_sort(named.begin(), named.end(), [](const TakenOver& p, const TakenOver& q) {
            return p.farthest_mm > q.farthest_mm;
        });
        for (std::size_t n = 0; n < std::min(named.size(), most_named_pairs); ++n) {
            Place place = place_of_slice(set_, named[n].slice, named[n].farthest_mm);
            const Structure& structure = set_.structures[named[n].structure];
            place.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
            context_.warn(
                {"W-RCN-010",
                 "the slice contradicts " +
                     std::string(named[n].for_most ? "most slices that meet it in one line"
                                                   : "a slice that crosses it") +
                     ": its contour ends before the line, or continues beyond it" +
                     std::string(named.size() > most_named_pairs && n == 0
                                     ? "; " + std::to_string(named.size()) + " such slices and structures"
                                     : ""),
                 std::move(place),
                 std::string("its contour was moved across the line to agree") +
                     (named[n].for_most ? " with the others; check this slice"
                                        : ", because that is the least movement; check both slices")});
        }
    }

    void warn_of_resolved() {
        std::vector<ResolvedInterval> named;
        for (const ResolvedInterval& piece : stats_.resolved) {
            if (piece.parts || piece.farthest_mm >= unit_mm_ * least_named_change) named.push_back(piece);
        }
        std::stable_sort(named.begin(), named.end(),
                         [](const ResolvedInterval& p, const ResolvedInterval& q) {
                             return p.farthest_mm > q.farthest_mm;
                         });
        for (std::size_t n = 0; n < std::min(named.size(), most_named_pairs); ++n) {
            const ResolvedInterval& piece = named[n];
            Place place = place_of_slice(set_, piece.slice, piece.farthest_mm);
            const Structure& structure = set_.structures[piece.structure];
            place.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
            context_.warn({"W-RCN-012",
                           "the slice contradicts slice " + set_.slices[piece.other].name + " on " +
                               brief(piece.length_mm) +
                               " mm of their common line, and moving contours did not resolve it" +
                               (named.size() > most_named_pairs && n == 0
                                    ? "; " + std::to_string(named.size()) + " such places"
                                    : ""),
                           std::move(place),
                           std::string("its contours were changed there by up to ") +
                               brief(piece.farthest_mm) + " mm, so that this place is " +
                               (piece.inside ? "inside" : "outside") +
                               " the structure, as on the other slice; check both slices"});
        }
    }

    void warn_of_walls() {
        const ConflationStats &slivers = stats_.slivers, &shared = stats_.shared_lines;
        if (slivers.contours_changed + shared.contours_changed == 0) return;
        const bool wider = slivers.widest_mm > shared.widest_mm;
        const ConflationStats& worst = wider ? slivers : shared;
        context_.warn({"W-RCN-011",
                       "contours of neighbouring structures that were moved to agree are very close: gaps "
                       "and overlaps of " +
                           brief(slivers.area_mm2) + " mm2 on " + std::to_string(slivers.slices) +
                           (slivers.slices == 1 ? " slice" : " slices") + ", and lines " +
                           brief(shared.widest_mm) + " mm apart on " + std::to_string(shared.slices),
                       place_of_slice(set_, worst.worst_slice, worst.widest_mm),
                       "these structures share their boundary there; --close-slivers 0 and --same-line 0 "
                       "keep the contours apart"});
    }

    void warn_of_shifts() {
        std::uint32_t shifted = 0, worst = 0;
        double sum = 0, others = 0;
        for (std::uint32_t s = 0; s < stats_.movements.size(); ++s) {
            const double shift = length(stats_.movements[s].shift);
            if (shift < unit_mm_ * 10 * align_precision_mm) continue;
            ++shifted;
            sum += shift;
            if (shift > length(stats_.movements[worst].shift)) worst = s;
        }
        if (shifted == 0) return;
        for (std::uint32_t s = 0; s < stats_.movements.size(); ++s) {
            if (s != worst) others = std::max(others, length(stats_.movements[s].shift));
        }
        context_.warn({"W-RCN-001",
                       std::to_string(shifted) + " of " + std::to_string(stats_.movements.size()) +
                           " slices agree better with the slices that they cross after a shift within their "
                           "planes, by " +
                           brief(sum / shifted) + " mm on average and most in slice " +
                           set_.slices[worst].name + "; the others by " + brief(others) + " mm at most",
                       place_of_slice(set_, worst, length(stats_.movements[worst].shift)),
                       "they were shifted"});
    }

    // Names slices that disagree with the others far more than these among themselves. As a rule a tracker
    // jumped there.
    void warn_of_outliers() {
        std::vector<std::vector<double>> of_slice(set_.slices.size());
        for (const PairDisagreement& pair : stats_.pairs) {
            const double figure = std::max(pair.median_mm, pair.unmatched > 0 ? 0.5 * pair.difference_mm : 0);
            of_slice[pair.slice_a].push_back(figure);
            of_slice[pair.slice_b].push_back(figure);
        }
        for (std::uint32_t s = 0; s < of_slice.size(); ++s) {
            std::vector<double>& figures = of_slice[s];
            if (figures.size() < 3) continue;
            const auto middle = figures.begin() + static_cast<std::ptrdiff_t>(figures.size() / 2);
            std::nth_element(figures.begin(), middle, figures.end());
            if (*middle <= std::max(unit_mm_ * outlier_gap, outlier_factor * stats_.median_mm)) continue;
            context_.warn({"W-RCN-005", "the slice disagrees with most of the slices that it crosses",
                           place_of_slice(set_, s, *middle), "kept; check the position of the slice"});
        }
    }

    void warn_of_disagreement() {
        if (stats_.max_mm <= unit_mm_ * joinable_mm && stats_.unmatched == 0) return;
        std::string done = "kept as drawn";
        if (options_.reconcile) {
            done = "contours moved in their planes by " + brief(stats_.mean_movement_mm) +
                   " mm on average and " + brief(stats_.max_movement_mm) + " mm at most";
        }
        context_.warn({"W-RCN-002",
                       "slices disagree where their planes cross: their contours meet the common line " +
                           brief(stats_.median_mm) + " mm apart in the median, " + brief(stats_.p95_mm) +
                           " mm at 95 % and " + brief(stats_.max_mm) + " mm at most; " +
                           std::to_string(stats_.unmatched) + " stretches or gaps are on one slice only",
                       {set_.source, "", "", "",
                        brief(stats_.difference_mm) + " mm on " + std::to_string(stats_.pairs.size()) +
                            " common lines"},
                       std::move(done)});
    }

    void warn_of_pairs() {
        const auto figure = [](const PairDisagreement& pair) {
            return std::max(pair.max_mm, pair.difference_mm);
        };
        const auto named =
            largest(figure, std::max(unit_mm_ * named_gap, named_share * options_.max_disagreement_mm));
        for (std::size_t n = 0; n < std::min(named.size(), most_named_pairs); ++n) {
            const PairDisagreement& pair = *named[n];
            context_.warn({"W-RCN-003",
                           names_of(set_, pair.slice_a, pair.slice_b) +
                               " disagree where their planes cross: " + std::to_string(pair.ends) +
                               " points of their contours by up to " + brief(pair.max_mm) + " mm, " +
                               std::to_string(pair.unmatched) + " stretches or gaps on one of them only",
                           place_of_slice(set_, pair.slice_a, pair.difference_mm),
                           options_.reconcile ? "their contours were moved to agree" : "kept as drawn"});
        }
    }

    void warn_of_rest() {
        if (!options_.reconcile) return;
        const auto figure = [](const PairDisagreement& pair) { return pair.difference_after_mm; };
        const auto left = largest(figure, unit_mm_ * line_in_plane_mm);
        if (left.empty()) return;
        std::string worst;
        for (std::size_t n = 0; n < std::min<std::size_t>(left.size(), 3); ++n) {
            worst += (n > 0 ? "; " : "") + names_of(set_, left[n]->slice_a, left[n]->slice_b) + " " +
                     brief(left[n]->difference_after_mm) + " mm";
        }
        context_.warn(
            {"W-RCN-004",
             std::to_string(left.size()) +
                 " pairs of slices could not be made to agree everywhere on their common line: " + worst,
             {set_.source, "", "", "", brief(stats_.difference_after_mm) + " mm"},
             "kept; near the line the surface follows the nearest contour"});
    }

    const ContourSet& set_;
    double unit_mm_;
    const ReconcileOptions& options_;
    const ReconcileStats& stats_;
    std::span<const UndrawnStructure> undrawn_;
    std::span<const IsolatedSlice> isolated_;
    RunContext& context_;
};

}  // namespace

void warn_of_reconciling(const ContourSet& set, const ReconcileOptions& options, const ReconcileStats& stats,
                         std::span<const UndrawnStructure> undrawn, std::span<const IsolatedSlice> isolated,
                         double unit_mm, RunContext& context) {
    ReconcileWarnings(set, options, stats, undrawn, isolated, unit_mm, context).warn();
}

Place place_of_slice(const ContourSet& set, std::uint32_t slice, double value_mm) {
    return {set.source, set.slices[slice].name, "", "", brief(value_mm) + " mm"};
}

std::string names_of(const ContourSet& set, std::uint32_t a, std::uint32_t b) {
    return "slices " + set.slices[a].name + " and " + set.slices[b].name;
}

}  // namespace anatomesh
