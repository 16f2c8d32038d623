#include "anatomesh/slices/arrangement/slices_beside_paths.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/slices/arrangement/path_link.h"
#include "anatomesh/slices/arrangement/paths_of_slices.h"

namespace anatomesh {

namespace {

// Fewer slices show no path: two or three planes that cross are one without a third. [slices; >= 3; C]
constexpr std::size_t fewest_along_paths = 5;
// No more slices are set apart than this share of all, but one may be, so that the others surely follow paths.
// [1; 0 to 0.5; C]
constexpr double most_beside = 0.1;
// Nor more than so many, whose search takes time. [slices; >= 1; B]
constexpr std::size_t most_sought = 10;
// Slices along paths lean by more than 60 degrees, of which this is the cosine, somewhere: those that a hand leads do
// not. [1, cosine; 0 to 1; C Sweep]
constexpr double cos_of_paths = 0.5;
// A message names no more slices, so that it stays short. [slices; >= 1; B]
constexpr std::size_t most_listed = 5;

bool lean_far(const ContourSet& set) {
    const auto drawn = [](const Slice& slice) { return slice.contour_count > 0; };
    return std::any_of(set.slices.begin(), set.slices.end(), [&](const Slice& a) {
        return drawn(a) && std::any_of(set.slices.begin(), set.slices.end(), [&](const Slice& b) {
                   return drawn(b) && std::abs(dot(a.plane.normal, b.plane.normal)) < cos_of_paths;
               });
    });
}

// The slices of a set, and which of them cross, without those that were set apart.
class Crossings {
  public:
    explicit Crossings(const ContourSet& set) : crossed_(set.slices.size()), lean_(set.slices.size(), 0) {
        const std::vector<PathLink> links = links_of(set);
        for (const PathLink& link : links) slices_.push_back(link.part.slice);
        const auto add = [&](std::uint32_t one, std::uint32_t other) {
            crossed_[slices_[one]].push_back(slices_[other]);
            crossed_[slices_[other]].push_back(slices_[one]);
        };
        for (const DrawnTwice& pair : drawn_twice(set, links)) add(pair.one, pair.other);
        for (const PathLink& a : links) {
            for (const PathLink& b : links)
                lean_[a.part.slice] += 1 - std::abs(dot(a.patch.plane.normal, b.patch.plane.normal));
        }
    }

    // With contours, rising.
    const std::vector<std::uint32_t>& slices() const { return slices_; }
    const std::vector<std::uint32_t>& crossed_by(std::uint32_t slice) const { return crossed_[slice]; }

    // Of some slices the one that crosses most others; of those the one that leans most.
    std::uint32_t worst_of(const std::vector<std::uint32_t>& some) const {
        return *std::max_element(some.begin(), some.end(), [&](std::uint32_t a, std::uint32_t b) {
            return std::pair(crossed_[a].size(), lean_[a]) < std::pair(crossed_[b].size(), lean_[b]);
        });
    }

    void set_apart(std::uint32_t slice) {
        std::erase(slices_, slice);
        for (const std::uint32_t other : std::exchange(crossed_[slice], {}))
            std::erase(crossed_[other], slice);
    }

    // Whether so many cross also without the worst ones that they are on no paths.
    bool cross_everywhere_without(std::size_t count) const {
        Crossings others = *this;
        for (; count > 0 && !others.slices_.empty(); --count)
            others.set_apart(others.worst_of(others.slices_));
        const auto crossing = std::count_if(others.slices_.begin(), others.slices_.end(),
                                            [&](std::uint32_t s) { return !others.crossed_[s].empty(); });
        return are_too_many_crossing(static_cast<std::size_t>(crossing), others.slices_.size());
    }

