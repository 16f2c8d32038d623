#include "anatomesh/field/sparse_planes.h"

#include <algorithm>
#include <string>
#include <vector>

#include "anatomesh/contour/message_text.h"
#include "anatomesh/field/thin_structures.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/reconcile/plane_patches.h"

namespace anatomesh {

namespace {

constexpr int lattice = 16;
constexpr double far_share = 0.25;    // of the thickness
constexpr double most_far_off = 0.1;  // of the volume

// Patches of the contours of one structure alone.
std::vector<PlanePatch> patches_of(const ContourSet& set, std::uint32_t structure, Box3& box) {
    std::vector<PlanePatch> patches;
    for (const Slice& slice : set.slices) {
        PlanePatch patch{slice.plane, {}, 0, 0};
        bool any = false;
        for (const Contour& contour : set.contours_of(slice)) {
            if (contour.structure != structure) continue;
            any = true;
            for (const Vec3& p : set.points_of(contour)) {
                patch.box.extend(slice.plane.to_plane(p));
                box.extend(p);
            }
        }
        if (any) patches.push_back(patch);
    }
    return patches;
}

double share_far_off(const StructureField& field, std::uint32_t structure,
                     const std::vector<PlanePatch>& patches, const Box3& box, double bound) {
    std::vector<Vec3> near;
    double far_off = 0, inside = 0;
    const Vec3 step = (1.0 / lattice) * (box.high - box.low);
    for (int n = 0; n < lattice * lattice * lattice; ++n) {
        const Vec3 p = box.low + Vec3{(n % lattice + 0.5) * step.x, (n / lattice % lattice + 0.5) * step.y,
                                      (n / (lattice * lattice) + 0.5) * step.z};
        const bool is_near = std::any_of(patches.begin(), patches.end(), [&](const PlanePatch& patch) {
            return squared_length(patch.offset_from(p, bound)) <= bound * bound;
        });
        if (is_near)
            near.push_back(p);
        else
            far_off += field.value(structure, p) < 0;
    }
    if (far_off == 0) return 0;
    for (const Vec3& p : near) inside += field.value(structure, p) < 0;
    return far_off / (far_off + inside);
}

}  // namespace

void warn_about_sparse_planes(const ContourSet& set, const StructureField& field, double known_mm,
                              RunContext& context) {
    const std::vector<double> thickness = mean_thicknesses(set);
    for (std::uint32_t s = 0; s < thickness.size(); ++s) {
        if (!(thickness[s] > 0) || context.cancelled()) continue;
        Box3 box;
        const std::vector<PlanePatch> patches = patches_of(set, s, box);
        const double far = std::max(far_share * thickness[s], known_mm);
        const double share = share_far_off(field, s, patches, box, far);
        if (share <= most_far_off) continue;
        const Structure& structure = set.structures[s];
        context.warn(
            {"W-FLD-008",
             "poorly sampled: much of the structure is far from the planes that it is drawn on, and what "
             "is there follows from none of them",
             {set.source, "", structure.name.empty() ? std::to_string(structure.number) : structure.name, "",
              brief(100 * share) + " % of its volume further than " + brief(far) + " mm from " +
                  std::to_string(patches.size()) + " planes"},
             "kept; its shape and volume may be wrong there: draw planes between"});
    }
}

}  // namespace anatomesh
