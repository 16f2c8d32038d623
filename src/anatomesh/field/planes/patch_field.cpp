#include "anatomesh/field/planes/patch_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/field/slice/slice_regions.h"
#include "anatomesh/field/stack/caps.h"

namespace anatomesh {

namespace {

// Beside wide gaps patches count within so many usual radii at most, so that a point in a gap sees both sides
// and queries stay fast. [usual radii; >= 1; M 2026-11 42 freehand planes with gaps]
constexpr double most_widened = 3;
// No end is told by wider gaps: what lies between two parts, or in a hole, is no gap between planes.
// [spacings; >= 1; M 2026-11 torus by seven planes]
constexpr double most_gap = 2;
// Obliquity factors are found on cells of this size: they change no faster than distances do within the
// clamp. [clamps; 0 to 1; B]
constexpr double obliquity_cell = 1.0 / 6;
// Of a patch that others hide down to this share nothing is left: the search for occluders ends there.
// [1; 0 to 1; B]
constexpr double least_share = 0.01;
// Outside has so little weight at the radius that it decides only where no patch is heard. [1; 0 to 1; D]
constexpr double fade_of_outside = 0.01;

}  // namespace

PatchField::PatchField(const PatchFieldOptions& options)
    : spacing_(options.spacings.median), margin_(options.margin), caps_(options.caps) {
    clamp_ = options.clamp;
    partition_ = options.partition;
    const PlaneSpacings& spacings = options.spacings;
    // Planes leave gaps of many times their spacing here and there: a point in one sees both of its sides,
    // however near to one of them it is, and is not beyond the end.
    const double usual = std::max({3 * spacings.wide, 2 * spacings.median, options.least_reach});
    radius_ = std::max(usual, std::min(2 * spacings.gap, most_widened * usual));
    // What is between two parts of a structure, or in its hole, is wider than any gap between planes.
    const double gap = radius_ > usual ? std::min(spacings.gap, most_gap * spacing_) : 0;
    end_spacing_ = std::max({spacing_, gap, options.least_reach});
    reach_ = std::max(spacings.wide, spacings.median);
}

SeenPatch PatchField::see(Vec3 p, const PatchGrid::Key& key) const {
    const PlanePatch& patch = grid_.patch(key.patch);
    const double height = patch.plane.signed_distance(p);
    const double across = std::clamp(height, patch.low, patch.high) - height;
    const Vec2 foot = patch.plane.to_plane(p), way = grid_.way_to(patch, foot);
    const Vec3 offset = way.x * patch.plane.u + way.y * patch.plane.v + across * patch.plane.normal;
    return {key.patch, std::sqrt(key.square), height, length(way), 1, 0, offset, foot};
}

// How much of a patch the nearer ones in view leave: the less the further the way to it leads through them;
// what they leave little of themselves hides as little, so that nothing changes at once where it is hidden.
double PatchField::share_of(const SeenPatch& near, const PatchView& view) const {
    double share = 1;
    for (std::uint32_t j = 0; j < view.count && share > least_share; ++j) {
        const SeenPatch& nearer = view.near[j];
        const double shown = 1 - nearer.lateral / margin_;
        if (shown <= 0) continue;
        const double square = nearer.height * nearer.height + nearer.lateral * nearer.lateral;
        const double along = dot(grid_.patch(nearer.patch).plane.normal, near.offset);
        // 1 where the way keeps to this side of the nearer patch, 0 where it ends on the patch or behind it.
        const double side = square > 0 ? std::clamp(1 + along * nearer.height / square, 0.0, 1.0) : 1.0;
        share *= 1 - nearer.share * shown * (1 - side);
    }
    return (share - least_share) / (1 - least_share);
}

// What lies beyond the end of the sweep. All patches on one side of the point: "outside" joins in like a
// patch half a spacing away; but beyond a patch that no other one lies behind, its region goes on for half a
// spacing, or not at all.
void PatchField::end(PatchView& view) const {
    view.outside = fade_of_outside / radius_;
    if (view.count == 0 || view.near[0].distance == 0) {
        for (const SeenPatch& near : view.patches()) {
            const PatchMaps& patch = patches_[near.patch];
            if (near.distance == 0 && caps_ == EndCaps::flat && (patch.open_below || patch.open_above))
                view.beyond_flat_cap = 0;
        }
        return;
    }
    const double local = view.count > 1 ? view.near[1].distance - view.near[0].distance : spacing_;
    const double half = caps_ == EndCaps::flat ? 0 : 0.5 * std::clamp(local, 0.5 * spacing_, 2 * reach_);
    for (const SeenPatch& near : view.patches()) {
        const PatchMaps& patch = patches_[near.patch];
        if (near.lateral > 0) continue;
        if (patch.open_above) view.beyond_flat_cap = std::max(view.beyond_flat_cap, near.height - half);
        if (patch.open_below) view.beyond_flat_cap = std::max(view.beyond_flat_cap, -near.height - half);
    }
    const PatchMaps& first = patches_[view.near[0].patch];
    const bool is_open = view.near[0].height > 0 ? first.open_above : first.open_below;
    if (is_open && view.near[0].lateral == 0) {
        if (caps_ == EndCaps::rounded) {
            view.rounded_at = std::abs(view.near[0].height);
            view.rounded_radius = half;
        }
        return;
    }
    // Not by their weights: beside one patch that alone would count, however near the next one is behind the
    // point.
    double total = 0;
    Vec3 pull;
    for (const SeenPatch& near : view.patches()) {
        total += near.weight * near.distance;
        pull += near.weight * near.offset;
    }
    const double one_sided = total > 0 ? length(pull) / total : 0;
    const double square = one_sided * one_sided, fourth = square * square;
    view.outside += fourth * fourth * 2 / end_spacing_;
}

// Weights fall as 1 / distance, which between two parallel patches is linear interpolation. On a patch it
// alone counts, or those that cross there.
PatchView PatchField::look(Vec3 p) const {
    PatchView view;
    PatchGrid::Keys keys;
    const std::uint32_t found = grid_.find_near(p, keys);
    const bool on_patch = found > 0 && keys[0].square == 0;
    for (std::uint32_t n = 0; n < found && (!on_patch || keys[n].square == 0); ++n) {
        SeenPatch& near = view.near[view.count];
        near = see(p, keys[n]);
        if (on_patch) {
            near.weight = std::numeric_limits<double>::infinity();
        } else {
            near.share = share_of(near, view);
            if (near.share <= 0) continue;
            near.weight = near.share * (radius_ - near.distance) / (radius_ * near.distance);
        }
        ++view.count;
    }
    end(view);
    return view;
}

PatchValue PatchField::said(std::uint32_t structure, const SeenPatch& near) const {
    const PatchMaps& patch = patches_[near.patch];
    const double obliquity = obliquity_.at(near.patch, structure, near.at);
    for (std::uint32_t m = patch.first; m < patch.first + patch.count; ++m) {
        if (structure_of_[m] == structure) return {obliquity * maps_[m]->value(near.at), obliquity};
    }
    return {obliquity * clamp_, obliquity};
}

double PatchField::blend(std::uint32_t structure, const PatchView& view) const {
    const double soft = 0.5 * clamp_;
    double total = view.outside / (soft + clamp_), sum = total * clamp_;
    double on_patch = std::numeric_limits<double>::infinity();
    for (const SeenPatch& near : view.patches()) {
        const auto [d, obliquity] = said(structure, near);
        if (std::isfinite(near.weight)) {
            const double weight = near.weight * obliquity / (soft + std::abs(d));
            sum += weight * d;
            total += weight;
        } else if (std::abs(d) < std::abs(on_patch)) {
            on_patch = d;  // where planes cross, the boundary nearest to the point counts
        }
    }
    if (std::isfinite(on_patch)) return on_patch;
    const double value = sum / total;
    return view.rounded_radius > 0 ? rounded_end(value, view.rounded_at, view.rounded_radius) : value;
}

// The lowest structure from `from` on that a patch in view draws.
std::uint32_t PatchField::next_structure(const PatchView& view, std::uint32_t from) const {
    std::uint32_t next = no_structure;
    for (const SeenPatch& near : view.patches()) {
        const PatchMaps& patch = patches_[near.patch];
        for (std::uint32_t m = patch.first; m < patch.first + patch.count; ++m) {
            if (structure_of_[m] < from || structure_of_[m] == union_) continue;
            next = std::min(next, structure_of_[m]);
            break;
        }
    }
    return next;
}

bool PatchField::slices_may_differ(Vec3 p, double radius) const {
    std::vector<std::uint32_t> first, inside;
    bool any = false;
    for (std::uint32_t n = 0; n < patches_.size(); ++n) {
        const PatchMaps& one = patches_[n];
        if (one.count == 0) continue;
        const PlanePatch& patch = grid_.patch(n);
        const double reach = radius_ + radius;
        if (squared_length(patch.offset_from(p, margin_)) > reach * reach) continue;
        const Vec2 foot = patch.plane.to_plane(p);
        inside.clear();
        for (std::uint32_t m = one.first; m < one.first + one.count; ++m) {
            if (structure_of_[m] == union_) continue;
            const double value = maps_[m]->value(foot);  // no steeper than 1
            if (std::abs(value) <= radius) return true;
            if (value < 0) inside.push_back(structure_of_[m]);
        }
        if (!any) {
            first.swap(inside);
            any = true;
        } else if (inside != first) {
            return true;
        }
    }
    return false;
}

Status PatchField::build_maps(const ContourSet& set, const std::vector<std::uint32_t>& slices,
                              RunContext& context) {
    union_ = static_cast<std::uint32_t>(set.structures.size());
    std::vector<SliceRegion> jobs;
    for (const std::uint32_t s : slices) {
        std::vector<SliceRegion> regions = slice_regions(set, s, set.slices[s].plane);
        if (partition_ && !regions.empty()) {
            std::vector<Edge2> boundary = union_boundary(regions);
            if (!boundary.empty()) regions.push_back({s, union_, std::move(boundary)});
        }
        patches_[s].first = static_cast<std::uint32_t>(jobs.size());
        patches_[s].count = static_cast<std::uint32_t>(regions.size());
        for (SliceRegion& region : regions) {
            structure_of_.push_back(region.structure);
            jobs.push_back(std::move(region));
        }
    }
    if (jobs.empty()) {
        return Error{ErrorKind::geometry,
                     "E-FLD-002",
                     "no contour encloses an area",
                     {set.source, "", "", "", ""},
                     "check the contours; each needs three points or more and an area"};
    }
    maps_.resize(jobs.size());
    parallel_for(jobs.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && !context.cancelled(); ++i) {
            maps_[i].emplace(std::move(jobs[i].edges), clamp_);
        }
    });
    if (context.cancelled()) return cancelled_error();
    return Nothing{};
}

