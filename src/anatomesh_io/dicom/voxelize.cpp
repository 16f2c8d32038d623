#include "anatomesh_io/dicom/voxelize.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

// Voxel coordinates of points: the inverse of the steps.
class ToVoxels {
  public:
    explicit ToVoxels(const ImageGeometry& geometry) : origin_(geometry.origin) {
        const auto& step = geometry.step;
        const double volume = dot(step[0], cross(step[1], step[2]));
        for (std::size_t a = 0; a < 3; ++a)
            row_[a] = (1 / volume) * cross(step[(a + 1) % 3], step[(a + 2) % 3]);
    }
    Vec3 operator()(Vec3 point) const {
        const Vec3 p = point - origin_;
        return {dot(row_[0], p), dot(row_[1], p), dot(row_[2], p)};
    }

  private:
    Vec3 origin_;
    std::array<Vec3, 3> row_;
};

bool is_inside(const std::array<Vec3, 4>& v, Vec3 p) {
    return orient3d(p, v[1], v[2], v[3]) >= 0 && orient3d(v[0], p, v[2], v[3]) >= 0 &&
           orient3d(v[0], v[1], p, v[3]) >= 0 && orient3d(v[0], v[1], v[2], p) >= 0;
}

// The voxels from ceil(low) to floor(high) along an axis, a little more for rounding.
struct Range {
    std::uint32_t begin, end;
};
Range range_of(double low, double high, std::uint32_t size) {
    // A voxel whose centre is this near to a contour's end counts, so that rounding does not decide.
    // [voxels; 0 to 0.01; D rounding of doubles]
    constexpr double rounding = 1e-6;
    const double first = std::max(0.0, std::ceil(low - rounding));
    const double last = std::min(size - 1.0, std::floor(high + rounding));
    if (!(first <= last)) return {0, 0};
    return {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last) + 1};
}

}  // namespace

std::vector<std::uint16_t> voxelize(const TetMesh& mesh, const ImageGeometry& geometry, RunContext& context) {
    const ToVoxels to_voxels(geometry);
    std::vector<std::uint16_t> regions(geometry.voxel_count(), 0);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        if (c % 65536 == 0 && context.cancelled()) break;
        if (mesh.regions[c] == 0) continue;
        std::array<Vec3, 4> corner;
        Box3 box;
        for (std::size_t i = 0; i < 4; ++i) {
            corner[i] = mesh.points[mesh.cells[c][i]];
            box.extend(to_voxels(corner[i]));
        }
        const Range is = range_of(box.low.x, box.high.x, geometry.size[0]);
        const Range js = range_of(box.low.y, box.high.y, geometry.size[1]);
        const Range ks = range_of(box.low.z, box.high.z, geometry.size[2]);
        for (std::uint32_t k = ks.begin; k < ks.end; ++k)
            for (std::uint32_t j = js.begin; j < js.end; ++j)
                for (std::uint32_t i = is.begin; i < is.end; ++i) {
                    std::uint16_t& region = regions[geometry.index(i, j, k)];
                    if (region == 0 && is_inside(corner, geometry.position(i, j, k)))
                        region = mesh.regions[c];
                }
    }
    return regions;
}

ImageGeometry grid_around(const TetMesh& mesh, double size_mm) {
    Box3 box;
    for (const Vec3& point : mesh.points) box.extend(point);
    const auto count = [&](double extent) {
        return static_cast<std::uint32_t>(std::ceil(extent / size_mm)) + 1;
    };
    ImageGeometry geometry;
    geometry.origin = box.low;
    geometry.size = {count(box.high.x - box.low.x), count(box.high.y - box.low.y),
                     count(box.high.z - box.low.z)};
    geometry.step = {Vec3{size_mm, 0, 0}, Vec3{0, size_mm, 0}, Vec3{0, 0, size_mm}};
    return geometry;
}

}  // namespace anatomesh
