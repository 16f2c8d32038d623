#include "anatomesh_io/segment/segment_slices.h"

#include <fmt/format.h>
#include <itkMedianImageFilter.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "anatomesh_io/segment/itk_image.h"

namespace anatomesh {

namespace {

class SliceSegmenter {
  public:
    SliceSegmenter(const GreyImage& image, const SegmentOptions& options, const SliceOptions& slices,
                   RunContext& context)
        : image_(image),
          options_(options),
          slices_(slices),
          context_(context),
          pixels_(std::size_t{image.geometry.size[0]} * image.geometry.size[1]),
          order_(slices.order) {
        if (order_.empty()) {
            order_.resize(image.geometry.size[2]);
            std::iota(order_.begin(), order_.end(), 0u);
        }
    }

    Result<Segmentation> run() {
        result_.labels.geometry = image_.geometry;
        result_.labels.source = image_.source;
        result_.labels.structures.push_back({1, "", {230, 200, 120}});
        result_.labels.voxels.assign(image_.voxels.size(), 0);
        const bool has_seeds =
            options_.method != SegmentMethod::threshold && options_.method != SegmentMethod::otsu;
        if (has_seeds) {
            ANATOMESH_CHECK_STATUS(follow_seeds());
        } else {
            for (std::size_t at = 0; at < order_.size(); ++at) {
                SegmentOptions own = options_;
                own.seeds.clear();
                ANATOMESH_TRY(const auto found, segment(at, own));
                if (found) keep(at, *found);
            }
        }
        const auto& voxels = result_.labels.voxels;
        if (std::all_of(voxels.begin(), voxels.end(), [](auto voxel) { return voxel == 0; }))
            return Error{ErrorKind::geometry,
                         "E-SGM-001",
                         "no pixel of any slice belongs to the structure",
                         {image_.source, "", "", "", ""},
                         "choose another --threshold, --seed or --method"};
        return std::move(result_);
    }

  private:
    GreyImage slice_of(std::size_t at) const {
        GreyImage slice;
        slice.source = image_.source;
        slice.geometry = image_.geometry;
        slice.geometry.size[2] = 1;
        const auto first = image_.voxels.begin() + static_cast<std::ptrdiff_t>(order_[at] * pixels_);
        slice.voxels.assign(first, first + static_cast<std::ptrdiff_t>(pixels_));
        return slice;
    }

    // Nothing when no pixel of the slice belongs to the structure.
    Result<std::optional<std::vector<std::uint8_t>>> segment(std::size_t at, const SegmentOptions& options) {
        if (context_.cancelled()) return cancelled_error();
        RunContext own;
        own.threads = context_.threads;
        own.cancel = context_.cancel;
        auto found = segment_image(slice_of(at), options, own);
        if (!found.ok() && (found.error().code == "E-SGM-001" || found.error().code == "E-SGM-002"))
            return std::optional<std::vector<std::uint8_t>>{};
        if (!found.ok()) return found.error();
        for (Warning& warning : own.warnings)
            if (warning.code == "W-SGM-002" && !warned_of_motion_) {
                warned_of_motion_ = true;
                warning.place.slice = fmt::format("slice {}", order_[at]);
                context_.warn(warning);
            }
        if (!result_.low) result_.low = found.value().low;
        if (!result_.high) result_.high = found.value().high;
        result_.iterations = std::max(result_.iterations, found.value().iterations);
        const auto& voxels = found.value().labels.voxels;
        return std::optional(std::vector<std::uint8_t>(voxels.begin(), voxels.end()));
    }

    void keep(std::size_t at, const std::vector<std::uint8_t>& found) {
        std::copy(found.begin(), found.end(),
                  result_.labels.voxels.begin() + static_cast<std::ptrdiff_t>(order_[at] * pixels_));
    }

