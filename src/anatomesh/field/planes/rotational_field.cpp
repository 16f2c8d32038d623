#include "anatomesh/field/planes/rotational_field.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include "anatomesh/field/model/field_queries.h"
#include "anatomesh/field/planes/general_field.h"
#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/field/warnings/missing_slices.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/arrangement/rotation_axis.h"

namespace anatomesh {

namespace {

// Where slices are nearer to each other than so many mean distances of vertices, planes in any position
// decide: contours are not drawn as finely. [mean vertex distances; > 0; M 2026-11 random sets about an axis]
constexpr double near_vertices = 1;
// The sweep in the chart joins every gap up to this: which ones are joined was decided by angle before.
// [spacings; >= 1e3; D]
constexpr double any_gap = 1e6;
constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

using Field = std::shared_ptr<const StructureField>;

// Where a point is.
struct Place {
    Vec3 in_chart;
    double near = 0;  // 1 near the axis, 0 away from it
};

// What both fields know of places.
struct Parts {
    RotationalSweep sweep;
    Field away;  // in chart coordinates
    Field near;
    double near_spacing = 0;  // slices nearer to each other are near the axis

    // Both count where slices are up to twice as far apart, and as far again as they run beside the axis.
    Place place(Vec3 p) const {
        const double radius = std::max(near_spacing / sweep.angle(p), sweep.apart_from(p));
        const double share = std::clamp(2 - sweep.radius(p) / radius, 0.0, 1.0);
        return {share < 1 ? sweep.to_chart(p) : Vec3{}, share};
    }
};

// Between near and away.
class BlendedField final : public FieldQueries<BlendedField> {
  public:
    explicit BlendedField(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {
        clamp_ = parts_->near->clamp();
        partition_ = parts_->near->exclusive();
    }

    double slice_spacing() const override { return parts_->near->slice_spacing(); }
    Box3 box() const override { return parts_->near->box(); }

    static constexpr bool sides_cost_less = false;
    RawValue raw(std::uint32_t structure, Vec3 p, double /*reach*/) const {
        const Place at = parts_->place(p);
        return {blended(at, parts_->near->value(structure, p), parts_->away->value(structure, at.in_chart))};
    }

    double raw_union(Vec3 p, double /*reach*/) const {
        const Place at = parts_->place(p);
        return blended(at, parts_->near->union_value(p), parts_->away->union_value(at.in_chart));
    }

    template <class Body>
    void each_raw(Vec3 p, double /*reach*/, Body body) const {
        const Place at = parts_->place(p);
        std::vector<Near> near, away;
        parts_->near->values_near(p, near);
        parts_->away->values_near(at.in_chart, away);
        const auto value_in = [&](const std::vector<Near>& list, std::size_t& n, std::uint32_t s) {
            return n < list.size() && list[n].structure == s ? list[n++].value : clamp_;
        };
        for (std::size_t i = 0, j = 0; i < near.size() || j < away.size();) {
            const std::uint32_t s = std::min(i < near.size() ? near[i].structure : none,
                                             j < away.size() ? away[j].structure : none);
            const double value = blended(at, value_in(near, i, s), value_in(away, j, s));
            if (value < clamp_) body(s, RawValue{value});
        }
    }

  private:
    static double blended(const Place& at, double near, double away) {
        return at.near * near + (1 - at.near) * away;
    }

    std::shared_ptr<const Parts> parts_;
};

class RotationalField final : public StructureField {
    // By the field that counts there.
    template <class Ask>
    auto ask(Vec3 p, Ask question) const {
        const Place at = parts_->place(p);
        const StructureField& field = at.near == 0 ? *parts_->away : at.near == 1 ? *parts_->near : between_;
        return question(field, at.near == 0 ? at.in_chart : p);
    }

  public:
    RotationalField(Parts parts, const ContourSet& set, const ContourSet& charted)
        : parts_(std::make_shared<const Parts>(std::move(parts))), between_(parts_) {
        // How far beyond the contours' box the field reaches.
        const Box3 inner = charted.box(), outer = parts_->away->box();
        const double reach = std::max({inner.low.x - outer.low.x, inner.low.y - outer.low.y,
                                       outer.high.x - inner.high.x, outer.high.y - inner.high.y, 0.0});
        box_ = grown(set.box(), parts_->near->box(), reach);
        std::vector<Box3> drawn(set.structures.size());
        for (const Contour& contour : set.contours) {
            for (const Vec3& p : set.points_of(contour)) drawn[contour.structure].extend(p);
        }
        for (std::uint32_t s = 0; s < drawn.size(); ++s)
            boxes_.push_back(drawn[s].empty() ? Box3{} : grown(drawn[s], parts_->near->box_of(s), reach));
    }

