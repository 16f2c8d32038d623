#include "anatomesh/field/stack/parallel_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/model/slice_groups.h"
#include "anatomesh/field/motion/slice_motion.h"
#include "anatomesh/field/slice/distance_map.h"
#include "anatomesh/field/slice/slice_regions.h"
#include "anatomesh/field/stack/parallel_field_class.h"
#include "anatomesh/field/stack/stack_warnings.h"
#include "anatomesh/field/stack/terminating_components.h"
#include "anatomesh/slices/coverage/covering_slices.h"

namespace anatomesh {

// The map of the union of a slice whose structures all have their maps from one slice of an earlier field, each from
// itself: what ends beside the slice depends on who draws what. Null if they have not.
std::shared_ptr<const DistanceMap> ParallelField::earlier_union(
    const std::vector<SliceRegion>& regions, const std::vector<const EarlierMaps::Entry*>& entries) const {
    if (std::find(entries.begin(), entries.end(), nullptr) != entries.end()) return nullptr;
    // Equal outlines of several slices have one map, so that any of the structures may name the slice.
    for (const EarlierMaps::Entry* named_by : entries) {
        const ParallelField& field = *earlier_[named_by->field];
        const std::uint32_t slice = field.slice_of_map_[named_by->place];
        std::size_t n = 0;
        bool is_same = true;
        for (std::uint32_t s = 0; s + 1 < field.map_of_.size() && is_same; ++s) {
            if (field.map_of_[s].empty() || field.map_of_[s][slice] == empty_knot) continue;
            is_same = n < regions.size() && regions[n].structure == s &&
                      entries[n]->map == field.maps_[static_cast<std::size_t>(field.map_of_[s][slice])].get();
            ++n;
        }
        const std::vector<std::int32_t>& unions = field.map_of_.back();
        if (is_same && n == regions.size() && !unions.empty() && unions[slice] != empty_knot)
            return field.maps_[static_cast<std::size_t>(unions[slice])];
    }
    return nullptr;
}

Status ParallelField::build_maps(const ContourSet& set, RunContext& context) {
    struct Job {
        SliceRegion region;
        std::uint64_t fingerprint = 0;
        std::shared_ptr<const DistanceMap> map;
    };
    const auto none = static_cast<std::uint32_t>(set.structures.size());
    std::vector<std::vector<Job>> slices(set.slices.size());
    parallel_for(set.slices.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) {
            std::vector<SliceRegion> regions = slice_regions(set, static_cast<std::uint32_t>(s), frame_);
            std::vector<const EarlierMaps::Entry*> entries;
            for (const SliceRegion& region : regions) {
                const std::uint64_t fingerprint = fingerprint_of(region.edges);
                entries.push_back(earlier_maps_.find(fingerprint, region.edges, clamp_));
                slices[s].push_back({{region.slice, region.structure, {}}, fingerprint, nullptr});
                if (entries.back() != nullptr)
                    slices[s].back().map = earlier_[entries.back()->field]->maps_[entries.back()->place];
            }
            if (partition_ && !regions.empty()) {
                std::shared_ptr<const DistanceMap> same = earlier_union(regions, entries);
                std::vector<Edge2> boundary;
                if (!same) boundary = union_boundary(regions);
                if (same || !boundary.empty())
                    slices[s].push_back(
                        {{regions.front().slice, none, std::move(boundary)}, 0, std::move(same)});
            }
            for (std::size_t r = 0; r < regions.size(); ++r)
                slices[s][r].region.edges = std::move(regions[r].edges);
        }
    });
    map_of_.assign(set.structures.size() + 1, std::vector<std::int32_t>());
    std::vector<Job*> jobs;
    for (std::vector<Job>& slice : slices) {
        for (Job& job : slice) {
            const SliceRegion& region = job.region;
            std::vector<std::int32_t>& row = map_of_[region.structure];
            if (row.empty()) row.assign(set.slices.size(), empty_knot);
            row[region.slice] = static_cast<std::int32_t>(jobs.size());
            jobs.push_back(&job);
            slice_of_map_.push_back(region.slice);
            taken_from_earlier_.maps_taken += job.map != nullptr;
            fingerprints_.push_back(job.fingerprint);
        }
    }
    // Equal outlines, as of a copy on the next slice, have one map.
    std::vector<std::size_t> first_of(jobs.size());
    std::map<std::uint64_t, std::vector<std::size_t>> by_fingerprint;
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        first_of[i] = i;
        if (jobs[i]->map || jobs[i]->region.structure == none) continue;
        std::vector<std::size_t>& alike = by_fingerprint[jobs[i]->fingerprint];
        const auto same = std::find_if(alike.begin(), alike.end(), [&](std::size_t n) {
            return have_equal_bits(jobs[n]->region.edges, jobs[i]->region.edges);
        });
        if (same != alike.end()) {
            first_of[i] = *same;
        } else {
            alike.push_back(i);
        }
    }
    maps_.resize(jobs.size());
    taken_from_earlier_.maps = jobs.size();
    parallel_for(jobs.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && !context.cancelled(); ++i) {
            if (first_of[i] != i) continue;
            maps_[i] = jobs[i]->map
                           ? jobs[i]->map
                           : std::make_shared<const DistanceMap>(std::move(jobs[i]->region.edges), clamp_);
        }
    });
    if (context.cancelled()) return cancelled_error();
    for (std::size_t i = 0; i < maps_.size(); ++i) maps_[i] = maps_[first_of[i]];
    return Nothing{};
}

