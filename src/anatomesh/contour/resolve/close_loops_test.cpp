#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "anatomesh/contour/cleaned_for_test.h"

namespace anatomesh::close_loops_test {
namespace {

using namespace fixtures;

constexpr int steps = 40;

// A circle of radius 20 whose line crosses itself `count` times: in loops as wide outside of it, or inside,
// where what they enclose is drawn round twice. Each is a triangle of 0.375 squared widths.
Points slipped(int count, double width, bool inside) {
    Points points;
    for (int n = 0; n < steps; ++n) {
        const double angle = 2 * M_PI * n / steps;
        const Vec3 out{std::cos(angle), std::sin(angle), 0}, along{-out.y, out.x, 0};
        const Vec3 at = 20 * out + Vec3{0, 0, 10}, aside = (inside ? -width : width) * out;
        points.push_back(at);
        if (n % (steps / count) != 0) continue;
        points.push_back(at + 1.5 * width * along);
        points.push_back(at + 0.75 * width * along + aside);
        points.push_back(at + 0.75 * width * along - 0.3 * aside);
    }
    return points;
}

TEST(CloseLoops, slips_of_the_pen_are_no_holes_and_no_islands) {
    const double area = clean(File().add(circle(0, 0, 20, steps))).area();
    for (const bool inside : {false, true}) {
        for (const int count : {1, 4, 8}) {
            for (const double width : {0.02, 0.1, 0.2}) {
                SCOPED_TRACE(std::to_string(inside) + " " + std::to_string(count) + " " +
                             std::to_string(width));
                const File file = File().add(slipped(count, width, inside));
                CleanOptions as_drawn;
                as_drawn.rings.loop_mm2 = 0;
                const Cleaned all = clean(file, as_drawn), closed = clean(file);
                ASSERT_TRUE(all.ok() && closed.ok());
                EXPECT_EQ(all.kept().contours.size(), 1u + static_cast<std::size_t>(count));
                EXPECT_EQ(all.count("W-CON-030"), 0u);
                EXPECT_EQ(closed.kept().contours.size(), 1u);
                EXPECT_EQ(closed.count("W-CON-030"), 1u);
                EXPECT_EQ(closed.count("W-CON-020"), 0u);  // nothing is left that touches
                EXPECT_NEAR(closed.area(), area, 2e-3 * area);
                const ContourLog& log = closed.result.value().log[0];
                EXPECT_NE(
                    log.rule.find(std::to_string(count) + (count == 1 ? " loop closed" : " loops closed")),
                    std::string::npos);
                EXPECT_NEAR(log.area_change_mm2, 0.375 * width * width * count, 1e-6);
                const std::vector<Vec3>& kept = closed.kept().points;
                EXPECT_EQ(log.points_kept, std::count_if(kept.begin(), kept.end(), [&](Vec3 p) {
                              return std::find(file.raw.points.begin(), file.raw.points.end(), p) !=
                                     file.raw.points.end();
                          }));
            }
        }
    }
}

TEST(CloseLoops, what_is_not_small_stays_as_drawn) {
    // Above the bound by area, though small for the contour.
    const File large = File().add(slipped(1, 1.8, false));
    EXPECT_EQ(clean(large).kept().contours.size(), 2u);
    CleanOptions wider;
    wider.rings.loop_mm2 = 10;
    EXPECT_EQ(clean(large, wider).kept().contours.size(), 1u);
    // Below it, but a part of a contour as small: all is scaled.
    Points small = slipped(1, 3, false);
    for (Vec3& p : small) p = {0.02 * p.x, 0.02 * p.y, p.z};
    File with_scale;
    with_scale.add(small).add(circle(50, 0, 5, 30), 1);
    const Cleaned kept = clean(with_scale);
    ASSERT_TRUE(kept.ok());
    EXPECT_EQ(kept.count("W-CON-030"), 0u);
    // A small loop beside a large one.
    Points both = slipped(4, 0.2, false);
    const Points wide = slipped(1, 1.8, false);
    both.erase(both.begin(), both.begin() + 4);
    both.insert(both.begin(), wide.begin(), wide.begin() + 4);
    EXPECT_EQ(clean(File().add(both)).kept().contours.size(), 5u);
    // Contours of their own, which cross nothing, however small.
    const Cleaned islands =
        clean(File().add(circle(0, 0, 20, 60)).add(circle(30, 0, 0.1, 12)).add(circle(5, 0, 0.1, 12)));
    EXPECT_EQ(islands.kept().contours.size(), 3u);
}

// A contour of its own in a loop, outside of the large ring or in it, keeps its meaning, and the loop stays.
TEST(CloseLoops, what_another_contour_draws_in_a_loop_stays_what_it_is) {
    for (const bool inside : {false, true}) {
        SCOPED_TRACE(inside);
        const Points drawn = slipped(1, 0.5, inside);
        const Vec3 crossing = 0.5 * (drawn[0] + drawn[1]),
                   middle = (1.0 / 3) * (crossing + drawn[1] + drawn[2]);
        const File file = File().add(drawn).add(circle(middle.x, middle.y, 0.03, 8));
        const Cleaned run = clean(file);
        ASSERT_TRUE(run.ok());
        EXPECT_EQ(run.count("W-CON-030"), 0u);
        CleanOptions as_drawn;
        as_drawn.rings.loop_mm2 = 0;
        EXPECT_TRUE(same(run.kept(), clean(file, as_drawn).kept()));
        EXPECT_EQ(run.kept().contours.size(), 3u);
        // Beside the loop it is none of the loop's business.
        const Cleaned beside = clean(File().add(drawn).add(circle(0, 0, 0.03, 8)));
        EXPECT_EQ(beside.kept().contours.size(), 2u);
        EXPECT_EQ(beside.count("W-CON-030"), 1u);
        EXPECT_LT(beside.area(), clean(File().add(drawn)).area());  // still a hole
    }
}

// What two contours enclose together is a hole however small, whether or not one of them has a loop
// elsewhere.
TEST(CloseLoops, a_pocket_between_contours_is_no_loop) {
    // An arch on the circle, 0.04 mm2 of light under it.
    const Points arch{{-1, 19, 10},  {-0.1, 19, 10}, {-0.1, 20.2, 10}, {0.1, 20.2, 10},
                      {0.1, 19, 10}, {1, 19, 10},    {1, 21, 10},      {-1, 21, 10}};
    CleanOptions as_drawn;
    as_drawn.rings.loop_mm2 = 0;
    const Points slip = slipped(1, 0.2, false);
    const Cleaned plain = clean(File().add(circle(0, 0, 20, steps)).add(arch)),
                  closed = clean(File().add(slip).add(arch)),
                  all = clean(File().add(slip).add(arch), as_drawn);
    ASSERT_TRUE(plain.ok() && closed.ok() && all.ok());
    EXPECT_EQ(plain.kept().contours.size(), 2u);  // the outline of both, and the pocket
    EXPECT_EQ(closed.kept().contours.size(), 2u);
    EXPECT_EQ(closed.count("W-CON-030"), 1u);
    EXPECT_EQ(all.kept().contours.size(), 3u);
    const std::vector<Vec3>& kept = closed.kept().points;
    const auto drawn = [&](Vec3 p) { return std::find(slip.begin(), slip.end(), p) != slip.end(); };
    EXPECT_EQ(closed.result.value().log[0].points_kept, std::count_if(kept.begin(), kept.end(), drawn));
}

}  // namespace
}  // namespace anatomesh::close_loops_test
