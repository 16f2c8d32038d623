#include "anatomesh/contour/chosen_slices.h"

#include <gtest/gtest.h>

namespace anatomesh {
namespace {

// A triangle on each of some slices.
ContourSet stack(std::uint32_t count) {
    ContourSet set;
    set.structures = {{1, "one", {}}};
    for (std::uint32_t s = 0; s < count; ++s) {
        const double z = s;
        set.slices.push_back({make_plane({0, 0, z}, {0, 0, 1}), s, 1, "k = " + std::to_string(s)});
        set.contours.push_back({0, s, 3 * s, 3});
        set.points.insert(set.points.end(), {{0, 0, z}, {1, 0, z}, {0, 1, z}});
    }
    return set;
}

TEST(WithoutSlices, the_others_stay_as_they_are) {
    const ContourSet set = stack(5);
    for (std::uint32_t left_out = 0; left_out < 5; ++left_out) {
        const std::vector<std::string> names{"K=" + std::to_string(left_out)};
        const ContourSet part = without_slices(set, names).value();
        ASSERT_EQ(part.slices.size(), 4u);
        std::uint32_t slice = 0;
        for (std::uint32_t s = 0; s < 5; ++s) {
            if (s == left_out) continue;
            EXPECT_EQ(part.slices[slice].name, set.slices[s].name);
            const auto points = part.points_of(part.contours_of(part.slices[slice])[0]);
            EXPECT_EQ(points[1], (Vec3{1, 0, static_cast<double>(s)}));
            ++slice;
        }
    }
    EXPECT_EQ(without_slices(set, {}).value().slices.size(), 5u);
}

TEST(WithoutSlices, names_that_there_are_not_and_nothing_left_are_refused) {
    const std::vector<std::string> other{"k = 1", "k = 7"};
    const auto unknown = without_slices(stack(3), other);
    ASSERT_FALSE(unknown.ok());
    EXPECT_EQ(unknown.error().code, "E-CON-010");
    EXPECT_EQ(unknown.error().place.slice, "k = 7");
    EXPECT_EQ(unknown.error().next_step, "there are: k = 0, k = 1, k = 2");
    const std::vector<std::string> all{"k = 0", "k = 1", "k = 2"};
    EXPECT_EQ(without_slices(stack(3), all).error().code, "E-CON-011");
    const auto many = without_slices(stack(100), std::vector<std::string>{"k = 100"}).error();
    EXPECT_LT(many.next_step.size(), 500u);
}

}  // namespace
}  // namespace anatomesh
