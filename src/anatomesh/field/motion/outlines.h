// The outlines and holes of a region one by one, from the pieces of its boundary.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "anatomesh/field/motion/boundary_pieces.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

struct Outline {
    std::uint32_t first = no_piece, count = 0;  // of its pieces, along the boundary
    double area = 0;                            // negative: of a hole
    double radius = 0;                          // of a disc of its area
    Box2 box;
};

// Requires: the boundary outlives it.
class Outlines {
  public:
    explicit Outlines(const Boundary& boundary) : boundary_(boundary), outlines_(boundary.outlines) {
        for (std::uint32_t p = 0; p < boundary.pieces.size(); ++p) {
            Outline& outline = outlines_[boundary.outline[p]];
            const BoundaryPiece& piece = boundary.pieces[p];
            if (outline.count++ == 0) outline.first = p;
            const Vec2 origin = boundary.pieces[outline.first].a;
            outline.box.extend(piece.a);
            outline.area += 0.5 * cross(piece.a - origin, piece.b - origin);
        }
        for (Outline& outline : outlines_)
            outline.radius = std::sqrt(std::abs(outline.area) / std::numbers::pi);
    }

    std::uint32_t size() const { return static_cast<std::uint32_t>(outlines_.size()); }
    const Outline& operator[](std::uint32_t n) const { return outlines_[n]; }

    template <class Body>
    void each_piece(const Outline& outline, const Body& body) const {
        std::uint32_t at = outline.first;
        for (std::uint32_t n = 0; n < outline.count && at != no_piece; ++n, at = boundary_.next[at])
            body(n, boundary_.pieces[at]);
    }

    // Even-odd, by the ray in +x.
    bool contains(const Outline& outline, Vec2 q) const {
        bool inside = false;
        each_piece(outline, [&](std::uint32_t, const BoundaryPiece& piece) {
            const Vec2 a = piece.a, b = piece.b;
            if ((a.y > q.y) != (b.y > q.y) && q.x < a.x + (q.y - a.y) / (b.y - a.y) * (b.x - a.x))
                inside = !inside;
        });
        return inside;
    }

  private:
    const Boundary& boundary_;
    std::vector<Outline> outlines_;
};

enum class Share { none, some, all };

// So many points of an outline, evenly spread, say whether it lies within another one. [points; >= 8; B]
inline constexpr std::uint32_t points_asked = 32;

// How much of an outline lies within another, by some of its points.
inline Share share_within(const Outlines& in, const Outline& outline, const Outlines& others,
                          const Outline& other) {
    const std::uint32_t stride = outline.count / points_asked + 1;
    std::uint32_t asked = 0, within = 0;
    in.each_piece(outline, [&](std::uint32_t n, const BoundaryPiece& piece) {
        if (n % stride != 0) return;
        ++asked;
        within += others.contains(other, piece.a);
    });
    return within == 0 ? Share::none : within < asked ? Share::some : Share::all;
}

// Whether two are of one kind and their boxes have a common point.
inline bool are_near(const Outline& a, const Outline& b) {
    return (a.area > 0) == (b.area > 0) && a.box.low.x < b.box.high.x && b.box.low.x < a.box.high.x &&
           a.box.low.y < b.box.high.y && b.box.low.y < a.box.high.y;
}

}  // namespace anatomesh
