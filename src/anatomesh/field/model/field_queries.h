// The queries of a StructureField on top of one raw value per structure: what parallel and general planes
// share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

// A structure's own interpolated value; where it ends flat, the signed distance beyond its end; between a
// slice that has it and one that has it not, the signed distance from its half of the gap.
struct RawValue {
    double value;
    double beyond_flat_cap = -std::numeric_limits<double>::infinity();
    double to_own_half_gap = std::numeric_limits<double>::infinity();
};

// Source gives, with values that beyond +-reach tell the side alone:
//   RawValue raw(std::uint32_t structure, Vec3 p, double reach) const;
//   template <class Body> void each_raw(Vec3 p, double reach, Body body) const;
//       calls body(structure, RawValue) in rising order
//   double raw_union(Vec3 p, double reach) const;
//       of the union of all structures
//   static constexpr bool sides_cost_less;
//       whether a side alone costs less than a value
//
// Overlapping sets: the value is the raw value. Exclusive sets are a partition: the raw value of the union
// decides between inside and outside, and inside it a point belongs to the structure with the smallest raw
// value. So a structure's value is the larger of the union's raw value and half its own raw value's distance
// from the best other one: negative for one structure at most, zero on every wall. (To let outside compete as
// one more label cuts a notch into the outer surface wherever an inner wall moves from slice to slice.) Where
// a structure ends it keeps its half of the gap before the others are compared: a lesion inside an organ ends
// as it would alone, else the organ, deep inside on the next slice, closes over it. What a structure with a
// flat end would own beyond it goes to outside.
template <class Source>
class FieldQueries : public StructureField {
  public:
    double value_within(std::uint32_t structure, Vec3 p, double reach) const final {
        return partition_ ? value(structure, p) : clipped(source().raw(structure, p, reach));
    }

    double value(std::uint32_t structure, Vec3 p) const final {
        if (!partition_) return clipped(source().raw(structure, p, everywhere));
        RawValue own{clamp_};
        Rival other{clamp_};
        source().each_raw(p, everywhere, [&](std::uint32_t s, RawValue raw) {
            if (s == structure) {
                own = raw;
            } else {
                other.take(raw);
            }
        });
        return owned(own, other, source().raw_union(p, everywhere));
    }

    void values_near(Vec3 p, std::vector<Near>& near) const final {
        if (!partition_) {
            source().each_raw(p, everywhere, [&](std::uint32_t s, RawValue raw) {
                near.push_back({s, clipped(raw)});
            });
            return;
        }
        Best best;
        const std::size_t first = near.size();
        source().each_raw(p, everywhere, [&](std::uint32_t s, RawValue raw) {
            best.take(s, raw);
            near.push_back({s, raw.value});
        });
        if (near.size() == first) return;
        const double all = source().raw_union(p, everywhere);
        for (std::size_t i = first; i < near.size(); ++i)
            near[i].value = best.value_of(*this, near[i].structure, near[i].value, all);
    }

    void members(Vec3 p, std::vector<std::uint32_t>& out) const final {
        out.clear();
        if (!partition_) {
            source().each_raw(p, 0, [&](std::uint32_t s, RawValue raw) {
                if (clipped(raw) < 0) out.push_back(s);
            });
            return;
        }
        if (!(source().raw_union(p, 0) < 0)) return;
        if (Source::sides_cost_less && take_lone_owner(p, out)) return;
        Best best;
        source().each_raw(p, everywhere, [&](std::uint32_t s, RawValue raw) { best.take(s, raw); });
        if (best.owner() != nobody && best.beyond_flat_cap() < 0) out.push_back(best.owner());
    }

    double interface_distance(Vec3 p) const final {
        if (!partition_) {
            double nearest = clamp_;
            source().each_raw(p, everywhere, [&](std::uint32_t, RawValue raw) {
                nearest = std::min(nearest, std::abs(clipped(raw)));
            });
            return nearest;
        }
        Best best;
        source().each_raw(p, everywhere, [&](std::uint32_t s, RawValue raw) { best.take(s, raw); });
        return best.owner() == nobody ? clamp_ : wall_distance(best, source().raw_union(p, everywhere));
    }

    bool exclusive() const final { return partition_; }

    double union_value(Vec3 p) const final {
        if (!partition_) {
            double least = clamp_;
            source().each_raw(p, everywhere,
                              [&](std::uint32_t, RawValue raw) { least = std::min(least, clipped(raw)); });
            return least;
        }
        Best best;
        source().each_raw(p, everywhere, [&](std::uint32_t s, RawValue raw) { best.take(s, raw); });
        return clipped(
            {source().raw_union(p, everywhere), best.owner() == nobody ? never : best.beyond_flat_cap()});
    }

