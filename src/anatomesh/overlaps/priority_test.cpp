#include "anatomesh/overlaps/priority.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/contour_laws_test.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh::priority_test {
namespace {

using Polygon = std::vector<Vec2>;

Polygon square(Vec2 low, Vec2 high) {
    return {low, {high.x, low.y}, high, {low.x, high.y}};
}

struct Drawn {
    std::uint32_t structure;
    Polygon polygon;
    double z = 5;
};

// Drawn on axial slices, structure by structure.
ContourSet kept(const std::vector<Drawn>& drawn) {
    RawContours raw;
    for (const auto& [structure, polygon, z] : drawn) {
        while (raw.structures.size() <= structure) {
            const auto number = static_cast<std::int32_t>(raw.structures.size()) + 1;
            raw.structures.push_back({number, "S" + std::to_string(number), {}});
        }
        RawContour contour;
        contour.structure = structure;
        contour.first_point = static_cast<std::uint32_t>(raw.points.size());
        contour.point_count = static_cast<std::uint32_t>(polygon.size());
        raw.contours.push_back(contour);
        for (const Vec2 q : polygon) raw.points.push_back({q.x, q.y, z});
    }
    RunContext context;
    return clean_contours(raw, {}, context).value().kept;
}

double area_of(const ContourSet& set, std::uint32_t structure) {
    double area = 0;
    for (const Contour& contour : set.contours) {
        if (contour.structure != structure) continue;
        Polygon polygon;
        for (const Vec3& p : set.points_of(contour)) polygon.push_back({p.x, p.y});
        area += signed_area(polygon);
    }
    return area;
}

PriorityResult given(const ContourSet& set, const std::vector<std::uint32_t>& order) {
    RunContext context;
    auto result = give_overlaps(set, order, context);
    EXPECT_TRUE(result.ok());
    return std::move(result).value();
}

TEST(Priority, an_overlap_goes_to_the_structure_named_first) {
    const ContourSet set = kept({{0, square({0, 0}, {10, 10})}, {1, square({6, 2}, {16, 8})}});
    const PriorityResult first = given(set, {0, 1}), second = given(set, {1, 0}), none = given(set, {});
    EXPECT_NEAR(area_of(first.kept, 0), 100, 1e-9);
    EXPECT_NEAR(area_of(first.kept, 1), 36, 1e-9);
    EXPECT_NEAR(first.given[1].area_mm2, 24, 1e-9);
    EXPECT_EQ(first.given[0].slices, 0u);
    EXPECT_NEAR(area_of(second.kept, 0), 76, 1e-9);
    EXPECT_NEAR(area_of(second.kept, 1), 60, 1e-9);
    EXPECT_NEAR(area_of(none.kept, 1), 60, 1e-9) << "the smaller one";
    EXPECT_TRUE(first.kept.exclusive);
}

TEST(Priority, both_have_the_points_where_their_contours_crossed) {
    const ContourSet set = kept({{0, square({0, 0}, {10, 10})}, {1, square({6, 2}, {16, 8})}});
    const PriorityResult result = given(set, {0});
    const auto less = [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); };
    for (const Contour& contour : result.kept.contours) {
        const auto points = result.kept.points_of(contour);
        const std::set<Vec3, decltype(less)> own(points.begin(), points.end(), less);
        EXPECT_EQ(own.count({10, 2, 5}), 1u);
        EXPECT_EQ(own.count({10, 8, 5}), 1u);
    }
}

TEST(Priority, what_lies_inside_becomes_a_hole_of_the_structure_around_it) {
    const ContourSet set =
        kept({{0, square({0, 0}, {20, 20})}, {1, square({5, 5}, {9, 9})}, {2, square({12, 5}, {16, 9})}});
    const PriorityResult result = given(set, {2, 1});
    EXPECT_NEAR(area_of(result.kept, 0), 400 - 32, 1e-9);
    EXPECT_EQ(result.kept.contours.size(), 5u);
    EXPECT_NEAR(result.given[0].area_mm2, 32, 1e-9);
}

