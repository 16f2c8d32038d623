#include "anatomesh_io/dicom/read_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "anatomesh_io/dicom/child.h"
#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/decoder.h"
#include "anatomesh_io/dicom/frame_places.h"
#include "anatomesh_io/dicom/pixels.h"
#include "anatomesh_io/dicom/sha256.h"
#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

namespace {

// Compressed pixels may claim so many times the size of their files: no codec of images packs better.
// [1; > 1; B]
constexpr std::uint64_t largest_ratio = 1000;
// Up to this size they may claim anything, because that much memory is always there. [bytes; > 0; B]
constexpr std::uint64_t free_bytes = std::uint64_t{256} << 20;

Error series_error(const char* code, std::string message, const std::string& file, std::string value,
                   std::string next_step) {
    return {ErrorKind::input,
            code,
            std::move(message),
            {file, {}, {}, {}, std::move(value)},
            std::move(next_step)};
}

Result<std::vector<std::uint32_t>> without_duplicates(const DicomFolder& folder,
                                                      const std::vector<std::uint32_t>& objects,
                                                      RunContext& context) {
    // Objects of one series are sorted by instance, then by content.
    std::vector<std::uint32_t> kept;
    for (const std::uint32_t index : objects) {
        const DicomObject& object = folder.objects[index];
        if (!kept.empty()) {
            const DicomObject& before = folder.objects[kept.back()];
            const bool same_uid = !object.sop_instance.empty() && object.sop_instance == before.sop_instance;
            if (object.sha256 == before.sha256 && (same_uid || object.sop_instance.empty())) {
                context.warn({"W-DCM-003",
                              "the folder holds the file twice",
                              {object.label, {}, {}, {}, before.label},
                              "it was read once"});
                continue;
            }
            if (same_uid)
                return series_error("E-DCM-024",
                                    "two files have the same SOPInstanceUID but different content",
                                    object.label, before.label, "remove the wrong file");
        }
        kept.push_back(index);
    }
    return kept;
}

Status check_frame_of_reference(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                                RunContext& context) {
    const DicomObject* first = nullptr;
    const DicomObject* absent = nullptr;
    for (const std::uint32_t index : objects) {
        const DicomObject& object = folder.objects[index];
        if (object.known_axes != folder.objects[objects[0]].known_axes)
            return series_error(
                "E-DCM-023", "some slices have positions in the patient's axes, others in their volume's",
                object.label, folder.objects[objects[0]].label, "give slices of one frame of reference");
        if (object.frame_of_reference.empty()) {
            absent = &object;
            continue;
        }
        if (!first) first = &object;
        if (object.frame_of_reference != first->frame_of_reference)
            return series_error("E-DCM-023", "the slices of the series have several frames of reference",
                                object.label, first->label, "give slices of one frame of reference");
    }
    if (first && absent)
        context.warn({"W-DCM-004",
                      "some slices do not state a frame of reference",
                      {absent->label, {}, {}, {}, {}},
                      "the frame of the other slices was used"});
    return Nothing{};
}

bool has_word(const std::string& image_type, const char* word) {
    return image_type.find(word) != std::string::npos;
}

Status check_image_types(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                         RunContext& context) {
    std::size_t localizers = 0;
    const DicomObject* one = nullptr;
    for (const std::uint32_t index : objects) {
        const DicomObject& object = folder.objects[index];
        if (has_word(object.image_type, "MOSAIC"))
            return series_error("E-DCM-026", "the image is a mosaic with many slices in one picture",
                                object.label, {}, "convert it to NIfTI, for example with dcm2niix");
        if (!has_word(object.image_type, "LOCALIZER")) continue;
        ++localizers;
        one = &object;
    }
    if (localizers > 0 && localizers < objects.size())
        context.warn({"W-DCM-017",
                      "one of the slices is a localizer (scout image)",
                      {one->label, {}, {}, {}, {}},
                      "it was read like the other slices; check the series"});
    return Nothing{};
}

VoxelType type_of(const PixelFormat& format) {
    if (format.bits_allocated == 8) return format.is_signed ? VoxelType::i8 : VoxelType::u8;
    if (format.bits_allocated == 16) return format.is_signed ? VoxelType::i16 : VoxelType::u16;
    return format.is_signed ? VoxelType::i32 : VoxelType::u32;
}

double value_at(const std::byte* values, VoxelType type, std::size_t i) {
    const auto as = [&]<class T>(T value) {
        std::memcpy(&value, values + i * sizeof(T), sizeof(T));
        return static_cast<double>(value);
    };
    switch (type) {
        case VoxelType::u8:
            return as(std::uint8_t{});
        case VoxelType::i8:
            return as(std::int8_t{});
        case VoxelType::u16:
            return as(std::uint16_t{});
        case VoxelType::i16:
            return as(std::int16_t{});
        case VoxelType::u32:
            return as(std::uint32_t{});
        default:
            return as(std::int32_t{});
    }
}

// The stored values of the frames that a volume needs, frame after frame, read file by file.
class FrameReader {
  public:
    FrameReader(const DicomFolder& folder, const SeriesPlanes& planes, const ReadSeriesOptions& options,
                RunContext& context)
        : folder_(folder), planes_(planes), options_(options), context_(context) {}

