#include "anatomesh/contour/model/chosen_slices.h"

#include <gtest/gtest.h>

#include <string>

#include "anatomesh/contour/cleaned_for_test.h"

namespace anatomesh::chosen_slices_test {
namespace {

using namespace fixtures;

TEST(ChosenSlices, leaves_out_the_slices_that_are_named) {
    File file, rest;
    const Points broken{{0, 0, 20}, {10, 10, 20}, {10, 0, 20}, {0, 10, 20}};  // crosses itself
    file.add(square(0, 0, 10, 10)).add(broken).add(square(1, 1, 10, 30));
    rest.add(square(0, 0, 10, 10)).add(square(1, 1, 10, 30));
    EXPECT_FALSE(clean(file).ok());
    CleanOptions options;
    for (const char* name : {"z = 20.0", "Z=20.0"}) {
        options.without = {name};
        const Cleaned cleaned = clean(file, options);
        ASSERT_TRUE(cleaned.ok()) << cleaned.result.error().message;
        EXPECT_TRUE(same(cleaned.kept(), clean(rest).kept()));
        EXPECT_EQ(cleaned.result.value().log[1].rule, "dropped: slice left out");
        ASSERT_EQ(cleaned.kept().left_out.size(), 1u);
        EXPECT_EQ(cleaned.kept().left_out[0].structure, 1);
        EXPECT_NEAR(cleaned.kept().left_out[0].plane.origin.z, 20, 1e-9);
    }
    options.without = {"z = 21.0"};
    EXPECT_EQ(clean(file, options).code(), "E-CON-010");
    options.without = {"z = 10.0", "z = 20.0", "z = 30.0"};
    EXPECT_EQ(clean(file, options).code(), "E-CON-011");
}

TEST(ChosenSlices, of_a_plane_that_is_given_twice_one_can_be_left_out) {
    File file;
    file.raw.planes = {make_plane({0, 0, 10}, {0, 0, 1}), make_plane({0, 0, 10}, {0, 0, 1}),
                       make_plane({0, 0, 20}, {0, 0, 1})};
    file.raw.plane_names = {"16", "17", "18"};
    file.add(square(0, 0, 10, 10), 0, ContourKind::closed_planar, 0)
        .add(square(4, 4, 12, 10), 0, ContourKind::closed_planar, 1)
        .add(square(0, 0, 10, 20), 0, ContourKind::closed_planar, 2);
    EXPECT_EQ(clean(file).code(), "E-CON-007");
    EXPECT_NE(clean(file).result.error().next_step.find("its planes: \"16\", \"17\""), std::string::npos);
    CleanOptions options;
    options.without = {"17"};
    const Cleaned first = clean(file, options);
    ASSERT_TRUE(first.ok()) << first.result.error().message;
    EXPECT_NEAR(first.area(), 100, 1e-9);
    EXPECT_EQ(first.result.value().log[1].rule, "dropped: slice left out");
    options.without = {"16"};
    EXPECT_NEAR(clean(file, options).area(), 144, 1e-9);
    options.without = {"16", "17"};
    EXPECT_EQ(clean(file, options).kept().slices.size(), 1u);
}

TEST(ChosenSlices, slices_are_called_as_in_the_file_where_it_gives_no_plane) {
    File file;
    file.add(square(0, 0, 10, 10)).add(square(0, 0, 10, 30)).add(square(0, 20, 10, 30));
    file.raw.contours[1].slice = "7";
    const Cleaned cleaned = clean(file);
    EXPECT_EQ(cleaned.kept().slices[0].name, "z = 10.0");
    EXPECT_EQ(cleaned.kept().slices[1].name, "7");
    CleanOptions options;
    options.without = {"7"};
    EXPECT_EQ(clean(file, options).kept().slices.size(), 1u);
}

}  // namespace
}  // namespace anatomesh::chosen_slices_test
