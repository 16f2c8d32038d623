#include "anatomesh/improve/reroute/routed_contours.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/contour/overlay/even_odd_area.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/improve/reroute/contour_loop.h"

namespace anatomesh {

namespace {

struct DrawnRing {
    std::uint32_t structure = 0;
    std::vector<Vec3> points;
    std::vector<std::uint32_t> vertices;

    // Begins it at its smallest point.
    void turn() {
        const auto less = [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); };
        const std::ptrdiff_t first = std::min_element(points.begin(), points.end(), less) - points.begin();
        std::rotate(points.begin(), points.begin() + first, points.end());
        std::rotate(vertices.begin(), vertices.begin() + first, vertices.end());
    }
};

}  // namespace

ContoursOfMesh route_contours(const ContourSet& set, std::span<const std::uint32_t> vertex_of,
                              std::span<const RoutedContour> routed, std::span<const Vec3> points) {
    assert(vertex_of.size() == set.points.size());
    ContoursOfMesh result{set, {}};
    if (routed.empty()) {
        result.vertices.assign(vertex_of.begin(), vertex_of.end());
        return result;
    }
    result.contours.points.clear();
    result.contours.contours.clear();
    auto next = routed.begin();
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        std::vector<DrawnRing> rings;
        const Slice& slice = set.slices[s];
        for (std::uint32_t c = slice.first_contour; c < slice.first_contour + slice.contour_count; ++c) {
            const Contour& contour = set.contours[c];
            DrawnRing& ring = rings.emplace_back();
            ring.structure = contour.structure;
            if (next != routed.end() && next->contour == c) {
                ring.vertices = next->vertices;
                for (const std::uint32_t v : ring.vertices) ring.points.push_back(points[v]);
                ring.turn();
                ++next;
                continue;
            }
            const std::span<const Vec3> drawn = set.points_of(contour);
            ring.points.assign(drawn.begin(), drawn.end());
            const auto first = vertex_of.begin() + contour.first_point;
            ring.vertices.assign(first, first + contour.point_count);
        }
        std::stable_sort(rings.begin(), rings.end(), [](const DrawnRing& a, const DrawnRing& b) {
            if (a.structure != b.structure) return a.structure < b.structure;
            return lexicographic_less(a.points.front(), b.points.front());
        });
        for (const DrawnRing& ring : rings) {
            const auto first = static_cast<std::uint32_t>(result.contours.points.size());
            result.contours.contours.push_back(
                {ring.structure, s, first, static_cast<std::uint32_t>(ring.points.size())});
            result.contours.points.insert(result.contours.points.end(), ring.points.begin(),
                                          ring.points.end());
            result.vertices.insert(result.vertices.end(), ring.vertices.begin(), ring.vertices.end());
        }
    }
    assert(next == routed.end());
    return result;
}

void drop_unsound(const ContourSet& set, std::vector<RoutedContour>& routed, std::span<const Vec3> points) {
    const std::vector<RoutedContour> all = routed;
    for (auto first = all.begin(); first != all.end();) {
        const std::uint32_t s = set.contours[first->contour].slice;
        const auto last =
            std::find_if(first, all.end(), [&](const auto& f) { return set.contours[f.contour].slice != s; });
        const Slice& slice = set.slices[s];
        std::vector<const RoutedContour*> rerouted(slice.contour_count, nullptr);
        for (auto f = first; f != last; ++f) rerouted[f->contour - slice.first_contour] = &*f;
        // Each time one at least stays as it is drawn.
        for (bool sound = false; !sound;) {
            std::vector<PlaneRing> rings = plane_rings(set, slice);
            for (std::size_t n = 0; n < rerouted.size(); ++n) {
                if (rerouted[n] == nullptr) continue;
                rings[n].at.clear();
                for (const std::uint32_t v : rerouted[n]->vertices)
                    rings[n].at.push_back(slice.plane.to_plane(points[v]));
            }
            const std::vector<RingSegment> faults = slice_faults(rings, set.exclusive);
            sound = faults.empty();
            bool any = false;
            for (const RingSegment& fault : faults)
                any |= std::exchange(rerouted[fault.ring], nullptr) != nullptr;
            // Those that are as drawn are at fault with others.
            if (!sound && !any) {
                sound = std::all_of(rerouted.begin(), rerouted.end(),
                                    [](const auto* one) { return one == nullptr; });
                std::fill(rerouted.begin(), rerouted.end(), nullptr);
            }
        }
        std::erase_if(routed, [&](const RoutedContour& f) {
            return set.contours[f.contour].slice == s && rerouted[f.contour - slice.first_contour] == nullptr;
        });
        first = last;
    }
}

std::vector<std::uint8_t> kept_vertices(const ContourSet& set, std::span<const std::uint32_t> vertex_of,
                                        std::span<const RoutedContour> routed, std::size_t vertex_count) {
    std::vector<std::uint8_t> kept(vertex_count, 0);
    auto next = routed.begin();
    for (std::uint32_t c = 0; c < set.contours.size(); ++c) {
        const bool is_routed = next != routed.end() && next->contour == c;
        const Contour& contour = set.contours[c];
        for (const std::uint32_t v : is_routed ? std::span<const std::uint32_t>(next->vertices)
                                               : vertex_of.subspan(contour.first_point, contour.point_count))
            kept[v] = 1;
        next += is_routed;
    }
    return kept;
}

