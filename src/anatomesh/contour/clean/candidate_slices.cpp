#include "anatomesh/contour/clean/candidate_slices.h"

#include <algorithm>
#include <cstddef>
#include <set>
#include <utility>

#include "anatomesh/base/text.h"
#include "anatomesh/contour/model/chosen_slices.h"

namespace anatomesh {

namespace {

std::string name_of_plane(const RawContours& raw, std::size_t plane) {
    return plane < raw.plane_names.size() ? raw.plane_names[plane] : "";
}

// What the file calls the plane of a contour; may be empty.
std::string given_name(const RawContours& raw, std::uint32_t contour) {
    const RawContour& entry = raw.contours[contour];
    return entry.plane < 0 ? entry.slice : name_of_plane(raw, static_cast<std::size_t>(entry.plane));
}

void name_slices(const RawContours& raw, const std::vector<Candidate>& candidates,
                 std::vector<CandidateSlice>& slices) {
    for (std::size_t s = 0; s < slices.size(); ++s) {
        std::set<std::string> given;
        for (const std::uint32_t c : slices[s].members) {
            std::string name = given_name(raw, candidates[c].raw);
            if (!name.empty()) given.insert(std::move(name));
        }
        slices[s].given_names.assign(given.begin(), given.end());
        slices[s].name = slice_text(slices[s].plane, given.empty() ? std::string() : *given.begin(), s);
    }
}

std::vector<EmptyPlane> planes_without_contours(const RawContours& raw) {
    std::vector<std::uint8_t> is_drawn(raw.planes.size(), 0);
    for (const RawContour& contour : raw.contours) {
        if (contour.plane >= 0) is_drawn[static_cast<std::size_t>(contour.plane)] = 1;
    }
    std::vector<EmptyPlane> empty;
    for (std::size_t p = 0; p < raw.planes.size(); ++p) {
        if (!is_drawn[p])
            empty.push_back({raw.planes[p], slice_text(raw.planes[p], name_of_plane(raw, p), p)});
    }
    return empty;
}

// By slice, then by empty plane: the names by which a user can call it.
std::vector<std::vector<std::string>> names_to_call(const CandidateSlices& slices) {
    std::vector<std::vector<std::string>> all;
    for (const CandidateSlice& slice : slices.slices) {
        all.push_back(slice.given_names);
        if (all.back().size() < 2) all.back().insert(all.back().begin(), slice.name);
    }
    for (const EmptyPlane& plane : slices.empty_planes) all.push_back({plane.name});
    return all;
}

}  // namespace

bool is_one_of(const std::vector<std::string>& names, const std::string& name) {
    return std::any_of(names.begin(), names.end(), [&](const std::string& one) {
        return lowered_without_blanks(one) == lowered_without_blanks(name);
    });
}

CandidateSlices group_candidates(const RawContours& raw, const std::vector<Candidate>& candidates,
                                 const PlaneGroupingOptions& options) {
    std::vector<ContourToPlace> contours;
    for (const Candidate& candidate : candidates) {
        const RawContour& contour = raw.contours[candidate.raw];
        contours.push_back({candidate.points, contour.plane, contour.structure});
    }
    const PlaneGroups groups = group_planes(contours, raw.planes, options);
    CandidateSlices grouped;
    for (std::size_t s = 0; s < groups.slices.size(); ++s)
        grouped.slices.push_back({groups.slices[s], groups.spread_mm[s], "", {}, {}});
    for (std::uint32_t c = 0; c < candidates.size(); ++c)
        grouped.slices[groups.slice_of[c]].members.push_back(c);
    name_slices(raw, candidates, grouped.slices);
    grouped.empty_planes = planes_without_contours(raw);
    return grouped;
}

Result<std::vector<LeftOutSlice>> leave_out_slices(const RawContours& raw,
                                                   const std::vector<Candidate>& candidates,
                                                   const std::vector<std::string>& without,
                                                   CandidateSlices& slices, ReadingLog& log) {
    std::vector<LeftOutSlice> left_out;
    if (without.empty()) return left_out;
    ANATOMESH_TRY(const std::vector<std::uint8_t> is_named,
                  named_slices(names_to_call(slices), without, raw.source));
    bool any_stays = false;
    for (std::size_t s = 0; s < slices.slices.size(); ++s) {
        CandidateSlice& slice = slices.slices[s];
        const auto leaves = [&](std::uint32_t c) {
            if (!is_named[s]) return false;
            return slice.given_names.size() < 2 || is_one_of(without, given_name(raw, candidates[c].raw));
        };
        std::vector<std::uint32_t> staying;
        for (const std::uint32_t c : slice.members) {
            if (!leaves(c)) {
                staying.push_back(c);
                continue;
            }
            log.drop(candidates[c].raw, "slice left out");
            const RawContour& contour = raw.contours[candidates[c].raw];
            left_out.push_back({raw.structures[contour.structure].number, slice.plane});
        }
        slice.members = std::move(staying);
        any_stays = any_stays || !slice.members.empty();
    }
    if (!any_stays) return no_slice_left(raw.source);
    return left_out;
}

}  // namespace anatomesh
