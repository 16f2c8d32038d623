#include "anatomesh/live/preview/preview_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <tuple>
#include <utility>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/random_drawing_for_test.h"
#include "anatomesh/field/stack/parallel_field.h"

namespace anatomesh::preview_surface_test {
namespace {

using namespace fixtures;

std::shared_ptr<const StructureField> field_of(const ContourSet& set, const FieldOptions& options = {}) {
    RunContext context;
    auto field = make_structure_field(set, options, context);
    EXPECT_TRUE(field.ok());
    return field.value();
}

PreviewSurface preview_of(const ContourSet& set, const StructureField& field, const PreviewOptions& options,
                          int threads = 1) {
    RunContext context;
    context.threads = threads;
    auto made = make_preview(set, field, options, context);
    EXPECT_TRUE(made.ok());
    return std::move(made.value());
}

void expect_same(const PreviewSurface& a, const PreviewSurface& b) {
    ASSERT_EQ(a.structures.size(), b.structures.size());
    for (std::size_t s = 0; s < a.structures.size(); ++s) {
        ASSERT_EQ(a.structures[s].size(), b.structures[s].size());
        for (auto p = a.structures[s].begin(), q = b.structures[s].begin(); p != a.structures[s].end();
             ++p, ++q) {
            ASSERT_EQ(p->first, q->first);
            ASSERT_EQ(p->second->points, q->second->points);
            ASSERT_EQ(p->second->normals, q->second->normals);
            ASSERT_EQ(p->second->triangles, q->second->triangles);
            ASSERT_EQ(p->second->cells, q->second->cells);
        }
    }
}

struct Measured {
    double volume = 0, area = 0;
    std::size_t triangles = 0, odd_edges = 0;
};

Measured measured(const PreviewSurface::Patches& patches) {
    using Key = std::tuple<double, double, double>;
    const auto key = [](Vec3 p) { return Key{p.x, p.y, p.z}; };
    std::map<std::pair<Key, Key>, int> edges;
    Measured sum;
    for (const auto& [brick, patch] : patches) {
        for (const auto& triangle : patch->triangles) {
            const Vec3 a = patch->points[triangle[0]], b = patch->points[triangle[1]],
                       c = patch->points[triangle[2]];
            sum.volume += dot(a, cross(b, c)) / 6;
            sum.area += 0.5 * length(cross(b - a, c - a));
            for (const auto& [p, q] : {std::pair{a, b}, {b, c}, {c, a}}) ++edges[std::minmax(key(p), key(q))];
        }
        sum.triangles += patch->triangles.size();
    }
    for (const auto& [edge, count] : edges) sum.odd_edges += count % 2;
    return sum;
}

TEST(PreviewSurface, of_a_ball_has_its_volume_and_area_and_is_closed) {
    const ContourSet set = ball(20, -20, 2, 90);
    const auto field = field_of(set);
    for (const double step : {2.0, 1.0, 0.5}) {
        PreviewOptions options;
        options.step_mm = step;
        const Measured found = measured(preview_of(set, *field, options).structures[0]);
        EXPECT_EQ(found.odd_edges, 0u);
        EXPECT_NEAR(found.volume, 4.0 / 3 * M_PI * 8000, 0.02 * 33510) << step;
        EXPECT_NEAR(found.area, 4 * M_PI * 400, 0.05 * 5027) << step;
    }
}

// However slices lie: no hole, every vertex near the surface, and its normal out of the structure.
TEST(PreviewSurface, is_closed_and_near_the_surface_on_random_drawings) {
    std::mt19937 random(1);
    std::size_t vertices = 0, far = 0, inward = 0;
    for (int member = 0; member < 20; ++member) {
        const ContourSet set = set_of(random_drawing(static_cast<Lie>(member % 5), member % 4 == 3, random));
        const auto field = field_of(set);
        const PreviewOptions options;
        const PreviewSurface surface = preview_of(set, *field, options);
        expect_same(preview_of(set, *field, options, 3), surface);
        for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
            EXPECT_EQ(measured(surface.structures[s]).odd_edges, 0u) << member;
            for (const auto& [brick, patch] : surface.structures[s]) {
                for (std::size_t v = 0; v < patch->points.size(); ++v) {
                    ++vertices;
                    far += std::abs(field->value(s, patch->points[v])) > options.step_mm;
                    const Vec3 out = patch->points[v] + options.step_mm * patch->normals[v],
                               in = patch->points[v] - options.step_mm * patch->normals[v];
                    inward += field->value(s, out) < field->value(s, in);
                }
            }
        }
    }
    EXPECT_GT(vertices, 10000u);
    EXPECT_LT(far, vertices / 100);
    EXPECT_LT(inward, vertices / 100);
}

// After edits what is taken over and what is made anew are together the surface of a field made anew, bit for bit, and
// most of it is taken over.
TEST(PreviewSurface, after_an_edit_is_that_of_a_new_field) {
    std::mt19937 random(2);
    PreviewStats sum;
    for (int member = 0; member < 20; ++member) {
        DrawnSlices drawing = random_drawing(static_cast<Lie>(member % 3), member % 4 == 3, random);
        PreviewOptions options;
        options.step_mm = 0.5 + 0.1 * (member % 10);
        ContourSet set = set_of(drawing);
        FieldOptions from_earlier;
        from_earlier.earlier = field_of(set);
        PreviewSurface surface = preview_of(set, *from_earlier.earlier, options);
        for (int step = 0; step < 5; ++step) {
            edit(drawing, random);
            set = set_of(drawing);
            const auto field = field_of(set, from_earlier);
            const auto unlike = stretches_unlike(*field, *from_earlier.earlier);
            std::vector<ChangedStretch> changed;
            if (unlike)
                for (const FieldStretch& stretch : *unlike)
                    changed.push_back({set.slices[0].plane, stretch.low, stretch.high});
            RunContext context;
            context.threads = 1 + step % 2;
            PreviewStats stats;
            auto made =
                make_preview(set, *field, options, context, &stats, unlike ? &surface : nullptr, changed);
            ASSERT_TRUE(made.ok());
            expect_same(made.value(), preview_of(set, *field_of(set), options));
            if (HasFatalFailure()) FAIL() << member << ' ' << step;
            sum.bricks_taken += stats.bricks_taken;
            sum.bricks_made += stats.bricks_made;
            from_earlier.earlier = field;
            surface = std::move(made.value());
        }
    }
    EXPECT_GT(sum.bricks_taken, 500u);
    EXPECT_GT(sum.bricks_made, 500u);
}

TEST(PreviewSurface, larger_than_allowed_is_refused) {
    const ContourSet set = ball(20, -20, 2, 90);
    const auto field = field_of(set);
    PreviewOptions options;
    options.step_mm = 0.1;
    options.max_cells = 1'000'000;
    RunContext context;
    auto made = make_preview(set, *field, options, context);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, "E-LIV-201");
    // Two structures 20 m apart along each axis: refused before anything is listed.
    SetBuilder far_apart;
    for (const double z : {0.0, 3.0, 20000.0, 20003.0}) {
        far_apart.slice(axial(z));
        far_apart.ring(0, circle(z > 100 ? Vec2{20000, 20000} : Vec2{}, 10, 30));
    }
    options.step_mm = 0.05;
    made = make_preview(far_apart.set, *field_of(far_apart.set), options, context);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, "E-LIV-201");
}

TEST(PreviewSurface, ends_when_cancelled) {
    const ContourSet set = ball(20, -20, 2, 90);
    const auto field = field_of(set);
    const std::atomic<bool> cancel = true;
    RunContext context;
    context.cancel = &cancel;
    const auto made = make_preview(set, *field, {}, context);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace anatomesh::preview_surface_test
