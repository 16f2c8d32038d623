#include "anatomesh/mesh/check/small_handles.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "anatomesh/base/disjoint_sets.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

namespace {

// All of a handle within the reach is seen from a place within this share of it, so that vertices that near
// are no further middles. [reaches; 0 to 1; B]
constexpr double covered = 0.5;

// A surface, and what lies near a vertex of it.
class Neighborhoods {
  public:
    Neighborhoods(std::span<const Vec3> points, std::span<const Triangle> triangles)
        : points_(points), triangles_(triangles), distance_(points.size(), far), taken_(triangles.size(), 0) {
        first_.assign(points.size() + 1, 0);
        for (const Triangle& t : triangles) {
            for (const std::uint32_t v : t) ++first_[v + 1];
        }
        for (std::size_t v = 0; v < points.size(); ++v) first_[v + 1] += first_[v];
        around_.resize(3 * triangles.size());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            for (const std::uint32_t v : triangles[t]) around_[next[v]++] = t;
        }
    }

    std::span<const std::uint32_t> around(std::uint32_t v) const {
        return {around_.data() + first_[v], first_[v + 1] - first_[v]};
    }

    // The vertices within reach of one along edges, nearest first, with their distances.
    const std::vector<std::pair<double, std::uint32_t>>& within(std::uint32_t middle, double reach) {
        near_.clear();
        using Entry = std::pair<double, std::uint32_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
        std::vector<std::uint32_t>& touched = scratch_;
        touched.assign(1, middle);
        distance_[middle] = 0;
        open.push({0, middle});
        while (!open.empty()) {
            const auto [d, v] = open.top();
            open.pop();
            if (d > distance_[v]) continue;
            near_.push_back({d, v});
            for (const std::uint32_t t : around(v)) {
                for (const std::uint32_t w : triangles_[t]) {
                    const double way = d + length(points_[w] - points_[v]);
                    if (way > reach || way >= distance_[w]) continue;
                    if (distance_[w] == far) touched.push_back(w);
                    distance_[w] = way;
                    open.push({way, w});
                }
            }
        }
        for (const std::uint32_t v : touched) distance_[v] = far;
        return near_;
    }

    // The triangles all corners of which are among the vertices.
    std::vector<std::uint32_t> filled_by(std::span<const std::pair<double, std::uint32_t>> vertices) {
        std::vector<std::uint32_t> filled;
        for (const auto& [d, v] : vertices) {
            for (const std::uint32_t t : around(v)) {
                if (++taken_[t] == 3) filled.push_back(t);
            }
        }
        for (const auto& [d, v] : vertices) {
            for (const std::uint32_t t : around(v)) taken_[t] = 0;
        }
        std::sort(filled.begin(), filled.end());
        return filled;
    }

  private:
    static constexpr double far = std::numeric_limits<double>::infinity();
    std::span<const Vec3> points_;
    std::span<const Triangle> triangles_;
    std::vector<std::uint32_t> first_, around_, scratch_;
    std::vector<double> distance_;     // by vertex, while one is asked
    std::vector<std::uint8_t> taken_;  // corners, by triangle
    std::vector<std::pair<double, std::uint32_t>> near_;
};

// The handles of every edge-connected part of some triangles, and to which part each of them belongs.
struct Parts {
    std::vector<std::uint32_t> handles;  // by part
    std::vector<std::uint32_t> part_of;  // by triangle of those given
};

