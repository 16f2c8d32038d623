// StructureField: region and signed distance at any point in space, from the contours alone.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

struct VolumeOptions;
class StructureField;

enum class EndCaps : std::uint8_t {
    half,    // half a slice beyond the last contour: the volume a label map means
    flat,    // the structure ends at its last contour; a single-slice island still gets half
    rounded  // as half, its rim rounded by a quarter circle of half a slice
};

struct FieldOptions {
    EndCaps caps = EndCaps::half;
    // Distances in a slice are clamped to +-clamp; half of it is the softness of the blend between two
    // slices, so that the surface leaves a contour that has no counterpart in the next slice at a steep
    // angle. mm; 0: 1.5 slice spacings. Range 0 or [0.1, 100].
    double clamp_mm = 0;
    // Parallel slices: neighbouring contours of a structure further apart than this many local spacings are
    // not joined; the structure ends on both sides of the gap. Range [1, 1e6].
    double max_gap_spacings = default_max_gap;
    // Parallel slices: each says something of every structure, also of one that is drawn on single slices;
    // else one drawn on every n-th slice is told of by its own alone.
    bool every_slice_covers = false;
    // Parallel slices: how thick a slice is of a structure that is drawn on one or two of them alone. mm; 0: as
    // few_slices.h finds it; a set of one slice whose thickness nothing says is refused. [0, 1000]
    double single_slice_mm = 0;
    // Parallel slices: such a structure is as thick as few_slices.h finds it; else as its gaps are wide. A part of a
    // set may draw a structure on few slices that the whole draws on many.
    bool knows_few_slices = true;
    // Planes in any position: how far beyond its own contours a plane still says "outside". mm; 0: one
    // spacing.
    double plane_margin_mm = 0;
    // Planes in any position: how far off a plane says something at least, and how wide a gap between planes
    // is no end, however near to each other most planes are. mm; 0: by their spacing.
    double least_reach_mm = 0;
    // A field of nearly the same contours, or null. What lies on and between parallel slices that are the same, bit for
    // bit, is taken over from it. The values are the same without it; after one edit most of the time is saved.
    std::shared_ptr<const StructureField> earlier = nullptr;
};

// The volume of one structure, mm^3.
struct StructureVolume {
    double by_field = 0;   // integral of the field's cross-sections
    double by_slices = 0;  // plain slice integration, drawn area x half the gaps to both neighbours, same
                           // caps; not a number for planes that are not parallel
    // Of the difference, what lies between two drawn slices and no taper explains: beyond what areas between
    // these of a prism and of a cone would have there.
    double unexplained = 0;
};

// Immutable after make_structure_field(); all queries are const and thread-safe.
class StructureField {
  public:
    struct Near {
        std::uint32_t structure;
        double value;
    };

    // Signed distance-like value of one structure at p: negative inside, positive outside, zero on its
    // surface; exactly the sign of the drawn region on every slice plane, exactly zero at every contour
    // vertex. |value| is a distance only near the surface; it never exceeds clamp(). For an exclusive contour
    // set at most one structure is negative at p, and no gaps are left between structures that share a wall.
    // O(1) for parallel slices apart from the nearest few contour segments.
    virtual double value(std::uint32_t structure, Vec3 p) const = 0;

    // value() where that lies within +-reach; elsewhere a number of the same sign beyond it, which may cost
    // less. With a reach of 0: the side.
    virtual double value_within(std::uint32_t structure, Vec3 p, double /*reach*/) const {
        return value(structure, p);
    }

    // Values of all structures whose neighbourhood holds p are appended to `near` as (structure, value), in
    // order of structure; structures not listed are outside by at least half the clamp.
    virtual void values_near(Vec3 p, std::vector<Near>& near) const = 0;

    // The structures that p lies in, in order, replace `out`: its region. Those with value < 0; for an
    // exclusive set at most one: the nearest, and the lowest index where several are equally near and outside
    // is farther.
    virtual void members(Vec3 p, std::vector<std::uint32_t>& out) const = 0;

    // Distance-like value whose zero set is the union of all interfaces: how far p is from the nearest change
    // of region, in [0, clamp()].
    virtual double interface_distance(Vec3 p) const = 0;

    // Whether structures exclude each other: then there is one surface more, that of all of them together,
    // on which outside begins.
    virtual bool exclusive() const { return false; }

    // The value of the union of all structures: that of the surface on which outside begins.
    virtual double union_value(Vec3 p) const = 0;

    // members() and interface_distance() at once, at about the price of one.
    virtual double members_and_distance(Vec3 p, std::vector<std::uint32_t>& out) const {
        members(p, out);
        return interface_distance(p);
    }

    // Planes of last contours in which structures end flat (EndCaps::flat), of slices that are parallel or a
    // sweep; some may be there twice.
    virtual std::vector<Plane> flat_ends() const { return {}; }

    virtual double slice_spacing() const = 0;  // mm between neighbouring slices (median); > 0
    virtual double clamp() const = 0;          // mm
    virtual Box3 box() const = 0;              // holds every point with a region other than outside
    virtual Box3 box_of(std::uint32_t /*structure*/) const { return box(); }  // and every point of this one

    // The fields that it is put together from; none where it is made of slices itself.
    virtual std::vector<const StructureField*> parts() const { return {}; }

    // Whether slices that count within `radius` of p may draw more than one region there: false only where
    // all of them agree on a disc of that radius.
    virtual bool slices_may_differ(Vec3 /*p*/, double /*radius*/) const { return true; }

    // Volume of structures 0 .. count - 1. See volume.h, through which it is called.
    virtual Result<std::vector<StructureVolume>> volumes(std::uint32_t count, const VolumeOptions& options,
                                                         RunContext& context) const;
    virtual ~StructureField() = default;
};

}  // namespace anatomesh
