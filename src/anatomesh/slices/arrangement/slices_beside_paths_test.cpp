// Laws of slices that keep the others from being along paths: each is found, and ordinary sets have none.
#include "anatomesh/slices/arrangement/slices_beside_paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "anatomesh/field/drawn_tubes_for_test.h"
#include "anatomesh/field/rotational_fixtures_for_test.h"

namespace anatomesh::slices_beside_paths_test {
namespace {

using namespace fixtures;

std::optional<SlicesBesidePaths> found_in(const ContourSet& set) {
    return slices_beside_paths(set, arrangement_of(set));
}

// Behind the slices of a set one more, with a rectangle about the middle.
ContourSet with_rectangle(ContourSet set, Vec3 middle, Vec3 along, Vec3 across, double length, double width,
                          std::uint32_t structure = 0) {
    const Vec3 corners[] = {
        middle - length * along - width * across, middle + length * along - width * across,
        middle + length * along + width * across, middle - length * along + width * across};
    Slice slice{make_plane(middle, cross(along, across)), static_cast<std::uint32_t>(set.contours.size()), 1,
                ""};
    set.contours.push_back({structure, static_cast<std::uint32_t>(set.slices.size()),
                            static_cast<std::uint32_t>(set.points.size()), 4});
    set.points.insert(set.points.end(), std::begin(corners), std::end(corners));
    set.slices.push_back(slice);
    return set;
}

Vec3 any_across(Vec3 along) {
    return normalized(cross(along, std::abs(along.y) < 0.8 ? Vec3{0, 1, 0} : Vec3{1, 0, 0}));
}

// Tubes that turn so far that their slices are no sweep.
std::vector<NamedTube> turning_tubes() {
    std::vector<NamedTube> made;
    for (const NamedTube& tube : random_tubes(80, 3)) {
        if (arrangement_of(drawn({tube.tube})).is_along_paths() && tube.name != "straight")
            made.push_back(tube);
    }
    return made;
}

TEST(SlicesBesidePaths, one_slice_along_a_tube_is_found_and_crosses) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0.2, 0.8);
    ASSERT_GE(turning_tubes().size(), 30u);
    for (const auto& [name, tube] : turning_tubes()) {
        const ContourSet set = drawn({tube});
        ASSERT_FALSE(found_in(set)) << name;
        const PathPoint at = tube.path.at(unit(random) * tube.path.length);
        const auto found = found_in(
            with_rectangle(set, at.at, at.along, any_across(at.along), 2.2 * tube.spacing, tube.radius(0)));
        ASSERT_TRUE(found && found->slices.size() == 1) << name << " " << tube.spacing;
        EXPECT_EQ(found->slices.front().slice, set.slices.size()) << name;
        EXPECT_TRUE(found->slices.front().crosses) << name;
        EXPECT_TRUE(found->structures.empty());
    }
}

TEST(SlicesBesidePaths, a_slice_far_from_all_others_is_found_and_crosses_none) {
    std::mt19937 random(4);
    for (const auto& [name, tube] : turning_tubes()) {
        const ContourSet set = drawn({tube});
        const Box3 box = set.box();
        const Vec3 along = random_direction(random),
                   far = 0.5 * (box.low + box.high) + 2 * box.diagonal() * along;
        const ContourSet more = with_rectangle(set, far, any_across(along), along, 9, 9);
        const auto found = found_in(more);
        ASSERT_TRUE(found && found->slices.size() == 1) << name;
        EXPECT_EQ(found->slices.front().slice, set.slices.size());
        EXPECT_FALSE(found->slices.front().crosses);
        RunContext context;
        warn_about_slices_beside_paths(more, arrangement_of(more), context);
        warn_about_slices_beside_paths(more, arrangement_of(more), context);
        ASSERT_EQ(context.warnings.size(), 1u);
        EXPECT_EQ(context.warnings.front().code, "W-FLD-018");
    }
}

// Up to a tenth of the slices; more are no exception any more.
TEST(SlicesBesidePaths, a_few_are_found_and_many_are_not) {
    const Tube tube{arch_path(60, 100, 30), [](double) { return 12.0; }, 4};
    ContourSet set = drawn({tube});
    const std::size_t count = set.slices.size();
    for (std::size_t more = 1; more < 12; ++more) {
        const PathPoint at = tube.path.at(static_cast<double>(21 * more));
        set = with_rectangle(std::move(set), at.at, at.along, any_across(at.along), 6, 12);
        const auto found = found_in(set);
        ASSERT_EQ(found.has_value(), more <= (count + more) / 10) << more;
        if (found) {
            EXPECT_EQ(found->slices.size(), more);
        }
    }
}

