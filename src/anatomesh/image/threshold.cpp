#include "anatomesh/image/threshold.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <string>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// A task is worth a thread from so many voxels on. [voxels; > 0; B]
constexpr std::size_t voxels_per_piece = std::size_t{1} << 18;

// Returns the shortest text that reads back as the same number, in any locale.
std::string text_of(double value) {
    std::array<char, 32> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    return {buffer.data(), end};
}

std::string range_of(const GreyImage& image) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const float value : image.voxels) {
        // These comparisons are false for a value that is not a number, so that it changes nothing.
        if (value < low) low = value;
        if (value > high) high = value;
    }
    return low <= high ? text_of(low) + ":" + text_of(high) : "not a number";
}

}  // namespace

Result<LabelMap> threshold_image(const GreyImage& image, const ThresholdOptions& options,
                                 RunContext& context) {
    assert(options.low <= options.high);
    assert(image.voxels.size() == image.geometry.voxel_count());
    const bool banded = options.high < std::numeric_limits<double>::infinity();
    const std::string range = text_of(options.low) + (banded ? ":" + text_of(options.high) : "");

    LabelMap labels;
    labels.geometry = image.geometry;
    labels.source = image.source;
    labels.structures.push_back({1, "threshold " + range, {230, 220, 200}});
    labels.voxels.resize(image.voxels.size());
    const std::size_t pieces = (image.voxels.size() + voxels_per_piece - 1) / voxels_per_piece;
    std::vector<std::uint8_t> any(pieces, 0);
    parallel_for(image.voxels.size(), voxels_per_piece, context.threads,
                 [&](std::size_t begin, std::size_t end) {
                     std::uint16_t found = 0;
                     for (std::size_t v = begin; v < end; ++v) {
                         const double value = image.voxels[v];
                         const std::uint16_t label = value >= options.low && value <= options.high ? 1 : 0;
                         labels.voxels[v] = label;
                         found |= label;
                     }
                     any[begin / voxels_per_piece] = found != 0;
                 });
    if (std::find(any.begin(), any.end(), 1) == any.end()) {
        return Error{ErrorKind::geometry,
                     "E-THR-001",
                     "no voxel has a value in the range of --threshold",
                     {image.source, "", "", "", range},
                     "give a --threshold within the values of the image, " + range_of(image)};
    }
    return labels;
}

}  // namespace anatomesh
