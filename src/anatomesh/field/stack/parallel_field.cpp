#include "anatomesh/field/stack/parallel_field.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <span>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/model/slice_groups.h"
#include "anatomesh/field/model/field_queries.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/field/motion/slice_motion.h"
#include "anatomesh/field/slice/distance_map.h"
#include "anatomesh/field/slice/slice_regions.h"
#include "anatomesh/field/stack/caps.h"
#include "anatomesh/field/stack/inside_share.h"
#include "anatomesh/field/stack/paraboloid_caps.h"
#include "anatomesh/field/stack/slice_knots.h"
#include "anatomesh/field/stack/stack_warnings.h"
#include "anatomesh/field/stack/structure_stack.h"
#include "anatomesh/field/stack/terminating_components.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/coverage/covering_slices.h"
#include "anatomesh/slices/coverage/few_slices.h"

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

class ParallelField final : public FieldQueries<ParallelField> {
  public:
    ParallelField(const Plane& frame, double spacing, double clamp, bool partition)
        : frame_(frame), spacing_(spacing) {
        clamp_ = clamp;
        partition_ = partition;
    }

    double slice_spacing() const override { return spacing_; }
    std::vector<Plane> flat_ends() const override {
        std::vector<double> heights;
        for (const StructureStack& structure_stack : structure_stacks_)
            structure_stack.add_flat_ends(heights);
        std::sort(heights.begin(), heights.end());
        std::vector<Plane> ends(heights.size(), frame_);
        for (std::size_t n = 0; n < ends.size(); ++n)
            ends[n].origin = frame_.origin + heights[n] * frame_.normal;
        return ends;
    }
    Box3 box() const override { return box_; }

    static constexpr bool sides_cost_less = true;
    RawValue raw(std::uint32_t structure, Vec3 p, double reach) const {
        assert(structure < structure_stacks_.size());
        return raw_at(structure, frame_.to_plane(p), frame_.signed_distance(p), reach);
    }

    double raw_union(Vec3 p, double reach) const {
        return union_.blend(maps_, clamp_, frame_.to_plane(p), frame_.signed_distance(p), reach);
    }

    template <class Body>
    void each_raw(Vec3 p, double reach, Body body) const {
        const double z = frame_.signed_distance(p);
        const double b = (z - low_) * inverse_bucket_;
        if (!(b >= 0) || b >= static_cast<double>(bucket_begin_.size() - 1)) return;
        const Vec2 q = frame_.to_plane(p);
        const auto bucket = static_cast<std::size_t>(b);
        for (std::uint32_t i = bucket_begin_[bucket]; i < bucket_begin_[bucket + 1]; ++i) {
            if (!near_[i].box.contains(q)) continue;
            const RawValue raw = raw_at(near_[i].structure, q, z, reach);
            if (raw.value < clamp_) body(near_[i].structure, raw);
        }
    }

    Result<std::vector<StructureVolume>> volumes(std::uint32_t count, const VolumeOptions& options,
                                                 RunContext& context) const override;

    // `few`: of the structures that are drawn on few slices.
    Status build(const ContourSet& set, const std::vector<SliceInterval>& intervals,
                 const std::vector<FewSlices>& few, const FieldOptions& options, RunContext& context);

  private:
    struct NearEntry {
        std::uint32_t structure;
        Box2 box;
    };

    RawValue raw_at(std::uint32_t structure, Vec2 q, double z, double reach) const {
        const StructureStack& structure_stack = structure_stacks_[structure];
        RawValue raw{clamp_, structure_stack.beyond_flat_cap(z)};
        raw.value =
            structure_stack.blend(maps_, clamp_, q, z, reach, partition_ ? &raw.to_own_half_gap : nullptr);
        return raw;
    }
    StructureVolume pair_volume(std::uint32_t structure, const StructureStack::Pair& pair, double points,
                                std::size_t layer) const;
    double inside_share(std::uint32_t structure, const StructureStack::Pair& pair, Vec2 q, double step) const;
    bool is_alone(std::uint32_t structure, const StructureStack::Pair& pair, Vec2 q) const;
    Status build_maps(const ContourSet& set, RunContext& context);
    Status find_motions(const ContourSet& set, RunContext& context);
    void add_terminations_to_union(std::size_t pair);
    void build_structure_stacks(const ContourSet& set, const std::vector<SliceInterval>& intervals,
                                const std::vector<FewSlices>& few, const FieldOptions& options,
                                RunContext& context);
    void build_near_table();
    void build_box();

