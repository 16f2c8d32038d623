#include "anatomesh_io/segment/segment.h"

#include <fmt/format.h>
#include <itkConfidenceConnectedImageFilter.h>
#include <itkConnectedThresholdImageFilter.h>
#include <itkGeodesicActiveContourLevelSetImageFilter.h>
#include <itkGradientMagnitudeRecursiveGaussianImageFilter.h>
#include <itkOtsuThresholdImageFilter.h>
#include <itkSmoothingRecursiveGaussianImageFilter.h>
#include <itkThresholdSegmentationLevelSetImageFilter.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "anatomesh_io/segment/itk_image.h"

namespace anatomesh {

namespace {

constexpr double settled = 0.02;  // RMS change of a level set, in voxels a step, below which it stands still

struct Mask {
    std::vector<std::uint8_t> voxels;
    std::optional<double> low, high;
    std::uint32_t iterations = 0;
};

class Segmenter {
  public:
    Segmenter(const GreyImage& image, const SegmentOptions& options, RunContext& context)
        : image_(image), options_(options), context_(context), spacing_(spacing_of(image.geometry)) {
        const double least = 1.5 * *std::max_element(spacing_.begin(), spacing_.end());
        radius_ = std::max(options.seed_radius_mm, least);
    }

    Result<Mask> run() {
        switch (options_.method) {
            case SegmentMethod::threshold:
                return threshold();
            case SegmentMethod::otsu:
                return otsu();
            case SegmentMethod::grow:
                return grow(options_.low, options_.high);
            case SegmentMethod::confidence:
                return confidence();
            case SegmentMethod::region:
                return region();
            case SegmentMethod::geodesic:
                return geodesic();
        }
        return filter_error(image_.source, "no such method");
    }

  private:
    struct Spread {
        double mean = 0, deviation = 0;
    };

    Mask mask_of(const ItkMask& image) const {
        Mask mask;
        const std::uint8_t* voxels = image.GetBufferPointer();
        mask.voxels.assign(voxels, voxels + image_.voxels.size());
        return mask;
    }

    Result<Mask> threshold() const {
        Mask mask;
        mask.voxels.resize(image_.voxels.size());
        std::transform(image_.voxels.begin(), image_.voxels.end(), mask.voxels.begin(), [&](float value) {
            return static_cast<std::uint8_t>(value >= options_.low && value <= options_.high);
        });
        mask.low = options_.low;
        mask.high = options_.high;
        return mask;
    }

    Result<Mask> otsu() {
        auto filter = itk::OtsuThresholdImageFilter<ItkGrey, ItkMask>::New();
        filter->SetInput(grey());
        filter->SetNumberOfHistogramBins(256);
        filter->SetInsideValue(0);  // ITK's inside is what lies below
        filter->SetOutsideValue(1);
        ANATOMESH_CHECK_STATUS(run_filter(*filter, image_.source, context_));
        Mask mask = mask_of(*filter->GetOutput());
        mask.low = filter->GetThreshold();
        return mask;
    }

    Result<Mask> grow(double low, double high) {
        for (const auto& seed : options_.seeds) {
            const float value = image_.voxels[image_.geometry.index(seed[0], seed[1], seed[2])];
            if (value >= low && value <= high) continue;
            return Error{ErrorKind::geometry,
                         "E-SGM-002",
                         "the value at a seed lies outside the range to grow in",
                         {image_.source, "", "", "",
                          fmt::format("{:.6g} at voxel {}, {}, {}", value, seed[0], seed[1], seed[2])},
                         "put the seed inside the structure, or give another --threshold LO:HI"};
        }
        auto filter = itk::ConnectedThresholdImageFilter<ItkGrey, ItkMask>::New();
        filter->SetInput(grey());
        filter->SetLower(static_cast<float>(low));
        filter->SetUpper(static_cast<float>(std::min(high, 3e38)));
        filter->SetReplaceValue(1);
        for (const auto& seed : options_.seeds) filter->AddSeed(index_of(seed));
        ANATOMESH_CHECK_STATUS(run_filter(*filter, image_.source, context_));
        Mask mask = mask_of(*filter->GetOutput());
        mask.low = low;
        mask.high = high;
        return mask;
    }

