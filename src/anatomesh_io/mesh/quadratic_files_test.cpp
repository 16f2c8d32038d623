// Models with mid-nodes, grey values and materials in every format that holds them.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "anatomesh/element/quadratic.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/material_file.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "anatomesh_io/mesh/model_sets.h"
#include "anatomesh_io/mesh/mutate_for_test.h"
#include "anatomesh_io/mesh/vtk_xml.h"

namespace anatomesh::quadratic_files_test {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> read_back{".vtu", ".msh", ".inp"};

// A rounded solid with another one in it; nodes on edges moved by hundredths, values that no short decimal
// hits.
ModelFile model(int n, bool quadratic, bool grey, bool material) {
    ModelFile m;
    m.mesh = testing::rounded_mesh(n, 10, [n](int i, int j, int k) -> Region {
        return i > 0 && j > 0 && k > 0 && i < n - 1 && j < n - 1 && k < n - 1 ? 2 : 1;
    });
    m.mesh.points[0].x = 1.23456789e-05;
    m.description.structures = {{5, "bone", {255, 0, 0}}, {7, "marrow", {0, 255, 0}}};
    m.description.regions.members = {{}, {0}, {0, 1}};
    if (quadratic) {
        m.mid_nodes = straight_mid_nodes(m.mesh);
        for (std::size_t i = 0; i < m.mid_nodes.points.size(); ++i)
            m.mid_nodes.points[i].z += 0.01 * std::sin(double(i));
    }
    for (std::size_t c = 0; grey && c < m.mesh.cells.size(); ++c)
        m.grey.push_back(1000 * std::sin(double(c)));
    if (material) {
        m.description.materials = {{12000.5, 0.3, 1.8e-9}, {1.0 / 3, 0.49, 0}};
        for (std::size_t c = 0; c < m.mesh.cells.size(); ++c) m.material.push_back(c % 3 == 0 ? 1 : 0);
    }
    return m;
}

void expect_same(const ModelFile& a, const ModelFile& b, const std::string& what) {
    EXPECT_EQ(a.mesh.points, b.mesh.points) << what;
    EXPECT_EQ(a.mesh.cells, b.mesh.cells) << what;
    EXPECT_EQ(a.mesh.regions, b.mesh.regions) << what;
    EXPECT_EQ(a.mid_nodes, b.mid_nodes) << what;
    EXPECT_EQ(a.material, b.material) << what;
    EXPECT_EQ(a.description.materials, b.description.materials) << what;
}

Result<ModelFile> parsed(const std::string& extension, const std::string& bytes, RunContext& context) {
    return extension == ".vtu"   ? parse_vtu("m", bytes_of(bytes), {}, context)
           : extension == ".msh" ? parse_gmsh("m", bytes_of(bytes), context)
                                 : parse_abaqus("m", bytes_of(bytes), context);
}

TEST(QuadraticFiles, come_back_to_the_last_bit_and_to_the_same_bytes) {
    for (const std::string& extension : read_back) {
        for (int parts = 0; parts < 8; ++parts) {
            const bool grey = (parts & 2) != 0, holds_grey = extension != ".inp";
            const ModelFile m = model(4, (parts & 1) != 0, grey, (parts & 4) != 0);
            RunContext context;
            const std::string bytes = format_model("m" + extension, m, context).value();
            EXPECT_EQ(context.warnings.size(), grey && !holds_grey && parts < 4 ? 1u : 0u)
                << extension << parts;
            context.warnings.clear();
            const auto back = parsed(extension, bytes, context);
            ASSERT_TRUE(back.ok()) << extension << parts << to_line(back.error());
            expect_same(back.value(), m, extension + std::to_string(parts));
            EXPECT_EQ(back.value().grey, holds_grey ? m.grey : std::vector<double>{}) << extension;
            EXPECT_TRUE(context.warnings.empty());
            EXPECT_TRUE(format_model("m" + extension, back.value(), context).value() == bytes)
                << extension << parts;
        }
    }
}

TEST(QuadraticFiles, values_at_points_come_back_and_are_the_mean_on_edges) {
    for (const bool quadratic : {false, true}) {
        ModelFile m = model(4, quadratic, false, false);
        PointArray& array = m.arrays.emplace_back(PointArray{"height", {}});
        for (const Vec3& p : m.mesh.points) array.values.push_back(static_cast<float>(p.x + 2 * p.y));
        RunContext context;
        const std::string bytes = format_model("m.vtu", m, context).value();
        const auto back = parse_vtu("m.vtu", bytes_of(bytes), {}, context);
        ASSERT_TRUE(back.ok()) << to_line(back.error());
        expect_same(back.value(), m, "m.vtu");
        ASSERT_EQ(back.value().arrays.size(), 1u);
        EXPECT_EQ(back.value().arrays[0].name, "height");
        EXPECT_EQ(back.value().arrays[0].values, array.values);
        EXPECT_TRUE(format_model("m.vtu", back.value(), context).value() == bytes);
        EXPECT_TRUE(context.warnings.empty());

        const VtkFile file = parse_vtk_xml(bytes_of(bytes), "m.vtu", {}).value();
        const std::vector<double> written = file.point_data.at(0).to_doubles();
        ASSERT_EQ(written.size(), m.mesh.points.size() + m.mid_nodes.points.size());
        // A linear function is its own mean; nodes on edges were moved along z only.
        for (std::size_t n = 0; n < written.size(); ++n)
            EXPECT_NEAR(written[n], file.points[n].x + 2 * file.points[n].y, 1e-4) << n;
    }
}

TEST(QuadraticFiles, formats_without_values_at_points_say_so) {
    ModelFile m = model(3, false, false, false);
    m.arrays = {{"height", std::vector<float>(m.mesh.points.size(), 1)}};
    for (const char* name : {"m.msh", "m.mesh", "m.inp"}) {
        RunContext context;
        ASSERT_TRUE(format_model(name, m, context).ok());
        ASSERT_EQ(context.warnings.size(), 1u) << name;
        EXPECT_EQ(context.warnings[0].code, "W-MDL-008") << name;
    }
}

TEST(QuadraticFiles, medit_holds_linear_elements_only) {
    RunContext context;
    const auto refused = format_model("m.mesh", model(3, true, false, false), context);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "E-MDL-014");
    EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    ASSERT_TRUE(format_model("m.mesh", model(3, false, true, true), context).ok());
    ASSERT_EQ(context.warnings.size(), 2u);
    EXPECT_EQ(context.warnings[0].code, "W-MDL-006");
}

