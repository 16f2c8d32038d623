// The volume of structures on parallel slices.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "anatomesh/base/parallel.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/field/stack/caps.h"
#include "anatomesh/field/stack/inside_share.h"
#include "anatomesh/field/stack/paraboloid_caps.h"
#include "anatomesh/field/stack/parallel_field_class.h"

namespace anatomesh {

namespace {

// A column through a larger correction is integrated in twice as many parts, because its boundary bends
// within a gap. [gaps; > 0; B]
constexpr double much_curved = 0.05;
// Where outlines are aligned, a column is integrated in at least a part for each such stretch that the boundary
// moves, for it may enter and leave an oblique tube within one. [gaps; > 0; M 2026-11 oblique tubes]
constexpr double moved_in_a_part = 0.25;
// In no more parts than this. [parts; a power of two, >= 8; B]
constexpr std::size_t most_parts = 64;

}  // namespace

// Whether no other structure reaches the column over q between two knots.
bool ParallelField::is_alone(std::uint32_t structure, const StructureStack::Pair& pair, Vec2 q) const {
    const double last = static_cast<double>(bucket_begin_.size() - 2);
    const auto from =
        static_cast<std::size_t>(std::clamp((pair.below_high - low_) * inverse_bucket_, 0.0, last));
    const auto to =
        static_cast<std::size_t>(std::clamp((pair.above_low - low_) * inverse_bucket_, 0.0, last));
    return std::none_of(
        near_.begin() + bucket_begin_[from], near_.begin() + bucket_begin_[to + 1],
        [&](const NearEntry& entry) { return entry.structure != structure && entry.box.contains(q); });
}

// The share of the column over q between two knots that is inside, less what slice integration gives it: a
// half for each knot on which q is inside. The column is `step` wide, the lattice's.
double ParallelField::inside_share(std::uint32_t structure, const StructureStack::Pair& pair, Vec2 q,
                                   double step) const {
    const auto distance = [&](std::int32_t map) {
        return map == empty_knot ? clamp_ : maps_[static_cast<std::size_t>(map)]->value(q);
    };
    const double a = distance(pair.below), b = distance(pair.above);
    const double rest_a = pair.rest[0] ? pair.rest[0]->value(q) : a,
                 rest_b = pair.rest[1] ? pair.rest[1]->value(q) : b;
    // Where the boundary is further away on both knots than it moves and curves between them, nothing changes.
    const double nearest = std::min(std::abs(a), std::abs(b));
    const bool alike =
        (a < 0) == (b < 0) && (a < 0) == (rest_a < 0) && (b < 0) == (rest_b < 0) && (a < 0 || !partition_);
    if (alike && nearest > 0.99 * clamp_) return 0;
    const double gap = pair.above_low - pair.below_high;
    const SliceMotion::Path path = pair.motion->at(q, 0.5);
    const double move = std::min(2 * length(path.move), pair.motion->max_move());
    const double correction = std::min({2 * SliceMotion::largest_correction(path),
                                        pair.motion->max_correction(), 10 * most_correction * gap});
    // Neighbours share what is between them by counted sections, so there a column is a line.
    const Strip column{partition_ || pair.below == empty_knot || pair.above == empty_knot ? 0 : step};
    if (alike && nearest > move + correction + 0.5 * column.width) return 0;
    const double by_slices = 0.5 * (column.inside(a) + column.inside(b));
    if (!partition_ || is_alone(structure, pair, q)) {
        if (pair.below == empty_knot || pair.above == empty_knot)
            return pair.rounded ? rounded_height(std::min(a, b), 0.5 * gap) / gap - by_slices : 0;
        const Vec3 foot = frame_.to_space(q) + pair.below_high * frame_.normal;
        std::array<double, most_parts + 1> values{rest_a};
        std::size_t parts = correction > much_curved * gap ? 8 : 4;
        while (pair.motion->is_aligned() && parts < most_parts &&
               length(path.move) > moved_in_a_part * gap * static_cast<double>(parts))
            parts *= 2;
        for (std::size_t k = 1; k < parts; ++k) {
            const double z = static_cast<double>(k) * gap / static_cast<double>(parts);
            const Vec3 p = foot + z * frame_.normal;
            values[k] = structure_stacks_[structure].blend(
                maps_, clamp_, frame_.to_plane(p), frame_.signed_distance(p), everywhere, nullptr, false);
        }
        values[parts] = rest_b;
        std::array<double, 2> halves = inside_halves(column, std::span(values).first(parts + 1));
        for (const bool is_void : {true, false}) {
            for (const Termination& lone : *pair.terminations) {
                if (lone.is_void != is_void || !lone.box.contains(q)) continue;
                const double d = lone.map.value(q);
                const std::array<double, 2> parts_of = lone.filled(d, gap, pair.rounded, column.inside(d));
                for (const std::size_t n : {0u, 1u}) {
                    double& half = halves[lone.from_below ? n : 1 - n];
                    half = is_void ? std::min(half, 1 - parts_of[n]) : std::max(half, parts_of[n]);
                }
            }
        }
        return 0.5 * (halves[0] + halves[1]) - by_slices;
    }
    if (std::min(a, b) > 0.25 * clamp_ + move + correction)
        return 0;  // what others leave between them is thinner
    // What structures keep between two slices is counted on so many sections of the gap. [sections; >= 1; B]
    constexpr int sections = 12;
    int inside = 0;
    std::vector<std::uint32_t> owners;
    const Vec3 foot = frame_.to_space(q);
    for (int k = 0; k < sections; ++k) {
        const double z = pair.below_high + (k + 0.5) / sections * gap;
        members(foot + z * frame_.normal, owners);
        inside += !owners.empty() && owners.front() == structure;
    }
    return static_cast<double>(inside) / sections - by_slices;
}

StructureVolume ParallelField::pair_volume(std::uint32_t structure, const StructureStack::Pair& pair,
                                           double points, std::size_t layer) const {
    const double gap = pair.above_low - pair.below_high;
    if (structure_stacks_[structure].beyond_flat_cap(0.5 * (pair.below_high + pair.above_low)) > 0) return {};
    double area = 0, thickness = 0;
    Box2 box;
    for (const std::int32_t map : {pair.below, pair.above}) {
        if (map == empty_knot) continue;
        const DistanceMap& drawn = *maps_[static_cast<std::size_t>(map)];
        area += 0.5 * drawn.area();
        box.extend(drawn.region_box().low);
        box.extend(drawn.region_box().high);
        if (map == pair.below) thickness = drawn.area() * (pair.below_high - pair.below_low);
    }
    StructureVolume volume{gap * area + thickness, gap * area + thickness};
    const bool is_prism = !pair.rounded && (pair.below == empty_knot || pair.above == empty_knot);
    if (box.empty() || (!partition_ && is_prism)) return volume;
    box = box.grown(pair.motion->max_move() +
                    std::min(pair.motion->max_correction(), 10 * most_correction * gap) +
                    (partition_ ? 0.25 * clamp_ : 0));
    const double correction = lattice_integral(
        box, points, layer, [&](Vec2 q, double step) { return inside_share(structure, pair, q, step); });
    volume.by_field += gap * correction;
    if (pair.below != empty_knot && pair.above != empty_knot) {
        const auto drawn = [&](std::int32_t map) { return maps_[static_cast<std::size_t>(map)]->area(); };
        const double taper = std::sqrt(drawn(pair.below)) - std::sqrt(drawn(pair.above));
        volume.unexplained = gap * (correction - std::clamp(correction, -taper * taper / 6, 0.0));
    }
    return volume;
}

Result<std::vector<StructureVolume>> ParallelField::volumes(std::uint32_t count, const VolumeOptions& options,
                                                            RunContext& context) const {
    struct Job {
        std::uint32_t structure;
        StructureStack::Pair pair;
        StructureVolume volume;
    };
    std::vector<Job> jobs;
    for (std::uint32_t s = 0; s < std::min<std::size_t>(count, structure_stacks_.size()); ++s) {
        for (std::size_t i = 0; i < structure_stacks_[s].pair_count(); ++i)
            jobs.push_back({s, structure_stacks_[s].pair(i), {}});
    }
    const double points =
        std::min<double>(options.points_per_slab,
                         std::max(4000.0, options.points_in_slabs / static_cast<double>(jobs.size() + 1)));
    parallel_for(jobs.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end && !context.cancelled(); ++j) {
            jobs[j].volume = pair_volume(jobs[j].structure, jobs[j].pair, points, j);
        }
    });
    if (context.cancelled()) return cancelled_error();
    std::vector<StructureVolume> totals(count);
    for (const Job& job : jobs) {
        totals[job.structure].by_field += job.volume.by_field;
        totals[job.structure].by_slices += job.volume.by_slices;
        totals[job.structure].unexplained += job.volume.unexplained;
    }
    return totals;
}

}  // namespace anatomesh
