// A structure along the common normal of parallel slices: what is drawn, and the rule between.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "anatomesh/field/motion/slice_motion.h"
#include "anatomesh/field/slice/distance_map.h"
#include "anatomesh/field/stack/caps.h"
#include "anatomesh/field/stack/paraboloid_caps.h"
#include "anatomesh/field/stack/slice_knots.h"
#include "anatomesh/field/stack/terminating_components.h"

namespace anatomesh {

// It stands for a knot on which nothing is drawn. [index; -1; D]
inline constexpr std::int32_t empty_knot = -1;

// A correction is at most nine tenths of the distance and this share of the gap. So it moves a surface by at most ten
// times this share, a quarter of the gap, and walls stay whole. [gaps; 0 to 0.1; M 2026-11 skull, slices left out]
inline constexpr double most_correction = 0.025;

// What the curvature of a path adds to the distance, before the bound of blend_distances().
inline double curvature_correction(double t, const SliceMotion::Path& path) {
    return t * (1 - t) * ((1 - t) * path.curvature_below - t * path.curvature_above);
}

// Between two slices, at the ends of a path from one to the other: the mean of their distances, weighted with
// the nearness of the slice and of its contour. Its zero set is that of (1 - t) s(a) + t s(b) with s(d) = d /
// (1 + |d| / softness): a contour without a counterpart is left at a steep angle. The corrections of the path are
// added as a cubic has them, but never so much that a path well inside at both ends leaves the structure, or
// the other way round: a correction moves the surface by a share of the gap at most.
inline double blend_distances(double a, double b, double t, double gap, double softness,
                              const SliceMotion::Path& path) {
    const double weight_a = (1 - t) * (softness + std::abs(b)), weight_b = t * (softness + std::abs(a));
    const double inverse = 1 / (weight_a + weight_b), ease = t * (1 - t);
    const double most =
        0.9 * (weight_a * std::abs(a) + weight_b * std::abs(b)) * inverse + 4 * ease * most_correction * gap;
    const double correction = curvature_correction(t, path);
    return (weight_a * a + weight_b * b) * inverse + std::clamp(correction, -most, most);
}

// Between a slice (distance d, t = 0) and one on which the structure is not drawn at all, a gap away: it
// keeps its shape half-way, or is rounded there.
inline double ending(double d, double t, double gap, bool rounded) {
    return rounded ? rounded_end(d, t * gap, 0.5 * gap) : (1 - t) * d + t * std::abs(d);
}

// The parts of a kind that end between two knots though the structure goes on beside them; where they end in
// a paraboloid cap, one part.
struct Termination {
    DistanceMap map;  // of the parts alone
    Box2 box;         // beyond it nothing of them is near
    bool from_below, is_void;
    std::optional<ParaboloidCap> paraboloid;

    // At the share `away` of the gap from their slice, where they lie at the distance d in it.
    double value(double d, double away, double gap, bool rounded) const {
        return paraboloid ? paraboloid->value(d, away * gap) : ending(d, away, gap, rounded);
    }
    // How much of each half of the gap they fill over a point, from their slice on. `inside`: the share of a
    // lattice's column there that is theirs on the slice.
    std::array<double, 2> filled(double d, double gap, bool rounded, double inside) const {
        const double half = 0.5 * gap;
        if (paraboloid) {
            const double height = paraboloid->height(d) / half;
            return {std::min(height, 1.0), std::max(height - 1, 0.0)};
        }
        return {rounded ? rounded_height(d, half) / half : inside, 0};
    }
};

// A stretch along the normal of the first slice, from the height of its origin on, mm.
struct FieldStretch {
    double low = 0, high = 0;
};

// What ends between two neighbouring knots.
struct GapEnds {
    std::vector<Termination> terminations;  // holes before pieces
    std::vector<Box2> boxes;                // theirs: most points are in none
    // The regions of the lower and the upper knot without the parts that end in paraboloid caps; null: no such parts.
    std::array<std::unique_ptr<const DistanceMap>, 2> rest;
};

// A structure along the normal: its knots, each with its distance map, and a table from position to knot.
// Immutable after build; queries are const and thread-safe. What lies between two knots is shared with stacks made later
// that have the same there.
class StructureStack {
  public:
    using Maps = std::vector<std::shared_ptr<const DistanceMap>>;

    StructureStack() = default;
    StructureStack(StructureKnots knots, const std::vector<std::int32_t>& map_of_slice, bool rounded);

    bool empty() const { return knots_.empty(); }
    double low() const { return knots_.front().low; }
    double high() const { return knots_.back().high; }

    // The structure at (q, z): the two knots around z, each with its clamped distance, blended. Where that
    // lies beyond +-reach by what the maps' grids know, a number of the same sign beyond reach. Where it or a
    // part of it ends, `end` (of a partition) gets the signed distance from its half of the gap.
    // `terminations`: with the parts of it that end.
    double blend(const Maps& maps, double clamp, Vec2 q, double z, double reach, double* end = nullptr,
                 bool terminations = true) const;

    // How far z lies beyond the flat ends of its part; negative within.
    double beyond_flat_cap(double z) const {
        if (!is_flat_) return -std::numeric_limits<double>::infinity();
        std::size_t part = 0;
        while (z > flat_[part].until) ++part;
        return std::max(flat_[part].low - z, z - flat_[part].high);
    }