Parts parts_of(std::span<const Triangle> triangles, std::span<const std::uint32_t> chosen) {
    struct Side {
        std::array<std::uint32_t, 2> ends;
        std::uint32_t corner;  // 3 n + k: from corner k of the chosen triangle n to the next
    };
    const auto count = static_cast<std::uint32_t>(chosen.size());
    const auto next = [](std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; };
    std::vector<Side> sides;
    sides.reserve(3 * chosen.size());
    for (std::uint32_t n = 0; n < count; ++n) {
        const Triangle& t = triangles[chosen[n]];
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            sides.push_back({{std::min(a, b), std::max(a, b)}, 3 * n + k});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
        return std::pair{x.ends, x.corner} < std::pair{y.ends, y.corner};
    });
    // Corners at a vertex are one up to a rim.
    DisjointSets pieces(count), corners(3 * count), rims(3 * count);
    std::vector<std::uint8_t> is_rim(3 * count, 0);
    std::vector<std::int64_t> inner_sides(count, 0);  // by the lower triangle
    for (std::size_t n = 0; n < sides.size(); ++n) {
        const std::uint32_t c = sides[n].corner;
        if (n + 1 < sides.size() && sides[n].ends == sides[n + 1].ends) {
            const std::uint32_t d = sides[++n].corner;
            pieces.join(c / 3, d / 3);
            corners.join(c, next(d));
            corners.join(next(c), d);
            ++inner_sides[c / 3];
        } else {
            is_rim[c] = 1;
        }
    }
    for (std::uint32_t c = 0; c < 3 * count; ++c) {
        if (is_rim[c]) rims.join(corners.root(c), corners.root(next(c)));
    }
    std::vector<std::int64_t> euler(count, 0), rim_count(count, 0);
    std::vector<std::uint8_t> seen(3 * count, 0);
    for (std::uint32_t c = 0; c < 3 * count; ++c) {
        const std::uint32_t piece = pieces.root(c / 3);
        if (c % 3 == 0) euler[piece] += 1 - inner_sides[c / 3];
        euler[piece] += corners.root(c) == c;
        if (!is_rim[c]) continue;
        --euler[piece];
        std::uint8_t& known = seen[rims.root(corners.root(c))];
        rim_count[piece] += known == 0;
        known = 1;
    }
    Parts parts;
    std::vector<std::uint32_t> number(count, 0);
    for (std::uint32_t n = 0; n < count; ++n) {
        const std::uint32_t root = pieces.root(n);
        if (root == n) {
            number[n] = static_cast<std::uint32_t>(parts.handles.size());
            parts.handles.push_back(static_cast<std::uint32_t>((2 - rim_count[n] - euler[n]) / 2));
        }
        parts.part_of.push_back(number[root]);
    }
    return parts;
}

}  // namespace

std::vector<SmallHandles> small_handles(std::span<const Vec3> points, std::span<const Triangle> triangles,
                                        double reach_mm) {
    assert(reach_mm > 0);
    Neighborhoods surface(points, triangles);
    std::vector<std::uint8_t> is_covered(points.size(), 0), has_handle(triangles.size(), 0);
    std::vector<std::uint32_t> middles;
    for (std::uint32_t v = 0; v < points.size(); ++v) {
        if (is_covered[v] || surface.around(v).empty()) continue;
        const auto& near = surface.within(v, reach_mm);
        for (const auto& [d, w] : near) {
            if (d <= covered * reach_mm) is_covered[w] = 1;
        }
        const std::vector<std::uint32_t> filled = surface.filled_by(near);
        const Parts parts = parts_of(triangles, filled);
        bool any = false;
        for (std::size_t n = 0; n < filled.size(); ++n) {
            if (parts.handles[parts.part_of[n]] > 0) has_handle[filled[n]] = 1, any = true;
        }
        if (any) middles.push_back(v);
    }
    std::vector<std::uint32_t> chosen;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (has_handle[t]) chosen.push_back(t);
    }
    const Parts parts = parts_of(triangles, chosen);
    std::vector<SmallHandles> found;
    for (const std::uint32_t handles : parts.handles) found.push_back({handles, no_cell, {}});
    for (std::size_t n = 0; n < chosen.size(); ++n) {
        const Triangle& t = triangles[chosen[n]];
        std::vector<std::uint32_t>& vertices = found[parts.part_of[n]].vertices;
        vertices.insert(vertices.end(), t.begin(), t.end());
    }
    for (SmallHandles& part : found) {
        sort_distinct(part.vertices);
        part.middle = part.vertices.front();
        const auto middle =
            std::find_first_of(part.vertices.begin(), part.vertices.end(), middles.begin(), middles.end());
        if (middle != part.vertices.end()) part.middle = *middle;
    }
    return found;
}

}  // namespace anatomesh
