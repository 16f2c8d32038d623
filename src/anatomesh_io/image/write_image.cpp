#include "anatomesh_io/image/write_image.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <new>
#include <string_view>
#include <type_traits>
#include <vector>

#include "anatomesh/base/text.h"
#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

// How a voxel type is called in both formats.
struct TypeNames {
    const char* nrrd;
    std::int16_t nifti, bits;
};
constexpr TypeNames u8_names{"uint8", 2, 8}, u16_names{"uint16", 512, 16}, i32_names{"int32", 8, 32},
    f32_names{"float", 16, 32};

struct Content {
    const ImageGeometry& geometry;
    TypeNames type;
    std::string data;   // little endian
    std::string pairs;  // key := value lines of a NRRD
    std::string made_by;
};

template <class T>
void append_little(std::string& bytes, T value) {
    using Bits = std::conditional_t<sizeof(T) == 1, std::uint8_t,
                                    std::conditional_t<sizeof(T) == 2, std::uint16_t, std::uint32_t>>;
    const Bits bits = std::bit_cast<Bits>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i)
        bytes.push_back(static_cast<char>(static_cast<std::uint64_t>(bits) >> (8 * i)));
}

template <class T>
void put_little(std::string& bytes, std::size_t at, T value) {
    std::string piece;
    append_little(piece, value);
    bytes.replace(at, piece.size(), piece);
}

std::string gzip(std::string_view data) {
    z_stream stream{};
    // 16 more window bits: a gzip frame, whose header zlib writes without name and time.
    if (deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
    std::string out;
    std::vector<char> piece(std::size_t{1} << 18);
    std::size_t taken = 0;
    int state = Z_OK;
    while (state != Z_STREAM_END) {
        if (stream.avail_in == 0 && taken < data.size()) {
            const std::size_t next = std::min<std::size_t>(data.size() - taken, std::size_t{1} << 30);
            stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data() + taken));
            stream.avail_in = static_cast<uInt>(next);
            taken += next;
        }
        stream.next_out = reinterpret_cast<Bytef*>(piece.data());
        stream.avail_out = static_cast<uInt>(piece.size());
        state = deflate(&stream, taken == data.size() ? Z_FINISH : Z_NO_FLUSH);
        assert(state == Z_OK || state == Z_STREAM_END);
        out.append(piece.data(), piece.size() - stream.avail_out);
    }
    deflateEnd(&stream);
    return out;
}

std::string vector_text(Vec3 v) {
    std::string text = "(";
    append_number(text, v.x);
    text += ",";
    append_number(text, v.y);
    text += ",";
    append_number(text, v.z);
    return text + ")";
}

std::string nrrd_file(const Content& content) {
    const ImageGeometry& geometry = content.geometry;
    std::string text = "NRRD0004\ntype: ";
    text += content.type.nrrd;
    text += "\ndimension: 3\nspace: left-posterior-superior\nsizes:";
    for (const std::uint32_t size : geometry.size) text += " " + std::to_string(size);
    text += "\nspace directions:";
    for (const Vec3 step : geometry.step) text += " " + vector_text(step);
    text +=
        "\nkinds: domain domain domain\nendian: little\nencoding: gzip\nspace units: \"mm\" \"mm\" \"mm\"";
    text += "\nspace origin: " + vector_text(geometry.origin) + "\n" + content.pairs;
    if (!content.made_by.empty()) text += "anatomesh:=" + content.made_by + "\n";
    text += "\n";
    return text + gzip(content.data);
}

// One line, as the value of a key must be.
std::string one_line(std::string_view name) {
    std::string text(name);
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 32; }, ' ');
    return text;
}

std::string segment_pairs(const std::vector<Structure>& structures) {
    std::string text;
    for (std::size_t s = 0; s < structures.size(); ++s) {
        const Structure& structure = structures[s];
        const std::string key = "Segment" + std::to_string(s) + "_",
                          number = std::to_string(structure.number);
        text += key + "ID:=Segment_" + number + "\n";
        text += key + "LabelValue:=" + number + "\n" + key + "Layer:=0\n";
        text += key + "Name:=" + (structure.name.empty() ? number : one_line(structure.name)) + "\n";
        text += key + "Color:=";
        for (std::size_t c = 0; c < 3; ++c) {
            if (c > 0) text += " ";
            append_number(text, structure.color[c] / 255.0);
        }
        text += "\n";
    }
    return text;
}