TEST(Priority, a_hole_is_no_overlap) {
    const ContourSet set =
        kept({{0, square({0, 0}, {20, 20})}, {0, square({4, 4}, {12, 12})}, {1, square({4, 4}, {12, 12})}});
    const PriorityResult result = given(set, {0, 1});
    EXPECT_NEAR(area_of(result.kept, 0), 400 - 64, 1e-9);
    EXPECT_NEAR(area_of(result.kept, 1), 64, 1e-9);
    for (const GivenOverlap& overlap : result.given) EXPECT_EQ(overlap.slices, 0u);
}

TEST(Priority, structures_that_do_not_overlap_keep_every_vertex) {
    const ContourSet set = kept({{0, square({0, 0}, {10, 10})}, {1, square({10.5, 2}, {16, 8})}});
    const PriorityResult result = given(set, {1});
    EXPECT_EQ(result.kept.points, set.points);
}

TEST(Priority, a_structure_wholly_inside_one_before_it_is_left_out_and_said) {
    const ContourSet set = kept({{0, square({0, 0}, {20, 20})}, {1, square({5, 5}, {9, 9})}});
    RunContext context;
    const auto result = give_overlaps(set, {0}, context);
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(result.value().kept.structures.size(), 1u);
    ASSERT_FALSE(context.warnings.empty());
    EXPECT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings.front().code, "W-PRI-001");
    EXPECT_TRUE(result.value().given[1].all);
    EXPECT_FALSE(result.value().given[0].all);
}

// A body's outline, drawn first, and what is drawn in it.
TEST(Priority, of_structures_that_are_not_named_the_smaller_one_comes_first) {
    const ContourSet set = kept({{0, square({0, 0}, {40, 40})},
                                 {1, square({5, 5}, {15, 15})},
                                 {2, square({8, 8}, {12, 12})},
                                 {3, square({20, 20}, {24, 24})}});
    const PriorityResult result = given(set, {3});
    ASSERT_EQ(result.kept.structures.size(), 4u);
    const std::vector<double> left{1600 - 100 - 16, 100 - 16, 16, 16};
    for (std::uint32_t s = 0; s < 4; ++s) {
        EXPECT_NEAR(area_of(result.kept, s), left[s], 1e-9);
        EXPECT_FALSE(result.given[s].all);
    }
}

// A lesion on every slice of an organ that is drawn on every eighth: more area in all, and the smaller one.
TEST(Priority, the_smaller_one_is_so_on_its_slices) {
    std::vector<Drawn> drawn{{0, square({0, 0}, {10, 10}), 0}};
    for (int z = 0; z < 8; ++z) drawn.push_back({1, square({3, 3}, {7, 7}), static_cast<double>(z)});
    const PriorityResult result = given(kept(drawn), {});
    EXPECT_EQ(result.order, (std::vector<std::uint32_t>{1, 0}));
    EXPECT_NEAR(area_of(result.kept, 1), 8 * 16, 1e-9);
    EXPECT_NEAR(result.given[0].area_mm2, 16, 1e-9);
}

// Discs at random: areas add up to that of the union, whatever the order.
TEST(Priority, nothing_is_lost_and_nothing_is_twice) {
    std::vector<Drawn> drawn;
    for (std::uint32_t s = 0; s < 5; ++s) {
        Polygon polygon;
        for (int i = 0; i < 40; ++i) {
            const double a = 2 * std::acos(-1.0) * i / 40 + 0.1 * s;
            polygon.push_back(Vec2{3.1 * s, 1.7 * (s % 3)} + (5 + 0.3 * s) * Vec2{std::cos(a), std::sin(a)});
        }
        drawn.push_back({s, polygon});
    }
    const ContourSet set = kept(drawn);
    double all = 0;
    for (const std::vector<std::uint32_t>& order :
         {std::vector<std::uint32_t>{0, 1, 2, 3, 4}, {4, 2, 0, 3, 1}, {3, 1}}) {
        const PriorityResult result = given(set, order);
        double sum = 0;
        for (std::uint32_t s = 0; s < result.kept.structures.size(); ++s) sum += area_of(result.kept, s);
        if (all == 0) all = sum;
        EXPECT_NEAR(sum, all, 1e-6);
    }
}

