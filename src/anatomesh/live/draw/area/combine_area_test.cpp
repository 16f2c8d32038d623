#include "anatomesh/live/draw/area/combine_area.h"

#include <gtest/gtest.h>

#include "anatomesh/live/draw/area/draw_fixtures.h"

namespace anatomesh::combine_area_test {
namespace {

using namespace draw_fixtures;

// Members of the family: each has a plane, rings and an area of one or two polygons that may cross.
constexpr int members = 300;
constexpr AreaRule rules[] = {AreaRule::unite, AreaRule::subtract, AreaRule::subtract_or_add,
                              AreaRule::replace};

struct Member {
    explicit Member(int seed) : random(static_cast<unsigned>(seed)) {
        plane = random_plane(random);
        before = random_rings(random, plane);
        const int polygons = whole(random, 1, 2);
        for (int n = 0; n < polygons; ++n) {
            const Vec2 centre{uniform(random, -20, 80), uniform(random, -20, 80)};
            area.push_back(ring_of(
                random() % 2 ? random_scrawl(random) : random_star(random, centre, uniform(random, 2, 30)),
                plane));
        }
    }

    Random random;
    Plane plane;
    StructureRings before;
    std::vector<Ring> area;
};

CombinedArea combined(const StructureRings& before, std::span<const Ring> area, AreaRule rule) {
    Result<CombinedArea> result = combine_area(before, area, rule);
    EXPECT_TRUE(result.ok());
    return result.value();
}

TEST(CombineArea, is_the_operation_of_sets_at_random_points) {
    std::size_t compared = 0;
    for (int seed = 0; seed < members; ++seed) {
        Member member(seed);
        const CombinedArea united = combined(member.before, member.area, AreaRule::unite);
        const CombinedArea cut = combined(member.before, member.area, AreaRule::subtract);
        const CombinedArea either = combined(member.before, member.area, AreaRule::subtract_or_add);
        for (const CombinedArea* result : {&united, &cut, &either}) expect_sound(result->rings);
        for (int n = 0; n < 300; ++n) {
            const Vec2 p{uniform(member.random, -60, 120), uniform(member.random, -60, 120)};
            if (distance_to_rings(member.before.rings, p) < 2e-3 || distance_to_rings(member.area, p) < 2e-3)
                continue;
            ++compared;
            const bool in_rings = encloses(member.before.rings, p), in_area = encloses(member.area, p);
            ASSERT_EQ(encloses(united.rings.rings, p), in_rings || in_area) << seed;
            ASSERT_EQ(encloses(cut.rings.rings, p), in_rings && !in_area) << seed;
            const bool is_cut = either.effect == AreaEffect::cut;
            ASSERT_EQ(encloses(either.rings.rings, p), is_cut ? in_rings && !in_area : in_rings || in_area)
                << seed;
        }
    }
    EXPECT_GT(compared, 80'000u);
}

TEST(CombineArea, areas_of_union_and_intersection_are_those_of_both) {
    for (int seed = 0; seed < members; ++seed) {
        const Member member(seed);
        const CombinedArea united = combined(member.before, member.area, AreaRule::unite);
        const CombinedArea cut = combined(member.before, member.area, AreaRule::subtract);
        const double before = area_of(member.before), drawn = area_of(member.area);
        const double common = before - area_of(cut.rings);
        EXPECT_NEAR(area_of(united.rings) + common, before + drawn,
                    1e-6 + united.sliver_area_mm2 + cut.sliver_area_mm2)
            << seed;
    }
}

TEST(CombineArea, a_second_time_changes_nothing) {
    for (int seed = 0; seed < members; ++seed) {
        const Member member(seed);
        for (const AreaRule rule : {AreaRule::unite, AreaRule::subtract, AreaRule::replace}) {
            const CombinedArea once = combined(member.before, member.area, rule);
            const CombinedArea twice = combined(once.rings, member.area, rule);
            EXPECT_TRUE(same_bytes(once.rings, twice.rings)) << seed << " " << static_cast<int>(rule);
        }
    }
}

TEST(CombineArea, union_then_difference_is_difference) {
    for (int seed = 0; seed < members; ++seed) {
        const Member member(seed);
        const CombinedArea united = combined(member.before, member.area, AreaRule::unite);
        const CombinedArea then_cut = combined(united.rings, member.area, AreaRule::subtract);
        const CombinedArea cut = combined(member.before, member.area, AreaRule::subtract);
        const double slivers = united.sliver_area_mm2 + then_cut.sliver_area_mm2 + cut.sliver_area_mm2;
        EXPECT_NEAR(area_of(then_cut.rings), area_of(cut.rings), 1e-6 + slivers) << seed;
        expect_sound(then_cut.rings);
    }
}

// The vertices of each ring that no crossing is next to stand in the result in the same order.
TEST(CombineArea, a_ring_that_is_not_reached_keeps_its_bytes_and_so_does_each_stretch_away_from_crossings) {
    std::size_t whole_rings = 0, stretches = 0;
    for (int seed = 0; seed < members; ++seed) {
        const Member member(seed);
        for (const AreaRule rule : {AreaRule::unite, AreaRule::subtract}) {
            const CombinedArea result = combined(member.before, member.area, rule);
            if (result.sliver_area_mm2 > 0) continue;  // a ring narrower than 0.001 mm went
            std::size_t last_place = 0;
            for (std::size_t r = 0; r < member.before.rings.size(); ++r) {
                const Ring& ring = member.before.rings[r];
                const std::size_t n = ring.size();
                std::vector<char> is_met(n, 0), is_inside;
                for (std::size_t i = 0; i < n; ++i) {
                    is_inside.push_back(encloses(member.area, ring.at[i]));
                    for (const Ring& drawn : member.area) {
                        for (std::size_t k = 0; k < drawn.size(); ++k) {
                            is_met[i] |=
                                segment_contact(ring.at[i], ring.at[(i + 1) % n], drawn.at[k],
                                                drawn.at[(k + 1) % drawn.size()]) != SegmentContact::none;
                        }
                    }
                }
                if (std::none_of(is_met.begin(), is_met.end(), [](char met) { return met; })) {
                    const auto same = [&](const Ring& other) {
                        return other.points == ring.points && other.at == ring.at;
                    };
                    const auto found =
                        std::find_if(result.rings.rings.begin(), result.rings.rings.end(), same);
                    ASSERT_EQ(found != result.rings.rings.end(), !is_inside[0]) << seed;
                    if (is_inside[0]) continue;
                    const auto place = static_cast<std::size_t>(found - result.rings.rings.begin());
                    EXPECT_GE(place, last_place) << "rings stay in their order";
                    EXPECT_EQ(result.came_from[place], static_cast<std::int32_t>(r));
                    last_place = place;
                    ++whole_rings;
                    continue;
                }
                // From a crossing to the next one.
                std::size_t start = 0;
                while (!is_met[start]) ++start;
                std::vector<Vec3> stretch;
                for (std::size_t k = 1; k <= n; ++k) {
                    const std::size_t i = (start + k) % n;
                    stretch.push_back(ring.points[i]);
                    if (!is_met[i]) continue;
                    if (!is_inside[i]) {
                        ++stretches;
                        const std::vector<Vec3> back(stretch.rbegin(), stretch.rend());
                        bool found = false;
                        for (std::size_t k2 = 0; k2 < result.rings.rings.size(); ++k2) {
                            const std::vector<Vec3>& points = result.rings.rings[k2].points;
                            // A ring that is joined to an earlier one runs as that one does.
                            const bool is_joined = result.came_from[k2] < static_cast<std::int32_t>(r);
                            found = found || has_stretch(points, stretch) ||
                                    (is_joined && has_stretch(points, back));
                        }
                        ASSERT_TRUE(found) << seed << " " << r;
                    }
                    stretch.clear();
                }
            }
        }
    }
    EXPECT_GT(whole_rings, 300u);
    EXPECT_GT(stretches, 300u);
}

// Every vertex of a result is a vertex of a ring or of the area, or lies where two edges cross.
TEST(CombineArea, makes_vertices_at_crossings_alone) {
    for (int seed = 0; seed < members; ++seed) {
        const Member member(seed);
        const CombinedArea result = combined(member.before, member.area, AreaRule::unite);
        std::vector<Vec3> known;
        for (const Ring& ring : member.before.rings)
            known.insert(known.end(), ring.points.begin(), ring.points.end());
        for (const Ring& ring : member.area)
            known.insert(known.end(), ring.points.begin(), ring.points.end());
        std::sort(known.begin(), known.end(), LexicographicLess{});
        for (const Ring& ring : result.rings.rings) {
            for (std::size_t i = 0; i < ring.size(); ++i) {
                if (std::binary_search(known.begin(), known.end(), ring.points[i], LexicographicLess{}))
                    continue;
                EXPECT_LT(distance_to_rings(member.area, ring.at[i]), 1e-9) << seed;
            }
        }
    }
}

TEST(CombineArea, replace_takes_the_parts_that_it_overlaps_and_no_other) {
    int replaced = 0;
    for (int seed = 0; seed < members; ++seed) {
        Member member(seed);
        const CombinedArea result = combined(member.before, member.area, AreaRule::replace);
        expect_sound(result.rings);
        // The parts that are overlapped, from points alone: a point's part is the innermost ring around it.
        const auto innermost = [&](Vec2 p) {
            std::size_t found = member.before.rings.size();
            double least = 1e300;
            for (std::size_t r = 0; r < member.before.rings.size(); ++r) {
                const double area = std::abs(signed_area(member.before.rings[r].at));
                if (area < least && encloses(member.before.rings[r].at, p)) least = area, found = r;
            }
            return found;
        };
        std::vector<Vec2> points;
        for (int n = 0; n < 600; ++n) {
            const Vec2 p{uniform(member.random, -60, 120), uniform(member.random, -60, 120)};
            if (distance_to_rings(member.before.rings, p) > 2e-3 && distance_to_rings(member.area, p) > 2e-3)
                points.push_back(p);
        }
        std::vector<char> gone(member.before.rings.size() + 1, 0), stays(gone);
        for (const Vec2 p : points) {
            const bool was = encloses(member.before.rings, p), is_drawn = encloses(member.area, p),
                       is = encloses(result.rings.rings, p);
            ASSERT_TRUE(is || !is_drawn) << seed;
            ASSERT_FALSE(is && !was && !is_drawn) << seed;
            if (was && is_drawn) gone[innermost(p)] = 1;
            if (was && !is_drawn && is) stays[innermost(p)] = 1;
        }
        for (std::size_t r = 0; r < member.before.rings.size(); ++r) {
            EXPECT_FALSE(gone[r] && stays[r]) << seed;
            replaced += gone[r];
        }
    }
    EXPECT_GT(replaced, 100);
}

// Rectangles and strokes on a coarse lattice: most edges overlap, and most vertices lie on edges.
TEST(CombineArea, is_exact_on_a_lattice) {
    for (int seed = 0; seed < 500; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const auto box = [&](double x, double y, double w, double h) {
            return Polygon{{x, y}, {x + w, y}, {x + w, y + h}, {x, y + h}};
        };
        std::vector<Polygon> polygons;
        for (int n = 0; n < 3; ++n) {
            const double x = 8 * n;
            polygons.push_back(box(x, 0, 7, 7));
            polygons.push_back(box(x + 1, 1, 5, 5));
            if (random() % 2) polygons.push_back(box(x + 2, 2, 3, 3));
        }
        StructureRings rings = rings_of(polygons, {});
        for (int step = 0; step < 6; ++step) {
            Polygon scrawl;
            const int points = whole(random, 3, 9);
            for (int n = 0; n < points; ++n)
                scrawl.push_back({1.0 * whole(random, -1, 24), 1.0 * whole(random, -1, 8)});
            const std::vector<Ring> area{ring_of(scrawl, {})};
            const bool cuts = random() % 2;
            const StructureRings after =
                combined(rings, area, cuts ? AreaRule::subtract : AreaRule::unite).rings;
            expect_sound(after);
            for (double x = -1.47; x < 26; x += 1.03) {
                for (double y = -1.41; y < 9; y += 1.07) {
                    const Vec2 p{x, y};
                    if (distance_to_rings(rings.rings, p) < 2e-3 || distance_to_rings(area, p) < 2e-3)
                        continue;
                    const bool was = encloses(rings.rings, p), in = encloses(area, p);
                    ASSERT_EQ(encloses(after.rings, p), cuts ? was && !in : was || in) << seed << " " << step;
                }
            }
            rings = after;
        }
    }
}

TEST(CombineArea, a_hole_of_a_hole_stays) {
    const StructureRings before = rings_of(
        {circle({0, 0}, 40, 90), circle({0, 0}, 30, 80), circle({0, 0}, 20, 70), circle({0, 0}, 10, 60)},
        make_plane({5, 6, 7}, {0.2, 0.3, 1}));
    // A bar through all of them.
    const std::vector<Ring> bar{ring_of(Polygon{{-60, -2}, {60, -2}, {60, 2}, {-60, 2}}, before.plane)};
    const CombinedArea united = combined(before, bar, AreaRule::unite);
    EXPECT_EQ(united.effect, AreaEffect::extended);
    EXPECT_EQ(united.rings.rings.size(), 5u);  // one outline, and two halves of each hole
    const CombinedArea cut = combined(before, bar, AreaRule::subtract);
    EXPECT_EQ(cut.rings.rings.size(), 4u);  // two halves of either annulus
    EXPECT_EQ(cut.effect, AreaEffect::cut);
    // A spot in the innermost hole is an island.
    const std::vector<Ring> spot{ring_of(circle({1, 1}, 3, 30), before.plane)};
    const CombinedArea with_spot = combined(before, spot, AreaRule::subtract_or_add);
    EXPECT_EQ(with_spot.effect, AreaEffect::new_part);
    EXPECT_EQ(with_spot.rings.rings.size(), 5u);
    for (std::size_t r = 0; r < 4; ++r) EXPECT_EQ(with_spot.rings.rings[r].points, before.rings[r].points);
}

TEST(CombineArea, of_nothing_and_with_nothing) {
    const std::vector<Ring> spot{ring_of(circle({1, 1}, 3, 30), {})};
    for (const AreaRule rule : rules) {
        const CombinedArea on_nothing = combined({}, spot, rule);
        EXPECT_EQ(on_nothing.effect, rule == AreaRule::subtract ? AreaEffect::nothing : AreaEffect::new_part);
        EXPECT_EQ(on_nothing.rings.rings.size(), rule == AreaRule::subtract ? 0u : 1u);
        const StructureRings before = rings_of({circle({0, 0}, 9, 20)}, {});
        const CombinedArea with_nothing = combined(before, {}, rule);
        EXPECT_EQ(with_nothing.effect, AreaEffect::nothing);
        EXPECT_TRUE(with_nothing.is_area_empty);
        EXPECT_TRUE(same_bytes(with_nothing.rings, before));
    }
}

}  // namespace
}  // namespace anatomesh::combine_area_test
