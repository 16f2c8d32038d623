#include "anatomesh/measure/slice_sections.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "anatomesh/contour/overlay/even_odd_area.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/mesh/model/box_tree.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

namespace {

// A vertex this near to a plane lies on it. [diagonals of the contours' box; 0 to 1e-6; D rounding of doubles]
constexpr double on_plane_share = 1e-9;

// The triangles of a surface that may meet a plane, found without the others.
class TrianglesAtPlanes {
  public:
    TrianglesAtPlanes(std::span<const Vec3> points, const std::vector<Triangle>& triangles)
        : triangles_(triangles), tree_(make_box_tree(points, triangles)) {}

    // Calls visit(triangle) for those nearer to the plane than `distance`, and for a few more.
    template <class Visit>
    void for_each_near(const Plane& plane, double distance, const Visit& visit) {
        if (!tree_.nodes.empty()) waiting_.push_back(0);
        while (!waiting_.empty()) {
            const BoxTree::Node& node = tree_.nodes[waiting_.back()];
            waiting_.pop_back();
            const Vec3 half = 0.5 * (node.box.high - node.box.low), n = plane.normal;
            const double reach = std::abs(n.x) * half.x + std::abs(n.y) * half.y + std::abs(n.z) * half.z;
            if (std::abs(plane.signed_distance(node.box.low + half)) > (1 + 1e-9) * reach + distance)
                continue;
            if (node.count == 0) {
                waiting_.insert(waiting_.end(), {node.first, node.first + 1});
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                visit(triangles_[tree_.order[i]]);
        }
    }

  private:
    const std::vector<Triangle>& triangles_;
    BoxTree tree_;
    std::vector<std::uint32_t> waiting_;
};

}  // namespace

double on_plane_mm(const ContourSet& contours) {
    const Box3 box = contours.box();
    return on_plane_share * length(box.high - box.low);
}

namespace {

// Kept contours may lie a little off their slice's plane, and with them the vertices on their segments.
double farthest_off_plane(const ContourSet& contours, const Slice& slice) {
    double farthest = 0;
    for (const Contour& contour : contours.contours_of(slice)) {
        for (const Vec3& p : contours.points_of(contour))
            farthest = std::max(farthest, std::abs(slice.plane.signed_distance(p)));
    }
    return farthest;
}

// The boundary of one cross-section, as segments of the plane. Two that are equal cancel: the area between is what is
// wanted.
class SectionBoundary {
  public:
    SectionBoundary(std::span<const Vec3> points, const Plane& plane, double tolerance,
                    const std::vector<std::uint8_t>& drawn_here)
        : points_(points), plane_(plane), tolerance_(tolerance), drawn_here_(drawn_here) {}

    // The solid is cut just above the plane, and facets in the plane with the solid below are added.
    void add(const Triangle& t) {
        std::array<int, 3> side{};
        for (std::size_t i = 0; i < 3; ++i) side[i] = side_of(t[i]);
        if (side[0] == 0 && side[1] == 0 && side[2] == 0) {
            const Vec3 a = points_[t[0]];
            if (dot(cross(points_[t[1]] - a, points_[t[2]] - a), plane_.normal) <= 0) return;
            for (std::size_t i = 0; i < 3; ++i) add(at(t[i]), at(t[(i + 1) % 3]));
            return;
        }
        std::array<Vec2, 2> ends;
        int count = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3;
            if ((side[i] > 0) == (side[j] > 0)) continue;
            if (side[i] == 0 || side[j] == 0) {
                ends[static_cast<std::size_t>(count++)] = at(side[i] == 0 ? t[i] : t[j]);
            } else {
                ends[static_cast<std::size_t>(count++)] =
                    crossing(std::min(t[i], t[j]), std::max(t[i], t[j]));
            }
        }
        if (count == 2) add(ends[0], ends[1]);
    }

    void add(Vec2 a, Vec2 b) {
        if (a == b) return;
        if (lexicographic_less(b, a)) std::swap(a, b);
        segments_.push_back({a, b});
    }