TEST(Priority, what_lies_in_another_one_stays_as_drawn_level_by_level) {
    const ContourSet set = kept({{0, square({0, 0}, {30, 30})},
                                 {1, square({5, 5}, {25, 25})},
                                 {2, square({8, 8}, {14, 22})},
                                 {3, square({40, 0}, {50, 30})},
                                 {4, square({30, 0}, {40, 30})}});
    const PriorityResult result = given(set, {2, 1});
    ASSERT_TRUE(result.kept.overlapping);
    const OverlappingContours& overlapping = *result.kept.overlapping;
    EXPECT_EQ(overlapping.order, (std::vector<std::int32_t>{3, 2, 4, 5, 1}));
    ASSERT_EQ(overlapping.levels.size(), 3u);
    EXPECT_EQ(overlapping.levels[0].structures.size(), 3u);
    EXPECT_TRUE(overlapping.levels[0].exclusive);
    EXPECT_EQ(overlapping.levels[1].structures[0].name, "S2");
    EXPECT_EQ(overlapping.levels[2].structures[0].name, "S3");
    for (const ContourSet& level : overlapping.levels) EXPECT_EQ(level.slices.size(), 1u);
    EXPECT_DOUBLE_EQ(area_of(overlapping.levels[0], 0), 900);
    EXPECT_DOUBLE_EQ(area_of(overlapping.levels[1], 0), 400);
    EXPECT_DOUBLE_EQ(area_of(result.kept, 1), 400 - 84);
}

// An organ on every fourth slice: with a lesion on every slice, and on slices between which others draw the
// organ alone.
TEST(Priority, what_lies_in_another_one_on_slices_of_its_own_leaves_none_between_them) {
    for (const int step : {1, 3}) {
        for (const bool touching : {false, true}) {
            std::vector<Drawn> drawn;
            for (int z = 0; z <= 24; z += 4) {
                drawn.push_back({0, square({0, 0}, {30, 30}), 1.0 * z});
                drawn.push_back({2, square({touching ? 30.0 : 40.0, 0}, {50, 30}), 1.0 * z});
            }
            for (int z = 8; z <= 17; z += step) drawn.push_back({1, square({8, 8}, {20, 20}), 1.0 * z});
            const PriorityResult result = given(kept(drawn), {});
            ASSERT_EQ(result.kept.overlapping != nullptr, step == 1) << step;
            if (!result.kept.overlapping) continue;
            const std::vector<ContourSet>& levels = result.kept.overlapping->levels;
            ASSERT_EQ(levels.size(), 2u);
            EXPECT_EQ(levels[0].exclusive, touching);
            EXPECT_EQ(levels[1].structures[0].name, "S2");
            // Neighbours have slices of their own together: 0, 4, 8, and so on.
            std::size_t own = 0;
            for (const std::uint32_t s : result.kept.overlapping->slices[0]) {
                const double z = result.kept.slices[s].plane.origin.z;
                EXPECT_EQ(levels[0].slices[own++].plane.origin.z, z);
                EXPECT_TRUE(!touching || std::fmod(z, 4) == 0) << z;
            }
            EXPECT_EQ(own, touching ? 7u : result.kept.slices.size());
            EXPECT_EQ(levels[0].slices.size(), own);
            EXPECT_EQ(levels[1].slices.size(), result.kept.slices.size());
            // So they have of some of the slices.
            std::vector<std::uint32_t> some;
            for (std::uint32_t s = 1; s < result.kept.slices.size(); s += 3) some.push_back(s);
            const ContourSet part = chosen_slices(result.kept, some);
            for (std::size_t n = 0; n < 2; ++n) {
                const std::vector<std::uint32_t>& of_level = part.overlapping->slices[n];
                const ContourSet& level = part.overlapping->levels[n];
                ASSERT_EQ(of_level.size(), level.slices.size());
                for (std::size_t k = 0; k < of_level.size(); ++k)
                    EXPECT_EQ(level.slices[k].plane.origin, part.slices[of_level[k]].plane.origin);
            }
            EXPECT_EQ(part.overlapping->levels[1].slices.size(), some.size());
        }
    }
}

