// Laws of sweeps of slices and of the field between them, on families of leaning slices.
#include "anatomesh/slices/arrangement/sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/field/voxel_topology_for_test.h"

namespace anatomesh::sweep_test {
namespace {

using namespace fixtures;

constexpr double pi = std::numbers::pi;

// Planes 3 mm apart that each lean by up to so many degrees, in any direction.
std::vector<Plane> leaning_planes(int count, double degrees, std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1);
    const double most = std::tan(degrees * pi / 180) / std::sqrt(2.0);
    std::vector<Plane> planes;
    for (int k = 0; k < count; ++k)
        planes.push_back(make_plane({0, 0, 3.0 * k}, {most * unit(random), most * unit(random), 1}));
    return planes;
}

// Planes in a fan about the y axis, whose middle one looks along -x.
std::vector<Plane> fan_planes(int count, double degrees) {
    std::vector<Plane> planes;
    for (int k = 0; k < count; ++k) {
        const double angle = (k / (count - 1.0) - 0.5) * degrees * pi / 180;
        planes.push_back(make_plane({100 * std::cos(angle), 0, 100 * std::sin(angle)},
                                    {-std::sin(angle), 0, std::cos(angle)}));
    }
    return planes;
}

// A round tube round the line through `p` along `along`, cut by planes; every second plane the other way
// round and the slices in any order.
ContourSet tube(const std::vector<Plane>& planes, Vec3 p, Vec3 along, double radius, std::mt19937& random) {
    std::vector<std::size_t> order(planes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::shuffle(order.begin(), order.end(), random);
    along = normalized(along);
    const Plane across = make_plane(p, along);
    SetBuilder builder;
    for (const std::size_t k : order) {
        Plane plane = planes[k];
        if (k % 2) plane.normal = -1.0 * plane.normal, plane.v = -1.0 * plane.v;
        builder.slice(plane);
        Ring ring;
        for (const Vec2 q : circle({}, radius, 60)) {
            const Vec3 start = across.to_space(q);
            const Vec3 end = start - (plane.signed_distance(start) / dot(along, plane.normal)) * along;
            ring.push_back(plane.to_plane(end));
        }
        builder.ring(0, ring);
    }
    return builder.set;
}

std::vector<ContourSet> sweeps() {
    std::mt19937 random(11);
    std::vector<ContourSet> sets;
    for (int n = 0; n < 6; ++n) {
        sets.push_back(
            tube(leaning_planes(12, 0.3 + 0.3 * n, random), {0, 0, 16}, {0.4, -0.3, 1}, 9, random));
        sets.push_back(tube(fan_planes(20 + n, 30.0 + 10 * n), {100, 0, 0}, {0.2, 0.1 * n, 1}, 12, random));
    }
    return sets;
}

TEST(Sweep, every_slice_gets_a_height_of_its_own_and_keeps_its_shape) {
    for (const ContourSet& set : sweeps()) {
        const auto sweep = Sweep::of(set);
        ASSERT_TRUE(sweep);
        const ContourSet straight = sweep->to_chart(set);
        std::vector<double> heights;
        for (const Slice& slice : straight.slices) {
            const Contour& contour = straight.contours[slice.first_contour];
            const auto now = straight.points_of(contour), before = set.points_of(contour);
            heights.push_back(now.front().z);
            for (std::size_t n = 0; n < now.size(); ++n) {
                ASSERT_EQ(now[n].z, slice.plane.origin.z);
                ASSERT_EQ(now[n], sweep->to_chart(before[n]));
                ASSERT_NEAR(length(now[n] - now.front()), length(before[n] - before.front()), 1e-10);
            }
        }
        std::sort(heights.begin(), heights.end());
        EXPECT_EQ(std::adjacent_find(heights.begin(), heights.end()), heights.end());
    }
}

TEST(Sweep, chart_coordinates_of_parallel_slices_are_a_rigid_movement) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const std::vector<Plane> upright = leaning_planes(9, 0, random);
    const ContourSet set = tube(upright, {5, 4, 3}, {0.5, 0.1, 1}, 7, random);
    const auto sweep = Sweep::of(set);
    ASSERT_TRUE(sweep);
    for (int n = 0; n < 1000; ++n) {
        const Vec3 p = 30 * Vec3{unit(random), unit(random), unit(random)},
                   q = 30 * Vec3{unit(random), unit(random), unit(random)};
        ASSERT_NEAR(length(sweep->to_chart(p) - sweep->to_chart(q)), length(p - q), 1e-10);
    }
}

// Through the middle of the planes, where they do not cross: the same way all along, without a jump.
TEST(Sweep, rises_and_is_continuous_across_the_slices) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const ContourSet& set : sweeps()) {
        const auto sweep = Sweep::of(set);
        ASSERT_TRUE(sweep);
        const Box3 box = set.box();
        const Vec3 middle = 0.5 * (box.low + box.high);
        for (int line = 0; line < 20; ++line) {
            const double x = middle.x + 3 * unit(random), y = middle.y + 3 * unit(random);
            Vec3 last = sweep->to_chart({x, y, box.low.z});
            const double step = 0.01, way = sweep->to_chart({x, y, box.high.z}).z < last.z ? -1 : 1;
            for (double z = box.low.z + step; z < box.high.z; z += step) {
                const Vec3 next = sweep->to_chart({x, y, z});
                ASSERT_GT(way * (next.z - last.z), -1e-9);
                ASSERT_LT(length(next - last), 5 * step);
                last = next;
            }
        }
    }
}

