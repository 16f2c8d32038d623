#include "anatomesh/field/overlaps/nested_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/field/planes/field_of_slices.h"
#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"

namespace anatomesh {

namespace {

// Whether a structure is parted at all is asked with so many times fewer points than its volume takes.
// [1; > 1; B]
constexpr double lattice_share = 5;
// If less than this share of a structure lies outside another one, or in it, its volume is not parted: it
// would be a small difference of large numbers. [1, of the volume; 0 to 0.1; M 2026-11, set not recorded]
constexpr double hardly_any = 0.002;
constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

using Fields = std::vector<std::shared_ptr<const StructureField>>;

// A structure as it was drawn.
struct Drawn {
    std::uint32_t level = 0, index = 0;  // in the level's contours
    std::uint32_t own = none;            // in the set; none where nothing of it is left
};

class NestedField final : public StructureField {
  public:
    // `of_levels`: by level, null where it has no contour; `of_slices`: of what is left, null where planes
    // are not parallel.
    NestedField(const Fields& of_levels, std::shared_ptr<const StructureField> of_slices,
                const ContourSet& set)
        : of_slices_(std::move(of_slices)) {
        const OverlappingContours& all = *set.overlapping;
        const auto place_of = [](const std::vector<Structure>& structures, std::int32_t number) {
            const auto same = std::find_if(structures.begin(), structures.end(),
                                           [&](const Structure& each) { return each.number == number; });
            return same == structures.end() ? none : static_cast<std::uint32_t>(same - structures.begin());
        };
        drawn_.resize(all.order.size());
        rank_.assign(set.structures.size(), none);
        for (std::uint32_t rank = 0; rank < drawn_.size(); ++rank) {
            drawn_[rank].own = place_of(set.structures, all.order[rank]);
            if (drawn_[rank].own != none) rank_[drawn_[rank].own] = rank;
        }
        for (std::size_t n = 0; n < of_levels.size(); ++n) {
            if (!of_levels[n]) continue;
            const auto level = static_cast<std::uint32_t>(levels_.size());
            levels_.push_back(of_levels[n]);
            clamp_ = std::max(clamp_, of_levels[n]->clamp());
            rank_of_.emplace_back(all.levels[n].structures.size(), none);
            for (std::uint32_t rank = 0; rank < drawn_.size(); ++rank) {
                const std::uint32_t index = place_of(all.levels[n].structures, all.order[rank]);
                if (index == none) continue;
                drawn_[rank].level = level;
                drawn_[rank].index = index;
                rank_of_[level][index] = rank;
            }
        }
    }

    double value(std::uint32_t structure, Vec3 p) const override {
        return value_within(structure, p, std::numeric_limits<double>::infinity());
    }

    double value_within(std::uint32_t structure, Vec3 p, double reach) const override {
        const Drawn& drawn = drawn_[rank_[structure]];
        if (drawn.level == none) return clamp_;
        double value = levels_[drawn.level]->value_within(drawn.index, p, reach);
        for (std::uint32_t rank = 0; rank < rank_[structure]; ++rank) {
            const Drawn& other = drawn_[rank];
            if (other.level != none && !excludes(other.level, drawn.level))
                value = std::max(value, -levels_[other.level]->value_within(other.index, p, reach));
        }
        return value;
    }

    void values_near(Vec3 p, std::vector<Near>& near) const override {
        const auto first = static_cast<std::ptrdiff_t>(near.size());
        const std::vector<Near> all = near_by_rank(p);
        for (const Near& one : all) {
            const std::uint32_t own = drawn_[one.structure].own;
            if (own != none) near.push_back({own, left_of(one, all)});
        }
        std::sort(near.begin() + first, near.end(),
                  [](const Near& a, const Near& b) { return a.structure < b.structure; });
    }

    void members(Vec3 p, std::vector<std::uint32_t>& out) const override {
        std::uint32_t least = none;
        for (std::uint32_t level = 0; level < levels_.size(); ++level) {
            levels_[level]->members(p, out);
            for (const std::uint32_t index : out) least = std::min(least, rank_of_[level][index]);
        }
        out.clear();
        if (least != none && drawn_[least].own != none) out.push_back(drawn_[least].own);
    }

    double interface_distance(Vec3 p) const override {
        const std::vector<Near> all = near_by_rank(p);
        double distance = clamp_;
        for (const Near& one : all) distance = std::min(distance, std::abs(left_of(one, all)));
        return distance;
    }

    double members_and_distance(Vec3 p, std::vector<std::uint32_t>& out) const override {
        members(p, out);
        return interface_distance(p);
    }

