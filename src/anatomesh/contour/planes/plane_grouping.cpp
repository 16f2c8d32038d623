#include "anatomesh/contour/planes/plane_grouping.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>

#include "anatomesh/contour/planes/coplanar_clusters.h"
#include "anatomesh/contour/planes/near_planes.h"
#include "anatomesh/contour/planes/point_scatter.h"

namespace anatomesh {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
constexpr std::array<int, 3> axis_order{2, 1, 0};  // axial first

double lower_median(std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// Position of a contour along a normal, robust against single points off the plane, and how far those are
// off.
struct Fit {
    double offset = 0, deviation = infinity;
};

Fit fit_along(std::span<const Vec3> points, Vec3 normal, std::vector<double>& buffer) {
    buffer.clear();
    for (const Vec3& p : points) buffer.push_back(dot(p, normal));
    Fit fit{lower_median(buffer), 0};
    for (double d : buffer) fit.deviation = std::max(fit.deviation, std::abs(d - fit.offset));
    return fit;
}

// The axis along which the contour lies at one coordinate: all its points, or three quarters of them with the
// rest within `allowed`. -1 if there is none.
int axis_position(std::span<const Vec3> points, double allowed, std::vector<double>& buffer) {
    for (int axis : axis_order) {
        const Fit fit = fit_along(points, axes[axis], buffer);
        std::size_t same = 0;
        for (const Vec3& p : points) same += dot(p, axes[axis]) == fit.offset;
        if (4 * same >= 3 * points.size() && fit.deviation <= allowed) return axis;
    }
    return -1;
}

// How far rounding to decimals has moved the points off their planes at most; 0 where it cannot be seen.
double rounding_of(std::span<const ContourToPlace> contours) {
    for (const double step : {0.1, 0.01, 0.001}) {
        const auto is_multiple = [&](double v) {
            return std::abs(v - step * std::round(v / step)) <= 1e-12 * (1 + std::abs(v));
        };
        const bool all = std::all_of(contours.begin(), contours.end(), [&](const ContourToPlace& contour) {
            return contour.plane >= 0 ||
                   std::all_of(contour.points.begin(), contour.points.end(), [&](const Vec3& p) {
                       return is_multiple(p.x) && is_multiple(p.y) && is_multiple(p.z);
                   });
        });
        if (all) return 0.5 * std::sqrt(3.0) * step;
    }
    return 0;
}

constexpr std::size_t least_points = 8;  // that show how far off a plane of their own they are

struct Orientation {
    Vec3 normal;
    bool fixed = false;  // an axis or a declared normal: not to be refined
    // Of its members, pooled: those that lie on planes along it, and the others.
    Scatter scatter, scatter_off;
    std::size_t points = 0, points_off = 0;

    void add(std::span<const Vec3> members, bool shows_plane) {
        (shows_plane ? scatter : scatter_off).add(scatter_of(members));
        (shows_plane ? points : points_off) += members.size();
    }
    // Points off their plane here and there are left out; where they are many, all together show the plane.
    void refine() {
        if (fixed) return;
        if (4 * points_off > points + points_off) scatter.add(scatter_off);
        normal = least_direction(scatter);
    }
};

Orientation oriented(Vec3 normal, bool fixed) {
    Orientation orientation;
    orientation.normal = normal;
    orientation.fixed = fixed;
    return orientation;
}

struct Own {
    Orientation orientation;
    double deviation = infinity;
};

// Assigns an orientation to every contour without a declared plane.
class OrientationFinder {
  public:
    // `noise`: of the points, by rounding.
    OrientationFinder(std::span<const ContourToPlace> contours, std::vector<double> area,
                      const PlaneGroupingOptions& options, double noise)
        : contours_(contours), options_(options), noise_(noise), area_(std::move(area)) {}

    void run(std::vector<Orientation>& orientations, std::vector<std::int32_t>& orientation_of) {
        place_axis_parallel(orientations, orientation_of);
        std::vector<std::size_t> rest;
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            if (orientation_of[c] < 0) rest.push_back(c);
        }
        // The largest contour shows its plane best.
        std::stable_sort(rest.begin(), rest.end(), [&](auto p, auto q) { return area_[p] > area_[q]; });
        std::vector<std::size_t> damaged;
        for (std::size_t c : rest) {
            if (!place(c, true, orientations, orientation_of)) damaged.push_back(c);
        }
        for (std::size_t c : damaged) place(c, false, orientations, orientation_of);
        for (Orientation& orientation : orientations) orientation.refine();
        turn_noisy_to_axes(orientations, orientation_of);
    }

    // Gives contours orientations of their own which do not lie in the plane of theirs, or which lie in
    // planes that cross or nearly do; but not where `stays`.
    void set_apart(const std::vector<bool>& stays, std::vector<Orientation>& orientations,
                   std::vector<std::int32_t>& orientation_of) {
        struct Placed {
            std::int32_t orientation;
            double low, high;
            std::size_t contour;
            Own own;
        };
        std::vector<Placed> placed;
        std::vector<bool> leaves(contours_.size(), false);
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            const std::span<const Vec3> points = contours_[c].points;
            if (contours_[c].plane >= 0 || stays[c] || points.size() < least_points) continue;
            const Own own = fitted_orientation(points);
            if (own.deviation > tolerance()) continue;
            const double off = fit_along(points, orientations[orientation_of[c]].normal, buffer_).deviation;
            leaves[c] = off > tolerance() && is_far_better(own, off, points.size());
            const auto [low, high] = std::minmax_element(buffer_.begin(), buffer_.end());
            // Points that lie no closer to a plane of their own overlap others by noise.
            if (2 * own.deviation > off && off > noise_) continue;
            placed.push_back({orientation_of[c], *low, *high, c, own});
        }
        std::stable_sort(placed.begin(), placed.end(), [](const Placed& p, const Placed& q) {
            return p.orientation != q.orientation ? p.orientation < q.orientation : p.low < q.low;
        });
        const Placed* highest = nullptr;
        for (const Placed& one : placed) {
            if (highest && highest->orientation == one.orientation && one.low < highest->high)
                leaves[highest->contour] = leaves[one.contour] = true;
            if (!highest || highest->orientation != one.orientation || one.high > highest->high)
                highest = &one;
        }
        for (const Placed& one : placed) {
            if (!leaves[one.contour]) continue;
            orientation_of[one.contour] = static_cast<std::int32_t>(orientations.size());
            orientations.push_back(one.own.orientation);
        }
    }

