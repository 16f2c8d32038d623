#include "anatomesh/measure/field_distance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::field_distance_test {
namespace {

// Beside a surface the nearest value, as that of a slab is.
fixtures::Distance cube(double low, double high) {
    return [=](Vec3 p) {
        return std::max({low - p.x, p.x - high, low - p.y, p.y - high, low - p.z, p.z - high});
    };
}

const std::vector<Structure> body_and_core{{1, "body", {1, 2, 3}}, {2, "core", {4, 5, 6}}};
const RegionTable nested{{{}, {0}, {0, 1}}};
const std::vector<std::uint32_t> both{0, 1};

// A cube of 8 with one of 4 in its middle: walls of 2. `hole`: a square of 2 through one of them.
TetMesh walled(bool hole) {
    const auto in_core = [](int i) { return i >= 2 && i < 6; };
    return testing::brick_mesh({8, 8, 8}, [&](int i, int j, int k) {
        if (in_core(i) && in_core(j) && in_core(k)) return Region{2};
        return hole && i >= 6 && (j == 3 || j == 4) && (k == 3 || k == 4) ? Region{0} : Region{1};
    });
}

FieldDistanceReport measured(const TetMesh& mesh, const StructureField& field,
                             const std::vector<std::uint32_t>& of_field = both, int threads = 1) {
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    return farthest_from_field(mesh, neighbors, nested, body_and_core, of_field, field, {}, threads);
}

TEST(FieldDistance, nothing_is_far_in_a_sound_model) {
    const fixtures::AnalyticField field({cube(0, 8), cube(2, 6)}, 9);
    const FieldDistanceReport report = measured(walled(false), field);
    EXPECT_GT(report.points, 100u);
    EXPECT_EQ(report.max_mm, 0);
    EXPECT_EQ(report.joined_mm, 0);
}

TEST(FieldDistance, a_facet_is_measured_to_its_own_structures) {
    // The bottom of the hole lies on the core's surface, and the body's is the wall's thickness away.
    const fixtures::AnalyticField field({cube(0, 8), cube(2, 6)}, 9);
    const FieldDistanceReport report = measured(walled(true), field);
    EXPECT_NEAR(report.max_mm, 2, 0.5);
    EXPECT_EQ(report.structure, "body");
    EXPECT_NEAR(report.joined_mm, 2, 0.5);
    EXPECT_EQ(report.joined_structure, "body");
    EXPECT_EQ(report.joined_at[0], 6);
    const FieldDistanceReport again = measured(walled(true), field, both, 4);
    EXPECT_EQ(again.max_mm, report.max_mm);
    EXPECT_EQ(again.at, report.at);
    EXPECT_EQ(again.joined_at, report.joined_at);
}

// A part that narrows to nothing on a slice which does not have it: its tip is on its surface, though the
// value there knows nothing of it and the part lies between all directions that are looked in.
TEST(FieldDistance, the_tip_of_a_wedge_is_near_though_the_value_jumps_there) {
    for (const double lean : {0.0, 0.2, 0.3, 0.6}) {
        const auto wedge = [=](Vec3 p) {
            if (p.z <= 2) return 3.0;  // of the plane z = 2 and below
            const double x = p.x - 2 - lean * (p.z - 2), y = p.y - 4;
            return std::max({std::abs(x) - 0.15 * (p.z - 2), std::abs(y) - 2, p.z - 6});
        };
        const fixtures::AnalyticField field({cube(0, 8), wedge}, 9);
        const TetMesh mesh = testing::brick_mesh({8, 8, 8}, [&](int i, int j, int k) {
            return i == 2 && j == 4 && k == 2 ? Region{2} : Region{1};
        });
        const FieldDistanceReport report = measured(mesh, field);
        EXPECT_EQ(report.structure, "core");
        EXPECT_LT(report.max_mm, 1.3) << lean;  // the cell's far corner; 3 by the value
    }
}

TEST(FieldDistance, structures_that_the_field_lacks_are_as_if_not_there) {
    const fixtures::AnalyticField body_alone({cube(0, 8)}, 9);
    const FieldDistanceReport report = measured(walled(false), body_alone, {0, no_cell});
    EXPECT_EQ(report.max_mm, 0);
    EXPECT_EQ(report.joined_mm, 0);
    // The field's structures in another order than the model's.
    const fixtures::AnalyticField turned({cube(2, 6), cube(0, 8)}, 9);
    EXPECT_EQ(measured(walled(false), turned, {1, 0}).max_mm, 0);
    EXPECT_GT(measured(walled(false), turned, {0, 1}).max_mm, 1);
}

}  // namespace
}  // namespace anatomesh::field_distance_test
