#include "anatomesh/contour/model/ring.h"

#include <algorithm>
#include <cstddef>

#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

// Start of the least rotation of the cycle get(0), ..., get(n - 1).
template <class Get>
std::size_t least_rotation(std::size_t n, const Get& get) {
    std::size_t i = 0, j = 1, k = 0;
    while (i < n && j < n && k < n) {
        const Vec3 p = get((i + k) % n), q = get((j + k) % n);
        if (p == q) {
            ++k;
            continue;
        }
        (lexicographic_less(p, q) ? j : i) += k + 1;
        if (i == j) ++j;
        k = 0;
    }
    return std::min(i, j);
}

// Whether the path p, q, r comes straight back at q (or stands still).
bool turns_back(Vec2 p, Vec2 q, Vec2 r) {
    if (p == q || q == r || p == r) return true;
    if (orient2d(p, q, r) != 0) return false;
    return lexicographic_less(p, q) != lexicographic_less(q, r);
}

}  // namespace

Ring make_ring(std::vector<Vec3> points, const Plane& plane, std::uint32_t source) {
    Ring ring;
    ring.at.reserve(points.size());
    for (const Vec3& p : points) ring.at.push_back(plane.to_plane(p));
    ring.points = std::move(points);
    ring.source = source;
    return ring;
}

std::size_t drop_repeated_points(std::vector<Vec3>& points) {
    const std::size_t before = points.size();
    points.erase(std::unique(points.begin(), points.end()), points.end());
    while (points.size() > 1 && points.back() == points.front()) points.pop_back();
    return before - points.size();
}

void canonicalize_cycle(std::vector<Vec3>& points) {
    const std::size_t n = points.size();
    if (n < 2) return;
    const auto forward = [&](std::size_t i) { return points[i]; };
    const auto backward = [&](std::size_t i) { return points[n - 1 - i]; };
    const std::size_t f = least_rotation(n, forward), b = least_rotation(n, backward);
    bool reverse = false;
    for (std::size_t k = 0; k < n; ++k) {
        const Vec3 p = forward((f + k) % n), q = backward((b + k) % n);
        if (p == q) continue;
        reverse = lexicographic_less(q, p);
        break;
    }
    if (reverse) std::reverse(points.begin(), points.end());
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(reverse ? b : f), points.end());
}

std::size_t remove_spikes(Ring& ring) {
    const std::size_t n = ring.size();
    const auto back = [&](std::size_t p, std::size_t q, std::size_t r) {
        return turns_back(ring.at[p], ring.at[q], ring.at[r]);
    };
    // A stack of kept vertices; a new one that turns back at the top takes the top off first.
    std::vector<std::size_t> kept;
    kept.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
        bool repeats = false;
        while (!kept.empty()) {
            repeats = ring.at[kept.back()] == ring.at[i];
            if (repeats || kept.size() < 2 || !back(kept[kept.size() - 2], kept.back(), i)) break;
            kept.pop_back();
        }
        if (!repeats) kept.push_back(i);
    }
    // The same where the cycle closes.
    std::size_t begin = 0, end = kept.size();
    for (bool changed = true; changed && end - begin >= 3;) {
        changed = true;
        if (back(kept[end - 2], kept[end - 1], kept[begin])) {
            --end;
        } else if (back(kept[end - 1], kept[begin], kept[begin + 1])) {
            ++begin;
        } else {
            changed = false;
        }
    }
    if (end - begin == n) return 0;
    Ring result;
    result.source = ring.source;
    result.plane = ring.plane;
    for (std::size_t k = begin; k < end; ++k) result.push_back(ring.at[kept[k]], ring.points[kept[k]]);
    ring = std::move(result);
    return n - (end - begin);
}

void reverse_ring(Ring& ring) {
    if (ring.size() < 2) return;
    std::reverse(ring.at.begin() + 1, ring.at.end());
    std::reverse(ring.points.begin() + 1, ring.points.end());
}

}  // namespace anatomesh
