// make_edits: the steps that a person makes, as edits of a drawing as it is now.
//
// Each takes the name of the step. What it names has to be in the drawing, unless it is added; the keys of what is added must
// be free; no key is named twice. What applied() refuses, it refuses of these edits as well. What would stay as it is is no
// change, and an edit without changes is refused.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "anatomesh/live/edit/edit.h"

namespace anatomesh {

// The structure comes last in the order.
Edit add_structure(const Drawing& drawing, DrawnStructure structure, std::string name);
// Its rings, proposals and pins on all planes go with it, and its place in the order.
Edit remove_structure(const Drawing& drawing, std::int32_t number, std::string name);
// Another name, another colour, locked or not: the structure becomes `structure`, which has its number.
Edit change_structure(const Drawing& drawing, DrawnStructure structure, std::string name);
Edit reorder_structures(const Drawing& drawing, StructureOrder order, std::string name);

Edit add_plane(const Drawing& drawing, std::int32_t id, DrawnPlane plane, std::string name);
// Rings, proposals and pins on it go with it.
Edit remove_plane(const Drawing& drawing, std::int32_t id, std::string name);
// Another name or thickness, left out or not. Requires: the same plane in space; move_plane() moves it.
Edit change_plane(const Drawing& drawing, std::int32_t id, DrawnPlane plane, std::string name);
// Moves and turns the plane. Rings, proposals and pins on it keep their coordinates in the plane, within rounding.
Edit move_plane(const Drawing& drawing, std::int32_t id, const Plane& to, std::string name);

// Replaces the rings, or the proposal, of the key; without rings there is nothing there afterwards.
Edit set_rings(const Drawing& drawing, RingsKey key, std::optional<DrawnRings> rings, std::string name);
Edit set_proposal(const Drawing& drawing, RingsKey key, std::optional<DrawnRings> rings, std::string name);
// Proposals of any number of keys become the rings there, as one step.
Edit accept_proposals(const Drawing& drawing, std::span<const RingsKey> keys, std::string name);
Edit reject_proposals(const Drawing& drawing, std::span<const RingsKey> keys, std::string name);

// Replaces the pin; nothing removes it.
Edit set_pin(const Drawing& drawing, std::int32_t id, std::optional<TopologyPin> pin, std::string name);

}  // namespace anatomesh
