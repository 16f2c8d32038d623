#include "anatomesh/reconcile/reconcile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"
#include "anatomesh/reconcile/working_unit.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh::reconcile_test {
namespace {

using namespace crossing_fixtures;

constexpr double margin = 5;

std::vector<LineComparison> compare(const ContourSet& set) {
    RunContext context;
    const std::vector<PlanePatch> patches = plane_patches(set);
    return compare_planes(set, patches, crossing_pairs(patches, margin), margin, context);
}

ReconcileResult reconciled(const ContourSet& set, ReconcileOptions options = {}) {
    RunContext context;
    options.margin_mm = margin;
    Result<ReconcileResult> result = reconcile_contours(set, options, context);
    EXPECT_TRUE(result.ok()) << to_line(result.error());
    return std::move(result).value();
}

std::string refused(const ContourSet& set, ReconcileOptions options = {}) {
    RunContext context;
    options.margin_mm = margin;
    const Result<ReconcileResult> result = reconcile_contours(set, options, context);
    return result.ok() ? "" : to_line(result.error());
}

void expect_exact_agreement(const ContourSet& set) {
    for (const LineComparison& comparison : compare(set)) {
        ASSERT_EQ(comparison.endpoints_a.size(), comparison.endpoints_b.size())
            << "slices " << comparison.a << " and " << comparison.b;
        for (std::size_t i = 0; i < comparison.endpoints_a.size(); ++i) {
            const IntervalEndpoint &a = comparison.endpoints_a[i], &b = comparison.endpoints_b[i];
            EXPECT_EQ(a.from, a.to) << "an end inside a segment";
            EXPECT_EQ(b.from, b.to) << "an end inside a segment";
            EXPECT_EQ(set.points[a.from], set.points[b.from]);
        }
    }
}

void expect_sound(const ContourSet& set) {
    for (const Slice& slice : set.slices) {
        std::vector<PlaneRing> rings;
        for (const Contour& contour : set.contours_of(slice)) {
            PlaneRing ring{contour.structure, {}};
            for (const Vec3& p : set.points_of(contour)) {
                ring.at.push_back(slice.plane.to_plane(p));
                EXPECT_LE(std::abs(slice.plane.signed_distance(p)), 1e-9);
                EXPECT_FALSE(lexicographic_less(p, set.points_of(contour).front()));
            }
            rings.push_back(std::move(ring));
        }
        EXPECT_TRUE(slice_faults(rings, set.exclusive).empty()) << "in slice " << slice.name;
    }
}

std::vector<Vec3> sorted(std::span<const Vec3> points) {
    std::vector<Vec3> all(points.begin(), points.end());
    std::sort(all.begin(), all.end(), [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); });
    return all;
}

double perimeter_of(std::span<const Vec3> points) {
    double sum = 0;
    for (std::size_t n = 0; n < points.size(); ++n)
        sum += length(points[(n + 1) % points.size()] - points[n]);
    return sum;
}

TEST(Reconcile, C24_C27_sections_of_a_solid_agree_and_no_vertex_moves) {
    std::mt19937 random(11);
    for (int n = 0; n < 12; ++n) {
        const auto solid = polytope(30, 20, random);
        const ContourSet set = cut(solid, n % 3 == 0   ? three_stacks(28, 7, 0.1)
                                          : n % 3 == 1 ? rotational_planes(12)
                                                       : random_planes(20, 25, random));
        const ReconcileResult result = reconciled(set);
        EXPECT_LT(result.stats.max_mm, 1e-9);
        EXPECT_LT(result.stats.max_movement_mm, 1e-9);
        EXPECT_EQ(result.stats.difference_after_mm, 0);
        // A vertex that all but lies where slices cross is the common point there (shared_points.h).
        const std::vector<Vec3> after = sorted(result.kept.points);
        for (const Contour& contour : set.contours) {
            const double near = 0.005 * perimeter_of(set.points_of(contour)) / contour.point_count;
            for (const Vec3& p : set.points_of(contour)) {
                EXPECT_TRUE(
                    std::binary_search(after.begin(), after.end(), p, LexicographicLess{}) ||
                    std::any_of(after.begin(), after.end(), [&](Vec3 q) { return length(q - p) <= near; }));
            }
        }
        expect_exact_agreement(result.kept);
        expect_sound(result.kept);
    }
}

TEST(Reconcile, C25_slices_drawn_apart_agree_exactly_afterwards_within_the_bound) {
    std::mt19937 random(12);
    for (int n = 0; n < 8; ++n) {
        const auto planes = n % 2 == 0 ? three_stacks(24, 6, 0.05) : random_planes(14, 12, random);
        const ContourSet set = drawn_ball(30, planes, {1.0, 0.7, 150}, random);
        const ReconcileResult result = reconciled(set);
        EXPECT_GT(result.stats.median_mm, 0.2);
        EXPECT_EQ(result.stats.difference_after_mm, 0) << "case " << n;
        EXPECT_LE(result.stats.max_movement_mm, 10);
        EXPECT_LT(result.stats.mean_movement_mm, result.stats.median_mm);
        expect_exact_agreement(result.kept);
        expect_sound(result.kept);
    }
}