TEST(QuadraticFiles, febio_needs_materials) {
    RunContext context;
    const std::string with = format_model("m.feb", model(3, true, true, true), context).value();
    EXPECT_TRUE(context.warnings.empty());
    EXPECT_NE(with.find("<Elements type=\"tet10\" name=\"REGION_1_MATERIAL_1\">"), std::string::npos);
    EXPECT_NE(with.find("<ElementData type=\"scalar\" name=\"grey\" elem_set=\"ALL_ELEMENTS\">"),
              std::string::npos);
    const std::string without = format_model("m.feb", model(3, false, false, false), context).value();
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-MDL-007");
    EXPECT_NE(without.find("<SolidDomain name=\"REGION_2\" mat=\"REGION_2\"/>"), std::string::npos);
}

TEST(QuadraticFiles, numbers_in_abaqus_have_no_exponent_that_could_be_cut_off) {
    RunContext context;
    ModelFile m = model(3, false, false, false);
    m.mesh.points[1].y = -1.2246467991473533e-15;
    const std::string text = format_model("m.inp", m, context).value();
    EXPECT_NE(text.find("\n1, 0.0000123456789, "), std::string::npos);
    EXPECT_NE(text.find(", -0.0000000000000012246467991473533, "), std::string::npos);
    const auto back = parsed(".inp", text, context);
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back.value().mesh.points, m.mesh.points);
}

