#include "anatomesh/contour/resolve/resolve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/overlay/combine.h"
#include "anatomesh/contour/overlay/nesting.h"
#include "anatomesh/contour/overlay/separate.h"
#include "anatomesh/contour/resolve/close_loops.h"
#include "anatomesh/contour/resolve/combined_readings.h"
#include "anatomesh/contour/resolve/doubled_rings.h"
#include "anatomesh/contour/resolve/planes_given_twice.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_crossings = 4'000'000;  // Of a slice; with more E-CON-008. [crossings; >= 1; B]
// Rings that keep so near to each other, as a share of the smaller one's radius, are asked about. [1; 0 to 1; D a choice, measurement not recorded]
constexpr double doubtful_wall_of_radius = 0.1;

CombineRule rule_of(bool exclusive_or, const ResolveOptions& options) {
    if (exclusive_or) return CombineRule::exclusive_or;
    return options.holes == HoleRule::united ? CombineRule::unite : CombineRule::nest_and_unite;
}

RingReadings started_readings(const std::vector<Ring>& rings, const PlaceOfSource& place_of) {
    RingReadings readings{place_of};
    for (const Ring& ring : rings) {
        RingReading& reading = readings.of[ring.source];
        reading.source = ring.source;
        reading.points_kept = static_cast<std::uint32_t>(ring.size());
    }
    return readings;
}

void close_corridors_of_all(std::vector<Ring>& rings, const ResolveOptions& options, RingReadings& readings) {
    for (Ring& ring : rings) {
        const std::size_t before = ring.size();
        double moved = close_corridors(ring, options.corridor_mm);
        moved = std::max(moved, close_keyholes(ring, options.keyhole_mm, options.corridor_mm));
        if (moved == 0) continue;
        readings.note(ring.source, "W-CON-013", "a narrow corridor joins the contour to a hole or island",
                      brief(moved) + " mm", "the corridor was closed");
        RingReading& reading = readings.of[ring.source];
        reading.repaired = true;
        reading.displacement_mm = moved;
        reading.points_kept -= static_cast<std::uint32_t>(before - ring.size());
        append_rule(reading, "corridor closed");
    }
    std::erase_if(rings, [&](const Ring& ring) {
        if (ring.size() >= 3) return false;
        readings.of[ring.source].points_kept = 0;
        append_rule(readings.of[ring.source], "dropped: no area");
        return true;
    });
}

// An outline drawn again a hair off itself would leave a skin of that hair between the two.
void drop_doubled(std::vector<Ring>& rings, double repeat_mm, RingReadings& readings) {
    std::vector<std::uint8_t> dropped(rings.size(), 0);
    for (const DoubledRings& pair : find_doubled_rings(rings, repeat_mm)) {
        const Ring &ring = rings[pair.smaller], &larger = rings[pair.larger];
        if (dropped[pair.larger] || dropped[pair.smaller]) continue;
        dropped[pair.smaller] = 1;
        const std::string number = std::to_string(larger.source);
        readings.note(ring.source, "W-CON-011",
                      "the contour nearly repeats contour " + number + " of its structure",
                      brief(pair.apart_mm) + " mm apart", "it was left out");
        RingReading& reading = readings.of[ring.source];
        reading.rule = "near repeat of " + number;
        reading.repeats = larger.source;
        reading.points_kept = 0;
        reading.area_change_mm2 = std::abs(signed_area(larger.at)) - std::abs(signed_area(ring.at));
    }
    std::size_t r = 0;
    std::erase_if(rings, [&](const Ring&) { return dropped[r++] != 0; });
}

// Each contour is looked at by itself, so that what others do beside a loop is no part of it. Returns, by source,
// how many vertices closing gave to it: entries are for rings that had a loop.
std::map<std::uint32_t, std::uint32_t> close_loops_of_all(std::vector<Ring>& rings, const Plane& plane,
                                                          CombineRule rule, const ResolveOptions& options,
                                                          RingReadings& readings) {
    std::map<std::uint32_t, std::uint32_t> made_vertices;
    for (Ring& ring : rings) {
        std::optional<ClosedLoops> closed =
            close_loops(ring, rings, plane, rule, options.max_repair_area_share, {options.loop_mm2});
        if (!closed) continue;
        const std::string loops = std::to_string(closed->loops);
        readings.note(ring.source, "W-CON-030",
                      closed->loops == 1 ? "the contour crosses itself in a small loop"
                                         : "the contour crosses itself in " + loops + " small loops",
                      brief(closed->area_mm2) + " mm2",
                      "the loops were closed; they become no holes or islands");
        RingReading& reading = readings.of[ring.source];
        append_rule(reading, loops + (closed->loops == 1 ? " loop closed" : " loops closed"));
        reading.area_change_mm2 += closed->area_mm2;
        reading.points_kept -= closed->points_dropped;
        reading.repaired = true;
        made_vertices[ring.source] = closed->crossings;
        ring = std::move(closed->ring);
    }
    return made_vertices;
}

// Combines the rings. Repeats on planes given twice are taken away one by one, because each changes what the
// others contradict; everything else is settled in one go.
Result<Combined> combine_without_repeats(std::vector<Ring>& rings, const Plane& plane, CombineRule rule,
                                         const ResolveOptions& options, RingReadings& readings) {
    for (bool first = true;; first = false) {
        std::optional<Combined> combined =
            combine_rings(rings, plane, rule, options.max_repair_area_share, most_crossings);
        if (!combined) {
            return Error{ErrorKind::limit, "E-CON-008",
                         "the contours of the slice cross too often to be repaired",
                         readings.place_of(rings.front().source), "draw the contours of this slice again"};
        }
        const bool unites = first && options.unite_repeated_planes && rule == CombineRule::nest_and_unite;
        if (unites && unite_nested_planes(rings, *combined, readings)) continue;
        ANATOMESH_TRY(const bool again, drop_repeat_of_plane(rings, *combined, options, readings));
        if (!again) return *std::move(combined);
    }
}

