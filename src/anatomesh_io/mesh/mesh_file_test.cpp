#include "anatomesh_io/mesh/mesh_file.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mutate_for_test.h"
#include "anatomesh_io/mesh/vtk_xml.h"

namespace anatomesh::mesh_file_test {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> model_extensions{".vtu", ".msh", ".mesh", ".inp"};
const std::vector<std::string> surface_extensions{".vtp", ".stl", ".ply", ".obj"};

MeshDescription description() {
    MeshDescription d;
    d.structures = {
        {5, "Liver", {255, 0, 0}}, {7, "GTV \"1\" <\\n>\n2", {0, 128, 255}}, {300, "", {1, 2, 3}}};
    d.regions.members = {{}, {0}, {0, 1}, {2}};
    d.notes = {
        {"version", "0.1.0"}, {"warning", "W-RTS-006 a.dcm: it's \xC3\xA9t\xC3\xA9"}, {"warning", "second"}};
    return d;
}

// n^3 boxes of six tetrahedra each (Kuhn), labelled by layers; coordinates that no short decimal hits.
ModelFile model(std::uint32_t n) {
    ModelFile m;
    m.description = description();
    const auto vertex = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
        return (k * (n + 1) + j) * (n + 1) + i;
    };
    for (std::uint32_t k = 0; k <= n; ++k) {
        for (std::uint32_t j = 0; j <= n; ++j) {
            for (std::uint32_t i = 0; i <= n; ++i) {
                m.mesh.points.push_back({i / 3.0 - 100 + 0.05 * std::sin(7.0 * i + k), j * 0.7 + 1e-9 * i,
                                         k * M_PI + 0.05 * std::cos(5.0 * j)});
            }
        }
    }
    constexpr int paths[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (std::uint32_t k = 0; k < n; ++k) {
        for (std::uint32_t j = 0; j < n; ++j) {
            for (std::uint32_t i = 0; i < n; ++i) {
                for (const auto& path : paths) {
                    std::uint32_t at[3] = {i, j, k};
                    Cell cell{vertex(i, j, k), 0, 0, 0};
                    for (std::size_t s = 0; s < 3; ++s) {
                        ++at[path[s]];
                        cell[s + 1] = vertex(at[0], at[1], at[2]);
                    }
                    const auto& p = m.mesh.points;
                    if (signed_volume(p[cell[0]], p[cell[1]], p[cell[2]], p[cell[3]]) < 0)
                        std::swap(cell[2], cell[3]);
                    m.mesh.cells.push_back(cell);
                    m.mesh.regions.push_back(static_cast<Region>((i + k) % 3 + 1));
                }
            }
        }
    }
    return m;
}

SurfaceFile surface(std::uint32_t n) {
    const ModelFile m = model(n);
    return {extract_interfaces(m.mesh), m.description};
}

void expect_same(const MeshDescription& a, const MeshDescription& b) {
    EXPECT_EQ(a.space, b.space);
    EXPECT_EQ(a.unit, b.unit);
    EXPECT_EQ(a.notes, b.notes);
    EXPECT_EQ(a.regions.members, b.regions.members);
    ASSERT_EQ(a.structures.size(), b.structures.size());
    for (std::size_t s = 0; s < a.structures.size(); ++s) {
        EXPECT_EQ(a.structures[s].number, b.structures[s].number);
        EXPECT_EQ(a.structures[s].name, b.structures[s].name);
        EXPECT_EQ(a.structures[s].color, b.structures[s].color);
    }
}

struct Folder {
    fs::path path;
    Folder() {
        std::string name = (fs::temp_directory_path() / "mesh_file_XXXXXX").string();
        path = ::mkdtemp(name.data());
    }
    ~Folder() { fs::remove_all(path); }
    std::string file(const std::string& name) const { return (path / name).string(); }
    std::string put(const std::string& name, const std::string& content) const {
        std::ofstream(path / name, std::ios::binary) << content;
        return file(name);
    }
};

TEST(MeshFile, O01_models_come_back_to_the_last_bit) {
    const Folder folder;
    const ModelFile m = model(4);
    for (const std::string& extension : model_extensions) {
        RunContext context;
        const std::string path = folder.file("m" + extension);
        const Status written = write_model(path, m, context);
        ASSERT_TRUE(written.ok()) << to_line(written.error());
        const auto read = read_model(path, context);
        ASSERT_TRUE(read.ok()) << extension << to_line(read.error());
        EXPECT_EQ(read.value().mesh.points, m.mesh.points) << extension;
        EXPECT_EQ(read.value().mesh.cells, m.mesh.cells) << extension;
        EXPECT_EQ(read.value().mesh.regions, m.mesh.regions) << extension;
        expect_same(read.value().description, m.description);
        EXPECT_TRUE(context.warnings.empty()) << extension;
    }
}

TEST(MeshFile, O01_write_read_write_gives_the_same_bytes) {
    const Folder folder;
    RunContext context;
    for (const std::string& extension : model_extensions) {
        const std::string path = folder.file("m" + extension);
        const auto first = format_model(path, model(3), context);
        ASSERT_TRUE(first.ok());
        folder.put("m" + extension, first.value());
        const auto read = read_model(path, context);
        ASSERT_TRUE(read.ok()) << to_line(read.error());
        EXPECT_TRUE(format_model(path, read.value(), context).value() == first.value()) << extension;
    }
    for (const std::string& extension : surface_extensions) {
        const std::string path = folder.file("s" + extension);
        const auto first = format_surface(path, surface(3), context);
        ASSERT_TRUE(first.ok());
        folder.put("s" + extension, first.value());
        const auto read = read_surface(path, context);
        ASSERT_TRUE(read.ok()) << to_line(read.error());
        EXPECT_TRUE(format_surface(path, read.value(), context).value() == first.value()) << extension;
    }
}

TEST(MeshFile, O01_surfaces_come_back_to_the_last_bit) {
    const Folder folder;
    const SurfaceFile s = surface(4);
    for (const std::string extension : {".vtp", ".ply", ".obj"}) {
        RunContext context;
        ASSERT_TRUE(write_surface(folder.file("s" + extension), s, context).ok());
        const auto read = read_surface(folder.file("s" + extension), context);
        ASSERT_TRUE(read.ok()) << to_line(read.error());
        EXPECT_EQ(read.value().surface.points, s.surface.points) << extension;
        EXPECT_EQ(read.value().surface.triangles, s.surface.triangles) << extension;
        EXPECT_EQ(read.value().surface.sides, s.surface.sides) << extension;
        expect_same(read.value().description, s.description);
        EXPECT_TRUE(context.warnings.empty());
    }
    RunContext context;
    ASSERT_TRUE(write_surface(folder.file("s.stl"), s, context).ok());
    const auto read = read_surface(folder.file("s.stl"), context);
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_TRUE(context.warnings.empty());
    EXPECT_EQ(read.value().description.space, "LPS");
    const SurfaceMesh& mesh = read.value().surface;
    ASSERT_EQ(mesh.triangles.size(), s.surface.triangles.size());
    EXPECT_EQ(mesh.points.size(), s.surface.points.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 there = mesh.points[mesh.triangles[t][k]],
                       here = s.surface.points[s.surface.triangles[t][k]];
            ASSERT_EQ(there.x, static_cast<float>(here.x));
            ASSERT_EQ(there.z, static_cast<float>(here.z));
        }
    }
}

