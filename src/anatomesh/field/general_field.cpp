#include "anatomesh/field/general_field.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "anatomesh/base/parallel.h"
#include "anatomesh/field/distance_map.h"
#include "anatomesh/field/field_queries.h"
#include "anatomesh/field/slice_regions.h"

namespace anatomesh {

namespace {

// The part of a plane on which its contours say something.
struct Patch {
    Plane plane;
    Box2 box;                  // of the contours
    double low = 0, high = 0;  // of the contour points along the normal: their deviations from the plane
    std::uint32_t first_map = 0, map_count = 0;
};

// The offset from p to the nearest point of the patch grown by `margin` in its plane.
Vec3 offset_to(const Patch& patch, double margin, Vec3 p) {
    const Vec2 q = patch.plane.to_plane(p);
    const double h = patch.plane.signed_distance(p);
    const double x = std::clamp(q.x, patch.box.low.x - margin, patch.box.high.x + margin) - q.x;
    const double y = std::clamp(q.y, patch.box.low.y - margin, patch.box.high.y + margin) - q.y;
    return x * patch.plane.u + y * patch.plane.v +
           (std::clamp(h, patch.low, patch.high) - h) * patch.plane.normal;
}

std::vector<Patch> patches_of(const ContourSet& set) {
    std::vector<Patch> patches;
    for (const Slice& slice : set.slices) {
        Patch patch{slice.plane, {}, 0, 0, 0, 0};
        for (const Contour& contour : set.contours_of(slice)) {
            for (const Vec3& point : set.points_of(contour)) {
                const double h = slice.plane.signed_distance(point);
                const bool first = patch.box.empty();
                patch.low = first ? h : std::min(patch.low, h);
                patch.high = first ? h : std::max(patch.high, h);
                patch.box.extend(slice.plane.to_plane(point));
            }
        }
        patches.push_back(patch);
    }
    return patches;
}

struct Spacings {
    double median, wide;  // wide: nine tenths of the places have a neighbour within it
};

// How far contour vertices are from the nearest plane that runs within 30 degrees of their own.
Spacings measure_spacings(const ContourSet& set, const std::vector<Patch>& patches) {
    constexpr double cos_30 = 0.866;
    const std::size_t samples = std::clamp<std::size_t>(4000 / (patches.size() + 1), 2, 16);
    std::vector<double> gaps;
    for (std::size_t i = 0; i < patches.size(); ++i) {
        std::vector<Vec3> points;
        for (const Contour& contour : set.contours_of(set.slices[i])) {
            const auto added = set.points_of(contour);
            points.insert(points.end(), added.begin(), added.end());
        }
        for (std::size_t sample = 0; sample < std::min(samples, points.size()); ++sample) {
            const Vec3 p = points[points.size() * sample / std::min(samples, points.size())];
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t j = 0; j < patches.size(); ++j) {
                if (j == i || patches[j].box.empty()) continue;
                if (std::abs(dot(patches[i].plane.normal, patches[j].plane.normal)) < cos_30) continue;
                nearest = std::min(nearest, length(offset_to(patches[j], 0, p)));
            }
            if (std::isfinite(nearest) && nearest > 0) gaps.push_back(nearest);
        }
    }
    if (gaps.empty()) {
        const double apart = set.box().diagonal() / static_cast<double>(patches.size() + 1);
        return {apart, apart};
    }
    std::sort(gaps.begin(), gaps.end());
    return {gaps[gaps.size() / 2], gaps[gaps.size() * 9 / 10]};
}

class GeneralField final : public FieldQueries<GeneralField> {
  public:
    GeneralField(std::vector<Patch> patches, Spacings spacings, double margin, double clamp, bool partition)
        : patches_(std::move(patches)), spacing_(spacings.median), margin_(margin) {
        clamp_ = clamp;
        partition_ = partition;
        radius_ = std::max(3 * spacings.wide, 2 * spacings.median);
    }

    double slice_spacing() const override { return spacing_; }
    Box3 box() const override { return box_; }

    RawValue raw(std::uint32_t structure, Vec3 p) const { return {blend(structure, weights(p))}; }
    double raw_union(Vec3 p) const { return blend(union_, weights(p)); }

    template <class Body>
    void each_raw(Vec3 p, Body body) const {
        const Weights near = weights(p);
        std::vector<std::uint32_t> structures;
        for (const Weighted& w : near.patches) {
            const Patch& patch = patches_[w.patch];
            for (std::uint32_t m = patch.first_map; m < patch.first_map + patch.map_count; ++m) {
                if (structure_of_[m] != union_) structures.push_back(structure_of_[m]);
            }
        }
        std::sort(structures.begin(), structures.end());
        structures.erase(std::unique(structures.begin(), structures.end()), structures.end());
        for (const std::uint32_t s : structures) {
            const double value = blend(s, near);
            if (value < clamp_) body(s, RawValue{value});
        }
    }

    Status build(const ContourSet& set, RunContext& context);

  private:
    struct Weighted {
        std::uint32_t patch;
        double weight;  // infinite on the patch itself
        Vec2 q;
    };
    struct Weights {
        std::vector<Weighted> patches;
        double outside = 0;
    };

    Weights weights(Vec3 p) const;
    double distance(std::uint32_t structure, const Weighted& weighted) const;
    double blend(std::uint32_t structure, const Weights& near) const;
    Status build_maps(const ContourSet& set, RunContext& context);
    void build_grid();

