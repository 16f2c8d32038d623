#include "anatomesh_io/segment/segment.h"

#include <fmt/format.h>
#include <itkConfidenceConnectedImageFilter.h>
#include <itkConnectedThresholdImageFilter.h>
#include <itkGeodesicActiveContourLevelSetImageFilter.h>
#include <itkGradientMagnitudeRecursiveGaussianImageFilter.h>
#include <itkOtsuThresholdImageFilter.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>
#include <itkSmoothingRecursiveGaussianImageFilter.h>
#include <itkThresholdSegmentationLevelSetImageFilter.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "anatomesh_io/segment/chan_vese.h"
#include "anatomesh_io/segment/itk_image.h"

namespace anatomesh {

namespace {

// An active contour that only grows begins with the region shrunk by this, so that it comes to the border
// from inside. [pixels; >= 0; M 2026-11, set not recorded]
constexpr double shrunk_by_pixels = 2;
// A level set stands still that changes by less in a step, as root mean square. [voxels; > 0; B]
constexpr double settled = 0.02;

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
            case SegmentMethod::chan_vese:
                return even_regions();
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
                         "the value at a seed is outside the range of --threshold",
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
        const auto seeds = seeds_of_start(low, high);
        for (const auto& seed : seeds) filter->AddSeed(index_of(seed));
        ANATOMESH_CHECK_STATUS(run_filter(*filter, image_.source, context_));
        Mask mask = mask_of(*filter->GetOutput());
        mask.low = low;
        mask.high = high;
        return mask;
    }

    // The voxels of the region to begin with whose values lie in the range.
    std::vector<std::array<std::uint32_t, 3>> seeds_of_start(double low, double high) const {
        std::vector<std::array<std::uint32_t, 3>> seeds;
        const auto& size = image_.geometry.size;
        for (std::size_t n = 0; n < options_.start.size(); ++n) {
            if (!options_.start[n] || !(image_.voxels[n] >= low && image_.voxels[n] <= high)) continue;
            const auto pixel = static_cast<std::uint32_t>(n % (std::size_t{size[0]} * size[1]));
            seeds.push_back({pixel % size[0], pixel / size[0],
                             static_cast<std::uint32_t>(n / (std::size_t{size[0]} * size[1]))});
        }
        return seeds;
    }

    // From the seeds' balls or the start, voxel by voxel.
    Result<Mask> even_regions() {
        ANATOMESH_TRY(const ItkGrey::Pointer smooth, smoothed());
        GreyImage values;
        values.geometry = image_.geometry;
        values.source = image_.source;
        values.voxels.assign(smooth->GetBufferPointer(), smooth->GetBufferPointer() + image_.voxels.size());
        std::vector<std::uint8_t> start = options_.start;
        if (start.empty()) {
            const std::vector<float> distance = distance_from_balls();
            start.resize(distance.size());
            std::transform(distance.begin(), distance.end(), start.begin(),
                           [](float d) { return static_cast<std::uint8_t>(d <= 0); });
        }
        ChanVeseOptions moving;
        moving.smoothing = static_cast<std::uint32_t>(std::clamp(std::round(options_.curvature), 0.0, 10.0));
        moving.iterations = options_.iterations;
        const double finest = *std::min_element(spacing_.begin(), spacing_.end());
        moving.surroundings = static_cast<std::uint32_t>(std::max(4.0, radius_ / finest));
        ANATOMESH_TRY(ChanVeseResult found, chan_vese(values, std::move(start), moving, context_));
        Mask mask;
        mask.iterations = found.iterations;
        const double middle = (found.mean_inside + found.mean_outside) / 2;
        (found.mean_inside >= found.mean_outside ? mask.low : mask.high) = middle;
        mask.voxels = std::move(found.inside);
        if (!found.is_settled) warn_of_motion(mask.iterations);
        return mask;
    }

    Result<Mask> confidence() {
        if (!options_.start.empty() && options_.known_low && options_.known_high)
            return grow(*options_.known_low, *options_.known_high);
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
        ANATOMESH_TRY(const std::vector<float> start, distance_from_start(0));
        Spread spread = spread_in_balls(start, image_.voxels.data());
        if (options_.known_low && options_.known_high)
            spread = {(*options_.known_low + *options_.known_high) / 2,
                      (*options_.known_high - *options_.known_low) / 2 / options_.spread};
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
        gradient->SetSigma(sigma());
        ANATOMESH_TRY(const ItkGrey::Pointer speed, filtered(*gradient));
        ANATOMESH_TRY(const std::vector<float> start, distance_from_start(shrunk_by_pixels));
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
        if (mask.iterations >= options_.iterations) warn_of_motion(mask.iterations);
        return mask;
    }
    void warn_of_motion(std::uint32_t iterations) {
        context_.warn({"W-SGM-002",
                       "the active contour was still moving after the last iteration",
                       {image_.source, "", "", "", fmt::format("{}", iterations)},
                       "its last state was used; --iterations allows more steps"});
    }

