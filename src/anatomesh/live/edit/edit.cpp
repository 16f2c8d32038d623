#include "anatomesh/live/edit/edit.h"

#include <cassert>
#include <type_traits>
#include <utility>

#include "anatomesh/base/plural.h"
#include "anatomesh/live/edit/check_drawing.h"
#include "anatomesh/live/edit/drawing_changer.h"

namespace anatomesh {

namespace {

Place place_of(const Drawing& drawing, const DrawingKey& key) {
    Place place;
    const bool of_rings = key.subject == Subject::rings || key.subject == Subject::proposal;
    if (of_rings || key.subject == Subject::plane) place.slice = label_of_plane(drawing, key.first);
    if (of_rings || key.subject == Subject::structure)
        place.structure = label_of_structure(drawing, of_rings ? key.second : key.first);
    return place;
}

std::string kind_name(Subject subject) {
    switch (subject) {
        case Subject::structure:
            return "the structure";
        case Subject::order:
            return "the order of structures";
        case Subject::plane:
            return "the plane";
        case Subject::rings:
            return "the rings";
        case Subject::proposal:
            return "the proposal";
        case Subject::pin:
            return "the pin";
    }
    return {};
}

Error refused(const Drawing& drawing, const DrawingKey& key, const char* code, std::string message,
              std::string next_step) {
    return {ErrorKind::input, code, kind_name(key.subject) + " " + std::move(message), place_of(drawing, key),
            std::move(next_step)};
}

// A lock bars the rings and proposals of a structure and its removal.
bool is_locked(const Drawing& now, const Change& change) {
    std::int32_t number = 0;
    if (change.key.subject == Subject::rings || change.key.subject == Subject::proposal)
        number = change.key.second;
    else if (change.key.subject == Subject::structure && change.after.index() == 0)
        number = change.key.first;
    else
        return false;
    const DrawnStructure* structure = now.structure(number);
    return structure && structure->locked;
}

Status check_change(const Drawing& now, const Change& change) {
    assert(is_of_kind(change.key, change.after));
    if (same_value(change.before, change.after))
        return refused(now, change.key, "E-EDT-012", "would stay as it is", "make no edit of it");
    const DrawingValue standing = now.value(change.key);
    if (!same_value(standing, change.before)) {
        Error error = refused(now, change.key, "E-EDT-001",
                              "changed meanwhile: expected is " + brief_value(change.before) + ", there is " +
                                  brief_value(standing),
                              "look at what is there now, and make the edit again");
        error.place.value = brief_value(standing);
        return error;
    }
    if (is_locked(now, change))
        return refused(now, change.key, "E-EDT-009", "cannot be changed, because the structure is locked",
                       "unlock the structure");
    return Nothing{};
}

}  // namespace

bool is_of_kind(const DrawingKey& key, const DrawingValue& value) {
    if (value.index() == 0) return key.subject != Subject::order;
    switch (key.subject) {
        case Subject::structure: {
            const auto* structure = std::get_if<std::shared_ptr<const DrawnStructure>>(&value);
            return structure && (*structure)->structure.number == key.first;
        }
        case Subject::order:
            return std::holds_alternative<std::shared_ptr<const StructureOrder>>(value);
        case Subject::plane:
            return std::holds_alternative<std::shared_ptr<const DrawnPlane>>(value);
        case Subject::rings:
        case Subject::proposal:
            return std::holds_alternative<std::shared_ptr<const DrawnRings>>(value);
        case Subject::pin:
            return std::holds_alternative<std::shared_ptr<const TopologyPin>>(value);
    }
    return false;
}

Result<Drawing> applied(const Drawing& drawing, const Edit& edit, CrossingCheck crossings) {
    if (edit.changes.empty())
        return Error{ErrorKind::input, "E-EDT-012", "an edit without changes", {}, "make no edit of it"};
    ANATOMESH_CHECK_STATUS(check_name(edit.name, {}));
    DrawingChanger changer(drawing);
    for (const Change& change : edit.changes) {
        ANATOMESH_CHECK_STATUS(check_change(changer.now(), change));
        changer.set(change.key, change.after);
    }
    ANATOMESH_CHECK_STATUS(check_drawing(changer.now(), edit, crossings));
    return std::move(changer).finish();
}

Edit inverse(const Edit& edit) {
    Edit back{edit.name, {}};
    back.changes.reserve(edit.changes.size());
    for (auto change = edit.changes.rbegin(); change != edit.changes.rend(); ++change)
        back.changes.push_back({change->key, change->after, change->before});
    return back;
}

Drawing taken_back(const Drawing& drawing, const Edit& edit) {
    DrawingChanger changer(drawing);
    for (auto change = edit.changes.rbegin(); change != edit.changes.rend(); ++change) {
        assert(same_value(changer.now().value(change->key), change->after));
        changer.set(change->key, change->before);
    }
    return std::move(changer).finish();
}

std::string brief_value(const DrawingValue& value) {
    return std::visit(
        [](const auto& p) -> std::string {
            using Pointer = std::decay_t<decltype(p)>;
            if constexpr (std::is_same_v<Pointer, std::monostate>) {
                return "nothing";
            } else if constexpr (std::is_same_v<Pointer, std::shared_ptr<const DrawnStructure>>) {
                const Structure& s = p->structure;
                return "\"" + s.name + "\" in colour " + std::to_string(s.color[0]) + ", " +
                       std::to_string(s.color[1]) + ", " + std::to_string(s.color[2]) +
                       (p->locked ? ", locked" : "");
            } else if constexpr (std::is_same_v<Pointer, std::shared_ptr<const StructureOrder>>) {
                std::string list;
                for (const std::int32_t number : *p)
                    list += (list.empty() ? "" : ", ") + std::to_string(number);
                return list.empty() ? "no structure" : list;
            } else if constexpr (std::is_same_v<Pointer, std::shared_ptr<const DrawnPlane>>) {
                const Vec3 o = p->plane.origin, n = p->plane.normal;
                return "\"" + p->name + "\" through " + brief_point(o) + " with normal " + brief_point(n) +
                       (p->left_out ? ", left out" : "");
            } else if constexpr (std::is_same_v<Pointer, std::shared_ptr<const DrawnRings>>) {
                return counted(p->rings.size(), "ring") + " with " + counted(p->points.size(), "point");
            } else {
                return p->joined ? "joined" : "kept apart";
            }
        },
        value);
}

}  // namespace anatomesh
