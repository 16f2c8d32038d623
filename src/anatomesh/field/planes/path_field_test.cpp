// Laws of the field of slices along paths, on families of tubes.
#include "anatomesh/field/planes/path_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/drawn_tubes_for_test.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/field/voxel_topology_for_test.h"

namespace anatomesh::path_field_test {
namespace {

using namespace fixtures;

std::shared_ptr<const StructureField> field_of(const ContourSet& set) {
    EXPECT_NE(arrangement_of(set).kind, ArrangementKind::general);
    RunContext context;
    return make_structure_field(set, {}, context).value();
}

double volume_in(const StructureField& field, std::uint32_t structure, std::uint32_t points = 200000) {
    RunContext context;
    VolumeOptions options;
    options.points_in_all = points;
    return field_volumes(field, structure + 1, options, context).value()[structure].by_field;
}

// How far beyond an end of the path the tube goes on, along its middle.
double end_of(const StructureField& field, const Tube& tube, bool last) {
    const double from = last ? tube.path.length - 1 : 1, way = last ? 1 : -1;
    double inside = 0, outside = 3 * tube.spacing + 1;
    const PathPoint at = tube.path.at(from);
    for (int k = 0; k < 40; ++k) {
        const double half = 0.5 * (inside + outside);
        (field.value(0, at.at + way * half * at.along) < 0 ? inside : outside) = half;
    }
    return inside - 1;
}

TEST(PathField, tubes_have_their_volume_and_end_half_a_spacing_beyond_their_last_contours) {
    ASSERT_GE(families_of_tubes().size(), 50u);
    for (const auto& [name, tube] : families_of_tubes()) {
        const auto field = field_of(drawn({tube}));
        EXPECT_NEAR(volume_in(*field, 0), volume_of(tube), 0.01 * volume_of(tube))
            << name << " " << tube.spacing;
        for (const bool last : {false, true})
            EXPECT_NEAR(end_of(*field, tube, last), 0, 0.1 * tube.spacing) << name << " " << tube.spacing;
    }
}

TEST(PathField, tubes_are_one_part_without_holes) {
    for (const auto& [name, tube] : families_of_tubes()) {
        const auto field = field_of(drawn({tube}));
        EXPECT_EQ(Voxels(*field, 0.45 * tube.radius(0)).topology(), (Topology{1, 0, 0}))
            << name << " " << tube.spacing;
    }
}

TEST(PathField, it_is_zero_at_contours_and_the_drawn_region_on_slices) {
    for (const auto& [name, tube] : families_of_tubes()) {
        const ContourSet set = drawn({tube});
        const auto field = field_of(set);
        for (const Vec3& p : set.points) ASSERT_EQ(field->value(0, p), 0) << name;
        for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
            const Plane& plane = set.slices[s].plane;
            const double radius = length(set.points_of(set.contours[s]).front() - plane.origin);
            EXPECT_LT(field->value(0, plane.to_space({0.9 * radius, 0})), 0) << name;
            EXPECT_GT(field->value(0, plane.to_space({0, 1.1 * radius})), 0) << name;
        }
    }
}

// Planes set by eye cross here and there; their tubes still have their volume and their ends and are one part.
TEST(PathField, tubes_on_planes_that_were_set_by_eye_stay_what_they_are) {
    std::size_t skipping = 0, n = 0;
    for (const auto& [name, tube] : random_tubes(48, 5)) {
        const ContourSet set = drawn_by_eye(tube, 1, 6, static_cast<unsigned>(++n));
        RunContext context;
        const SliceFacts facts = slice_facts_of(set, default_max_gap, context);
        const auto field = make_structure_field(set, facts, {}, context).value();
        EXPECT_NEAR(volume_in(*field, 0), volume_of(tube), 0.03 * volume_of(tube)) << name << " " << n;
        for (const bool last : {false, true})
            EXPECT_NEAR(end_of(*field, tube, last), 0, 0.5 * tube.spacing + 1.5) << name << " " << n;
        EXPECT_EQ(Voxels(*field, 0.25 * tube.radius(0)).topology(), (Topology{1, 0, 0})) << name << " " << n;
        if (name == "straight") continue;
        EXPECT_EQ(facts.arrangement.kind, ArrangementKind::along_paths) << name << " " << n;
        EXPECT_EQ(facts.arrangement.paths.size(), 1u) << name << " " << n;
        const std::vector<std::uint8_t> off = contours_off_paths(set, facts);
        const auto skipped = static_cast<std::size_t>(std::count(off.begin(), off.end(), 1));
        skipping += skipped > 0;
        EXPECT_LE(4 * skipped, set.slices.size()) << name << " " << n;
        const bool told = std::any_of(context.warnings.begin(), context.warnings.end(),
                                      [](const Warning& w) { return w.code == "W-FLD-019"; });
        EXPECT_EQ(told, skipped > 0) << name << " " << n;
        for (std::size_t c = 0; c < off.size(); ++c) {
            if (off[c]) continue;
            for (const Vec3& p : set.points_of(set.contours[c])) ASSERT_EQ(field->value(0, p), 0) << name;
        }
    }
    EXPECT_GT(skipping, 4u);
}

TEST(PathField, a_gap_is_told_by_the_slices_beside_it) {
    const Tube tube{arch_path(60, 100, 30), [](double) { return 12.0; }, 4};
    ContourSet set = drawn({tube});
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) set.slices[s].name = "s" + std::to_string(s);
    for (const std::uint32_t missing : {1u, 4u}) {
        std::vector<std::uint32_t> some;
        for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
            if (s < 30 || s >= 30 + missing) some.push_back(s);
        }
        ContourSet part = chosen_slices(set, some);
        part.left_out.clear();
        RunContext context;
        ASSERT_TRUE(make_structure_field(part, {}, context).ok());
        const auto told = std::find_if(
            context.warnings.begin(), context.warnings.end(),
            [&](const Warning& w) { return w.code == (missing == 1 ? "W-FLD-002" : "W-FLD-001"); });
        ASSERT_NE(told, context.warnings.end()) << missing;
        const std::string first = "s29", last = "s" + std::to_string(30 + missing);
        EXPECT_TRUE(told->place.slice == first + " and " + last ||
                    told->place.slice == last + " and " + first)
            << told->place.slice;
    }
}

