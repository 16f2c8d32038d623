// SegmentTask: one structure to be found in an image, as the command line or a recipe says.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh_io/image/read_image.h"
#include "anatomesh_io/segment/segment.h"
#include "input_options.h"

namespace anatomesh {

struct SegmentTask {
    std::string name = "structure", method;  // method empty: by the other options
    std::uint32_t number = 1;
    std::optional<ThresholdOptions> threshold;
    std::optional<std::uint32_t> keep_largest;
    std::vector<Vec3> seeds;        // LPS mm; of frames with a pose, in their axes
    std::vector<Vec3> voxel_seeds;  // whole numbers
    std::optional<double> radius_mm, spread, curvature;
    std::optional<std::uint32_t> iterations;
    CleanMaskOptions cleaning;
    bool per_slice = false;
    std::vector<Vec3> within;  // two opposite corners, LPS mm, of the part of the image to look at; or empty
};

extern const std::vector<std::string> segment_methods;

struct TaskResult {
    Segmentation segmentation;  // cleaned, with name and number
    std::string method;
    bool by_value = false;  // the structure ends where the value passes a threshold
    std::uint64_t voxels = 0;
};

// Checks what the method cannot do without, or has no use for; then finds the structure. Frames with poses
// are treated one by one. Errors: usage E-SGM-005, -006, -007, -012, -013, E-CMD-008; those of segment.h.
Result<TaskResult> run_task(const SegmentTask& task, const LoadedImage& image, RunContext& context);

// The tasks of a recipe file. Errors: E-SGM-009, with the structure and the key.
Result<std::vector<SegmentTask>> read_recipe(const std::string& path, const InputLimits& limits);

}  // namespace anatomesh
