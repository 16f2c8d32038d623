#include "anatomesh/slices/arrangement/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "anatomesh/geom/box.h"
#include "anatomesh/slices/arrangement/mirrored_frame.h"

namespace anatomesh {

namespace {

// Neighbours lean by no more, because the mean of both projections is no chart beyond it: it is a few per
// cent of the gap off at this angle. [degrees; 0 to 45; M 2026-11 slices that lean]
constexpr double most_between_neighbors = 10;
// No slice leans by more against the mean of all, so that the order along that mean is the order of the
// slices. [degrees; 0 to 90; D]
constexpr double most_from_mean = 60;
// Two neighbours are nowhere nearer than this share of their mean distance: nearer planes cross, or nearly
// do. [1; 0 to 1; M 2026-11 slices that lean]
constexpr double least_gap = 0.2;
// A slice's contours leave its plane by no more than this share of its least gap, so that slices have an
// order. [1; 0 to 1; D]
constexpr double thickest = 0.1;

double cosine(double degrees) {
    return std::cos(degrees * std::numbers::pi / 180);
}

// A slice on its way into the order of the sweep.
struct Candidate {
    Plane plane;
    double low = 0, high = 0;
    std::array<Vec3, 4> corners;  // of its contours' box
    double place = 0;             // along the mean normal through the middle
    std::uint32_t slice = 0;
};

// `middle`: of the set; of a slice without contours the point nearest to it counts.
Candidate candidate_of(const ContourSet& set, std::uint32_t s, Vec3 middle) {
    Candidate made;
    made.slice = s;
    made.plane = set.slices[s].plane;
    Box2 box;
    if (set.slices[s].contour_count == 0) {
        box.extend(made.plane.to_plane(middle));
    } else {
        made.low = HUGE_VAL, made.high = -HUGE_VAL;
    }
    for (const Contour& contour : set.contours_of(set.slices[s])) {
        for (const Vec3& p : set.points_of(contour)) {
            box.extend(made.plane.to_plane(p));
            made.low = std::min(made.low, made.plane.signed_distance(p));
            made.high = std::max(made.high, made.plane.signed_distance(p));
        }
    }
    made.corners = {made.plane.to_space(box.low), made.plane.to_space({box.high.x, box.low.y}),
                    made.plane.to_space(box.high), made.plane.to_space({box.low.x, box.high.y})};
    return made;
}

void turn_round(Candidate& slice) {
    slice.plane.normal = -1.0 * slice.plane.normal;
    slice.plane.v = -1.0 * slice.plane.v;
    const double low = -slice.high;
    slice.high = -slice.low;
    slice.low = low;
}

// By which sign each normal runs the way of the first: passed on from slice to slice, always to the one that
// leans least against one that has it (Prim, Bell Syst. Tech. J. 36, 1957), so that the ends of a fan may
// look apart.
std::vector<double> signs_of(const std::vector<Candidate>& slices) {
    std::vector<double> sign(slices.size(), 1), nearest(slices.size(), -1);
    std::vector<std::uint32_t> left(slices.size() - 1);
    std::iota(left.begin(), left.end(), 1u);
    for (std::size_t from = 0; !left.empty();) {
        std::size_t next = 0;
        for (std::size_t i = 0; i < left.size(); ++i) {
            const double along = dot(slices[left[i]].plane.normal, slices[from].plane.normal);
            if (std::abs(along) > nearest[left[i]]) {
                nearest[left[i]] = std::abs(along);
                sign[left[i]] = along < 0 ? -sign[from] : sign[from];
            }
            if (nearest[left[i]] > nearest[left[next]]) next = i;
        }
        from = left[next];
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(next));
    }
    return sign;
}

// All normals the same way, sorted along their mean; false where that cannot be.
bool sort_along_mean(const Vec3& middle, std::vector<Candidate>& slices) {
    const std::vector<double> sign = signs_of(slices);
    Vec3 sum{};
    for (std::size_t i = 0; i < slices.size(); ++i) sum = sum + sign[i] * slices[i].plane.normal;
    if (!(squared_length(sum) > 0)) return false;
    const Vec3 mean = normalized(sum);
    for (Candidate& slice : slices) {
        if (dot(slice.plane.normal, mean) < 0) turn_round(slice);
        const double along = dot(slice.plane.normal, mean);
        if (along < cosine(most_from_mean)) return false;
        slice.place = -slice.plane.signed_distance(middle) / along;
    }
    std::sort(slices.begin(), slices.end(), [](const Candidate& a, const Candidate& b) {
        return a.place != b.place ? a.place < b.place : a.slice < b.slice;
    });
    return true;
}

// Whether the contours of two slices lie on the sides of each other's planes that the order says.
bool in_order(const Candidate& below, const Candidate& above) {
    return std::all_of(below.corners.begin(), below.corners.end(),
                       [&](Vec3 p) { return above.plane.signed_distance(p) < above.low; }) &&
           std::all_of(above.corners.begin(), above.corners.end(),
                       [&](Vec3 p) { return below.plane.signed_distance(p) > below.high; });
}

// The mean distance of two neighbours; 0 where they are no neighbours of a sweep.
double gap_between(const Candidate& below, const Candidate& above) {
    if (dot(below.plane.normal, above.plane.normal) < cosine(most_between_neighbors)) return 0;
    double sum = 0, least = HUGE_VAL;
    for (std::size_t n = 0; n < 4; ++n) {
        for (const double gap : {-above.plane.signed_distance(below.corners[n]),
                                 below.plane.signed_distance(above.corners[n])}) {
            sum += gap;
            least = std::min(least, gap);
        }
    }
    const double mean = sum / 8;
    const bool thin = std::max(below.high - below.low, above.high - above.low) <= thickest * least;
    return thin && least >= least_gap * mean ? mean : 0;
}

}  // namespace

