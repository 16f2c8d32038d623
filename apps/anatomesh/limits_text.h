// What --limits prints: every limit on inputs and results, with its value.
#pragma once

#include <string>

namespace anatomesh {

std::string limits_text();

}  // namespace anatomesh
