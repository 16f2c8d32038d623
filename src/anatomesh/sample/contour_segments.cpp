#include "anatomesh/sample/contour_segments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

// An end this near to another segment lies on it, in lengths of that segment: contours drawn on one grid
// touch to within the last digits of their files. The certificate's chains have the same tolerance.
// [lengths of the segment; 0 to 1e-3; D digits of files]
constexpr double touching = 1e-6;
// A subsegment is not split on a shell nearer to its ends. [its lengths; 0 to 0.5; M 2026-11, set not recorded]
constexpr double from_ends = 0.25;
// A foot is used only if the way to it is at least so steep (foot_on()). [1; 0 to 1; M 2026-11 16 structures of a head]
constexpr double least_slope_to_foot = 0.005;

// Whether a point this share of the way along s is no nearer than `distance` to its ends.
bool clear_of_ends(const Segment2& s, double share, double distance) {
    const double whole = length(s.b - s.a);
    return share * whole > distance && (1 - share) * whole > distance;
}

// Share of the way along s at which p lies on it, if it does.
bool lies_on(const Segment2& s, Vec2 p, double& share) {
    const Vec2 way = s.b - s.a;
    const double squared = dot(way, way);
    if (!(squared > 0)) return false;
    share = dot(p - s.a, way) / squared;
    return std::abs(cross(way, p - s.a)) <= touching * squared;
}

// Finds the contacts of the segments of one slice.
class SliceContacts {
  public:
    SliceContacts(const Plane& plane, const std::vector<ContourSegment>& segments,
                  std::vector<std::uint32_t> chosen, double clearance, std::vector<Vec3>& points,
                  std::vector<SegmentCut>& cuts)
        : plane_(plane),
          segments_(segments),
          chosen_(std::move(chosen)),
          clearance_(clearance),
          points_(points),
          cuts_(cuts) {}

    void find() {
        std::vector<Segment2> flat;
        for (const std::uint32_t s : chosen_) {
            flat.push_back(
                {plane_.to_plane(points_[segments_[s].a]), plane_.to_plane(points_[segments_[s].b])});
        }
        const SegmentIndex index(std::move(flat));
        index.for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            meet(chosen_[i], index.segments()[i], chosen_[j], index.segments()[j]);
            return true;
        });
    }

  private:
    void meet(std::uint32_t s, const Segment2& p, std::uint32_t t, const Segment2& q) {
        const ContourSegment &one = segments_[s], &other = segments_[t];
        bool touch = false;
        touch |= cut_at_end(s, p, q.a, other.a);
        touch |= cut_at_end(s, p, q.b, other.b);
        touch |= cut_at_end(t, q, p.a, one.a);
        touch |= cut_at_end(t, q, p.b, one.b);
        if (touch || one.a == other.a || one.a == other.b || one.b == other.a || one.b == other.b) return;
        if (orient2d(p.a, p.b, q.a) * orient2d(p.a, p.b, q.b) >= 0) return;
        if (orient2d(q.a, q.b, p.a) * orient2d(q.a, q.b, p.b) >= 0) return;
        const Vec2 u = p.b - p.a, v = q.b - q.a;
        const double area = cross(u, v);
        const double along = cross(q.a - p.a, v) / area, along_other = cross(q.a - p.a, u) / area;
        if (!clear_of_ends(p, along, clearance_) || !clear_of_ends(q, along_other, clearance_)) return;
        const auto point = static_cast<std::uint32_t>(points_.size());
        points_.push_back(points_[one.a] + along * (points_[one.b] - points_[one.a]));
        cuts_.push_back({s, along, point});
        cuts_.push_back({t, along_other, point});
    }

    bool cut_at_end(std::uint32_t segment, const Segment2& s, Vec2 end, std::uint32_t point) {
        double share = 0;
        if (point == segments_[segment].a || point == segments_[segment].b || !lies_on(s, end, share))
            return false;
        if (clear_of_ends(s, share, 0)) cuts_.push_back({segment, share, point});
        return true;
    }

    const Plane& plane_;
    const std::vector<ContourSegment>& segments_;
    std::vector<std::uint32_t> chosen_;
    double clearance_;
    std::vector<Vec3>& points_;
    std::vector<SegmentCut>& cuts_;
};

