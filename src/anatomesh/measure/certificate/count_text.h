// count_of: "3 of 12", for the evidence of a clause.
#pragma once

#include <cstdint>
#include <string>

namespace anatomesh {

inline std::string count_of(std::uint64_t part, std::uint64_t total) {
    return std::to_string(part) + " of " + std::to_string(total);
}

}  // namespace anatomesh
