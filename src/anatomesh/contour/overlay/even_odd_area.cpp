#include "anatomesh/contour/overlay/even_odd_area.h"

#include <algorithm>
#include <utility>

namespace anatomesh {

namespace {

double x_at(const Segment2& s, double y) {
    return s.a.x + (y - s.a.y) / (s.b.y - s.a.y) * (s.b.x - s.a.x);
}

// The heights between which no segment begins, ends, or crosses another or the clip's sides.
std::vector<double> heights(const std::vector<Segment2>& segments, const Box2& clip) {
    std::vector<double> found{clip.low.y, clip.high.y};
    for (const Segment2& s : segments) {
        found.push_back(s.a.y);
        found.push_back(s.b.y);
        // These are the heights at which it enters or leaves the clip's columns.
        for (const double x : {clip.low.x, clip.high.x}) {
            if ((s.a.x < x) != (s.b.x < x))
                found.push_back(s.a.y + (x - s.a.x) / (s.b.x - s.a.x) * (s.b.y - s.a.y));
        }
    }
    const SegmentIndex index(segments);
    index.for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
        const Segment2 &p = segments[i], &q = segments[j];
        const Vec2 u = p.b - p.a, v = q.b - q.a;
        const double area = cross(u, v);
        if (area == 0) return true;
        const double along = cross(q.a - p.a, v) / area;
        if (along > 0 && along < 1) found.push_back(p.a.y + along * u.y);
        return true;
    });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

}  // namespace

double even_odd_area(std::vector<Segment2> segments, const Box2& clip) {
    // Horizontal segments bound no width.
    std::erase_if(segments, [](const Segment2& s) { return s.a.y == s.b.y; });
    if (segments.empty()) return 0;
    const std::vector<double> levels = heights(segments, clip);
    for (Segment2& s : segments) {
        if (s.b.y < s.a.y) std::swap(s.a, s.b);
    }
    std::sort(segments.begin(), segments.end(),
              [](const Segment2& s, const Segment2& t) { return s.a.y < t.a.y; });
    std::vector<std::uint32_t> active;
    std::vector<double> crossings;
    double area = 0;
    std::uint32_t next = 0;
    for (std::size_t n = 0; n + 1 < levels.size(); ++n) {
        const double low = levels[n], high = levels[n + 1], middle = 0.5 * (low + high);
        for (; next < segments.size() && segments[next].a.y <= low; ++next) active.push_back(next);
        std::erase_if(active, [&](std::uint32_t s) { return segments[s].b.y <= low; });
        if (low < clip.low.y || high > clip.high.y) continue;
        crossings.clear();
        for (const std::uint32_t s : active) {
            crossings.push_back(std::clamp(x_at(segments[s], middle), clip.low.x, clip.high.x));
        }
        std::sort(crossings.begin(), crossings.end());
        for (std::size_t k = 0; k + 1 < crossings.size(); k += 2)
            area += (crossings[k + 1] - crossings[k]) * (high - low);
    }
    return area;
}

}  // namespace anatomesh
