#include "anatomesh/pipeline/followed_contours.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <string>

#include "anatomesh/measure/even_odd_area.h"

namespace anatomesh {

namespace {

struct Ring {
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

ContoursOfMesh follow_contours(const ContourSet& set, std::span<const std::uint32_t> vertex_of,
                               std::span<const FollowedContour> followed, std::span<const Vec3> points) {
    assert(vertex_of.size() == set.points.size());
    ContoursOfMesh result{set, {}};
    if (followed.empty()) {
        result.vertices.assign(vertex_of.begin(), vertex_of.end());
        return result;
    }
    result.contours.points.clear();
    result.contours.contours.clear();
    auto next = followed.begin();
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        std::vector<Ring> rings;
        const Slice& slice = set.slices[s];
        for (std::uint32_t c = slice.first_contour; c < slice.first_contour + slice.contour_count; ++c) {
            const Contour& contour = set.contours[c];
            Ring& ring = rings.emplace_back();
            ring.structure = contour.structure;
            if (next != followed.end() && next->contour == c) {
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
        std::stable_sort(rings.begin(), rings.end(), [](const Ring& a, const Ring& b) {
            if (a.structure != b.structure) return a.structure < b.structure;
            return lexicographic_less(a.points.front(), b.points.front());
        });
        for (const Ring& ring : rings) {
            const auto first = static_cast<std::uint32_t>(result.contours.points.size());
            result.contours.contours.push_back(
                {ring.structure, s, first, static_cast<std::uint32_t>(ring.points.size())});
            result.contours.points.insert(result.contours.points.end(), ring.points.begin(),
                                          ring.points.end());
            result.vertices.insert(result.vertices.end(), ring.vertices.begin(), ring.vertices.end());
        }
    }
    assert(next == followed.end());
    return result;
}

std::vector<std::uint8_t> kept_vertices(const ContourSet& set, std::span<const std::uint32_t> vertex_of,
                                        std::span<const FollowedContour> followed, std::size_t vertex_count) {
    std::vector<std::uint8_t> kept(vertex_count, 0);
    auto next = followed.begin();
    for (std::uint32_t c = 0; c < set.contours.size(); ++c) {
        const bool is_followed = next != followed.end() && next->contour == c;
        const Contour& contour = set.contours[c];
        for (const std::uint32_t v :
             is_followed ? std::span<const std::uint32_t>(next->vertices)
                         : vertex_of.subspan(contour.first_point, contour.point_count))
            kept[v] = 1;
        next += is_followed;
    }
    return kept;
}

std::vector<FollowedContourReport> followed_contours(const ContourSet& set,
                                                     std::span<const FollowedContour> followed,
                                                     std::span<const Vec3> points) {
    std::vector<FollowedContourReport> reports;
    for (const FollowedContour& one : followed) {
        const Contour& contour = set.contours[one.contour];
        const Slice& slice = set.slices[contour.slice];
        // What lies in one of the two alone is within an odd number of both.
        std::vector<Segment2> segments;
        Box2 clip;
        const auto add = [&](const auto& place, std::size_t count) {
            for (std::size_t n = 0; n < count; ++n) {
                const Vec2 a = slice.plane.to_plane(place(n)),
                           b = slice.plane.to_plane(place((n + 1) % count));
                segments.push_back({a, b});
                clip.extend(a);
            }
        };
        const std::span<const Vec3> drawn = set.points_of(contour);
        add([&](std::size_t n) { return drawn[n]; }, drawn.size());
        add([&](std::size_t n) { return points[one.vertices[n]]; }, one.vertices.size());
        const Structure& structure = set.structures[contour.structure];
        reports.push_back({structure.name.empty() ? std::to_string(structure.number) : structure.name,
                           slice.name.empty() ? std::to_string(contour.slice) : slice.name, one.segments,
                           one.farthest_mm, even_odd_area(std::move(segments), clip)});
    }
    return reports;
}

}  // namespace anatomesh
