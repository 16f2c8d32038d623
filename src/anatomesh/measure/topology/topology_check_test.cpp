// Solids of unit cubes, and what their contours say of them.
#include "anatomesh/measure/topology/topology_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "anatomesh/mesh/model/cube_solid_for_test.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/sample/drawing_for_test.h"

namespace anatomesh::topology_check_test {
namespace {

using namespace fixtures;

using Polygons = std::vector<Polygon>;
// What its surface and contours say of tears.
class TornSolid : public CubeSolid {
  public:
    // As it is; the same is to be found where it is bent, so that its slices lean against each other, and
    // where a plane that is no part of it runs across them.
    std::vector<TopologyMismatch> tears(const Drawing& drawing) {
        const auto as_it_is = [](Vec3 p) { return p; };
        const std::vector<TopologyMismatch> found = tears(drawing, as_it_is);
        EXPECT_EQ(found_in(tears(drawing, bend)), found_in(found)) << "bent";
        const Box3 box = kept(drawing.raw).box();
        Drawing finer;
        for (const RawContour& contour : drawing.raw.contours) {
            Polygon polygon;
            for (std::uint32_t n = 0; n < contour.point_count; ++n) {
                const Vec3 p = drawing.raw.points[contour.first_point + n];
                polygon.push_back({p.x, p.y});
            }
            // Planes closer than the vertices along them are not told from those across.
            finer.add(0, drawing.raw.points[contour.first_point].z, divided(polygon, 1));
        }
        const auto as_finer = found_in(tears(finer, as_it_is));
        EXPECT_EQ(as_finer.empty(), found.empty());
        Drawing crossed = finer;
        const double y = 0.5 * (box.low.y + box.high.y) + 0.1;
        RawContour across = crossed.raw.contours.front();
        across.first_point = static_cast<std::uint32_t>(crossed.raw.points.size());
        across.point_count = 4;
        across.name = "across";
        crossed.raw.contours.push_back(across);
        for (const auto& [x, z] : rectangle({box.low.x, box.low.z - 2}, {box.high.x, box.high.z + 2}))
            crossed.raw.points.push_back({x, y, z});
        EXPECT_EQ(found_in(tears(crossed, as_it_is)), as_finer) << "crossed";
        EXPECT_EQ(found_in(tears(crossed, bend)), as_finer) << "bent and crossed";
        return found;
    }

    // As it is alone: of slices in any position.
    std::vector<TopologyMismatch> tears_in_stacks(const Drawing& drawing) {
        return tears(drawing, [](Vec3 p) { return p; });
    }

  private:
    // Round an axis along y, 60 mm off: planes of equal z turn by a degree a mm.
    static Vec3 bend(Vec3 p) {
        const double angle = p.z * pi / 180, reach = 60 + p.x;
        return {reach * std::cos(angle) - 60, p.y, reach * std::sin(angle)};
    }

    // What was found, whatever the slices' numbers are: a set across them may be numbered otherwise.
    static std::vector<std::array<std::int64_t, 3>> found_in(const std::vector<TopologyMismatch>& tears) {
        std::vector<std::array<std::int64_t, 3>> found;
        for (const TopologyMismatch& tear : tears) found.push_back({tear.euler, tear.expected, tear.whole});
        std::sort(found.begin(), found.end());
        return found;
    }

    // With all points put elsewhere.
    template <class Place>
    std::vector<TopologyMismatch> tears(Drawing drawing, const Place& place) {
        drawing.move(place);
        const ContourSet set = kept(drawing.raw);
        const std::vector<Triangle> triangles = surface();
        std::vector<Vec3> moved;
        std::map<std::array<long long, 3>, std::uint32_t> at;
        const auto key = [](Vec3 p) {
            return std::array{std::llround(1e6 * p.x), std::llround(1e6 * p.y), std::llround(1e6 * p.z)};
        };
        for (const Vec3& p : points()) {
            at[key(place(p))] = static_cast<std::uint32_t>(moved.size());
            moved.push_back(place(p));
        }
        std::vector<std::uint32_t> vertex_of;  // none of a contour across, nor where a hole is
        for (const Vec3& p : set.points) {
            const auto found = at.find(key(p));
            vertex_of.push_back(found == at.end() ? no_cell : found->second);
        }
        EXPECT_LT(2 * std::count(vertex_of.begin(), vertex_of.end(), no_cell), std::ssize(vertex_of));
        const std::vector<std::vector<Triangle>> surfaces{triangles};
        const std::uint8_t all[] = {0}, whole_only[] = {1};
        std::vector<TopologyMismatch> tears =
            topology_check(moved, surfaces, set, arrangement_of(set), vertex_of, all);
        expect_whole_ones(topology_check(moved, surfaces, set, arrangement_of(set), vertex_of, whole_only),
                          tears);
        EXPECT_EQ(topology_check(moved, surfaces, set, arrangement_of(set), vertex_of, all, 3), tears);
        return tears;
    }

