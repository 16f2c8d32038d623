// Laws of the field of slices about an axis.
#include "anatomesh/field/planes/rotational_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/planes/general_field.h"
#include "anatomesh/field/rotational_fixtures_for_test.h"
#include "anatomesh/field/voxel_topology_for_test.h"

namespace anatomesh::rotational_field_test {
namespace {

using namespace fixtures;

constexpr double pi = std::numbers::pi;

std::shared_ptr<const StructureField> field_of(const ContourSet& set) {
    EXPECT_EQ(arrangement_of(set).kind, ArrangementKind::about_axis);
    RunContext context;
    return make_structure_field(set, {}, context).value();
}

Vec3 random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return normalized({normal(random), normal(random), normal(random)});
}

// From the middle of a solid to the field's surface along a direction, by halving.
double surface_at(const StructureField& field, Vec3 middle, Vec3 direction, double most) {
    double in = 0, out = most;
    for (int k = 0; k < 40; ++k) {
        const double half = 0.5 * (in + out);
        (field.value(0, middle + half * direction) < 0 ? in : out) = half;
    }
    return in;
}

// Mean distance from the true surface along rays from the middle.
double mean_error(const StructureField& field, const Ellipsoid& solid) {
    std::mt19937 random(3);
    double sum = 0;
    constexpr int rays = 2000;
    for (int k = 0; k < rays; ++k) {
        const Vec3 direction = random_direction(random);
        const double truth = 1 / (1 + Ellipsoid{{}, solid.half}.level(direction));
        sum += std::abs(surface_at(field, solid.middle, direction, 80) - truth);
    }
    return sum / rays;
}

TEST(RotationalField, C27_contours_are_where_it_is_zero_and_slices_as_they_are_drawn) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const int planes : {2, 3, 5, 12, 30}) {
        for (const double beside : {0.0, 0.2}) {
            const Plane axis = make_plane({3, -4, 2}, {unit(random), unit(random), 2});
            const Ellipsoid solid{{}, {30, 22, 40}};
            const std::vector<Plane> cut =
                beside_their_places(in_any_order(planes_about(axis, planes), random), beside, 0, random);
            const auto field = field_of(sections_of(solid, cut, 400));
            for (const Plane& plane : cut) {
                for (const Vec2 q : solid.section(plane, 400)) {
                    const Vec3 p = plane.to_space(q);
                    ASSERT_NEAR(field->value(0, p), 0, 1e-9);
                }
                for (int trial = 0; trial < 200; ++trial) {
                    const Vec3 p = plane.to_space({45 * unit(random), 45 * unit(random)});
                    if (std::abs(solid.level(p)) < 0.005) continue;
                    ASSERT_EQ(field->value(0, p) < 0, solid.level(p) < 0) << planes << " " << beside;
                }
            }
        }
    }
}

// A ring about an axis, on planes that show both of its sides, or that beside which they were drawn.
ContourSet ring_about(const Plane& axis, const std::vector<Plane>& planes, bool both_sides) {
    SetBuilder builder;
    for (const Plane& plane : planes) {
        builder.slice(plane);
        const Vec2 out = plane.to_plane(axis.origin + cross(plane.normal, axis.normal));
        builder.ring(0, circle(30 * out, 8, 80));
        if (both_sides) builder.ring(0, circle(-30 * out, 8, 80));
    }
    return builder.set;
}

void expect_ring(const StructureField& field, const Plane& axis) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int trial = 0; trial < 4000; ++trial) {
        const double a = pi * unit(random), b = pi * unit(random);
        for (const double off : {-0.2, 0.2}) {
            const double radius = 30 + (8 + off) * std::cos(b);
            const Vec3 p = axis.origin + (radius * std::cos(a)) * axis.u + (radius * std::sin(a)) * axis.v +
                           ((8 + off) * std::sin(b)) * axis.normal;
            ASSERT_EQ(field.value(0, p) < 0, off < 0) << a << " " << b;
        }
    }
    EXPECT_EQ(Voxels(field, 1.5).topology(), (Topology{1, 1, 0}));
}