std::optional<Sweep> Sweep::of(const ContourSet& set) {
    if (set.slices.size() < 2) return std::nullopt;
    const Box3 box = set.box();
    const Vec3 middle = 0.5 * (box.low + box.high);
    std::vector<Candidate> slices;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) slices.push_back(candidate_of(set, s, middle));
    if (!sort_along_mean(middle, slices)) return std::nullopt;
    std::vector<double> gaps;
    for (std::size_t i = 0; i + 1 < slices.size(); ++i) {
        gaps.push_back(gap_between(slices[i], slices[i + 1]));
        if (!(gaps.back() > 0)) return std::nullopt;
    }
    for (std::size_t i = 0; i < slices.size(); ++i) {
        for (std::size_t j = i + 1; j < slices.size(); ++j) {
            if (!in_order(slices[i], slices[j])) return std::nullopt;
        }
    }

    Sweep sweep;
    double height = 0;
    for (std::size_t i = 0; i < slices.size(); ++i) {
        Plane plane = slices[i].plane;
        if (i > 0) {
            plane = mirrored_frame(sweep.layers_.back().plane, plane);
            height += gaps[i - 1];
        } else {
            plane.origin = middle - plane.signed_distance(middle) * plane.normal;
        }
        Layer layer{plane, 0, 0, height, slices[i].slice};
        if (set.slices[layer.slice].contour_count > 0) layer.low = HUGE_VAL, layer.high = -HUGE_VAL;
        // As to_chart() will find them.
        for (const Contour& contour : set.contours_of(set.slices[layer.slice])) {
            for (const Vec3& p : set.points_of(contour)) {
                layer.low = std::min(layer.low, plane.signed_distance(p));
                layer.high = std::max(layer.high, plane.signed_distance(p));
            }
        }
        sweep.layers_.push_back(layer);
    }
    return sweep;
}

std::vector<std::uint32_t> Sweep::order() const {
    std::vector<std::uint32_t> slices;
    for (const Layer& layer : layers_) slices.push_back(layer.slice);
    return slices;
}

Vec3 Sweep::to_chart(Vec3 p) const {
    const auto next = std::partition_point(layers_.begin(), layers_.end(), [&](const Layer& layer) {
        return layer.plane.signed_distance(p) >= layer.low;
    });
    const auto at = [&](const Layer& layer) { return layer.plane.to_plane(p); };
    if (next == layers_.begin()) {
        const Vec2 q = at(*next);
        return {q.x, q.y, next->height + (next->plane.signed_distance(p) - next->low)};
    }
    const Layer &below = *(next - 1), &above = *next;
    const Vec2 q = at(below);
    const double beyond = below.plane.signed_distance(p) - below.high;
    if (beyond <= 0) return {q.x, q.y, below.height};
    if (next == layers_.end()) return {q.x, q.y, below.height + beyond};
    const double before = above.low - above.plane.signed_distance(p), t = beyond / (beyond + before);
    const Vec2 mean = q + t * (at(above) - q);
    return {mean.x, mean.y, below.height + t * (above.height - below.height)};
}

Plane Sweep::slice_at(double height) const {
    return std::min_element(layers_.begin(), layers_.end(),
                            [&](const Layer& a, const Layer& b) {
                                return std::abs(a.height - height) < std::abs(b.height - height);
                            })
        ->plane;
}

ContourSet Sweep::to_chart(const ContourSet& set) const {
    ContourSet result = set;
    result.left_out.clear();
    const Box3 box = set.box();
    const Vec3 middle = 0.5 * (box.low + box.high);
    for (LeftOutSlice slice : set.left_out) {
        const double height = to_chart(middle - slice.plane.signed_distance(middle) * slice.plane.normal).z;
        // Another one crosses these.
        if (std::abs(dot(slice.plane.normal, slice_at(height).normal)) < cosine(most_between_neighbors))
            continue;
        slice.plane = {{0, 0, height}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        result.left_out.push_back(slice);
    }
    for (const Layer& layer : layers_) {
        Slice& slice = result.slices[layer.slice];
        slice.plane = {{0, 0, layer.height}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (const Contour& contour : set.contours_of(slice)) {
            for (std::uint32_t n = contour.first_point; n < contour.first_point + contour.point_count; ++n) {
                const Vec2 q = layer.plane.to_plane(set.points[n]);
                result.points[n] = {q.x, q.y, layer.height};
            }
        }
    }
    return result;
}

}  // namespace anatomesh
