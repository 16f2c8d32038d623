#include "anatomesh/contour/planes/empty_slices.h"

#include <gtest/gtest.h>

#include "anatomesh/contour/cleaned_for_test.h"

namespace anatomesh::empty_slices_test {
namespace {

using namespace fixtures;

// A stack of squares at these heights, and planes without contours at others.
File stack(const std::vector<double>& drawn, const std::vector<double>& empty, Vec3 normal = {0, 0, 1}) {
    File file;
    const Plane across = make_plane({0, 0, 0}, normal);
    const auto plane_at = [&](double z) {
        const Vec3 origin = z * across.normal + 40 * across.u;  // anywhere on it
        file.raw.planes.push_back(make_plane(origin, normal));
        file.raw.plane_names.push_back("at " + std::to_string(static_cast<int>(z)));
    };
    for (const double z : empty) plane_at(z);
    for (const double z : drawn) {
        Points points;
        for (const Vec3& p : square(0, 0, 10, 0))
            points.push_back(p.x * across.u + p.y * across.v + z * across.normal);
        file.add(points, 0, ContourKind::closed_planar, static_cast<std::int32_t>(file.raw.planes.size()));
        plane_at(z);
    }
    return file;
}

std::vector<double> positions(const ContourSet& set, Vec3 normal = {0, 0, 1}) {
    std::vector<double> at;
    for (const Slice& slice : set.slices) at.push_back(dot(slice.plane.origin, normalized(normal)));
    return at;
}

TEST(EmptySlices, a_plane_that_is_named_and_not_drawn_on_is_a_slice) {
    const Cleaned run = clean(stack({0, 3, 9, 12}, {6}));
    ASSERT_TRUE(run.ok());
    ASSERT_EQ(positions(run.kept()), (std::vector<double>{0, 3, 6, 9, 12}));
    const Slice& empty = run.kept().slices[2];
    EXPECT_EQ(empty.contour_count, 0u);
    EXPECT_EQ(empty.first_contour, 2u);
    EXPECT_EQ(empty.name, "at 6");
    for (std::uint32_t s = 0; s < 5; ++s) {
        EXPECT_EQ(run.kept().contours_of(run.kept().slices[s]).size(), s == 2 ? 0u : 1u);
        for (const Contour& contour : run.kept().contours_of(run.kept().slices[s]))
            EXPECT_EQ(contour.slice, s);
    }
    EXPECT_EQ(run.count("W-CON-031"), 0u);
}

TEST(EmptySlices, of_a_tilted_stack_too) {
    const Vec3 normal{1, 2, 5};
    const Cleaned run = clean(stack({-30, -27, -21}, {-24}, normal));
    ASSERT_TRUE(run.ok());
    const std::vector<double> at = positions(run.kept(), normal);
    ASSERT_EQ(at.size(), 4u);
    for (int s = 0; s < 4; ++s) EXPECT_NEAR(at[static_cast<std::size_t>(s)], -30 + 3 * s, 1e-9);
    EXPECT_TRUE(all_parallel(run.kept(), 1e-6));
}

TEST(EmptySlices, of_slices_that_lean_against_each_other_too) {
    File file;
    for (int k = 0; k < 9; ++k) {
        const double angle = 0.03 * (k - 4);
        const Vec3 normal{-std::sin(angle), 0, std::cos(angle)};
        const Plane plane = make_plane({0, 0, 5.0 * k}, normal);
        file.raw.planes.push_back(plane);
        file.raw.plane_names.push_back("image " + std::to_string(k));
        if (k == 3) continue;
        Points points;
        for (const Vec3& p : square(-5, -5, 10, 0)) points.push_back(plane.to_space({p.x, p.y}));
        file.add(points, 0, ContourKind::closed_planar, k);
    }
    const Cleaned run = clean(file);
    ASSERT_TRUE(run.ok());
    ASSERT_EQ(run.kept().slices.size(), 9u);
    EXPECT_EQ(run.kept().slices.back().name, "image 3");
    EXPECT_EQ(run.kept().slices.back().contour_count, 0u);
    EXPECT_EQ(run.count("W-CON-031"), 0u);
}

TEST(EmptySlices, not_before_the_first_drawn_slice_nor_after_the_last) {
    const Cleaned run = clean(stack({0, 3, 6}, {-6, -3, 9, 12}));
    ASSERT_TRUE(run.ok());
    EXPECT_EQ(positions(run.kept()), (std::vector<double>{0, 3, 6}));
}

TEST(EmptySlices, one_beside_a_drawn_slice_or_named_twice_is_one_slice) {
    const Cleaned run = clean(stack({0, 3, 9}, {0.1, 6, 6, 2.9}));
    ASSERT_TRUE(run.ok());
    EXPECT_EQ(positions(run.kept()), (std::vector<double>{0, 3, 6, 9}));
}

TEST(EmptySlices, can_be_left_out_by_name) {
    CleanOptions options;
    options.without = {"at 6"};
    const Cleaned run = clean(stack({0, 3, 9, 12}, {6}), options);
    ASSERT_TRUE(run.ok());
    EXPECT_EQ(positions(run.kept()), (std::vector<double>{0, 3, 9, 12}));
}

TEST(EmptySlices, a_plane_whose_contours_were_dropped_is_not_empty) {
    File file = stack({0, 3, 9, 12}, {6});
    file.add({{5, 5, 6}}, 0, ContourKind::closed_planar, 0);  // a single point: nothing to read
    const Cleaned run = clean(file);
    ASSERT_TRUE(run.ok());
    EXPECT_EQ(positions(run.kept()), (std::vector<double>{0, 3, 9, 12}));
}

TEST(EmptySlices, C26_where_planes_cross_an_empty_one_tells_nothing_and_that_is_said) {
    File file = stack({0, 3, 9, 12}, {6});
    file.raw.planes.push_back(make_plane({5, 0, 0}, {1, 0, 0}));
    file.raw.plane_names.push_back("long axis");
    const Cleaned across = clean(file);  // empty itself: the stack's own stays
    ASSERT_TRUE(across.ok());
    EXPECT_EQ(across.kept().slices.size(), 5u);
    EXPECT_EQ(across.count("W-CON-031"), 1u);

    file.add({{5, 2, -1}, {5, 8, -1}, {5, 8, 13}, {5, 2, 13}}, 0, ContourKind::closed_planar,
             static_cast<std::int32_t>(file.raw.planes.size()) - 1);
    const Cleaned crossed = clean(file);
    ASSERT_TRUE(crossed.ok());
    EXPECT_EQ(crossed.kept().slices.size(), 5u);  // four and the long axis
    EXPECT_EQ(crossed.count("W-CON-031"), 1u);
    EXPECT_EQ(crossed.warning("W-CON-031").place.slice, "at 6");
}

}  // namespace
}  // namespace anatomesh::empty_slices_test
