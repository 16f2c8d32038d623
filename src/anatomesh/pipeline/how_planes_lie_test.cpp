#include "anatomesh/pipeline/how_planes_lie.h"

#include <gtest/gtest.h>

#include <cmath>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/sample/drawing_for_test.h"

namespace anatomesh::how_planes_lie_test {
namespace {

constexpr double pi = 3.14159265358979323846, radius = 20;
constexpr std::uint64_t any_number = 1'000'000;

// A ball on planes with these normals, which go through its centre, or are so far from it.
HowPlanesLie of_ball(const std::vector<Vec3>& normals, int corners, std::uint64_t spare_dense_above,
                     const std::vector<double>& heights = {}) {
    RawContours raw;
    raw.structures.push_back({1, "ball", {}});
    for (std::size_t k = 0; k < normals.size(); ++k) {
        const double h = heights.empty() ? 0 : heights[k], reach = std::sqrt(radius * radius - h * h);
        const Plane plane = make_plane(h * normals[k], normals[k]);
        raw.planes.push_back(plane);
        raw.plane_names.push_back("plane " + std::to_string(k));
        RawContour contour;
        contour.plane = static_cast<std::int32_t>(k);
        contour.first_point = static_cast<std::uint32_t>(raw.points.size());
        contour.point_count = static_cast<std::uint32_t>(corners);
        for (int i = 0; i < corners; ++i) {
            const double angle = 2 * pi * i / corners;
            raw.points.push_back(plane.to_space({reach * std::cos(angle), reach * std::sin(angle)}));
        }
        raw.contours.push_back(contour);
    }
    const ContourSet set = fixtures::kept(raw);
    RunContext context;
    const auto field = make_structure_field(set, {}, context);
    EXPECT_TRUE(field.ok());
    return how_planes_lie(set, arrangement_of(set), *field.value(), spare_dense_above);
}

std::vector<Vec3> about_an_axis(int planes) {
    std::vector<Vec3> normals;
    for (int k = 0; k < planes; ++k)
        normals.push_back({std::cos(pi * k / planes), std::sin(pi * k / planes), 0});
    return normals;
}

TEST(HowPlanesLie, parallel_ones_are_apart) {
    const HowPlanesLie planes = of_ball(std::vector<Vec3>(5, {0, 0, 1}), 40, any_number, {-12, -6, 0, 6, 12});
    EXPECT_TRUE(planes.apart);
    EXPECT_EQ(planes.density, 0);
    EXPECT_TRUE(planes.bear_all);
    EXPECT_FALSE(planes.dense || planes.crammed || planes.may_conform || planes.meet_cuts);
}

// Many vertices are too many about an axis, where all planes come together; elsewhere beyond what is spared.
TEST(HowPlanesLie, dense_ones_conform_unless_they_are_many_about_an_axis) {
    for (const auto& [planes, corners] : {std::pair{50, 70}, {90, 80}}) {
        SCOPED_TRACE(planes);
        std::vector<Vec3> jittered;
        std::vector<double> heights;
        for (int k = 0; k < planes; ++k) {
            heights.push_back(0.9 * radius * (2.0 * k / (planes - 1) - 1));
            jittered.push_back(normalized(Vec3{0.03 * std::sin(2.7 * k), 0.03 * std::cos(1.3 * k), 1}));
        }
        const HowPlanesLie sweep = of_ball(jittered, corners, any_number, heights),
                           axis = of_ball(about_an_axis(planes), corners, any_number);
        EXPECT_FALSE(sweep.apart || sweep.crammed || axis.crammed) << sweep.density << " " << axis.density;
        EXPECT_TRUE(sweep.dense && axis.dense) << sweep.density << " " << axis.density;
        EXPECT_TRUE(sweep.may_conform && sweep.bear_all);
        EXPECT_EQ(axis.may_conform, planes * corners <= 5000);
        EXPECT_TRUE(of_ball(jittered, corners, 1000, heights).crammed);
    }
}

TEST(HowPlanesLie, few_that_cross_conform_and_meet_cuts) {
    for (const std::vector<Vec3>& normals :
         {std::vector<Vec3>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, about_an_axis(6)}) {
        const HowPlanesLie planes = of_ball(normals, 60, any_number);
        EXPECT_FALSE(planes.apart || planes.dense || planes.crammed);
        EXPECT_TRUE(planes.bear_all && planes.may_conform && planes.meet_cuts);
    }
}

TEST(HowPlanesLie, of_many_that_are_dense_not_all_is_done) {
    const HowPlanesLie few = of_ball(about_an_axis(16), 20, any_number);
    EXPECT_TRUE(few.dense && few.bear_all && few.may_conform);
    EXPECT_FALSE(few.crammed);
    const HowPlanesLie spared = of_ball(about_an_axis(16), 20, 0);
    EXPECT_TRUE(spared.dense && spared.crammed);
    EXPECT_FALSE(spared.bear_all || spared.may_conform || spared.meet_cuts);
    const HowPlanesLie crammed = of_ball(about_an_axis(40), 20, any_number);
    EXPECT_TRUE(crammed.crammed);
    EXPECT_FALSE(crammed.may_conform);
}

}  // namespace
}  // namespace anatomesh::how_planes_lie_test
