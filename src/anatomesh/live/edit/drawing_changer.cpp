#include "anatomesh/live/edit/drawing_changer.h"

#include <algorithm>

namespace anatomesh {

namespace {

template <class Table, class Key>
void put(Table& table, const Key& key, const DrawingValue& value) {
    using Pointer = decltype(Table::Entry::value);
    if (const Pointer* pointer = std::get_if<Pointer>(&value))
        table.set(key, *pointer);
    else
        table.erase(key);
}

}  // namespace

std::span<const Drawing::Rings::Entry> entries_on_plane(const Drawing::Rings& table, std::int32_t plane) {
    const auto all = table.entries();
    const auto first = std::partition_point(all.begin(), all.end(),
                                            [&](const auto& entry) { return entry.key.plane < plane; });
    const auto last =
        std::partition_point(first, all.end(), [&](const auto& entry) { return entry.key.plane == plane; });
    return {first, last};
}

DrawingChanger::DrawingChanger(const Drawing& drawing) : drawing_(drawing) {
    ++drawing_.revision_;
}

void DrawingChanger::touch_plane(std::int32_t id) {
    for (const auto* table : {&drawing_.rings_, &drawing_.proposals_}) {
        for (const auto& entry : entries_on_plane(*table, id)) touch(entry.key);
    }
}

void DrawingChanger::set(const DrawingKey& key, const DrawingValue& value) {
    switch (key.subject) {
        case Subject::structure:
            put(drawing_.structures_, key.first, value);
            break;
        case Subject::order:
            drawing_.order_ = std::get<std::shared_ptr<const StructureOrder>>(value);
            break;
        case Subject::plane:
            put(drawing_.planes_, key.first, value);
            touch_plane(key.first);
            break;
        case Subject::rings:
            put(drawing_.rings_, key.rings_key(), value);
            touch(key.rings_key());
            break;
        case Subject::proposal:
            put(drawing_.proposals_, key.rings_key(), value);
            touch(key.rings_key());
            break;
        case Subject::pin:
            put(drawing_.pins_, key.first, value);
            break;
    }
}

Drawing DrawingChanger::finish() && {
    drawing_.structures_.share();
    drawing_.planes_.share();
    drawing_.rings_.share();
    drawing_.proposals_.share();
    drawing_.pins_.share();
    drawing_.revisions_.share();
    return std::move(drawing_);
}

}  // namespace anatomesh