// Contours that run along each other are crossed by a third at one place, and vertices lie where others
// cross: one point, the first of them. Points from `before` on that no cut has any more go.
void unite_contacts(std::vector<SegmentCut>& cuts, std::size_t before, std::vector<Vec3>& points) {
    std::vector<std::uint32_t> first(points.size());
    std::iota(first.begin(), first.end(), 0u);
    const auto first_of = [&](std::uint32_t point) {
        while (first[point] != point) point = first[point];
        return point;
    };
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t n = 1; n < cuts.size(); ++n) {
        if (cuts[n].segment != cuts[n - 1].segment || cuts[n].share - cuts[n - 1].share > touching) continue;
        const std::uint32_t one = first_of(cuts[n - 1].point), other = first_of(cuts[n].point);
        first[std::max(one, other)] = std::min(one, other);
    }
    std::vector<std::uint32_t> now(points.size());
    auto kept = static_cast<std::uint32_t>(before);
    for (std::uint32_t p = 0; p < points.size(); ++p) {
        now[p] = first[p] != p ? now[first_of(p)] : p < before ? p : kept++;
        if (first[p] == p) points[now[p]] = points[p];
    }
    points.resize(kept);
    for (SegmentCut& cut : cuts) cut.point = now[cut.point];
    const auto repeats = [](const SegmentCut& x, const SegmentCut& y) {
        return x.segment == y.segment && x.point == y.point;
    };
    cuts.erase(std::unique(cuts.begin(), cuts.end(), repeats), cuts.end());
}

}  // namespace

std::vector<ContourSegment> distinct_segments(const ContourSet& contours,
                                              const std::vector<std::uint32_t>& vertices) {
    struct Drawn {
        std::uint32_t a, b, slice, structure;
        auto operator<=>(const Drawn&) const = default;
    };
    std::vector<Drawn> drawn;
    for (const Contour& contour : contours.contours) {
        for (std::uint32_t n = 0; n < contour.point_count; ++n) {
            const std::uint32_t a = vertices[contour.first_point + n];
            const std::uint32_t b = vertices[contour.first_point + (n + 1) % contour.point_count];
            if (a != b) drawn.push_back({std::min(a, b), std::max(a, b), contour.slice, contour.structure});
        }
    }
    std::sort(drawn.begin(), drawn.end());
    std::vector<ContourSegment> segments;
    for (const Drawn& d : drawn) {
        if (segments.empty() || segments.back().a != d.a || segments.back().b != d.b)
            segments.push_back({d.a, d.b, d.slice, {}});
        segments.back().structures.push_back(d.structure);
    }
    for (ContourSegment& segment : segments) {
        std::sort(segment.structures.begin(), segment.structures.end());
        segment.structures.erase(std::unique(segment.structures.begin(), segment.structures.end()),
                                 segment.structures.end());
    }
    return segments;
}

std::vector<SegmentCut> cuts_at_contacts(const ContourSet& contours,
                                         const std::vector<ContourSegment>& segments, double clearance_mm,
                                         std::vector<Vec3>& points) {
    std::vector<SegmentCut> cuts;
    if (contours.structures.size() < 2) return cuts;  // contours of one structure do not meet
    const std::size_t before = points.size();
    std::vector<std::vector<std::uint32_t>> by_slice(contours.slices.size());
    for (std::uint32_t s = 0; s < segments.size(); ++s) by_slice[segments[s].slice].push_back(s);
    for (std::uint32_t slice = 0; slice < by_slice.size(); ++slice) {
        SliceContacts(contours.slices[slice].plane, segments, std::move(by_slice[slice]), clearance_mm,
                      points, cuts)
            .find();
    }
    unite_contacts(cuts, before, points);
    return cuts;
}

