// Laws of the rule between parallel slices on families of shapes.
#include "anatomesh/field/stack/parallel_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/field/voxel_topology_for_test.h"

namespace anatomesh::parallel_field_test {
namespace {

using namespace fixtures;

constexpr double pi = std::numbers::pi;

std::shared_ptr<const StructureField> field_of(const ContourSet& set, RunContext& context) {
    auto field = make_structure_field(set, {}, context);
    EXPECT_TRUE(field.ok());
    return field.value();
}
Topology topology_of(const ContourSet& set, double step) {
    RunContext context;
    return Voxels(*field_of(set, context), step).topology();
}

ContourSet stack(const std::vector<std::vector<Ring>>& slices, double spacing) {
    SetBuilder builder;
    double z = 0;
    for (const std::vector<Ring>& rings : slices) {
        builder.slice(axial(z));
        for (const Ring& ring : rings) builder.ring(0, ring);
        z += spacing;
    }
    return builder.set;
}

// A spherical shell, the highest slice `top` below its north pole.
ContourSet shell(double radius, double thickness, double spacing, double top) {
    SetBuilder builder;
    for (double z = radius - top - spacing * std::floor((2 * radius - top) / spacing); z < radius;
         z += spacing) {
        const double outer = radius * radius - z * z,
                     inner = (radius - thickness) * (radius - thickness) - z * z;
        if (outer <= 0) continue;
        builder.slice(axial(z));
        builder.ring(0, circle({}, std::sqrt(outer), 240));
        if (inner > 0) builder.ring(0, reversed(circle({}, std::sqrt(inner), 240)));
    }
    return builder.set;
}

// A round tube whose axis leans by `degrees` from the normal of the slices.
ContourSet oblique_tube(double degrees, double radius, double spacing, int slices) {
    SetBuilder builder;
    const double lean = degrees * pi / 180;
    for (int k = 0; k < slices; ++k) {
        builder.slice(axial(spacing * k));
        Ring ring = circle({}, radius, 60);
        for (Vec2& q : ring) q.x = q.x / std::cos(lean) + spacing * k * std::tan(lean);
        builder.ring(0, ring);
    }
    return builder.set;
}

// A ring with a gap at angle 0.
Ring open_ring(double inner, double outer, double half_gap) {
    Ring ring;
    constexpr int n = 60;
    for (int i = 0; i <= n; ++i) {
        const double angle = half_gap + (2 * pi - 2 * half_gap) * i / n;
        ring.push_back({outer * std::cos(angle), outer * std::sin(angle)});
    }
    for (int i = n; i >= 0; --i) {
        const double angle = half_gap + (2 * pi - 2 * half_gap) * i / n;
        ring.push_back({inner * std::cos(angle), inner * std::sin(angle)});
    }
    return ring;
}

TEST(ParallelField, a_shell_as_thick_as_the_spacing_is_closed) {
    for (const double top : {0.5, 2.0})
        EXPECT_EQ(topology_of(shell(80, 3, 3, top), 1.2), (Topology{1, 0, 1})) << top;
}

// Wherever the slices lie: the void ends in a paraboloid cap below the last slice, which may be a disc that
// hardly covers it.
TEST(ParallelField, a_shell_is_closed_at_any_position_of_its_slices) {
    struct Shell {
        double radius, thickness, spacing, step;
    };
    for (const Shell& of : {Shell{40, 3, 3, 0.8}, Shell{30, 2, 2, 0.55}, Shell{40, 4, 3, 0.8}}) {
        for (int n = 0; n < 10; ++n) {
            const double top = (n + 0.2) / 10 * of.spacing;
            EXPECT_EQ(topology_of(shell(of.radius, of.thickness, of.spacing, top), of.step),
                      (Topology{1, 0, 1}))
                << of.radius << " " << of.thickness << " " << top;
        }
    }
}

// Between the void's end and the outside there is as much as in the shell elsewhere, but for half a slice's
// cap.
TEST(ParallelField, the_wall_over_a_void_is_not_pinched) {
    for (const double thickness : {3.0, 4.0}) {
        for (int n = 0; n < 20; ++n) {
            const double radius = 60, spacing = 3, top = (n + 0.3) / 20 * spacing;
            RunContext context;
            const auto field = field_of(shell(radius, thickness, spacing, top), context);
            for (double x = 0; x < 20; x += 0.5) {
                double wall = 0, z = radius - 9;
                while (z < radius + 3) {
                    z += 0.02;
                    if (field->value(0, {x, 0.1, z}) < 0) wall += 0.02;
                }
                EXPECT_GT(wall, 0.4 * thickness) << thickness << " " << top << " " << x;
            }
        }
    }
}

TEST(ParallelField, C17_a_shell_whose_rings_do_not_overlap_is_closed_or_a_warning_names_the_slices) {
    for (const double spacing : {5.0, 7.0}) {
        RunContext context;
        const auto field = field_of(shell(80, 3, spacing, 2), context);
        const Topology found = Voxels(*field, 1.2).topology();
        EXPECT_TRUE(found == (Topology{1, 0, 1}) ||
                    (!context.warnings.empty() && context.warnings.front().code == "W-FLD-005" &&
                     !context.warnings.front().place.slice.empty()))
            << spacing << ": " << found;
    }
}

TEST(ParallelField, C21_oblique_tubes_and_a_helix_are_one_piece) {
    for (const double degrees : {45.0, 60.0})
        EXPECT_EQ(topology_of(oblique_tube(degrees, 4, 5, 10), 0.6), (Topology{1, 0, 0})) << degrees;
    SetBuilder helix;
    for (int k = 0; k < 40; ++k) {
        helix.slice(axial(3.0 * k));
        const double angle = 2 * pi * k / 13;
        helix.ring(0, circle({15 * std::cos(angle), 15 * std::sin(angle)}, 4, 40));
    }
    EXPECT_EQ(topology_of(helix.set, 0.8), (Topology{1, 0, 0}));
}

// Between its slices the tube keeps its section: blending distances alone pinches it.
TEST(ParallelField, an_oblique_tube_keeps_its_volume) {
    const double degrees = 60, radius = 4, spacing = 5;
    const auto set = oblique_tube(degrees, radius, spacing, 10);
    RunContext context;
    const auto field = field_of(set, context);
    const StructureVolume volume = field_volumes(*field, 1, {}, context).value().front();
    const double section = pi * radius * radius / std::cos(degrees * pi / 180);
    EXPECT_NEAR(volume.by_field / (section * spacing * 10), 1, 0.03);
    EXPECT_NEAR(volume.by_field / volume.by_slices, 1, 0.03);
}

TEST(ParallelField, C16_branching) {
    const auto at = [](double x, double y, double r) { return circle({x, y}, r, 48); };
    const std::vector<Ring> one{at(0, 0, 10)}, two{at(-6, 0, 5), at(6, 0, 5)};
    EXPECT_EQ(topology_of(stack({one, one, two, two}, 3), 0.5), (Topology{1, 0, 0}));
    EXPECT_EQ(topology_of(stack({two, two, one, one}, 3), 0.5), (Topology{1, 0, 0}));
    const std::vector<Ring> wide{at(0, 0, 14)}, three{at(-8, -5, 5), at(8, -5, 5), at(0, 9, 5)};
    EXPECT_EQ(topology_of(stack({wide, three, wide}, 3), 0.5), (Topology{1, 2, 0}));
}

bool is_ambiguous(const RunContext& context) {
    return std::any_of(context.warnings.begin(), context.warnings.end(),
                       [](const Warning& warning) { return warning.code == "W-FLD-010"; });
}

TEST(ParallelField, C16_what_branches_one_to_many_is_not_ambiguous) {
    const auto at = [](double x, double y, double r) { return circle({x, y}, r, 48); };
    const std::vector<Ring> one{at(0, 0, 14)}, two{at(-6, 0, 5), at(6, 0, 5)},
        three{at(-8, -5, 5), at(8, -5, 5), at(0, 9, 5)}, apart{at(-6, 0, 5), at(6, 0, 5), at(30, 0, 5)};
    // A ring round others is one outline among several.
    const std::vector<Ring> ring{at(0, 0, 40), reversed(at(0, 0, 36)), at(-6, 0, 5), at(6, 0, 5)},
        in_ring{at(0, 0, 40), reversed(at(0, 0, 36)), at(0, 0, 12)};
    for (const std::vector<std::vector<Ring>>& slices :
         std::vector<std::vector<std::vector<Ring>>>{{one, two},
                                                     {two, one},
                                                     {one, three, one},
                                                     {two, two},
                                                     {two, apart},
                                                     {ring, in_ring},
                                                     {in_ring, ring}}) {
        RunContext context;
        field_of(stack(slices, 3), context);
        EXPECT_FALSE(is_ambiguous(context));
    }
}

// Five discs and seven at random: the warning comes where, and only where, discs hang together by
// overlapping, several of each slice, not as many of the one as of the other.
TEST(ParallelField, C16_five_outlines_and_seven_are_ambiguous_where_several_overlap_several) {
    std::mt19937 random(57);
    int ambiguous = 0;
    for (int n = 0; n < 60; ++n) {
        const double spread = 12 + 0.5 * n;  // half the width of where they lie
        struct Disc {
            Vec2 at;
            double radius;
        };
        const auto discs = [&](std::size_t count, double radius) {
            std::uniform_real_distribution<double> place(-spread, spread);
            std::vector<Disc> found;
            for (int tries = 0; found.size() < count && tries < 20000; ++tries) {
                const Vec2 at{place(random), place(random)};
                if (std::none_of(found.begin(), found.end(),
                                 [&](const Disc& other) { return length(at - other.at) < 2.1 * radius; }))
                    found.push_back({at, radius});
            }
            return found;
        };
        const std::array<std::vector<Disc>, 2> drawn{discs(5, 0.34 * spread), discs(7, 0.29 * spread)};
        std::array<std::vector<Ring>, 2> rings;
        std::vector<std::size_t> group(drawn[0].size() + drawn[1].size());
        std::iota(group.begin(), group.end(), std::size_t{0});
        bool is_close = false;  // too close to tell from polygons
        for (std::size_t k : {0u, 1u}) {
            for (const Disc& disc : drawn[k]) rings[k].push_back(circle(disc.at, disc.radius, 90));
        }
        for (std::size_t i = 0; i < drawn[0].size(); ++i) {
            for (std::size_t j = 0; j < drawn[1].size(); ++j) {
                const double over =
                    drawn[0][i].radius + drawn[1][j].radius - length(drawn[0][i].at - drawn[1][j].at);
                is_close |= std::abs(over) < 0.02 * spread;
                if (!(over > 0)) continue;
                const std::size_t from = group[drawn[0].size() + j], to = group[i];
                std::replace(group.begin(), group.end(), from, to);
            }
        }
        if (is_close) continue;
        bool expected = false;
        for (std::size_t g = 0; g < group.size(); ++g) {
            const auto middle = group.begin() + static_cast<std::ptrdiff_t>(drawn[0].size());
            const auto below = std::count(group.begin(), middle, g),
                       above = std::count(middle, group.end(), g);
            expected |= below > 1 && above > 1 && below != above;
        }
        ambiguous += expected;
        RunContext context;
        field_of(stack({rings[0], rings[1]}, 3), context);
        EXPECT_EQ(is_ambiguous(context), expected) << n;
    }
    EXPECT_GT(ambiguous, 5);
}

TEST(ParallelField, C18_a_tip_of_a_thousandth_of_the_area_is_joined) {
    EXPECT_EQ(
        topology_of(stack({{circle({}, 16, 60)}, {circle({}, 16, 60)}, {circle({1, 0}, 0.5, 20)}}, 3), 0.4),
        (Topology{1, 0, 0}));
}

TEST(ParallelField, C20_holes_that_open_to_the_outside) {
    const std::vector<Ring> ring{circle({}, 12, 60), reversed(circle({}, 8, 60))},
        open{open_ring(8, 12, 0.4)};
    EXPECT_EQ(topology_of(stack({open, open, ring, ring}, 3), 0.4), (Topology{1, 1, 0}));
    EXPECT_EQ(topology_of(stack({ring, open, ring}, 3), 0.4), (Topology{1, 2, 0}));
}

TEST(ParallelField, what_does_not_change_stays_upright) {
    std::mt19937 random(5);
    const std::vector<Ring> rings{star({0, 0}, 8, 20, 50, random), reversed(star({0, 0}, 2, 7, 15, random))};
    RunContext context;
    const auto field = field_of(stack({rings, rings, rings, rings}, 3), context);
    std::uniform_real_distribution<double> at(-21, 21), height(0, 9);
    for (int i = 0; i < 5000; ++i) {
        const Vec2 q{at(random), at(random)};
        ASSERT_NEAR(field->value(0, {q.x, q.y, height(random)}), field->value(0, {q.x, q.y, 3}), 1e-6);
    }
}

TEST(ParallelField, a_stack_upside_down_gives_the_same_field) {
    std::mt19937 random(9);
    std::vector<std::vector<Ring>> slices;
    for (int k = 0; k < 5; ++k)
        slices.push_back({star({1.5 * k, 0}, 9, 15, 40, random), circle({40, 0}, 3.0 + k, 30)});
    std::vector<std::vector<Ring>> turned(slices.rbegin(), slices.rend());
    RunContext context;
    const auto field = field_of(stack(slices, 3), context), other = field_of(stack(turned, 3), context);
    std::uniform_real_distribution<double> x(-20, 55), y(-20, 20), z(-2, 14);
    for (int i = 0; i < 5000; ++i) {
        const Vec3 p{x(random), y(random), z(random)};
        ASSERT_NEAR(field->value(0, p), other->value(0, {p.x, p.y, 12 - p.z}), 1e-5);
    }
}

// A point that is far inside on both sides stays inside, and the field has no jumps: from one sample to the
// next it changes by no more than its slope allows.
TEST(ParallelField, is_continuous_along_lines) {
    std::mt19937 random(3);
    std::vector<std::vector<Ring>> slices;
    for (int k = 0; k < 6; ++k) slices.push_back({star({2.5 * k, 0}, 9, 15, 40, random)});
    RunContext context;
    const auto field = field_of(stack(slices, 3), context);
    for (int line = 0; line < 100; ++line) {
        std::uniform_real_distribution<double> x(-20, 32), y(-20, 20), z(-2, 17);
        const Vec3 from{x(random), y(random), z(random)}, to{x(random), y(random), z(random)};
        const auto largest_step = [&](int steps) {
            double largest = 0, last = field->value(0, from);
            for (int i = 1; i <= steps; ++i) {
                const double value = field->value(0, from + (static_cast<double>(i) / steps) * (to - from));
                largest = std::max(largest, std::abs(value - last));
                last = value;
            }
            return largest;
        };
        ASSERT_LT(largest_step(40000), 0.05) << line;
    }
}

TEST(ParallelField, a_ball_bulges_between_its_slices) {
    const double radius = 30;
    RunContext context;
    const auto field = field_of(ball(radius, -28, 4, 360), context);
    double sum = 0;
    int count = 0;
    for (double z = -22; z < 24; z += 4) {  // half-way between slices
        for (int i = 0; i < 12; ++i) {
            const Vec2 direction{std::cos(0.5 * i), std::sin(0.5 * i)};
            double low = 0, high = 40;
            while (high - low > 1e-6) {
                const double middle = 0.5 * (low + high);
                (field->value(0, {middle * direction.x, middle * direction.y, z}) < 0 ? low : high) = middle;
            }
            sum += low - std::sqrt(radius * radius - z * z);
            ++count;
        }
    }
    // Straight lines between the slices are 0.08 mm too far in on average.
    EXPECT_NEAR(sum / count, 0, 0.03);
}

// On slices and between them.
std::vector<double> heights_through(const ContourSet& set, const Box3& box) {
    std::vector<double> heights;
    for (double z = box.low.z; z < box.high.z; z += 0.37) heights.push_back(z);
    for (const Slice& slice : set.slices) heights.push_back(slice.plane.origin.z);
    return heights;
}

// What a value within a reach says is what the value says; also where the boundary moves and curves.
TEST(ParallelField, values_within_a_reach_are_the_values) {
    RunContext context;
    std::size_t beyond = 0;
    for (const ContourSet& set : {shell(12, 3, 2, 0.7), oblique_tube(55, 6, 3, 8), ball(9, -8.5, 3, 40)}) {
        const auto field = field_of(set, context);
        const Box3 box = field->box().grown(1);
        for (const double reach : {0.0, 0.4, 1.5, 100.0}) {
            for (double x = box.low.x; x < box.high.x; x += 0.83) {
                for (double y = box.low.y; y < box.high.y; y += 0.79) {
                    for (const double z : heights_through(set, box)) {
                        const double value = field->value(0, {x, y, z});
                        const double within = field->value_within(0, {x, y, z}, reach);
                        if (within == value) continue;
                        ++beyond;
                        ASSERT_EQ(within < 0, value < 0);
                        ASSERT_GT(std::abs(value), reach);
                        ASSERT_GT(std::abs(within), reach);
                    }
                }
            }
        }
    }
    EXPECT_GT(beyond, 1000u);
}

}  // namespace
}  // namespace anatomesh::parallel_field_test