    Plane frame_;
    double spacing_ = 0;
    Box3 box_;
    std::vector<std::optional<DistanceMap>> maps_;
    std::vector<std::uint32_t> slice_of_map_;
    std::vector<std::vector<std::int32_t>> map_of_;  // [structure][slice]; the union comes last
    std::vector<StructureStack> structure_stacks_;
    StructureStack union_;
    // Along the normal in buckets: the structures whose neighbourhood reaches into the bucket, rising.
    double low_ = 0, inverse_bucket_ = 0;
    std::vector<std::uint32_t> bucket_begin_;
    std::vector<NearEntry> near_;
};

Status ParallelField::build_maps(const ContourSet& set, RunContext& context) {
    std::vector<std::vector<SliceRegion>> regions(set.slices.size());
    parallel_for(set.slices.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) {
            regions[s] = slice_regions(set, static_cast<std::uint32_t>(s), frame_);
            if (partition_ && !regions[s].empty()) {
                const auto none = static_cast<std::uint32_t>(set.structures.size());
                std::vector<Edge2> boundary = union_boundary(regions[s]);
                if (!boundary.empty())
                    regions[s].push_back({regions[s].front().slice, none, std::move(boundary)});
            }
        }
    });
    map_of_.assign(set.structures.size() + 1, std::vector<std::int32_t>());
    std::vector<SliceRegion*> jobs;
    for (std::vector<SliceRegion>& slice : regions) {
        for (SliceRegion& region : slice) {
            std::vector<std::int32_t>& row = map_of_[region.structure];
            if (row.empty()) row.assign(set.slices.size(), empty_knot);
            row[region.slice] = static_cast<std::int32_t>(jobs.size());
            jobs.push_back(&region);
            slice_of_map_.push_back(region.slice);
        }
    }
    maps_.resize(jobs.size());
    parallel_for(jobs.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && !context.cancelled(); ++i) {
            maps_[i].emplace(std::move(jobs[i]->edges), clamp_);
        }
    });
    if (context.cancelled()) return cancelled_error();
    return Nothing{};
}

void ParallelField::build_structure_stacks(const ContourSet& set, const std::vector<SliceInterval>& intervals,
                                           const std::vector<FewSlices>& few, const FieldOptions& options,
                                           RunContext& context) {
    structure_stacks_.resize(set.structures.size());
    const auto knots_of = [&](std::uint32_t s, const std::vector<StructurePart>& parts) {
        std::vector<std::uint32_t> drawn;
        for (std::uint32_t i = 0; i < intervals.size(); ++i) {
            if (map_of_[s][intervals[i].slice] != empty_knot) drawn.push_back(i);
        }
        const bool is_union = s == set.structures.size();
        const bool every_slice = says_all(set) || options.every_slice_covers;
        const Plane& frame = set.slices.front().plane;
        GapEvidence evidence{heights_left_out(set, s, frame.origin, frame.normal), {}, parts, is_union};
        for (const std::uint32_t i : drawn) {
            if (!is_union && is_interpolated(set, intervals[i].slice, s)) evidence.interpolated.push_back(i);
        }
        evidence.thickness = thickness_of(few, s);
        return structure_knots(intervals, drawn, every_slice, spacing_, options, evidence);
    };
    // Where some have slices of their own, others may end where they go on.
    std::vector<StructurePart> parts;
    for (std::uint32_t s = 0; s < structure_stacks_.size() && set.exclusive && has_interpolated(set); ++s) {
        if (map_of_[s].empty()) continue;
        const std::vector<StructurePart> own = parts_of(knots_of(s, {}));
        parts.insert(parts.end(), own.begin(), own.end());
    }
    std::vector<double> made_mm(few.size(), 0.0);
    for (std::uint32_t s = 0; s < map_of_.size(); ++s) {
        if (map_of_[s].empty()) continue;
        StructureKnots knots = knots_of(s, parts);
        const bool is_union = s == set.structures.size();
        if (!is_union) warn_about_knots(set, s, knots, context);
        for (std::size_t n = 0; n < few.size(); ++n)
            if (few[n].structure == s) made_mm[n] = mean_thickness(knots);
        (is_union ? union_ : structure_stacks_[s]) =
            StructureStack(std::move(knots), map_of_[s], options.caps == EndCaps::rounded);
    }
    warn_about_few_slices(set, few, made_mm, context);
}

