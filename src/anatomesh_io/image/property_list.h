// The values of an XML property list (Apple's plist), flattened.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"

namespace anatomesh {

// Path of keys and the value as text: {"matrix/dtype", "int16"}. The items of an array all have the array's
// path, in order; an array in an array adds nothing to it.
using PropertyList = std::vector<std::pair<std::string, std::string>>;

// Errors (input): E-INV-004 not well-formed, nested deeper than 32, or more than 100000 values.
Result<PropertyList> parse_property_list(std::string_view xml, const std::string& path);

// The values at a key path, in order.
std::vector<std::string_view> values_at(const PropertyList& list, std::string_view key_path);

}  // namespace anatomesh
