// DrawingChanger: the only one that changes a drawing.
#pragma once

#include "anatomesh/live/edit/drawing.h"

namespace anatomesh {

// A drawing that is being changed. Each set() is seen by the next value().
class DrawingChanger {
  public:
    explicit DrawingChanger(const Drawing& drawing);

    const Drawing& now() const { return drawing_; }

    // Requires: is_of_kind(key, value). Complexity: that of SharedTable; of a plane also O(log n) for each key on it.
    void set(const DrawingKey& key, const DrawingValue& value);

    // The drawing, ready to be shared.
    Drawing finish() &&;

  private:
    void touch(RingsKey key) { drawing_.revisions_.set(key, drawing_.revision_); }
    void touch_plane(std::int32_t id);

    Drawing drawing_;
};

// The entries of a table by (plane, structure) that lie on the plane. O(log n).
std::span<const Drawing::Rings::Entry> entries_on_plane(const Drawing::Rings& table, std::int32_t plane);

}  // namespace anatomesh