    // `place_of[frame]` is where among the values a frame goes, or -1. Returns shared memory of `count`
    // frames.
    Result<SharedBytes> read(const std::vector<std::int64_t>& place_of, std::size_t count) {
        format_ = &folder_.objects[planes_.objects[planes_.frames[0].object]].format;
        size_ = frame_bytes(*format_);
        ANATOMESH_CHECK_STATUS(check_size(count));
        SharedBytes values(size_ * count);
        if (!values.data()) return too_large("the memory does not suffice for the pixels", count);
        of_object_.assign(planes_.objects.size(), {});
        for (std::size_t i = 0; i < place_of.size(); ++i)
            if (place_of[i] >= 0)
                of_object_[planes_.frames[i].object].push_back({planes_.frames[i].frame, place_of[i]});
        std::vector<std::size_t> compressed;
        for (std::size_t o = 0; o < of_object_.size(); ++o) {
            if (of_object_[o].empty()) continue;
            if (context_.cancelled()) return cancelled_error();
            ANATOMESH_TRY(const bool is_compressed, read_object(o, values));
            if (is_compressed) compressed.push_back(o);
            context_.report("read", static_cast<double>(o) / static_cast<double>(of_object_.size()));
        }
        if (compressed.empty()) return values;
        ANATOMESH_CHECK_STATUS(decode(compressed, values));
        return values;
    }

  private:
    struct Wanted {
        std::uint32_t frame;
        std::int64_t place;
    };

    const DicomObject& object(std::size_t o) const { return folder_.objects[planes_.objects[o]]; }

    Error too_large(const char* message, std::size_t count) const {
        return {ErrorKind::limit,
                "E-DCM-022",
                message,
                {planes_.facts.name,
                 {},
                 {},
                 {},
                 fmt::format("{} x {} x {}", format_->columns, format_->rows, count)},
                "give fewer slices"};
    }
    Status check_size(std::size_t count) const {
        std::uint64_t bytes = 0;
        for (const std::uint32_t index : planes_.objects) bytes += folder_.objects[index].bytes;
        const std::uint64_t pixels = std::uint64_t{format_->rows} * format_->columns;  // below 2^32
        if (pixels * count > options_.max_voxels)
            return too_large("the series has more voxels than the limit", count);
        if (size_ * count > std::max(free_bytes, largest_ratio * bytes))
            return too_large("the series announces more pixels than its files can hold", count);
        return Nothing{};
    }

    // Copies the frames of an object; true when they are compressed, and left to the child.
    Result<bool> read_object(std::size_t o, SharedBytes& values) {
        ANATOMESH_TRY(const InputFile file, read_input_file(object(o).path, options_.limits));
        if (file.sha256() != object(o).sha256)
            return series_error("E-DCM-027", "the file changed while it was read", object(o).label, {},
                                "wait until the file is complete, then run the command again");
        ANATOMESH_TRY(const DataSet set, DataSet::parse(as_text(file.bytes()), object(o).label));
        ANATOMESH_TRY(const PixelData data, find_pixel_data(set, *format_, context_));
        if (data.is_compressed) return true;
        for (const Wanted& wanted : of_object_[o]) {
            std::byte* to = values.data() + static_cast<std::size_t>(wanted.place) * size_;
            std::memcpy(to, data.values.data() + wanted.frame * size_, size_);
            normalize({to, size_}, *format_, set.is_big_endian());
        }
        return false;
    }