TEST(QuadraticFiles, facets_have_their_own_mid_nodes) {
    const ModelFile m = model(3, true, false, false);
    const auto facets = interface_facets(m.mesh);
    ASSERT_FALSE(facets.empty());
    for (const InterfaceFacet& facet : facets) {
        for (const std::uint64_t id : {facet.facet, facet.other}) {
            if (id == no_facet) continue;
            const auto nodes = nodes_of_facet(m, id);
            ASSERT_EQ(nodes.size(), 6u);
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 a = m.mesh.points[nodes[k]], b = m.mesh.points[nodes[(k + 1) % 3]];
                const Vec3 node = m.mid_nodes.points[nodes[3 + k] - m.mesh.points.size()];
                EXPECT_LT(length(node - 0.5 * (a + b)), 0.011);
            }
        }
    }
    const auto inside = structure_facets(facets, m.description.regions, 1);
    EXPECT_EQ(inside.size(), 12u);  // the middle cube: 12 triangles
    EXPECT_EQ(facet_nodes(m, inside).size(), 8u + 18u);
    for (const std::uint64_t id : inside) EXPECT_EQ(m.mesh.regions[id / 4], 2);
}

TEST(QuadraticFiles, bad_ones_are_refused) {
    RunContext context;
    const std::string nodes =
        "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n5, .5, 0, 0\n6, .5, .5, 0\n7, 0, .5, 0\n8, "
        "0, 0, .5\n"
        "9, .5, 0, .5\n10, 0, .5, .5\n11, 1, 1, 1\n";
    const std::string element = "*ELEMENT, TYPE=C3D10\n1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10\n";
    const auto code = [&](const std::string& text) {
        const auto read = parse_abaqus("m", bytes_of(text), context);
        return read.ok() ? "ok" : read.error().code;
    };
    EXPECT_EQ(code(nodes + element), "ok");
    EXPECT_EQ(code(nodes + "*ELEMENT, TYPE=C3D10\n1, 1, 2, 3, 4, 5, 6,\n7, 8, 9, 10\n"), "ok");
    EXPECT_EQ(code(nodes + element + "*ELEMENT, TYPE=C3D4\n2, 2, 3, 4, 11\n"), "E-MDL-006");
    EXPECT_EQ(code(nodes + element + "2, 2, 3, 5, 11, 5, 6, 7, 8, 9, 10\n"), "E-MDL-015");
    EXPECT_EQ(code(nodes + element + "2, 2, 3, 4, 11, 6, 10, 9, 8, 12, 10\n"), "E-MDL-004");
}

TEST(QuadraticFiles, damaged_ones_never_crash) {
    RunContext context;
    const ModelFile m = model(3, true, true, true);
    for (const std::string& extension : read_back) {
        const std::string good = format_model("m" + extension, m, context).value();
        int refused = 0;
        for_each_damage(good, 1500, 11, [&](const std::string& bad) {
            RunContext own;
            const auto read = parsed(extension, bad, own);
            if (!read.ok()) {
                ++refused;
                return;
            }
            const ModelFile& back = read.value();
            for (const auto& mids : back.mid_nodes.cells) {
                for (const std::uint32_t n : mids) ASSERT_LT(n, back.mid_nodes.points.size());
            }
            for (const std::uint32_t n : back.material) ASSERT_LT(n, back.description.materials.size());
            ASSERT_TRUE(format_model("m" + extension, back, own).ok());
        });
        EXPECT_GT(refused, 100) << extension;
    }
}

std::string law_file(const std::string& laws) {
    return R"({"format": "anatomesh-material", "version": 1, "laws": )" + laws + "}";
}

struct MaterialFiles : ::testing::Test {
    fs::path folder;
    void SetUp() override {
        std::string name = (fs::temp_directory_path() / "material_XXXXXX").string();
        folder = ::mkdtemp(name.data());
    }
    void TearDown() override { fs::remove_all(folder); }
    Result<MaterialFile> read(const std::string& content) const {
        std::ofstream(folder / "m.json", std::ios::binary) << content;
        return read_material_file((folder / "m.json").string(), {});
    }
    std::string code(const std::string& content) const {
        const auto file = read(content);
        return file.ok() ? "ok" : file.error().code + " " + file.error().place.value;
    }
};

