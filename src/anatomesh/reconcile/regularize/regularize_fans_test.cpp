#include "anatomesh/reconcile/regularize/regularize_fans.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/reconcile/reconcile.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::regularize_fans_test {
namespace {

using crossing_fixtures::Ring;

constexpr double pi = std::numbers::pi;
constexpr double radius = 2, reach = 20;

// Slope of the surface at a pole in the half plane of an azimuth, radians; and its number.
using Slope = std::function<double(double azimuth, int ray)>;

struct Fan {
    ContourSet set;
    OriginalPositions drawn;
    FanStats regularize(double most_moved_mm = 10) {
        drawn = original_positions(set);
        return regularize_fans(set, drawn, {radius, 70, most_moved_mm});
    }
};

void add_ring(ContourSet& set, const Plane& plane, std::uint32_t structure, const std::vector<Vec3>& points) {
    Ring ring;
    for (const Vec3& p : points) ring.push_back(plane.to_plane(p));
    double area = 0;
    for (std::size_t k = 0; k < ring.size(); ++k) area += cross(ring[k], ring[(k + 1) % ring.size()]);
    if (area < 0) std::reverse(ring.begin(), ring.end());
    ContourSet one;
    crossing_fixtures::add_slice(one, plane, ring);
    set.contours.push_back({structure, static_cast<std::uint32_t>(set.slices.size() - 1),
                            static_cast<std::uint32_t>(set.points.size()),
                            static_cast<std::uint32_t>(one.points.size())});
    set.points.insert(set.points.end(), one.points.begin(), one.points.end());
    ++set.slices.back().contour_count;
}

// In every one of `planes` about the z axis a body below the surface, whose rays meet at the origin; above it
// another one, on the slices that `above` says; on the first slice, with a `branch`, one that leaves the ray
// so far from the origin.
Fan fan_of(
    int planes, const Slope& slope, const std::function<bool(int)>& above = [](int) { return false; },
    double branch = 0) {
    Fan fan;
    fan.set.source = "fan";
    fan.set.structures = {{1, "below", {200, 0, 0}}, {2, "above", {0, 200, 0}}};
    for (int k = 0; k < planes; ++k) {
        const double azimuth = pi * k / planes;
        const Vec3 out{std::cos(azimuth), std::sin(azimuth), 0};
        const Plane plane = make_plane({}, {-out.y, out.x, 0});
        fan.set.slices.push_back(
            {plane, static_cast<std::uint32_t>(fan.set.contours.size()), 0, std::to_string(k)});
        const Vec3 one = reach * out + Vec3{0, 0, reach * std::tan(slope(azimuth, k))};
        const Vec3 other = -reach * out + Vec3{0, 0, reach * std::tan(slope(azimuth + pi, k + planes))};
        const Vec3 down{0, 0, 80};
        if (k == 0 && branch > 0) {
            const Vec3 near = branch * normalized(one);
            add_ring(fan.set, plane, 0, {{}, near, one, reach * out - down, -reach * out - down, other});
            add_ring(fan.set, plane, 1, {{}, near, near + down, -reach * out + down, other});
            continue;
        }
        add_ring(fan.set, plane, 0, {{}, one, reach * out - down, -reach * out - down, other});
        if (above(k)) add_ring(fan.set, plane, 1, {{}, one, reach * out + down, -reach * out + down, other});
    }
    return fan;
}

double degrees(double angle) {
    return angle * 180 / pi;
}

// The smallest angle at a ray between the facets to those beside it, of structure 0, from its points next to
// the origin.
double sharpest(const ContourSet& set) {
    std::vector<Vec3> rays;
    for (const Contour& contour : set.contours) {
        if (contour.structure != 0) continue;
        const auto points = set.points_of(contour);
        for (std::size_t k = 0; k < points.size(); ++k) {
            const Vec3 before = points[(k + points.size() - 1) % points.size()], p = points[k];
            if (before == Vec3{}) rays.push_back(normalized(p));
            if (p == Vec3{}) rays.push_back(normalized(before));
        }
    }
    std::sort(rays.begin(), rays.end(),
              [](Vec3 p, Vec3 q) { return std::atan2(p.y, p.x) < std::atan2(q.y, q.x); });
    double least = 180;
    for (std::size_t k = 0; k < rays.size(); ++k) {
        const Vec3 ray = rays[k];
        const auto across = [&](Vec3 p) { return normalized(p - dot(p, ray) * ray); };
        const double cosine =
            dot(across(rays[(k + rays.size() - 1) % rays.size()]), across(rays[(k + 1) % rays.size()]));
        least = std::min(least, degrees(std::acos(std::clamp(cosine, -1.0, 1.0))));
    }
    return least;
}

void expect_sound(const ContourSet& set) {
    for (const Slice& slice : set.slices) {
        EXPECT_TRUE(slice_faults(plane_rings(set, slice), set.exclusive).empty()) << slice.name;
    }
}

bool has(const ContourSet& set, std::uint32_t slice, std::uint32_t structure, Vec3 p) {
    for (const Contour& contour : set.contours_of(set.slices[slice])) {
        const auto points = set.points_of(contour);
        if (contour.structure == structure && std::find(points.begin(), points.end(), p) != points.end())
            return true;
    }
    return false;
}

// A slope that rises and falls by turns on one that is plain.
Slope zigzag(double tilt, double azimuth, double height) {
    return [=](double at, int ray) {
        return std::atan(std::tan(tilt) * std::cos(at - azimuth)) + (ray % 2 == 0 ? height : -height);
    };
}

// A contour that branches next to the pole keeps its ray; the others are turned as far out as without it.
TEST(RegularizeFans, one_ray_without_room_does_not_take_that_of_the_others) {
    for (const double branch : {0.03 * radius, 0.3 * radius}) {
        Fan fan = fan_of(
            10, zigzag(0, 0, 0.5), [](int) { return false; }, branch);
        const auto points = fan.set.points_of(fan.set.contours[0]);
        const auto found = std::find_if(points.begin(), points.end(),
                                        [&](Vec3 p) { return std::abs(length(p) - branch) < 1e-9; });
        ASSERT_NE(found, points.end());
        const Vec3 near = *found;
        EXPECT_EQ(fan.regularize().fans, 1u);
        EXPECT_TRUE(has(fan.set, 0, 0, near));
        EXPECT_TRUE(has(fan.set, 0, 1, near));
        std::size_t turned = 0;
        for (std::size_t n = 0; n < fan.set.points.size(); ++n) {
            if (fan.set.points[n] == fan.drawn.at[n]) continue;
            EXPECT_NEAR(length(fan.set.points[n]), radius, 1e-9);
            ++turned;
        }
        EXPECT_GT(turned, 10u);
        expect_sound(fan.set);
    }
}

// A contour that lies within the radius altogether has no ray: nothing is turned, and it ends.
TEST(RegularizeFans, a_contour_smaller_than_the_radius_has_no_rays) {
    Fan fan = fan_of(10, zigzag(0, 0, 0.5));
    const Plane plane = make_plane({}, {1, 0, 0});
    fan.set.slices.push_back({plane, static_cast<std::uint32_t>(fan.set.contours.size()), 0, "small"});
    const double side = 0.2 * radius;
    add_ring(fan.set, plane, 0, {{}, {0, side, -side}, {0, -side, -side}});
    const ContourSet before = fan.set;
    EXPECT_EQ(fan.regularize().fans, 0u);
    EXPECT_EQ(fan.set.points, before.points);
}

// A surface that runs nearly along the line: its rays come near to each other.
TEST(RegularizeFans, what_runs_along_the_line_leaves_it_at_an_angle) {
    const double steepest = FanOptions{}.steepest_degrees, least_turn = 3;
    for (const int planes : {8, 12, 20}) {
        for (const double tilt_degrees : {70.0, 73.0, 75.0}) {
            const double tilt = tilt_degrees * pi / 180, turn = 0.37 * pi / planes;
            Fan fan = fan_of(planes, [&](double azimuth, int) {
                return std::atan(std::tan(tilt) * std::cos(azimuth - turn));
            });
            const ContourSet before = fan.set;
            EXPECT_EQ(fan.regularize().fans, 1u);
            std::size_t rays = 0, turned = 0;
            for (const Contour& contour : fan.set.contours) {
                const auto points = fan.set.points_of(contour);
                for (std::size_t k = 0; k < points.size(); ++k) {
                    if (points[k] != Vec3{}) continue;
                    for (const Vec3 p :
                         {points[(k + 1) % points.size()], points[(k + points.size() - 1) % points.size()]}) {
                        ++rays;
                        const double slope = degrees(std::atan2(std::abs(p.z), std::hypot(p.x, p.y)));
                        EXPECT_LE(slope, steepest + least_turn);
                        if (std::abs(slope - steepest) > 1e-6) continue;
                        ++turned;
                        EXPECT_NEAR(length(p), radius, 1e-9);
                    }
                }
            }
            EXPECT_EQ(rays, 2u * static_cast<std::size_t>(planes));
            EXPECT_GE(turned, 4u);
            EXPECT_LT(turned, rays);
            for (std::uint32_t s = 0; s < before.slices.size(); ++s) {
                for (const Vec3& p : before.points_of(before.contours[s])) EXPECT_TRUE(has(fan.set, s, 0, p));
            }
            expect_sound(fan.set);
        }
    }
}

TEST(RegularizeFans, what_rises_and_falls_from_plane_to_plane_goes) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int n = 0; n < 40; ++n) {
        const int planes = 8 + 2 * (n % 5);
        Fan fan = fan_of(planes, zigzag(0.6 * unit(random), 2 * pi * unit(random), 0.5));
        const ContourSet before = fan.set;
        ASSERT_LT(sharpest(before), 60);
        const FanStats stats = fan.regularize();
        EXPECT_EQ(stats.fans, 1u);
        EXPECT_GT(stats.highest_mm, 0.1 * radius);
        EXPECT_LT(stats.highest_mm, 0.6 * radius);
        EXPECT_GE(sharpest(fan.set), 70 - 1e-6);
        expect_sound(fan.set);
        // What was drawn further out, and the pole, is where it was; the others are on the rays at the
        // radius.
        ASSERT_EQ(fan.drawn.at.size(), fan.set.points.size());
        std::size_t put_in = 0;
        for (std::uint32_t s = 0; s < before.slices.size(); ++s) {
            for (const Vec3& p : before.points_of(before.contours[s])) EXPECT_TRUE(has(fan.set, s, 0, p));
        }
        for (std::size_t k = 0; k < fan.set.points.size(); ++k) {
            if (fan.drawn.is_drawn[k]) {
                EXPECT_EQ(fan.drawn.at[k], fan.set.points[k]);
                continue;
            }
            ++put_in;
            EXPECT_NEAR(length(fan.set.points[k]), radius, 1e-9);
        }
        EXPECT_EQ(fan.set.points.size(), before.points.size() + put_in);
        EXPECT_LE(put_in, 2u * static_cast<std::size_t>(planes));
    }
}

