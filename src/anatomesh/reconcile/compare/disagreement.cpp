#include "anatomesh/reconcile/compare/disagreement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/slices/lines/arc.h"

namespace anatomesh {

namespace {

struct Figures {
    double median = 0, p95 = 0, max = 0;
};

// Returns the least values that half and 95 % of the distances do not exceed. The same elements give the
// same figures.
Figures figures_of(std::vector<double> distances) {
    if (distances.empty()) return {};
    std::sort(distances.begin(), distances.end());
    const std::size_t n = distances.size();
    return {distances[(n - 1) / 2], distances[(95 * n + 99) / 100 - 1], distances.back()};
}

void append_distances(const LineComparison& comparison, std::vector<double>& distances) {
    for (const auto& [i, j] : comparison.matching.matched) {
        distances.push_back(std::abs(comparison.endpoints_a[i].t - comparison.endpoints_b[j].t));
    }
}

std::size_t unmatched_in(const LineComparison& comparison) {
    return comparison.matching.only_first.size() + comparison.matching.only_second.size();
}

double distance_to_region_boundary(const ContourSet& set, std::uint32_t slice, std::uint32_t structure,
                                   Vec3 p) {
    double least = std::numeric_limits<double>::infinity();
    for (const Contour& contour : set.contours_of(set.slices[slice])) {
        if (contour.structure != structure) continue;
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            const Vec3 a = set.points[k], along = set.points[point_after(contour, k)] - a;
            const double square = squared_length(along);
            const double share = square > 0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0;
            least = std::min(least, squared_length(p - a - share * along));
        }
    }
    return std::sqrt(least);
}

std::uint32_t most_of(const std::vector<std::uint64_t>& counts) {
    return static_cast<std::uint32_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

// Returns how far apart corresponding endpoints are across the contours. It is the distance along the line
// times the lesser sine of the angles at which the two contours meet it.
double distance_across(const ContourSet& set, const LineComparison& c, const IntervalEndpoint& a,
                       const IntervalEndpoint& b) {
    const auto sine = [&](const IntervalEndpoint& end, std::uint32_t slice) {
        const Plane& plane = set.slices[slice].plane;
        return std::abs(dot(contour_normal(set, end, measuring_chord_mm),
                            {dot(c.line.direction, plane.u), dot(c.line.direction, plane.v)}));
    };
    return std::abs(a.t - b.t) * std::min(sine(a, c.a), sine(b, c.b));
}

class WorstDisagreement {
  public:
    WorstDisagreement(const ContourSet& set, double bound)
        : set_(set), bound_(bound), counts_(set.slices.size(), 0) {}

    void look_at(const LineComparison& c) {
        for (const auto& [i, j] : c.matching.matched) {
            const IntervalEndpoint &a = c.endpoints_a[i], &b = c.endpoints_b[j];
            if (std::abs(a.t - b.t) <= bound_) continue;
            take(c, 0.5 * std::min(distance_to_region_boundary(set_, c.a, c.structure, b.at),
                                   distance_to_region_boundary(set_, c.b, c.structure, a.at)));
        }
        for (const std::uint32_t i : c.matching.only_first)
            look_at_single(c, c.endpoints_a[i], c.endpoints_a[i + 1], c.a, c.b);
        for (const std::uint32_t i : c.matching.only_second)
            look_at_single(c, c.endpoints_b[i], c.endpoints_b[i + 1], c.b, c.a);
    }

    std::optional<WorstPlace> result() {
        if (worst_.places == 0) return std::nullopt;
        worst_.culprit = most_of(counts_);
        return worst_;
    }

  private:
    void look_at_single(const LineComparison& c, const IntervalEndpoint& p, const IntervalEndpoint& q,
                        std::uint32_t own, std::uint32_t other) {
        const Arc arc = arc_between(set_, p, q, set_.slices[own].plane, set_.slices[other].plane);
        if (!arc.points.empty() && arc.height_mm <= bound_) return;
        take(c, 0.5 * distance_to_region_boundary(set_, own, c.structure, 0.5 * (p.at + q.at)));
    }

    void take(const LineComparison& c, double distance) {
        if (distance <= bound_) return;
        ++worst_.places;
        ++counts_[c.a];
        ++counts_[c.b];
        if (distance <= worst_.distance_mm) return;
        worst_.a = c.a;
        worst_.b = c.b;
        worst_.structure = c.structure;
        worst_.distance_mm = distance;
    }

    const ContourSet& set_;
    const double bound_;
    WorstPlace worst_;
    std::vector<std::uint64_t> counts_;
};

}  // namespace

std::vector<PairDisagreement> disagreements(std::span<const LineComparison> comparisons) {
    std::vector<PairDisagreement> pairs;
    std::vector<double> distances;
    for (std::size_t i = 0; i < comparisons.size(); ++i) {
        const LineComparison& c = comparisons[i];
        if (pairs.empty() || pairs.back().slice_a != c.a || pairs.back().slice_b != c.b) {
            pairs.push_back({});
            pairs.back().slice_a = c.a;
            pairs.back().slice_b = c.b;
            distances.clear();
        }
        PairDisagreement& pair = pairs.back();
        append_distances(c, distances);
        pair.ends += static_cast<std::uint32_t>(c.matching.matched.size());
        pair.unmatched += static_cast<std::uint32_t>(unmatched_in(c));
        pair.difference_mm += c.difference_mm;
        const bool last =
            i + 1 == comparisons.size() || comparisons[i + 1].a != c.a || comparisons[i + 1].b != c.b;
        if (!last) continue;
        const Figures figures = figures_of(distances);
        pair.median_mm = figures.median;
        pair.p95_mm = figures.p95;
        pair.max_mm = figures.max;
    }
    return pairs;
}

void summarize(std::span<const LineComparison> comparisons, ReconcileStats& stats) {
    std::vector<double> distances;
    for (const LineComparison& comparison : comparisons) {
        append_distances(comparison, distances);
        stats.unmatched += unmatched_in(comparison);
        stats.difference_mm += comparison.difference_mm;
    }
    stats.ends = distances.size();
    const Figures figures = figures_of(std::move(distances));
    stats.median_mm = figures.median;
    stats.p95_mm = figures.p95;
    stats.max_mm = figures.max;
}

bool is_pair_before(const PairDisagreement& p, const PairDisagreement& q) {
    return std::tie(p.slice_a, p.slice_b) < std::tie(q.slice_a, q.slice_b);
}

void summarize_after(std::span<const LineComparison> comparisons, ReconcileStats& stats) {
    for (const PairDisagreement& after : disagreements(comparisons)) {
        stats.difference_after_mm += after.difference_mm;
        const auto at = std::lower_bound(stats.pairs.begin(), stats.pairs.end(), after, is_pair_before);
        if (at != stats.pairs.end() && at->slice_a == after.slice_a && at->slice_b == after.slice_b) {
            at->difference_after_mm = after.difference_mm;
        } else if (after.difference_mm > 0) {
            PairDisagreement added{after.slice_a, after.slice_b, 0, 0, 0, 0, 0, 0, after.difference_mm};
            stats.pairs.insert(at, added);
        }
    }
}

void summarize_movements(const ContourSet& set, const OriginalPositions& drawn, ReconcileStats& stats) {
    double sum = 0;
    stats.max_movement_mm = 0;
    std::size_t count = 0;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        SliceMovement& movement = stats.movements[s];
        double of_slice = 0;
        movement.max_mm = 0;
        std::size_t vertices = 0;
        for (const Contour& contour : set.contours_of(set.slices[s])) {
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
                if (!drawn.is_drawn[k]) continue;
                const double distance = length(set.points[k] - drawn.at[k]);
                of_slice += distance;
                movement.max_mm = std::max(movement.max_mm, distance);
                ++vertices;
            }
        }
        movement.mean_mm = of_slice / static_cast<double>(std::max<std::size_t>(1, vertices));
        stats.max_movement_mm = std::max(stats.max_movement_mm, movement.max_mm);
        sum += of_slice;
        count += vertices;
    }
    stats.mean_movement_mm = sum / static_cast<double>(std::max<std::size_t>(1, count));
}

std::optional<WorstPlace> worst_pair(const ContourSet& set, std::span<const LineComparison> comparisons,
                                     double bound_mm) {
    WorstPlace worst;
    std::vector<std::uint64_t> counts(set.slices.size(), 0);
    for (const LineComparison& c : comparisons) {
        std::vector<double> distances;
        for (const auto& [i, j] : c.matching.matched)
            distances.push_back(distance_across(set, c, c.endpoints_a[i], c.endpoints_b[j]));
        const double median = figures_of(std::move(distances)).median;
        if (median <= bound_mm) continue;
        ++worst.places, ++counts[c.a], ++counts[c.b];
        if (median > worst.distance_mm)
            worst.a = c.a, worst.b = c.b, worst.structure = c.structure, worst.distance_mm = median;
    }
    if (worst.places == 0) return std::nullopt;
    worst.culprit = most_of(counts);
    return worst;
}

std::optional<WorstPlace> worst_place(const ContourSet& set, std::span<const LineComparison> comparisons,
                                      double bound_mm) {
    WorstDisagreement worst(set, bound_mm);
    for (const LineComparison& comparison : comparisons) worst.look_at(comparison);
    return worst.result();
}

}  // namespace anatomesh
