// Random drawings and random steps, for the laws of this room and of the project file.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/live/edit/edit_history.h"
#include "anatomesh/live/edit/make_edits.h"

namespace anatomesh::drawing_for_test {

// Star-shaped rings side by side in the plane: they cross nowhere. The first has its first point at (radius, 0).
inline DrawnRings star_rings(const Plane& plane, std::mt19937& random, int rings = 1, int points = 12,
                             RingTool tool = RingTool::stroke) {
    std::uniform_real_distribution<double> radius(5, 20);
    DrawnRings drawn;
    for (int r = 0; r < rings; ++r) {
        std::vector<Vec3> ring;
        for (int i = 0; i < points; ++i) {
            const double angle = 2 * std::numbers::pi * i / points, length = radius(random);
            ring.push_back(plane.to_space({50.0 * r + length * std::cos(angle), length * std::sin(angle)}));
        }
        const std::vector<Vec3> control = tool == RingTool::stroke
                                              ? std::vector<Vec3>()
                                              : std::vector<Vec3>(ring.begin(), ring.begin() + 3);
        drawn.add(ring, tool, control);
    }
    return drawn;
}

inline Plane random_plane(std::mt19937& random) {
    std::uniform_real_distribution<double> any(-1, 1);
    return make_plane({200 * any(random), 200 * any(random), 200 * any(random)},
                      {any(random), any(random), any(random) + 0.01});
}

// Makes steps of every kind that fit to a drawing as it is now.
class RandomSteps {
  public:
    explicit RandomSteps(unsigned seed) : random_(seed) {}

    // A step that applied() takes; nothing where this draw of the dice fits to nothing in the drawing.
    std::optional<Edit> next(const Drawing& drawing) {
        if (drawing.structures().entries().size() < 2) return new_structure(drawing);
        if (drawing.planes().entries().size() < 3) return new_plane(drawing);
        switch (below(16)) {
            case 0:
                return new_structure(drawing);
            case 1:
                return new_plane(drawing);
            case 2:
                return below(4) == 0 ? removed_structure(drawing) : std::nullopt;
            case 3:
                return below(4) == 0 ? removed_plane(drawing) : std::nullopt;
            case 4:
                return moved_plane(drawing);
            case 5:
                return changed_structure(drawing);
            case 6:
                return reordered(drawing);
            case 7:
                return changed_plane(drawing);
            case 8:
                return proposed(drawing);
            case 9:
                return accepted(drawing);
            case 10:
                return pinned(drawing);
            case 11:
                return cut(drawing);
            default:
                return drawn(drawing);
        }
    }

    // The same, drawn until one fits.
    Edit step(const Drawing& drawing) {
        for (;;) {
            if (auto edit = next(drawing); edit && applied(drawing, *edit).ok()) return *std::move(edit);
        }
    }

    std::uint32_t below(std::uint32_t count) { return random_() % count; }
    std::mt19937& random() { return random_; }

  private:
    template <class Table>
    const auto& any_of(const Table& table) {
        return table.entries()[below(static_cast<std::uint32_t>(table.entries().size()))];
    }
    std::string text() {
        return "step " + std::to_string(below(1000)) + (below(3) == 0 ? " \"\xC3\xA4\"\n" : "");
    }
    bool is_locked(const Drawing& drawing, std::int32_t number) { return drawing.structure(number)->locked; }

