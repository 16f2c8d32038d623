// Arrays of VTK XML files: conversions between the types of the file and the types of the callers.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "anatomesh_io/mesh/vtk_xml.h"

namespace anatomesh {

namespace {

template <class T>
std::int64_t to_integer(T value) {
    if constexpr (std::is_floating_point_v<T>) {
        if (std::isnan(value)) return std::numeric_limits<std::int64_t>::min();
        // The bounds are powers of two: exact in either type.
        if (value >= T(9223372036854775808.0)) return std::numeric_limits<std::int64_t>::max();
        if (value < T(-9223372036854775808.0)) return std::numeric_limits<std::int64_t>::min();
    } else if constexpr (std::is_same_v<T, std::uint64_t>) {
        return static_cast<std::int64_t>(
            std::min<std::uint64_t>(value, std::numeric_limits<std::int64_t>::max()));
    }
    return static_cast<std::int64_t>(value);
}

template <class Source, class Target, class Convert>
std::vector<Target> converted(const std::string& bytes, Convert convert) {
    std::vector<Target> values(bytes.size() / sizeof(Source));
    for (std::size_t i = 0; i < values.size(); ++i) {
        Source value;
        std::memcpy(&value, bytes.data() + i * sizeof(Source), sizeof(Source));
        values[i] = convert(value);
    }
    return values;
}

template <class Target, class Convert>
std::vector<Target> converted(const VtkArray& array, Convert convert) {
    switch (array.type) {
        case VtkType::int8:
            return converted<std::int8_t, Target>(array.bytes, convert);
        case VtkType::uint8:
            return converted<std::uint8_t, Target>(array.bytes, convert);
        case VtkType::int16:
            return converted<std::int16_t, Target>(array.bytes, convert);
        case VtkType::uint16:
            return converted<std::uint16_t, Target>(array.bytes, convert);
        case VtkType::int32:
            return converted<std::int32_t, Target>(array.bytes, convert);
        case VtkType::uint32:
            return converted<std::uint32_t, Target>(array.bytes, convert);
        case VtkType::int64:
            return converted<std::int64_t, Target>(array.bytes, convert);
        case VtkType::uint64:
            return converted<std::uint64_t, Target>(array.bytes, convert);
        case VtkType::float32:
            return converted<float, Target>(array.bytes, convert);
        case VtkType::float64:
            return converted<double, Target>(array.bytes, convert);
        case VtkType::string:
            break;
    }
    assert(false && "a string array has no numbers");
    return {};
}

const VtkArray* find(const std::vector<VtkArray>& arrays, std::string_view name) {
    const auto found =
        std::find_if(arrays.begin(), arrays.end(), [&](const VtkArray& array) { return array.name == name; });
    return found == arrays.end() ? nullptr : &*found;
}

}  // namespace

std::size_t byte_size(VtkType type) {
    switch (type) {
        case VtkType::int8:
        case VtkType::uint8:
        case VtkType::string:
            return 1;
        case VtkType::int16:
        case VtkType::uint16:
            return 2;
        case VtkType::int32:
        case VtkType::uint32:
        case VtkType::float32:
            return 4;
        case VtkType::int64:
        case VtkType::uint64:
        case VtkType::float64:
            return 8;
    }
    return 1;
}

VtkArray VtkArray::of_points(std::span<const Vec3> points) {
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    VtkArray array{"Points", VtkType::float64, 3, {}};
    array.bytes.assign(reinterpret_cast<const char*>(points.data()), points.size_bytes());
    return array;
}

VtkArray VtkArray::of_strings(std::string name, std::span<const std::string> strings) {
    VtkArray array{std::move(name), VtkType::string, 1, {}};
    for (const std::string& text : strings) {
        array.bytes.append(text.c_str());
        array.bytes.push_back('\0');
    }
    return array;
}

std::vector<double> VtkArray::to_doubles() const {
    return converted<double>(*this, [](auto value) { return static_cast<double>(value); });
}

std::vector<std::int64_t> VtkArray::to_integers() const {
    return converted<std::int64_t>(*this, [](auto value) { return to_integer(value); });
}

std::vector<std::string> VtkArray::to_strings() const {
    assert(type == VtkType::string);
    std::vector<std::string> strings;
    for (std::size_t begin = 0; begin < bytes.size();) {
        const std::size_t end = std::min(bytes.find('\0', begin), bytes.size());
        strings.push_back(bytes.substr(begin, end - begin));
        begin = end + 1;
    }
    return strings;
}

const VtkArray* VtkFile::field(std::string_view name) const {
    return find(field_data, name);
}
const VtkArray* VtkFile::point_array(std::string_view name) const {
    return find(point_data, name);
}
const VtkArray* VtkFile::cell_array(std::string_view name) const {
    return find(cell_data, name);
}

std::size_t VtkFile::cell_count() const {
    return kind == VtkDataSet::unstructured_grid ? cells.size()
                                                 : verts.size() + lines.size() + strips.size() + polys.size();
}

}  // namespace anatomesh
