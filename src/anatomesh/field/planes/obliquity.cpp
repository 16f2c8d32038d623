#include "anatomesh/field/planes/obliquity.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// A grid of obliquity factors has no more nodes on its longer side; beyond it the cells grow.
// [nodes; >= 4; B]
constexpr double most_nodes = 64;
// No factor is smaller, because the surface has to keep off the plane but on its contours.
// [1; 0 to 1; M 2026-11 71 sets of crossing stacks]
constexpr float least_obliquity = 0.05F;
// A factor from this on counts as none, and a grid without smaller ones is not kept. [1; 0 to 1; B]
constexpr float hardly = 0.99F;
// The boundary may be this share of the way further from the point than from its foot on the other plane:
// feet on few planes tell little. [1; 0 to 1; M 2026-11 ball by two planes in each direction]
constexpr double change_on_the_way = 0.25;
// Planes nearer than this weigh no more, so that one at a node does not outweigh all others.
// [cells; 0 to 1; D]
constexpr double nearest = 0.04;

// A patch near the node, with what it weighs and what is drawn near the node's foot there.
struct Across {
    double distance, weight;
    std::vector<DistanceInPlane> drawn;
};

double distance_of(const std::vector<DistanceInPlane>& drawn, std::uint32_t structure, double clamp) {
    const auto at = std::find_if(drawn.begin(), drawn.end(),
                                 [&](const DistanceInPlane& one) { return one.structure == structure; });
    return at == drawn.end() ? clamp : at->distance;
}

// The obliquity factors on one patch.
class PatchObliquity {
  public:
    PatchObliquity(const PatchesSeen& seen, std::uint32_t patch)
        : seen_(seen), patch_(patch), box_(seen.boxes[patch]) {
        const double width = box_.high.x - box_.low.x, height = box_.high.y - box_.low.y;
        cell_ = std::max(seen.cell, std::max(width, height) / (most_nodes - 2));
        nx_ = static_cast<std::uint32_t>(width / cell_) + 2;
        ny_ = static_cast<std::uint32_t>(height / cell_) + 2;
    }

    std::vector<ObliquityMap> run() {
        for (std::uint32_t j = 0; j < ny_; ++j) {
            for (std::uint32_t i = 0; i < nx_; ++i) look_from(i, j);
        }
        std::vector<ObliquityMap> maps;
        for (auto& [structure, values] : values_) {
            if (std::any_of(values.begin(), values.end(), [](float v) { return v < hardly; }))
                maps.push_back(cropped(structure, values));
        }
        return maps;
    }

  private:
    void look_from(std::uint32_t i, std::uint32_t j) {
        const Vec2 q{box_.low.x + i * cell_, box_.low.y + j * cell_};
        find_across(seen_.planes[patch_].to_space(q));
        if (count_ == 0) return;
        seen_.distances(patch_, q, own_);
        structures_.clear();
        for (const DistanceInPlane& one : own_) structures_.push_back(one.structure);
        for (std::size_t k = 0; k < count_; ++k) {
            for (const DistanceInPlane& one : across_[k].drawn) structures_.push_back(one.structure);
        }
        std::sort(structures_.begin(), structures_.end());
        structures_.erase(std::unique(structures_.begin(), structures_.end()), structures_.end());
        for (const std::uint32_t structure : structures_) {
            const double obliquity = obliquity_at(structure);
            if (obliquity < 1) values_of(structure)[std::size_t{j} * nx_ + i] = static_cast<float>(obliquity);
        }
    }

    // The planes that cross the patch's near p.
    void find_across(Vec3 p) {
        seen_.near(patch_, p, near_);
        count_ = 0;
        for (const auto& [patch, distance] : near_) {
            const double along = dot(seen_.planes[patch].normal, seen_.planes[patch_].normal);
            const double r = std::max(distance, nearest * seen_.cell);
            const double weight = (1 - along * along) * (seen_.radius - r) / (seen_.radius * r);
            if (!(weight > 0)) continue;
            if (count_ == across_.size()) across_.emplace_back();
            Across& one = across_[count_++];
            one.distance = r;
            one.weight = weight;
            seen_.distances(patch, seen_.planes[patch].to_plane(p), one.drawn);
        }
    }

