#include "anatomesh/live/edit/check_drawing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/text.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/live/edit/check_rings.h"
#include "anatomesh/live/edit/drawing_changer.h"

namespace anatomesh {

namespace {

// A contour file keeps a normal to the last bit only if its squared length differs from 1 by less. [1; > 0; D rounding of a unit
// vector, as in the readers]
constexpr double most_off_unit = 1e-14;
// The axes of a frame are orthonormal within this: files round them. [1; > 0; D digits of files]
constexpr double most_off_orthonormal = 1e-6;
// Planes are one if this far from their origins they are: no patient is longer. [mm; > 0; D a choice, measurement not recorded]
constexpr double reach_mm = 2000;
// A contour file holds no longer text. [bytes; >= 1; D limit of the reader of JSON contours]
constexpr std::size_t longest_name = std::size_t{1} << 20;

Error bad(const char* code, std::string message, Place place, std::string next_step) {
    return {ErrorKind::input, code, std::move(message), std::move(place), std::move(next_step)};
}

class DrawingCheck {
  public:
    DrawingCheck(const Drawing& drawing, CrossingCheck crossings)
        : drawing_(drawing), crossings_(crossings) {}

    Status run(const Edit& edit) {
        bool is_order_touched = false;
        for (const Change& change : edit.changes) {
            ANATOMESH_CHECK_STATUS(check(change));
            is_order_touched |=
                change.key.subject == Subject::structure || change.key.subject == Subject::order;
        }
        return is_order_touched ? check_order() : Status(Nothing{});
    }

  private:
    Place at(RingsKey key) const {
        return {"", label_of_plane(drawing_, key.plane), label_of_structure(drawing_, key.structure), "", ""};
    }

    Status check(const Change& change) {
        switch (change.key.subject) {
            case Subject::structure:
                return check_structure(change.key.first);
            case Subject::order:
                return Nothing{};
            case Subject::plane:
                return check_plane(change.key.first);
            case Subject::rings:
                return check_key(drawing_.rings(), change.key.rings_key(), crossings_);
            case Subject::proposal:
                return check_key(drawing_.proposals(), change.key.rings_key(), crossings_);
            case Subject::pin:
                return check_pin(change.key.first);
        }
        return Nothing{};
    }

    Status known(RingsKey key) const {
        if (!drawing_.structure(key.structure)) {
            Place place = at(key);
            place.value = std::to_string(key.structure);
            return bad("E-EDT-002", "there is no such structure", std::move(place),
                       "add the structure first, or remove what belongs to it as well");
        }
        if (!drawing_.plane(key.plane)) {
            Place place = at(key);
            place.value = std::to_string(key.plane);
            return bad("E-EDT-003", "there is no such plane", std::move(place),
                       "add the plane first, or remove what lies on it as well");
        }
        return Nothing{};
    }

    Status check_key(const Drawing::Rings& table, RingsKey key, CrossingCheck crossings) const {
        const auto* rings = table.find(key);
        if (!rings) return Nothing{};
        ANATOMESH_CHECK_STATUS(known(key));
        return check_rings(**rings, drawing_.plane(key.plane)->plane, crossings, at(key));
    }

    Status check_order() {
        StructureOrder sorted = drawing_.order();
        std::sort(sorted.begin(), sorted.end());
        const auto all = drawing_.structures().entries();
        const bool same =
            std::equal(sorted.begin(), sorted.end(), all.begin(), all.end(),
                       [](std::int32_t number, const auto& entry) { return number == entry.key; });
        if (same) return Nothing{};
        return bad("E-EDT-010", "the order of structures does not name each structure once",
                   {"", "", "", "", brief_value(drawing_.value(DrawingKey::of_order()))},
                   "name each structure once");
    }

    Status check_structure(std::int32_t number) {
        if (const DrawnStructure* structure = drawing_.structure(number))
            return check_name(structure->structure.name, {"", "", std::to_string(number), "", ""});
        for (const auto* table : {&drawing_.rings(), &drawing_.proposals()}) {
            for (const auto& entry : table->entries()) {
                if (entry.key.structure == number) return known(entry.key);
            }
        }
        return check_pins();
    }

