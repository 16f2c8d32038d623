#include "dicom_outputs.h"

#include <tuple>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh_io/dicom/voxelize.h"
#include "anatomesh_io/dicom/write_objects.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "help_text.h"
#include "option_values.h"
#include "outputs.h"

namespace anatomesh {

std::vector<std::string> DicomOutputs::paths() const {
    std::vector<std::string> all;
    if (!surface.empty()) all.push_back(surface);
    if (!obj.empty()) all.push_back(obj);
    if (!segmentation.empty()) all.push_back(segmentation);
    return all;
}

void add_dicom_output_options(CLI::App& verb, DicomOutputs& outputs) {
    add_text(verb, "--dicom-surface", outputs.surface, "FILE",
             "Also write the surface as a DICOM object of the input's study (Encapsulated STL): .dcm");
    add_text(verb, "--dicom-obj", outputs.obj, "FILE",
             "Also write the surface as a DICOM object in double precision (Encapsulated OBJ): .dcm");
    add_text(verb, "--dicom-segmentation", outputs.segmentation, "FILE",
             "Also write the model as a DICOM segmentation on the grid of the input's images: .dcm");
    group_new_options(verb, option_group::outputs);
}

Status check_dicom_outputs(const DicomOutputs& outputs) {
    for (const std::string& path : outputs.paths()) {
        ANATOMESH_CHECK_STATUS(check_extension(path, {".dcm"}));
    }
    return Nothing{};
}

Status add_dicom_outputs(const Model& model, const DicomSource& source, const DicomOutputs& outputs,
                         AtomicFileSet& files, RunContext& context) {
    if (outputs.paths().empty()) return Nothing{};
    if (model.report.conventions.space != "LPS")
        return Error{ErrorKind::usage,
                     "E-CMD-018",
                     "the axes of the model are unknown, and DICOM needs them",
                     {outputs.paths()[0], "", "", "", ""},
                     "give --frame LPS or --frame RAS"};
    SurfaceFile surface;
    if (!outputs.surface.empty() || !outputs.obj.empty()) {
        surface.surface = extract_interfaces(model.mesh);
        surface.description.structures = model.structures;
        surface.description.regions = model.regions;
    }
    for (const auto& [path, kind, name] : {std::tuple{&outputs.surface, SurfaceObject::stl, "surface.stl"},
                                           {&outputs.obj, SurfaceObject::obj, "surface.obj"}}) {
        if (path->empty()) continue;
        ANATOMESH_TRY(const std::string bytes, format_surface(name, surface, context));
        ANATOMESH_TRY(const std::string object, format_encapsulated(kind, bytes, "model surface", source));
        ANATOMESH_CHECK_STATUS(files.add(*path, object));
    }
    if (!outputs.segmentation.empty()) {
        VoxelModel voxels;
        voxels.geometry =
            source.grid ? *source.grid : grid_around(model.mesh, model.report.lengths.size_mm / 2);
        voxels.regions = voxelize(model.mesh, voxels.geometry, context);
        voxels.structures = model.structures;
        voxels.members = model.regions.members;
        if (context.cancelled()) return cancelled_error();
        ANATOMESH_TRY(const std::string object, format_segmentation(voxels, source));
        ANATOMESH_CHECK_STATUS(files.add(outputs.segmentation, object));
    }
    return Nothing{};
}

}  // namespace anatomesh