TEST(RotationalField, C27_C30_a_solid_of_revolution_comes_back_from_few_slices) {
    const Plane axis = make_plane({5, 1, -2}, {0.3, 0.2, 1});
    for (const int planes : {2, 3, 4, 6, 9}) {
        SCOPED_TRACE(planes);
        expect_ring(*field_of(ring_about(axis, planes_about(axis, planes), true)), axis);
    }
}

TEST(RotationalField, C27_slices_that_are_drawn_on_one_side_of_the_axis_say_nothing_of_the_other) {
    const Plane axis = make_plane({5, 1, -2}, {0.3, 0.2, 1});
    for (const int planes : {5, 7, 9, 15}) {  // an odd number: no two of them in one plane
        SCOPED_TRACE(planes);
        std::vector<Plane> all_round;
        for (int k = 0; k < planes; ++k) all_round.push_back(plane_about(axis, 2 * pi * k / planes));
        expect_ring(*field_of(ring_about(axis, all_round, false)), axis);
    }
}

TEST(RotationalField, is_nearer_to_the_truth_than_planes_in_any_position_are) {
    const Plane axis = make_plane({4, 2, 0}, {0.1, 0.2, 1});
    const Ellipsoid solid{{}, {30, 22, 40}};
    for (const int planes : {2, 3, 4, 6, 9, 13, 18}) {
        const ContourSet set = sections_of(solid, planes_about(axis, planes), 200);
        RunContext context;
        const auto general =
            make_general_field(set, slice_facts_of(set, default_max_gap, context).coverage, {}, context)
                .value();
        const double error = mean_error(*field_of(set), solid), before = mean_error(*general, solid);
        EXPECT_LT(error, 0.8 * before) << planes << ": " << error << " " << before;
    }
}

// By rays from the middle of a solid: its volume by the field over that of the truth.
double volume_share(const StructureField& field, const Ellipsoid& solid) {
    std::mt19937 random(6);
    double sum = 0, true_sum = 0;
    for (int k = 0; k < 4000; ++k) {
        const Vec3 direction = random_direction(random);
        const double truth = 1 / (1 + Ellipsoid{{}, solid.half}.level(direction));
        sum += std::pow(surface_at(field, solid.middle, direction, 80), 3);
        true_sum += std::pow(truth, 3);
    }
    return sum / true_sum;
}

TEST(RotationalField, C27_planes_beside_the_axis_tell_as_much_as_those_through_it) {
    // As the image of a probe may lie beside the axis that it is turned about; or as it is held by hand.
    const Plane axis = make_plane({4, 2, 0}, {0.1, 0.2, 1});
    const Ellipsoid solid{axis.origin, {30, 22, 40}};
    std::mt19937 random(12);
    for (const int planes : {6, 12, 24}) {
        for (const double beside : {0.5, 1.0, 2.0, 5.0}) {
            std::vector<Plane> cut = planes_about(axis, planes);
            for (Plane& plane : cut) plane.origin += beside * plane.normal;
            const auto field = field_of(sections_of(solid, cut, 200));
            EXPECT_EQ(Voxels(*field, 2).topology(), (Topology{1, 0, 0})) << planes << " " << beside;
            EXPECT_NEAR(volume_share(*field, solid), 1, 0.005 + 0.003 * beside) << planes << " " << beside;
        }
        for (const double beside : {0.5, 1.0}) {
            const std::vector<Plane> cut =
                beside_their_places(planes_about(axis, planes), beside, 0.02 * beside, random);
            const auto field = field_of(sections_of(solid, cut, 200));
            EXPECT_EQ(Voxels(*field, 2).topology(), (Topology{1, 0, 0})) << planes << " " << beside;
            EXPECT_NEAR(volume_share(*field, solid), 1, 0.01) << planes << " " << beside;
        }
    }
}

