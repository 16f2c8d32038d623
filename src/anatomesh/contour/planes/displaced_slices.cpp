#include "anatomesh/contour/planes/displaced_slices.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "anatomesh/contour/planes/common_normal.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

namespace {

// A displaced slice lies off the line between those beside it by all of the next three.
// It lies off by so much at least. [mm; > 0; C W-FLD-011]
constexpr double least_mm = 2;
// Radii of the circle of its area. [1; 0 to 1; D a choice, measurement not recorded]
constexpr double least_of_radius = 0.1;
// Times the median of what is usual around it. [1; > 1; D a choice, measurement not recorded]
constexpr double times_usual = 5;
// So many slices on either side show what is usual, the two beside it left out. [slices; >= 2; D a choice, measurement not recorded]
constexpr std::size_t around = 4;
// With fewer of them nothing is judged. [slices; >= 1; D a choice, measurement not recorded]
constexpr std::size_t fewest_around = 3;
// Those beside lie so near to a line without it, as a share of the distance. [1; 0 to 1; D a choice, measurement not recorded]
constexpr double in_line_share = 1.0 / 3;
// Areas that differ by a larger share of the mean of those beside are no shift. [1; 0 to 1; D a choice, measurement not recorded]
constexpr double most_area_change = 0.25;
// So much may the sides of its box move otherwise, as a share of the distance. [1; 0 to 1; D a choice, measurement not recorded]
constexpr double as_a_whole = 0.35;

// What is drawn of a structure on a slice.
struct Region {
    double area = 0, height = 0;  // of its middle along the stack
    Vec2 middle;                  // across
    Box2 box;                     // of its contours, across
    std::uint32_t slice = 0, contours = 0;
};

// Nothing where it has no area.
std::optional<Region> region_on(const ContourSet& set, std::uint32_t slice, std::uint32_t structure,
                                const Plane& across) {
    Region region;
    region.slice = slice;
    const Plane& plane = set.slices[slice].plane;
    Vec2 moment;
    for (const Contour& contour : set.contours_of(set.slices[slice])) {
        if (contour.structure != structure) continue;
        ++region.contours;
        const auto points = set.points_of(contour);
        const Vec2 from = plane.to_plane(points[0]);
        for (const Vec3& p : points) region.box.extend(across.to_plane(p));
        for (std::size_t n = 0; n < points.size(); ++n) {
            const Vec2 a = plane.to_plane(points[n]) - from,
                       b = plane.to_plane(points[(n + 1) % points.size()]) - from;
            const double twice = a.x * b.y - a.y * b.x;
            region.area += 0.5 * twice;
            moment = moment + (twice / 6) * (a + b) + (0.5 * twice) * from;
        }
    }
    if (!(region.area > 0)) return std::nullopt;
    const Vec3 middle = plane.to_space((1 / region.area) * moment);
    region.middle = across.to_plane(middle);
    region.height = across.signed_distance(middle);
    return region;
}

// Of the slices that draw it, rising.
std::vector<Region> regions_of(const ContourSet& set, std::uint32_t structure, const Plane& across) {
    std::vector<Region> regions;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        if (const std::optional<Region> region = region_on(set, s, structure, across))
            regions.push_back(*region);
    }
    std::stable_sort(regions.begin(), regions.end(),
                     [](const Region& a, const Region& b) { return a.height < b.height; });
    return regions;
}

// What one is off the line between two others: its middle, and the corners of its box.
struct LineOffset {
    Vec2 middle, low, high;
};

LineOffset off_line(const Region& below, const Region& one, const Region& above) {
    const double gap = above.height - below.height;
    const double t = gap > 0 ? (one.height - below.height) / gap : 0.5;
    const auto off = [&](Vec2 p, Vec2 q, Vec2 r) { return q - ((1 - t) * p + t * r); };
    return {off(below.middle, one.middle, above.middle), off(below.box.low, one.box.low, above.box.low),
            off(below.box.high, one.box.high, above.box.high)};
}

double distance_off(const Region& below, const Region& one, const Region& above) {
    return length(off_line(below, one, above).middle);
}

// Whether all of it has moved as its middle did: what grows or ends on one side moves that side alone.
bool has_moved(const LineOffset& off) {
    const double most = as_a_whole * length(off.middle);
    return length(off.low - off.middle) <= most && length(off.high - off.middle) <= most;
}

bool can_be_judged(const Region& below, const Region& one, const Region& above) {
    const double mean = 0.5 * (below.area + above.area);
    return one.contours == below.contours && one.contours == above.contours &&
           std::abs(one.area - mean) <= most_area_change * mean;
}

// How far region k is displaced; 0 if it is not; nothing where it cannot be told.
std::optional<double> displacement(const std::vector<Region>& regions, std::size_t k) {
    if (k < 2 || k + 2 >= regions.size() || !can_be_judged(regions[k - 1], regions[k], regions[k + 1]))
        return std::nullopt;
    std::vector<double> usual;
    for (std::size_t j = k > around ? k - around : 1; j <= k + around && j + 1 < regions.size(); ++j) {
        if (j >= 1 && (j + 1 < k || j > k + 1) && can_be_judged(regions[j - 1], regions[j], regions[j + 1]))
            usual.push_back(distance_off(regions[j - 1], regions[j], regions[j + 1]));
    }
    if (usual.size() < fewest_around) return std::nullopt;
    const LineOffset moved = off_line(regions[k - 1], regions[k], regions[k + 1]);
    const double off = length(moved.middle);
    const auto middle = usual.begin() + static_cast<std::ptrdiff_t>(usual.size() / 2);
    std::nth_element(usual.begin(), middle, usual.end());
    const double radius = std::sqrt(regions[k].area / std::numbers::pi);
    const double beside = std::max(distance_off(regions[k - 2], regions[k - 1], regions[k + 1]),
                                   distance_off(regions[k - 1], regions[k + 1], regions[k + 2]));
    const bool is_displaced = off >= std::max({least_mm, least_of_radius * radius, times_usual * *middle}) &&
                              beside <= in_line_share * off && has_moved(moved);
    return is_displaced ? off : 0;
}

}  // namespace

std::vector<DisplacedSlice> find_displaced_slices(const ContourSet& set) {
    struct Votes {
        std::size_t judged = 0, displaced = 0;
        DisplacedSlice furthest;
    };
    std::vector<Votes> votes(set.slices.size());
    const std::optional<Vec3> normal = common_normal(set);
    if (!normal) return {};
    const Plane across = make_plane({}, *normal);
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        const std::vector<Region> regions = regions_of(set, s, across);
        for (std::size_t k = 0; k < regions.size(); ++k) {
            const std::optional<double> off = displacement(regions, k);
            if (!off) continue;
            Votes& slice = votes[regions[k].slice];
            ++slice.judged;
            slice.displaced += *off > 0;
            if (*off > slice.furthest.distance_mm) slice.furthest = {regions[k].slice, s, *off};
        }
    }
    std::vector<DisplacedSlice> result;
    for (const Votes& slice : votes) {
        if (2 * slice.displaced > slice.judged) result.push_back(slice.furthest);
    }
    return result;
}

}  // namespace anatomesh
