// Edit: one step that a person makes, as changes of values with what stood there before.
//
// An edit is applied whole or not at all. Each change names what it expects to find. Where something else stands by
// then, as when two windows made edits of the same drawing, the edit is refused: optimistic concurrency control (Kung and
// Robinson, ACM TODS 6, 1981).
//
// Errors of applied(), all of kind input; the place has slice, structure, contour and value as far as they apply:
//   E-EDT-001 something else stands there now    E-EDT-008 rings cross
//   E-EDT-002 no such structure                  E-EDT-009 the structure is locked
//   E-EDT-003 no such plane                      E-EDT-010 the order does not name each structure once
//   E-EDT-004 the plane is there already         E-EDT-011 no plane: its axes, origin or thickness
//   E-EDT-005 a point off its plane              E-EDT-012 nothing would change
//   E-EDT-006 a coordinate is impossible         E-EDT-013 a name is no text
//   E-EDT-007 a ring of fewer than three points, or no ring
#pragma once

#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/live/edit/drawing.h"

namespace anatomesh {

// What stands at the key becomes `after`. Guarantees by those that make it: both values are of the key's kind (is_of_kind).
struct Change {
    DrawingKey key;
    DrawingValue before, after;
};

struct Edit {
    std::string name;  // for the list of steps: "Extend liver on k = 12"; UTF-8
    std::vector<Change> changes;
};

// Whether such a value can stand at such a key: a structure's number is that of its key, and an order is never nothing.
bool is_of_kind(const DrawingKey& key, const DrawingValue& value);

// Whether changed rings are checked for crossings, which takes longer than all other checks. Rings that were checked when
// they were drawn need no second check.
enum class CrossingCheck : std::uint8_t { yes, no };

// Returns the drawing with the edit. The changes are made one after another: a later one finds what an earlier one left.
// What the whole leaves must be a drawing. Coordinates and names are kept to the last bit. Errors: those above.
// Complexity: O(changes log n) and a copy of each table that changes; of changed rings O(points log points).
Result<Drawing> applied(const Drawing& drawing, const Edit& edit,
                        CrossingCheck crossings = CrossingCheck::yes);

// The edit that takes `edit` back: its changes in reverse order, each with its values exchanged. O(changes).
Edit inverse(const Edit& edit);

// Returns the drawing with the edit taken back, also where a structure is locked by then: what stood before may stand
// again. Requires: `drawing` is what the edit led to. Complexity: O(changes log n) and a copy of each table that changes.
Drawing taken_back(const Drawing& drawing, const Edit& edit);

// What stands at a key in a few words, for messages: "2 rings with 40 points".
std::string brief_value(const DrawingValue& value);

}  // namespace anatomesh
