#include "anatomesh/element/material.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh::material_test {
namespace {

MaterialLaw power() {
    MaterialLaw law;
    law.kind = MaterialLaw::Kind::power;
    law.intercept = 0.05;
    law.slope = 0.001;
    law.factor_mpa = 6850;
    law.exponent = 1.49;
    law.low_mpa = 10;
    return law;
}

TEST(Material, laws_are_what_they_say) {
    MaterialLaw law = power();
    EXPECT_NEAR(young_modulus(law, 950), 6850, 1e-9);
    EXPECT_NEAR(density(law, 950), 1, 1e-12);
    EXPECT_EQ(young_modulus(law, -1000), 10);
    EXPECT_EQ(density(law, -1000), 0);
    law.kind = MaterialLaw::Kind::table;
    law.low_mpa = 0;
    law.table = {{-100, 1}, {0, 5}, {200, 25}};
    EXPECT_EQ(young_modulus(law, -500), 1);
    EXPECT_EQ(young_modulus(law, -50), 3);
    EXPECT_EQ(young_modulus(law, 0), 5);
    EXPECT_EQ(young_modulus(law, 100), 15);
    EXPECT_EQ(young_modulus(law, 900), 25);
    EXPECT_EQ(density(law, 900), 0);
}

TEST(Material, bins_keep_the_mean_and_differ_by_less_than_their_width) {
    const TetMesh mesh =
        testing::rounded_mesh(6, 10, [](int i, int, int) -> Region { return i < 3 ? 1 : 2; });
    std::vector<double> grey;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        grey.push_back(700 + 600 * std::sin(0.37 * double(c)));
    std::vector<MaterialLaw> laws{power(), {}};
    laws[0].bins = 12;
    laws[1].young_mpa = 3;
    laws[1].poisson = 0.49;
    laws[1].density_g_cm3 = 1.1;
    const auto binned = bin_materials(mesh, grey, laws, std::vector<std::uint32_t>{0, 0, 1});
    ASSERT_TRUE(binned.ok());
    const auto& [materials, of_cell] = binned.value();
    ASSERT_EQ(materials.size(), 13u);
    EXPECT_EQ(materials.back(), (Material{3, 0.49, 1e-9 * 1.1}));
    double low = 1e9, high = 0, exact = 0, sum = 0;
    for (std::size_t c = 0; c < of_cell.size(); ++c) {
        if (mesh.regions[c] == 2) {
            EXPECT_EQ(of_cell[c], 12u);
            continue;
        }
        const double young = young_modulus(laws[0], grey[c]);
        const auto& [p, q, r, s] = mesh.cells[c];
        const double volume = signed_volume(mesh.points[p], mesh.points[q], mesh.points[r], mesh.points[s]);
        low = std::min(low, young);
        high = std::max(high, young);
        exact += volume * young;
        sum += volume * materials[of_cell[c]].young_mpa;
    }
    EXPECT_NEAR(sum / exact, 1, 1e-12);
    for (std::size_t c = 0; c < of_cell.size(); ++c) {
        if (mesh.regions[c] == 2) continue;
        EXPECT_LE(std::abs(materials[of_cell[c]].young_mpa - young_modulus(laws[0], grey[c])),
                  (high - low) / 12);
    }
    for (std::size_t m = 1; m < 12; ++m) EXPECT_LT(materials[m - 1].young_mpa, materials[m].young_mpa);
}

TEST(Material, a_modulus_of_zero_is_refused) {
    const TetMesh mesh = testing::rounded_mesh(2, 10, [](int, int, int) -> Region { return 1; });
    MaterialLaw law = power();
    law.low_mpa = 0;
    law.intercept = 0;
    const std::vector<double> grey(mesh.cells.size(), -5.0);
    const auto refused = bin_materials(mesh, grey, std::vector{law}, std::vector<std::uint32_t>{0, 0});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "E-ELM-002");
}

}  // namespace
}  // namespace anatomesh::material_test
