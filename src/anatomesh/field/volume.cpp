#include "anatomesh/field/volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

constexpr double block_steps = 3;  // edge of a block, in steps of the lattice that is counted
constexpr double steepest = 1.5;   // the field's distances change by no more than this per length

// The box in blocks. Where the field at the eight corners of a block lies in one region, and so far from the
// next that no interface can come into the block, that is the region of all of it.
class Blocks {
  public:
    Blocks(const StructureField& field, double edge, const RunContext& context) : low_(field.box().low) {
        const Vec3 size = field.box().high - low_;
        const std::array<double, 3> extent{size.x, size.y, size.z};
        for (std::size_t a = 0; a < 3; ++a) {
            count_[a] = static_cast<std::size_t>(std::ceil(extent[a] / edge));
            per_mm_[a] = static_cast<double>(count_[a]) / extent[a];
        }
        const Vec3 block{1 / per_mm_[0], 1 / per_mm_[1], 1 / per_mm_[2]};
        const double reach = steepest * 0.5 * length(block);
        nodes_.resize((count_[0] + 1) * (count_[1] + 1) * (count_[2] + 1));
        std::vector<std::uint8_t> clear(nodes_.size());
        parallel_for(count_[2] + 1, 1, context.threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end && !context.cancelled(); ++k) {
                for (std::size_t j = 0; j <= count_[1]; ++j) {
                    for (std::size_t i = 0; i <= count_[0]; ++i) {
                        const std::size_t n = node(i, j, k);
                        const Vec3 p =
                            low_ + Vec3{block.x * static_cast<double>(i), block.y * static_cast<double>(j),
                                        block.z * static_cast<double>(k)};
                        clear[n] = field.members_and_distance(p, nodes_[n]) > reach;
                    }
                }
            }
        });
        one_region_.assign(nodes_.size(), 0);
        for (std::size_t k = 0; k < count_[2]; ++k) {
            for (std::size_t j = 0; j < count_[1]; ++j) {
                for (std::size_t i = 0; i < count_[0]; ++i) {
                    bool one = true;
                    for (std::size_t corner = 0; corner < 8 && one; ++corner) {
                        const std::size_t n =
                            node(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
                        one = clear[n] && nodes_[n] == nodes_[node(i, j, k)];
                    }
                    one_region_[node(i, j, k)] = one;
                }
            }
        }
    }

    // The structures at p, or nothing where the field must be asked. Requires: p in the box.
    const std::vector<std::uint32_t>* members(Vec3 p) const {
        const auto index = [&](std::size_t axis, double from_low) {
            return std::min(static_cast<std::size_t>(from_low * per_mm_[axis]), count_[axis] - 1);
        };
        const std::size_t n = node(index(0, p.x - low_.x), index(1, p.y - low_.y), index(2, p.z - low_.z));
        return one_region_[n] ? &nodes_[n] : nullptr;
    }

  private:
    std::size_t node(std::size_t i, std::size_t j, std::size_t k) const {
        return (k * (count_[1] + 1) + j) * (count_[0] + 1) + i;
    }

    Vec3 low_;
    std::array<std::size_t, 3> count_{};
    std::array<double, 3> per_mm_{};
    std::vector<std::vector<std::uint32_t>> nodes_;  // the structures at the corners of blocks
    std::vector<std::uint8_t> one_region_;           // by the lowest corner
};

}  // namespace

// Counts the points of a lattice in space: layers of a turned square lattice, each shifted against the one
// below. The field itself is asked only in blocks that an interface may run through.
Result<std::vector<StructureVolume>> StructureField::volumes(std::uint32_t count,
                                                             const VolumeOptions& options,
                                                             RunContext& context) const {
    const Box3 all = box();
    const Vec3 size = all.high - all.low;
    const double step = std::cbrt(size.x * size.y * size.z / options.points_in_all);
    const auto layers = static_cast<std::size_t>(std::ceil(size.z / step));
    const double height = size.z / static_cast<double>(layers);
    const double points_per_layer = static_cast<double>(options.points_in_all) / static_cast<double>(layers);
    const Blocks blocks(*this, block_steps * step, context);
    std::vector<std::vector<std::uint64_t>> counts(layers, std::vector<std::uint64_t>(count, 0));
    std::vector<double> per_point(layers, 0);
    parallel_for(layers, 1, context.threads, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> inside;
        for (std::size_t k = begin; k < end && !context.cancelled(); ++k) {
            const double z = all.low.z + (static_cast<double>(k) + 0.5) * height;
            const Box2 layer{{all.low.x, all.low.y}, {all.high.x, all.high.y}};
            std::uint64_t points = 0;
            lattice_integral(layer, points_per_layer, k, [&](Vec2 q) {
                ++points;
                const std::vector<std::uint32_t>* here = blocks.members({q.x, q.y, z});
                if (!here) {
                    members({q.x, q.y, z}, inside);
                    here = &inside;
                }
                for (const std::uint32_t s : *here) {
                    if (s < count) ++counts[k][s];
                }
                return 0.0;
            });
            per_point[k] = size.x * size.y * height / static_cast<double>(std::max<std::uint64_t>(points, 1));
        }
    });
    if (context.cancelled()) return cancelled_error();
    std::vector<StructureVolume> totals(count, {0, std::numeric_limits<double>::quiet_NaN()});
    for (std::size_t k = 0; k < layers; ++k) {
        for (std::uint32_t s = 0; s < count; ++s) {
            totals[s].by_field += static_cast<double>(counts[k][s]) * per_point[k];
        }
    }
    return totals;
}

}  // namespace anatomesh
