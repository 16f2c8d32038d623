#include "anatomesh/field/planes/crossed_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/model/field_queries.h"
#include "anatomesh/field/planes/plane_trace.h"
#include "anatomesh/field/slice/distance_map.h"
#include "anatomesh/field/slice/slice_regions.h"
#include "anatomesh/field/stack/stack_field.h"
#include "anatomesh/field/warnings/sparse_planes.h"
#include "anatomesh/field/warnings/thin_structures.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

// A slice that leans no more against the stack lies in it, and counts in its gaps although it was taken out.
// [degrees; 0 to 90; D]
constexpr double leaning_degrees = 30;
// A crossing plane corrects the stack so far to either side, as far as a slice of the stack is heard.
// [spacings; > 0; M 2026-11 cups, hollow cylinders and balls with crossing planes]
constexpr double reach_spacings = 2;
// Where a plane's share fades, it counts as from no nearer than this, so that its weight stays finite.
// [reaches; 0 to 1e-3; D rounding of doubles]
constexpr double nearest_share = 1e-9;
// A value in the plane is no larger than so many distances to what is drawn: else the sign would change in
// one step. [1; > 1; M 2026-11 cups, hollow cylinders and balls with crossing planes]
constexpr double most_steep = 10;
// Below this share of the distance to what is drawn the stack's value gives way to that distance, without a
// step. [1; 0 to 1; M 2026-11 winding vessel of 1 mm]
constexpr double least_steep = 0.3;
// Surfaces further apart in the plane than this do not agree; nearer ones differ as drawings of one outline
// do. [spacings; 0 to 1; M 2026-11 winding vessel of 1 mm]
constexpr double agreeing_spacings = 0.25;
// The stack's surface is traced in a plane with so many lattice steps a spacing: two of them are as far as
// surfaces agree. [steps a spacing; >= 4; D]
constexpr double trace_steps = 8;
// All traces together have no more lattice points; beyond it the steps grow. [points; >= 1e4; B]
constexpr double most_traced = 1e6;

class CrossedField final : public FieldQueries<CrossedField> {
  public:
    CrossedField(std::shared_ptr<const StructureField> stack, const ContourSet& set,
                 const StackAndCrossing& slices, const SliceCoverage& coverage, int threads)
        : stack_(std::move(stack)), reach_(reach_spacings * stack_->slice_spacing()) {
        clamp_ = stack_->clamp();
        const auto count = static_cast<std::uint32_t>(set.structures.size());
        const std::vector<PlanePatch> patches = plane_patches(set);
        for (const std::uint32_t s : slices.stack) {
            if (patches[s].box.empty()) continue;
            layers_.push_back({patches[s], {}});
            for (std::uint32_t n = 0; n < count; ++n) {
                if (coverage.is_unknown(s, n)) layers_.back().unknown.push_back(n);
            }
            layers_cover_all_ &= layers_.back().unknown.empty();
        }
        box_ = stack_->box();
        for (std::uint32_t s = 0; s < count; ++s) boxes_.push_back(stack_->box_of(s));
        for (const std::uint32_t s : slices.crossing) {
            if (patches[s].box.empty()) continue;
            planes_.push_back({patches[s], {}, {}});
            planes_.back().maps.resize(count);
            planes_.back().traces.resize(count);
            for (SliceRegion& region : slice_regions(set, s, patches[s].plane))
                planes_.back().maps[region.structure].emplace(std::move(region.edges), clamp_);
            for (const Contour& contour : set.contours_of(set.slices[s])) {
                Box3 drawn;
                for (const Vec3& p : set.points_of(contour)) drawn.extend(p);
                drawn = drawn.grown(reach_);
                for (Box3* const box : {&box_, &boxes_[contour.structure]}) {
                    box->extend(drawn.low);
                    box->extend(drawn.high);
                }
            }
        }
        trace_stack(threads);
    }

    double slice_spacing() const override { return stack_->slice_spacing(); }
    std::vector<const StructureField*> parts() const override { return {stack_.get()}; }
    Box3 box() const override { return box_; }
    Box3 box_of(std::uint32_t structure) const override { return boxes_[structure]; }

    static constexpr bool sides_cost_less = false;
    RawValue raw(std::uint32_t structure, Vec3 p, double reach) const {
        Sight sight;
        return {look(p, sight) ? value_at(structure, p, sight) : stack_->value_within(structure, p, reach)};
    }
    double raw_union(Vec3 p, double /*reach*/) const { return union_value(p); }

    template <class Body>
    void each_raw(Vec3 p, double /*reach*/, Body body) const {
        Sight sight;
        if (!look(p, sight)) {
            std::vector<Near> near;
            stack_->values_near(p, near);
            for (const Near& one : near) body(one.structure, RawValue{one.value});
            return;
        }
        for (std::uint32_t s = 0; s < boxes_.size(); ++s) {
            const double value = value_at(s, p, sight);
            if (value < clamp_) body(s, RawValue{value});
        }
    }