    std::vector<Patch> patches_;
    std::vector<std::optional<DistanceMap>> maps_;  // per patch in order of structure, the union last
    std::vector<std::uint32_t> structure_of_;
    std::uint32_t union_ = 0;
    double spacing_ = 0, margin_ = 0, radius_ = 0;
    Box3 box_;
    // Cells over the box; each lists the patches within the radius of any of its points.
    double inverse_cell_ = 0;
    std::array<std::uint32_t, 3> cells_{};
    std::vector<std::uint32_t> cell_begin_, cell_patches_;
};

GeneralField::Weights GeneralField::weights(Vec3 p) const {
    Weights near;
    if (!box_.contains(p)) return near;
    const Vec3 at = inverse_cell_ * (p - box_.low);
    const auto index = [](double v, std::uint32_t n) {
        return std::min(static_cast<std::uint32_t>(v), n - 1);
    };
    const std::size_t cell =
        (static_cast<std::size_t>(index(at.z, cells_[2])) * cells_[1] + index(at.y, cells_[1])) * cells_[0] +
        index(at.x, cells_[0]);
    double total = 0;
    Vec3 pull;
    for (std::uint32_t i = cell_begin_[cell]; i < cell_begin_[cell + 1]; ++i) {
        const Patch& patch = patches_[cell_patches_[i]];
        const Vec3 offset = offset_to(patch, margin_, p);
        const double r = length(offset);
        if (r >= radius_) continue;
        const double root = (radius_ - r) / (radius_ * r);
        const double weight = root * root;
        near.patches.push_back({cell_patches_[i], weight, patch.plane.to_plane(p)});
        if (!std::isfinite(weight)) continue;
        total += weight;
        pull += (weight / r) * offset;
    }
    // All patches on one side: beyond the end of the sweep, where outside weighs as much as a plane half a
    // spacing away. Patches on both sides: only enough to fade out at the radius.
    const double one_sided = total > 0 ? length(pull) / total : 0;
    const double square = one_sided * one_sided, fourth = square * square;
    near.outside = 4 / (spacing_ * spacing_) * fourth * fourth + 0.01 / (radius_ * radius_);
    return near;
}

double GeneralField::distance(std::uint32_t structure, const Weighted& weighted) const {
    const Patch& patch = patches_[weighted.patch];
    const auto first = structure_of_.begin() + patch.first_map, last = first + patch.map_count;
    const auto found = std::lower_bound(first, last, structure);
    if (found == last || *found != structure) return clamp_;
    return maps_[static_cast<std::size_t>(found - structure_of_.begin())]->value(weighted.q);
}

double GeneralField::blend(std::uint32_t structure, const Weights& near) const {
    double sum = near.outside * clamp_, total = near.outside;
    double on_patch = std::numeric_limits<double>::infinity();
    for (const Weighted& weighted : near.patches) {
        const double d = distance(structure, weighted);
        if (std::isfinite(weighted.weight)) {
            sum += weighted.weight * d;
            total += weighted.weight;
        } else if (std::abs(d) < std::abs(on_patch)) {
            on_patch = d;  // where planes cross, the boundary nearest to the point counts
        }
    }
    if (std::isfinite(on_patch)) return on_patch;
    return total > 0 ? sum / total : clamp_;
}

Status GeneralField::build_maps(const ContourSet& set, RunContext& context) {
    union_ = static_cast<std::uint32_t>(set.structures.size());
    std::vector<SliceRegion> jobs;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
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

void GeneralField::build_grid() {
    constexpr double most_cells = 1 << 18;
    const Vec3 size = box_.high - box_.low;
    const double cell = std::max(0.5 * radius_, std::cbrt(size.x * size.y * size.z / most_cells));
    inverse_cell_ = 1 / cell;
    const std::array<double, 3> sizes{size.x, size.y, size.z};
    for (std::size_t a = 0; a < 3; ++a) cells_[a] = static_cast<std::uint32_t>(sizes[a] * inverse_cell_) + 1;
    const double reach = radius_ + 0.5 * std::sqrt(3.0) * cell * (1 + 1e-9);
    cell_begin_.assign(1, 0);
    for (std::uint32_t k = 0; k < cells_[2]; ++k) {
        for (std::uint32_t j = 0; j < cells_[1]; ++j) {
            for (std::uint32_t i = 0; i < cells_[0]; ++i) {
                const Vec3 centre = box_.low + Vec3{(i + 0.5) * cell, (j + 0.5) * cell, (k + 0.5) * cell};
                for (std::uint32_t n = 0; n < patches_.size(); ++n) {
                    if (patches_[n].map_count == 0) continue;
                    if (squared_length(offset_to(patches_[n], margin_, centre)) <= reach * reach) {
                        cell_patches_.push_back(n);
                    }
                }
                cell_begin_.push_back(static_cast<std::uint32_t>(cell_patches_.size()));
            }
        }
    }
}

Status GeneralField::build(const ContourSet& set, RunContext& context) {
    ANATOMESH_CHECK_STATUS(build_maps(set, context));
    box_ = set.box().grown(radius_);
    build_grid();
    return Nothing{};
}

}  // namespace

Result<std::shared_ptr<const StructureField>> make_general_field(const ContourSet& set,
                                                                 const FieldOptions& options,
                                                                 RunContext& context) {
    std::vector<Patch> patches = patches_of(set);
    const Spacings spacings = measure_spacings(set, patches);
    const double clamp = options.clamp_mm > 0 ? options.clamp_mm : 1.5 * spacings.median;
    const double margin = options.plane_margin_mm > 0 ? options.plane_margin_mm : spacings.median;
    std::vector<bool> used(set.structures.size(), false);
    for (const Contour& contour : set.contours) used[contour.structure] = true;
    const bool several = std::count(used.begin(), used.end(), true) > 1;
    auto field =
        std::make_shared<GeneralField>(std::move(patches), spacings, margin, clamp, set.exclusive && several);
    ANATOMESH_CHECK_STATUS(field->build(set, context));
    return std::shared_ptr<const StructureField>(std::move(field));
}

}  // namespace anatomesh
