#include "anatomesh/live/section/section_of_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/contour/simplify/simplify.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/planes/plane_trace.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

namespace {

// Proposals join slices however far apart they are. [spacings; >= 1e3; D]
constexpr double any_gap = 1e6;

// The part of the plane within the box; empty where the plane misses it.
Box2 part_within(const Box3& box, const Plane& plane) {
    Box2 part;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p{corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                     corner & 4 ? box.high.z : box.low.z};
        part.extend(plane.to_plane(p));
        low = std::min(low, plane.signed_distance(p));
        high = std::max(high, plane.signed_distance(p));
    }
    return low <= 0 && high >= 0 ? part : Box2{};
}

// Rings with fewer vertices, in a set of one slice.
Result<std::vector<std::vector<Vec3>>> thinned(const std::vector<std::vector<Vec3>>& loops,
                                               const Plane& plane, double tolerance_mm,
                                               const RunContext& context) {
    ContourSet set;
    set.structures = {{1, "", {}}};
    set.slices.push_back({plane, 0, static_cast<std::uint32_t>(loops.size()), ""});
    for (const std::vector<Vec3>& loop : loops) {
        set.contours.push_back(
            {0, 0, static_cast<std::uint32_t>(set.points.size()), static_cast<std::uint32_t>(loop.size())});
        set.points.insert(set.points.end(), loop.begin(), loop.end());
    }
    RunContext apart;  // what a proposal loses is no news of the set
    apart.threads = context.threads;
    apart.cancel = context.cancel;
    ANATOMESH_TRY(const SimplifyResult fewer, simplify_contours(set, {tolerance_mm, 0, 0}, apart));
    std::vector<std::vector<Vec3>> rings;
    for (const Contour& contour : fewer.kept.contours) {
        const auto points = fewer.kept.points_of(contour);
        rings.emplace_back(points.begin(), points.end());
    }
    return rings;
}

}  // namespace

Result<StructureRings> section_of_field(const StructureField& field, std::uint32_t structure,
                                        const Plane& plane, const SectionOptions& options,
                                        RunContext& context) {
    assert(options.step_mm > 0 && options.tolerance_mm >= 0);
    const Box3 whole = field.box_of(structure);
    Box2 box = whole.empty() ? Box2{} : part_within(whole, plane);
    if (box.empty()) return StructureRings{plane, {}};
    box = box.grown(2 * options.step_mm);
    const Vec2 size = box.high - box.low;
    if (!((size.x / options.step_mm + 2) * (size.y / options.step_mm + 2) <=
          static_cast<double>(options.max_points))) {
        return Error{ErrorKind::limit,
                     "E-LIV-301",
                     "a section with a step of " + brief(options.step_mm) +
                         " mm would have more points than the limit of " + std::to_string(options.max_points),
                     {},
                     "take a larger step"};
    }
    const auto value = [&](Vec2 q) {
        return context.cancelled() ? 1.0 : field.value_within(structure, plane.to_space(q), 0);
    };
    std::vector<std::vector<Vec3>> loops =
        loops_in_plane(trace_in_plane(value, box, options.step_mm, context.threads), plane);
    if (context.cancelled()) return cancelled_error();
    std::erase_if(loops, [](const std::vector<Vec3>& loop) { return loop.size() < 3; });
    std::sort(loops.begin(), loops.end(),
              [](const auto& a, const auto& b) { return lexicographic_less(a.front(), b.front()); });
    if (options.tolerance_mm > 0 && !loops.empty()) {
        ANATOMESH_TRY(loops, thinned(loops, plane, options.tolerance_mm, context));
    }
    return make_structure_rings(loops, plane);
}

Result<Proposal> propose_rings(const ContourSet& set, std::uint32_t structure, const Plane& plane,
                               const FieldOptions& field, const SectionOptions& options,
                               RunContext& context) {
    assert(structure < set.structures.size());
    Proposal proposal{{plane, {}}, NothingProposed::none};
    ContourSet alone = choose_structures(set, {&structure, 1});
    alone.exclusive = false;
    alone.overlapping = nullptr;
    double low = HUGE_VAL, high = -HUGE_VAL;
    std::size_t drawn = 0;
    bool is_parallel = true, is_drawn_here = false;
    for (const Slice& slice : alone.slices) {
        if (slice.contour_count == 0) continue;
        ++drawn;
        double nearest = HUGE_VAL, farthest = -HUGE_VAL;  // of its points, over the plane
        for (const Contour& contour : alone.contours_of(slice)) {
            for (const Vec3& p : alone.points_of(contour)) {
                nearest = std::min(nearest, plane.signed_distance(p));
                farthest = std::max(farthest, plane.signed_distance(p));
            }
        }
        is_parallel = is_parallel && farthest - nearest <= parallel_tolerance_mm;
        is_drawn_here = is_drawn_here ||
                        (std::abs(nearest) <= ring_off_plane_mm && std::abs(farthest) <= ring_off_plane_mm);
        low = std::min(low, nearest);
        high = std::max(high, farthest);
    }
    if (is_drawn_here) {
        proposal.reason = NothingProposed::drawn_here;
    } else if (drawn < 2) {
        proposal.reason = NothingProposed::one_slice;
    } else if (is_parallel && (low > 0 || high < 0)) {
        proposal.reason = NothingProposed::beyond_ends;
    }
    if (proposal.reason != NothingProposed::none) return proposal;
    FieldOptions joined = field;
    joined.max_gap_spacings = any_gap;
    joined.knows_few_slices = false;
    RunContext apart;  // the set's own field says what is to be said
    apart.threads = context.threads;
    apart.cancel = context.cancel;
    ANATOMESH_TRY(const auto made, make_structure_field(alone, joined, apart));
    ANATOMESH_TRY(proposal.rings, section_of_field(*made, 0, plane, options, context));
    if (proposal.rings.rings.empty()) proposal.reason = NothingProposed::nothing_here;
    return proposal;
}

}  // namespace anatomesh