TEST(RotationalField, C21_a_thin_ring_that_leans_is_in_one_piece) {
    // Of 3 mm, round an axis that leans by 40 degrees against the probe's.
    const Plane axis = make_plane({}, {0, 0, 1});
    const Plane ring = make_plane({}, {std::sin(40 * pi / 180), 0, std::cos(40 * pi / 180)});
    const auto distance = [&](Vec3 p) {
        const Vec2 across = ring.to_plane(p);
        return length(Vec2{length(across) - 30, ring.signed_distance(p)}) - 3;
    };
    SetBuilder builder;
    for (const Plane& plane : planes_about(axis, 18)) {
        builder.slice(plane);
        const Vec3 way = normalized(cross(plane.normal, ring.normal));
        for (const double side : {-30.0, 30.0}) {
            const Vec2 centre = plane.to_plane(side * way);
            Ring contour;
            for (Vec2 out : circle({}, 1, 48)) {
                double in = 0, far = 20;
                for (int k = 0; k < 50; ++k) {
                    const double half = 0.5 * (in + far);
                    (distance(plane.to_space(centre + half * out)) < 0 ? in : far) = half;
                }
                contour.push_back(centre + in * out);
            }
            builder.ring(0, contour);
        }
    }
    EXPECT_EQ(Voxels(*field_of(builder.set), 0.8).topology(), (Topology{1, 1, 0}));
}

TEST(RotationalField, structures_that_share_a_wall_leave_no_gap_and_do_not_overlap) {
    // The two halves of a ball, and a third round both.
    constexpr int corners = 90;
    const Plane axis = make_plane({}, {0, 0, 1});
    SetBuilder builder(true);
    for (const Plane& plane : planes_about(axis, 10)) {
        builder.slice(plane);
        for (const bool upper : {true, false}) {
            Ring half;
            for (int k = 0; k <= corners; ++k) {
                const double angle = pi * k / corners + (upper ? 0 : pi);
                const Vec3 side = cross(axis.normal, plane.normal);
                half.push_back(
                    plane.to_plane(20 * std::cos(angle) * side + 20 * std::sin(angle) * axis.normal));
            }
            if (area_of(half) < 0) half = reversed(half);
            builder.ring(upper ? 0 : 1, half);
        }
    }
    const auto field = field_of(builder.set);
    ASSERT_TRUE(field->exclusive());
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<std::uint32_t> members;
    for (int trial = 0; trial < 20000; ++trial) {
        const Vec3 p{21 * unit(random), 21 * unit(random), 21 * unit(random)};
        field->members(p, members);
        const double radius = length(p);
        if (std::abs(radius - 20) < 0.3) continue;
        ASSERT_EQ(members.size(), radius < 20 ? 1u : 0u) << p.x << " " << p.y << " " << p.z;
        if (members.empty()) continue;
        EXPECT_LE(field->value(members[0], p), 0);
        EXPECT_GE(field->value(1 - members[0], p), 0);
        if (std::abs(p.z) > 0.01) {
            EXPECT_EQ(members[0], p.z > 0 ? 0u : 1u);
        }
    }
}

// About z, with u away from it.
std::vector<Plane> upright_planes(int count) {
    std::vector<Plane> planes = planes_about(make_plane({}, {0, 0, 1}), count);
    for (Plane& plane : planes) {
        plane.v = {0, 0, 1};
        plane.u = cross(plane.v, plane.normal);
    }
    return planes;
}

TEST(RotationalField, a_structure_drawn_on_single_slices_is_nowhere_on_others) {
    const std::vector<Plane> planes = upright_planes(6);
    for (const std::size_t second : {1u, 3u}) {
        SetBuilder builder;
        for (std::size_t k = 0; k < planes.size(); ++k) {
            builder.slice(planes[k]);
            builder.ring(0, circle({}, 20, 80));
            if (k == 1 || k == second) builder.ring(1, circle({12, 0}, 2, 20));
        }
        const auto field = field_of(builder.set);
        for (std::size_t k = 0; k < planes.size(); ++k) {
            for (const double x : {12.0, -12.0}) {
                const bool drawn = (k == 1 || k == second) && x > 0;
                EXPECT_EQ(field->value(1, planes[k].to_space({x, 0})) < 0, drawn) << k << " " << x;
            }
        }
    }
}