    Result<ItkGrey::Pointer> smoothed() {
        auto filter = itk::SmoothingRecursiveGaussianImageFilter<ItkGrey, ItkGrey>::New();
        filter->SetSigma(sigma());
        return filtered(*filter);
    }
    // The recursive filters want four voxels along each axis: a thinner image gets its last ones repeated.
    template <class Filter>
    Result<ItkGrey::Pointer> filtered(Filter& filter) {
        // ITK's recursive filters want so many voxels along each axis: a thinner image gets its last ones
        // repeated. [voxels; 4; D ITK]
        constexpr std::uint32_t least = 4;
        const auto& size = image_.geometry.size;
        ImageGeometry thick = image_.geometry;
        for (std::uint32_t& count : thick.size) count = std::max(count, least);
        std::vector<float> voxels;
        if (thick.size == size) {
            filter.SetInput(grey());
        } else {
            voxels.resize(thick.voxel_count());
            for (std::uint32_t k = 0; k < thick.size[2]; ++k)
                for (std::uint32_t j = 0; j < thick.size[1]; ++j)
                    for (std::uint32_t i = 0; i < thick.size[0]; ++i)
                        voxels[thick.index(i, j, k)] = image_.voxels[image_.geometry.index(
                            std::min(i, size[0] - 1), std::min(j, size[1] - 1), std::min(k, size[2] - 1))];
            filter.SetInput(itk_view<ItkGrey>(thick, voxels.data()));
        }
        ANATOMESH_CHECK_STATUS(run_filter(filter, image_.source, context_));
        const ItkGrey::Pointer found = filter.GetOutput();
        found->DisconnectPipeline();
        if (thick.size == size) return found;
        const ItkGrey::Pointer out = ItkGrey::New();
        out->CopyInformation(grey());
        out->SetRegions(grey()->GetLargestPossibleRegion());
        out->Allocate();
        for (std::uint32_t k = 0; k < size[2]; ++k)
            for (std::uint32_t j = 0; j < size[1]; ++j)
                for (std::uint32_t i = 0; i < size[0]; ++i)
                    out->GetBufferPointer()[image_.geometry.index(i, j, k)] =
                        found->GetBufferPointer()[thick.index(i, j, k)];
        return out;
    }
    double sigma() const { return 0.7 * *std::min_element(spacing_.begin(), spacing_.end()); }

    ItkGrey::Pointer grey() const { return itk_view<ItkGrey>(image_.geometry, image_.voxels.data()); }

    static itk::Index<3> index_of(const std::array<std::uint32_t, 3>& seed) {
        return {{itk::IndexValueType{seed[0]}, itk::IndexValueType{seed[1]}, itk::IndexValueType{seed[2]}}};
    }

