// Relations between models: what must not change when the input is given in another way, and random solids.
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "anatomesh/contour/trace/trace.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh::relations_test {
namespace {

using namespace fixtures;

// A solid without symmetry, with a hole, a branch, an island and a second structure; coordinates are
// multiples of 2^-20.
Drawing awkward_solid() {
    Drawing drawing;
    for (int z = 0; z < 8; ++z) {
        drawing.add(0, z, circle({0.3 * z, 0}, 6, 26 + z));
        if (z > 1 && z < 6) drawing.add(0, z, circle({0.3 * z, 1}, 2.5, 13));
        if (z > 3) drawing.add(0, z, circle({12, 3}, 2, 11));
        if (z > 2) drawing.add(1, z, circle({-7.5 - 0.2 * z, 1}, 3, 15));
    }
    drawing.add(0, 4, circle({0, 14}, 2, 9));
    drawing.move([](Vec3 p) {
        const auto rounded = [](double x) { return std::ldexp(std::round(std::ldexp(x, 20)), -20); };
        return Vec3{rounded(p.x), rounded(p.y), rounded(p.z)};
    });
    return drawing;
}

Model model_of(const RawContours& raw, double size = 0, int threads = 1) {
    auto made = build(kept(raw), size, threads);
    if (!made.ok()) {
        ADD_FAILURE() << to_line(made.error());
        return {};
    }
    return std::move(made).value();
}

// M1: the order of contours, where each starts and which way it runs do not matter.
TEST(Relations, C38_shuffled_rotated_and_reversed_contours_give_the_same_bytes) {
    const Drawing drawing = awkward_solid();
    const Model reference = model_of(drawing.raw);
    EXPECT_GT(reference.mesh.cells.size(), 1000u);
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        std::mt19937 random(seed);
        RawContours shuffled = drawing.raw;
        shuffled.points.clear();
        std::shuffle(shuffled.contours.begin(), shuffled.contours.end(), random);
        for (RawContour& contour : shuffled.contours) {
            std::vector<Vec3> points(drawing.raw.points.begin() + contour.first_point,
                                     drawing.raw.points.begin() + contour.first_point + contour.point_count);
            std::rotate(points.begin(), points.begin() + random() % points.size(), points.end());
            if (random() % 2) std::reverse(points.begin(), points.end());
            contour.first_point = static_cast<std::uint32_t>(shuffled.points.size());
            shuffled.points.insert(shuffled.points.end(), points.begin(), points.end());
        }
        std::swap(shuffled.structures[0], shuffled.structures[1]);
        for (RawContour& contour : shuffled.contours) contour.structure = 1 - contour.structure;
        expect_same_mesh(model_of(shuffled), reference);
    }
}

// M2
TEST(Relations, one_and_several_threads_give_the_same_bytes) {
    const Drawing drawing = awkward_solid();
    const Model reference = model_of(drawing.raw);
    for (const int threads : {2, 3, 8}) expect_same_mesh(model_of(drawing.raw, 0, threads), reference);
}

// M4: the volumes stay within the certificate's tolerance, on both sides.
TEST(Relations, turns_by_90_degrees_keep_volume_and_topology) {
    Drawing drawing = awkward_solid();
    const Model reference = model_of(drawing.raw);
    const std::vector<std::function<Vec3(Vec3)>> turns{[](Vec3 p) {
                                                           return Vec3{-p.y, p.x, p.z};
                                                       },
                                                       [](Vec3 p) {
                                                           return Vec3{p.y, p.z, p.x};
                                                       },
                                                       [](Vec3 p) {
                                                           return Vec3{p.x, -p.z, p.y};
                                                       }};
    for (const auto& turn : turns) {
        Drawing turned = drawing;
        turned.move(turn);
        const Model model = model_of(turned.raw);
        for (std::size_t s = 0; s < 2; ++s) {
            const StructureReport& a = reference.report.structures[s];
            expect_structure(model, s, {a.surface.components, a.surface.genus, a.volume.mesh_mm3, 0.004});
        }
        const double cells = static_cast<double>(reference.mesh.cells.size());
        EXPECT_NEAR(static_cast<double>(model.mesh.cells.size()), cells, 0.05 * cells);
    }
}

// M6
TEST(Relations, C32_scaling_by_a_power_of_two_keeps_the_cells) {
    const Drawing drawing = awkward_solid();
    const Model reference = model_of(drawing.raw);
    for (const double factor : {0.25, 8.0}) {
        // Grouping and repair have tolerances in mm, so the kept contours are scaled.
        ContourSet set = kept(drawing.raw);
        for (Vec3& p : set.points) p = factor * p;
        for (Slice& slice : set.slices) slice.plane.origin = factor * slice.plane.origin;
        const auto made = build(set);
        ASSERT_TRUE(made.ok()) << to_line(made.error());
        EXPECT_EQ(made.value().mesh.cells, reference.mesh.cells) << factor;
        EXPECT_EQ(made.value().mesh.regions, reference.mesh.regions) << factor;
    }
}