// The volume of two tubes together, counted on a grid.
double counted_volume(const std::vector<Tube>& tubes, double step) {
    double inside = 0;
    Box3 box;
    for (const Tube& tube : tubes) {
        for (const double s : {0.0, tube.path.length}) {
            const Vec3 at = tube.path.at(s).at, reach{tube.radius(0), tube.radius(0), tube.radius(0)};
            box.extend(at - reach);
            box.extend(at + reach);
        }
    }
    for (double z = box.low.z + 0.37 * step; z < box.high.z; z += step) {
        for (double y = box.low.y + 0.41 * step; y < box.high.y; y += step) {
            for (double x = box.low.x + 0.57 * step; x < box.high.x; x += step) {
                inside += std::any_of(tubes.begin(), tubes.end(), [&](const Tube& tube) {
                    const PathPoint start = tube.path.at(0);
                    const Vec3 way = Vec3{x, y, z} - start.at;
                    const double along = dot(way, start.along);
                    return along > 0 && along < tube.path.length &&
                           length(way - along * start.along) < tube.radius(0);
                });
            }
        }
    }
    return inside * step * step * step;
}

// Y and T: branches at 30 to 90 degrees whose first slices lie in their parent.
TEST(PathField, branches_are_united_with_their_parent) {
    for (const double degrees : {30.0, 45.0, 60.0, 75.0, 90.0}) {
        for (const double radius : {4.0, 7.0}) {
            for (const double spacing : {2.5, 5.0}) {
                const double a = degrees * std::numbers::pi / 180;
                const Vec3 root{0, 0, 50}, tip = root + 60.0 * Vec3{std::sin(a), 0, std::cos(a)};
                const Tube trunk{straight_path({0, 0, 0}, {0, 0, 100}), [](double) { return 12.0; }, spacing};
                const Tube branch{straight_path(root, tip), [=](double) { return radius; }, spacing};
                const ContourSet set = drawn({trunk, branch});
                const auto field = field_of(set);
                const double right = counted_volume({trunk, branch}, 1.0);
                EXPECT_NEAR(volume_in(*field, 0), right, 0.015 * right)
                    << degrees << " " << radius << " " << spacing;
                EXPECT_EQ(Voxels(*field, 1.8).topology(), (Topology{1, 0, 0})) << degrees << " " << radius;
                RunContext context;
                const auto facts = slice_facts_of(set, default_max_gap, context);
                const auto inside = contours_inside_other_paths(set, facts, {}, context).value();
                const auto count = static_cast<std::size_t>(std::count(inside.begin(), inside.end(), 1));
                EXPECT_GT(count, 2u);
                EXPECT_LT(count, set.contours.size() / 2);
            }
        }
    }
}

