#include "anatomesh/field/planes/general_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/model/field_queries.h"
#include "anatomesh/field/planes/obliquity.h"
#include "anatomesh/field/slice/distance_map.h"
#include "anatomesh/field/slice/slice_regions.h"
#include "anatomesh/field/stack/caps.h"
#include "anatomesh/field/warnings/sparse_planes.h"
#include "anatomesh/field/warnings/thin_structures.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

constexpr std::uint32_t most_near = 16;  // patches that a query takes into account: the nearest
constexpr std::uint32_t no_structure = 0xffffffffu, no_patch = no_structure;
constexpr double most_widened = 3;          // times the usual, the radius within which patches count
constexpr double most_gap = 2;              // spacings: no end is told by wider ones
constexpr std::size_t few_listed = 6;       // patches, among which hidden ones cost nothing
constexpr double obliquity_cell = 1.0 / 6;  // of the grids of obliquity factors, a share of the clamp
constexpr double least_share = 0.01;        // of a patch that others hide: less is nothing
constexpr double fade_of_outside = 0.01;    // weight of outside at the radius
constexpr double never = -std::numeric_limits<double>::infinity();

// A patch with what its side of the sweep is: whether no other patch within the radius lies beyond it.
struct FieldPatch {
    PlanePatch patch;
    std::uint32_t first_map = 0, map_count = 0;
    bool open_below = false, open_above = false;
};

struct Key {
    double square;  // of the distance from the point
    std::uint32_t patch;
};
using Keys = std::array<Key, most_near>;

// What a patch says of a structure at a point.
struct PatchValue {
    double distance;   // signed, in the plane, less where the plane runs along the boundary
    double obliquity;  // of the boundary against the plane (obliquity.h)
};

// A patch as a point sees it.
struct SeenPatch {
    std::uint32_t patch;
    double distance;  // from the point
    double height;    // of the point above the plane
    double lateral;   // how far the point's projection lies beside the grown patch
    double share;     // of it that nearer patches leave
    double weight;    // infinite on the patch itself
    Vec3 offset;      // to the nearest point of the grown patch
    Vec2 at;          // the point's projection
};

// A patch that a cell of the grid lists.
struct Listed {
    std::uint32_t patch : 30;
    std::uint32_t before : 1;   // all points of the cell project into the grown patch
    std::uint32_t against : 1;  // its normal runs against that of the first that the cell lists
};

// The nearest patch on one side of a point.
struct Occluder {
    std::uint32_t patch = 0;
    double height = 0;  // of the point above its plane; 0 of none
    Vec3 normal;

    // Whether the way to another patch, `across` along its normal, leads through this one: its share would be
    // nothing.
    bool hides(std::uint32_t other, double across, const Vec3& n) const {
        return height != 0 && other != patch && -across * height * dot(n, normal) >= height * height;
    }
};

// A patch beside a cell of the grid, as the cell's centre sees it.
struct Beside {
    std::uint32_t patch;
    double height;    // of the centre above the plane
    double distance;  // of the centre above the patch's points, if above it, or below
    bool apart;       // the cell lies on one side of the patch, before it in full
};

// The patches that count at a point, nearest first.
struct PatchView {
    std::array<SeenPatch, most_near> near;  // the first `count`
    std::uint32_t count = 0;
    double outside = 0;  // weight of "outside"
    double beyond_end = never;
    double rounded_at = 0, rounded_radius = 0;  // height in a rounded end, and the radius; 0 elsewhere

    std::span<const SeenPatch> patches() const { return {near.data(), count}; }
};

class GeneralField final : public FieldQueries<GeneralField> {
  public:
    GeneralField(PlaneSpacings spacings, double least_reach, double margin, double clamp, bool partition,
                 EndCaps caps)
        : spacing_(spacings.median), margin_(margin), caps_(caps) {
        clamp_ = clamp;
        partition_ = partition;
        // Planes leave gaps of many times their spacing here and there: a point in one sees both of its
        // sides, however near to one of them it is, and is not beyond the end.
        const double usual = std::max({3 * spacings.wide, 2 * spacings.median, least_reach});
        radius_ = std::max(usual, std::min(2 * spacings.gap, most_widened * usual));
        // What is between two parts of a structure, or in its hole, is wider than any gap between planes.
        const double gap = radius_ > usual ? std::min(spacings.gap, most_gap * spacing_) : 0;
        end_spacing_ = std::max({spacing_, gap, least_reach});
        reach_ = std::max(spacings.wide, spacings.median);
    }

