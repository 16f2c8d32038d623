// find_structures: structures by the name or number that a person gives.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/structure.h"

namespace anatomesh {

// Returns the positions in `all` of the structures wanted, ascending; all of them when `wanted` is empty. A text is
// a name first, else a number; a name that several have means all of them. `file` is what messages call the input.
// Error: usage E-CMD-005 there is no such structure, with those that there are.
Result<std::vector<std::uint32_t>> find_structures(const std::vector<Structure>& all,
                                                   const std::vector<std::string>& wanted,
                                                   const std::string& file);

// Returns the same in the order in which they are wanted, each once; none when `wanted` is empty.
Result<std::vector<std::uint32_t>> find_in_order(const std::vector<Structure>& all,
                                                 const std::vector<std::string>& wanted,
                                                 const std::string& file);

// Returns a text by which a structure alone is found: its name where no other one has it, else its number.
std::string unique_text(const std::vector<Structure>& all, std::uint32_t structure);

}  // namespace anatomesh
