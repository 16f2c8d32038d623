#include "anatomesh/pipeline/how_planes_lie.h"

#include "anatomesh/sample/sample_points.h"

namespace anatomesh {

namespace {

constexpr double most_dense = 3;  // as plane_density() has it: more are left as they come first
// Between dense planes about an axis subsegments are so many and so near to each other at its poles
// that splitting all for each other's sake, and bringing back what is missing, costs a hundred times the
// rest; but not where there are few.
constexpr std::size_t few_points = 5000;

}  // namespace

HowPlanesLie how_planes_lie(const ContourSet& contours, const SliceArrangement& arrangement,
                            const StructureField& field, std::uint64_t spare_dense_above) {
    HowPlanesLie planes;
    planes.density = plane_density(contours, arrangement, field);
    planes.apart = arrangement.is_stack();
    planes.dense = planes.density > 1;
    // Of sweeps of one extent: the time that all takes goes with it (docs/benchmarks.md).
    const double work = static_cast<double>(contours.points.size()) * planes.density * planes.density;
    planes.crammed =
        planes.density > most_dense || (planes.dense && work > static_cast<double>(spare_dense_above));
    const bool are_many =
        planes.dense && contours.points.size() > few_points && arrangement.rotation.has_value();
    planes.bear_all = !planes.crammed && !are_many;
    planes.may_conform = planes.bear_all && !planes.apart;
    // A few planes across a stack come near to others only where they cross them: vertices for cuts there
    // cost shapes of cells (seven above ratio 4 in a ball) and, where they contradict it, handles.
    planes.meet_cuts = planes.may_conform && !arrangement.parts;
    return planes;
}

}  // namespace anatomesh