    double slice_spacing() const override { return spacing_; }
    Box3 box() const override { return box_; }
    Box3 box_of(std::uint32_t structure) const override { return boxes_[structure]; }
    bool slices_may_differ(Vec3 p, double radius) const override;

    static constexpr bool sides_cost_less = false;
    RawValue raw(std::uint32_t structure, Vec3 p, double /*reach*/) const {
        const PatchView sight = look(p);
        return {blend(structure, sight), sight.beyond_end};
    }
    double raw_union(Vec3 p, double /*reach*/) const { return blend(union_, look(p)); }

    template <class Body>
    void each_raw(Vec3 p, double /*reach*/, Body body) const {
        const PatchView sight = look(p);
        for (std::uint32_t s = next_structure(sight, 0); s != no_structure;
             s = next_structure(sight, s + 1)) {
            const double value = blend(s, sight);
            if (value < clamp_) body(s, RawValue{value, sight.beyond_end});
        }
    }

    // Without the slices that are left out, if any are.
    Status build(const ContourSet& set, std::vector<PlanePatch> patches, const std::vector<Box2>& frames,
                 const std::vector<bool>& left_out, RunContext& context);

  private:
    PatchView look(Vec3 p) const;
    // From a point of a patch's plane to the patch grown by the margin.
    Vec2 way_to_box(const PlanePatch& patch, Vec2 q) const {
        return {std::clamp(q.x, patch.box.low.x - margin_, patch.box.high.x + margin_) - q.x,
                std::clamp(q.y, patch.box.low.y - margin_, patch.box.high.y + margin_) - q.y};
    }
    std::array<Occluder, 2> occluders_at(Vec3 p, std::span<const Listed> listed, std::uint32_t but) const;
    std::uint32_t find_near(Vec3 p, Keys& keys, std::uint32_t but = no_patch) const;
    SeenPatch see(Vec3 p, const Key& key) const;
    double share_of(const SeenPatch& near, const PatchView& sight) const;
    void end(PatchView& sight) const;
    PatchValue said(std::uint32_t structure, const SeenPatch& near) const;
    double blend(std::uint32_t structure, const PatchView& sight) const;
    std::uint32_t next_structure(const PatchView& sight, std::uint32_t from) const;
    Status build_maps(const ContourSet& set, const std::vector<bool>& left_out, RunContext& context);
    void find_open_sides();
    bool is_before(Vec3 p, double reach, const PlanePatch& patch) const;
    bool is_hidden(const Beside& far, const Beside& near, double half) const;
    void drop_hidden(Vec3 center, double half, std::vector<std::uint32_t>& list,
                     std::vector<Beside>& scratch) const;
    void build_grid(int threads);
    void find_obliquity(RunContext& context);

    std::vector<FieldPatch> patches_;
    std::vector<std::optional<DistanceMap>> maps_;  // per patch in order of structure, the union last
    std::vector<std::uint32_t> structure_of_;
    std::uint32_t union_ = 0;
    ObliquityFactors obliquity_;
    double spacing_ = 0, margin_ = 0, radius_ = 0, reach_ = 0,
           end_spacing_ = 0;  // outside joins in half of it beyond the end
    EndCaps caps_;
    Box3 box_;
    std::vector<Box3> boxes_;  // by structure; empty of one that is not drawn
    // Cells over the box; each lists the patches within the radius of any of its points.
    double inverse_cell_ = 0;
    std::array<std::uint32_t, 3> cells_{};
    std::vector<std::uint32_t> cell_begin_;
    std::vector<Listed> cell_patches_;
};

// The nearest patch on either side of those before which p lies, but for one.
std::array<Occluder, 2> GeneralField::occluders_at(Vec3 p, std::span<const Listed> listed,
                                                   std::uint32_t but) const {
    std::array<Occluder, 2> occluders;
    for (const Listed& one : listed) {
        if (!one.before || one.patch == but) continue;
        const Plane& plane = patches_[one.patch].patch.plane;
        const double height = plane.signed_distance(p);
        Occluder& occluder = occluders[(height > 0) != (one.against == 1)];
        if (occluder.height == 0 || std::abs(height) < std::abs(occluder.height))
            occluder = {one.patch, height, plane.normal};
    }
    return occluders;
}