    double value(std::uint32_t structure, Vec3 p) const override {
        return ask(p, [&](const StructureField& field, Vec3 q) { return field.value(structure, q); });
    }
    double value_within(std::uint32_t structure, Vec3 p, double reach) const override {
        return ask(
            p, [&](const StructureField& field, Vec3 q) { return field.value_within(structure, q, reach); });
    }
    void values_near(Vec3 p, std::vector<Near>& near) const override {
        ask(p, [&](const StructureField& field, Vec3 q) { field.values_near(q, near); });
    }
    void members(Vec3 p, std::vector<std::uint32_t>& out) const override {
        ask(p, [&](const StructureField& field, Vec3 q) { field.members(q, out); });
    }
    double interface_distance(Vec3 p) const override {
        return ask(p, [](const StructureField& field, Vec3 q) { return field.interface_distance(q); });
    }
    double union_value(Vec3 p) const override {
        return ask(p, [](const StructureField& field, Vec3 q) { return field.union_value(q); });
    }
    double members_and_distance(Vec3 p, std::vector<std::uint32_t>& out) const override {
        return ask(p,
                   [&](const StructureField& field, Vec3 q) { return field.members_and_distance(q, out); });
    }
    bool exclusive() const override { return parts_->near->exclusive(); }
    double slice_spacing() const override { return parts_->near->slice_spacing(); }
    double clamp() const override { return parts_->near->clamp(); }
    std::vector<const StructureField*> parts() const override {
        return {parts_->away.get(), parts_->near.get()};
    }
    Box3 box() const override { return box_; }
    Box3 box_of(std::uint32_t structure) const override { return boxes_[structure]; }

  private:
    Box3 grown(const Box3& drawn, const Box3& near, double reach) const {
        Box3 box = parts_->sweep.around(drawn, reach);
        box.extend(near.low);
        box.extend(near.high);
        return box;
    }

    std::shared_ptr<const Parts> parts_;
    BlendedField between_;
    Box3 box_;
    std::vector<Box3> boxes_;  // by structure; empty of one that is not drawn
};

void warn_about_gaps(const ContourSet& set, const RotationalSweep& sweep, RunContext& context) {
    for (const bool joined : {false, true}) {
        std::vector<RotationalSweep::Gap> gaps = sweep.wide_gaps();
        std::erase_if(gaps, [&](const auto& gap) { return gap.joined != joined; });
        if (gaps.empty()) continue;
        const auto widest = std::max_element(gaps.begin(), gaps.end(),
                                             [](const auto& x, const auto& y) { return x.angle < y.angle; });
        char value[160];
        std::snprintf(value, sizeof value, "%zu gap%s, the widest %.1f degrees, between it and slice ",
                      gaps.size(), gaps.size() > 1 ? "s" : "", widest->angle * 180 / std::numbers::pi);
        context.warn(
            {joined ? "W-FLD-002" : "W-FLD-001",
             "slices about the axis are missing, or one half of them is empty",
             {set.source, set.slices[widest->from].name, "", "", value + set.slices[widest->to].name},
             joined ? "the structure was continued through the gaps, where its shape is a guess"
                    : "the structure ends on both sides of the gaps, except near the axis; --max-gap joins "
                      "it over up to 110 degrees"});
    }
}

}  // namespace

Result<std::shared_ptr<const StructureField>> make_rotational_field(const ContourSet& set,
                                                                    const SliceFacts& slices,
                                                                    const FieldOptions& options,
                                                                    RunContext& context) {
    Parts parts{*slices.arrangement.rotation, nullptr, nullptr, 0};
    FieldOptions near = options;
    near.least_reach_mm = reach_across_axis * parts.sweep.beside();
    ANATOMESH_TRY(parts.near, make_general_field(set, slices.coverage, near, context));
    RunContext apart;  // its warnings are those of the field near the axis, or of chart coordinates
    apart.threads = context.threads;
    apart.cancel = context.cancel;
    if (slices.coverage.has_unknown()) {
        warn_about_missing_slices(set, slices.arrangement.axis, context);
        return parts.near;
    }
    warn_about_gaps(set, parts.sweep, context);
    const ContourSet charted = parts.sweep.to_chart(set);
    FieldOptions in_chart = options;
    in_chart.clamp_mm = parts.near->clamp();
    in_chart.max_gap_spacings = any_gap;
    in_chart.every_slice_covers = true;
    ANATOMESH_TRY(parts.away, make_parallel_field(charted, in_chart, apart));
    parts.near_spacing = near_vertices * mean_vertex_spacing(set);
    return std::shared_ptr<const StructureField>(
        std::make_shared<RotationalField>(std::move(parts), set, charted));
}

}  // namespace anatomesh
