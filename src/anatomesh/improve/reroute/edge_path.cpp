#include "anatomesh/improve/reroute/edge_path.h"

#include <algorithm>
#include <cstddef>
#include <queue>
#include <utility>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/improve/reroute/contour_loop.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_seen = 20'000;  // for a way: beside a segment there are a few [vertices; > 0; B]
constexpr double least_distance = 1e-3;    // in most_mm: of ways as near, the shorter one [1; > 0; D]
// of a step back [1; > 1; M 2026-11 dense freehand planes]
constexpr double backwards_price = 100;

}  // namespace

void EdgePathSearch::begin(std::vector<std::uint32_t> stretch) {
    stretch_ = std::move(stretch);
    stretch_places_ = places(stretch_);
}

std::optional<std::vector<std::uint32_t>> EdgePathSearch::find(
    EdgePathRule rule, std::span<const Segment> beside, const std::function<bool(std::uint32_t)>& may_pass) {
    if (!reach_end(rule, beside, may_pass)) return std::nullopt;
    std::vector<std::uint32_t> between;
    for (std::uint32_t v = reached_.at(stretch_.back()).from; v != stretch_.front(); v = reached_.at(v).from)
        between.push_back(v);
    std::reverse(between.begin(), between.end());
    return between;
}

bool EdgePathSearch::reach_end(EdgePathRule rule, std::span<const Segment> beside,
                               const std::function<bool(std::uint32_t)>& may_pass) {
    const std::uint32_t a = stretch_.front(), b = stretch_.back();
    const Vec3 forward = points_[b] - points_[a];
    using Step = std::pair<double, std::uint32_t>;
    std::priority_queue<Step, std::vector<Step>, std::greater<>> queue;
    reached_.clear();
    reached_[a].price = 0;
    queue.push({0, a});
    while (!queue.empty() && reached_.size() <= most_seen) {
        const std::uint32_t v = queue.top().second;
        queue.pop();
        if (std::exchange(reached_.at(v).is_done, true)) continue;
        if (v == b) return true;
        const Reached here = reached_.at(v);
        for (const std::uint32_t w : graph_.neighbors(v)) {
            const Vec3 step = points_[w] - points_[v];
            if (!may_pass(w) || (rule == EdgePathRule::onwards && dot(step, forward) <= 0) ||
                (rule == EdgePathRule::clear && crosses_any(v, w, beside)))
                continue;
            const auto [found, is_new] = reached_.try_emplace(w);
            Reached& there = found->second;
            if (is_new) there.distance = distance_from_stretch(w);
            if (there.is_done || there.distance > most_mm_) continue;
            const double mean = 0.5 * (here.distance + there.distance) + least_distance * most_mm_;
            const bool is_dear = rule == EdgePathRule::clear && dot(step, forward) < 0;
            const double price = here.price + mean * length(step) * (is_dear ? backwards_price : 1);
            if (!(price < there.price)) continue;
            there.price = price;
            there.from = v;
            queue.push({price, w});
        }
    }
    return false;
}

// Whether the edge, seen along the slice's normal, meets a segment elsewhere than at a common vertex.
bool EdgePathSearch::crosses_any(std::uint32_t v, std::uint32_t w, std::span<const Segment> beside) const {
    const Vec2 p = at(v), q = at(w);
    return std::any_of(beside.begin(), beside.end(), [&](const Segment& segment) {
        const auto& [a, b] = segment;
        if (a == v || a == w || b == v || b == w) return false;
        const Vec2 s = at(a), t = at(b);
        return orient2d(p, q, s) * orient2d(p, q, t) <= 0 && orient2d(s, t, p) * orient2d(s, t, q) <= 0;
    });
}

double EdgePathSearch::distance_from_stretch(std::uint32_t v) const {
    return length(points_[v] - nearest_on_row(stretch_places_, points_[v]));
}

bool EdgePathSearch::are_edges(std::span<const std::uint32_t> between) const {
    std::uint32_t before = stretch_.front();
    for (std::size_t k = 0; k <= between.size(); ++k) {
        const std::uint32_t v = k < between.size() ? between[k] : stretch_.back();
        const std::span<const std::uint32_t> joined = graph_.neighbors(before);
        if (std::find(joined.begin(), joined.end(), v) == joined.end()) return false;
        before = v;
    }
    return true;
}

double EdgePathSearch::farthest(std::span<const std::uint32_t> between) const {
    std::vector<std::uint32_t> row{stretch_.front()};
    row.insert(row.end(), between.begin(), between.end());
    row.push_back(stretch_.back());
    return distance_of_rows(stretch_places_, places(row));
}

std::vector<Vec3> EdgePathSearch::places(std::span<const std::uint32_t> vertices) const {
    std::vector<Vec3> all;
    for (const std::uint32_t v : vertices) all.push_back(points_[v]);
    return all;
}

}  // namespace anatomesh
