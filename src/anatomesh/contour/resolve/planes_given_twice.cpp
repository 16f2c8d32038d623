#include "anatomesh/contour/resolve/planes_given_twice.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "anatomesh/base/number_text.h"

namespace anatomesh {

namespace {

// Whether ring r lies where another plane than its own is inside, just outside of r.
bool is_covered(std::uint32_t r, const std::vector<Ring>& rings, const Combined& combined) {
    const double area = combined.fates[r].area_mm2;
    std::map<std::int32_t, bool> inside;  // by plane
    inside[rings[r].plane] = false;
    for (std::uint32_t q = 0; q < rings.size(); ++q) {
        if (q == r || combined.fates[q].area_mm2 <= area) continue;
        const double common = combined.common_area(std::min(q, r), std::max(q, r));
        if (area - common <= area_rounding_share * area) inside[rings[q].plane] ^= true;
    }
    return std::any_of(inside.begin(), inside.end(),
                       [&](const auto& plane) { return plane.second && plane.first != rings[r].plane; });
}

Error contradiction(std::uint32_t first, std::uint32_t second, double differing_mm2,
                    const RingReadings& readings) {
    return {ErrorKind::geometry, "E-CON-007",
            "a plane is drawn twice, and the two drawings contradict each other: contour " +
                readings.place_of(first).contour + " and this one",
            readings.place_with_value(second, brief(differing_mm2) + " mm2"),
            "leave out one of the two planes with --without, or unite them with --unite-repeated-planes"};
}

}  // namespace

bool are_on_several_planes(const std::vector<Ring>& rings) {
    return std::any_of(rings.begin(), rings.end(),
                       [&](const Ring& ring) { return ring.plane != rings.front().plane; });
}

bool unite_nested_planes(std::vector<Ring>& rings, const Combined& combined, RingReadings& readings) {
    std::vector<std::uint8_t> covered(rings.size(), 0);
    for (std::uint32_t r = 0; r < rings.size(); ++r) covered[r] = is_covered(r, rings, combined);
    if (std::none_of(covered.begin(), covered.end(), [](std::uint8_t c) { return c != 0; })) return false;
    std::vector<Ring> rest;
    for (std::uint32_t r = 0; r < rings.size(); ++r) {
        if (!covered[r]) {
            rest.push_back(std::move(rings[r]));
            continue;
        }
        RingReading& reading = readings.of[rings[r].source];
        append_rule(reading, "united with the other drawing of its plane, which covers it");
        reading.points_kept = 0;
        reading.repaired = true;
        readings.note(rings[r].source, "W-CON-022",
                      "a plane is drawn twice, and this contour of plane " + std::to_string(rings[r].plane) +
                          " lies inside a contour of the other drawing",
                      brief(combined.fates[r].area_mm2) + " mm2",
                      "the two were united; this contour adds nothing");
    }
    rings = std::move(rest);
    return true;
}

Result<bool> drop_repeat_of_plane(std::vector<Ring>& rings, const Combined& combined,
                                  const ResolveOptions& options, RingReadings& readings) {
    for (std::uint32_t r = 0; r < rings.size(); ++r) {
        for (std::uint32_t q = 0; q < r; ++q) {
            if (rings[r].plane == rings[q].plane) continue;
            const double common = combined.common_area(q, r);
            const double smaller = std::min(combined.fates[q].area_mm2, combined.fates[r].area_mm2);
            const double all = combined.fates[q].area_mm2 + combined.fates[r].area_mm2 - common;
            const std::uint32_t source = rings[r].source;
            if (common <= area_rounding_share * smaller) continue;
            if (all - common <= options.max_repair_area_share * all) {
                const std::string repeated = std::to_string(rings[q].source);
                readings.note(source, "W-CON-018",
                              "a plane is drawn twice, with nearly the same contour " + repeated,
                              brief(all - common) + " mm2", "it was left out");
                RingReading& reading = readings.of[source];
                reading.rule = "near repeat of " + repeated;
                reading.points_kept = 0;
                reading.area_change_mm2 = all - common;
                rings.erase(rings.begin() + r);
                return true;
            }
            // A ring inside another one is a hole of it, which check_nesting_across_planes() looks at.
            if (smaller - common <= area_rounding_share * smaller) continue;
            if (options.unite_repeated_planes) continue;
            return contradiction(rings[q].source, source, all - common, readings);
        }
    }
    return false;
}

Status check_nesting_across_planes(const std::vector<Ring>& rings, const Combined& combined,
                                   RingReadings& readings) {
    for (std::uint32_t r = 0; r < rings.size(); ++r) {
        const RingFate& fate = combined.fates[r];
        if (fate.parent < 0) continue;
        const auto parent = static_cast<std::uint32_t>(fate.parent);
        if (rings[r].plane < 0 || rings[parent].plane < 0 || rings[r].plane == rings[parent].plane) continue;
        const std::string message = "a plane is drawn twice, and this contour lies inside contour " +
                                    readings.place_of(rings[parent].source).contour + " of the other drawing";
        const std::string value = brief(fate.area_mm2) + " mm2";
        if (fate.level % 2 == 1) {
            return Error{ErrorKind::geometry, "E-CON-007", message,
                         readings.place_with_value(rings[r].source, value),
                         "unite the two with --unite-repeated-planes, or leave out one plane with --without; "
                         "for a hole, "
                         "draw both contours in one plane"};
        }
        readings.note(rings[r].source, "W-CON-022", message, value,
                      fate.level > 0 ? "it was read as an island in a hole"
                                     : "it adds nothing, because holes are filled");
    }
    return Nothing{};
}

}  // namespace anatomesh