TEST(Sweep, slices_that_cross_or_turn_too_far_are_none) {
    std::mt19937 random(2);
    const auto of = [&](std::vector<Plane> planes) {
        return Sweep::of(tube(planes, {0, 0, 16}, {0, 0, 1}, 9, random)).has_value();
    };
    const std::vector<Plane> good = leaning_planes(12, 1, random);
    EXPECT_TRUE(of(good));
    std::vector<Plane> crossing = good;
    crossing[5] = make_plane(good[5].origin, {std::tan(20 * pi / 180), 0, 1});
    EXPECT_FALSE(of(crossing));
    std::vector<Plane> near = good;  // does not cross, but nearly touches the next
    near[5] = make_plane(good[5].origin, {2.7 / 9, 0, 1});
    EXPECT_FALSE(of(near));
    std::vector<Plane> about_axis;
    for (int k = 0; k < 18; ++k)
        about_axis.push_back(make_plane({0, 0, 16}, {std::cos(k * pi / 18), std::sin(k * pi / 18), 0.5}));
    EXPECT_FALSE(of(about_axis));
    EXPECT_FALSE(of({good[0]}));
}

// A thin vessel that runs obliquely through a fan of up to 120 degrees, its planes either way round and in
// any order.
TEST(Sweep, C28_the_ends_of_a_fan_may_look_almost_120_degrees_apart) {
    for (const double degrees : {80.0, 95.0, 118.0}) {
        std::mt19937 random(static_cast<unsigned>(degrees));
        const std::vector<Plane> planes = fan_planes(49, degrees);
        std::vector<std::size_t> order(planes.size());
        std::iota(order.begin(), order.end(), 0u);
        std::shuffle(order.begin(), order.end(), random);
        SetBuilder builder;
        for (const std::size_t k : order) {
            const Vec3 middle = (60 + 0.6 * static_cast<double>(k)) / 100 * planes[k].origin +
                                Vec3{0, 0.9 * static_cast<double>(k), 0};
            Plane plane = planes[k];
            if (k % 2) plane.normal = -1.0 * plane.normal, plane.v = -1.0 * plane.v;
            builder.slice(plane);
            builder.ring(0, circle(plane.to_plane(middle), 2, 40));
        }
        ASSERT_TRUE(Sweep::of(builder.set)) << degrees;
        RunContext context;
        const auto field = make_structure_field(builder.set, {}, context).value();
        EXPECT_EQ(Voxels(*field, 0.8).topology(), (Topology{1, 0, 0})) << degrees;
    }
}

