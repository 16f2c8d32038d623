#include "anatomesh/contour/resolve/combined_readings.h"

#include <algorithm>
#include <set>
#include <string>

#include "anatomesh/base/number_text.h"

namespace anatomesh {

namespace {

// Reads what a ring does by itself: it crosses itself, it runs back along itself, or it touches itself.
Status read_self_contact(const Ring& ring, const RingFate& fate, double max_repair_area_share,
                         RingReadings& readings) {
    RingReading& reading = readings.of[ring.source];
    if (fate.ambiguous_area_mm2 > area_rounding_share * fate.area_mm2) {
        const double share = std::min(1.0, fate.ambiguous_area_mm2 / fate.area_mm2);
        const std::string value = brief(fate.ambiguous_area_mm2) + " mm2, " + brief(100 * share) + " %";
        if (share > max_repair_area_share) {
            return Error{ErrorKind::geometry, "E-CON-006",
                         "the contour crosses itself, and too much of the area that it encloses is ambiguous",
                         readings.place_with_value(ring.source, value),
                         "draw the contour again, or allow more with --max-repair"};
        }
        readings.note(ring.source, "W-CON-014", "the contour crosses itself", value,
                      "areas that it encloses an even number of times are outside (even-odd rule)");
        append_rule(reading, "self-crossing, even-odd");
        reading.area_change_mm2 += fate.ambiguous_area_mm2;
        reading.repaired = true;
    } else if (fate.retraces_itself) {
        append_rule(reading, "keyhole, opened");
    } else if (fate.touches_itself) {
        readings.note(ring.source, "W-CON-015", "the contour touches itself", "", "it was split there");
        append_rule(reading, "split where it touches itself");
        reading.repaired = true;
    }
    return Nothing{};
}

// Reads how a ring lies in the others: outer, hole or island, reaching beyond its parent, sharing an edge.
void read_nesting_of(std::span<const Ring> rings, const Ring& ring, const RingFate& fate,
                     RingReadings& readings) {
    RingReading& reading = readings.of[ring.source];
    const std::string parent = fate.parent < 0 ? "" : std::to_string(rings[fate.parent].source);
    reading.adds = fate.parent < 0 || fate.level % 2 == 0;
    append_rule(reading, fate.parent < 0 || fate.level == 0 ? "outer"
                         : fate.level % 2 == 1              ? "hole of " + parent
                                                            : "island in hole " + parent);
    if (fate.protruding_area_mm2 > 0 && fate.level > 0) {
        readings.note(ring.source, "W-CON-017",
                      "the contour lies inside contour " + parent + ", but partly reaches beyond it",
                      brief(fate.protruding_area_mm2) + " mm2", "the part outside was cut off");
        reading.area_change_mm2 += fate.protruding_area_mm2;
        reading.repaired = true;
    }
    if (fate.shares_edge) {
        readings.note(ring.source, "W-CON-016", "contours of one structure share an edge", "",
                      "they were joined along it");
        reading.repaired = true;
    }
}

// Warns once for every group of united rings, at the smallest source.
void read_united_groups(std::span<const Ring> rings, const Combined& combined, RingReadings& readings) {
    std::map<std::uint32_t, std::set<std::uint32_t>> sources_of_group;
    for (const RingOverlap& overlap : combined.overlaps) {
        std::set<std::uint32_t>& sources = sources_of_group[combined.fates[overlap.first].group];
        sources.insert(rings[overlap.first].source);
        sources.insert(rings[overlap.second].source);
    }
    for (const auto& [group, sources] : sources_of_group) {
        const double area = combined.overlap_of_group_mm2[group];
        const std::uint32_t first = *sources.begin();
        std::string others;
        for (std::uint32_t source : sources) {
            if (source != first) others += (others.empty() ? "" : ", ") + std::to_string(source);
            RingReading& reading = readings.of[source];
            append_rule(reading, "united with others");
            reading.repaired = true;
            if (source == first) reading.area_change_mm2 += area;
        }
        readings.note(first, "W-CON-019", "the contour overlaps others of its structure: " + others,
                      brief(area) + " mm2", "the contours were united");
    }
}

}  // namespace

Status read_combined(std::span<const Ring> rings, const Combined& combined, CombineRule rule,
                     double max_repair_area_share, std::map<std::uint32_t, std::uint32_t>& made_vertices,
                     RingReadings& readings) {
    for (std::uint32_t r = 0; r < rings.size(); ++r) {
        const Ring& ring = rings[r];
        const RingFate& fate = combined.fates[r];
        RingReading& reading = readings.of[ring.source];
        reading.points_kept = fate.points_kept - std::min(fate.points_kept, made_vertices[ring.source]);
        ANATOMESH_CHECK_STATUS(read_self_contact(ring, fate, max_repair_area_share, readings));
        if (rule == CombineRule::exclusive_or) {
            append_rule(reading, "exclusive or");
        } else {
            read_nesting_of(rings, ring, fate, readings);
        }
    }
    if (rule != CombineRule::exclusive_or) read_united_groups(rings, combined, readings);
    return Nothing{};
}

}  // namespace anatomesh
