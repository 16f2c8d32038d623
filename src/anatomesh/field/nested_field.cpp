#include "anatomesh/field/nested_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/field/parallel_field.h"
#include "anatomesh/field/volume.h"

namespace anatomesh {

namespace {

constexpr double lattice_share = 5;  // of the points that a volume by itself takes
constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

class NestedField final : public StructureField {
  public:
    NestedField(std::shared_ptr<const StructureField> drawn, std::shared_ptr<const StructureField> of_slices,
                const ContourSet& set)
        : drawn_(std::move(drawn)), of_slices_(std::move(of_slices)) {
        const OverlappingContours& all = *set.overlapping;
        order_ = all.order;
        rank_.resize(order_.size());
        for (std::uint32_t r = 0; r < all.order.size(); ++r) rank_[all.order[r]] = r;
        own_.assign(all.drawn.structures.size(), none);
        for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
            const auto same = std::find_if(
                all.drawn.structures.begin(), all.drawn.structures.end(),
                [&](const Structure& structure) { return structure.number == set.structures[s].number; });
            assert(same != all.drawn.structures.end());
            drawn_structure_.push_back(static_cast<std::uint32_t>(same - all.drawn.structures.begin()));
            own_[drawn_structure_.back()] = s;
        }
    }

    double value(std::uint32_t structure, Vec3 p) const override {
        return value_within(structure, p, std::numeric_limits<double>::infinity());
    }

    double value_within(std::uint32_t structure, Vec3 p, double reach) const override {
        const std::uint32_t drawn = drawn_structure_[structure];
        double value = drawn_->value_within(drawn, p, reach);
        for (std::uint32_t other = 0; other < rank_.size(); ++other) {
            if (rank_[other] < rank_[drawn]) value = std::max(value, -drawn_->value_within(other, p, reach));
        }
        return value;
    }

    void values_near(Vec3 p, std::vector<Near>& near) const override {
        std::vector<Near> all;
        drawn_->values_near(p, all);
        const auto first = static_cast<std::ptrdiff_t>(near.size());
        for (const Near& one : all) {
            if (own_[one.structure] != none) near.push_back({own_[one.structure], left_of(one, all)});
        }
        std::sort(near.begin() + first, near.end(),
                  [](const Near& a, const Near& b) { return a.structure < b.structure; });
    }

    void members(Vec3 p, std::vector<std::uint32_t>& out) const override {
        drawn_->members(p, out);
        keep_first(out);
    }

    double interface_distance(Vec3 p) const override {
        std::vector<std::uint32_t> members;
        return members_and_distance(p, members);
    }

    double members_and_distance(Vec3 p, std::vector<std::uint32_t>& out) const override {
        std::vector<Near> near;
        drawn_->values_near(p, near);
        out.clear();
        double distance = clamp();
        for (const Near& one : near) {
            distance = std::min(distance, std::abs(left_of(one, near)));
            if (one.value < 0) out.push_back(one.structure);
        }
        keep_first(out);
        return distance;
    }

    bool exclusive() const override { return true; }
    double union_value(Vec3 p) const override { return drawn_->union_value(p); }
    ParallelPlanes flat_ends() const override { return drawn_->flat_ends(); }
    double slice_spacing() const override { return drawn_->slice_spacing(); }
    double clamp() const override { return drawn_->clamp(); }
    Box3 box() const override { return drawn_->box(); }
    Box3 box_of(std::uint32_t structure) const override {
        return drawn_->box_of(drawn_structure_[structure]);
    }
    bool slices_may_differ(Vec3 p, double radius) const override {
        return drawn_->slices_may_differ(p, radius);
    }

    // Of each as drawn, less what those before it keep of it: shares of theirs, counted on a lattice. Plain
    // slice integration is of the areas that are left.
    Result<std::vector<StructureVolume>> volumes(std::uint32_t count, const VolumeOptions& options,
                                                 RunContext& context) const override {
        const auto all = static_cast<std::uint32_t>(rank_.size());
        ANATOMESH_TRY(const std::vector<StructureVolume> whole, drawn_->volumes(all, options, context));
        std::vector<double> left(all);
        for (std::uint32_t s = 0; s < all; ++s) left[s] = whole[s].by_field;
        for (const std::uint32_t owner : order_) {
            const std::vector<double> shares = shares_of(owner, options, context);
            if (context.cancelled()) return cancelled_error();
            for (std::uint32_t s = 0; s < all; ++s) {
                if (rank_[s] > rank_[owner]) left[s] -= shares[s] * left[owner];
            }
        }
        std::vector<StructureVolume> volumes(count, {0, std::numeric_limits<double>::quiet_NaN()});
        for (std::uint32_t s = 0; s < count; ++s) volumes[s].by_field = left[drawn_structure_[s]];
        if (!of_slices_) return volumes;
        ANATOMESH_TRY(const std::vector<StructureVolume> plain, of_slices_->volumes(count, options, context));
        for (std::uint32_t s = 0; s < count; ++s) volumes[s].by_slices = plain[s].by_slices;
        return volumes;
    }