namespace {

// The fields of parallel slices among the parts of a field, or it itself.
std::vector<const ParallelField*> parallel_parts(const StructureField* whole) {
    std::vector<const ParallelField*> found;
    std::vector<const StructureField*> open;
    if (whole != nullptr) open.push_back(whole);
    while (!open.empty()) {
        const StructureField* field = open.back();
        open.pop_back();
        for (const StructureField* part : field->parts()) open.push_back(part);
        if (const auto* parallel = dynamic_cast<const ParallelField*>(field)) found.push_back(parallel);
    }
    return found;
}

}  // namespace

// Maps and gaps of fields made earlier by the same rules.
void ParallelField::look_at_earlier(const StructureField* earlier) {
    for (const ParallelField* field : parallel_parts(earlier)) {
        if (field->clamp_ == clamp_ && field->partition_ == partition_) earlier_.push_back(field);
    }
    std::vector<EarlierMaps::Entry> entries;
    for (std::uint32_t f = 0; f < earlier_.size(); ++f) {
        const ParallelField& field = *earlier_[f];
        for (std::uint32_t m = 0; m < field.maps_.size(); ++m) {
            if (field.map_of_.back().empty() ||
                field.map_of_.back()[field.slice_of_map_[m]] != static_cast<std::int32_t>(m))
                entries.push_back({field.fingerprints_[m], field.maps_[m].get(), f, m});
        }
    }
    earlier_maps_ = EarlierMaps(std::move(entries));
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

// The gaps of earlier fields, by the maps that they lie between.
std::vector<ParallelField::GapEntry> ParallelField::earlier_gaps() const {
    std::vector<GapEntry> gaps;
    for (const ParallelField* field : earlier_) {
        const auto add = [&](const StructureStack& stack) {
            for (std::size_t i = 0; i < stack.pair_count(); ++i) {
                const StructureStack::Pair pair = stack.pair(i);
                if (pair.below == empty_knot || pair.above == empty_knot) continue;
                gaps.push_back({field->maps_[static_cast<std::size_t>(pair.below)].get(),
                                field->maps_[static_cast<std::size_t>(pair.above)].get(),
                                {&stack, &field->maps_, i}});
            }
        };
        for (const StructureStack& stack : field->structure_stacks_) add(stack);
        add(field->union_);
    }
    std::stable_sort(gaps.begin(), gaps.end(),
                     [](const GapEntry& a, const GapEntry& b) { return before(a, b); });
    return gaps;
}

namespace {

// Whether the body says true of an earlier gap. Copied slices have many gaps between equal maps: those at the height of
// this one come first, so that gaps beside each other are taken from gaps beside each other.
template <class Entries, class Body>
bool any_nearest_first(const StructureStack& stack, std::size_t gap, const Entries& entries, Body body) {
    for (const bool at_its_height : {true, false}) {
        for (const auto& entry : entries) {
            if (stack.lies_at(gap, entry.gap) == at_its_height && body(entry)) return true;
        }
    }
    return false;
}

}  // namespace

Status ParallelField::find_motions(const ContourSet& set, RunContext& context) {
    struct Job {
        StructureStack* stack;
        std::size_t gap;
        bool is_drawn;  // on both sides
        std::span<const GapEntry> earlier = {};
        bool is_taken = false;
    };
    const std::vector<GapEntry> gaps = earlier_gaps();
    std::vector<Job> jobs;
    const auto add = [&](StructureStack& stack) {
        for (std::size_t i = 0; i < stack.pair_count(); ++i) {
            const StructureStack::Pair pair = stack.pair(i);
            Job job{&stack, i, pair.below != empty_knot && pair.above != empty_knot};
            if (job.is_drawn && !gaps.empty()) {
                const GapEntry key{maps_[static_cast<std::size_t>(pair.below)].get(),
                                   maps_[static_cast<std::size_t>(pair.above)].get(),
                                   {}};
                const auto [first, last] = std::equal_range(gaps.begin(), gaps.end(), key, before);
                job.earlier = std::span(first, last);
            }
            jobs.push_back(job);
        }
    };
    for (StructureStack& structure_stack : structure_stacks_) add(structure_stack);
    add(union_);
    parallel_for(jobs.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end && !context.cancelled(); ++j) {
            const Job& job = jobs[j];
            if (any_nearest_first(*job.stack, job.gap, job.earlier, [&](const GapEntry& entry) {
                    return job.stack->take_terminations(job.gap, maps_, entry.gap);
                }))
                continue;
            // In a partition a part ends where what it touches begins.
            job.stack->find_terminations(job.gap, maps_, clamp_, !partition_);
            if (job.stack == &union_) add_terminations_to_union(job.gap);
        }
    });
    parallel_for(jobs.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end && !context.cancelled(); ++j) {
            Job& job = jobs[j];
            job.is_taken = std::any_of(job.earlier.begin(), job.earlier.end(), [&](const GapEntry& entry) {
                return job.stack->take_motion(job.gap, maps_, entry.gap);
            });
            if (!job.is_taken) job.stack->find_motion(job.gap, maps_);
        }
    });
    if (context.cancelled()) return cancelled_error();
    for (const Job& job : jobs) {
        taken_from_earlier_.gaps += job.is_drawn;
        taken_from_earlier_.gaps_taken += job.is_taken;
    }
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
    look_at_earlier(options.earlier.get());
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
    earlier_.clear();
    earlier_maps_ = {};
    build_near_table();
    build_box();
    return Nothing{};
}