TEST(MeshFile, surface_without_regions) {
    const Folder folder;
    SurfaceFile s = surface(2);
    s.surface.sides.clear();
    for (const std::string& extension : surface_extensions) {
        RunContext context;
        ASSERT_TRUE(write_surface(folder.file("s" + extension), s, context).ok());
        const auto read = read_surface(folder.file("s" + extension), context);
        ASSERT_TRUE(read.ok()) << to_line(read.error());
        EXPECT_EQ(read.value().surface.triangles.size(), s.surface.triangles.size());
        EXPECT_TRUE(read.value().surface.sides.empty());
    }
}

TEST(MeshFile, cells_outside_of_an_early_stage) {
    const Folder folder;
    ModelFile m = model(2);
    for (std::size_t c = 0; c < m.mesh.regions.size(); c += 5) m.mesh.regions[c] = 0;
    for (const std::string& extension : model_extensions) {
        RunContext context;
        ASSERT_TRUE(write_model(folder.file("m" + extension), m, context).ok());
        const auto read = read_model(folder.file("m" + extension), context);
        ASSERT_TRUE(read.ok()) << to_line(read.error());
        EXPECT_EQ(read.value().mesh.regions, m.mesh.regions) << extension;
    }
}

TEST(MeshFile, region_numbers_are_the_structures_own_or_above_all) {
    MeshDescription d = description();
    EXPECT_EQ(region_numbers(d), (std::vector<std::int32_t>{0, 5, 301, 300}));
    d.structures[2].number = std::numeric_limits<std::int32_t>::max();
    EXPECT_EQ(region_numbers(d),
              (std::vector<std::int32_t>{0, 5, 1, std::numeric_limits<std::int32_t>::max()}));
    d.structures[0].number = -4;
    d.structures[1].number = 0;
    d.structures[2].number = -9;
    EXPECT_EQ(region_numbers(d), (std::vector<std::int32_t>{0, -4, 1, -9}));
}

