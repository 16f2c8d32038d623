// The queries of a StructureField on top of one raw value per structure: what parallel and general planes
// share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "anatomesh/field/structure_field.h"

namespace anatomesh {

// A structure's own interpolated value and, where it ends flat, the signed distance beyond its end.
struct RawValue {
    double value;
    double beyond_end = -std::numeric_limits<double>::infinity();
};

// Source gives:
//   RawValue raw(std::uint32_t structure, Vec3 p, double reach) const;  // beyond +-reach: the side
//   template <class Body> void each_raw(Vec3 p, Body body) const;  // body(structure, RawValue), rising order
//   double raw_union(Vec3 p) const;                                // of the union of all structures
//
// Overlapping sets: the value is the raw value. Exclusive sets are a partition: the raw value of the union
// decides between inside and outside, and inside it a point belongs to the structure with the smallest raw
// value. So a structure's value is the larger of the union's raw value and half its own raw value's distance
// from the best other one: negative for one structure at most, zero on every wall. (To let outside compete as
// one more label cuts a notch into the outer surface wherever an inner wall moves from slice to slice.) What
// a structure with a flat end would own beyond it goes to outside.
template <class Source>
class FieldQueries : public StructureField {
  public:
    double value_within(std::uint32_t structure, Vec3 p, double reach) const final {
        return partition_ ? value(structure, p) : clipped(source().raw(structure, p, reach));
    }

    double value(std::uint32_t structure, Vec3 p) const final {
        if (!partition_) return clipped(source().raw(structure, p, everywhere));
        RawValue own{clamp_};
        double other = clamp_;
        source().each_raw(p, [&](std::uint32_t s, RawValue raw) {
            if (s == structure) {
                own = raw;
            } else {
                other = std::min(other, raw.value);
            }
        });
        return owned(own, other, source().raw_union(p));
    }

    void values_near(Vec3 p, std::vector<Near>& near) const final {
        if (!partition_) {
            source().each_raw(p, [&](std::uint32_t s, RawValue raw) { near.push_back({s, clipped(raw)}); });
            return;
        }
        Best best;
        const std::size_t first = near.size();
        source().each_raw(p, [&](std::uint32_t s, RawValue raw) {
            best.take(s, raw);
            near.push_back({s, raw.value});
        });
        if (near.size() == first) return;
        const double all = source().raw_union(p);
        for (std::size_t i = first; i < near.size(); ++i) {
            const bool is_best = near[i].structure == best.structure;
            const double beyond_end = is_best ? best.beyond_end : never;
            near[i].value = owned({near[i].value, beyond_end}, is_best ? best.second : best.first, all);
        }
    }

    void members(Vec3 p, std::vector<std::uint32_t>& out) const final {
        out.clear();
        if (!partition_) {
            source().each_raw(p, [&](std::uint32_t s, RawValue raw) {
                if (clipped(raw) < 0) out.push_back(s);
            });
            return;
        }
        if (!(source().raw_union(p) < 0)) return;
        Best best;
        source().each_raw(p, [&](std::uint32_t s, RawValue raw) { best.take(s, raw); });
        if (best.structure != nobody && best.beyond_end < 0) out.push_back(best.structure);
    }

    double interface_distance(Vec3 p) const final {
        if (!partition_) {
            double nearest = clamp_;
            source().each_raw(
                p, [&](std::uint32_t, RawValue raw) { nearest = std::min(nearest, std::abs(clipped(raw))); });
            return nearest;
        }
        Best best;
        source().each_raw(p, [&](std::uint32_t s, RawValue raw) { best.take(s, raw); });
        return best.structure == nobody ? clamp_ : wall_distance(best, source().raw_union(p));
    }

    bool exclusive() const final { return partition_; }

    double union_value(Vec3 p) const final {
        if (!partition_) {
            double least = clamp_;
            source().each_raw(p, [&](std::uint32_t, RawValue raw) { least = std::min(least, clipped(raw)); });
            return least;
        }
        Best best;
        source().each_raw(p, [&](std::uint32_t s, RawValue raw) { best.take(s, raw); });
        return clipped({source().raw_union(p), best.structure == nobody ? never : best.beyond_end});
    }

    double members_and_distance(Vec3 p, std::vector<std::uint32_t>& out) const final {
        out.clear();
        if (!partition_) {
            double nearest = clamp_;
            source().each_raw(p, [&](std::uint32_t s, RawValue raw) {
                const double value = clipped(raw);
                if (value < 0) out.push_back(s);
                nearest = std::min(nearest, std::abs(value));
            });
            return nearest;
        }
        Best best;
        source().each_raw(p, [&](std::uint32_t s, RawValue raw) { best.take(s, raw); });
        if (best.structure == nobody) return clamp_;
        const double all = source().raw_union(p);
        if (all < 0 && best.beyond_end < 0) out.push_back(best.structure);
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

    // The smallest raw value, of the lowest index where several are equal, and the next smallest.
    struct Best {
        std::uint32_t structure = nobody;
        double first = std::numeric_limits<double>::max(), second = first, beyond_end = never;

        void take(std::uint32_t s, RawValue raw) {
            if (raw.value < first) {
                *this = {s, raw.value, first, raw.beyond_end};
            } else {
                second = std::min(second, raw.value);
            }
        }
    };

    const Source& source() const { return static_cast<const Source&>(*this); }

    // How far the nearest wall of a partition is: that of the best structure or of the next one.
    double wall_distance(const Best& best, double all) const {
        return std::min({clamp_, std::abs(owned({best.first, best.beyond_end}, best.second, all)),
                         std::abs(owned({best.second, never}, best.first, all))});
    }
    double clipped(RawValue raw) const {
        return std::clamp(std::max(raw.value, raw.beyond_end), -clamp_, clamp_);
    }
    double owned(RawValue own, double other, double all) const {
        return clipped({std::max(all, 0.5 * (own.value - std::min(other, clamp_))), own.beyond_end});
    }
};

}  // namespace anatomesh
