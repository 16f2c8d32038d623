#include "anatomesh/field/planes/general_field.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/planes/patch_field.h"
#include "anatomesh/field/warnings/sparse_planes.h"
#include "anatomesh/field/warnings/thin_structures.h"

namespace anatomesh {

namespace {

// Which slices say something of which structures: groups of structures with the same slices. The first group
// has all slices, whether or not a structure is in it.
struct CoverageGroups {
    std::vector<std::vector<std::uint32_t>> slices;  // by group, rising
    std::vector<std::uint32_t> group_of;             // by structure
};

CoverageGroups coverage_groups(const ContourSet& set, const SliceCoverage& coverage) {
    CoverageGroups groups{{std::vector<std::uint32_t>(set.slices.size())}, {}};
    std::iota(groups.slices[0].begin(), groups.slices[0].end(), 0u);
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        std::vector<std::uint32_t> known;
        for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
            if (!coverage.is_unknown(k, s)) known.push_back(k);
        }
        const auto at = std::find(groups.slices.begin(), groups.slices.end(), known);
        groups.group_of.push_back(static_cast<std::uint32_t>(at - groups.slices.begin()));
        if (at == groups.slices.end()) groups.slices.push_back(std::move(known));
    }
    return groups;
}

// The spacings of some slices, which are further apart than all.
PlaneSpacings spacings_of(const ContourSet& set, const std::vector<std::uint32_t>& slices) {
    const ContourSet some = chosen_slices(set, slices);
    return plane_spacings(some, plane_patches(some));
}

// Where slices say nothing of a structure it has a field without them.
class FieldsByCoverage final : public FieldQueries<FieldsByCoverage> {
  public:
    // fields[of[s]] is that of structure s, fields[0] that of all slices.
    FieldsByCoverage(std::vector<std::shared_ptr<const PatchField>> fields, std::vector<std::uint32_t> of)
        : fields_(std::move(fields)), of_(std::move(of)) {
        clamp_ = all().clamp();
        partition_ = all().exclusive();
    }

    double slice_spacing() const override { return all().slice_spacing(); }
    Box3 box() const override {
        Box3 whole;
        for (const auto& field : fields_) {
            whole.extend(field->box().low);
            whole.extend(field->box().high);
        }
        return whole;
    }
    Box3 box_of(std::uint32_t structure) const override { return fields_[of_[structure]]->box_of(structure); }
    bool slices_may_differ(Vec3 p, double radius) const override {
        return all().slices_may_differ(p, radius);
    }

    static constexpr bool sides_cost_less = false;
    RawValue raw(std::uint32_t structure, Vec3 p, double reach) const {
        return fields_[of_[structure]]->raw(structure, p, reach);
    }
    // With what the slices that draw it say of a structure beside what is drawn on the others.
    double raw_union(Vec3 p, double /*reach*/) const {
        double least = all().raw_union(p, everywhere);
        for (std::uint32_t s = 0; s < of_.size(); ++s) {
            if (of_[s] > 0) least = std::min(least, fields_[of_[s]]->raw(s, p, everywhere).value);
        }
        return least;
    }

    template <class Body>
    void each_raw(Vec3 p, double /*reach*/, Body body) const {
        std::uint32_t next = 0;
        const auto up_to = [&](std::uint32_t end) {
            for (; next < end; ++next) {
                if (of_[next] == 0) continue;
                const RawValue value = raw(next, p, everywhere);
                if (value.value < clamp_) body(next, value);
            }
        };
        all().each_raw(p, everywhere, [&](std::uint32_t s, RawValue value) {
            up_to(s);
            if (of_[s] == 0) body(s, value);
        });
        up_to(static_cast<std::uint32_t>(of_.size()));
    }

  private:
    const PatchField& all() const { return *fields_.front(); }

    std::vector<std::shared_ptr<const PatchField>> fields_;
    std::vector<std::uint32_t> of_;
};

}  // namespace

Result<std::shared_ptr<const StructureField>> make_general_field(const ContourSet& set,
                                                                 const SliceCoverage& coverage,
                                                                 const FieldOptions& options,
                                                                 RunContext& context) {
    const std::vector<PlanePatch> patches = plane_patches(set);
    const PlaneSpacings spacings = plane_spacings(set, patches);
    const std::vector<Box2> frames = frames_of_slices(set, patches, spacings.median);
    // Where planes lie close, distances still reach as far as the vertices are apart: cells are no smaller.
    const double reach = std::max(1.5 * spacings.median, mean_vertex_spacing(set));
    std::vector<bool> used(set.structures.size(), false);
    for (const Contour& contour : set.contours) used[contour.structure] = true;
    const bool several = std::count(used.begin(), used.end(), true) > 1;
    CoverageGroups groups = coverage_groups(set, coverage);
    std::vector<std::shared_ptr<const PatchField>> fields;
    for (const std::vector<std::uint32_t>& slices : groups.slices) {
        PatchFieldOptions own;
        own.spacings = slices.size() == set.slices.size() ? spacings : spacings_of(set, slices);
        own.least_reach = options.least_reach_mm;
        own.margin = options.plane_margin_mm > 0 ? options.plane_margin_mm : own.spacings.median;
        own.clamp = options.clamp_mm > 0 ? options.clamp_mm : reach;
        own.partition = set.exclusive && several;
        own.caps = options.caps;
        auto field = std::make_shared<PatchField>(own);
        ANATOMESH_CHECK_STATUS(field->build(set, patches, frames, slices, context));
        fields.push_back(std::move(field));
    }
    warn_about_thin_structures(set, spacings.median, context);
    std::shared_ptr<const StructureField> field;
    if (fields.size() == 1)
        field = std::move(fields.front());
    else
        field = std::make_shared<FieldsByCoverage>(std::move(fields), std::move(groups.group_of));
    warn_about_sparse_planes(set, *field, std::vector<double>(set.structures.size(), 0), context);
    return field;
}

}  // namespace anatomesh
