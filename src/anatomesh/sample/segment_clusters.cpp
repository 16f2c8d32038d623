#include "anatomesh/sample/segment_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <functional>
#include <queue>

#include "anatomesh/base/sort_distinct.h"

namespace anatomesh {

namespace {

// It stands for no apex. [index that no vertex has; 0xFFFFFFFF; D]
constexpr std::uint32_t no_apex = 0xFFFFFFFFu;
// The squared sine of the angle between subsegments of one segment is below this. [1; 0 to 1e-12; D rounding of doubles]
constexpr double straight = 1e-18;
// The cosine between a subsegment and the way to it from a pole is above this. [1; 0 to 1; M 2026-11 skin of a head, 36 and 60 planes]
constexpr double least_cosine = 0.9;
// Four planes that meet in a line make so many ways. [ways; >= 3; D]
constexpr std::ptrdiff_t ways_at_pole = 8;

// Whether the way from one point to another leads on from the apex: straight, or from a pole about so.
bool leads_on(Vec3 apex, Vec3 from, Vec3 to, bool is_pole) {
    const Vec3 way = from - apex, next = to - from;
    const double along = dot(way, next), squares = squared_length(way) * squared_length(next);
    if (is_pole) return along >= least_cosine * std::sqrt(squares);
    return along > 0 && squared_length(cross(way, next)) <= straight * squares;
}

}  // namespace

SegmentClusters::SegmentClusters(std::span<const Vec3> points, const std::vector<Subsegment>& subsegments,
                                 std::vector<std::uint32_t> acute)
    : acute_(std::move(acute)) {
    std::uint32_t balls = 0;
    for (const Subsegment& subsegment : subsegments) balls = std::max(balls, subsegment.ball + 1);
    of_ball_.assign(balls, no_apex);
    // By an end: the other one, and the ball.
    std::vector<std::array<std::uint32_t, 3>> at;
    for (const Subsegment& subsegment : subsegments) {
        at.push_back({subsegment.a, subsegment.b, subsegment.ball});
        at.push_back({subsegment.b, subsegment.a, subsegment.ball});
    }
    sort_distinct(at);
    const auto ends_at = [&](std::uint32_t v) {
        return std::equal_range(at.begin(), at.end(), std::array{v, 0u, 0u},
                                [](const auto& x, const auto& y) { return x[0] < y[0]; });
    };
    // The nearest to an apex first: where two ways meet each has its half.
    struct Way {
        double reached;
        std::uint32_t apex, from, to, ball;
        auto operator<=>(const Way&) const = default;
    };
    std::priority_queue<Way, std::vector<Way>, std::greater<>> ways;
    for (const std::uint32_t apex : acute_) {
        const auto [first, last] = ends_at(apex);
        for (auto way = first; way != last; ++way) ways.push({0, apex, apex, (*way)[1], (*way)[2]});
    }
    while (!ways.empty()) {
        const auto [reached, apex, from, to, ball] = ways.top();
        ways.pop();
        if (is_apex(to) || of_ball_[ball] != no_apex) continue;
        of_ball_[ball] = apex;
        const auto [first, last] = ends_at(apex);
        const bool is_pole = last - first >= ways_at_pole;
        const auto [next, end] = ends_at(to);
        const auto ahead =
            std::find_if(next, end, [&, back = from, at = to, begin = apex](const auto& subsegment) {
                return subsegment[1] != back &&
                       leads_on(points[begin], points[at], points[subsegment[1]], is_pole);
            });
        if (ahead != end) ways.push({length(points[to] - points[apex]), apex, to, (*ahead)[1], (*ahead)[2]});
    }
}

std::optional<std::uint32_t> SegmentClusters::of(const Subsegment& subsegment) const {
    if (of_ball_.empty() || of_ball_[subsegment.ball] == no_apex) return std::nullopt;
    return of_ball_[subsegment.ball];
}

void SegmentClusters::pass_on(const Subsegment& subsegment, std::uint32_t low, std::uint32_t high) {
    if (of_ball_.empty()) return;
    of_ball_.resize(std::max<std::size_t>(of_ball_.size(), std::max(low, high) + 1), no_apex);
    of_ball_[low] = of_ball_[high] = of_ball_[subsegment.ball];
    if (of_ball_[subsegment.ball] != no_apex) return;
    if (is_apex(subsegment.a)) of_ball_[low] = subsegment.a;
    if (is_apex(subsegment.b)) of_ball_[high] = subsegment.b;
}

bool SegmentClusters::is_apex(std::uint32_t vertex) const {
    return std::binary_search(acute_.begin(), acute_.end(), vertex);
}

}  // namespace anatomesh
