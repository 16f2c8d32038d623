// Voxels as ITK images, and ITK's filters run with the product's errors. Internal to the room.
#pragma once

#include <itkImage.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"

namespace anatomesh {

using ItkGrey = itk::Image<float, 3>;
using ItkMask = itk::Image<std::uint8_t, 3>;

inline std::array<double, 3> spacing_of(const ImageGeometry& geometry) {
    return {length(geometry.step[0]), length(geometry.step[1]), length(geometry.step[2])};
}

// An image on the caller's voxels, which outlive it: sizes and spacing of the geometry, no direction, origin
// 0.
template <class Image>
typename Image::Pointer itk_view(const ImageGeometry& geometry, const typename Image::PixelType* voxels) {
    auto image = Image::New();
    typename Image::RegionType region;
    const std::array<double, 3> spacing = spacing_of(geometry);
    typename Image::SpacingType steps;
    for (unsigned axis = 0; axis < 3; ++axis) {
        region.SetSize(axis, geometry.size[axis]);
        steps[axis] = spacing[axis];
    }
    image->SetRegions(region);
    image->SetSpacing(steps);
    // ITK reads inputs alone; its interface does not say so.
    image->GetPixelContainer()->SetImportPointer(const_cast<typename Image::PixelType*>(voxels),
                                                 geometry.voxel_count(), false);
    return image;
}

inline Error filter_error(const std::string& source, const std::string& what) {
    return {ErrorKind::internal,
            "E-SGM-003",
            "a filter failed: " + what,
            {source, "", "", "", ""},
            "please report this with the command and the image"};
}

// Updates the filter; a cancelled run ends it.
template <class Filter>
Status run_filter(Filter& filter, const std::string& source, RunContext& context) {
    const auto stop = [&](const itk::EventObject&) {
        if (context.cancelled()) filter.AbortGenerateDataOn();
    };
    filter.SetNumberOfWorkUnits(static_cast<unsigned>(context.threads));
    filter.AddObserver(itk::ProgressEvent(), stop);
    filter.AddObserver(itk::IterationEvent(), stop);
    try {
        filter.Update();
    } catch (const itk::ExceptionObject& failure) {
        if (!context.cancelled()) return filter_error(source, failure.GetDescription());
    }
    if (context.cancelled()) return cancelled_error();
    return Nothing{};
}

}  // namespace anatomesh