  private:
    struct Layer {
        PlanePatch patch;
        std::vector<std::uint32_t> unknown;  // structures of which it says nothing
    };
    struct CrossingPlane {
        PlanePatch patch;
        std::vector<std::optional<DistanceMap>> maps;    // by structure; of others it says nothing
        std::vector<std::optional<DistanceMap>> traces;  // of what the stack has there
    };
    // The planes near a point, and the nearest slice of the stack.
    struct Sight {
        struct Seen {
            const CrossingPlane* plane;
            double weight;  // grows beyond all bounds towards the plane
            Vec2 at;        // the point's projection
            double distance;
            bool on_plane;
        };
        std::vector<Seen> planes;
        double nearest = 0;  // distance of the nearest layer
    };

    static double distance_from(const PlanePatch& patch, Vec3 p) {
        const double height = patch.plane.signed_distance(p);
        return std::abs(std::clamp(height, patch.low, patch.high) - height);
    }

    // The nearest slice of the stack that says something of the structure.
    double nearest_layer(std::uint32_t structure, Vec3 p) const {
        double nearest = HUGE_VAL;
        for (const Layer& layer : layers_) {
            if (std::find(layer.unknown.begin(), layer.unknown.end(), structure) == layer.unknown.end())
                nearest = std::min(nearest, distance_from(layer.patch, p));
        }
        return nearest;
    }

    // False where the stack alone counts.
    bool look(Vec3 p, Sight& sight) const {
        const double margin = stack_->slice_spacing();
        for (const CrossingPlane& plane : planes_) {
            const double distance = distance_from(plane.patch, p);
            if (distance >= reach_) continue;
            const Vec2 at = plane.patch.plane.to_plane(p);
            const Box2& box = plane.patch.box;
            const Vec2 beside{std::clamp(at.x, box.low.x, box.high.x) - at.x,
                              std::clamp(at.y, box.low.y, box.high.y) - at.y};
            const double share = std::clamp(2 - length(beside) / margin, 0.0, 1.0);
            if (share == 0) continue;
            // On a plane beside what it draws, where its share fades, it counts as from very near.
            const double from = std::max(distance, nearest_share * reach_);
            sight.planes.push_back({&plane, share * (reach_ - from) / (reach_ * from), at, distance,
                                    distance == 0 && share == 1});
        }
        if (sight.planes.empty()) return false;
        sight.nearest = HUGE_VAL;
        for (const Layer& layer : layers_)
            sight.nearest = std::min(sight.nearest, distance_from(layer.patch, p));
        return sight.nearest > 0 || !layers_cover_all_;
    }

    double value_at(std::uint32_t structure, Vec3 p, const Sight& sight) const {
        const double stack = no_further_than_drawn(structure, stack_->value(structure, p), sight);
        const double nearest = layers_cover_all_ ? sight.nearest : nearest_layer(structure, p);
        if (nearest == 0) return stack;
        double all = 1 / nearest, sum = 0;
        for (const auto& [plane, weight, at, distance, on_plane] : sight.planes) {
            if (!plane->maps[structure]) continue;
            // Of several that meet here one will do: what is drawn on them agrees.
            if (on_plane) return drawn_instead(stack, *plane, structure, at);
            const double far = std::abs(plane->maps[structure]->value(at)),
                         there =
                             std::clamp(stack_->value(structure, plane->patch.plane.to_space(at)), -far, far);
            sum += weight * (drawn_instead(there, *plane, structure, at) - there);
            all += weight;
        }
        return std::clamp(stack + sum / all, -clamp_, clamp_);
    }

    // The stack's value, where what is drawn across it is nearer: the surface runs there, so that what the
    // stack has deep inside, or far outside, is not. Its surface stays.
    static double no_further_than_drawn(std::uint32_t structure, double stack, const Sight& sight) {
        for (const Sight::Seen& seen : sight.planes) {
            if (!seen.plane->maps[structure]) continue;
            const double most = std::hypot(seen.distance, seen.plane->maps[structure]->value(seen.at));
            stack = std::clamp(stack, -most, most);
        }
        return stack;
    }