    void add_flat_ends(std::vector<double>& heights) const {
        for (const StructureKnots::Extent& part : flat_) {
            for (const double height : {part.low, part.high}) {
                if (std::isfinite(height)) heights.push_back(height);
            }
        }
    }

    std::size_t pair_count() const { return knots_.empty() ? 0 : knots_.size() - 1; }

    // The parts that end between knots i and i + 1; both must be drawn, else nothing happens. `paraboloid
    // caps`: those whose sections shrink end in paraboloid caps.
    void find_terminations(std::size_t i, const Maps& maps, double clamp, bool paraboloids);
    void add_terminations(std::size_t i, const std::vector<TerminatingComponent>& parts, bool from_below,
                          double clamp);

    // How the structure moves between knots i and i + 1; both must be drawn, else nothing happens. Requires:
    // find_terminations() for all knots.
    void find_motion(std::size_t i, const Maps& maps);
    const SliceMotion& motion(std::size_t i) const { return *motions_[i]; }

    // A gap of a stack that was made earlier, with the maps of its field.
    struct EarlierGap {
        const StructureStack* stack;
        const Maps* maps;
        std::size_t i;
    };
    // Whether the earlier gap is at the same height.
    bool lies_at(std::size_t i, const EarlierGap& earlier) const {
        return knots_[i].high == earlier.stack->knots_[earlier.i].high;
    }
    // Both take over what lies in the earlier gap, instead of finding it, where all that it is found from is the same:
    // maps, by their addresses, and distances. Return whether they did.
    bool take_terminations(std::size_t i, const Maps& maps, const EarlierGap& earlier);
    // Requires: all terminations are found or taken.
    bool take_motion(std::size_t i, const Maps& maps, const EarlierGap& earlier);

    // Appends the stretches from knot to knot of this stack that the other has not, with the same maps (by address),
    // motion and ends: there values may differ.
    void add_unlike(const Maps& maps, const StructureStack& other, const Maps& other_maps,
                    std::vector<FieldStretch>& stretches) const;

    // Two neighbouring knots as the maps drawn there (empty_knot: none) and the positions they reach.
    struct Pair {
        std::int32_t below, above;
        double below_low, below_high, above_low;
        const SliceMotion* motion;
        const std::vector<Termination>* terminations;
        // What is drawn there without the parts that end in paraboloid caps between them; null: no such
        // parts.
        std::array<const DistanceMap*, 2> rest;
        bool rounded;  // how it ends where one of them is empty
    };
    Pair pair(std::size_t i) const {
        return {knots_[i].map,
                knots_[i + 1].map,
                knots_[i].low,
                knots_[i].high,
                knots_[i + 1].low,
                motions_[i].get(),
                &ends_[i]->terminations,
                {ends_[i]->rest[0].get(), ends_[i]->rest[1].get()},
                rounded_};
    }

    // Calls body(z from, z to, map, how far the structure moves beside it) for the stretch of the axis on
    // which a map has a say.
    template <class Body>
    void each_stretch(Body body) const {
        for (std::size_t i = 0; i < knots_.size(); ++i) {
            if (knots_[i].map == empty_knot) continue;
            body(i > 0 ? knots_[i - 1].high : low(), i + 1 < knots_.size() ? knots_[i + 1].low : high(),
                 static_cast<std::size_t>(knots_[i].map),
                 std::max(i > 0 ? motions_[i - 1]->max_move() : 0.0,
                          i < motions_.size() ? motions_[i]->max_move() : 0.0));
        }
    }

  private:
    struct Known {
        double low, high;
        std::int32_t map;
    };

    const DistanceMap* map_at(std::size_t knot, const Maps& maps) const {
        return knot < knots_.size() && knots_[knot].map != empty_knot
                   ? maps[static_cast<std::size_t>(knots_[knot].map)].get()
                   : nullptr;
    }
    bool has_surroundings_of(std::size_t i, const Maps& maps, const EarlierGap& earlier) const;
    double gap(std::size_t i) const { return knots_[i + 1].low - knots_[i].high; }
    // Takes those out of `parts`, of knot i or i + 1, that end in paraboloid caps.
    void add_paraboloid_caps(std::size_t i, std::vector<TerminatingComponent>& parts, bool from_below,
                             const Maps& maps, double clamp);
    // Of the parts that end between knots i and i + 1, the first whose box holds q; their number if none
    // does.
    std::size_t first_termination(std::size_t i, Vec2 q) const {
        const std::vector<Box2>& boxes = ends_[i]->boxes;
        std::size_t n = 0;
        while (n < boxes.size() && !boxes[n].contains(q)) ++n;
        return n;
    }
    // Both look at the parts from the one of number `first` on.
    bool is_near_termination(std::size_t i, std::size_t first, Vec2 q, double clamp) const;
    double with_terminations(std::size_t i, std::size_t first, Vec2 q, double t, double clamp, double value,
                             double* end) const;
    void sort_terminations(std::size_t i);

    std::vector<Known> knots_;
    // Between a knot and the next; never null.
    std::vector<std::shared_ptr<const SliceMotion>> motions_;
    std::vector<std::shared_ptr<GapEnds>> ends_;
    std::vector<StructureKnots::Extent> flat_;
    std::vector<std::uint32_t> buckets_;
    double inverse_bucket_ = 0;
    bool is_flat_ = false, rounded_ = false;
};

}  // namespace anatomesh