  private:
    // What of it those before it leave.
    double left_of(const Near& one, const std::vector<Near>& all) const {
        double value = one.value;
        for (const Near& other : all) {
            if (rank_[other.structure] < rank_[one.structure]) value = std::max(value, -other.value);
        }
        return value;
    }

    // By structure as drawn: how much of what the owner keeps lies in it.
    std::vector<double> shares_of(std::uint32_t owner, const VolumeOptions& options,
                                  const RunContext& context) const {
        const Box3 box = drawn_->box_of(owner);
        std::vector<double> shares(rank_.size(), 0);
        const bool is_last = rank_[owner] + 1 == rank_.size();
        if (box.empty() || is_last) return shares;
        const Vec3 size = box.high - box.low;
        const double points = options.points_in_all / lattice_share;
        const auto layers =
            static_cast<std::size_t>(std::ceil(size.z / std::cbrt(size.x * size.y * size.z / points)));
        std::vector<std::vector<std::uint64_t>> counts(layers, std::vector<std::uint64_t>(rank_.size(), 0));
        parallel_for(layers, 1, context.threads, [&](std::size_t begin, std::size_t end) {
            std::vector<std::uint32_t> members;
            for (std::size_t k = begin; k < end && !context.cancelled(); ++k) {
                const double z =
                    box.low.z + (static_cast<double>(k) + 0.5) * size.z / static_cast<double>(layers);
                const Box2 layer{{box.low.x, box.low.y}, {box.high.x, box.high.y}};
                lattice_integral(layer, points / static_cast<double>(layers), k, [&](Vec2 q, double) {
                    drawn_->members({q.x, q.y, z}, members);
                    if (!members.empty() && first_of(members) == owner) {
                        for (const std::uint32_t s : members) ++counts[k][s];
                    }
                    return 0.0;
                });
            }
        });
        std::vector<std::uint64_t> sum(rank_.size(), 0);
        for (const auto& layer : counts) {
            for (std::size_t s = 0; s < sum.size(); ++s) sum[s] += layer[s];
        }
        for (std::size_t s = 0; s < sum.size(); ++s) {
            if (sum[owner] > 0) shares[s] = static_cast<double>(sum[s]) / static_cast<double>(sum[owner]);
        }
        return shares;
    }

    std::uint32_t first_of(const std::vector<std::uint32_t>& members) const {
        return *std::min_element(members.begin(), members.end(),
                                 [&](std::uint32_t a, std::uint32_t b) { return rank_[a] < rank_[b]; });
    }

    // Of structures as drawn the first, as one of the set.
    void keep_first(std::vector<std::uint32_t>& members) const {
        if (members.empty()) return;
        const std::uint32_t first = first_of(members);
        members.clear();
        if (own_[first] != none) members.push_back(own_[first]);
    }

    std::shared_ptr<const StructureField> drawn_;
    std::shared_ptr<const StructureField> of_slices_;  // of what is left; null where planes are not parallel
    std::vector<std::uint32_t> order_;                 // of structures as drawn
    std::vector<std::uint32_t> rank_, own_;            // by structure as drawn; own_: of the set, or none
    std::vector<std::uint32_t> drawn_structure_;       // by structure of the set
};

}  // namespace

Result<std::shared_ptr<const StructureField>> make_nested_field(const ContourSet& set,
                                                                const FieldOptions& options,
                                                                RunContext& context) {
    ANATOMESH_TRY(std::shared_ptr<const StructureField> drawn,
                  make_structure_field(set.overlapping->drawn, options, context));
    std::shared_ptr<const StructureField> of_slices;
    if (is_parallel(set)) {
        RunContext apart;  // what it would warn of is no part of the field
        apart.threads = context.threads;
        apart.cancel = context.cancel;
        ANATOMESH_TRY(of_slices, make_parallel_field(set, options, apart));
    }
    return std::shared_ptr<const StructureField>(
        std::make_shared<NestedField>(std::move(drawn), std::move(of_slices), set));
}

}  // namespace anatomesh