namespace {

constexpr int parts = 16;  // of a segment, to measure distances between [parts; > 0; B]

// Places in the ring that is drawn, and in that which was re-routed, between two vertices that both have;
// these included.
struct Stretch {
    std::vector<std::size_t> drawn, rerouted;

    bool is_same_segment() const { return drawn.size() == 2 && rerouted.size() == 2; }
};

// From one common vertex to the next, if they come in one order; else, and where there are none, the whole
// rings as one, closed.
std::vector<Stretch> stretches_of(std::span<const std::uint32_t> drawn,
                                  std::span<const std::uint32_t> rerouted) {
    std::unordered_map<std::uint32_t, std::size_t> place_in_rerouted;
    for (std::size_t n = 0; n < rerouted.size(); ++n) place_in_rerouted[rerouted[n]] = n;
    std::vector<std::array<std::size_t, 2>> common;  // places in both, from the first
    for (std::size_t n = 0; n < drawn.size(); ++n) {
        if (const auto found = place_in_rerouted.find(drawn[n]); found != place_in_rerouted.end())
            common.push_back({n, found->second});
    }
    bool in_order = !common.empty();
    for (std::size_t k = 0; k < common.size(); ++k) {
        const auto after = [&](std::size_t n) {
            return (common[n % common.size()][1] + rerouted.size() - common[0][1]) % rerouted.size();
        };
        in_order = in_order && (k + 1 == common.size() || after(k) < after(k + 1));
    }
    if (!in_order) common = {{0, 0}};
    const auto between = [](std::size_t size, std::size_t from, std::size_t to) {
        std::vector<std::size_t> row{from};
        do row.push_back((row.back() + 1) % size);
        while (row.back() != to);
        return row;
    };
    std::vector<Stretch> stretches;
    for (std::size_t k = 0; k < common.size(); ++k) {
        const auto [d, l] = common[k];
        const auto [next_d, next_l] = common[(k + 1) % common.size()];
        stretches.push_back({between(drawn.size(), d, next_d), between(rerouted.size(), l, next_l)});
    }
    return stretches;
}

// Of the segments of a row from another one.
double farthest(const std::vector<Vec3>& row, const std::vector<Vec3>& other) {
    double most = 0;
    for (std::size_t n = 1; n < row.size(); ++n) {
        for (int k = 0; k < parts; ++k) {
            const Vec3 p = row[n - 1] + static_cast<double>(k) / parts * (row[n] - row[n - 1]);
            most = std::max(most, length(p - nearest_on_row(other, p)));
        }
    }
    return most;
}

void add_segments(const std::vector<Vec3>& row, const Plane& plane, std::vector<Segment2>& segments,
                  Box2& box) {
    for (std::size_t n = 1; n < row.size(); ++n) {
        segments.push_back({plane.to_plane(row[n - 1]), plane.to_plane(row[n])});
        box.extend(segments.back().a);
        box.extend(segments.back().b);
    }
}

}  // namespace

std::vector<RoutedContourReport> routed_contour_reports(const ContourSet& set,
                                                        std::span<const std::uint32_t> vertex_of,
                                                        std::span<const RoutedContour> routed,
                                                        std::span<const Vec3> points) {
    std::vector<RoutedContourReport> reports;
    for (const RoutedContour& one : routed) {
        const Contour& contour = set.contours[one.contour];
        const Slice& slice = set.slices[contour.slice];
        const Structure& structure = set.structures[contour.structure];
        RoutedContourReport& report = reports.emplace_back();
        report.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
        report.slice = slice.name.empty() ? std::to_string(contour.slice) : slice.name;
        report.segments = one.segments;
        const auto drawn = vertex_of.subspan(contour.first_point, contour.point_count);
        std::vector<std::uint32_t> now = one.vertices;
        sort_distinct(now);
        for (const std::uint32_t v : drawn)
            report.vertices_left += !std::binary_search(now.begin(), now.end(), v);
        // What lies in one of the two alone is within an odd number of both, and of where they differ.
        std::vector<Segment2> segments;
        Box2 box;
        for (const Stretch& stretch : stretches_of(drawn, one.vertices)) {
            if (stretch.is_same_segment()) continue;
            std::vector<Vec3> was, is;
            for (const std::size_t n : stretch.drawn) was.push_back(set.points_of(contour)[n]);
            for (const std::size_t n : stretch.rerouted) is.push_back(points[one.vertices[n]]);
            report.farthest_mm = std::max({report.farthest_mm, farthest(was, is), farthest(is, was)});
            add_segments(was, slice.plane, segments, box);
            add_segments(is, slice.plane, segments, box);
        }
        report.difference_mm2 = even_odd_area(std::move(segments), box);
    }
    return reports;
}

}  // namespace anatomesh
