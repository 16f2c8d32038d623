// Slants: how far a structure's boundary is in space where a plane runs along it, as the planes across tell.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// The slants of one structure on a grid of one plane, bilinear between its nodes; beyond them as at the
// nearest place.
class SlantMap {
  public:
    // `values`: of the nodes of a grid from `low` on, row by row, `nx` in each. Requires: nx and the rows
    // > 1.
    SlantMap(std::uint32_t structure, Vec2 low, double cell, std::uint32_t nx, std::vector<float> values);

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
    // Of a point those within the radius.
    std::function<void(Vec3, std::vector<PatchNear>&)> near;
    // Signed distances in the plane from a point of it, of all structures that are drawn on the patch.
    std::function<void(std::uint32_t, Vec2, std::vector<DistanceInPlane>&)> distances;
};

// A plane that runs along a boundary, just below or above it, has its contours far away: distances in it tell
// nothing of how near the boundary is, and a mean of such distances pushes the surface away from the plane in
// all places but beside the contours of planes across, which then lie in grooves. Those planes cut the
// boundary at a right angle, and know. The slant of a structure at a point of a plane is the share of its
// distance in the plane that the planes across leave of it: the mean of t / d, at most 1, with d the plane's
// own distance and t another plane's at the foot of the point, or where the boundary lies between the two the
// distance of the feet at most; weights sin^2 (the angle between the planes) (R - r) / (R r), with r the
// other plane's distance and R the radius, and 1 / R for the plane itself, whose share is 1. It is about the
// sine of the angle between the plane and the boundary; 1 for parallel planes alone.
class Slants {
  public:
    Slants() = default;

    // Guarantees: the same at any number of threads. Complexity: O(nodes x patches near them), about 1 us
    // each.
    static Slants of(const PatchesSeen& seen, int threads);

    // In (0, 1]; `q` in the patch's plane.
    double at(std::uint32_t patch, std::uint32_t structure, Vec2 q) const {
        if (maps_.empty()) return 1;
        for (const SlantMap& map : maps_[patch]) {
            if (map.structure() == structure) return map.at(q);
        }
        return 1;
    }

    // How many structures have a slant other than 1 on the patch.
    std::size_t count(std::uint32_t patch) const { return maps_.empty() ? 0 : maps_[patch].size(); }

  private:
    std::vector<std::vector<SlantMap>> maps_;  // by patch
};

}  // namespace anatomesh
