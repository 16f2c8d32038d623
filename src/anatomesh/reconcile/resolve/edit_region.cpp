#include "anatomesh/reconcile/resolve/edit_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "anatomesh/contour/overlay/arrangement.h"
#include "anatomesh/contour/overlay/boundary_loops.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/point_triangle.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/reconcile/move/contour_graph.h"

namespace anatomesh {

namespace {

bool less(Vec3 a, Vec3 b) {
    return lexicographic_less(a, b);
}

// A segment without direction.
using SegmentKey = std::array<Vec3, 2>;
SegmentKey key_of(Vec3 a, Vec3 b) {
    return less(b, a) ? SegmentKey{b, a} : SegmentKey{a, b};
}
bool key_less(const SegmentKey& p, const SegmentKey& q) {
    return p[0] != q[0] ? less(p[0], q[0]) : less(p[1], q[1]);
}

// A place that is put into a segment.
struct CutPoint {
    SegmentKey segment;
    Vec3 at;
};

// Sorts by segment, and along it.
std::vector<CutPoint> in_order(std::vector<CutPoint> all) {
    std::sort(all.begin(), all.end(), [](const CutPoint& p, const CutPoint& q) {
        if (p.segment != q.segment) return key_less(p.segment, q.segment);
        return squared_length(p.at - p.segment[0]) < squared_length(q.at - q.segment[0]);
    });
    all.erase(std::unique(all.begin(), all.end(),
                          [](const CutPoint& p, const CutPoint& q) {
                              return p.segment == q.segment && p.at == q.at;
                          }),
              all.end());
    return all;
}

std::vector<CutPoint> to_put_in(const ContourSet& set, std::span<const IntervalEndpoint> places) {
    std::vector<CutPoint> all;
    for (const IntervalEndpoint& place : places) {
        if (place.from == place.to) continue;
        const SegmentKey segment = key_of(set.points[place.from], set.points[place.to]);
        if (place.at != segment[0] && place.at != segment[1]) all.push_back({segment, place.at});
    }
    return in_order(std::move(all));
}

std::vector<Vec3> with_places(const ContourSet& set, const Contour& contour,
                              const std::vector<CutPoint>& all) {
    std::vector<Vec3> points;
    for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
        const Vec3 from = set.points[k], to = set.points[point_after(contour, k)];
        points.push_back(from);
        const auto [first, last] = std::equal_range(
            all.begin(), all.end(), CutPoint{key_of(from, to), {}},
            [](const CutPoint& p, const CutPoint& q) { return key_less(p.segment, q.segment); });
        const auto begin = static_cast<std::ptrdiff_t>(points.size());
        for (auto put = first; put != last; ++put) points.push_back(put->at);
        if (less(to, from)) std::reverse(points.begin() + begin, points.end());
    }
    return points;
}

// Holds the contours of a slice and the edited regions as a plane graph, and says to whom each face
// belongs after the edit.
class EditedFaces {
  public:
    EditedFaces(const ContourSet& set, const RegionEdit& edit) : set_(set), edit_(edit) {}

    bool arrange_rings() {
        const Slice& slice = set_.slices[edit_.slice];
        const std::vector<CutPoint> put = to_put_in(set_, edit_.places);
        std::vector<Ring> rings;
        for (const Contour& contour : set_.contours_of(slice)) {
            if (!is_edited(contour.structure)) continue;
            rings.push_back(make_ring(with_places(set_, contour, put), slice.plane,
                                      static_cast<std::uint32_t>(rings.size())));
            structures_.push_back(contour.structure);
        }
        for (const std::vector<Vec3>& region : edit_.regions)
            rings.push_back(make_ring(region, slice.plane, static_cast<std::uint32_t>(rings.size())));
        graph_ = arrange(rings, slice.plane, most_arrangement_edges);
        return graph_.has_value();
    }

    bool is_edited(std::uint32_t structure) const { return set_.exclusive || structure == edit_.structure; }

