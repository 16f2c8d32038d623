#include "anatomesh/measure/topology/spurious_joints.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "anatomesh/base/disjoint_sets.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

namespace {

// A rim on a sheet is flat if the mean of its unit normals is longer. [1; 0 to 1; M 2026-11, set not recorded]
constexpr double least_flatness = 0.3;

// A side of a triangle, number 3 t + k of triangle t: from its corner k to the next.
using Side = std::uint32_t;

// A closed line of sides at which patches meet, of one of them.
struct Rim {
    double length = 0;
    Vec3 normal;  // mean of the facets beyond, by length
    Vec3 middle;
    Vec3 area;                 // with the patch on its left
    std::uint32_t points = 0;  // of contours
    std::uint32_t lowest_point = no_cell, highest_point = 0;

    bool is_on_sheet() const {
        return squared_length(normal) >= least_flatness * least_flatness && dot(area, normal) > 0;
    }
};

struct Patch {
    std::int64_t euler = 0;
    std::vector<std::uint32_t> rims;
    bool is_whole = true;     // no segment of a contour is missing in it
    bool has_points = false;  // of contours, within
};

// The surface of one structure, parted by the edges along its contours.
class PatchedSurface {
  public:
    // `point_at`: by vertex the first contour point of the structure there, or no_cell.
    PatchedSurface(std::span<const Vec3> points, const std::vector<Triangle>& triangles,
                   std::span<const std::array<std::uint32_t, 2>> edges,
                   std::span<const std::array<std::uint32_t, 2>> missed,
                   const std::vector<std::uint32_t>& point_at)
        : points_(points),
          triangles_(triangles),
          point_at_(point_at),
          origin_(points[triangles.front()[0]]),
          patch_(triangles.size()) {
        find_twins();
        mark_rims(edges);
        find_patches();
        find_rims();
        note_missed(missed);
    }

    const std::vector<Patch>& patches() const { return patches_; }
    const std::vector<Rim>& rims() const { return rims_; }

  private:
    std::uint32_t start(Side s) const { return triangles_[s / 3][s % 3]; }
    std::uint32_t end(Side s) const { return start(next(s)); }
    static Side next(Side s) { return s % 3 == 2 ? s - 2 : s + 1; }

    void find_twins() {
        std::vector<std::pair<std::array<std::uint32_t, 2>, Side>> sides;
        sides.reserve(3 * triangles_.size());
        for (Side s = 0; s < 3 * triangles_.size(); ++s)
            sides.push_back({{std::min(start(s), end(s)), std::max(start(s), end(s))}, s});
        std::sort(sides.begin(), sides.end());
        twin_.resize(sides.size());
        for (std::size_t n = 0; n + 1 < sides.size(); n += 2) {
            assert(sides[n].first == sides[n + 1].first);
            twin_[sides[n].second] = sides[n + 1].second;
            twin_[sides[n + 1].second] = sides[n].second;
        }
    }

    // Sides along contours with different patches beyond them.
    void mark_rims(std::span<const std::array<std::uint32_t, 2>> edges) {
        is_rim_.assign(twin_.size(), 0);
        for (Side s = 0; s < twin_.size(); ++s) {
            is_rim_[s] =
                std::binary_search(edges.begin(), edges.end(),
                                   std::array{std::min(start(s), end(s)), std::max(start(s), end(s))});
            if (!is_rim_[s]) patch_.join(s / 3, twin_[s] / 3);
        }
        for (Side s = 0; s < twin_.size(); ++s)
            is_rim_[s] = is_rim_[s] && patch_.root(s / 3) != patch_.root(twin_[s] / 3);
    }

