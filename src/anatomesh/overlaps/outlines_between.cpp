#include "anatomesh/overlaps/outlines_between.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/contour/simplify/simplify.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/planes/plane_trace.h"
#include "anatomesh/field/stack/slice_knots.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/coverage/covering_slices.h"
#include "anatomesh/slices/coverage/few_slices.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

namespace {

// A step of the lattice is at most this share of the mean distance of drawn vertices.
// [1; 0 to 1; M 2026-11 random solids]
constexpr double lattice_share = 0.5;
// It is also at most this share of the mean length of a contour, which may have few vertices.
// [1; 0 to 1; M 2026-11 random solids]
constexpr double contour_share = 1.0 / 96;
// Vertices are left out where the outline moves by this share of a step at most.
// [1; 0 to 1; M 2026-11 48 drawings of organs and lesions]
constexpr double most_moved_steps = 0.05;

// Returns the set as if a missing contour did not mean that a structure is absent.
ContourSet not_exclusive(ContourSet set) {
    set.exclusive = false;
    set.overlapping = nullptr;
    return set;
}

// Finds the slices between the structure's own that say nothing of it.
std::vector<std::uint32_t> find_unknown_slices(const ContourSet& set, std::uint32_t structure,
                                               const SliceCoverage& coverage) {
    std::vector<std::uint32_t> drawn, unknown_slices;
    for (const Contour& contour : set.contours) {
        if (contour.structure == structure) drawn.push_back(contour.slice);
    }
    if (drawn.empty()) return unknown_slices;
    const auto [first, last] = std::minmax_element(drawn.begin(), drawn.end());
    for (std::uint32_t k = *first; k < *last; ++k) {
        if (coverage.is_unknown(k, structure)) unknown_slices.push_back(k);
    }
    return unknown_slices;
}

bool has_unknown_slices(const ContourSet& set) {
    if (!set.drawn || !set.exclusive) return false;
    const ContourSet plain = not_exclusive(set);
    const SliceArrangement arrangement = arrangement_of(plain);
    if (!arrangement.is_parallel()) return false;
    RunContext context;
    const SliceCoverage coverage = coverage_of(plain, arrangement, context);
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        if (!find_unknown_slices(plain, s, coverage).empty()) return true;
    }
    return false;
}

// Returns whether a structure of a level goes on through slices that draw only a structure after it in the
// order. There it would cut what is drawn.
bool cuts_what_is_drawn(const OverlappingContours& all, std::size_t level) {
    const ContourSet plain = not_exclusive(all.levels[level]);
    if (!plain.drawn) return false;
    // A level is another set than the whole: some of its slices.
    const SliceArrangement arrangement = arrangement_of(plain);
    if (!arrangement.is_parallel()) return false;
    RunContext context;
    const SliceCoverage coverage = coverage_of(plain, arrangement, context);
    const auto rank = [&](std::int32_t number) {
        return std::find(all.order.begin(), all.order.end(), number) - all.order.begin();
    };
    // These are slices of the whole set, with the numbers of what they draw in other levels.
    std::map<std::uint32_t, std::vector<std::int32_t>> drawn;
    for (std::size_t n = 0; n < all.levels.size(); ++n) {
        for (const Contour& contour : all.levels[n].contours) {
            if (n != level)
                drawn[all.slices[n][contour.slice]].push_back(
                    all.levels[n].structures[contour.structure].number);
        }
    }
    for (std::uint32_t s = 0; s < plain.structures.size(); ++s) {
        const auto own = rank(plain.structures[s].number);
        for (const std::uint32_t k : find_unknown_slices(plain, s, coverage)) {
            const std::vector<std::int32_t>& others = drawn[all.slices[level][k]];
            if (std::any_of(others.begin(), others.end(),
                            [&](std::int32_t other) { return own < rank(other); }))
                return true;
        }
    }
    return false;
}

bool lacks_outlines(const ContourSet& kept) {
    if (!kept.overlapping) return has_unknown_slices(kept);
    for (std::size_t n = 0; n < kept.overlapping->levels.size(); ++n) {
        if (has_unknown_slices(kept.overlapping->levels[n]) || cuts_what_is_drawn(*kept.overlapping, n))
            return true;
    }
    return false;
}

double lattice_step(const ContourSet& set) {
    const double edge = mean_vertex_spacing(set);
    const auto points = static_cast<double>(set.points.size()),
               contours = static_cast<double>(set.contours.size());
    return std::min(lattice_share * edge, contour_share * edge * points / contours);
}

double area_of(const std::vector<Vec3>& loop, const Plane& plane) {
    std::vector<Vec2> ring;
    for (const Vec3& p : loop) ring.push_back(plane.to_plane(p));
    return std::abs(signed_area(ring));
}

class Outlines {
  public:
    Outlines(const ContourSet& set, const FieldOptions& options, RunContext& context)
        : set_(set), options_(options), context_(context) {}