// Where vertices are further apart than the planes, there are more places to bring together than vertices
// that can be moved.
TEST(Reconcile, C25_coarse_contours_far_apart_agree_too) {
    std::mt19937 random(21);
    for (int n = 0; n < 6; ++n) {
        const ContourSet set =
            drawn_ball(30, three_stacks(24, 4, 0.05), {2.0, 1.5, n < 5 ? 16 : 150}, random);
        ReconcileOptions options;
        options.max_disagreement_mm = 20;
        const ReconcileResult result = reconciled(set, options);
        EXPECT_EQ(result.stats.difference_after_mm, 0) << "case " << n;
        expect_exact_agreement(result.kept);
        expect_sound(result.kept);
    }
}

TEST(Reconcile, C25_moved_vertices_leave_room_for_common_points) {
    std::mt19937 random(4);
    const ContourSet set = drawn_ball(30, three_stacks(24, 6, 0.05), {1.0, 0.7, 400}, random);
    const ContourSet kept = reconciled(set).kept;
    std::vector<Vec3> sorted = kept.points;
    std::sort(sorted.begin(), sorted.end(), LexicographicLess{});
    const auto is_common = [&](Vec3 p) {
        const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), p, LexicographicLess{});
        return last - first > 1;
    };
    std::size_t common = 0, crowded = 0;
    for (const Contour& contour : kept.contours) {
        const auto points = kept.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n) {
            const Vec3 p = points[n], q = points[(n + 1) % points.size()];
            common += is_common(p);
            crowded += is_common(p) != is_common(q) && length(q - p) < 0.03;
        }
    }
    EXPECT_GT(common, 400u);
    EXPECT_EQ(crowded, 0u);
}

// An interval on a common line that came to nothing has one point, not two beside each other.
TEST(Reconcile, C25_two_slices_have_no_two_common_points_in_one_place) {
    std::mt19937 random(21);
    std::size_t common = 0;
    ReconcileOptions options;
    options.max_disagreement_mm = 40;
    for (int n = 0; n < 120; ++n) {
        const ContourSet drawn = drawn_ball(30, random_planes(16, 29, random), {4, 3, 200}, random);
        const ContourSet kept = reconciled(drawn, options).kept;
        std::map<std::array<double, 3>, std::vector<std::uint32_t>> slices;
        for (const Contour& contour : kept.contours) {
            for (const Vec3& p : kept.points_of(contour)) slices[{p.x, p.y, p.z}].push_back(contour.slice);
        }
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Vec3>> of_pair;
        for (const auto& [at, all] : slices) {
            for (const std::uint32_t a : all) {
                for (const std::uint32_t b : all) {
                    if (a < b) of_pair[{a, b}].push_back({at[0], at[1], at[2]});
                }
            }
        }
        for (const auto& [pair, points] : of_pair) {
            common += points.size();
            for (std::size_t i = 0; i < points.size(); ++i) {
                for (std::size_t j = 0; j < i; ++j)
                    EXPECT_GE(length(points[i] - points[j]), 0.001) << pair.first << " " << pair.second;
            }
        }
    }
    EXPECT_GT(common, 5000u);
}

// A rectangle from low to high, in the two axes that the plane holds, with a vertex about every 2 mm.
void add_rectangle(ContourSet& set, std::uint32_t structure, const std::array<Vec3, 4>& corners) {
    const Plane& plane = set.slices.back().plane;
    std::vector<Vec3> points;
    for (std::size_t n = 0; n < 4; ++n) {
        const Vec3 from = corners[n], way = corners[(n + 1) % 4] - from;
        const auto steps = static_cast<int>(std::lround(length(way) / 2));
        for (int k = 0; k < steps; ++k) points.push_back(from + (static_cast<double>(k) / steps) * way);
    }
    double area = 0;
    for (std::size_t n = 0; n < points.size(); ++n)
        area += cross(plane.to_plane(points[n]), plane.to_plane(points[(n + 1) % points.size()]));
    if (area < 0) std::reverse(points.begin(), points.end());
    std::rotate(points.begin(),
                std::min_element(points.begin(), points.end(),
                                 [](Vec3 p, Vec3 q) { return lexicographic_less(p, q); }),
                points.end());
    set.contours.push_back({structure, static_cast<std::uint32_t>(set.slices.size() - 1),
                            static_cast<std::uint32_t>(set.points.size()),
                            static_cast<std::uint32_t>(points.size())});
    set.points.insert(set.points.end(), points.begin(), points.end());
    ++set.slices.back().contour_count;
}

