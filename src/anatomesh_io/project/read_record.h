// read_record: records of a project file, back from JSON. It trusts nothing that a record says.
//
// Errors, with the place left to the caller: input E-PRJ-001 no head of a project file, E-PRJ-002 a newer version,
// E-PRJ-004 a record that cannot be; limit E-PRJ-011 more points than are allowed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "anatomesh/base/result.h"
#include "anatomesh/live/edit/edit.h"

namespace anatomesh {

struct ProjectRecord {
    enum class Move : std::uint8_t { apply, undo, redo };
    Move move = Move::apply;
    Edit edit;  // of undo and redo: the name alone. Of apply: its values before are those of the drawing.
};

// Reads record 0. O(n).
Result<DrawingSource> read_head(std::string_view record);

// Reads record `number` of a file whose records before lead to `drawing`. `points_left` bounds the points that its rings
// may have, also those in common with rings of the drawing, and is lowered by them; memory is taken after that check.
// Complexity: linear in the record and its points.
Result<ProjectRecord> read_record(std::string_view record, std::uint64_t number, const Drawing& drawing,
                                  std::uint64_t& points_left);

}  // namespace anatomesh
