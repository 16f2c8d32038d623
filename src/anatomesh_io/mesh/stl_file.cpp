// STL: written binary; read binary or as text. Equal corners become one vertex, in order of first appearance.
#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/description.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"

namespace anatomesh {

namespace {

// A binary file begins with a text of this size. [bytes; 80; D STL]
constexpr std::size_t header_bytes = 80;
// A triangle takes twelve floats and two further bytes. [bytes; 50; D STL]
constexpr std::size_t triangle_bytes = 50;
// If single floats round coordinates by more, a warning says so: a micrometre is below every measurement.
// [mm; > 0; C]
constexpr double tolerated_loss = 1e-3;

// The nearest float. Not inline: g++ 12 drops the rounding when it vectorises double -> float -> double.
[[gnu::noinline]] float nearest_float(double value) {
    return static_cast<float>(value);
}

void append_float(std::string& bytes, double value) {
    static_assert(std::endian::native == std::endian::little);
    const float narrow = nearest_float(value);
    bytes.append(reinterpret_cast<const char*>(&narrow), sizeof narrow);
}

void append_vector(std::string& bytes, const Vec3& v) {
    append_float(bytes, v.x);
    append_float(bytes, v.y);
    append_float(bytes, v.z);
}

Vec3 normal_of(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 normal = cross(b - a, c - a);
    const double size = length(normal);
    return size > 0 ? (1 / size) * normal : Vec3{};
}

void warn_of_loss(const SurfaceMesh& mesh, const std::string& path, RunContext& context) {
    double loss = 0;
    for (const Vec3& point : mesh.points) {
        for (const double coordinate : {point.x, point.y, point.z}) {
            loss = std::max(loss, std::abs(coordinate - static_cast<double>(nearest_float(coordinate))));
        }
    }
    if (!(loss > tolerated_loss)) return;
    std::string text;
    append_number(text, loss);
    Warning warning{"W-MDL-004",
                    "STL holds coordinates in single precision, which changes them by up to " + text + " mm",
                    {},
                    "written with this loss; .ply and .vtp keep coordinates exactly"};
    warning.place.file = path;
    warning.place.value = text;
    context.warn(std::move(warning));
}

// The corners of triangles, three each, as a mesh.
SurfaceMesh merged(const std::vector<Vec3>& corners) {
    std::vector<std::uint32_t> order(corners.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        if (lexicographic_less(corners[a], corners[b])) return true;
        return !lexicographic_less(corners[b], corners[a]) && a < b;
    });
    std::vector<std::uint32_t> first(corners.size());  // the first corner at the same place
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && corners[order[i]] == corners[order[i - 1]];
        first[order[i]] = same ? first[order[i - 1]] : order[i];
    }
    SurfaceMesh mesh;
    std::vector<std::uint32_t> vertex(corners.size());
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
        if (first[i] == i) {
            vertex[i] = static_cast<std::uint32_t>(mesh.points.size());
            mesh.points.push_back(corners[i]);
        } else {
            vertex[i] = vertex[first[i]];
        }
        if (i % 3 == 2) mesh.triangles.push_back({vertex[i - 2], vertex[i - 1], vertex[i]});
    }
    return mesh;
}

Result<std::vector<Vec3>> binary_corners(const std::string& path, Bytes content,
                                         DescriptionReader& description) {
    ByteReader reader(content);
    std::string_view header = reader.read_text(header_bytes).value_or("");
    while (!header.empty()) {
        header.remove_prefix(std::min(header.find_first_not_of(std::string_view(" \0", 2)), header.size()));
        const std::string_view word = header.substr(0, header.find_first_of(std::string_view(" \0", 2)));
        ANATOMESH_CHECK_STATUS(description.take(word));
        header.remove_prefix(word.size());
    }
    const auto count = reader.read<std::uint32_t>();
    if (!count || std::uint64_t{*count} * triangle_bytes > reader.remaining()) {
        return mesh_error("E-MDL-007", "the file is too short for the number of triangles it states", path,
                          count ? std::to_string(*count) : "byte 80");
    }
    std::vector<Vec3> corners;
    corners.reserve(std::size_t{3} * *count);
    for (std::uint32_t t = 0; t < *count; ++t) {
        reader.skip(12);  // the normal
        for (int k = 0; k < 3; ++k) {
            std::array<double, 3> x{};
            for (double& coordinate : x) coordinate = reader.read<float>().value_or(0);
            ANATOMESH_CHECK_STATUS(check_point({x[0], x[1], x[2]}, corners.size(), path));
            corners.push_back({x[0], x[1], x[2]});
        }
        reader.skip(2);
    }
    return corners;
}

