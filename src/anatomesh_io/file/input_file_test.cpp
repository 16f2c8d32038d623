#include "anatomesh_io/file/input_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "anatomesh_io/file/byte_reader.h"

namespace anatomesh::input_file_test {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text));
}

std::string deflated(const std::string& plain, int window_bits) {
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
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

// Text that neither shrinks much nor repeats.
std::string noise(std::size_t size) {
    std::string text(size, '\0');
    std::uint64_t state = 7;
    for (char& c : text) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        c = static_cast<char>(state >> 56);
    }
    return text;
}

class InputFileTest : public testing::Test {
  protected:
    void SetUp() override {
        std::string pattern = (std::filesystem::temp_directory_path() / "anatomesh-XXXXXX").string();
        folder_ = ::mkdtemp(pattern.data());
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    std::string write(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
        return (folder_ / name).string();
    }
    std::filesystem::path folder_;
    InputLimits limits_;
    RunContext context_;
};

TEST_F(InputFileTest, a_file_is_read_whole_with_its_hash) {
    const auto empty = read_input_file(write("empty", ""), limits_);
    ASSERT_TRUE(empty.ok());
    EXPECT_EQ(empty.value().bytes().size(), 0U);
    EXPECT_EQ(empty.value().sha256(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    const auto file = read_input_file(write("abc", "abc"), limits_);
    ASSERT_TRUE(file.ok());
    EXPECT_EQ(as_text(file.value().bytes()), "abc");
    EXPECT_EQ(file.value().sha256(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    const std::string large = noise(3000000);
    const auto whole = read_input_file(write("large", large), limits_);
    ASSERT_TRUE(whole.ok());
    EXPECT_EQ(as_text(whole.value().bytes()), large);
    const auto start = read_input_start(write("large", large), 1000);
    ASSERT_TRUE(start.ok());
    EXPECT_EQ(as_text(start.value()), large.substr(0, 1000));
}

TEST_F(InputFileTest, D24_what_is_no_regular_file_is_refused_without_waiting) {
    const auto code = [&](const std::string& path) {
        const auto result = read_input_file(path, limits_);
        if (result.ok()) return std::string();
        EXPECT_EQ(result.error().place.file, path);
        return result.error().code;
    };
    EXPECT_EQ(code((folder_ / "absent").string()), "E-INP-001");
    EXPECT_EQ(code(write("file", "x") + "/below"), "E-INP-001");
    EXPECT_EQ(code(folder_.string()), "E-INP-003");
    ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
    EXPECT_EQ(code((folder_ / "pipe").string()), "E-INP-004");
    EXPECT_EQ(code("/dev/zero"), "E-INP-004");
    EXPECT_EQ(code(""), "E-INP-001");
    EXPECT_EQ(code(std::string("a\0b", 3)), "E-INP-005");
    limits_.max_file_bytes = 2;
    EXPECT_EQ(code(write("three", "123")), "E-INP-008");
    EXPECT_EQ(code(write("two", "12")), "");
}

TEST_F(InputFileTest, inflated_bytes_are_those_deflated) {
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{1}, std::size_t{4095}, std::size_t{70000}, std::size_t{9000000}})
        for (const int window_bits : {15, 31}) {
            const std::string plain = noise(size);
            const auto out = inflate(bytes_of(deflated(plain, window_bits)), "x", limits_, context_);
            ASSERT_TRUE(out.ok()) << to_line(out.error());
            EXPECT_EQ(as_text(out.value().bytes()), plain);
        }
    EXPECT_TRUE(context_.warnings.empty());
}

TEST_F(InputFileTest, N10_members_padding_and_trailing_bytes) {
    const std::string one = deflated("one", 31), two = deflated("two", 31), none = deflated("", 31);
    const auto members = inflate(bytes_of(none + one + none + two), "x", limits_, context_);
    ASSERT_TRUE(members.ok());
    EXPECT_EQ(as_text(members.value().bytes()), "onetwo");
    EXPECT_EQ(as_text(inflate_start(bytes_of(none + one + two), 5)), "onetw");
    EXPECT_TRUE(inflate(bytes_of(one + std::string(512, '\0')), "x", limits_, context_).ok());
    EXPECT_TRUE(context_.warnings.empty());
    EXPECT_TRUE(inflate(bytes_of(one + "tail"), "x", limits_, context_).ok());
    ASSERT_EQ(context_.warnings.size(), 1U);
    EXPECT_EQ(context_.warnings[0].code, "W-INP-001");
    EXPECT_FALSE(inflate(bytes_of(one + two.substr(0, 12)), "x", limits_, context_).ok());
}

TEST_F(InputFileTest, N11_truncated_or_damaged_data_is_an_error) {
    const std::string good = deflated(noise(2000), 31);
    for (std::size_t size = 0; size < good.size(); ++size) {
        const auto out = inflate(bytes_of(good.substr(0, size)), "x", limits_, context_);
        ASSERT_FALSE(out.ok()) << size;
        EXPECT_EQ(out.error().code, "E-INP-010") << size;
    }
    for (std::size_t at = 10; at < good.size(); ++at) {
        std::string wrong = good;
        wrong[at] ^= 4;
        const auto out = inflate(bytes_of(wrong), "x", limits_, context_);
        if (out.ok()) ADD_FAILURE() << "a flipped bit went unseen at byte " << at;
    }
}

TEST_F(InputFileTest, N12_limits_of_inflation) {
    const std::string zeros = deflated(std::string(20 << 20, '\0'), 31);
    const auto refused = inflate(bytes_of(zeros), "x", limits_, context_);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "E-INP-012");
    EXPECT_EQ(refused.error().kind, ErrorKind::limit);
    EXPECT_TRUE(inflate(bytes_of(deflated(std::string(15 << 20, '\0'), 31)), "x", limits_, context_).ok());
    // An honest size is granted, a lie is not, and one beyond all measure is refused at once.
    EXPECT_TRUE(inflate(bytes_of(zeros), "x", limits_, context_, 20 << 20).ok());
    EXPECT_FALSE(inflate(bytes_of(zeros), "x", limits_, context_, 100).ok());
    EXPECT_FALSE(inflate(bytes_of(zeros), "x", limits_, context_, std::uint64_t{1} << 30).ok());
    limits_.max_inflated_bytes = 1000;
    EXPECT_FALSE(inflate(bytes_of(deflated(noise(1001), 31)), "x", limits_, context_).ok());
    EXPECT_TRUE(inflate(bytes_of(deflated(noise(1000), 31)), "x", limits_, context_).ok());
}

TEST_F(InputFileTest, N23_mutated_streams_end) {
    const std::string good = deflated(std::string(5000, 'a') + noise(500), 31);
    std::uint64_t state = 3;
    for (int round = 0; round < 3000; ++round) {
        std::string wrong = good;
        for (int change = 0; change < 3; ++change) {
            state = state * 6364136223846793005U + 1442695040888963407U;
            wrong[(state >> 33) % wrong.size()] = static_cast<char>(state >> 25);
        }
        const auto out = inflate(bytes_of(wrong), "x", limits_, context_);
        if (out.ok()) {
            EXPECT_EQ(out.value().size(), 5500U);
        }
    }
}

}  // namespace
}  // namespace anatomesh::input_file_test