TEST(RegularizeFans, slopes_ridges_and_cones_keep_their_bits) {
    const std::vector<Slope> smooth{
        [](double, int) { return 0.0; },
        [](double, int) { return 0.8; },
        [](double at, int) { return std::atan(1.5 * std::cos(at - 0.3)); },
        [](double at, int) { return -std::atan(std::abs(std::cos(at - 0.3))); },  // a ridge of 90 degrees
        [](double at, int) { return std::atan(0.7 * std::cos(2 * at)); },         // a saddle
    };
    for (const Slope& slope : smooth) {
        for (const int planes : {4, 8, 13, 20}) {
            Fan fan = fan_of(planes, slope);
            const std::vector<Vec3> before = fan.set.points;
            EXPECT_EQ(fan.regularize().fans, 0u);
            EXPECT_EQ(fan.set.points, before);
        }
    }
}

TEST(RegularizeFans, three_planes_through_a_line_stay) {
    Fan fan = fan_of(3, zigzag(0, 0, 1.2));
    const std::vector<Vec3> before = fan.set.points;
    ASSERT_LT(sharpest(fan.set), 70);
    EXPECT_EQ(fan.regularize().fans, 0u);
    EXPECT_EQ(fan.set.points, before);
}

// Also where the other structure has rays on some of the planes only.
TEST(RegularizeFans, walls_stay_shared) {
    for (const int every : {1, 2, 3, 6}) {
        Fan fan = fan_of(12, zigzag(0.3, 1, 0.5), [&](int k) { return k % every == 0; });
        EXPECT_EQ(fan.regularize().fans, 1u);
        expect_sound(fan.set);
        std::size_t shared = 0;
        for (const Contour& contour : fan.set.contours) {
            if (contour.structure != 1) continue;
            for (const Vec3& p : fan.set.points_of(contour)) {
                if (length(p) > 2 * reach) continue;
                EXPECT_TRUE(has(fan.set, contour.slice, 0, p));
                ++shared;
            }
        }
        EXPECT_GE(shared, 4u * (12 / static_cast<std::size_t>(every)));
    }
}

