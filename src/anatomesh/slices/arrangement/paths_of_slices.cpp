#include "anatomesh/slices/arrangement/paths_of_slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "anatomesh/slices/arrangement/mirrored_frame.h"

namespace anatomesh {

namespace {

// Two slices at a larger angle tell of two tubes rather than of one that bends. [degrees; 0 to 180; C]
constexpr double most_turn = 110;
// Of paths with branches no more slices draw places that others draw too. [1; 0 to 1; C more than twice a half, which
// is the most of a branch and its parent]
constexpr double most_twice = 0.75;
// Slices of a branch and its parent that cross lean by 10 degrees at least: slices of a probe that cross lean less.
// [1, cosine; 0 to 1; C Sweep]
constexpr double cos_of_branch = 0.985;
// Where slices of two paths cross they draw less than this in common in the mean: planes of one body agree, while a
// branch and its parent draw two tubes. [1; 0 to 1; M 2026-11 Y and T of tubes of one radius]
constexpr double most_agreement = 0.9;
// Slices that lean by 25 degrees at least, of which this is the cosine, are led by no hand, so that they may agree where
// they cross: the two legs of a Y do, where they are alike. [1, cosine; 0 to 1; C]
constexpr double cos_of_legs = 0.906;
// It stands for no slice. [index; 2^32 - 1; D]
constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

// What is drawn on a slice, or a part of it.
struct Drawing : PlanePatch {
    std::vector<Vec3> points;
};

Drawing drawing_of(const ContourSet& set, const PathSlice& part) {
    Drawing drawing{patch_of(set, part), {}};
    for (const std::uint32_t c : part.contours) {
        const std::span<const Vec3> points = set.points_of(set.contours[c]);
        drawing.points.insert(drawing.points.end(), points.begin(), points.end());
    }
    return drawing;
}

// On which side of a slice points lie: 1 before it, -1 behind it, 0 on both.
int side_of(const PlanePatch& of, std::span<const Vec3> points) {
    bool before = true, behind = true;
    for (const Vec3& point : points) {
        const double height = of.plane.signed_distance(point);
        before = before && height > of.high;
        behind = behind && height < of.low;
        if (!before && !behind) return 0;
    }
    return before ? 1 : -1;
}

// On which side what another slice draws lies. The corners of its box mostly tell.
int side_of(const PlanePatch& of, const Drawing& other) {
    const int side = side_of(of, std::span<const Vec3>(other.corners()));
    return side != 0 ? side : side_of(of, std::span<const Vec3>(other.points));
}

bool overlap(const Box2& p, const Box2& q) {
    return p.low.x <= q.high.x && q.low.x <= p.high.x && p.low.y <= q.high.y && q.low.y <= p.high.y;
}

// A slice, or a part of one, as a link of a chain.
struct Link {
    PathSlice part;
    Drawing patch;
    std::vector<std::uint32_t> structures;  // rising
    std::vector<Drawing> alone;             // of each contour where there are several
};

Link link_of(const ContourSet& set, PathSlice part) {
    Link link{std::move(part), {}, {}, {}};
    link.patch = drawing_of(set, link.part);
    if (link.part.contours.size() > 1) {
        for (const std::uint32_t c : link.part.contours)
            link.alone.push_back(drawing_of(set, {link.part.slice, {c}}));
    }
    for (const std::uint32_t c : link.part.contours) {
        const std::uint32_t structure = set.contours[c].structure;
        if (link.structures.empty() || link.structures.back() != structure)
            link.structures.push_back(structure);
    }
    return link;
}

// Of each slice with contours.
std::vector<Link> links_of(const ContourSet& set) {
    std::vector<Link> links;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        const Slice& slice = set.slices[s];
        if (slice.contour_count == 0) continue;
        PathSlice part{s, std::vector<std::uint32_t>(slice.contour_count)};
        std::iota(part.contours.begin(), part.contours.end(), slice.first_contour);
        links.push_back(link_of(set, std::move(part)));
    }
    return links;
}

bool share(const Link& a, const Link& b) {
    return std::any_of(a.structures.begin(), a.structures.end(), [&](std::uint32_t s) {
        return std::binary_search(b.structures.begin(), b.structures.end(), s);
    });
}

// Two slices whose sides face each other: the frame of one carried on to the other.
struct Facing {
    Plane from, to, carried;
};

// Nothing where they lie across each other, or are turned by too much.
std::optional<Facing> facing(const PlanePatch& a, int side_of_a, const PlanePatch& b, int side_of_b) {
    if (side_of_a == 0 || side_of_b == 0) return std::nullopt;
    Facing made{a.plane, b.plane, {}};
    made.from.normal = static_cast<double>(side_of_a) * a.plane.normal;
    made.from.v = static_cast<double>(side_of_a) * a.plane.v;
    made.to.normal = static_cast<double>(-side_of_b) * b.plane.normal;
    if (dot(made.from.normal, made.to.normal) < std::cos(most_turn * std::numbers::pi / 180))
        return std::nullopt;
    made.carried = mirrored_frame(made.from, made.to);
    return made;
}

Box2 box_in(const Plane& plane, const PlanePatch& patch) {
    Box2 box;
    for (const Vec3 corner : patch.corners()) box.extend(plane.to_plane(corner));
    return box;
}

// How long a path between two slices is; nothing where the boxes of their contours do not lie before each other.
std::optional<double> way_between(const Facing& both, const PlanePatch& a, const PlanePatch& b) {
    const Box2 here = box_in(both.from, a), there = box_in(both.carried, b);
    if (!overlap(here, there)) return std::nullopt;
    const Vec2 lower = 0.5 * (here.low + here.high), upper = 0.5 * (there.low + there.high);
    const double chord = 0.5 * (both.from.signed_distance(both.carried.to_space(upper)) -
                                both.to.signed_distance(both.from.to_space(lower)));
    return std::hypot(chord, length(upper - lower));
}

// Of each link the nearest one behind it and before it.
struct Nearest {
    std::uint32_t link = nobody;
    bool its_side = false;  // on which the link lies of that one: behind it, or before it
    bool is_part = false;   // some contours of that one alone lie before the link; the others lie across it
    double way = HUGE_VAL;
};
using Neighbors = std::vector<std::array<Nearest, 2>>;

// How one slice sees another one.
struct Sight {
    bool side, its_side;
    double way;
};

std::optional<Sight> sight(const Drawing& a, const Drawing& b) {
    const int side = side_of(a, b), its_side = side == 0 ? 0 : side_of(b, a);
    const std::optional<Facing> both = facing(a, side, b, its_side);
    if (!both) return std::nullopt;
    const std::optional<double> way = way_between(*both, a, b);
    if (!way) return std::nullopt;
    return Sight{side > 0, its_side > 0, *way};
}

// Takes link j as the nearest of link i where it is nearer than what is known.
void consider(const std::vector<Link>& links, std::uint32_t i, std::uint32_t j,
              std::array<Nearest, 2>& nearest) {
    if (i == j || !share(links[i], links[j])) return;
    const auto take = [&](const std::optional<Sight>& seen, bool is_part) {
        if (!seen) return;
        Nearest& known = nearest[seen->side];
        if (seen->way < known.way || (seen->way == known.way && j < known.link))
            known = {j, seen->its_side, is_part, seen->way};
    };
    const Drawing &a = links[i].patch, &b = links[j].patch;
    if (side_of(a, b) != 0) return take(sight(a, b), false);
    for (const Drawing& contour : links[j].alone) take(sight(a, contour), true);
}

// Finds the nearest ones of the links from `first` on and of those whose nearest one is link n, and compares those of
// all others with these. O(links that are found anew x links).
void renew(const std::vector<Link>& links, std::uint32_t n, std::uint32_t first, Neighbors& nearest) {
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
std::vector<PathSlice> parts_before(const std::vector<Link>& links, std::uint32_t n,
                                    const std::vector<std::uint32_t>& claimants) {
    const Link& link = links[n];
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
std::vector<PathSlice> parts_seen(const Link& link, const Link& by) {
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

std::optional<Fork> find_fork(const Neighbors& nearest, const std::vector<Link>& links) {
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
void part_at_forks(const ContourSet& set, std::vector<Link>& links, Neighbors& nearest) {
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

// Where a slice's contours of a structure pass another plane, along the common line from `origin`; rising.
std::vector<double> passes(const ContourSet& set, const Link& link, std::uint32_t structure,
                           const Plane& other, Vec3 origin, Vec3 direction) {
    std::vector<double> at;
    for (const std::uint32_t c : link.part.contours) {
        const Contour& contour = set.contours[c];
        if (contour.structure != structure) continue;
        const std::span<const Vec3> points = set.points_of(contour);
        double before = other.signed_distance(points.back());
        for (std::size_t n = 0; n < points.size(); ++n) {
            const double here = other.signed_distance(points[n]);
            if ((before < 0) != (here < 0)) {
                const Vec3 from = n == 0 ? points.back() : points[n - 1];
                at.push_back(dot(from + (before / (before - here)) * (points[n] - from) - origin, direction));
            }
            before = here;
        }
    }
    std::sort(at.begin(), at.end());
    return at;
}

double total_length(const std::vector<double>& ends) {
    double sum = 0;
    for (std::size_t n = 0; n + 1 < ends.size(); n += 2) sum += ends[n + 1] - ends[n];
    return sum;
}

double common_length(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t m = 0, n = 0; m + 1 < a.size() && n + 1 < b.size();) {
        sum += std::max(0.0, std::min(a[m + 1], b[n + 1]) - std::max(a[m], b[n]));
        if (a[m + 1] < b[n + 1])
            m += 2;
        else
            n += 2;
    }
    return sum;
}

// How much of what two slices draw of their structures on their common line both of them draw. [0 to 1]
double agreement(const ContourSet& set, const Link& one, const Link& other) {
    const Plane &a = one.patch.plane, &b = other.patch.plane;
    const Vec3 direction = cross(a.normal, b.normal), origin = a.origin;
    double common = 0, all = 0;
    for (const std::uint32_t s : one.structures) {
        const std::vector<double> on_a = passes(set, one, s, b, origin, direction),
                                  on_b = passes(set, other, s, a, origin, direction);
        const double both = common_length(on_a, on_b);
        if (!(both > 0)) continue;
        common += both;
        all += total_length(on_a) + total_length(on_b) - both;
    }
    return common > 0 ? common / all : 0;
}

// Two links that draw one place.
struct DrawnTwice {
    std::uint32_t one, other;
    double agreement;
};

std::vector<DrawnTwice> drawn_twice(const ContourSet& set, const std::vector<Link>& links) {
    std::vector<PlanePatch> patches;
    for (const Link& link : links) patches.push_back(link.patch);
    std::vector<DrawnTwice> twice;
    for (const auto& [i, j] : crossing_pairs(patches, 0)) {
        const double both = agreement(set, links[i], links[j]);
        if (both > 0) twice.push_back({i, j, both});
    }
    return twice;
}

// Whether so many links draw places that others draw too that they are no paths with branches.
bool cross_everywhere(const std::vector<Link>& links, const std::vector<DrawnTwice>& twice) {
    std::vector<std::uint8_t> crosses(links.size(), 0);
    for (const DrawnTwice& pair : twice) crosses[pair.one] = crosses[pair.other] = 1;
    return static_cast<double>(std::count(crosses.begin(), crosses.end(), 1)) >
           most_twice * static_cast<double>(links.size());
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
bool are_paths(const ContourSet& set, const std::vector<Link>& links,
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

// Whether two slices lie before each other, lean by little, and reach through each other: a hand led the probe, and
// none of them ends a tube.
bool reach_through(const Link& one, const Link& other) {
    const Drawing &a = one.patch, &b = other.patch;
    if (!share(one, other) || std::abs(dot(a.plane.normal, b.plane.normal)) < cos_of_branch) return false;
    if (side_of(a, b) != 0 && side_of(b, a) != 0) return false;
    return overlap(a.box, box_in(a.plane, b));
}

bool are_by_hand(const std::vector<Link>& links) {
    for (std::size_t i = 0; i < links.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (reach_through(links[i], links[j])) return true;
        }
    }
    return false;
}

}  // namespace

std::optional<std::vector<SlicePath>> paths_of_slices(const ContourSet& set) {
    if (set.exclusive && set.structures.size() > 1) return std::nullopt;
    std::vector<Link> links = links_of(set);
    if (links.size() < 2 || cross_everywhere(links, drawn_twice(set, links))) return std::nullopt;
    Neighbors nearest;
    renew(links, 0, 0, nearest);
    part_at_forks(set, links, nearest);
    const auto chains = chains_of(mutual(std::move(nearest)));
    if (!chains || are_by_hand(links) || !are_paths(set, links, *chains)) return std::nullopt;
    std::vector<SlicePath> paths;
    for (const std::vector<std::uint32_t>& chain : *chains) {
        std::vector<PathSlice> slices;
        for (const std::uint32_t n : chain) slices.push_back(links[n].part);
        paths.emplace_back(set, std::move(slices));
    }
    return paths;
}

}  // namespace anatomesh
