// Laws of the paraboloid caps that parts end with, on families of sections.
#include "anatomesh/field/stack/paraboloid_caps.h"

#include <gtest/gtest.h>

#include "anatomesh/field/field_fixtures.h"

namespace anatomesh::paraboloid_caps_test {
namespace {

using namespace fixtures;

constexpr double pi = std::numbers::pi;

DistanceMap map_of(const std::vector<Ring>& rings, double limit) {
    return DistanceMap(edges_of(rings), limit);
}

// The paraboloid cap of a disc of radius `r` that was one of radius `before` a gap of 3 mm earlier.
std::optional<ParaboloidCap> cap_of_disc(double r, double before, double gap, bool is_void) {
    const Ring outline = circle({}, 60, 200), larger = circle({}, before, 200);
    const DistanceMap section = map_of({circle({}, r, 200)}, 100);
    return is_void ? paraboloid_cap_of(section, true, map_of({outline, reversed(larger)}, 4.5), 3, gap)
                   : paraboloid_cap_of(section, false, map_of({larger}, 4.5), 3, gap);
}

double volume_of(const ParaboloidCap& paraboloid, double r) {
    double volume = 0;
    constexpr int rings = 2000;
    for (int n = 0; n < rings; ++n) {
        const double at = (n + 0.5) / rings * r;
        volume += 2 * pi * at * (r / rings) * paraboloid.height(at - r);
    }
    return volume;
}

// The cap of a ball above any slice that is less than 0.85 gaps below its pole.
TEST(ParaboloidCaps, of_balls_end_at_the_pole) {
    for (const double radius : {20.0, 40.0, 60.0}) {
        for (const double below : {0.1, 0.4, 1.0, 1.7, 2.5}) {
            for (const bool is_void : {true, false}) {
                const double z = radius - below;
                const double r = std::sqrt(radius * radius - z * z),
                             before = std::sqrt(radius * radius - (z - 3) * (z - 3));
                const std::optional<ParaboloidCap> paraboloid = cap_of_disc(r, before, 3, is_void);
                ASSERT_TRUE(paraboloid) << radius << " " << below;
                if (below < 2) {
                    EXPECT_TRUE(paraboloid->is_whole()) << radius << " " << below;
                }
                // Towards the pole a ball's sections shrink somewhat faster than between the slices.
                for (double at = 0; at < r; at += 0.1 * r) {
                    const double truth = std::sqrt(radius * radius - at * at) - z;
                    EXPECT_NEAR(paraboloid->height(at - r), truth, 0.2 + 0.1 * below)
                        << radius << " " << below;
                }
            }
        }
    }
}

// What would not end before the next slice has the volume of half the gap, and ends before it.
TEST(ParaboloidCaps, that_are_cut_off_have_the_volume_of_half_the_gap) {
    for (const double r : {2.0, 10.0, 20.0}) {
        for (const double wider : {1.39, 1.3, 1.2, 1.15}) {
            for (const double gap : {2.5, 3.0}) {
                const std::optional<ParaboloidCap> paraboloid = cap_of_disc(r, wider * r, gap, true);
                ASSERT_TRUE(paraboloid);
                const double height = paraboloid->height(-r);
                EXPECT_GT(height, 0.5 * gap);
                EXPECT_LE(height, 0.85 * gap + 1e-12);
                EXPECT_NEAR(volume_of(*paraboloid, r) / (pi * r * r * 0.5 * gap), 1, 0.04)
                    << r << " " << wider;
            }
        }
    }
}

TEST(ParaboloidCaps, are_for_what_shrinks) {
    for (const bool is_void : {true, false}) {
        for (const double before : {5.0, 9.0, 9.99, 10.0, 10.3})
            EXPECT_FALSE(cap_of_disc(10, before, 3, is_void)) << before;
    }
}

// On its slice the value is the distance; it is negative below the paraboloid cap alone, and does not jump.
TEST(ParaboloidCaps, values) {
    for (const ParaboloidCap& paraboloid : {ParaboloidCap(4, 1.5, 1.5), ParaboloidCap(10, 0.3, 0.3),
                                            ParaboloidCap(3, 9, 1.7), ParaboloidCap(0.5, 2.5, 2.5)}) {
        for (double d = -12; d < 6; d += 0.037) {
            EXPECT_EQ(paraboloid.value(d, 0), d);
            const double top = paraboloid.height(d);
            EXPECT_EQ(top > 0, d < 0);
            double last = d;
            for (double h = 0.01; h < 3; h += 0.01) {
                const double value = paraboloid.value(d, h);
                if (std::abs(h - top) > 1e-9) {
                    EXPECT_EQ(value < 0, h < top) << d << " " << h;
                }
                EXPECT_LT(std::abs(value - last), 0.2 + 2.1 * std::abs(d) * 0.01 / std::max(top, 0.01));
                EXPECT_NEAR(paraboloid.value(d + 1e-7, h), value, 1e-4);
                last = value;
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::paraboloid_caps_test
