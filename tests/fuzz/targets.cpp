#include "targets.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "anatomesh_io/contour/csl_reader.h"
#include "anatomesh_io/contour/json_reader.h"
#include "anatomesh_io/contour/raw_builder.h"
#include "anatomesh_io/contour/rtstruct_reader.h"
#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/object.h"
#include "anatomesh_io/dicom/pixels.h"
#include "anatomesh_io/dicom/segmentation.h"
#include "anatomesh_io/dicom/stack.h"
#include "anatomesh_io/image/raw_image.h"
#include "anatomesh_io/project/read_project.h"
#include "anatomesh_io/project/record_line.h"
#include "seeds.h"

namespace anatomesh::fuzz {

namespace {

void expect(bool kept, const char* promise) {
    if (kept) return;
    std::fprintf(stderr, "broken: %s\n", promise);
    std::abort();
}

// ---- contours

ContourLimits small_limits() {
    ContourLimits limits;
    limits.points = 100'000;
    return limits;
}

void expect_sound(const RawContours& raw) {
    for (const Vec3& p : raw.points)
        expect(std::abs(p.x) <= 1e7 && std::abs(p.y) <= 1e7 && std::abs(p.z) <= 1e7, "points within 1e7 mm");
    for (const RawContour& contour : raw.contours) {
        expect(contour.structure < raw.structures.size(), "contours of structures there are");
        expect(std::size_t{contour.first_point} + contour.point_count <= raw.points.size(),
               "points of contours");
        expect(contour.plane < static_cast<std::int32_t>(raw.planes.size()), "planes there are");
    }
}

template <Status (*reader)(std::string_view, RawBuilder&)>
void read_contour_file(std::string_view bytes) {
    RunContext context;
    RawBuilder builder("input", small_limits(), context);
    if (!reader(bytes, builder).ok()) return;
    const auto raw = builder.finish(FileFrame::lps);
    if (raw.ok()) expect_sound(raw.value());
}

// ---- projects

void expect_sound(const Drawing& drawing) {
    for (const auto* table : {&drawing.rings(), &drawing.proposals()}) {
        for (const auto& entry : table->entries()) {
            expect(drawing.structure(entry.key.structure) && drawing.plane(entry.key.plane),
                   "rings of a structure and on a plane that are there");
            for (const DrawnRing& ring : entry.value->rings)
                expect(ring.point_count >= 3 &&
                           std::size_t{ring.first_point} + ring.point_count <= entry.value->points.size(),
                       "points of rings");
        }
    }
}

// Every line is a record; its checksum is right, so that what is in it is read.
void read_project_records(std::string_view bytes) {
    std::string text;
    while (!bytes.empty()) {
        const std::size_t end = std::min(bytes.find('\n'), bytes.size());
        text += record_line(bytes.substr(0, end));
        bytes.remove_prefix(std::min(end + 1, bytes.size()));
    }
    RunContext context;
    ReadProjectOptions options;
    options.limits.points = 100'000;
    options.readable_part = true;
    auto project = replay_project(text, "input", options, context);
    if (!project.ok()) return;
    EditHistory& history = project.value().history;
    expect_sound(history.drawing());
    while (history.undo().value()) expect_sound(history.drawing());
    expect(history.drawing().planes().entries().empty(), "nothing is drawn at the begin");
}

// ---- DICOM

void read_dicom_header(std::string_view bytes) {
    DataSet partial;
    const auto set = DataSet::parse(bytes, "input", &partial);
    const DicomObject object = describe_object(set.ok() ? set.value() : partial, "input", "input");
    if (!set.ok() || object.image_error || object.planes.empty()) return;
    RunContext context;
    for (const DicomFrame& frame : object.planes) {
        expect(frame.spacing[0] > 0 && frame.spacing[1] > 0, "pixels of some size");
        expect(std::abs(length(frame.row) - 1) < 1e-9 && std::abs(dot(frame.row, frame.column)) < 1e-9,
               "axes at right angles");
    }
    const auto pixels = find_pixel_data(set.value(), object.format, context);
    if (!pixels.ok()) return;
    if (!pixels.value().is_compressed)
        expect(pixels.value().values.size() * 8 >= object.format.frame_bits() * object.format.frames,
               "pixels of all frames");
    SeriesFacts facts;
    facts.name = "input";
    const auto stack = stack_frames(object.planes, {"input"}, facts, {}, context);
    if (stack.ok())
        expect(stack.value().slices.size() == stack.value().geometry.size[2],
               "a slice for each plane of the stack");
}

void read_seg(std::string_view bytes) {
    const auto set = DataSet::parse(bytes, "input");
    // Compressed pixels are decoded in a process of their own, by a library with fuzzers of its own.
    if (set.ok() && set.value().root().fragments({0x7FE0, 0x0010}).size() > 0) return;
    RunContext context;
    ReadSegmentationOptions options;
    options.max_voxels = 1 << 20;
    const auto loaded = read_dicom_segmentation(bytes, "input", options, context);
    if (!loaded.ok()) return;
    for (const LabelMap& layer : loaded.value().layers) {
        expect(layer.voxels.size() == layer.geometry.voxel_count(), "a label a voxel");
        for (const std::uint16_t label : layer.voxels)
            expect(label <= layer.structures.size(), "labels of structures there are");
    }
}

// ---- images

template <class Reader>
void read_image_file(std::string_view bytes, Reader&& reader) {
    InputFile file;
    file.path = "input";
    if (!file.content.reserve(bytes.size())) return;
    if (!bytes.empty()) std::memcpy(file.content.data(), bytes.data(), bytes.size());
    file.content.set_size(bytes.size());
    RunContext context;
    ReadImageOptions options;
    options.max_voxels = 1 << 20;
    options.limits.max_inflated_bytes = 1 << 22;
    options.limits.free_inflated_bytes = 1 << 20;
    options.frame = ImageFrame::lps;
    options.assume_orientation = "LPS";
    options.tracked = true;
    const auto raw = reader(file, options, context);
    if (!raw.ok()) return;
    const auto loaded = to_grey(raw.value(), "input", context);
    if (!loaded.ok()) return;
    expect(loaded.value().image.voxels.size() == raw.value().geometry.voxel_count(), "a value a voxel");
    for (const float value : loaded.value().image.voxels) expect(std::isfinite(value), "finite values");
    if (!looks_like_label_map(loaded.value().facts)) return;
    const auto labels = to_label_map(loaded.value(), context);
    if (!labels.ok()) return;
    for (const std::uint16_t label : labels.value().voxels)
        expect(label <= labels.value().structures.size(), "labels of structures there are");
}

void read_nifti_file(std::string_view bytes) {
    read_image_file(bytes, [](const InputFile& file, const ReadImageOptions& options, RunContext& context) {
        return read_nifti(file, options, context);
    });
}

using ContentReader = Result<RawImage> (*)(const InputFile&, std::span<const std::byte>,
                                           const ReadImageOptions&, RunContext&);
template <ContentReader reader>
void read_content(std::string_view bytes) {
    read_image_file(
        bytes,
        [](const InputFile& file, const ReadImageOptions& options, RunContext& context) -> Result<RawImage> {
            static ByteBuffer inflated;
            if (!is_gzip(file.bytes())) return reader(file, file.bytes(), options, context);
            ANATOMESH_TRY(inflated, inflate(file.bytes(), file.path, options.limits, context));
            return reader(file, inflated.bytes(), options, context);
        });
}

constexpr Target all[] = {{"dicom_series", read_dicom_header, dicom_series_seeds},
                          {"rtstruct", read_contour_file<read_rtstruct>, rtstruct_seeds},
                          {"seg", read_seg, seg_seeds},
                          {"nifti", read_nifti_file, nifti_seeds},
                          {"nrrd", read_content<read_nrrd>, nrrd_seeds},
                          {"metaimage", read_content<read_metaimage>, metaimage_seeds},
                          {"contour_json", read_contour_file<read_json_contours>, contour_json_seeds},
                          {"project", read_project_records, project_seeds},
                          {"csl", read_contour_file<read_csl>, csl_seeds},
                          {"inv3", read_content<read_invesalius>, inv3_seeds}};

}  // namespace

std::span<const Target> targets() {
    return all;
}

const Target* find_target(std::string_view name) {
    for (const Target& target : all)
        if (name == target.name) return &target;
    return nullptr;
}

}  // namespace anatomesh::fuzz
