// Laws of the field of a stack with a few planes across it.
#include "anatomesh/field/planes/crossed_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/planes/general_field.h"
#include "anatomesh/field/voxel_topology_for_test.h"
#include "anatomesh/slices/arrangement/stack_and_crossing.h"

namespace anatomesh::crossed_field_test {
namespace {

using namespace fixtures;

constexpr double pi = std::numbers::pi;

// Where a ball round the origin meets a plane.
void add_ball(SetBuilder& builder, const Plane& plane, double radius) {
    const double h = plane.signed_distance({}), r2 = radius * radius - h * h;
    if (r2 > 0) builder.ring(0, circle(plane.to_plane({}), std::sqrt(r2), 80));
}

// Slices 3 mm apart from z = -21 to 21, the fifth leaning by so many degrees, and planes along z.
std::vector<Plane> stack_planes(double degrees, int along) {
    std::vector<Plane> planes;
    for (int k = -7; k <= 7; ++k)
        planes.push_back(make_plane({0, 0, 3.0 * k}, {k == -3 ? std::tan(degrees * pi / 180) : 0.0, 0, 1}));
    for (int n = 0; n < along; ++n) {
        const double angle = 0.3 + pi * n / along;
        planes.push_back(make_plane({0.4, 0.2, 0}, {std::cos(angle), std::sin(angle), 0.02}));
    }
    return planes;
}

ContourSet ball_on(const std::vector<Plane>& planes, double radius, double inner = 0) {
    SetBuilder builder;
    for (const Plane& plane : planes) {
        builder.slice(plane);
        add_ball(builder, plane, radius);
        if (inner > 0 && std::abs(plane.signed_distance({})) < inner) {
            const double h = plane.signed_distance({});
            builder.ring(0, reversed(circle(plane.to_plane({}), std::sqrt(inner * inner - h * h), 80)));
        }
    }
    return builder.set;
}

std::shared_ptr<const StructureField> field_of(const ContourSet& set) {
    RunContext context;
    return make_structure_field(set, {}, context).value();
}

TEST(CrossedField, the_few_that_run_across_or_lean_too_much_are_told_from_the_stack) {
    const auto of = [](const std::vector<Plane>& planes) {
        const auto slices = stack_and_crossing(ball_on(planes, 22.5));
        return slices ? slices->crossing : std::vector<std::uint32_t>{};
    };
    EXPECT_EQ(of(stack_planes(0, 1)), (std::vector<std::uint32_t>{15}));
    EXPECT_EQ(of(stack_planes(0, 3)), (std::vector<std::uint32_t>{15, 16, 17}));
    EXPECT_EQ(of(stack_planes(12, 0)), (std::vector<std::uint32_t>{4}));
    EXPECT_EQ(of(stack_planes(12, 2)), (std::vector<std::uint32_t>{4, 15, 16}));
    // As many across as along, an axis, and one structure that is drawn across alone: none.
    EXPECT_EQ(of(stack_planes(0, 8)), std::vector<std::uint32_t>{});
    ContourSet another = ball_on(stack_planes(0, 2), 22.5);
    another.structures.push_back(another.structures[0]);
    another.contours.back().structure = 1;
    EXPECT_FALSE(stack_and_crossing(another));
}

TEST(CrossedField, zero_exactly_at_every_contour_vertex_and_of_the_drawn_side_on_every_plane) {
    for (const auto& planes : {stack_planes(0, 2), stack_planes(12, 0), stack_planes(9, 3)}) {
        const ContourSet set = ball_on(planes, 20.3);
        ASSERT_TRUE(stack_and_crossing(set));
        const auto field = field_of(set);
        for (const Vec3& p : set.points) ASSERT_EQ(field->value(0, p), 0.0);
        for (const Slice& slice : set.slices) {
            if (slice.contour_count == 0) continue;
            const auto ring = set.points_of(set.contours[slice.first_contour]);
            const Vec3 centre = slice.plane.to_space(slice.plane.to_plane({}));
            for (const Vec3& p : ring) {
                EXPECT_LT(field->value(0, centre + 0.96 * (p - centre)), 0);
                EXPECT_GT(field->value(0, centre + 1.04 * (p - centre)), 0);
            }
        }
    }
}

// Planes that agree with the stack make it better where they are, and nowhere much worse; planes in any
// position would do worse.
TEST(CrossedField, planes_that_agree_leave_the_stack_what_it_is) {
    const double radius = 22.5;
    const auto error = [&](const StructureField& field, double& worst) {
        double sum = 0;
        int count = 0;
        worst = 0;
        for (int n = 0; n < 4000; ++n) {
            // Along a ray from the origin (Fibonacci's lattice on the sphere).
            const double z = 1 - (2 * n + 1) / 4000.0, turn = n * pi * (3 - std::sqrt(5.0));
            const Vec3 way{std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z};
            double low = 0.5 * radius, high = 1.5 * radius;
            for (int step = 0; step < 20; ++step) {
                const double middle = 0.5 * (low + high);
                (field.value(0, middle * way) < 0 ? low : high) = middle;
            }
            sum += std::abs(low - radius);
            worst = std::max(worst, std::abs(low - radius));
            ++count;
        }
        return sum / count;
    };
    double worst_alone = 0, worst = 0, worst_general = 0;
    const double alone = error(*field_of(ball_on(stack_planes(0, 0), radius)), worst_alone);
    for (const auto& planes : {stack_planes(0, 1), stack_planes(0, 2), stack_planes(12, 0)}) {
        const ContourSet set = ball_on(planes, radius);
        const double mean = error(*field_of(set), worst);
        RunContext context;
        const double general = error(
            *make_general_field(set, slice_facts_of(set, default_max_gap, context).coverage, {}, context)
                 .value(),
            worst_general);
        EXPECT_LT(mean, 1.15 * alone);
        EXPECT_LT(worst, 1.15 * worst_alone);
        EXPECT_LT(mean, 0.7 * general) << worst_general;
    }
}

// Thin walls are not torn by one slice that crosses its neighbours, nor by long axes.
TEST(CrossedField, C28_a_thin_wall_stays_whole) {
    for (const auto& planes : {stack_planes(12, 0), stack_planes(0, 1), stack_planes(8, 2)}) {
        const auto field = field_of(ball_on(planes, 22.5, 20));
        EXPECT_EQ(Voxels(*field, 0.9).topology(), (Topology{1, 0, 1}));
    }
}

// What the planes across tell of it holds near them alone.
TEST(CrossedField, a_structure_thinner_than_the_slices_are_apart_is_warned_of) {
    for (const double inner : {22.0, 0.0}) {
        RunContext context;
        ASSERT_TRUE(make_structure_field(ball_on(stack_planes(0, 1), 22.5, inner), {}, context).ok());
        const auto warned = std::count_if(context.warnings.begin(), context.warnings.end(),
                                          [](const Warning& w) { return w.code == "W-FLD-007"; });
        EXPECT_EQ(warned, inner > 0 ? 1 : 0);
    }
}

// A ball in a ball; the planes from `first` on draw one of the two alone.
ContourSet two_balls(const std::vector<Plane>& planes, std::size_t first, std::uint32_t drawn) {
    SetBuilder builder;
    for (std::size_t n = 0; n < planes.size(); ++n) {
        builder.slice(planes[n]);
        for (const std::uint32_t s : {0u, 1u}) {
            const Vec3 centre{s * 3.0, 0, s * 2.0};
            const double h = planes[n].signed_distance(centre), radius = s == 0 ? 22.5 : 10,
                         r2 = radius * radius - h * h;
            if (r2 > 0 && (n < first || s == drawn))
                builder.ring(s, circle(planes[n].to_plane(centre), std::sqrt(r2), 80));
        }
    }
    return builder.set;
}

// Of a structure that it does not draw a plane across says nothing: the field is that without the plane.
TEST(CrossedField, a_plane_across_says_nothing_of_what_it_does_not_draw) {
    const std::vector<Plane> planes = stack_planes(0, 2);
    for (const std::uint32_t drawn : {0u, 1u}) {
        const auto alone = field_of(two_balls(stack_planes(0, 0), 99, 0)),
                   all = field_of(two_balls(planes, 99, 0));
        for (const std::size_t first : {15u, 16u}) {
            const auto field = field_of(two_balls(planes, first, drawn));
            std::mt19937 random(7);
            std::uniform_real_distribution<double> unit(-22, 22);
            for (int n = 0; n < 2000; ++n) {
                const Vec3 p{unit(random), unit(random), unit(random)};
                if (first == 15) {
                    EXPECT_EQ(field->value(1 - drawn, p), alone->value(1 - drawn, p));
                }
                EXPECT_NEAR(field->value(drawn, p), all->value(drawn, p), 0.1);  // its box is smaller
            }
        }
    }
}

// A winding vessel thinner than the slices are apart: discs round a curve.
Vec2 vessel_at(double z) {
    return {2 * std::sin(z / 5), 2 * std::cos(z / 4)};
}

// Where the plane x = at cuts it: one ring for every stretch of z.
void add_vessel_along(SetBuilder& builder, double at) {
    constexpr double step = 0.05;
    const auto half = [&](double z) { return 1 - (at - vessel_at(z).x) * (at - vessel_at(z).x); };
    const Plane plane = make_plane({at, 0, 0}, {1, 0, 0});
    builder.slice(plane);
    for (double z = -18; z < 18;) {
        std::vector<double> heights;
        for (; z < 18 && half(z) <= 0.01; z += step) {
        }
        for (; z < 18 && half(z) > 0.01; z += step) heights.push_back(z);
        if (heights.size() < 8) continue;
        Ring ring;
        for (const int side : {1, -1}) {
            for (std::size_t n = 0; n < heights.size(); n += 4) {
                const double h = side > 0 ? heights[n] : heights[heights.size() - 1 - n];
                ring.push_back(plane.to_plane({at, vessel_at(h).y + side * std::sqrt(half(h)), h}));
            }
        }
        builder.ring(0, area_of(ring) > 0 ? ring : reversed(ring));
    }
}

// The more planes agree with the stack, the better: none of them takes anything off.
TEST(CrossedField, planes_along_a_winding_vessel_that_agree_do_not_shrink_it) {
    const auto volumes = [](const StructureField& field) {
        constexpr double step = 0.125;
        std::pair<double, double> made{0, 0};  // its own, and what is amiss
        for (double z = -15; z < 15; z += 2 * step) {
            for (double x = -4; x < 4; x += step) {
                for (double y = -4; y < 4; y += step) {
                    const bool inside = field.value(0, {x, y, z}) < 0;
                    made.first += inside ? 2 * step * step * step : 0;
                    if (inside != (length(Vec2{x, y} - vessel_at(z)) < 1))
                        made.second += 2 * step * step * step;
                }
            }
        }
        return made;
    };
    double alone = 0;
    for (const int planes : {0, 1, 2, 3}) {
        SetBuilder builder;
        for (int k = -9; k <= 9; ++k) {
            builder.slice(axial(2.0 * k));
            builder.ring(0, circle(vessel_at(2.0 * k), 1, 24));
        }
        for (int n = 0; n < planes; ++n) add_vessel_along(builder, -0.7 + 0.9 * n);
        if (planes > 0) {
            ASSERT_TRUE(stack_and_crossing(builder.set));
        }
        const auto [volume, amiss] = volumes(*field_of(builder.set));
        if (planes == 0) alone = volume;
        EXPECT_NEAR(volume, alone, 0.07 * alone) << planes;
        EXPECT_LT(amiss, 0.07 * alone) << planes;
    }
}

// Several that lie in the stack one after the other are no gap of it.
TEST(CrossedField, where_slices_were_taken_out_nothing_ends) {
    std::vector<Plane> planes = stack_planes(0, 0);
    for (const int k : {6, 7, 8}) planes[k] = make_plane(planes[k].origin, {k == 7 ? -0.2 : 0.2, 0.05, 1});
    const ContourSet set = ball_on(planes, 22.5);
    const auto slices = stack_and_crossing(set);
    ASSERT_TRUE(slices);
    ASSERT_GE(slices->crossing.size(), 2u);
    RunContext context;
    const auto field = make_structure_field(set, {}, context).value();
    EXPECT_EQ(Voxels(*field, 1.2).topology(), (Topology{1, 0, 0}));
    EXPECT_TRUE(context.warnings.empty()) << context.warnings.front().code;
}

// Beyond the last slice a plane along the axis says where the end is.
TEST(CrossedField, a_plane_across_bounds_the_end) {
    std::vector<Plane> planes = stack_planes(0, 1);
    planes.erase(planes.begin() + 13, planes.begin() + 15);  // the last slice is at z = 15
    const auto field = field_of(ball_on(planes, 22.5));
    const auto top = [&](Vec3 p) {
        double low = 15, high = 30;
        for (int step = 0; step < 20; ++step) {
            const double middle = 0.5 * (low + high);
            (field->value(0, {p.x, p.y, middle}) < 0 ? low : high) = middle;
        }
        return low;
    };
    const Plane& across = planes.back();
    const Vec3 on = across.origin + 2.0 * across.u - dot(across.u, Vec3{0, 0, 2}) * across.u;
    const Vec3 foot = across.to_space(across.to_plane({on.x, on.y, 22}));
    EXPECT_NEAR(top(foot), std::sqrt(22.5 * 22.5 - foot.x * foot.x - foot.y * foot.y), 0.1);
}

// A bridge over a gap 20 mm wide, its lower side so far below a slice that shows nothing of the gap: a plane
// across draws it. Beside the plane its ceiling goes on, a third as far as the slice is away at least.
TEST(CrossedField, a_ceiling_near_a_slice_goes_on_beside_the_plane_that_draws_it) {
    for (const double below : {0.5, 1.0, 2.0}) {
        SetBuilder builder;
        const auto draw = [&](const Plane& plane, const std::vector<Vec3>& corners) {
            Ring ring;
            for (std::size_t n = 0; n < corners.size(); ++n) {
                const Vec3 from = corners[n], way = corners[(n + 1) % corners.size()] - from;
                for (double at = 0; at < length(way) - 0.1; at += 2)
                    ring.push_back(plane.to_plane(from + at / length(way) * way));
            }
            builder.ring(0, ring);
        };
        for (int k = -3; k <= 2; ++k) {
            const double z = 8.0 * k;
            const Plane plane = make_plane({0, 0, z}, {0, 0, 1});
            builder.slice(plane);
            const auto box = [&](double low, double high) {
                draw(plane, {{-30, low, z}, {30, low, z}, {30, high, z}, {-30, high, z}});
            };
            if (k >= 0) {
                box(-25, 25);
            } else {
                box(-25, -10);
                box(10, 25);
            }
        }
        const Plane across = make_plane({0.3, 0, 0}, {1, 0, 0});
        builder.slice(across);
        draw(across, {{0.3, -25, -26},
                      {0.3, -10, -26},
                      {0.3, -10, -below},
                      {0.3, 10, -below},
                      {0.3, 10, -26},
                      {0.3, 25, -26},
                      {0.3, 25, 18},
                      {0.3, -25, 18}});
        const auto field = field_of(builder.set);
        for (const double beside : {-0.33, -0.1, 0.02, 0.1, 0.33}) {
            const Vec3 ceiling{0.3 + beside * below, 1, -below};
            EXPECT_GT(field->value(0, ceiling - Vec3{0, 0, 0.4 * below}), 0) << below << " " << beside;
            EXPECT_LT(field->value(0, ceiling + Vec3{0, 0, 0.4 * below}), 0) << below << " " << beside;
        }
    }
}

}  // namespace
}  // namespace anatomesh::crossed_field_test
