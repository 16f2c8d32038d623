#include "anatomesh/reconcile/contradictions.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/contour/message_text.h"
#include "anatomesh/reconcile/disagreement.h"
#include "anatomesh/reconcile/reconcile_warnings.h"

namespace anatomesh {

namespace {

constexpr double at_bound_share = 1e-3;   // of the bound: a contour so near to it cannot move further
constexpr double least_left_share = 0.1;  // of the bound: slices that differ by less are warned of

std::string ways_out(const ReconcileOptions& options) {
    return std::string("leave a slice out, ") + (options.align ? "" : "shift slices with --align, ") +
           "raise the bound with --max-disagreement, or keep every vertex with --reconcile 0";
}

Error contradiction(const ContourSet& set, const WorstPlace& worst, const ReconcileOptions& options,
                    const std::string& where, const std::string& which) {
    Place place = place_of_slice(set, worst.a, worst.distance_mm);
    const Structure& structure = set.structures[worst.structure];
    place.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
    return Error{ErrorKind::geometry, "E-RCN-001",
                 names_of(set, worst.a, worst.b) + " contradict each other by " + brief(worst.distance_mm) +
                     " mm" + where + brief(options.max_disagreement_mm) + " mm; " +
                     std::to_string(worst.places) + which + set.slices[worst.culprit].name,
                 std::move(place), ways_out(options)};
}

}  // namespace

Status check_bound(const ContourSet& set, std::span<const LineComparison> comparisons,
                   const ReconcileOptions& options) {
    const double bound = options.max_disagreement_mm;
    if (const std::optional<WorstPlace> worst = worst_pair(set, comparisons, bound))
        return contradiction(set, *worst, options,
                             " in the median of the region ends where their planes cross, more than ",
                             " such pairs, most of them with slice ");
    if (const std::optional<WorstPlace> worst = worst_place(set, comparisons, bound))
        return contradiction(set, *worst, options, " where their planes cross, more than ",
                             " such places, most of them in slice ");
    return Nothing{};
}

Status check_what_is_left(const ContourSet& set, std::span<const LineComparison> comparisons,
                          std::span<const SliceMovement> movements, const ReconcileOptions& options) {
    const double bound = options.max_disagreement_mm;
    const auto at_bound = [&](std::uint32_t slice) {
        return movements[slice].max_mm >= (1 - at_bound_share) * bound;
    };
    PairDisagreement worst;
    std::uint64_t pairs = 0;
    std::vector<std::uint64_t> pairs_of(set.slices.size(), 0);
    for (const PairDisagreement& pair : disagreements(comparisons)) {
        if (pair.difference_mm <= least_left_share * bound) continue;
        if (!at_bound(pair.slice_a) && !at_bound(pair.slice_b)) continue;
        ++pairs;
        ++pairs_of[pair.slice_a];
        ++pairs_of[pair.slice_b];
        if (pair.difference_mm > worst.difference_mm) worst = pair;
    }
    if (pairs == 0) return Nothing{};
    const auto most = std::max_element(pairs_of.begin(), pairs_of.end()) - pairs_of.begin();
    return Error{
        ErrorKind::geometry, "E-RCN-003",
        names_of(set, worst.slice_a, worst.slice_b) + " still differ along " + brief(worst.difference_mm) +
            " mm of the line where their planes cross when contours have moved by as much as they "
            "may, " +
            brief(bound) + " mm; " + std::to_string(pairs) + " such pairs, most of them with slice " +
            set.slices[static_cast<std::size_t>(most)].name,
        place_of_slice(set, worst.slice_a, worst.difference_mm), ways_out(options)};
}

}  // namespace anatomesh