    // Returns the outlines of a structure on slices that say nothing about it, in a set of all slices.
    Result<ContourSet> of(std::uint32_t structure, const std::vector<std::uint32_t>& unknown_slices) const {
        std::vector<std::uint32_t> own;
        for (std::uint32_t k = 0; k < set_.slices.size(); ++k) {
            if (!std::binary_search(unknown_slices.begin(), unknown_slices.end(), k)) own.push_back(k);
        }
        const ContourSet alone = chosen_slices(choose_structures(set_, {&structure, 1}), own);
        RunContext apart;  // the set's own field will say what is to be said
        apart.threads = context_.threads;
        apart.cancel = context_.cancel;
        ANATOMESH_TRY(const auto field, make_structure_field(alone, options_, apart));
        const std::vector<std::uint32_t> within = within_parts(alone, unknown_slices);
        const double step = lattice_step(alone);
        ContourSet outlines = choose_structures(set_, {&structure, 1});
        outlines.contours.clear();
        outlines.points.clear();
        for (std::uint32_t k = 0; k < set_.slices.size(); ++k) {
            Slice& slice = outlines.slices[k];
            slice.first_contour = static_cast<std::uint32_t>(outlines.contours.size());
            slice.contour_count = 0;
            if (context_.cancelled()) return cancelled_error();
            if (std::binary_search(within.begin(), within.end(), k)) trace(*field, step, k, outlines);
        }
        ANATOMESH_TRY(SimplifyResult fewer,
                      simplify_contours(outlines, {most_moved_steps * step, step / lattice_share, 0}, apart));
        return std::move(fewer.kept);
    }

  private:
    // Returns the slices that lie within a part of the structure, and not beyond its ends.
    std::vector<std::uint32_t> within_parts(const ContourSet& alone,
                                            const std::vector<std::uint32_t>& slices) const {
        const Plane& frame = set_.slices.front().plane;
        const std::vector<SliceInterval> intervals = parallel_intervals(alone, frame);
        std::vector<std::uint32_t> drawn, within;
        for (std::uint32_t i = 0; i < intervals.size(); ++i) {
            if (alone.slices[intervals[i].slice].contour_count > 0) drawn.push_back(i);
        }
        GapEvidence evidence;
        evidence.left_out = heights_left_out(alone, 0, frame.origin, frame.normal);
        evidence.thickness =
            thickness_of(structures_on_few_slices(alone, intervals, options_.single_slice_mm), 0);
        const std::vector<StructurePart> parts =
            parts_of(structure_knots(intervals, drawn, false, median_spacing(alone), options_, evidence));
        for (const std::uint32_t k : slices) {
            const double height = frame.signed_distance(set_.slices[k].plane.origin);
            if (std::any_of(parts.begin(), parts.end(), [&](const StructurePart& part) {
                    return part.low < height && height < part.high;
                }))
                within.push_back(k);
        }
        return within;
    }

    void trace(const StructureField& field, double step, std::uint32_t k, ContourSet& outlines) const {
        Slice& slice = outlines.slices[k];
        const Plane& plane = slice.plane;
        Box2 box;
        const Box3 whole = field.box();
        for (int corner = 0; corner < 8; ++corner)
            box.extend(plane.to_plane({corner & 1 ? whole.high.x : whole.low.x,
                                       corner & 2 ? whole.high.y : whole.low.y,
                                       corner & 4 ? whole.high.z : whole.low.z}));
        const auto value = [&](Vec2 q) { return field.value_within(0, plane.to_space(q), 0); };
        std::vector<std::vector<Vec3>> loops =
            loops_in_plane(trace_in_plane(value, box.grown(2 * step), step, context_.threads), plane);
        std::erase_if(loops, [&](const std::vector<Vec3>& loop) {
            return loop.size() < 3 || area_of(loop, plane) < step * step;
        });
        std::sort(loops.begin(), loops.end(),
                  [](const auto& a, const auto& b) { return lexicographic_less(a.front(), b.front()); });
        for (const std::vector<Vec3>& loop : loops) {
            outlines.contours.push_back({0, k, static_cast<std::uint32_t>(outlines.points.size()),
                                         static_cast<std::uint32_t>(loop.size())});
            outlines.points.insert(outlines.points.end(), loop.begin(), loop.end());
            ++slice.contour_count;
        }
    }

    const ContourSet& set_;
    const FieldOptions& options_;
    RunContext& context_;
};

// Fills `all` with the contours of the set and, on slices without any of a structure, with those of
// `outlines`, by structure.
void put_together(const ContourSet& set, const std::vector<ContourSet>& outlines, ContourSet& all) {
    all.contours.clear();
    all.points.clear();
    const auto add = [&](const ContourSet& from, Contour contour, std::uint32_t structure) {
        const auto points = from.points_of(contour);
        contour.structure = structure;
        contour.first_point = static_cast<std::uint32_t>(all.points.size());
        all.points.insert(all.points.end(), points.begin(), points.end());
        all.contours.push_back(contour);
    };
    for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
        const auto first = static_cast<std::uint32_t>(all.contours.size());
        for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
            for (const Contour& contour : set.contours_of(set.slices[k])) {
                if (contour.structure == s) add(set, contour, s);
            }
            if (outlines[s].slices.empty()) continue;
            for (const Contour& contour : outlines[s].contours_of(outlines[s].slices[k]))
                add(outlines[s], contour, s);
        }
        all.slices[k].first_contour = first;
        all.slices[k].contour_count = static_cast<std::uint32_t>(all.contours.size()) - first;
    }
}