Result<std::string> nifti_file(const Content& content) {
    const ImageGeometry& geometry = content.geometry;
    constexpr std::uint32_t longest = std::numeric_limits<std::int16_t>::max();
    if (*std::max_element(geometry.size.begin(), geometry.size.end()) > longest)
        return Error{ErrorKind::limit,
                     "E-IMG-017",
                     "the image has an axis of more than 32767 voxels, which NIfTI-1 cannot hold",
                     {},
                     "write it as .nrrd"};
    std::string header(352, '\0');
    put_little<std::int32_t>(header, 0, 348);
    const std::array<Vec3, 3>& step = geometry.step;
    put_little<std::int16_t>(header, 40, 3);
    put_little<float>(header, 76, 1);
    for (std::size_t axis = 0; axis < 7; ++axis)
        put_little<std::int16_t>(header, 42 + 2 * axis,
                                 axis < 3 ? static_cast<std::int16_t>(geometry.size[axis]) : std::int16_t{1});
    for (std::size_t axis = 0; axis < 3; ++axis)
        put_little<float>(header, 80 + 4 * axis, static_cast<float>(length(step[axis])));
    put_little<std::int16_t>(header, 70, content.type.nifti);
    put_little<std::int16_t>(header, 72, content.type.bits);
    put_little<float>(header, 108, 352);
    put_little<float>(header, 112, 1);
    header[123] = 2;  // millimetres
    const std::string_view description = std::string_view(content.made_by).substr(0, 79);
    header.replace(148, description.size(), description);
    put_little<std::int16_t>(header, 254, 1);  // sform: scanner coordinates
    const Vec3& at = geometry.origin;
    const std::array<double, 12> rows = {-step[0].x, -step[1].x, -step[2].x, -at.x,
                                         -step[0].y, -step[1].y, -step[2].y, -at.y,
                                         step[0].z,  step[1].z,  step[2].z,  at.z};
    for (std::size_t i = 0; i < rows.size(); ++i)
        put_little<float>(header, 280 + 4 * i, static_cast<float>(rows[i] == 0 ? 0.0 : rows[i]));
    header.replace(344, 4, std::string_view("n+1\0", 4));
    return header + content.data;
}

Result<std::string> file_of(const Content& content, ImageFormat format) {
    if (format == ImageFormat::nrrd) return nrrd_file(content);
    ANATOMESH_TRY(std::string bytes, nifti_file(content));
    return format == ImageFormat::nifti_gzip ? gzip(bytes) : std::move(bytes);
}

template <class T>
std::string label_data(const LabelMap& labels) {
    std::string data;
    data.reserve(labels.voxels.size() * sizeof(T));
    for (const std::uint16_t voxel : labels.voxels)
        append_little(data, static_cast<T>(voxel == 0 ? 0 : labels.structures[voxel - 1u].number));
    return data;
}

}  // namespace

Result<ImageFormat> image_format_of(const std::string& path) {
    const std::string name = lower_case(path);
    if (name.ends_with(".nrrd")) return ImageFormat::nrrd;
    if (name.ends_with(".nii")) return ImageFormat::nifti;
    if (name.ends_with(".nii.gz")) return ImageFormat::nifti_gzip;
    return Error{ErrorKind::usage,
                 "E-IMG-016",
                 "the extension of the output is no format for images",
                 {path, "", "", "", ""},
                 "use .nrrd, .nii or .nii.gz"};
}

Result<std::string> format_image(const ImageGeometry& geometry, std::span<const float> voxels,
                                 ImageFormat format, const std::string& made_by) {
    assert(voxels.size() == geometry.voxel_count());
    Content content{geometry, f32_names, {}, {}, made_by};
    content.data.reserve(voxels.size() * sizeof(float));
    for (const float value : voxels) append_little(content.data, value);
    return file_of(content, format);
}

Result<std::string> format_label_map(const LabelMap& labels, ImageFormat format, const std::string& made_by) {
    std::int32_t low = 0, high = 0;
    for (const Structure& structure : labels.structures) {
        low = std::min(low, structure.number);
        high = std::max(high, structure.number);
    }
    Content content{labels.geometry, i32_names, {}, segment_pairs(labels.structures), made_by};
    if (low == 0 && high <= 0xFF) {
        content.type = u8_names;
        content.data = label_data<std::uint8_t>(labels);
    } else if (low == 0 && high <= 0xFFFF) {
        content.type = u16_names;
        content.data = label_data<std::uint16_t>(labels);
    } else {
        content.data = label_data<std::int32_t>(labels);
    }
    return file_of(content, format);
}

}  // namespace anatomesh