// Two islands of a structure, one of which moves past the other's leftmost vertex, and a second structure
// that comes to lie on the first one's wall.
TEST(Reconcile, C25_movements_are_told_of_islands_that_change_their_order_where_walls_are_united) {
    ContourSet set;
    set.structures = {{1, "one", {}}, {2, "other", {}}};
    const auto begin = [&](Vec3 origin, Vec3 normal) {
        set.slices.push_back({make_plane(origin, normal), static_cast<std::uint32_t>(set.contours.size()), 0,
                              std::to_string(set.slices.size())});
    };
    const auto flat = [](double x0, double y0, double x1, double y1) {
        return std::array<Vec3, 4>{{{x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0}}};
    };
    const auto upright = [](double y, double x0, double z0, double x1, double z1) {
        return std::array<Vec3, 4>{{{x0, y, z0}, {x1, y, z0}, {x1, y, z1}, {x0, y, z1}}};
    };
    begin({}, {0, 0, 1});
    add_rectangle(set, 0, flat(0, 0, 10, 10));
    add_rectangle(set, 0, flat(0.1, 20, 10, 30));
    add_rectangle(set, 1, flat(4, 2, 9.97, 8));
    begin({0, 5, 0}, {0, 1, 0});
    add_rectangle(set, 0, upright(5, 0.6, -10, 9.985, 10));
    add_rectangle(set, 1, upright(5, 4, -6, 9.985, 6));
    begin({0, 25, 0}, {0, 1, 0});
    add_rectangle(set, 0, upright(25, 0.1, -10, 10, 10));
    const ReconcileResult result = reconciled(set);
    // How far the nearest kept vertex is at least.
    for (std::uint32_t s = 0; s < 2; ++s) {
        double most = 0;
        for (const Contour& contour : set.contours_of(set.slices[s])) {
            for (const Vec3& p : set.points_of(contour)) {
                double least = 1;
                for (const Contour& kept : result.kept.contours_of(result.kept.slices[s])) {
                    if (kept.structure != contour.structure) continue;
                    for (const Vec3& q : result.kept.points_of(kept)) least = std::min(least, length(q - p));
                }
                most = std::max(most, least);
            }
        }
        EXPECT_GT(most, 0.2);
        EXPECT_GE(result.stats.movements[s].max_mm, most - 1e-9);
    }
}

TEST(Reconcile, C25_the_movement_is_shared_between_two_slices_that_cross) {
    std::mt19937 random(1);
    // Circles of radius 20 and 22 at right angles: each has to give way by a millimetre.
    ContourSet set = drawn_ball(20, {make_plane({}, {0, 0, 1})}, {0, 0, 400}, random);
    const ContourSet larger = drawn_ball(22, {make_plane({}, {1, 0, 0})}, {0, 0, 400}, random);
    Ring ring;
    for (const Vec3& p : larger.points) ring.push_back(larger.slices[0].plane.to_plane(p));
    add_slice(set, larger.slices[0].plane, ring);
    const ReconcileResult result = reconciled(set);
    ASSERT_EQ(result.stats.pairs.size(), 1u);
    EXPECT_EQ(result.stats.pairs[0].ends, 2u);
    EXPECT_NEAR(result.stats.max_mm, 2, 0.01);
    EXPECT_NEAR(result.stats.difference_mm, 4, 0.02);
    for (const SliceMovement& movement : result.stats.movements) EXPECT_NEAR(movement.max_mm, 1, 0.05);
    expect_exact_agreement(result.kept);
}

TEST(Reconcile, C25_pairs_that_differ_by_more_than_half_a_millimetre_are_named) {
    for (const auto& [radius, named] : {std::pair{20.35, true}, {20.2, false}}) {
        std::mt19937 random(1);
        ContourSet set = drawn_ball(20, {make_plane({}, {0, 0, 1})}, {0, 0, 400}, random);
        const ContourSet larger = drawn_ball(radius, {make_plane({}, {1, 0, 0})}, {0, 0, 400}, random);
        Ring ring;
        for (const Vec3& p : larger.points) ring.push_back(larger.slices[0].plane.to_plane(p));
        add_slice(set, larger.slices[0].plane, ring);
        RunContext context;
        ASSERT_TRUE(reconcile_contours(set, {}, context).ok());
        const auto is_pair = [](const Warning& warning) {
            return warning.code == "W-RCN-003" && warning.message.rfind("slices ", 0) == 0;
        };
        EXPECT_EQ(std::count_if(context.warnings.begin(), context.warnings.end(), is_pair), named) << radius;
    }
}

