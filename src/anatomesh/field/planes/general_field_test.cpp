#include "anatomesh/field/planes/general_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh::general_field_test {
namespace {

using namespace fixtures;

constexpr double radius = 20;

// A ball on three stacks that cross, or on planes through one axis.
ContourSet crossing_stacks() {
    SetBuilder builder;
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{0, 1, 0.1}, Vec3{1, 0.2, 0.1}}) {
        const Vec3 n = normalized(normal);
        for (double h = -18; h < radius; h += 4) {
            builder.slice(make_plane(h * n, n));
            builder.ring(0, circle({}, std::sqrt(radius * radius - h * h), 180, 0.3 * h));
        }
    }
    return builder.set;
}

ContourSet rotational_sweep() {
    SetBuilder builder;
    for (int k = 0; k < 12; ++k) {
        const double angle = std::numbers::pi * k / 12;
        builder.slice(make_plane({0, 0, 0}, {std::cos(angle), std::sin(angle), 0}));
        builder.ring(0, circle({}, radius, 180, 0.01));
    }
    return builder.set;
}

std::shared_ptr<const StructureField> field_of(const ContourSet& set) {
    RunContext context;
    return make_structure_field(set, {}, context).value();
}

// A ball on the planes through its middle with the given normals.
ContourSet ball_on(const std::vector<Vec3>& normals) {
    SetBuilder builder;
    for (const Vec3 normal : normals) {
        builder.slice(make_plane({}, normal));
        builder.ring(0, circle({}, radius, 180, 0.01));
    }
    return builder.set;
}

bool is_poorly_sampled(const ContourSet& set) {
    RunContext context;
    EXPECT_TRUE(make_structure_field(set, {}, context).ok());
    return std::any_of(context.warnings.begin(), context.warnings.end(),
                       [](const Warning& warning) { return warning.code == "W-FLD-008"; });
}

TEST(GeneralField, C30_few_planes_that_cross_are_told) {
    const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    EXPECT_TRUE(is_poorly_sampled(ball_on({x, y})));
    EXPECT_TRUE(is_poorly_sampled(ball_on({x, y, z})));
    for (const int count : {2, 3, 5, 6, 8, 12}) {
        std::vector<Vec3> normals;
        for (int k = 0; k < count; ++k) {
            const double angle = std::numbers::pi * k / count;
            normals.push_back({std::cos(angle), std::sin(angle), 0});
        }
        EXPECT_EQ(is_poorly_sampled(ball_on(normals)), count <= 3) << count;
    }
    // At an angle so narrow that the ball is a wafer beside them.
    for (const double degrees : {5.0, 10.0, 20.0, 30.0}) {
        const double angle = degrees * std::numbers::pi / 180;
        EXPECT_TRUE(is_poorly_sampled(ball_on({x, {std::cos(angle), std::sin(angle), 0}}))) << degrees;
    }
    // A plate that planes at right angles cut through its middle: they tell how thin it is.
    SetBuilder plate;
    for (const Vec3 normal : {x, y, z}) {
        plate.slice(make_plane({}, normal));
        Ring ring;
        for (int n = 0; n < 180; ++n) {
            const double t = 2 * std::numbers::pi * n / 180;
            const Vec2 q{std::cos(t), std::sin(t)};
            const Vec3 way = plate.set.slices.back().plane.to_space(q);
            ring.push_back(1 / std::sqrt((way.x * way.x + way.y * way.y) / 900 + way.z * way.z / 4) * q);
        }
        plate.ring(0, ring);
    }
    EXPECT_FALSE(is_poorly_sampled(plate.set));
    EXPECT_FALSE(is_poorly_sampled(crossing_stacks()));
    // A stack alone is not asked, and a plane across it takes nothing away.
    for (const double spacing : {2.0, 5.0, 8.0, 11.0}) {
        SetBuilder stack;
        for (double h = 0.5 * spacing - radius; h < radius; h += spacing) {
            stack.slice(make_plane({0, 0, h}, z));
            stack.ring(0, circle({}, std::sqrt(radius * radius - h * h), 90));
        }
        EXPECT_FALSE(is_poorly_sampled(stack.set)) << spacing;
        stack.slice(make_plane({}, x));
        stack.ring(0, circle({}, radius, 90));
        EXPECT_FALSE(is_poorly_sampled(stack.set)) << spacing;
    }
    // Two balls, and planes across through one of them alone: the other is drawn on the stack.
    SetBuilder stack;
    for (double h = -16; h < radius; h += 4) {
        stack.slice(make_plane({0, 0, h}, z));
        for (const double at : {-30.0, 30.0})
            stack.ring(0, circle({at, 0}, std::sqrt(radius * radius - h * h), 90));
    }
    stack.slice(make_plane({-30, 0, 0}, x));
    stack.ring(0, circle({}, radius, 90));
    EXPECT_FALSE(is_poorly_sampled(stack.set));
}

