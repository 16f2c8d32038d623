// RawImage: an image whose header was read and checked and whose values are still bytes; and the checks that
// all formats share. Internal to the room.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/text.h"
#include "anatomesh/image/image.h"
#include "anatomesh_io/file/input_file.h"
#include "anatomesh_io/image/read_image.h"

namespace anatomesh {

enum class VoxelType : std::uint8_t { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

std::size_t byte_size(VoxelType type);
const char* name_of(VoxelType type);
bool is_integer(VoxelType type);

struct RawImage {
    ImageGeometry geometry;
    VoxelType type = VoxelType::u8;
    std::endian order = std::endian::little;
    double slope = 1, intercept = 0;
    // Voxel n is the element n * stride of `data`, which holds (voxel_count - 1) * stride + 1 of them or
    // more.
    std::span<const std::byte> data;
    std::size_t stride = 1;
    ByteBuffer storage;  // holds `data` when it is not part of the file as it is
    std::vector<Structure> structures;
    std::vector<InputHash> further_inputs;
    std::vector<FramePose> poses;
};

// The readers; `file` must live as long as the result. `content` is file.bytes(), or those inflated.
Result<RawImage> read_nifti(const InputFile& file, const ReadImageOptions& options, RunContext& context);
Result<RawImage> read_nrrd(const InputFile& file, std::span<const std::byte> content,
                           const ReadImageOptions& options, RunContext& context);
Result<RawImage> read_metaimage(const InputFile& file, std::span<const std::byte> content,
                                const ReadImageOptions& options, RunContext& context);
Result<RawImage> read_invesalius(const InputFile& file, std::span<const std::byte> content,
                                 const ReadImageOptions& options, RunContext& context);

// Turns values into floats and gathers the facts. Requires: the invariants of RawImage.
Result<LoadedImage> to_grey(const RawImage& raw, const std::string& path, RunContext& context);

// ---- checks

Error image_error(const char* code, std::string message, const std::string& path, std::string value = "",
                  std::string next_step = "");
Warning image_warning(const char* code, std::string message, const std::string& path, std::string value,
                      std::string what_was_done);

// What a file claims to hold: `sizes` of the voxel axes, and how many volumes of them.
struct ClaimedLayout {
    std::array<std::uint64_t, 3> sizes{1, 1, 1};
    std::uint64_t volumes = 1;
    VoxelType type = VoxelType::u8;
};

// Bytes of all volumes. Errors: E-IMG-003 an axis of no or too many voxels, E-IMG-004 (limit) more voxels
// than allowed, also when the product does not fit 64 bits.
Result<std::uint64_t> claimed_bytes(const ClaimedLayout& layout, const std::string& path,
                                    const ReadImageOptions& options);

// E-IMG-005 when `available` bytes are fewer than claimed; W-IMG-001 when they are more.
Status check_length(std::uint64_t claimed, std::uint64_t available, const std::string& path,
                    RunContext& context);

// Which volume to read. `volumes` counts each of the `channels` of a pixel as one. Errors: E-IMG-008 several
// volumes or channels and none chosen, E-IMG-009 no such volume.
Result<std::uint64_t> chosen_volume(std::uint64_t volumes, const std::string& path,
                                    const ReadImageOptions& options, std::uint64_t channels = 1);

// E-IMG-006 a number that is not finite or a corner beyond 1e7 mm, E-IMG-007 steps that span no volume.
Status check_geometry(const ImageGeometry& geometry, const std::string& path);

// Positions in RAS become positions in LPS, and the other way round.
void turn_ras_lps(ImageGeometry& geometry);

// Unit steps (LPS) towards which the axes run: "RAS" gives (-1,0,0), (0,-1,0), (0,0,1).
// E-IMG-011 when the text is not one letter of each pair.
Result<std::array<Vec3, 3>> orientation_steps(const std::string& letters, const std::string& path);

// ---- text

// The whole text as a number: no blanks, no locale, nothing after it. Finite or not.
std::optional<double> parse_double(std::string_view text);
std::optional<std::int64_t> parse_integer(std::string_view text);
std::string_view trimmed(std::string_view text);
// The words between blanks.
std::vector<std::string_view> words(std::string_view text);
// A piece of a file in a message: cut to 40 characters, control characters as '?'.
std::string shown(std::string_view text);

// Values written as text, `count` of them, as 64-bit floats. E-IMG-005 when there are fewer, E-IMG-014 when
// one is no number. Memory is taken only for what the text can hold.
Result<ByteBuffer> parse_text_values(std::string_view text, std::uint64_t count, const std::string& path);

// The path of a data file that the header at `path` names. E-IMG-013 when the name leads out of the header's
// folder, is a URL or the header itself; E-IMG-015 for several files.
Result<std::string> data_file_path(const std::string& path, std::string_view name);

}  // namespace anatomesh