    Status check_plane(std::int32_t id) {
        const DrawnPlane* plane = drawing_.plane(id);
        if (plane) {
            ANATOMESH_CHECK_STATUS(check_frame(id, *plane));
        } else {
            ANATOMESH_CHECK_STATUS(check_pins());
        }
        // What was drawn on the plane was checked for crossings when it was drawn.
        for (const auto* table : {&drawing_.rings(), &drawing_.proposals()}) {
            for (const auto& entry : entries_on_plane(*table, id)) {
                ANATOMESH_CHECK_STATUS(check_key(*table, entry.key, CrossingCheck::no));
            }
        }
        return Nothing{};
    }

    Status check_frame(std::int32_t id, const DrawnPlane& drawn) const {
        const Place place{"", label_of_plane(drawing_, id), "", "", std::to_string(id)};
        ANATOMESH_CHECK_STATUS(check_name(drawn.name, {"", "plane " + std::to_string(id), "", "", ""}));
        const Plane& plane = drawn.plane;
        const auto near = [](double value, double wanted) {
            return std::abs(value - wanted) <= most_off_orthonormal;  // false for NaN
        };
        const Vec3 right_handed = cross(plane.u, plane.v) - plane.normal;
        if (!is_possible(plane.origin) || !(std::abs(squared_length(plane.normal) - 1) < most_off_unit) ||
            !near(squared_length(plane.u), 1) || !near(squared_length(plane.v), 1) ||
            !near(dot(plane.u, plane.v), 0) || !near(squared_length(right_handed), 0))
            return bad("E-EDT-011", "the plane has no right-handed axes of length 1, or no possible origin",
                       place, "make the plane of an origin and a normal");
        if (!(drawn.thickness_mm >= 0 && drawn.thickness_mm <= coordinate_bound_mm))
            return bad("E-EDT-011", "the thickness of the slice is " + brief(drawn.thickness_mm) + " mm",
                       place, "give a thickness of 0, which is unknown, or more");
        for (const auto& other : drawing_.planes().entries()) {
            if (other.key == id || !are_one(plane, other.value->plane)) continue;
            return bad("E-EDT-004", "the plane is there already, as " + label_of_plane(drawing_, other.key),
                       place, "draw on the plane that is there");
        }
        return Nothing{};
    }

    // Whether the planes, of any direction of their normals, are as near as files can say around both origins.
    static bool are_one(const Plane& a, const Plane& b) {
        const auto near = [](const Plane& p, const Plane& q) {
            return std::abs(p.signed_distance(q.origin)) <= exactly_parallel_mm &&
                   length(cross(p.normal, q.normal)) * reach_mm <= exactly_parallel_mm;
        };
        return near(a, b) && near(b, a);
    }

    Status check_pins() const {
        for (const auto& entry : drawing_.pins().entries()) {
            ANATOMESH_CHECK_STATUS(check_pin(entry.key));
        }
        return Nothing{};
    }

    Status check_pin(std::int32_t id) const {
        const auto* pin = drawing_.pins().find(id);
        if (!pin) return Nothing{};
        for (const ContourPlace& place : {(*pin)->first, (*pin)->second}) {
            ANATOMESH_CHECK_STATUS(known(place.key));
            if (is_possible(place.point)) continue;
            Place where = at(place.key);
            where.value = brief_point(place.point);
            return bad("E-EDT-006", "a coordinate is not finite, or beyond 1e7 mm", std::move(where),
                       "correct the point of the pin");
        }
        return Nothing{};
    }

    const Drawing& drawing_;
    CrossingCheck crossings_;
};

}  // namespace

Status check_drawing(const Drawing& drawing, const Edit& edit, CrossingCheck crossings) {
    return DrawingCheck(drawing, crossings).run(edit);
}

Status check_name(const std::string& name, Place place) {
    if (is_utf8(name) && name.size() <= longest_name) return Nothing{};
    return bad("E-EDT-013", "a name is no UTF-8 text, or longer than 1 MiB", std::move(place),
               "give another name");
}

std::string brief_point(Vec3 p) {
    return "(" + brief(p.x) + ", " + brief(p.y) + ", " + brief(p.z) + ")";
}

}  // namespace anatomesh