TEST(Reconcile, C25_refuses_above_the_bound_and_names_both_slices) {
    std::mt19937 random(2);
    ContourSet set = drawn_ball(40, three_stacks(30, 10, 0), {0, 0, 150}, random);
    const Contour& contour = set.contours[3];
    for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
        set.points[k] += 30 * set.slices[3].plane.u;
    }
    const std::string error = refused(set);
    EXPECT_EQ(error.substr(0, 9), "E-RCN-001") << error;
    EXPECT_NE(error.find("slices 3 and "), std::string::npos) << error;
    ReconcileOptions wide;
    wide.max_disagreement_mm = 40;
    EXPECT_EQ(refused(set, wide), "");
    ReconcileOptions narrow;
    narrow.max_disagreement_mm = 0.5;
    EXPECT_EQ(refused(drawn_ball(40, three_stacks(30, 10, 0), {2, 0, 150}, random), narrow).substr(0, 9),
              "E-RCN-001");
}

// A ball of radius 20 in slices 4 mm apart, and a long axis, the last slice, of another radius and shifted.
ContourSet ball_with_long_axis(double radius, Vec3 shift) {
    std::mt19937 random(21);
    std::vector<Plane> stack;
    for (int k = -4; k <= 4; ++k) stack.push_back(make_plane({0, 0, 4.0 * k}, {0, 0, 1}));
    ContourSet set = drawn_ball(20, stack, {0, 0, 150}, random);
    const ContourSet across = drawn_ball(radius, {make_plane({}, {0, 1, 0})}, {0, 0, 150}, random);
    Ring ring;
    for (const Vec3& p : across.points) ring.push_back(across.slices[0].plane.to_plane(p + shift));
    add_slice(set, across.slices[0].plane, ring);
    return set;
}

TEST(Reconcile, C25_a_long_axis_out_of_place_by_more_than_the_bound_is_refused) {
    for (const Vec3 way : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0.9, 0, 0.436}}) {
        for (const double far : {1.0, 5.0, 9.0}) EXPECT_EQ(refused(ball_with_long_axis(20, far * way)), "");
        for (const double far : {12.0, 15.0, 18.0, 22.0, 25.0, 30.0, 35.0, 39.0}) {
            const ContourSet set = ball_with_long_axis(20, far * way);
            const std::string error = refused(set);
            EXPECT_EQ(error.substr(0, 9), "E-RCN-001") << far << ' ' << way.x << ' ' << way.z;
            EXPECT_NE(error.find(" and 9 contradict each other"), std::string::npos) << error;
            ReconcileOptions wide;
            wide.max_disagreement_mm = far + 1;
            EXPECT_EQ(refused(set, wide), "") << far << ' ' << way.x << ' ' << way.z;
        }
    }
}

