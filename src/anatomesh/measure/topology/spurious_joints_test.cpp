// Solids of unit cubes cut by three stacks of planes 8 mm apart.
#include "anatomesh/measure/topology/spurious_joints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "anatomesh/mesh/model/cube_solid_for_test.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh::spurious_joints_test {
namespace {

using fixtures::CubeSolid;
using Pair = std::array<std::uint32_t, 2>;

double along(Vec3 p, std::size_t axis) {
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

// The contours of a solid in the planes 4, 12, 20 ... across each axis, every edge of them one of its
// surface.
struct Cut {
    std::vector<Vec3> points;
    std::vector<std::vector<Triangle>> surfaces;
    std::vector<Pair> edges, missed;
    ContourSet contours;
    std::vector<std::uint32_t> vertex_of;

    explicit Cut(CubeSolid solid) {
        surfaces.push_back(solid.surface());
        points = solid.points();
        contours.structures.push_back({1, "one", {}});
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (int level = 4; level < 40; level += 8) add_slice(axis, level);
        }
        std::sort(edges.begin(), edges.end());
    }

    std::vector<SpuriousJoint> joints() const {
        return spurious_joints(points, surfaces, edges, missed, contours, vertex_of);
    }
    std::uint32_t count() const {
        const std::vector<SpuriousJoint> found = joints();
        return std::accumulate(
            found.begin(), found.end(), 0u,
            [](std::uint32_t sum, const SpuriousJoint& joint) { return sum + joint.joints; });
    }

  private:
    void add_slice(std::size_t axis, int level) {
        // From each vertex of the plane to the next, and on.
        std::map<std::uint32_t, std::uint32_t> next;
        for (const Triangle& t : surfaces[0]) {
            int on_plane = 0, above = 0;
            for (const std::uint32_t v : t) {
                on_plane += along(points[v], axis) == level;
                above += along(points[v], axis) > level;
            }
            if (on_plane != 2 || above != 1) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                if (along(points[t[k]], axis) == level && along(points[t[(k + 1) % 3]], axis) == level)
                    next[t[k]] = t[(k + 1) % 3];
            }
        }
        if (next.empty()) return;
        const Vec3 normal{axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
        const auto slice = static_cast<std::uint32_t>(contours.slices.size());
        contours.slices.push_back({make_plane(static_cast<double>(level) * normal, normal),
                                   static_cast<std::uint32_t>(contours.contours.size()), 0,
                                   "xyz"[axis] + std::to_string(level)});
        while (!next.empty()) {
            Contour contour{0, slice, static_cast<std::uint32_t>(contours.points.size()), 0};
            for (auto at = next.begin(); at != next.end(); ++contour.point_count) {
                const auto [from, to] = *at;
                contours.points.push_back(points[from]);
                vertex_of.push_back(from);
                edges.push_back({std::min(from, to), std::max(from, to)});
                next.erase(at);
                at = next.find(to);
            }
            contours.contours.push_back(contour);
            ++contours.slices.back().contour_count;
        }
    }
};

CubeSolid two_blocks() {
    CubeSolid solid;
    solid.add({0, 0, 0}, {24, 9, 24});
    solid.add({0, 10, 0}, {24, 19, 24});
    return solid;
}

CubeSolid plate() {
    CubeSolid solid;
    solid.add({0, 5, 0}, {24, 7, 24});
    return solid;
}

TEST(SpuriousJoints, a_bridge_between_the_slices_of_three_stacks) {
    for (const int bridges : {0, 1, 2}) {
        CubeSolid solid = two_blocks();
        for (int n = 0; n < bridges; ++n) solid.add({6 + 8 * n, 9, 6}, {8 + 8 * n, 10, 8});
        const std::vector<SpuriousJoint> found = Cut(solid).joints();
        ASSERT_EQ(found.size(), static_cast<std::size_t>(bridges));
        for (std::size_t n = 0; n < found.size(); ++n) {
            EXPECT_EQ(found[n].joints, 1u);
            EXPECT_EQ(found[n].place.x, 8 + 8 * static_cast<double>(n));
            EXPECT_NEAR(found[n].place.y, 9.5, 0.5);
            EXPECT_EQ(found[n].place.z, 8);
        }
    }
    CubeSolid solid = two_blocks();
    solid.add({5, 9, 6}, {7, 10, 8});
    solid.add({9, 9, 6}, {11, 10, 8});
    const std::vector<SpuriousJoint> found = Cut(solid).joints();  // two in one cell
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].joints, 2u);
}