// A slice on which a structure is not drawn says that it is not there, as among parallel ones.
TEST(Sweep, a_slice_without_contours_is_one_of_them) {
    std::mt19937 random(2);
    SetBuilder builder;
    for (const Plane& plane : leaning_planes(12, 1, random)) {
        builder.slice(plane);
        if (builder.set.slices.size() <= 8) builder.ring(0, circle({}, 8, 30));
    }
    ASSERT_TRUE(Sweep::of(builder.set));
    RunContext context;
    const auto field = make_structure_field(builder.set, {}, context).value();
    EXPECT_LT(field->value(0, {0, 0, 22}), 0);
    EXPECT_GT(field->value(0, {0, 0, 23}), 0);
    for (const Vec3& p : builder.set.points) ASSERT_EQ(field->value(0, p), 0.0);
}

// Slices that were left out have their places among the others; one that crosses them has none.
TEST(Sweep, slices_left_out_lie_where_they_were) {
    for (const ContourSet& set : sweeps()) {
        for (std::uint32_t gone = 0; gone < set.slices.size(); ++gone) {
            const auto all = Sweep::of(set);
            ASSERT_TRUE(all);
            const std::vector<std::uint32_t> order = all->order();
            const auto place = std::find(order.begin(), order.end(), gone) - order.begin();
            if (place == 0 || place + 1 == std::ssize(order)) continue;
            std::vector<std::uint32_t> others(set.slices.size());
            std::iota(others.begin(), others.end(), 0u);
            others.erase(others.begin() + gone);
            ContourSet rest = chosen_slices(set, others);
            ASSERT_EQ(rest.left_out.size(), 1u);
            const Vec3 along = rest.left_out[0].plane.normal;
            rest.left_out.push_back({1, make_plane(rest.left_out[0].plane.origin, cross(along, {0, 1, 0}))});
            const auto sweep = Sweep::of(rest);
            ASSERT_TRUE(sweep);
            const ContourSet straight = sweep->to_chart(rest);
            ASSERT_EQ(straight.left_out.size(), 1u);
            const auto height_of = [&](std::uint32_t slice) {
                return straight.slices[slice - (slice > gone)].plane.origin.z;
            };
            const double before = height_of(order[static_cast<std::size_t>(place - 1)]),
                         after = height_of(order[static_cast<std::size_t>(place + 1)]),
                         share = (straight.left_out[0].plane.origin.z - before) / (after - before);
            EXPECT_GT(share, 0.3);
            EXPECT_LT(share, 0.7);
        }
    }
}

// One slice less of those that lean is a gap of two spacings, which are not twice one to the last digit.
TEST(SweptField, is_joined_over_a_slice_that_is_left_out) {
    std::mt19937 random(4);
    for (const ContourSet& set : {tube(fan_planes(21, 60), {100, 0, 0}, {0, 0, 1}, 12, random),
                                  tube(fan_planes(15, 25), {100, 0, 0}, {0.2, 0, 1}, 12, random)}) {
        for (std::uint32_t gone = 0; gone < set.slices.size(); ++gone) {
            std::vector<std::uint32_t> others(set.slices.size());
            std::iota(others.begin(), others.end(), 0u);
            others.erase(others.begin() + gone);
            RunContext context;
            const auto field = make_structure_field(chosen_slices(set, others), {}, context).value();
            const std::vector<std::uint32_t> order = Sweep::of(set)->order();
            if (order.front() == gone || order.back() == gone) continue;
            const auto ring = set.points_of(set.contours[set.slices[gone].first_contour]);
            const Vec3 centre =
                (1.0 / static_cast<double>(ring.size())) * std::accumulate(ring.begin(), ring.end(), Vec3{});
            for (const Vec3& p : ring) EXPECT_LT(field->value(0, centre + 0.9 * (p - centre)), 0) << gone;
            EXPECT_TRUE(std::none_of(context.warnings.begin(), context.warnings.end(),
                                     [](const Warning& w) { return w.code == "W-FLD-001"; }));
        }
    }
}

