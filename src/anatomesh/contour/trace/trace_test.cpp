#include "anatomesh/contour/trace/trace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/contour/contour_laws_test.h"
#include "anatomesh/contour/same_contours_for_test.h"

namespace anatomesh::trace_test {
namespace {

using fixtures::same;

constexpr double pi = std::numbers::pi;

LabelMap label_map(std::array<std::uint32_t, 3> size, std::uint16_t structures = 1) {
    LabelMap map;
    map.geometry.size = size;
    map.voxels.assign(map.geometry.voxel_count(), 0);
    for (std::uint16_t s = 1; s <= structures; ++s)
        map.structures.push_back({s, "s" + std::to_string(s), {}});
    return map;
}

// One slice from rows of digits; the first row is j = 0.
LabelMap slice_of(const std::vector<std::string>& rows, std::uint16_t structures = 1) {
    LabelMap map = label_map(
        {static_cast<std::uint32_t>(rows[0].size()), static_cast<std::uint32_t>(rows.size()), 1}, structures);
    for (std::uint32_t j = 0; j < rows.size(); ++j) {
        for (std::uint32_t i = 0; i < rows[j].size(); ++i) {
            map.voxels[map.geometry.index(i, j, 0)] = static_cast<std::uint16_t>(rows[j][i] - '0');
        }
    }
    return map;
}

// A grey image of `value` at the voxel centres in millimetres, and its label map at value >= 0.
std::pair<GreyImage, LabelMap> sampled(const ImageGeometry& geometry,
                                       const std::function<double(Vec3)>& value) {
    GreyImage grey;
    grey.geometry = geometry;
    LabelMap map = label_map(geometry.size);
    map.geometry = geometry;
    for (std::uint32_t k = 0; k < geometry.size[2]; ++k) {
        for (std::uint32_t j = 0; j < geometry.size[1]; ++j) {
            for (std::uint32_t i = 0; i < geometry.size[0]; ++i) {
                grey.voxels.push_back(static_cast<float>(value(geometry.position(i, j, k))));
                map.voxels[geometry.index(i, j, k)] = grey.voxels.back() >= 0 ? 1 : 0;
            }
        }
    }
    return {grey, map};
}

TraceResult trace(const LabelMap& map, const TraceOptions& options = {}, const GreyImage* grey = nullptr,
                  double threshold = 0) {
    RunContext context;
    auto result = trace_contours(map, grey, threshold, options, context);
    if (!result) {
        ADD_FAILURE() << to_line(result.error());
        return {};
    }
    expect_kept_contour_set(result.value().kept);
    return std::move(result).value();
}

TraceOptions everything() {
    TraceOptions options;
    options.epsilon_mm = 0;
    options.min_area_mm2 = 0;
    return options;
}

TEST(Trace, circles_are_met_to_a_fiftieth_of_a_pixel) {
    for (const double radius : {9.0, 13.3, 20.7}) {
        for (const Vec2 centre : {Vec2{24, 24}, Vec2{24.3, 23.1}, Vec2{23.5, 24.5}}) {
            ImageGeometry geometry;
            geometry.size = {49, 49, 1};
            const auto [grey, map] = sampled(geometry, [&](Vec3 p) {
                return radius - length(Vec2{p.x, p.y} - centre);
            });
            const TraceResult traced = trace(map, everything(), &grey);
            ASSERT_EQ(traced.kept.contours.size(), 1u);
            for (const Vec3& p : traced.kept.points) {
                EXPECT_NEAR(length(Vec2{p.x, p.y} - centre), radius, 0.02);
            }
            EXPECT_NEAR(region_area(traced.kept, 0, 0), pi * radius * radius, 0.01 * pi * radius * radius);

            const TraceResult thin = trace(map, {}, &grey);
            EXPECT_LT(thin.kept.points.size(), traced.kept.points.size() / 2);
            EXPECT_LE(thin.stats.max_distance_mm, 0.15);
            EXPECT_NEAR(region_area(thin.kept, 0, 0), pi * radius * radius, 2 * pi * radius * 0.15);
        }
    }
}

TEST(Trace, annuli_on_oblique_sheared_and_mirrored_grids_have_their_area) {
    const Vec3 u = normalized({1, 0.2, -0.3}), w = normalized(cross(u, {0.1, 1, 0.4})), v = cross(w, u);
    std::vector<ImageGeometry> grids(5);
    grids[1].step = {0.8 * u, 0.5 * v, 3.0 * w};            // anisotropic, oblique
    grids[2].step = {0.8 * u, 0.5 * v, 3.0 * w + 0.7 * v};  // gantry tilt
    grids[3].step = {0.8 * u, -0.5 * v, 3.0 * w};           // left-handed
    grids[4].step = {0.7 * u + 0.3 * v, 0.6 * v - 0.1 * u,
                     -3.0 * w};  // sheared in the plane, slices downwards
    for (ImageGeometry& grid : grids) {
        grid.size = {80, 90, 3};
        grid.origin = {-100.3, 55.7, 12.1};
        const Vec3 centre = grid.position(40.2, 44.6, 1);
        const Vec3 normal = normalized(cross(grid.step[0], grid.step[1]));
        const double outer = 15.2, inner = 7.3;
        const auto [grey, map] = sampled(grid, [&](Vec3 p) {
            const double distance = length(p - centre - dot(p - centre, normal) * normal);
            return std::min(outer - distance, distance - inner);
        });
        const TraceResult traced = trace(map, everything(), &grey);
        ASSERT_EQ(traced.kept.slices.size(), 3u);
        ASSERT_EQ(traced.kept.contours.size(), 6u);
        for (std::uint32_t s = 0; s < 3; ++s) {
            EXPECT_NEAR(region_area(traced.kept, s, 0), pi * (outer * outer - inner * inner), 4.0);
        }
        EXPECT_TRUE(all_parallel(traced.kept, 1e-9));
        EXPECT_NEAR(median_spacing(traced.kept), std::abs(dot(grid.step[2], normal)), 1e-9);
        trace(map, {}, &grey);
    }
}

TEST(Trace, slices_lie_across_the_axis_of_largest_spacing) {
    for (std::uint32_t across = 0; across < 3; ++across) {
        LabelMap map = label_map({6, 6, 6});
        map.geometry.step[across] = 2.0 * map.geometry.step[across];
        for (std::uint32_t n = 0; n < 27; ++n)
            map.voxels[map.geometry.index(1 + n % 3, 1 + n / 3 % 3, 1 + n / 9)] = 1;
        const TraceResult traced = trace(map, everything());
        EXPECT_EQ(traced.stats.slice_axis, across);
        EXPECT_EQ(traced.stats.slices, 3u);
        EXPECT_EQ(traced.kept.slices[0].name, std::string(1, "ijk"[across]) + " = 1");
        EXPECT_NEAR(median_spacing(traced.kept), 2.0, 1e-12);
        EXPECT_EQ(traced.kept.slices[0].plane.normal,
                  (Vec3{across == 0 ? 1.0 : 0, across == 1 ? 1.0 : 0, across == 2 ? 1.0 : 0}));
    }
    EXPECT_EQ(trace(slice_of({"11", "11"})).stats.slice_axis, 2u);
}

TEST(Trace, every_nth_slice_from_an_offset) {
    LabelMap map = label_map({4, 4, 10});
    map.geometry.step[2] = {0, 0, 2};
    std::fill(map.voxels.begin(), map.voxels.end(), std::uint16_t{1});
    TraceOptions options;
    options.every = 3;
    options.offset = 2;
    const TraceResult traced = trace(map, options);
    ASSERT_EQ(traced.kept.slices.size(), 3u);
    EXPECT_EQ(traced.kept.slices[0].name, "k = 2");
    EXPECT_EQ(traced.kept.slices[2].name, "k = 8");
    EXPECT_EQ(traced.kept.slices[2].plane.origin.z, 16.0);
}

TEST(Trace, nested_rings_alternate_in_direction) {
    ImageGeometry geometry;
    geometry.size = {64, 64, 1};
    const auto [grey, map] = sampled(geometry, [](Vec3 p) {
        return std::cos(length(Vec2{p.x - 31.4, p.y - 31.7}) * 0.7);
    });
    const TraceResult traced = trace(map, {}, &grey);
    EXPECT_GE(traced.kept.contours.size(), 6u);
}

TEST(Trace, an_empty_slice_between_two_is_kept_and_those_at_the_ends_are_not) {
    LabelMap map = label_map({4, 4, 6});
    for (const std::uint32_t k : {1u, 3u}) {
        for (std::uint32_t n = 0; n < 4; ++n) map.voxels[map.geometry.index(1 + n % 2, 1 + n / 2, k)] = 1;
    }
    const TraceResult traced = trace(map);
    ASSERT_EQ(traced.kept.slices.size(), 3u);
    EXPECT_EQ(traced.kept.slices[1].contour_count, 0u);
}

TEST(Trace, L13_all_ones_is_closed_half_a_pixel_beyond_the_border) {
    LabelMap map = label_map({5, 4, 3});
    std::fill(map.voxels.begin(), map.voxels.end(), std::uint16_t{1});
    RunContext context;
    const auto traced = trace_contours(map, nullptr, 0, everything(), context);
    ASSERT_TRUE(traced.ok());
    expect_kept_contour_set(traced.value().kept);
    const Box3 box = traced.value().kept.box();
    // The four corners are cut, and the sides lie a little farther out for it.
    EXPECT_GT(length(box.low - Vec3{-0.5, -0.5, 0}), 0.0);
    EXPECT_LT(length(box.low - Vec3{-0.5, -0.5, 0}), 0.05);
    EXPECT_LT(length(box.high - Vec3{4.5, 3.5, 2}), 0.05);
    EXPECT_NEAR(region_area(traced.value().kept, 0, 0), 20, 1e-9);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-TRC-001");
}

TEST(Trace, L14_all_zeros_names_the_structure) {
    RunContext context;
    const auto traced = trace_contours(label_map({3, 3, 3}, 2), nullptr, 0, {}, context);
    ASSERT_FALSE(traced.ok());
    EXPECT_EQ(traced.error().code, "E-TRC-001");
    EXPECT_EQ(traced.error().kind, ErrorKind::geometry);
    EXPECT_EQ(traced.error().place.structure, "s1, s2");
}

TEST(Trace, slices_kept_where_nothing_is_labelled_are_told_from_an_empty_image) {
    LabelMap map = label_map({6, 6, 5});
    for (std::uint32_t j = 1; j < 5; ++j) {
        for (std::uint32_t i = 1; i < 5; ++i) map.voxels[map.geometry.index(i, j, 2)] = 1;
    }
    TraceOptions options;
    options.every = 4;
    RunContext context;
    const auto traced = trace_contours(map, nullptr, 0, options, context);
    ASSERT_FALSE(traced.ok());
    EXPECT_EQ(traced.error().code, "E-TRC-001");
    EXPECT_EQ(traced.error().message, "no voxel belongs to a structure in the 2 of 5 slices that are used");
    EXPECT_EQ(traced.error().next_step, "give a smaller --every or another --offset");
    options.offset = 2;
    EXPECT_TRUE(trace_contours(map, nullptr, 0, options, context).ok());
}

TEST(Trace, contours_that_a_wide_bound_makes_smaller_are_warned_of) {
    ImageGeometry geometry;
    geometry.size = {48, 48, 3};
    // A ring, so that the hole counts as one, turned and mirrored.
    geometry.step = {Vec3{0.6, 0.8, 0}, Vec3{0.8, -0.6, 0}, Vec3{0, 0, 3}};
    const Vec3 centre = geometry.position(23.5, 23.5, 1);
    const auto [grey, map] = sampled(geometry, [&](Vec3 p) {
        const double r = std::hypot(p.x - centre.x, p.y - centre.y);
        return std::abs(p.z - centre.z) < 1 ? std::min(18 - r, r - 6) : -1.0;
    });
    for (const double epsilon : {-1.0, 0.0, 0.5, 5.0}) {
        TraceOptions options;
        options.epsilon_mm = epsilon;
        RunContext context;
        const auto traced = trace_contours(map, &grey, 0, options, context);
        ASSERT_TRUE(traced.ok());
        std::vector<std::string> codes;
        for (const Warning& warning : context.warnings) codes.push_back(warning.code);
        EXPECT_EQ(codes, epsilon < 5 ? std::vector<std::string>{} : std::vector<std::string>{"W-CON-024"});
    }
}

TEST(Trace, an_empty_structure_among_others_is_named) {
    RunContext context;
    const auto traced =
        trace_contours(slice_of({"0000", "0110", "0110", "0000"}, 2), nullptr, 0, {}, context);
    ASSERT_TRUE(traced.ok());
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-TRC-004");
    EXPECT_EQ(context.warnings[0].place.structure, "s2");
}

TEST(Trace, pieces_that_no_kept_slice_meets_are_told) {
    // A block through all slices and, between the slices 2 and 4, an island of 3 x 3 voxels.
    for (const int turned : {0, 1, 2}) {
        LabelMap map = label_map({12, 12, 12}, 2);
        map.geometry.step = {Vec3{0.5, 0, 0}, Vec3{0, 0.5, 0}, Vec3{0, 0, 0.5}};
        const int across = 2 - turned, u = (across + 1) % 3, v = (across + 2) % 3;
        map.geometry.step[across] = 4 * map.geometry.step[across];
        for (std::uint32_t n = 0; n < 1728; ++n) {
            const std::array<std::uint32_t, 3> at{n % 12, n / 12 % 12, n / 144};
            const bool block = at[u] < 5 && at[v] < 5;
            const bool island = at[u] > 7 && at[u] < 11 && at[v] > 7 && at[v] < 11 && at[across] == 3;
            map.voxels[n] = block ? 1 : island ? 1 : 0;
        }
        map.voxels[map.geometry.index(6, 6, 6)] = 2;  // a structure of its own that is lost: another warning
        const auto told = [&](std::uint32_t every, std::uint32_t offset) {
            TraceOptions options;
            options.every = every;
            options.offset = offset;
            options.min_area_mm2 = 1;
            RunContext context;
            EXPECT_TRUE(trace_contours(map, nullptr, 0, options, context).ok());
            std::vector<std::string> values;
            for (const Warning& warning : context.warnings) {
                if (warning.code == "W-TRC-006")
                    values.push_back(warning.place.structure + " " + warning.place.value);
            }
            return values;
        };
        EXPECT_TRUE(told(1, 0).empty());
        EXPECT_TRUE(told(2, 1).empty());
        EXPECT_TRUE(told(3, 0).empty());
        EXPECT_EQ(told(2, 0), std::vector<std::string>{"s1 4.5 mm3"});
        EXPECT_EQ(told(4, 1), std::vector<std::string>{"s1 4.5 mm3"});
    }
}

TEST(Trace, no_slice_kept) {
    RunContext context;
    TraceOptions options;
    options.every = 9;
    options.offset = 5;
    const auto traced = trace_contours(slice_of({"1"}), nullptr, 0, options, context);
    ASSERT_FALSE(traced.ok());
    EXPECT_EQ(traced.error().code, "E-TRC-002");
}

TEST(Trace, L15_checkerboard_pixels_stay_apart) {
    LabelMap map = label_map({9, 8, 1});
    std::uint32_t ones = 0;
    for (std::uint32_t n = 0; n < 72; ++n) ones += map.voxels[n] = (n % 9 + n / 9) % 2;
    const TraceResult traced = trace(map, everything());
    EXPECT_EQ(traced.kept.contours.size(), ones);
    EXPECT_NEAR(region_area(traced.kept, 0, 0), ones, 1e-9);
}

TEST(Trace, L15_two_pixels_joined_by_a_corner_stay_apart_and_their_inverse_is_joined) {
    EXPECT_EQ(trace(slice_of({"0000", "0100", "0010", "0000"}), everything()).kept.contours.size(), 2u);
    // The outside is joined across corners: one hole.
    const TraceResult inverse = trace(slice_of({"1111", "1011", "1101", "1111"}), everything());
    EXPECT_EQ(inverse.kept.contours.size(), 2u);
}

TEST(Trace, L15_a_checkerboard_of_two_structures_joins_the_lower_number) {
    const TraceResult traced = trace(slice_of({"1212", "2121", "1212"}, 2), everything());
    std::map<std::uint32_t, int> contours;
    for (const Contour& contour : traced.kept.contours) ++contours[contour.structure];
    EXPECT_EQ(contours[1], 6);
    EXPECT_LT(contours[0], 6);
}

TEST(Trace, L16_small_pieces_are_left_out_and_counted_or_kept_on_demand) {
    const LabelMap map = slice_of({"100000000", "000000000", "001111100", "001111100", "001101100",
                                   "001111100", "001111100", "000000000", "011100000"});
    RunContext context;
    const auto traced = trace_contours(map, nullptr, 0, {}, context);
    ASSERT_TRUE(traced.ok());
    EXPECT_EQ(traced.value().stats.islands_left_out, 2u);
    EXPECT_EQ(traced.value().stats.area_left_out_mm2, 4.0);
    EXPECT_EQ(traced.value().stats.holes_filled, 1u);
    EXPECT_EQ(traced.value().kept.contours.size(), 1u);
    std::vector<std::string> codes;
    for (const Warning& warning : context.warnings) codes.push_back(warning.code);
    // Of 26 pixels 4 are islands.
    EXPECT_EQ(codes, (std::vector<std::string>{"W-TRC-002", "W-TRC-003", "W-TRC-005", "W-TRC-009"}));
    EXPECT_EQ(trace(map, everything()).kept.contours.size(), 4u);
}

TEST(Trace, L16_everything_below_the_minimum_area) {
    RunContext context;
    const auto traced = trace_contours(slice_of({"000", "010", "000"}), nullptr, 0, {}, context);
    ASSERT_FALSE(traced.ok());
    EXPECT_EQ(traced.error().next_step, "give a smaller --min-area");
}

TEST(Trace, L17_thinnest_images) {
    TraceOptions options;
    options.min_area_mm2 = 0;
    for (const std::array<std::uint32_t, 3> size : {std::array<std::uint32_t, 3>{1, 1, 1},
                                                    {7, 1, 1},
                                                    {1, 7, 1},
                                                    {1, 1, 7},
                                                    {5, 6, 1},
                                                    {5, 1, 6},
                                                    {1, 5, 6}}) {
        LabelMap map = label_map(size);
        std::fill(map.voxels.begin(), map.voxels.end(), std::uint16_t{1});
        const TraceResult traced = trace(map, options);
        EXPECT_EQ(traced.kept.contours.size(), size[2]);
        EXPECT_NEAR(region_area(traced.kept, 0, 0), double(size[0]) * size[1], 1e-9);
    }
}

TEST(Trace, values_exactly_at_the_threshold_give_simple_contours) {
    // Many voxels on the threshold itself: every crossing would fall on a pixel centre.
    std::mt19937 random(7);
    for (int round = 0; round < 20; ++round) {
        ImageGeometry geometry;
        geometry.size = {23, 19, 2};
        const auto [grey, map] = sampled(geometry, [&](Vec3) { return double(random() % 3) - 1.0; });
        trace(map, everything(), &grey);
        trace(map, {}, &grey);
        TraceOptions coarse;
        coarse.epsilon_mm = 0.9;
        trace(map, coarse, &grey);
    }
}

TEST(Trace, values_that_are_no_numbers_are_crossed_half_way) {
    const double infinite = std::numeric_limits<double>::infinity();
    for (const double outside : {std::nan(""), -infinite}) {
        ImageGeometry geometry;
        geometry.size = {4, 4, 1};
        const auto [grey, map] = sampled(geometry, [&](Vec3 p) {
            return p.x >= 1 && p.x <= 2 && p.y >= 1 && p.y <= 2 ? infinite : outside;
        });
        const TraceResult traced = trace(map, everything(), &grey);
        EXPECT_NEAR(region_area(traced.kept, 0, 0), 3.5, 1e-12);
    }
}

// A random partition with junctions, pinches and enclosed pieces.
LabelMap random_partition(std::uint32_t width, std::uint32_t height, std::uint16_t structures, unsigned seed,
                          bool with_outside) {
    LabelMap map = label_map({width, height, 4}, structures);
    map.geometry.step = {Vec3{0.7, 0, 0}, Vec3{0, 0.9, 0}, Vec3{0, 0, 2}};
    std::mt19937 random(seed);
    const std::uint32_t least = with_outside ? 0 : 1;
    for (std::uint32_t k = 0; k < 4; ++k) {
        // Blobs of 1 to 4 pixels.
        const std::uint32_t block = 1 + k;
        std::vector<std::uint16_t> blobs(std::size_t{width} * height);
        for (auto& blob : blobs)
            blob = static_cast<std::uint16_t>(least + random() % (structures + 1 - least));
        for (std::uint32_t j = 0; j < height; ++j) {
            for (std::uint32_t i = 0; i < width; ++i) {
                map.voxels[map.geometry.index(i, j, k)] = blobs[(j / block) * width + i / block];
            }
        }
    }
    return map;
}

TEST(Trace, regions_sum_up_to_their_union) {
    for (unsigned seed = 0; seed < 12; ++seed) {
        const auto structures = static_cast<std::uint16_t>(1 + seed / 2);
        const LabelMap map = random_partition(31, 27, structures, seed, seed % 2 == 0);
        LabelMap whole = map;
        whole.structures.resize(1);
        for (auto& voxel : whole.voxels) voxel = voxel > 0 ? 1 : 0;
        const TraceResult united = trace(whole, everything());
        for (const double epsilon : {0.0, 0.1, 0.3}) {
            TraceOptions options = everything();
            options.epsilon_mm = epsilon;
            const TraceResult traced = trace(map, options);
            EXPECT_LE(traced.stats.max_distance_mm, epsilon);
            for (std::uint32_t slice = 0; slice < 4; ++slice) {
                double sum = 0;
                for (std::uint32_t s = 0; s < structures; ++s) sum += region_area(traced.kept, slice, s);
                double length_of_all = 0;
                for (const Contour& contour : united.kept.contours_of(united.kept.slices[slice])) {
                    length_of_all += perimeter(in_plane(united.kept, contour));
                }
                EXPECT_NEAR(sum, region_area(united.kept, slice, 0), 1e-9 + length_of_all * epsilon);
            }
        }
    }
}

// Every segment of a structure's contour is a segment of exactly one other contour, run the other way, or
// borders the outside: together the regions leave no gap and no overlap.
TEST(Trace, neighbours_share_every_vertex_of_their_common_boundary) {
    for (unsigned seed = 10; seed < 16; ++seed) {
        const bool with_outside = seed % 2 == 0;
        const LabelMap map = random_partition(24, 26, 4, seed, with_outside);
        TraceOptions options;
        options.min_area_mm2 = 0;
        const TraceResult traced = trace(map, options);
        const auto key = [](Vec3 p) { return std::array<double, 3>{p.x, p.y, p.z}; };
        std::map<std::pair<std::array<double, 3>, std::array<double, 3>>, int> directed;
        for (const Contour& contour : traced.kept.contours) {
            const auto points = traced.kept.points_of(contour);
            for (std::size_t i = 0; i < points.size(); ++i) {
                ++directed[{key(points[i]), key(points[(i + 1) % points.size()])}];
            }
        }
        std::size_t shared = 0;
        for (const auto& [segment, count] : directed) {
            EXPECT_EQ(count, 1);
            shared += directed.count({segment.second, segment.first});
        }
        EXPECT_GT(shared, directed.size() / 2);
        // Without an outside only the border of the image is run in one direction alone.
        if (!with_outside) {
            for (const auto& [segment, count] : directed) {
                if (directed.count({segment.second, segment.first})) continue;
                const Vec3 middle{(segment.first[0] + segment.second[0]) / 2,
                                  (segment.first[1] + segment.second[1]) / 2, 0};
                const double margin = std::min(
                    {middle.x + 0.35, 23.5 * 0.7 - middle.x, middle.y + 0.45, 25.5 * 0.9 - middle.y});
                EXPECT_LT(margin, 0.5);
            }
        }
    }
}

TEST(Trace, every_traced_vertex_is_within_epsilon_of_the_kept_polygon) {
    const LabelMap map = random_partition(40, 40, 3, 99, true);
    // With grey values, which put every crossing half-way, no vertex moves.
    GreyImage grey;
    grey.geometry = map.geometry;
    for (const std::uint16_t label : map.voxels) grey.voxels.push_back(label > 0 ? 1.0f : -1.0f);
    TraceOptions options;
    options.min_area_mm2 = 0;
    options.epsilon_mm = 0;
    const TraceResult all = trace(map, options, &grey);
    options.epsilon_mm = 0.25;
    const TraceResult thin = trace(map, options, &grey);
    EXPECT_EQ(thin.stats.max_shift_mm, 0);
    EXPECT_LT(thin.stats.points_kept, all.stats.points_kept);
    ASSERT_EQ(thin.kept.contours.size(), all.kept.contours.size());
    double worst = 0;
    for (const Contour& contour : all.kept.contours) {
        for (const Vec2& p : in_plane(all.kept, contour)) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const Contour& other : thin.kept.contours_of(thin.kept.slices[contour.slice])) {
                if (other.structure != contour.structure) continue;
                nearest = std::min(nearest, distance_to_polygon(p, in_plane(thin.kept, other)));
            }
            worst = std::max(worst, nearest);
        }
    }
    EXPECT_LE(worst, thin.stats.max_distance_mm + 1e-12);
    EXPECT_LE(thin.stats.max_distance_mm, 0.25);
    // Kept vertices are traced ones.
    std::vector<Vec3> points = all.kept.points;
    std::sort(points.begin(), points.end(), LexicographicLess{});
    for (const Vec3& p : thin.kept.points) {
        EXPECT_TRUE(std::binary_search(points.begin(), points.end(), p, LexicographicLess{}));
    }
}

