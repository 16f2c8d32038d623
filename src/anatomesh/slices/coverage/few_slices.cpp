#include "anatomesh/slices/coverage/few_slices.h"

#include <algorithm>
#include <limits>

#include "anatomesh/contour/model/slice_groups.h"

namespace anatomesh {

namespace {

// The drawing leaves out images where it is wider apart than they are thick by more than this factor.
// [thicknesses; 1 to 2; D half way between every image and every second one]
constexpr double leaves_out_images = 1.5;

// A structure that is drawn on more slices: the intervals that draw it, and its spacing.
struct OnMoreSlices {
    const std::vector<std::uint32_t>* drawn = nullptr;
    double spacing = 0;
};

// The lower median of the gaps between a structure's slices; planes in groups count once.
double spacing_of(const std::vector<SliceInterval>& intervals, const std::vector<std::uint32_t>& drawn) {
    std::vector<double> gaps;
    for (std::size_t i = 1; i < drawn.size(); ++i)
        gaps.push_back(intervals[drawn[i]].low - intervals[drawn[i - 1]].high);
    gaps = gaps_between_groups(gaps);
    const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>((gaps.size() - 1) / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    return *middle;
}

// Of every structure, the intervals that draw it.
std::vector<std::vector<std::uint32_t>> drawn_intervals(const ContourSet& set,
                                                        const std::vector<SliceInterval>& intervals) {
    std::vector<std::vector<std::uint32_t>> drawn(set.structures.size());
    for (std::uint32_t i = 0; i < intervals.size(); ++i)
        for (const Contour& contour : set.contours_of(set.slices[intervals[i].slice])) {
            std::vector<std::uint32_t>& of_structure = drawn[contour.structure];
            if (of_structure.empty() || of_structure.back() != i) of_structure.push_back(i);
        }
    return drawn;
}

// The least spacing of structures that are drawn on these slices, too, and of any. 0: none.
struct SpacingOfOthers {
    double same_slices = 0, any = 0;
};

SpacingOfOthers spacing_of_others(const std::vector<OnMoreSlices>& others,
                                  const std::vector<std::uint32_t>& slices) {
    constexpr double none = std::numeric_limits<double>::infinity();
    double same_slices = none, any = none;
    for (const OnMoreSlices& other : others) {
        any = std::min(any, other.spacing);
        if (std::includes(other.drawn->begin(), other.drawn->end(), slices.begin(), slices.end()))
            same_slices = std::min(same_slices, other.spacing);
    }
    return {same_slices < none ? same_slices : 0, any < none ? any : 0};
}

}  // namespace

std::vector<FewSlices> structures_on_few_slices(const ContourSet& set,
                                                const std::vector<SliceInterval>& intervals,
                                                double asked_mm) {
    std::vector<FewSlices> few;
    if (says_all(set)) return few;
    const std::vector<std::vector<std::uint32_t>> drawn = drawn_intervals(set, intervals);
    std::vector<OnMoreSlices> others;
    for (const std::vector<std::uint32_t>& slices : drawn) {
        if (slices.size() > most_few_slices) others.push_back({&slices, spacing_of(intervals, slices)});
    }
    for (std::uint32_t s = 0; s < drawn.size(); ++s) {
        if (drawn[s].empty() || drawn[s].size() > most_few_slices) continue;
        FewSlices which{s};
        for (const std::uint32_t i : drawn[s]) which.slices.push_back(intervals[i].slice);
        const SpacingOfOthers spacing = spacing_of_others(others, drawn[s]);
        const double stated = set.slice_thickness_mm;
        if (asked_mm > 0) {
            which.mm = asked_mm;
            which.by = ThicknessBy::option;
        } else if (stated > 0 && spacing.same_slices <= leaves_out_images * stated) {
            which.mm = stated;
            which.by = ThicknessBy::source;
        } else if (spacing.any > 0) {
            which.mm = spacing.same_slices > 0 ? spacing.same_slices : spacing.any;
            which.by = ThicknessBy::others;
        }
        if (drawn[s].size() == 2 && which.by != ThicknessBy::option)
            which.mm = std::min(which.mm, intervals[drawn[s][1]].low - intervals[drawn[s][0]].high);
        few.push_back(std::move(which));
    }
    return few;
}

double thickness_of(const std::vector<FewSlices>& few, std::uint32_t structure) {
    const auto found = std::find_if(few.begin(), few.end(),
                                    [&](const FewSlices& which) { return which.structure == structure; });
    return found != few.end() ? found->mm : 0;
}

double thickness_of_all(const ContourSet& set, const std::vector<FewSlices>& few) {
    std::vector<bool> is_few(set.structures.size(), false);
    double least = 0;
    for (const FewSlices& which : few) {
        is_few[which.structure] = true;
        if (which.mm > 0 && (least == 0 || which.mm < least)) least = which.mm;
    }
    const bool all = std::all_of(set.contours.begin(), set.contours.end(), [&](const Contour& contour) {
        return static_cast<bool>(is_few[contour.structure]);
    });
    return all ? least : 0;
}

std::vector<std::uint32_t> structures_on_few_slices(const ContourSet& set) {
    std::vector<std::uint32_t> few;
    if (says_all(set)) return few;
    std::vector<std::size_t> count(set.structures.size(), 0);
    for (const Slice& slice : set.slices) {
        const Contour* before = nullptr;
        for (const Contour& contour : set.contours_of(slice)) {
            if (before == nullptr || before->structure != contour.structure) ++count[contour.structure];
            before = &contour;
        }
    }
    for (std::uint32_t s = 0; s < count.size(); ++s)
        if (count[s] > 0 && count[s] <= most_few_slices) few.push_back(s);
    return few;
}

}  // namespace anatomesh