TEST(RotationalField, gaps_that_are_bridged_are_told_of) {
    const std::vector<Plane> planes = upright_planes(12);
    for (const int missing : {0, 1, 2}) {  // halves of a slice
        SetBuilder builder;
        for (std::size_t k = 0; k < planes.size(); ++k) {
            if (k == 5 && missing == 2) continue;
            builder.slice(planes[k]);
            builder.ring(0, circle({-20, 0}, 6, 40));
            if (k != 5 || missing == 0) builder.ring(0, circle({20, 0}, 6, 40));
        }
        RunContext context;
        ASSERT_TRUE(make_structure_field(builder.set, {}, context).ok());
        std::vector<Warning> told = context.warnings;
        std::erase_if(told, [](const Warning& w) { return w.code != "W-FLD-002"; });
        ASSERT_EQ(told.size(), missing > 0) << missing;
        if (missing == 0) continue;
        const std::string gaps = missing == 1 ? "1 gap, " : "2 gaps, ";
        EXPECT_EQ(told[0].place.value.find(gaps + "the widest 30.0 degrees"), 0u);
    }
}

TEST(RotationalField, C27_a_turn_that_was_not_finished_goes_on_round_the_axis_and_ends_elsewhere) {
    const Plane axis = make_plane({4, 2, 0}, {0.1, 0.2, 1});
    const Ellipsoid solid{axis.origin, {30, 22, 40}};
    const std::vector<Plane> all = planes_about(axis, 18);
    const std::vector<Plane> some{all.begin(), all.begin() + 13};  // 60 degrees are missing
    const auto codes_of = [](const ContourSet& set, std::shared_ptr<const StructureField>& field) {
        RunContext context;
        field = make_structure_field(set, {}, context).value();
        std::vector<std::string> codes;
        for (const Warning& warning : context.warnings) codes.push_back(warning.code);
        return codes;
    };
    std::shared_ptr<const StructureField> field;
    EXPECT_EQ(codes_of(sections_of(solid, some, 200), field), std::vector<std::string>{"W-FLD-002"});
    EXPECT_EQ(Voxels(*field, 2).topology(), (Topology{1, 0, 0}));
    EXPECT_NEAR(volume_share(*field, solid), 1, 0.01);

    // A ring, of which nothing tells that it goes on: what is drawn and half a slice on both sides.
    const std::vector<std::string> codes = codes_of(ring_about(axis, some, true), field);
    EXPECT_EQ(std::count(codes.begin(), codes.end(), "W-FLD-001"), 1);
    int inside = 0;
    for (int a = 0; a < 360; ++a) {
        const double angle = a * pi / 180;
        inside +=
            field->value(0, axis.origin + 30.0 * (std::cos(angle) * axis.u + std::sin(angle) * axis.v)) < 0;
    }
    EXPECT_NEAR(inside, 2 * 130, 4);
    EXPECT_EQ(Voxels(*field, 1.5).topology(), (Topology{2, 0, 0}));
}

TEST(RotationalField, box_holds_what_bulges_between_the_slices) {
    // Wide in directions that no plane runs in.
    const Plane axis = make_plane({}, {0, 0, 1});
    for (const int planes : {2, 3, 4, 7}) {
        const ContourSet set = sections_of({{}, {30, 30, 10}}, planes_about(axis, planes), 120);
        const auto field = field_of(set);
        const Box3 box = field->box(), own = field->box_of(0);
        for (int k = 0; k < 720; ++k) {
            const double angle = pi * k / 360;
            const Vec3 p{29.5 * std::cos(angle), 29.5 * std::sin(angle), 0};
            EXPECT_LT(field->value(0, p), 0) << planes << " " << angle;
            EXPECT_TRUE(box.contains(p) && own.contains(p));
        }
    }
}

}  // namespace
}  // namespace anatomesh::rotational_field_test
