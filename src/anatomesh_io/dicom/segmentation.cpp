#include "anatomesh_io/dicom/segmentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <utility>

#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh_io/contour/dicom_text.h"
#include "anatomesh_io/dicom/child.h"
#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/decoder.h"
#include "anatomesh_io/dicom/lab_color.h"
#include "anatomesh_io/dicom/object.h"
#include "anatomesh_io/dicom/pixels.h"
#include "anatomesh_io/dicom/segmentation_grid.h"
#include "anatomesh_io/dicom/tags.h"

namespace anatomesh {

namespace {

// Directions of frames agree within this, because files round cosines. [1; 0 to 0.1; D digits of files]
constexpr double same_frame_direction = 1e-3;
// Places of more decimals are not rounded. [decimals; >= 1; D the rounding would be below the tolerance of the grid]
constexpr int most_decimals = 3;
// A place is a whole number of units within it. [units; 0 to 0.5; D digits of a double]
constexpr double whole_tolerance = 1e-6;
// First, last and the frame itself may be rounded where it is held against the grid. [roundings; >= 1; D]
constexpr double most_roundings = 3;
// A frame may be so far off its place in the grid, because files round positions and tables are set to 0.01 mm.
// [spacings; 0 to 0.5; D digits of files]
constexpr double grid_tolerance = 0.02;
// So many slices are allowed whatever the frames are: a label on few slices of a volume is no attack.
// [slices; > 0; B]
constexpr std::uint64_t free_slices = 1000;
// Beyond free_slices a segmentation may have so many slices for each frame that it holds.
// [slices per frame; >= 1; B]
constexpr std::uint64_t largest_sparseness = 100;

enum class SegmentationType : std::uint8_t { binary, fractional, labelmap };

class SegmentationReader {
  public:
    SegmentationReader(const DataSet& set, const ReadSegmentationOptions& options, RunContext& context)
        : set_(set), root_(set.root()), options_(options), context_(context) {}

    Result<LoadedSegmentation> read() {
        ANATOMESH_CHECK_STATUS(check_type());
        ANATOMESH_TRY(format_, read_pixel_format(set_, context_));
        ANATOMESH_CHECK_STATUS(check_format());
        ANATOMESH_TRY(FramesOfObject found, read_frames(set_, context_));
        frames_ = std::move(found.frames);
        if (!found.known_axes)
            context_.warn({"W-DCM-026",
                           "the segmentation has positions in axes of its own volume, not of the patient",
                           place({}), "the numbers were kept"});
        ANATOMESH_CHECK_STATUS(read_segments());
        ANATOMESH_CHECK_STATUS(read_segments_of_frames());
        ANATOMESH_CHECK_STATUS(place_frames());
        ANATOMESH_TRY(const PixelData pixels, find_pixel_data(set_, format_, context_));
        if (pixels.is_compressed) {
            ANATOMESH_CHECK_STATUS(decode(pixels));
        }
        values_ = pixels.is_compressed ? decoded_view() : pixels.values;
        if (type_ == SegmentationType::labelmap) {
            ANATOMESH_CHECK_STATUS(paint_label_map());
        } else {
            ANATOMESH_CHECK_STATUS(paint_segments());
        }
        ANATOMESH_TRY(LoadedSegmentation loaded, finish());
        loaded.known_axes = found.known_axes;
        return loaded;
    }

  private:
    Error error(const char* code, std::string message, std::string value = {}, std::string structure = {},
                std::string slice = {}) const {
        return {ErrorKind::input,
                code,
                std::move(message),
                {set_.name(), std::move(slice), std::move(structure), {}, std::move(value)},
                "correct the segmentation, or export it again"};
    }
    Place place(std::string structure, std::string value = {}) const {
        return {set_.name(), {}, std::move(structure), {}, std::move(value)};
    }
    static std::string frame_name(std::uint32_t frame) { return fmt::format("frame {}", frame + 1); }

    Status check_type() {
        const std::string_view sop_class = root_.text(tags::sop_class);
        const std::string_view type = root_.text(tags::segmentation_type);
        if (sop_class == "1.2.840.10008.5.1.4.1.1.66.7" || type == "LABELMAP") {
            type_ = SegmentationType::labelmap;
            return Nothing{};
        }
        if (sop_class != "1.2.840.10008.5.1.4.1.1.66.4")
            return error("E-SEG-001", "the DICOM object is no segmentation (SEG) of voxels",
                         std::string(sop_class.substr(0, 64)));
        if (type == "BINARY")
            type_ = SegmentationType::binary;
        else if (type == "FRACTIONAL")
            type_ = SegmentationType::fractional;
        else
            return error("E-SEG-006", "the program does not read this type of segmentation",
                         std::string(type.substr(0, 40)));
        return Nothing{};
    }

