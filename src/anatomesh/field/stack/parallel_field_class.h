// ParallelField: the class behind make_parallel_field(). parallel_field.cpp makes it, parallel_volume.cpp measures it.
#pragma once

#include <cassert>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "anatomesh/field/model/field_queries.h"
#include "anatomesh/field/slice/slice_regions.h"
#include "anatomesh/field/stack/earlier_maps.h"
#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/field/stack/slice_knots.h"
#include "anatomesh/field/stack/structure_stack.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/coverage/few_slices.h"

namespace anatomesh {

class ParallelField final : public FieldQueries<ParallelField> {
  public:
    ParallelField(const Plane& frame, double spacing, double clamp, bool partition)
        : frame_(frame), spacing_(spacing) {
        clamp_ = clamp;
        partition_ = partition;
    }

    double slice_spacing() const override { return spacing_; }
    std::vector<Plane> flat_ends() const override {
        std::vector<double> heights;
        for (const StructureStack& structure_stack : structure_stacks_)
            structure_stack.add_flat_ends(heights);
        std::sort(heights.begin(), heights.end());
        std::vector<Plane> ends(heights.size(), frame_);
        for (std::size_t n = 0; n < ends.size(); ++n)
            ends[n].origin = frame_.origin + heights[n] * frame_.normal;
        return ends;
    }
    Box3 box() const override { return box_; }
    const TakenFromEarlier& taken_from_earlier() const { return taken_from_earlier_; }
    std::optional<std::vector<FieldStretch>> stretches_unlike(const ParallelField& other) const;

    static constexpr bool sides_cost_less = true;
    RawValue raw(std::uint32_t structure, Vec3 p, double reach) const {
        assert(structure < structure_stacks_.size());
        return raw_at(structure, frame_.to_plane(p), frame_.signed_distance(p), reach);
    }

    double raw_union(Vec3 p, double reach) const {
        return union_.blend(maps_, clamp_, frame_.to_plane(p), frame_.signed_distance(p), reach);
    }

    template <class Body>
    void each_raw(Vec3 p, double reach, Body body) const {
        const double z = frame_.signed_distance(p);
        const double b = (z - low_) * inverse_bucket_;
        if (!(b >= 0) || b >= static_cast<double>(bucket_begin_.size() - 1)) return;
        const Vec2 q = frame_.to_plane(p);
        const auto bucket = static_cast<std::size_t>(b);
        for (std::uint32_t i = bucket_begin_[bucket]; i < bucket_begin_[bucket + 1]; ++i) {
            if (!near_[i].box.contains(q)) continue;
            const RawValue raw = raw_at(near_[i].structure, q, z, reach);
            if (raw.value < clamp_) body(near_[i].structure, raw);
        }
    }

    Result<std::vector<StructureVolume>> volumes(std::uint32_t count, const VolumeOptions& options,
                                                 RunContext& context) const override;

    // `few`: of the structures that are drawn on few slices.
    Status build(const ContourSet& set, const std::vector<SliceInterval>& intervals,
                 const std::vector<FewSlices>& few, const FieldOptions& options, RunContext& context);

  private:
    struct NearEntry {
        std::uint32_t structure;
        Box2 box;
    };

    RawValue raw_at(std::uint32_t structure, Vec2 q, double z, double reach) const {
        const StructureStack& structure_stack = structure_stacks_[structure];
        RawValue raw{clamp_, structure_stack.beyond_flat_cap(z)};
        raw.value =
            structure_stack.blend(maps_, clamp_, q, z, reach, partition_ ? &raw.to_own_half_gap : nullptr);
        return raw;
    }
    StructureVolume pair_volume(std::uint32_t structure, const StructureStack::Pair& pair, double points,
                                std::size_t layer) const;
    double inside_share(std::uint32_t structure, const StructureStack::Pair& pair, Vec2 q, double step) const;
    bool is_alone(std::uint32_t structure, const StructureStack::Pair& pair, Vec2 q) const;
    // A gap of an earlier field between two maps.
    struct GapEntry {
        const DistanceMap *below, *above;
        StructureStack::EarlierGap gap;
    };
    static bool before(const GapEntry& a, const GapEntry& b) {
        const std::less<const DistanceMap*> less;
        return a.below != b.below ? less(a.below, b.below) : less(a.above, b.above);
    }
    void look_at_earlier(const StructureField* earlier);
    std::shared_ptr<const DistanceMap> earlier_union(
        const std::vector<SliceRegion>& regions, const std::vector<const EarlierMaps::Entry*>& entries) const;
    std::vector<GapEntry> earlier_gaps() const;
    Status build_maps(const ContourSet& set, RunContext& context);
    Status find_motions(const ContourSet& set, RunContext& context);
    void add_terminations_to_union(std::size_t pair);
    void build_structure_stacks(const ContourSet& set, const std::vector<SliceInterval>& intervals,
                                const std::vector<FewSlices>& few, const FieldOptions& options,
                                RunContext& context);
    void build_near_table();
    void build_box();

    Plane frame_;
    double spacing_ = 0;
    Box3 box_;
    StructureStack::Maps maps_;
    std::vector<std::uint64_t> fingerprints_;  // of their edges
    std::vector<std::uint32_t> slice_of_map_;
    std::vector<std::vector<std::int32_t>> map_of_;  // [structure][slice]; the union comes last
    std::vector<StructureStack> structure_stacks_;
    StructureStack union_;
    // Along the normal in buckets: the structures whose neighbourhood reaches into the bucket, rising.
    double low_ = 0, inverse_bucket_ = 0;
    std::vector<std::uint32_t> bucket_begin_;
    std::vector<NearEntry> near_;
    TakenFromEarlier taken_from_earlier_;
    // While the field is made: earlier ones, whose parts are taken over.
    std::vector<const ParallelField*> earlier_;
    EarlierMaps earlier_maps_;
};

}  // namespace anatomesh
