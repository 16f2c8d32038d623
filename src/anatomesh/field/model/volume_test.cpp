#include "anatomesh/field/model/volume.h"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"

namespace anatomesh::volume_test {
namespace {

using namespace fixtures;

std::vector<StructureVolume> volumes_of(const ContourSet& set, const FieldOptions& field_options = {},
                                        const VolumeOptions& options = {}, int threads = 1) {
    RunContext context;
    context.threads = threads;
    const auto field = make_structure_field(set, field_options, context);
    EXPECT_TRUE(field.ok());
    const auto volumes =
        field_volumes(*field.value(), static_cast<std::uint32_t>(set.structures.size()), options, context);
    EXPECT_TRUE(volumes.ok());
    return volumes.value();
}

// The integral by brute force: midpoints of a fine grid in space.
std::vector<double> by_counting(const ContourSet& set, double step) {
    RunContext context;
    const auto field = make_structure_field(set, {}, context).value();
    const Box3 box = field->box();
    std::vector<double> totals(set.structures.size(), 0);
    std::vector<std::uint32_t> inside;
    for (double z = box.low.z + 0.5 * step; z < box.high.z; z += step) {
        for (double y = box.low.y + 0.5 * step; y < box.high.y; y += step) {
            for (double x = box.low.x + 0.5 * step; x < box.high.x; x += step) {
                field->members({x, y, z}, inside);
                for (const std::uint32_t s : inside) totals[s] += step * step * step;
            }
        }
    }
    return totals;
}

TEST(FieldVolumes, prism_with_half_and_flat_caps_is_exact) {
    SetBuilder builder;
    const Ring square{{-20, -20}, {20, -20}, {20, 20}, {-20, 20}};
    for (const double z : {0.0, 3.0, 6.0, 10.0}) {
        builder.slice(axial(z));
        builder.ring(0, square);
    }
    const StructureVolume half = volumes_of(builder.set).front();
    EXPECT_NEAR(half.by_field, 1600 * (10 + 1.5 + 1.5), 1e-6);  // local spacing at both ends: 3
    EXPECT_NEAR(half.by_slices, half.by_field, 1e-6);
    FieldOptions options;
    options.caps = EndCaps::flat;
    const StructureVolume flat = volumes_of(builder.set, options).front();
    EXPECT_NEAR(flat.by_field, 16000, 1e-6);
    EXPECT_NEAR(flat.by_slices, 16000, 1e-6);
}

// What the quarter circle of radius r cuts from the rim of a circle of radius R, by Pappus: its area (1 - pi / 4) r^2,
// the middle of which lies 0.2234 r from the sides.
TEST(FieldVolumes, rounded_caps_lose_what_the_rim_loses) {
    SetBuilder builder;
    for (const double z : {0.0, 3.0, 6.0, 9.0}) {
        builder.slice(axial(z));
        builder.ring(0, circle({}, 20, 720));
    }
    FieldOptions options;
    options.caps = EndCaps::rounded;
    const double pi = std::numbers::pi, r = 1.5;
    const double cut = (1 - pi / 4) * r * r * 2 * pi * (20 - 0.2234 * r);
    EXPECT_NEAR(volumes_of(builder.set, options).front().by_field, pi * 400 * 12 - 2 * cut, 0.02 * cut + 1);
}

// Slices at regular positions integrate a ball's cross-sections almost exactly; the field, between them, must
// follow.
TEST(FieldVolumes, ball_and_torus_agree_with_their_formulas) {
    const double r = 30;
    const StructureVolume ball_volume = volumes_of(ball(r, -28.5, 3, 720)).front();
    EXPECT_NEAR(ball_volume.by_slices / (4.0 / 3 * std::numbers::pi * r * r * r), 1, 0.003);
    EXPECT_NEAR(ball_volume.by_field / ball_volume.by_slices, 1, 0.01);

    SetBuilder torus;  // axis z, radii 30 and 10
    for (double z = -9.5; z < 10; z += 1) {
        torus.slice(axial(z));
        const double half = std::sqrt(100 - z * z);
        torus.ring(0, circle({}, 30 + half, 720));
        torus.ring(0, reversed(circle({}, 30 - half, 720)));
    }
    const StructureVolume volume = volumes_of(torus.set).front();
    // The half slices at both ends are 0.7 % more than what the torus has there.
    EXPECT_NEAR(volume.by_field / (2 * std::numbers::pi * std::numbers::pi * 30 * 100), 1.0066, 0.003);
}

TEST(FieldVolumes, equals_brute_force_counting_of_the_field) {
    std::mt19937 random(12);
    SetBuilder builder;
    for (int k = 0; k < 6; ++k) {
        builder.slice(axial(2.5 * k));
        builder.ring(0, star({2.0 * k, 0}, 8, 20, 50, random));
        builder.ring(0, reversed(star({2.0 * k, 0}, 2, 7, 15, random)));
        if (k % 3 == 1) builder.ring(0, circle({60, 0}, 3, 30));
    }
    const double expected = by_counting(builder.set, 0.2).front();
    EXPECT_NEAR(volumes_of(builder.set).front().by_field / expected, 1, 5e-4);
    VolumeOptions fine;
    fine.points_per_slab = 500000;
    EXPECT_NEAR(volumes_of(builder.set).front().by_field / volumes_of(builder.set, {}, fine).front().by_field,
                1, 3e-4);
}

// What a point of the lattice stands for is cut by a boundary near it: few points see that.
TEST(FieldVolumes, few_points_find_what_many_do) {
    std::mt19937 random(5);
    SetBuilder builder;
    for (int k = 0; k < 16; ++k) {
        builder.slice(axial(3.0 * k));
        builder.ring(0, star({1.5 * k, -1.0 * k}, 18, 24, 80, random));
        builder.ring(0, reversed(star({1.5 * k, -1.0 * k}, 13, 16, 60, random)));
    }
    VolumeOptions few, many;
    few.points_per_slab = 2000;
    many.points_per_slab = 60000;
    many.points_in_slabs = 2000000;
    EXPECT_NEAR(volumes_of(builder.set, {}, few).front().by_field /
                    volumes_of(builder.set, {}, many).front().by_field,
                1, 2e-4);
}

// Two equal contours one above the other, between which the surface bulges: nothing moves, but it bows.
TEST(FieldVolumes, count_the_bulge_between_equal_contours) {
    for (const double spacing : {8.0, 12.0}) {
        const double first = -1.5 * spacing;
        const ContourSet set = ball(20, first, spacing, 120);
        ASSERT_EQ(set.slices.size(), static_cast<std::size_t>(std::ceil((20 - first) / spacing)));
        EXPECT_NEAR(volumes_of(set).front().by_field / by_counting(set, 0.5).front(), 1, 2e-3) << spacing;
    }
}

ContourSet leaning_blocks(bool exclusive) {
    SetBuilder builder(exclusive);
    for (int k = 0; k < 6; ++k) {
        const double wall = 3.0 * k - 6;
        builder.slice(axial(3.0 * k));
        builder.ring(0, {{-20, -10}, {wall, -10}, {wall + 3, 0}, {wall, 10}, {-20, 10}});
        if (exclusive) builder.ring(1, {{wall, -10}, {25, -10}, {25, 10}, {wall, 10}, {wall + 3, 0}});
    }
    return builder.set;
}

// A ball with a void, and two balls of which one ends first, at several positions of the slices: what ends in
// a paraboloid cap counts as every point of it does, and the whole has the volume of its slices.
TEST(FieldVolumes, what_ends_in_a_dome_equals_the_count_of_every_point) {
    for (const bool is_void : {true, false}) {
        for (int n = 0; n < 5; ++n) {
            SetBuilder builder;
            for (double z = -26.9 + 0.6 * n; z < 27; z += 3) {
                builder.slice(axial(z));
                builder.ring(0, circle({}, std::sqrt(27 * 27 - z * z), 90));
                const double r2 = 12 * 12 - z * z;
                if (r2 < 0.1) continue;
                const Ring inner = circle({is_void ? 3.0 : 45.0, 0}, std::sqrt(r2), 60);
                builder.ring(0, is_void ? reversed(inner) : inner);
            }
            RunContext context;
            const auto field = make_structure_field(builder.set, {}, context).value();
            const StructureVolume volume = volumes_of(builder.set, {}).front();
            double counted = 0;
            const double step = 0.31;
            for (double x = -28.1; x < 60; x += step) {
                for (double y = -28.1; y < 29; y += step) {
                    for (double z = -30.1; z < 31; z += step) counted += field->value(0, {x, y, z}) < 0;
                }
            }
            EXPECT_NEAR(volume.by_field / (counted * step * step * step), 1, 0.001) << is_void << " " << n;
            EXPECT_NEAR(volume.by_field / volume.by_slices, 1, 0.01) << is_void << " " << n;
        }
    }
}

TEST(FieldVolumes, walls_along_the_axes_and_shared_walls) {
    const auto alone = volumes_of(leaning_blocks(false)), pair = volumes_of(leaning_blocks(true));
    EXPECT_NEAR(alone[0].by_field / by_counting(leaning_blocks(false), 0.125)[0], 1, 1e-3);
    const std::vector<double> counted = by_counting(leaning_blocks(true), 0.125);
    for (const std::size_t s : {0u, 1u}) EXPECT_NEAR(pair[s].by_field / counted[s], 1, 1e-3);
    EXPECT_NEAR(pair[0].by_field + pair[1].by_field, 45 * 20 * 18,
                0.0005 * 45 * 20 * 18);  // no gap, no overlap
}

TEST(FieldVolumes, same_at_any_thread_count) {
    const ContourSet set = ball(30, -28.5, 3, 200);
    EXPECT_EQ(volumes_of(set, {}, {}, 1).front().by_field, volumes_of(set, {}, {}, 2).front().by_field);
}

// A ball seen on three crossing stacks: planes in any position.
TEST(FieldVolumes, ball_on_crossing_planes) {
    SetBuilder builder;
    const double r = 20;
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{0, 1, 0}, Vec3{1, 0.2, 0.1}}) {
        const Vec3 n = normalized(normal);
        for (double h = -18; h < r; h += 4) {
            builder.slice(make_plane(h * n, n));
            builder.ring(0, circle({}, std::sqrt(r * r - h * h), 180));
        }
    }
    VolumeOptions options;
    options.points_in_all = 100000;
    const StructureVolume volume = volumes_of(builder.set, {}, options).front();
    EXPECT_NEAR(volume.by_field / (4.0 / 3 * std::numbers::pi * r * r * r), 1, 0.03);
    EXPECT_TRUE(std::isnan(volume.by_slices));
}

