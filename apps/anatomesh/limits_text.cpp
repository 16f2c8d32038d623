#include "limits_text.h"

#include <fmt/format.h>

#include "anatomesh/pipeline/build_model.h"
#include "anatomesh_io/contour/contour_limits.h"
#include "anatomesh_io/file/input_file.h"
#include "anatomesh_io/image/read_image.h"

namespace anatomesh {

std::string limits_text() {
    const InputLimits input;
    const ContourLimits contour;
    const ReadImageOptions image;
    const ModelOptions model;
    std::string text;
    const auto add = [&](const char* what, auto value, const char* unit) {
        text += fmt::format("{:<36} {} {}\n", what, value, unit);
    };
    add("input file", input.max_file_bytes, "bytes");
    add("inflated input", input.max_inflated_bytes, "bytes");
    add("inflated / compressed", input.max_inflate_ratio, "times");
    add("  beyond the first", input.free_inflated_bytes, "bytes");
    add("voxels of an image", image.max_voxels, "");
    add("structures", contour.structures, "");
    add("contours", contour.contours, "");
    add("points of a contour", contour.points_per_contour, "");
    add("points of all contours", contour.points, "");
    add("coordinates, largest", contour.coordinate_mm, "mm");
    add("tetrahedra", model.max_tetrahedra, "");
    return text;
}

}  // namespace anatomesh