    bool exclusive() const override { return true; }
    double union_value(Vec3 p) const override {
        double least = clamp_;
        for (const auto& level : levels_) least = std::min(least, level->union_value(p));
        return least;
    }
    std::vector<Plane> flat_ends() const override {
        std::vector<Plane> ends;
        for (const auto& level : levels_) {
            const std::vector<Plane> more = level->flat_ends();
            ends.insert(ends.end(), more.begin(), more.end());
        }
        return ends;
    }
    double slice_spacing() const override { return levels_.front()->slice_spacing(); }
    double clamp() const override { return clamp_; }
    std::vector<const StructureField*> parts() const override {
        std::vector<const StructureField*> parts;
        for (const auto& level : levels_) parts.push_back(level.get());
        if (of_slices_) parts.push_back(of_slices_.get());
        return parts;
    }
    Box3 box() const override {
        Box3 box;
        for (const auto& level : levels_) {
            if (level->box().empty()) continue;
            box.extend(level->box().low);
            box.extend(level->box().high);
        }
        return box;
    }
    Box3 box_of(std::uint32_t structure) const override { return box_as_drawn(rank_[structure]); }
    bool slices_may_differ(Vec3 p, double radius) const override {
        return std::any_of(levels_.begin(), levels_.end(),
                           [&](const auto& level) { return level->slices_may_differ(p, radius); });
    }

    // Of each as drawn, less what those before it keep of it: shares of theirs, counted on a lattice. Plain
    // slice integration is of the areas that are left.
    Result<std::vector<StructureVolume>> volumes(std::uint32_t count, const VolumeOptions& options,
                                                 RunContext& context) const override {
        std::vector<double> left(drawn_.size(), 0);
        for (std::uint32_t level = 0; level < levels_.size(); ++level) {
            const auto structures = static_cast<std::uint32_t>(rank_of_[level].size());
            ANATOMESH_TRY(const std::vector<StructureVolume> whole,
                          levels_[level]->volumes(structures, options, context));
            for (std::uint32_t s = 0; s < structures; ++s) left[rank_of_[level][s]] = whole[s].by_field;
        }
        for (std::uint32_t owner = 0; owner < drawn_.size(); ++owner) {
            const std::vector<double> shares = shares_of(owner, options, context);
            if (context.cancelled()) return cancelled_error();
            for (std::uint32_t rank = owner + 1; rank < drawn_.size(); ++rank)
                left[rank] -= shares[rank] * left[owner];
        }
        std::vector<StructureVolume> volumes(count, {0, std::numeric_limits<double>::quiet_NaN()});
        for (std::uint32_t s = 0; s < count; ++s) volumes[s].by_field = left[rank_[s]];
        if (!of_slices_) return volumes;
        ANATOMESH_TRY(const std::vector<StructureVolume> plain, of_slices_->volumes(count, options, context));
        for (std::uint32_t s = 0; s < count; ++s) volumes[s].by_slices = plain[s].by_slices;
        return volumes;
    }

  private:
    Box3 box_as_drawn(std::uint32_t rank) const {
        const Drawn& drawn = drawn_[rank];
        return drawn.level == none ? Box3{} : levels_[drawn.level]->box_of(drawn.index);
    }

    // What was drawn, by rank.
    std::vector<Near> near_by_rank(Vec3 p) const {
        std::vector<Near> all;
        for (std::uint32_t level = 0; level < levels_.size(); ++level) {
            const std::size_t first = all.size();
            levels_[level]->values_near(p, all);
            for (std::size_t n = first; n < all.size(); ++n)
                all[n].structure = rank_of_[level][all[n].structure];
        }
        return all;
    }

    // Whether structures of the two exclude each other by themselves: of one with walls between them.
    bool excludes(std::uint32_t level, std::uint32_t other) const {
        return level == other && levels_[level]->exclusive();
    }

    // What of it those before it leave; those of its level may exclude it already.
    double left_of(const Near& one, const std::vector<Near>& all) const {
        double value = one.value;
        for (const Near& other : all) {
            if (other.structure < one.structure &&
                !excludes(drawn_[other.structure].level, drawn_[one.structure].level))
                value = std::max(value, -other.value);
        }
        return value;
    }

    // By rank: how much of what the owner keeps lies in structures of other levels.
    std::vector<double> shares_of(std::uint32_t owner, const VolumeOptions& options,
                                  const RunContext& context) const {
        const std::vector<double> shares = shares_by(owner, options.points_in_all / lattice_share, context);
        const bool is_parted = std::any_of(shares.begin() + owner + 1, shares.end(), [](double share) {
            return share > hardly_any && share < 1 - hardly_any;
        });
        return is_parted ? shares_by(owner, options.points_in_all, context) : shares;
    }