// The nearest patches within the radius, sorted by distance, but for one and most of those that nearer ones
// hide.
std::uint32_t GeneralField::find_near(Vec3 p, Keys& keys, std::uint32_t but) const {
    if (!box_.contains(p)) return 0;
    const Vec3 at = inverse_cell_ * (p - box_.low);
    const auto index = [](double v, std::uint32_t n) {
        return std::min(static_cast<std::uint32_t>(v), n - 1);
    };
    const std::size_t cell =
        (static_cast<std::size_t>(index(at.z, cells_[2])) * cells_[1] + index(at.y, cells_[1])) * cells_[0] +
        index(at.x, cells_[0]);
    const std::span<const Listed> listed{cell_patches_.data() + cell_begin_[cell],
                                         cell_patches_.data() + cell_begin_[cell + 1]};
    const std::array<Occluder, 2> occluders =
        listed.size() > few_listed ? occluders_at(p, listed, but) : std::array<Occluder, 2>{};
    std::uint32_t count = 0;
    double farthest = radius_ * radius_;
    for (const Listed& one : listed) {
        if (one.patch == but) continue;
        const PlanePatch& patch = patches_[one.patch].patch;
        const double height = patch.plane.signed_distance(p);
        const double across = std::clamp(height, patch.low, patch.high) - height;
        if (across * across >= farthest) continue;
        const auto is_hidden_by = [&](const Occluder& occluder) {
            return occluder.hides(one.patch, across, patch.plane.normal);
        };
        if (one.before && (is_hidden_by(occluders[0]) || is_hidden_by(occluders[1]))) continue;
        const Vec2 way = one.before ? Vec2{} : way_to_box(patch, patch.plane.to_plane(p));
        const double square = squared_length(way) + across * across;
        if (square >= farthest) continue;
        std::uint32_t place = count == most_near ? most_near - 1 : count++;
        for (; place > 0 && keys[place - 1].square > square; --place) keys[place] = keys[place - 1];
        keys[place] = {square, one.patch};
        if (count == most_near) farthest = keys[most_near - 1].square;
    }
    return count;
}

SeenPatch GeneralField::see(Vec3 p, const Key& key) const {
    const PlanePatch& patch = patches_[key.patch].patch;
    const double height = patch.plane.signed_distance(p);
    const double across = std::clamp(height, patch.low, patch.high) - height;
    const Vec2 foot = patch.plane.to_plane(p), way = way_to_box(patch, foot);
    const Vec3 offset = way.x * patch.plane.u + way.y * patch.plane.v + across * patch.plane.normal;
    return {key.patch, std::sqrt(key.square), height, length(way), 1, 0, offset, foot};
}

// How much of a patch the nearer ones in sight leave: the less the further the way to it leads through them;
// what they leave little of themselves hides as little, so that nothing changes at once where it is hidden.
double GeneralField::share_of(const SeenPatch& near, const PatchView& sight) const {
    double share = 1;
    for (std::uint32_t j = 0; j < sight.count && share > least_share; ++j) {
        const SeenPatch& nearer = sight.near[j];
        const double shown = 1 - nearer.lateral / margin_;
        if (shown <= 0) continue;
        const double square = nearer.height * nearer.height + nearer.lateral * nearer.lateral;
        const double along = dot(patches_[nearer.patch].patch.plane.normal, near.offset);
        // 1 where the way keeps to this side of the nearer patch, 0 where it ends on the patch or behind it.
        const double side = square > 0 ? std::clamp(1 + along * nearer.height / square, 0.0, 1.0) : 1.0;
        share *= 1 - nearer.share * shown * (1 - side);
    }
    return (share - least_share) / (1 - least_share);
}