    // Where the stack's own surfaces cut the planes, as far as these say something.
    void trace_stack(int threads) {
        const double beside = 2 * stack_->slice_spacing() + clamp_;
        double area = 0;
        for (const CrossingPlane& plane : planes_) {
            const Vec2 size = plane.patch.box.high - plane.patch.box.low;
            const auto drawn = std::count_if(plane.maps.begin(), plane.maps.end(),
                                             [](const auto& map) { return map.has_value(); });
            area += static_cast<double>(drawn) * (size.x + 2 * beside) * (size.y + 2 * beside);
        }
        const double step = std::max(stack_->slice_spacing() / trace_steps, std::sqrt(area / most_traced));
        for (CrossingPlane& plane : planes_) {
            for (std::uint32_t s = 0; s < plane.maps.size(); ++s) {
                if (!plane.maps[s]) continue;
                const auto value = [&](Vec2 q) {
                    return stack_->value_within(s, plane.patch.plane.to_space(q), 0);
                };
                std::vector<Edge2> edges =
                    trace_in_plane(value, plane.patch.box.grown(beside), step, threads);
                if (!edges.empty()) plane.traces[s].emplace(std::move(edges), clamp_);
            }
        }
    }

    // What takes the place of the stack's value in the plane. Its sign is that of what is drawn, and where
    // they have the same sign and the stack's is the larger, it stays. Where the stack's is the smaller, it
    // stays as far as its surface runs in the plane where the contours run, and else the distance from these
    // takes its place: where they run along the boundary, distances in the plane are larger than those in the
    // slices.
    double drawn_instead(double stack, const CrossingPlane& plane, std::uint32_t structure, Vec2 at) const {
        const double drawn = plane.maps[structure]->value(at), side = drawn < 0 ? -1 : 1;
        const double far = std::abs(drawn), own = side * stack;
        if (own >= far) return side * std::min(own, most_steep * far);
        if (own <= 0) return drawn;
        const double traced = plane.traces[structure] ? plane.traces[structure]->value(at) : clamp_;
        const double agreed =
            std::max(0.0, 1 - std::abs(drawn - traced) / (agreeing_spacings * stack_->slice_spacing()));
        const double kept = agreed * std::min(1.0, own / (least_steep * far));
        return side * (far - kept * (far - own));
    }

    std::shared_ptr<const StructureField> stack_;
    double reach_;
    std::vector<Layer> layers_;
    bool layers_cover_all_ = true;
    std::vector<CrossingPlane> planes_;
    Box3 box_;
    std::vector<Box3> boxes_;  // by structure
};

// How many slices one after the other were taken out of the stack, those across it left aside.
std::size_t longest_gap(const ContourSet& set, const StackAndCrossing& slices) {
    const Plane& first = set.slices[slices.stack.front()].plane;
    const Box3 box = set.box();
    const Vec3 middle = 0.5 * (box.low + box.high);
    std::vector<std::pair<double, bool>> places;  // along the first one's normal; whether taken out
    const auto add = [&](std::uint32_t s, bool out) {
        const Plane& plane = set.slices[s].plane;
        const double along = dot(plane.normal, first.normal);
        if (out && std::abs(along) < std::cos(leaning_degrees * std::numbers::pi / 180)) return;
        places.push_back({along == 0 ? 0 : -plane.signed_distance(middle) / along, out});
    };
    for (const std::uint32_t s : slices.stack) add(s, false);
    for (const std::uint32_t s : slices.crossing) add(s, true);
    std::sort(places.begin(), places.end());
    std::size_t longest = 0, run = 0;
    for (const auto& [place, out] : places) longest = std::max(longest, run = out ? run + 1 : 0);
    return longest;
}

}  // namespace

Result<std::shared_ptr<const StructureField>> make_crossed_field(const ContourSet& set,
                                                                 const SliceFacts& slices,
                                                                 const FieldOptions& options,
                                                                 RunContext& context) {
    // Where a slice was taken out there is no gap.
    const StackAndCrossing& parts = *slices.arrangement.parts;
    const std::size_t gap = longest_gap(set, parts);
    FieldOptions of_stack = options;
    of_stack.max_gap_spacings *= 1 + static_cast<double>(gap);
    const auto before = static_cast<std::ptrdiff_t>(context.warnings.size());
    // The stack is another set than the whole: what is left without the slices across it.
    const ContourSet chosen = chosen_slices(set, parts.stack);
    ANATOMESH_TRY(std::shared_ptr<const StructureField> stack,
                  make_stack_field(chosen, arrangement_of(chosen), of_stack, context));
    if (gap > 0) {
        const auto bridged = std::remove_if(context.warnings.begin() + before, context.warnings.end(),
                                            [](const Warning& w) { return w.code == "W-FLD-002"; });
        context.warnings.erase(bridged, context.warnings.end());
    }
    const double spacing = stack->slice_spacing();
    warn_about_thin_structures(set, spacing, context);
    std::shared_ptr<const StructureField> field =
        std::make_shared<CrossedField>(std::move(stack), set, parts, slices.coverage, context.threads);
    // What lies between two slices of the stack they tell.
    warn_about_sparse_planes(set, *field, std::vector<double>(set.structures.size(), 0.5 * spacing), context);
    return field;
}

}  // namespace anatomesh
