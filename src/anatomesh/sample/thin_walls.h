// Where walls and gaps are thinner than the edge length, and the finer lattice sites about them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/sample/interface_probe.h"
#include "anatomesh/sample/local_thickness.h"

namespace anatomesh {

// Walls and gaps thinner than this need finer points. [sizes; 0 to 1; M 2026-11 skull]
inline constexpr double thin_wall = 0.5;
// The finest edge length is the size halved so often. [halvings; 0 to 8; B]
inline constexpr int max_thin_level = 3;

// A place on a surface where the edge length should be the size / 2^level.
struct ThinSpot {
    Vec3 point;
    int level = 0;  // 1 .. max_thin_level
};

// The level that a wall of this thickness needs: an edge length of at most 5/3 of the thickness; 0 when it is not thin.
int level_of(double thickness, double size);

// The thickness at `surface`, where a lattice point p was moved to, of every structure whose surface lies there: the
// smallest. Nothing when p moved too little to tell the direction. `changed` is scratch space.
std::optional<double> thickness_beside(Vec3 p, Vec3 surface, const LocalThickness& local_thickness,
                                       InterfaceProbe& probe, std::uint32_t structures,
                                       std::vector<std::uint32_t>& changed);

// The points of the body-centred cubic lattice of edge length size / 2^level within 0.7 sizes of the spots of this level
// or a finer one, each once, in a fixed order. Complexity: O(n log n) in the sites.
std::vector<Vec3> fine_sites(Vec3 low, const std::vector<ThinSpot>& spots, int level, double size);

}  // namespace anatomesh
