#include "anatomesh/measure/volume.h"

#include <gtest/gtest.h>

#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::volume_of_slices_test {
namespace {

// Squares of 4 by 4, each on a slice of its own.
struct Squares {
    ContourSet set;

    explicit Squares(std::uint32_t structures) {
        for (std::uint32_t s = 0; s < structures; ++s)
            set.structures.push_back({static_cast<std::int32_t>(s + 1), "", {}});
    }
    void draw(double z, std::uint32_t structure) {
        const auto slice = static_cast<std::uint32_t>(set.slices.size());
        set.slices.push_back({make_plane({0, 0, z}, {0, 0, 1}), slice, 1, "z"});
        set.contours.push_back({structure, slice, 4 * slice, 4});
        for (const Vec2 p : {Vec2{0, 0}, Vec2{4, 0}, Vec2{4, 4}, Vec2{0, 4}})
            set.points.push_back({p.x, p.y, z});
    }
    std::vector<double> volumes() const {
        RunContext context;
        return slice_volumes(set, coverage_of(set, arrangement_of(set), context));
    }
};

TEST(Volume, overlapping_structures_get_their_overlap_each) {
    const TetMesh mesh = testing::brick_mesh({3, 1, 1}, [](int i, int, int) { return Region(i + 1); });
    const std::vector<double> volumes = mesh_volumes(mesh, {{{}, {0}, {0, 1}, {1}}}, 2);
    EXPECT_DOUBLE_EQ(volumes[0], 2.0);
    EXPECT_DOUBLE_EQ(volumes[1], 2.0);
}

TEST(Volume, slices_that_cross_are_not_integrated) {
    Squares turned(1);
    for (int k = 0; k < 3; ++k) turned.draw(k, 0);
    EXPECT_EQ(turned.volumes().size(), 1u);
    turned.set.slices[1].plane = make_plane({0, 0, 2}, {0, 1, 1});
    EXPECT_TRUE(turned.volumes().empty());
}

// Each of two structures on slices of its own: others' slices are none of its.
TEST(Volume, RS19_slices_that_say_nothing_about_a_structure_are_none_of_its) {
    for (const double shift : {0.5, 1.0}) {
        Squares squares(2);
        for (int k = 0; k < 6; ++k) {
            squares.draw(3 * k, 0);
            if (k < 4) squares.draw(3 * k + shift, 1);
        }
        const std::vector<double> volumes = squares.volumes();
        ASSERT_EQ(volumes.size(), 2u);
        EXPECT_NEAR(volumes[0], 6 * 3 * 16, 1e-9);
        EXPECT_NEAR(volumes[1], 4 * 3 * 16, 1e-9);
    }
}

// The first structure is on slices 0, 1 and 3, at 0, 3 and 6 mm; slice 2 at 4 mm shows another.
TEST(Volume, only_slices_that_are_certain_of_a_structure_count) {
    Squares squares(2);
    for (const double z : {0.0, 3.0, 4.0, 6.0}) squares.draw(z, z == 4.0);
    const auto volume = [&](Coverage of_slice_2) {
        SliceCoverage coverage(squares.set);
        coverage.set_absence(2, 0, of_slice_2);
        return slice_volumes(squares.set, coverage).at(0);
    };
    EXPECT_NEAR(volume(Coverage::absent), (3 + 2 + 2) * 16, 1e-9) << "a slice without it parts the gap";
    EXPECT_NEAR(volume(Coverage::doubtful), (3 + 3 + 3) * 16, 1e-9);
    EXPECT_NEAR(volume(Coverage::unknown), (3 + 3 + 3) * 16, 1e-9);
}

TEST(Volume, with_one_certain_slice_alone_all_slices_count) {
    Squares squares(2);
    for (const double z : {0.0, 2.0, 4.0}) squares.draw(z, z != 2.0);
    SliceCoverage coverage(squares.set);
    for (const std::uint32_t slice : {0u, 2u}) coverage.set_absence(slice, 0, Coverage::unknown);
    EXPECT_NEAR(slice_volumes(squares.set, coverage).at(0), 2 * 16, 1e-9);
}

}  // namespace
}  // namespace anatomesh::volume_of_slices_test