// M11, as far as it is promised: what is far away changes neither the topology nor the volume.
TEST(Relations, a_second_structure_far_away_leaves_the_first_alone) {
    Drawing drawing = awkward_solid();
    const Model alone = model_of(drawing.raw, 1);
    for (int z = 0; z < 8; ++z) drawing.add(2, z, circle({60, 40}, 3, 20));
    const Model both = model_of(drawing.raw, 1);
    ASSERT_EQ(both.report.structures.size(), 3u);
    for (std::size_t s = 0; s < 2; ++s) {
        const StructureReport& a = alone.report.structures[s];
        expect_structure(both, s, {a.surface.components, a.surface.genus, a.volume.mesh_mm3, 0.004});
    }
}

// Sums of random balls in an image: branches, holes, islands, contacts of three structures, in any place.
LabelMap random_balls(std::uint32_t seed, std::uint16_t structures) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(0, 1);
    LabelMap map;
    map.geometry.size = {22, 20, 9};
    map.geometry.step = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 2}};
    map.voxels.assign(map.geometry.voxel_count(), 0);
    for (std::uint16_t s = 1; s <= structures; ++s)
        map.structures.push_back({s, "s" + std::to_string(s), {}});
    for (int ball = 0; ball < 7; ++ball) {
        const Vec3 centre{22 * share(random), 20 * share(random), 18 * share(random)};
        const double radius = 2 + 4 * share(random);
        // Every fifth ball is cut out.
        const auto label = static_cast<std::uint16_t>(ball % 5 == 4 ? 0 : 1 + ball % structures);
        for (std::uint32_t k = 0; k < 9; ++k) {
            for (std::uint32_t j = 0; j < 20; ++j) {
                for (std::uint32_t i = 0; i < 22; ++i) {
                    if (length(map.geometry.position(i, j, k) - centre) < radius)
                        map.voxels[map.geometry.index(i, j, k)] = label;
                }
            }
        }
    }
    return map;
}

struct SegmentCount {
    std::uint64_t drawn = 0, missed = 0;
};

SegmentCount expect_random_solid_certified(std::uint32_t seed, std::uint16_t structures) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", structures " + std::to_string(structures));
    RunContext context;
    TraceOptions options;
    options.min_area_mm2 = 0;
    const auto traced = trace_contours(random_balls(seed, structures), nullptr, 0, options, context);
    EXPECT_TRUE(traced.ok()) << to_line(traced.error());
    if (!traced.ok()) return {};
    const auto made = build(traced.value().kept);
    EXPECT_TRUE(made.ok()) << to_line(made.error());
    if (!made.ok()) return {};
    expect_certified(made.value(), traced.value().kept);
    SegmentCount count;
    for (const StructureReport& structure : made.value().report.structures) {
        count.drawn += structure.fidelity.segments;
        count.missed += structure.fidelity.segments - structure.fidelity.segments_on_surface;
    }
    return count;
}

TEST(Relations, random_solids_of_one_structure_are_certified) {
    for (std::uint32_t seed = 1; seed <= 22; ++seed)
        EXPECT_EQ(expect_random_solid_certified(seed, 1).missed, 0u) << "seed " << seed;
}

// Where three structures meet, one segment in some thousands is not a chain of surface edges.
TEST(Relations, random_solids_of_three_structures_are_certified) {
    SegmentCount all;
    for (std::uint32_t seed = 101; seed <= 108; ++seed) {
        const SegmentCount count = expect_random_solid_certified(seed, 3);
        all.drawn += count.drawn;
        all.missed += count.missed;
    }
    EXPECT_GT(all.drawn, 1000u);
    EXPECT_LE(all.missed, 1u);
}

// Overlapping discs drawn at random, each structure by itself.
TEST(Relations, random_drawings_of_overlapping_structures_are_certified) {
    for (std::uint32_t seed = 201; seed <= 210; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> share(0, 1);
        Drawing drawing;
        for (std::uint32_t s = 0; s < 3; ++s) {
            Vec2 centre{6 * share(random), 6 * share(random)};
            const int first = static_cast<int>(3 * share(random)),
                      last = 4 + static_cast<int>(4 * share(random));
            for (int z = first; z < last; ++z) {
                centre = centre + Vec2{share(random) - 0.5, share(random) - 0.5};
                drawing.add(s, 1.5 * z,
                            circle(centre, 2 + 2 * share(random), 10 + static_cast<int>(10 * share(random))));
            }
        }
        const ContourSet set = kept(drawing.raw);
        const auto made = build(set);
        ASSERT_TRUE(made.ok()) << to_line(made.error());
        expect_certified(made.value(), set);
    }
}

// M3, G-31
TEST(Relations, an_exact_translation_moves_the_points_and_keeps_the_cells) {
    Drawing drawing = awkward_solid();
    const Model reference = model_of(drawing.raw, 1);
    const Vec3 shift{1024, -2048, 512};
    drawing.move([&](Vec3 p) { return p + shift; });
    const Model moved = model_of(drawing.raw, 1);
    ASSERT_EQ(moved.mesh.points.size(), reference.mesh.points.size());
    EXPECT_TRUE(moved.mesh.cells == reference.mesh.cells);
    for (std::size_t v = 0; v < moved.mesh.points.size(); ++v) {
        ASSERT_LT(length(moved.mesh.points[v] - shift - reference.mesh.points[v]), 1e-9);
    }
}

}  // namespace
}  // namespace anatomesh::relations_test
