#include "anatomesh/uncertainty/gap_doubts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/field/stack/slice_knots.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"
#include "anatomesh/slices/coverage/covering_slices.h"
#include "anatomesh/slices/coverage/few_slices.h"

namespace anatomesh {

namespace {

// By structure and slice.
std::vector<std::vector<double>> drawn_areas(const ContourSet& set) {
    std::vector<std::vector<double>> areas(set.structures.size(), std::vector<double>(set.slices.size(), 0));
    std::vector<Vec2> polygon;
    for (const Contour& contour : set.contours) {
        polygon.clear();
        for (const Vec3& point : set.points_of(contour))
            polygon.push_back(set.slices[contour.slice].plane.to_plane(point));
        areas[contour.structure][contour.slice] += signed_area(polygon);  // of holes below 0
    }
    return areas;
}

}  // namespace

GapDoubts::GapDoubts(const ContourSet& set, const FieldOptions& options)
    : max_gap_spacings_(options.max_gap_spacings) {
    for (const PlanePatch& patch : plane_patches(set)) {
        planes_.push_back(patch.plane);
        if (!patch.box.empty())
            planes_.back().origin = patch.plane.to_space(0.5 * (patch.box.low + patch.box.high));
    }
    SliceArrangement arrangement = arrangement_of(set);
    if (!arrangement.is_stack()) return;
    sweep_ = std::move(arrangement.sweep);
    const ContourSet stack = sweep_ ? sweep_->to_chart(set) : set;
    frame_ = stack.slices.front().plane;
    if (sweep_) frame_.origin = {};  // chart heights are heights above 0
    const std::vector<SliceInterval> intervals = parallel_intervals(stack, frame_);
    const std::vector<std::vector<double>> areas = drawn_areas(set);
    const double spacing = median_spacing(stack);
    if (intervals.empty() || !(spacing > 0)) return;
    const std::vector<FewSlices> few = structures_on_few_slices(stack, intervals, options.single_slice_mm);
    for (std::uint32_t s = 0; s < areas.size(); ++s) {
        std::vector<std::uint32_t> drawn;
        for (std::uint32_t i = 0; i < intervals.size(); ++i) {
            if (areas[s][intervals[i].slice] > 0) drawn.push_back(i);
        }
        if (drawn.empty()) continue;
        GapEvidence evidence;
        evidence.left_out = heights_left_out(stack, s, frame_.origin, frame_.normal);
        evidence.thickness = thickness_of(few, s);
        const StructureKnots found =
            structure_knots(intervals, drawn, says_all(set), spacing, options, evidence);
        for (const SliceGap& gap : found.open_gaps) {
            const auto [low, high, a, b] = gap;
            // Empty levels stand a spacing from both sides.
            const auto below =
                std::find_if(found.knots.begin(), found.knots.end(),
                             [from = low](const SliceKnot& level) { return level.high > from; });
            const auto above = below + 1;
            gaps_.push_back({s, a, b, low, high, low, high, 0.5 * (below->low - low + high - above->low),
                             0.5 * (areas[s][a] + areas[s][b])});
        }
    }
}

double GapDoubts::height_of(Vec3 p) const {
    return frame_.signed_distance(sweep_ ? sweep_->to_chart(p) : p);
}

double GapDoubts::doubt(const Gap& gap) const {
    const double height = gap.high - gap.low, joined = 1.001 * max_gap_spacings_ * gap.spacing;
    if (height <= joined) return 0;
    return gap.area * (height - gap.spacing) * 0.5 * (1 - joined / height);
}

std::vector<PlaneBetween> GapDoubts::middles() const {
    std::vector<PlaneBetween> middles;
    for (const Gap& gap : gaps_) {
        if (!(doubt(gap) > 0)) continue;
        const Plane &a = planes_[gap.slice_a], &b = planes_[gap.slice_b];
        const double t = (0.5 * (gap.low + gap.high) - gap.first) / (gap.last - gap.first);
        const double same_way = dot(a.normal, b.normal) < 0 ? -1 : 1;
        const Vec3 normal = (1 - t) * a.normal + (t * same_way) * b.normal;
        middles.push_back({make_plane((1 - t) * a.origin + t * b.origin, normalized(normal)),
                           static_cast<std::int64_t>(std::min(gap.slice_a, gap.slice_b)),
                           static_cast<std::int64_t>(std::max(gap.slice_a, gap.slice_b))});
    }
    return middles;
}

bool GapDoubts::is_across(const PlaneBetween& between) const {
    if (between.slice_b < 0 || gaps_.empty()) return false;
    const double a = height_of(planes_[static_cast<std::size_t>(between.slice_a)].origin),
                 b = height_of(planes_[static_cast<std::size_t>(between.slice_b)].origin);
    const double low = std::min(a, b), high = std::max(a, b);
    return std::any_of(gaps_.begin(), gaps_.end(), [&](const Gap& gap) {
        const double middle_a = height_of(planes_[gap.slice_a].origin),
                     middle_b = height_of(planes_[gap.slice_b].origin);
        return low <= middle_a && middle_b <= high && high - low > middle_b - middle_a;
    });
}

double GapDoubts::volume() const {
    double volume = 0;
    for (const Gap& gap : gaps_) volume += doubt(gap);
    return volume;
}

double GapDoubts::gain(Vec3 p, std::vector<double>& by_structure) const {
    if (gaps_.empty()) return 0;
    const double height = height_of(p);
    double gain = 0;
    for (const Gap& gap : gaps_) {
        if (!(height > gap.low && height < gap.high)) continue;
        Gap below = gap, above = gap;
        below.high = above.low = height;
        const double of_gap = doubt(gap) - doubt(below) - doubt(above);
        by_structure[gap.structure] += of_gap;
        gain += of_gap;
    }
    return gain;
}

void GapDoubts::draw(Vec3 p) {
    if (gaps_.empty()) return;
    const double height = height_of(p);
    const std::size_t count = gaps_.size();
    for (std::size_t g = 0; g < count; ++g) {
        if (!(height > gaps_[g].low && height < gaps_[g].high)) continue;
        gaps_.push_back(gaps_[g]);
        gaps_[g].high = gaps_.back().low = height;
    }
}

}  // namespace anatomesh