// A slice along the stack whose image ends above the middle of the ball: its contour follows the image's
// edge.
TEST(Reconcile, C26_a_slice_that_its_image_cuts_off_is_named_where_others_go_on) {
    std::mt19937 random(22);
    std::vector<Plane> upright;
    for (int k = -6; k <= 6; ++k) upright.push_back(make_plane({0, 0, 3.0 * k}, {0, 0, 1}));
    ContourSet set = drawn_ball(20, upright, {0, 0, 120}, random);
    for (const double x : {-6.0, 0.0, 6.0}) {
        const Plane along{{x, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
        const double radius = std::sqrt(400 - x * x);
        Ring ring;
        for (int n = 0; n < 120; ++n) {
            const double t = 2 * std::numbers::pi * n / 120;
            ring.push_back({radius * std::cos(t), std::min(radius * std::sin(t), 8.0)});
        }
        add_slice(set, along, ring);
        set.slices.back().name = "cut off";
    }
    const std::string line = refused(set);
    EXPECT_EQ(line.substr(0, 5), "E-RCN") << line;
    EXPECT_NE(line.find("the contours of slice cut off end 4 mm before that line"), std::string::npos)
        << line;
}

// Two stacks of a ball across each other, one of them out of place: what one slice alone has is drawn back,
// by more than how far apart ends are.
TEST(Reconcile, C25_slices_that_differ_when_contours_moved_by_all_of_the_bound_are_refused) {
    const auto stacks = [](double shift) {
        std::mt19937 random(22);
        std::vector<Plane> upright;
        ContourSet set;
        for (int k = -3; k <= 3; ++k) upright.push_back(make_plane({0, 0, 6.0 * k}, {0, 0, 1}));
        set = drawn_ball(20, upright, {0, 0, 60}, random);
        for (int k = -3; k <= 3; ++k) {
            const ContourSet across =
                drawn_ball(20, {make_plane({6.0 * k, 0, 0}, {1, 0, 0})}, {0, 0, 60}, random);
            Ring ring;
            for (const Vec3& p : across.points)
                ring.push_back(across.slices[0].plane.to_plane(p + Vec3{0, 0, shift}));
            add_slice(set, across.slices[0].plane, ring);
        }
        return set;
    };
    const auto within = [](double bound) {
        ReconcileOptions options;
        options.max_disagreement_mm = bound;
        return options;
    };
    const std::string error = refused(stacks(4), within(6));
    EXPECT_EQ(error.substr(0, 9), "E-RCN-003") << error;
    EXPECT_NE(error.find("slices 0 and "), std::string::npos) << error;
    for (const auto& [shift, bound] : {std::pair{4.0, 10.0}, std::pair{2.0, 6.0}})
        EXPECT_EQ(refused(stacks(shift), within(bound)), "") << shift;

    // Beside a ball on the same slices that they agree on: the one that they do not is named.
    const auto with_another = [&](const ContourSet& set, std::uint32_t own) {
        std::mt19937 random(22);
        ContourSet both;
        both.structures = {{1, "first", {}}, {2, "second", {}}};
        for (const Slice& slice : set.slices) {
            const ContourSet other = drawn_ball(20, {slice.plane}, {0, 0, 60}, random);
            Slice at{slice.plane, static_cast<std::uint32_t>(both.contours.size()), 2, slice.name};
            for (const std::uint32_t structure : {0u, 1u}) {
                const auto points = structure == own ? set.points_of(set.contours_of(slice)[0])
                                                     : std::span<const Vec3>(other.points);
                both.contours.push_back({structure, static_cast<std::uint32_t>(both.slices.size()),
                                         static_cast<std::uint32_t>(both.points.size()),
                                         static_cast<std::uint32_t>(points.size())});
                for (const Vec3& p : points)
                    both.points.push_back(structure == own ? p : p + Vec3{0, 100, 0});
            }
            both.slices.push_back(at);
        }
        return both;
    };
    for (const std::uint32_t own : {0u, 1u}) {
        const std::string line = refused(with_another(stacks(4), own), within(6));
        EXPECT_EQ(line.substr(0, 9), "E-RCN-003") << line;
        EXPECT_NE(line.find(own == 0 ? "structure first" : "structure second"), std::string::npos) << line;
        EXPECT_NE(line.find("--without \""), std::string::npos) << line;
        EXPECT_EQ(refused(with_another(stacks(4), own), within(10)), "");
    }
}

TEST(Reconcile, C25_regions_of_another_size_are_refused_above_the_bound) {
    for (const double radius : {25.0, 28.0}) EXPECT_EQ(refused(ball_with_long_axis(radius, {})), "");
    for (const double radius : {32.0, 35.0, 40.0})
        EXPECT_EQ(refused(ball_with_long_axis(radius, {})).substr(0, 9), "E-RCN-001") << radius;
}

std::vector<std::string> slices_named(const ContourSet& set, const std::string& code) {
    RunContext context;
    ReconcileOptions options;
    options.margin_mm = margin;
    EXPECT_TRUE(reconcile_contours(set, options, context).ok());
    std::vector<std::string> named;
    for (const Warning& warning : context.warnings) {
        if (warning.code == code) named.push_back(warning.place.slice);
    }
    return named;
}

TEST(Reconcile, C26_a_slice_apart_from_all_that_it_crosses_is_named) {
    using Names = std::vector<std::string>;
    for (const double far : {46.0, 60.0, 200.0}) {
        EXPECT_EQ(slices_named(ball_with_long_axis(20, {far, 0, 0}), "W-RCN-008"), Names{"9"}) << far;
        EXPECT_EQ(slices_named(ball_with_long_axis(20, {-far, 0, 8}), "W-RCN-008"), Names{"9"}) << far;
    }
    EXPECT_EQ(slices_named(ball_with_long_axis(20, {5, 0, 0}), "W-RCN-008"), Names{});
    std::mt19937 random(22);
    for (int n = 0; n < 12; ++n) {
        const auto solid = polytope(30, 20, random);
        for (const auto& planes :
             {three_stacks(28, 7, 0.1), rotational_planes(12), random_planes(20, 25, random)})
            EXPECT_EQ(slices_named(cut(solid, planes), "W-RCN-008"), Names{}) << n;
    }
}

// Ends 1 and 3 mm apart: 95 % of two is both.
TEST(Reconcile, few_ends_count_in_full_at_95_percent) {
    std::mt19937 random(23);
    ContourSet set = drawn_ball(20, {make_plane({}, {0, 0, 1})}, {0, 0, 400}, random);
    const ContourSet larger = drawn_ball(22, {make_plane({}, {1, 0, 0})}, {0, 0, 400}, random);
    Ring ring;
    for (const Vec3& p : larger.points) ring.push_back(larger.slices[0].plane.to_plane(p + Vec3{0, 1, 0}));
    add_slice(set, larger.slices[0].plane, ring);
    const ReconcileStats stats = reconciled(set).stats;
    ASSERT_EQ(stats.pairs.size(), 1u);
    EXPECT_NEAR(stats.pairs[0].median_mm, 1, 0.01);
    EXPECT_NEAR(stats.pairs[0].p95_mm, 3, 0.01);
    EXPECT_EQ(stats.pairs[0].p95_mm, stats.pairs[0].max_mm);
    EXPECT_EQ(stats.p95_mm, stats.max_mm);
}

// A circle of radius 20 and so many vertices in z = 0, and a smaller section in the plane of that x, which
// does not reach down to it.
ContourSet circle_with_section_across(int count, double x, std::mt19937& random) {
    ContourSet set = drawn_ball(20, {make_plane({}, {0, 0, 1})}, {0, 0, count}, random);
    const Plane upright = make_plane({x, 0, 0}, {1, 0, 0});
    Ring ring;
    for (int i = 0; i < 60; ++i) {
        const double angle = 2 * std::numbers::pi * i / 60;
        ring.push_back(upright.to_plane({x, 8 * std::cos(angle), 10 + 8 * std::sin(angle)}));
    }
    add_slice(set, upright, ring);
    return set;
}

TEST(Reconcile, C26_what_one_slice_alone_has_is_drawn_back_across_the_line) {
    std::mt19937 random(3);
    const ContourSet set = circle_with_section_across(200, 17, random);
    const ReconcileResult result = reconciled(set);
    EXPECT_EQ(result.stats.unmatched, 1u);
    EXPECT_GT(result.stats.movements[0].max_mm, 3);
    EXPECT_EQ(result.stats.movements[1].max_mm, 0);
    EXPECT_EQ(result.stats.difference_after_mm, 0);
    expect_sound(result.kept);
}

// Nearer to it than the vertices lie, cells between the planes there would have no shape.
TEST(Reconcile, C26_what_is_drawn_back_keeps_off_the_line_by_a_share_of_the_vertices_distance) {
    std::mt19937 random(3);
    for (const int count : {24, 48, 150, 600}) {
        const ContourSet set = circle_with_section_across(count, 17, random);
        const double spacing = mean_vertex_spacing(set);
        const ReconcileResult result = reconciled(set);
        double beyond = -HUGE_VAL;
        for (const Vec3& p : result.kept.points) {
            if (std::abs(p.z) < 1e-9) beyond = std::max(beyond, p.x - 17);
        }
        EXPECT_LT(beyond, -std::max(0.099 * working_unit_mm(set), 0.09 * spacing))
            << count << " vertices, " << spacing << " mm apart";
        expect_sound(result.kept);
    }
}

TEST(Reconcile, C26_what_is_hardly_beyond_the_line_is_not_taken_far) {
    std::mt19937 random(3);
    for (const int count : {12, 24, 150}) {
        const double x = 20 - 0.05;
        const ContourSet set = circle_with_section_across(count, x, random);
        double beyond = 0;
        for (const Vec3& p : set.points) {
            if (std::abs(p.z) < 1e-9) beyond = std::max(beyond, p.x - x);
        }
        EXPECT_GT(beyond, 0);
        const ReconcileResult result = reconciled(set);
        EXPECT_GT(result.stats.max_movement_mm, beyond) << count;
        EXPECT_LT(result.stats.max_movement_mm, 0.2 * std::max(1.0, working_unit_mm(set))) << count;
    }
}

// As rounded, not only as meant: a report that says "10 against a bound of 10" reads it off.
TEST(Reconcile, C26_no_vertex_moves_further_than_the_bound) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> any(-300, 300), near(12, 18);
    for (int n = 0; n < 60; ++n) {
        const double x = near(random);
        ContourSet set = circle_with_section_across(400, x, random);
        const Vec3 away{any(random), any(random), any(random)};
        for (Vec3& p : set.points) p += away;
        for (Slice& slice : set.slices) slice.plane.origin += away;
        ReconcileOptions options;
        options.max_disagreement_mm = 20.0005 - x;  // just as high as the arc that is drawn back across x
        RunContext context;
        const auto result = reconcile_contours(std::move(set), options, context);
        ASSERT_TRUE(result.ok());
        EXPECT_GT(result.value().stats.max_movement_mm, 20 - x - 0.1);
        EXPECT_LE(result.value().stats.max_movement_mm, options.max_disagreement_mm);
    }
}

TEST(Reconcile, C26_beyond_its_contours_a_slice_says_nothing) {
    std::mt19937 random(4);
    ContourSet set = drawn_ball(20, {make_plane({}, {0, 0, 1})}, {0, 0, 200}, random);
    const Plane upright = make_plane({5, 0, 0}, {1, 0, 0});
    Ring ring;
    for (const Vec3 p : {Vec3{5, -5, 30}, Vec3{5, 5, 30}, Vec3{5, 5, 40}, Vec3{5, -5, 40}})
        ring.push_back(upright.to_plane(p));
    add_slice(set, upright, ring);
    const ReconcileResult result = reconciled(set);
    EXPECT_TRUE(result.stats.pairs.empty());
    EXPECT_EQ(sorted(result.kept.points), sorted(set.points));
}

TEST(Reconcile, kept_as_drawn_when_only_measured) {
    std::mt19937 random(5);
    const ContourSet set = drawn_ball(30, three_stacks(24, 6, 0.05), {2, 1, 100}, random);
    ReconcileOptions options;
    options.reconcile = false;
    options.margin_mm = margin;
    RunContext context;
    const ReconcileResult result = reconcile_contours(set, options, context).value();
    EXPECT_EQ(result.kept.points, set.points);
    EXPECT_GT(result.stats.difference_mm, 10);
    EXPECT_EQ(result.stats.difference_after_mm, result.stats.difference_mm);
    EXPECT_TRUE(std::any_of(context.warnings.begin(), context.warnings.end(),
                            [](const Warning& warning) { return warning.code == "W-RCN-002"; }));
}

TEST(Reconcile, parallel_slices_come_back_as_they_are) {
    std::mt19937 random(6);
    std::vector<Plane> planes;
    for (int k = -5; k <= 5; ++k) planes.push_back(make_plane({0, 0, 3.0 * k}, {0, 0, 1}));
    const ContourSet set = drawn_ball(20, planes, {3, 1, 80}, random);
    const ReconcileResult result = reconciled(set);
    EXPECT_EQ(result.kept.points, set.points);
    EXPECT_TRUE(result.stats.pairs.empty());
}

// Three pairs of slices meet the surface within some micrometres of the point in which all three planes meet.
TEST(Reconcile, slices_that_meet_in_a_point_of_the_surface_share_one_vertex_there) {
    std::mt19937 random(5);
    for (const double off : {-2e-3, 5e-4, 2e-3}) {  // of vertices 0.3 mm apart
        const double radius = 20, at = radius / std::sqrt(3.0) + off;
        const ContourSet set =
            drawn_ball(radius,
                       {make_plane({at, 0, 0}, {1, 0, 0}), make_plane({0, at, 0}, {0, 1, 0}),
                        make_plane({0, 0, at}, {0, 0, 1})},
                       {0, 0, 390}, random);
        const ContourSet agreed = reconciled(set).kept;
        expect_exact_agreement(agreed);
        expect_sound(agreed);
        std::vector<Vec3> near;
        for (const Vec3& p : agreed.points) {
            if (length(p - Vec3{at, at, at}) < 0.03) near.push_back(p);
        }
        EXPECT_EQ(near.size(), 3u) << off;
        for (const Vec3& p : near) EXPECT_EQ(p, near[0]) << off;
    }
}

TEST(Reconcile, align_finds_a_shift) {
    std::mt19937 random(7);
    for (int n = 0; n < 4; ++n) {
        ContourSet set = drawn_ball(30, three_stacks(24, 5, 0.05), {0, 0, 300}, random);
        const std::uint32_t moved = random() % set.slices.size();
        const Plane plane = set.slices[moved].plane;
        const Vec3 shift = 3 * normalized(plane.u + (0.3 * n) * plane.v);
        const Contour& contour = set.contours[moved];
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            set.points[k] += shift;
        }
        ReconcileOptions options;
        options.align = true;
        const ReconcileResult result = reconciled(set, options);
        EXPECT_LT(length(result.stats.movements[moved].shift + shift), 0.15);
        EXPECT_LT(result.stats.max_mm, 0.5);
        for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
            if (s == moved) continue;
            EXPECT_LT(length(result.stats.movements[s].shift), 0.3);
        }
        expect_exact_agreement(result.kept);
    }
}

