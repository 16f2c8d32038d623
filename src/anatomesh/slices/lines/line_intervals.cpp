#include "anatomesh/slices/lines/line_intervals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// So many points of a contour share a ball, which tells whether a plane can meet them. [points; >= 1; B]
constexpr std::uint32_t block_size = 16;

// A ball round a run of a contour's segments: those that begin at points [first, first + count).
struct Block {
    std::uint32_t contour, first, count;
    Vec3 center;
    double radius;
};

std::uint32_t next_point(const Contour& contour, std::uint32_t point) {
    return point + 1 == contour.first_point + contour.point_count ? contour.first_point : point + 1;
}
std::uint32_t previous_point(const Contour& contour, std::uint32_t point) {
    return point == contour.first_point ? contour.first_point + contour.point_count - 1 : point - 1;
}

std::vector<std::vector<Block>> blocks_of(const ContourSet& set) {
    std::vector<std::vector<Block>> blocks(set.slices.size());
    for (std::uint32_t c = 0; c < set.contours.size(); ++c) {
        const Contour& contour = set.contours[c];
        const std::uint32_t end = contour.first_point + contour.point_count;
        for (std::uint32_t first = contour.first_point; first < end; first += block_size) {
            const std::uint32_t count = std::min(block_size, end - first);
            Box3 box;
            for (std::uint32_t k = first; k < first + count; ++k) box.extend(set.points[k]);
            box.extend(set.points[next_point(contour, first + count - 1)]);
            blocks[contour.slice].push_back(
                {c, first, count, 0.5 * (box.low + box.high), 0.5 * box.diagonal() + 2 * line_in_plane_mm});
        }
    }
    return blocks;
}

class Comparer {
  public:
    Comparer(const ContourSet& set, const std::vector<PlanePatch>& patches, double margin)
        : set_(set), patches_(patches), margin_(margin), blocks_(blocks_of(set)) {}

    std::vector<LineComparison> compare(std::uint32_t a, std::uint32_t b) const {
        const Box2 &box_a = patches_[a].box, &box_b = patches_[b].box;
        const Vec3 middle = 0.5 * (patches_[a].plane.to_space(0.5 * (box_a.low + box_a.high)) +
                                   patches_[b].plane.to_space(0.5 * (box_b.low + box_b.high)));
        const Line line = common_line(patches_[a].plane, patches_[b].plane, middle);
        // Readings of points on the line: as of its one side, and of its other.
        bool unsure_a = false, unsure_b = false;
        const std::array<std::vector<IntervalEndpoint>, 2> endpoints_a = readings(a, b, line, unsure_a),
                                                           endpoints_b = readings(b, a, line, unsure_b);
        std::vector<std::uint32_t> structures;
        for (const auto* readings : {&endpoints_a, &endpoints_b}) {
            for (const auto& reading : *readings) {
                for (const IntervalEndpoint& end : reading) structures.push_back(structure_of(end));
            }
        }
        std::sort(structures.begin(), structures.end());
        structures.erase(std::unique(structures.begin(), structures.end()), structures.end());
        const std::array<double, 2> seen_a = seen_part(line, a), seen_b = seen_part(line, b);
        std::vector<LineComparison> result;
        for (const std::uint32_t structure : structures) {
            LineComparison best;
            bool any = false;
            for (std::size_t i = 0; i < (unsure_a ? 2u : 1u); ++i) {
                for (std::size_t j = 0; j < (unsure_b ? 2u : 1u); ++j) {
                    LineComparison tried{a,
                                         b,
                                         structure,
                                         line,
                                         part(endpoints_a[i], structure, b),
                                         part(endpoints_b[j], structure, a),
                                         {},
                                         seen_a,
                                         seen_b,
                                         0};
                    match(tried);
                    if (!any || tried.matching.cost < best.matching.cost) best = std::move(tried);
                    any = true;
                }
            }
            if (!best.endpoints_a.empty() || !best.endpoints_b.empty()) result.push_back(std::move(best));
        }
        return result;
    }