    // Euler numbers of patches as closed surfaces with rims: corners at a vertex are one up to a rim.
    void find_patches() {
        number_.assign(triangles_.size(), no_cell);
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            const std::uint32_t root = patch_.root(t);
            if (root == t) {
                number_[t] = static_cast<std::uint32_t>(patches_.size());
                patches_.emplace_back();
            }
            number_[t] = number_[root];
            ++patches_[number_[t]].euler;
        }
        DisjointSets corners(twin_.size());
        for (Side s = 0; s < twin_.size(); ++s) {
            const Side other = twin_[s];
            if (is_rim_[s]) {
                --patches_[number_[s / 3]].euler;
            } else if (s < other) {
                --patches_[number_[s / 3]].euler;
                corners.join(s, next(other));
                corners.join(next(s), other);
            }
        }
        std::vector<std::uint8_t> on_rim(twin_.size(), 0);
        corner_.resize(twin_.size());
        for (Side s = 0; s < twin_.size(); ++s) {
            corner_[s] = corners.root(s);
            patches_[number_[s / 3]].euler += corner_[s] == s;
        }
        for (Side s = 0; s < twin_.size(); ++s) {
            if (is_rim_[s]) on_rim[corner_[s]] = on_rim[corner_[next(s)]] = 1;
        }
        for (Side s = 0; s < twin_.size(); ++s) {
            if (!on_rim[corner_[s]] && point_at_[start(s)] != no_cell)
                patches_[number_[s / 3]].has_points = true;
        }
    }

    // A corner on a rim is where one side ends and another starts.
    void find_rims() {
        DisjointSets lines(twin_.size());
        for (Side s = 0; s < twin_.size(); ++s) {
            if (is_rim_[s]) lines.join(corner_[s], corner_[next(s)]);
        }
        std::vector<std::uint32_t> rim_of(twin_.size(), no_cell);
        for (Side s = 0; s < twin_.size(); ++s) {
            if (!is_rim_[s]) continue;
            std::uint32_t& rim = rim_of[lines.root(corner_[s])];
            if (rim == no_cell) {
                rim = static_cast<std::uint32_t>(rims_.size());
                patches_[number_[s / 3]].rims.push_back(rim);
                rims_.emplace_back();
            }
            add(rims_[rim], s);
        }
        for (Rim& rim : rims_) {
            rim.normal = (1 / rim.length) * rim.normal;
            rim.middle = (1 / rim.length) * rim.middle;
        }
    }

    void note_missed(std::span<const std::array<std::uint32_t, 2>> missed) {
        std::vector<std::uint32_t> ends;
        for (const auto& [a, b] : missed) ends.insert(ends.end(), {a, b});
        sort_distinct(ends);
        std::vector<std::array<std::uint32_t, 2>> patch_at;  // of ends
        for (Side s = 0; s < twin_.size(); ++s) {
            if (std::binary_search(ends.begin(), ends.end(), start(s)))
                patch_at.push_back({start(s), number_[s / 3]});
        }
        sort_distinct(patch_at);
        for (const auto& [a, b] : missed) {
            for (auto at = std::lower_bound(patch_at.begin(), patch_at.end(), std::array{a, 0u});
                 at != patch_at.end() && (*at)[0] == a; ++at) {
                if (std::binary_search(patch_at.begin(), patch_at.end(), std::array{b, (*at)[1]}))
                    patches_[(*at)[1]].is_whole = false;
            }
        }
    }

    void add(Rim& rim, Side s) const {
        const Vec3 a = points_[start(s)], b = points_[end(s)];
        const double size = length(b - a);
        const Triangle& beyond = triangles_[twin_[s] / 3];
        const Vec3 n =
            cross(points_[beyond[1]] - points_[beyond[0]], points_[beyond[2]] - points_[beyond[0]]);
        rim.length += size;
        rim.area += 0.5 * cross(a - origin_, b - origin_);
        rim.middle += (0.5 * size) * (a + b);
        if (const double area = length(n); area > 0) rim.normal += (size / area) * n;
        if (const std::uint32_t point = point_at_[start(s)]; point != no_cell) {
            ++rim.points;
            rim.lowest_point = std::min(rim.lowest_point, point);
            rim.highest_point = std::max(rim.highest_point, point);
        }
    }