// A side of a patch is open when all patches within the radius keep to the other one.
void PatchField::find_open_sides(const std::vector<PlanePatch>& patches, const Box3& drawn) {
    std::vector<std::array<Vec3, 4>> corners;
    std::vector<Vec3> centers;
    std::vector<double> radii;
    for (const PlanePatch& one : patches) {
        const Box2& box = one.box;
        const Plane& plane = one.plane;
        corners.push_back({plane.to_space(box.low), plane.to_space({box.high.x, box.low.y}),
                           plane.to_space(box.high), plane.to_space({box.low.x, box.high.y})});
        centers.push_back(plane.to_space(0.5 * (box.low + box.high)));
        radii.push_back(0.5 * length(box.high - box.low));
    }
    const double rounding = 1e-9 * (1 + drawn.diagonal());
    for (std::size_t i = 0; i < patches_.size(); ++i) {
        PatchMaps& one = patches_[i];
        if (one.count == 0) continue;
        one.open_below = one.open_above = true;
        for (std::size_t j = 0; j < patches_.size() && (one.open_below || one.open_above); ++j) {
            if (j == i || patches_[j].count == 0) continue;
            if (length(centers[i] - centers[j]) > radii[i] + radii[j] + radius_) continue;
            for (const Vec3& corner : corners[j]) {
                const double height = patches[i].plane.signed_distance(corner);
                if (height > patches[i].high + rounding) one.open_above = false;
                if (height < patches[i].low - rounding) one.open_below = false;
            }
        }
    }
}

