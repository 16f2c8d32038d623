#include "anatomesh/contour/clean/finish_set.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/clean/crowded_points.h"
#include "anatomesh/contour/clean/weld.h"
#include "anatomesh/contour/overlay/structure_overlap.h"

namespace anatomesh {

namespace {

// So far off the line that is kept may a crowded point lie, as a share of how near crowded points are.
// [1; 0 to 1; M 2026-11 contours of 100,000 and a million points]
constexpr double crowded_off = 0.1;

}  // namespace

Status keep_structures(const RawContours& raw, ContourSet& set, RunContext& context) {
    std::vector<std::uint8_t> is_used(raw.structures.size(), 0);
    for (const Contour& contour : set.contours) is_used[contour.structure] = 1;
    std::vector<std::uint32_t> new_index(raw.structures.size(), 0);
    std::string names;
    for (std::uint32_t s : structures_by_number(raw.structures)) {
        const std::string name = structure_text(raw.structures[s]);
        names += (names.empty() ? "" : ", ") + name;
        if (is_used[s]) {
            new_index[s] = static_cast<std::uint32_t>(set.structures.size());
            set.structures.push_back(raw.structures[s]);
        } else {
            context.warn({"W-CON-001",
                          "the structure has no contour that encloses an area",
                          {raw.source, "", name, "", ""},
                          "it was left out"});
        }
    }
    if (set.structures.empty()) {
        return Error{ErrorKind::input,
                     "E-CON-001",
                     names.empty()
                         ? "the file holds no contours and no structures"
                         : "the file holds no contour that encloses an area; its structures are " + names,
                     {raw.source, "", "", "", ""},
                     "give a file with closed contours in planes"};
    }
    for (Contour& contour : set.contours) contour.structure = new_index[contour.structure];
    return Nothing{};
}

double weld_structures(ContourSet& set, double weld_mm, RunContext& context) {
    if (weld_mm <= 0) return 0;
    const WeldStats welded = weld_contours(set, weld_mm);
    if (welded.moved == 0) return welded.max_displacement_mm;
    context.warn({"W-CON-021",
                  std::to_string(welded.moved) +
                      " vertices differ from a vertex of another structure by rounding only",
                  {set.source, "", "", "", "at most " + pointed_text(welded.max_displacement_mm) + " mm"},
                  "they were moved onto that vertex"});
    return welded.max_displacement_mm;
}

Status thin_crowded_points(const RawContours& raw, double crowded_mm, ResolvedSlices& resolved,
                           ReadingLog& log, RunContext& context) {
    ContourSet& set = resolved.set;
    if (!has_crowded(set, crowded_mm)) return Nothing{};
    // Thinning renumbers the contours, so the sources are kept by point.
    std::vector<std::pair<Vec3, std::uint32_t>> sources;
    for (std::size_t c = 0; c < set.contours.size(); ++c) {
        for (const Vec3& p : set.points_of(set.contours[c])) sources.push_back({p, resolved.source_of[c]});
    }
    ANATOMESH_TRY(CrowdedPoints thin,
                  leave_out_crowded(std::move(set), {crowded_mm, crowded_off * crowded_mm}, context));
    set = std::move(thin.kept);
    if (thin.left_out.empty()) return Nothing{};
    std::map<std::uint32_t, std::uint32_t> counts;
    for (const auto& [point, source] : sources)
        counts[source] += std::binary_search(thin.left_out.begin(), thin.left_out.end(), point,
                                             [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); });
    std::erase_if(counts, [](const auto& entry) { return entry.second == 0; });
    for (const auto& [contour, count] : counts) {
        ContourLog& entry = log.of(contour);
        entry.points_kept -= std::min(entry.points_kept, count);
        entry.max_displacement_mm = std::max(entry.max_displacement_mm, thin.distance_mm);
        log.add_rule(contour, "crowded points left out");
        log.mark_repaired(contour);
    }
    Place place = place_of_contour(raw, counts.begin()->first);
    place.value = std::to_string(thin.left_out.size()) + " points";
    context.warn({"W-CON-032",
                  std::to_string(thin.left_out.size()) + " points are closer than " + brief(crowded_mm) +
                      " mm to the next one; the contour named is the first of these",
                  std::move(place),
                  "they were left out, which moves the contours by at most " + brief(thin.distance_mm) +
                      " mm; --epsilon exact keeps them"});
    return Nothing{};
}

void add_empty_slices(std::vector<EmptyPlane> planes, const std::vector<std::string>& without,
                      double group_tolerance_mm, ContourSet& set, RunContext& context) {
    std::erase_if(planes, [&](const EmptyPlane& plane) { return is_one_of(without, plane.name); });
    const std::vector<std::string> not_placed = keep_empty_slices(set, planes, group_tolerance_mm);
    if (not_placed.empty()) return;
    context.warn({"W-CON-031",
                  "planes without contours cross other planes, and their extent is unknown",
                  {set.source, not_placed.front(), "", "", std::to_string(not_placed.size()) + " planes"},
                  "they were not used; if a structure ends there, draw its end on a plane that crosses it"});
}

void settle_exclusive(const RawContours& raw, ContourSet& set, RunContext& context) {
    if (!raw.exclusive) return;
    // Structures that exclude each other leave no place unsaid, so that every slice has to say all.
    if (!set.complete) {
        context.warn(
            {"W-CON-034",
             "the file says that structures exclude each other, but not that its slices are complete",
             {raw.source, "", "", "", ""},
             "they were read as structures that may overlap; give overlaps to one with --priority"});
        return;
    }
    if (const auto overlap = find_overlap(set)) {
        const auto name = [&](std::uint32_t index) { return structure_text(set.structures[index]); };
        context.warn(
            {"W-CON-034",
             "the file says that structures exclude each other, but " + name(overlap->first) + " and " +
                 name(overlap->second) +
                 (overlap->area_mm2 > 0 ? " overlap" : " share a wall with different vertices"),
             {raw.source, set.slices[overlap->slice].name, "", "",
              overlap->area_mm2 > 0 ? brief(overlap->area_mm2) + " mm2" : ""},
             "they were read as structures that may overlap; correct the file, or give overlaps to one "
             "with --priority"});
        return;
    }
    set.exclusive = true;
    set.drawn = false;
}

}  // namespace anatomesh