    // By so many points over the owner's box.
    std::vector<double> shares_by(std::uint32_t owner, double points, const RunContext& context) const {
        std::vector<double> shares(drawn_.size(), 0);
        const Box3 box = box_as_drawn(owner);
        if (box.empty() || owner + 1 == drawn_.size()) return shares;
        const Vec3 size = box.high - box.low;
        const auto layers =
            static_cast<std::size_t>(std::ceil(size.z / std::cbrt(size.x * size.y * size.z / points)));
        std::vector<std::vector<std::uint64_t>> counts(layers, std::vector<std::uint64_t>(drawn_.size(), 0));
        parallel_for(layers, 1, context.threads, [&](std::size_t begin, std::size_t end) {
            std::vector<std::uint32_t> ranks, members;
            for (std::size_t k = begin; k < end && !context.cancelled(); ++k) {
                const double z =
                    box.low.z + (static_cast<double>(k) + 0.5) * size.z / static_cast<double>(layers);
                const Box2 layer{{box.low.x, box.low.y}, {box.high.x, box.high.y}};
                lattice_integral(layer, points / static_cast<double>(layers), k, [&](Vec2 q, double) {
                    ranks.clear();
                    for (std::uint32_t level = 0; level < levels_.size(); ++level) {
                        levels_[level]->members({q.x, q.y, z}, members);
                        for (const std::uint32_t index : members) ranks.push_back(rank_of_[level][index]);
                    }
                    if (!ranks.empty() && *std::min_element(ranks.begin(), ranks.end()) == owner) {
                        for (const std::uint32_t rank : ranks) ++counts[k][rank];
                    }
                    return 0.0;
                });
            }
        });
        std::vector<std::uint64_t> sum(drawn_.size(), 0);
        for (const auto& layer : counts) {
            for (std::size_t rank = 0; rank < sum.size(); ++rank) sum[rank] += layer[rank];
        }
        for (std::size_t rank = 0; rank < sum.size(); ++rank) {
            if (sum[owner] > 0)
                shares[rank] = static_cast<double>(sum[rank]) / static_cast<double>(sum[owner]);
        }
        return shares;
    }

    Fields levels_;
    std::shared_ptr<const StructureField> of_slices_;
    std::vector<Drawn> drawn_;                         // by rank
    std::vector<std::vector<std::uint32_t>> rank_of_;  // by level, then structure of it
    std::vector<std::uint32_t> rank_;                  // by structure of the set
    double clamp_ = 0;
};

// Slices between those of a level that it has not.
void warn_of_unknown_slices(const ContourSet& set, RunContext& context) {
    for (std::size_t n = 0; n < set.overlapping->levels.size() && set.drawn; ++n) {
        const std::vector<std::uint32_t>& own = set.overlapping->slices[n];
        const ContourSet& level = set.overlapping->levels[n];
        const auto gap = std::adjacent_find(own.begin(), own.end(),
                                            [](std::uint32_t a, std::uint32_t b) { return b > a + 1; });
        if (gap == own.end()) continue;
        std::string names;
        for (const Structure& structure : level.structures)
            names += (names.empty() ? "" : ", ") +
                     (structure.name.empty() ? std::to_string(structure.number) : structure.name);
        context.warn(
            {"W-FLD-012",
             "slices between those of the structure draw other structures, but not this one",
             {set.source, set.slices[*gap + 1].name, names, "",
              std::to_string(own.back() - own.front() + 1 - own.size()) + " slices without it"},
             "the structure was continued through them; if it ends there, draw it as two structures"});
    }
}

}  // namespace

Result<std::shared_ptr<const StructureField>> make_nested_field(const ContourSet& set,
                                                                const SliceFacts& slices,
                                                                const FieldOptions& options,
                                                                RunContext& context) {
    Fields levels;
    warn_of_unknown_slices(set, context);
    for (const ContourSet& level : set.overlapping->levels) {
        if (level.contours.empty()) {
            levels.push_back(nullptr);
            continue;
        }
        // A level is another set than the whole: some of its slices, which may lie otherwise than all do.
        ANATOMESH_TRY(std::shared_ptr<const StructureField> field,
                      make_field_of_slices(level, slice_facts_of(level, options.max_gap_spacings, context),
                                           options, context));
        levels.push_back(std::move(field));
    }
    std::shared_ptr<const StructureField> of_slices;
    if (slices.arrangement.is_parallel()) {
        RunContext apart;  // what it would warn of is no part of the field
        apart.threads = context.threads;
        apart.cancel = context.cancel;
        ContourSet plain = set;
        plain.exclusive = false;  // slices that draw others alone are none of a structure's
        ANATOMESH_TRY(of_slices, make_parallel_field(plain, options, apart));
    }
    return std::shared_ptr<const StructureField>(
        std::make_shared<NestedField>(levels, std::move(of_slices), set));
}

}  // namespace anatomesh
