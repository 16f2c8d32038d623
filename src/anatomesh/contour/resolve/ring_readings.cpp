#include "anatomesh/contour/resolve/ring_readings.h"

#include <utility>

namespace anatomesh {

void append_rule(RingReading& reading, const std::string& more) {
    reading.rule += reading.rule.empty() ? more : "; " + more;
}

Place RingReadings::place_with_value(std::uint32_t source, std::string value) const {
    Place place = place_of(source);
    place.value = std::move(value);
    return place;
}

void RingReadings::note(std::uint32_t source, std::string code, std::string message, std::string value,
                        std::string what_was_done) {
    notes.push_back({source,
                     {std::move(code), std::move(message), place_with_value(source, std::move(value)),
                      std::move(what_was_done)}});
}

}  // namespace anatomesh
