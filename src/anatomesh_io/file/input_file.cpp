#include "anatomesh_io/file/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <libdeflate.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <system_error>
#include <utility>

#include "anatomesh_io/file/uninterrupted.h"

namespace anatomesh {

namespace {

Error failure(ErrorKind kind, const char* code, std::string message, const std::string& path,
              std::string next_step = "") {
    return {kind, code, std::move(message), Place{path, "", "", "", ""}, std::move(next_step)};
}

Error no_memory(const std::string& path, std::uint64_t bytes) {
    return failure(ErrorKind::limit, "E-INP-009",
                   fmt::format("the memory does not suffice for {} bytes", bytes), path,
                   "use a machine with more memory, or a smaller image");
}

std::string system_message(int number) {
    return std::generic_category().message(number);
}

// Closes when the scope ends.
struct Descriptor {
    int number = -1;
    explicit Descriptor(int opened) : number(opened) {}
    Descriptor(Descriptor&& other) noexcept : number(std::exchange(other.number, -1)) {}
    Descriptor& operator=(Descriptor&&) = delete;
    ~Descriptor() {
        if (number >= 0) ::close(number);
    }
};

struct OpenedFile {
    Descriptor descriptor;
    struct stat state;
};

// O_NONBLOCK: opening a FIFO that nobody writes to must not wait.
Result<OpenedFile> open_regular_file(const std::string& path) {
    if (path.find('\0') != std::string::npos)
        return failure(ErrorKind::file, "E-INP-005", "the path contains a zero byte", path);
    Descriptor descriptor(
        uninterrupted([&] { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY); }));
    if (descriptor.number < 0) {
        const int number = errno;
        if (number == ENOENT || number == ENOTDIR)
            return failure(ErrorKind::file, "E-INP-001", "the file does not exist", path, "check the path");
        if (number == EACCES || number == EPERM)
            return failure(ErrorKind::file, "E-INP-002", "the file cannot be read", path,
                           "check the permissions of the file");
        if (number == ENXIO)
            return failure(ErrorKind::file, "E-INP-004", "the path is not a regular file", path,
                           "give a file");
        return failure(ErrorKind::file, "E-INP-005", "the file cannot be opened: " + system_message(number),
                       path);
    }
    struct stat state {};
    if (uninterrupted([&] { return ::fstat(descriptor.number, &state); }) != 0)
        return failure(ErrorKind::file, "E-INP-005", "the file cannot be opened: " + system_message(errno),
                       path);
    if (S_ISDIR(state.st_mode))
        return failure(ErrorKind::file, "E-INP-003", "the path is a folder", path,
                       "give one file of the folder");
    if (!S_ISREG(state.st_mode))
        return failure(ErrorKind::file, "E-INP-004", "the path is not a regular file", path, "give a file");
    return OpenedFile{std::move(descriptor), state};
}

// Bytes read: fewer than `count` only at the end of the file.
Result<std::size_t> read_fully(int descriptor, std::byte* target, std::size_t count,
                               const std::string& path) {
    std::size_t done = 0;
    while (done < count) {
        const ssize_t got = ::read(descriptor, target + done, std::min(count - done, std::size_t{1} << 30));
        if (got == 0) break;
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            return failure(ErrorKind::file, "E-INP-006",
                           fmt::format("reading failed at byte {}: {}", done, system_message(errno)), path);
        done += static_cast<std::size_t>(got);
    }
    return done;
}

bool same_state(const struct stat& a, const struct stat& b) {
    return a.st_size == b.st_size && a.st_mtim.tv_sec == b.st_mtim.tv_sec &&
           a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

}  // namespace

bool ByteBuffer::reserve(std::size_t capacity) {
    if (capacity <= capacity_) return true;
    std::byte* memory = static_cast<std::byte*>(std::realloc(data_.get(), capacity));
    if (!memory) return false;
    (void)data_.release();
    data_.reset(memory);
    capacity_ = capacity;
    return true;
}

void ByteBuffer::Release::operator()(std::byte* memory) const {
    std::free(memory);
}

Result<InputFile> read_input_file(const std::string& path, const InputLimits& limits) {
    ANATOMESH_TRY(const OpenedFile opened, open_regular_file(path));
    const auto size = static_cast<std::uint64_t>(opened.state.st_size);
    if (size > limits.max_file_bytes)
        return failure(ErrorKind::limit, "E-INP-008",
                       fmt::format("the file has {} bytes, and the limit is {}", size, limits.max_file_bytes),
                       path);
    InputFile file{path, {}};
    // One byte more than stated, to see whether the file grew meanwhile.
    if (!file.content.reserve(size + 1)) return no_memory(path, size);
    ANATOMESH_TRY(const std::size_t done,
                  read_fully(opened.descriptor.number, file.content.data(), size + 1, path));
    struct stat after {};
    if (done != size || uninterrupted([&] { return ::fstat(opened.descriptor.number, &after); }) != 0 ||
        !same_state(opened.state, after))
        return failure(ErrorKind::file, "E-INP-007", "the file changed while it was read", path,
                       "wait until the file is complete, then run the command again");
    file.content.set_size(done);
    return file;
}

Result<std::vector<std::byte>> read_input_start(const std::string& path, std::size_t count) {
    ANATOMESH_TRY(const OpenedFile opened, open_regular_file(path));
    std::vector<std::byte> start(
        std::min<std::uint64_t>(count, static_cast<std::uint64_t>(opened.state.st_size)));
    ANATOMESH_TRY(const std::size_t done,
                  read_fully(opened.descriptor.number, start.data(), start.size(), path));
    start.resize(done);
    return start;
}

std::string InputFile::sha256() const {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int length = 0;
    EVP_Digest(content.data(), content.size(), digest, &length, EVP_sha256(), nullptr);
    std::string text;
    for (unsigned int i = 0; i < length; ++i) text += fmt::format("{:02x}", digest[i]);
    return text;
}

bool is_gzip(std::span<const std::byte> bytes) {
    return bytes.size() >= 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
}

namespace {

// A zlib inflater over a span that may be longer than zlib's 32-bit counts.
class Inflater {
  public:
    explicit Inflater(std::span<const std::byte> input) : input_(input) {
        // 32: takes gzip as well as zlib, by the first bytes.
        ready_ = inflateInit2(&stream_, 15 + 32) == Z_OK;
    }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    ~Inflater() {
        if (ready_) inflateEnd(&stream_);
    }