    double obliquity_at(std::uint32_t structure) const {
        const double own = distance_of(own_, structure, seen_.clamp);
        double total = 1 / seen_.radius, sum = total;
        for (std::size_t k = 0; k < count_; ++k) {
            const Across& one = across_[k];
            const double other = distance_of(one.drawn, structure, seen_.clamp);
            double far = std::abs(other);
            if ((own < 0) != (other < 0)) far = std::min(far, one.distance);
            far += change_on_the_way * one.distance;
            sum += one.weight * (std::abs(own) > far ? far / std::abs(own) : 1);
            total += one.weight;
        }
        return sum / total;
    }

    std::vector<float>& values_of(std::uint32_t structure) {
        auto at = std::lower_bound(values_.begin(), values_.end(), structure,
                                   [](const auto& one, std::uint32_t s) { return one.first < s; });
        if (at == values_.end() || at->first != structure)
            at = values_.insert(at, {structure, std::vector<float>(std::size_t{nx_} * ny_, 1)});
        return at->second;
    }

    // Without the rows and columns where there is hardly any, but for those next to others.
    ObliquityMap cropped(std::uint32_t structure, const std::vector<float>& values) const {
        std::uint32_t left = nx_ - 1, right = 0, low = ny_ - 1, high = 0;
        for (std::uint32_t j = 0; j < ny_; ++j) {
            for (std::uint32_t i = 0; i < nx_; ++i) {
                if (!(values[std::size_t{j} * nx_ + i] < hardly)) continue;
                left = std::min(left, std::max(i, 1u) - 1);
                right = std::max(right, std::min(i + 1, nx_ - 1));
                low = std::min(low, std::max(j, 1u) - 1);
                high = std::max(high, std::min(j + 1, ny_ - 1));
            }
        }
        std::vector<float> kept;
        for (std::uint32_t j = low; j <= high; ++j) {
            for (std::uint32_t i = left; i <= right; ++i)
                kept.push_back(std::max(least_obliquity, values[std::size_t{j} * nx_ + i]));
        }
        return {structure,
                {box_.low.x + left * cell_, box_.low.y + low * cell_},
                cell_,
                right - left + 1,
                std::move(kept)};
    }

    const PatchesSeen& seen_;
    std::uint32_t patch_;
    Box2 box_;
    double cell_ = 0;
    std::uint32_t nx_ = 0, ny_ = 0;
    std::vector<std::pair<std::uint32_t, std::vector<float>>> values_;  // by structure, rising
    std::vector<PatchNear> near_;
    std::vector<Across> across_;  // the first `count_`
    std::size_t count_ = 0;
    std::vector<DistanceInPlane> own_;
    std::vector<std::uint32_t> structures_;
};

}  // namespace

ObliquityMap::ObliquityMap(std::uint32_t structure, Vec2 low, double cell, std::uint32_t nx,
                           std::vector<float> values)
    : structure_(structure),
      nx_(nx),
      ny_(static_cast<std::uint32_t>(values.size() / nx)),
      low_(low),
      inverse_cell_(1 / cell),
      values_(std::move(values)) {
    assert(nx_ > 1 && ny_ > 1 && values_.size() == std::size_t{nx_} * ny_);
}

double ObliquityMap::at(Vec2 q) const {
    const double x = std::clamp((q.x - low_.x) * inverse_cell_, 0.0, nx_ - 1.0),
                 y = std::clamp((q.y - low_.y) * inverse_cell_, 0.0, ny_ - 1.0);
    const std::uint32_t i = std::min(static_cast<std::uint32_t>(x), nx_ - 2),
                        j = std::min(static_cast<std::uint32_t>(y), ny_ - 2);
    const double along = x - i, up = y - j;
    const float* v = values_.data() + std::size_t{j} * nx_ + i;
    return (1 - up) * ((1 - along) * v[0] + along * v[1]) + up * ((1 - along) * v[nx_] + along * v[nx_ + 1]);
}

ObliquityFactors ObliquityFactors::of(const PatchesSeen& seen, RunContext& context) {
    ObliquityFactors obliquities;
    obliquities.maps_.resize(seen.planes.size());
    parallel_for(seen.planes.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end && !context.cancelled(); ++n) {
            if (!seen.boxes[n].empty())
                obliquities.maps_[n] = PatchObliquity(seen, static_cast<std::uint32_t>(n)).run();
        }
    });
    return obliquities;
}

}  // namespace anatomesh