    Status check_format() const {
        const std::uint32_t bits = format_.bits_allocated;
        const bool fits = type_ == SegmentationType::binary       ? bits == 1
                          : type_ == SegmentationType::fractional ? bits == 8
                                                                  : bits == 8 || bits == 16;
        if (fits && !format_.is_signed) return Nothing{};
        return error("E-SEG-006", "the pixels do not fit the type of the segmentation",
                     fmt::format("{} bits", bits));
    }

    Status read_segments() {
        for (const DicomItem& item : root_.items(tags::segment_sequence)) {
            ANATOMESH_TRY(const auto number, unsigned_short(item, tags::segment_number));
            if (!number) return error("E-SEG-002", "a segment has no number");
            Structure structure;
            structure.number = static_cast<std::int32_t>(*number);
            structure.name = dicom_text(item.text(tags::segment_label), root_.text(tags::character_set)).text;
            if (const std::string_view lab = item.bytes(tags::recommended_color); lab.size() == 6)
                structure.color = color_of_lab(lab, set_.is_big_endian());
            if (!segments_.emplace(*number, std::move(structure)).second)
                return error("E-SEG-002", "two segments have the same number", std::to_string(*number));
        }
        return Nothing{};
    }

    Status read_segments_of_frames() {
        if (type_ == SegmentationType::labelmap) {
            segment_of_frame_.assign(frames_.size(), 0);
            return Nothing{};
        }
        const std::vector<DicomItem> per_frame = root_.items(tags::per_frame_groups);
        const auto shared = root_.item(tags::shared_groups);
        for (std::uint32_t f = 0; f < frames_.size(); ++f) {
            auto item = f < per_frame.size() ? per_frame[f].item(tags::segment_identification_sequence)
                                             : std::nullopt;
            if (!item && shared) item = shared->item(tags::segment_identification_sequence);
            std::optional<std::uint32_t> number;
            if (item) {
                ANATOMESH_TRY(number, unsigned_short(*item, tags::referenced_segment_number));
            }
            if (!number)
                return error("E-SEG-007", "the frame does not name its segment", {}, {}, frame_name(f));
            segment_of_frame_.push_back(*number);
            if (segments_.contains(*number)) continue;
            segments_[*number].number = static_cast<std::int32_t>(*number);
            context_.warn({"W-SEG-003", "frames of a segment that is not declared",
                           place(std::to_string(*number)), "they are kept, without a name"});
        }
        return Nothing{};
    }

    // Where every frame lies on a grid of parallel planes. Planes that are not stored are empty, so that the
    // distance of neighbouring planes is a multiple of the spacing.
    Status place_frames() {
        const Vec3 normal = cross(frames_[0].row, frames_[0].column);
        std::vector<std::uint32_t> order(frames_.size());
        for (std::uint32_t f = 0; f < frames_.size(); ++f) {
            order[f] = f;
            const bool is_parallel = length(frames_[f].row - frames_[0].row) < same_frame_direction &&
                                     length(frames_[f].column - frames_[0].column) < same_frame_direction &&
                                     frames_[f].spacing == frames_[0].spacing;
            if (!is_parallel)
                return error("E-SEG-003", "the frames do not lie in parallel planes of one size", {}, {},
                             frame_name(f));
        }
        const auto height = [&](std::uint32_t f) {
            return dot(frames_[f].position - frames_[0].position, normal);
        };
        std::sort(order.begin(), order.end(), [&](auto a, auto b) { return height(a) < height(b); });
        const std::uint32_t first = order.front(), last = order.back();
        const double span = height(last) - height(first);
        ANATOMESH_TRY(const GridSpacing grid, plane_spacing(order, height));
        const double spacing = grid.mm;
        const double last_slice = std::round(span / spacing);
        if (!(last_slice < static_cast<double>(free_slices + largest_sparseness * frames_.size())))
            return too_large(fmt::format("{:.0f} planes", last_slice + 1));
        slices_ = static_cast<std::uint32_t>(last_slice) + 1;
        // First and last frame tell the step better than the header does, unless their places are rounded.
        const double steps = grid.is_rounded ? span / spacing : last_slice;
        const Vec3 step =
            slices_ > 1 ? (1 / steps) * (frames_[last].position - frames_[first].position) : spacing * normal;
        slice_of_frame_.resize(frames_.size());
        for (std::uint32_t f = 0; f < frames_.size(); ++f) {
            const double slice =
                slices_ > 1 ? std::round((height(f) - height(first)) / span * last_slice) : 0;
            const Vec3 expected = frames_[first].position + slice * step;
            if (length(expected - frames_[f].position) >
                std::max(grid_tolerance * spacing, most_roundings * rounding_of_places()))
                return error("E-SEG-004", "the frames are not equidistant",
                             fmt::format("off by {:.3g} mm", length(expected - frames_[f].position)), {},
                             frame_name(f));
            slice_of_frame_[f] = static_cast<std::uint32_t>(slice);
        }
        geometry_ = {
            {format_.columns, format_.rows, slices_},
            frames_[first].position,
            {frames_[0].spacing[0] * frames_[0].row, frames_[0].spacing[1] * frames_[0].column, step}};
        // Planes that are empty are not stored, so that the last one stored need not be the last of the image.
        const std::vector<double> images = heights_of_images();
        ends_at_image_ = {!images.empty() && height(first) < images.front() + spacing / 2,
                          !images.empty() && height(last) > images.back() - spacing / 2};
        if (std::uint64_t{format_.columns} * format_.rows * slices_ > options_.max_voxels)
            return too_large(fmt::format("{} x {} x {} voxels", format_.columns, format_.rows, slices_));
        return check_frames_once();
    }

