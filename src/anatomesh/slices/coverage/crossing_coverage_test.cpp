// Laws of what slices say of structures that are not drawn on them.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh::crossing_coverage_test {
namespace {

// A stack of discs of one structure 2 mm apart, and one of another structure whose planes lie `offset` mm
// above those of the first and lean by so many degrees; `both`: each plane has both.
ContourSet two_stacks(double degrees, double offset, bool both) {
    ContourSet set;
    set.structures = {{1, "one", {}}, {2, "two", {}}};
    const double angle = degrees * std::numbers::pi / 180;
    for (int k = -5; k <= 5; ++k) {
        for (const std::uint32_t own : {0u, 1u}) {
            const Vec3 normal = own == 0 ? Vec3{0, 0, 1} : Vec3{0, -std::sin(angle), std::cos(angle)};
            const Plane plane = make_plane({0, 0, 2.0 * k + (own == 0 ? 0 : offset)}, normal);
            const auto slice = static_cast<std::uint32_t>(set.slices.size());
            set.slices.push_back(
                {plane, static_cast<std::uint32_t>(set.contours.size()), 0, std::to_string(slice)});
            for (const std::uint32_t structure : {0u, 1u}) {
                if (structure != own && !both) continue;
                set.contours.push_back({structure, slice, static_cast<std::uint32_t>(set.points.size()), 24});
                ++set.slices.back().contour_count;
                for (int n = 0; n < 24; ++n) {
                    const double turn = n * std::numbers::pi / 12, radius = structure == 0 ? 10 : 4;
                    set.points.push_back(plane.origin + radius * std::cos(turn) * plane.u +
                                         radius * std::sin(turn) * plane.v);
                }
            }
        }
    }
    return set;
}

TEST(CrossingCoverage, a_structure_on_planes_of_its_own_is_not_told_by_those_between) {
    int tried = 0;
    for (const double degrees : {0.2, 1.0, 2.5, 4.0, 10.0, 15.0}) {
        for (const double offset : {0.3, 1.0}) {
            SCOPED_TRACE(std::to_string(degrees) + " degrees, " + std::to_string(offset) + " mm");
            const ContourSet set = two_stacks(degrees, offset, false);
            RunContext context;
            const auto [arrangement, coverage] = slice_facts_of(set, default_max_gap, context);
            // Slices come in turn; the first of the second structure and the last of the first lie at an end.
            if (arrangement.is_stack()) {
                for (std::uint32_t s = 1; s + 1 < set.slices.size(); ++s)
                    EXPECT_EQ(coverage.at(s, s % 2 == 0 ? 1 : 0), Coverage::unknown) << s;
                continue;
            }
            ++tried;
            for (std::uint32_t s = 1; s + 1 < set.slices.size(); ++s) {
                const std::uint32_t other = s % 2 == 0 ? 1 : 0;
                EXPECT_EQ(coverage.at(s, other), Coverage::unknown) << s;
                EXPECT_EQ(coverage.at(s, 1 - other), Coverage::drawn) << s;
            }
        }
    }
    EXPECT_GE(tried, 2);
}

TEST(CrossingCoverage, planes_that_all_draw_a_structure_leave_nothing_unsaid) {
    RunContext context;
    for (const double degrees : {0.2, 2.5}) {
        const ContourSet set = two_stacks(degrees, 0.3, true);
        EXPECT_FALSE(slice_facts_of(set, default_max_gap, context).coverage.has_unknown());
    }
}

// Of a structure that is missing on single slices of its stack these say that it is not there.
TEST(CrossingCoverage, a_slice_that_is_left_out_of_many_says_outside) {
    ContourSet set = two_stacks(0.2, 0.3, true);
    std::vector<Contour> kept;
    for (const Contour& contour : set.contours) {
        if (contour.structure != 1 || contour.slice != 10) kept.push_back(contour);
    }
    for (Slice& slice : set.slices) slice.contour_count = 0;
    set.contours = kept;
    for (std::uint32_t n = 0; n < kept.size(); ++n) {
        Slice& slice = set.slices[kept[n].slice];
        if (slice.contour_count++ == 0) slice.first_contour = n;
    }
    RunContext context;
    EXPECT_EQ(slice_facts_of(set, default_max_gap, context).coverage.at(10, 1), Coverage::absent);
}

}  // namespace
}  // namespace anatomesh::crossing_coverage_test
