// Laws of where a structure is known along the normal, on families of spacings.
#include "anatomesh/field/stack/slice_knots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"

namespace anatomesh::slice_knots_test {
namespace {

using namespace fixtures;

std::vector<double> positions_of(const std::vector<double>& gaps) {
    std::vector<double> positions{0};
    for (const double gap : gaps) positions.push_back(positions.back() + gap);
    return positions;
}

StructureKnots knots_of(const std::vector<double>& gaps, const FieldOptions& options,
                        bool every_slice = false, const GapEvidence& evidence = {}) {
    std::vector<SliceInterval> intervals;
    for (const double z : positions_of(gaps))
        intervals.push_back({static_cast<std::uint32_t>(intervals.size()), z, z});
    std::vector<std::uint32_t> drawn(intervals.size());
    std::iota(drawn.begin(), drawn.end(), 0u);
    return structure_knots(intervals, drawn, every_slice, 1, options, evidence);
}

// Gaps a, b, a, b, ...
std::vector<double> alternating(double a, double b, int count) {
    std::vector<double> gaps;
    for (int i = 0; i < count; ++i) gaps.push_back(i % 2 == 0 ? a : b);
    return gaps;
}

// The length of the axis along which a prism drawn on all slices is inside, and in how many parts.
std::pair<double, std::size_t> inside_of(const StructureKnots& knots) {
    double length = 0;
    std::size_t parts = 0;
    for (std::size_t i = 0; i + 1 < knots.knots.size(); ++i) {
        const SliceKnot &below = knots.knots[i], &above = knots.knots[i + 1];
        const int known = (below.slice != SliceKnot::no_slice) + (above.slice != SliceKnot::no_slice);
        length += 0.5 * known * (above.low - below.high);
        parts += below.slice == SliceKnot::no_slice && above.slice != SliceKnot::no_slice;
    }
    return {length, parts};
}

TEST(SliceKnots, rise_for_any_spacings_and_an_end_takes_at_most_half_of_an_open_gap) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> exponent(-2, 2), most(1, 5);
    for (int trial = 0; trial < 2000; ++trial) {
        std::vector<double> gaps(1 + random() % 12);
        for (double& gap : gaps) gap = std::exp(exponent(random));
        FieldOptions options;
        options.max_gap_spacings = trial % 4 == 0 ? 1 : most(random);
        const StructureKnots result = knots_of(gaps, options);
        const std::vector<SliceKnot>& knots = result.knots;
        ASSERT_EQ(knots.size(), gaps.size() + 3 + 2 * result.open_gaps.size());
        for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
            ASSERT_LE(knots[i].high, knots[i + 1].low);
            const bool in_gap =
                knots[i].slice == SliceKnot::no_slice && knots[i + 1].slice == SliceKnot::no_slice;
            if (!in_gap) {
                ASSERT_LT(knots[i].high, knots[i + 1].low);
            } else {
                const double gap = knots[i + 2].low - knots[i - 1].high;
                ASSERT_LE(knots[i].low - knots[i - 1].high, 0.5 * gap * (1 + 1e-12));
                ASSERT_LE(knots[i + 2].low - knots[i + 1].high, 0.5 * gap * (1 + 1e-12));
            }
        }
        ASSERT_EQ(inside_of(result).second, result.open_gaps.size() + 1);
    }
}

// Slices in pairs, down to a pair that is one plane given twice: one part.
TEST(SliceKnots, of_slices_in_pairs_are_joined_and_end_half_a_wide_gap_beyond) {
    for (const double ratio : {2.1, 3.0, 5.67, 9.0, 20.0, 100.0}) {
        for (int slices = 6; slices <= 15; ++slices) {
            for (const bool pair_first : {true, false}) {
                const auto gaps =
                    pair_first ? alternating(1, ratio, slices - 1) : alternating(ratio, 1, slices - 1);
                const StructureKnots knots = knots_of(gaps, {});
                EXPECT_TRUE(knots.open_gaps.empty());
                EXPECT_TRUE(knots.bridged_gaps.empty());
                const double expected = std::accumulate(gaps.begin(), gaps.end(), 0.0) + ratio;
                const auto [length, parts] = inside_of(knots);
                EXPECT_EQ(parts, 1u);
                EXPECT_NEAR(length, expected, 1e-9) << ratio << " " << slices << pair_first;
            }
        }
    }
}