TEST_F(MaterialFiles, P05_are_read_strictly) {
    EXPECT_EQ(code(law_file(R"([{"young_mpa": 5}])")), "ok");
    EXPECT_EQ(code(law_file(R"([{"structure": 5, "table": [[0, 1], [10, 2.5]], "density_g_cm3": 1.1}])")),
              "ok");
    EXPECT_EQ(code(law_file(R"([{"structure": "bone", "density_of_grey": {"intercept": 0.1, "slope": 0.001},
        "young_of_density": {"factor": 6850, "exponent": 1.49}, "low_mpa": 1, "poisson": 0.35, "bins": 7}])")),
              "ok");
    EXPECT_EQ(code("{").substr(0, 9), "E-MAT-001");
    EXPECT_EQ(code("").substr(0, 9), "E-MAT-001");
    EXPECT_EQ(code("[1]").substr(0, 9), "E-MAT-001");
    EXPECT_EQ(code(R"({"format": "anatomesh-material", "version": 2, "laws": []})").substr(0, 9),
              "E-MAT-001");
    EXPECT_EQ(code(std::string(200000, '[')).substr(0, 9), "E-MAT-001");
    EXPECT_EQ(code(law_file("[]")), "E-MAT-002 file.laws");
    EXPECT_EQ(code(law_file(R"([{"table": [[5, -1]]}])")), "E-MAT-002 laws[0].table");
    EXPECT_EQ(code(law_file("[7]")), "E-MAT-002 laws[0]");
    EXPECT_EQ(code(law_file(R"([{"poisson": 0.3}])")), "E-MAT-002 laws[0]");
    EXPECT_EQ(code(law_file(R"([{"young_mpa": 5, "table": [[0, 1]]}])")), "E-MAT-002 laws[0]");
    EXPECT_EQ(code(law_file(R"([{"young_mpa": -5}])")), "E-MAT-002 laws[0].young_mpa");
    EXPECT_EQ(code(law_file(R"([{"young_mpa": 5, "poisson": 0.5}])")), "E-MAT-002 laws[0].poisson");
    EXPECT_EQ(code(law_file(R"([{"young_mpa": 5, "yuong": 3}])")), "E-MAT-002 laws[0].yuong");
    EXPECT_EQ(code(law_file(R"([{"table": [[5, 1], [5, 2]]}])")), "E-MAT-002 laws[0].table");
    EXPECT_EQ(code(law_file(R"([{"young_of_density": {"factor": 1}}])")),
              "E-MAT-002 laws[0].density_of_grey");
    EXPECT_EQ(code(law_file(R"([{"young_of_density": {"factor": 1, "exponant": 2},
        "density_of_grey": {"slope": 1}}])")),
              "E-MAT-002 laws[0].young_of_density.exponant");
}

TEST_F(MaterialFiles, are_applied_by_name_or_number_in_their_order) {
    ModelFile m = model(4, false, true, false);
    const auto file = read(law_file(
        R"([{"structure": "marrow", "young_mpa": 2}, {"structure": 9, "optional": true, "young_mpa": 3},
        {"structure": "5", "table": [[-1000, 100], [1000, 300]], "bins": 4}])"));
    ASSERT_TRUE(file.ok()) << to_line(file.error());
    ASSERT_TRUE(apply_materials(m, file.value()).ok());
    ASSERT_EQ(m.description.materials.size(), 5u);
    for (std::size_t c = 0; c < m.mesh.cells.size(); ++c) {
        const double young = m.description.materials[m.material[c]].young_mpa;
        EXPECT_NEAR(young, m.mesh.regions[c] == 2 ? 2 : 200 + 0.1 * m.grey[c],
                    m.mesh.regions[c] == 2 ? 0 : 50);
    }
    const std::vector<MaterialRange> ranges = material_ranges(m);
    ASSERT_EQ(ranges.size(), m.description.structures.size());
    for (std::uint32_t s = 0; s < 2; ++s) {
        EXPECT_EQ(ranges[s].structure, m.description.structures[s].name);
        std::set<std::uint32_t> materials;
        double volume = 0, low = 1e9, high = 0;
        for (std::size_t c = 0; c < m.mesh.cells.size(); ++c) {
            const auto& members = m.description.regions.members[m.mesh.regions[c]];
            if (std::find(members.begin(), members.end(), s) == members.end()) continue;
            const Cell& cell = m.mesh.cells[c];
            volume += std::abs(signed_volume(m.mesh.points[cell[0]], m.mesh.points[cell[1]],
                                             m.mesh.points[cell[2]], m.mesh.points[cell[3]]));
            materials.insert(m.material[c]);
            low = std::min(low, m.description.materials[m.material[c]].young_mpa);
            high = std::max(high, m.description.materials[m.material[c]].young_mpa);
        }
        EXPECT_EQ(ranges[s].materials, materials.size());
        EXPECT_NEAR(ranges[s].volume_mm3, volume, 1e-9 * volume);
        EXPECT_EQ(ranges[s].young_low_mpa, low);
        EXPECT_EQ(ranges[s].young_high_mpa, high);
    }

    const auto one = read(law_file(R"([{"structure": "marrow", "young_mpa": 2}])"));
    const auto refused = apply_materials(m, one.value());
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "E-MAT-003");
    EXPECT_EQ(refused.error().place.structure, "bone");
}