namespace {

// The clamp follows a spacing rounded to this, because vertices lie off oblique planes by rounding: else each edit of an
// outline would change the clamp, and no map of another slice could be taken over. [mm; 2^-30 to 2^-10; D rounding]
constexpr double spacing_grain_mm = 0x1p-20;

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

std::optional<std::vector<FieldStretch>> ParallelField::stretches_unlike(const ParallelField& other) const {
    const auto same = [](Vec3 a, Vec3 b) { return a == b; };
    if (!same(frame_.origin, other.frame_.origin) || !same(frame_.u, other.frame_.u) ||
        !same(frame_.v, other.frame_.v) || !same(frame_.normal, other.frame_.normal) ||
        clamp_ != other.clamp_ || partition_ != other.partition_ ||
        structure_stacks_.size() != other.structure_stacks_.size())
        return std::nullopt;
    std::vector<FieldStretch> unlike;
    const auto compare = [&](const StructureStack& here, const StructureStack& there) {
        here.add_unlike(maps_, there, other.maps_, unlike);
        there.add_unlike(other.maps_, here, maps_, unlike);
    };
    for (std::size_t s = 0; s < structure_stacks_.size(); ++s)
        compare(structure_stacks_[s], other.structure_stacks_[s]);
    compare(union_, other.union_);
    std::sort(unlike.begin(), unlike.end(),
              [](const FieldStretch& a, const FieldStretch& b) { return a.low < b.low; });
    std::vector<FieldStretch> merged;
    for (const FieldStretch& stretch : unlike) {
        if (!merged.empty() && stretch.low <= merged.back().high) {
            merged.back().high = std::max(merged.back().high, stretch.high);
        } else {
            merged.push_back(stretch);
        }
    }
    return merged;
}

std::optional<std::vector<FieldStretch>> stretches_unlike(const StructureField& field,
                                                          const StructureField& earlier) {
    const auto* here = dynamic_cast<const ParallelField*>(&field);
    const auto* there = dynamic_cast<const ParallelField*>(&earlier);
    if (here == nullptr || there == nullptr) return std::nullopt;
    return here->stretches_unlike(*there);
}

TakenFromEarlier taken_from_earlier(const StructureField& field) {
    TakenFromEarlier sum;
    for (const ParallelField* part : parallel_parts(&field)) {
        sum.maps += part->taken_from_earlier().maps;
        sum.maps_taken += part->taken_from_earlier().maps_taken;
        sum.gaps += part->taken_from_earlier().gaps;
        sum.gaps_taken += part->taken_from_earlier().gaps_taken;
    }
    return sum;
}

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
    const double rounded =
        std::max(spacing_grain_mm * std::round(spacing / spacing_grain_mm), spacing_grain_mm);
    const double clamp = options.clamp_mm > 0 ? options.clamp_mm : 1.5 * rounded;
    auto field = std::make_shared<ParallelField>(frame, spacing, clamp, set.exclusive && several);
    ANATOMESH_CHECK_STATUS(field->build(set, intervals, few, options, context));
    return std::shared_ptr<const StructureField>(std::move(field));
}

}  // namespace anatomesh
