#include "anatomesh/outliers/outlying_slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "anatomesh/base/parallel.h"
#include "anatomesh/outliers/compare_sections.h"
#include "anatomesh/outliers/judged_stacks.h"
#include "anatomesh/outliers/section.h"

namespace anatomesh {

namespace {

// What is too much or lacks, of the area drawn there. [1; 0 to 1; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double least_share = 0.1;
// The outline's mean distance from where it may lie: a slope or a bulge may do as much.
// [gaps between slices; > 0; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double least_gaps = 0.1;
// It is so large at least, or a share of the radius of the circle of its area, of which the smaller decides: hands draw no
// better. [mm; > 0; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double least_mean_mm = 0.3;
// The same for small structures. [radii of the circle of its area; > 0; D a choice]
constexpr double least_mean_radii = 0.1;
// What is too much or lacks, of all that is drawn of the structure on the slice.
// [1; 0 to 1; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double least_share_of_all = 0.1;
// What is too much or lacks on a slice, unless it is half of all that is drawn there, of the volume of the structure.
// [1; 0 to 1; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double least_share_of_volume = 0.004;
// A part or hole that is missing has so much of that. [1; 0 to 1; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double least_missing = 0.005;
// What the neighbours differ by, of what is wrong with the section between them: where it is more, the shape changes there.
// [1; > 0; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double most_beside = 6;
// With fewer other sections to compare with, the section and its neighbours alone must tell, by the next two.
// [sections; >= 1; D a choice]
constexpr std::size_t fewest_others = 3;
// The share then. [1; least_share to 1; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double least_share_of_few = 0.15;
// The difference of the neighbours then. [1; 0 to most_beside; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double most_beside_of_few = 3;
// With fewer sections the middle one of a ball is larger than both ends by any factor. [sections; 4; D geometry of balls]
constexpr std::size_t fewest_round_middle = 4;
// A displaced section lies aside by this or by the next, of which the smaller decides. [mm; > 0; C W-FLD-011]
constexpr double least_shift_mm = 2;
// The same for small structures. [radii of the circle of its area; > 0; D a choice]
constexpr double least_shift_radii = 0.6;
// One that lies aside by so much of the radius of the circle of its area is displaced also where its neighbours grow.
// [radii; 0 to 1; D a choice]
constexpr double least_shift_of_radius = 0.1;
// A displaced section lies aside by so many times the median of others. [1; > 1; D a choice]
constexpr double times_median_shift = 5;
// A shift explains what is wrong where no larger share is left when it is taken back. [1; 0 to 1; D a choice]
constexpr double explained_share = 0.4;
// A section is larger or smaller where excess and deficit differ by this factor. [1; > 1; B]
constexpr double one_sided = 3;
// A part alone is farther from others: a tip that leans goes on nearer.
// [gaps between slices; > 0; M docs/experiments/2026-11-30-wrong-slices.md]
constexpr double alone_gaps = 1.2;
// Times the median of other sections. [1; > 1; D a choice]
constexpr double times_median = 3;
// Where so many of the other sections do half as much of the same kind, it is the shape of the structure.
// [1; 0 to 1; D a choice: a process on every seventh slice of a spine is its shape]
constexpr double usual_share = 0.1;
// What is half as much counts as as much. [1; 0 to 1; B]
constexpr double half_as_much = 0.5;
// A part or hole tells more than the shape where it is so much of what is wrong. [1; 0 to 1; B]
constexpr double telling_share = 0.25;
// Gaps wider than so many usual ones are ends on both sides. [usual gaps; > 2; D a slice that is taken out leaves two]
constexpr double widest_gap = 2.6;
// Of the sections of a structure no more are taken out, but for one. [1; 0 to 0.5; D a choice]
constexpr double most_outlying = 0.2;

// What is wrong with a section.
struct Finding {
    OutlierKind kind = OutlierKind::displaced;
    std::uint32_t contour = 0;  // of the stack
    double distance_mm = 0, area_mm2 = 0, share = 0;
};

// A section that was taken out of its row, with those beside it then.
struct TakenOut {
    std::uint32_t section = 0, below = 0, above = 0;
    std::optional<Finding> shape, topology;
};

// The sections of one structure in one stack.
struct Row {
    std::uint32_t stack = 0, structure = 0;
    std::vector<Section> sections;
    double usual_gap = 0, volume = 0;  // mm, mm3
    // By section, with those kept beside it; nothing where it is not judged.
    std::vector<std::optional<SectionComparison>> comparisons;
    std::vector<std::uint32_t> kept;  // sections that were not taken out, rising
};

// Of three sections, between the two pairs that follow one another.
struct Gaps {
    double least, most;
};
Gaps gaps_of(const Row& row, std::uint32_t below, std::uint32_t one, std::uint32_t above) {
    const double first = row.sections[one].height - row.sections[below].height,
                 second = row.sections[above].height - row.sections[one].height;
    return {std::min(first, second), std::max(first, second)};
}

std::optional<SectionComparison> compared(const Row& row, std::uint32_t below, std::uint32_t one,
                                          std::uint32_t above) {
    const Gaps gaps = gaps_of(row, below, one, above);
    if (!(gaps.least > 0) || gaps.most > widest_gap * row.usual_gap) return std::nullopt;
    return compare_sections(row.sections[below], row.sections[one], row.sections[above]);
}

// Of the n-th section kept, with those kept beside it.
std::optional<SectionComparison> compared(const Row& row, std::size_t n) {
    if (n == 0 || n + 1 >= row.kept.size()) return std::nullopt;
    return compared(row, row.kept[n - 1], row.kept[n], row.kept[n + 1]);
}

OutlierKind kind_of(const ShapeDifference& shape) {
    if (shape.unshifted_share <= explained_share * shape.share) return OutlierKind::displaced;
    if (shape.excess_mm2 >= one_sided * shape.deficit_mm2) return OutlierKind::larger;
    if (shape.deficit_mm2 >= one_sided * shape.excess_mm2) return OutlierKind::smaller;
    return OutlierKind::other_shape;
}

OutlierKind kind_of(TopologyDifferenceKind kind) {
    switch (kind) {
        case TopologyDifferenceKind::part_missing:
            return OutlierKind::part_missing;
        case TopologyDifferenceKind::part_alone:
            return OutlierKind::part_alone;
        case TopologyDifferenceKind::hole_missing:
            return OutlierKind::hole_missing;
        case TopologyDifferenceKind::hole_alone:
            break;
    }
    return OutlierKind::hole_alone;
}

// Whether the section is aside so far that its middle tells it, though its neighbours grow.
bool is_far_aside(const ShapeDifference& shape) {
    return kind_of(shape) == OutlierKind::displaced &&
           shape.shift_mm >= std::max(least_shift_mm, least_shift_of_radius * circle_radius(shape.wide_mm2));
}

std::optional<Finding> finding_of(const ShapeDifference& shape, const Gaps& gaps, const Row& row) {
    const bool few = row.sections.size() < fewest_others + 5;  // two ends, the section and those beside it
    const OutlierKind kind = kind_of(shape);
    const bool displaced = kind == OutlierKind::displaced;
    const double wrong = shape.excess_mm2 + shape.deficit_mm2;
    const double radius = circle_radius(shape.wide_mm2);
    const double least = (few ? least_share_of_few : least_share) * std::max(1.0, gaps.most / row.usual_gap);
    if (few || !is_far_aside(shape)) {
        if (wrong * row.usual_gap < least_share_of_volume * row.volume && shape.share_of_all < half_as_much)
            return std::nullopt;
        if (shape.share < least || shape.share_of_all < least_share_of_all ||
            shape.mean_mm <
                std::max(least_gaps * gaps.most, std::min(least_mean_mm, least_mean_radii * radius)))
            return std::nullopt;
        if (displaced && shape.shift_mm < std::min(least_shift_mm, least_shift_radii * radius))
            return std::nullopt;
    }
    if (kind == OutlierKind::larger && row.sections.size() < fewest_round_middle) return std::nullopt;
    if (shape.beside_mm2 > (few ? most_beside_of_few : most_beside) * wrong) return std::nullopt;
    return Finding{kind, shape.contour, displaced ? shape.shift_mm : shape.mean_mm, wrong, shape.share};
}

// Whether a part alone lies far enough from others, and what is missing is not too small.
bool counts(const TopologyDifference& difference, double gap) {
    switch (difference.kind) {
        case TopologyDifferenceKind::part_alone:
            return difference.reach_mm > alone_gaps * gap;
        case TopologyDifferenceKind::hole_alone:
            return true;
        case TopologyDifferenceKind::part_missing:
        case TopologyDifferenceKind::hole_missing:
            break;
    }
    return difference.share >= least_missing;
}

std::optional<Finding> finding_of(const std::vector<TopologyDifference>& topology, const Gaps& gaps) {
    std::optional<Finding> worst;
    std::array<bool, 4> has{};
    for (const TopologyDifference& difference : topology) {
        if (!counts(difference, gaps.least)) continue;
        has[static_cast<std::size_t>(difference.kind)] = true;
        if (worst && worst->area_mm2 >= difference.area_mm2) continue;
        const bool alone = difference.kind == TopologyDifferenceKind::part_alone;
        worst = Finding{kind_of(difference.kind), difference.contour,
                        alone ? difference.reach_mm : 2 * circle_radius(difference.area_mm2),
                        difference.area_mm2, difference.share};
    }
    const auto both = [&](TopologyDifferenceKind a, TopologyDifferenceKind b) {
        return has[static_cast<std::size_t>(a)] && has[static_cast<std::size_t>(b)];
    };
    if (both(TopologyDifferenceKind::hole_missing, TopologyDifferenceKind::hole_alone))
        worst->kind = OutlierKind::hole_displaced;
    if (both(TopologyDifferenceKind::part_missing, TopologyDifferenceKind::part_alone))
        worst->kind = OutlierKind::part_displaced;
    return worst;
}

// What would be said of the n-th section kept, if other sections were as their neighbours tell.
TakenOut suspicion(const Row& row, std::size_t n) {
    TakenOut suspect{row.kept[n], row.kept[n - 1], row.kept[n + 1], {}, {}};
    const std::optional<SectionComparison>& comparison = row.comparisons[suspect.section];
    if (!comparison) return suspect;
    const Gaps gaps = gaps_of(row, suspect.below, suspect.section, suspect.above);
    suspect.shape = finding_of(comparison->shape, gaps, row);
    suspect.topology = finding_of(comparison->topology, gaps);
    return suspect;
}

double contradiction(const SectionComparison& comparison) {
    double sum = comparison.shape.share;
    for (const TopologyDifference& difference : comparison.topology) sum += difference.share;
    return sum;
}

// By how much less the sections contradict each other without the n-th one kept. One beside it that cannot be judged
// then, because the gap is too wide, counts as before.
double gain_of(const Row& row, std::size_t n) {
    double gain = contradiction(*row.comparisons[row.kept[n]]);
    const auto add = [&](std::size_t below, std::size_t one, std::size_t above) {
        const std::optional<SectionComparison>& before = row.comparisons[row.kept[one]];
        if (!before) return;
        const auto after = compared(row, row.kept[below], row.kept[one], row.kept[above]);
        if (after) gain += contradiction(*before) - contradiction(*after);
    };
    if (n >= 2) add(n - 2, n - 1, n + 1);
    if (n + 2 < row.kept.size()) add(n - 1, n + 1, n + 2);
    return gain;
}

// The suspect without which the others agree best: the one that contradicts its neighbours most, or one beside it.
std::optional<std::size_t> worst_of(const Row& row) {
    const auto is_suspect = [&](std::size_t n) {
        const TakenOut suspect = suspicion(row, n);
        return suspect.shape || suspect.topology;
    };
    std::optional<std::size_t> worst;
    for (std::size_t n = 1; n + 1 < row.kept.size(); ++n) {
        if (is_suspect(n) && (!worst || contradiction(*row.comparisons[row.kept[n]]) >
                                            contradiction(*row.comparisons[row.kept[*worst]])))
            worst = n;
    }
    if (!worst) return worst;
    std::size_t best = *worst;
    double most = gain_of(row, best);
    for (const std::size_t n : {*worst - 1, *worst + 1}) {
        if (n == 0 || n + 1 >= row.kept.size() || !is_suspect(n)) continue;
        const double gain = gain_of(row, n);
        if (gain <= most) continue;
        best = n;
        most = gain;
    }
    return best;
}

// The worst sections, each judged without those before it.
std::vector<TakenOut> take_out_worst(Row& row) {
    std::vector<TakenOut> taken;
    const auto most = static_cast<std::size_t>(most_outlying * static_cast<double>(row.sections.size())) + 1;
    while (taken.size() < most) {
        const std::optional<std::size_t> worst = worst_of(row);
        if (!worst) break;
        taken.push_back(suspicion(row, *worst));
        row.kept.erase(row.kept.begin() + static_cast<std::ptrdiff_t>(*worst));
        for (const std::size_t n : {*worst - 1, *worst}) row.comparisons[row.kept[n]] = compared(row, n);
    }
    return taken;
}

// The judged sections that were kept, without those beside the one taken out.
std::vector<const SectionComparison*> others_than(const TakenOut& out, const Row& row) {
    std::vector<const SectionComparison*> others;
    for (const std::uint32_t section : row.kept) {
        if (section != out.below && section != out.above && row.comparisons[section])
            others.push_back(&*row.comparisons[section]);
    }
    return others;
}

bool are_usual(std::size_t alike, std::size_t others) {
    return alike > 0 && static_cast<double>(alike) >= usual_share * static_cast<double>(others);
}

// The upper one of an even number.
double median_of(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

bool is_usual_shape(const TakenOut& out, const std::vector<const SectionComparison*>& others,
                    const std::vector<TakenOut>& taken) {
    const Finding& finding = *out.shape;
    std::size_t alike = 0;
    std::vector<double> shares, shifts;
    for (const SectionComparison* other : others) {
        shares.push_back(other->shape.share);
        shifts.push_back(other->shape.shift_mm);
        alike += other->shape.share >= half_as_much * finding.share && kind_of(other->shape) == finding.kind;
    }
    // Two slices that moved have moved for reasons of their own, while what grows twice is the shape.
    if (finding.kind != OutlierKind::displaced) {
        for (const TakenOut& other : taken)
            alike += &other != &out && other.shape && other.shape->kind == finding.kind &&
                     other.shape->share >= half_as_much * finding.share;
    }
    if (are_usual(alike, others.size())) return true;
    if (shares.size() < fewest_others) return false;
    return finding.kind == OutlierKind::displaced
               ? finding.distance_mm < times_median_shift * median_of(shifts)
               : finding.share < times_median * median_of(shares);
}

bool is_usual_topology(const TakenOut& out, const std::vector<const SectionComparison*>& others,
                       const std::vector<TakenOut>& taken, double gap) {
    const OutlierKind kind = out.topology->kind;
    auto alike = static_cast<std::size_t>(
        std::count_if(others.begin(), others.end(), [&](const SectionComparison* other) {
            return std::any_of(
                other->topology.begin(), other->topology.end(),
                [&](const TopologyDifference& d) { return kind_of(d.kind) == kind && counts(d, gap); });
        }));
    for (const TakenOut& other : taken)
        alike += &other != &out && other.topology && other.topology->kind == kind;
    return are_usual(alike, others.size());
}

// What is said of a section that was taken out, if anything.
std::optional<Finding> verdict_of(const TakenOut& out, const Row& row, const std::vector<TakenOut>& taken) {
    const std::vector<const SectionComparison*> others = others_than(out, row);
    std::optional<Finding> shape = out.shape, topology = out.topology;
    const double gap = gaps_of(row, out.below, out.section, out.above).least;
    if (topology && is_usual_topology(out, others, taken, gap)) topology.reset();
    if (shape && is_usual_shape(out, others, taken)) shape.reset();
    // A part or hole says more than the area that it leaves.
    return !topology || (shape && telling_share * shape->share > topology->share) ? shape : topology;
}

// Of the area that a contour encloses.
Vec3 middle_of(const ContourSet& set, const Contour& contour) {
    const Plane& plane = set.slices[contour.slice].plane;
    const auto points = set.points_of(contour);
    double area = 0;
    Vec2 moment;
    const Vec2 from = plane.to_plane(points[0]);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const Vec2 a = plane.to_plane(points[n]) - from,
                   b = plane.to_plane(points[(n + 1) % points.size()]) - from;
        area += 0.5 * cross(a, b);
        moment = moment + (cross(a, b) / 6) * (a + b);
    }
    return plane.to_space(area != 0 ? from + (1 / area) * moment : from);
}

std::vector<OutlyingSlice> outliers_of(Row& row, const JudgedStack& stack, const ContourSet& set) {
    std::vector<OutlyingSlice> outliers;
    const std::vector<TakenOut> taken = take_out_worst(row);
    const auto slice_of = [&](std::uint32_t section) { return stack.slices[row.sections[section].place]; };
    for (const TakenOut& out : taken) {
        const std::optional<Finding> verdict = verdict_of(out, row, taken);
        if (!verdict) continue;
        OutlyingSlice outlier;
        outlier.slice = slice_of(out.section);
        outlier.structure = row.structure;
        outlier.kind = verdict->kind;
        outlier.where = middle_of(set, set.contours[stack.contours[verdict->contour]]);
        outlier.distance_mm = verdict->distance_mm;
        outlier.area_mm2 = verdict->area_mm2;
        outlier.share = verdict->share;
        outlier.beside = {slice_of(out.below), slice_of(out.above)};
        outliers.push_back(outlier);
    }
    return outliers;
}

std::vector<Row> rows_of(const std::vector<JudgedStack>& stacks) {
    std::vector<Row> rows;
    for (std::uint32_t k = 0; k < stacks.size(); ++k) {
        for (std::uint32_t s = 0; s < stacks[k].charted.structures.size(); ++s) {
            Row row{k, s, sections_of(stacks[k].charted, s), 0, 0, {}, {}};
            if (row.sections.size() < 3) continue;
            std::vector<double> gaps;
            for (std::uint32_t n = 0; n < row.sections.size(); ++n) {
                row.kept.push_back(n);
                if (n > 0) gaps.push_back(row.sections[n].height - row.sections[n - 1].height);
            }
            std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2),
                             gaps.end());
            row.usual_gap = gaps[gaps.size() / 2];
            for (const Section& section : row.sections) row.volume += row.usual_gap * section.area;
            row.comparisons.resize(row.sections.size());
            rows.push_back(std::move(row));
        }
    }
    return rows;
}

}  // namespace