// Few slices that are out of place together: they move, and the stack that they cross stays.
TEST(Reconcile, C29_align_leaves_the_many_where_they_are) {
    std::vector<Plane> stack, across;
    for (int k = -6; k <= 6; ++k) stack.push_back(make_plane({0, 0, 3.0 * k}, {0, 0, 1}));
    for (const Vec3 normal : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{1, 1, 0}})
        across.push_back(make_plane({}, normal));
    for (const std::size_t few : {1u, 2u, 3u}) {
        for (const double far : {2.0, 4.0, 8.0}) {
            for (const Vec3 way : {Vec3{1, 0, 0}, Vec3{0.5, 0.8, 0}, Vec3{0, 0, 1}, Vec3{0.6, 0, 0.8}}) {
                ContourSet set;
                const auto ball = [](const Plane& plane, Vec3 center) {
                    const Vec2 at = plane.to_plane(center);
                    const double height = plane.signed_distance(center);
                    Ring ring;
                    for (int i = 0; i < 120; ++i) {
                        const double angle = 2 * std::numbers::pi * (i + 0.37) / 120;
                        ring.push_back(at + std::sqrt(400 - height * height) *
                                                Vec2{std::cos(angle), std::sin(angle)});
                    }
                    return ring;
                };
                for (const Plane& plane : stack) add_slice(set, plane, ball(plane, {}));
                for (std::size_t i = 0; i < few; ++i) add_slice(set, across[i], ball(across[i], far * way));
                ReconcileOptions options;
                options.align = true;
                options.max_disagreement_mm = 1000;
                const ReconcileResult result = reconciled(set, options);
                // Two slices at an end of the ball, small beside the distance, may follow.
                std::size_t stay = 0;
                for (std::size_t s = 0; s < stack.size(); ++s)
                    stay += length(result.stats.movements[s].shift) < 0.1 * far;
                EXPECT_GE(stay + 4, stack.size()) << few << ' ' << far << ' ' << way.x << ' ' << way.z;
            }
        }
    }
}