    // What does not cancel.
    std::vector<Segment2> rest() {
        const auto less = [](const Segment2& s, const Segment2& t) {
            return s.a == t.a ? lexicographic_less(s.b, t.b) : lexicographic_less(s.a, t.a);
        };
        std::sort(segments_.begin(), segments_.end(), less);
        std::vector<Segment2> rest;
        for (const Segment2& s : segments_) {
            if (!rest.empty() && rest.back().a == s.a && rest.back().b == s.b) {
                rest.pop_back();
            } else {
                rest.push_back(s);
            }
        }
        return rest;
    }

  private:
    int side_of(std::uint32_t v) const {
        if (drawn_here_[v]) return 0;
        const double height = plane_.signed_distance(points_[v]);
        return std::abs(height) <= tolerance_ ? 0 : height > 0 ? 1 : -1;
    }
    Vec2 at(std::uint32_t v) const { return plane_.to_plane(points_[v]); }
    Vec2 crossing(std::uint32_t a, std::uint32_t b) const {
        const double below = plane_.signed_distance(points_[a]), above = plane_.signed_distance(points_[b]);
        return plane_.to_plane(points_[a] + below / (below - above) * (points_[b] - points_[a]));
    }

    std::span<const Vec3> points_;
    const Plane& plane_;
    double tolerance_;
    const std::vector<std::uint8_t>& drawn_here_;
    std::vector<Segment2> segments_;
};

}  // namespace

std::vector<SliceSection> slice_sections(std::span<const Vec3> points,
                                         std::span<const std::vector<Triangle>> surfaces,
                                         const ContourSet& contours, const SliceCoverage& coverage,
                                         std::span<const std::uint32_t> vertex_of) {
    assert(surfaces.size() == contours.structures.size() && vertex_of.size() == contours.points.size());
    std::vector<SliceSection> sections;
    if (contours.slices.empty()) return sections;
    const double tolerance = on_plane_mm(contours);
    const bool parallel = all_parallel(contours, exactly_parallel_mm);
    const std::vector<Box2> frames = parallel ? std::vector<Box2>() : frames_of_slices(contours);
    std::vector<std::uint8_t> drawn_here(points.size(), 0);
    for (std::uint32_t s = 0; s < surfaces.size(); ++s) {
        TrianglesAtPlanes surface(points, surfaces[s]);
        for (std::uint32_t k = 0; k < contours.slices.size(); ++k) {
            const Slice& slice = contours.slices[k];
            const double off_plane = farthest_off_plane(contours, slice) + tolerance;
            SectionBoundary boundary(points, slice.plane, off_plane, drawn_here);
            SliceSection measured{s, k, 0, 0};
            // A box of this half width lies around everything that coordinates can reach. [mm; > 1e7; D]
            constexpr double far = 1e12;
            const Box2 extent = parallel ? Box2{{-far, -far}, {far, far}} : frames[k];
            bool drawn = false;
            const auto mark = [&](std::uint8_t value) {
                for (const Contour& contour : contours.contours_of(slice)) {
                    if (contour.structure != s) continue;
                    for (std::uint32_t n = 0; n < contour.point_count; ++n) {
                        if (const std::uint32_t v = vertex_of[contour.first_point + n]; v != no_cell)
                            drawn_here[v] = value;
                    }
                }
            };
            mark(1);
            for (const Contour& contour : contours.contours_of(slice)) {
                std::vector<Vec2> ring;
                for (const Vec3& p : contours.points_of(contour)) {
                    ring.push_back(slice.plane.to_plane(p));
                }
                if (contour.structure != s) continue;
                drawn = true;
                measured.drawn += signed_area(ring);
                for (std::size_t n = 0; n < ring.size(); ++n)
                    boundary.add(ring[n], ring[(n + 1) % ring.size()]);
            }
            if (drawn || ((parallel || slice.contour_count > 0) && coverage.is_certain(k, s))) {
                // Twice what counts as on the plane, for rounding.
                surface.for_each_near(slice.plane, 2 * off_plane,
                                      [&](const Triangle& t) { boundary.add(t); });
                measured.difference = even_odd_area(boundary.rest(), extent);
                sections.push_back(measured);
            }
            mark(0);
        }
    }
    return sections;
}

}  // namespace anatomesh