TEST(MeshFile, numbers_below_one_come_back_from_every_format) {
    const Folder folder;
    ModelFile m = model(2);
    m.description.structures[0].number = -3;
    for (const std::string& extension : model_extensions) {
        RunContext context;
        ASSERT_TRUE(write_model(folder.file("m" + extension), m, context).ok());
        const auto read = read_model(folder.file("m" + extension), context);
        ASSERT_TRUE(read.ok()) << to_line(read.error());
        EXPECT_EQ(read.value().mesh.regions, m.mesh.regions) << extension;
        EXPECT_EQ(context.warnings.size(), extension == ".msh" ? 1u : 0u);
        if (extension == ".msh") {
            EXPECT_EQ(context.warnings[0].code, "W-MDL-003");
        }
    }
}

TEST(MeshFile, vtu_holds_structure_and_quality) {
    RunContext context;
    const ModelFile m = model(2);
    const auto bytes = format_model("m.vtu", m, context);
    const auto file = parse_vtk_xml(bytes_of(bytes.value()), "m.vtu");
    ASSERT_TRUE(file.ok());
    const VtkArray* structure = file.value().cell_array("structure");
    const VtkArray* quality = file.value().cell_array("quality");
    ASSERT_TRUE(structure && quality);
    EXPECT_EQ(structure->type, VtkType::int32);
    EXPECT_EQ(quality->type, VtkType::float64);
    const std::vector<std::int64_t> numbers = structure->to_integers();
    EXPECT_EQ(std::set<std::int64_t>(numbers.begin(), numbers.end()), (std::set<std::int64_t>{5, 300, 301}));
    for (std::size_t c = 0; c < m.mesh.cells.size(); ++c) {
        const Cell& cell = m.mesh.cells[c];
        const auto& p = m.mesh.points;
        ASSERT_EQ(quality->to_doubles()[c],
                  radius_edge_ratio(p[cell[0]], p[cell[1]], p[cell[2]], p[cell[3]]));
    }
    EXPECT_EQ(file.value().field("SPACE")->to_strings(), std::vector<std::string>{"LPS"});
    EXPECT_EQ(file.value().field("UNIT")->to_strings(), std::vector<std::string>{"mm"});
}

TEST(MeshFile, abaqus_surfaces_face_out_of_their_cells) {
    RunContext context;
    const ModelFile m = model(2);
    const std::string text = format_model("m.inp", m, context).value();
    // Faces by the manual: node numbers 1 to 4 of the element.
    const std::map<std::string, std::array<int, 3>> faces{
        {"S1", {0, 1, 2}}, {"S2", {0, 3, 1}}, {"S3", {1, 3, 2}}, {"S4", {2, 3, 0}}};
    std::istringstream in(text);
    std::string line;
    bool in_surface = false;
    std::map<std::array<std::uint32_t, 3>, int> seen;
    while (std::getline(in, line)) {
        if (line[0] == '*') {
            in_surface = line.starts_with("*SURFACE") && line.find("NAME=INTERFACE") != std::string::npos;
            continue;
        }
        if (!in_surface) continue;
        const std::size_t comma = line.find(',');
        const Cell& cell = m.mesh.cells[std::stoul(line.substr(0, comma)) - 1];
        std::array<std::uint32_t, 3> face{};
        for (std::size_t k = 0; k < 3; ++k)
            face[k] = cell[static_cast<std::size_t>(faces.at(line.substr(comma + 2))[k])];
        std::sort(face.begin(), face.end());
        ++seen[face];
    }
    const SurfaceMesh expected = extract_interfaces(m.mesh);
    EXPECT_EQ(seen.size(), expected.triangles.size());
    // extract_interfaces renumbers the points it uses, in their order.
    std::map<Vec3, std::uint32_t, bool (*)(Vec3, Vec3)> vertex(&lexicographic_less);
    for (std::uint32_t i = 0; i < m.mesh.points.size(); ++i) vertex[m.mesh.points[i]] = i;
    for (const Triangle& triangle : expected.triangles) {
        std::array<std::uint32_t, 3> face{};
        for (std::size_t k = 0; k < 3; ++k) face[k] = vertex.at(expected.points[triangle[k]]);
        std::sort(face.begin(), face.end());
        EXPECT_EQ(seen[face], 1);
    }
}

