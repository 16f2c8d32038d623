// RingReadings: how each source ring is read while the rings of a slice are resolved, and what is warned about.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"

namespace anatomesh {

// How one source ring was read.
struct RingReading {
    std::uint32_t source = 0;
    std::string rule;
    std::uint32_t points_kept = 0;  // vertices of the result that are vertices of the source
    double displacement_mm = 0, area_change_mm2 = 0;
    bool repaired = false;
    bool adds = false;          // an outer one or an island: what it bounds is inside
    std::int64_t repeats = -1;  // the source on its plane that it nearly repeats and is dropped for
};

// A warning about a source ring.
struct RingNote {
    std::uint32_t source = 0;
    Warning warning;
};

// Where a source is, for messages.
using PlaceOfSource = std::function<Place(std::uint32_t source)>;

// Appends to a rule, after a semicolon.
void append_rule(RingReading& reading, const std::string& more);

struct RingReadings {
    const PlaceOfSource& place_of;
    std::map<std::uint32_t, RingReading> of = {};  // by source
    std::vector<RingNote> notes = {};              // in the order in which they arose

    Place place_with_value(std::uint32_t source, std::string value) const;
    void note(std::uint32_t source, std::string code, std::string message, std::string value,
              std::string what_was_done);
};

}  // namespace anatomesh