TEST(RegularizeFans, a_slice_that_would_not_be_sound_keeps_its_contours) {
    Fan fan = fan_of(12, zigzag(0, 0, 0.5));
    // Just below the ray of slice 0, which comes down.
    const double slope = std::tan(0.5);
    ContourSet set;
    set.source = fan.set.source;
    set.structures = fan.set.structures;
    for (std::uint32_t s = 0; s < fan.set.slices.size(); ++s) {
        set.slices.push_back(fan.set.slices[s]);
        set.slices.back().first_contour = static_cast<std::uint32_t>(set.contours.size());
        set.slices.back().contour_count = 0;
        const auto points = fan.set.points_of(fan.set.contours[s]);
        add_ring(set, set.slices.back().plane, 0, {points.begin(), points.end()});
        if (s != 0) continue;
        // A hole in it.
        const Vec3 middle{0.7 * radius, 0, 0.7 * radius * slope - 0.15 * radius};
        std::vector<Vec3> hole{middle, middle + Vec3{0.1, 0, 0.05}, middle + Vec3{0.1, 0, -0.05}};
        const Plane& plane = set.slices.back().plane;
        if (cross(plane.to_plane(hole[1]) - plane.to_plane(hole[0]),
                  plane.to_plane(hole[2]) - plane.to_plane(hole[0])) > 0)
            std::swap(hole[1], hole[2]);
        set.contours.push_back({0, 0, static_cast<std::uint32_t>(set.points.size()), 3});
        set.points.insert(set.points.end(), hole.begin(), hole.end());
        ++set.slices.back().contour_count;
    }
    fan.set = set;
    expect_sound(fan.set);
    fan.regularize();
    expect_sound(fan.set);
    for (const std::uint32_t contour : {0u, 1u})
        EXPECT_EQ(fan.set.contours[contour].point_count, set.contours[contour].point_count);
    EXPECT_GT(fan.set.contours[3].point_count, set.contours[3].point_count);
    EXPECT_EQ(fan.drawn.at.size(), fan.set.points.size());
}