  private:
    std::vector<std::uint32_t> slices_;
    std::vector<std::vector<std::uint32_t>> crossed_;  // by slice
    std::vector<double> lean_;                         // against all others
};

bool follow_paths(const ContourSet& set, const std::vector<std::uint32_t>& slices) {
    const ContourSet chosen = chosen_slices(set, slices);
    return lean_far(chosen) && paths_of_slices(chosen);
}

std::vector<std::uint32_t> with_slice(std::vector<std::uint32_t> slices, std::uint32_t slice) {
    slices.insert(std::upper_bound(slices.begin(), slices.end(), slice), slice);
    return slices;
}

// The slices without which all others of a set follow paths; empty where none is to be set apart, nothing where too
// many were.
std::optional<std::vector<SliceBesidePaths>> slices_beside(const ContourSet& set) {
    if (!lean_far(set)) return std::nullopt;
    const Crossings all(set);
    const std::size_t count = all.slices().size();
    const std::size_t most = std::min(
        most_sought,
        std::max<std::size_t>(1, static_cast<std::size_t>(most_beside * static_cast<double>(count))));
    if (count < fewest_along_paths + most || all.cross_everywhere_without(most)) return std::nullopt;
    Crossings others = all;
    std::vector<std::uint32_t> apart;
    while (!follow_paths(set, others.slices())) {
        if (apart.size() == most) return std::nullopt;
        // One without a neighbour is on no path; else one that crosses others keeps them from being neighbours.
        std::vector<std::uint32_t> alone = slices_without_neighbor(chosen_slices(set, others.slices()));
        for (std::uint32_t& slice : alone) slice = others.slices()[slice];
        const std::uint32_t worst = others.worst_of(alone.empty() ? others.slices() : alone);
        if (alone.empty() && others.crossed_by(worst).empty()) return std::nullopt;
        others.set_apart(worst);
        apart.push_back(worst);
    }
    std::vector<std::uint32_t> rest = others.slices();
    // Some may have had no neighbour for the sake of another one that was set apart later.
    for (std::size_t n = apart.size(); n-- > 0 && apart.size() > 1;) {
        std::vector<std::uint32_t> more = with_slice(rest, apart[n]);
        if (!follow_paths(set, more)) continue;
        rest = std::move(more);
        apart.erase(apart.begin() + static_cast<std::ptrdiff_t>(n));
    }
    if (!arrangement_of(chosen_slices(set, rest)).is_along_paths()) return std::nullopt;
    std::sort(apart.begin(), apart.end());
    std::vector<SliceBesidePaths> beside;
    for (const std::uint32_t slice : apart) {
        const std::vector<std::uint32_t>& crossed = all.crossed_by(slice);
        const auto first = std::find_if(crossed.begin(), crossed.end(), [&](std::uint32_t other) {
            return std::binary_search(rest.begin(), rest.end(), other);
        });
        beside.push_back({slice, first == crossed.end() ? std::nullopt : std::optional(*first)});
    }
    return beside;
}

// Structures that share slices, by each other; in the order of their first ones.
std::vector<std::vector<std::uint32_t>> groups_by_slices(const ContourSet& set) {
    std::vector<std::uint32_t> group(set.structures.size());
    std::iota(group.begin(), group.end(), 0u);
    for (const Slice& slice : set.slices) {
        for (const Contour& contour : set.contours_of(slice)) {
            const std::uint32_t to = group[set.contours[slice.first_contour].structure],
                                from = group[contour.structure];
            std::replace(group.begin(), group.end(), std::max(from, to), std::min(from, to));
        }
    }
    std::vector<std::vector<std::uint32_t>> groups(set.structures.size());
    std::vector<std::uint8_t> is_drawn(set.structures.size(), 0);
    for (const Contour& contour : set.contours) is_drawn[contour.structure] = 1;
    for (std::uint32_t s = 0; s < group.size(); ++s) {
        if (is_drawn[s]) groups[group[s]].push_back(s);
    }
    std::erase_if(groups, [](const auto& one) { return one.empty(); });
    return groups;
}

std::vector<std::uint32_t> slices_of_group(const ContourSet& set, const std::vector<std::uint32_t>& group) {
    std::vector<std::uint32_t> slices;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        if (set.slices[s].contour_count == 0) continue;
        const std::uint32_t structure = set.contours[set.slices[s].first_contour].structure;
        if (std::binary_search(group.begin(), group.end(), structure)) slices.push_back(s);
    }
    return slices;
}

std::string name_of_structure(const Structure& structure) {
    return structure.name.empty() ? std::to_string(structure.number) : structure.name;
}

// "the first, the second, ..." by the name that `name` gives.
template <class List, class Name>
std::string listed(const List& list, const char* between, Name name) {
    std::string text;
    for (std::size_t n = 0; n < std::min(list.size(), most_listed); ++n)
        text += (n > 0 ? between : "") + name(list[n]);
    return list.size() > most_listed ? text + between + "..." : text;
}

}  // namespace