// What a structure of a partition ends with is part of the union, though there it touches others that go on.
void ParallelField::add_terminations_to_union(std::size_t i) {
    const StructureStack::Pair pair = union_.pair(i);
    if (pair.below == empty_knot || pair.above == empty_knot) return;
    for (const bool from_below : {true, false}) {
        const std::int32_t here = from_below ? pair.below : pair.above,
                           there = from_below ? pair.above : pair.below;
        const auto map = [&](std::int32_t m) {
            return m == empty_knot ? nullptr : &*maps_[static_cast<std::size_t>(m)];
        };
        const auto slice_of = [&](std::int32_t m) { return slice_of_map_[static_cast<std::size_t>(m)]; };
        for (std::size_t s = 0; s < structure_stacks_.size(); ++s) {
            if (map_of_[s].empty() || map_of_[s][slice_of(here)] == empty_knot) continue;
            union_.add_terminations(i,
                                    terminating_components_of_union(
                                        *map(map_of_[s][slice_of(here)]), map(map_of_[s][slice_of(there)]),
                                        *map(here), *map(there), pair.above_low - pair.below_high),
                                    from_below, clamp_);
        }
    }
}

Status ParallelField::find_motions(const ContourSet& set, RunContext& context) {
    std::vector<std::pair<StructureStack*, std::size_t>> jobs;
    const auto add = [&](StructureStack& structure_stack) {
        for (std::size_t i = 0; i < structure_stack.pair_count(); ++i) jobs.emplace_back(&structure_stack, i);
    };
    for (StructureStack& structure_stack : structure_stacks_) add(structure_stack);
    add(union_);
    parallel_for(jobs.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end && !context.cancelled(); ++j) {
            // In a partition a part ends where what it touches begins.
            jobs[j].first->find_terminations(jobs[j].second, maps_, clamp_, !partition_);
            if (jobs[j].first == &union_) add_terminations_to_union(jobs[j].second);
        }
    });
    parallel_for(jobs.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end && !context.cancelled(); ++j) {
            jobs[j].first->find_motion(jobs[j].second, maps_);
        }
    });
    if (context.cancelled()) return cancelled_error();
    warn_about_jumps(set, structure_stacks_, slice_of_map_, context);
    warn_about_ambiguities(set, structure_stacks_, slice_of_map_, frame_, context);
    return Nothing{};
}

// Buckets as fine as the knots lie; a structure is entered with the box of those maps that have a say there.
void ParallelField::build_near_table() {
    double high = -std::numeric_limits<double>::infinity();
    low_ = -high;
    std::size_t knots = 0;
    for (const StructureStack& structure_stack : structure_stacks_) {
        if (structure_stack.empty()) continue;
        low_ = std::min(low_, structure_stack.low());
        high = std::max(high, structure_stack.high());
        structure_stack.each_stretch([&](double, double, std::size_t, double) { ++knots; });
    }
    const std::size_t buckets = std::min<std::size_t>(2 * knots + 1, 4096);
    inverse_bucket_ = static_cast<double>(buckets) / (high - low_);
    std::vector<std::vector<NearEntry>> entries(buckets);
    const auto bucket_of = [&](double z) {
        return static_cast<std::size_t>(
            std::clamp((z - low_) * inverse_bucket_, 0.0, static_cast<double>(buckets - 1)));
    };
    for (std::uint32_t s = 0; s < structure_stacks_.size(); ++s) {
        structure_stacks_[s].each_stretch([&](double from, double to, std::size_t map, double move) {
            const Box2 box = maps_[map]->box().grown(move);
            for (std::size_t b = bucket_of(from); b <= bucket_of(to); ++b) {
                if (entries[b].empty() || entries[b].back().structure != s) entries[b].push_back({s, box});
                entries[b].back().box.extend(box.low);
                entries[b].back().box.extend(box.high);
            }
        });
    }
    bucket_begin_.assign(1, 0);
    for (const auto& list : entries) {
        near_.insert(near_.end(), list.begin(), list.end());
        bucket_begin_.push_back(static_cast<std::uint32_t>(near_.size()));
    }
}