std::vector<OutlyingSlice> find_outlying_slices(const ContourSet& set, const SliceArrangement& arrangement,
                                                const RunContext& context) {
    const std::vector<JudgedStack> stacks = judged_stacks(set, arrangement);
    std::vector<Row> rows = rows_of(stacks);
    struct Task {
        std::size_t row, section;
    };
    std::vector<Task> tasks;
    for (std::size_t r = 0; r < rows.size(); ++r) {
        for (std::size_t n = 1; n + 1 < rows[r].sections.size(); ++n) tasks.push_back({r, n});
    }
    parallel_for(tasks.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end && !context.cancelled(); ++n) {
            Row& row = rows[tasks[n].row];
            row.comparisons[tasks[n].section] = compared(row, tasks[n].section);
        }
    });
    std::vector<std::vector<OutlyingSlice>> of_rows(rows.size());
    parallel_for(rows.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end && !context.cancelled(); ++r)
            of_rows[r] = outliers_of(rows[r], stacks[rows[r].stack], set);
    });
    std::vector<OutlyingSlice> worst;
    for (const std::vector<OutlyingSlice>& of_row : of_rows) {
        for (const OutlyingSlice& one : of_row) {
            const auto same = std::find_if(worst.begin(), worst.end(),
                                           [&](const OutlyingSlice& w) { return w.slice == one.slice; });
            if (same == worst.end())
                worst.push_back(one);
            else if (one.share > same->share)
                *same = one;
        }
    }
    std::sort(worst.begin(), worst.end(),
              [](const OutlyingSlice& a, const OutlyingSlice& b) { return a.slice < b.slice; });
    return worst;
}

}  // namespace anatomesh