TEST(SlicesBesidePaths, a_structure_on_slices_of_its_own_is_found) {
    for (const auto& [name, tube] : turning_tubes()) {
        ContourSet set = drawn({tube});
        const std::size_t count = set.slices.size();
        const Box3 box = set.box();
        const Vec3 middle = 0.5 * (box.low + box.high) + Vec3{0, 1.5 * box.diagonal(), 0};
        for (double z = -16; z < 17; z += 8) {
            const double half = std::sqrt(400 - z * z);
            set = with_rectangle(std::move(set), middle + Vec3{0, 0, z}, {1, 0, 0}, {0, 1, 0}, half, half, 1);
            set = with_rectangle(std::move(set), middle + Vec3{z, 0, 0}, {0, 1, 0}, {0, 0, 1}, half, half, 1);
        }
        set.structures.push_back({2, "heart", {200, 0, 0}});
        const auto found = found_in(set);
        ASSERT_TRUE(found) << name;
        EXPECT_TRUE(found->slices.empty());
        EXPECT_EQ(found->structures, std::vector<std::uint32_t>{1});
        EXPECT_EQ(found->along_paths, std::vector<std::uint32_t>{0});
        EXPECT_GT(set.slices.size(), count);
    }
}

// Stacks that cross, fans, planes of a probe, long axes and planes anywhere, on solids of any size.
TEST(SlicesBesidePaths, ordinary_sets_that_cross_have_none) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(0, 1);
    std::size_t asked = 0;
    for (int n = 0; n < 240; ++n) {
        const Ellipsoid solid{{0, 0, 0},
                              {15 + 20 * unit(random), 15 + 20 * unit(random), 15 + 30 * unit(random)}};
        const double spacing = 3 + 7 * unit(random), lean = 0.6 * unit(random);
        std::vector<Plane> planes;
        const auto stack = [&](Vec3 normal, double from, double to) {
            for (double at = from; at < to; at += spacing) planes.push_back(make_plane(at * normal, normal));
        };
        if (n % 6 == 0) {
            stack({0, 0, 1}, -40, 40);
            stack({1, 0, 0}, -30, 30);
            if (n % 12 == 0) stack({0, 1, 0}, -30, 30);
        } else if (n % 6 == 1) {
            for (double a = 0; a < std::numbers::pi; a += 0.1 + 0.04 * spacing)
                planes.push_back(
                    make_plane({3 * lean, 0, 0}, {std::cos(a), std::sin(a), lean * (unit(random) - 0.5)}));
        } else if (n % 6 == 2) {
            for (double at = -40; at < 40; at += spacing * (0.5 + unit(random)))
                planes.push_back(
                    make_plane({0, 0, at}, {lean * (unit(random) - 0.5), lean * (unit(random) - 0.5), 1}));
            if (n % 12 == 2) planes.push_back(make_plane({0, 0, 0}, {1, 0.2, 0.1}));
        } else if (n % 6 == 3) {
            stack({0, 0, 1}, -35, 35);
            for (int k = 0; k < 3; ++k)
                planes.push_back(make_plane({0, 0, 0}, {std::cos(1.0 * k), std::sin(1.0 * k), 0}));
        } else if (n % 6 == 4) {
            for (int k = 0; k < 25; ++k) {
                const Vec3 normal = random_direction(random);
                planes.push_back(make_plane(24 * (unit(random) - 0.5) * normal, normal));
            }
        } else {
            for (int k = 0; k < 3 + n % 4; ++k)
                planes.push_back(make_plane({0, 0, 0}, {std::cos(0.5 * k), std::sin(0.5 * k), 0}));
        }
        const ContourSet set = sections_of(solid, planes, 60);
        const SliceArrangement arrangement = arrangement_of(set);
        asked += !arrangement.is_stack();
        EXPECT_FALSE(slices_beside_paths(set, arrangement)) << n;
    }
    EXPECT_GT(asked, 150u);
}

}  // namespace
}  // namespace anatomesh::slices_beside_paths_test
