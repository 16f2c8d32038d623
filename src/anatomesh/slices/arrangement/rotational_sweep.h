// RotationalSweep: slices about an axis, unwarped into parallel ones.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/rotation_axis.h"

namespace anatomesh {

// A probe that is turned about its own axis gives slices that all run through this axis (rotational scanning:
// Fenster, Downey and Cardinal, Phys. Med. Biol. 46, 2001). Each is two half-planes, and these follow one
// another all round as the slices of a stack do: in the coordinates (distance from the axis, way along it,
// angle times the contours' mean distance from it) they are parallel. Each slice comes twice, the second time
// half a turn later, from behind; both times with all its contours, so that distances go on across the axis.
// A half-plane on which nothing is drawn says nothing, and is left out. Where neighbours are further apart
// than 1.25 times so many usual angles - which three in four do not exceed - as are asked for (1.75 times up
// to 30 degrees), what is drawn ends on both sides of the gap, which is far wider in chart coordinates
// than it is - but that most of it on both, by area, is round the axis, and the gap no wider than 75 degrees:
// then it goes on.
//
// Guarantees: all points of a slice's contours on a half-plane have that half-plane's z, exactly, and the x
// and y of its frame; continuous where the half-planes are apart. Immutable.
class RotationalSweep {
  public:
    // Nothing unless there are two slices or more; what is drawn on half-planes reaches a quarter as far out
    // on each as in the median, or nowhere; none leans by more than 30 degrees against the axis
    // (rotation_axis.h); no two neighbours are apart by more than 179 degrees but where nothing is drawn on
    // one side of the axis, nor, where they are joined, by more than 110; and their planes run by the axis so
    // closely that of neighbours half the pairs are apart (apart_from()) from the contours' mean distance
    // from it on. Requires: a contour; `axis` is rotation_axis(set); max_gap >= 1, usual angles that are joined. Complexity: O(points +
    // slices^2).
    static std::optional<RotationalSweep> of(const ContourSet& set, const Axis& axis, double max_gap);

    // Neighbours further apart than 1.5 times the usual angle or than 95 degrees, by their slices: slices are
    // missing there, or nothing is drawn on them.
    struct Gap {
        std::uint32_t from, to;
        double angle;  // radians
        bool joined;
    };
    std::vector<Gap> wide_gaps() const;

    double radius(Vec3 p) const;  // distance from the axis

    // The distance from the axis from which on neighbours about a point are at least half as far apart as
    // their angle says: next to none where their planes run through the axis, wide where they cross beside
    // it. Continuous off the axis. Complexity: logarithmic in the slices.
    double apart_from(Vec3 p) const;

    // How far planes run beside the axis at most, between the ends of the contours along it.
    double beside() const { return beside_; }

    // Between neighbours: the usual, or that of the gap in which the point is where that is wider;
    // continuous off the axis. Radians.
    double angle(Vec3 p) const;

    // Requires, for what is guaranteed: radius(p) >= apart_from(p). Complexity: logarithmic in the slices.
    Vec3 to_chart(Vec3 p) const;

    // The set in chart coordinates: its slices all round, and some of them again before and after.
    ContourSet to_chart(const ContourSet& set) const;

    // A box that holds every point whose chart coordinates lie within `reach` of those of contours in
    // `box`. Requires: `box` holds the contours.
    Box3 around(const Box3& box, double reach) const;

  private:
    struct HalfPlane {
        Plane plane;          // u away from the axis, v along it, the normal towards the next one
        double beside, lean;  // how far along the normal it is from the axis, there and a mm on along this
        double low, high;     // of its slice's points, along the normal
        double angle;         // from that of the first, [0, 2 pi)
        std::uint32_t slice;  // of the set
        bool behind;          // its normal is opposite to the slice's
        double reach;         // of its slice's points, along u
        double round_axis;    // share of what is drawn, by area, that the axis runs through
        double height;        // straight
        bool joined;          // to the next one
    };

    void add_half_planes(const ContourSet& set, std::uint32_t s);
    bool leave_out_empty();
    double mean_radius(const ContourSet& set) const;
    bool put_in_order(double max_gap);
    double angle_of(Vec3 p) const;
    std::size_t before(double angle) const;   // the last half-plane up to there
    double angle_after(std::size_t k) const;  // from a half-plane to the next one
    double apart_after(std::size_t k, double along) const;
    void find_apart(double low, double high);
    double height(std::ptrdiff_t place) const;  // in the chart; before and after the first turn too

    Vec3 origin_, direction_;             // of the axis
    std::vector<HalfPlane> half_planes_;  // by angle
    double mean_radius_ = 0, usual_angle_ = 0, widest_joined_ = 0;
    double turn_height_ = 0;  // straight
    // After each half-plane, where neighbours are apart (apart_from()), at both ends of the axis; empty where
    // all planes run through it.
    using Ends = std::array<double, 2>;
    std::vector<Ends> apart_;
    double low_ = 0, high_ = 0, beside_ = 0;  // these ends; the farthest there
};

}  // namespace anatomesh