    Result<Mask> confidence() {
        auto filter = itk::ConfidenceConnectedImageFilter<ItkGrey, ItkMask>::New();
        filter->SetInput(grey());
        filter->SetMultiplier(options_.spread);
        filter->SetNumberOfIterations(4);
        const double finest = *std::min_element(spacing_.begin(), spacing_.end());
        filter->SetInitialNeighborhoodRadius(static_cast<unsigned>(std::max(1.0, radius_ / finest)));
        filter->SetReplaceValue(1);
        for (const auto& seed : options_.seeds) filter->AddSeed(index_of(seed));
        ANATOMESH_CHECK_STATUS(run_filter(*filter, image_.source, context_));
        Mask mask = mask_of(*filter->GetOutput());
        mask.low = filter->GetMean() - options_.spread * std::sqrt(filter->GetVariance());
        mask.high = filter->GetMean() + options_.spread * std::sqrt(filter->GetVariance());
        return mask;
    }

    // The contour grows where the smoothed value lies within the range of the values in the seeds' balls.
    Result<Mask> region() {
        ANATOMESH_TRY(const ItkGrey::Pointer smooth, smoothed());
        const std::vector<float> start = distance_from_balls();
        const Spread spread = spread_in_balls(start, image_.voxels.data());
        // In a ball of one value alone the range would be empty.
        const double deviation = std::max(spread.deviation, 1e-3 * std::abs(spread.mean) + 1e-6);
        // The speed is the value's distance from the ends of the range; beyond twice the range it would only
        // make the steps of time small.
        const double reach = options_.spread * deviation;
        float* values = smooth->GetBufferPointer();
        for (std::size_t n = 0; n < start.size(); ++n)
            values[n] = std::clamp(values[n], static_cast<float>(spread.mean - 2 * reach),
                                   static_cast<float>(spread.mean + 2 * reach));
        auto filter = itk::ThresholdSegmentationLevelSetImageFilter<ItkGrey, ItkGrey>::New();
        filter->SetFeatureImage(smooth);
        filter->SetLowerThreshold(static_cast<float>(spread.mean - reach));
        filter->SetUpperThreshold(static_cast<float>(spread.mean + reach));
        // The speed of the range is in the image's unit: brought to one at its middle.
        filter->SetPropagationScaling(static_cast<float>(1 / reach));
        filter->SetCurvatureScaling(static_cast<float>(0.2 * options_.curvature));
        ANATOMESH_TRY(Mask mask, evolve(*filter, start));
        mask.low = spread.mean - reach;
        mask.high = spread.mean + reach;
        return mask;
    }

    // The speed is 1 where the image is as even as in the seeds' balls and falls at edges.
    Result<Mask> geodesic() {
        auto gradient = itk::GradientMagnitudeRecursiveGaussianImageFilter<ItkGrey, ItkGrey>::New();
        gradient->SetInput(grey());
        gradient->SetSigma(sigma());
        ANATOMESH_CHECK_STATUS(run_filter(*gradient, image_.source, context_));
        const ItkGrey::Pointer speed = gradient->GetOutput();
        speed->DisconnectPipeline();
        const std::vector<float> start = distance_from_balls();
        float* values = speed->GetBufferPointer();
        const Spread spread = spread_in_balls(start, values);
        const double edge = std::max(spread.mean + options_.spread * spread.deviation, 1e-6);
        for (std::size_t n = 0; n < start.size(); ++n) {
            const double share = values[n] / edge;
            values[n] = static_cast<float>(1 / (1 + share * share * share * share));
        }
        auto filter = itk::GeodesicActiveContourLevelSetImageFilter<ItkGrey, ItkGrey>::New();
        filter->SetFeatureImage(speed);
        filter->SetPropagationScaling(1);
        filter->SetCurvatureScaling(static_cast<float>(0.5 * options_.curvature));
        filter->SetAdvectionScaling(1);
        return evolve(*filter, start);
    }

    template <class Filter>
    Result<Mask> evolve(Filter& filter, const std::vector<float>& start) {
        filter.SetInput(itk_view<ItkGrey>(image_.geometry, start.data()));
        filter.SetMaximumRMSError(settled);
        filter.SetNumberOfIterations(options_.iterations);
        filter.SetIsoSurfaceValue(0);
        ANATOMESH_CHECK_STATUS(run_filter(filter, image_.source, context_));
        Mask mask;
        const float* level = filter.GetOutput()->GetBufferPointer();
        mask.voxels.resize(start.size());
        std::transform(level, level + start.size(), mask.voxels.begin(),
                       [](float value) { return static_cast<std::uint8_t>(value <= 0); });
        mask.iterations = static_cast<std::uint32_t>(filter.GetElapsedIterations());
        if (mask.iterations >= options_.iterations)
            context_.warn({"W-SGM-002",
                           "the active contour was still moving after the last iteration",
                           {image_.source, "", "", "", fmt::format("{}", mask.iterations)},
                           "taken as it was; --iterations allows more"});
        return mask;
    }