TEST(MeshFile, O04_more_than_a_format_can_number_is_refused) {
    constexpr std::uint64_t most = 0x7FFFFFFF;
    for (const auto format :
         {ModelFormat::gmsh, ModelFormat::medit, ModelFormat::abaqus, ModelFormat::febio}) {
        EXPECT_TRUE(check_numbers(format, most, most, "m").ok());
        for (const std::uint64_t beyond : {most + 1, std::uint64_t{1} << 32, ~std::uint64_t{0}}) {
            EXPECT_FALSE(check_numbers(format, beyond, 1, "m").ok());
            const Status status = check_numbers(format, 1, beyond, "m");
            ASSERT_FALSE(status.ok());
            EXPECT_EQ(status.error().code, "E-MDL-013");
            EXPECT_EQ(status.error().kind, ErrorKind::limit);
        }
    }
    for (const auto format : {SurfaceFormat::ply, SurfaceFormat::obj}) {
        EXPECT_TRUE(check_numbers(format, most, most, "s").ok());
        EXPECT_FALSE(check_numbers(format, most + 1, 1, "s").ok());
        EXPECT_FALSE(check_numbers(format, 1, most + 1, "s").ok());
    }
    EXPECT_TRUE(check_numbers(SurfaceFormat::stl, 2 * most, 2 * most + 1, "s").ok());
    EXPECT_FALSE(check_numbers(SurfaceFormat::stl, 1, 2 * most + 2, "s").ok());
    EXPECT_TRUE(check_numbers(ModelFormat::vtu, 4 * most, 4 * most, "m").ok());
    EXPECT_TRUE(check_numbers(SurfaceFormat::vtp, 4 * most, 4 * most, "s").ok());
}

TEST(MeshFile, O03_stl_says_how_much_precision_is_lost) {
    SurfaceFile s = surface(1);
    for (Vec3& point : s.surface.points) point.x += 1e6;
    RunContext context;
    ASSERT_TRUE(format_surface("s.stl", s, context).ok());
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-MDL-004");
    const double loss = std::strtod(context.warnings[0].place.value.c_str(), nullptr);
    EXPECT_GT(loss, 1e-3);
    EXPECT_LE(loss, 0.03125);
    RunContext exact;
    ASSERT_TRUE(format_surface("s.ply", s, exact).ok());
    EXPECT_TRUE(exact.warnings.empty());
}

TEST(MeshFile, same_bytes_for_any_number_of_threads) {
    const ModelFile m = model(12);
    for (const std::string& extension : model_extensions) {
        RunContext one, two;
        two.threads = 2;
        EXPECT_TRUE(format_model("m" + extension, m, one).value() ==
                    format_model("m" + extension, m, two).value());
    }
}

std::string model_code(const Folder& folder, const std::string& content) {
    RunContext context;
    const auto read = read_model(folder.put("bad", content), context);
    if (read.ok()) return "ok";
    EXPECT_EQ(read.error().place.file, folder.file("bad"));
    return read.error().code;
}
std::string surface_code(const Folder& folder, const std::string& content) {
    RunContext context;
    const auto read = read_surface(folder.put("bad", content), context);
    if (read.ok()) return "ok";
    EXPECT_EQ(read.error().place.file, folder.file("bad"));
    return read.error().code;
}

TEST(MeshFile, unknown_extension_is_a_usage_error) {
    RunContext context;
    for (const std::string path : {"a.vtx", "a", "a.b/c", ".vtk", "a.stl"}) {
        const auto written = format_model(path, model(1), context);
        ASSERT_FALSE(written.ok());
        EXPECT_EQ(written.error().code, "E-MDL-001");
        EXPECT_EQ(written.error().kind, ErrorKind::usage);
    }
    EXPECT_TRUE(format_model("A.MSH", model(1), context).ok());
}

TEST(MeshFile, other_content_is_refused_by_its_kind) {
    const Folder folder;
    RunContext context;
    EXPECT_EQ(model_code(folder, ""), "E-MDL-002");
    EXPECT_EQ(model_code(folder, "hello"), "E-MDL-002");
    EXPECT_EQ(model_code(folder, format_surface("s.ply", surface(1), context).value()), "E-MDL-002");
    EXPECT_EQ(surface_code(folder, format_model("m.vtu", model(1), context).value()), "E-MDL-002");
    EXPECT_EQ(read_model(folder.file("none"), context).error().kind, ErrorKind::file);
}

