#include "anatomesh/field/warnings/sparse_planes.h"

#include <algorithm>
#include <string>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/field/warnings/thin_structures.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

// A structure's box has so many lattice points a side, enough for the two shares that a warning goes by.
// [points; >= 8; B]
constexpr int lattice = 16;
// A place is far from what is drawn beyond this share of the structure's thickness.
// [thicknesses; 0 to 1; C W-FLD-008]
constexpr double far_share = 0.25;
// If more of the volume is far from what is drawn, the structure is poorly sampled.
// [1, of the volume; 0 to 1; C W-FLD-008]
constexpr double most_far_off = 0.1;
// Up to so many planes may lie at a narrow angle all together; of more, gaps between them are told
// (missing_slices.h). [planes; >= 2; M 2026-11 balls by two planes at 5 to 30 degrees]
constexpr std::size_t few_planes = 6;
// Planes that lean by less than 45 degrees are at a narrow angle: none tells how far the structure reaches
// across the others. [1, cosine; 0 to 1; D]
constexpr double cos_45 = 0.7071067811865476;
// A structure is a wafer that has less than this share of the volume of a body as thick across its planes as
// in them. [1; 0 to 1; M 2026-11 balls by two planes at 5 to 30 degrees]
constexpr double least_thickness = 0.4;

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

// Of lattice points, in a structure's box.
struct Inside {
    double volume = 0;   // mm^3
    double far_off = 0;  // share of it further than the bound from all patches
};

// `all`: also where nothing lies far off.
Inside count_inside(const StructureField& field, std::uint32_t structure,
                    const std::vector<PlanePatch>& patches, const Box3& box, double bound, bool all) {
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
    if (far_off == 0 && !all) return {};
    for (const Vec3& p : near) inside += field.value(structure, p) < 0;
    inside += far_off;
    return {inside * step.x * step.y * step.z, inside > 0 ? far_off / inside : 0};
}

bool are_at_narrow_angles(const std::vector<PlanePatch>& patches) {
    return std::all_of(patches.begin(), patches.end(), [&](const PlanePatch& a) {
        return std::all_of(patches.begin(), patches.end(), [&](const PlanePatch& b) {
            return std::abs(dot(a.plane.normal, b.plane.normal)) >= cos_45;
        });
    });
}

// The volume of a body as thick across its planes as it is in them: of a ball, 4/3 of its section's area
// times its radius, which is twice the area over the outline. Of the planes that draw a structure the
// largest.
double volume_as_thick(const ContourSet& set, std::uint32_t structure) {
    double largest = 0;
    for (const Slice& slice : set.slices) {
        double area = 0, outline = 0;
        for (const Contour& contour : set.contours_of(slice)) {
            if (contour.structure != structure) continue;
            std::vector<Vec2> ring;
            for (const Vec3& p : set.points_of(contour)) ring.push_back(slice.plane.to_plane(p));
            area += signed_area(ring);
            for (std::size_t n = 0; n < ring.size(); ++n)
                outline += length(ring[(n + 1) % ring.size()] - ring[n]);
        }
        if (area > 0) largest = std::max(largest, 4.0 / 3 * area * 2 * area / outline);
    }
    return largest;
}

}  // namespace

void warn_about_sparse_planes(const ContourSet& set, const StructureField& field,
                              std::span<const double> known_mm, RunContext& context) {
    const std::vector<double> thickness = mean_thicknesses(set);
    for (std::uint32_t s = 0; s < thickness.size(); ++s) {
        if (!(thickness[s] > 0) || context.cancelled()) continue;
        Box3 box;
        const std::vector<PlanePatch> patches = patches_of(set, s, box);
        const double far = std::max(far_share * thickness[s], known_mm[s]);
        const bool are_few = patches.size() <= few_planes && are_at_narrow_angles(patches);
        const Inside inside = count_inside(field, s, patches, box, far, are_few);
        const Structure& structure = set.structures[s];
        const std::string name = structure.name.empty() ? std::to_string(structure.number) : structure.name,
                          planes = std::to_string(patches.size()) + " planes";
        if (inside.far_off > most_far_off) {
            context.warn(
                {"W-FLD-008",
                 "the structure is poorly sampled: much of it is far from the planes that it is drawn on",
                 {set.source, "", name, "",
                  brief(100 * inside.far_off) + " % of its volume is further than " + brief(far) +
                      " mm from " + planes},
                 "its shape and volume may be wrong there; draw it on planes in between"});
            continue;
        }
        const double as_thick = are_few ? volume_as_thick(set, s) : 0;
        if (inside.volume >= least_thickness * as_thick) continue;
        context.warn({"W-FLD-008",
                      "the structure is poorly sampled: its planes are so close together that its extent "
                      "across them is unknown, "
                      "and it ends close to them",
                      {set.source, "", name, "",
                       brief(inside.volume) + " mm3 round " + planes +
                           "; a body as thick across them as in "
                           "them has about " +
                           brief(as_thick) + " mm3"},
                      "most of it may be missing; draw it on planes that cross these"});
    }
}

}  // namespace anatomesh