    Status decode(const std::vector<std::size_t>& compressed, SharedBytes& values) {
        const auto step = [&](std::size_t i) { return decode_object(compressed[i], values); };
        ChildLimits limits;
        limits.memory_bytes += 16 * size_;
        const ChildResult result = run_in_child(compressed.size(), step, limits, context_);
        if (result.cancelled) return cancelled_error();
        if (result.ok) return Nothing{};
        const DicomObject& failed = object(compressed[std::min(result.failure.step, compressed.size() - 1)]);
        return series_error("E-DCM-021", "the pixels cannot be decoded: " + result.failure.reason,
                            failed.label, failed.transfer_syntax.substr(0, 64),
                            "copy or export the file again");
    }

    // In the child.
    std::string decode_object(std::size_t o, SharedBytes& values) const {
        const auto file = read_input_file(object(o).path, options_.limits);
        if (!file.ok()) return "the file cannot be read again";
        const auto set = DataSet::parse(as_text(file.value().bytes()), object(o).label);
        if (!set.ok()) return "the file cannot be read again";
        RunContext ignored;
        const auto data = find_pixel_data(set.value(), *format_, ignored);
        if (!data.ok() || !data.value().is_compressed) return "the file cannot be read again";
        for (const Wanted& wanted : of_object_[o]) {
            const std::span<std::byte> to(values.data() + static_cast<std::size_t>(wanted.place) * size_,
                                          size_);
            const std::string reason = decode_frame(data.value().fragments[wanted.frame],
                                                    set.value().layout().transfer_syntax, *format_, to);
            if (!reason.empty()) return fmt::format("frame {}: {}", wanted.frame + 1, reason);
            normalize(to, *format_, false);
        }
        return {};
    }

    const DicomFolder& folder_;
    const SeriesPlanes& planes_;
    const ReadSeriesOptions& options_;
    RunContext& context_;
    const PixelFormat* format_ = nullptr;
    std::size_t size_ = 0;
    std::vector<std::vector<Wanted>> of_object_;
};

Status check_formats(const DicomFolder& folder, const SeriesPlanes& planes) {
    const PixelFormat& first = folder.objects[planes.objects[0]].format;
    for (const std::uint32_t index : planes.objects) {
        const DicomObject& object = folder.objects[index];
        PixelFormat format = object.format;
        format.frames = first.frames;
        if (format == first) continue;
        return series_error(
            "E-DCM-025", "the slices are stored with different pixel types", object.label,
            fmt::format("{} of {} bits{}, others {} of {}{}", format.bits_stored, format.bits_allocated,
                        format.is_signed ? " signed" : "", first.bits_stored, first.bits_allocated,
                        first.is_signed ? " signed" : ""),
            "give slices of one pixel type");
    }
    if (first.bits_allocated == 1)
        return series_error("E-DCM-025", "the pixels have one bit, and a grey image needs more",
                            planes.labels[0], {}, "give the grey images");
    return Nothing{};
}

// Positions in axes of the volume become the patient's where the options name them; else they stay and it is said.
bool take_axes(SeriesPlanes& planes, bool known_axes, const ReadSeriesOptions& options, RunContext& context) {
    if (known_axes) return true;
    if (!options.frame) {
        context.warn({"W-DCM-026",
                      "the image has positions in axes of its own volume, not of the patient",
                      {planes.facts.name, {}, {}, {}, {}},
                      "the numbers were kept; --frame LPS or --frame RAS names the axes"});
        return false;
    }
    if (*options.frame == ImageFrame::ras) turn_ras_to_lps(planes.frames);
    return true;
}

// Every slice scaled by its own slope, interpolated where slices are missing.
void scale_slices(const SeriesPlanes& planes, const Stack& stack, const std::vector<std::int64_t>& place_of,
                  VoxelType type, std::size_t frame_size, const SharedBytes& values, float* out) {
    const std::size_t pixels = std::size_t{stack.geometry.size[0]} * stack.geometry.size[1];
    const auto at = [&](std::uint32_t frame, std::size_t i) {
        const std::byte* of_frame = values.data() + static_cast<std::size_t>(place_of[frame]) * frame_size;
        return value_at(of_frame, type, i) * planes.frames[frame].slope + planes.frames[frame].intercept;
    };
    for (const StackSlice& slice : stack.slices)
        for (std::size_t i = 0; i < pixels; ++i) {
            const double below = at(slice.below, i);
            *out++ =
                static_cast<float>(slice.t == 0 ? below : below + slice.t * (at(slice.above, i) - below));
        }
}

}  // namespace