  private:
    std::uint32_t structure_of(const IntervalEndpoint& end) const {
        return set_.contours[end.contour].structure;
    }

    // The ends of slice `own` on the plane of `other`, by structure, then along the line. The second reading
    // is made only when a contour touches the plane without passing to its other side there.
    std::array<std::vector<IntervalEndpoint>, 2> readings(std::uint32_t own, std::uint32_t other,
                                                          const Line& line, bool& unsure) const {
        const Plane& plane = patches_[other].plane;
        std::array<std::vector<IntervalEndpoint>, 2> ends;
        std::vector<const Block*> near;
        for (const Block& block : blocks_[own]) {
            if (std::abs(plane.signed_distance(block.center)) <= block.radius) near.push_back(&block);
        }
        for (const Block* block : near) find(*block, plane, line, 1, ends[0], unsure);
        if (unsure) {
            for (const Block* block : near) find(*block, plane, line, -1, ends[1], unsure);
        }
        for (auto& reading : ends) {
            std::sort(reading.begin(), reading.end(),
                      [&](const IntervalEndpoint& p, const IntervalEndpoint& q) {
                          const std::uint32_t sp = structure_of(p), sq = structure_of(q);
                          if (sp != sq) return sp < sq;
                          if (p.t != q.t) return p.t < q.t;
                          return p.from != q.from ? p.from < q.from : p.to < q.to;
                      });
        }
        return ends;
    }

    static int side(double distance, int of_zero) {
        return distance > line_in_plane_mm ? 1 : distance < -line_in_plane_mm ? -1 : of_zero;
    }

    void find(const Block& block, const Plane& plane, const Line& line, int of_zero,
              std::vector<IntervalEndpoint>& ends, bool& unsure) const {
        const Contour& contour = set_.contours[block.contour];
        double here = plane.signed_distance(set_.points[block.first]);
        for (std::uint32_t k = block.first; k < block.first + block.count; ++k) {
            const std::uint32_t next = next_point(contour, k);
            const double there = plane.signed_distance(set_.points[next]);
            if (std::abs(here) <= line_in_plane_mm) {
                const double before = plane.signed_distance(set_.points[previous_point(contour, k)]);
                unsure |= side(before, 0) * side(there, 0) >= 0;
            }
            if (side(here, of_zero) != side(there, of_zero))
                ends.push_back(end_on(block.contour, k, next, here, there, line));
            here = there;
        }
    }

    IntervalEndpoint end_on(std::uint32_t contour, std::uint32_t k, std::uint32_t next, double here,
                            double there, const Line& line) const {
        IntervalEndpoint end{contour, k, next, {}, 0};
        if (std::abs(here) <= line_in_plane_mm) {
            end.to = k;
            end.at = set_.points[k];
        } else if (std::abs(there) <= line_in_plane_mm) {
            end.from = next;
            end.at = set_.points[next];
        } else {
            // Always from the same end of the segment, so that contours which share it share the place.
            Vec3 p = set_.points[k], q = set_.points[next];
            if (lexicographic_less(q, p)) std::swap(p, q), std::swap(here, there);
            end.at = p + (here / (here - there)) * (q - p);
        }
        end.t = line.along(end.at);
        return end;
    }