  private:
    // Noise turns the normal of a stack a little: where the points of its contours lie no closer to planes
    // along the normal found than to planes along an axis, the axis it is.
    void turn_noisy_to_axes(std::vector<Orientation>& orientations,
                            const std::vector<std::int32_t>& orientation_of) {
        struct OffPlanes {
            double own = 0;
            std::array<double, 3> along{};
        };
        std::vector<OffPlanes> off(orientations.size());
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            const auto o = static_cast<std::size_t>(orientation_of[c]);
            if (orientations[o].fixed) continue;
            const std::span<const Vec3> points = contours_[c].points;
            off[o].own = std::max(off[o].own, fit_along(points, orientations[o].normal, buffer_).deviation);
            for (int axis : axis_order)
                off[o].along[axis] =
                    std::max(off[o].along[axis], fit_along(points, axes[axis], buffer_).deviation);
        }
        for (std::size_t o = 0; o < orientations.size(); ++o) {
            if (orientations[o].fixed || off[o].own <= options_.plane_tolerance_mm) continue;
            for (int axis : axis_order) {
                if (off[o].along[axis] <= fitted_share * off[o].own) orientations[o].normal = axes[axis];
            }
        }
    }

    // Contours at one x, y or z, when they make up a tenth of the area: fewer are an accident of a tilted
    // stack.
    void place_axis_parallel(std::vector<Orientation>& orientations,
                             std::vector<std::int32_t>& orientation_of) {
        std::vector<int> axis_of_contour(contours_.size(), -1);
        std::array<double, 3> area_along{};
        double all = 0;
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            if (orientation_of[c] >= 0) continue;
            axis_of_contour[c] = axis_position(contours_[c].points, options_.plane_repair_mm, buffer_);
            all += area_[c];
            if (axis_of_contour[c] >= 0) area_along[axis_of_contour[c]] += area_[c];
        }
        for (int axis : axis_order) {
            if (area_along[axis] <= 0 || area_along[axis] < 0.1 * all) continue;
            orientations.push_back(oriented(axes[axis], true));
            for (std::size_t c = 0; c < contours_.size(); ++c) {
                if (axis_of_contour[c] == axis) {
                    orientation_of[c] = static_cast<std::int32_t>(orientations.size()) - 1;
                }
            }
        }
    }

    // Points so far off a plane still show it.
    double tolerance() const { return std::max(options_.plane_tolerance_mm, fitted_share * noise_); }

    // The orientation that a contour's own points show when they lie on one plane within the tolerance.
    std::optional<Own> clean_orientation(std::span<const Vec3> points) {
        const Own own = fitted_orientation(points);
        for (int axis : axis_order) {
            const double deviation = fit_along(points, axes[axis], buffer_).deviation;
            if (deviation <= noise_ ||
                (deviation <= options_.plane_tolerance_mm && !is_far_better(own, deviation, points.size())))
                return Own{oriented(axes[axis], true), deviation};
        }
        if (own.deviation > tolerance()) return std::nullopt;
        return own;
    }

    Own fitted_orientation(std::span<const Vec3> points) {
        const Vec3 normal = least_direction(scatter_of(points));
        return Own{oriented(normal, false), fit_along(points, normal, buffer_).deviation};
    }

    // A few points always lie near some plane: their own one counts only when it fits far better.
    bool is_far_better(const Own& own, double off, std::size_t points) const {
        return points >= least_points &&
               own.deviation <= std::max(0.1 * off, std::min(0.5 * off, fitted_share * noise_));
    }

    // The best guess for a contour with points off its plane.
    Own damaged_orientation(std::span<const Vec3> points) {
        const int axis = axis_position(points, infinity, buffer_);
        if (axis >= 0)
            return Own{oriented(axes[axis], true), fit_along(points, axes[axis], buffer_).deviation};
        return fitted_orientation(points);
    }

    // Puts contour c into the orientation it fits, or into a new one of its own. With `clean_only` a contour
    // that neither fits one nor lies on a plane of its own is put off: returns false.
    bool place(std::size_t c, bool clean_only, std::vector<Orientation>& orientations,
               std::vector<std::int32_t>& orientation_of) {
        const std::span<const Vec3> points = contours_[c].points;
        double best = infinity;
        std::size_t chosen = orientations.size();
        for (std::size_t o = 0; o < orientations.size(); ++o) {
            const double deviation = fit_along(points, orientations[o].normal, buffer_).deviation;
            if (deviation < best) best = deviation, chosen = o;
        }
        bool shows_plane = best <= tolerance();
        if (!shows_plane && (clean_only || best > options_.plane_repair_mm)) {
            const std::optional<Own> own =
                clean_only ? clean_orientation(points) : damaged_orientation(points);
            if (!own) return false;
            const bool far_better = is_far_better(*own, best, points.size());
            if (far_better || (best > options_.plane_repair_mm && own->deviation < best)) {
                chosen = orientations.size();
                orientations.push_back(own->orientation);
                shows_plane = clean_only;
            }
        }
        orientation_of[c] = static_cast<std::int32_t>(chosen);
        if (!orientations[chosen].fixed) orientations[chosen].add(points, shows_plane);
        return true;
    }

    std::span<const ContourToPlace> contours_;
    const PlaneGroupingOptions& options_;
    double noise_;
    std::vector<double> area_;
    std::vector<double> buffer_;
};

