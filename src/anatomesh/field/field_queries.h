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
//   RawValue raw(std::uint32_t structure, Vec3 p) const;
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
    double value(std::uint32_t structure, Vec3 p) const final {
        if (!partition_) return clipped(source().raw(structure, p));
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
        const Best best = two_best(p);
        const double all = source().raw_union(p);
        source().each_raw(p, [&](std::uint32_t s, RawValue raw) {
            near.push_back({s, owned(raw, best.structure == s ? best.second : best.first, all)});
        });
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
        const Best best = two_best(p);
        if (best.structure != nobody && best.beyond_end < 0) out.push_back(best.structure);
    }

    double interface_distance(Vec3 p) const final {
        double nearest = clamp_;
        const auto consider = [&](double value) { nearest = std::min(nearest, std::abs(value)); };
        if (!partition_) {
            source().each_raw(p, [&](std::uint32_t, RawValue raw) { consider(clipped(raw)); });
            return nearest;
        }
        const Best best = two_best(p);
        const double all = source().raw_union(p);
        source().each_raw(p, [&](std::uint32_t s, RawValue raw) {
            consider(owned(raw, best.structure == s ? best.second : best.first, all));
        });
        return nearest;
    }

    double clamp() const final { return clamp_; }

  protected:
    double clamp_ = 0;
    bool partition_ = false;

  private:
    static constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();
    struct Best {
        std::uint32_t structure = nobody;
        double first, second, beyond_end = 0;
    };

    const Source& source() const { return static_cast<const Source&>(*this); }

    double clipped(RawValue raw) const {
        return std::clamp(std::max(raw.value, raw.beyond_end), -clamp_, clamp_);
    }
    double owned(RawValue own, double other, double all) const {
        return clipped({std::max(all, 0.5 * (own.value - other)), own.beyond_end});
    }

    // The smallest raw value, of the lowest index where several are equal, and the next smallest.
    Best two_best(Vec3 p) const {
        Best best{nobody, clamp_, clamp_, 0};
        source().each_raw(p, [&](std::uint32_t s, RawValue raw) {
            if (raw.value < best.first) {
                best = {s, raw.value, best.first, raw.beyond_end};
            } else {
                best.second = std::min(best.second, raw.value);
            }
        });
        return best;
    }
};

}  // namespace anatomesh