TEST(SpuriousJoints, a_hole_through_a_plate) {
    for (const int holes : {0, 1, 2}) {
        CubeSolid solid = plate();
        for (int n = 0; n < holes; ++n) solid.remove({6 + 8 * n, 5, 6}, {8 + 8 * n, 7, 8});
        EXPECT_EQ(Cut(solid).count(), static_cast<std::uint32_t>(holes));
    }
}

TEST(SpuriousJoints, a_handle_between_the_slices) {
    CubeSolid solid = two_blocks();
    solid.add({6, 6, 24}, {7, 7, 25});
    solid.add({9, 6, 24}, {10, 7, 25});
    EXPECT_EQ(Cut(solid).count(), 0u);
    solid.add({6, 6, 25}, {10, 7, 26});
    EXPECT_EQ(Cut(solid).count(), 1u);
}

TEST(SpuriousJoints, what_a_slice_shows_is_none) {
    CubeSolid bridged = two_blocks();
    bridged.add({11, 9, 6}, {14, 10, 8});
    EXPECT_EQ(Cut(bridged).count(), 0u);
    CubeSolid pierced = plate();
    pierced.remove({11, 5, 6}, {14, 7, 8});
    EXPECT_EQ(Cut(pierced).count(), 0u);
}

// From one block to another one far off, along a way that misses two of the stacks.
TEST(SpuriousJoints, a_rod_or_a_channel_is_none) {
    for (const bool channel : {false, true}) {
        CubeSolid solid;
        solid.add({0, 0, 0}, {24, 9, 24});
        solid.add({0, channel ? 9 : 30, 0}, {24, 39, 24});
        if (channel) solid.remove({6, 9, 6}, {8, 30, 8});  // closed at both ends
        if (!channel) solid.add({6, 9, 6}, {8, 30, 8});
        EXPECT_EQ(Cut(solid).count(), 0u) << channel;
    }
}

TEST(SpuriousJoints, bumps_dents_rims_and_what_no_contour_is_on_are_none) {
    CubeSolid solid = two_blocks();
    solid.add({6, 6, 24}, {8, 8, 26});
    solid.remove({14, 6, 22}, {16, 8, 24});
    solid.remove({5, 7, 5}, {7, 8, 7});   // a void between all slices
    solid.add({22, 0, 22}, {26, 3, 26});  // on a corner
    EXPECT_EQ(Cut(solid).count(), 0u);
}

// Patches of one sheet run together.
TEST(SpuriousJoints, edges_that_are_missing_make_none) {
    for (std::uint32_t step = 2; step < 12; ++step) {
        for (const bool bridged : {false, true}) {
            CubeSolid solid = two_blocks();
            if (bridged) solid.add({6, 9, 6}, {8, 10, 8});
            Cut cut(solid);
            std::uint32_t n = 0;
            std::erase_if(cut.edges, [&](const Pair& edge) {
                if (n++ % step != 0) return false;
                cut.missed.push_back(edge);
                return true;
            });
            EXPECT_LE(cut.count(), bridged) << step;
        }
    }
}

// A segment far from it.
TEST(SpuriousJoints, an_edge_that_is_missing_elsewhere_hides_none) {
    CubeSolid solid = two_blocks();
    solid.add({6, 9, 6}, {8, 10, 8});
    Cut cut(solid);
    const auto far = std::find_if(cut.edges.begin(), cut.edges.end(), [&](const Pair& edge) {
        return cut.points[edge[0]].z > 20 && cut.points[edge[1]].z > 20;
    });
    ASSERT_NE(far, cut.edges.end());
    cut.missed.push_back(*far);
    cut.edges.erase(far);
    EXPECT_EQ(cut.count(), 1u);
}

TEST(SpuriousJoints, of_structures_that_are_not_asked_for_there_are_none) {
    CubeSolid solid = two_blocks();
    solid.add({6, 9, 6}, {8, 10, 8});
    Cut cut(solid);
    cut.surfaces[0].clear();
    EXPECT_TRUE(cut.joints().empty());
}

}  // namespace
}  // namespace anatomesh::spurious_joints_test