// But since islands may be drawn so as well, it is told.
TEST(SliceKnots, of_slices_in_groups_are_told_where_the_groups_alone_join_them) {
    for (const double ratio : {2.1, 3.0, 9.0, 50.0}) {
        for (int slices = 6; slices <= 15; ++slices) {
            for (const bool pair_first : {true, false}) {
                const auto gaps =
                    pair_first ? alternating(1, ratio, slices - 1) : alternating(ratio, 1, slices - 1);
                const auto wide = static_cast<std::size_t>(std::count(gaps.begin(), gaps.end(), ratio));
                const std::size_t told = knots_of(gaps, {}).gaps_by_groups.size();
                EXPECT_GE(told, 1u) << ratio << ' ' << slices << pair_first;
                EXPECT_LE(told, wide) << ratio << ' ' << slices << pair_first;
            }
        }
    }
    for (const std::vector<double>& gaps : {std::vector{3.0, 3.0, 3.0, 3.0},
                                            {3.0, 3.0, 0.2, 2.8, 3.0, 3.0},
                                            {3.0, 6.0, 3.0, 3.0, 3.0},
                                            {3.0, 3.0, 1.0, 3.0, 3.0},
                                            {1.0, 1.0, 1.0, 1.0, 4.0, 4.0, 4.0, 4.0}}) {
        EXPECT_TRUE(knots_of(gaps, {}).gaps_by_groups.empty()) << gaps[1] << ' ' << gaps[2];
    }
}

// Three or more slices near each other are islands, however alike the gaps between; and so are two of two
// slices that are further apart than a plane from itself.
TEST(SliceKnots, of_islands_of_slices_are_not_joined) {
    for (int in_one = 3; in_one <= 6; ++in_one) {
        for (const double apart : {4.0, 9.0, 15.0, 40.0, 100.0}) {
            for (int islands = 2; islands <= 5; ++islands) {
                std::vector<double> gaps;
                for (int n = 0; n < islands; ++n) {
                    if (n > 0) gaps.push_back(apart);
                    gaps.insert(gaps.end(), static_cast<std::size_t>(in_one - 1), 1.0);
                }
                const StructureKnots knots = knots_of(gaps, {});
                EXPECT_EQ(knots.open_gaps.size(), static_cast<std::size_t>(islands - 1))
                    << in_one << ' ' << apart;
                EXPECT_NEAR(inside_of(knots).first, islands * in_one, 1e-9);
            }
        }
    }
    for (const double apart : {15.0, 40.0}) EXPECT_EQ(knots_of({1, apart, 1}, {}).open_gaps.size(), 1u);
}

// Gaps that are nearly even are no pairs, and two pairs alone may be four slices of many.
TEST(SliceKnots, of_few_slices_or_gaps_alike_tell_no_pairs) {
    for (const double ratio : {1.0, 1.5, 1.99}) {
        const StructureKnots knots = knots_of(alternating(1, ratio, 9), {});
        EXPECT_TRUE(knots.open_gaps.empty()) << ratio;
    }
    EXPECT_EQ(knots_of({1, 5, 1}, {}).open_gaps.size(), 1u);
    EXPECT_EQ(knots_of({1, 5}, {}).open_gaps.size(), 1u);
}