TEST(PathField, a_structure_is_not_changed_by_a_branch_of_another_one) {
    for (const double degrees : {0.0, 20.0, 35.0}) {
        const double a = degrees * std::numbers::pi / 180;
        const Tube trunk{arch_path(60, 100, 30), [](double) { return 12.0; }, 4};
        const Tube branch{straight_path({0, 0, 90}, Vec3{40 * std::sin(a), 0, 90 + 40 * std::cos(a)}),
                          [](double) { return 5.0; }, 4, 1};
        const ContourSet both = drawn({trunk, branch});
        const auto field = field_of(both), alone = field_of(drawn({trunk}));
        std::mt19937 random(7);
        std::uniform_real_distribution<double> x(-45, 45), y(-15, 15), z(0, 140);
        for (int n = 0; n < 2000; ++n) {
            const Vec3 p{x(random), y(random), z(random)};
            EXPECT_EQ(field->value(0, p) < 0, alone->value(0, p) < 0);
        }
        EXPECT_NEAR(volume_in(*field, 1), volume_of(branch), 0.01 * volume_of(branch));
        RunContext context;
        const auto facts = slice_facts_of(both, default_max_gap, context);
        const auto inside = contours_inside_other_paths(both, facts, {}, context).value();
        EXPECT_EQ(std::count(inside.begin(), inside.end(), 1), 0);
    }
}

// Not joined, and told; a tube far off is nothing to tell of.
TEST(PathField, a_branch_that_ends_before_its_parent_is_told) {
    const Tube trunk{straight_path({0, 0, 0}, {0, 0, 80}), [](double) { return 12.0; }, 3};
    for (const double gap : {-6.0, 1.0, 3.0, 4.0, 20.0}) {
        for (const std::uint32_t structure : {0u, 1u}) {
            const Tube branch{straight_path({12 + gap, 0, 40}, {60 + gap, 0, 40}), [](double) { return 5.0; },
                              4, structure};
            RunContext context;
            ASSERT_TRUE(make_structure_field(drawn({trunk, branch}), {}, context).ok());
            const bool told = std::any_of(context.warnings.begin(), context.warnings.end(),
                                          [](const Warning& w) { return w.code == "W-FLD-017"; });
            EXPECT_EQ(told, structure == 0 && gap > 0 && gap < 10) << gap << " " << structure;
        }
    }
}

// Two to five slices of a fan: the part of a torus that its outline sweeps, and half a gap at each end.
TEST(PathField, few_slices_of_a_fan_give_what_the_outline_sweeps) {
    for (const double angle : {20.0, 40.0, 60.0, 90.0}) {
        for (const int count : {2, 3, 5}) {
            SetBuilder builder;
            for (int n = 0; n < count; ++n) {
                const double a = angle * n / (count - 1) * std::numbers::pi / 180;
                builder.slice(
                    make_plane({60 * std::cos(a), 60 * std::sin(a), 0}, {-std::sin(a), std::cos(a), 0}));
                builder.ring(0, circle({}, 20, corners_of_tube));
            }
            const double turned = angle * count / (count - 1) * std::numbers::pi / 180;
            const double right = area_of(circle({}, 20, corners_of_tube)) * 60 * turned;
            const auto field = field_of(builder.set);
            EXPECT_NEAR(volume_in(*field, 0, 2000000), right, 0.01 * right) << angle << " " << count;
            RunContext context;
            ASSERT_TRUE(make_structure_field(builder.set, {}, context).ok());
            const bool told = std::any_of(context.warnings.begin(), context.warnings.end(),
                                          [](const Warning& w) { return w.code == "W-FLD-008"; });
            if (count == 2 && angle > 40) {
                EXPECT_TRUE(told) << angle << " " << count;
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::path_field_test