    std::optional<Edit> new_structure(const Drawing& drawing) {
        const std::int32_t number =
            below(3) == 0 ? -static_cast<std::int32_t>(below(1000)) : next_structure_number(drawing);
        if (drawing.structure(number)) return std::nullopt;
        const auto color = [&] { return static_cast<std::uint8_t>(below(256)); };
        return add_structure(drawing, {{number, text(), {color(), color(), color()}}, false}, text());
    }
    std::optional<Edit> new_plane(const Drawing& drawing) {
        DrawnPlane plane{random_plane(random_), text(), below(2) * 2.5, false};
        return add_plane(drawing, next_plane_id(drawing), std::move(plane), text());
    }
    std::optional<Edit> removed_structure(const Drawing& drawing) {
        const std::int32_t number = any_of(drawing.structures()).key;
        if (is_locked(drawing, number)) return std::nullopt;
        return remove_structure(drawing, number, text());
    }
    std::optional<Edit> removed_plane(const Drawing& drawing) {
        return remove_plane(drawing, any_of(drawing.planes()).key, text());
    }
    std::optional<Edit> moved_plane(const Drawing& drawing) {
        return move_plane(drawing, any_of(drawing.planes()).key, random_plane(random_), text());
    }
    std::optional<Edit> changed_structure(const Drawing& drawing) {
        DrawnStructure structure = *any_of(drawing.structures()).value;
        if (below(2) == 0) structure.structure.name = text();
        if (below(2) == 0) structure.structure.color[0] ^= 1;
        if (below(3) == 0) structure.locked = !structure.locked;
        return change_structure(drawing, std::move(structure), text());
    }
    std::optional<Edit> reordered(const Drawing& drawing) {
        StructureOrder order = drawing.order();
        std::swap(order.front(), order[below(static_cast<std::uint32_t>(order.size()))]);
        return reorder_structures(drawing, std::move(order), text());
    }
    std::optional<Edit> changed_plane(const Drawing& drawing) {
        const auto& entry = any_of(drawing.planes());
        DrawnPlane plane = *entry.value;
        if (below(2) == 0) plane.name = text();
        if (below(2) == 0) plane.left_out = !plane.left_out;
        if (below(2) == 0) plane.thickness_mm += 0.1;
        return change_plane(drawing, entry.key, std::move(plane), text());
    }
    DrawnRings rings_on(const Drawing& drawing, std::int32_t plane) {
        return star_rings(drawing.plane(plane)->plane, random_, 1 + static_cast<int>(below(3)),
                          5 + static_cast<int>(below(20)), static_cast<RingTool>(below(3)));
    }
    RingsKey any_key(const Drawing& drawing) {
        return {any_of(drawing.planes()).key, any_of(drawing.structures()).key};
    }
    std::optional<Edit> drawn(const Drawing& drawing) {
        const RingsKey key = any_key(drawing);
        return set_rings(drawing, key, rings_on(drawing, key.plane), text());
    }
    // One ring less, or a vertex less of the last ring: what stays keeps its bits.
    std::optional<Edit> cut(const Drawing& drawing) {
        if (drawing.rings().entries().empty()) return std::nullopt;
        const auto& entry = any_of(drawing.rings());
        DrawnRings rest;
        for (std::size_t r = 0; r + 1 < entry.value->rings.size(); ++r) {
            const DrawnRing& ring = entry.value->rings[r];
            rest.add(entry.value->points_of(ring), ring.tool, entry.value->control_points_of(ring));
        }
        const DrawnRing& last = entry.value->rings.back();
        if (below(2) == 0 && last.point_count > 4) {
            const auto all = entry.value->points_of(last);
            std::vector<Vec3> fewer(all.begin(), all.end());
            fewer.erase(fewer.begin() + below(last.point_count));
            rest.add(fewer, last.tool, entry.value->control_points_of(last));
        }
        return set_rings(drawing, entry.key, std::move(rest), text());
    }
    std::optional<Edit> proposed(const Drawing& drawing) {
        const RingsKey key = any_key(drawing);
        return set_proposal(drawing, key, rings_on(drawing, key.plane), text());
    }
    std::optional<Edit> accepted(const Drawing& drawing) {
        std::vector<RingsKey> keys;
        for (const auto& entry : drawing.proposals().entries()) {
            if (below(2) == 0) keys.push_back(entry.key);
        }
        return below(3) == 0 ? reject_proposals(drawing, keys, text())
                             : accept_proposals(drawing, keys, text());
    }
    std::optional<Edit> pinned(const Drawing& drawing) {
        if (!drawing.pins().entries().empty() && below(3) == 0)
            return set_pin(drawing, any_of(drawing.pins()).key, std::nullopt, text());
        const Vec3 p = random_plane(random_).origin, q = random_plane(random_).origin;
        return set_pin(drawing, next_pin_id(drawing),
                       TopologyPin{{any_key(drawing), p}, {any_key(drawing), q}, below(2) == 0}, text());
    }

    std::mt19937 random_;
};

}  // namespace anatomesh::drawing_for_test