// Declared planes whose normals differ by less than the tolerance at their contours' extent share an
// orientation.
void place_declared(std::span<const ContourToPlace> contours, std::span<const Plane> declared,
                    const PlaneGroupingOptions& options, std::vector<Orientation>& orientations,
                    std::vector<std::int32_t>& orientation_of) {
    struct Use {
        Vec3 normal;
        double radius = 0;
        std::size_t points = 0;
        std::vector<std::uint32_t> contours;
    };
    std::vector<Use> uses;
    for (const Plane& plane : declared) uses.push_back({canonical(plane.normal), 0, 0, {}});
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (contours[c].plane < 0) continue;
        Use& use = uses[static_cast<std::size_t>(contours[c].plane)];
        Box3 box;
        for (const Vec3& p : contours[c].points) box.extend(p);
        use.radius = std::max(use.radius, box.diagonal());
        use.points += contours[c].points.size();
        use.contours.push_back(static_cast<std::uint32_t>(c));
    }
    // Merge equal normals, then let the most used one speak for its neighbours.
    std::sort(uses.begin(), uses.end(), [](const Use& p, const Use& q) {
        return p.normal != q.normal ? lexicographic_less(p.normal, q.normal) : p.points > q.points;
    });
    std::vector<Use> merged;
    for (Use& use : uses) {
        if (use.contours.empty()) continue;
        if (merged.empty() || merged.back().normal != use.normal) {
            merged.push_back(std::move(use));
            continue;
        }
        merged.back().radius = std::max(merged.back().radius, use.radius);
        merged.back().points += use.points;
        merged.back().contours.insert(merged.back().contours.end(), use.contours.begin(), use.contours.end());
    }
    std::stable_sort(merged.begin(), merged.end(),
                     [](const Use& p, const Use& q) { return p.points > q.points; });
    const std::size_t first = orientations.size();
    for (const Use& use : merged) {
        std::size_t o = first;
        while (o < orientations.size() &&
               length(cross(orientations[o].normal, use.normal)) * use.radius > options.group_tolerance_mm) {
            ++o;
        }
        if (o == orientations.size()) orientations.push_back(oriented(use.normal, true));
        for (std::uint32_t c : use.contours) orientation_of[c] = static_cast<std::int32_t>(o);
    }
}