void PatchField::find_obliquity(RunContext& context) {
    PatchesSeen seen{radius_, clamp_, obliquity_cell * clamp_, {}, {}, {}, {}};
    for (std::uint32_t n = 0; n < patches_.size(); ++n) {
        seen.planes.push_back(grid_.patch(n).plane);
        seen.boxes.push_back(patches_[n].count > 0 ? grid_.patch(n).box.grown(margin_) : Box2{});
    }
    // A patch hides nothing from its own points.
    seen.near = [this](std::uint32_t own, Vec3 p, std::vector<PatchNear>& near) {
        PatchGrid::Keys keys;
        const std::uint32_t count = grid_.find_near(p, keys, own);
        near.clear();
        for (std::uint32_t n = 0; n < count; ++n) near.push_back({keys[n].patch, std::sqrt(keys[n].square)});
    };
    seen.distances = [this](std::uint32_t n, Vec2 q, std::vector<DistanceInPlane>& distances) {
        const PatchMaps& patch = patches_[n];
        distances.clear();
        for (std::uint32_t m = patch.first; m < patch.first + patch.count; ++m) {
            const double value = maps_[m]->value(q);
            if (value < clamp_) distances.push_back({structure_of_[m], value});
        }
    };
    obliquity_ = ObliquityFactors::of(seen, context);
}

Status PatchField::build(const ContourSet& set, std::vector<PlanePatch> patches,
                         const std::vector<Box2>& frames, const std::vector<std::uint32_t>& slices,
                         RunContext& context) {
    patches_.resize(patches.size());
    ANATOMESH_CHECK_STATUS(build_maps(set, slices, context));
    const Box3 box = set.box().grown(reach_);
    boxes_.resize(set.structures.size());
    for (const Contour& contour : set.contours) {
        for (const Vec3& p : set.points_of(contour)) boxes_[contour.structure].extend(p);
    }
    for (Box3& one : boxes_) {
        if (!one.empty()) one = one.grown(reach_);
    }
    // The sides go by what is drawn on the patches; from here on the patches are as large as they say something.
    find_open_sides(patches, box);
    std::vector<std::uint32_t> drawn;
    for (std::uint32_t n = 0; n < patches_.size(); ++n) {
        patches[n].box = frames[n];
        if (patches_[n].count > 0) drawn.push_back(n);
    }
    grid_ = PatchGrid(std::move(patches), drawn, box, radius_, margin_, context.threads);
    find_obliquity(context);
    if (context.cancelled()) return cancelled_error();
    return Nothing{};
}

}  // namespace anatomesh