Result<std::vector<Vec3>> text_corners(const std::string& path, std::string_view text) {
    std::vector<Vec3> corners;
    bool ended = false;
    Lines lines(text);
    while (const auto line = lines.next()) {
        std::string_view rest = *line;
        const std::string word = lower_case(take_word(rest));
        if (word == "vertex") {
            Vec3 point;
            for (double* coordinate : {&point.x, &point.y, &point.z}) {
                const auto value = take_number<double>(rest);
                if (!value) return expected(path, "a coordinate", lines.place());
                *coordinate = *value;
            }
            ANATOMESH_CHECK_STATUS(check_point(point, corners.size(), path));
            corners.push_back(point);
        } else if (word == "endfacet" && corners.size() % 3 != 0) {
            return mesh_error("E-MDL-006", "a facet does not have three vertices", path, lines.place());
        } else if (word == "endsolid") {
            ended = true;
        }
    }
    if (!ended) return expected(path, "endsolid", lines.place());
    if (corners.size() % 3 != 0) return expected(path, "three vertices per facet", lines.place());
    return corners;
}

}  // namespace

Result<std::string> format_stl(const std::string& path, const SurfaceFile& surface, RunContext& context) {
    const SurfaceMesh& mesh = surface.surface;
    warn_of_loss(mesh, path, context);
    // Not "solid", by which readers know the text form.
    std::string bytes = "anatomesh binary STL SPACE=" + surface.description.space.substr(0, 20) +
                        " UNIT=" + surface.description.unit.substr(0, 10);
    bytes.resize(header_bytes, ' ');
    bytes.reserve(header_bytes + 4 + triangle_bytes * mesh.triangles.size());
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
    for (const Triangle& triangle : mesh.triangles) {
        const auto stored = [&](std::uint32_t vertex) {
            const Vec3& p = mesh.points[vertex];
            return Vec3{nearest_float(p.x), nearest_float(p.y), nearest_float(p.z)};
        };
        const Vec3 a = stored(triangle[0]), b = stored(triangle[1]), c = stored(triangle[2]);
        append_vector(bytes, normal_of(a, b, c));
        for (const Vec3& corner : {a, b, c}) append_vector(bytes, corner);
        bytes.append(2, '\0');
    }
    return bytes;
}

Result<SurfaceFile> parse_stl(const std::string& path, Bytes content, RunContext& context) {
    DescriptionReader description(path);
    // A binary file may begin with "solid" as well: its length tells.
    ByteReader reader(content);
    bool binary = true;
    if (as_text(content).starts_with("solid")) {
        reader.skip(header_bytes);
        const auto count = reader.read<std::uint32_t>();
        binary = count && header_bytes + 4 + std::uint64_t{*count} * triangle_bytes == content.size();
    }
    ANATOMESH_TRY(const std::vector<Vec3> corners,
                  binary ? binary_corners(path, content, description) : text_corners(path, as_text(content)));
    if (corners.empty()) return mesh_error("E-MDL-008", "the file has no triangles", path);
    if (corners.size() >= no_cell) return mesh_error("E-MDL-013", "more than 2^32 - 2 corners", path);
    SurfaceFile surface;
    surface.surface = merged(corners);
    surface.description = description.finish(context);
    return surface;
}

}  // namespace anatomesh