    Status follow_seeds() {
        std::vector<std::vector<std::array<std::uint32_t, 3>>> seeds(order_.size());
        for (std::size_t at = 0; at < order_.size(); ++at)
            for (const auto& seed : options_.seeds)
                if (seed[2] == order_[at]) seeds[at].push_back({seed[0], seed[1], 0});
        std::vector<std::size_t> seeded;
        for (std::size_t at = 0; at < order_.size(); ++at)
            if (!seeds[at].empty()) seeded.push_back(at);
        for (std::size_t s = 0; s < seeded.size(); ++s) {
            SegmentOptions own = options_;
            own.seeds = seeds[seeded[s]];
            ANATOMESH_TRY(const auto found, segment(seeded[s], own));
            if (!found) continue;
            keep(seeded[s], *found);
            const std::size_t first = s == 0 ? 0 : (seeded[s - 1] + seeded[s]) / 2 + 1;
            const std::size_t end =
                s + 1 == seeded.size() ? order_.size() : (seeded[s] + seeded[s + 1]) / 2 + 1;
            ANATOMESH_CHECK_STATUS(follow(seeded[s], *found, first, end, 1));
            ANATOMESH_CHECK_STATUS(follow(seeded[s], *found, first, end, -1));
        }
        return Nothing{};
    }

    Status follow(std::size_t from, std::vector<std::uint8_t> region, std::size_t first, std::size_t end,
                  int step) {
        auto at = static_cast<std::ptrdiff_t>(from) + step;
        for (; at >= static_cast<std::ptrdiff_t>(first) && at < static_cast<std::ptrdiff_t>(end);
             at += step) {
            const auto here = static_cast<std::size_t>(at);
            SegmentOptions own = options_;
            own.seeds.clear();
            own.start = region;
            // What belongs to the structure is what belonged to it where somebody said so.
            own.known_low = result_.low;
            own.known_high = result_.high;
            ANATOMESH_TRY(const auto found, segment(here, own));
            if (!found) return Nothing{};
            if (share_kept(region, *found) < slices_.kept_share) {
                context_.warn({"W-SGM-003",
                               "the region changes abruptly from one slice to the next",
                               {image_.source, fmt::format("slice {}", order_[here]), "", "", ""},
                               "the search ended there; a seed in this slice continues it"});
                return Nothing{};
            }
            keep(here, *found);
            region = *found;
        }
        return Nothing{};
    }

    // How much of `region` lies in `before`.
    static double share_kept(const std::vector<std::uint8_t>& before,
                             const std::vector<std::uint8_t>& region) {
        double both = 0, all = 0;
        for (std::size_t n = 0; n < region.size(); ++n) {
            both += before[n] && region[n];
            all += region[n];
        }
        return all > 0 ? both / all : 0;
    }

    const GreyImage& image_;
    const SegmentOptions& options_;
    const SliceOptions& slices_;
    RunContext& context_;
    std::size_t pixels_;
    std::vector<std::uint32_t> order_;
    Segmentation result_;
    bool warned_of_motion_ = false;
};

}  // namespace

Result<Segmentation> segment_slices(const GreyImage& image, const SegmentOptions& options,
                                    const SliceOptions& slices, RunContext& context) {
    return SliceSegmenter(image, options, slices, context).run();
}

Status reduce_speckle(GreyImage& image, double radius_mm, RunContext& context) {
    auto filter = itk::MedianImageFilter<ItkGrey, ItkGrey>::New();
    const auto spacing = spacing_of(image.geometry);
    itk::MedianImageFilter<ItkGrey, ItkGrey>::RadiusType radius;
    for (unsigned axis = 0; axis < 2; ++axis)
        radius[axis] = static_cast<itk::SizeValueType>(std::max(1.0, std::round(radius_mm / spacing[axis])));
    radius[2] = 0;
    filter->SetRadius(radius);
    filter->SetInput(itk_view<ItkGrey>(image.geometry, image.voxels.data()));
    ANATOMESH_CHECK_STATUS(run_filter(*filter, image.source, context));
    const float* values = filter->GetOutput()->GetBufferPointer();
    std::copy_n(values, image.voxels.size(), image.voxels.begin());
    return Nothing{};
}

}  // namespace anatomesh