// A contour with its position along its orientation's normal.
struct Positioned {
    std::int32_t orientation = 0;
    double offset = 0;
    std::uint32_t contour = 0;
    std::size_t points = 0;
};

double declared_offset(const ContourToPlace& contour, const Plane& plane, Vec3 normal) {
    if (cross(plane.normal, normal) == Vec3{}) return dot(plane.origin, normal);
    Box3 box;
    for (const Vec3& p : contour.points) box.extend(p);
    const Vec3 center = 0.5 * (box.low + box.high);
    return dot(center - plane.signed_distance(center) * plane.normal, normal);
}

// How near each other planes of one orientation, in order, are one plane given twice. `extent` is that of all
// contours.
double same_plane_mm(std::span<const Positioned> stack, double extent, double bound) {
    constexpr double share_of_gap = 0.02, share_of_extent = 1e-3, rounding_share = 1e-5;
    const double rounding = rounding_share * extent;
    double largest_gap = 0;
    std::size_t planes = 1;
    for (std::size_t i = 1; i < stack.size(); ++i) {
        const double gap = stack[i].offset - stack[i - 1].offset;
        if (gap <= rounding) continue;
        ++planes;
        largest_gap = std::max(largest_gap, gap);
    }
    // One gap says nothing of what is usual in the stack.
    if (planes <= 2) return std::min(bound, share_of_extent * extent);
    return std::min(bound, std::max(rounding, share_of_gap * largest_gap));
}

// The offset that half the points of a run of contours reach.
double common_offset(std::span<const Positioned> run) {
    std::size_t all = 0, seen = 0;
    for (const Positioned& p : run) all += p.points;
    for (const Positioned& p : run) {
        seen += p.points;
        if (2 * seen >= all) return p.offset;
    }
    return run.back().offset;
}

Plane plane_at(double offset, Vec3 normal) {
    // Adding 0.0 turns a negative zero positive.
    const Vec3 origin = offset * normal;
    return make_plane({origin.x + 0.0, origin.y + 0.0, origin.z + 0.0}, normal);
}

// Contours with their orientations, stack by stack: those of one orientation in the order of their offsets.
// `rank`: of the orientations.
std::vector<Positioned> positioned_contours(std::span<const ContourToPlace> contours,
                                            std::span<const Plane> declared,
                                            const std::vector<Orientation>& orientations,
                                            const std::vector<std::int32_t>& orientation_of,
                                            const std::vector<std::int32_t>& rank) {
    std::vector<Positioned> positioned;
    std::vector<double> buffer;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        const std::int32_t o = orientation_of[c];
        const Vec3 normal = orientations[o].normal;
        const double offset = contours[c].plane >= 0
                                  ? declared_offset(contours[c], declared[contours[c].plane], normal)
                                  : fit_along(contours[c].points, normal, buffer).offset;
        positioned.push_back({rank[o], offset, static_cast<std::uint32_t>(c), contours[c].points.size()});
    }
    std::stable_sort(positioned.begin(), positioned.end(), [](const Positioned& p, const Positioned& q) {
        return p.orientation != q.orientation ? p.orientation < q.orientation : p.offset < q.offset;
    });
    return positioned;
}

// The contours of one orientation each, in the order of `positioned`.
std::vector<std::span<const Positioned>> stacks_of(std::span<const Positioned> positioned) {
    std::vector<std::span<const Positioned>> stacks;
    for (std::size_t first = 0, last = 0; first < positioned.size(); first = last) {
        while (last < positioned.size() && positioned[last].orientation == positioned[first].orientation)
            ++last;
        stacks.push_back(positioned.subspan(first, last - first));
    }
    return stacks;
}

