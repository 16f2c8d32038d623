#include "anatomesh/contour/model/chosen_slices.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "anatomesh/base/text.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_names_listed = 40;  // A message lists at most so many names. [names; > 0; B]

}  // namespace

ContourSet chosen_slices(const ContourSet& set, std::span<const std::uint32_t> slices) {
    ContourSet part = set;
    part.slices.clear();
    part.contours.clear();
    part.points.clear();
    std::vector<bool> is_chosen(set.slices.size(), false);
    for (const std::uint32_t s : slices) is_chosen[s] = true;
    for (const Contour& contour : set.contours) {
        const Slice& slice = set.slices[contour.slice];
        // Those of a slice come one after the other, by structure.
        const std::size_t first = slice.first_contour,
                          n = static_cast<std::size_t>(&contour - set.contours.data());
        if (!is_chosen[contour.slice] && (n == first || set.contours[n - 1].structure != contour.structure))
            part.left_out.push_back({set.structures[contour.structure].number, slice.plane});
    }
    for (const std::uint32_t s : slices) {
        Slice slice = set.slices[s];
        slice.first_contour = static_cast<std::uint32_t>(part.contours.size());
        for (Contour contour : set.contours_of(set.slices[s])) {
            const auto points = set.points_of(contour);
            contour.slice = static_cast<std::uint32_t>(part.slices.size());
            contour.first_point = static_cast<std::uint32_t>(part.points.size());
            part.points.insert(part.points.end(), points.begin(), points.end());
            part.contours.push_back(contour);
        }
        part.slices.push_back(std::move(slice));
    }
    if (set.overlapping) {
        OverlappingContours overlapping{{}, {}, set.overlapping->order};
        for (std::size_t n = 0; n < set.overlapping->levels.size(); ++n) {
            const std::vector<std::uint32_t>& of_level = set.overlapping->slices[n];
            std::vector<std::uint32_t> chosen, places;
            for (std::uint32_t k = 0; k < slices.size(); ++k) {
                const auto found = std::lower_bound(of_level.begin(), of_level.end(), slices[k]);
                if (found == of_level.end() || *found != slices[k]) continue;
                chosen.push_back(static_cast<std::uint32_t>(found - of_level.begin()));
                places.push_back(k);
            }
            overlapping.levels.push_back(chosen_slices(set.overlapping->levels[n], chosen));
            overlapping.slices.push_back(std::move(places));
        }
        part.overlapping = std::make_shared<const OverlappingContours>(std::move(overlapping));
    }
    return part;
}

ContourSet without_contours(const ContourSet& set, std::span<const std::uint8_t> marked) {
    assert(marked.size() == set.contours.size() && !set.overlapping);
    ContourSet rest = set;
    rest.contours.clear();
    rest.points.clear();
    for (Slice& slice : rest.slices) {
        const std::uint32_t first = slice.first_contour, last = first + slice.contour_count;
        slice.first_contour = static_cast<std::uint32_t>(rest.contours.size());
        for (std::uint32_t c = first; c < last; ++c) {
            if (marked[c]) continue;
            Contour contour = set.contours[c];
            const std::span<const Vec3> points = set.points_of(contour);
            contour.first_point = static_cast<std::uint32_t>(rest.points.size());
            rest.points.insert(rest.points.end(), points.begin(), points.end());
            rest.contours.push_back(contour);
        }
        slice.contour_count = static_cast<std::uint32_t>(rest.contours.size()) - slice.first_contour;
    }
    return rest;
}

ContourSet every_nth_slice(const ContourSet& set, std::uint32_t every, std::uint32_t offset) {
    std::vector<std::uint32_t> slices;
    for (std::size_t s = offset; s < set.slices.size(); s += every)
        slices.push_back(static_cast<std::uint32_t>(s));
    return chosen_slices(set, slices);
}

Result<std::vector<std::uint8_t>> named_slices(std::span<const std::vector<std::string>> names,
                                               std::span<const std::string> wanted, const std::string& file) {
    std::vector<std::uint8_t> is_named(names.size(), 0);
    for (const std::string& text : wanted) {
        bool found = false;
        for (const bool exactly : {true, false}) {
            const auto is_meant = [&](const std::string& name) {
                return exactly ? name == text : lowered_without_blanks(name) == lowered_without_blanks(text);
            };
            for (std::size_t s = 0; s < names.size(); ++s) {
                if (!std::any_of(names[s].begin(), names[s].end(), is_meant)) continue;
                is_named[s] = 1;
                found = true;
            }
            if (found) break;
        }
        if (found) continue;
        std::string list;
        for (std::size_t s = 0; s < std::min(names.size(), most_names_listed); ++s)
            list += (s > 0 ? ", " : "") + names[s].front();
        if (names.size() > most_names_listed) list += ", ...";
        return Error{ErrorKind::usage,
                     "E-CON-010",
                     "--without names a slice that the input does not have",
                     {file, text, "", "", ""},
                     "the slices are: " + list};
    }
    return is_named;
}

Result<ContourSet> without_slices(ContourSet set, std::span<const std::string> names) {
    if (names.empty()) return set;
    std::vector<std::vector<std::string>> all;
    for (const Slice& slice : set.slices) all.push_back({slice.name});
    ANATOMESH_TRY(const std::vector<std::uint8_t> is_named, named_slices(all, names, set.source));
    std::vector<std::uint32_t> others;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        if (!is_named[s]) others.push_back(s);
    }
    ContourSet part = chosen_slices(set, others);
    if (part.contours.empty()) return no_slice_left(set.source);
    return part;
}

Error no_slice_left(const std::string& file) {
    return {ErrorKind::usage,
            "E-CON-011",
            "--without leaves no slice with a contour",
            {file, "", "", "", ""},
            "leave out fewer slices"};
}

}  // namespace anatomesh