Status move_apart(std::vector<Ring>& rings, const Plane& plane, double separation_mm,
                  RingReadings& readings) {
    std::vector<Separation> done;
    if (!separate_rings(rings, plane, separation_mm, done)) {
        return Error{ErrorKind::geometry, "E-CON-009",
                     "contours of one structure touch where there is no space to separate them",
                     readings.place_of(rings.front().source), "draw the contours of this slice again"};
    }
    for (const Separation& separation : done) {
        const std::uint32_t source = rings[separation.ring].source;
        readings.note(
            source, "W-CON-020", "two contours of one structure touch at a vertex",
            std::to_string(separation.vertices) + (separation.vertices == 1 ? " vertex" : " vertices"),
            "they were moved apart by " + brief(separation.displacement_mm) + " mm");
        RingReading& reading = readings.of[source];
        reading.displacement_mm = std::max(reading.displacement_mm, separation.displacement_mm);
        reading.repaired = true;
    }
    return Nothing{};
}

void read_nesting(const std::vector<Ring>& rings, const Nesting& nesting, bool fills_holes,
                  RingReadings& readings) {
    for (std::size_t r = 0; r < rings.size(); ++r) {
        RingReading& reading = readings.of[rings[r].source];
        reading.adds = nesting.depth[r] % 2 == 0;
        if (nesting.depth[r] == 0) {
            append_rule(reading, "outer");
        } else if (fills_holes) {
            append_rule(reading, "dropped: inside another, holes are filled");
            reading.points_kept = 0;
        } else {
            append_rule(reading, (nesting.depth[r] % 2 == 1 ? "hole of " : "island in hole ") +
                                     std::to_string(rings[nesting.parent[r]].source));
        }
    }
}

// A hole that follows its outline everywhere is a thin wall, or the outline drawn twice. Only the user can tell.
void warn_of_doubtful_walls(const std::vector<Ring>& rings, const Nesting& nesting, double doubtful_wall_mm,
                            RingReadings& readings) {
    for (const DoubledRings& pair : find_doubled_rings(rings, doubtful_wall_mm, doubtful_wall_of_radius)) {
        if (nesting.depth[pair.smaller] % 2 == 0 ||
            nesting.parent[pair.smaller] != static_cast<std::int32_t>(pair.larger))
            continue;
        readings.note(rings[pair.smaller].source, "W-CON-026",
                      "a hole runs close along its outline, contour " +
                          std::to_string(rings[pair.larger].source) +
                          ", all around; the outline may be drawn twice",
                      brief(pair.apart_mm) + " mm apart",
                      "it was read as a hole, so that a thin wall remains; check the drawing");
    }
}

// Orients the rings, which keep apart, by their depth; rings inside others go where holes are filled.
Resolved resolved_of(std::vector<Ring> rings, const Nesting& nesting, bool fills_holes,
                     RingReadings readings) {
    Resolved resolved;
    for (std::size_t r = 0; r < rings.size(); ++r) {
        if (fills_holes && nesting.depth[r] > 0) continue;
        const bool counter_clockwise = signed_area(rings[r].at) > 0;
        if (counter_clockwise != (nesting.depth[r] % 2 == 0)) reverse_ring(rings[r]);
        resolved.rings.push_back(std::move(rings[r]));
        resolved.depth.push_back(nesting.depth[r]);
    }
    for (auto& [source, reading] : readings.of) resolved.readings.push_back(std::move(reading));
    resolved.notes = std::move(readings.notes);
    return resolved;
}

}  // namespace

Result<Resolved> resolve_rings(std::vector<Ring> rings, const Plane& plane, bool exclusive_or,
                               const ResolveOptions& options, const PlaceOfSource& place_of) {
    const CombineRule rule = rule_of(exclusive_or, options);
    const bool fills_holes = rule == CombineRule::unite;
    RingReadings readings = started_readings(rings, place_of);
    close_corridors_of_all(rings, options, readings);
    drop_doubled(rings, options.repeat_mm, readings);
    RingEdges edges(rings);
    bool apart = keep_apart(edges, rings);
    std::map<std::uint32_t, std::uint32_t> made_vertices;
    if (!apart) {
        made_vertices = close_loops_of_all(rings, plane, rule, options, readings);
        if (!made_vertices.empty()) {
            edges = RingEdges(rings);
            apart = keep_apart(edges, rings);
        }
    }
    if (apart && !are_on_several_planes(rings)) {
        read_nesting(rings, nest(edges, rings), fills_holes, readings);
    } else {
        ANATOMESH_TRY(Combined combined, combine_without_repeats(rings, plane, rule, options, readings));
        ANATOMESH_CHECK_STATUS(
            read_combined(rings, combined, rule, options.max_repair_area_share, made_vertices, readings));
        if (!exclusive_or && !options.unite_repeated_planes) {
            ANATOMESH_CHECK_STATUS(check_nesting_across_planes(rings, combined, readings));
        }
        rings = std::move(combined.rings);
        ANATOMESH_CHECK_STATUS(move_apart(rings, plane, options.separation_mm, readings));
        edges = RingEdges(rings);
    }
    const Nesting nesting = nest(edges, rings);
    if (!fills_holes) warn_of_doubtful_walls(rings, nesting, options.doubtful_wall_mm, readings);
    return resolved_of(std::move(rings), nesting, fills_holes, std::move(readings));
}

}  // namespace anatomesh