    Error too_large(std::string value) const {
        Error found = error("E-SEG-009", "the segmentation is larger than the limit", std::move(value));
        found.kind = ErrorKind::limit;
        return found;
    }

    // `order`: the frames from the lowest to the highest.
    template <class Height>
    Result<GridSpacing> plane_spacing(const std::vector<std::uint32_t>& order, Height height) const {
        const auto shared = root_.item(tags::shared_groups);
        const auto per_frame = root_.item(tags::per_frame_groups);
        FrameHeights heights;
        for (const auto& groups : {shared, per_frame}) {
            const auto measures = groups ? groups->item(tags::pixel_measures_sequence) : std::nullopt;
            if (!measures) continue;
            ANATOMESH_TRY(const auto distance, decimal(*measures, tags::spacing_between_slices));
            ANATOMESH_TRY(const auto thick, decimal(*measures, tags::slice_thickness));
            if (!heights.stated_mm) heights.stated_mm = distance;
            if (!heights.thickness_mm) heights.thickness_mm = thick;
        }
        std::vector<double> frames(order.size());
        std::transform(order.begin(), order.end(), frames.begin(), height);
        const std::vector<double> images = heights_of_images();
        heights.frames = frames;
        heights.images = images;
        heights.rounding_mm = rounding_of_places();
        const GridSpacing grid = grid_spacing(heights);
        if (grid.source == GridSource::none && frames.back() - frames.front() < 1e-4)
            return error("E-SEG-004", "the segmentation has a single plane and does not state its thickness");
        if (grid.source == GridSource::none)
            return error(
                "E-SEG-004", "the frames are at uneven distances, and no spacing of planes fits them",
                heights.stated_mm      ? fmt::format("spacing between slices {:.4g} mm", *heights.stated_mm)
                : heights.thickness_mm ? fmt::format("slice thickness {:.4g} mm", *heights.thickness_mm)
                                       : std::string{});
        const bool is_stated = heights.stated_mm.value_or(0) != 0 || heights.thickness_mm.value_or(0) > 0;
        if (grid.source == GridSource::frames && !is_stated)
            context_.warn(
                {"W-SEG-008", "nothing says how far apart the planes of the segmentation are",
                 place({}, fmt::format("{:.4g} mm", grid.mm)),
                 "the distances of its frames were taken for it; put the images that it was made of beside "
                 "it"});
        if (grid.is_rounded)
            context_.warn(
                {"W-SEG-009",
                 fmt::format("the places of the frames are rounded by up to {:.3g} mm, and fit planes "
                             "{:.4g} mm apart, as the file states",
                             heights.rounding_mm, grid.mm),
                 place({}), "they were taken for these planes"});
        if (grid.skips_a_thickness)
            context_.warn(
                {"W-SEG-007",
                 fmt::format("all frames are {:.4g} mm apart, twice the stated slice thickness of {:.4g} "
                             "mm",
                             grid.mm, *heights.thickness_mm),
                 place({}),
                 "they were taken for neighbouring slices with gaps between them, so that nothing is "
                 "missing"});
        return grid;
    }

