#include "anatomesh/measure/contradicted_segments.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace anatomesh::contradicted_segments_test {
namespace {

using Numbers = std::vector<std::uint32_t>;
using Flat = std::vector<std::array<double, 2>>;  // (along, z)

// Two slices through the z axis: what is drawn along x on the first, along y on the second. One contour each.
ContourSet crossed(const Flat& in_xz, const Flat& in_yz, std::uint32_t structure_of_second = 0) {
    ContourSet set;
    set.structures.resize(2);
    const auto add = [&](const Flat& drawn, Vec3 along, std::uint32_t structure) {
        const auto slice = static_cast<std::uint32_t>(set.slices.size());
        set.slices.emplace_back();
        set.slices.back().plane = {{0, 0, 0}, along, {0, 0, 1}, cross(along, Vec3{0, 0, 1})};
        set.slices.back().first_contour = slice;
        set.slices.back().contour_count = 1;
        set.contours.push_back({structure, slice, static_cast<std::uint32_t>(set.points.size()),
                                static_cast<std::uint32_t>(drawn.size())});
        for (const auto& [x, z] : drawn) set.points.push_back(x * along + Vec3{0, 0, z});
    };
    add(in_xz, {1, 0, 0}, 0);
    add(in_yz, {0, 1, 0}, structure_of_second);
    return set;
}

Flat square(double half_width, double middle = 0) {
    const double h = half_width;
    return {{-h, middle - h}, {h, middle - h}, {h, middle + h}, {-h, middle + h}};
}

// Of all segments, numbered through.
Numbers contradicted(const ContourSet& set) {
    std::vector<SegmentOfContour> all;
    for (std::uint32_t c = 0; c < set.contours.size(); ++c) {
        for (std::uint32_t n = 0; n < set.contours[c].point_count; ++n) all.push_back({c, n});
    }
    Numbers numbers;
    for (const auto& [contour, index] : contradicted_segments(set, all))
        numbers.push_back(set.contours[contour].first_point + index);
    return numbers;
}

ContourSet turned(ContourSet set, double angle) {
    const auto turn = [&](Vec3 p) {
        const Vec3 q{p.x, std::cos(angle) * p.y - std::sin(angle) * p.z,
                     std::sin(angle) * p.y + std::cos(angle) * p.z};
        return Vec3{std::cos(angle) * q.x - std::sin(angle) * q.y,
                    std::sin(angle) * q.x + std::cos(angle) * q.y, q.z};
    };
    for (Vec3& p : set.points) p = turn(p) + Vec3{100, 7, -30};
    for (Slice& slice : set.slices)
        slice.plane = {Vec3{100, 7, -30}, turn(slice.plane.u), turn(slice.plane.v), turn(slice.plane.normal)};
    return set;
}

TEST(ContradictedSegments, none_where_slices_agree) {
    EXPECT_TRUE(contradicted(crossed(square(10), square(10))).empty());
    EXPECT_TRUE(contradicted(crossed(square(10), square(10 + 0.5 * contradiction_mm))).empty());
}

TEST(ContradictedSegments, those_that_pass_where_the_other_slice_has_no_contour) {
    // The lower and the upper side of the smaller square pass within the larger one; those of the larger one
    // are beyond what the smaller one reaches.
    EXPECT_EQ(contradicted(crossed(square(8), square(10))), (Numbers{0, 2}));
    EXPECT_EQ(contradicted(crossed(square(10), square(8))), (Numbers{4, 6}));
    // Shifted along the common line: one side of each lies within the other, the others beyond it.
    EXPECT_EQ(contradicted(crossed(square(10), square(10, 1))), (Numbers{2, 4}));
}

TEST(ContradictedSegments, both_that_meet_where_the_contour_passes) {
    // A vertex on the common line in the middle of each side.
    const Flat with_middles{{-8, -8}, {0, -8}, {8, -8}, {8, 8}, {0, 8}, {-8, 8}};
    EXPECT_EQ(contradicted(crossed(with_middles, square(10))), (Numbers{0, 1, 3, 4}));
    EXPECT_TRUE(contradicted(crossed(with_middles, square(8))).empty());
}

TEST(ContradictedSegments, nothing_of_contours_that_touch_a_plane_or_run_along_it) {
    const Flat tip{{0, 0}, {8, -5}, {8, 5}}, beside{{0, -5}, {8, -5}, {8, 5}, {0, 5}};
    for (int n = 0; n < 50; ++n) {
        EXPECT_TRUE(contradicted(turned(crossed(tip, square(10)), 0.1 * n)).empty()) << n;
        EXPECT_TRUE(contradicted(turned(crossed(beside, square(10)), 0.1 * n)).empty()) << n;
        EXPECT_EQ(contradicted(turned(crossed(square(8), square(10)), 0.1 * n)), (Numbers{0, 2})) << n;
    }
}

TEST(ContradictedSegments, of_those_asked_for_in_their_order) {
    const ContourSet set = crossed(square(8), square(10));
    using Segments = std::vector<SegmentOfContour>;
    EXPECT_EQ(contradicted_segments(set, Segments{{0, 3}, {0, 2}, {1, 1}, {0, 0}}),
              (Segments{{0, 2}, {0, 0}}));
    EXPECT_TRUE(contradicted_segments(set, {}).empty());
}

TEST(ContradictedSegments, a_slice_says_nothing_of_structures_that_it_does_not_draw) {
    EXPECT_TRUE(contradicted(crossed(square(8), square(10), 1)).empty());
    ContourSet set = crossed(square(8), square(10));
    set.slices[1].contour_count = 0;  // nor does an empty one
    EXPECT_TRUE(contradicted_segments(set, std::vector<SegmentOfContour>{{0, 0}, {0, 2}}).empty());
}

}  // namespace
}  // namespace anatomesh::contradicted_segments_test
