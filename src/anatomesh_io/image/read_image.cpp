#include "anatomesh_io/image/read_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

namespace {

Error not_an_image(FileKind kind, std::span<const std::byte> start, const std::string& path) {
    const std::string readable = "give a NIfTI, NRRD or MetaImage file or an InVesalius project";
    if (kind == FileKind::unknown && start.empty())
        return image_error("E-IMG-001", "the file is empty", path, "", readable);
    if (kind == FileKind::unknown)
        return image_error("E-IMG-001", "the format of the file is not known", path, "", readable);
    if (kind == FileKind::dicom || kind == FileKind::dicom_segmentation) {
        const std::string uid = dicom_sop_class(start);
        const std::string name = dicom_sop_class_name(uid);
        return image_error("E-IMG-002",
                           fmt::format("the program does not read DICOM objects of this kind{}",
                                       name.empty() ? "" : ": " + name),
                           path, shown(uid),
                           "convert it to NIfTI or NRRD, for example with dcmqi or 3D Slicer");
    }
    return image_error("E-IMG-001", fmt::format("the file is no image; its kind is: {}", name_of(kind)), path,
                       "", readable);
}

Result<RawImage> read_raw(const InputFile& file, FileKind kind, std::span<const std::byte> content,
                          const ReadImageOptions& options, RunContext& context) {
    switch (kind) {
        case FileKind::nifti:
            return read_nifti(file, options, context);
        case FileKind::nrrd:
            return read_nrrd(file, content, options, context);
        case FileKind::metaimage:
            return read_metaimage(file, content, options, context);
        case FileKind::invesalius:
            return read_invesalius(file, content, options, context);
        default:
            return not_an_image(kind, content, file.path);
    }
}

}  // namespace

Result<LoadedImage> read_image(const std::string& path, const ReadImageOptions& options,
                               RunContext& context) {
    ANATOMESH_TRY(const InputFile file, read_input_file(path, options.limits));
    const auto bytes = file.bytes();
    const FileKind kind = detect_bytes(bytes.first(std::min<std::size_t>(bytes.size(), 65536)));
    context.report("read", 0);

    // NIfTI checks its header before it inflates the rest; the others have no length to check before.
    ByteBuffer inflated;
    std::span<const std::byte> content = bytes;
    const bool other_image =
        kind == FileKind::nrrd || kind == FileKind::metaimage || kind == FileKind::invesalius;
    std::string hash;
    std::optional<Result<ByteBuffer>> whole;
    parallel_tasks(context.threads, {[&] {
                                         if (is_gzip(bytes) && other_image)
                                             whole.emplace(inflate(bytes, path, options.limits, context));
                                     },
                                     [&] { hash = file.sha256(); }});
    if (whole) {
        ANATOMESH_TRY(inflated, std::move(*whole));
        content = inflated.bytes();
    }
    ANATOMESH_TRY(const RawImage raw, read_raw(file, kind, content, options, context));
    ANATOMESH_TRY(LoadedImage loaded, to_grey(raw, path, context));
    loaded.kind = kind;
    loaded.poses = raw.poses;
    loaded.known_axes = raw.poses.empty() || options.frame;
    loaded.inputs.push_back({path, hash});
    loaded.inputs.insert(loaded.inputs.end(), raw.further_inputs.begin(), raw.further_inputs.end());
    context.report("read", 1);
    return loaded;
}

}  // namespace anatomesh
