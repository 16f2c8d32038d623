#include "anatomesh/element/grey.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

// A thread takes so many cells at a time. [cells; >= 1; B]
constexpr std::size_t cells_at_once = 512;

// The image with the map from space to its voxels.
class Sampler {
  public:
    explicit Sampler(const GreyImage& image) : image_(image) {
        const auto& step = image.geometry.step;
        const double volume = dot(cross(step[0], step[1]), step[2]);
        assert(volume != 0);
        for (std::size_t k = 0; k < 3; ++k) {
            to_index_[k] = (1 / volume) * cross(step[(k + 1) % 3], step[(k + 2) % 3]);
        }
    }

    double smallest_step() const {
        const auto& step = image_.geometry.step;
        return std::min({length(step[0]), length(step[1]), length(step[2])});
    }
    std::array<double, 3> index(Vec3 p) const {
        const Vec3 offset = p - image_.geometry.origin;
        return {dot(offset, to_index_[0]), dot(offset, to_index_[1]), dot(offset, to_index_[2])};
    }
    bool contains(const std::array<double, 3>& index) const {
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(index[k] >= -0.5 && index[k] <= image_.geometry.size[k] - 0.5)) return false;
        }
        return true;
    }
    // Between the eight nearest voxels; beyond the centres of the last ones, theirs.
    double value(const std::array<double, 3>& index) const {
        std::array<std::uint32_t, 3> low, high;
        std::array<double, 3> share;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t last = image_.geometry.size[k] - 1;
            const double at = std::clamp(index[k], 0.0, static_cast<double>(last));
            low[k] = static_cast<std::uint32_t>(at);
            high[k] = std::min(low[k] + 1, last);
            share[k] = at - low[k];
        }
        const auto row = [&](std::uint32_t j, std::uint32_t k) {
            return (1 - share[0]) * voxel(low[0], j, k) + share[0] * voxel(high[0], j, k);
        };
        const auto layer = [&](std::uint32_t k) {
            return (1 - share[1]) * row(low[1], k) + share[1] * row(high[1], k);
        };
        return (1 - share[2]) * layer(low[2]) + share[2] * layer(high[2]);
    }

  private:
    double voxel(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
        return image_.voxels[image_.geometry.index(i, j, k)];
    }

    const GreyImage& image_;
    std::array<Vec3, 3> to_index_;
};

struct CellGrey {
    double mean = 0;
    std::uint32_t samples = 0, inside = 0;
};

// Samples: the centres of the upright tetrahedra among those into which n layers divide the cell.
CellGrey cell_grey(const Sampler& sampler, const std::array<Vec3, 4>& corners, const GreyOptions& options) {
    double longest = 0;
    for (const auto& [a, b] : cell_edges) {
        longest = std::max(
            longest, length(corners[static_cast<std::size_t>(a)] - corners[static_cast<std::size_t>(b)]));
    }
    const double wanted = std::ceil(longest / (options.spacing_voxels * sampler.smallest_step()));
    const int n = static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(options.max_layers)));
    // The map to voxels is affine: its corners are enough.
    std::array<std::array<double, 3>, 4> at;
    for (std::size_t v = 0; v < 4; ++v) at[v] = sampler.index(corners[v]);
    CellGrey result;
    double inside = 0, all = 0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; i + j < n; ++j) {
            for (int k = 0; i + j + k < n; ++k) {
                const std::array<double, 4> share{(i + 0.25) / n, (j + 0.25) / n, (k + 0.25) / n,
                                                  (n - 1 - i - j - k + 0.25) / n};
                std::array<double, 3> p{};
                for (std::size_t v = 0; v < 4; ++v) {
                    for (std::size_t x = 0; x < 3; ++x) p[x] += share[v] * at[v][x];
                }
                const double value = sampler.value(p);
                ++result.samples;
                all += value;
                if (!sampler.contains(p)) continue;
                ++result.inside;
                inside += value;
            }
        }
    }
    result.mean = result.inside > 0 ? inside / result.inside : all / result.samples;
    return result;
}

}  // namespace

Result<GreyResult> grey_values(const TetMesh& mesh, const GreyImage& image, const GreyOptions& options,
                               RunContext& context) {
    assert(image.geometry.voxel_count() > 0 && options.spacing_voxels > 0 && options.max_layers > 0);
    const Sampler sampler(image);
    std::vector<CellGrey> cells(mesh.cells.size());
    const auto corners_of = [&](std::size_t c) {
        std::array<Vec3, 4> corners;
        for (std::size_t v = 0; v < 4; ++v) corners[v] = mesh.points[mesh.cells[c][v]];
        return corners;
    };
    parallel_for(cells.size(), cells_at_once, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end && !context.cancelled(); ++c) {
            cells[c] = cell_grey(sampler, corners_of(c), options);
        }
    });
    if (context.cancelled()) return cancelled_error();

    GreyResult result;
    GreyStats& stats = result.stats;
    double volume = 0;
    for (std::size_t c = 0; c < cells.size(); ++c) {
        const CellGrey& cell = cells[c];
        result.values.push_back(cell.mean);
        stats.samples += cell.samples;
        stats.cells_outside += cell.inside == 0;
        stats.cells_cut += cell.inside > 0 && cell.inside < cell.samples;
        stats.low = c == 0 ? cell.mean : std::min(stats.low, cell.mean);
        stats.high = c == 0 ? cell.mean : std::max(stats.high, cell.mean);
        const auto p = corners_of(c);
        const double size = signed_volume(p[0], p[1], p[2], p[3]);
        volume += size;
        stats.mean += size * cell.mean;
    }
    if (volume > 0) stats.mean /= volume;
    if (stats.cells_outside == cells.size() && !cells.empty()) {
        return Error{ErrorKind::geometry,
                     "E-ELM-001",
                     "no tetrahedron of the model lies in the image",
                     {image.source, "", "", "", ""},
                     "give the image that the model was made from, with the same axes"};
    }
    return result;
}

}  // namespace anatomesh
