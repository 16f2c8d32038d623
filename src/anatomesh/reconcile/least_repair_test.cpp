#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh::least_repair_test {
namespace {

using Outline = std::vector<Vec2>;

// Vertices about every 2 mm along a polygon.
Outline dense(const Outline& corners) {
    Outline points;
    for (std::size_t n = 0; n < corners.size(); ++n) {
        const Vec2 from = corners[n], way = corners[(n + 1) % corners.size()] - from;
        const int steps = std::max(1, static_cast<int>(std::lround(length(way) / 2)));
        for (int k = 0; k < steps; ++k) points.push_back(from + (static_cast<double>(k) / steps) * way);
    }
    return points;
}

double area(const Outline& outline) {
    double twice = 0;
    for (std::size_t n = 0; n < outline.size(); ++n)
        twice += cross(outline[n], outline[(n + 1) % outline.size()]);
    return 0.5 * twice;
}

void add_contour(ContourSet& set, std::uint32_t structure, Outline outline, bool is_hole = false) {
    Slice& slice = set.slices.back();
    if ((area(outline) < 0) != is_hole) std::reverse(outline.begin(), outline.end());
    std::vector<Vec3> points;
    for (const Vec2 q : outline) points.push_back(slice.plane.to_space(q));
    std::rotate(points.begin(), std::min_element(points.begin(), points.end(), LexicographicLess{}),
                points.end());
    set.contours.push_back({structure, static_cast<std::uint32_t>(set.slices.size() - 1),
                            static_cast<std::uint32_t>(set.points.size()),
                            static_cast<std::uint32_t>(points.size())});
    set.points.insert(set.points.end(), points.begin(), points.end());
    ++slice.contour_count;
}

void begin_slice(ContourSet& set, const Plane& plane, const std::string& name) {
    set.slices.push_back({plane, static_cast<std::uint32_t>(set.contours.size()), 0, name});
}

// Slice "face" is x = 0 with u = y and v = z, slice "along" is y = 0 with u = x and v = z. On the face a part of
// `width` leans over the line by `over_mm`, and along it the other slice ends `off_mm` before the line.
struct Member {
    double off_mm, over_mm, width, tilt_degrees;
    bool is_slot, has_second;
};

// The part: a finger up from an arm, or a slot of the same shape within a block.
Outline leaning(const Member& m) {
    const double t = m.tilt_degrees * std::numbers::pi / 180, c = std::cos(t), s = std::sin(t);
    // Its far corner comes `over_mm` beyond the line, which is v = any, u = 0.
    const auto at = [&](double across, double along) {
        return Vec2{across * c + along * s, along * c - across * s};
    };
    Outline part{at(0, 0), at(0, 40), at(m.width, 40), at(m.width, 0)};
    double farthest = -1e9;
    for (const Vec2 p : part) farthest = std::max(farthest, p.x);
    for (Vec2& p : part) p.x += m.over_mm - farthest;
    return part;
}

Outline face_of(const Member& m) {
    const Outline part = leaning(m);
    const double left = -40, bottom = std::min(part[0].y, part[3].y) - 15,
                 top = std::max(part[1].y, part[2].y) + 15;
    if (m.is_slot) return {{left, bottom}, {left + 90, bottom}, {left + 90, top}, {left, top}};
    // A block, an arm at its bottom, and the finger up from that.
    return {{left, bottom},
            {part[3].x, bottom},
            part[3],
            part[2],
            part[1],
            part[0],
            {part[0].x - 5, bottom + 8},
            {part[0].x - 5, top},
            {left, top}};
}

ContourSet drawn(const Member& m) {
    ContourSet set;
    set.source = "parts";
    set.structures.push_back({1, "part", {200, 200, 200}});
    if (m.has_second) set.structures.push_back({2, "beside", {200, 100, 100}});
    const Outline face = dense(face_of(m)), edge = m.is_slot ? dense(leaning(m)) : face;
    double low = 1e9, high = -1e9, bottom = 1e9, top = -1e9;
    for (const Vec2 p : face) bottom = std::min(bottom, p.y), top = std::max(top, p.y);
    for (std::size_t n = 0; n < edge.size(); ++n) {
        const Vec2 p = edge[n], q = edge[(n + 1) % edge.size()];
        if ((p.x > 0) == (q.x > 0)) continue;
        const double v = p.y + (p.x / (p.x - q.x)) * (q.y - p.y);
        low = std::min(low, v);
        high = std::max(high, v);
    }
    begin_slice(set, {{}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, "face");
    add_contour(set, 0, face);
    if (m.is_slot) add_contour(set, 0, edge, true);
    if (m.has_second) add_contour(set, 1, dense({{60, -30}, {80, -30}, {80, 50}, {60, 50}}));
    begin_slice(set, {{}, {1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, "along");
    if (m.is_slot) {
        // As long as the face is high: the slot's gap alone is contradicted.
        add_contour(set, 0,
                    dense({{-40, bottom},
                           {40, bottom},
                           {40, low - 4},
                           {m.off_mm, low - 4},
                           {m.off_mm, high + 4},
                           {40, high + 4},
                           {40, top},
                           {-40, top}}));
    } else {
        add_contour(set, 0,
                    dense({{m.off_mm, low - 4}, {40, low - 4}, {40, high + 4}, {m.off_mm, high + 4}}));
    }
    return set;
}

std::vector<Member> members() {
    std::vector<Member> all;
    for (const double off : {0.1, 0.3, 1.0, 3.0}) {
        for (const double over : {6.5, 8.0, 9.5}) {
            for (const double tilt : {4.0, 9.0, 14.0, 20.0}) {
                for (const bool is_slot : {false, true})
                    all.push_back({off, over, is_slot ? 2 * over : over + 2, tilt, is_slot, tilt == 9});
            }
        }
    }
    return all;
}

// The slice that has to move less moves: no more than the contradiction and the clearance beyond the line, and
// nothing of the other one goes.
TEST(LeastRepair, a_part_does_not_go_because_another_slice_ends_a_little_before_it) {
    std::size_t count = 0;
    for (const Member& m : members()) {
        SCOPED_TRACE("off " + std::to_string(m.off_mm) + ", over " + std::to_string(m.over_mm) + ", tilt " +
                     std::to_string(m.tilt_degrees) + (m.is_slot ? ", slot" : ", finger") +
                     (m.has_second ? ", two" : ""));
        const ContourSet set = drawn(m);
        RunContext context;
        Result<ReconcileResult> result = reconcile_contours(set, {}, context);
        ASSERT_TRUE(result.ok()) << to_line(result.error());
        const ReconcileStats& stats = result.value().stats;
        EXPECT_EQ(stats.difference_after_mm, 0);
        EXPECT_LE(stats.max_movement_mm, 1.2 * m.off_mm + 0.5);
        EXPECT_EQ(stats.folds.vertices, 0u);
        const ContourSet& kept = result.value().kept;
        EXPECT_EQ(kept.contours.size(), set.contours.size());
        for (const Contour& contour : set.contours_of(set.slices[0])) {
            for (const Vec3& p : set.points_of(contour))
                EXPECT_TRUE(std::any_of(kept.points.begin(), kept.points.end(),
                                        [&](Vec3 q) { return length(q - p) < 0.05; }));
        }
        ++count;
    }
    EXPECT_GE(count, 50u);
}

}  // namespace
}  // namespace anatomesh::least_repair_test