TEST(GeneralField, zero_exactly_at_every_contour_vertex) {
    for (const ContourSet& set : {crossing_stacks(), rotational_sweep()}) {
        const auto field = field_of(set);
        for (const Vec3& p : set.points) ASSERT_EQ(field->value(0, p), 0.0);
    }
}

TEST(GeneralField, C24_C27_the_ball_comes_back_inside_and_outside_near_its_surface) {
    std::mt19937 random(31);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const ContourSet& set : {crossing_stacks(), rotational_sweep()}) {
        const auto field = field_of(set);
        std::vector<std::uint32_t> members;
        for (int i = 0; i < 4000; ++i) {
            const Vec3 direction = normalized({unit(random), unit(random), unit(random)});
            field->members((radius - 1.5) * direction, members);
            ASSERT_EQ(members.size(), 1u) << direction.x << " " << direction.y << " " << direction.z;
            field->members((radius + 1.5) * direction, members);
            ASSERT_TRUE(members.empty()) << direction.x << " " << direction.y << " " << direction.z;
        }
        field->members({}, members);
        EXPECT_EQ(members.size(), 1u);
    }
}

// A ball on planes at random heights, some of which look the other way.
ContourSet freehand_planes(int planes) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(-1, 1);
    SetBuilder builder;
    for (int k = 0; k < planes; ++k) {
        const Vec3 n = normalized({0.05 * unit(random), 0.05 * unit(random), 1});
        const double h = 0.98 * radius * unit(random);
        builder.slice(make_plane(h * n, k % 5 == 3 ? -1 * n : n));
        builder.ring(0, circle({}, std::sqrt(radius * radius - h * h), 48, h));
    }
    return builder.set;
}

TEST(GeneralField, says_where_a_structure_is_thinner_than_the_planes_are_apart) {
    for (const double thickness : {1.0, 3.0, 40.0}) {
        SetBuilder builder;
        for (int k = 0; k < 12; ++k) {
            const double angle = k * std::numbers::pi / 12;
            const Vec3 along{std::cos(angle), std::sin(angle), 0};
            builder.slice({{}, along, {0, 0, 1}, cross(along, {0, 0, 1})});
            builder.ring(
                0, {{-30, -thickness / 2}, {30, -thickness / 2}, {30, thickness / 2}, {-30, thickness / 2}});
        }
        RunContext context;
        ASSERT_TRUE(make_structure_field(builder.set, {}, context).ok());
        const bool told = std::any_of(context.warnings.begin(), context.warnings.end(),
                                      [](const Warning& warning) { return warning.code == "W-FLD-007"; });
        EXPECT_EQ(told, thickness < 10) << thickness;
    }
}