// Marks which outlines of `set` were not drawn, as `marked` has it: its slice `from[k]` is slice k of
// `set`.
void mark(ContourSet& set, const ContourSet& marked, const std::vector<std::uint32_t>& from) {
    for (std::uint32_t k = 0; k < set.slices.size(); ++k)
        set.slices[k].interpolated = marked.slices[from[k]].interpolated;
}

void mark_all(ContourSet& kept, const ContourSet& marked) {
    std::vector<std::uint32_t> all(kept.slices.size());
    std::iota(all.begin(), all.end(), 0u);
    mark(kept, marked, all);
    if (!kept.overlapping) return;
    OverlappingContours overlapping = *kept.overlapping;
    for (std::size_t n = 0; n < overlapping.levels.size(); ++n)
        mark(overlapping.levels[n], marked, overlapping.slices[n]);
    kept.overlapping = std::make_shared<const OverlappingContours>(std::move(overlapping));
}

void warn_of_outlines(const ContourSet& set, RunContext& context) {
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        std::vector<std::uint32_t> slices;
        for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
            if (is_interpolated(set, k, s)) slices.push_back(k);
        }
        if (slices.empty()) continue;
        const Structure& structure = set.structures[s];
        context.warn({"W-PRI-002",
                      "slices between those of the structure draw other structures, but not this one",
                      {set.source, set.slices[slices.front()].name,
                       structure.name.empty() ? std::to_string(structure.number) : structure.name, "",
                       std::to_string(slices.size()) + " slices"},
                      "its outline there was interpolated from its own slices; draw separate parts as "
                      "separate structures"});
    }
}

}  // namespace

Result<ContourSet> outlines_between(const ContourSet& set, const FieldOptions& options, RunContext& context) {
    assert(!set.exclusive);
    const SliceArrangement arrangement = arrangement_of(set);
    assert(arrangement.is_parallel());
    const SliceCoverage coverage = coverage_of(set, arrangement, context);
    ContourSet all = set;
    std::vector<ContourSet> outlines(set.structures.size());
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        const std::vector<std::uint32_t> unknown_slices = find_unknown_slices(set, s, coverage);
        if (unknown_slices.empty()) continue;
        ANATOMESH_TRY(outlines[s], Outlines(set, options, context).of(s, unknown_slices));
        for (const std::uint32_t k : unknown_slices) {
            if (outlines[s].slices[k].contour_count > 0)
                all.slices[k].interpolated.push_back(set.structures[s].number);
        }
    }
    put_together(set, outlines, all);
    return all;
}

Result<PriorityResult> part_structures(const ContourSet& set, const std::vector<std::uint32_t>& order,
                                       const FieldOptions& options, RunContext& context) {
    const std::size_t warnings = context.warnings.size();
    ANATOMESH_TRY(PriorityResult result, give_overlaps(set, order, context));
    if (!arrangement_of(set).is_parallel() || !lacks_outlines(result.kept)) return result;
    ANATOMESH_TRY(const ContourSet whole, outlines_between(not_exclusive(set), options, context));
    if (!has_interpolated(whole)) return result;
    context.warnings.resize(warnings);
    ANATOMESH_TRY(result, give_overlaps(whole, order, context));
    // Planes so near that they became one are no longer marked: what was interpolated counts as drawn.
    if (result.kept.slices.size() == whole.slices.size()) mark_all(result.kept, whole);
    warn_of_outlines(whole, context);
    return result;
}

ContourSet drawn_alone(const ContourSet& set) {
    if (!has_interpolated(set)) return set;
    ContourSet drawn = not_exclusive(set);
    std::erase_if(drawn.contours, [&](const Contour& contour) {
        return is_interpolated(set, contour.slice, contour.structure);
    });
    std::size_t next = 0;
    std::vector<Vec3> points;
    for (std::uint32_t k = 0; k < drawn.slices.size(); ++k) {
        drawn.slices[k].first_contour = static_cast<std::uint32_t>(next);
        drawn.slices[k].interpolated.clear();
        for (; next < drawn.contours.size() && drawn.contours[next].slice == k; ++next) {
            Contour& contour = drawn.contours[next];
            const auto from = set.points_of(contour);
            contour.first_point = static_cast<std::uint32_t>(points.size());
            points.insert(points.end(), from.begin(), from.end());
        }
        drawn.slices[k].contour_count = static_cast<std::uint32_t>(next) - drawn.slices[k].first_contour;
    }
    drawn.points = std::move(points);
    return drawn;
}

}  // namespace anatomesh
