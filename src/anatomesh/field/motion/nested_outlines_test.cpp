// Laws of outlines that correspond because one lies within the other.
#include "anatomesh/field/motion/nested_outlines.h"

#include <gtest/gtest.h>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/structure_field.h"

namespace anatomesh::nested_outlines_test {
namespace {

using namespace fixtures;

constexpr double gap = 3;

Boundary boundary(const std::vector<Ring>& rings) {
    return boundary_of(DistanceMap(edges_of(rings), 4.5), gap);
}

std::size_t pairs_of(const std::vector<Ring>& below, const std::vector<Ring>& above) {
    const Boundary lower = boundary(below), upper = boundary(above);
    const auto [in_below, in_above] = nested_outlines(lower, upper, gap);
    std::size_t pairs = 0;
    for (std::uint32_t n = 0; n < in_below.size(); ++n) {
        const NestedOutline& nested = in_below[n];
        if (nested.other == no_piece) continue;
        ++pairs;
        EXPECT_EQ(in_above[nested.other].other, n);
        EXPECT_EQ(in_above[nested.other].reach, nested.reach);
    }
    // Upside down it is the same.
    const auto turned = nested_outlines(upper, lower, gap);
    EXPECT_EQ(turned.second.size(), in_below.size());
    for (std::size_t n = 0; n < in_below.size(); ++n) EXPECT_EQ(turned.second[n].other, in_below[n].other);
    return pairs;
}

TEST(NestedOutlines, correspond_one_to_one_where_one_is_much_smaller) {
    const Ring large = circle({}, 20, 80), small = circle({3, 2}, 6, 30), near = circle({1, 1}, 15, 60);
    EXPECT_EQ(pairs_of({large}, {small}), 1u);
    EXPECT_EQ(pairs_of({large}, {near}), 0u);  // found without
    EXPECT_EQ(pairs_of({large}, {circle({40, 0}, 6, 30)}), 0u);
    EXPECT_EQ(pairs_of({large}, {circle({17, 0}, 6, 30)}), 0u);  // not within
    // A third one that the same outline could have become.
    EXPECT_EQ(pairs_of({large}, {small, circle({-8, -6}, 6, 30)}), 0u);
    EXPECT_EQ(pairs_of({large, circle({40, 0}, 6, 30)}, {small}), 1u);
    // Holes with holes, outlines with outlines.
    const Ring outer = circle({}, 40, 120);
    EXPECT_EQ(pairs_of({outer, reversed(large)}, {outer, reversed(small)}), 1u);
    EXPECT_EQ(pairs_of({outer, reversed(large)}, {circle({}, 22, 80)}), 1u);
}

// However far a cap shrinks from one slice to the next, and a little to the side, its boundary goes over from
// the one to the other evenly: no flat step half-way.
TEST(NestedOutlines, a_cap_that_shrinks_fast_has_no_step) {
    for (const double radius : {15.0, 24.0, 40.0}) {
        for (const double off : {0.0, 0.2}) {
            const double small = 0.3 * radius, shift = off * (radius - small);
            RunContext context;
            SetBuilder cap;
            cap.slice(axial(0));
            cap.ring(0, circle({}, radius, 120));
            cap.slice(axial(gap));
            cap.ring(0, circle({shift, 0}, small, 60));
            const auto field = make_structure_field(cap.set, {}, context);
            ASSERT_TRUE(field.ok());
            for (const double t : {0.2, 0.35, 0.65, 0.8}) {
                // Where it lies on rays from the centre, compared with the cone between the two.
                const Vec2 centre{t * shift, 0};
                const double expected = (1 - t) * radius + t * small;
                for (int k = 0; k < 12; ++k) {
                    const Vec2 direction{std::cos(0.5 * k), std::sin(0.5 * k)};
                    double low = 0, high = 1.5 * radius;
                    while (high - low > 1e-3) {
                        const double middle = 0.5 * (low + high);
                        const Vec2 q = centre + middle * direction;
                        (field.value()->value(0, {q.x, q.y, t * gap}) < 0 ? low : high) = middle;
                    }
                    EXPECT_NEAR(low, expected, 0.2 * (radius - small))
                        << radius << " " << off << " " << t << " " << k;
                }
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::nested_outlines_test
