// LocalStar: where a vertex is best placed inside the facets that it is joined to.
#pragma once

#include <array>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Facets (a, b, c) such that (p, a, b, c) is a positive cell for the vertex p. Cells of facets with `inside`
// are to be well shaped, the others only not flat.
class LocalStar {
  public:
    // `flat`: least sine that cells outside must have. `squared_ratio`: bound of (circumradius / shortest
    // edge)^2 inside.
    void reset(double flat, double squared_ratio) {
        faces_.clear();
        flat_ = flat;
        squared_ratio_ = squared_ratio;
    }
    void add(Vec3 a, Vec3 b, Vec3 c, bool inside) { faces_.push_back({a, b, c, inside}); }
    std::size_t size() const { return faces_.size(); }

    // The least sine of the dihedral angles of the cells inside with the vertex at p; anything below `enough`
    // when it is below `enough`, or when a bound is broken.
    double worst(Vec3 p, double enough);

    // Moves p uphill until the worst sine is `goal` or no step gains. `adjust(q)` may move a tried place
    // (onto a surface) and says false where it is not allowed. `normal`: when not zero, steps are taken at
    // right angles to it. Returns the worst sine at p. Non-smooth ascent along the shortest vector in the
    // convex hull of the gradients of the worst cells (Freitag and Ollivier-Gooch 1997), steps halved until
    // they gain.
    template <class Adjust>
    double ascend(Vec3& p, double value, double goal, Vec3 normal, Adjust&& adjust) {
        const double reach = shortest_distance(p);
        for (int round = 0; round < max_rounds && value < goal; ++round) {
            const Vec3 way = direction(p, value, normal, 1e-5 * reach);
            const double rate = length(way);
            if (!(rate * reach > least_rate)) break;
            double step = std::min(1.2 * (goal - value) / rate, 0.4 * reach);
            bool gained = false;
            for (int half = 0; half < max_halvings && !gained; ++half, step *= 0.4) {
                const Vec3 tried = p + (step / rate) * way;
                Vec3 q = tried;
                const double enough = value + 0.1 * step * rate;
                double there = worst(q, enough);
                if (there < enough || !adjust(q)) continue;
                if (q != tried) there = worst(q, enough);
                if (there < enough) continue;
                p = q;
                value = there;
                gained = true;
            }
            if (!gained) break;
        }
        return value;
    }

  private:
    static constexpr int max_rounds = 12;   // steps of one ascent [steps; > 0; B]
    static constexpr int max_halvings = 5;  // attempts at one step, each shorter [attempts; > 0; B]
    // An ascent ends where the sine would grow by less than this over the shortest distance. [1; > 0; M
    // 2026-11, set not recorded]
    static constexpr double least_rate = 0.01;

    struct Face {
        Vec3 a, b, c;
        bool inside;
    };
    double shortest_distance(Vec3 p) const;
    Vec3 direction(Vec3 p, double value, Vec3 normal, double delta) const;

    std::vector<Face> faces_;
    double flat_ = 0, squared_ratio_ = 0;
};

}  // namespace anatomesh
