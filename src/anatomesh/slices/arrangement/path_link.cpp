#include "anatomesh/slices/arrangement/path_link.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "anatomesh/slices/arrangement/mirrored_frame.h"

namespace anatomesh {

namespace {

// Two slices at a larger angle tell of two tubes rather than of one that bends. [degrees; 0 to 180; C]
constexpr double most_turn = 110;
// Of paths with branches no more slices draw places that others draw too. [1; 0 to 1; C more than twice a half, which
// is the most of a branch and its parent]
constexpr double most_twice = 0.75;

DrawnPatch drawing_of(const ContourSet& set, const PathSlice& part) {
    DrawnPatch drawing{patch_of(set, part), {}};
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

bool overlap(const Box2& p, const Box2& q) {
    return p.low.x <= q.high.x && q.low.x <= p.high.x && p.low.y <= q.high.y && q.low.y <= p.high.y;
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

// Where a slice's contours of a structure pass another plane, along the common line from `origin`; rising.
std::vector<double> passes(const ContourSet& set, const PathLink& link, std::uint32_t structure,
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
double agreement(const ContourSet& set, const PathLink& one, const PathLink& other) {
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

}  // namespace

PathLink link_of(const ContourSet& set, PathSlice part) {
    PathLink link{std::move(part), {}, {}, {}};
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

std::vector<PathLink> links_of(const ContourSet& set) {
    std::vector<PathLink> links;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        const Slice& slice = set.slices[s];
        if (slice.contour_count == 0) continue;
        PathSlice part{s, std::vector<std::uint32_t>(slice.contour_count)};
        std::iota(part.contours.begin(), part.contours.end(), slice.first_contour);
        links.push_back(link_of(set, std::move(part)));
    }
    return links;
}

bool share(const PathLink& a, const PathLink& b) {
    return std::any_of(a.structures.begin(), a.structures.end(), [&](std::uint32_t s) {
        return std::binary_search(b.structures.begin(), b.structures.end(), s);
    });
}

int side_of(const PlanePatch& of, const DrawnPatch& other) {
    const int side = side_of(of, std::span<const Vec3>(other.corners()));
    return side != 0 ? side : side_of(of, std::span<const Vec3>(other.points));
}

std::optional<Sight> sight(const DrawnPatch& a, const DrawnPatch& b) {
    const int side = side_of(a, b), its_side = side == 0 ? 0 : side_of(b, a);
    const std::optional<Facing> both = facing(a, side, b, its_side);
    if (!both) return std::nullopt;
    const std::optional<double> way = way_between(*both, a, b);
    if (!way) return std::nullopt;
    return Sight{side > 0, its_side > 0, *way};
}

bool reach_through(const PathLink& one, const PathLink& other, double least_cosine) {
    const DrawnPatch &a = one.patch, &b = other.patch;
    if (!share(one, other) || std::abs(dot(a.plane.normal, b.plane.normal)) < least_cosine) return false;
    if (side_of(a, b) != 0 && side_of(b, a) != 0) return false;
    return overlap(a.box, box_in(a.plane, b));
}

std::vector<DrawnTwice> drawn_twice(const ContourSet& set, const std::vector<PathLink>& links) {
    std::vector<PlanePatch> patches;
    for (const PathLink& link : links) patches.push_back(link.patch);
    std::vector<DrawnTwice> twice;
    for (const auto& [i, j] : crossing_pairs(patches, 0)) {
        const double both = agreement(set, links[i], links[j]);
        if (both > 0) twice.push_back({i, j, both});
    }
    return twice;
}

bool cross_everywhere(const std::vector<PathLink>& links, const std::vector<DrawnTwice>& twice) {
    std::vector<std::uint8_t> crosses(links.size(), 0);
    for (const DrawnTwice& pair : twice) crosses[pair.one] = crosses[pair.other] = 1;
    return are_too_many_crossing(static_cast<std::size_t>(std::count(crosses.begin(), crosses.end(), 1)),
                                 links.size());
}

bool are_too_many_crossing(std::size_t crossing, std::size_t all) {
    return static_cast<double>(crossing) > most_twice * static_cast<double>(all);
}

}  // namespace anatomesh