    // How far the file's rounding moves a frame along the normal at most: half a unit of the last decimal of each coordinate
    // that differs from frame to frame. 0 where places have many decimals.
    double rounding_of_places() const {
        const Vec3 normal = cross(frames_[0].row, frames_[0].column);
        double rounding = 0;
        for (const auto coordinate : {&Vec3::x, &Vec3::y, &Vec3::z}) {
            const bool differs = std::any_of(frames_.begin(), frames_.end(), [&](const auto& frame) {
                return frame.position.*coordinate != frames_[0].position.*coordinate;
            });
            if (!differs) continue;
            double unit = 1;
            const auto is_whole = [&](const auto& frame) {
                const double times = frame.position.*coordinate / unit;
                return std::abs(times - std::round(times)) < whole_tolerance;
            };
            for (int decimals = 0; !std::all_of(frames_.begin(), frames_.end(), is_whole); ++decimals) {
                if (decimals == most_decimals) return 0;
                unit /= 10;
            }
            rounding += 0.5 * unit * std::abs(normal.*coordinate);
        }
        return rounding;
    }

    // Of the images beside the segmentation, along the frames' normal.
    std::vector<double> heights_of_images() const {
        std::vector<double> heights;
        const Vec3 normal = cross(frames_[0].row, frames_[0].column);
        for (const Vec3& position : options_.image_positions)
            heights.push_back(dot(position - frames_[0].position, normal));
        std::sort(heights.begin(), heights.end());
        return heights;
    }

    Status check_frames_once() {
        std::map<std::uint32_t, std::vector<std::uint32_t>> slices_of_segment;
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> seen;
        for (std::uint32_t f = 0; f < frames_.size(); ++f) {
            const auto [before, is_new] =
                seen.emplace(std::pair{segment_of_frame_[f], slice_of_frame_[f]}, f);
            if (!is_new)
                return error("E-SEG-008", "two frames of one segment lie in one plane",
                             frame_name(before->second), std::to_string(segment_of_frame_[f]), frame_name(f));
            slices_of_segment[segment_of_frame_[f]].push_back(slice_of_frame_[f]);
        }
        for (auto& [segment, slices] : slices_of_segment) {
            const auto [low, high] = std::minmax_element(slices.begin(), slices.end());
            const std::size_t missing = *high - *low + 1 - slices.size();
            if (missing == 0) continue;
            context_.warn({"W-SEG-004",
                           fmt::format("{} planes are missing between the frames of a segment", missing),
                           place(name_of(segment)), "they were read as empty, as the format allows"});
        }
        return Nothing{};
    }

    std::string name_of(std::uint32_t segment) const {
        const auto found = segments_.find(segment);
        return found == segments_.end() || found->second.name.empty() ? fmt::format("number {}", segment)
                                                                      : found->second.name;
    }

    Status decode(const PixelData& pixels) {
        const std::size_t bytes = frame_bytes(format_);
        std::uint64_t compressed = 0;
        for (const auto& fragments : pixels.fragments)
            for (const std::string_view fragment : fragments) compressed += fragment.size();
        // Up to this size compressed frames may claim anything, because that much memory is always there.
        // [bytes; > 0; B]
        constexpr std::uint64_t free_frame_bytes = std::uint64_t{256} << 20;
        // Beyond free_frame_bytes they may claim so many times their size: no codec of images packs better.
        // [1; > 1; B]
        constexpr std::uint64_t largest_frame_ratio = 1000;
        if (bytes * frames_.size() > std::max(free_frame_bytes, largest_frame_ratio * compressed))
            return too_large("more pixels than the compressed data can hold");
        decoded_.emplace(bytes * frames_.size());
        if (!decoded_->data()) return too_large("no memory for the pixels");
        const auto step = [&](std::size_t f) {
            const std::span<std::byte> to(decoded_->data() + f * bytes, bytes);
            std::string reason =
                decode_frame(pixels.fragments[f], set_.layout().transfer_syntax, format_, to);
            return reason;
        };
        const ChildResult result = run_in_child(frames_.size(), step, {}, context_);
        if (result.cancelled) return cancelled_error();
        if (result.ok) return Nothing{};
        return error("E-SEG-010", "the pixels cannot be decoded: " + result.failure.reason, {}, {},
                     frame_name(static_cast<std::uint32_t>(result.failure.step)));
    }
    std::string_view decoded_view() const {
        return {reinterpret_cast<const char*>(decoded_->data()), decoded_->size()};
    }