    Result<ItkGrey::Pointer> smoothed() {
        auto filter = itk::SmoothingRecursiveGaussianImageFilter<ItkGrey, ItkGrey>::New();
        filter->SetInput(grey());
        filter->SetSigma(sigma());
        ANATOMESH_CHECK_STATUS(run_filter(*filter, image_.source, context_));
        return ItkGrey::Pointer(filter->GetOutput());
    }
    double sigma() const { return 0.7 * *std::min_element(spacing_.begin(), spacing_.end()); }

    ItkGrey::Pointer grey() const { return itk_view<ItkGrey>(image_.geometry, image_.voxels.data()); }

    static itk::Index<3> index_of(const std::array<std::uint32_t, 3>& seed) {
        return {{itk::IndexValueType{seed[0]}, itk::IndexValueType{seed[1]}, itk::IndexValueType{seed[2]}}};
    }

    // Signed distance from the nearest seed's ball, mm, negative inside.
    std::vector<float> distance_from_balls() const {
        std::vector<float> distance(image_.voxels.size(), std::numeric_limits<float>::max());
        const auto& size = image_.geometry.size;
        for (const auto& seed : options_.seeds) {
            std::size_t n = 0;
            for (std::uint32_t k = 0; k < size[2]; ++k) {
                const double z = (double{1} * k - seed[2]) * spacing_[2];
                for (std::uint32_t j = 0; j < size[1]; ++j) {
                    const double y = (double{1} * j - seed[1]) * spacing_[1];
                    for (std::uint32_t i = 0; i < size[0]; ++i, ++n) {
                        const double x = (double{1} * i - seed[0]) * spacing_[0];
                        const double d = std::sqrt(x * x + y * y + z * z) - radius_;
                        distance[n] = std::min(distance[n], static_cast<float>(d));
                    }
                }
            }
        }
        return distance;
    }

    static Spread spread_in_balls(const std::vector<float>& distance, const float* values) {
        double sum = 0, squares = 0, count = 0;
        for (std::size_t n = 0; n < distance.size(); ++n) {
            if (distance[n] > 0) continue;
            sum += values[n];
            squares += double{values[n]} * values[n];
            ++count;
        }
        const double mean = sum / count;
        return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
    }

    const GreyImage& image_;
    const SegmentOptions& options_;
    RunContext& context_;
    std::array<double, 3> spacing_;
    double radius_ = 0;
};

Error nothing_left(const GreyImage& image) {
    const auto [low, high] = std::minmax_element(image.voxels.begin(), image.voxels.end());
    return {ErrorKind::geometry,
            "E-SGM-001",
            fmt::format("no voxel belongs to the structure; the values of the image run from {} to {}", *low,
                        *high),
            {image.source, "", "", "", ""},
            "choose another --threshold, --seed or --method"};
}

}  // namespace

Result<Segmentation> segment_image(const GreyImage& image, const SegmentOptions& options,
                                   RunContext& context) {
    assert(options.method == SegmentMethod::threshold || options.method == SegmentMethod::otsu ||
           !options.seeds.empty());
    Segmenter segmenter(image, options, context);
    ANATOMESH_TRY(const Mask mask, segmenter.run());
    Segmentation result;
    result.low = mask.low;
    result.high = mask.high;
    result.iterations = mask.iterations;
    result.labels.geometry = image.geometry;
    result.labels.source = image.source;
    result.labels.structures.push_back({1, "", {230, 200, 120}});
    result.labels.voxels.assign(mask.voxels.begin(), mask.voxels.end());
    const auto inside = std::count(mask.voxels.begin(), mask.voxels.end(), 1);
    if (inside == 0) return nothing_left(image);
    if (2 * static_cast<std::size_t>(inside) > mask.voxels.size())
        context.warn({"W-SGM-001",
                      "the structure takes more than half of the image",
                      {image.source, "", "", "",
                       fmt::format("{:.0f} %", 100.0 * static_cast<double>(inside) /
                                                   static_cast<double>(mask.voxels.size()))},
                      "kept; it has probably leaked into what surrounds it"});
    return result;
}

}  // namespace anatomesh