    double members_and_distance(Vec3 p, std::vector<std::uint32_t>& out) const final {
        out.clear();
        if (!partition_) {
            double nearest = clamp_;
            source().each_raw(p, everywhere, [&](std::uint32_t s, RawValue raw) {
                const double value = clipped(raw);
                if (value < 0) out.push_back(s);
                nearest = std::min(nearest, std::abs(value));
            });
            return nearest;
        }
        Best best;
        source().each_raw(p, everywhere, [&](std::uint32_t s, RawValue raw) { best.take(s, raw); });
        if (best.owner() == nobody) return clamp_;
        const double all = source().raw_union(p, everywhere);
        if (all < 0 && best.beyond_flat_cap() < 0) out.push_back(best.owner());
        return wall_distance(best, all);
    }

    double clamp() const final { return clamp_; }

  protected:
    static constexpr double everywhere = std::numeric_limits<double>::infinity();  // as a reach
    double clamp_ = 0;
    bool partition_ = false;

  private:
    static constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();
    static constexpr double never = -std::numeric_limits<double>::infinity();

    static constexpr double nowhere = std::numeric_limits<double>::infinity();

    // What a structure of a partition competes with: the smallest raw value of the others, and of those that
    // end.
    struct Rival {
        double value;
        double to_own_half_gap = nowhere;
        void take(RawValue raw) {
            value = std::min(value, raw.value);
            to_own_half_gap = std::min(to_own_half_gap, raw.to_own_half_gap);
        }
    };

    // The structure with the smallest raw value, the lowest index where several are equal, and the one whose
    // half of a gap is nearest; with the next smallest values of each.
    struct Best {
        static constexpr double most = std::numeric_limits<double>::max();
        std::uint32_t structure = nobody, next = nobody, ender = nobody;
        RawValue first{most}, end{most};
        double second = most, second_to_half_gap = nowhere;

        void take(std::uint32_t s, RawValue raw) {
            if (raw.value < first.value) {
                second = first.value;
                next = structure;
                first = raw;
                structure = s;
            } else if (raw.value < second) {
                second = raw.value;
                next = s;
            }
            if (raw.to_own_half_gap < end.to_own_half_gap) {
                second_to_half_gap = end.to_own_half_gap;
                end = raw;
                ender = s;
            } else {
                second_to_half_gap = std::min(second_to_half_gap, raw.to_own_half_gap);
            }
        }
        std::uint32_t owner() const { return end.to_own_half_gap < 0 ? ender : structure; }
        double beyond_flat_cap() const {
            return end.to_own_half_gap < 0 ? end.beyond_flat_cap : first.beyond_flat_cap;
        }
        // Of the structure s, whose raw value is `raw`.
        double value_of(const FieldQueries& field, std::uint32_t s, double raw, double all) const {
            return field.owned(
                {raw, s == owner() ? beyond_flat_cap() : never, s == ender ? end.to_own_half_gap : nowhere},
                {s == structure ? second : first.value,
                 s == ender ? second_to_half_gap : end.to_own_half_gap},
                all);
        }
    };

    // Where one structure alone has the point on its side, and none ends there, the sides tell the owner: its
    // value is the smallest. False where they do not tell.
    bool take_lone_owner(Vec3 p, std::vector<std::uint32_t>& out) const {
        std::uint32_t owner = nobody;
        double beyond_flat_cap = never;
        bool is_clear = true;
        source().each_raw(p, 0, [&](std::uint32_t s, RawValue raw) {
            is_clear = is_clear && raw.to_own_half_gap == nowhere && (owner == nobody || !(raw.value < 0));
            if (!(raw.value < 0)) return;
            owner = s;
            beyond_flat_cap = raw.beyond_flat_cap;
        });
        if (!is_clear || owner == nobody) return false;
        if (beyond_flat_cap < 0) out.push_back(owner);
        return true;
    }

    const Source& source() const { return static_cast<const Source&>(*this); }

    // How far the nearest wall of a partition is: that of the best structure, of the next one, or of one that
    // ends.
    double wall_distance(const Best& best, double all) const {
        double nearest =
            std::min(clamp_, std::abs(best.value_of(*this, best.structure, best.first.value, all)));
        if (best.ender != nobody)
            nearest = std::min(nearest, std::abs(best.value_of(*this, best.ender, best.end.value, all)));
        if (best.next != nobody)
            nearest = std::min(nearest, std::abs(best.value_of(*this, best.next, best.second, all)));
        return nearest;
    }
    double clipped(RawValue raw) const {
        return std::clamp(std::max(raw.value, raw.beyond_flat_cap), -clamp_, clamp_);
    }
    double owned(RawValue own, Rival other, double all) const {
        const double nearer =
            std::max(0.5 * (own.value - std::min(other.value, clamp_)), -other.to_own_half_gap);
        return clipped(
            {std::max(all, own.to_own_half_gap < other.to_own_half_gap ? std::min(nearer, own.to_own_half_gap)
                                                                       : nearer),
             own.beyond_flat_cap});
    }
};

}  // namespace anatomesh
