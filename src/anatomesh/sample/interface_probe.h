// InterfaceProbe: which region a point is in, how far the nearest change of region is, and where.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

// Not thread-safe (it keeps scratch space): one per thread, cheap to make. The field must outlive it.
class InterfaceProbe {
  public:
    explicit InterfaceProbe(const StructureField& field, std::uint32_t structure_count)
        : field_(field), single_(structure_count == 1) {}

    // From now on only the surfaces of these structures count for distance(), which is that of the farthest,
    // project(), which ends on all of them, and first_crossing(), for one of them alone. None: all
    // interfaces.
    void focus(std::span<const std::uint32_t> structures) {
        focus_.assign(structures.begin(), structures.end());
    }

    // On those of the structures that one of two regions has and the other has not, given by their structures
    // in rising order; on all interfaces where structures exclude each other.
    void focus_between(const std::vector<std::uint32_t>& here, const std::vector<std::uint32_t>& there);

    // Sorted structures at p; valid until the next call.
    const std::vector<std::uint32_t>& members(Vec3 p);

    // Distance-like, >= 0, clamped to the field's clamp. One above `reach` may be any number above it, which
    // costs less.
    double distance(Vec3 p, double reach = std::numeric_limits<double>::infinity());

    // Members and the distance from the nearest interface of all at once, at about the price of one; the
    // members are valid until the next call. A distance above `reach` may be any number above it, which costs
    // less.
    struct Look {
        const std::vector<std::uint32_t>& members;
        double distance;
    };
    Look look(Vec3 p, double reach = std::numeric_limits<double>::infinity());

    // The point of the nearest interface in the direction in which the distance falls, at most `max_move` mm away
    // and on it to within `tolerance` mm along that direction; nothing if there is none there.
    std::optional<Vec3> project(Vec3 p, double max_move, double tolerance);

    // The first change of region on the way from p to q, looked for in steps of `step` mm, at most 64 of them.
    std::optional<Vec3> first_crossing(Vec3 p, Vec3 q, double step, double tolerance);

  private:
    // Positive while the region is that at the point which `fix_side` was given, negative beyond; zero on the interface.
    // fix_side returns its value there.
    double fix_side(Vec3 p);
    double single_value(Vec3 p, double reach);
    double side_distance(Vec3 p);
    std::optional<Vec3> project_one(Vec3 p, double max_move, double tolerance);
    Vec3 crossing_between(Vec3 p, Vec3 q, double at_p, double at_q, double tolerance);

    const StructureField& field_;
    bool single_;
    double sign_ = 1;                   // one surface alone: the sign of the value on this side
    std::vector<std::uint32_t> focus_;  // structures, if not all
    std::uint32_t surface_ = 0;         // that of the structure looked at
    Vec3 looked_at_{NAN, NAN, NAN};     // single structure: where the exact value was last found, and that
    double seen_ = 0;
    std::vector<std::uint32_t> side_, members_;  // members on this side; scratch
};

}  // namespace anatomesh