    std::span<const Vec3> points_;
    const std::vector<Triangle>& triangles_;
    const std::vector<std::uint32_t>& point_at_;
    const Vec3 origin_;  // areas are taken about it
    DisjointSets patch_;
    std::vector<Side> twin_;
    std::vector<std::uint8_t> is_rim_;   // by side
    std::vector<std::uint32_t> number_;  // of the patch, by triangle
    std::vector<std::uint32_t> corner_;  // by side: that at its start
    std::vector<Patch> patches_;
    std::vector<Rim> rims_;
};

// Of one structure; `contour_of` every point of the contours.
void find_joints(std::uint32_t structure, const PatchedSurface& surface, const ContourSet& contours,
                 const std::vector<std::uint32_t>& contour_of, std::vector<SpuriousJoint>& joints) {
    // All points of a whole contour, and no others.
    const auto is_contour = [&](const Rim& rim) {
        return rim.lowest_point != no_cell && contour_of[rim.lowest_point] == contour_of[rim.highest_point] &&
               rim.points >= contours.contours[contour_of[rim.lowest_point]].point_count;
    };
    const auto shorter = [](const Rim* one, const Rim* other) { return one->length < other->length; };
    for (const Patch& patch : surface.patches()) {
        if (patch.rims.empty() || !patch.is_whole) continue;
        const auto rims = static_cast<std::int64_t>(patch.rims.size());
        const std::int64_t handles = patch.has_points ? 0 : (2 - rims - patch.euler) / 2;
        std::vector<const Rim*> sheets, all;
        for (const std::uint32_t r : patch.rims) {
            const Rim& rim = surface.rims()[r];
            all.push_back(&rim);
            if (rim.is_on_sheet() && !is_contour(rim)) sheets.push_back(&rim);
        }
        if (handles == 0 && sheets.size() < 2) continue;
        SpuriousJoint joint{structure, 0, static_cast<std::uint32_t>(handles), {}};
        if (sheets.size() > 1) joint.joints += static_cast<std::uint32_t>(sheets.size()) - 1;
        const std::vector<const Rim*>& choice = sheets.empty() ? all : sheets;
        joint.place = (*std::min_element(choice.begin(), choice.end(), shorter))->middle;
        std::uint32_t point = no_cell;
        for (const Rim* rim : all) point = std::min(point, rim->lowest_point);
        if (point != no_cell) joint.slice = contours.contours[contour_of[point]].slice;
        joints.push_back(joint);
    }
}

}  // namespace

std::vector<SpuriousJoint> spurious_joints(std::span<const Vec3> points,
                                           std::span<const std::vector<Triangle>> surfaces,
                                           std::span<const std::array<std::uint32_t, 2>> edges,
                                           std::span<const std::array<std::uint32_t, 2>> missed,
                                           const ContourSet& contours,
                                           std::span<const std::uint32_t> vertex_of) {
    assert(surfaces.size() == contours.structures.size() && vertex_of.size() == contours.points.size());
    std::vector<SpuriousJoint> joints;
    std::vector<std::uint32_t> point_at(points.size(), no_cell), contour_of(contours.points.size(), 0);
    for (std::uint32_t s = 0; s < surfaces.size(); ++s) {
        if (surfaces[s].empty()) continue;
        std::fill(point_at.begin(), point_at.end(), no_cell);
        for (std::uint32_t c = 0; c < contours.contours.size(); ++c) {
            const Contour& contour = contours.contours[c];
            if (contour.structure != s) continue;
            for (std::uint32_t n = 0; n < contour.point_count; ++n) {
                const std::uint32_t p = contour.first_point + n;
                contour_of[p] = c;
                if (vertex_of[p] != no_cell && point_at[vertex_of[p]] == no_cell) point_at[vertex_of[p]] = p;
            }
        }
        const PatchedSurface surface(points, surfaces[s], edges, missed, point_at);
        find_joints(s, surface, contours, contour_of, joints);
    }
    return joints;
}

}  // namespace anatomesh
