// For tests: a StructureField of solids given by formulas.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh::fixtures {

using Distance = std::function<double(Vec3)>;  // signed, negative inside

inline Distance ball(Vec3 centre, double radius) {
    return [=](Vec3 p) { return length(p - centre) - radius; };
}

inline Distance shell(Vec3 centre, double outer, double inner) {
    return
        [=](Vec3 p) { return std::abs(length(p - centre) - 0.5 * (outer + inner)) - 0.5 * (outer - inner); };
}

// About the z axis.
inline Distance torus(double ring, double tube) {
    return [=](Vec3 p) { return std::hypot(std::hypot(p.x, p.y) - ring, p.z) - tube; };
}

// Structure n is the n-th solid. Exclusive: where several overlap, the point belongs to the one it is deepest
// in.
class AnalyticField final : public StructureField {
  public:
    AnalyticField(std::vector<Distance> solids, double reach, bool exclusive = false)
        : solids_(std::move(solids)), reach_(reach), exclusive_(exclusive) {}

    double value(std::uint32_t structure, Vec3 p) const override {
        double value = solids_[structure](p);
        if (exclusive_) {
            for (std::uint32_t s = 0; s < solids_.size(); ++s) {
                if (s != structure) value = std::max(value, 0.5 * (solids_[structure](p) - solids_[s](p)));
            }
        }
        return std::clamp(value, -clamp(), clamp());
    }
    void values_near(Vec3 p, std::vector<Near>& near) const override {
        for (std::uint32_t s = 0; s < solids_.size(); ++s) {
            if (value(s, p) < clamp()) near.push_back({s, value(s, p)});
        }
    }
    void members(Vec3 p, std::vector<std::uint32_t>& out) const override {
        out.clear();
        for (std::uint32_t s = 0; s < solids_.size(); ++s) {
            if (value(s, p) < 0) out.push_back(s);
        }
    }
    double interface_distance(Vec3 p) const override {
        double least = clamp();
        for (std::uint32_t s = 0; s < solids_.size(); ++s) least = std::min(least, std::abs(value(s, p)));
        return least;
    }
    bool exclusive() const override { return exclusive_; }
    double union_value(Vec3 p) const override {
        double least = clamp();
        for (const Distance& solid : solids_) least = std::min(least, solid(p));
        return std::max(least, -clamp());
    }
    double slice_spacing() const override { return 1; }
    double clamp() const override { return 4; }
    Box3 box() const override { return {{-reach_, -reach_, -reach_}, {reach_, reach_, reach_}}; }

  private:
    std::vector<Distance> solids_;
    double reach_;
    bool exclusive_;
};

}  // namespace anatomesh::fixtures