TEST(RegularizeFans, no_vertex_moves_further_than_it_may) {
    const auto with_inner_vertices = [] {
        Fan fan = fan_of(12, zigzag(0, 0, 0.5));
        ContourSet set = fan.set;
        set.contours.clear();
        set.points.clear();
        for (std::uint32_t s = 0; s < fan.set.slices.size(); ++s) {
            const auto points = fan.set.points_of(fan.set.contours[s]);
            const auto first = static_cast<std::uint32_t>(set.points.size());
            for (std::size_t k = 0; k < points.size(); ++k) {
                const Vec3 p = points[k], q = points[(k + 1) % points.size()];
                set.points.push_back(p);
                if (p == Vec3{}) set.points.push_back(0.4 * radius * normalized(q));
                if (q == Vec3{}) set.points.push_back(0.4 * radius * normalized(p));
            }
            set.contours.push_back({0, s, first, static_cast<std::uint32_t>(set.points.size()) - first});
        }
        fan.set = set;
        return fan;
    };
    for (const double most : {0.01, 10.0}) {
        Fan fan = with_inner_vertices();
        const std::size_t before = fan.set.points.size();
        const FanStats stats = fan.regularize(most);
        double furthest = 0;
        for (std::size_t k = 0; k < fan.set.points.size(); ++k) {
            if (fan.drawn.is_drawn[k])
                furthest = std::max(furthest, length(fan.set.points[k] - fan.drawn.at[k]));
        }
        EXPECT_LE(furthest, most);
        EXPECT_LE(stats.highest_mm, most);
        EXPECT_EQ(stats.fans, most < 1 ? 0u : 1u);
        EXPECT_EQ(fan.set.points.size() > before, most > 1);
        EXPECT_EQ(furthest > 0.1, most > 1);
        expect_sound(fan.set);
    }
}

