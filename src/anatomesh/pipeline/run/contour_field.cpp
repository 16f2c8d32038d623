#include "anatomesh/pipeline/run/contour_field.h"

#include <utility>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/volume.h"

namespace anatomesh {

ContourSet relative_to(Vec3 origin, ContourSet set) {
    for (Vec3& p : set.points) p = p - origin;
    for (Slice& slice : set.slices) {
        Plane& plane = slice.plane;
        plane.origin = dot(plane.origin - origin, plane.normal) * plane.normal;
    }
    for (LeftOutSlice& slice : set.left_out) slice.plane.origin = slice.plane.origin - origin;
    if (set.overlapping) {
        OverlappingContours moved{*set.overlapping};
        for (ContourSet& level : moved.levels) level = relative_to(origin, std::move(level));
        set.overlapping = std::make_shared<const OverlappingContours>(std::move(moved));
    }
    return set;
}

Result<ContourField> contour_field(const ContourSet& contours, const FieldOptions& options,
                                   RunContext& context) {
    ContourField made;
    if (!contours.points.empty()) made.origin = contours.box().low;
    ANATOMESH_TRY(made.field, make_structure_field(relative_to(made.origin, contours), options, context));
    const auto structures = static_cast<std::uint32_t>(contours.structures.size());
    ANATOMESH_TRY(const std::vector<StructureVolume> volumes,
                  field_volumes(*made.field, structures, {}, context));
    for (const StructureVolume& volume : volumes) made.volumes_mm3.push_back(volume.by_field);
    return made;
}

}  // namespace anatomesh