// A lesion between two slices of its organ, which no slice draws with it: their outlines tell, if it lies in
// them; not if it lies beside it or half in it, or if slices between its own draw the organ alone.
TEST(Priority, what_lies_in_another_one_between_its_slices_is_found_by_those) {
    const auto nested = [](Vec2 low, Vec2 high, const std::vector<double>& heights) {
        std::vector<Drawn> drawn;
        for (int z = 0; z <= 32; z += 4) drawn.push_back({0, square({0, 0}, {30, 30}), 1.0 * z});
        for (const double z : heights) drawn.push_back({1, square(low, high), z});
        return given(kept(drawn), {1}).kept.overlapping != nullptr;
    };
    EXPECT_TRUE(nested({8, 8}, {14, 14}, {13}));
    EXPECT_TRUE(nested({8, 8}, {14, 14}, {13, 14, 15}));
    EXPECT_FALSE(nested({32, 8}, {38, 14}, {13, 14, 15}));
    EXPECT_FALSE(nested({28, 8}, {38, 14}, {13, 14, 15}));
    EXPECT_FALSE(nested({0, 8}, {6, 14}, {13, 14, 15}));  // along a side of it
    EXPECT_FALSE(nested({8, 8}, {14, 14}, {10, 14, 18}));
}

TEST(Priority, what_runs_along_another_ones_outline_or_beside_it_does_not_lie_in_it) {
    // Along a side of it; two that overlap in less than half; one and itself.
    for (const auto& [low, high] :
         {std::pair{Vec2{0, 5}, Vec2{10, 25}}, {Vec2{22, 5}, Vec2{42, 25}}, {Vec2{0, 0}, Vec2{30, 30}}}) {
        const ContourSet set = kept({{0, square({0, 0}, {30, 30})}, {1, square(low, high)}});
        EXPECT_FALSE(given(set, {1}).kept.overlapping);
    }
}

// What an outer one leaves of an inner one, a little that sticks out, is no wall; nor is its volume known
// well as a difference.
TEST(Priority, what_lies_in_one_before_it_is_parted_from_it_as_neighbours_are) {
    const ContourSet two = kept({{0, square({0, 0}, {30, 30})}, {1, square({20, 8}, {34, 22})}});
    EXPECT_FALSE(given(two, {0}).kept.overlapping);
    EXPECT_TRUE(given(two, {1}).kept.overlapping);
    const ContourSet three =
        kept({{0, square({0, 0}, {30, 30})}, {1, square({12, 5}, {34, 25})}, {2, square({20, 8}, {31, 22})}});
    EXPECT_TRUE(given(three, {2, 1}).kept.overlapping);
    for (const std::vector<std::uint32_t>& order :
         {std::vector<std::uint32_t>{0}, {0, 1, 2}, {0, 2, 1}, {1, 0, 2}})
        EXPECT_FALSE(given(three, order).kept.overlapping);
}

TEST(Priority, on_slices_that_cross_all_must_lie_one_in_another) {
    for (const bool beside : {false, true}) {
        ContourSet set;
        set.structures = {{1, "inner", {}}, {2, "outer", {}}};
        if (beside) set.structures.push_back({3, "beside", {}});
        for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{0, 1, 0}}) {
            const Plane plane = make_plane({0, 0, 0}, normal);
            set.slices.push_back({plane, static_cast<std::uint32_t>(set.contours.size()), 0,
                                  std::to_string(set.slices.size())});
            for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
                const double low = s == 2 ? 40 : 10.0 * s, size = s == 0 ? 10 : 30;
                set.contours.push_back({s, static_cast<std::uint32_t>(set.slices.size()) - 1,
                                        static_cast<std::uint32_t>(set.points.size()), 4});
                for (const Vec2 q :
                     square({low - 20 * (s == 1), -size / 2}, {low - 20 * (s == 1) + size, size / 2}))
                    set.points.push_back(plane.to_space(q));
                ++set.slices.back().contour_count;
            }
        }
        EXPECT_EQ(given(set, {0}).kept.overlapping != nullptr, !beside);
    }
}

}  // namespace
}  // namespace anatomesh::priority_test
