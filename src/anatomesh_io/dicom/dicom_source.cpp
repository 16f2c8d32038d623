#include "anatomesh_io/dicom/dicom_source.h"

#include <algorithm>

#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/read_series.h"
#include "anatomesh_io/dicom/sha256.h"
#include "anatomesh_io/dicom/stack.h"
#include "anatomesh_io/dicom/tags.h"
#include "anatomesh_io/file/byte_reader.h"

namespace anatomesh {

namespace {

Status read_identity(const DicomObject& object, DicomSource& source) {
    ANATOMESH_TRY(const InputFile file, read_input_file(object.path, {}));
    ANATOMESH_TRY(const DataSet set, DataSet::parse(as_text(file.bytes()), object.label));
    const DicomItem root = set.root();
    const auto text = [&](DicomTag tag) { return std::string(root.text(tag)); };
    source.character_set = text(tags::character_set);
    source.patient_name = text(tags::patient_name);
    source.patient_id = text(tags::patient_id);
    source.birth_date = text(tags::patient_birth_date);
    source.sex = text(tags::patient_sex);
    source.study_date = text(tags::study_date);
    source.study_time = text(tags::study_time);
    source.study_id = text(tags::study_id);
    source.accession = text(tags::accession_number);
    source.referring_physician = text(tags::referring_physician);
    return Nothing{};
}

// The volume of the images, without a word on what is wrong with it: whoever reads them says that.
std::optional<ImageGeometry> grid_of(const DicomFolder& folder, const std::vector<std::uint32_t>& objects) {
    RunContext quiet;
    const auto planes = series_planes(folder, objects, quiet);
    if (!planes.ok() || planes.value().frames.empty()) return std::nullopt;
    const auto stack =
        stack_frames(planes.value().frames, planes.value().labels, planes.value().facts, {}, quiet);
    if (!stack.ok()) return std::nullopt;
    const ImageGeometry& grid = stack.value().geometry;
    const double shear = length(cross(grid.step[2], cross(grid.step[0], grid.step[1])));
    const double scale = length(grid.step[2]) * length(grid.step[0]) * length(grid.step[1]);
    if (shear > 1e-4 * scale || grid.size[0] > 65535 || grid.size[1] > 65535) return std::nullopt;
    return grid;
}

}  // namespace

std::string replaced_uid(const std::string& uid) {
    return uid.empty() ? std::string{} : derived_uid("anatomesh UID\n" + uid);
}

Result<DicomSource> dicom_source(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                                 bool keep_identity, const std::vector<std::uint32_t>& also) {
    const auto shown = [&](const std::string& uid) { return keep_identity ? uid : replaced_uid(uid); };
    const DicomObject& first = folder.objects[objects[0]];
    DicomSource source;
    source.keeps_identity = keep_identity;
    source.study = shown(first.study);
    source.series = shown(first.series);
    // What is written lies in the patient's axes, and the images do not where they have axes of their own.
    if (first.known_axes) source.frame_of_reference = shown(first.frame_of_reference);
    for (const std::uint32_t index : objects) {
        const DicomObject& object = folder.objects[index];
        if (object.kind != DicomKind::image || object.planes.empty() || object.sop_instance.empty() ||
            !object.known_axes)
            continue;
        const DicomFrame& plane = object.planes[0];
        source.images.push_back({object.sop_class, shown(object.sop_instance), plane.position,
                                 cross(plane.row, plane.column), object.frames});
    }
    for (const auto* list : {&objects, &also}) {
        for (const std::uint32_t index : *list) {
            const DicomObject& object = folder.objects[index];
            if (object.sop_class.empty() || object.sop_instance.empty()) continue;
            source.origins.push_back(
                {shown(object.study), shown(object.series), object.sop_class, shown(object.sop_instance)});
        }
    }
    std::sort(source.origins.begin(), source.origins.end());
    source.origins.erase(std::unique(source.origins.begin(), source.origins.end()), source.origins.end());
    if (first.kind == DicomKind::image && first.known_axes) source.grid = grid_of(folder, objects);
    if (keep_identity) {
        ANATOMESH_CHECK_STATUS(read_identity(first, source));
    }
    return source;
}

}  // namespace anatomesh
