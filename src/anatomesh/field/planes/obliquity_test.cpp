#include "anatomesh/field/planes/obliquity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/structure_field.h"

namespace anatomesh::obliquity_test {
namespace {

using namespace fixtures;

constexpr double depth = 1;  // of the plane below the boundary

// Half space below z = 0, seen by a plane `depth` below it and by planes across it, x = const and y = const.
PatchesSeen half_space(const std::vector<double>& across) {
    PatchesSeen seen;
    seen.radius = 30;
    seen.clamp = 15;
    seen.cell = 2.5;
    const Box2 box{{-40, -40}, {40, 40}};
    seen.planes.push_back(make_plane({0, 0, -depth}, {0, 0, 1}));
    for (const double at : across) {
        seen.planes.push_back(make_plane({at, 0, 0}, {1, 0, 0}));
        seen.planes.push_back(make_plane({0, at, 0}, {0, 1, 0}));
    }
    seen.boxes.assign(seen.planes.size(), box);
    const std::vector<Plane> planes = seen.planes;
    const double radius = seen.radius, clamp = seen.clamp;
    seen.near = [planes, radius](std::uint32_t own, Vec3 p, std::vector<PatchNear>& near) {
        near.clear();
        for (std::uint32_t n = 0; n < planes.size(); ++n) {
            if (n == own) continue;
            const double distance = std::abs(planes[n].signed_distance(p));
            if (distance < radius) near.push_back({n, distance});
        }
    };
    seen.distances = [planes, clamp](std::uint32_t n, Vec2 q, std::vector<DistanceInPlane>& distances) {
        distances.clear();
        const double value = n == 0 ? -clamp : planes[n].to_space(q).z;
        distances.push_back({7, std::clamp(value, -clamp, clamp)});
    };
    return seen;
}

ObliquityFactors obliquity_of(const PatchesSeen& seen, int threads) {
    RunContext context;
    context.threads = threads;
    return ObliquityFactors::of(seen, context);
}

TEST(ObliquityFactors, planes_across_tell_how_near_the_boundary_is) {
    const PatchesSeen seen = half_space({-20, -10, 0, 10, 20});
    const ObliquityFactors obliquities = obliquity_of(seen, 2);
    for (double x = -20; x <= 20; x += 1.7) {
        for (double y = -20; y <= 20; y += 1.3) {
            const double obliquity = obliquities.at(0, 7, seen.planes[0].to_plane({x, y, -depth}));
            EXPECT_GE(obliquity, depth / seen.clamp) << x << " " << y;
            EXPECT_LE(obliquity, 0.25) << x << " " << y;
        }
    }
    // Those across see the boundary where it is: the plane along it says that it is further.
    for (std::uint32_t n = 1; n < seen.planes.size(); ++n) EXPECT_EQ(obliquities.at(n, 7, {1, -3}), 1) << n;
    EXPECT_EQ(obliquities.at(0, 8, {1, -3}), 1);
}

TEST(ObliquityFactors, a_plane_on_which_a_structure_is_not_drawn_has_one_too) {
    PatchesSeen seen = half_space({-10, 0, 10});
    // Above the boundary.
    seen.planes[0] = make_plane({0, 0, depth}, {0, 0, 1});
    const auto below = seen.distances;
    seen.distances = [below](std::uint32_t n, Vec2 q, std::vector<DistanceInPlane>& distances) {
        below(n, q, distances);
        if (n == 0) distances.clear();
    };
    const ObliquityFactors obliquities = obliquity_of(seen, 1);
    EXPECT_EQ(obliquities.count(0), 1u);
    EXPECT_LE(obliquities.at(0, 7, {3, 4}), 0.25);
    EXPECT_GE(obliquities.at(0, 7, {3, 4}), depth / seen.clamp);
}

TEST(ObliquityFactors, parallel_planes_have_none) {
    PatchesSeen seen = half_space({});
    seen.planes.push_back(make_plane({0, 0, -2 * depth}, {0, 0, 1}));
    seen.boxes.push_back(seen.boxes.front());
    const ObliquityFactors obliquities = obliquity_of(seen, 1);
    EXPECT_EQ(obliquities.count(0), 0u);
    EXPECT_EQ(obliquities.count(1), 0u);
    EXPECT_EQ(ObliquityFactors().at(0, 7, {}), 1);
}

TEST(ObliquityFactors, between_nodes_linear_and_beyond_them_as_at_the_edge) {
    const ObliquityMap map(3, {10, 20}, 2, 3, {0.1F, 0.2F, 0.3F, 0.5F, 0.6F, 0.7F});
    EXPECT_NEAR(map.at({11, 20}), 0.15, 1e-6);
    EXPECT_NEAR(map.at({11, 21}), 0.35, 1e-6);
    EXPECT_NEAR(map.at({14, 22}), 0.7, 1e-6);
    EXPECT_NEAR(map.at({0, 0}), 0.1, 1e-6);
    EXPECT_NEAR(map.at({100, 21}), 0.5, 1e-6);
}

// A ball on three stacks at right angles, one plane of each just inside its pole or just beyond.
ContourSet ball_on_stacks(double radius, double spacing, double first) {
    SetBuilder builder;
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{0, 1, 0}, Vec3{1, 0, 0}}) {
        for (double h = first; h < radius; h += spacing) {
            builder.slice(make_plane(h * normal, normal));
            builder.ring(0, circle({}, std::sqrt(radius * radius - h * h), 180, 0.1));
        }
    }
    return builder.set;
}