// One pair missing is one slice missing: joined, and said; more are not joined.
TEST(SliceKnots, of_pairs_that_are_missing_are_as_of_slices_that_are) {
    for (const double ratio : {2.1, 5.67, 9.0, 20.0}) {
        for (const std::size_t at : {1u, 5u, 9u}) {
            for (const int missing : {1, 2, 5}) {
                auto gaps = alternating(1, ratio, 13);
                gaps[at] += missing * (1 + ratio);
                const StructureKnots knots = knots_of(gaps, {});
                EXPECT_EQ(knots.open_gaps.size(), missing > 1 ? 1u : 0u) << ratio << " " << at;
                EXPECT_EQ(knots.bridged_gaps.size(), missing > 1 ? 0u : 1u) << ratio << " " << at;
                if (missing > 1) {
                    const double drawn = std::accumulate(gaps.begin(), gaps.end(), 0.0) - gaps[at];
                    EXPECT_NEAR(inside_of(knots).first, drawn + 2 * ratio, 1e-9);
                }
            }
        }
    }
}

// What a structure that has one or two pairs of the stack cannot tell, the stack does.
TEST(SliceKnots, of_a_structure_in_few_pairs_are_those_of_the_stack) {
    for (const double ratio : {3.0, 5.67, 9.0}) {
        const std::vector<double> positions = positions_of(alternating(1, ratio, 13));
        std::vector<SliceInterval> intervals;
        for (const double z : positions)
            intervals.push_back({static_cast<std::uint32_t>(intervals.size()), z, z});
        for (const std::uint32_t pairs : {1u, 2u, 3u}) {
            for (const std::uint32_t first : {0u, 4u, 8u}) {
                std::vector<std::uint32_t> drawn(2 * pairs);
                std::iota(drawn.begin(), drawn.end(), first);
                for (const bool every_slice : {false, true}) {
                    const StructureKnots knots = structure_knots(intervals, drawn, every_slice, ratio, {});
                    EXPECT_TRUE(knots.open_gaps.empty());
                    EXPECT_NEAR(inside_of(knots).first, pairs * (1 + ratio), 1e-9) << ratio << ' ' << first;
                }
            }
        }
    }
}

// However many planes of a stack are given again a little off themselves, it goes on through them.
TEST(SliceKnots, of_planes_given_twice_or_more_count_once) {
    std::mt19937 random(5);
    for (const double off : {0.001, 0.01, 0.05, 0.09}) {
        for (const double share : {0.1, 0.5, 1.0}) {
            for (int slices = 3; slices <= 12; ++slices) {
                std::vector<double> gaps;
                std::bernoulli_distribution is_repeated(share);
                double more = 0;
                for (int i = 0; i < slices; ++i) {
                    if (i > 0) gaps.push_back(1.0);
                    for (int again = 0; again < 2 && is_repeated(random); ++again) {
                        gaps.push_back(off / 2);
                        more += off / 2;
                    }
                }
                const StructureKnots knots = knots_of(gaps, {});
                EXPECT_TRUE(knots.open_gaps.empty());
                EXPECT_TRUE(knots.bridged_gaps.empty());
                EXPECT_NEAR(inside_of(knots).first, slices - 1 + more + 1, 1e-9) << off << ' ' << share;
            }
        }
    }
}

TEST(SliceKnots, of_two_fine_stacks_apart_are_two_parts) {
    for (const int fine : {3, 5, 9}) {
        std::vector<double> gaps(static_cast<std::size_t>(fine), 0.1);
        gaps.push_back(2);
        gaps.insert(gaps.end(), static_cast<std::size_t>(fine), 0.1);
        EXPECT_EQ(inside_of(knots_of(gaps, {})).second, 2u) << fine;
    }
}

TEST(SliceKnots, of_even_gaps_with_some_missing_slices_end_half_a_spacing_beyond) {
    for (const std::size_t at : {0u, 3u, 5u, 8u}) {
        for (const double missing : {2.5, 3.0, 7.0}) {
            std::vector<double> gaps(9, 1.0);
            gaps[at] = missing;
            const auto [length, parts] = inside_of(knots_of(gaps, {}));
            EXPECT_EQ(parts, 2u);
            EXPECT_NEAR(length, 8 + 2, 1e-12);
        }
    }
}