// The lattice of field_volumes() for planes in any position, the field asked at each of its points.
std::vector<double> by_asking_everywhere(const ContourSet& set, double points_in_box) {
    RunContext context;
    const auto field = make_structure_field(set, {}, context).value();
    std::vector<double> totals;
    std::vector<std::uint32_t> inside;
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        const Box3 box = field->box_of(s);
        const Vec3 size = box.high - box.low;
        const auto layers =
            static_cast<std::size_t>(std::ceil(size.z / std::cbrt(size.x * size.y * size.z / points_in_box)));
        double total = 0;
        for (std::size_t k = 0; k < layers; ++k) {
            const double z =
                box.low.z + (static_cast<double>(k) + 0.5) * size.z / static_cast<double>(layers);
            std::uint64_t points = 0, counted = 0;
            lattice_integral({{box.low.x, box.low.y}, {box.high.x, box.high.y}},
                             points_in_box / static_cast<double>(layers), k, [&](Vec2 q, double) {
                                 ++points;
                                 field->members({q.x, q.y, z}, inside);
                                 counted += std::count(inside.begin(), inside.end(), s);
                                 return 0.0;
                             });
            total += static_cast<double>(counted) * size.x * size.y * size.z /
                     static_cast<double>(layers * points);
        }
        totals.push_back(total);
    }
    return totals;
}

