#include "anatomesh/pipeline/run/effort.h"

#include <gtest/gtest.h>

#include <cmath>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/sample/drawing_for_test.h"

namespace anatomesh::effort_test {
namespace {

constexpr double pi = 3.14159265358979323846, radius = 20;
constexpr std::uint64_t any_number = 1'000'000;

bool is_crammed(const Effort& effort) {
    return effort.density == PlaneDensity::crammed;
}

RunConfig config_with(std::uint64_t spare_dense_above, std::size_t failures = 0) {
    RunConfig config;
    config.options.spare_dense_above = spare_dense_above;
    config.runs_before = config.ill_shaped_before = failures;
    return config;
}

// A ball on planes with these normals, which go through its centre, or are so far from it.
Effort of_ball(const std::vector<Vec3>& normals, int corners, const RunConfig& config,
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
    return effort_of(set, arrangement_of(set), *field.value(), config);
}

Effort of_ball(const std::vector<Vec3>& normals, int corners, std::uint64_t spare_dense_above,
               const std::vector<double>& heights = {}) {
    return of_ball(normals, corners, config_with(spare_dense_above), heights);
}

std::vector<Vec3> about_an_axis(int planes) {
    std::vector<Vec3> normals;
    for (int k = 0; k < planes; ++k)
        normals.push_back({std::cos(pi * k / planes), std::sin(pi * k / planes), 0});
    return normals;
}

std::vector<double> heights_of(int planes) {
    std::vector<double> heights;
    for (int k = 0; k < planes; ++k) heights.push_back(0.6 * radius * (2.0 * k / (planes - 1) - 1));
    return heights;
}

Effort of_stack(bool has_planes_across) {
    std::vector<Vec3> normals(7, {0, 0, 1});
    std::vector<double> heights = heights_of(7);
    if (has_planes_across) normals.insert(normals.end(), {{1, 0, 0}, {0, 1, 0}});
    heights.resize(normals.size(), 0);
    return of_ball(normals, 60, any_number, heights);
}

// Planes that meet in a line beside the ball.
Effort of_sweep() {
    std::vector<Vec3> normals;
    std::vector<double> heights;
    for (int k = -2; k <= 2; ++k) {
        const double angle = 0.06 * k;
        normals.push_back({std::sin(angle), 0, std::cos(angle)});
        heights.push_back(-100 * std::sin(angle));
    }
    return of_ball(normals, 60, any_number, heights);
}

TEST(Effort, each_row_of_the_table_says_what_is_done_for_contours) {
    struct Row {
        const char* name;
        Effort effort;
        ArrangementKind arrangement;
        PlaneDensity density;
        bool conforms, fits_sections, recovers;
    };
    using Kind = ArrangementKind;
    using Density = PlaneDensity;
    const Row rows[] = {
        {"crammed", of_ball(about_an_axis(40), 20, any_number), Kind::about_axis, Density::crammed, false,
         false, false},
        {"dense about an axis", of_ball(about_an_axis(90), 80, any_number), Kind::about_axis,
         Density::dense_about_axis, false, false, false},
        {"parallel", of_stack(false), Kind::parallel, Density::sparse, false, false, true},
        {"sweep", of_sweep(), Kind::sweep, Density::sparse, false, false, true},
        {"stack and planes across", of_stack(true), Kind::stack_and_crossing, Density::sparse, true, false,
         true},
        {"about an axis", of_ball(about_an_axis(6), 60, any_number), Kind::about_axis, Density::sparse, true,
         true, true},
        {"in any position",
         of_ball({normalized(Vec3{1, 0.2, 0}), normalized(Vec3{0.1, 1, 0.3}), normalized(Vec3{0, -0.4, 1})},
                 60, any_number, {1, -2, 3}),
         Kind::general, Density::sparse, true, true, true},
    };
    for (const Row& row : rows) {
        SCOPED_TRACE(row.name);
        EXPECT_EQ(row.effort.arrangement, row.arrangement);
        EXPECT_EQ(row.effort.density, row.density);
        EXPECT_EQ(row.effort.conforming, row.conforms);
        EXPECT_EQ(row.effort.fits_sections, row.fits_sections);
        EXPECT_EQ(row.effort.recovery.has_value(), row.recovers);
    }
}

TEST(Effort, parallel_ones_are_apart) {
    const Effort planes = of_ball(std::vector<Vec3>(5, {0, 0, 1}), 40, any_number, {-12, -6, 0, 6, 12});
    EXPECT_TRUE(planes.is_apart());
    EXPECT_EQ(planes.plane_density, 0);
    EXPECT_TRUE(planes.recovery.has_value());
    EXPECT_FALSE(planes.is_dense() || is_crammed(planes) || planes.conforming || planes.fits_sections);
}

// Many vertices are too many about an axis, where all planes come together; elsewhere beyond what is spared.
TEST(Effort, dense_ones_conform_unless_they_are_many_about_an_axis) {
    for (const auto& [planes, corners] : {std::pair{50, 70}, {90, 80}}) {
        SCOPED_TRACE(planes);
        std::vector<Vec3> jittered;
        std::vector<double> heights;
        for (int k = 0; k < planes; ++k) {
            heights.push_back(0.9 * radius * (2.0 * k / (planes - 1) - 1));
            jittered.push_back(normalized(Vec3{0.03 * std::sin(2.7 * k), 0.03 * std::cos(1.3 * k), 1}));
        }
        const Effort sweep = of_ball(jittered, corners, any_number, heights),
                     axis = of_ball(about_an_axis(planes), corners, any_number);
        EXPECT_FALSE(sweep.is_apart() || is_crammed(sweep) || is_crammed(axis))
            << sweep.plane_density << " " << axis.plane_density;
        EXPECT_TRUE(sweep.is_dense() && axis.is_dense()) << sweep.plane_density << " " << axis.plane_density;
        EXPECT_TRUE(sweep.conforming && sweep.recovery.has_value());
        EXPECT_EQ(axis.conforming, planes * corners <= 5000);
        EXPECT_TRUE(is_crammed(of_ball(jittered, corners, 1000, heights)));
    }
}

TEST(Effort, few_that_cross_conform_and_meet_cuts) {
    for (const std::vector<Vec3>& normals :
         {std::vector<Vec3>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, about_an_axis(6)}) {
        const Effort planes = of_ball(normals, 60, any_number);
        EXPECT_FALSE(planes.is_apart() || planes.is_dense() || is_crammed(planes));
        EXPECT_TRUE(planes.recovery.has_value() && planes.conforming && planes.fits_sections);
    }
}

TEST(Effort, of_many_that_are_dense_not_all_is_done) {
    const Effort few = of_ball(about_an_axis(16), 20, any_number);
    EXPECT_TRUE(few.is_dense() && few.recovery.has_value() && few.conforming);
    EXPECT_FALSE(is_crammed(few));
    const Effort spared = of_ball(about_an_axis(16), 20, 0);
    EXPECT_TRUE(spared.is_dense() && is_crammed(spared));
    EXPECT_FALSE(spared.recovery.has_value() || spared.conforming || spared.fits_sections);
    const Effort crammed = of_ball(about_an_axis(40), 20, any_number);
    EXPECT_TRUE(is_crammed(crammed));
    EXPECT_FALSE(crammed.conforming);
}

// What a run leaves out for time it does where the user chose the size, and after a run that was not enough.
TEST(Effort, is_reduced_at_the_first_run_with_a_default_size_alone) {
    const std::vector<Vec3> normals = about_an_axis(16);
    const Effort first = of_ball(normals, 20, config_with(0));
    EXPECT_TRUE(first.reduced);
    EXPECT_EQ(first.improvement.sections, SectionRepair::none);
    EXPECT_GT(first.growth, Effort{}.growth);
    EXPECT_GT(first.refinement.crowded_sizes, 0);
    RunConfig of_user = config_with(0);
    of_user.size_given = true;
    for (const RunConfig& config : {of_user, config_with(0, 1)}) {
        const Effort full = of_ball(normals, 20, config);
        EXPECT_FALSE(full.reduced);
        EXPECT_EQ(full.improvement.sections, SectionRepair::all);
        EXPECT_EQ(full.growth, Effort{}.growth);
        EXPECT_EQ(full.refinement.crowded_sizes, 0);
        EXPECT_FALSE(full.conforming || full.recovery) << "all that can be done would still be too much";
    }
}

TEST(Effort, what_may_not_conform_does_not_but_fits_sections) {
    RunConfig config = config_with(any_number);
    config.may_conform = false;
    const Effort effort = of_ball(about_an_axis(6), 60, config);
    EXPECT_FALSE(effort.conforming);
    EXPECT_TRUE(effort.fits_sections && effort.recovery);
}

TEST(Effort, recovery_costs_less_after_each_run_that_was_ill_shaped) {
    const std::vector<Vec3> normals = about_an_axis(6);
    double most_more_bad = 1, least_shape = 0;
    for (std::size_t failures = 0; failures < 3; ++failures) {
        const Effort effort = of_ball(normals, 60, config_with(any_number, failures));
        ASSERT_TRUE(effort.recovery);
        EXPECT_LE(effort.recovery->most_more_bad, most_more_bad);
        EXPECT_GE(effort.recovery->least_shape, least_shape);
        if (failures > 0) {
            EXPECT_TRUE(effort.recovery->most_more_bad < most_more_bad ||
                        effort.recovery->least_shape > least_shape);
        }
        EXPECT_EQ(effort.recovery->few_missing > 0, failures == 0);
        EXPECT_GT(effort_at_pole(effort).recovery->few_missing, 0u);
        most_more_bad = effort.recovery->most_more_bad;
        least_shape = effort.recovery->least_shape;
    }
    EXPECT_FALSE(of_ball(normals, 60, config_with(any_number, 3)).recovery);
}

TEST(Effort, at_a_pole_the_worst_sections_are_repaired_alone) {
    const Effort across = of_ball(about_an_axis(6), 60, any_number);
    EXPECT_EQ(across.improvement.sections, SectionRepair::all);
    EXPECT_EQ(effort_at_pole(across).improvement.sections, SectionRepair::worst_at_last);
    EXPECT_FALSE(effort_at_pole(across).losses_wait);
    const Effort reduced = of_ball(about_an_axis(16), 20, config_with(0));
    EXPECT_EQ(effort_at_pole(reduced).improvement.sections, SectionRepair::none);
    EXPECT_LT(effort_at_pole(reduced).improvement.most_off_surface, 1);
    const Effort parallel = of_ball(std::vector<Vec3>(3, {0, 0, 1}), 40, any_number, {-6, 0, 6});
    EXPECT_EQ(effort_at_pole(parallel).improvement.sections, SectionRepair::all);
}

}  // namespace
}  // namespace anatomesh::effort_test
