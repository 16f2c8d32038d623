// solve_movement: the smoothest small movement of contours that brings corresponding ends together.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// How a node of the contours' graph is held.
enum class Hold : std::uint8_t {
    free,
    anchor,  // moves by (position of its group - place) * direction
    pinned   // moves by `direction`
};

struct MovementNode {
    Hold hold = Hold::free;
    std::uint32_t group = 0;
    double place = 0;
    Vec2 direction;
};

struct MovementEdge {
    std::uint32_t a = 0, b = 0;
    double length = 0;  // mm, > 0
};

// Minimises the integral of |d|^2 + smoothing^2 |d'|^2 along all edges. The unknowns are the movements d
// of the nodes, each in the frame of its own plane, and one position for each group. A group's position
// has its `usual` value where nothing else decides.
//
// Chains of free nodes are eliminated exactly, by Gaussian elimination of a tridiagonal matrix along each.
// What is left are groups and free nodes where chains meet. They are found by conjugate gradients with
// diagonal preconditioning (Hestenes and Stiefel, J. Res. Natl. Bur. Stand. 49, 1952), to five digits or
// 1000 steps.
//
// Returns d of every node; it is 0 on rings without anything that moves. Requires: edges of positive
// length between different nodes. Guarantees: the same bits every time. O(nodes + groups times steps).
std::vector<Vec2> solve_movement(const std::vector<MovementNode>& nodes,
                                 const std::vector<MovementEdge>& edges, const std::vector<double>& usual,
                                 double smoothing);

}  // namespace anatomesh