// A ball of radius 20 on each plane that meets it, as `draw` says.
ContourSet cut_ball(const std::vector<Vec3>& normals, const std::vector<double>& heights,
                    const std::function<void(SetBuilder&, double)>& draw) {
    SetBuilder builder;
    for (const Vec3 normal : normals) {
        const Vec3 n = normalized(normal);
        for (const double h : heights) {
            builder.slice(make_plane(h * n, n));
            if (std::abs(h) < 20) draw(builder, std::sqrt(400 - h * h));
        }
    }
    return builder.set;
}

// Blocks that no interface comes near are not asked: nothing may be lost for it, of thin walls, of structures
// inside others, nor of what a few planes draw and their neighbours do not.
TEST(FieldVolumes, planes_in_any_position_equal_the_count_of_every_point) {
    std::mt19937 random(5);
    std::vector<double> even, close;
    for (double h = -18; h < 20; h += 4) even.push_back(h);
    for (double h = -18; h < 20; h += 1) close.push_back(h);
    const std::vector<Vec3> stacks{{0, 0, 1}, {0, 1, 0}, {1, 0.2, 0.1}}, pair{{0, 0, 1}, {0, 1, 0.1}};
    std::vector<Vec3> fan;
    for (int k = 0; k < 18; ++k) fan.push_back({std::cos(k * 0.1745), std::sin(k * 0.1745), 0.01 * k});
    int drawn = 0;
    const auto ball = [](SetBuilder& b, double r) { b.ring(0, circle({}, r, 90)); };
    const auto shell = [](SetBuilder& b, double r) {
        b.ring(0, circle({}, r, 90));
        if (r > 1) b.ring(0, reversed(circle({}, r - 0.8, 90)));
    };
    const auto nested = [](SetBuilder& b, double r) {
        b.ring(0, circle({}, r, 90));
        if (r > 12) b.ring(1, circle({}, r - 8, 60));
    };
    const auto ragged = [&](SetBuilder& b, double r) { b.ring(0, star({}, 0.5 * r, r, 30, random)); };
    const auto here_and_there = [&](SetBuilder& b, double r) {
        b.ring(0, circle({}, r, 90));
        if (++drawn % 5 == 0 && r > 10) b.ring(1, circle({0.2 * r, 0}, 2, 20));
    };
    // A disc on one of many planes, with vertices far apart.
    SetBuilder with_disc;
    for (int k = 0; k < 40; ++k) {
        const Vec3 normal = normalized({0.05 * std::sin(7.0 * k), 0.05 * std::cos(5.0 * k), 1});
        with_disc.slice(make_plane({0, 0, 0.5 * k - 10}, normal));
        with_disc.ring(0, circle({}, 20, 12));
        if (k == 20) with_disc.ring(1, circle({}, 8, 12));
    }
    VolumeOptions options;
    options.points_in_all = 100000;
    for (const ContourSet& set :
         {cut_ball(stacks, even, ball), cut_ball(stacks, even, shell), cut_ball(stacks, even, nested),
          cut_ball(pair, even, ragged), cut_ball(pair, close, ragged), cut_ball(fan, {0.0}, ball),
          cut_ball(fan, {0.0}, shell), cut_ball(pair, close, here_and_there),
          cut_ball(stacks, close, here_and_there), with_disc.set}) {
        const std::vector<double> expected = by_asking_everywhere(set, 100000);
        const std::vector<StructureVolume> found = volumes_of(set, {}, options);
        for (std::size_t s = 0; s < expected.size(); ++s) {
            EXPECT_GT(expected[s], 0);
            EXPECT_NEAR(found[s].by_field / expected[s], 1, 1e-12) << s << " of " << set.slices.size();
        }
    }
}

