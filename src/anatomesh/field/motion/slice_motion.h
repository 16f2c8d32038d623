// SliceMotion: how the drawn region of a structure moves and curves between two neighbouring slices.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "anatomesh/field/motion/branching.h"
#include "anatomesh/field/slice/distance_map.h"

namespace anatomesh {

class MotionAverage;

// A boundary that leans moves sideways from one slice to the next. The motion says by how much: `move` is the
// vector from where a point of the boundary lies in the slice below to where it lies in the slice above.
// Pieces of the two boundaries are matched with the nearest piece that faces the same way, so outer walls
// with outer walls and inner ones with inner ones, also where the two regions do not overlap; matches are
// averaged over a neighbourhood that shrinks from round to round, and each round searches from where the last
// one led (iterated closest points: Besl and McKay, IEEE PAMI 14, 1992; Chui and Rangarajan, Comput. Vis.
// Image Underst. 89, 2003). A piece whose match does not lead back to it has little say. Where nothing is
// matched the motion fades to 0.
//
// The nearest piece of the same facing is the wrong one where an outline slides along itself: the sides of an
// oblique tube stay, and between the slices it gets a neck. So outlines that are carried amiss, though one is
// the other moved, start where the map between the two leads them (aligned_outlines.h).
//
// `curvature_below` and `curvature_above` say how the path through the point curves at either end: the change of slope
// of the distance that the slice beyond adds, as in a cubic through four slices (Catmull and Rom, 1974).
//
// Immutable after build; queries are const and thread-safe. Guarantees: continuous in the plane; the same for
// the pair upside down, but for signs and rounding; equal boundaries do not move. Complexity: construction
// O(n) in the edges for contours with bounded curvature; memory linear in the edges; a query O(1).
class SliceMotion {
  public:
    struct Path {
        Vec2 move;
        double curvature_below = 0, curvature_above = 0;
    };
    // A slice beyond the two and its distance from the nearer of them; map null: no slice there. `ending`:
    // the parts of the nearer one that end before it (terminating_components()): it says nothing of them.
    struct Beyond {
        const DistanceMap* map = nullptr;
        double gap = 0;
        std::vector<const DistanceMap*> ending;
    };

    SliceMotion() = default;  // nothing moves
    // Requires: gap > 0, the distance of the two slices, mm.
    SliceMotion(const DistanceMap& below, const DistanceMap& above, double gap, Beyond further_below,
                Beyond further_above);

    // The path that is at q at the share t of the way from the slice below to the one above. Inlined by
    // order: called, it makes a value of the field take a fifth longer.
    [[gnu::always_inline]] Path at(Vec2 q, double t) const {
        const Path first = at_middle(q);
        return t == 0.5 || first.move == Vec2{} ? first : at_middle(q - (t - 0.5) * first.move);
    }

    double max_move() const { return max_move_; }  // no path moves further, mm
    // No correction t (1 - t) ((1 - t) curvature_below - t curvature_above) of a path is larger, mm; of those with its curvature.
    double max_correction() const { return max_correction_; }
    static double largest_correction(const Path& path) {
        return 4.0 / 27 * (std::abs(path.curvature_below) + std::abs(path.curvature_above));
    }
    // Whether outlines moved so far that they had to be aligned first (aligned_outlines.h).
    bool is_aligned() const { return is_aligned_; }
    bool overlaps() const {
        return overlaps_;
    }  // whether the two regions have a common point, as seen from above
    const std::vector<Ambiguity>& ambiguities() const { return ambiguities_; }
    std::size_t bytes() const { return nodes_.size() * sizeof(Node); }

  private:
    using Node = std::array<float, 4>;  // move x and y, bend below and above
    struct Neighbour {
        const DistanceMap& map;
        const Beyond& further;
    };

    void set_paths(const MotionAverage& average, const Neighbour& lower, const Neighbour& upper, double gap);
    // amiss_shares() of the outlines of one of the slices in the other.
    std::vector<double> amiss(const Boundary& boundary, const DistanceMap& other, bool upwards) const;

    // The path through q half-way between the slices: bilinear between the nodes of a lattice.
    [[gnu::always_inline]] Path at_middle(Vec2 q) const {
        const double x = (q.x - low_.x) * inverse_step_, y = (q.y - low_.y) * inverse_step_;
        if (!(x >= 0 && y >= 0 && x < cells_x_ && y < cells_y_)) return {};
        const auto i = static_cast<std::uint32_t>(x), j = static_cast<std::uint32_t>(y);
        const Node* row = &nodes_[static_cast<std::size_t>(j) * (cells_x_ + 1) + i];
        const Node* next_row = row + cells_x_ + 1;
        const auto u = static_cast<float>(x - i), v = static_cast<float>(y - j);
        const float w00 = (1 - u) * (1 - v), w10 = u * (1 - v), w01 = (1 - u) * v, w11 = u * v;
        Node mean;
        for (std::size_t k = 0; k < 4; ++k) {
            mean[k] = w00 * row[0][k] + w10 * row[1][k] + w01 * next_row[0][k] + w11 * next_row[1][k];
        }
        return {{mean[0], mean[1]}, mean[2], mean[3]};
    }

    Vec2 low_;
    double step_ = 1, inverse_step_ = 1, max_move_ = 0, max_correction_ = 0;
    std::uint32_t cells_x_ = 0, cells_y_ = 0;
    bool overlaps_ = true, is_aligned_ = false;
    std::vector<Ambiguity> ambiguities_;
    std::vector<Node> nodes_;
};

}  // namespace anatomesh
