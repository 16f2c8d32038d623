#include "anatomesh/slices/coverage/slice_coverage.h"

#include <gtest/gtest.h>

#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/arrangement/sweep.h"
#include "anatomesh/slices/coverage/covering_slices.h"

namespace anatomesh::slice_coverage_test {
namespace {

using namespace fixtures;
using Places = std::vector<std::uint32_t>;

Places covering(const std::vector<double>& heights, const std::vector<double>& drawn_at) {
    Places drawn;
    for (std::uint32_t n = 0; n < heights.size(); ++n) {
        if (std::find(drawn_at.begin(), drawn_at.end(), heights[n]) != drawn_at.end()) drawn.push_back(n);
    }
    return covering_slices(drawn, heights);
}

TEST(CoveringSlices, RS18_one_that_is_skipped_in_an_even_stack_tells) {
    EXPECT_EQ(covering({0, 3, 6, 9, 12, 15}, {0, 3, 9, 12, 15}), (Places{0, 1, 2, 3, 4, 5}));
}

TEST(CoveringSlices, RS19_those_between_slices_of_its_own_do_not) {
    EXPECT_EQ(covering({0, 3, 6, 9, 12, 15, 18}, {0, 6, 12, 18}), (Places{0, 2, 4, 6}));
}

// A lesion is drawn on finer slices inside an organ that is drawn every 3 mm.
TEST(CoveringSlices, those_in_a_gap_that_is_as_wide_as_its_others_do_not) {
    const std::vector<double> heights{0, 3, 6, 8, 9, 10, 12, 14, 15, 18, 21};
    EXPECT_EQ(covering(heights, {0, 3, 6, 9, 12, 15, 18, 21}), (Places{0, 1, 2, 4, 6, 8, 9, 10}));
    // Not drawn at 9 either: there it is empty.
    EXPECT_EQ(covering(heights, {0, 3, 6, 12, 15, 18, 21}), (Places{0, 1, 2, 3, 4, 5, 6, 8, 9, 10}));
}

// Not drawn at 9, since that slice was left out: what lies beside it tells nothing.
TEST(CoveringSlices, those_between_four_that_are_evenly_spaced_do_not) {
    // 0, 5, 10 and 15 mm, of which the last two gaps hold others.
    const std::vector<double> heights{0, 5, 6, 8, 10, 12, 15};
    EXPECT_EQ(covering_slices({0, 1, 4, 6}, heights), (std::vector<std::uint32_t>{0, 1, 4, 6}));
    // Three show no spacing, nor do four of which one gap is wider.
    EXPECT_EQ(covering_slices({0, 1, 4}, {0, 5, 6, 8, 10}), (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
    EXPECT_EQ(covering_slices({0, 1, 4, 5}, {0, 5, 6, 8, 11, 16}),
              (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
}

TEST(CoveringSlices, what_was_left_out_is_no_slice_without_it) {
    const std::vector<double> heights{0, 3, 6, 8, 10, 12, 14, 15, 18, 21};
    const Places drawn{0, 1, 2, 5, 7, 8, 9};
    EXPECT_EQ(covering_slices(drawn, heights), (Places{0, 1, 2, 3, 4, 5, 7, 8, 9}));
    EXPECT_EQ(covering_slices(drawn, heights, {9}), (Places{0, 1, 2, 5, 7, 8, 9}));
    EXPECT_EQ(covering_slices(drawn, heights, {-3, 9, 24}), (Places{0, 1, 2, 5, 7, 8, 9}));
    EXPECT_EQ(covering_slices(drawn, heights, {8}), (Places{0, 1, 2, 3, 4, 5, 7, 8, 9}));
}

TEST(CoveringSlices, uneven_gaps_show_no_spacing) {
    EXPECT_EQ(covering({0, 2, 3, 7, 9, 10.5, 12, 18}, {0, 2, 3, 7, 9, 12, 18}),
              (Places{0, 1, 2, 3, 4, 5, 6, 7}));
}

// An organ on every third millimetre, and a lesion inside on every second.
TEST(CoveringSlices, an_organ_is_whole_where_a_lesion_in_it_has_slices_of_its_own) {
    for (const double lean : {0.0, 0.004}) {
        SetBuilder builder;
        std::vector<std::pair<double, bool>> slices;
        for (int z = -24; z <= 24; ++z) {
            const bool organ = z % 3 == 0, lesion = z >= -3 && z <= 5 && (z + 3) % 2 == 0;
            if (!organ && !lesion) continue;
            builder.slice(make_plane({0, 0, static_cast<double>(z)}, {lean * (z % 2), lean * (z % 5), 1}));
            if (organ) builder.ring(0, circle({}, std::sqrt(26.0 * 26 - z * z), 80));
            if (lesion) builder.ring(1, circle({4, 0}, 5, 40));
        }
        RunContext context;
        const auto field = make_structure_field(builder.set, {}, context).value();
        for (double z = -20; z <= 20; z += 0.25) {
            EXPECT_LT(field->value(0, {0, 10, z}), 0) << z;
            if (z >= -2.5 && z <= 4.5) {
                EXPECT_LT(field->value(1, {4, 0, z}), 0) << z;
            }
        }
        const auto told = [&](const std::string& code) {
            return std::count_if(context.warnings.begin(), context.warnings.end(),
                                 [&](const Warning& warning) { return warning.code == code; });
        };
        EXPECT_EQ(told("W-FLD-003"), 0);
        EXPECT_EQ(told("W-FLD-012"), 2);  // the lesion goes on through the organ's slice at 0, too
        const SliceCoverage coverage = slice_facts_of(builder.set, default_max_gap, context).coverage;
        for (std::uint32_t s = 0; s < builder.set.slices.size(); ++s) {
            const auto drawn = builder.set.contours_of(builder.set.slices[s]);
            EXPECT_EQ(coverage.at(s, 0), drawn.front().structure == 0 ? Coverage::drawn : Coverage::unknown)
                << s;
        }
    }
}

// An organ every 3 mm, a lesion in it on each of some, and one of the organ's slices left out: parallel
// slices, some that lean more and more, and some that lean as by hand and cross.
TEST(CoveringSlices, an_organ_is_whole_where_a_slice_of_its_own_is_left_out) {
    enum class Lean { none, more_and_more, by_hand };
    for (const Lean lean : {Lean::none, Lean::more_and_more, Lean::by_hand}) {
        SCOPED_TRACE(static_cast<int>(lean));
        SetBuilder builder;
        std::vector<std::uint32_t> others;
        std::uint32_t slice = 0;
        for (int z = -24; z <= 24; ++z) {
            const bool organ = z % 3 == 0, lesion = z >= -2 && z <= 4;
            if (!organ && !lesion) continue;
            Vec3 normal{0, 0, 1};
            if (lean == Lean::more_and_more) normal.x = 0.007 * z;
            if (lean == Lean::by_hand) normal = {0.12 * std::sin(2.3 * z), 0.1 * std::cos(1.7 * z), 1};
            builder.slice(make_plane({0, 0, static_cast<double>(z)}, normal));
            if (organ) builder.ring(0, circle({}, 20, 80));
            if (lesion) builder.ring(1, circle({0, 4}, 5, 40));
            if (z != 0) others.push_back(slice);
            ++slice;
        }
        const ContourSet set = chosen_slices(builder.set, others);
        ASSERT_EQ(set.left_out.size(), 2u);
        EXPECT_EQ(set.left_out[0].structure, builder.set.structures[0].number);
        const SliceArrangement arrangement = arrangement_of(set);
        EXPECT_EQ(arrangement.is_parallel(), lean == Lean::none);
        EXPECT_EQ(arrangement.is_stack(), lean != Lean::by_hand);
        ContourSet unknown = set;
        unknown.left_out.clear();
        for (const bool known : {true, false}) {
            RunContext context;
            const auto field = make_structure_field(known ? set : unknown, {}, context).value();
            bool whole = true;
            for (double z = -20; z <= 20; z += 0.25) whole = whole && field->value(0, {0, 6, z}) < 0;
            // Between planes that cross those of the lesion hardly tell of it.
            if (known || lean != Lean::by_hand) {
                EXPECT_EQ(whole, known);
            }
        }
    }
}

// Five discs of one structure; the third slice draws another structure alone.
ContourSet discs_with_another_between() {
    SetBuilder builder;
    for (int k = 0; k < 5; ++k) {
        builder.slice(make_plane({0, 0, 2.0 * k}, {0, 0, 1}));
        builder.ring(k == 2 ? 1 : 0, circle({}, 10, 40));
    }
    return std::move(builder.set);
}

TEST(SliceCoverage, a_slice_without_a_contour_between_others_shows_that_the_structure_is_absent) {
    const ContourSet set = discs_with_another_between();
    RunContext context;
    const SliceCoverage coverage = slice_facts_of(set, default_max_gap, context).coverage;
    for (std::uint32_t k = 0; k < 5; ++k) {
        EXPECT_EQ(coverage.at(k, 0), k == 2 ? Coverage::absent : Coverage::drawn) << k;
        EXPECT_EQ(coverage.at(k, 1), k == 2 ? Coverage::drawn : Coverage::absent) << k;
        EXPECT_TRUE(coverage.is_certain(k, 0) && coverage.is_certain(k, 1));
    }
    EXPECT_FALSE(coverage.has_unknown());
}

TEST(SliceCoverage, an_outline_that_nobody_drew_is_interpolated_and_stays_so) {
    ContourSet set = discs_with_another_between();
    set.slices[2].interpolated = {set.structures[1].number};
    SliceCoverage coverage(set);
    EXPECT_EQ(coverage.at(2, 1), Coverage::interpolated);
    EXPECT_EQ(coverage.at(1, 0), Coverage::drawn);
    coverage.set_absence(2, 1, Coverage::unknown);
    EXPECT_EQ(coverage.at(2, 1), Coverage::interpolated);
    coverage.set_absence(2, 0, Coverage::unknown);
    EXPECT_TRUE(coverage.is_unknown(2, 0) && coverage.has_unknown() && !coverage.is_certain(2, 0));
}

// The rule for slices on levels of nested structures: what a level has no slice of is unknown.
TEST(SliceCoverage, a_level_of_nested_structures_says_nothing_of_slices_that_it_has_not) {
    ContourSet set = discs_with_another_between();
    set.exclusive = true;
    OverlappingContours all;
    const std::vector<std::uint32_t> outer{0, 1, 3, 4}, inner{2};
    for (const auto& own : {outer, inner}) {
        ContourSet level = chosen_slices(set, own);
        // A level holds its own structures alone.
        level.structures = {set.structures[all.levels.size()]};
        for (Contour& contour : level.contours) contour.structure = 0;
        all.levels.push_back(std::move(level));
    }
    all.slices = {outer, inner};
    set.overlapping = std::make_shared<const OverlappingContours>(std::move(all));
    RunContext context;
    const SliceCoverage coverage = slice_facts_of(set, default_max_gap, context).coverage;
    EXPECT_EQ(coverage.at(2, 0), Coverage::unknown);
    EXPECT_EQ(coverage.at(1, 0), Coverage::drawn);
    EXPECT_EQ(coverage.at(1, 1), Coverage::unknown);
    EXPECT_EQ(coverage.at(2, 1), Coverage::drawn);
}

}  // namespace
}  // namespace anatomesh::slice_coverage_test