    // Calls inside(voxel) for every pixel of the frame that is in its segment.
    template <class Inside>
    void for_each_inside(std::uint32_t frame, double lowest, Inside inside) const {
        const std::size_t pixels = std::size_t{format_.columns} * format_.rows;
        const std::size_t voxel = slice_of_frame_[frame] * pixels;
        const auto* bytes = reinterpret_cast<const unsigned char*>(values_.data());
        if (type_ == SegmentationType::fractional) {
            for (std::size_t i = 0; i < pixels; ++i)
                if (bytes[frame * pixels + i] >= lowest) inside(voxel + i);
            return;
        }
        // Bits are packed over the ends of rows and frames, the lowest first.
        const std::size_t first = frame * pixels;
        for (std::size_t i = 0; i < pixels; ++i) {
            const std::size_t bit = first + i;
            if (bit % 8 == 0 && bytes[bit / 8] == 0 && i + 8 <= pixels) {
                i += 7;
                continue;
            }
            if (bytes[bit / 8] >> (bit % 8) & 1) inside(voxel + i);
        }
    }

    Status paint_segments() {
        double lowest = 0;
        if (type_ == SegmentationType::fractional) {
            ANATOMESH_TRY(const auto stated, unsigned_short(root_, tags::maximum_fractional_value));
            const std::uint32_t most = stated.value_or(255);
            if (most == 0 || most > 255)
                return error("E-SEG-006", "MaximumFractionalValue is not possible", std::to_string(most));
            lowest = std::max(1.0, options_.threshold * most);
            context_.warn(
                {"W-SEG-001",
                 fmt::format("the segmentation holds fractions ({})",
                             root_.text(tags::fractional_type) == "OCCUPANCY" ? "occupancy" : "probability"),
                 place({}),
                 fmt::format("voxels from {} of the maximum on were read as inside", options_.threshold)});
        }
        std::map<std::uint32_t, std::vector<std::uint32_t>> frames_of_segment;
        for (std::uint32_t f = 0; f < frames_.size(); ++f)
            frames_of_segment[segment_of_frame_[f]].push_back(f);
        for (const auto& [segment, structure] : segments_) {
            if (context_.cancelled()) return cancelled_error();
            const std::vector<std::uint32_t>& own = frames_of_segment[segment];
            bool is_empty = true;
            for (const std::uint32_t f : own)
                for_each_inside(f, lowest, [&](std::size_t) { is_empty = false; });
            if (is_empty) {
                context_.warn(
                    {"W-SEG-002", "the segment is empty", place(name_of(segment)), "it was left out"});
                continue;
            }
            LabelMap& layer = layer_for(own, lowest);
            layer.structures.push_back(structure);
            const auto label = static_cast<std::uint16_t>(layer.structures.size());
            for (const std::uint32_t f : own)
                for_each_inside(f, lowest, [&](std::size_t voxel) { layer.voxels[voxel] = label; });
        }
        if (layers_.size() > 1)
            context_.warn({"W-SEG-005", "segments overlap", place({}),
                           fmt::format("they were read as {} layers, and the structures overlap in the model",
                                       layers_.size())});
        return Nothing{};
    }

    // The first layer in which all voxels of these frames are free.
    LabelMap& layer_for(const std::vector<std::uint32_t>& own, double lowest) {
        for (LabelMap& layer : layers_) {
            bool is_free = true;
            for (const std::uint32_t f : own)
                for_each_inside(f, lowest,
                                [&](std::size_t voxel) { is_free = is_free && layer.voxels[voxel] == 0; });
            if (is_free) return layer;
        }
        return new_layer();
    }
    LabelMap& new_layer() {
        LabelMap& layer = layers_.emplace_back();
        layer.geometry = geometry_;
        layer.voxels.assign(geometry_.voxel_count(), 0);
        layer.source = set_.name();
        layer.ends_at_image = ends_at_image_;
        return layer;
    }

