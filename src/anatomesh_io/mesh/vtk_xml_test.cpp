#include "anatomesh_io/mesh/vtk_xml.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "anatomesh_io/mesh/mutate_for_test.h"

namespace anatomesh::vtk_xml_test {
namespace {

// Polylines, a polygon and a vertex with arrays of every type.
VtkFile sample() {
    VtkFile file;
    for (int i = 0; i < 7; ++i) file.points.push_back({i / 3.0, -i * 1e-300, i * 1e7});
    file.verts.add(std::vector<std::int64_t>{6});
    file.lines.add(std::vector<std::int64_t>{0, 1, 2, 0});
    file.lines.add(std::vector<std::int64_t>{3, 4});
    file.polys.add(std::vector<std::int64_t>{2, 4, 6});
    const std::vector<std::int32_t> structure{7, -1, 2147483647, 0};
    const std::vector<double> quality{0.5, std::numeric_limits<double>::infinity(), -0.0, 1e-320};
    const std::vector<std::uint8_t> colors{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 255};
    file.cell_data = {VtkArray::of<std::int32_t>("structure", structure),
                      VtkArray::of<double>("quality", quality),
                      VtkArray::of<std::uint8_t>("color", colors, 3)};
    file.point_data = {VtkArray::of<float>("weight", std::vector<float>(7, 0.1f))};
    file.field_data = {VtkArray::of_strings("SPACE", std::vector<std::string>{"LPS"}),
                       VtkArray::of_strings("names", std::vector<std::string>{"", "Foie \xC3\xA9 <&\">", ""}),
                       VtkArray::of<std::int64_t>(
                           "large", std::vector<std::int64_t>{std::numeric_limits<std::int64_t>::min()})};
    return file;
}

void expect_same(const VtkArray& a, const VtkArray& b) {
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.type, b.type);
    EXPECT_EQ(a.components, b.components);
    EXPECT_EQ(a.bytes, b.bytes);
}

TEST(VtkXml, O01_write_read_write_gives_the_same_bytes) {
    const VtkFile file = sample();
    const std::string first = format_vtk_xml(file, "SPACE=LPS -- unit=mm", {});
    const auto read = parse_vtk_xml(bytes_of(first), "a.vtp");
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_EQ(read.value().points, file.points);
    EXPECT_EQ(read.value().lines.connectivity, file.lines.connectivity);
    EXPECT_EQ(read.value().lines.offsets, file.lines.offsets);
    ASSERT_EQ(read.value().cell_data.size(), 3u);
    for (int i = 0; i < 3; ++i) expect_same(read.value().cell_data[i], file.cell_data[i]);
    for (int i = 0; i < 3; ++i) expect_same(read.value().field_data[i], file.field_data[i]);
    EXPECT_EQ(read.value().field("names")->to_strings()[1], "Foie \xC3\xA9 <&\">");
    EXPECT_TRUE(format_vtk_xml(read.value(), "SPACE=LPS -- unit=mm", {}) == first);
}

TEST(VtkXml, same_bytes_for_any_number_of_threads) {
    VtkFile file = sample();
    for (int i = 0; i < 100'000; ++i) file.points.push_back({std::sin(i), std::cos(i), i * 0.1});
    file.point_data.clear();
    const std::string one = format_vtk_xml(file, "", {1, 1});
    EXPECT_TRUE(format_vtk_xml(file, "", {1, 2}) == one);
    const auto read = parse_vtk_xml(bytes_of(one), "a.vtp");
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_EQ(read.value().points, file.points);
}

TEST(VtkXml, empty_file) {
    const auto read = parse_vtk_xml(bytes_of(format_vtk_xml(VtkFile{}, "", {})), "a.vtp");
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_EQ(read.value().cell_count(), 0u);
}

// A triangle; `arrays` is put in place of its Points and Polys.
std::string document(const std::string& attributes, const std::string& arrays, const std::string& tail = "") {
    return "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" " + attributes +
           "><PolyData><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">" + arrays + "</Piece></PolyData>" +
           tail + "</VTKFile>";
}
std::string ascii(const std::string& points, const std::string& connectivity, const std::string& offsets) {
    return "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">" + points +
           "</DataArray></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\">" + connectivity +
           "</DataArray><DataArray type=\"Int32\" Name=\"offsets\">" + offsets + "</DataArray></Polys>";
}
std::string code_of(const std::string& text) {
    const auto read = parse_vtk_xml(bytes_of(text), "a.vtp");
    if (read.ok()) return "ok";
    EXPECT_EQ(read.error().place.file, "a.vtp");
    return read.error().code;
}

TEST(VtkXml, reads_ascii) {
    const auto read =
        parse_vtk_xml(bytes_of(document("", ascii("0 0 0\n 1e-3 0.1 0 \t 0 1 nan", "0 1 2", "3"))), "a");
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_EQ(read.value().points[1], (Vec3{1e-3, 0.1, 0}));
    EXPECT_TRUE(std::isnan(read.value().points[2].z));
    EXPECT_EQ(read.value().polys.connectivity, (std::vector<std::int64_t>{0, 1, 2}));
}

TEST(VtkXml, reads_base64_with_header_padded_alone_or_together) {
    // Offsets {3} as Int32: header 4 as UInt32, then 03 00 00 00.
    for (const std::string offsets : {"BAAAAAMAAAA=", "BAAAAA==AwAAAA==", " BAAA AA==\nAwAA AA== "}) {
        const std::string arrays = ascii("0 0 0 1 0 0 0 1 0", "0 1 2", "");
        const std::string text =
            document("", arrays.substr(0, arrays.find("<DataArray type=\"Int32\"")) +
                             "<DataArray type=\"Int32\" Name=\"offsets\" format=\"binary\">" + offsets +
                             "</DataArray></Polys>");
        EXPECT_EQ(code_of(text), "ok") << offsets;
    }
    const std::string big =
        document("byte_order=\"BigEndian\" header_type=\"UInt64\"",
                 "<Points><DataArray type=\"Int16\" NumberOfComponents=\"3\" format=\"appended\" "
                 "offset=\"0\"/></Points>"
                 "<Polys><DataArray type=\"Int64\" Name=\"connectivity\">0 1 2</DataArray>"
                 "<DataArray type=\"Int32\" Name=\"offsets\">3</DataArray></Polys>",
                 "<AppendedData encoding=\"base64\">\n _AAAAAAAAABIAAQACAAMABAAFAAYABwAI//8=</AppendedData>");
    const auto read = parse_vtk_xml(bytes_of(big), "a");
    ASSERT_TRUE(read.ok()) << to_line(read.error());
    EXPECT_EQ(read.value().points[2], (Vec3{7, 8, -1}));
}

TEST(VtkXml, bad_content_is_refused_with_its_place) {
    const std::string points = "0 0 0 1 0 0 0 1 0";
    EXPECT_EQ(code_of(document("", ascii(points, "0 1 2", "3"))), "ok");
    EXPECT_EQ(code_of(""), "E-VTK-001");
    EXPECT_EQ(code_of("<VTKFile"), "E-VTK-001");
    EXPECT_EQ(code_of(std::string(40, '<')), "E-VTK-001");
    EXPECT_EQ(code_of("<html></html>"), "E-VTK-002");
    EXPECT_EQ(code_of("<VTKFile type=\"ImageData\"></VTKFile>"), "E-VTK-002");
    EXPECT_EQ(code_of(document("byte_order=\"Middle\"", "")), "E-VTK-003");
    EXPECT_EQ(code_of(document("", ascii("0 0 0 1 0 0 0 1,5 0", "0 1 2", "3"))), "E-VTK-004");
    EXPECT_EQ(code_of(document("", ascii("0 0 0 1 0 0 0 1 ", "0 1 2", "3"))), "E-VTK-006");
    EXPECT_EQ(code_of(document("", ascii("0 0 0 1 0 0", "0 1 1", "3"))), "E-VTK-006");
    EXPECT_EQ(code_of(document("", ascii(points, "0 1 3", "3"))), "E-VTK-007");
    EXPECT_EQ(code_of(document("", ascii(points, "0 1 -1", "3"))), "E-VTK-007");
    EXPECT_EQ(code_of(document("", ascii(points, "0 1 2", "4"))), "E-VTK-012");
    EXPECT_EQ(code_of(document("", ascii(points, "0 1 2", "2"))), "E-VTK-012");
    EXPECT_EQ(code_of(document("", ascii(points, "0 1 2", "3 2 3"))), "E-VTK-012");
    EXPECT_EQ(code_of(document("", ascii(points, "0 1 2", "99999999999999999999999"))), "E-VTK-004");
    EXPECT_EQ(code_of(document("compressor=\"vtkLZ4DataCompressor\"", "")), "E-VTK-011");
    EXPECT_EQ(code_of(document("", ascii(points, "0 1 2", "3") + "</Piece><Piece>")), "E-VTK-009");
    EXPECT_EQ(code_of("<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY b \"c\">]><VTKFile/>"), "E-VTK-001");
    std::string deep = "<VTKFile type=\"PolyData\">";
    for (int i = 0; i < 100'000; ++i) deep += "<a>";
    EXPECT_EQ(code_of(deep), "E-VTK-001");
}

TEST(VtkXml, array_that_claims_more_than_the_file_has_is_refused_before_allocation) {
    const auto with_offsets = [](const std::string& attributes, const std::string& base64) {
        const std::string arrays = ascii("0 0 0 1 0 0 0 1 0", "0 1 2", "");
        return document(attributes,
                        arrays.substr(0, arrays.find("<Polys>")) +
                            "<Polys><DataArray type=\"Int32\" Name=\"offsets\" format=\"binary\">" + base64 +
                            "</DataArray></Polys>");
    };
    EXPECT_EQ(code_of(with_offsets("", "/////wMAAAA=")), "E-VTK-004");                        // 4 GiB
    EXPECT_EQ(code_of(with_offsets("header_type=\"UInt64\"", "//////////8=")), "E-VTK-004");  // 2^64 - 1
    const std::string zlib = "compressor=\"vtkZLibDataCompressor\"";
    EXPECT_EQ(code_of(with_offsets(zlib, "/////wAAAQAAAAAA")), "E-VTK-004");  // 2^32 - 1 blocks
    EXPECT_EQ(code_of(with_offsets(zlib, "AQAAAP///38AAAAABAAAAAAAAAA=")),
              "E-VTK-005");  // 2 GiB out of 4 bytes
}

TEST(VtkXml, D15_inflating_beyond_the_limit_is_refused) {
    VtkFile file;
    file.field_data = {VtkArray::of<std::int32_t>("zero", std::vector<std::int32_t>(5'000'000))};
    const std::string text = format_vtk_xml(file, "", {});
    InputLimits wider;
    wider.max_inflate_ratio = 1000;
    EXPECT_TRUE(parse_vtk_xml(bytes_of(text), "a.vtp", wider).ok());
    const auto read = parse_vtk_xml(bytes_of(text), "a.vtp");
    ASSERT_FALSE(read.ok()) << text.size();
    EXPECT_EQ(read.error().code, "E-VTK-010");
    EXPECT_EQ(read.error().kind, ErrorKind::limit);
}

TEST(VtkXml, damaged_files_never_crash) {
    int refused = 0;
    for (const std::string& good :
         {format_vtk_xml(sample(), "", {}), document("", ascii("0 0 0 1 0 0 0 1 0", "0 1 2", "3"))}) {
        for_each_damage(good, 3000, 15, [&](const std::string& bad) {
            const auto read = parse_vtk_xml(bytes_of(bad), "a.vtp");
            if (!read.ok()) {
                ++refused;
                EXPECT_FALSE(read.error().message.empty());
                return;
            }
            for (const VtkCells* cells : {&read.value().verts, &read.value().lines, &read.value().polys}) {
                for (std::size_t c = 0; c < cells->size(); ++c) {
                    for (const std::int64_t p : cells->points_of(c)) {
                        ASSERT_LT(static_cast<std::size_t>(p), read.value().points.size());
                    }
                }
            }
        });
    }
    EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace anatomesh::vtk_xml_test