// What lies beyond the end of the sweep. All patches on one side of the point: "outside" joins in like a
// patch half a spacing away; but beyond a patch that no other one lies behind, its region goes on for half a
// spacing, or not at all.
void GeneralField::end(PatchView& sight) const {
    sight.outside = fade_of_outside / radius_;
    if (sight.count == 0 || sight.near[0].distance == 0) {
        for (const SeenPatch& near : sight.patches()) {
            const FieldPatch& patch = patches_[near.patch];
            if (near.distance == 0 && caps_ == EndCaps::flat && (patch.open_below || patch.open_above))
                sight.beyond_end = 0;
        }
        return;
    }
    const double local = sight.count > 1 ? sight.near[1].distance - sight.near[0].distance : spacing_;
    const double half = caps_ == EndCaps::flat ? 0 : 0.5 * std::clamp(local, 0.5 * spacing_, 2 * reach_);
    for (const SeenPatch& near : sight.patches()) {
        const FieldPatch& patch = patches_[near.patch];
        if (near.lateral > 0) continue;
        if (patch.open_above) sight.beyond_end = std::max(sight.beyond_end, near.height - half);
        if (patch.open_below) sight.beyond_end = std::max(sight.beyond_end, -near.height - half);
    }
    const FieldPatch& first = patches_[sight.near[0].patch];
    const bool is_open = sight.near[0].height > 0 ? first.open_above : first.open_below;
    if (is_open && sight.near[0].lateral == 0) {
        if (caps_ == EndCaps::rounded) {
            sight.rounded_at = std::abs(sight.near[0].height);
            sight.rounded_radius = half;
        }
        return;
    }
    // Not by their weights: beside one patch that alone would count, however near the next one is behind the
    // point.
    double total = 0;
    Vec3 pull;
    for (const SeenPatch& near : sight.patches()) {
        total += near.weight * near.distance;
        pull += near.weight * near.offset;
    }
    const double one_sided = total > 0 ? length(pull) / total : 0;
    const double square = one_sided * one_sided, fourth = square * square;
    sight.outside += fourth * fourth * 2 / end_spacing_;
}

// Weights fall as 1 / distance, which between two parallel patches is linear interpolation. On a patch it
// alone counts, or those that cross there.
PatchView GeneralField::look(Vec3 p) const {
    PatchView sight;
    Keys keys;
    const std::uint32_t found = find_near(p, keys);
    const bool on_patch = found > 0 && keys[0].square == 0;
    for (std::uint32_t n = 0; n < found && (!on_patch || keys[n].square == 0); ++n) {
        SeenPatch& near = sight.near[sight.count];
        near = see(p, keys[n]);
        if (on_patch) {
            near.weight = std::numeric_limits<double>::infinity();
        } else {
            near.share = share_of(near, sight);
            if (near.share <= 0) continue;
            near.weight = near.share * (radius_ - near.distance) / (radius_ * near.distance);
        }
        ++sight.count;
    }
    end(sight);
    return sight;
}

PatchValue GeneralField::said(std::uint32_t structure, const SeenPatch& near) const {
    const FieldPatch& patch = patches_[near.patch];
    const double obliquity = obliquity_.at(near.patch, structure, near.at);
    for (std::uint32_t m = patch.first_map; m < patch.first_map + patch.map_count; ++m) {
        if (structure_of_[m] == structure) return {obliquity * maps_[m]->value(near.at), obliquity};
    }
    return {obliquity * clamp_, obliquity};
}

