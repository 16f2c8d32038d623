#include "anatomesh/live/draw/area/thin_line.h"

#include <gtest/gtest.h>

#include "anatomesh/live/draw/area/draw_fixtures.h"

namespace anatomesh::thin_line_test {
namespace {

using namespace draw_fixtures;

TEST(ThinLine, keeps_every_point_within_the_tolerance_and_the_ends) {
    for (int seed = 0; seed < 300; ++seed) {
        Random random(static_cast<unsigned>(seed));
        Polygon line = random() % 3
                           ? random_path(random, {3, 4}, whole(random, 0, 300), 0.5, uniform(random, 0, 0.3))
                           : random_scrawl(random);
        if (random() % 2) line.insert(line.end(), line.rbegin(), line.rend());
        const double tolerance = uniform(random, 0.001, 1);
        for (const Polygon& thinned : {thin_line(line, tolerance), thin_path(line, tolerance)}) {
            EXPECT_EQ(thinned.front(), line.front());
            EXPECT_EQ(thinned.back(), line.back());
            EXPECT_LE(thinned.size(), line.size());
            for (const Vec2 p : line) ASSERT_LE(distance_to_path(thinned, p), tolerance * (1 + 1e-9)) << seed;
            // And the other way round: the line passes near every point of the result.
            for (std::size_t i = 0; i + 1 < thinned.size(); ++i) {
                for (const double share : {0.25, 0.5, 0.75}) {
                    const Vec2 p = thinned[i] + share * (thinned[i + 1] - thinned[i]);
                    ASSERT_LE(distance_to_path(line, p), tolerance * (1 + 1e-9)) << seed;
                }
            }
        }
    }
}

TEST(ThinLine, of_a_straight_line_has_its_ends) {
    Polygon line;
    for (int n = 0; n <= 600; ++n) line.push_back({0.25 * n, 0.1 * n});
    EXPECT_EQ(thin_path(line, 0.01).size(), 2u);
    line.insert(line.end(), line.rbegin(), line.rend());
    EXPECT_EQ(thin_path(line, 0.01).size(), 3u);
    EXPECT_EQ(thin_path(Polygon{{1, 1}, {1, 1}}, 0.01).size(), 1u);
}

}  // namespace
}  // namespace anatomesh::thin_line_test
