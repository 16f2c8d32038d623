#include "anatomesh/overlaps/priority.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <string>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/overlaps/nesting.h"
#include "anatomesh/overlaps/slice_partition.h"
#include "anatomesh/slices/coverage/covering_slices.h"

namespace anatomesh {

namespace {

// It stands for no slice. [index; 2^32 - 1; D]
constexpr std::uint32_t no_slice = 0xFFFFFFFFu;
// Planes that are nearer to each other and whose normals differ by less are one, as cleaning has it.
// [mm; > 0; D as group_tolerance_mm of cleaning]
constexpr double same_plane_mm = 0.01;
// The normals of such planes differ by less, as unit vectors. [1; > 0; M 2026-11, set not recorded]
constexpr double same_normal = 1e-4;

bool are_one(const Plane& p, const Plane& q) {
    return length(p.normal - q.normal) < same_normal && std::abs(p.signed_distance(q.origin)) < same_plane_mm;
}

// Returns, by structure, the mean area on the slices that draw it.
std::vector<double> mean_areas(const ContourSet& set) {
    std::vector<double> areas(set.structures.size(), 0);
    std::vector<std::uint32_t> slices(set.structures.size(), 0), last(set.structures.size(), no_slice);
    for (const Contour& contour : set.contours) {
        // Contours of a slice come one after the other.
        slices[contour.structure] += last[contour.structure] != contour.slice;
        last[contour.structure] = contour.slice;
        const std::span<const Vec3> points = set.points_of(contour);
        Vec3 twice;
        for (std::size_t n = 2; n < points.size(); ++n)
            twice += cross(points[n - 1] - points[0], points[n] - points[0]);
        areas[contour.structure] += 0.5 * dot(twice, set.slices[contour.slice].plane.normal);
    }
    for (std::size_t s = 0; s < areas.size(); ++s) areas[s] /= std::max(1u, slices[s]);
    return areas;
}

// Returns all structures, with those of `order` first.
std::vector<std::uint32_t> whole_order(const std::vector<std::uint32_t>& order, const ContourSet& set) {
    const std::vector<double> areas = mean_areas(set);
    std::vector<std::uint32_t> all = order;
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        if (std::find(order.begin(), order.end(), s) == order.end()) all.push_back(s);
    }
    std::stable_sort(all.begin() + static_cast<std::ptrdiff_t>(order.size()), all.end(),
                     [&](std::uint32_t s, std::uint32_t t) { return areas[s] < areas[t]; });
    return all;
}

// Returns `part` with all slices of `whole`, of which it has some in the same order; its other slices are
// empty.
ContourSet on_all_slices(const ContourSet& part, const ContourSet& whole) {
    ContourSet all = part;
    all.slices.clear();
    all.contours.clear();
    std::size_t next = 0;
    for (const Slice& slice : whole.slices) {
        const auto first = static_cast<std::uint32_t>(all.contours.size());
        const auto number = static_cast<std::uint32_t>(all.slices.size());
        const bool is_here = next < part.slices.size() && part.slices[next].name == slice.name &&
                             are_one(part.slices[next].plane, slice.plane);
        all.slices.push_back({is_here ? part.slices[next].plane : slice.plane, first, 0, slice.name});
        if (!is_here) continue;
        for (Contour contour : part.contours_of(part.slices[next])) {
            contour.slice = number;
            all.contours.push_back(contour);
            ++all.slices.back().contour_count;
        }
        ++next;
    }
    return next == part.slices.size() ? all : part;
}

// Returns the slices that say something about any of the structures: all slices, unless the structures
// have slices of their own.
std::vector<std::uint32_t> slices_of(const ContourSet& set, const std::vector<std::uint32_t>& structures) {
    std::vector<std::uint32_t> all(set.slices.size()), drawn;
    std::iota(all.begin(), all.end(), 0u);
    if (structures.empty() || !all_parallel(set, parallel_tolerance_mm)) return all;
    std::vector<double> heights;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        heights.push_back(dot(set.slices[s].plane.origin, set.slices.front().plane.normal));
        const auto contours = set.contours_of(set.slices[s]);
        if (std::any_of(contours.begin(), contours.end(), [&](const Contour& contour) {
                return std::find(structures.begin(), structures.end(), contour.structure) != structures.end();
            }))
            drawn.push_back(s);
    }
    if (drawn.empty()) return all;
    std::vector<double> left_out;
    for (const std::uint32_t s : structures) {
        const std::vector<double> own = heights_left_out(set, s, {}, set.slices.front().plane.normal);
        left_out.insert(left_out.end(), own.begin(), own.end());
    }
    sort_distinct(left_out);
    std::vector<std::uint32_t> covering = covering_slices(drawn, heights, left_out);
    return covering.size() == drawn.back() - drawn.front() + 1u ? all : covering;
}

Result<ContourSet> given_on_slices(const ContourSet& set, const std::vector<std::uint32_t>& rank,
                                   std::vector<GivenOverlap>& given, Relations* relations,
                                   RunContext& context);

std::vector<std::uint32_t> of_level(const std::vector<std::uint32_t>& level_of, std::uint32_t level) {
    std::vector<std::uint32_t> structures;
    for (std::uint32_t s = 0; s < level_of.size(); ++s) {
        if (level_of[s] == level) structures.push_back(s);
    }
    return structures;
}

