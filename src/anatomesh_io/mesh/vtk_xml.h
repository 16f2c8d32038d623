// VTK XML files (.vtu, .vtp) as plain arrays: what the format can say about a mesh, without what it means.
//
// Reads ascii, inline base64, appended raw and appended base64 arrays, zlib-compressed or not, UInt32 and
// UInt64 headers, both byte orders, all number types and strings. Writes appended raw, zlib-compressed,
// UInt64 headers, little endian: the bytes depend on the content alone, not on the number of threads.
// Follows: VTK File Formats (VTK 9.1 User's Guide) and vtkXMLDataParser.
//
// Errors (kind `input` unless stated):
//   E-VTK-001 not well-formed XML (with the line)   E-VTK-006 array whose size does not fit the others
//   E-VTK-002 not a PolyData or UnstructuredGrid    E-VTK-007 cell that names a point which does not exist
//   E-VTK-003 attribute missing or out of range     E-VTK-008 array missing
//   E-VTK-004 array that ends early, or bad number  E-VTK-009 several pieces
//   E-VTK-005 compressed array damaged              E-VTK-010 (limit) inflates beyond the limit
//   E-VTK-011 compressor other than zlib            E-VTK-012 offsets of cells not increasing
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/geom/vec.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

enum class VtkType : std::uint8_t {
    int8,
    uint8,
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float32,
    float64,
    string
};

std::size_t byte_size(VtkType type);  // of one value; 1 for string

template <class T>
constexpr VtkType vtk_type_of() {
    if constexpr (std::is_same_v<T, float>) return VtkType::float32;
    if constexpr (std::is_same_v<T, double>) return VtkType::float64;
    if constexpr (std::is_integral_v<T>) {
        // The integer types of VtkType come in pairs of one size, the signed one first. [index; 0 to 6; D]
        constexpr int size_step = sizeof(T) == 1 ? 0 : sizeof(T) == 2 ? 2 : sizeof(T) == 4 ? 4 : 6;
        return static_cast<VtkType>(size_step + (std::is_unsigned_v<T> ? 1 : 0));
    }
}

// An array as in the file.
struct VtkArray {
    std::string name;
    VtkType type = VtkType::float64;
    std::uint32_t components = 1;
    std::string bytes;  // native byte order, packed; strings one after the other, each ended by a zero byte

    // Requires: values.size() is a multiple of components.
    template <class T>
    static VtkArray of(std::string name, std::span<const T> values, std::uint32_t components = 1) {
        VtkArray array{std::move(name), vtk_type_of<T>(), components, {}};
        array.bytes.assign(reinterpret_cast<const char*>(values.data()), values.size_bytes());
        return array;
    }
    static VtkArray of_points(std::span<const Vec3> points);
    static VtkArray of_strings(std::string name, std::span<const std::string> strings);

    std::size_t values() const { return bytes.size() / byte_size(type); }
    std::size_t tuples() const { return values() / components; }
    // Conversions of every number type. Requires: not a string array.
    std::vector<double> to_doubles() const;
    std::vector<std::int64_t> to_integers() const;  // fractions are cut; beyond 64 bits: the nearest end
    // Requires: a string array.
    std::vector<std::string> to_strings() const;
};

// Cells: the points of cell i are connectivity[offsets[i - 1], offsets[i]), with offsets[-1] = 0.
struct VtkCells {
    std::vector<std::int64_t> connectivity, offsets;

    std::size_t size() const { return offsets.size(); }
    std::span<const std::int64_t> points_of(std::size_t cell) const {
        const auto first = static_cast<std::size_t>(cell == 0 ? 0 : offsets[cell - 1]);
        return {connectivity.data() + first, static_cast<std::size_t>(offsets[cell]) - first};
    }
    void add(std::span<const std::int64_t> points) {
        connectivity.insert(connectivity.end(), points.begin(), points.end());
        offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    }
};

enum class VtkDataSet : std::uint8_t { poly_data, unstructured_grid };

struct VtkFile {
    VtkDataSet kind = VtkDataSet::poly_data;
    std::vector<Vec3> points;
    VtkCells verts, lines, strips, polys;  // poly_data; cell data in this order
    VtkCells cells;                        // unstructured_grid
    std::vector<std::uint8_t> types;       // unstructured_grid: VTK cell types, one per cell
    std::vector<VtkArray> field_data, point_data, cell_data;

    const VtkArray* field(std::string_view name) const;
    const VtkArray* point_array(std::string_view name) const;
    const VtkArray* cell_array(std::string_view name) const;
    std::size_t cell_count() const;
};

// Guarantees on success: offsets increase, every index of a cell names a point, data arrays have a tuple per
// point or cell, types one per cell. Coordinates may be NaN. `path` is for messages.
// Complexity: linear in the inflated size; memory is taken only for bytes that are there.
Result<VtkFile> parse_vtk_xml(std::span<const std::byte> content, const std::string& path,
                              const InputLimits& limits = {});

struct VtkWriteOptions {
    int compression_level = 1;  // zlib, 1 to 9
    int threads = 1;            // at least 1
};

// The file as bytes. `comment` is put into an XML comment at the head; "--" in it is broken up.
// Requires: the guarantees of parse_vtk_xml.
std::string format_vtk_xml(const VtkFile& file, std::string_view comment, const VtkWriteOptions& options);

}  // namespace anatomesh
