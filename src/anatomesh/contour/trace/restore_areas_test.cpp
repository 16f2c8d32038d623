#include "anatomesh/contour/trace/restore_areas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/contour/contour_laws_test.h"
#include "anatomesh/contour/trace/trace.h"

namespace anatomesh::restore_areas_test {
namespace {

struct Picture {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint16_t> labels;

    Picture(std::uint32_t w, std::uint32_t h) : width(w), height(h), labels(std::size_t{w} * h, 0) {}
    std::uint16_t& at(std::uint32_t i, std::uint32_t j) { return labels[std::size_t{j} * width + i]; }
    std::uint16_t at(std::uint32_t i, std::uint32_t j) const { return labels[std::size_t{j} * width + i]; }
};

// A region with a wavy border about a centre off the grid.
void paint_blob(Picture& picture, std::mt19937& random, double radius, std::uint16_t label) {
    std::uniform_real_distribution<double> share(0, 1);
    const Vec2 centre{share(random) * picture.width, share(random) * picture.height};
    const double waves = 2 + std::floor(4 * share(random)), depth = 0.4 * share(random),
                 turn = 6 * share(random);
    for (std::uint32_t j = 0; j < picture.height; ++j) {
        for (std::uint32_t i = 0; i < picture.width; ++i) {
            const Vec2 d = Vec2{double(i), double(j)} - centre;
            if (length(d) < radius * (1 + depth * std::sin(waves * std::atan2(d.y, d.x) + turn)))
                picture.at(i, j) = label;
        }
    }
}

// A path of pixels, one wide, by steps along the axes or also across corners.
void paint_path(Picture& picture, std::mt19937& random, int steps, bool corners, std::uint16_t label) {
    int i = static_cast<int>(random() % picture.width), j = static_cast<int>(random() % picture.height);
    for (int step = 0; step < steps; ++step) {
        picture.at(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)) = label;
        const int di = static_cast<int>(random() % 3) - 1, dj = static_cast<int>(random() % 3) - 1;
        if (!corners && di != 0 && dj != 0) continue;
        i = std::clamp(i + di, 0, static_cast<int>(picture.width) - 1);
        j = std::clamp(j + dj, 0, static_cast<int>(picture.height) - 1);
    }
}

constexpr std::uint16_t structures = 9;
constexpr int kinds = 9;

Picture random_picture(int member) {
    std::mt19937 random(static_cast<unsigned>(member) + 1);
    const std::uint32_t width = 6 + random() % 34, height = 6 + random() % 34;
    Picture picture(width, height);
    std::uniform_real_distribution<double> radius(0.8, 15);
    switch (member % kinds) {
        case 0:  // one region, some with parts
            for (unsigned n = 0; n < 1 + random() % 2; ++n) paint_blob(picture, random, radius(random), 1);
            break;
        case 1:  // holes, and islands in them
            paint_blob(picture, random, 15, 1);
            for (const std::uint16_t label : {0, 0, 1, 2})
                paint_blob(picture, random, radius(random) / 3, label);
            break;
        case 2:  // three labels that meet
            for (std::uint16_t label = 1; label <= 3; ++label)
                paint_blob(picture, random, 4 + radius(random), label);
            break;
        case 3:  // paths of one pixel
            for (std::uint16_t label = 1; label <= 3; ++label) paint_path(picture, random, 60, false, label);
            break;
        case 4:  // pixels that touch at corners
            for (std::uint16_t label = 1; label <= 2; ++label) paint_path(picture, random, 40, true, label);
            break;
        case 5:  // single pixels and pairs, apart
            for (std::uint32_t j = 1; j + 2 < height; j += 3)
                for (std::uint32_t i = 1; i + 2 < width; i += 3) {
                    picture.at(i, j) = 1 + random() % 3;
                    if (random() % 2) picture.at(i + random() % 2, j + 1) = picture.at(i, j);
                }
            break;
        case 6:  // small blocks of four labels that leave no outside
        {
            const std::uint32_t block = 2 + random() % 4;
            std::vector<std::uint16_t> of(std::size_t{width} * height);
            for (auto& label : of) label = 1 + random() % 4;
            for (std::uint32_t j = 0; j < height; ++j)
                for (std::uint32_t i = 0; i < width; ++i)
                    picture.at(i, j) = of[std::size_t{j / block} * width + i / block];
            break;
        }
        case 7:  // noise
            for (auto& label : picture.labels) label = static_cast<std::uint16_t>(random() % 3);
            break;
        default:  // noise of as many labels as there are
            for (auto& label : picture.labels)
                label = static_cast<std::uint16_t>(random() % (structures + 1));
    }
    picture.at(width / 2, height / 2) = 1;  // never empty
    return picture;
}

LabelMap label_map_of(const Picture& picture, int member) {
    LabelMap map;
    map.geometry.size = {picture.width, picture.height, 1};
    std::mt19937 random(static_cast<unsigned>(member));
    std::uniform_real_distribution<double> step(0.3, 3);
    if (member % 3 == 1)
        map.geometry.step = {Vec3{step(random), 0, 0}, Vec3{0, step(random), 0}, Vec3{0, 0, 9}};
    if (member % 3 == 2) map.geometry.step = {Vec3{0.5, 0.2, 0}, Vec3{0.1, -0.6, 0}, Vec3{0, 0, 9}};
    map.voxels = picture.labels;
    for (std::uint16_t s = 1; s <= structures; ++s)
        map.structures.push_back({s, "s" + std::to_string(s), {}});
    return map;
}

LabelGrid grid_of(const Picture& picture) {
    LabelGrid grid;
    grid.width = picture.width;
    grid.height = picture.height;
    grid.labels.assign(std::size_t{grid.row_length()} * (grid.height + 2), 0);
    for (std::uint32_t j = 0; j < grid.height; ++j)
        for (std::uint32_t i = 0; i < grid.width; ++i)
            grid.labels[std::size_t{j + 1} * grid.row_length() + i + 1] = picture.at(i, j);
    return grid;
}

std::vector<Vec2> polygon_of(const TracedGrid& traced, const TracedRing& ring,
                             const std::vector<std::uint8_t>& kept) {
    std::vector<std::uint32_t> points;
    append_ring_points(traced, ring, points);
    std::vector<Vec2> polygon;
    for (const std::uint32_t p : points)
        if (kept[p]) polygon.push_back(traced.network.points[p]);
    return polygon;
}

constexpr int members = 30 * kinds;

TEST(RestoreAreas, every_ring_and_every_hole_has_the_area_of_its_pixels) {
    for (int member = 0; member < members; ++member) {
        const Picture picture = random_picture(member);
        std::int64_t painted = 0;
        for (const std::uint16_t label : picture.labels) painted += label != 0;
        for (const double epsilon : {0.0, 0.15}) {
            TracedGrid traced = trace_label_grid(grid_of(picture), {});
            std::vector<std::uint8_t> kept(traced.network.points.size(), 1);
            if (epsilon > 0) kept = thin_chains(traced.network, {epsilon, 1.0 / 3, 0.1}).kept;
            restore_areas(traced, kept, epsilon);
            std::int64_t pixels = 0;
            for (const TracedRing& ring : traced.rings) {
                const double area = signed_area(polygon_of(traced, ring, kept));
                EXPECT_NEAR(area / static_cast<double>(ring.pixels), 1, 0.005)
                    << "member " << member << ", epsilon " << epsilon << ", pixels " << ring.pixels;
                pixels += ring.pixels;
            }
            EXPECT_EQ(pixels, painted);
        }
    }
}

TEST(RestoreAreas, holes_that_several_structures_bound_have_the_area_of_their_pixels) {
    for (int member = 0; member < members; ++member) {
        TracedGrid traced = trace_label_grid(grid_of(random_picture(member)), {});
        const std::vector<std::uint8_t> kept(traced.network.points.size(), 1);
        restore_areas(traced, kept, 0);
        for (const TracedRing& ring : traced.outside) {
            EXPECT_NEAR(signed_area(polygon_of(traced, ring, kept)) / static_cast<double>(ring.pixels), 1,
                        0.005);
        }
    }
}

TEST(RestoreAreas, outlines_stay_simple_and_on_their_side_of_every_pixel_centre) {
    for (int member = 0; member < members; ++member) {
        const Picture picture = random_picture(member);
        const LabelMap map = label_map_of(picture, member);
        TraceOptions options;
        options.min_area_mm2 = 0;
        if (member / kinds % 2 == 1) options.epsilon_mm = 0;
        RunContext context;
        const auto result = trace_contours(map, nullptr, 0, options, context);
        ASSERT_TRUE(result.ok());
        for (const Warning& warning : context.warnings) EXPECT_NE(warning.code, "W-TRC-009") << member;
        const ContourSet& set = result.value().kept;
        expect_kept_contour_set(set);
        std::vector<double> area(structures + 1, 0), pixels(structures + 1, 0);
        std::vector<std::uint16_t> inside(picture.labels.size(), 0);
        for (const Contour& contour : set.contours) {
            const std::vector<Vec2> polygon = in_plane(set, contour);
            area[contour.structure + 1] += signed_area(polygon);
            for (std::uint32_t j = 0; j < picture.height; ++j) {
                for (std::uint32_t i = 0; i < picture.width; ++i) {
                    const Vec3 centre = map.geometry.position(i, j, 0);
                    if (encloses(polygon, set.slices[0].plane.to_plane(centre)))
                        inside[std::size_t{j} * picture.width + i] ^= 1u << contour.structure;
                }
            }
        }
        std::size_t wrong = 0;
        for (std::size_t n = 0; n < inside.size(); ++n) {
            const std::uint16_t label = picture.labels[n];
            wrong += inside[n] != (label == 0 ? 0 : 1u << (label - 1));
            pixels[label] += 1;
        }
        EXPECT_EQ(wrong, 0u) << member;
        const double pixel = length(cross(map.geometry.step[0], map.geometry.step[1]));
        for (std::uint16_t s = 1; s <= structures; ++s)
            EXPECT_NEAR(area[s], pixels[s] * pixel, 0.005 * area[s]);
    }
}

// Every boundary that two structures share is run in both directions, vertex for vertex: its length is that of the
// pixel edges between them, chamfered.
TEST(RestoreAreas, neighbours_still_share_their_common_boundary_bit_for_bit) {
    for (int member = 0; member < members; ++member) {
        const LabelMap map = label_map_of(random_picture(member), member);
        TraceOptions options;
        options.min_area_mm2 = 0;
        RunContext context;
        const auto result = trace_contours(map, nullptr, 0, options, context);
        ASSERT_TRUE(result.ok());
        const ContourSet& set = result.value().kept;
        LabelMap united = map;
        for (auto& voxel : united.voxels) voxel = voxel > 0 ? 1 : 0;
        const auto outer = trace_contours(united, nullptr, 0, options, context);
        ASSERT_TRUE(outer.ok());
        using Key = std::array<double, 3>;
        std::map<std::pair<Key, Key>, int> directed;
        for (const Contour& contour : set.contours) {
            const auto points = set.points_of(contour);
            for (std::size_t i = 0; i < points.size(); ++i) {
                const Vec3 a = points[i], b = points[(i + 1) % points.size()];
                ++directed[{{a.x, a.y, a.z}, {b.x, b.y, b.z}}];
            }
        }
        // What is run once bounds the outside: together it has the area of all pixels.
        double twice = 0;
        const Vec3 origin = set.points[0], normal = set.slices[0].plane.normal;
        for (const auto& [segment, count] : directed) {
            EXPECT_EQ(count, 1);
            if (directed.count({segment.second, segment.first})) continue;
            const Vec3 a{segment.first[0], segment.first[1], segment.first[2]};
            const Vec3 b{segment.second[0], segment.second[1], segment.second[2]};
            twice += dot(cross(a - origin, b - origin), normal);
        }
        double whole = 0;
        for (const Contour& contour : outer.value().kept.contours)
            whole += signed_area(in_plane(outer.value().kept, contour));
        EXPECT_NEAR(twice / 2, whole, 1e-6 * whole);
    }
}

TEST(RestoreAreas, a_shape_is_the_same_whatever_else_lies_in_the_slice) {
    for (int member = 0; member < members; member += 3) {
        const Picture picture = random_picture(member);
        Picture wide(picture.width + 12, picture.height + 3);
        for (std::uint32_t j = 0; j < picture.height; ++j)
            for (std::uint32_t i = 0; i < picture.width; ++i) wide.at(i, j) = picture.at(i, j);
        Picture both = wide;
        both.at(wide.width - 3, 1) = both.at(wide.width - 3, 3) = both.at(wide.width - 4, 3) = 2;
        std::vector<std::vector<Vec2>> alone, together;
        for (const auto& [of, found] : {std::pair(&wide, &alone), std::pair(&both, &together)}) {
            TracedGrid traced = trace_label_grid(grid_of(*of), {});
            const std::vector<std::uint8_t> kept(traced.network.points.size(), 1);
            restore_areas(traced, kept, 0);
            for (const TracedRing& ring : traced.rings) found->push_back(polygon_of(traced, ring, kept));
        }
        for (const std::vector<Vec2>& polygon : alone)
            EXPECT_EQ(std::count(together.begin(), together.end(), polygon), 1) << member;
    }
}

TEST(RestoreAreas, no_vertex_moves_far_and_large_outlines_hardly_move) {
    for (const double radius : {1.3, 2.6, 5.2, 10.4, 20.8, 41.6}) {
        Picture picture(90, 90);
        for (std::uint32_t j = 0; j < 90; ++j)
            for (std::uint32_t i = 0; i < 90; ++i)
                picture.at(i, j) = std::hypot(i - 44.6, j - 44.3) < radius ? 1 : 0;
        TracedGrid traced = trace_label_grid(grid_of(picture), {});
        const std::vector<Vec2> before = traced.network.points;
        restore_areas(traced, std::vector<std::uint8_t>(before.size(), 1), 0);
        for (std::size_t p = 0; p < before.size(); ++p) {
            // Half a pixel in area, spread over the boundary.
            EXPECT_LT(length(traced.network.points[p] - before[p]), 0.75 / (2 * std::numbers::pi * radius));
        }
    }
}

TEST(RestoreAreas, outlines_of_another_volume_are_told_with_both) {
    const auto told = [](const Picture& picture, const TraceOptions& options) {
        RunContext context;
        EXPECT_TRUE(trace_contours(label_map_of(picture, 0), nullptr, 0, options, context).ok());
        std::vector<std::string> texts;
        for (const Warning& warning : context.warnings)
            if (warning.code == "W-TRC-009")
                texts.push_back(warning.place.structure + ": " + warning.place.value + "; " +
                                warning.what_was_done);
        return texts;
    };
    Picture picture(40, 40);
    for (std::uint32_t j = 5; j < 15; ++j)
        for (std::uint32_t i = 5; i < 25; ++i) picture.at(i, j) = 2;
    EXPECT_TRUE(told(picture, {}).empty());
    picture.at(30, 30) = 2;  // 0.498 % of the structure
    EXPECT_TRUE(told(picture, {}).empty());
    picture.at(34, 30) = 2;
    EXPECT_EQ(told(picture, {}),
              std::vector<std::string>{
                  "s2: 202 mm3 in voxels, 200 mm3 within the outlines; small islands and holes were "
                  "given to what surrounds them; --min-area 0 keeps them"});
    TraceOptions all;
    all.min_area_mm2 = 0;
    EXPECT_TRUE(told(picture, all).empty());
}

TEST(RestoreAreas, a_structure_is_told_where_its_area_could_not_be_kept_and_only_there) {
    int told = 0, kept = 0;
    for (int member = 0; member < members / 3; ++member) {
        const Picture picture = random_picture(member);
        const LabelMap map = label_map_of(picture, member);
        TraceOptions coarse;
        coarse.min_area_mm2 = 0;
        coarse.epsilon_mm = 2;
        RunContext context;
        const auto result = trace_contours(map, nullptr, 0, coarse, context);
        ASSERT_TRUE(result.ok());
        expect_kept_contour_set(result.value().kept);
        std::vector<double> off(structures, 0), pixels(structures, 0);
        const double pixel = length(cross(map.geometry.step[0], map.geometry.step[1]));
        for (std::uint16_t s = 0; s < structures; ++s) {
            for (const std::uint16_t label : picture.labels) pixels[s] += label == s + 1 ? pixel : 0;
            off[s] = std::abs(region_area(result.value().kept, 0, s) - pixels[s]);
        }
        std::size_t warnings = 0;
        for (const Warning& warning : context.warnings) {
            if (warning.code != "W-TRC-009") continue;
            ++warnings;
            EXPECT_NE(warning.what_was_done.find("a smaller --epsilon"), std::string::npos);
        }
        std::size_t expected = 0;
        for (std::uint16_t s = 0; s < structures; ++s) expected += off[s] > 0.005 * pixels[s];
        EXPECT_EQ(warnings, expected) << member;
        (expected > 0 ? told : kept) += 1;
    }
    EXPECT_GT(told, 0);
    EXPECT_GT(kept, 0);
}

}  // namespace
}  // namespace anatomesh::restore_areas_test
