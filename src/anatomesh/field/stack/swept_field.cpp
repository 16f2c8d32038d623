#include "anatomesh/field/stack/swept_field.h"

#include <algorithm>
#include <utility>

#include "anatomesh/field/stack/parallel_field.h"

namespace anatomesh {

namespace {

class SweptField final : public StructureField {
  public:
    SweptField(Sweep sweep, std::shared_ptr<const StructureField> straight, const ContourSet& set,
               const ContourSet& straightened)
        : sweep_(std::move(sweep)), straight_(std::move(straight)) {
        // How far beyond the contours' box the field reaches.
        const Box3 inner = straightened.box(), outer = straight_->box();
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
        return straight_->value(structure, sweep_.straight(p));
    }
    double value_within(std::uint32_t structure, Vec3 p, double reach) const override {
        return straight_->value_within(structure, sweep_.straight(p), reach);
    }
    void values_near(Vec3 p, std::vector<Near>& near) const override {
        straight_->values_near(sweep_.straight(p), near);
    }
    void members(Vec3 p, std::vector<std::uint32_t>& out) const override {
        straight_->members(sweep_.straight(p), out);
    }
    double interface_distance(Vec3 p) const override {
        return straight_->interface_distance(sweep_.straight(p));
    }
    bool exclusive() const override { return straight_->exclusive(); }
    double union_value(Vec3 p) const override { return straight_->union_value(sweep_.straight(p)); }
    double members_and_distance(Vec3 p, std::vector<std::uint32_t>& out) const override {
        return straight_->members_and_distance(sweep_.straight(p), out);
    }
    std::vector<Plane> flat_ends() const override {
        std::vector<Plane> ends;
        for (const Plane& end : straight_->flat_ends()) ends.push_back(sweep_.slice_at(end.origin.z));
        return ends;
    }
    double slice_spacing() const override { return straight_->slice_spacing(); }
    double clamp() const override { return straight_->clamp(); }
    Box3 box() const override { return box_; }
    Box3 box_of(std::uint32_t structure) const override { return boxes_[structure]; }

  private:
    Sweep sweep_;
    std::shared_ptr<const StructureField> straight_;
    Box3 box_;
    std::vector<Box3> boxes_;  // by structure; empty of one that is not drawn
};

}  // namespace

Result<std::shared_ptr<const StructureField>> make_swept_field(Sweep sweep, const ContourSet& set,
                                                               const FieldOptions& options,
                                                               RunContext& context) {
    const ContourSet straightened = sweep.straight(set);
    ANATOMESH_TRY(std::shared_ptr<const StructureField> straight,
                  make_parallel_field(straightened, options, context));
    return std::shared_ptr<const StructureField>(
        std::make_shared<SweptField>(std::move(sweep), std::move(straight), set, straightened));
}

}  // namespace anatomesh