TEST(GeneralField, gaps_between_freehand_planes_are_no_bubbles) {
    for (const int planes : {60, 240}) {
        std::mt19937 random(8);
        std::uniform_real_distribution<double> unit(-1, 1);
        const auto field = field_of(freehand_planes(planes));
        std::vector<std::uint32_t> members;
        int bubbles = 0;
        for (int i = 0; i < 20000; ++i) {
            const Vec3 p = 0.85 * radius * Vec3{unit(random), unit(random), unit(random)};
            if (length(p) > 0.85 * radius) continue;
            field->members(p, members);
            bubbles += members.empty();
        }
        EXPECT_EQ(bubbles, 0) << planes;
    }
}

TEST(GeneralField, on_a_plane_away_from_others_the_drawn_region_holds) {
    SetBuilder builder;
    const Ring notched{{-20, -20}, {20, -20}, {20, 20}, {0, 0}, {-20, 20}};
    builder.slice(axial(0));
    builder.ring(0, notched);
    builder.slice({{100, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}});  // crosses the first plane far away
    builder.ring(0, circle({}, 10, 40));
    const auto field = field_of(builder.set);
    EXPECT_LT(field->value(0, {0, -1, 0}), 0);
    EXPECT_GT(field->value(0, {0, 1, 0}), 0);
    EXPECT_LT(field->value(0, {100, 0, 9.9}), 0);
    EXPECT_GT(field->value(0, {100, 0, 10.1}), 0);
}

// An ellipsoid cut by planes: the sections, seen from the point of the plane nearest to the middle.
constexpr Vec3 axes{80, 60, 50};

double ellipsoid(Vec3 p) {
    return p.x * p.x / (axes.x * axes.x) + p.y * p.y / (axes.y * axes.y) + p.z * p.z / (axes.z * axes.z) - 1;
}

ContourSet cut_ellipsoid(const std::vector<Plane>& planes, int corners = 200) {
    SetBuilder builder;
    for (const Plane& plane : planes) {
        const Vec2 middle = plane.to_plane({});
        if (ellipsoid(plane.to_space(middle)) >= 0) continue;
        Ring ring;
        for (int i = 0; i < corners; ++i) {
            const double angle = 2 * std::numbers::pi * i / corners;
            const Vec2 ray{std::cos(angle), std::sin(angle)};
            double inside = 0, outside = 200;
            for (int step = 0; step < 50; ++step) {
                const double half = 0.5 * (inside + outside);
                (ellipsoid(plane.to_space(middle + half * ray)) < 0 ? inside : outside) = half;
            }
            ring.push_back(middle + inside * ray);
        }
        builder.slice(plane);
        builder.ring(0, ring);
    }
    return builder.set;
}

std::vector<Plane> fan(int count) {
    std::vector<Plane> planes;
    for (int k = 0; k < count; ++k) {
        const double angle = (-45 + 90.0 * k / (count - 1)) * std::numbers::pi / 180;
        planes.push_back(make_plane({0, 0, -120}, {std::cos(angle), 0, -std::sin(angle)}));
    }
    return planes;
}

std::vector<Plane> about_an_axis(int count) {
    std::vector<Plane> planes;
    for (int k = 0; k < count; ++k) {
        const double angle = std::numbers::pi * k / count;
        planes.push_back(make_plane({3, 2, 0}, {std::cos(angle), std::sin(angle), 0}));
    }
    return planes;
}

struct Errors {
    double mean = 0, p95 = 0;
};

// Distances of the field's surface from the truth along rays from the middle, in directions that `seen`
// accepts.
template <class Seen>
Errors errors_of(const StructureField& field, Seen seen) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<double> errors;
    while (errors.size() < 3000) {
        const Vec3 direction = normalized({unit(random), unit(random), unit(random)});
        const double truth = 1 / std::sqrt(ellipsoid(direction) + 1);
        if (!seen(truth * direction)) continue;
        double inside = 0.5 * truth, outside = 1.5 * truth;
        for (int step = 0; step < 40; ++step) {
            const double half = 0.5 * (inside + outside);
            (field.value(0, half * direction) < 0 ? inside : outside) = half;
        }
        errors.push_back(std::abs(inside - truth));
    }
    std::sort(errors.begin(), errors.end());
    Errors result;
    for (const double error : errors) result.mean += error / static_cast<double>(errors.size());
    result.p95 = errors[errors.size() * 95 / 100];
    return result;
}