// The error of a structure's volume is one of its own size, whatever else is drawn.
TEST(FieldVolumes, a_small_structure_in_a_large_one_on_crossing_planes) {
    SetBuilder builder;
    const double large = 120, small = 5;
    const Vec3 centre{31, -17, 8};
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{0, 1, 0.1}}) {
        const Vec3 n = normalized(normal);
        const double middle = dot(centre, n);
        std::vector<double> heights;
        for (double h = -115; h < large; h += 10) heights.push_back(h);
        for (double h = middle - 4.5; h < middle + small; h += 1.5) heights.push_back(h);
        std::sort(heights.begin(), heights.end());
        for (const double h : heights) {
            const Plane plane = make_plane(h * n, n);
            builder.slice(plane);
            builder.ring(0, circle({}, std::sqrt(large * large - h * h), 180));
            if (std::abs(h - middle) >= small) continue;
            const double r = std::sqrt(small * small - (h - middle) * (h - middle));
            builder.ring(1, circle(plane.to_plane(centre), r, 60));
        }
    }
    const std::vector<double> expected = by_asking_everywhere(builder.set, 2e6);
    const std::vector<StructureVolume> found = volumes_of(builder.set);
    for (const std::size_t s : {0u, 1u}) EXPECT_NEAR(found[s].by_field / expected[s], 1, 0.003) << s;
}

// A lesion on a few slices of an organ, by its radius and place: it ends at half a slice as it would alone,
// and the organ gets what is left.
TEST(FieldVolumes, a_structure_inside_another_has_the_volume_of_its_slices) {
    for (const double radius : {2.0, 3.0, 5.0, 8.0}) {
        for (const double shift : {0.0, 3.0}) {
            for (int drawn = 1; drawn <= 3; ++drawn) {
                for (const EndCaps caps : {EndCaps::half, EndCaps::rounded}) {
                    SetBuilder builder(true);
                    const Ring organ = circle({}, 14, 90), lesion = circle({shift, 0.5}, radius, 60);
                    for (int k = 0; k < 9; ++k) {
                        builder.slice(axial(5 * k));
                        builder.ring(0, organ);
                        if (k < 3 || k >= 3 + drawn) continue;
                        builder.ring(0, reversed(lesion));
                        builder.ring(1, lesion);
                    }
                    FieldOptions options;
                    options.caps = caps;
                    const auto volumes = volumes_of(builder.set, options);
                    const double slices = 5 * drawn * area_of(lesion);
                    EXPECT_NEAR(volumes[1].by_slices, slices, 1e-6);
                    if (caps == EndCaps::half) {
                        EXPECT_NEAR(volumes[1].by_field, slices, 0.01 * slices)
                            << radius << " " << shift << " " << drawn;
                    } else {
                        EXPECT_LT(volumes[1].by_field, slices);
                    }
                    const double organ_slices = volumes[0].by_slices;
                    EXPECT_NEAR(volumes[0].by_field + volumes[1].by_field, organ_slices + slices,
                                caps == EndCaps::half ? 0.001 * organ_slices : 0.03 * organ_slices);
                }
            }
        }
    }
}

