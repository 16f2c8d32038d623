// Where structures cross, touch or lie in each other, every surface stays near its own in the field.
#include <gtest/gtest.h>

#include "anatomesh/contour/trace/trace.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh::surface_near_field_test {
namespace {

using namespace fixtures;

constexpr double corner_spacing = 1.5;

// Slices at (n + phase) spacing, for all structures the same.
struct Slices {
    double spacing, phase;

    // `radius_at(z)`: of the disc there, its centre `centre_at(z)`; none where it is not positive.
    template <class Centre, class Radius>
    void add(Drawing& drawing, std::uint32_t structure, const Centre& centre_at,
             const Radius& radius_at) const {
        for (int n = -40; n <= 40; ++n) {
            const double z = (n + phase) * spacing, radius = radius_at(z);
            if (!(radius > 0)) continue;
            const int corners = std::max(6, static_cast<int>(2 * pi * radius / corner_spacing));
            drawing.add(structure, z, circle(centre_at(z), radius, corners));
        }
    }
    void add_ball(Drawing& drawing, std::uint32_t structure, Vec3 centre, double radius) const {
        add(
            drawing, structure,
            [&](double) {
                return Vec2{centre.x, centre.y};
            },
            [&](double z) {
                const double squared = radius * radius - (z - centre.z) * (z - centre.z);
                return squared > 0.01 * radius * radius ? std::sqrt(squared) : 0;
            });
    }
    // Its axis leans by `lean` a mm of height.
    void add_tube(Drawing& drawing, std::uint32_t structure, double lean, double radius) const {
        add(
            drawing, structure,
            [&](double z) {
                return Vec2{lean * z, 0};
            },
            [&](double z) { return std::abs(z) <= 14 ? radius : 0; });
    }
};

// No vertex of a surface, nor the middle of a facet, is much more than half an edge length from it.
TEST(SurfaceNearField, structures_that_cross_touch_or_lie_in_each_other_have_no_spikes) {
    for (const double spacing : {1.5, 2.0, 3.0}) {
        for (const double phase : {0.13, 0.5}) {
            const Slices slices{spacing, phase};
            std::array<Drawing, 4> drawings;
            slices.add_ball(drawings[0], 0, {}, 12);  // overlap
            slices.add_ball(drawings[0], 1, {10, 0, 2}, 8);
            slices.add_ball(drawings[1], 0, {}, 12);  // one in the other
            slices.add_ball(drawings[1], 1, {3, 2, 1}, 7);
            slices.add_ball(drawings[2], 0, {}, 10);  // touch
            slices.add_ball(drawings[2], 1, {18, 0, 0}, 8);
            slices.add_tube(drawings[3], 0, 0.6, 4);  // cross
            slices.add_tube(drawings[3], 1, -0.7, 3);
            for (std::size_t n = 0; n < drawings.size(); ++n) {
                SCOPED_TRACE("drawing " + std::to_string(n) + ", slices " + std::to_string(spacing) +
                             " mm apart, phase " + std::to_string(phase));
                const auto made = build(kept(drawings[n].raw));
                ASSERT_TRUE(made.ok()) << to_line(made.error());
                const ModelReport& report = made.value().report;
                EXPECT_LT(report.field.distance.max_mm, 0.55 * report.lengths.size_mm);
                EXPECT_GT(report.field.difference.points, 1000u);
                EXPECT_LT(report.field.difference.max_mm, 0.4 * report.lengths.size_mm);
            }
        }
    }
}

// Voxels of 1 x 1 x `step` mm: an organ, and a lesion of `slices` slices that touches it.
LabelMap organ_and_lesion(double step, double radius, std::uint32_t slices) {
    LabelMap map;
    map.geometry.size = {44, 44, 11};
    map.geometry.step = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, step}};
    map.voxels.assign(map.geometry.voxel_count(), 0);
    map.structures = {{1, "organ", {}}, {2, "lesion", {}}};
    for (std::uint32_t k = 1; k < 10; ++k) {
        for (std::uint32_t j = 0; j < 44; ++j) {
            for (std::uint32_t i = 0; i < 44; ++i) {
                std::uint16_t& voxel = map.voxels[map.geometry.index(i, j, k)];
                if (k >= 4 && k < 4 + slices && std::hypot(i - 24.0 - radius, j - 21.0) < radius) voxel = 2;
                if (std::hypot(i - 14.0, j - 21.0) < 11) voxel = 1;
            }
        }
    }
    return map;
}

// The lesion ends half-way to the next slice, and the organ's contours there are not its own.
TEST(SurfaceNearField, parts_that_touch_and_end_reach_to_no_contour_of_the_next_slice) {
    int far = 0;  // two have a flat cell along the wall that was relabelled to outside
    for (const double step : {2.0, 5.0}) {
        for (const double radius : {2.6, 4.2}) {
            for (const std::uint32_t slices : {1u, 2u, 3u}) {
                SCOPED_TRACE(std::to_string(step) + " mm, radius " + std::to_string(radius) + ", slices " +
                             std::to_string(slices));
                RunContext context;
                TraceOptions options;
                options.min_area_mm2 = 0;
                const auto traced =
                    trace_contours(organ_and_lesion(step, radius, slices), nullptr, 0, options, context);
                ASSERT_TRUE(traced.ok());
                const auto made = build(traced.value().kept);
                ASSERT_TRUE(made.ok()) << to_line(made.error());
                const ModelReport& report = made.value().report;
                EXPECT_LT(report.field.distance.max_mm, 0.65 * report.lengths.size_mm);
                far += report.field.distance.max_mm > 0.45 * report.lengths.size_mm;
            }
        }
    }
    EXPECT_LE(far, 2);
}

}  // namespace
}  // namespace anatomesh::surface_near_field_test