TEST(GeneralField, C27_C28_thirty_six_planes_give_the_solid_back) {
    const Errors axis = errors_of(*field_of(cut_ellipsoid(about_an_axis(36))), [](Vec3) { return true; });
    EXPECT_LT(axis.mean, 0.045);
    EXPECT_LT(axis.p95, 0.15);
    const Errors swept = errors_of(*field_of(cut_ellipsoid(fan(36))), [](Vec3 p) {
        return std::abs(std::atan2(p.x, p.z + 120)) < 30 * std::numbers::pi / 180;
    });
    EXPECT_LT(swept.mean, 0.09);
    EXPECT_LT(swept.p95, 0.3);
}

// Beside one of its planes a point in a wide gap sees the other one too: else the gap is joined in its middle
// alone, and slits are cut along the planes.
TEST(GeneralField, a_gap_of_several_spacings_is_joined_from_plane_to_plane) {
    constexpr double spacing = 4;
    for (const double gap : {3.0, 4.0, 5.0}) {
        std::vector<Plane> planes;
        double z = -54;
        for (int k = 0; z < 54; ++k) {
            const double lean = (k % 2 == 0 ? 4 : -4) * std::numbers::pi / 180;
            planes.push_back(make_plane({0, 0, z}, {std::sin(lean), 0.3 * std::sin(lean), std::cos(lean)}));
            z += z < 10 && z + spacing >= 10 ? gap * spacing : spacing;
        }
        const ContourSet set = cut_ellipsoid(planes);
        const auto field = field_of(set);
        int missing = 0, all = 0;
        for (double x = -60; x <= 60; x += 2.5) {
            for (double y = -45; y <= 45; y += 2.5) {
                for (double at = -35; at <= 35; at += 0.5) {
                    const Vec3 p{x, y, at};
                    if (ellipsoid(1.05 * p) >= 0) continue;
                    ++all;
                    missing += field->value(0, p) >= 0;
                }
            }
        }
        EXPECT_LE(missing, 1e-4 * all) << gap;
    }
}

// Planes about an axis that is never quite the same meet in many lines at its poles. Reconciled, their
// contours have a vertex there for each, far nearer to each other than the planes are elsewhere.
TEST(GeneralField, planes_that_crowd_at_poles_fill_the_gaps_between_them_elsewhere) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Plane> planes = about_an_axis(60);
    for (Plane& plane : planes) plane.origin = plane.origin + 0.3 * Vec3{unit(random), unit(random), 0};
    RunContext context;
    for (const int corners : {80, 110, 200}) {
        const auto reconciled = reconcile_contours(cut_ellipsoid(planes, corners), {}, context);
        ASSERT_TRUE(reconciled.ok());
        const Errors errors = errors_of(*field_of(reconciled.value().kept), [](Vec3) { return true; });
        EXPECT_LT(errors.mean, 0.05) << corners;
        EXPECT_LT(errors.p95, 0.15) << corners;
    }
}

TEST(GeneralField, ends_of_a_sweep_are_flat_or_half_a_spacing_further) {
    std::vector<Plane> planes;
    for (int k = -8; k <= 8; ++k) {
        const double angle = k * std::numbers::pi / 180;
        planes.push_back(make_plane({0, 0, -200}, {std::cos(angle), 0, -std::sin(angle)}));
    }
    const ContourSet set = cut_ellipsoid(planes);
    RunContext context;
    FieldOptions flat;
    flat.caps = EndCaps::flat;
    const auto with_flat = make_structure_field(set, flat, context).value(), with_half = field_of(set);
    const Plane& last = set.slices.back().plane;
    const Vec3 middle = last.to_space(last.to_plane({}));
    const double away = dot(last.normal, middle) > 0 ? 1 : -1;
    const double spacing = length(middle) - length(set.slices[set.slices.size() - 2].plane.to_space(
                                                set.slices[set.slices.size() - 2].plane.to_plane({})));
    EXPECT_GT(with_flat->value(0, middle + (0.05 * away) * last.normal), 0);
    EXPECT_LT(with_flat->value(0, middle - (0.05 * away) * last.normal), 0);
    EXPECT_LT(with_half->value(0, middle + (0.4 * spacing * away) * last.normal), 0);
    EXPECT_GT(with_half->value(0, middle + (0.6 * spacing * away) * last.normal), 0);
}

