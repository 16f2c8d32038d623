// Laws of what slices leave undrawn: two boxes, one in the other, in stacks of several directions.
#include "anatomesh/slices/coverage/undrawn_structures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh::undrawn_structures_test {
namespace {

const Vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

// Slices square to an axis through a box of half width 20 and another one in it, from -8 to `top` along z, of
// half width 8 across; `leaves_out(s)`: the inner one is not drawn.
template <class LeavesOut>
ContourSet boxes_on(const std::vector<std::pair<int, double>>& planes, double top,
                    const LeavesOut& leaves_out) {
    ContourSet set;
    set.structures = {{1, "outer", {}}, {2, "inner", {}}};
    for (std::uint32_t s = 0; s < planes.size(); ++s) {
        const int axis = planes[s].first;
        const double height = planes[s].second;
        const Plane plane = make_plane(height * axes[axis], axes[axis]);
        set.slices.push_back({plane, static_cast<std::uint32_t>(set.contours.size()), 0, std::to_string(s)});
        const auto add = [&](std::uint32_t structure, Vec3 low, Vec3 high) {
            const double at[] = {dot(low, axes[axis]), dot(high, axes[axis])};
            if (height <= at[0] || height >= at[1]) return;
            const auto first = static_cast<std::uint32_t>(set.points.size());
            set.contours.push_back({structure, s, first, 4});
            const Vec3 &u = axes[(axis + 1) % 3], &v = axes[(axis + 2) % 3];
            const Vec3 corners[][2] = {{low, low}, {high, low}, {high, high}, {low, high}};
            for (const auto& [x, y] : corners)
                set.points.push_back(height * axes[axis] + dot(x, u) * u + dot(y, v) * v);
            ++set.slices.back().contour_count;
        };
        add(0, {-20, -20, -20}, {20, 20, 20});
        if (!leaves_out(s)) add(1, {-8, -8, -8}, {8, 8, top});
    }
    return set;
}

std::vector<std::pair<int, double>> stack(int axis) {
    std::vector<std::pair<int, double>> planes;
    for (int k = -4; k <= 4; ++k) planes.push_back({axis, 4.0 * k + 0.3});
    return planes;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> undrawn_of(const ContourSet& set) {
    RunContext context;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> undrawn;
    for (const UndrawnStructure& missing : find_undrawn_structures(set, context))
        undrawn.emplace_back(missing.slice, missing.structure);
    return undrawn;
}

TEST(UndrawnStructures, slices_of_one_direction_or_that_draw_all_leave_nothing_unsaid) {
    EXPECT_TRUE(undrawn_of(boxes_on(stack(2), 8, [](auto) { return false; })).empty());
    EXPECT_TRUE(undrawn_of(boxes_on(stack(2), 8, [](auto s) { return s % 2 == 0; })).empty());
    std::vector<std::pair<int, double>> planes = stack(2);
    for (const int axis : {0, 1}) {
        const auto more = stack(axis);
        planes.insert(planes.end(), more.begin(), more.end());
    }
    EXPECT_TRUE(undrawn_of(boxes_on(planes, 8, [](auto) { return false; })).empty());
}

TEST(UndrawnStructures, a_plane_across_that_never_draws_a_structure_says_nothing_of_it) {
    std::vector<std::pair<int, double>> planes = stack(2);
    planes.push_back({0, 1});
    planes.push_back({1, 15});  // beside it: "outside"
    const ContourSet set = boxes_on(planes, 8, [](auto s) { return s >= 9; });
    EXPECT_EQ(undrawn_of(set), (std::vector<std::pair<std::uint32_t, std::uint32_t>>{{9, 1}}));
}

// The first slice beyond a structure's end says that it is not there, also where a plane across draws the end
// a little further; one that misses it in the midst, or far below its end, leaves it unknown.
TEST(UndrawnStructures, beyond_the_end_of_its_own_direction_a_slice_says_outside) {
    for (const double top : {9.0, 11.0, 17.0}) {
        std::vector<std::pair<int, double>> planes = stack(2);
        planes.push_back({0, 1});
        const ContourSet set = boxes_on(planes, top, [&](auto s) { return s == 6 || s == 7; });
        const auto undrawn = undrawn_of(set);  // slices 6 and 7 at 8.3 and 12.3
        const bool is_end = top < 8.3 + 4;
        EXPECT_EQ(undrawn.size(), is_end ? 0u : 2u) << top;
    }
    std::vector<std::pair<int, double>> planes = stack(2);
    planes.push_back({0, 1});
    EXPECT_EQ(undrawn_of(boxes_on(planes, 8, [](auto s) { return s == 4; })),
              (std::vector<std::pair<std::uint32_t, std::uint32_t>>{{4, 1}}));
}

// One slice that is drawn too far does not outvote the slices that it crosses; all of them together do, and
// go as far as they are drawn: the outermost slice does not cut off what goes on through those before it.
TEST(UndrawnStructures, beyond_an_end_one_slice_among_many_does_not_prolong_a_structure) {
    std::vector<std::pair<int, double>> planes = stack(2);
    const auto across = stack(0);
    planes.insert(planes.end(), across.begin(), across.end());
    for (const bool all : {false, true}) {
        ContourSet set = boxes_on(planes, 8, [](auto) { return false; });
        for (const Contour& contour : set.contours) {
            if (contour.structure != 1 || contour.slice < 9 || (!all && contour.slice != 13)) continue;
            for (std::uint32_t n = contour.first_point; n < contour.first_point + contour.point_count; ++n) {
                if (set.points[n].z == 8) set.points[n].z = 17;
            }
        }
        // At 8.3, 12.3 and 16.3.
        const std::vector<std::pair<std::uint32_t, std::uint32_t>> outvoted{{6, 1}, {7, 1}, {8, 1}};
        EXPECT_EQ(undrawn_of(set), all ? outvoted : decltype(outvoted){});
    }
}

// Nothing moves, and the slice and the structure are named.
TEST(UndrawnStructures, reconciling_leaves_them_alone_and_warns) {
    std::vector<std::pair<int, double>> planes = stack(2);
    planes.push_back({0, 1});
    const ContourSet set = boxes_on(planes, 8, [](auto s) { return s == 9; });
    RunContext context;
    const ReconcileResult result = reconcile_contours(set, {}, context).value();
    EXPECT_EQ(result.stats.max_movement_mm, 0);
    EXPECT_EQ(result.stats.unmatched, 0u);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-RCN-007");
    EXPECT_EQ(context.warnings[0].place.slice, "9");
    EXPECT_EQ(context.warnings[0].place.structure, "inner");
}

}  // namespace
}  // namespace anatomesh::undrawn_structures_test
