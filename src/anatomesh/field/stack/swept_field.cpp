#include "anatomesh/field/stack/swept_field.h"

#include <algorithm>
#include <utility>

#include "anatomesh/field/stack/parallel_field.h"

namespace anatomesh {

namespace {

class SweptField final : public StructureField {
  public:
    SweptField(Sweep sweep, std::shared_ptr<const StructureField> in_chart, const ContourSet& set,
               const ContourSet& charted)
        : sweep_(std::move(sweep)), in_chart_(std::move(in_chart)) {
        // How far beyond the contours' box the field reaches.
        const Box3 inner = charted.box(), outer = in_chart_->box();
        const Vec3 low = inner.low - outer.low, high = outer.high - inner.high;
        const double reach = std::max({low.x, low.y, low.z, high.x, high.y, high.z});
        box_ = sweep_.around(set.box(), reach);
        boxes_.resize(set.structures.size());
        for (const Contour& contour : set.contours) {
            for (const Vec3& p : set.points_of(contour)) boxes_[contour.structure].extend(p);
        }
        for (Box3& box : boxes_) {
            if (!box.empty()) box = sweep_.around(box, reach);
        }
    }

    double value(std::uint32_t structure, Vec3 p) const override {
        return in_chart_->value(structure, sweep_.to_chart(p));
    }
    double value_within(std::uint32_t structure, Vec3 p, double reach) const override {
        return in_chart_->value_within(structure, sweep_.to_chart(p), reach);
    }
    void values_near(Vec3 p, std::vector<Near>& near) const override {
        in_chart_->values_near(sweep_.to_chart(p), near);
    }
    void members(Vec3 p, std::vector<std::uint32_t>& out) const override {
        in_chart_->members(sweep_.to_chart(p), out);
    }
    double interface_distance(Vec3 p) const override {
        return in_chart_->interface_distance(sweep_.to_chart(p));
    }
    bool exclusive() const override { return in_chart_->exclusive(); }
    double union_value(Vec3 p) const override { return in_chart_->union_value(sweep_.to_chart(p)); }
    double members_and_distance(Vec3 p, std::vector<std::uint32_t>& out) const override {
        return in_chart_->members_and_distance(sweep_.to_chart(p), out);
    }
    std::vector<Plane> flat_ends() const override {
        std::vector<Plane> ends;
        for (const Plane& end : in_chart_->flat_ends()) ends.push_back(sweep_.slice_at(end.origin.z));
        return ends;
    }
    double slice_spacing() const override { return in_chart_->slice_spacing(); }
    double clamp() const override { return in_chart_->clamp(); }
    std::vector<const StructureField*> parts() const override { return {in_chart_.get()}; }
    Box3 box() const override { return box_; }
    Box3 box_of(std::uint32_t structure) const override { return boxes_[structure]; }

  private:
    Sweep sweep_;
    std::shared_ptr<const StructureField> in_chart_;
    Box3 box_;
    std::vector<Box3> boxes_;  // by structure; empty of one that is not drawn
};

}  // namespace

Result<std::shared_ptr<const StructureField>> make_swept_field(Sweep sweep, const ContourSet& set,
                                                               const FieldOptions& options,
                                                               RunContext& context) {
    const ContourSet charted = sweep.to_chart(set);
    ANATOMESH_TRY(std::shared_ptr<const StructureField> in_chart,
                  make_parallel_field(charted, options, context));
    return std::shared_ptr<const StructureField>(
        std::make_shared<SweptField>(std::move(sweep), std::move(in_chart), set, charted));
}

}  // namespace anatomesh