void ParallelField::build_box() {
    for (const StructureStack& structure_stack : structure_stacks_) {
        structure_stack.each_stretch([&](double from, double to, std::size_t map, double move) {
            const Box2 region = maps_[map]->region_box().grown(move);
            for (const double z : {from, to}) {
                for (const Vec2 corner : {region.low, region.high, Vec2{region.low.x, region.high.y},
                                          Vec2{region.high.x, region.low.y}}) {
                    box_.extend(frame_.to_space(corner) + z * frame_.normal);
                }
            }
        });
    }
}

Status ParallelField::build(const ContourSet& set, const std::vector<SliceInterval>& intervals,
                            const std::vector<FewSlices>& few, const FieldOptions& options,
                            RunContext& context) {
    ANATOMESH_CHECK_STATUS(build_maps(set, context));
    if (maps_.empty()) {
        return Error{ErrorKind::geometry,
                     "E-FLD-002",
                     "no contour encloses an area",
                     {set.source, "", "", "", ""},
                     "check the contours; each needs three points or more and an area"};
    }
    build_structure_stacks(set, intervals, few, options, context);
    ANATOMESH_CHECK_STATUS(find_motions(set, context));
    build_near_table();
    build_box();
    return Nothing{};
}

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

double median_gap(const std::vector<SliceInterval>& intervals) {
    std::vector<double> gaps;
    for (std::size_t i = 1; i < intervals.size(); ++i)
        gaps.push_back(intervals[i].low - intervals[i - 1].high);
    gaps = gaps_between_groups(gaps);
    if (gaps.empty()) return 0;
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
    return gaps[gaps.size() / 2];
}

}  // namespace

Result<std::shared_ptr<const StructureField>> make_parallel_field(const ContourSet& set,
                                                                  const FieldOptions& options,
                                                                  RunContext& context) {
    const Plane& frame = set.slices.front().plane;
    const std::vector<SliceInterval> intervals = parallel_intervals(set, frame);
    assert(!intervals.empty());
    std::vector<FewSlices> few;
    if (options.knows_few_slices && !options.every_slice_covers && intervals.size() > 1)
        few = structures_on_few_slices(set, intervals, options.single_slice_mm);
    double spacing = median_gap(intervals);
    if (const double thickness = thickness_of_all(set, few); thickness > 0) spacing = thickness;
    if (spacing <= 0) spacing = options.single_slice_mm;
    if (spacing <= 0) spacing = set.slice_thickness_mm;
    if (spacing <= 0) {
        return Error{ErrorKind::geometry,
                     "E-FLD-003",
                     "there is a single slice, and nothing says how thick it is",
                     {set.source, set.slices.front().name, "", "", ""},
                     "give the thickness with --slice-thickness"};
    }
    std::vector<bool> used(set.structures.size(), false);
    for (const Contour& contour : set.contours) used[contour.structure] = true;
    const bool several = std::count(used.begin(), used.end(), true) > 1;
    const double clamp = options.clamp_mm > 0 ? options.clamp_mm : 1.5 * spacing;
    auto field = std::make_shared<ParallelField>(frame, spacing, clamp, set.exclusive && several);
    ANATOMESH_CHECK_STATUS(field->build(set, intervals, few, options, context));
    return std::shared_ptr<const StructureField>(std::move(field));
}

}  // namespace anatomesh
