#include "anatomesh/outliers/judged_stacks.h"

#include <string>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/measure/topology/stacks_of_slices.h"

namespace anatomesh {

namespace {

// Requires: each slice of the chart has the contours of its slice in their order.
void find_contours(const ContourSet& contours, JudgedStack& stack) {
    for (const std::uint32_t s : stack.slices) {
        const Slice& slice = contours.slices[s];
        for (std::uint32_t n = 0; n < slice.contour_count; ++n)
            stack.contours.push_back(slice.first_contour + n);
    }
}

JudgedStack about_axis(const ContourSet& contours, const RotationalSweep& rotation) {
    JudgedStack stack;
    // A slice comes several times in the chart, and its name comes with it.
    ContourSet numbered = contours;
    for (std::uint32_t s = 0; s < numbered.slices.size(); ++s) numbered.slices[s].name = std::to_string(s);
    stack.charted = rotation.to_chart(numbered);
    for (const Slice& slice : stack.charted.slices)
        stack.slices.push_back(parse_integer<std::uint32_t>(slice.name).value_or(0));
    find_contours(contours, stack);
    return stack;
}

JudgedStack along_path(const ContourSet& contours, const SlicePath& path) {
    JudgedStack stack;
    stack.charted = path.to_chart(contours);
    for (const PathSlice& part : path.slices()) {
        stack.slices.push_back(part.slice);
        stack.contours.insert(stack.contours.end(), part.contours.begin(), part.contours.end());
    }
    return stack;
}

}  // namespace

std::vector<JudgedStack> judged_stacks(const ContourSet& contours, const SliceArrangement& arrangement) {
    std::vector<JudgedStack> stacks;
    if (arrangement.kind == ArrangementKind::about_axis && arrangement.rotation) {
        stacks.push_back(about_axis(contours, *arrangement.rotation));
        return stacks;
    }
    for (const SlicePath& path : arrangement.paths) stacks.push_back(along_path(contours, path));
    for (StackOfSlices& found : stacks_of_slices(contours, arrangement)) {
        JudgedStack stack;
        stack.charted = std::move(found.charted);
        stack.slices = std::move(found.slices);
        find_contours(contours, stack);
        stacks.push_back(std::move(stack));
    }
    return stacks;
}

}  // namespace anatomesh
