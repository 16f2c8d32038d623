#include "anatomesh/reconcile/compare/contradictions.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/reconcile/compare/disagreement.h"
#include "anatomesh/reconcile/compare/reconcile_warnings.h"

namespace anatomesh {

namespace {

// A contour that is nearer to the bound, in shares of it, cannot move further. [1; 0 to 1; D]
constexpr double at_bound_share = 1e-3;
// Slices that differ by a smaller share of the bound are warned of alone. [1; 0 to 1; M 2026-11 two stacks
// that moved]
constexpr double least_left_share = 0.1;
// A moved point counts up to so many bounds from the other slice's plane. [bounds; >= 1; M 2026-11, set not
// recorded]
constexpr double beside_line = 2;

// Advises on a slice whose contours all lie on one side of the other's plane, beside their common line.
// Within a margin it says there only that nothing is there, and an image that ends there is drawn along
// its edge. `at`: where the points were drawn.
std::string beyond_its_contours(const ContourSet& set, const std::vector<Vec3>& at, std::uint32_t a,
                                std::uint32_t b, double unit_mm) {
    for (const auto& [slice, other] : {std::pair{a, b}, std::pair{b, a}}) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const Contour& contour : set.contours_of(set.slices[slice])) {
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
                const double height = set.slices[other].plane.signed_distance(at[k]);
                low = std::min(low, height);
                high = std::max(high, height);
            }
        }
        if (low > 0 || high < 0)
            return "the contours of slice " + set.slices[slice].name + " end " +
                   brief(unit_mm * std::max(low, -high)) +
                   " mm before that line; if its image ends there too, leave the slice out with --without "
                   "\"" +
                   set.slices[slice].name + "\"; otherwise ";
    }
    return {};
}

// Says what a user can do. `culprit`: the slice that is in most of the contradictions.
std::string ways_out(const ReconcileOptions& options, const std::string& culprit) {
    return "leave out a slice, first with --without \"" + culprit + "\", " +
           (options.align ? "" : "shift slices with --align, ") +
           "allow more with --max-disagreement, or keep contours as drawn with --reconcile 0";
}

Place place_of(const ContourSet& set, const WorstPlace& worst, double unit_mm) {
    Place place = place_of_slice(set, worst.a, unit_mm * worst.distance_mm);
    const Structure& structure = set.structures[worst.structure];
    place.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
    return place;
}

Error contradiction(const ContourSet& set, const WorstPlace& worst, const ReconcileOptions& options,
                    double unit_mm, const std::string& where, const std::string& which) {
    return Error{ErrorKind::geometry, "E-RCN-001",
                 names_of(set, worst.a, worst.b) + " contradict each other by " +
                     brief(unit_mm * worst.distance_mm) + " mm" + where +
                     brief(unit_mm * options.max_disagreement_mm) +
                     " mm, whatever the size of the contours; " + std::to_string(worst.places) + which +
                     set.slices[worst.culprit].name,
                 place_of(set, worst, unit_mm),
                 beyond_its_contours(set, set.points, worst.a, worst.b, unit_mm) +
                     ways_out(options, set.slices[worst.culprit].name)};
}

// A point that moved by nearly all of the bound, with its slice and structure.
struct MovedFar {
    std::uint32_t slice = 0, structure = 0;
    Vec3 at;
};

std::vector<MovedFar> moved_by(const ContourSet& set, const OriginalPositions& drawn, double least_mm) {
    std::vector<MovedFar> moved;
    for (const Contour& contour : set.contours) {
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            if (length(set.points[k] - drawn.at[k]) >= least_mm)
                moved.push_back({contour.slice, contour.structure, set.points[k]});
        }
    }
    return moved;
}

}  // namespace

Status check_bound(const ContourSet& set, std::span<const LineComparison> comparisons,
                   const ReconcileOptions& options, double unit_mm) {
    const double bound = options.max_disagreement_mm;
    if (const std::optional<WorstPlace> worst = worst_pair(set, comparisons, bound))
        return contradiction(set, *worst, options, unit_mm,
                             " in the median where their planes cross, and the limit is ",
                             " such pairs of slices exist, most with slice ");
    if (const std::optional<WorstPlace> worst = worst_place(set, comparisons, bound))
        return contradiction(set, *worst, options, unit_mm, " where their planes cross, and the limit is ",
                             " such places exist, most in slice ");
    return Nothing{};
}

Status check_what_is_left(const ContourSet& set, const OriginalPositions& drawn,
                          std::span<const LineComparison> comparisons, const ReconcileOptions& options,
                          double unit_mm) {
    const double bound = options.max_disagreement_mm;
    const std::vector<MovedFar> moved = moved_by(set, drawn, (1 - at_bound_share) * bound);
    const auto has_moved = [&](std::uint32_t slice, std::uint32_t structure, std::uint32_t other) {
        return std::any_of(moved.begin(), moved.end(), [&](const MovedFar& m) {
            return m.slice == slice && m.structure == structure &&
                   std::abs(set.slices[other].plane.signed_distance(m.at)) <= beside_line * bound;
        });
    };
    WorstPlace worst;
    std::vector<std::uint64_t> pairs_of(set.slices.size(), 0);
    for (std::uint32_t structure = 0; structure < set.structures.size() && !moved.empty(); ++structure) {
        std::vector<LineComparison> of_structure;
        std::copy_if(comparisons.begin(), comparisons.end(), std::back_inserter(of_structure),
                     [&](const LineComparison& c) { return c.structure == structure; });
        for (const PairDisagreement& pair : disagreements(of_structure)) {
            if (pair.difference_mm <= least_left_share * bound) continue;
            const std::uint32_t a = pair.slice_a, b = pair.slice_b;
            if (!has_moved(a, structure, b) && !has_moved(b, structure, a)) continue;
            ++worst.places;
            ++pairs_of[a];
            ++pairs_of[b];
            if (pair.difference_mm <= worst.distance_mm) continue;
            worst.a = a;
            worst.b = b;
            worst.structure = structure;
            worst.distance_mm = pair.difference_mm;
        }
    }
    if (worst.places == 0) return Nothing{};
    const auto most = std::max_element(pairs_of.begin(), pairs_of.end()) - pairs_of.begin();
    worst.culprit = static_cast<std::uint32_t>(most);
    return Error{ErrorKind::geometry, "E-RCN-003",
                 names_of(set, worst.a, worst.b) + " still differ along " +
                     brief(unit_mm * worst.distance_mm) +
                     " mm of the line where their planes cross, after contours moved by the allowed " +
                     brief(unit_mm * bound) + " mm; there are " + std::to_string(worst.places) +
                     " such pairs, most with slice " + set.slices[worst.culprit].name,
                 place_of(set, worst, unit_mm),
                 beyond_its_contours(set, drawn.at, worst.a, worst.b, unit_mm) +
                     ways_out(options, set.slices[worst.culprit].name)};
}

}  // namespace anatomesh
