// Laws of which planes near each other are one slice, on families of stacks whose planes are not declared.
#include "anatomesh/contour/planes/near_planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace anatomesh::near_planes_test {
namespace {

using Points = std::vector<Vec3>;

struct Drawn {
    std::vector<Points> contours;
    std::vector<std::size_t> slices;  // the one that each contour was drawn on
    std::vector<std::uint32_t> structures;

    void circle(double z, double radius, std::size_t slice, Vec2 center = {}, std::uint32_t structure = 0) {
        const int count = 48;
        Points points;
        for (int i = 0; i < count; ++i) {
            const double angle = 2 * std::numbers::pi * (i + 0.3) / count;
            points.push_back({center.x + radius * std::cos(angle), center.y + radius * std::sin(angle), z});
        }
        contours.push_back(std::move(points));
        slices.push_back(slice);
        structures.push_back(structure);
    }
    void add_noise(double most, unsigned seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> off(-most, most);
        for (Points& points : contours) {
            for (Vec3& p : points) p.z += off(random);
        }
    }
    void turn(Vec3 normal) {
        const Plane plane = make_plane({3, -20, 7}, normal);
        for (Points& points : contours) {
            for (Vec3& p : points) p = plane.to_space({p.x, p.y}) + p.z * plane.normal;
        }
    }
    PlaneGroups group() const {
        std::vector<ContourToPlace> to_place;
        for (std::size_t c = 0; c < contours.size(); ++c)
            to_place.push_back({contours[c], -1, structures[c]});
        return group_planes(to_place, {}, {});
    }
    // Whether two contours share a slice where they were drawn on one, and only there; slices are parallel.
    bool is_grouped_as_drawn() const {
        const PlaneGroups groups = group();
        for (std::size_t c = 0; c < contours.size(); ++c) {
            for (std::size_t d = 0; d < c; ++d) {
                if ((slices[c] == slices[d]) != (groups.slice_of[c] == groups.slice_of[d])) return false;
            }
        }
        return std::all_of(groups.slices.begin(), groups.slices.end(),
                           [&](const Plane& plane) { return plane.normal == groups.slices[0].normal; });
    }
};

const std::vector<Vec3> normals{{0, 0, 1}, {0.3, -0.2, 1}};

// One file rounds the places of slices to a tenth for one structure and to a hundredth for another.
TEST(NearPlanes, of_different_structures_that_a_file_rounds_are_one_slice) {
    for (const double spacing : {1.25, 0.625, 2.35}) {
        Drawn drawn;
        for (std::size_t k = 0; k < 12; ++k) {
            const double z = spacing * static_cast<double>(k);
            drawn.circle(std::round(10 * z) / 10, 20, k, {}, 0);
            if (k == 5 || k == 6) drawn.circle(std::round(100 * z) / 100, 4, k, {5, 0}, 1);
        }
        EXPECT_TRUE(drawn.is_grouped_as_drawn()) << spacing;
    }
}

// Two legs of a bent tube whose slices lie a little apart along their normal, beside each other; the bend is drawn
// across its path. In a set without other planes they are one slice each, as two vessels on one image are.
TEST(NearPlanes, legs_of_a_bent_tube_keep_slices_of_their_own) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> between(0, 1);
    for (int n = 0; n < 60; ++n) {
        const double spacing = 3 + 4 * between(random), off = 0.03 + 0.9 * between(random);
        const double bend = 24 + 10 * between(random), radius = 5 + 7 * between(random);
        for (const bool has_bend : {true, false}) {
            Drawn legs;
            for (std::size_t k = 0; k < 10; ++k) {
                const double z = -spacing * static_cast<double>(k);
                legs.circle(z, radius, has_bend ? 2 * k : k, {-bend, 0});
                legs.circle(z - off, radius, has_bend ? 2 * k + 1 : k, {bend, 0});
            }
            for (int k = 1; has_bend && k < 12; ++k) {
                const double a = std::numbers::pi * k / 12;
                Points ring;
                for (int i = 0; i < 48; ++i) {
                    const double t = 2 * std::numbers::pi * (i + 0.3) / 48, out = bend + radius * std::cos(t);
                    ring.push_back({-out * std::cos(a), radius * std::sin(t), out * std::sin(a) + spacing});
                }
                legs.contours.push_back(std::move(ring));
                legs.slices.push_back(100 + static_cast<std::size_t>(k));
                legs.structures.push_back(0);
            }
            const PlaneGroups groups = legs.group();
            for (std::size_t c = 0; c < 20; ++c)
                for (std::size_t d = 0; d < c; ++d)
                    ASSERT_EQ(legs.slices[c] == legs.slices[d], groups.slice_of[c] == groups.slice_of[d])
                        << n << " " << c << " " << d << " spacing " << spacing << " off " << off;
        }
    }
}