    // Signed distance from the region to begin with, mm, negative inside; from the seeds' balls without one.
    // The region is taken so many pixels smaller, as far as it then has an inside.
    Result<std::vector<float>> distance_from_start(double pixels_smaller) {
        if (options_.start.empty()) return distance_from_balls();
        auto filter = itk::SignedMaurerDistanceMapImageFilter<ItkMask, ItkGrey>::New();
        filter->SetInput(itk_view<ItkMask>(image_.geometry, options_.start.data()));
        filter->SetSquaredDistance(false);
        filter->SetUseImageSpacing(true);
        filter->SetInsideIsPositive(false);
        ANATOMESH_CHECK_STATUS(run_filter(*filter, image_.source, context_));
        const float* found = filter->GetOutput()->GetBufferPointer();
        std::vector<float> distance(found, found + image_.voxels.size());
        const float deepest = *std::min_element(distance.begin(), distance.end());
        const double finest = *std::min_element(spacing_.begin(), spacing_.end());
        const auto by = static_cast<float>(std::min(pixels_smaller * finest, -0.5 * double{deepest}));
        for (float& d : distance) d += std::max(by, 0.0F);
        return distance;
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

// ITK's level sets want so many voxels along each axis. A thinner image gets its last ones repeated, and a
// contour in it evolves as the cylinder above it does. [voxels; 4; D ITK]
constexpr std::uint32_t least_voxels = 4;

bool is_too_thin(const GreyImage& image, SegmentMethod method) {
    const auto& size = image.geometry.size;
    return (method == SegmentMethod::region || method == SegmentMethod::geodesic) &&
           *std::min_element(size.begin(), size.end()) < least_voxels;
}

// Calls body(voxel of the thick image, voxel of the thin one that it repeats).
template <class Body>
void each_repeated(const ImageGeometry& thick, const ImageGeometry& thin, Body&& body) {
    for (std::uint32_t k = 0; k < thick.size[2]; ++k)
        for (std::uint32_t j = 0; j < thick.size[1]; ++j)
            for (std::uint32_t i = 0; i < thick.size[0]; ++i)
                body(thick.index(i, j, k),
                     thin.index(std::min(i, thin.size[0] - 1), std::min(j, thin.size[1] - 1),
                                std::min(k, thin.size[2] - 1)));
}

Result<Segmentation> segment_thin(const GreyImage& image, const SegmentOptions& options,
                                  RunContext& context) {
    if (image.geometry.size[2] > 1)
        return Error{ErrorKind::usage,
                     "E-SGM-011",
                     "an active contour by region or edges needs four slices, or one",
                     {image.source, "", "", "", fmt::format("{} slices", image.geometry.size[2])},
                     "work slice by slice with --per-slice, or choose --method chan-vese"};
    const ImageGeometry& thin = image.geometry;
    SegmentOptions repeated = options;
    if (repeated.start.empty()) {
        const auto spacing = spacing_of(thin);
        const double radius =
            std::max(options.seed_radius_mm, 1.5 * *std::max_element(spacing.begin(), spacing.begin() + 2));
        repeated.start.assign(thin.voxel_count(), 0);
        for (const auto& seed : options.seeds)
            for (std::uint32_t k = 0; k < thin.size[2]; ++k)
                for (std::uint32_t j = 0; j < thin.size[1]; ++j)
                    for (std::uint32_t i = 0; i < thin.size[0]; ++i) {
                        const double x = (double{1} * i - seed[0]) * spacing[0],
                                     y = (double{1} * j - seed[1]) * spacing[1];
                        if (x * x + y * y <= radius * radius) repeated.start[thin.index(i, j, k)] = 1;
                    }
    }
    GreyImage thick;
    thick.source = image.source;
    thick.geometry = thin;
    for (std::uint32_t& count : thick.geometry.size) count = std::max(count, least_voxels);
    thick.voxels.resize(thick.geometry.voxel_count());
    std::vector<std::uint8_t> start(thick.voxels.size());
    each_repeated(thick.geometry, thin, [&](std::size_t n, std::size_t of) {
        thick.voxels[n] = image.voxels[of];
        start[n] = repeated.start[of];
    });
    repeated.start = std::move(start);
    repeated.seeds.clear();
    ANATOMESH_TRY(Segmentation result, segment_image(thick, repeated, context));
    LabelMap labels = std::move(result.labels);
    result.labels.geometry = thin;
    result.labels.source = labels.source;
    result.labels.structures = std::move(labels.structures);
    result.labels.voxels.resize(thin.voxel_count());
    // Of the repeated voxels those in the middle count.
    const auto middle = [&](std::uint32_t at, std::uint32_t count) {
        return at + 1 == count && count < least_voxels ? at + (least_voxels - count) / 2 : at;
    };
    for (std::uint32_t k = 0; k < thin.size[2]; ++k)
        for (std::uint32_t j = 0; j < thin.size[1]; ++j)
            for (std::uint32_t i = 0; i < thin.size[0]; ++i)
                result.labels.voxels[thin.index(i, j, k)] = labels.voxels[thick.geometry.index(
                    middle(i, thin.size[0]), middle(j, thin.size[1]), middle(k, thin.size[2]))];
    return result;
}

}  // namespace

Result<Segmentation> segment_image(const GreyImage& image, const SegmentOptions& options,
                                   RunContext& context) {
    if (is_too_thin(image, options.method)) return segment_thin(image, options, context);
    assert(options.method == SegmentMethod::threshold || options.method == SegmentMethod::otsu ||
           !options.seeds.empty() || !options.start.empty());
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
                      "the structure fills more than half of the image",
                      {image.source, "", "", "",
                       fmt::format("{:.0f} %", 100.0 * static_cast<double>(inside) /
                                                   static_cast<double>(mask.voxels.size()))},
                      "kept; it has probably spread into its surroundings, so check the result"});
    return result;
}

}  // namespace anatomesh
