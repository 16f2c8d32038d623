// Components, tunnels and cavities of a solid sampled on a grid: laws of the field about what is joined to
// what.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <ostream>
#include <vector>

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh::fixtures {

struct Topology {
    int components = 0, tunnels = 0, cavities = 0;
    friend bool operator==(const Topology&, const Topology&) = default;
    friend std::ostream& operator<<(std::ostream& out, const Topology& t) {
        return out << t.components << " components, " << t.tunnels << " tunnels, " << t.cavities
                   << " cavities";
    }
};

// Closed cubes round the points that are inside; 0 all round.
class Voxels {
  public:
    Voxels(const StructureField& field, double step) {
        const Box3 box = field.box();
        const Vec3 size = box.high - box.low, low = box.low - Vec3{0.63 * step, 0.71 * step, 0.57 * step};
        n_ = {static_cast<int>(size.x / step) + 4, static_cast<int>(size.y / step) + 4,
              static_cast<int>(size.z / step) + 4};
        inside_.assign(static_cast<std::size_t>(n_[0]) * n_[1] * n_[2], 0);
        for (int z = 1; z + 1 < n_[2]; ++z) {
            for (int y = 1; y + 1 < n_[1]; ++y) {
                for (int x = 1; x + 1 < n_[0]; ++x)
                    inside_[index(x, y, z)] =
                        field.value(0, low + Vec3{(x - 1) * step, (y - 1) * step, (z - 1) * step}) < 0;
            }
        }
    }

    // Euler's number of the union of the cubes gives the tunnels.
    Topology topology() const {
        Topology result;
        result.components = components(1, 3);
        result.cavities = components(0, 1) - 1;
        std::int64_t euler = 0;
        for (int z = 1; z < n_[2]; ++z) {
            for (int y = 1; y < n_[1]; ++y) {
                for (int x = 1; x < n_[0]; ++x) {
                    // The corner at the low end of voxel (x, y, z), the edges, squares and the cube that
                    // start there.
                    for (int along = 0; along < 8; ++along) {
                        const int dimensions = (along & 1) + (along >> 1 & 1) + (along >> 2);
                        if (touches(x, y, z, along)) euler += dimensions % 2 == 0 ? 1 : -1;
                    }
                }
            }
        }
        result.tunnels = static_cast<int>(result.components + result.cavities - euler);
        return result;
    }

  private:
    std::size_t index(int x, int y, int z) const {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(n_[1]) + static_cast<std::size_t>(y)) *
                   static_cast<std::size_t>(n_[0]) +
               static_cast<std::size_t>(x);
    }
    bool touches(int x, int y, int z, int along) const {
        for (int k = along & 4 ? 0 : -1; k <= 0; ++k) {
            for (int j = along & 2 ? 0 : -1; j <= 0; ++j) {
                for (int i = along & 1 ? 0 : -1; i <= 0; ++i) {
                    if (inside_[index(x + i, y + j, z + k)]) return true;
                }
            }
        }
        return false;
    }
    // Voxels are neighbours if they differ in at most `most` coordinates.
    int components(std::uint8_t wanted, int most) const {
        std::vector<bool> seen(inside_.size(), false);
        std::vector<std::array<int, 3>> open;
        int count = 0;
        for (int z = 0; z < n_[2]; ++z) {
            for (int y = 0; y < n_[1]; ++y) {
                for (int x = 0; x < n_[0]; ++x) {
                    if (seen[index(x, y, z)] || inside_[index(x, y, z)] != wanted) continue;
                    ++count;
                    seen[index(x, y, z)] = true;
                    open.push_back({x, y, z});
                    while (!open.empty()) {
                        const auto at = open.back();
                        open.pop_back();
                        for (int step = 0; step < 27; ++step) {
                            const std::array<int, 3> d{step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1};
                            if (std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]) > most) continue;
                            const std::array<int, 3> to{at[0] + d[0], at[1] + d[1], at[2] + d[2]};
                            bool outside = false;
                            for (std::size_t c = 0; c < 3; ++c) outside |= to[c] < 0 || to[c] >= n_[c];
                            if (outside) continue;
                            const std::size_t i = index(to[0], to[1], to[2]);
                            if (seen[i] || inside_[i] != wanted) continue;
                            seen[i] = true;
                            open.push_back(to);
                        }
                    }
                }
            }
        }
        return count;
    }

    std::array<int, 3> n_{};
    std::vector<std::uint8_t> inside_;
};

}  // namespace anatomesh::fixtures
