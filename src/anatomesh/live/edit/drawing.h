// Drawing: all that a person has drawn, as one value: structures, planes, rings, proposals, pins.
//
// Terms. A *structure* is known by its number and a *plane* by its id; both stay for life. The *rings* of a structure on a
// plane are what was drawn there; a *proposal* is rings that nobody has accepted yet. A *topology pin* says of two contours
// that the model joins them, or that it does not. A slice that is *left out* stays in the drawing and not in the model.
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "anatomesh/base/structure.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/live/edit/drawn_rings.h"
#include "anatomesh/live/edit/shared_table.h"

namespace anatomesh {

struct DrawnStructure {
    Structure structure;  // its number is its key
    bool locked = false;  // its rings, proposals and itself cannot be changed
};

// A plane to draw on. Its normal has length 1 within rounding; u and v are those of the image that is shown there.
struct DrawnPlane {
    Plane plane;
    std::string name;         // what the image calls it: "k = 12"; may be empty
    double thickness_mm = 0;  // of the slice; 0 when unknown
    bool left_out = false;
};

// The structure whose rings lie on the plane.
struct RingsKey {
    std::int32_t plane = 0;      // id
    std::int32_t structure = 0;  // number
    friend auto operator<=>(const RingsKey&, const RingsKey&) = default;
};

// A contour, by a point on it: rings change places in their list, points do not.
struct ContourPlace {
    RingsKey key;
    Vec3 point;  // mm
};

struct TopologyPin {
    ContourPlace first, second;
    bool joined = true;  // false: the model keeps them apart
};

// The structures' numbers in the order in which they are listed.
using StructureOrder = std::vector<std::int32_t>;

// What an edit can change: one structure, the order of structures, one plane, the rings or the proposal of a key, one pin.
enum class Subject : std::uint8_t { structure, order, plane, rings, proposal, pin };
struct DrawingKey {
    Subject subject = Subject::order;
    std::int32_t first = 0;   // number of a structure, id of a plane or of a pin; else 0
    std::int32_t second = 0;  // of rings and proposals: number of the structure; else 0
    friend auto operator<=>(const DrawingKey&, const DrawingKey&) = default;

    static DrawingKey of_structure(std::int32_t number) { return {Subject::structure, number, 0}; }
    static DrawingKey of_order() { return {Subject::order, 0, 0}; }
    static DrawingKey of_plane(std::int32_t id) { return {Subject::plane, id, 0}; }
    static DrawingKey of_rings(RingsKey key) { return {Subject::rings, key.plane, key.structure}; }
    static DrawingKey of_proposal(RingsKey key) { return {Subject::proposal, key.plane, key.structure}; }
    static DrawingKey of_pin(std::int32_t id) { return {Subject::pin, id, 0}; }
    // Requires: rings or a proposal.
    RingsKey rings_key() const { return {first, second}; }
};

// What stands at a key. The first alternative: nothing. The pointers are never null, and what they point to never changes.
using DrawingValue = std::variant<std::monostate, std::shared_ptr<const DrawnStructure>,
                                  std::shared_ptr<const StructureOrder>, std::shared_ptr<const DrawnPlane>,
                                  std::shared_ptr<const DrawnRings>, std::shared_ptr<const TopologyPin>>;

template <class T>
DrawingValue drawing_value(T value) {
    return std::make_shared<const T>(std::move(value));
}

// Whether two values are the same, bit for bit. O(points).
bool same_value(const DrawingValue& a, const DrawingValue& b);

// What the drawing was begun on. It never changes.
struct DrawingSource {
    Frame frame = Frame::lps;
    double pixel_mm = 0;            // in-plane pixel size of the image, mm; 0 when unknown
    double slice_thickness_mm = 0;  // of its slices, mm; 0 when unknown
};

// A value: copies cost O(1) and share what does not change. Only edits change one (edit.h). Guarantees: rings and
// proposals belong to a plane and a structure that are there and lie on that plane; the order names each structure once;
// no two planes are one. A const drawing may be read and copied on several threads.
class Drawing {
  public:
    using Structures = SharedTable<std::int32_t, std::shared_ptr<const DrawnStructure>>;
    using Planes = SharedTable<std::int32_t, std::shared_ptr<const DrawnPlane>>;
    using Rings = SharedTable<RingsKey, std::shared_ptr<const DrawnRings>>;
    using Pins = SharedTable<std::int32_t, std::shared_ptr<const TopologyPin>>;

    explicit Drawing(const DrawingSource& source = {});

    const DrawingSource& source() const { return source_; }
    const StructureOrder& order() const { return *order_; }

    // By number, id, or (plane, structure), ascending.
    const Structures& structures() const { return structures_; }
    const Planes& planes() const { return planes_; }
    const Rings& rings() const { return rings_; }
    const Rings& proposals() const { return proposals_; }
    const Pins& pins() const { return pins_; }

    // Each returns nullptr where there is none. O(log n).
    const DrawnStructure* structure(std::int32_t number) const;
    const DrawnPlane* plane(std::int32_t id) const;
    const DrawnRings* rings(RingsKey key) const;
    const DrawnRings* proposal(RingsKey key) const;

    // What stands at the key; of the order always a list. O(log n).
    DrawingValue value(const DrawingKey& key) const;

    // It rises by 1 with each edit, and with each that is undone or redone.
    std::uint64_t revision() const { return revision_; }
    // The revision at which rings, proposal or plane of the key changed last; 0: never. What was computed of the key at
    // this revision still holds, also if the key was removed and came back between.
    std::uint64_t revision(RingsKey key) const;

  private:
    friend class DrawingChanger;

    DrawingSource source_;
    Structures structures_;
    std::shared_ptr<const StructureOrder> order_;
    Planes planes_;
    Rings rings_, proposals_;
    Pins pins_;
    std::uint64_t revision_ = 0;
    SharedTable<RingsKey, std::uint64_t> revisions_;
};

// Whether two drawings hold the same, bit for bit. Revisions do not count. O(points that they do not share).
bool same_drawing(const Drawing& a, const Drawing& b);

// How messages call a structure or a plane: its name, else its number or id.
std::string label_of_structure(const Drawing& drawing, std::int32_t number);
std::string label_of_plane(const Drawing& drawing, std::int32_t id);

// A number or id that is larger than all there are; 1 for the first. Requires: none is the largest std::int32_t.
std::int32_t next_structure_number(const Drawing& drawing);
std::int32_t next_plane_id(const Drawing& drawing);
std::int32_t next_pin_id(const Drawing& drawing);

}  // namespace anatomesh