TEST(NearPlanes, RS09_noise_off_the_planes_does_not_part_the_contours_of_a_slice) {
    for (const Vec3 normal : normals) {
        for (const double noise : {0.02, 0.05, 0.1, 0.3, 0.6}) {
            for (const double spacing : {0.5, 1.0, 2.0, 5.0}) {
                if (noise > 0.3 * spacing) continue;
                for (unsigned seed = 0; seed < 5; ++seed) {
                    Drawn drawn;
                    for (std::size_t k = 0; k < 12; ++k) {
                        const double z = spacing * static_cast<double>(k);
                        drawn.circle(z, 10, k);
                        drawn.circle(z, 6, k);
                        drawn.circle(z, 3, k, {30, 1});
                    }
                    drawn.add_noise(noise, seed);
                    drawn.turn(normal);
                    EXPECT_TRUE(drawn.is_grouped_as_drawn())
                        << "noise " << noise << " spacing " << spacing << " seed " << seed;
                }
            }
        }
    }
}

TEST(NearPlanes, RS09_of_a_noisy_axial_stack_are_axial) {
    for (const double noise : {0.1, 0.3, 0.6}) {
        Drawn drawn;
        for (std::size_t k = 0; k < 12; ++k) drawn.circle(2.0 * static_cast<double>(k), 10, k);
        drawn.add_noise(noise, 1);
        const PlaneGroups groups = drawn.group();
        ASSERT_EQ(groups.slices.size(), 12u);
        for (const Plane& plane : groups.slices) EXPECT_EQ(plane.normal, (Vec3{0, 0, 1}));
    }
}

TEST(NearPlanes, of_an_outline_and_its_hole_at_a_little_other_height_are_one_slice) {
    for (const Vec3 normal : normals) {
        for (const double share : {0.005, 0.05, 0.15, 0.25}) {
            for (const double wall : {1.0, 5.0}) {
                for (const double taper : {0.0, 0.3}) {  // mm a slice
                    if (taper > 0.1 * wall) continue;
                    Drawn drawn;
                    for (std::size_t k = 0; k < 10; ++k) {
                        const double z = 2.0 * static_cast<double>(k),
                                     r = 10 - taper * static_cast<double>(k);
                        drawn.circle(z, r, k);
                        if (k < 8) drawn.circle(z + 2 * share, r - wall, k);
                    }
                    drawn.turn(normal);
                    EXPECT_TRUE(drawn.is_grouped_as_drawn()) << share << ' ' << wall << ' ' << taper;
                }
            }
        }
    }
}

// A solid at two heights near each other: two slices, though one circle lies in the other.
TEST(NearPlanes, of_a_solid_stay_apart) {
    const std::vector<std::vector<double>> families{{0.3, 1.7},     {0.1, 1.9}, {0.5},    {0.3, 0.3, 4},
                                                    {2, 2, 0.2, 2}, {1, 3},     {0.25, 5}};
    for (const Vec3 normal : normals) {
        for (const std::vector<double>& gaps : families) {
            for (const double taper : {0.0, 0.1, 0.4}) {
                for (const bool is_tube : {false, true}) {
                    Drawn drawn;
                    double z = 0;
                    for (std::size_t k = 0; k < 16; ++k) {
                        drawn.circle(z, 20 - taper * z, k);
                        if (is_tube) drawn.circle(z, 8 - 0.1 * taper * z, k);
                        z += gaps[k % gaps.size()];
                    }
                    drawn.turn(normal);
                    EXPECT_TRUE(drawn.is_grouped_as_drawn()) << gaps[0] << ' ' << taper << ' ' << is_tube;
                }
            }
        }
    }
}

