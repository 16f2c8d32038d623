// write_record: the records of a project file as JSON (docs/formats.md, "Project files").
#pragma once

#include <cstdint>
#include <string>

#include "anatomesh/live/edit/edit.h"

namespace anatomesh {

// Record 0. O(1).
std::string head_record(const DrawingSource& source);

// An edit, without what stood before: the records before it say that. Of changed rings, points that they have in common
// with the rings that stood there, at the begin and the end of a ring, are told by their number; all others to the last
// bit. O(points), times the rings of a key that begin or end alike.
std::string apply_record(std::uint64_t number, const Edit& edit);

// `what`: "undo" or "redo"; `name` is that of the step.
std::string move_record(std::uint64_t number, const char* what, const std::string& name);

}  // namespace anatomesh