TEST(GeneralField, the_surface_stays_within_a_spacing_of_what_the_planes_see) {
    const ContourSet set = cut_ellipsoid(about_an_axis(24));
    const auto field = field_of(set);
    const Box3 seen = set.box(), box = field->box();
    EXPECT_LT(box.high.x - seen.high.x, 15);
    EXPECT_LT(seen.low.z - box.low.z, 15);
}

TEST(GeneralField, changes_by_little_over_short_ways) {
    for (const ContourSet& set : {crossing_stacks(), freehand_planes(60), freehand_planes(240)}) {
        const auto field = field_of(set);
        std::mt19937 random(8);
        std::uniform_real_distribution<double> unit(-1, 1);
        int jumps = 0;
        for (int i = 0; i < 20000; ++i) {
            const Vec3 p = 22 * Vec3{unit(random), unit(random), unit(random)};
            const Vec3 q = p + 1e-4 * Vec3{unit(random), unit(random), unit(random)};
            jumps += std::abs(field->value(0, p) - field->value(0, q)) > 0.05;
        }
        EXPECT_LE(jumps, 1);  // where contours of planes that cross were not reconciled
    }
}

// A ball in a ball on stacks that cross and on planes about an axis; one plane in four, or all of one
// direction, leave the inner one out: it stays whole, and where all planes draw it nothing changes.
TEST(GeneralField, planes_that_leave_a_structure_out_say_nothing_of_it) {
    const auto inside_another = [](const ContourSet& balls, std::uint32_t every, std::uint32_t from) {
        SetBuilder builder;
        const Vec3 centre{2, 1, 3};
        for (std::uint32_t s = 0; s < balls.slices.size(); ++s) {
            const Plane& plane = balls.slices[s].plane;
            builder.slice(plane);
            Ring outer;
            for (const Vec3& p : balls.points_of(balls.contours[s])) outer.push_back(plane.to_plane(p));
            builder.ring(0, outer);
            const double h = plane.signed_distance(centre), r2 = 9 * 9 - h * h;
            if (r2 > 0 && (s < from || s % every != 1))
                builder.ring(1, circle(plane.to_plane(centre), std::sqrt(r2), 120));
        }
        return builder.set;
    };
    for (const ContourSet& balls : {crossing_stacks(), rotational_sweep()}) {
        const auto whole = field_of(inside_another(balls, 1000, 0));
        for (const auto& [every, from] : {std::pair{4u, 0u}, {1u, 20u}}) {
            if (from > balls.slices.size()) continue;
            const ContourSet set = inside_another(balls, every, from);
            const auto field = field_of(set);
            std::mt19937 random(3);
            std::uniform_real_distribution<double> unit(-1, 1);
            std::vector<std::uint32_t> members;
            for (int n = 0; n < 2000; ++n) {
                const Vec3 p = Vec3{2, 1, 3} + 18 * Vec3{unit(random), unit(random), unit(random)};
                EXPECT_NEAR(field->value(0, p), whole->value(0, p), 0.5);  // clamped a little otherwise
                const double distance = length(p - Vec3{2, 1, 3});
                field->members(p, members);
                const bool inside = std::find(members.begin(), members.end(), 1u) != members.end();
                if (distance < 7 || distance > 11.5) {
                    EXPECT_EQ(inside, distance < 7) << every << " " << distance;
                }
            }
        }
    }
}