TEST(SweptField, zero_exactly_at_every_contour_vertex_and_of_the_drawn_side_on_the_slices) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const ContourSet& set : sweeps()) {
        RunContext context;
        const auto field = make_structure_field(set, {}, context).value();
        for (const Vec3& p : set.points) ASSERT_EQ(field->value(0, p), 0.0);
        for (const Slice& slice : set.slices) {
            const auto ring = set.points_of(set.contours[slice.first_contour]);
            const Vec3 centre =
                (1.0 / static_cast<double>(ring.size())) * std::accumulate(ring.begin(), ring.end(), Vec3{});
            for (const Vec3& p : ring) {
                EXPECT_LT(field->value(0, centre + 0.97 * (p - centre)), 0);
                EXPECT_GT(field->value(0, centre + 1.03 * (p - centre)), 0);
            }
        }
    }
}

// C21: what parallel slices join, slices that lean a little join as well.
TEST(SweptField, C21_an_oblique_thin_tube_is_one_piece_of_its_volume) {
    for (int n = 0; n < 5; ++n) {
        std::mt19937 random(static_cast<unsigned>(20 + n));
        for (const auto& planes : {leaning_planes(11, 0.2 + 0.4 * n, random), fan_planes(21, 20.0 + 6 * n)}) {
            const bool is_fan = planes.size() == 21;
            const Vec3 through = is_fan ? Vec3{100, 0, 0} : Vec3{0, 0, 15}, along{1, 0.1 * n, 1};
            const double radius = is_fan ? 3 : 2;
            const ContourSet set = tube(planes, through, along, radius, random);
            RunContext context;
            FieldOptions options;
            options.caps = EndCaps::flat;
            const auto field = make_structure_field(set, options, context).value();
            EXPECT_EQ(Voxels(*field, 0.8).topology(), (Topology{1, 0, 0})) << n << (is_fan ? " fan" : "");
            const Vec3 way = normalized(along);
            const auto end = [&](const Plane& plane) {
                return -plane.signed_distance(through) / dot(way, plane.normal);
            };
            const double drawn = pi * radius * radius * (end(planes.back()) - end(planes.front()));
            const auto volumes = field_volumes(*field, 1, {}, context);
            ASSERT_TRUE(volumes.ok());
            EXPECT_NEAR(volumes.value()[0].by_field / drawn, 1, 0.05) << n << (is_fan ? " fan" : "");
        }
    }
}

// A wall of 2 mm that leans by 45 degrees and more from the slices is one closed shell, and not torn.
TEST(SweptField, a_thin_wall_is_not_torn_by_slices_that_lean_a_little) {
    for (const double degrees : {0.0, 0.2, 1.0}) {
        std::mt19937 random(4);
        SetBuilder builder;
        for (Plane plane : leaning_planes(13, degrees, random)) {
            plane.origin.z -= 18;
            builder.slice(plane);
            // The sphere's circle in a plane through (0, 0, z).
            const auto sphere = [&](double radius) {
                const double h = plane.signed_distance({});
                const Vec2 centre = plane.to_plane({});
                return circle(centre, std::sqrt(radius * radius - h * h), 90);
            };
            builder.ring(0, sphere(24));
            builder.ring(0, reversed(sphere(22)));
        }
        RunContext context;
        const auto field = make_structure_field(builder.set, {}, context).value();
        EXPECT_EQ(Voxels(*field, 0.6).topology(), (Topology{1, 1, 0})) << degrees;
    }
}

TEST(SweptField, box_holds_every_point_inside) {
    for (const ContourSet& set : sweeps()) {
        RunContext context;
        const auto field = make_structure_field(set, {}, context).value();
        std::mt19937 random(6);
        std::uniform_real_distribution<double> unit(-1, 1);
        const Box3 wide = set.box().grown(20), box = field->box();
        const Vec3 middle = 0.5 * (wide.low + wide.high), half = 0.5 * (wide.high - wide.low);
        for (int n = 0; n < 20000; ++n) {
            const Vec3 p = middle + Vec3{half.x * unit(random), half.y * unit(random), half.z * unit(random)};
            ASSERT_TRUE(field->value(0, p) >= 0 || box.contains(p));
        }
    }
}

}  // namespace
}  // namespace anatomesh::sweep_test
