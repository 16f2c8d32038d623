#include "anatomesh/live/draw/copy_rings.h"

#include <utility>

#include "anatomesh/base/standard_arithmetic.h"

namespace anatomesh {

Result<StructureRings> copy_rings(const StructureRings& from, const Plane& to) {
    const StandardArithmetic arithmetic;
    StructureRings copy{to, {}};
    for (const Ring& ring : from.rings) {
        Ring& copied = copy.rings.emplace_back();
        copied.source = ring.source;
        for (const Vec2 q : ring.at) {
            const Vec3 point = to.to_space(q);
            copied.push_back(to.to_plane(point), point);
        }
    }
    ANATOMESH_CHECK_STATUS(check_structure_rings(copy));
    return copy;
}

}  // namespace anatomesh