// Half-way between the planes across, where the plane below the pole alone would say that the boundary is
// half a spacing away.
TEST(ObliquityFactors, the_surface_keeps_by_a_plane_that_runs_along_it) {
    const double radius = 60, spacing = 12;
    for (const double below : {0.1, 0.3, 1.0, 2.0, 4.0}) {
        RunContext context;
        const auto field =
            make_structure_field(ball_on_stacks(radius, spacing, below - radius), {}, context).value();
        double sum = 0;
        int count = 0;
        for (double x = -spacing; x <= spacing; x += 1) {
            for (double y = -spacing; y <= spacing; y += 1) {
                const Vec3 way = normalized({x, y, -radius});
                double in = radius - 6, out = radius + 6;
                if (field->value(0, out * way) < 0) in = out;
                while (out - in > 0.001) {
                    const double middle = 0.5 * (in + out);
                    (field->value(0, middle * way) < 0 ? in : out) = middle;
                }
                sum += std::abs(0.5 * (in + out) - radius);
                ++count;
            }
        }
        EXPECT_LT(sum / count, 0.7) << below;  // 1.1 to 4 mm without obliquity factors
    }
}

// Oblique stacks moved as a whole: planes that meet at any angle say the same wherever they lie, and in any
// order.
TEST(ObliquityFactors, are_the_same_wherever_the_planes_lie) {
    const double radius = 60, spacing = 10;
    const auto stacks = [&](Vec3 center, bool backwards) {
        std::vector<Plane> planes;
        for (const double angle : {0.3, 0.3 + 0.5 * std::numbers::pi, 0.0}) {
            const Vec3 n = angle > 0 ? Vec3{std::cos(angle), std::sin(angle), 0} : Vec3{0, 0, 1};
            const Vec3 leaning = normalized(n + Vec3{0.2, -0.1, 0.3});
            for (double h = 3 - radius; h < radius; h += spacing)
                planes.push_back(make_plane(center + h * leaning, leaning));
        }
        if (backwards) std::reverse(planes.begin(), planes.end());
        SetBuilder builder;
        for (const Plane& plane : planes) {
            const double h = plane.signed_distance(center);
            builder.slice(plane);
            builder.ring(0, circle(plane.to_plane(center), std::sqrt(radius * radius - h * h), 180, 0.1));
        }
        RunContext context;
        return make_structure_field(builder.set, {}, context).value();
    };
    const Vec3 far{123.4, -56.7, 89.1};
    const auto here = stacks({}, false), there = stacks(far, false), backwards = stacks({}, true);
    double most = 0;
    for (int n = 0; n < 4000; ++n) {
        const double along = std::acos(1 - 2 * (n + 0.5) / 4000), around = 2.399963 * n;
        const Vec3 way{std::sin(along) * std::cos(around), std::sin(along) * std::sin(around),
                       std::cos(along)};
        const Vec3 p = (radius + 0.3 * (n % 7 - 3)) * way;
        most = std::max(most, std::abs(here->value(0, p) - there->value(0, p + far)));
        most = std::max(most, std::abs(here->value(0, p) - backwards->value(0, p)));
    }
    EXPECT_LT(most, 0.05);
}

}  // namespace
}  // namespace anatomesh::obliquity_test