TEST(Reconcile, C29_names_a_slice_that_jumped) {
    std::mt19937 random(8);
    ContourSet set = drawn_ball(40, three_stacks(30, 6, 0.05), {0, 0, 200}, random);
    const Contour& contour = set.contours[5];
    for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
        set.points[k] += 12 * set.slices[5].plane.v;
    }
    ReconcileOptions options;
    options.reconcile = false;
    options.margin_mm = margin;
    RunContext context;
    EXPECT_TRUE(reconcile_contours(set, options, context).ok());
    std::vector<std::string> named;
    for (const Warning& warning : context.warnings) {
        if (warning.code == "W-RCN-005") named.push_back(warning.place.slice);
    }
    EXPECT_EQ(named, std::vector<std::string>{"5"});
}

// The same slices in another order.
ContourSet reordered(const ContourSet& set, std::mt19937& random) {
    std::vector<std::uint32_t> order(set.slices.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), random);
    ContourSet result;
    for (const std::uint32_t s : order) {
        Ring ring;
        for (const Vec3& p : set.points_of(set.contours[s])) ring.push_back(set.slices[s].plane.to_plane(p));
        add_slice(result, set.slices[s].plane, ring);
        result.slices.back().name = set.slices[s].name;
    }
    return result;
}

TEST(Reconcile, the_order_of_slices_does_not_matter) {
    std::mt19937 random(9);
    const ContourSet set = drawn_ball(30, three_stacks(24, 8, 0.05), {1, 0.5, 100}, random);
    const ReconcileResult one = reconciled(set), two = reconciled(reordered(set, random));
    const std::vector<Vec3> p = sorted(one.kept.points), q = sorted(two.kept.points);
    ASSERT_EQ(p.size(), q.size());
    for (std::size_t i = 0; i < p.size(); ++i) EXPECT_LT(length(p[i] - q[i]), 1e-3);
    EXPECT_NEAR(one.stats.difference_mm, two.stats.difference_mm, 1e-6);
}

