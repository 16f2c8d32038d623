// CountedField: a StructureField that counts how often it is asked.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

// Answers as `field` does, and counts the places at which it is asked for a value, a region or a distance: a number
// that is the same on every machine, and tells what a stage costs better than its seconds there. Volumes are passed
// on uncounted. Unlike other fields it is not thread-safe. Complexity: one call more per query.
class CountedField final : public StructureField {
  public:
    explicit CountedField(std::shared_ptr<const StructureField> field) : field_(std::move(field)) {}

    std::uint64_t values() const { return values_; }

    double value(std::uint32_t structure, Vec3 p) const override {
        ++values_;
        return field_->value(structure, p);
    }
    double value_within(std::uint32_t structure, Vec3 p, double reach) const override {
        ++values_;
        return field_->value_within(structure, p, reach);
    }
    void values_near(Vec3 p, std::vector<Near>& near) const override {
        ++values_;
        field_->values_near(p, near);
    }
    void members(Vec3 p, std::vector<std::uint32_t>& out) const override {
        ++values_;
        field_->members(p, out);
    }
    double interface_distance(Vec3 p) const override {
        ++values_;
        return field_->interface_distance(p);
    }
    double union_value(Vec3 p) const override {
        ++values_;
        return field_->union_value(p);
    }
    double members_and_distance(Vec3 p, std::vector<std::uint32_t>& out) const override {
        ++values_;
        return field_->members_and_distance(p, out);
    }

    bool exclusive() const override { return field_->exclusive(); }
    std::vector<Plane> flat_ends() const override { return field_->flat_ends(); }
    double slice_spacing() const override { return field_->slice_spacing(); }
    double clamp() const override { return field_->clamp(); }
    std::vector<const StructureField*> parts() const override { return {field_.get()}; }
    Box3 box() const override { return field_->box(); }
    Box3 box_of(std::uint32_t structure) const override { return field_->box_of(structure); }
    bool slices_may_differ(Vec3 p, double radius) const override {
        return field_->slices_may_differ(p, radius);
    }
    Result<std::vector<StructureVolume>> volumes(std::uint32_t count, const VolumeOptions& options,
                                                 RunContext& context) const override {
        return field_->volumes(count, options, context);
    }

  private:
    std::shared_ptr<const StructureField> field_;
    mutable std::uint64_t values_ = 0;
};

}  // namespace anatomesh