    Status paint_label_map() {
        LabelMap& layer = new_layer();
        const std::size_t pixels = std::size_t{format_.columns} * format_.rows;
        const std::size_t size = format_.bits_allocated / 8;
        const bool big = set_.is_big_endian() && !decoded_;
        const auto value = [&](std::size_t n) -> std::uint32_t {
            const auto* bytes = reinterpret_cast<const unsigned char*>(values_.data()) + n * size;
            if (size == 1) return bytes[0];
            return static_cast<std::uint32_t>(bytes[big ? 0 : 1] << 8 | bytes[big ? 1 : 0]);
        };
        std::vector<std::uint8_t> is_used(65536, 0);
        for (std::size_t n = 0; n < pixels * frames_.size(); ++n) is_used[value(n)] = 1;
        std::vector<std::uint16_t> label_of(65536, 0);
        for (std::uint32_t number = 1; number < 65536; ++number) {
            const auto declared = segments_.find(number);
            if (!is_used[number]) {
                if (declared != segments_.end())
                    context_.warn(
                        {"W-SEG-002", "the segment is empty", place(name_of(number)), "it was left out"});
                continue;
            }
            Structure structure;
            structure.number = static_cast<std::int32_t>(number);
            if (declared != segments_.end())
                structure = declared->second;
            else
                context_.warn({"W-SEG-003", "frames of a segment that is not declared",
                               place(name_of(number)), "they are kept, without a name"});
            layer.structures.push_back(std::move(structure));
            label_of[number] = static_cast<std::uint16_t>(layer.structures.size());
        }
        for (std::size_t f = 0; f < frames_.size(); ++f)
            for (std::size_t i = 0; i < pixels; ++i)
                layer.voxels[slice_of_frame_[f] * pixels + i] = label_of[value(f * pixels + i)];
        if (layer.structures.empty()) layers_.clear();
        return Nothing{};
    }

    Result<LoadedSegmentation> finish() {
        if (layers_.empty()) return error("E-SEG-005", "all segments are empty");
        LoadedSegmentation loaded;
        loaded.layers = std::move(layers_);
        renumber_zero(loaded.layers);
        constexpr const char* names[] = {"BINARY", "FRACTIONAL", "LABELMAP"};
        loaded.type = names[static_cast<int>(type_)];
        loaded.frames = static_cast<std::uint32_t>(frames_.size());
        return loaded;
    }

    // 0 is the outside in everything that comes after.
    void renumber_zero(std::vector<LabelMap>& layers) {
        std::int32_t largest = 0;
        Structure* zero = nullptr;
        for (LabelMap& layer : layers)
            for (Structure& structure : layer.structures) {
                largest = std::max(largest, structure.number);
                if (structure.number == 0) zero = &structure;
            }
        if (!zero) return;
        zero->number = largest + 1;
        context_.warn({"W-SEG-006", "a segment has the number 0, which is reserved for outside",
                       place(zero->name, "0"), fmt::format("it was given the number {}", zero->number)});
        for (LabelMap& layer : layers) sort_structures(layer);
    }
    static void sort_structures(LabelMap& layer) {
        std::vector<std::uint16_t> order(layer.structures.size());
        for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint16_t>(i);
        std::sort(order.begin(), order.end(),
                  [&](auto a, auto b) { return layer.structures[a].number < layer.structures[b].number; });
        std::vector<std::uint16_t> new_label(order.size() + 1, 0);
        std::vector<Structure> sorted;
        for (std::size_t i = 0; i < order.size(); ++i) {
            sorted.push_back(layer.structures[order[i]]);
            new_label[order[i] + 1u] = static_cast<std::uint16_t>(i + 1);
        }
        layer.structures = std::move(sorted);
        for (std::uint16_t& voxel : layer.voxels) voxel = new_label[voxel];
    }

    const DataSet& set_;
    DicomItem root_;
    const ReadSegmentationOptions& options_;
    RunContext& context_;

    SegmentationType type_ = SegmentationType::binary;
    PixelFormat format_;
    std::vector<DicomFrame> frames_;
    std::map<std::uint32_t, Structure> segments_;
    std::vector<std::uint32_t> segment_of_frame_, slice_of_frame_;
    std::uint32_t slices_ = 0;
    ImageGeometry geometry_;
    std::array<bool, 2> ends_at_image_{};
    std::string_view values_;
    std::optional<SharedBytes> decoded_;
    std::vector<LabelMap> layers_;
};

}  // namespace

Result<LoadedSegmentation> read_dicom_segmentation(std::string_view file, const std::string& name,
                                                   const ReadSegmentationOptions& options,
                                                   RunContext& context) {
    ANATOMESH_TRY(const DataSet set, DataSet::parse(file, name));
    warn_of_guess(set.layout(), name, context);
    return SegmentationReader(set, options, context).read();
}

}  // namespace anatomesh