// A knob on the last slice of a solid looks like the hole of that slice: a pit in the model for a knob.
TEST(NearPlanes, of_a_knob_on_an_end_stay_apart) {
    for (const double radius : {2.0, 3.0, 4.0, 5.0, 8.0}) {
        for (const double gap : {0.2, 0.5, 0.9}) {
            for (const bool both : {false, true}) {
                Drawn drawn;
                for (std::size_t k = 0; k < 11; ++k) drawn.circle(3.0 * static_cast<double>(k), 10, k);
                drawn.circle(30 + gap, radius, 11);
                if (both) drawn.circle(-gap, radius, 12);
                EXPECT_TRUE(drawn.is_grouped_as_drawn()) << radius << " " << gap << " " << both;
            }
        }
    }
}

TEST(NearPlanes, of_structures_each_on_a_stack_of_its_own_stay_apart) {
    for (const double shift : {0.1, 0.3, 0.5, 1.0}) {
        Drawn drawn;
        for (std::size_t k = 0; k < 10; ++k) {
            drawn.circle(2.0 * static_cast<double>(k), 10, 2 * k, {}, 0);
            drawn.circle(2.0 * static_cast<double>(k) + shift, 5, 2 * k + 1, {4, 0}, 1);
        }
        EXPECT_TRUE(drawn.is_grouped_as_drawn()) << shift;
    }
}

// Files round places of slices to a hundredth; a lesion lies on few of an organ's slices, and beyond them.
TEST(NearPlanes, of_which_some_lack_a_structure_are_read) {
    constexpr double rounded = 0.06;
    for (const double spacing : {0.04, 0.1, 0.5, 1.0}) {
        for (std::size_t organ = 1; organ <= 6; ++organ) {
            for (std::size_t lesion = 1; lesion <= 3; ++lesion) {
                for (const double aside : {0.0, 12.0}) {
                    Drawn drawn;
                    for (std::size_t k = 0; k < organ; ++k)
                        drawn.circle(spacing * static_cast<double>(k), 10, k, {}, 0);
                    for (std::size_t k = 0; k < lesion; ++k) {
                        const double z = spacing * static_cast<double>(organ / 2 + k);
                        drawn.circle(z + 0.5 * rounded, 3, 100 + k, {aside, 0}, 1);
                        drawn.circle(z - 0.5 * rounded, 3, 100 + k, {-aside - 8, 0}, 1);
                    }
                    const PlaneGroups groups = drawn.group();
                    ASSERT_EQ(groups.slice_of.size(), drawn.contours.size());
                    for (const std::uint32_t slice : groups.slice_of)
                        EXPECT_LT(slice, groups.slices.size()) << spacing << " " << organ << " " << lesion;
                }
            }
        }
    }
}

TEST(NearPlanes, that_are_declared_stay_as_they_are) {
    std::vector<Plane> declared;
    Drawn drawn;
    for (std::size_t k = 0; k < 10; ++k) {
        drawn.circle(2.0 * static_cast<double>(k), 10, 2 * k);
        drawn.circle(2.0 * static_cast<double>(k) + 0.3, 5, 2 * k + 1);
    }
    std::vector<ContourToPlace> to_place;
    for (const Points& points : drawn.contours) {
        to_place.push_back({points, static_cast<std::int32_t>(declared.size())});
        declared.push_back(make_plane({0, 0, points[0].z}, {0, 0, 1}));
    }
    EXPECT_EQ(group_planes(to_place, declared, {}).slices.size(), 20u);
}

}  // namespace
}  // namespace anatomesh::near_planes_test
