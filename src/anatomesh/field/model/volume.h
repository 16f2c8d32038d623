// field_volumes: the volume that the field itself encloses, to compare a mesh with.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

struct VolumeOptions {
    // Points of the sampling lattice over the box of a structure between two neighbouring slices, at most.
    // [100, 1e8]
    std::uint32_t points_per_slab = 60000;
    // Points in all slabs of all structures: fewer a slab where there are many of them, but 4000. [1e4, 4e9]
    std::uint32_t points_in_slabs = 280000;
    // Planes that are not parallel: points over the box of the structure; where there are n of them, over the
    // box of each fewer by the square root of n, but 100,000. [1000, 1e9]
    std::uint32_t points_in_all = 1000000;
};

// The volume of every structure by the integral of the field's cross-sections.
// Parallel slices: slice integration of the drawn areas, which are exact, plus the integral of the difference
// between it and the field, which is not zero only where the two contours differ; along the normal by
// five values, nine where the surface curves much (where structures of an exclusive set meet: 12 sections), in
// the plane on a lattice that no straight wall runs along, whose points stand for columns a step wide. Planes
// in any position: a lattice in space over the box of each. Error: some 0.01 %. Guarantees:
// the same at any thread count. Errors: cancelled.
inline Result<std::vector<StructureVolume>> field_volumes(const StructureField& field,
                                                          std::uint32_t structures,
                                                          const VolumeOptions& options, RunContext& context) {
    return field.volumes(structures, options, context);
}

// Integral of f(point, step of the lattice) over a box by the points of a square lattice turned by the golden
// angle, whose rows no straight line of small slope follows. The lattices of different layers are shifted
// against each other: what one layer's makes too large that of the next like it does not. Requires: f
// vanishes outside the box.
template <class F>
double lattice_integral(const Box2& box, double points, std::size_t layer, F&& f) {
    const Vec2 size = box.high - box.low, centre = 0.5 * (box.low + box.high);
    // The layer's multiple of two irrational numbers, less the whole part.
    const double turn = static_cast<double>(layer);
    const Vec2 shift{turn * 0.7548776662466927 - std::floor(turn * 0.7548776662466927),
                     turn * 0.5698402909980532 - std::floor(turn * 0.5698402909980532)};
    const double step = std::sqrt(size.x * size.y / points);
    if (!(step > 0)) return 0;
    // tan of the angle is the golden ratio less one: the slope hardest to approximate by fractions.
    const double slope = 0.5 * (std::sqrt(5.0) - 1), cosine = 1 / std::sqrt(1 + slope * slope);
    const Vec2 u{step * cosine, step * slope * cosine}, v{-u.y, u.x};
    const auto reach = static_cast<std::int64_t>(0.5 * length(size) / step) + 1;
    double sum = 0;
    for (std::int64_t j = -reach; j <= reach; ++j) {
        for (std::int64_t i = -reach; i <= reach; ++i) {
            const Vec2 q =
                centre + (static_cast<double>(i) + shift.x) * u + (static_cast<double>(j) + shift.y) * v;
            if (box.contains(q)) sum += f(q, step);
        }
    }
    return sum * step * step;
}

}  // namespace anatomesh
