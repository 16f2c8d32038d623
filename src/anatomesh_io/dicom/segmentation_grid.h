// grid_spacing: how far apart the planes are on which frames of a segmentation lie.
//
// A segmentation stores the frames that hold something. Planes between them that are not stored are empty, as
// the format allows (DICOM PS3.3 C.8.20.2), so the distance of stored frames alone does not say how far apart
// planes are: two lesions 24 mm apart are not one of 24 mm. What states it is used in this order:
// SpacingBetweenSlices, the images beside the segmentation, SliceThickness, and at last the distances of the frames.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace anatomesh {

enum class GridSource : std::uint8_t { none, images, stated_spacing, thickness, frames };

struct GridSpacing {
    double mm = 0;
    GridSource source = GridSource::none;  // none: nothing says it, or no spacing fits the frames
    // All frames are two thicknesses apart: they are taken for neighbours, as in an acquisition with gaps.
    bool skips_a_thickness = false;
    // The frames lie beside its planes, by no more than the file rounds places.
    bool is_rounded = false;
};

// Where frames lie, and what says how far apart planes are. Heights are along the normal, in mm, and rise.
struct FrameHeights {
    std::span<const double> frames;           // several may be equal
    std::span<const double> images = {};      // of the images beside them; empty: none are there
    std::optional<double> stated_mm = {};     // SpacingBetweenSlices
    std::optional<double> thickness_mm = {};  // SliceThickness
    double rounding_mm = 0;  // a frame may lie so far from its plane, because the file rounds places. >= 0
};

// The first of these that all distances of neighbouring frames are multiples of, within two hundredths of it, or else that has all
// frames on its planes within the rounding, where that is a fifth of it at most (not of the distances): the
// stated spacing (its sign is no matter), the images' one (their least distance, where the frames lie on images), the
// thickness, the largest part of the least distance (at most its tenth part; the whole where a spacing is stated). If three frames or more are all two thicknesses
// apart, their distance is taken, for gaps of one thickness between slices are usual. Of a single plane the
// spacing is the stated one, that of the images, or the thickness. Requires: frames is not empty.
// Complexity: O(frames + images).
GridSpacing grid_spacing(const FrameHeights& heights);

}  // namespace anatomesh