double GeneralField::blend(std::uint32_t structure, const PatchView& sight) const {
    const double soft = 0.5 * clamp_;
    double total = sight.outside / (soft + clamp_), sum = total * clamp_;
    double on_patch = std::numeric_limits<double>::infinity();
    for (const SeenPatch& near : sight.patches()) {
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
    return sight.rounded_radius > 0 ? rounded_end(value, sight.rounded_at, sight.rounded_radius) : value;
}

// The lowest structure from `from` on that a patch in sight draws.
std::uint32_t GeneralField::next_structure(const PatchView& sight, std::uint32_t from) const {
    std::uint32_t next = no_structure;
    for (const SeenPatch& near : sight.patches()) {
        const FieldPatch& patch = patches_[near.patch];
        for (std::uint32_t m = patch.first_map; m < patch.first_map + patch.map_count; ++m) {
            if (structure_of_[m] < from || structure_of_[m] == union_) continue;
            next = std::min(next, structure_of_[m]);
            break;
        }
    }
    return next;
}

bool GeneralField::slices_may_differ(Vec3 p, double radius) const {
    std::vector<std::uint32_t> first, inside;
    bool any = false;
    for (const FieldPatch& one : patches_) {
        if (one.map_count == 0) continue;
        const double reach = radius_ + radius;
        if (squared_length(one.patch.offset_from(p, margin_)) > reach * reach) continue;
        const Vec2 foot = one.patch.plane.to_plane(p);
        inside.clear();
        for (std::uint32_t m = one.first_map; m < one.first_map + one.map_count; ++m) {
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

Status GeneralField::build_maps(const ContourSet& set, const std::vector<bool>& left_out,
                                RunContext& context) {
    union_ = static_cast<std::uint32_t>(set.structures.size());
    std::vector<SliceRegion> jobs;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        if (!left_out.empty() && left_out[s]) continue;
        std::vector<SliceRegion> regions = slice_regions(set, s, set.slices[s].plane);
        if (partition_ && !regions.empty()) {
            std::vector<Edge2> boundary = union_boundary(regions);
            if (!boundary.empty()) regions.push_back({s, union_, std::move(boundary)});
        }
        patches_[s].first_map = static_cast<std::uint32_t>(jobs.size());
        patches_[s].map_count = static_cast<std::uint32_t>(regions.size());
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
                     ""};
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
void GeneralField::find_open_sides() {
    std::vector<std::array<Vec3, 4>> corners;
    std::vector<Vec3> centers;
    std::vector<double> radii;
    for (const FieldPatch& one : patches_) {
        const Box2& box = one.patch.box;
        const Plane& plane = one.patch.plane;
        corners.push_back({plane.to_space(box.low), plane.to_space({box.high.x, box.low.y}),
                           plane.to_space(box.high), plane.to_space({box.low.x, box.high.y})});
        centers.push_back(plane.to_space(0.5 * (box.low + box.high)));
        radii.push_back(0.5 * length(box.high - box.low));
    }
    const double rounding = 1e-9 * (1 + box_.diagonal());
    for (std::size_t i = 0; i < patches_.size(); ++i) {
        FieldPatch& one = patches_[i];
        if (one.map_count == 0) continue;
        one.open_below = one.open_above = true;
        for (std::size_t j = 0; j < patches_.size() && (one.open_below || one.open_above); ++j) {
            if (j == i || patches_[j].map_count == 0) continue;
            if (length(centers[i] - centers[j]) > radii[i] + radii[j] + radius_) continue;
            for (const Vec3& corner : corners[j]) {
                const double height = one.patch.plane.signed_distance(corner);
                if (height > one.patch.high + rounding) one.open_above = false;
                if (height < one.patch.low - rounding) one.open_below = false;
            }
        }
    }
}

// Whether for every point of a cell the way to the further patch leads through the nearer one: then its share
// is nothing (share_of), also where the nearer one is hidden itself. The heights are linear over the cell.
bool GeneralField::is_hidden(const Beside& far, const Beside& near, double half) const {
    const Vec3 m = patches_[near.patch].patch.plane.normal, n = patches_[far.patch].patch.plane.normal;
    const double along = dot(m, n);
    const Vec3 change = along * n - m;
    const double beyond = far.distance * along - near.height;
    return (near.height > 0 ? beyond : -beyond) >=
           half * (std::abs(change.x) + std::abs(change.y) + std::abs(change.z));
}

// Whether all points within `reach` of p project into the grown patch.
bool GeneralField::is_before(Vec3 p, double reach, const PlanePatch& patch) const {
    const Vec2 foot = patch.plane.to_plane(p);
    const double inside = std::min({foot.x - patch.box.low.x, patch.box.high.x - foot.x,
                                    foot.y - patch.box.low.y, patch.box.high.y - foot.y});
    return inside + margin_ >= reach;
}

// Leaves out those of a cell's patches that count nowhere in it.
void GeneralField::drop_hidden(Vec3 center, double half, std::vector<std::uint32_t>& list,
                               std::vector<Beside>& beside) const {
    constexpr std::size_t most_hiders = 4;
    std::array<Beside, most_hiders> occluders;
    std::size_t count = 0;
    const double diagonal = std::sqrt(3.0) * half;
    beside.clear();
    for (const std::uint32_t n : list) {
        const PlanePatch& patch = patches_[n].patch;
        const Vec3 normal = patch.plane.normal;
        const double height = patch.plane.signed_distance(center);
        const double distance =
            height - std::clamp(height, std::min(patch.low, 0.0), std::max(patch.high, 0.0));
        beside.push_back(
            {n, height, distance,
             is_before(center, diagonal, patch) &&
                 std::abs(distance) > half * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z))});
    }
    // The nearest hide most: the nearest of all, the nearest that it does not hide, and so on.
    std::size_t left = beside.size();
    while (count < most_hiders) {
        const Beside* nearest = nullptr;
        for (std::size_t n = 0; n < left; ++n) {
            const Beside& one = beside[n];
            if (one.apart && (!nearest || std::abs(one.distance) < std::abs(nearest->distance)))
                nearest = &one;
        }
        if (!nearest) break;
        const Beside occluder = occluders[count++] = *nearest;
        const auto kept = std::remove_if(
            beside.begin(), beside.begin() + static_cast<std::ptrdiff_t>(left), [&](const Beside& one) {
                return one.patch == occluder.patch || (one.apart && is_hidden(one, occluder, half));
            });
        left = static_cast<std::size_t>(kept - beside.begin());
    }
    list.clear();
    for (std::size_t n = 0; n < count; ++n) list.push_back(occluders[n].patch);
    for (std::size_t n = 0; n < left; ++n) list.push_back(beside[n].patch);
    std::sort(list.begin(), list.end());
}

// Blocks of cells keep the patches near them, their cells choose from these.
void GeneralField::build_grid(int threads) {
    constexpr double most_cells = 1 << 18;
    constexpr std::uint32_t block = 4;
    const Vec3 size = box_.high - box_.low;
    const double cell = std::max(0.5 * radius_, std::cbrt(size.x * size.y * size.z / most_cells));
    inverse_cell_ = 1 / cell;
    const std::array<double, 3> sizes{size.x, size.y, size.z};
    for (std::size_t a = 0; a < 3; ++a) cells_[a] = static_cast<std::uint32_t>(sizes[a] * inverse_cell_) + 1;
    const auto [nx, ny, nz] = cells_;
    const double half_diagonal = 0.5 * std::sqrt(3.0) * cell * (1 + 1e-9);
    const auto within = [&](Vec3 center, double reach, std::span<const std::uint32_t> from,
                            std::vector<std::uint32_t>& out) {
        for (const std::uint32_t n : from) {
            if (squared_length(patches_[n].patch.offset_from(center, margin_)) <= reach * reach)
                out.push_back(n);
        }
    };
    std::vector<std::uint32_t> all;
    for (std::uint32_t n = 0; n < patches_.size(); ++n) {
        if (patches_[n].map_count > 0) all.push_back(n);
    }
    const std::uint32_t bx = (nx + block - 1) / block, by = (ny + block - 1) / block;
    // A layer of cells a job.
    std::vector<std::vector<std::uint32_t>> counts(nz);
    std::vector<std::vector<Listed>> lists(nz);
    parallel_for(nz, block, threads, [&](std::size_t begin, std::size_t end) {
        std::vector<std::vector<std::uint32_t>> near(std::size_t{bx} * by);
        for (std::size_t b = 0; b < near.size(); ++b) {
            const double x = (static_cast<double>(b % bx) + 0.5) * block,
                         y = (static_cast<double>(b / bx) + 0.5) * block,
                         z = 0.5 * static_cast<double>(begin + end);
            within(box_.low + cell * Vec3{x, y, z}, radius_ + block * half_diagonal, all, near[b]);
        }
        std::vector<std::uint32_t> here;
        std::vector<Beside> scratch;
        for (std::size_t k = begin; k < end; ++k) {
            for (std::uint32_t j = 0; j < ny; ++j) {
                for (std::uint32_t i = 0; i < nx; ++i) {
                    const Vec3 center =
                        box_.low + cell * Vec3{i + 0.5, j + 0.5, static_cast<double>(k) + 0.5};
                    here.clear();
                    within(center, radius_ + half_diagonal, near[(j / block) * std::size_t{bx} + i / block],
                           here);
                    if (here.size() > few_listed) drop_hidden(center, 0.5 * cell * (1 + 1e-9), here, scratch);
                    for (const std::uint32_t n : here) {
                        const bool against =
                            dot(patches_[n].patch.plane.normal, patches_[here[0]].patch.plane.normal) < 0;
                        lists[k].push_back({n, is_before(center, half_diagonal, patches_[n].patch), against});
                    }
                    counts[k].push_back(static_cast<std::uint32_t>(here.size()));
                }
            }
        }
    });
    cell_begin_.assign(1, 0);
    for (std::uint32_t k = 0; k < nz; ++k) {
        for (const std::uint32_t count : counts[k]) cell_begin_.push_back(cell_begin_.back() + count);
        cell_patches_.insert(cell_patches_.end(), lists[k].begin(), lists[k].end());
    }
}

void GeneralField::find_obliquity(RunContext& context) {
    PatchesSeen seen{radius_, clamp_, obliquity_cell * clamp_, {}, {}, {}, {}};
    for (const FieldPatch& one : patches_) {
        seen.planes.push_back(one.patch.plane);
        seen.boxes.push_back(one.map_count > 0 ? one.patch.box.grown(margin_) : Box2{});
    }
    // A patch hides nothing from its own points.
    seen.near = [this](std::uint32_t own, Vec3 p, std::vector<PatchNear>& near) {
        Keys keys;
        const std::uint32_t count = find_near(p, keys, own);
        near.clear();
        for (std::uint32_t n = 0; n < count; ++n) near.push_back({keys[n].patch, std::sqrt(keys[n].square)});
    };
    seen.distances = [this](std::uint32_t n, Vec2 q, std::vector<DistanceInPlane>& distances) {
        const FieldPatch& patch = patches_[n];
        distances.clear();
        for (std::uint32_t m = patch.first_map; m < patch.first_map + patch.map_count; ++m) {
            const double value = maps_[m]->value(q);
            if (value < clamp_) distances.push_back({structure_of_[m], value});
        }
    };
    obliquity_ = ObliquityFactors::of(seen, context);
}

Status GeneralField::build(const ContourSet& set, std::vector<PlanePatch> patches,
                           const std::vector<Box2>& frames, const std::vector<bool>& left_out,
                           RunContext& context) {
    for (PlanePatch& patch : patches) patches_.push_back({std::move(patch), 0, 0, false, false});
    ANATOMESH_CHECK_STATUS(build_maps(set, left_out, context));
    box_ = set.box().grown(reach_);
    boxes_.resize(set.structures.size());
    for (const Contour& contour : set.contours) {
        for (const Vec3& p : set.points_of(contour)) boxes_[contour.structure].extend(p);
    }
    for (Box3& box : boxes_) {
        if (!box.empty()) box = box.grown(reach_);
    }
    // By what is drawn on them; from here on as far as they tell.
    find_open_sides();
    for (std::size_t s = 0; s < patches_.size(); ++s) patches_[s].patch.box = frames[s];
    build_grid(context.threads);
    find_obliquity(context);
    if (context.cancelled()) return cancelled_error();
    return Nothing{};
}

// Slices of a structure's own are further apart than all.
PlaneSpacings spacings_without(const ContourSet& set, const std::vector<bool>& left_out) {
    std::vector<std::uint32_t> others;
    for (std::uint32_t s = 0; s < left_out.size(); ++s) {
        if (!left_out[s]) others.push_back(s);
    }
    const ContourSet rest = chosen_slices(set, others);
    return plane_spacings(rest, plane_patches(rest));
}

// Where slices say nothing of a structure it has a field without them.
class PartlySaidField final : public FieldQueries<PartlySaidField> {
  public:
    // fields[of[s]] is that of structure s, fields[0] that of all slices.
    PartlySaidField(std::vector<std::shared_ptr<const GeneralField>> fields, std::vector<std::uint32_t> of)
        : fields_(std::move(fields)), of_(std::move(of)) {
        clamp_ = all().clamp();
        partition_ = all().exclusive();
    }

    double slice_spacing() const override { return all().slice_spacing(); }
    Box3 box() const override {
        Box3 whole;
        for (const auto& field : fields_) {
            whole.extend(field->box().low);
            whole.extend(field->box().high);
        }
        return whole;
    }
    Box3 box_of(std::uint32_t structure) const override { return fields_[of_[structure]]->box_of(structure); }
    bool slices_may_differ(Vec3 p, double radius) const override {
        return all().slices_may_differ(p, radius);
    }

    static constexpr bool sides_cost_less = false;
    RawValue raw(std::uint32_t structure, Vec3 p, double reach) const {
        return fields_[of_[structure]]->raw(structure, p, reach);
    }
    // With what the slices that draw it say of a structure beside what is drawn on the others.
    double raw_union(Vec3 p, double /*reach*/) const {
        double least = all().raw_union(p, everywhere);
        for (std::uint32_t s = 0; s < of_.size(); ++s) {
            if (of_[s] > 0) least = std::min(least, fields_[of_[s]]->raw(s, p, everywhere).value);
        }
        return least;
    }

    template <class Body>
    void each_raw(Vec3 p, double /*reach*/, Body body) const {
        std::uint32_t next = 0;
        const auto up_to = [&](std::uint32_t end) {
            for (; next < end; ++next) {
                if (of_[next] == 0) continue;
                const RawValue value = raw(next, p, everywhere);
                if (value.value < clamp_) body(next, value);
            }
        };
        all().each_raw(p, everywhere, [&](std::uint32_t s, RawValue value) {
            up_to(s);
            if (of_[s] == 0) body(s, value);
        });
        up_to(static_cast<std::uint32_t>(of_.size()));
    }

  private:
    const GeneralField& all() const { return *fields_.front(); }

    std::vector<std::shared_ptr<const GeneralField>> fields_;
    std::vector<std::uint32_t> of_;
};

}  // namespace

Result<std::shared_ptr<const StructureField>> make_general_field(const ContourSet& set,
                                                                 const SliceCoverage& coverage,
                                                                 const FieldOptions& options,
                                                                 RunContext& context) {
    std::vector<PlanePatch> patches = plane_patches(set);
    const PlaneSpacings spacings = plane_spacings(set, patches);
    const std::vector<Box2> frames = frames_of_slices(set, patches, spacings.median);
    // Where planes lie close, distances still reach as far as the vertices are apart: cells are no smaller.
    const double vertex_spacing = mean_vertex_spacing(set);
    const double reach = std::max(1.5 * spacings.median, vertex_spacing);
    const double clamp = options.clamp_mm > 0 ? options.clamp_mm : reach;
    std::vector<bool> used(set.structures.size(), false);
    for (const Contour& contour : set.contours) used[contour.structure] = true;
    const bool several = std::count(used.begin(), used.end(), true) > 1;
    // One field for all structures of which the same slices say nothing; the first for those of which all do.
    std::vector<std::vector<bool>> left_out(1);
    std::vector<std::uint32_t> field_of(set.structures.size(), 0);
    for (std::uint32_t s = 0; s < field_of.size(); ++s) {
        std::vector<bool> unknown_slices(set.slices.size());
        for (std::uint32_t k = 0; k < unknown_slices.size(); ++k)
            unknown_slices[k] = coverage.is_unknown(k, s);
        if (std::find(unknown_slices.begin(), unknown_slices.end(), true) == unknown_slices.end()) continue;
        const auto at = std::find(left_out.begin(), left_out.end(), unknown_slices);
        field_of[s] = static_cast<std::uint32_t>(at - left_out.begin());
        if (at == left_out.end()) left_out.push_back(std::move(unknown_slices));
    }
    std::vector<std::shared_ptr<const GeneralField>> fields;
    for (const std::vector<bool>& slices : left_out) {
        const PlaneSpacings own = slices.empty() ? spacings : spacings_without(set, slices);
        const double margin = options.plane_margin_mm > 0 ? options.plane_margin_mm : own.median;
        auto field = std::make_shared<GeneralField>(own, options.least_reach_mm, margin, clamp,
                                                    set.exclusive && several, options.caps);
        ANATOMESH_CHECK_STATUS(field->build(set, patches, frames, slices, context));
        fields.push_back(std::move(field));
    }
    warn_about_thin_structures(set, spacings.median, context);
    std::shared_ptr<const StructureField> field;
    if (fields.size() == 1)
        field = std::move(fields.front());
    else
        field = std::make_shared<PartlySaidField>(std::move(fields), std::move(field_of));
    warn_about_sparse_planes(set, *field, 0, context);
    return field;
}

}  // namespace anatomesh
