// What the verb model writes besides as DICOM: its surface (Encapsulated STL, OBJ) and its voxels (SEG).
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "anatomesh/pipeline/build_model.h"
#include "anatomesh_io/dicom/dicom_source.h"
#include "anatomesh_io/file/atomic_file.h"

namespace anatomesh {

struct DicomOutputs {
    std::string surface, obj, segmentation;  // paths; empty: not written

    std::vector<std::string> paths() const;
};

// --dicom-surface, --dicom-obj, --dicom-segmentation.
void add_dicom_output_options(CLI::App& verb, DicomOutputs& outputs);

// The names end in .dcm. Error: usage E-CMD-004.
Status check_dicom_outputs(const DicomOutputs& outputs);

// Formats the objects and adds them to the files of the run. The segmentation has the grid of the source's
// images, or cubes of half the edge length. Errors: E-CMD-018 a model whose axes are not known; those of the
// files.
Status add_dicom_outputs(const Model& model, const DicomSource& source, const DicomOutputs& outputs,
                         AtomicFileSet& files, RunContext& context);

}  // namespace anatomesh
