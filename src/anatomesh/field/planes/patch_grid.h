// PatchGrid: the plane patches near a point, without those that nearer ones hide.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

// Finds the patches within a radius of a point, each patch grown by a margin in its plane. Cells over a box
// list the patches within the radius of any of their points, but those that others hide from all of these
// points. Immutable; queries are const and thread-safe.
class PatchGrid {
  public:
    // A query gives the nearest patches, so many at most: further ones are hidden by these. [patches; > 0; B]
    static constexpr std::uint32_t most_near = 16;
    // It stands for no patch. [index; 2^32 - 1; D]
    static constexpr std::uint32_t no_patch = 0xffffffffu;

    struct Key {
        double square;  // of the distance from the point
        std::uint32_t patch;
    };
    using Keys = std::array<Key, most_near>;

    PatchGrid() = default;
    // `drawn`: the patches that are found, rising; the others only keep their number. Points outside `box`
    // have no patches near. Complexity: O(cells x patches near a block of cells).
    PatchGrid(std::vector<PlanePatch> patches, const std::vector<std::uint32_t>& drawn, const Box3& box,
              double radius, double margin, int threads);

    // Fills the first keys with the nearest patches within the radius, sorted by distance, and returns how
    // many; without `but`, and without most of those that nearer ones hide. Linear in the patches of a cell.
    std::uint32_t find_near(Vec3 p, Keys& keys, std::uint32_t but = no_patch) const;

    // From a point of a patch's plane to the patch grown by the margin.
    Vec2 way_to(const PlanePatch& patch, Vec2 q) const {
        return {std::clamp(q.x, patch.box.low.x - margin_, patch.box.high.x + margin_) - q.x,
                std::clamp(q.y, patch.box.low.y - margin_, patch.box.high.y + margin_) - q.y};
    }

    const PlanePatch& patch(std::uint32_t n) const { return patches_[n]; }
    std::uint32_t size() const { return static_cast<std::uint32_t>(patches_.size()); }
    double radius() const { return radius_; }
    double margin() const { return margin_; }
    const Box3& box() const { return box_; }

  private:
    // A patch that a cell lists.
    struct Listed {
        std::uint32_t patch : 30;
        std::uint32_t before : 1;   // all points of the cell project into the grown patch
        std::uint32_t against : 1;  // its normal runs against that of the first that the cell lists
    };

    // The nearest patch on one side of a point.
    struct Occluder {
        std::uint32_t patch = 0;
        double height = 0;  // of the point above its plane; 0 of none
        Vec3 normal;

        // Whether the way to another patch, `across` along its normal, leads through this one: its share
        // would be nothing.
        bool hides(std::uint32_t other, double across, const Vec3& n) const {
            return height != 0 && other != patch && -across * height * dot(n, normal) >= height * height;
        }
    };

    // A patch beside a cell, as the cell's centre sees it.
    struct Beside {
        std::uint32_t patch;
        double height;    // of the centre above the plane
        double distance;  // of the centre above the patch's points, if above it, or below
        bool apart;       // the cell lies on one side of the patch, before it in full
    };

    std::array<Occluder, 2> occluders_at(Vec3 p, std::span<const Listed> listed, std::uint32_t but) const;
    bool is_before(Vec3 p, double reach, const PlanePatch& patch) const;
    bool is_hidden(const Beside& far, const Beside& near, double half) const;
    void drop_hidden(Vec3 center, double half, std::vector<std::uint32_t>& list,
                     std::vector<Beside>& scratch) const;
    void add_within(Vec3 center, double reach, std::span<const std::uint32_t> from,
                    std::vector<std::uint32_t>& out) const;
    void list_patches(const std::vector<std::uint32_t>& drawn, double cell, int threads);

    std::vector<PlanePatch> patches_;
    Box3 box_;
    double radius_ = 0, margin_ = 0, inverse_cell_ = 0;
    std::array<std::uint32_t, 3> cells_{};
    std::vector<std::uint32_t> cell_begin_;
    std::vector<Listed> cell_patches_;
};

}  // namespace anatomesh
