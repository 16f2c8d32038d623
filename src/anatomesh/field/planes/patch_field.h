// PatchField: the field of planes in any position, of which every slice says something of every structure.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/field/model/field_queries.h"
#include "anatomesh/field/planes/obliquity.h"
#include "anatomesh/field/planes/patch_grid.h"
#include "anatomesh/field/slice/distance_map.h"

namespace anatomesh {

// What a patch says of a structure at a point.
struct PatchValue {
    double distance;   // signed, in the plane, less where the plane runs along the boundary
    double obliquity;  // of the boundary against the plane (obliquity.h)
};

// A patch as a point sees it.
struct SeenPatch {
    std::uint32_t patch;
    double distance;  // from the point
    double height;    // of the point above the plane
    double lateral;   // how far the point's projection lies beside the grown patch
    double share;     // of it that nearer patches leave
    double weight;    // infinite on the patch itself
    Vec3 offset;      // to the nearest point of the grown patch
    Vec2 at;          // the point's projection
};

// The patches that count at a point, nearest first.
struct PatchView {
    std::array<SeenPatch, PatchGrid::most_near> near;  // the first `count`
    std::uint32_t count = 0;
    double outside = 0;  // weight of "outside"
    double beyond_flat_cap = -std::numeric_limits<double>::infinity();
    double rounded_at = 0, rounded_radius = 0;  // height in a rounded end, and the radius; 0 elsewhere

    std::span<const SeenPatch> patches() const { return {near.data(), count}; }
};

// What decides how a patch field blends; lengths in mm.
struct PatchFieldOptions {
    PlaneSpacings spacings;  // of the planes. > 0
    double least_reach = 0;  // how far off a plane says something at least. >= 0
    double margin = 0;       // how far beyond its contours a plane says "outside". > 0
    double clamp = 0;        // distances in a plane end there. > 0
    bool partition = false;  // structures exclude each other
    EndCaps caps = EndCaps::half;
};

// The field of general_field.h from some slices of a set. Immutable after build().
class PatchField final : public FieldQueries<PatchField> {
  public:
    explicit PatchField(const PatchFieldOptions& options);

    double slice_spacing() const override { return spacing_; }
    Box3 box() const override { return grid_.box(); }
    Box3 box_of(std::uint32_t structure) const override { return boxes_[structure]; }
    bool slices_may_differ(Vec3 p, double radius) const override;

    static constexpr bool sides_cost_less = false;
    RawValue raw(std::uint32_t structure, Vec3 p, double /*reach*/) const {
        const PatchView view = look(p);
        return {blend(structure, view), view.beyond_flat_cap};
    }
    double raw_union(Vec3 p, double /*reach*/) const { return blend(union_, look(p)); }

    template <class Body>
    void each_raw(Vec3 p, double /*reach*/, Body body) const {
        const PatchView view = look(p);
        for (std::uint32_t s = next_structure(view, 0); s != no_structure; s = next_structure(view, s + 1)) {
            const double value = blend(s, view);
            if (value < clamp_) body(s, RawValue{value, view.beyond_flat_cap});
        }
    }

    // `patches`: by slice, as far as it draws; `frames`: as far as it says something; `slices`: those that
    // count, rising. Errors: E-FLD-002 where none of these encloses an area.
    Status build(const ContourSet& set, std::vector<PlanePatch> patches, const std::vector<Box2>& frames,
                 const std::vector<std::uint32_t>& slices, RunContext& context);

  private:
    // It stands for no structure. [index; 2^32 - 1; D]
    static constexpr std::uint32_t no_structure = 0xffffffffu;

    // The distance maps of a patch, and its place at the ends of a sweep.
    struct PatchMaps {
        std::uint32_t first = 0, count = 0;
        // Whether no other patch within the radius lies beyond it on that side.
        bool open_below = false, open_above = false;
    };

    PatchView look(Vec3 p) const;
    SeenPatch see(Vec3 p, const PatchGrid::Key& key) const;
    double share_of(const SeenPatch& near, const PatchView& view) const;
    void end(PatchView& view) const;
    PatchValue said(std::uint32_t structure, const SeenPatch& near) const;
    double blend(std::uint32_t structure, const PatchView& view) const;
    std::uint32_t next_structure(const PatchView& view, std::uint32_t from) const;
    Status build_maps(const ContourSet& set, const std::vector<std::uint32_t>& slices, RunContext& context);
    void find_open_sides(const std::vector<PlanePatch>& patches, const Box3& box);
    void find_obliquity(RunContext& context);

    PatchGrid grid_;
    std::vector<PatchMaps> patches_;
    std::vector<std::optional<DistanceMap>> maps_;  // per patch in order of structure, the union last
    std::vector<std::uint32_t> structure_of_;
    std::uint32_t union_ = 0;
    ObliquityFactors obliquity_;
    double spacing_ = 0, margin_ = 0, radius_ = 0, reach_ = 0,
           end_spacing_ = 0;  // outside joins in half of it beyond the end
    EndCaps caps_;
    std::vector<Box3> boxes_;  // by structure; empty of one that is not drawn
};

}  // namespace anatomesh
