#include "anatomesh/live/edit/drawing.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <type_traits>
#include <utility>

namespace anatomesh {

namespace {

bool same(const DrawnStructure& a, const DrawnStructure& b) {
    return a.structure.number == b.structure.number && a.structure.name == b.structure.name &&
           a.structure.color == b.structure.color && a.locked == b.locked;
}

bool same(const StructureOrder& a, const StructureOrder& b) {
    return a == b;
}

bool same(const Plane& a, const Plane& b) {
    return same_bits(a.origin, b.origin) && same_bits(a.u, b.u) && same_bits(a.v, b.v) &&
           same_bits(a.normal, b.normal);
}

bool same(const DrawnPlane& a, const DrawnPlane& b) {
    return same(a.plane, b.plane) && a.name == b.name && same_bits(a.thickness_mm, b.thickness_mm) &&
           a.left_out == b.left_out;
}

bool same(const DrawnRings& a, const DrawnRings& b) {
    return same_bits(a, b);
}

bool same(const ContourPlace& a, const ContourPlace& b) {
    return a.key == b.key && same_bits(a.point, b.point);
}

bool same(const TopologyPin& a, const TopologyPin& b) {
    return same(a.first, b.first) && same(a.second, b.second) && a.joined == b.joined;
}

template <class Table>
bool same_tables(const Table& a, const Table& b) {
    const auto p = a.entries(), q = b.entries();
    if (p.data() == q.data()) return p.size() == q.size();
    return std::equal(p.begin(), p.end(), q.begin(), q.end(), [](const auto& x, const auto& y) {
        return x.key == y.key && (x.value == y.value || same(*x.value, *y.value));
    });
}

template <class Table, class Key>
auto pointer_of(const Table& table, const Key& key) {
    const auto* found = table.find(key);
    return found ? found->get() : nullptr;
}

template <class Table, class Key>
DrawingValue value_of(const Table& table, const Key& key) {
    const auto* found = table.find(key);
    return found ? DrawingValue(*found) : DrawingValue();
}

template <class Table>
std::int32_t key_after(const Table& table) {
    const auto all = table.entries();
    if (all.empty()) return 1;
    assert(all.back().key < std::numeric_limits<std::int32_t>::max());
    return std::max(all.back().key, 0) + 1;
}

}  // namespace

bool same_value(const DrawingValue& a, const DrawingValue& b) {
    if (a.index() != b.index()) return false;
    return std::visit(
        [&](const auto& p) {
            using Pointer = std::decay_t<decltype(p)>;
            if constexpr (std::is_same_v<Pointer, std::monostate>) {
                return true;
            } else {
                const Pointer& q = std::get<Pointer>(b);
                return p == q || same(*p, *q);
            }
        },
        a);
}

Drawing::Drawing(const DrawingSource& source)
    : source_(source), order_(std::make_shared<const StructureOrder>()) {}

const DrawnStructure* Drawing::structure(std::int32_t number) const {
    return pointer_of(structures_, number);
}
const DrawnPlane* Drawing::plane(std::int32_t id) const {
    return pointer_of(planes_, id);
}
const DrawnRings* Drawing::rings(RingsKey key) const {
    return pointer_of(rings_, key);
}
const DrawnRings* Drawing::proposal(RingsKey key) const {
    return pointer_of(proposals_, key);
}

DrawingValue Drawing::value(const DrawingKey& key) const {
    switch (key.subject) {
        case Subject::structure:
            return value_of(structures_, key.first);
        case Subject::order:
            return order_;
        case Subject::plane:
            return value_of(planes_, key.first);
        case Subject::rings:
            return value_of(rings_, key.rings_key());
        case Subject::proposal:
            return value_of(proposals_, key.rings_key());
        case Subject::pin:
            return value_of(pins_, key.first);
    }
    return {};
}

std::uint64_t Drawing::revision(RingsKey key) const {
    const std::uint64_t* found = revisions_.find(key);
    return found ? *found : 0;
}

bool same_drawing(const Drawing& a, const Drawing& b) {
    return a.source().frame == b.source().frame && same_bits(a.source().pixel_mm, b.source().pixel_mm) &&
           same_bits(a.source().slice_thickness_mm, b.source().slice_thickness_mm) &&
           a.order() == b.order() && same_tables(a.structures(), b.structures()) &&
           same_tables(a.planes(), b.planes()) && same_tables(a.rings(), b.rings()) &&
           same_tables(a.proposals(), b.proposals()) && same_tables(a.pins(), b.pins());
}

std::string label_of_structure(const Drawing& drawing, std::int32_t number) {
    const DrawnStructure* structure = drawing.structure(number);
    return structure && !structure->structure.name.empty() ? structure->structure.name
                                                           : "number " + std::to_string(number);
}

std::string label_of_plane(const Drawing& drawing, std::int32_t id) {
    const DrawnPlane* plane = drawing.plane(id);
    return plane && !plane->name.empty() ? plane->name : "plane " + std::to_string(id);
}

std::int32_t next_structure_number(const Drawing& drawing) {
    return key_after(drawing.structures());
}
std::int32_t next_plane_id(const Drawing& drawing) {
    return key_after(drawing.planes());
}
std::int32_t next_pin_id(const Drawing& drawing) {
    return key_after(drawing.pins());
}

}  // namespace anatomesh