    // The ends of one structure without intervals and gaps that are rounding, or lie where the other slice
    // says nothing.
    std::vector<IntervalEndpoint> part(const std::vector<IntervalEndpoint>& all, std::uint32_t structure,
                                       std::uint32_t other) const {
        std::vector<IntervalEndpoint> ends;
        for (const IntervalEndpoint& end : all) {
            if (structure_of(end) != structure) continue;
            if (!ends.empty() && end.t - ends.back().t <= 2 * line_in_plane_mm) {
                ends.pop_back();
            } else {
                ends.push_back(end);
            }
        }
        const Box2 seen = patches_[other].box.grown(margin_);
        const auto is_seen = [&](const IntervalEndpoint& end) {
            return seen.contains(patches_[other].plane.to_plane(end.at));
        };
        std::vector<IntervalEndpoint> kept;
        for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
            if (!is_seen(ends[i]) && !is_seen(ends[i + 1]) && !spans(ends[i], ends[i + 1], seen, other))
                continue;
            kept.push_back(ends[i]);
            kept.push_back(ends[i + 1]);
        }
        return kept;
    }

    // Whether the segment between two places meets the box that a slice sees.
    bool spans(const IntervalEndpoint& p, const IntervalEndpoint& q, const Box2& seen,
               std::uint32_t other) const {
        const auto [enter, leave] =
            clip(patches_[other].plane.to_plane(p.at), patches_[other].plane.to_plane(q.at), seen, 0, 1);
        return enter <= leave;
    }

    // The part of the line that a slice says something of; ends before it begins where there is none.
    std::array<double, 2> seen_part(const Line& line, std::uint32_t slice) const {
        const Plane& plane = patches_[slice].plane;
        constexpr double infinity = std::numeric_limits<double>::infinity();
        return clip(plane.to_plane(line.at(0)), plane.to_plane(line.at(1)),
                    patches_[slice].box.grown(margin_), -infinity, infinity);
    }

    // From where to where, in shares of the way between two places, a line lies in a box; cut to a part of
    // it.
    static std::array<double, 2> clip(Vec2 from, Vec2 to, const Box2& box, double enter, double leave) {
        const auto cut = [&](double start, double along, double low, double high) {
            if (along == 0) {
                if (start < low || start > high) leave = -std::numeric_limits<double>::infinity();
                return;
            }
            const double u = (low - start) / along, v = (high - start) / along;
            enter = std::max(enter, std::min(u, v));
            leave = std::min(leave, std::max(u, v));
        };
        cut(from.x, to.x - from.x, box.low.x, box.high.x);
        cut(from.y, to.y - from.y, box.low.y, box.high.y);
        return {enter, leave};
    }

    static void match(LineComparison& comparison) {
        std::vector<double> a, b;
        for (const IntervalEndpoint& end : comparison.endpoints_a) a.push_back(end.t);
        for (const IntervalEndpoint& end : comparison.endpoints_b) b.push_back(end.t);
        comparison.matching = match_intervals(a, b);
        comparison.difference_mm = symmetric_difference(a, b);
    }

    const ContourSet& set_;
    const std::vector<PlanePatch>& patches_;
    const double margin_;
    const std::vector<std::vector<Block>> blocks_;
};

}  // namespace

Line common_line(const Plane& a, const Plane& b, Vec3 near) {
    const Vec3 direction = cross(a.normal, b.normal);
    const double square = squared_length(direction);
    // From `near` by a multiple of each normal onto both planes.
    const double ha = -a.signed_distance(near), hb = -b.signed_distance(near), c = dot(a.normal, b.normal);
    const double x = (ha - c * hb) / square, y = (hb - c * ha) / square;
    return {near + x * a.normal + y * b.normal, (1 / std::sqrt(square)) * direction};
}

std::vector<LineComparison> compare_planes(const ContourSet& set, const std::vector<PlanePatch>& patches,
                                           const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
                                           double margin, RunContext& context) {
    const Comparer comparer(set, patches, margin);
    std::vector<std::vector<LineComparison>> found(pairs.size());
    parallel_for(pairs.size(), 64, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && !context.cancelled(); ++i) {
            found[i] = comparer.compare(pairs[i].first, pairs[i].second);
        }
    });
    std::vector<LineComparison> comparisons;
    for (auto& of_pair : found) {
        for (LineComparison& comparison : of_pair) comparisons.push_back(std::move(comparison));
    }
    return comparisons;
}

double total_difference_mm(std::span<const LineComparison> comparisons) {
    double total = 0;
    for (const LineComparison& comparison : comparisons) total += comparison.difference_mm;
    return total;
}

}  // namespace anatomesh