// Slices at random heights through prisms: hardly one falls into parts, and they are as long in the mean.
TEST(SliceKnots, of_uneven_gaps_are_joined_and_their_ends_are_right_in_the_mean) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> gap(1.5, 6), start(0, 6), size(25, 60);
    double off = 0, all = 0;
    int torn = 0;
    constexpr int trials = 3000;
    for (int trial = 0; trial < trials; ++trial) {
        const double low = 30 + start(random), high = low + size(random);
        std::vector<double> gaps;
        double last = 0;
        for (double z = gap(random); z < high; z += gap(random)) {
            if (z < low) continue;
            if (last > 0) gaps.push_back(z - last);
            last = z;
        }
        const auto [length, parts] = inside_of(knots_of(gaps, {}));
        torn += parts > 1;
        off += length - (high - low);
        all += high - low;
    }
    EXPECT_LT(torn, trials / 100);
    EXPECT_LT(std::abs(off), 0.01 * all);
}

// Two bodies on slices near each other, among such that are far apart: these do not tell of the gap between.
TEST(SliceKnots, of_fine_slices_among_coarse_ones_a_gap_of_theirs_is_one) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> jitter(0.9, 1.1);
    for (int trial = 0; trial < 300; ++trial) {
        for (const std::size_t fine : {3u, 4u, 6u}) {
            std::vector<double> gaps;
            const auto add = [&](std::size_t count, double gap) {
                for (std::size_t n = 0; n < count; ++n) gaps.push_back(gap * jitter(random));
            };
            add(5, 5);
            add(fine, 1);
            gaps.push_back(7);
            add(fine, 1);
            add(5, 5);
            const StructureKnots knots = knots_of(gaps, {});
            const auto is_gap = [](const SliceGap& gap) { return std::abs(gap.high - gap.low - 7) < 1e-9; };
            ASSERT_TRUE(std::any_of(knots.open_gaps.begin(), knots.open_gaps.end(), is_gap)) << fine;
        }
    }
}

// What uneven gaps alone join is told where even ones would not be joined.
TEST(SliceKnots, of_uneven_gaps_wide_ones_are_told) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> gap(1.5, 6);
    for (int trial = 0; trial < 500; ++trial) {
        std::vector<double> gaps(12);
        for (double& one : gaps) one = gap(random);
        const std::vector<double> z = positions_of(gaps);
        const StructureKnots knots = knots_of(gaps, {});
        const auto told = [&](std::size_t i) {
            const auto is_it = [&](const SliceGap& one) { return one.low == z[i]; };
            return std::any_of(knots.open_gaps.begin(), knots.open_gaps.end(), is_it) ||
                   std::any_of(knots.bridged_gaps.begin(), knots.bridged_gaps.end(), is_it) ||
                   std::any_of(knots.gaps_by_groups.begin(), knots.gaps_by_groups.end(), is_it);
        };
        for (std::size_t i = 3; i + 3 < gaps.size(); ++i) {
            std::vector<double> near(gaps.begin() + static_cast<std::ptrdiff_t>(i) - 3,
                                     gaps.begin() + static_cast<std::ptrdiff_t>(i) + 4);
            std::sort(near.begin(), near.end());
            if (gaps[i] > 2.05 * near[3]) {
                EXPECT_TRUE(told(i)) << trial;
            }
        }
    }
}

