#include "anatomesh/outliers/section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// So many vertices stand for a loop. [points; >= 4; B]
constexpr std::size_t samples_per_loop = 24;
// They are drawn towards the middle by these shares, so that each ring of samples stands for about the same area, and
// walls in common do not count. [1; 0 to 1; B]
constexpr std::array<double, 3> drawn_inwards{0.04, 0.25, 0.55};

SectionLoop loop_of(std::span<const Vec3> points) {
    SectionLoop loop;
    loop.points.reserve(points.size());
    for (const Vec3& p : points) {
        loop.points.push_back({p.x, p.y});
        loop.box.extend(loop.points.back());
    }
    const Vec2 from = loop.points.front();
    Vec2 moment;
    for (std::size_t n = 0; n < loop.points.size(); ++n) {
        const Vec2 a = loop.points[n] - from, b = loop.points[(n + 1) % loop.points.size()] - from;
        const double twice = cross(a, b);
        loop.area += 0.5 * twice;
        moment = moment + (twice / 6) * (a + b);
    }
    loop.centre = loop.area != 0 ? from + (1 / loop.area) * moment : from;
    return loop;
}

}  // namespace

std::vector<Section> sections_of(const ContourSet& stack, std::uint32_t structure) {
    std::vector<Section> sections;
    for (std::uint32_t s = 0; s < stack.slices.size(); ++s) {
        if (is_interpolated(stack, s, structure)) continue;
        Section section;
        section.place = s;
        const Slice& slice = stack.slices[s];
        for (std::uint32_t c = slice.first_contour; c < slice.first_contour + slice.contour_count; ++c) {
            if (stack.contours[c].structure != structure) continue;
            section.height = stack.points_of(stack.contours[c]).front().z;
            section.loops.push_back(loop_of(stack.points_of(stack.contours[c])));
            section.loops.back().contour = c;
        }
        for (const SectionLoop& loop : section.loops) {
            section.area += loop.area;
            section.perimeter += perimeter(loop.points);
            section.box.extend(loop.box.low);
            section.box.extend(loop.box.high);
        }
        // Seen from behind, contours run the other way round.
        if (section.area < 0) {
            section.area = -section.area;
            for (SectionLoop& loop : section.loops) {
                std::reverse(loop.points.begin(), loop.points.end());
                loop.area = -loop.area;
            }
        }
        if (section.area > 0) sections.push_back(std::move(section));
    }
    std::stable_sort(sections.begin(), sections.end(),
                     [](const Section& a, const Section& b) { return a.height < b.height; });
    return sections;
}

bool is_inside(const SectionLoop& loop, Vec2 p) {
    if (!loop.box.contains(p)) return false;
    bool inside = false;
    const std::size_t count = loop.points.size();
    for (std::size_t n = 0; n < count; ++n) {
        const Vec2 a = loop.points[n], b = loop.points[n + 1 < count ? n + 1 : 0];
        if ((a.y > p.y) == (b.y > p.y)) continue;
        if (p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
    }
    return inside;
}

bool is_inside(const Section& section, Vec2 p) {
    bool inside = false;
    for (const SectionLoop& loop : section.loops) inside ^= is_inside(loop, p);
    return inside;
}

double distance_to(const Section& section, Vec2 p, double most) {
    double nearest = most;
    for (const SectionLoop& loop : section.loops) {
        const double dx = std::max({loop.box.low.x - p.x, p.x - loop.box.high.x, 0.0}),
                     dy = std::max({loop.box.low.y - p.y, p.y - loop.box.high.y, 0.0});
        if (std::hypot(dx, dy) >= nearest) continue;
        const std::size_t count = loop.points.size();
        for (std::size_t n = 0; n < count; ++n)
            nearest = std::min(
                nearest, distance_to_segment(p, loop.points[n], loop.points[n + 1 < count ? n + 1 : 0]));
    }
    return nearest;
}

std::vector<Vec2> samples_of(const SectionLoop& loop) {
    std::vector<Vec2> samples;
    const std::size_t step = loop.points.size() / samples_per_loop + 1;
    for (std::size_t n = 0; n < loop.points.size(); n += step) {
        for (const double share : drawn_inwards) {
            const Vec2 p = loop.points[n] + share * (loop.centre - loop.points[n]);
            if (is_inside(loop, p)) samples.push_back(p);
        }
    }
    return samples;
}

void append_edges(const SectionLoop& loop, Vec2 moved_by, std::vector<Edge2>& edges) {
    const std::size_t count = loop.points.size();
    for (std::size_t n = 0; n < count; ++n) {
        const Vec2 a = loop.points[n] + moved_by, b = loop.points[n + 1 < count ? n + 1 : 0] + moved_by;
        if (!(a == b)) edges.push_back({a, b});
    }
}

}  // namespace anatomesh
