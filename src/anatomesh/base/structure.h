// Structure: a thing that contours or labels bound: an organ, a bone, a target volume.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace anatomesh {

struct Structure {
    std::int32_t number = 0;  // the source's own: label value, ROI number, CSL label; unique in a set
    std::string name;         // as the source says; may be empty; need not be unique
    std::array<std::uint8_t, 3> color{200, 200, 200};
};

}  // namespace anatomesh