std::optional<SlicesBesidePaths> slices_beside_paths(const ContourSet& set,
                                                     const SliceArrangement& arrangement) {
    if (arrangement.is_stack() || arrangement.is_along_paths() || set.overlapping) return std::nullopt;
    SlicesBesidePaths found;
    const std::vector<std::vector<std::uint32_t>> groups = groups_by_slices(set);
    for (const std::vector<std::uint32_t>& group : groups) {
        const std::vector<std::uint32_t> slices = slices_of_group(set, group);
        const ContourSet of_group = choose_structures(chosen_slices(set, slices), group);
        const bool is_whole = slices.size() >= fewest_along_paths && groups.size() > 1 &&
                              lean_far(of_group) && arrangement_of(of_group).is_along_paths();
        std::optional<std::vector<SliceBesidePaths>> beside;
        if (is_whole)
            beside.emplace();
        else
            beside = slices_beside(of_group);
        std::vector<std::uint32_t>& to = beside ? found.along_paths : found.structures;
        to.insert(to.end(), group.begin(), group.end());
        if (!beside) continue;
        for (SliceBesidePaths one : *beside) {
            one.slice = slices[one.slice];
            if (one.crosses) one.crosses = slices[*one.crosses];
            found.slices.push_back(one);
        }
    }
    if (found.along_paths.empty() || (found.slices.empty() && found.structures.empty())) return std::nullopt;
    std::sort(found.slices.begin(), found.slices.end(),
              [](const SliceBesidePaths& a, const SliceBesidePaths& b) { return a.slice < b.slice; });
    std::sort(found.structures.begin(), found.structures.end());
    std::sort(found.along_paths.begin(), found.along_paths.end());
    return found;
}

void warn_about_slices_beside_paths(const ContourSet& set, const SliceArrangement& arrangement,
                                    RunContext& context) {
    const bool is_told = std::any_of(context.warnings.begin(), context.warnings.end(),
                                     [](const Warning& told) { return told.code == "W-FLD-018"; });
    if (is_told) return;
    const std::optional<SlicesBesidePaths> found = slices_beside_paths(set, arrangement);
    if (!found) return;
    const auto slice_name = [&](std::uint32_t slice) {
        const std::string& name = set.slices[slice].name;
        return name.empty() ? "slice " + std::to_string(slice) : name;
    };
    const auto structure_name = [&](std::uint32_t s) { return name_of_structure(set.structures[s]); };
    std::vector<std::string> why, what;
    if (!found->slices.empty()) {
        why.push_back(listed(found->slices, ", ", [&](const SliceBesidePaths& one) {
            return slice_name(one.slice) + (one.crosses ? " (crosses " + slice_name(*one.crosses) + ")"
                                                        : std::string(" (has no neighbour)"));
        }));
        what.push_back("leave these slices out: " +
                       listed(found->slices, " ", [&](const SliceBesidePaths& one) {
                           return "--without '" + slice_name(one.slice) + "'";
                       }));
    }
    if (!found->structures.empty()) {
        why.push_back("all slices of " + listed(found->structures, ", ", structure_name));
        what.push_back("model the tubes on their own: " +
                       listed(found->along_paths, " ",
                              [&](std::uint32_t s) { return "--structure '" + structure_name(s) + "'"; }));
    }
    const auto joined = [](const std::vector<std::string>& parts) {
        return parts.size() > 1 ? parts.front() + "; " + parts.back() : parts.front();
    };
    std::string slice, value;
    std::uint32_t structure = 0;
    if (found->slices.empty()) {
        structure = found->structures.front();
    } else {
        const std::uint32_t first = found->slices.front().slice;
        slice = slice_name(first);
        structure = set.contours[set.slices[first].first_contour].structure;
        value = std::to_string(found->slices.size()) + " of " + std::to_string(set.slices.size()) + " slices";
    }
    context.warn({"W-FLD-018",
                  "slices follow the paths of tubes, but others that fit no path keep them from being joined "
                  "along these: " +
                      joined(why),
                  {set.source, slice, structure_name(structure), "", value},
                  "all slices were taken as planes in any position, so that tubes may reach far beyond their "
                  "first and last slices; " +
                      joined(what)});
}

}  // namespace anatomesh