std::vector<SegmentPart> parts_between(const std::vector<ContourSegment>& segments,
                                       const std::vector<SegmentCut>& cuts) {
    std::vector<SegmentPart> parts;
    auto cut = cuts.begin();
    for (std::uint32_t s = 0; s < segments.size(); ++s) {
        std::uint32_t from = segments[s].a;
        const auto add_to = [&](std::uint32_t to) {
            if (from == to) return;
            parts.push_back({segments[s], {s}});
            parts.back().segment.a = std::min(from, to);
            parts.back().segment.b = std::max(from, to);
            from = to;
        };
        for (; cut != cuts.end() && cut->segment == s; ++cut) add_to(cut->point);
        add_to(segments[s].b);
    }
    if (cuts.empty()) return parts;
    std::vector<std::uint32_t> order(parts.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto ends = [&](std::uint32_t n) { return std::pair{parts[n].segment.a, parts[n].segment.b}; };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t m, std::uint32_t n) { return ends(m) < ends(n); });
    for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
        for (last = first + 1; last < order.size() && ends(order[last]) == ends(order[first]); ++last) {
            SegmentPart &one = parts[order[first]], &other = parts[order[last]];
            std::vector<std::uint32_t> all;
            std::set_union(one.segment.structures.begin(), one.segment.structures.end(),
                           other.segment.structures.begin(), other.segment.structures.end(),
                           std::back_inserter(all));
            one.segment.structures = std::move(all);
            one.of.insert(one.of.end(), other.of.begin(), other.of.end());
            other.of.clear();
        }
    }
    std::erase_if(parts, [](const SegmentPart& part) { return part.of.empty(); });
    return parts;
}

std::vector<std::uint32_t> acute_vertices(std::span<const Vec3> points,
                                          const std::vector<Subsegment>& subsegments) {
    std::vector<std::array<std::uint32_t, 2>> ways;
    for (const Subsegment& subsegment : subsegments) {
        ways.push_back({subsegment.a, subsegment.b});
        ways.push_back({subsegment.b, subsegment.a});
    }
    std::sort(ways.begin(), ways.end());
    ways.erase(std::unique(ways.begin(), ways.end()), ways.end());
    std::vector<std::uint32_t> found;
    for (auto first = ways.begin(); first != ways.end();) {
        const std::uint32_t v = (*first)[0];
        const auto last = std::find_if(first, ways.end(), [&](const auto& way) { return way[0] != v; });
        const auto direction = [&](auto way) { return points[(*way)[1]] - points[v]; };
        bool acute = false;
        for (auto p = first; p != last; ++p) {
            for (auto q = first; q != p; ++q) acute = acute || dot(direction(p), direction(q)) > 0;
        }
        if (acute) found.push_back(v);
        first = last;
    }
    return found;
}

Vec3 split_point(std::span<const Vec3> points, const Subsegment& subsegment,
                 std::span<const std::uint32_t> acute) {
    const Vec3 a = points[subsegment.a], b = points[subsegment.b];
    const bool at_a = std::binary_search(acute.begin(), acute.end(), subsegment.a);
    if (at_a == std::binary_search(acute.begin(), acute.end(), subsegment.b)) return 0.5 * (a + b);
    const double span = length(b - a);
    const double share = std::exp2(std::floor(std::log2(span * 2 / 3))) / span;
    return at_a ? a + share * (b - a) : b + share * (a - b);
}

Vec3 shell_point(std::span<const Vec3> points, const Subsegment& subsegment, Vec3 apex) {
    const bool outward =
        squared_length(points[subsegment.a] - apex) < squared_length(points[subsegment.b] - apex);
    const Vec3 a = points[outward ? subsegment.a : subsegment.b],
               b = points[outward ? subsegment.b : subsegment.a];
    const double at_a = length(a - apex), at_b = length(b - apex);
    const double low = at_a + from_ends * (at_b - at_a), high = at_b - from_ends * (at_b - at_a);
    double unit = std::exp2(std::ceil(std::log2(high)));
    while (std::floor(high / unit) * unit < low) unit /= 2;
    const double shell = std::floor(high / unit) * unit;
    // The greater root of |a + t way - apex| = shell.
    const Vec3 way = b - a;
    const double slope = dot(way, a - apex), square = squared_length(way);
    const double rest = (shell - at_a) * (shell + at_a);
    return a + (rest / (slope + std::sqrt(slope * slope + square * rest))) * way;
}

std::optional<Vec3> foot_on(std::span<const Vec3> points, const Subsegment& subsegment, Vec3 p) {
    const Vec3 a = points[subsegment.a], b = points[subsegment.b], way = b - a;
    const Vec3 foot = a + (dot(p - a, way) / squared_length(way)) * way;
    const double shorter = std::min(length(foot - a), length(b - foot));
    if (length(p - foot) < least_slope_to_foot * shorter) return std::nullopt;
    return foot;
}

}  // namespace anatomesh