    // Returns where segments of the contours were cut, for others that have the same segments.
    std::vector<CutPoint> cuts() const {
        std::vector<CutPoint> all;
        std::size_t ring = 0;
        for (const Contour& contour : set_.contours_of(set_.slices[edit_.slice])) {
            if (!is_edited(contour.structure)) continue;
            const std::vector<std::uint32_t>& cycle = graph_->cycles[ring++];
            const auto points = set_.points_of(contour);
            std::vector<CutPoint> of_ring;
            std::size_t last = points.size() - 1;  // of the contour's points, the one passed last
            for (const std::uint32_t vertex : cycle) {
                const Vec3 at = graph_->points[vertex];
                if (at == points[(last + 1) % points.size()]) {
                    last = (last + 1) % points.size();
                } else {
                    of_ring.push_back({key_of(points[last], points[(last + 1) % points.size()]), at});
                }
            }
            // A crossing may have taken the place of a point, which then is no cut.
            if (last + 1 == points.size()) all.insert(all.end(), of_ring.begin(), of_ring.end());
        }
        return in_order(std::move(all));
    }

    // Returns the rings that bound what a structure has after the edit.
    std::vector<std::vector<Vec3>> rings_of(std::uint32_t structure) const {
        std::vector<bool> has;
        for (const Winding& winding : graph_->windings) has.push_back(comes_to_have(winding, structure));
        std::vector<BoundaryEdge> boundary;
        for (const Arrangement::Edge& edge : graph_->edges) {
            if (has[edge.left] == has[edge.right]) continue;
            boundary.push_back(has[edge.left] ? BoundaryEdge{edge.a, edge.b} : BoundaryEdge{edge.b, edge.a});
        }
        std::sort(boundary.begin(), boundary.end(), [](const BoundaryEdge& p, const BoundaryEdge& q) {
            return p.from != q.from ? p.from < q.from : p.to < q.to;
        });
        std::vector<std::vector<Vec3>> rings;
        for (const std::vector<std::uint32_t>& loop : boundary_loops(graph_->at, boundary)) {
            std::vector<Vec2> at;
            for (const std::uint32_t edge : loop) at.push_back(graph_->at[boundary[edge].from]);
            if (2 * std::abs(signed_area(at)) <= sliver_width_mm * perimeter(at)) continue;
            std::vector<Vec3> points;
            for (const std::uint32_t edge : loop) points.push_back(graph_->points[boundary[edge].from]);
            rings.push_back(std::move(points));
        }
        return rings;
    }

  private:
    // By the even-odd rule a hole takes away what the contour around it draws.
    bool comes_to_have(const Winding& winding, std::uint32_t structure) const {
        bool has = false;
        for (const RingTurns& turns : winding) {
            if (turns.turns % 2 == 0) continue;
            if (turns.ring >= structures_.size()) return structure == edit_.structure && edit_.inside;
            has ^= structures_[turns.ring] == structure;
        }
        return has;
    }

    const ContourSet& set_;
    const RegionEdit& edit_;
    std::vector<std::uint32_t> structures_;  // per contour's ring; the regions' come after these
    std::optional<Arrangement> graph_;
};

// Returns the segments of a structure's contours on a slice, sorted.
std::vector<SegmentKey> segments_of(const ContourSet& set, const Slice& slice, std::uint32_t structure) {
    std::vector<SegmentKey> segments;
    for (const Contour& contour : set.contours_of(slice)) {
        if (contour.structure != structure) continue;
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k)
            segments.push_back(key_of(set.points[k], set.points[point_after(contour, k)]));
    }
    std::sort(segments.begin(), segments.end(), key_less);
    return segments;
}

std::vector<SegmentKey> segments_of(std::span<const EditedRing> rings, std::uint32_t structure) {
    std::vector<SegmentKey> segments;
    for (const EditedRing& ring : rings) {
        if (ring.structure != structure) continue;
        for (std::size_t n = 0; n < ring.points.size(); ++n)
            segments.push_back(key_of(ring.points[n], ring.points[(n + 1) % ring.points.size()]));
    }
    std::sort(segments.begin(), segments.end(), key_less);
    return segments;
}