    bool ready() const { return ready_; }
    std::size_t consumed() const { return consumed_; }
    bool at_end() const { return consumed_ == input_.size(); }
    std::span<const std::byte> rest() const { return input_.subspan(consumed_); }
    const char* message() const { return stream_.msg ? stream_.msg : "unreadable"; }
    void next_member() { inflateReset(&stream_); }

    // Inflates into [target, target + count); `produced` is what came out. Returns zlib's code.
    int step(std::byte* target, std::size_t count, std::size_t& produced) {
        // zlib counts in 32 bits, so that larger blocks are handed over in pieces of this size.
        // [bytes; < 2^32; D zlib]
        constexpr std::size_t piece = std::size_t{1} << 30;
        const auto in = static_cast<uInt>(std::min(input_.size() - consumed_, piece));
        const auto out = static_cast<uInt>(std::min(count, piece));
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(input_.data() + consumed_));
        stream_.avail_in = in;
        stream_.next_out = reinterpret_cast<Bytef*>(target);
        stream_.avail_out = out;
        const int code = ::inflate(&stream_, Z_NO_FLUSH);
        consumed_ += in - stream_.avail_in;
        produced = out - stream_.avail_out;
        return code;
    }

  private:
    std::span<const std::byte> input_;
    z_stream stream_{};
    std::size_t consumed_ = 0;
    bool ready_ = false;
};

// One member or stream that fills `compressed`, in half of zlib's time; checks the same sums. False where it
// is anything else, or longer than the buffer's capacity: step by step it is told what is wrong.
bool inflate_at_once(std::span<const std::byte> compressed, ByteBuffer& out) {
    const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor(
        libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
    if (!decompressor) return false;
    const auto run = is_gzip(compressed) ? libdeflate_gzip_decompress_ex : libdeflate_zlib_decompress_ex;
    std::size_t consumed = 0, produced = 0;
    if (run(decompressor.get(), compressed.data(), compressed.size(), out.data(), out.capacity(), &consumed,
            &produced) != LIBDEFLATE_SUCCESS ||
        consumed != compressed.size())
        return false;
    out.set_size(produced);
    return true;
}

// How much may have come out when `consumed` compressed bytes went in.
std::uint64_t allowed_bytes(std::uint64_t consumed, std::uint64_t free_bytes, const InputLimits& limits) {
    const std::uint64_t by_ratio = consumed * limits.max_inflate_ratio;
    return std::min(std::max(free_bytes, by_ratio), limits.max_inflated_bytes);
}

// The capacity to begin with: the length a gzip file states at its end, when it is believable.
std::size_t first_capacity(std::span<const std::byte> compressed, std::uint64_t expected_bytes) {
    std::uint64_t stated = expected_bytes;
    if (stated == 0 && is_gzip(compressed) && compressed.size() >= 18) {
        const std::byte* tail = compressed.data() + compressed.size() - 4;
        for (int i = 0; i < 4; ++i) stated |= std::to_integer<std::uint64_t>(tail[i]) << (8 * i);
    }
    const std::uint64_t believable = std::uint64_t{16} * compressed.size() + 65536;
    return static_cast<std::size_t>(std::min(std::max<std::uint64_t>(stated + 1, 4096), believable));
}

bool all_zero(std::span<const std::byte> bytes) {
    return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

void warn_trailing(std::span<const std::byte> rest, const std::string& path, RunContext& context) {
    if (all_zero(rest)) return;  // tapes and block devices pad with zeros
    context.warn({"W-INP-001", fmt::format("the file has {} bytes after its compressed data", rest.size()),
                  Place{path, "", "", "", ""}, "they were ignored"});
}

Error beyond_limit(std::uint64_t compressed, std::uint64_t inflated, const std::string& path) {
    return failure(
        ErrorKind::limit, "E-INP-012",
        fmt::format("{} compressed bytes expand to {} bytes or more, beyond the limit", compressed, inflated),
        path, "expand the file with gunzip if you trust it");
}

Error inflate_error(int code, const Inflater& inflater, std::size_t produced, const std::string& path) {
    if (code == Z_MEM_ERROR) return no_memory(path, produced);
    if (code == Z_BUF_ERROR && inflater.at_end())
        return failure(ErrorKind::input, "E-INP-010",
                       fmt::format("the compressed data ends too early, after {} expanded bytes", produced),
                       path, "copy or download the file again");
    return failure(ErrorKind::input, "E-INP-011",
                   fmt::format("the compressed data is damaged near byte {} ({})", inflater.consumed(),
                               inflater.message()),
                   path, "copy or download the file again");
}

}  // namespace

Result<ByteBuffer> inflate(std::span<const std::byte> compressed, const std::string& path,
                           const InputLimits& limits, RunContext& context, std::uint64_t expected_bytes) {
    // A size that the header states honestly is no bomb as long as it is at most this. [bytes; > 0; B]
    constexpr std::uint64_t moderate = std::uint64_t{512} << 20;
    const std::uint64_t free_bytes =
        std::max(limits.free_inflated_bytes, expected_bytes <= moderate ? expected_bytes : 0);
    if (expected_bytes > allowed_bytes(compressed.size(), free_bytes, limits))
        return beyond_limit(compressed.size(), expected_bytes, path);
    Inflater inflater(compressed);
    ByteBuffer out;
    if (!inflater.ready() || !out.reserve(first_capacity(compressed, expected_bytes)))
        return no_memory(path, 0);
    if (context.cancelled()) return cancelled_error();
    // What is larger takes long, and is inflated in steps, between which it can be cancelled. [bytes; > 0; B]
    constexpr std::uint64_t quick = std::uint64_t{256} << 20;
    if (out.capacity() <= std::min(quick, allowed_bytes(compressed.size(), free_bytes, limits)) &&
        inflate_at_once(compressed, out))
        return out;
    const bool members = is_gzip(compressed);
    while (true) {
        if (context.cancelled()) return cancelled_error();
        if (out.size() == out.capacity() && !out.reserve(out.capacity() + out.capacity() / 2))
            return no_memory(path, out.capacity());
        // In pieces, so that a bomb is met soon after the limit.
        const std::size_t room = std::min(out.capacity() - out.size(), std::size_t{4} << 20);
        std::size_t produced = 0;
        const int code = inflater.step(out.data() + out.size(), room, produced);
        out.set_size(out.size() + produced);
        if (out.size() > allowed_bytes(inflater.consumed(), free_bytes, limits))
            return beyond_limit(inflater.consumed(), out.size(), path);
        if (code == Z_STREAM_END) {
            if (members && is_gzip(inflater.rest())) {
                inflater.next_member();
                continue;
            }
            if (!inflater.at_end()) warn_trailing(inflater.rest(), path, context);
            return out;
        }
        if (code != Z_OK) return inflate_error(code, inflater, out.size(), path);
    }
}

std::vector<std::byte> inflate_start(std::span<const std::byte> compressed, std::size_t count) {
    std::vector<std::byte> out(count);
    Inflater inflater(compressed);
    std::size_t size = 0;
    while (inflater.ready() && size < count) {
        std::size_t produced = 0;
        const int code = inflater.step(out.data() + size, count - size, produced);
        size += produced;
        if (code == Z_STREAM_END && is_gzip(inflater.rest()))
            inflater.next_member();
        else if (code != Z_OK || produced == 0)
            break;
    }
    out.resize(size);
    return out;
}

}  // namespace anatomesh