TEST(Reconcile, the_number_of_threads_does_not_matter) {
    std::mt19937 random(10);
    const ContourSet set = drawn_ball(30, three_stacks(24, 6, 0.05), {1, 0.7, 100}, random);
    std::vector<ContourSet> results;
    for (const int threads : {1, 3}) {
        RunContext context;
        context.threads = threads;
        results.push_back(reconcile_contours(set, {}, context).value().kept);
    }
    EXPECT_EQ(results[0].points, results[1].points);
}

TEST(SliceFaults, finds_crossings_and_wrong_turns) {
    const PlaneRing square{0, {{0, 0}, {10, 0}, {10, 10}, {0, 10}}};
    const PlaneRing hole{0, {{2, 2}, {2, 8}, {8, 8}, {8, 2}}};
    const PlaneRing island{0, {{20, 0}, {30, 0}, {30, 10}, {20, 10}}};
    const PlaneRing bow{0, {{0, 0}, {10, 10}, {10, 0}, {0, 10}}};
    const PlaneRing across{0, {{5, 5}, {15, 5}, {15, 8}, {5, 8}}};
    EXPECT_TRUE(slice_faults(std::vector{square, hole, island}, false).empty());
    EXPECT_FALSE(slice_faults(std::vector{bow}, false).empty());
    EXPECT_FALSE(slice_faults(std::vector{square, across}, false).empty());
    PlaneRing turned = hole;
    std::reverse(turned.at.begin(), turned.at.end());
    EXPECT_FALSE(slice_faults(std::vector{square, turned}, false).empty());
    PlaneRing other = across;
    other.structure = 1;
    EXPECT_TRUE(slice_faults(std::vector{square, other}, false).empty());
    EXPECT_FALSE(slice_faults(std::vector{square, other}, true).empty());
}

}  // namespace
}  // namespace anatomesh::reconcile_test
