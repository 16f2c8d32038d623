// LocalThickness: how thick a structure, or the gap between two of its parts, is at a point of its surface.
#pragma once

#include <cstdint>
#include <optional>

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

// A mesh of edge length h loses walls and gaps thinner than about h: all vertices of a cell lie on the surface then, and
// few of the cells know on which side they are. Where one is found, the sample is made finer.
// Thread-safe; the field must outlive it.
class LocalThickness {
  public:
    // Walls and gaps are looked for up to `reach` mm. > 0.
    LocalThickness(const StructureField& field, double reach) : field_(field), reach_(reach) {}

    double reach() const { return reach_; }

    // The structure's unit outward normal near p, by differences of its value; nothing where that is flat.
    std::optional<Vec3> normal(std::uint32_t structure, Vec3 p) const;

    // The smaller of the wall behind and the gap before a point of the structure's surface with this unit outward
    // normal, mm; reach() when both are at least as thick. What is thinner than reach() / 16 counts as that.
    // Complexity: four field values where nothing is thin.
    double thickness(std::uint32_t structure, Vec3 p, Vec3 normal) const;

  private:
    bool inside(std::uint32_t structure, Vec3 p) const { return field_.value_within(structure, p, 0) < 0; }
    double depth(std::uint32_t structure, Vec3 p, Vec3 direction, bool expected) const;

    const StructureField& field_;
    double reach_;
};

}  // namespace anatomesh