    // A search for whole runs alone finds those of `all` that are whole.
    static void expect_whole_ones(const std::vector<TopologyMismatch>& found,
                                  std::vector<TopologyMismatch> all) {
        std::erase_if(all, [](const TopologyMismatch& tear) { return !tear.whole; });
        ASSERT_EQ(found.size(), all.size());
        for (std::size_t n = 0; n < all.size(); ++n) {
            EXPECT_TRUE(found[n].whole);
            EXPECT_EQ(found[n].low_slice, all[n].low_slice);
            EXPECT_EQ(found[n].euler, all[n].euler);
            EXPECT_EQ(found[n].expected, all[n].expected);
        }
    }
};

// Contours on slices at 2, 6, 10 ... below `top`: those that `at_height` gives for each.
template <class AtHeight>
Drawing drawn_below(int top, const AtHeight& at_height) {
    Drawing drawing;
    for (int z = 2; z < top; z += 4) {
        for (const Polygon& polygon : at_height(z)) drawing.add(0, z, polygon);
    }
    return drawing;
}

// The same ones on all slices up to 18.
Drawing drawn_on_all(const Polygons& polygons) {
    return drawn_below(20, [&](int) { return polygons; });
}

// 20 x 2 mm, from z = 0 to 20.
struct Plate {
    TornSolid solid;
    Drawing drawing = drawn_on_all({rectangle({0, 0}, {20, 2})});
    Plate() { solid.add({0, 0, 0}, {20, 2, 20}); }
    std::vector<TopologyMismatch> tears() { return solid.tears(drawing); }
};

std::int64_t handles(const std::vector<TopologyMismatch>& tears) {
    std::int64_t twice = 0;
    for (const TopologyMismatch& tear : tears) twice += tear.expected - tear.euler;
    return twice / 2;
}

TEST(TopologyCheck, a_whole_plate_has_none) {
    EXPECT_TRUE(Plate().tears().empty());
}

TEST(TopologyCheck, C35_a_hole_through_a_plate_is_found_wherever_it_lies) {
    for (int low = 1; low < 17; ++low) {
        for (const int height : {1, 2, 3}) {
            Plate plate;
            plate.solid.remove({8, 0, low}, {10, 2, low + height});
            const auto tears = plate.tears();
            ASSERT_EQ(tears.size(), 1u) << low << ' ' << height;
            EXPECT_EQ(handles(tears), 1) << low << ' ' << height;
            EXPECT_TRUE(tears[0].whole);
        }
    }
}

TEST(TopologyCheck, the_slices_about_a_hole_are_named_and_holes_counted) {
    Plate plate;
    plate.solid.remove({3, 0, 7}, {5, 2, 8});
    plate.solid.remove({13, 0, 7}, {15, 2, 8});
    const auto tears = plate.tears();
    ASSERT_EQ(tears.size(), 1u);
    EXPECT_EQ(handles(tears), 2);
    EXPECT_EQ(tears[0].low_slice, 1u);
    EXPECT_EQ(tears[0].high_slice, 2u);
}

TEST(TopologyCheck, dents_bumps_and_notches_are_no_tears) {
    Plate plate;
    for (int z = 1; z < 18; z += 3) {
        plate.solid.remove({2 * (z % 7) + 2, 0, z}, {2 * (z % 7) + 3, 1, z + 2});  // a dent in one side
        plate.solid.add({2 * (z % 7) + 5, 2, z}, {2 * (z % 7) + 6, 3, z + 2});     // a bump on the other
    }
    plate.solid.remove({9, 0, 19}, {11, 2, 20});  // a notch in the rim
    plate.solid.add({4, 0, 20}, {6, 1, 22});      // a tip on it
    EXPECT_TRUE(plate.tears().empty());
}

TEST(TopologyCheck, the_wall_of_a_tube) {
    for (const bool torn : {false, true}) {
        TornSolid solid;
        solid.add({0, 0, 0}, {9, 9, 20});
        solid.remove({2, 2, 0}, {7, 7, 20});
        if (torn) solid.remove({4, 0, 9}, {5, 2, 11});
        const Drawing drawing = drawn_on_all({rectangle({0, 0}, {9, 9}), rectangle({2, 2}, {7, 7})});
        EXPECT_EQ(handles(solid.tears(drawing)), torn);
    }
}

TEST(TopologyCheck, a_bridge_over_a_gap) {
    for (const int bridges : {0, 1, 2}) {
        TornSolid solid;
        solid.add({0, 0, 0}, {20, 2, 20});
        solid.add({0, 3, 0}, {20, 5, 20});
        const Drawing drawing = drawn_on_all({rectangle({0, 0}, {20, 2}), rectangle({0, 3}, {20, 5})});
        for (int n = 0; n < bridges; ++n) solid.add({5 + 6 * n, 2, 7}, {7 + 6 * n, 3, 9});
        EXPECT_EQ(handles(solid.tears(drawing)), bridges);
    }
}

// Contours in planes across the three axes, 4 mm apart: on each those that `on_plane` gives, in the frame of
// the other two axes in their order round.
template <class OnPlane>
Drawing drawn_in_three_stacks(const OnPlane& on_plane) {
    Drawing drawing;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (int level = 2; level < 20; level += 4) {
            for (const Polygon& polygon : on_plane(axis, level)) {
                drawing.add(0, level, polygon);
                const RawContour& contour = drawing.raw.contours.back();
                for (std::uint32_t n = 0; n < contour.point_count; ++n) {
                    Vec3& p = drawing.raw.points[contour.first_point + n];
                    const double xyz[3] = {p.x, p.y, p.z};
                    double to[3];
                    to[axis] = xyz[2], to[(axis + 1) % 3] = xyz[0], to[(axis + 2) % 3] = xyz[1];
                    p = {to[0], to[1], to[2]};
                }
            }
        }
    }
    return drawing;
}

// Two blocks of 20 x 8 x 20 mm, a mm apart along y, drawn in three stacks; `bridge` on the plane x = 10.
Drawing two_blocks_in_three_stacks(bool bridge) {
    return drawn_in_three_stacks([&](std::size_t axis, int level) -> Polygons {
        if (axis == 1 && level > 17) return {};
        if (axis == 1) return {rectangle({0, 0}, {20, 20})};  // z, x: one of the blocks
        if (axis == 2) return {rectangle({0, 0}, {20, 8}), rectangle({0, 9}, {20, 17})};
        if (!bridge || level != 10) return {rectangle({0, 0}, {8, 20}), rectangle({9, 0}, {17, 20})};
        return {{{0, 0},
                 {8, 0},
                 {8, 7},
                 {9, 7},
                 {9, 0},
                 {17, 0},
                 {17, 20},
                 {9, 20},
                 {9, 9},
                 {8, 9},
                 {8, 20},
                 {0, 20}}};
    });
}

TEST(TopologyCheck, a_bridge_between_the_slices_of_three_stacks) {
    for (const int bridges : {0, 1, 2}) {
        TornSolid solid;
        solid.add({0, 0, 0}, {20, 8, 20});
        solid.add({0, 9, 0}, {20, 17, 20});
        for (int n = 0; n < bridges; ++n) solid.add({3 + 8 * n, 8, 7}, {5 + 8 * n, 9, 9});
        const std::vector<TopologyMismatch> tears = solid.tears_in_stacks(two_blocks_in_three_stacks(false));
        EXPECT_EQ(handles(tears), bridges);
        for (const TopologyMismatch& tear : tears) EXPECT_FALSE(tear.by_mesh);
    }
}

TEST(TopologyCheck, a_bridge_that_a_plane_across_shows_is_none) {
    TornSolid solid;
    solid.add({0, 0, 0}, {20, 8, 20});
    solid.add({0, 9, 0}, {20, 17, 20});
    solid.add({9, 8, 7}, {11, 9, 9});
    EXPECT_TRUE(solid.tears_in_stacks(two_blocks_in_three_stacks(true)).empty());
}

TEST(TopologyCheck, a_gap_that_is_filled_but_for_cavities) {
    TornSolid solid;
    solid.add({0, 0, 0}, {20, 5, 20});
    const Drawing drawing = drawn_on_all({rectangle({0, 0}, {20, 2}), rectangle({0, 3}, {20, 5})});
    for (int z = 2; z < 20; z += 4) {
        for (const int x : {0, 18})
            solid.remove({x, 2, z - 1}, {x + 2, 3, z + 1});  // corners are on the surface
        solid.remove({4, 2, z - 1}, {16, 3, z + 1});         // a cavity
    }
    EXPECT_FALSE(solid.tears(drawing).empty());
}

// A box with voids that begin and end between slices, one side of it or a cap torn.
TEST(TopologyCheck, the_wall_of_a_closed_shell) {
    for (const int voids : {1, 2}) {
        const auto box = [&] {
            TornSolid solid;
            solid.add({0, 0, 0}, {10 * voids, 10, 22});
            for (int n = 0; n < voids; ++n) solid.remove({10 * n + 2, 2, 4}, {10 * n + 8, 8, 18});
            return solid;
        };
        const Drawing drawing = drawn_below(22, [&](int z) {
            Polygons polygons{rectangle({0, 0}, {10.0 * voids, 10})};
            for (int n = 0; n < voids && z > 4 && z < 18; ++n)
                polygons.push_back(rectangle({10.0 * n + 2, 2}, {10.0 * n + 8, 8}));
            return polygons;
        });
        EXPECT_TRUE(box().tears(drawing).empty()) << voids;
        for (int z = 4; z < 17; ++z) {
            TornSolid torn = box();
            torn.remove({4, 0, z}, {5, 2, z + 1});
            const auto tears = torn.tears(drawing);
            ASSERT_EQ(tears.size(), 1u) << voids << ' ' << z;
            EXPECT_EQ(handles(tears), 1) << voids << ' ' << z;
            EXPECT_TRUE(tears[0].whole);
        }
        TornSolid open = box();  // through the top, beyond the last slice but one
        open.remove({4, 4, 18}, {5, 5, 22});
        EXPECT_EQ(handles(open.tears(drawing)), 1) << voids;
    }
}

// The hole of the second slice reaches beyond the outline of the first, and none of what is left is judged.
TEST(TopologyCheck, a_void_that_may_open_to_the_outside_is_not_judged) {
    for (const bool opens : {false, true}) {
        TornSolid solid;
        solid.add({0, 0, 0}, {10, 10, 4});
        solid.add({0, 0, 4}, {20, 10, 20});
        solid.remove({4, 2, opens ? 4 : 5}, {16, 8, 20});
        const Drawing drawing = drawn_below(20, [](int z) {
            if (z < 4) return Polygons{rectangle({0, 0}, {10, 10})};
            return Polygons{rectangle({0, 0}, {20, 10}), rectangle({4, 2}, {16, 8})};
        });
        EXPECT_TRUE(solid.tears(drawing).empty()) << opens;
    }
}

// The lower half of the plate goes on as two: its run ends there.
TEST(TopologyCheck, a_hole_in_a_run_that_ends_where_the_part_branches) {
    for (const bool torn : {false, true}) {
        TornSolid solid;
        solid.add({0, 0, 0}, {20, 2, 20});
        solid.remove({9, 0, 12}, {11, 2, 20});
        const Drawing drawing = drawn_below(20, [](int z) {
            if (z < 12) return Polygons{rectangle({0, 0}, {20, 2})};
            return Polygons{rectangle({0, 0}, {9, 2}), rectangle({11, 0}, {20, 2})};
        });
        if (torn) solid.remove({4, 0, 7}, {6, 2, 8});
        const auto tears = solid.tears(drawing);
        EXPECT_EQ(handles(tears), torn);
        for (const TopologyMismatch& tear : tears) EXPECT_FALSE(tear.whole);
    }
}

// One contour, two, and one again: a handle that is drawn.
TEST(TopologyCheck, C16_branches_are_not_judged) {
    TornSolid solid;
    solid.add({0, 0, 0}, {20, 4, 20});
    solid.remove({8, 0, 8}, {12, 4, 12});
    const Drawing drawing = drawn_below(20, [](int z) {
        if (z != 10) return Polygons{rectangle({0, 0}, {20, 4})};
        return Polygons{rectangle({0, 0}, {8, 4}), rectangle({12, 0}, {20, 4})};
    });
    EXPECT_TRUE(solid.tears(drawing).empty());
}

}  // namespace
}  // namespace anatomesh::topology_check_test
