#include "anatomesh_io/segment/chan_vese.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace anatomesh {

namespace {

struct Offset {
    int i, j, k;
};

// The lines through a pixel (in a slice) or planes through a voxel whose least and largest values smooth.
std::vector<std::vector<Offset>> structuring_elements(bool is_flat) {
    if (is_flat)
        return {{{-1, 0, 0}, {1, 0, 0}},
                {{0, -1, 0}, {0, 1, 0}},
                {{-1, -1, 0}, {1, 1, 0}},
                {{-1, 1, 0}, {1, -1, 0}}};
    // Planes square to the axes and to the diagonals of the faces.
    const Offset normals[] = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 1, 0}, {1, -1, 0},
                              {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1}};
    std::vector<std::vector<Offset>> elements;
    for (const Offset n : normals) {
        elements.emplace_back();
        for (int k = -1; k <= 1; ++k)
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    if ((i || j || k) && i * n.i + j * n.j + k * n.k == 0)
                        elements.back().push_back({i, j, k});
    }
    return elements;
}

class ChanVese {
  public:
    ChanVese(const GreyImage& image, std::vector<std::uint8_t> start, const ChanVeseOptions& options,
             RunContext& context)
        : image_(image),
          options_(options),
          context_(context),
          size_{static_cast<int>(image.geometry.size[0]), static_cast<int>(image.geometry.size[1]),
                static_cast<int>(image.geometry.size[2])},
          elements_(structuring_elements(size_[2] == 1)),
          inside_(std::move(start)),
          next_(inside_.size()) {}

    Result<ChanVeseResult> run() {
        ChanVeseResult result;
        std::vector<std::uint8_t> before = inside_, before_that;
        while (result.iterations < options_.iterations && !result.is_settled) {
            if (context_.cancelled()) return cancelled_error();
            find_box();
            if (is_empty_) break;
            find_means(result);
            move(result);
            for (std::uint32_t pass = 0; pass < options_.smoothing; ++pass)
                smooth((pass + result.iterations) % 2 == 0);
            ++result.iterations;
            // The smoothing alternates: what stands still may swing between two shapes.
            result.is_settled = inside_ == before || inside_ == before_that;
            before_that = std::move(before);
            before = inside_;
        }
        result.is_settled = result.is_settled || is_empty_;
        result.inside = std::move(inside_);
        return result;
    }

  private:
    std::size_t index(int i, int j, int k) const {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) +
                static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(size_[0]) +
               static_cast<std::size_t>(i);
    }
    template <class Body>
    void each_voxel(Body&& body) const {
        for (int k = low_[2]; k < high_[2]; ++k)
            for (int j = low_[1]; j < high_[1]; ++j)
                for (int i = low_[0]; i < high_[0]; ++i) body(i, j, k, index(i, j, k));
    }

    // The box about the region.
    void find_box() {
        std::array<int, 3> low{size_}, high{0, 0, 0};
        std::size_t n = 0;
        for (int k = 0; k < size_[2]; ++k)
            for (int j = 0; j < size_[1]; ++j)
                for (int i = 0; i < size_[0]; ++i, ++n) {
                    if (!inside_[n]) continue;
                    low = {std::min(low[0], i), std::min(low[1], j), std::min(low[2], k)};
                    high = {std::max(high[0], i + 1), std::max(high[1], j + 1), std::max(high[2], k + 1)};
                }
        is_empty_ = high[0] == 0;
        low_ = low;
        high_ = high;
    }
    // False when the box is the image already.
    bool grow_box(int by) {
        const auto before = std::pair(low_, high_);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low_[axis] = std::max(0, low_[axis] - by);
            high_[axis] = std::min(size_[axis], high_[axis] + by);
        }
        return before != std::pair(low_, high_);
    }

    // The means inside and in the surroundings, which are taken wider while they are as the inside is: a
    // small beginning within a large even region.
    void find_means(ChanVeseResult& result) {
        int margin = static_cast<int>(options_.surroundings);
        for (bool grows = true; grows; margin *= 2) {
            grows = grow_box(margin);
            double sum[2] = {0, 0}, count[2] = {0, 0}, squares = 0;
            each_voxel([&](int, int, int, std::size_t n) {
                const double value = image_.voxels[n];
                sum[inside_[n]] += value;
                count[inside_[n]] += 1;
                if (inside_[n]) squares += value * value;
            });
            result.mean_inside = sum[1] / count[1];
            result.mean_outside = count[0] > 0 ? sum[0] / count[0] : result.mean_inside;
            const double variance = squares / count[1] - result.mean_inside * result.mean_inside;
            const double apart = result.mean_inside - result.mean_outside;
            if (apart * apart > std::max(variance, 1e-12 * squares / count[1])) return;
        }
    }

    // Voxels on either side of the boundary go to the region that they are nearer to in value.
    void move(const ChanVeseResult& means) {
        next_ = inside_;
        each_voxel([&](int i, int j, int k, std::size_t n) {
            if (!differs_from_neighbor(i, j, k, n)) return;
            const double in = image_.voxels[n] - means.mean_inside,
                         out = image_.voxels[n] - means.mean_outside;
            if (in * in < out * out) next_[n] = 1;
            if (in * in > out * out) next_[n] = 0;
        });
        std::swap(inside_, next_);
    }
    bool differs_from_neighbor(int i, int j, int k, std::size_t n) const {
        const std::uint8_t own = inside_[n];
        const std::size_t row = static_cast<std::size_t>(size_[0]),
                          slice = row * static_cast<std::size_t>(size_[1]);
        return (i > 0 && inside_[n - 1] != own) || (i + 1 < size_[0] && inside_[n + 1] != own) ||
               (j > 0 && inside_[n - row] != own) || (j + 1 < size_[1] && inside_[n + row] != own) ||
               (k > 0 && inside_[n - slice] != own) || (k + 1 < size_[2] && inside_[n + slice] != own);
    }

    // One after the other: the largest of the least values over the elements, and the least of the largest.
    void smooth(bool least_first) {
        for (const bool least : {least_first, !least_first}) {
            next_ = inside_;
            each_voxel([&](int i, int j, int k, std::size_t n) {
                // An element of equal values leaves the voxel as it is.
                const std::uint8_t sought = least ? 1 : 0;
                if (inside_[n] != sought) return;
                bool stays = false;
                for (const auto& element : elements_) stays = stays || is_whole(element, i, j, k, sought);
                if (!stays) next_[n] = static_cast<std::uint8_t>(1 - sought);
            });
            std::swap(inside_, next_);
        }
    }
    bool is_whole(const std::vector<Offset>& element, int i, int j, int k, std::uint8_t sought) const {
        for (const Offset o : element) {
            const int x = std::clamp(i + o.i, 0, size_[0] - 1), y = std::clamp(j + o.j, 0, size_[1] - 1),
                      z = std::clamp(k + o.k, 0, size_[2] - 1);
            if (inside_[index(x, y, z)] != sought) return false;
        }
        return true;
    }

    const GreyImage& image_;
    const ChanVeseOptions& options_;
    RunContext& context_;
    std::array<int, 3> size_;
    std::vector<std::vector<Offset>> elements_;
    std::vector<std::uint8_t> inside_, next_;
    std::array<int, 3> low_{}, high_{};
    bool is_empty_ = false;
};

}  // namespace

Result<ChanVeseResult> chan_vese(const GreyImage& image, std::vector<std::uint8_t> start,
                                 const ChanVeseOptions& options, RunContext& context) {
    assert(start.size() == image.voxels.size());
    return ChanVese(image, std::move(start), options, context).run();
}

}  // namespace anatomesh