TEST(MeshFile, bad_medit_files) {
    const Folder folder;
    const std::string head =
        "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n";
    EXPECT_EQ(model_code(folder, head + "Tetrahedra\n1\n1 2 3 4 9\nEnd\n"), "ok");
    EXPECT_EQ(model_code(folder, head + "Tetrahedra\n1\n1 2 3 5 9\nEnd\n"), "E-MDL-004");
    EXPECT_EQ(model_code(folder, head + "Tetrahedra\n1\n0 2 3 4 9\nEnd\n"), "E-MDL-004");
    EXPECT_EQ(model_code(folder, head + "Tetrahedra\n1\n1 2 3 4\nEnd\n"), "E-MDL-003");
    EXPECT_EQ(model_code(folder, head + "Tetrahedra\n900000000\n1 2 3 4 9\nEnd\n"), "E-MDL-007");
    EXPECT_EQ(model_code(folder, head + "Tetrahedra\n18446744073709551615\n1 2 3 4 9\nEnd\n"), "E-MDL-007");
    EXPECT_EQ(model_code(folder, head + "Hexahedra\n1\n1 2 3 4 1 2 3 4 9\nEnd\n"), "E-MDL-006");
    EXPECT_EQ(model_code(folder, head + "End\n"), "E-MDL-008");
    EXPECT_EQ(model_code(folder, "MeshVersionFormatted 2\nDimension 2\n"), "E-MDL-012");
    EXPECT_EQ(model_code(folder, "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 nan 0 0\n"),
              "E-MDL-005");
    EXPECT_EQ(model_code(folder, "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 1e8 0 0\n"),
              "E-MDL-005");
    EXPECT_EQ(model_code(folder, "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 0,5 0 0\n"),
              "E-MDL-003");
}