// One slice more, at any place and height, takes nothing off either end.
TEST(SliceKnots, of_even_gaps_with_a_slice_more_end_half_a_spacing_beyond) {
    for (int slices = 3; slices <= 10; ++slices) {
        for (int at = 0; at < slices - 1; ++at) {
            for (const double off :
                 {0.01, 0.05, 0.097, 0.11, 0.2, 1.0 / 3, 0.45, 0.5, 0.6, 0.75, 0.9, 0.97}) {
                // Of three slices and one half-way two are as well a missing one.
                if (slices == 3 && (off == 0.5 || off < 0.1 || off > 0.9)) continue;
                std::vector<double> gaps(static_cast<std::size_t>(slices - 1), 1.0);
                gaps[static_cast<std::size_t>(at)] = 1 - off;
                gaps.insert(gaps.begin() + at, off);
                const std::vector<SliceKnot> knots = knots_of(gaps, {}).knots;
                EXPECT_NEAR(knots.front().low, -1, 0.051) << slices << ' ' << at << ' ' << off;
                EXPECT_NEAR(knots.back().high, slices, 0.051) << slices << ' ' << at << ' ' << off;
            }
        }
    }
}

// Nor does one slice less.
TEST(SliceKnots, of_even_gaps_with_a_slice_less_end_half_a_spacing_beyond) {
    for (int slices = 4; slices <= 10; ++slices) {
        for (std::size_t at = 0; at + 1 < static_cast<std::size_t>(slices - 1); ++at) {
            std::vector<double> gaps(static_cast<std::size_t>(slices - 1), 1.0);
            gaps.erase(gaps.begin() + static_cast<std::ptrdiff_t>(at));
            gaps[at] = 2;
            const std::vector<SliceKnot> knots = knots_of(gaps, {}).knots;
            EXPECT_NEAR(knots.front().low, -1, 1e-12) << slices << ' ' << at;
            EXPECT_NEAR(knots.back().high, slices, 1e-12) << slices << ' ' << at;
        }
    }
}

// Where the spacing changes two slices before an end, the end has that beside it (of half the spacing the
// slice between two gaps may be one more).
TEST(SliceKnots, of_two_spacings_in_one_part_each_end_has_the_one_beside_it) {
    for (const double fine : {0.55, 0.6, 0.75, 0.9}) {
        for (int coarse = 3; coarse <= 7; ++coarse) {
            for (int finer = 2; finer <= 4; ++finer) {
                std::vector<double> gaps(static_cast<std::size_t>(coarse), 1.0);
                gaps.insert(gaps.end(), static_cast<std::size_t>(finer), fine);
                for (const bool turned : {false, true}) {
                    if (turned) std::reverse(gaps.begin(), gaps.end());
                    const StructureKnots knots = knots_of(gaps, {});
                    const double all = coarse + finer * fine;
                    EXPECT_NEAR(inside_of(knots).first, all + 0.5 * (1 + fine), 1e-9)
                        << fine << ' ' << coarse << ' ' << finer << turned;
                }
            }
        }
    }
}

// A change of spacing at an open gap: each side keeps its own.
TEST(SliceKnots, of_two_spacings_apart_each_end_has_its_own) {
    for (const double wide : {2.0, 3.0}) {
        std::vector<double> gaps(6, 1.0);
        gaps.push_back(9);
        gaps.insert(gaps.end(), 6, wide);
        const auto [length, parts] = inside_of(knots_of(gaps, {}));
        EXPECT_EQ(parts, 2u);
        EXPECT_NEAR(length, 6 + 6 * wide + 1 + wide, 1e-12);
    }
}

TEST(SliceKnots, the_field_of_slices_in_pairs_is_one_part) {
    for (const double ratio : {2.5, 3.0, 5.0}) {
        for (const EndCaps caps : {EndCaps::half, EndCaps::rounded, EndCaps::flat}) {
            const std::vector<double> gaps = alternating(1, ratio, 7), positions = positions_of(gaps);
            SetBuilder builder;
            for (const double z : positions) {
                builder.slice(axial(z));
                builder.ring(0, circle({}, 10, 60));
            }
            RunContext context;
            FieldOptions options;
            options.caps = caps;
            const auto field = make_structure_field(builder.set, options, context).value();
            ASSERT_EQ(context.warnings.size(), 1u);
            EXPECT_EQ(context.warnings[0].code, "W-FLD-009");
            EXPECT_NEAR(field->slice_spacing(), ratio, 1e-12);
            int parts = 0;
            bool inside = false;
            for (double z = -5; z < positions.back() + 5; z += 0.01) {
                const bool now = field->value(0, {0, 0, z}) < 0;
                parts += now && !inside;
                inside = now;
            }
            EXPECT_EQ(parts, 1);
            if (caps == EndCaps::rounded) continue;
            const auto volumes = field_volumes(*field, 1, {}, context).value();
            const double length = positions.back() + (caps == EndCaps::half ? ratio : 0);
            EXPECT_NEAR(volumes[0].by_field, length * area_of(circle({}, 10, 60)), 1e-6);
            EXPECT_NEAR(volumes[0].by_slices, length * area_of(circle({}, 10, 60)), 1e-6);
        }
    }
}

