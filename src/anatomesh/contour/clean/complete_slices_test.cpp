#include "anatomesh/contour/clean/complete_slices.h"

#include <gtest/gtest.h>

#include <random>

#include "anatomesh/contour/cleaned_for_test.h"

namespace anatomesh::complete_slices_test {
namespace {

using fixtures::circle;
using fixtures::clean;
using fixtures::Cleaned;
using fixtures::File;

std::string value_of(const Cleaned& cleaned, const std::string& code) {
    for (const Warning& warning : cleaned.warnings)
        if (warning.code == code) return warning.place.value;
    return "";
}

// The second structure is on every slice, the first on some: what the file calls complete is told as what it does not.
TEST(CompleteSlices, slices_without_a_structure_are_told_wherever_they_are) {
    std::mt19937 random(11);
    int told = 0;
    for (int round = 0; round < 60; ++round) {
        const int count = 3 + static_cast<int>(random() % 12);
        const double spacing = 0.5 + 0.25 * (random() % 16);
        File file;
        int absent = 0, first = -1, last = -1;
        for (int k = 0; k < count; ++k) {
            file.add(circle(60, 0, 9, 24, spacing * k), 1);
            if (random() % 3 == 0) continue;
            if (first < 0) first = k;
            absent += last >= 0 ? k - last - 1 : 0;
            last = k;
            file.add(circle(0, 0, 10, 24, spacing * k), 0);
        }
        if (first < 0) continue;
        EXPECT_EQ(clean(file).count("W-FLD-003"), 0u) << "of slices that are not complete the field tells";
        file.raw.complete = true;
        file.raw.exclusive = round % 2 == 0;
        const Cleaned cleaned = clean(file);
        EXPECT_EQ(cleaned.count("W-FLD-003"), absent > 0 ? 1u : 0u);
        EXPECT_EQ(cleaned.count("W-FLD-014"), 0u);
        if (absent == 0) continue;
        ++told;
        EXPECT_EQ(value_of(cleaned, "W-FLD-003").find(std::to_string(absent) + " slices without it"), 0u);
    }
    EXPECT_GT(told, 30);
}

TEST(CompleteSlices, slices_further_apart_than_two_of_them_are_thick_are_told) {
    std::mt19937 random(12);
    for (int round = 0; round < 60; ++round) {
        File file;
        double height = 0, widest = 0;
        const double thickness = 0.5 + 0.5 * (random() % 6);
        const int slices = 2 + static_cast<int>(random() % 8);
        for (int k = 0; k < slices; ++k) {
            const double step = thickness * (1 + static_cast<double>(random() % (round % 2 ? 2 : 4)));
            if (k > 0) widest = std::max(widest, step);
            height += k > 0 ? step : 0;
            file.add(circle(0, 0, 10, 24, height), 0);
        }
        file.raw.slice_thickness_mm = thickness;
        EXPECT_EQ(clean(file).count("W-FLD-014"), 0u);
        file.raw.complete = true;
        EXPECT_EQ(clean(file).count("W-FLD-014"), widest > 2.04 * thickness ? 1u : 0u);
        file.raw.slice_thickness_mm = 0;
        EXPECT_EQ(clean(file).count("W-FLD-014"), 0u) << "nothing says how thick they are";
    }
}

}  // namespace
}  // namespace anatomesh::complete_slices_test