TEST(MeshFile, bad_gmsh_files) {
    const Folder folder;
    const std::string head = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    const std::string nodes = "$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n";
    EXPECT_EQ(model_code(folder, head + nodes + "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n"),
              "ok");
    EXPECT_EQ(model_code(folder, head + nodes + "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 5\n$EndElements\n"),
              "E-MDL-004");
    EXPECT_EQ(model_code(folder,
                         head + nodes + "$Elements\n1 2 1 2\n3 1 4 2\n1 1 2 3 4\n1 1 2 3 4\n$EndElements\n"),
              "E-MDL-009");
    EXPECT_EQ(
        model_code(folder, head + nodes + "$Elements\n1 1 1 1\n3 1 5 1\n1 1 2 3 4 1 2 3 4\n$EndElements\n"),
        "E-MDL-006");
    EXPECT_EQ(model_code(folder, head + nodes + "$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n$EndElements\n"),
              "E-MDL-008");
    EXPECT_EQ(
        model_code(folder, head + nodes + "$Elements\n1 99999999999 1 1\n3 1 4 99999999999\n1 1 2 3 4\n"),
        "E-MDL-007");
    EXPECT_EQ(model_code(folder, head + nodes + "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3"), "E-MDL-003");
    EXPECT_EQ(model_code(folder, head + "$Other\n"), "E-MDL-003");
    EXPECT_EQ(model_code(folder, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"), "E-MDL-012");
}

TEST(MeshFile, bad_abaqus_files) {
    const Folder folder;
    const std::string nodes = "*HEADING\nx\n*NODE\n10, 0, 0, 0\n20, 1, 0, 0\n30, 0, 1, 0\n40, 0, 0, 1\n";
    EXPECT_EQ(model_code(folder, nodes + "*Element, type=C3D4, elset=Bone\n7, 10, 20, 30, 40\n"), "ok");
    EXPECT_EQ(model_code(folder, nodes + "*ELEMENT, TYPE=C3D4\n7, 10, 20, 30, 50\n"), "E-MDL-004");
    EXPECT_EQ(model_code(folder, nodes + "*ELEMENT, TYPE=C3D4\n7, 10, 20, 30\n"), "E-MDL-003");
    EXPECT_EQ(model_code(folder, nodes + "*ELEMENT, TYPE=C3D4\n7, 10, 20, 30, 40\n7, 10, 20, 30, 40\n"),
              "E-MDL-009");
    EXPECT_EQ(model_code(folder, nodes + "20, 1, 1, 1\n*ELEMENT, TYPE=C3D4\n7, 10, 20, 30, 40\n"),
              "E-MDL-009");
    EXPECT_EQ(model_code(folder, nodes + "*ELEMENT, TYPE=C3D8\n7, 10, 20, 30, 40\n"), "E-MDL-006");
    EXPECT_EQ(model_code(folder, nodes + "*ELEMENT, TYPE=C3D10\n7, 10, 20, 30, 40\n"), "E-MDL-003");
    EXPECT_EQ(model_code(folder, nodes + "*ELEMENT, TYPE=C3D4\n7, 10, 20,\n30, 40\n"), "ok");
    EXPECT_EQ(model_code(folder, nodes + "*ELEMENT, TYPE=C3D4\n7, 10, 20, 30\n8, 10, 20, 30, 40\n"),
              "E-MDL-003");
    EXPECT_EQ(model_code(folder, nodes), "E-MDL-008");
    EXPECT_EQ(model_code(folder, "*HEADING\nx\n*NODE\n1, inf, 0, 0\n"), "E-MDL-005");
}

TEST(MeshFile, foreign_labels_become_structures) {
    const Folder folder;
    RunContext context;
    const std::string path = folder.put(
        "m",
        "MeshVersionFormatted 1\nDimension\n3\nVertices\n5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 0\n"
        "Triangles\n1\n1 2 3 5\nTetrahedra\n2\n1 2 3 4 9\n2 3 4 5 -2\nEnd\n");
    const auto read = read_model(path, context);
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_EQ(read.value().mesh.regions, (std::vector<Region>{2, 1}));
    ASSERT_EQ(read.value().description.structures.size(), 2u);
    EXPECT_EQ(read.value().description.structures[0].number, -2);
    EXPECT_EQ(read.value().description.structures[1].number, 9);
    EXPECT_EQ(read.value().description.space, "unknown");
    ASSERT_EQ(context.warnings.size(), 2u);
    EXPECT_EQ(context.warnings[0].code, "W-MDL-002");
    EXPECT_EQ(context.warnings[1].code, "W-MDL-001");
}

TEST(MeshFile, bad_tables_of_regions_are_refused) {
    const Folder folder;
    RunContext context;
    const std::string good = format_model("m.mesh", model(1), context).value();
    ASSERT_EQ(model_code(folder, good), "ok");
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return text.replace(at, from.size(), to);
    };
    EXPECT_EQ(model_code(folder, with("REGION 2 = 5 7", "REGION 2 = 5 8")), "E-MDL-011");
    EXPECT_EQ(model_code(folder, with("REGION 2 = 5 7", "REGION 9 = 5 7")), "E-MDL-011");
    EXPECT_EQ(model_code(folder, with("STRUCTURE 7 0", "STRUCTURE 5 0")), "E-MDL-011");
    EXPECT_EQ(model_code(folder, with("STRUCTURE 7 0", "STRUCTURE 7 -1")), "E-MDL-011");
    EXPECT_EQ(model_code(folder, with("STRUCTURE 300", "STRUCTURE 299")), "E-MDL-011");
}

TEST(MeshFile, arrays_that_contradict_each_other_are_refused) {
    const Folder folder;
    RunContext context;
    const auto with_other_structure = [&](const std::string& name, const std::string& bytes) {
        VtkFile file = parse_vtk_xml(bytes_of(bytes), name).value();
        for (VtkArray& array : file.cell_data) {
            if (array.name != "structure") continue;
            std::vector<std::int32_t> numbers;
            for (const std::int64_t number : array.to_integers())
                numbers.push_back(static_cast<std::int32_t>(number));
            numbers.back() = numbers.back() == 5 ? 300 : 5;
            array = VtkArray::of<std::int32_t>("structure", numbers);
        }
        return format_vtk_xml(file, "", {1, 1});
    };
    const std::string good = format_model("m.vtu", model(2), context).value();
    EXPECT_EQ(model_code(folder, good), "ok");
    EXPECT_EQ(model_code(folder, with_other_structure("m.vtu", good)), "E-MDL-016");
    const SurfaceFile surface{extract_interfaces(model(2).mesh), description()};
    const std::string skin = format_surface("m.vtp", surface, context).value();
    EXPECT_EQ(surface_code(folder, skin), "ok");
    EXPECT_EQ(surface_code(folder, with_other_structure("m.vtp", skin)), "E-MDL-016");
}

TEST(MeshFile, units_other_than_the_millimetre_are_refused) {
    const Folder folder;
    for (const auto& [unit, code] :
         {std::pair{"mm", "ok"}, {"Millimetre", "ok"}, {"m", "E-MDL-017"}, {"um", "E-MDL-017"}}) {
        ModelFile m = model(1);
        m.description.unit = unit;
        for (const std::string& extension : model_extensions) {
            RunContext context;
            EXPECT_EQ(model_code(folder, format_model("m" + extension, m, context).value()), code)
                << unit << extension;
        }
    }
}

TEST(MeshFile, bad_surfaces) {
    const Folder folder;
    EXPECT_EQ(surface_code(folder, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "ok");
    EXPECT_EQ(surface_code(folder, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), "E-MDL-004");
    EXPECT_EQ(surface_code(folder, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n"), "E-MDL-004");
    EXPECT_EQ(surface_code(folder, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n"), "E-MDL-003");
    EXPECT_EQ(surface_code(folder, "v 0 0 0\nv 1 0 0\nv 0 1 nan\nf 1 2 3\n"), "E-MDL-005");
    const std::string stl =
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
        "0\nendloop\nendfacet\nendsolid\n";
    EXPECT_EQ(surface_code(folder, stl), "ok");
    EXPECT_EQ(surface_code(folder, stl.substr(0, 80)), "E-MDL-003");
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    EXPECT_EQ(surface_code(folder, ply + "3 0 1 2\n"), "ok");
    EXPECT_EQ(surface_code(folder, ply + "3 0 1 3\n"), "E-MDL-004");
    EXPECT_EQ(surface_code(folder, ply + "3 0 1\n"), "E-MDL-003");
    EXPECT_EQ(surface_code(folder, ply + "200 0 1\n"), "E-MDL-007");
    std::string many = ply;
    many.replace(many.find("vertex 3"), 8, "vertex 4000000000");
    EXPECT_EQ(surface_code(folder, many), "E-MDL-007");
    RunContext context;
    std::string binary = format_surface("s.stl", surface(1), context).value();
    EXPECT_EQ(surface_code(folder, binary.substr(0, binary.size() - 1)).substr(0, 6), "E-MDL-");
}

TEST(MeshFile, polygons_are_cut_into_triangles) {
    const Folder folder;
    RunContext context;
    const auto read =
        read_surface(folder.put("s", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1 2/2/2 3//3 -1\n"), context);
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_EQ(read.value().surface.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(context.warnings.front().code, "W-MDL-005");
}

// The readers themselves, without the detection by content: damage to the first bytes must not hide the rest.
TEST(MeshFile, damaged_files_never_crash) {
    RunContext context;
    const ModelFile m = model(2);
    const SurfaceFile s = surface(2);
    for (const std::string& extension : model_extensions) {
        const std::string good = format_model("m" + extension, m, context).value();
        int refused = 0;
        for_each_damage(good, 3000, 7, [&](const std::string& bad) {
            RunContext own;
            const auto read = extension == ".vtu"    ? parse_vtu("m", bytes_of(bad), {}, own)
                              : extension == ".msh"  ? parse_gmsh("m", bytes_of(bad), own)
                              : extension == ".mesh" ? parse_medit("m", bytes_of(bad), own)
                                                     : parse_abaqus("m", bytes_of(bad), own);
            if (!read.ok()) {
                ++refused;
                EXPECT_EQ(read.error().place.file, "m");
                return;
            }
            const ModelFile& back = read.value();
            ASSERT_EQ(back.mesh.regions.size(), back.mesh.cells.size());
            for (const Cell& cell : back.mesh.cells) {
                for (const std::uint32_t vertex : cell) ASSERT_LT(vertex, back.mesh.points.size());
            }
            for (const Vec3& point : back.mesh.points)
                ASSERT_TRUE(std::isfinite(point.x + point.y + point.z));
            for (const Region region : back.mesh.regions)
                ASSERT_LT(region, back.description.regions.members.size());
            ASSERT_TRUE(format_model("m" + extension, back, own).ok());
        });
        EXPECT_GT(refused, 500) << extension;
    }
    for (const std::string& extension : surface_extensions) {
        const std::string good = format_surface("s" + extension, s, context).value();
        for_each_damage(good, 3000, 8, [&](const std::string& bad) {
            RunContext own;
            const auto read = extension == ".vtp"   ? parse_vtp("s", bytes_of(bad), {}, own)
                              : extension == ".stl" ? parse_stl("s", bytes_of(bad), own)
                              : extension == ".ply" ? parse_ply("s", bytes_of(bad), own)
                                                    : parse_obj("s", bytes_of(bad), own);
            if (!read.ok()) return;
            const SurfaceFile& back = read.value();
            for (const Triangle& triangle : back.surface.triangles) {
                for (const std::uint32_t vertex : triangle) ASSERT_LT(vertex, back.surface.points.size());
            }
            ASSERT_TRUE(format_surface("s" + extension, back, own).ok());
        });
    }
}

// Writes one model and its surface in every format into $ANATOMESH_FORMATS_DIR, for
// tests/formats/models_test.py.
TEST(MeshFile, writes_samples_for_foreign_readers) {
    const char* folder = std::getenv("ANATOMESH_FORMATS_DIR");
    if (!folder) GTEST_SKIP() << "ANATOMESH_FORMATS_DIR is not set";
    fs::create_directories(folder);
    RunContext context;
    ModelFile m = model(5);
    for (const std::string& extension : model_extensions) {
        ASSERT_TRUE(write_model((fs::path(folder) / ("model" + extension)).string(), m, context).ok());
    }
    for (const std::string& extension : surface_extensions) {
        ASSERT_TRUE(
            write_surface((fs::path(folder) / ("surface" + extension)).string(), surface(5), context).ok());
    }
    // The truth as plain numbers: points (hexadecimal doubles), cells with their numbers.
    std::ofstream truth(fs::path(folder) / "truth.txt");
    const std::vector<std::int32_t> numbers = region_numbers(m.description);
    truth << std::hexfloat << m.mesh.points.size() << ' ' << m.mesh.cells.size() << '\n';
    for (const Vec3& p : m.mesh.points) truth << p.x << ' ' << p.y << ' ' << p.z << '\n';
    for (std::size_t c = 0; c < m.mesh.cells.size(); ++c) {
        for (const std::uint32_t vertex : m.mesh.cells[c]) truth << vertex << ' ';
        truth << numbers[m.mesh.regions[c]] << '\n';
    }
    const SurfaceMesh s = surface(5).surface;
    truth << s.points.size() << ' ' << s.triangles.size() << '\n';
    for (const Vec3& p : s.points) truth << p.x << ' ' << p.y << ' ' << p.z << '\n';
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        for (const std::uint32_t vertex : s.triangles[t]) truth << vertex << ' ';
        truth << numbers[s.sides[t][0]] << ' ' << s.sides[t][0] << ' ' << s.sides[t][1] << '\n';
    }
}

// Reads what VTK and meshio made of the model in $ANATOMESH_FORMATS_DIR/foreign.
TEST(MeshFile, reads_what_foreign_writers_wrote) {
    const char* folder = std::getenv("ANATOMESH_FORMATS_DIR");
    if (!folder) GTEST_SKIP() << "ANATOMESH_FORMATS_DIR is not set";
    const ModelFile m = model(5);
    const std::vector<std::int32_t> numbers = region_numbers(m.description);
    int files = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(folder) / "foreign")) {
        const std::string name = entry.path().filename().string();
        RunContext context;
        const auto read = read_model(entry.path().string(), context);
        ASSERT_TRUE(read.ok()) << to_line(read.error());
        const ModelFile& got = read.value();
        ASSERT_EQ(got.mesh.points.size(), m.mesh.points.size()) << name;
        for (std::size_t i = 0; i < got.mesh.points.size(); ++i) {  // Gmsh writes 16 digits
            ASSERT_LE(length(got.mesh.points[i] - m.mesh.points[i]), name == "gmsh_text.msh" ? 1e-12 : 0)
                << name;
        }
        EXPECT_TRUE(got.mesh.cells == m.mesh.cells) << name;
        ASSERT_EQ(got.mesh.regions.size(), m.mesh.regions.size()) << name;
        ++files;
        if (name == "meshio.inp") continue;  // meshio writes no labels there
        const std::vector<std::int32_t> shown = region_numbers(got.description);
        for (std::size_t c = 0; c < got.mesh.cells.size(); ++c) {
            ASSERT_EQ(shown[got.mesh.regions[c]], numbers[m.mesh.regions[c]]) << name << ", cell " << c;
        }
        if (!name.starts_with("meshio") && !name.starts_with("gmsh"))
            expect_same(got.description, m.description);
    }
    EXPECT_GT(files, 20);
}

}  // namespace
}  // namespace anatomesh::mesh_file_test