// Orientations in a fixed order, and the place of each in it.
std::pair<std::vector<std::int32_t>, std::vector<std::int32_t>> ranked(
    const std::vector<Orientation>& orientations) {
    std::vector<std::int32_t> order(orientations.size()), rank(orientations.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](auto p, auto q) {
        return lexicographic_less(orientations[p].normal, orientations[q].normal);
    });
    for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<std::int32_t>(i);
    return {std::move(order), std::move(rank)};
}

// Root mean square distance of points from the plane that they show themselves; 0 of so few that they always
// lie near one.
double noise_of(std::span<const Vec3> points) {
    if (points.size() < least_points) return 0;
    const Scatter scatter = scatter_of(points);
    const Vec3 normal = least_direction(scatter);
    return std::sqrt(std::max(dot(normal, scatter.times(normal)), 0.0) / static_cast<double>(points.size()));
}

// Contours that share a plane are grouped as one: `points` of all of them together take their place.
struct Together {
    std::vector<ContourToPlace> contours;
    std::vector<std::vector<std::uint32_t>> members;  // per contour: of the contours of the input
    std::vector<double> area;                         // per contour
};

class Grouper {
  public:
    // `noise` of the points by rounding, `are_sheets`: no two that were not put together lie on one plane
    // exactly.
    Grouper(std::span<const ContourToPlace> contours, const Together& together,
            std::span<const Plane> declared, const PlaneGroupingOptions& options, double noise,
            bool are_sheets)
        : contours_(contours),
          together_(together),
          declared_(declared),
          options_(options),
          noise_(noise),
          are_sheets_(are_sheets) {
        for (const ContourToPlace& contour : contours) {
            for (const Vec3& p : contour.points) box_.extend(p);
        }
    }

    // Slices per contour of `together`.
    PlaneGroups run() {
        orientation_of_.assign(together_.contours.size(), -1);
        place_declared(together_.contours, declared_, options_, orientations_, orientation_of_);
        OrientationFinder finder(together_.contours, together_.area, options_, noise_);
        finder.run(orientations_, orientation_of_);
        const std::vector<std::uint32_t> run_of = runs_of_one_slice();
        if (are_sheets_) {
            std::vector<std::size_t> in_run(run_of.size() + 1, 0);
            for (const std::uint32_t run : run_of) ++in_run[run];
            std::vector<bool> stays;
            for (const std::uint32_t run : run_of) stays.push_back(in_run[run] > 1);
            finder.set_apart(stays, orientations_, orientation_of_);
        }
        return grouped(run_of);
    }

  private:
    std::vector<Positioned> positioned(const std::vector<std::int32_t>& rank) const {
        return positioned_contours(together_.contours, declared_, orientations_, orientation_of_, rank);
    }

    // A number per contour: of the run of planes near each other that are one slice, as the contours on them
    // show.
    std::vector<std::uint32_t> runs_of_one_slice() const {
        std::vector<std::uint32_t> run_of(together_.contours.size());
        std::iota(run_of.begin(), run_of.end(), 0u);
        const auto [order, rank] = ranked(orientations_);
        const std::vector<Positioned> all = positioned(rank);
        for (const std::span<const Positioned> stack : stacks_of(all)) {
            const Vec3 normal = orientations_[order[stack.front().orientation]].normal;
            std::vector<SheetAt> sheets;
            std::vector<std::size_t> first_of;
            const double same = same_plane_mm(stack, box_.diagonal(), options_.group_tolerance_mm);
            for (std::size_t i = 0; i < stack.size(); ++i) {
                const ContourToPlace& contour = together_.contours[stack[i].contour];
                if (sheets.empty() || stack[i].offset - sheets.back().offset > same) {
                    first_of.push_back(i);
                    sheets.push_back({stack[i].offset, 0, false, {}});
                }
                SheetAt& sheet = sheets.back();
                sheet.noise = std::max(sheet.noise, noise_of(contour.points));
                sheet.is_declared |= contour.plane >= 0;
                const std::vector<std::uint32_t>& members = together_.members[stack[i].contour];
                sheet.contours.insert(sheet.contours.end(), members.begin(), members.end());
            }
            first_of.push_back(stack.size());
            for (const auto& [first, last] :
                 anatomesh::runs_of_one_slice(sheets, contours_, normal, options_.plane_repair_mm)) {
                for (std::size_t i = first_of[first]; i < first_of[last]; ++i)
                    run_of[stack[i].contour] = run_of[stack[first_of[first]].contour];
            }
        }
        return run_of;
    }