// Passed over, such a law leaves its structure to the next one: a skull of 1 MPa.
TEST_F(MaterialFiles, a_law_that_names_nothing_is_refused) {
    for (const char* wrong : {"\"bones\"", "\"Bone\"", "\"bone \"", "8", "\"05\"", "-5"}) {
        ModelFile m = model(4, false, true, false);
        const std::string law = std::string(R"({"structure": )") + wrong + R"(, "young_mpa": 3})";
        const auto file = read(law_file("[" + law + R"(, {"young_mpa": 1}])"));
        ASSERT_TRUE(file.ok()) << wrong << to_line(file.error());
        const auto refused = apply_materials(m, file.value());
        ASSERT_FALSE(refused.ok()) << wrong;
        EXPECT_EQ(refused.error().code, "E-MAT-004");
        EXPECT_NE(refused.error().message.find("bone"), std::string::npos) << "it names what there is";
        EXPECT_TRUE(m.material.empty());
    }
    ModelFile m = model(4, false, true, false);
    const auto file = read(law_file(R"([{"structure": "liver", "young_mpa": 3}, {"young_mpa": 1}])"));
    const std::vector<Structure> of_run{{1, "liver", {}}, {2, "bone", {}}};
    EXPECT_TRUE(apply_materials(m, file.value(), of_run).ok()) << "another model of the run has it";
    EXPECT_EQ(code(law_file(R"([{"young_mpa": 5, "optional": 1}])")), "E-MAT-002 laws[0].optional");
}

// Writes a model with everything in every format that holds it into $ANATOMESH_FORMATS_DIR, for
// tests/formats/elements_test.py.
TEST(QuadraticFiles, O02_writes_samples_for_foreign_readers) {
    const char* folder = std::getenv("ANATOMESH_FORMATS_DIR");
    if (!folder) GTEST_SKIP() << "ANATOMESH_FORMATS_DIR is not set";
    fs::create_directories(folder);
    RunContext context;
    const ModelFile m = model(5, true, true, true);
    for (const char* extension : {".vtu", ".msh", ".inp", ".feb"}) {
        ASSERT_TRUE(
            write_model((fs::path(folder) / (std::string("quadratic") + extension)).string(), m, context)
                .ok());
    }
    // All in one region: meshio wants views in the order of the elements' tags.
    ModelFile one = m;
    for (Region& region : one.mesh.regions) region = 1;
    ASSERT_TRUE(write_model((fs::path(folder) / "one_region.msh").string(), one, context).ok());
    std::ofstream truth(fs::path(folder) / "quadratic.txt");
    truth << std::hexfloat << m.mesh.points.size() << ' ' << m.mid_nodes.points.size() << ' '
          << m.mesh.cells.size() << '\n';
    for (const Vec3& p : m.mesh.points) truth << p.x << ' ' << p.y << ' ' << p.z << '\n';
    for (const Vec3& p : m.mid_nodes.points) truth << p.x << ' ' << p.y << ' ' << p.z << '\n';
    for (std::size_t c = 0; c < m.mesh.cells.size(); ++c) {
        for (const std::uint32_t v : m.mesh.cells[c]) truth << v << ' ';
        for (const std::uint32_t v : m.mid_nodes.cells[c]) truth << v << ' ';
        truth << m.mesh.regions[c] << ' ' << m.material[c] + 1 << ' ' << m.grey[c] << '\n';
    }
}

}  // namespace
}  // namespace anatomesh::quadratic_files_test
