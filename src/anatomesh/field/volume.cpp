#include "anatomesh/field/volume.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

// Counts the points of a lattice in space: layers of a turned square lattice, each shifted against the one
// below.
Result<std::vector<StructureVolume>> StructureField::volumes(std::uint32_t count,
                                                             const VolumeOptions& options,
                                                             RunContext& context) const {
    const Box3 all = box();
    const Vec3 size = all.high - all.low;
    const double step = std::cbrt(size.x * size.y * size.z / options.points_in_all);
    const auto layers = static_cast<std::size_t>(std::ceil(size.z / step));
    const double height = size.z / static_cast<double>(layers);
    const double points_per_layer = static_cast<double>(options.points_in_all) / static_cast<double>(layers);
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
                members({q.x, q.y, z}, inside);
                for (const std::uint32_t s : inside) {
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
