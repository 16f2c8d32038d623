#include <itkBinaryFillholeImageFilter.h>
#include <itkBinaryMedianImageFilter.h>
#include <itkBinaryMorphologicalClosingImageFilter.h>
#include <itkBinaryMorphologicalOpeningImageFilter.h>
#include <itkFlatStructuringElement.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "anatomesh_io/segment/itk_image.h"
#include "anatomesh_io/segment/segment.h"

namespace anatomesh {

namespace {

using Ball = itk::FlatStructuringElement<3>;

// Voxels along each axis that lie within the radius.
Ball::RadiusType radius_of(const ImageGeometry& geometry, double mm) {
    Ball::RadiusType radius;
    const auto spacing = spacing_of(geometry);
    for (unsigned axis = 0; axis < 3; ++axis)
        radius[axis] = static_cast<itk::SizeValueType>(std::floor(mm / spacing[axis] + 1e-6));
    return radius;
}

class Cleaner {
  public:
    Cleaner(LabelMap& labels, RunContext& context)
        : labels_(labels), context_(context), mask_(labels.voxels.size()) {
        std::transform(labels.voxels.begin(), labels.voxels.end(), mask_.begin(),
                       [](std::uint16_t voxel) { return static_cast<std::uint8_t>(voxel != 0); });
    }

    template <class Filter>
    Status run(Filter& filter) {
        filter.SetInput(itk_view<ItkMask>(labels_.geometry, mask_.data()));
        ANATOMESH_CHECK_STATUS(run_filter(filter, labels_.source, context_));
        const ItkMask& out = *filter.GetOutput();
        std::copy_n(out.GetBufferPointer(), mask_.size(), mask_.begin());
        return Nothing{};
    }
    Status median(double mm) {
        auto filter = itk::BinaryMedianImageFilter<ItkMask, ItkMask>::New();
        filter->SetRadius(radius_of(labels_.geometry, mm));
        filter->SetForegroundValue(1);
        filter->SetBackgroundValue(0);
        return run(*filter);
    }
    Status open(double mm) {
        auto filter = itk::BinaryMorphologicalOpeningImageFilter<ItkMask, ItkMask, Ball>::New();
        filter->SetKernel(Ball::Ball(radius_of(labels_.geometry, mm)));
        filter->SetForegroundValue(1);
        filter->SetBackgroundValue(0);
        return run(*filter);
    }
    Status close(double mm) {
        auto filter = itk::BinaryMorphologicalClosingImageFilter<ItkMask, ItkMask, Ball>::New();
        filter->SetKernel(Ball::Ball(radius_of(labels_.geometry, mm)));
        filter->SetForegroundValue(1);
        return run(*filter);
    }
    Status fill_holes() {
        auto filter = itk::BinaryFillholeImageFilter<ItkMask>::New();
        filter->SetForegroundValue(1);
        return run(*filter);
    }
    // False when nothing is left.
    bool finish() {
        std::transform(mask_.begin(), mask_.end(), labels_.voxels.begin(),
                       [](std::uint8_t inside) { return static_cast<std::uint16_t>(inside != 0); });
        return std::find(mask_.begin(), mask_.end(), 1) != mask_.end();
    }

  private:
    LabelMap& labels_;
    RunContext& context_;
    std::vector<std::uint8_t> mask_;
};

}  // namespace

Status clean_mask(LabelMap& labels, const CleanMaskOptions& options, RunContext& context) {
    assert(labels.structures.size() == 1);
    Cleaner cleaner(labels, context);
    if (options.median_mm > 0) {
        ANATOMESH_CHECK_STATUS(cleaner.median(options.median_mm));
    }
    if (options.open_mm > 0) {
        ANATOMESH_CHECK_STATUS(cleaner.open(options.open_mm));
    }
    if (options.close_mm > 0) {
        ANATOMESH_CHECK_STATUS(cleaner.close(options.close_mm));
    }
    if (options.fill_holes) {
        ANATOMESH_CHECK_STATUS(cleaner.fill_holes());
    }
    if (cleaner.finish()) return Nothing{};
    return Error{ErrorKind::geometry,
                 "E-SGM-004",
                 "the clean-up removes all of the structure",
                 {labels.source, "", "", "", ""},
                 "give smaller radii to --median and --open"};
}

}  // namespace anatomesh
