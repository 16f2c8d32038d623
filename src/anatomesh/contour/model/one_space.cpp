#include "anatomesh/contour/model/one_space.h"

#include <algorithm>
#include <string>

namespace anatomesh {

Status check_one_space(const RawContours& raw, bool take_for_one, RunContext& context) {
    const auto told = [](const RawContour& contour) { return contour.space != 0; };
    const auto first = std::find_if(raw.contours.begin(), raw.contours.end(), told);
    const auto other = std::find_if(first, raw.contours.end(), [&](const RawContour& contour) {
        return told(contour) && contour.space != first->space;
    });
    if (other == raw.contours.end()) return Nothing{};
    const auto name = [&](const RawContour& contour) {
        const Structure& structure = raw.structures[contour.structure];
        return structure.name.empty() ? std::to_string(structure.number) : structure.name;
    };
    const std::string message =
        "'" + name(*first) + "' and '" + name(*other) + "' are drawn in different frames of reference";
    const Place place{raw.source, "", name(*other), "", ""};
    if (take_for_one) {
        context.warn({"W-RTS-007", message, place,
                      "they were used together, because --ignore-frame-of-reference is given"});
        return Nothing{};
    }
    return Error{ErrorKind::input, "E-RTS-010", message, place,
                 "choose structures of one frame with --structure, or use both as they are with "
                 "--ignore-frame-of-reference"};
}

}  // namespace anatomesh
