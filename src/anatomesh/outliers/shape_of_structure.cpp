#include "anatomesh/outliers/shape_of_structure.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/field/make_structure_field.h"

namespace anatomesh {

namespace {

// Across the slices the grid has so many steps. [steps; >= 16; B]
constexpr double steps_across = 52;
// A grid coarser by so much must count the same, else what is counted is its own. [1; > 1; B]
constexpr double coarser_step = 1.4;
// It has so many from one slice to the next, [steps; >= 2; D what is drawn on one slice alone is a slice thick]
constexpr double steps_per_slice = 3;
// and so many along all slices. [steps; >= 16; B]
constexpr double most_steps_along = 160;
// Its points lie off the planes of slices by this share of a step: there a field may change its side. [1; 0 to 1; D]
constexpr double off_plane = 0.37;

// Points that are inside or outside; outside all round.
class Voxels {
  public:
    Voxels(const StructureField& field, const Plane& frame, const Box3& box, Vec3 step,
           const RunContext& context)
        : step_(step) {
        const Vec3 size = box.high - box.low;
        n_ = {static_cast<std::size_t>(size.x / step.x) + 4, static_cast<std::size_t>(size.y / step.y) + 4,
              static_cast<std::size_t>(size.z / step.z) + 4};
        inside_.assign(n_[0] * n_[1] * n_[2], 0);
        parallel_for(n_[2] - 2, 1, context.threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t z = begin + 1; z < end + 1; ++z) {
                for (std::size_t y = 1; y + 1 < n_[1]; ++y) {
                    for (std::size_t x = 1; x + 1 < n_[0]; ++x)
                        inside_[index(x, y, z)] =
                            field.value_within(0, place(frame, box.low, x, y, z), 0) < 0;
                }
            }
        });
    }

    StructureShape shape() const {
        StructureShape shape;
        const auto inside = static_cast<double>(std::count(inside_.begin(), inside_.end(), 1));
        shape.volume_mm3 = inside * step_.x * step_.y * step_.z;
        shape.parts = components(1, 3);
        const std::uint64_t outside = components(0, 1);
        shape.cavities = outside - 1;
        const auto holes = static_cast<std::int64_t>(shape.parts + shape.cavities) - euler_number();
        shape.tunnels = static_cast<std::uint64_t>(std::max<std::int64_t>(0, holes));
        return shape;
    }

  private:
    std::size_t index(std::size_t x, std::size_t y, std::size_t z) const {
        return (z * n_[1] + y) * n_[0] + x;
    }
    Vec3 place(const Plane& frame, Vec3 low, std::size_t x, std::size_t y, std::size_t z) const {
        const auto at = [&](double from, double step, std::size_t n) {
            return from + (static_cast<double>(n) - 1 - off_plane) * step;
        };
        return frame.origin + at(low.x, step_.x, x) * frame.u + at(low.y, step_.y, y) * frame.v +
               at(low.z, step_.z, z) * frame.normal;
    }

    // Of the union of the closed cubes round the points inside: its corners, edges, squares and cubes. Each is counted at
    // its low end; `along` has the bits of the axes that it runs along.
    std::int64_t euler_number() const {
        std::int64_t euler = 0;
        for (std::size_t z = 1; z < n_[2]; ++z) {
            for (std::size_t y = 1; y < n_[1]; ++y) {
                for (std::size_t x = 1; x < n_[0]; ++x) {
                    for (unsigned along = 0; along < 8; ++along) {
                        if (is_touched(x, y, z, along)) euler += std::popcount(along) % 2 == 0 ? 1 : -1;
                    }
                }
            }
        }
        return euler;
    }
    bool is_touched(std::size_t x, std::size_t y, std::size_t z, unsigned along) const {
        for (std::size_t k = along & 4u ? z : z - 1; k <= z; ++k) {
            for (std::size_t j = along & 2u ? y : y - 1; j <= y; ++j) {
                for (std::size_t i = along & 1u ? x : x - 1; i <= x; ++i) {
                    if (inside_[index(i, j, k)]) return true;
                }
            }
        }
        return false;
    }

    // Points are neighbours if they differ by one in `most` coordinates at most.
    std::uint64_t components(std::uint8_t side, int most) const {
        std::vector<std::uint8_t> seen(inside_.size(), 0);
        std::vector<std::size_t> open;
        std::uint64_t count = 0;
        for (std::size_t start = 0; start < inside_.size(); ++start) {
            if (seen[start] || inside_[start] != side) continue;
            ++count;
            seen[start] = 1;
            open.assign(1, start);
            while (!open.empty()) {
                const std::size_t at = open.back();
                open.pop_back();
                const std::size_t x = at % n_[0], y = at / n_[0] % n_[1], z = at / n_[0] / n_[1];
                for (std::size_t k = z > 0 ? z - 1 : z; k <= std::min(z + 1, n_[2] - 1); ++k) {
                    for (std::size_t j = y > 0 ? y - 1 : y; j <= std::min(y + 1, n_[1] - 1); ++j) {
                        for (std::size_t i = x > 0 ? x - 1 : x; i <= std::min(x + 1, n_[0] - 1); ++i) {
                            const std::size_t to = index(i, j, k);
                            if ((i != x) + (j != y) + (k != z) > most || seen[to] || inside_[to] != side)
                                continue;
                            seen[to] = 1;
                            open.push_back(to);
                        }
                    }
                }
            }
        }
        return count;
    }

    Vec3 step_;
    std::array<std::size_t, 3> n_{};
    std::vector<std::uint8_t> inside_;
};

}  // namespace

Result<StructureShape> shape_of_structure(const ContourSet& set, std::uint32_t structure,
                                          const FieldOptions& options, const RunContext& context) {
    const ContourSet alone = choose_structures(set, std::array{structure});
    RunContext quiet;
    quiet.threads = context.threads;
    quiet.cancel = context.cancel;
    ANATOMESH_TRY(const std::shared_ptr<const StructureField> field,
                  make_structure_field(alone, options, quiet));
    const Plane frame = make_plane({}, alone.slices[alone.contours[0].slice].plane.normal);
    Box3 box;
    for (const Vec3& p : alone.points) {
        const Vec2 across = frame.to_plane(p);
        box.extend({across.x, across.y, frame.signed_distance(p)});
    }
    const double spacing = field->slice_spacing();
    box = box.grown(spacing);
    const Vec3 size = box.high - box.low;
    const double across = std::max(size.x, size.y) / steps_across;
    const double along = std::max(spacing / steps_per_slice, size.z / most_steps_along);
    const auto shape_at = [&](double step) {
        return Voxels(*field, frame, box, {step, step, along}, context).shape();
    };
    StructureShape shape = shape_at(across);
    const StructureShape coarser = shape_at(coarser_step * across);
    shape.is_counted = shape.parts == coarser.parts && shape.tunnels == coarser.tunnels &&
                       shape.cavities == coarser.cavities;
    return shape;
}

}  // namespace anatomesh
