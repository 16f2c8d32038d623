#include "anatomesh/live/edit/make_edits.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "anatomesh/live/edit/drawing_changer.h"

namespace anatomesh {

namespace {

// Collects changes of a drawing. Changes of one key are made of what stands there, so each key is changed once.
class EditMaker {
  public:
    EditMaker(const Drawing& drawing, std::string name) : drawing_(drawing) { edit_.name = std::move(name); }

    void change(const DrawingKey& key, DrawingValue after) {
        DrawingValue before = drawing_.value(key);
        if (same_value(before, after)) return;
        edit_.changes.push_back({key, std::move(before), std::move(after)});
    }
    void remove(const DrawingKey& key) { change(key, DrawingValue()); }

    // Removes the pins of which `is_meant` holds for the key of one end.
    template <class IsMeant>
    void remove_pins(const IsMeant& is_meant) {
        for (const auto& entry : drawing_.pins().entries()) {
            if (is_meant(entry.value->first.key) || is_meant(entry.value->second.key))
                remove(DrawingKey::of_pin(entry.key));
        }
    }

    Edit finish() && { return std::move(edit_); }

  private:
    const Drawing& drawing_;
    Edit edit_;
};

DrawingValue value_or_nothing(std::optional<DrawnRings> rings) {
    return rings && !rings->rings.empty() ? drawing_value(*std::move(rings)) : DrawingValue();
}

Edit only(const Drawing& drawing, const DrawingKey& key, DrawingValue after, std::string name) {
    EditMaker maker(drawing, std::move(name));
    maker.change(key, std::move(after));
    return std::move(maker).finish();
}

Vec3 carried(Vec3 point, const Plane& from, const Plane& to) {
    return to.to_space(from.to_plane(point));
}

DrawingValue carried(DrawnRings rings, const Plane& from, const Plane& to) {
    for (Vec3& point : rings.points) point = carried(point, from, to);
    for (Vec3& point : rings.control_points) point = carried(point, from, to);
    return drawing_value(std::move(rings));
}

}  // namespace

Edit add_structure(const Drawing& drawing, DrawnStructure structure, std::string name) {
    const std::int32_t number = structure.structure.number;
    assert(!drawing.structure(number));
    EditMaker maker(drawing, std::move(name));
    maker.change(DrawingKey::of_structure(number), drawing_value(std::move(structure)));
    StructureOrder order = drawing.order();
    order.push_back(number);
    maker.change(DrawingKey::of_order(), drawing_value(std::move(order)));
    return std::move(maker).finish();
}

Edit remove_structure(const Drawing& drawing, std::int32_t number, std::string name) {
    assert(drawing.structure(number));
    EditMaker maker(drawing, std::move(name));
    for (const auto& entry : drawing.rings().entries()) {
        if (entry.key.structure == number) maker.remove(DrawingKey::of_rings(entry.key));
    }
    for (const auto& entry : drawing.proposals().entries()) {
        if (entry.key.structure == number) maker.remove(DrawingKey::of_proposal(entry.key));
    }
    maker.remove_pins([&](RingsKey key) { return key.structure == number; });
    maker.remove(DrawingKey::of_structure(number));
    StructureOrder order = drawing.order();
    std::erase(order, number);
    maker.change(DrawingKey::of_order(), drawing_value(std::move(order)));
    return std::move(maker).finish();
}

Edit change_structure(const Drawing& drawing, DrawnStructure structure, std::string name) {
    const DrawingKey key = DrawingKey::of_structure(structure.structure.number);
    assert(drawing.structure(key.first));
    return only(drawing, key, drawing_value(std::move(structure)), std::move(name));
}

Edit reorder_structures(const Drawing& drawing, StructureOrder order, std::string name) {
    return only(drawing, DrawingKey::of_order(), drawing_value(std::move(order)), std::move(name));
}

Edit add_plane(const Drawing& drawing, std::int32_t id, DrawnPlane plane, std::string name) {
    assert(!drawing.plane(id));
    return only(drawing, DrawingKey::of_plane(id), drawing_value(std::move(plane)), std::move(name));
}

Edit remove_plane(const Drawing& drawing, std::int32_t id, std::string name) {
    assert(drawing.plane(id));
    EditMaker maker(drawing, std::move(name));
    for (const auto& entry : entries_on_plane(drawing.rings(), id))
        maker.remove(DrawingKey::of_rings(entry.key));
    for (const auto& entry : entries_on_plane(drawing.proposals(), id))
        maker.remove(DrawingKey::of_proposal(entry.key));
    maker.remove_pins([&](RingsKey key) { return key.plane == id; });
    maker.remove(DrawingKey::of_plane(id));
    return std::move(maker).finish();
}

Edit change_plane(const Drawing& drawing, std::int32_t id, DrawnPlane plane, std::string name) {
    assert(drawing.plane(id));
    return only(drawing, DrawingKey::of_plane(id), drawing_value(std::move(plane)), std::move(name));
}

Edit move_plane(const Drawing& drawing, std::int32_t id, const Plane& to, std::string name) {
    assert(drawing.plane(id));
    EditMaker maker(drawing, std::move(name));
    DrawnPlane moved = *drawing.plane(id);
    const Plane from = std::exchange(moved.plane, to);
    maker.change(DrawingKey::of_plane(id), drawing_value(std::move(moved)));
    for (const auto& entry : entries_on_plane(drawing.rings(), id))
        maker.change(DrawingKey::of_rings(entry.key), carried(*entry.value, from, to));
    for (const auto& entry : entries_on_plane(drawing.proposals(), id))
        maker.change(DrawingKey::of_proposal(entry.key), carried(*entry.value, from, to));
    for (const auto& entry : drawing.pins().entries()) {
        TopologyPin pin = *entry.value;
        if (pin.first.key.plane != id && pin.second.key.plane != id) continue;
        for (ContourPlace* place : {&pin.first, &pin.second}) {
            if (place->key.plane == id) place->point = carried(place->point, from, to);
        }
        maker.change(DrawingKey::of_pin(entry.key), drawing_value(pin));
    }
    return std::move(maker).finish();
}

Edit set_rings(const Drawing& drawing, RingsKey key, std::optional<DrawnRings> rings, std::string name) {
    return only(drawing, DrawingKey::of_rings(key), value_or_nothing(std::move(rings)), std::move(name));
}

Edit set_proposal(const Drawing& drawing, RingsKey key, std::optional<DrawnRings> rings, std::string name) {
    return only(drawing, DrawingKey::of_proposal(key), value_or_nothing(std::move(rings)), std::move(name));
}

Edit accept_proposals(const Drawing& drawing, std::span<const RingsKey> keys, std::string name) {
    EditMaker maker(drawing, std::move(name));
    for (const RingsKey& key : keys) {
        const DrawingValue proposal = drawing.value(DrawingKey::of_proposal(key));
        assert(proposal.index() != 0);
        maker.change(DrawingKey::of_rings(key), proposal);
        maker.remove(DrawingKey::of_proposal(key));
    }
    return std::move(maker).finish();
}

Edit reject_proposals(const Drawing& drawing, std::span<const RingsKey> keys, std::string name) {
    EditMaker maker(drawing, std::move(name));
    for (const RingsKey& key : keys) maker.remove(DrawingKey::of_proposal(key));
    return std::move(maker).finish();
}

Edit set_pin(const Drawing& drawing, std::int32_t id, std::optional<TopologyPin> pin, std::string name) {
    return only(drawing, DrawingKey::of_pin(id), pin ? drawing_value(*pin) : DrawingValue(), std::move(name));
}

}  // namespace anatomesh
