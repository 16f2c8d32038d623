// InputFile: the bytes of an input, read once, and its gzip content, inflated within limits.
//
// Errors (kind `file` unless stated) name the path:
//   E-INP-001 no such file                  E-INP-007 changed while being read
//   E-INP-002 may not be read               E-INP-008 (limit) file larger than the limit
//   E-INP-003 is a folder                   E-INP-009 (limit) out of memory
//   E-INP-004 not a regular file            E-INP-010 (input) compressed data ends early
//   E-INP-005 cannot be opened              E-INP-011 (input) compressed data damaged, or its check fails
//   E-INP-006 a read failed                 E-INP-012 (limit) inflates beyond the limit
//   W-INP-001 bytes after the end of the compressed data, ignored
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"

namespace anatomesh {

struct InputLimits {
    std::uint64_t max_file_bytes = std::uint64_t{8} << 30;
    std::uint64_t max_inflated_bytes = std::uint64_t{4} << 30;
    // Compressed data may inflate to free_inflated_bytes, beyond that to at most this many times its size.
    std::uint32_t max_inflate_ratio = 200;
    std::uint64_t free_inflated_bytes = std::uint64_t{16} << 20;
};

// A growing byte buffer that is not cleared first: most of it is overwritten at once.
class ByteBuffer {
  public:
    std::byte* data() { return data_.get(); }
    const std::byte* data() const { return data_.get(); }
    std::size_t size() const { return size_; }
    std::size_t capacity() const { return capacity_; }
    std::span<const std::byte> bytes() const { return {data_.get(), size_}; }
    // Keeps the content. False when there is no memory. Requires: capacity >= size().
    bool reserve(std::size_t capacity);
    // Requires: size <= capacity().
    void set_size(std::size_t size) { size_ = size; }

  private:
    struct Release {
        void operator()(std::byte* memory) const;
    };
    std::unique_ptr<std::byte, Release> data_;
    std::size_t size_ = 0, capacity_ = 0;
};

struct InputFile {
    std::string path;  // as the user named it
    ByteBuffer content;

    std::span<const std::byte> bytes() const { return content.bytes(); }
    // Lower-case hexadecimal SHA-256 of the content. Linear in the size, not kept.
    std::string sha256() const;
};

// Reads a whole regular file; links are followed. A FIFO, device, socket or folder is refused without waiting
// on it. Memory is taken for the size the file system states, never more.
Result<InputFile> read_input_file(const std::string& path, const InputLimits& limits);

// The first bytes of a regular file, at most `count`: enough to see what it is.
Result<std::vector<std::byte>> read_input_start(const std::string& path, std::size_t count);

bool is_gzip(std::span<const std::byte> bytes);

// Inflates gzip (one or more members, each checked by its CRC and length) or a zlib stream (checked by its
// Adler-32). `path` is for messages. `expected_bytes` is the size that a checked header states, 0 when
// unknown: up to 512 MiB it is granted whatever the ratio, and a size beyond the limits is refused before
// inflating. Follows: RFC 1950, 1951, 1952. Linear in the output; memory at most 1.5 times the output.
Result<ByteBuffer> inflate(std::span<const std::byte> compressed, const std::string& path,
                           const InputLimits& limits, RunContext& context, std::uint64_t expected_bytes = 0);

// The first inflated bytes, at most `count`; fewer, without an error, when the data ends or is damaged.
std::vector<std::byte> inflate_start(std::span<const std::byte> compressed, std::size_t count);

}  // namespace anatomesh
