#include "anatomesh/pipeline/run/contradicted_places.h"

#include <gtest/gtest.h>

#include <random>

#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::contradicted_places_test {
namespace {

using namespace crossing_fixtures;

std::vector<ContradictedPlace> places_of(const ContourSet& set, const std::vector<double>& weights) {
    RunContext context;
    return contradicted_places(set, weights, context);
}

TEST(ContradictedPlaces, slices_of_one_solid_have_none) {
    std::mt19937 random(1);
    for (const std::vector<Plane>& planes : {three_stacks(20, 5, 0.1), rotational_planes(8)}) {
        const ContourSet set = cut(polytope(22, 20, random), planes);
        EXPECT_GT(set.contours.size(), 7u);
        EXPECT_TRUE(places_of(set, std::vector<double>(set.slices.size(), 1)).empty());
    }
}

// A circle with a dent where others run through: from its floor up to where its contour ends, beyond which it
// says nothing, the others have the structure and it has not.
TEST(ContradictedPlaces, a_dent_has_one_on_each_of_its_lines) {
    std::mt19937 random(1);
    constexpr double floor = 15, reach = 6, radius = 20;
    ContourSet set = drawn_ball(radius, rotational_planes(8), {}, random);
    ASSERT_EQ(set.slices.size(), 8u);
    const Contour& dented = set.contours[2];
    double top = 0;
    for (std::uint32_t n = dented.first_point; n < dented.first_point + dented.point_count; ++n) {
        Vec3& p = set.points[n];
        if (p.z > 0 && std::hypot(p.x, p.y) < reach) p.z = floor;
        top = std::max(top, p.z);
    }
    std::vector<double> weights(set.slices.size(), 1);
    const std::vector<ContradictedPlace> places = places_of(set, weights);
    EXPECT_EQ(places.size(), 7u);
    for (const ContradictedPlace& place : places) {
        EXPECT_EQ(place.structure, 0u);
        for (const Vec3& p : {place.from, place.to}) EXPECT_LT(std::hypot(p.x, p.y), 1e-6) << "on the axis";
        EXPECT_NEAR(std::min(place.from.z, place.to.z), floor, 1e-6);
        EXPECT_NEAR(std::max(place.from.z, place.to.z), top, 1e-6);
    }
    weights[dented.slice] = 0;
    EXPECT_TRUE(places_of(set, weights).empty()) << "it says nothing of the structure";
}

}  // namespace
}  // namespace anatomesh::contradicted_places_test
