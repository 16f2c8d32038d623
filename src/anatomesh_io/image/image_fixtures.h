// Images written byte by byte, good and bad, for the tests of this room.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/image/read_image.h"

namespace anatomesh::fixtures {

// A folder of its own that goes with the object; in memory where the system offers that.
class Folder {
  public:
    Folder() {
        const std::filesystem::path memory = "/dev/shm";
        const bool usable = ::access(memory.c_str(), W_OK | X_OK) == 0;
        const auto parent = usable ? memory : std::filesystem::temp_directory_path();
        std::string pattern = (parent / "anatomesh-XXXXXX").string();
        path_ = ::mkdtemp(pattern.data());
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::string path(const std::string& name) const { return (path_ / name).string(); }
    std::string write(const std::string& name, std::string_view bytes) const {
        std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
        std::ofstream(path(name), std::ios::binary)
            .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        return path(name);
    }

  private:
    std::filesystem::path path_;
};

template <class T>
void put(std::string& bytes, std::size_t at, T value, std::endian order = std::endian::little) {
    if (order != std::endian::native) value = byte_swapped(value);
    if (bytes.size() < at + sizeof(T)) bytes.resize(at + sizeof(T));
    std::memcpy(bytes.data() + at, &value, sizeof(T));
}

template <class T>
std::string values_as_bytes(const std::vector<T>& values, std::endian order = std::endian::little) {
    std::string bytes;
    for (const T value : values) put(bytes, bytes.size(), value, order);
    return bytes;
}

// window_bits 31: gzip, 15: zlib.
inline std::string deflated(std::string_view plain, int window_bits = 31, int level = 6) {
    z_stream stream{};
    deflateInit2(&stream, level, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&stream, plain.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
    stream.avail_in = static_cast<uInt>(plain.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    ::deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

// A good NIfTI image of 3 x 4 x 5 voxels of int16 unless changed; voxel n has the value n % 7.
struct Nifti {
    int version = 1;
    std::endian order = std::endian::little;
    std::vector<std::int64_t> dim = {3, 3, 4, 5, 1, 1, 1, 1};
    std::int16_t datatype = 4, bitpix = 16;
    std::vector<double> pixdim = {1, 0.75, 0.5, 2, 0, 0, 0, 0};
    double vox_offset = -1;  // -1: right behind the header and its extensions
    double slope = 0, intercept = 0;
    int units = 2;
    int qform_code = 0, sform_code = 1;
    std::vector<double> quaternion = {0, 0, 0}, qoffset = {10, 20, 30};
    std::vector<double> srow = {0.75, 0, 0, 10, 0, 0.5, 0, 20, 0, 0, 2, 30};
    std::string magic;       // empty: the right one of a single file
    std::string extensions;  // behind the header, with the four extension bytes
    std::string data;        // empty: the default values

    std::string default_data() const {
        std::vector<std::int16_t> values;
        for (int n = 0; n < 60; ++n) values.push_back(static_cast<std::int16_t>(n % 7));
        return values_as_bytes(values, order);
    }
    std::string header() const {
        std::string h(version == 1 ? 348 : 540, '\0');
        put<std::int32_t>(h, 0, static_cast<std::int32_t>(h.size()), order);
        const std::size_t behind = h.size() + (extensions.empty() ? 4 : extensions.size());
        const double offset = vox_offset == -1 ? static_cast<double>(behind) : vox_offset;
        if (version == 1) {
            for (std::size_t i = 0; i < 8; ++i) {
                put<std::int16_t>(h, 40 + 2 * i, static_cast<std::int16_t>(dim[i]), order);
                put<float>(h, 76 + 4 * i, static_cast<float>(pixdim[i]), order);
            }
            put<std::int16_t>(h, 70, datatype, order);
            put<std::int16_t>(h, 72, bitpix, order);
            put<float>(h, 108, static_cast<float>(offset), order);
            put<float>(h, 112, static_cast<float>(slope), order);
            put<float>(h, 116, static_cast<float>(intercept), order);
            h[123] = static_cast<char>(units);
            put<std::int16_t>(h, 252, static_cast<std::int16_t>(qform_code), order);
            put<std::int16_t>(h, 254, static_cast<std::int16_t>(sform_code), order);
            for (std::size_t i = 0; i < 3; ++i) {
                put<float>(h, 256 + 4 * i, static_cast<float>(quaternion[i]), order);
                put<float>(h, 268 + 4 * i, static_cast<float>(qoffset[i]), order);
            }
            for (std::size_t i = 0; i < 12; ++i)
                put<float>(h, 280 + 4 * i, static_cast<float>(srow[i]), order);
            const std::string text = magic.empty() ? std::string("n+1\0", 4) : magic;
            h.replace(344, text.size(), text);
        } else {
            const std::string text = magic.empty() ? std::string("n+2\0\r\n\032\n", 8) : magic;
            h.replace(4, text.size(), text);
            put<std::int16_t>(h, 12, datatype, order);
            put<std::int16_t>(h, 14, bitpix, order);
            for (std::size_t i = 0; i < 8; ++i) {
                put<std::int64_t>(h, 16 + 8 * i, dim[i], order);
                put<double>(h, 104 + 8 * i, pixdim[i], order);
            }
            put<std::int64_t>(h, 168, static_cast<std::int64_t>(offset), order);
            put<double>(h, 176, slope, order);
            put<double>(h, 184, intercept, order);
            put<std::int32_t>(h, 344, qform_code, order);
            put<std::int32_t>(h, 348, sform_code, order);
            for (std::size_t i = 0; i < 3; ++i) {
                put<double>(h, 352 + 8 * i, quaternion[i], order);
                put<double>(h, 376 + 8 * i, qoffset[i], order);
            }
            for (std::size_t i = 0; i < 12; ++i) put<double>(h, 400 + 8 * i, srow[i], order);
            put<std::int32_t>(h, 500, units, order);
        }
        return h;
    }
    std::string bytes() const {
        return header() + (extensions.empty() ? std::string(4, '\0') : extensions) +
               (data.empty() ? default_data() : data);
    }
};

// A good NRRD of 3 x 4 x 5 voxels of int16, fields as lines that a test may replace.
inline std::string nrrd_header(const std::string& more = "", const std::string& space = "space: LPS\n",
                               const std::string& encoding = "raw") {
    return "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 5\nendian: little\nencoding: " + encoding + "\n" +
           space + "space directions: (0.75,0,0) (0,0.5,0) (0,0,2)\nspace origin: (10,20,30)\n" + more + "\n";
}

inline std::string metaimage_header(const std::string& more = "") {
    return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
           "CompressedData = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 10 20 30\n"
           "AnatomicalOrientation = RAI\nElementSpacing = 0.75 0.5 2\nDimSize = 3 4 5\nElementType = "
           "MET_SHORT\n" +
           more + "ElementDataFile = LOCAL\n";
}

struct Outcome {
    std::string code;  // of the error; empty when there was none
    Error error;
    LoadedImage loaded;
    std::vector<Warning> warnings;

    bool ok() const { return code.empty(); }
    bool warned(const std::string& of) const {
        for (const Warning& warning : warnings)
            if (warning.code == of) return true;
        return false;
    }
};

inline Outcome read(const std::string& path, const ReadImageOptions& options = {}) {
    RunContext context;
    auto result = read_image(path, options, context);
    Outcome outcome;
    outcome.warnings = context.warnings;
    if (result.ok()) {
        outcome.loaded = std::move(result).value();
        return outcome;
    }
    outcome.error = result.error();
    outcome.code = outcome.error.code;
    EXPECT_FALSE(outcome.error.message.empty());
    EXPECT_FALSE(outcome.error.place.file.empty());
    return outcome;
}

inline Outcome read_bytes(std::string_view bytes, const ReadImageOptions& options = {},
                          const std::string& name = "image") {
    const Folder folder;
    return read(folder.write(name, bytes), options);
}

// The peak of resident memory since the last call of forget_peak_memory(), in bytes; 0 when the system does
// not tell, or a sanitizer keeps what was freed.
inline void forget_peak_memory() {
    std::ofstream("/proc/self/clear_refs") << "5";
}
inline std::uint64_t memory_line(const char* key) {
    std::ifstream status("/proc/self/status");
    std::string word;
    while (status >> word)
        if (word == key) {
            std::uint64_t kilobytes = 0;
            status >> kilobytes;
            return kilobytes * 1024;
        }
    return 0;
}
inline std::uint64_t memory_now() {
    return memory_line("VmRSS:");
}
inline std::uint64_t peak_memory() {
    return memory_line("VmHWM:");
}

inline void expect_position(const LoadedImage& loaded, double i, double j, double k, Vec3 expected,
                            double tolerance = 1e-6) {
    const Vec3 p = loaded.image.geometry.position(i, j, k);
    EXPECT_NEAR(p.x, expected.x, tolerance);
    EXPECT_NEAR(p.y, expected.y, tolerance);
    EXPECT_NEAR(p.z, expected.z, tolerance);
}

}  // namespace anatomesh::fixtures