// An organ on nine slices, and something small on 1 to 3 of them: far away, beside it or touching it, of the
// same structure or of another one; or a cavity in it.
enum class Small { island, island_beside, lesion_far, lesion_beside, lesion_touching, cavity };

ContourSet organ_and(Small small, double radius, int drawn, double& area) {
    const bool other =
        small == Small::lesion_far || small == Small::lesion_beside || small == Small::lesion_touching;
    SetBuilder builder(true);
    const Ring organ{{-14, -14}, {14, -14}, {14, 14}, {-14, 14}};
    Ring part =
        circle({small == Small::cavity ? 2.0 : 14 + radius + (small == Small::lesion_far ? 25 : 1.5), 0.5},
               radius, 60);
    if (small == Small::island) part = circle({45, 3}, radius, 60);
    if (small == Small::lesion_touching)
        part = {{14, -radius}, {14 + 2 * radius, -radius}, {14 + 2 * radius, radius}, {14, radius}};
    area = area_of(part);
    for (int k = 0; k < 9; ++k) {
        builder.slice(axial(5 * k));
        const bool is_drawn = k >= 3 && k < 3 + drawn;
        if (is_drawn && small == Small::lesion_touching) {
            builder.ring(0, {{-14, -14}, {14, -14}, {14, -radius}, {14, radius}, {14, 14}, {-14, 14}});
        } else {
            builder.ring(0, organ);
        }
        if (is_drawn) builder.ring(other ? 1 : 0, small == Small::cavity ? reversed(part) : part);
    }
    return builder.set;
}

// Beyond its last slice it keeps half of the gap, as a structure does that ends; without this, half and more
// of its volume is lost.
TEST(FieldVolumes, what_ends_beside_the_rest_has_the_volume_of_its_slices) {
    for (const Small small : {Small::island, Small::island_beside, Small::lesion_far, Small::lesion_beside,
                              Small::lesion_touching, Small::cavity}) {
        for (const double radius : {1.5, 2.6, 5.0, 8.0}) {
            for (int drawn = 1; drawn <= 3; ++drawn) {
                double area = 0;
                const ContourSet set = organ_and(small, radius, drawn, area);
                const auto volumes = volumes_of(set, {});
                const double part = 5 * drawn * area, organ = 9 * 5 * 28 * 28.0;
                double field = -organ;
                for (const auto& volume : volumes) field += volume.by_field;
                // What touches the rest is rounded at its root.
                const double share = small == Small::lesion_touching ? 0.1 : 0.02;
                EXPECT_NEAR(field, small == Small::cavity ? -part : part, share * part + 1e-5 * organ)
                    << static_cast<int>(small) << " " << radius << " " << drawn;
            }
        }
    }
}

// The volume that a field gives all structures, integrated and counted on a lattice.
std::array<double, 2> integrated_and_counted(const ContourSet& set) {
    RunContext context;
    const auto field = make_structure_field(set, {}, context).value();
    std::array<double, 2> sums{};
    for (const auto& volume : volumes_of(set, {})) sums[0] += volume.by_field;
    const double step = 0.23;
    std::vector<std::uint32_t> owners;
    for (double x = -15.1; x < 24; x += step) {
        for (double y = -15.1; y < 16; y += step) {
            for (double z = -3.1; z < 44; z += step) {
                field->members({x, y, z}, owners);
                sums[1] += owners.empty() ? 0 : step * step * step;
            }
        }
    }
    return sums;
}

TEST(FieldVolumes, what_ends_beside_the_rest_equals_the_count_of_every_point) {
    for (const Small small :
         {Small::island_beside, Small::lesion_beside, Small::lesion_touching, Small::cavity}) {
        double area = 0;
        const std::array<double, 2> with = integrated_and_counted(organ_and(small, 3, 2, area)),
                                    without = integrated_and_counted(organ_and(small, 3, 0, area));
        EXPECT_NEAR(with[0] - without[0], with[1] - without[1], 0.04 * 2 * 5 * area)
            << static_cast<int>(small);
    }
}

}  // namespace
}  // namespace anatomesh::volume_test