TEST(GeneralField, far_from_all_planes_is_outside) {
    const auto field = field_of(crossing_stacks());
    std::vector<StructureField::Near> near;
    field->values_near({1000, 0, 0}, near);
    EXPECT_TRUE(near.empty());
    EXPECT_EQ(field->value(0, {1000, 0, 0}), field->clamp());
}

// Two balls beside each other, of one structure or of two, on axial slices; sagittal ones through the first
// alone.
ContourSet two_balls(bool of_one) {
    SetBuilder builder;
    const Vec3 middles[]{{0, 0, 0}, {40, 0, 0}};
    const double radii[]{14, 9};
    for (int k = -6; k <= 6; ++k) {
        const Plane plane = axial(2.2 * k + 0.1);
        bool first = true;
        for (std::uint32_t b = 0; b < 2; ++b) {
            const double height = plane.signed_distance(middles[b]),
                         square = radii[b] * radii[b] - height * height;
            if (square <= 0.5) continue;
            if (first) builder.slice(plane);
            first = false;
            builder.ring(of_one ? 0 : b, circle(plane.to_plane(middles[b]), std::sqrt(square), 60));
        }
    }
    for (double x = -12; x < 14; x += 3) {
        builder.slice(make_plane({x, 0, 0}, {1, 0, 0}));
        builder.ring(
            0, circle(builder.set.slices.back().plane.to_plane({x, 0, 0}), std::sqrt(14 * 14 - x * x), 60));
    }
    return builder.set;
}

TEST(GeneralField, what_one_slice_of_a_stack_does_not_draw_where_its_neighbours_do_is_not_there) {
    for (const bool of_one : {true, false}) {
        SCOPED_TRACE(of_one);
        const auto field = field_of(two_balls(of_one));
        const std::uint32_t structure = of_one ? 0 : 1;
        // Half a spacing beyond the last slice that draws it, not two.
        for (const double z : {-11.5, 11.5}) EXPECT_GT(field->value(structure, {40, 0, z}), 0) << z;
        for (const double z : {-7.0, 0.0, 7.0}) EXPECT_LT(field->value(structure, {40, 0, z}), 0) << z;
    }
}

// An ellipsoid that two passes of a probe show side by side, each what its images, 40 mm wide, hold of it;
// the passes interleave, and planes lean to and fro.
TEST(GeneralField, two_passes_of_a_probe_side_by_side_do_not_deny_each_other) {
    SetBuilder builder;
    const auto radius_at = [](double z) { return std::sqrt(std::max(0.0, 1 - z * z / 400)); };
    for (int k = -9; k <= 9; ++k) {
        for (const double side : {-1.0, 1.0}) {
            const double z = 2.0 * k + 0.5 * side, lean = 0.017 * ((k + 20) % 3 - 1);
            const double a = 34 * radius_at(z), b = 12 * radius_at(z);
            const Plane plane = make_plane({17 * side, 0, z}, {lean, 0, 1});
            builder.slice(plane);
            Ring ring;
            // What of the section lies within 20 mm of the image's middle.
            for (int n = 0; n < 90; ++n) {
                const double t = 2 * std::numbers::pi * n / 90;
                const double x = std::clamp(a * std::cos(t), 17 * side - 20, 17 * side + 20);
                const double y =
                    b * std::sqrt(std::max(0.0, 1 - x * x / (a * a))) * (std::sin(t) < 0 ? -1 : 1);
                const Vec2 q = plane.to_plane({x, y, z - lean * (x - 17 * side)});
                if (ring.empty() || length(q - ring.back()) > 1e-6) ring.push_back(q);
            }
            builder.ring(0, ring);
        }
    }
    const auto field = field_of(builder.set);
    for (double z = -15; z <= 15; z += 1) {
        for (const double share : {-0.7, -0.4, 0.0, 0.4, 0.7})
            EXPECT_LT(field->value(0, {34 * share * radius_at(z), 0, z}), 0) << share << " " << z;
    }
}

}  // namespace
}  // namespace anatomesh::general_field_test
