// find_meetings: where contours of different structures on one slice cross or have a vertex in common.
#pragma once

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "anatomesh/contour/walls/conflated_contours.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Where two loops meet: how far along either, the n-th vertex at n.
struct Meeting {
    std::array<std::uint32_t, 2> loops{};  // rising
    double along_first = 0, along_second = 0;
    std::uint32_t vertex = no_vertex;  // the common one; none where they cross

    auto key() const { return std::tuple{loops, along_first, along_second}; }
};

// Returns the meetings of loops of different structures, by loops and along the first, each once. `at`: the vertices'
// places in the slice's plane. Complexity: O(n log n + pairs of segments whose boxes meet).
std::vector<Meeting> find_meetings(const std::vector<ConflatedContour>& loops, const std::vector<Vec2>& at);

}  // namespace anatomesh
