// ObliquityFactors: how far a structure's boundary is in space where a plane runs along it, as the planes
// across tell.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// The obliquity factors of one structure on a grid of one plane, bilinear between its nodes; beyond them as
// at the nearest place.
class ObliquityMap {
  public:
    // `values`: of the nodes of a grid from `low` on, row by row, `nx` in each. Requires: nx and the rows
    // > 1.
    ObliquityMap(std::uint32_t structure, Vec2 low, double cell, std::uint32_t nx, std::vector<float> values);

    std::uint32_t structure() const { return structure_; }
    double at(Vec2 q) const;

  private:
    std::uint32_t structure_, nx_, ny_;
    Vec2 low_;
    double inverse_cell_;
    std::vector<float> values_;
};

// A patch that a point of another one has near it, and how far it is.
struct PatchNear {
    std::uint32_t patch;
    double distance;
};

struct DistanceInPlane {
    std::uint32_t structure;
    double distance;
};

// What is known of the patches.
struct PatchesSeen {
    double radius = 0;  // within which patches count, mm
    double clamp = 0;   // distance in a plane of a structure that is not drawn on it, mm
    double cell = 0;    // of the grids, mm; as many times that as keep them at 64 nodes a side
    std::vector<Plane> planes;
    std::vector<Box2> boxes;  // where each says something; empty: it says nothing
    // Of a point of a patch the others near it, or the nearest of them.
    std::function<void(std::uint32_t, Vec3, std::vector<PatchNear>&)> near;
    // Signed distances in the plane from a point of it, of the structures for which they are below the clamp.
    std::function<void(std::uint32_t, Vec2, std::vector<DistanceInPlane>&)> distances;
};

// A plane that runs along a boundary, just below or above it, has its contours far away: distances in it tell
// nothing of how near the boundary is, and a mean of such distances pushes the surface away from the plane in
// all places but beside the contours of planes across, which then lie in grooves. Those planes cut the
// boundary at a right angle, and know. The obliquity factor of a structure at a point of a plane is the share
// of its distance in the plane that the planes across leave of it: the mean of (t + r / 4) / d, at most 1,
// with d the plane's own distance, t another plane's at the foot of the point - where the boundary lies
// between the two at most r -, and r its distance; weights sin^2 (the angle between the planes) (R - r) / (R
// r), with R the radius, and 1 / R for the plane itself, whose share is 1. Beside planes across it is about
// the sine of the angle between the plane and the boundary; not below 0.05, and 1 for parallel planes alone.
class ObliquityFactors {
  public:
    ObliquityFactors() = default;

    // Guarantees: the same at any number of threads; unfinished where the context is cancelled. Complexity:
    // O(nodes x patches near them), about 1 us each.
    static ObliquityFactors of(const PatchesSeen& seen, RunContext& context);

    // In (0, 1]; `q` in the patch's plane.
    double at(std::uint32_t patch, std::uint32_t structure, Vec2 q) const {
        if (maps_.empty()) return 1;
        const std::vector<ObliquityMap>& maps = maps_[patch];
        const auto map =
            std::lower_bound(maps.begin(), maps.end(), structure,
                             [](const ObliquityMap& one, std::uint32_t s) { return one.structure() < s; });
        return map == maps.end() || map->structure() != structure ? 1 : map->at(q);
    }

    // How many structures have a obliquity factor other than 1 on the patch.
    std::size_t count(std::uint32_t patch) const { return maps_.empty() ? 0 : maps_[patch].size(); }

  private:
    std::vector<std::vector<ObliquityMap>> maps_;  // by patch and structure
};

}  // namespace anatomesh
