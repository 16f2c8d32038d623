#include "anatomesh/slices/arrangement/plane_patches.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "anatomesh/geom/numbers.h"

namespace anatomesh {

namespace {

// Images of one series have one frame. They agree within 0.1 degrees, the rounding of their directions in
// files. [1, cosine; 0 to 1; D digits of files]
constexpr double cos_of_series = 0.9999985;
// A slice takes over the frame of another one that covers this share of its own box: two narrow passes side
// by side must not deny each other.
// [1, of an area; 0 to 1; M 2026-11 two balls by axial and sagittal slices, 14 drawings of two organs]
constexpr double covered_share = 0.75;
// So many neighbours share the room on both sides of a place, two on each: one alone may be near by chance.
// [planes, even; >= 2; M 2026-11 random solids]
constexpr std::size_t crowd = 4;
// Among fewer planes none is near another one by chance, and the nearest one gives the spacing.
// [planes; > crowd; M 2026-11 random solids]
constexpr std::size_t least_crowded = 12;
// Planes at a smaller angle have no common line: rounding alone would say where it is.
// [1, sine; 0 to 1; D rounding of doubles]
constexpr double least_sine = 1e-4;

std::array<Vec3, 4> corners(const PlanePatch& patch, double margin) {
    const Box2 box = patch.box.grown(margin);
    return {patch.plane.to_space(box.low), patch.plane.to_space({box.high.x, box.low.y}),
            patch.plane.to_space(box.high), patch.plane.to_space({box.low.x, box.high.y})};
}

// Whether the corners of a patch lie on both sides of a plane.
bool straddles(const std::array<Vec3, 4>& corners, const Plane& plane) {
    bool below = false, above = false;
    for (const Vec3& corner : corners) {
        const double h = plane.signed_distance(corner);
        below |= h <= 0;
        above |= h >= 0;
    }
    return below && above;
}

}  // namespace

std::vector<PlanePatch> plane_patches(const ContourSet& set) {
    std::vector<PlanePatch> patches;
    for (const Slice& slice : set.slices) {
        PlanePatch patch{slice.plane, {}, 0, 0};
        for (const Contour& contour : set.contours_of(slice)) {
            for (const Vec3& point : set.points_of(contour)) {
                const double h = slice.plane.signed_distance(point);
                const bool first = patch.box.empty();
                patch.low = first ? h : std::min(patch.low, h);
                patch.high = first ? h : std::max(patch.high, h);
                patch.box.extend(slice.plane.to_plane(point));
            }
        }
        patches.push_back(patch);
    }
    return patches;
}

namespace {

bool are_of_one_series(const Plane& a, const Plane& b) {
    return std::abs(dot(a.normal, b.normal)) >= cos_of_series;
}

double area_of(const Box2& box) {
    return box.empty() ? 0 : (box.high.x - box.low.x) * (box.high.y - box.low.y);
}

// Whether the box has most of a slice's own in it.
bool covers(const Box2& box, const Box2& own) {
    const Box2 common{{std::max(box.low.x, own.low.x), std::max(box.low.y, own.low.y)},
                      {std::min(box.high.x, own.high.x), std::min(box.high.y, own.high.y)}};
    return area_of(common) >= covered_share * area_of(own);
}

// Takes the point and what is within the margin of it out of the frame, on the side where least beyond the
// box is lost.
void take_out(Vec2 p, const Box2& box, double margin, Box2& frame) {
    struct Side {
        double lost;
        double* rim;
        double to;
    };
    std::array<Side, 4> sides{{{frame.high.x - p.x, &frame.high.x, std::max(box.high.x, p.x - margin)},
                               {p.x - frame.low.x, &frame.low.x, std::min(box.low.x, p.x + margin)},
                               {frame.high.y - p.y, &frame.high.y, std::max(box.high.y, p.y - margin)},
                               {p.y - frame.low.y, &frame.low.y, std::min(box.low.y, p.y + margin)}}};
    const std::array<bool, 4> is_beyond{p.x > box.high.x, p.x<box.low.x, p.y> box.high.y, p.y < box.low.y};
    const Side* least = nullptr;
    for (std::size_t n = 0; n < sides.size(); ++n) {
        if (is_beyond[n] && (least == nullptr || sides[n].lost < least->lost)) least = &sides[n];
    }
    if (least != nullptr && frame.grown(margin).contains(p)) *least->rim = least->to;
}

// Where contours of slices of other directions pass through the plane.
void take_out_others(const ContourSet& set, const std::vector<PlanePatch>& patches, const PlanePatch& one,
                     double margin, Box2& frame) {
    for (std::size_t k = 0; k < patches.size(); ++k) {
        if (are_of_one_series(one.plane, patches[k].plane)) continue;
        for (const Contour& contour : set.contours_of(set.slices[k])) {
            const auto points = set.points_of(contour);
            for (std::size_t n = 0; n < points.size(); ++n) {
                const Vec3 a = points[n], b = points[(n + 1) % points.size()];
                const double above = one.plane.signed_distance(a), below = one.plane.signed_distance(b);
                if ((above < 0) == (below < 0)) continue;
                take_out(one.plane.to_plane(a + (above / (above - below)) * (b - a)), one.box, margin, frame);
            }
        }
    }
}

bool is_same(const Box2& a, const Box2& b) {
    return a.low == b.low && a.high == b.high;
}

}  // namespace

std::vector<Box2> frames_of_slices(const ContourSet& set, const std::vector<PlanePatch>& patches,
                                   double margin) {
    std::vector<Box2> frames;
    for (const PlanePatch& one : patches) {
        Box2& frame = frames.emplace_back(one.box);
        if (one.box.empty()) continue;
        for (const PlanePatch& other : patches) {
            if (other.box.empty() || !are_of_one_series(one.plane, other.plane)) continue;
            Box2 box;
            for (const Vec3& corner : corners(other, 0)) box.extend(one.plane.to_plane(corner));
            if (!covers(box, one.box)) continue;
            frame.extend(box.low);
            frame.extend(box.high);
        }
        if (!is_same(frame, one.box)) take_out_others(set, patches, one, margin, frame);
    }
    return frames;
}

PlaneSpacings plane_spacings(const ContourSet& set, const std::vector<PlanePatch>& patches) {
    const std::size_t samples = std::clamp<std::size_t>(4000 / (patches.size() + 1), 2, 16);
    std::vector<double> gaps, shares, sides;
    for (std::size_t i = 0; i < patches.size(); ++i) {
        std::vector<Vec3> points;
        for (const Contour& contour : set.contours_of(set.slices[i])) {
            const auto added = set.points_of(contour);
            points.insert(points.end(), added.begin(), added.end());
        }
        for (std::size_t sample = 0; sample < std::min(samples, points.size()); ++sample) {
            const Vec3 p = points[points.size() * sample / std::min(samples, points.size())];
            std::array<double, crowd> near;  // the nearest, rising
            near.fill(std::numeric_limits<double>::infinity());
            std::array<double, 2> beside = {near[0], near[0]};  // on either side
            for (std::size_t j = 0; j < patches.size(); ++j) {
                if (j == i || patches[j].box.empty()) continue;
                if (std::abs(dot(patches[i].plane.normal, patches[j].plane.normal)) < cos_of_about_30_degrees)
                    continue;
                const Vec3 offset = patches[j].offset_from(p, 0);
                double distance = length(offset);
                double& side = beside[dot(offset, patches[i].plane.normal) > 0];
                side = std::min(side, distance);
                for (double& one : near) {
                    if (distance < one) std::swap(distance, one);
                }
            }
            if (std::isfinite(near[0]) && near[0] > 0) gaps.push_back(near[0]);
            for (const double side : beside) {
                if (std::isfinite(side)) sides.push_back(side);
            }
            if (std::isfinite(near[crowd - 1])) shares.push_back(near[crowd - 1] / (crowd / 2));
        }
    }
    if (gaps.empty()) {
        const double apart = set.box().diagonal() / static_cast<double>(patches.size() + 1);
        return {apart, apart, apart};
    }
    std::sort(gaps.begin(), gaps.end());
    std::sort(shares.begin(), shares.end());
    std::sort(sides.begin(), sides.end());
    PlaneSpacings spacings{gaps[gaps.size() / 2], gaps[gaps.size() * 9 / 10],
                           sides[sides.size() * 995 / 1000]};
    // Planes that cross here and there are near each other by chance: among many, the room each has counts.
    if (2 * shares.size() > gaps.size() && patches.size() >= least_crowded) {
        spacings.median = std::max(spacings.median, shares[shares.size() / 2]);
        spacings.wide = std::max(spacings.wide, spacings.median);
    }
    return spacings;
}

std::vector<Box2> frames_of_slices(const ContourSet& set) {
    const std::vector<PlanePatch> patches = plane_patches(set);
    return frames_of_slices(set, patches, plane_spacings(set, patches).median);
}

double mean_vertex_spacing(const ContourSet& set) {
    double total = 0;
    for (const Contour& contour : set.contours) {
        const auto points = set.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n)
            total += length(points[(n + 1) % points.size()] - points[n]);
    }
    return total / static_cast<double>(std::max<std::size_t>(1, set.points.size()));
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> crossing_pairs(const std::vector<PlanePatch>& patches,
                                                                    double margin) {
    std::vector<std::array<Vec3, 4>> rims(patches.size());
    std::vector<Box3> boxes(patches.size());
    std::vector<std::uint32_t> order;
    Box3 all;
    for (std::uint32_t i = 0; i < patches.size(); ++i) {
        if (patches[i].box.empty()) continue;
        rims[i] = corners(patches[i], margin);
        for (const Vec3& corner : rims[i]) boxes[i].extend(corner);
        all.extend(boxes[i].low);
        all.extend(boxes[i].high);
        order.push_back(i);
    }
    if (order.empty()) return {};
    const Vec3 size = all.high - all.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto along = [axis](const Vec3& p) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; };
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
        const double low_i = along(boxes[i].low), low_j = along(boxes[j].low);
        return low_i != low_j ? low_i < low_j : i < j;
    });
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (std::size_t m = 0; m < order.size(); ++m) {
        const std::uint32_t i = order[m];
        for (std::size_t n = m + 1; n < order.size() && along(boxes[order[n]].low) <= along(boxes[i].high);
             ++n) {
            const std::uint32_t j = order[n];
            if (!meet(boxes[i], boxes[j])) continue;
            if (length(cross(patches[i].plane.normal, patches[j].plane.normal)) < least_sine) continue;
            if (!straddles(rims[i], patches[j].plane) || !straddles(rims[j], patches[i].plane)) continue;
            pairs.emplace_back(std::min(i, j), std::max(i, j));
        }
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

}  // namespace anatomesh