    PlaneGroups grouped(const std::vector<std::uint32_t>& run_of) const {
        PlaneGroups groups;
        groups.slice_of.resize(together_.contours.size());
        const auto [order, rank] = ranked(orientations_);
        const std::vector<Positioned> all = positioned(rank);
        for (const std::span<const Positioned> stack : stacks_of(all)) {
            const double same = same_plane_mm(stack, box_.diagonal(), options_.group_tolerance_mm);
            const Vec3 normal = orientations_[order[stack.front().orientation]].normal;
            for (std::size_t begin = 0, end = 0; begin < stack.size(); begin = end) {
                while (end < stack.size() && (stack[end].offset - stack[begin].offset <= same ||
                                              run_of[stack[end].contour] == run_of[stack[end - 1].contour])) {
                    groups.slice_of[stack[end].contour] = static_cast<std::uint32_t>(groups.slices.size());
                    ++end;
                }
                const std::span<const Positioned> run = stack.subspan(begin, end - begin);
                groups.slices.push_back(plane_at(common_offset(run), normal));
                groups.spread_mm.push_back(run.back().offset - run.front().offset);
            }
        }
        return groups;
    }

    std::span<const ContourToPlace> contours_;
    const Together& together_;
    std::span<const Plane> declared_;
    const PlaneGroupingOptions& options_;
    double noise_;
    bool are_sheets_;
    Box3 box_;
    std::vector<Orientation> orientations_;
    std::vector<std::int32_t> orientation_of_;
};

}  // namespace

int axis_of(const Plane& plane) {
    for (int axis : axis_order) {
        if (plane.normal == axes[axis]) return axis;
    }
    return -1;
}

PlaneGroups group_planes(std::span<const ContourToPlace> contours, std::span<const Plane> declared,
                         const PlaneGroupingOptions& options) {
    std::vector<double> buffer;
    const bool are_known = std::all_of(contours.begin(), contours.end(), [&](const ContourToPlace& contour) {
        return contour.plane >= 0 || axis_position(contour.points, options.plane_repair_mm, buffer) >= 0;
    });
    const double noise = are_known ? 0 : rounding_of(contours);
    std::vector<std::vector<std::uint32_t>> sheets(declared.size());
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        if (contours[c].plane >= 0) {
            sheets[static_cast<std::size_t>(contours[c].plane)].push_back(c);
        } else if (are_known) {
            sheets.push_back({c});
        }
    }
    if (!are_known) {
        const double tolerance = std::max(options.plane_tolerance_mm, fitted_share * noise);
        for (CoplanarCluster& sheet : find_coplanar_clusters(contours, tolerance, noise)) {
            std::sort(sheet.contours.begin(), sheet.contours.end());
            sheets.push_back(std::move(sheet.contours));
        }
    }
    std::erase_if(sheets, [](const auto& sheet) { return sheet.empty(); });
    std::sort(sheets.begin(), sheets.end());

    // The contours of a sheet take their place as one.
    std::vector<std::vector<Vec3>> points(sheets.size());
    Together together;
    for (std::size_t s = 0; s < sheets.size(); ++s) {
        const ContourToPlace& first = contours[sheets[s][0]];
        double area = 0;
        for (const std::uint32_t c : sheets[s]) {
            area += vector_area(contours[c].points);
            if (sheets[s].size() > 1)
                points[s].insert(points[s].end(), contours[c].points.begin(), contours[c].points.end());
        }
        together.area.push_back(area);
        together.contours.push_back({sheets[s].size() > 1 ? points[s] : first.points, first.plane});
    }
    together.members = std::move(sheets);
    PlaneGroups groups = Grouper(contours, together, declared, options, noise, !are_known).run();
    std::vector<std::uint32_t> slice_of(contours.size());
    for (std::size_t s = 0; s < together.members.size(); ++s) {
        for (const std::uint32_t c : together.members[s]) slice_of[c] = groups.slice_of[s];
    }
    groups.slice_of = std::move(slice_of);
    return groups;
}

}  // namespace anatomesh