// Returns nothing where no structure lies in another one.
Result<std::shared_ptr<const OverlappingContours>> overlapping_contours(
    const ContourSet& set, const std::vector<std::uint32_t>& rank, Relations& relations,
    const RunContext& context) {
    const std::size_t count = set.structures.size();
    std::vector<std::uint32_t> level_of = levels_of(relations, rank);
    // Every slice says something of structures with walls between them, unless they have slices of their
    // own together. Otherwise slices of one's own help none.
    for (std::uint32_t level = 0; level < count; ++level) {
        const std::vector<std::uint32_t> own = of_level(level_of, level);
        if (have_walls(set, own, relations) && slices_of(set, own).size() == set.slices.size())
            relations.forget_own_slices();
    }
    level_of = levels_of(relations, rank);
    const std::uint32_t highest = *std::max_element(level_of.begin(), level_of.end());
    if (highest == 0 || gives_much_across(relations, rank, level_of) ||
        (highest + 1 < count && !all_parallel(set, parallel_tolerance_mm)))
        return std::shared_ptr<const OverlappingContours>();
    OverlappingContours overlapping;
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return rank[a] < rank[b]; });
    for (const std::uint32_t s : order) overlapping.order.push_back(set.structures[s].number);
    for (std::uint32_t level = 0; level <= highest; ++level) {
        const std::vector<std::uint32_t> own = of_level(level_of, level);
        std::vector<std::uint32_t> own_rank;
        for (const std::uint32_t s : own) own_rank.push_back(rank[s]);
        ContourSet part = choose_structures(set, own);
        if (own.size() > 1) {
            RunContext apart;  // what is said of the whole set is said of it
            apart.cancel = context.cancel;
            std::vector<GivenOverlap> given(own.size());
            ANATOMESH_TRY(part, given_on_slices(part, own_rank, given, nullptr, apart));
            part = on_all_slices(part, set);
            if (part.slices.size() != set.slices.size())  // planes so near that they became one
                return std::shared_ptr<const OverlappingContours>();
        }
        // Structures that are apart need not exclude each other: each goes on through slices that draw
        // others alone.
        part.exclusive = have_walls(set, own, relations);
        overlapping.slices.push_back(slices_of(set, part.exclusive ? own : std::vector<std::uint32_t>{}));
        if (overlapping.slices.back().size() < set.slices.size())
            part = chosen_slices(part, overlapping.slices.back());
        overlapping.levels.push_back(std::move(part));
    }
    return std::make_shared<const OverlappingContours>(std::move(overlapping));
}

Result<ContourSet> given_on_slices(const ContourSet& set, const std::vector<std::uint32_t>& rank,
                                   std::vector<GivenOverlap>& given, Relations* relations,
                                   RunContext& context) {
    RawContours raw;
    raw.structures = set.structures;
    raw.frame = set.frame;
    raw.pixel_mm = set.pixel_mm;
    raw.slice_thickness_mm = set.slice_thickness_mm;
    raw.complete = set.complete;
    raw.source = set.source;
    for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
        raw.planes.push_back(set.slices[k].plane);
        raw.plane_names.push_back(set.slices[k].name);
        if (set.slices[k].contour_count == 0) continue;
        if (context.cancelled()) return cancelled_error();
        SlicePartition partition(set, set.slices[k], rank);
        if (!partition.arrange_contours()) {
            return Error{ErrorKind::geometry,
                         "E-PRI-001",
                         "the contours of the slice cross too often for --priority",
                         {set.source, set.slices[k].name, "", "", ""},
                         "leave out --priority, or draw the contours of this slice again"};
        }
        if (relations != nullptr) partition.add_to(*relations);
        for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
            const double area = partition.add_region(s, static_cast<std::int32_t>(k), raw);
            if (area <= least_overlap_mm2) continue;
            given[s].area_mm2 += area;
            ++given[s].slices;
        }
    }
    const std::size_t warnings = context.warnings.size();
    ANATOMESH_TRY(CleanResult cleaned, clean_contours(raw, {}, context));
    // W-CON-001 names structures without contours. Here they are those that lost everything, which
    // W-PRI-001 names.
    context.warnings.erase(std::remove_if(context.warnings.begin() + static_cast<std::ptrdiff_t>(warnings),
                                          context.warnings.end(),
                                          [](const Warning& warning) { return warning.code == "W-CON-001"; }),
                           context.warnings.end());
    ContourSet kept = std::move(cleaned.kept);
    kept.exclusive = true;
    kept.drawn = set.drawn;
    kept.left_out = set.left_out;
    return kept;
}

}  // namespace

Result<PriorityResult> give_overlaps(const ContourSet& set, const std::vector<std::uint32_t>& order,
                                     RunContext& context) {
    PriorityResult result;
    result.order = whole_order(order, set);
    std::vector<std::uint32_t> rank(result.order.size());
    for (std::uint32_t r = 0; r < rank.size(); ++r) rank[result.order[r]] = r;
    result.given.resize(set.structures.size());
    Relations relations(set.structures.size());
    ANATOMESH_TRY(result.kept, given_on_slices(set, rank, result.given, &relations, context));
    note_alone(set, relations);
    if (all_parallel(set, parallel_tolerance_mm)) relate_between(set, rank, relations);
    for (std::size_t s = 0; s < set.structures.size(); ++s) {
        const auto is_it = [&](const Structure& kept) { return kept.number == set.structures[s].number; };
        result.given[s].all =
            std::none_of(result.kept.structures.begin(), result.kept.structures.end(), is_it);
        if (result.given[s].all)
            context.warn({"W-PRI-001",
                          "the structure lies entirely in others that have priority over it",
                          {set.source, "", set.structures[s].name, "",
                           brief(result.given[s].area_mm2) + " mm2 on " +
                               std::to_string(result.given[s].slices) + " slices"},
                          "it is not in the model; name it before them in --priority to keep it"});
    }
    result.kept = on_all_slices(result.kept, set);
    if (result.kept.slices.size() == set.slices.size()) {
        ANATOMESH_TRY(result.kept.overlapping, overlapping_contours(set, rank, relations, context));
    }
    return result;
}

}  // namespace anatomesh
