// find_structures: structures by the name or number that a person gives.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/structure.h"

namespace anatomesh {

// Positions in `all` of the structures wanted, ascending; all when `wanted` is empty. A text is a name first,
// else a number; a name that several have means all of them. Error: usage E-CMD-005 there is no such
// structure, with those that there are. `file`: what messages call the input.
Result<std::vector<std::uint32_t>> find_structures(const std::vector<Structure>& all,
                                                   const std::vector<std::string>& wanted,
                                                   const std::string& file);

// The same in the order in which they are wanted, each once; none when `wanted` is empty.
Result<std::vector<std::uint32_t>> find_in_order(const std::vector<Structure>& all,
                                                 const std::vector<std::string>& wanted,
                                                 const std::string& file);

// A structure's name where no other one has it, else its number: a text by which it alone is found.
std::string unique_text(const std::vector<Structure>& all, std::uint32_t structure);

}  // namespace anatomesh
