#include "anatomesh/contour/overlay/boundary_loops.h"

#include <cstddef>
#include <map>

#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

class LoopWalker {
  public:
    LoopWalker(std::span<const Vec2> at, std::span<const BoundaryEdge> edges)
        : at_(at), edges_(edges), leaving_(at.size()), used_(edges.size(), 0) {
        for (std::uint32_t e = 0; e < edges.size(); ++e) leaving_[edges[e].from].push_back(e);
    }

    std::vector<std::vector<std::uint32_t>> run() {
        for (std::uint32_t start = 0; start < edges_.size(); ++start) {
            if (!used_[start]) walk(start);
        }
        return std::move(loops_);
    }

  private:
    // The next edge bounds the same wedge of the region: it is the first one clockwise from where `edge` came.
    std::uint32_t successor(std::uint32_t edge) const {
        const Vec2 v = at_[edges_[edge].to], back = at_[edges_[edge].from];
        auto best = static_cast<std::uint32_t>(edges_.size());
        for (const std::uint32_t candidate : leaving_[edges_[edge].to]) {
            if (used_[candidate]) continue;
            if (best == edges_.size() ||
                clockwise_before(v, back, at_[edges_[candidate].to], at_[edges_[best].to])) {
                best = candidate;
            }
        }
        return best;
    }

    // Whether, turning clockwise about v from the direction of `back`, p comes before q. All three differ in
    // direction.
    static bool clockwise_before(Vec2 v, Vec2 back, Vec2 p, Vec2 q) {
        const bool p_right = is_right(v, back, p), q_right = is_right(v, back, q);
        if (p_right != q_right) return p_right;
        return orient2d(v, p, q) < 0;
    }

    // Whether p is reached from `back` by turning clockwise about v by 180 degrees or less.
    static bool is_right(Vec2 v, Vec2 back, Vec2 p) { return orient2d(v, back, p) <= 0; }

    // Follows the boundary from `start` and cuts the walk into simple loops at vertices it meets again.
    void walk(std::uint32_t start) {
        std::vector<std::uint32_t> path;
        std::map<std::uint32_t, std::size_t> position;  // of the vertices an edge of the path leaves from
        std::uint32_t edge = start;
        while (edge < edges_.size()) {
            used_[edge] = 1;
            position[edges_[edge].from] = path.size();
            path.push_back(edge);
            const auto met = position.find(edges_[edge].to);
            if (met == position.end()) {
                edge = successor(edge);
                continue;
            }
            const std::size_t begin = met->second;
            loops_.emplace_back(path.begin() + static_cast<std::ptrdiff_t>(begin), path.end());
            for (std::size_t i = begin; i < path.size(); ++i) position.erase(edges_[path[i]].from);
            path.resize(begin);
            if (path.empty()) break;
            edge = successor(path.back());
        }
    }

    std::span<const Vec2> at_;
    std::span<const BoundaryEdge> edges_;
    std::vector<std::vector<std::uint32_t>> leaving_;  // per vertex: edges from it
    std::vector<char> used_;
    std::vector<std::vector<std::uint32_t>> loops_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> boundary_loops(std::span<const Vec2> at,
                                                       std::span<const BoundaryEdge> edges) {
    return LoopWalker(at, edges).run();
}

}  // namespace anatomesh