bool has(const std::vector<SegmentKey>& sorted, const SegmentKey& key) {
    return std::binary_search(sorted.begin(), sorted.end(), key, key_less);
}

// Returns the largest distance from segments that only the first has to the nearest one of the second.
double farthest_from(const std::vector<SegmentKey>& own, const std::vector<SegmentKey>& other) {
    double farthest = 0;
    for (const SegmentKey& segment : own) {
        if (has(other, segment)) continue;
        for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
            const Vec3 p = segment[0] + share * (segment[1] - segment[0]);
            double nearest = std::numeric_limits<double>::infinity();
            for (const SegmentKey& s : other)
                nearest = std::min(nearest, point_segment_distance(p, s[0], s[1]));
            farthest = std::max(farthest, nearest);
        }
    }
    return farthest;
}

bool is_sound(const ContourSet& set, const Slice& slice, std::span<const EditedRing> rings) {
    std::vector<PlaneRing> all;
    for (const EditedRing& ring : rings) {
        PlaneRing one{ring.structure, {}};
        for (const Vec3& p : ring.points) one.at.push_back(slice.plane.to_plane(p));
        all.push_back(std::move(one));
    }
    return slice_faults(all, set.exclusive).empty();
}

}  // namespace

std::optional<std::vector<EditedRing>> edit_region(const ContourSet& set, const RegionEdit& edit) {
    const Slice& slice = set.slices[edit.slice];
    EditedFaces canvas(set, edit);
    if (!canvas.arrange_rings()) return std::nullopt;
    const std::vector<CutPoint> cuts = canvas.cuts();
    std::vector<EditedRing> rings;
    for (std::uint32_t structure = 0; structure < set.structures.size(); ++structure) {
        if (canvas.is_edited(structure)) {
            const std::vector<SegmentKey> before = segments_of(set, slice, structure);
            for (std::vector<Vec3>& points : canvas.rings_of(structure)) {
                EditedRing ring{structure, std::move(points), false};
                for (const SegmentKey& segment : segments_of({&ring, 1}, structure)) {
                    if (has(before, segment)) continue;
                    ring.is_new = true;
                    if (length(segment[1] - segment[0]) < sliver_width_mm) return std::nullopt;
                }
                rings.push_back(std::move(ring));
            }
            continue;
        }
        for (const Contour& contour : set.contours_of(slice)) {
            if (contour.structure != structure) continue;
            rings.push_back({structure, with_places(set, contour, cuts), false});
        }
    }
    if (!is_sound(set, slice, rings)) return std::nullopt;
    return rings;
}

double farthest_change(const ContourSet& set, std::uint32_t slice, std::span<const EditedRing> rings) {
    double farthest = 0;
    for (std::uint32_t structure = 0; structure < set.structures.size(); ++structure) {
        const std::vector<SegmentKey> before = segments_of(set, set.slices[slice], structure),
                                      after = segments_of(rings, structure);
        farthest = std::max({farthest, farthest_from(before, after), farthest_from(after, before)});
    }
    return farthest;
}

ContourSet with_edited(const ContourSet& set, std::uint32_t slice, std::span<const EditedRing> rings) {
    ContourSet result = set;
    result.contours.clear();
    result.points.clear();
    const auto add = [&](std::uint32_t structure, std::uint32_t number, std::span<const Vec3> points) {
        result.contours.push_back({structure, number, static_cast<std::uint32_t>(result.points.size()),
                                   static_cast<std::uint32_t>(points.size())});
        result.points.insert(result.points.end(), points.begin(), points.end());
    };
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        Slice& now = result.slices[s];
        now.first_contour = static_cast<std::uint32_t>(result.contours.size());
        if (s == slice) {
            for (const EditedRing& ring : rings) add(ring.structure, s, ring.points);
        } else {
            for (const Contour& contour : set.contours_of(set.slices[s]))
                add(contour.structure, s, set.points_of(contour));
        }
        now.contour_count = static_cast<std::uint32_t>(result.contours.size()) - now.first_contour;
    }
    return result;
}

}  // namespace anatomesh