// Nor does what is put in, where no vertex lies within the radius.
TEST(RegularizeFans, no_ray_without_vertices_is_turned_further_either) {
    for (const double most : {0.01, 10.0}) {
        Fan fan = fan_of(12, zigzag(0.3, 1, 0.5));
        const std::vector<Vec3> before = fan.set.points;
        const FanStats stats = fan.regularize(most);
        EXPECT_LE(stats.highest_mm, most);
        EXPECT_EQ(stats.fans, most < 1 ? 0u : 1u);
        EXPECT_EQ(fan.set.points == before, most < 1);
    }
}

TEST(RegularizeFans, C25_reconciling_settles_them_and_says_so) {
    const auto codes = [](const ContourSet& set, bool reconcile, ReconcileStats& stats) {
        RunContext context;
        ReconcileOptions options;
        options.reconcile = reconcile;
        options.margin_mm = 5;
        auto result = reconcile_contours(set, options, context);
        EXPECT_TRUE(result.ok());
        stats = result.value().stats;
        return std::count_if(context.warnings.begin(), context.warnings.end(),
                             [](const Warning& warning) { return warning.code == "W-RCN-009"; });
    };
    ReconcileStats stats;
    // Where all agree as drawn a sharp edge is one.
    ContourSet sharp = fan_of(12, zigzag(0.3, 1, 0.5)).set;
    EXPECT_EQ(codes(sharp, true, stats), 0);
    EXPECT_EQ(stats.fans.fans, 0u);
    for (const Contour& contour : sharp.contours_of(sharp.slices[0])) {
        for (std::uint32_t n = 0; n < contour.point_count; ++n)
            sharp.points[contour.first_point + n].z += 1.5;
    }
    EXPECT_EQ(codes(sharp, true, stats), 1);
    EXPECT_EQ(stats.fans.fans, 1u);
    EXPECT_EQ(stats.difference_after_mm, 0);
    EXPECT_EQ(codes(sharp, false, stats), 0);
    EXPECT_EQ(stats.fans.fans, 0u);
    EXPECT_EQ(codes(fan_of(12, zigzag(0.3, 1, 0.02)).set, true, stats), 0);
}

}  // namespace
}  // namespace anatomesh::regularize_fans_test
