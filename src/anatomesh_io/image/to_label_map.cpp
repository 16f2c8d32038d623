#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

namespace {

// Labels this near to whole numbers are whole: floats and scaling round. [1; 0 to 0.5; D digits of files]
constexpr double rounding = 1e-3;
// Larger whole numbers are not all exact in a 32-bit float. [label; 2^24 - 1; D IEEE 754]
constexpr float largest_label = 16777215;

Error label_error(const char* code, std::string message, const GreyImage& image, std::size_t index) {
    const std::size_t row = index / image.geometry.size[0];
    Error error =
        image_error(code, std::move(message), image.source, fmt::format("{}", image.voxels[index]),
                    "give a threshold (--threshold) if this is a grey image, or correct the label map");
    error.place.slice =
        fmt::format("{} (voxel {}, {}, {})", row / image.geometry.size[1], index % image.geometry.size[0],
                    row % image.geometry.size[1], row / image.geometry.size[1]);
    return error;
}

// The label values that occur, ascending, without 0; and how far the values were from integers.
Result<std::vector<std::int32_t>> occurring_labels(const GreyImage& image, float& largest_fraction) {
    std::vector<bool> seen(65536);
    std::vector<std::int32_t> beyond;  // sorted
    std::size_t count = 0;
    float last = 0;
    for (std::size_t n = 0; n < image.voxels.size(); ++n) {
        const float value = image.voxels[n];
        if (value == last) continue;
        last = value;
        const float whole = std::rint(value);
        const float fraction = std::abs(value - whole);
        largest_fraction = std::max(largest_fraction, fraction);
        if (fraction > rounding)
            return label_error("E-LBL-003", "the image is no label map: a value is not an integer", image, n);
        if (whole < 0)
            return label_error("E-LBL-002", "the image is no label map: a value is negative", image, n);
        if (whole > largest_label) return label_error("E-LBL-004", "a label is above 16777215", image, n);
        const auto label = static_cast<std::int32_t>(whole);
        if (label < 65536) {
            if (!seen[label] && label != 0) ++count;
            seen[label] = true;
        } else if (const auto at = std::lower_bound(beyond.begin(), beyond.end(), label);
                   at == beyond.end() || *at != label) {
            beyond.insert(at, label);
            ++count;
        }
        if (count > 65535) return label_error("E-LBL-005", "the image has more than 65535 labels", image, n);
    }
    std::vector<std::int32_t> labels;
    for (std::int32_t label = 1; label < 65536; ++label)
        if (seen[label]) labels.push_back(label);
    labels.insert(labels.end(), beyond.begin(), beyond.end());
    return labels;
}

std::vector<Structure> structures_of(const std::vector<std::int32_t>& labels,
                                     const std::vector<Structure>& named) {
    std::vector<Structure> structures;
    for (const std::int32_t label : labels) {
        Structure structure;
        structure.number = label;
        const auto known =
            std::find_if(named.begin(), named.end(), [&](const Structure& s) { return s.number == label; });
        if (known != named.end()) structure = *known;
        structures.push_back(structure);
    }
    return structures;
}

void fill_voxels(const GreyImage& image, const std::vector<std::int32_t>& labels, LabelMap& map) {
    // Labels below 65536 by a table, the rare others by search.
    std::vector<std::uint16_t> index_of(65536);
    for (std::size_t i = 0; i < labels.size(); ++i)
        if (labels[i] < 65536) index_of[labels[i]] = static_cast<std::uint16_t>(i + 1);
    map.voxels.resize(image.voxels.size());
    for (std::size_t n = 0; n < image.voxels.size(); ++n) {
        const auto label = static_cast<std::int32_t>(std::rint(image.voxels[n]));
        map.voxels[n] = label < 65536
                            ? index_of[label]
                            : static_cast<std::uint16_t>(
                                  std::lower_bound(labels.begin(), labels.end(), label) - labels.begin() + 1);
    }
}

// Structures with a voxel in the first or last layer along any axis of more than one layer.
void warn_of_cut_structures(const LabelMap& map, RunContext& context) {
    const auto& size = map.geometry.size;
    std::vector<bool> cut(map.structures.size() + 1);
    for (std::uint32_t k = 0; k < size[2]; ++k)
        for (std::uint32_t j = 0; j < size[1]; ++j) {
            const bool border_row = (size[2] > 1 && (k == 0 || k + 1 == size[2])) ||
                                    (size[1] > 1 && (j == 0 || j + 1 == size[1]));
            const std::uint32_t step = border_row || size[0] == 1 ? 1 : size[0] - 1;
            if (!border_row && size[0] == 1) continue;
            for (std::uint32_t i = 0; i < size[0]; i += step)
                cut[map.voxels[map.geometry.index(i, j, k)]] = true;
        }
    std::string numbers;
    int count = 0;
    for (std::size_t s = 0; s < map.structures.size(); ++s)
        if (cut[s + 1] && ++count <= 20)
            numbers += (numbers.empty() ? "" : ", ") + fmt::format("{}", map.structures[s].number);
    if (count > 20) numbers += ", ...";
    if (count > 0) {
        Warning warning =
            image_warning("W-LBL-002", fmt::format("{} structures reach the image border", count), map.source,
                          "", "they were closed at the border");
        warning.place.structure = numbers;
        context.warn(std::move(warning));
    }
}

}  // namespace

Result<LabelMap> to_label_map(const LoadedImage& loaded, RunContext& context) {
    const GreyImage& image = loaded.image;
    if (loaded.facts.not_finite > 0) {
        const auto& [i, j, k] = loaded.facts.first_not_finite;
        return label_error("E-LBL-001", "the image is no label map: a value is not finite", image,
                           image.geometry.index(i, j, k));
    }
    float largest_fraction = 0;
    ANATOMESH_TRY(const std::vector<std::int32_t> labels, occurring_labels(image, largest_fraction));
    if (labels.empty())
        return image_error("E-LBL-006", "the label map is empty: every voxel is 0", image.source, "",
                           "give a label map with a structure in it");
    LabelMap map;
    map.geometry = image.geometry;
    map.source = image.source;
    map.structures = structures_of(labels, loaded.structures);
    fill_voxels(image, labels, map);
    if (largest_fraction > 0)
        context.warn(image_warning("W-LBL-001", "the labels are not exact whole numbers", image.source,
                                   fmt::format("off by up to {:.3g}", largest_fraction),
                                   "they were rounded"));
    warn_of_cut_structures(map, context);
    return map;
}

}  // namespace anatomesh