// A structure drawn every 4 mm that has outlines every mm from its second slice to its last but one.
std::vector<double> with_finer_middle() {
    std::vector<double> gaps{4};
    gaps.insert(gaps.end(), 16, 1.0);
    gaps.push_back(4);
    return gaps;
}

TEST(SliceKnots, of_outlines_that_nobody_drew_make_no_other_gap_wide) {
    GapEvidence evidence;
    EXPECT_EQ(inside_of(knots_of(with_finer_middle(), {}, true, evidence)).second, 3u)
        << "all drawn: two wide gaps";
    for (std::uint32_t i = 1; i < 18; ++i) {
        if ((i - 1) % 4 != 0) evidence.interpolated.push_back(i);
    }
    const StructureKnots knots = knots_of(with_finer_middle(), {}, true, evidence);
    const auto [length, parts] = inside_of(knots);
    EXPECT_EQ(parts, 1u);
    EXPECT_DOUBLE_EQ(length, 24 + 4) << "half of its own spacing beyond either end";
    EXPECT_TRUE(knots.open_gaps.empty());
    EXPECT_TRUE(knots.bridged_gaps.empty());
}

TEST(SliceKnots, of_all_structures_together_go_on_where_one_does) {
    GapEvidence evidence;
    evidence.parts = {{0, 24, 4, 4}};
    evidence.of_all = true;
    const auto [length, parts] = inside_of(knots_of(with_finer_middle(), {}, true, evidence));
    EXPECT_EQ(parts, 1u);
    EXPECT_DOUBLE_EQ(length, 24 + 4);
}

TEST(SliceKnots, of_one_that_ends_where_others_go_on_end_half_way_to_the_next_slice) {
    // Slices at 0, 1, 2, 3 and 9: drawn on the first four.
    std::vector<SliceInterval> intervals;
    for (const double z : {0.0, 1.0, 2.0, 3.0, 9.0})
        intervals.push_back({static_cast<std::uint32_t>(intervals.size()), z, z});
    const std::vector<std::uint32_t> drawn{0, 1, 2, 3};
    GapEvidence evidence;
    EXPECT_EQ(structure_knots(intervals, drawn, true, 1, {}, evidence).knots.back().low, 4);
    evidence.parts = {{0, 9, 1, 6}};
    EXPECT_EQ(structure_knots(intervals, drawn, true, 1, {}, evidence).knots.back().low, 9);
}

TEST(SliceKnots, tell_their_parts) {
    const StructureKnots one = knots_of({1, 1, 1}, {}), two = knots_of({1, 1, 9, 1, 1}, {});
    ASSERT_EQ(parts_of(one).size(), 1u);
    EXPECT_EQ(parts_of(one)[0].low, 0);
    EXPECT_EQ(parts_of(one)[0].high, 3);
    EXPECT_EQ(parts_of(one)[0].below, 1);
    EXPECT_EQ(parts_of(one)[0].above, 1);
    ASSERT_EQ(parts_of(two).size(), 2u);
    EXPECT_EQ(parts_of(two)[0].high, 2);
    EXPECT_EQ(parts_of(two)[1].low, 11);
    EXPECT_EQ(parts_of(two)[1].high, 13);
}

}  // namespace
}  // namespace anatomesh::slice_knots_test
