// Laws of how far slices say what is there.
#include "anatomesh/slices/arrangement/plane_patches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace anatomesh::plane_patches_test {
namespace {

class Drawn {
  public:
    // A rectangle in the plane's own coordinates.
    void slice(const Plane& plane, const std::vector<Box2>& boxes) {
        set.slices.push_back({plane, static_cast<std::uint32_t>(set.contours.size()),
                              static_cast<std::uint32_t>(boxes.size()), ""});
        for (const Box2& box : boxes) {
            set.contours.push_back({0, static_cast<std::uint32_t>(set.slices.size() - 1),
                                    static_cast<std::uint32_t>(set.points.size()), 4});
            for (const Vec2 q : {box.low, Vec2{box.high.x, box.low.y}, box.high, Vec2{box.low.x, box.high.y}})
                set.points.push_back(plane.to_space(q));
        }
    }
    std::vector<Box2> frames(double margin = 0) const {
        return frames_of_slices(set, plane_patches(set), margin);
    }
    ContourSet set;
};

void expect_box(const Box2& box, Vec2 low, Vec2 high) {
    EXPECT_NEAR(box.low.x, low.x, 1e-9);
    EXPECT_NEAR(box.low.y, low.y, 1e-9);
    EXPECT_NEAR(box.high.x, high.x, 1e-9);
    EXPECT_NEAR(box.high.y, high.y, 1e-9);
}

Plane axial(double z) {
    return make_plane({0, 0, z}, {0, 0, 1});
}

TEST(FramesOfSlices, reach_as_far_as_those_that_draw_beside_what_they_draw) {
    Drawn drawn;
    drawn.slice(axial(0), {{{0, 0}, {10, 10}}});
    drawn.slice(axial(5), {{{0, 0}, {9, 10}}, {{30, 5}, {40, 12}}});
    drawn.slice(axial(10), {{{2, -1}, {8, 10}}});
    drawn.slice(axial(15), {{{31, 6}, {39, 11}}});
    const std::vector<Box2> frames = drawn.frames();
    expect_box(frames[0], {0, 0}, {40, 12});
    expect_box(frames[1], {0, 0}, {40, 12});
    expect_box(frames[2], {0, -1}, {40, 12});
    expect_box(frames[3], {0, 0}, {40, 12});
}

// Two passes of a probe that overlap by a sixth; and slices by hand.
TEST(FramesOfSlices, of_other_images_or_by_hand_are_their_own) {
    for (const double lean : {0.0, 0.02}) {
        Drawn drawn;
        for (int k = 0; k < 6; ++k) {
            const double left = k % 2 == 0 || lean > 0 ? 0 : 34;
            drawn.slice(make_plane({0, 0, 2.0 * k}, {0, lean * (k % 3), 1}),
                        {{{left, 0}, {left + 40 - 2 * k, 20}}});
        }
        const std::vector<Box2> frames = drawn.frames();
        const std::vector<PlanePatch> patches = plane_patches(drawn.set);
        for (std::size_t k = 0; k < frames.size(); ++k) {
            EXPECT_LE(frames[k].high.x - frames[k].low.x, 40) << k;
            if (lean > 0 && k % 3 == 1) {
                // Of one direction with the fourth after it alone.
                EXPECT_NEAR(frames[k].low.x, patches[k].box.low.x, 1e-9);
            }
        }
    }
}

TEST(FramesOfSlices, end_where_a_slice_of_another_direction_draws_something) {
    Drawn drawn;
    drawn.slice(axial(0), {{{0, 0}, {10, 10}}});
    drawn.slice(axial(5), {{{0, 0}, {10, 10}}, {{30, 0}, {40, 10}}});
    // In the plane x = 25, from y = 2 to 8 and z = -4 to 4: through the first of them alone.
    const Plane across = make_plane({25, 0, 0}, {1, 0, 0});
    const Vec2 p = across.to_plane({25, 2, -4}), q = across.to_plane({25, 8, 4});
    Box2 box;
    box.extend(p);
    box.extend(q);
    drawn.slice(across, {box});
    const std::vector<Box2> frames = drawn.frames();
    expect_box(frames[0], {0, 0}, {25, 10});
    expect_box(frames[1], {0, 0}, {40, 10});
    // With its margin a frame ends there, but it is no smaller than what is drawn.
    expect_box(drawn.frames(4)[0], {0, 0}, {21, 10});
    expect_box(drawn.frames(30)[0], {0, 0}, {10, 10});
    expect_box(frames[2], box.low, box.high);
}

// Half-planes about an axis, the opposite ones of which nearly make one plane, each drawn on its own side.
TEST(FramesOfSlices, about_an_axis_are_their_own) {
    Drawn about_axis;
    for (int k = 0; k < 25; ++k) {
        const double angle = 2 * std::numbers::pi * k / 25;
        const Plane plane = make_plane({}, {-std::sin(angle), std::cos(angle), 0});
        Box2 box;
        for (const auto& [r, z] : {std::pair{0.0, -5.0}, std::pair{10.0, 5.0}})
            box.extend(plane.to_plane({r * std::cos(angle), r * std::sin(angle), z}));
        about_axis.slice(plane, {box});
    }
    const std::vector<Box2> frames = about_axis.frames();
    for (std::size_t k = 0; k < frames.size(); ++k) {
        const Box2 own = plane_patches(about_axis.set)[k].box;
        expect_box(frames[k], own.low, own.high);
    }
}

TEST(FramesOfSlices, that_draw_nothing_are_empty) {
    Drawn drawn;
    drawn.slice(axial(0), {});
    drawn.slice(axial(5), {{{0, 0}, {10, 10}}});
    EXPECT_TRUE(drawn.frames()[0].empty());
}

}  // namespace
}  // namespace anatomesh::plane_patches_test
