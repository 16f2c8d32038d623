#include "anatomesh/slices/arrangement/paths_of_slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "anatomesh/slices/arrangement/path_link.h"

namespace anatomesh {

namespace {

// Where slices of two paths cross they draw less than this in common in the mean: planes of one body agree, while a
// branch and its parent draw two tubes. [1; 0 to 1; M 2026-11 Y and T of tubes of one radius]
constexpr double most_agreement = 0.9;
// A path that skips slices turns by more than this somewhere. A probe that a hand leads turns by less, and its slices
// that cross are planes in any position. [degrees; 0 to 180; C Sweep]
constexpr double least_turn_with_skipped = 60;
// No larger share of all slices is skipped: the others then still show a tube that is as thick as its slices are apart.
// [1; 0 to 0.5; M 2026-11 arches and helices on planes off by 6 degrees, every fourth slice at most]
constexpr double most_skipped = 1.0 / 3;
// A skipped slice draws as much as its neighbours: boxes at least this times as large as theirs, and theirs as its own.
// A branch draws less. [1; 0 to 1; C]
constexpr double least_size = 0.5;
// The lean of a slice against so many around it tells which of two that cross is askew. [slices; >= 1; C]
constexpr std::size_t slices_around = 4;
// A skipped slice that lies in no gap is kept the next time, so often. [tries; >= 1; B]
constexpr std::size_t most_tries = 8;
// It stands for no slice. [index; 2^32 - 1; D]
constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

// Of each link the nearest one behind it and before it.
struct Nearest {
    std::uint32_t link = nobody;
    bool its_side = false;  // on which the link lies of that one: behind it, or before it
    bool is_part = false;   // some contours of that one alone lie before the link; the others lie across it
    double way = HUGE_VAL;
};
using Neighbors = std::vector<std::array<Nearest, 2>>;

// Takes link j as the nearest of link i where it is nearer than what is known.
void consider(const std::vector<PathLink>& links, std::uint32_t i, std::uint32_t j,
              std::array<Nearest, 2>& nearest) {
    if (i == j || !share(links[i], links[j])) return;
    const auto take = [&](const std::optional<Sight>& seen, bool is_part) {
        if (!seen) return;
        Nearest& known = nearest[seen->side];
        if (seen->way < known.way || (seen->way == known.way && j < known.link))
            known = {j, seen->its_side, is_part, seen->way};
    };
    const DrawnPatch &a = links[i].patch, &b = links[j].patch;
    if (side_of(a, b) != 0) return take(sight(a, b), false);
    for (const DrawnPatch& contour : links[j].alone) take(sight(a, contour), true);
}

// Finds the nearest ones of the links from `first` on and of those whose nearest one is link n, and compares those of
// all others with these. O(links that are found anew x links).
void renew(const std::vector<PathLink>& links, std::uint32_t n, std::uint32_t first, Neighbors& nearest) {
    nearest.resize(links.size());
    const auto count = static_cast<std::uint32_t>(links.size());
    for (std::uint32_t i = 0; i < count; ++i) {
        const bool is_new = i == n || i >= first;
        if (is_new || nearest[i][0].link == n || nearest[i][1].link == n) {
            nearest[i] = {};
            for (std::uint32_t j = 0; j < count; ++j) consider(links, i, j, nearest[i]);
        } else {
            for (std::uint32_t j = first; j < count; ++j) consider(links, i, j, nearest[i]);
            consider(links, i, n, nearest[i]);
        }
    }
}

// Those that have each other as the nearest.
Neighbors mutual(Neighbors nearest) {
    Neighbors both = nearest;
    for (std::uint32_t i = 0; i < both.size(); ++i) {
        for (Nearest& other : both[i]) {
            if (other.link != nobody && nearest[other.link][other.its_side].link != i) other.link = nobody;
        }
    }
    return both;
}

// The parts of a link of which one side is the nearest of several others: each part lies before one of them.
// Empty where some contour lies before none of them, or before several.
std::vector<PathSlice> parts_before(const std::vector<PathLink>& links, std::uint32_t n,
                                    const std::vector<std::uint32_t>& claimants) {
    const PathLink& link = links[n];
    std::vector<PathSlice> parts(claimants.size(), PathSlice{link.part.slice, {}});
    for (std::size_t k = 0; k < link.alone.size(); ++k) {
        std::size_t found = claimants.size();
        for (std::size_t m = 0; m < claimants.size(); ++m) {
            if (!sight(links[claimants[m]].patch, link.alone[k])) continue;
            if (found < claimants.size()) return {};
            found = m;
        }
        if (found == claimants.size()) return {};
        parts[found].contours.push_back(link.part.contours[k]);
    }
    const bool all =
        std::all_of(parts.begin(), parts.end(), [](const PathSlice& p) { return !p.contours.empty(); });
    return all ? parts : std::vector<PathSlice>{};
}

// The contours of a link that another one sees, and the others. Empty where there are no others.
std::vector<PathSlice> parts_seen(const PathLink& link, const PathLink& by) {
    std::vector<PathSlice> parts(2, PathSlice{link.part.slice, {}});
    for (std::size_t k = 0; k < link.alone.size(); ++k)
        parts[sight(by.patch, link.alone[k]) ? 0 : 1].contours.push_back(link.part.contours[k]);
    return parts[0].contours.empty() || parts[1].contours.empty() ? std::vector<PathSlice>{} : parts;
}

// A link to be parted, and its parts: legs of an arch that are drawn on one plane, before which the path forks.
struct Fork {
    std::uint32_t link;
    std::vector<PathSlice> parts;
};

std::optional<Fork> find_fork(const Neighbors& nearest, const std::vector<PathLink>& links) {
    std::vector<std::array<std::vector<std::uint32_t>, 2>> claimants(links.size());
    for (std::uint32_t i = 0; i < links.size(); ++i) {
        for (const Nearest& to : nearest[i]) {
            if (to.link == nobody) continue;
            claimants[to.link][to.its_side].push_back(i);
            if (!to.is_part) continue;
            std::vector<PathSlice> parts = parts_seen(links[to.link], links[i]);
            if (!parts.empty()) return Fork{to.link, std::move(parts)};
        }
    }
    for (std::uint32_t n = 0; n < links.size(); ++n) {
        for (const std::vector<std::uint32_t>& of_side : claimants[n]) {
            if (of_side.size() < 2 || links[n].alone.empty()) continue;
            std::vector<PathSlice> parts = parts_before(links, n, of_side);
            if (!parts.empty()) return Fork{n, std::move(parts)};
        }
    }
    return std::nullopt;
}

// Parts links at forks until there are none. O(contours) forks, each O(links).
void part_at_forks(const ContourSet& set, std::vector<PathLink>& links, Neighbors& nearest) {
    while (std::optional<Fork> fork = find_fork(nearest, links)) {
        const auto first = static_cast<std::uint32_t>(links.size());
        links[fork->link] = link_of(set, std::move(fork->parts.front()));
        for (std::size_t k = 1; k < fork->parts.size(); ++k)
            links.push_back(link_of(set, std::move(fork->parts[k])));
        renew(links, fork->link, first, nearest);
    }
}

// Chains of neighbours, each as links; nothing where a link is in none, or one is closed.
std::optional<std::vector<std::vector<std::uint32_t>>> chains_of(const Neighbors& neighbors) {
    std::vector<std::vector<std::uint32_t>> chains;
    std::vector<std::uint8_t> taken(neighbors.size(), 0);
    for (std::uint32_t start = 0; start < neighbors.size(); ++start) {
        const bool ends[] = {neighbors[start][0].link == nobody, neighbors[start][1].link == nobody};
        if (taken[start] || ends[0] == ends[1]) continue;
        std::vector<std::uint32_t> chain;
        bool side = ends[0];  // by which the chain leaves a link
        for (std::uint32_t at = start; at != nobody && !taken[at];) {
            taken[at] = 1;
            chain.push_back(at);
            const Nearest& next = neighbors[at][side];
            at = next.link;
            side = !next.its_side;
        }
        chains.push_back(std::move(chain));
    }
    if (std::find(taken.begin(), taken.end(), 0) != taken.end()) return std::nullopt;
    return chains;
}

// The places along two paths at which they draw one place.
struct Meeting {
    std::vector<std::size_t> on_one, on_other;
    double agreement = 0;  // sum of all pairs
    std::size_t pairs = 0;
    double along = 0;  // the largest cosine of two slices
};

void sort_and_count_once(std::vector<std::size_t>& places) {
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
}

// Whether a path begins, or ends, in another one.
bool is_root(const std::vector<std::size_t>& branch, std::size_t of_branch,
             const std::vector<std::size_t>& parent, std::size_t of_parent) {
    return (2 * branch.back() < of_branch || 2 * branch.front() >= of_branch) &&
           2 * parent.size() <= of_parent;
}

// Whether slices cross at the roots of branches alone.
bool are_paths(const ContourSet& set, const std::vector<PathLink>& links,
               const std::vector<std::vector<std::uint32_t>>& chains) {
    std::vector<std::pair<std::uint32_t, std::size_t>> place(links.size());  // chain, and place in it
    for (std::uint32_t c = 0; c < chains.size(); ++c) {
        for (std::size_t n = 0; n < chains[c].size(); ++n) place[chains[c][n]] = {c, n};
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, Meeting> meetings;
    for (const DrawnTwice& pair : drawn_twice(set, links)) {
        const auto [one, other] = std::minmax(place[pair.one], place[pair.other]);
        const double along = dot(links[pair.one].patch.plane.normal, links[pair.other].patch.plane.normal);
        if (one.first == other.first || std::abs(along) > cos_of_branch) return false;
        Meeting& meeting = meetings[{one.first, other.first}];
        meeting.on_one.push_back(one.second);
        meeting.on_other.push_back(other.second);
        meeting.agreement += pair.agreement;
        ++meeting.pairs;
        meeting.along = std::max(meeting.along, std::abs(along));
    }
    return std::all_of(meetings.begin(), meetings.end(), [&](auto& at) {
        Meeting& meeting = at.second;
        const bool agrees = meeting.agreement > most_agreement * static_cast<double>(meeting.pairs);
        if (agrees && meeting.along > cos_of_legs) return false;
        const std::size_t one = chains[at.first.first].size(), other = chains[at.first.second].size();
        sort_and_count_once(meeting.on_one);
        sort_and_count_once(meeting.on_other);
        return is_root(meeting.on_one, one, meeting.on_other, other) ||
               is_root(meeting.on_other, other, meeting.on_one, one);
    });
}

bool are_by_hand(const std::vector<PathLink>& links) {
    for (std::size_t i = 0; i < links.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (reach_through(links[i], links[j], cos_of_branch)) return true;
        }
    }
    return false;
}

// Chains of links, some of which may be parts of slices.
struct Chained {
    std::vector<PathLink> links;
    std::vector<std::vector<std::uint32_t>> chains;
};

std::optional<Chained> chained(const ContourSet& set, std::vector<PathLink> links) {
    if (links.size() < 2 || cross_everywhere(links, drawn_twice(set, links))) return std::nullopt;
    Neighbors nearest;
    renew(links, 0, 0, nearest);
    part_at_forks(set, links, nearest);
    auto chains = chains_of(mutual(std::move(nearest)));
    if (!chains || are_by_hand(links) || !are_paths(set, links, *chains)) return std::nullopt;
    return Chained{std::move(links), std::move(*chains)};
}

// Of each link those that it reaches through as slices of one tube do that were set askew.
using Crossed = std::vector<std::vector<std::uint32_t>>;

Crossed crossed_neighbors(const std::vector<PathLink>& links) {
    Crossed crossed(links.size());
    for (std::uint32_t i = 0; i < links.size(); ++i) {
        for (std::uint32_t j = 0; j < i; ++j) {
            if (!reach_through(links[i], links[j], cos_of_legs)) continue;
            crossed[i].push_back(j);
            crossed[j].push_back(i);
        }
    }
    return crossed;
}

// How much a link leans against those around it. [1 - cosine, sum] O(links).
double lean_of(const std::vector<PathLink>& links, std::uint32_t n) {
    std::vector<std::pair<double, double>> around;  // distance, lean
    for (std::uint32_t i = 0; i < links.size(); ++i) {
        if (i == n || !share(links[i], links[n])) continue;
        const DrawnPatch &a = links[i].patch, &b = links[n].patch;
        around.emplace_back(squared_length(a.middle() - b.middle()),
                            1 - std::abs(dot(a.plane.normal, b.plane.normal)));
    }
    const std::size_t count = std::min(slices_around, around.size());
    std::partial_sort(around.begin(), around.begin() + static_cast<std::ptrdiff_t>(count), around.end());
    double sum = 0;
    for (std::size_t k = 0; k < count; ++k) sum += around[k].second;
    return sum;
}

// Links without which no two cross: as long as two do, the one that crosses most of them, or leans more. Nothing where
// too many are needed, or one that is kept.
std::optional<std::vector<std::uint32_t>> skipped_links(const std::vector<PathLink>& links, Crossed crossed,
                                                        const std::vector<std::uint8_t>& kept) {
    std::vector<double> lean(links.size(), 0);
    for (std::uint32_t n = 0; n < links.size(); ++n) {
        if (!crossed[n].empty()) lean[n] = lean_of(links, n);
    }
    std::vector<std::uint32_t> skipped;
    while (true) {
        std::uint32_t worst = nobody;
        for (std::uint32_t n = 0; n < links.size(); ++n) {
            if (crossed[n].empty() || kept[n]) continue;
            if (worst == nobody ||
                std::pair(crossed[n].size(), lean[n]) > std::pair(crossed[worst].size(), lean[worst]))
                worst = n;
        }
        if (worst == nobody) break;
        for (const std::uint32_t other : std::exchange(crossed[worst], {})) std::erase(crossed[other], worst);
        skipped.push_back(worst);
        if (static_cast<double>(skipped.size()) > most_skipped * static_cast<double>(links.size()))
            return std::nullopt;
    }
    const bool done = std::all_of(crossed.begin(), crossed.end(), [](const auto& of) { return of.empty(); });
    return done ? std::optional(std::move(skipped)) : std::nullopt;
}

double size_of(const DrawnPatch& drawing) {
    return (drawing.box.high.x - drawing.box.low.x) * (drawing.box.high.y - drawing.box.low.y);
}

// Whether a link lies between two neighbours of a path as a slice of it does.
bool lies_between(const PathLink& link, const PathLink& before, const PathLink& after) {
    const Vec3 from = before.patch.middle(), way = after.patch.middle() - from;
    const double along = dot(link.patch.middle() - from, way);
    if (along < 0 || along > squared_length(way)) return false;
    const auto is_alike = [&](const PathLink& other) {
        const double size = size_of(link.patch), its_size = size_of(other.patch);
        return share(link, other) && std::min(size, its_size) >= least_size * std::max(size, its_size) &&
               std::abs(dot(link.patch.plane.normal, other.patch.plane.normal)) > cos_of_legs;
    };
    return is_alike(before) && is_alike(after);
}

// Whether a chain turns so far that no hand leads a probe along it.
bool turns_far(const std::vector<PathLink>& links, const std::vector<std::uint32_t>& chain) {
    std::vector<Vec3> along;  // unit normals, along the chain
    for (std::size_t n = 0; n < chain.size(); ++n) {
        const std::size_t from = n + 1 < chain.size() ? n : n - 1;
        const Vec3 way = links[chain[from + 1]].patch.middle() - links[chain[from]].patch.middle();
        const Vec3& normal = links[chain[n]].patch.plane.normal;
        along.push_back((dot(normal, way) < 0 ? -1.0 : 1.0) * normal);
    }
    const double most = std::cos(least_turn_with_skipped * std::numbers::pi / 180);
    return std::any_of(along.begin(), along.end(), [&](const Vec3& a) {
        return std::any_of(along.begin(), along.end(), [&](const Vec3& b) { return dot(a, b) < most; });
    });
}

// Whether a link lies in a gap of a chain that turns far.
bool is_skipped_well(const PathLink& link, const Chained& others) {
    return std::any_of(others.chains.begin(), others.chains.end(),
                       [&](const std::vector<std::uint32_t>& chain) {
                           for (std::size_t n = 0; n + 1 < chain.size(); ++n) {
                               if (lies_between(link, others.links[chain[n]], others.links[chain[n + 1]]))
                                   return turns_far(others.links, chain);
                           }
                           return false;
                       });
}

// The chains that are left when slices are skipped that were set askew and cross others of their tube. Nothing where
// there are none, or one of them does not lie in a gap that it leaves.
std::optional<Chained> chained_with_skipped(const ContourSet& set, const std::vector<PathLink>& links) {
    const Crossed crossed = crossed_neighbors(links);
    std::vector<std::uint8_t> kept(links.size(), 0);
    for (std::size_t tries = 0; tries < most_tries; ++tries) {
        const auto skipped = skipped_links(links, crossed, kept);
        if (!skipped || skipped->empty()) return std::nullopt;
        std::vector<PathLink> others;
        for (std::uint32_t n = 0; n < links.size(); ++n) {
            if (std::find(skipped->begin(), skipped->end(), n) == skipped->end()) others.push_back(links[n]);
        }
        std::optional<Chained> made = chained(set, std::move(others));
        if (!made) return std::nullopt;
        bool all = true;
        for (const std::uint32_t n : *skipped) {
            if (is_skipped_well(links[n], *made)) continue;
            kept[n] = 1;
            all = false;
        }
        if (all) return made;
    }
    return std::nullopt;
}

}  // namespace

std::optional<std::vector<SlicePath>> paths_of_slices(const ContourSet& set) {
    if (set.exclusive && set.structures.size() > 1) return std::nullopt;
    const std::vector<PathLink> links = links_of(set);
    if (links.size() < 2 || cross_everywhere(links, drawn_twice(set, links))) return std::nullopt;
    std::optional<Chained> made = chained(set, links);
    // A tube that is broken where slices of it cross is whole without some of them.
    std::optional<Chained> whole = chained_with_skipped(set, links);
    if (whole && (!made || whole->chains.size() < made->chains.size())) made = std::move(whole);
    if (!made) return std::nullopt;
    std::vector<SlicePath> paths;
    for (const std::vector<std::uint32_t>& chain : made->chains) {
        std::vector<PathSlice> slices;
        for (const std::uint32_t n : chain) slices.push_back(made->links[n].part);
        paths.emplace_back(set, std::move(slices));
    }
    return paths;
}

std::vector<std::uint32_t> slices_without_neighbor(const ContourSet& set) {
    std::vector<PathLink> links = links_of(set);
    Neighbors nearest;
    renew(links, 0, 0, nearest);
    part_at_forks(set, links, nearest);
    const Neighbors both = mutual(std::move(nearest));
    std::vector<std::uint32_t> slices;
    for (std::size_t n = 0; n < links.size(); ++n) {
        if (both[n][0].link == nobody && both[n][1].link == nobody) slices.push_back(links[n].part.slice);
    }
    std::sort(slices.begin(), slices.end());
    slices.erase(std::unique(slices.begin(), slices.end()), slices.end());
    return slices;
}

}  // namespace anatomesh