TEST(Trace, kept_vertices_of_a_smooth_contour_are_well_apart) {
    ImageGeometry geometry;
    geometry.size = {120, 120, 1};
    const auto [grey, map] = sampled(geometry, [](Vec3 p) {
        const Vec2 d{p.x - 59.7, p.y - 60.2};
        return 40 + 9 * std::sin(5 * std::atan2(d.y, d.x)) - length(d);
    });
    const TraceResult traced = trace(map, {}, &grey);
    for (const Contour& contour : traced.kept.contours) {
        const std::vector<Vec2> polygon = in_plane(traced.kept, contour);
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            EXPECT_GT(length(polygon[(i + 1) % polygon.size()] - polygon[i]), 1.0 / 3);
        }
    }
}

TEST(Trace, the_same_at_any_number_of_threads) {
    const LabelMap map = random_partition(60, 50, 5, 3, true);
    RunContext one, four;
    four.threads = 4;
    const auto a = trace_contours(map, nullptr, 0, {}, one), b = trace_contours(map, nullptr, 0, {}, four);
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_TRUE(same(a.value().kept, b.value().kept));
    EXPECT_EQ(a.value().stats.area_left_out_mm2, b.value().stats.area_left_out_mm2);
    EXPECT_EQ(one.warnings.size(), four.warnings.size());
}

TEST(Trace, L19_noise_leaves_no_small_piece) {
    const LabelMap map = random_partition(80, 80, 2, 5, true);
    const TraceResult traced = trace(map);
    EXPECT_GT(traced.stats.islands_left_out, 100u);
    // Cut corners make a piece of four pixels at least half its pixels large.
    for (const Contour& contour : traced.kept.contours) {
        EXPECT_GT(std::abs(signed_area(in_plane(traced.kept, contour))), 0.35 * 4 * 0.7 * 0.9);
    }
}

TEST(Trace, stops_when_cancelled) {
    RunContext context;
    const std::atomic<bool> cancel{true};
    context.cancel = &cancel;
    const auto traced = trace_contours(slice_of({"11", "11"}), nullptr, 0, {}, context);
    ASSERT_FALSE(traced.ok());
    EXPECT_EQ(traced.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace anatomesh::trace_test