Result<SeriesPlanes> series_planes(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                                   RunContext& context) {
    for (const std::uint32_t index : objects) {
        const DicomObject& object = folder.objects[index];
        if (object.damage) return *object.damage;
        if (object.image_error) return *object.image_error;
    }
    SeriesPlanes planes;
    ANATOMESH_TRY(planes.objects, without_duplicates(folder, objects, context));
    ANATOMESH_CHECK_STATUS(check_frame_of_reference(folder, planes.objects, context));
    ANATOMESH_CHECK_STATUS(check_image_types(folder, planes.objects, context));
    const DicomObject& first = folder.objects[planes.objects[0]];
    planes.facts = {planes.objects.size() > 1 ? folder.path : first.label, first.gantry_tilt,
                    first.spacing_between_slices, first.images_in_acquisition, first.slice_thickness};
    for (std::uint32_t o = 0; o < planes.objects.size(); ++o) {
        const DicomObject& object = folder.objects[planes.objects[o]];
        planes.labels.push_back(object.label);
        // The same blemish in every slice is said once.
        for (const Warning& warning : object.image_warnings)
            if (o == 0 || std::none_of(first.image_warnings.begin(), first.image_warnings.end(),
                                       [&](const Warning& w) { return w.code == warning.code; }))
                context.warn(warning);
        for (DicomFrame frame : object.planes) {
            frame.object = o;
            planes.frames.push_back(std::move(frame));
        }
    }
    return planes;
}

Result<LoadedImage> read_dicom_series(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                                      const ReadSeriesOptions& options, RunContext& context) {
    ANATOMESH_TRY(SeriesPlanes planes, series_planes(folder, objects, context));
    const bool known_axes = take_axes(planes, folder.objects[planes.objects[0]].known_axes, options, context);
    StackOptions stacking;
    stacking.volume = options.volume;
    stacking.allow_gaps = options.allow_gaps;
    ANATOMESH_TRY(const Stack stack,
                  stack_frames(planes.frames, planes.labels, planes.facts, stacking, context));
    ANATOMESH_CHECK_STATUS(check_formats(folder, planes));
    ANATOMESH_CHECK_STATUS(check_geometry(stack.geometry, planes.facts.name));

    // Frames in the order of the slices.
    std::vector<std::int64_t> place_of(planes.frames.size(), -1);
    std::int64_t count = 0;
    for (const StackSlice& slice : stack.slices)
        for (const std::uint32_t frame : {slice.below, slice.above})
            if (place_of[frame] < 0) place_of[frame] = count++;
    FrameReader reader(folder, planes, options, context);
    ANATOMESH_TRY(const SharedBytes values, reader.read(place_of, static_cast<std::size_t>(count)));

    const PixelFormat& format = folder.objects[planes.objects[0]].format;
    const DicomFrame& first = planes.frames[stack.slices[0].below];
    const bool is_even =
        !stack.is_uneven && std::all_of(stack.slices.begin(), stack.slices.end(), [&](auto slice) {
            return planes.frames[slice.below].slope == first.slope &&
                   planes.frames[slice.below].intercept == first.intercept;
        });
    RawImage raw;
    raw.geometry = stack.geometry;
    raw.type = type_of(format);
    raw.order = std::endian::native;
    ByteBuffer scaled;
    if (is_even) {
        raw.slope = first.slope;
        raw.intercept = first.intercept;
        raw.data = {values.data(), values.size()};
    } else {
        const std::size_t bytes = stack.geometry.voxel_count() * sizeof(float);
        if (!scaled.reserve(bytes))
            return Error{ErrorKind::limit,
                         "E-DCM-022",
                         "the memory does not suffice for the pixels",
                         {folder.path, {}, {}, {}, {}},
                         "give fewer slices"};
        scaled.set_size(bytes);
        scale_slices(planes, stack, place_of, raw.type, frame_bytes(format), values,
                     reinterpret_cast<float*>(scaled.data()));
        raw.type = VoxelType::f32;
        raw.data = scaled.bytes();
    }
    ANATOMESH_TRY(LoadedImage loaded, to_grey(raw, folder.path, context));
    loaded.kind = FileKind::dicom;
    loaded.known_axes = known_axes;
    loaded.inputs.push_back(hash_of(folder, planes.objects));
    return loaded;
}

InputHash hash_of(const DicomFolder& folder, const std::vector<std::uint32_t>& objects) {
    if (objects.size() == 1) return {folder.path, folder.objects[objects[0]].sha256};
    std::vector<std::string> sums;
    for (const std::uint32_t index : objects) sums.push_back(folder.objects[index].sha256);
    std::sort(sums.begin(), sums.end());
    std::string all;
    for (const std::string& sum : sums) all += sum + "\n";
    return {folder.path, sha256_text(all)};
}

}  // namespace anatomesh
