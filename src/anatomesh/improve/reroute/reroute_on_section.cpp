#include "anatomesh/improve/reroute/reroute_on_section.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/reroute/reroute_attempt.h"
#include "anatomesh/improve/reroute/rerouted_contours.h"
#include "anatomesh/improve/reroute/section_path.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_missed =
    1000;  // where more are, the cells do not fit the contours [segments; > 0; B]
constexpr std::size_t most_attempts = 400;  // to re-route segments [attempts; > 0; B]
constexpr int contour_rounds = 3;           // over the contours: one may need that beside it [passes; > 0; B]
// No more missed segments than these may ask for worse shapes. [segments; >= 0; M 2026-11 skull mask]
constexpr std::size_t last_missed = 10;
// Share of an edge that a way crosses: a free end as near as that moves onto the way. Tried in turn.
// [1; 0 to 0.5; M 2026-11 282 random sets of planes that cross or lean]
constexpr std::array nearness{0.3, 0.5, 0.1};

// When a segment was tried in vain last.
struct TriedSegment {
    std::vector<std::uint32_t> reach = {};  // vertices where a way might have ended; rising
    std::size_t changed_before = 0;         // cells, before it
};

class SectionRerouting {
  public:
    SectionRerouting(EditContext& edit, const DrawnSlices& drawn, std::span<std::uint8_t> constraint_limited,
                     double least_sine, double last_sine, const ImproveCells& improve,
                     const RunContext& context)
        : edit_(edit),
          drawn_(drawn),
          constraint_limited_(constraint_limited),
          contours_(edit, drawn.routable),
          search_(edit, drawn.routable, contours_),
          least_sine_(least_sine),
          last_sine_(last_sine),
          improve_(improve),
          context_(context) {}

    RerouteStats run() {
        RerouteStats stats;
        stats.missed = contours_.missed_at_first();
        if (stats.missed == 0 || stats.missed > most_missed) return stats;
        contours_.find_vertices();
        route_all();
        std::size_t left = 0;
        for (const ReroutedContour& contour : contours_.contours()) left += contours_.count_missed(contour);
        if (left > 0 && left <= last_missed) {
            least_sine_ = std::min(least_sine_, last_sine_);
            tried_.clear();
            attempts_ = 0;
            route_all();
        }
        for (const ReroutedContour& contour : contours_.contours()) {
            if (!contour.is_rerouted || contours_.is_as_drawn(contour)) continue;
            RoutedContour& routed = stats.routed.emplace_back(
                RoutedContour{contour.number, {}, contour.segments, contour.farthest_mm});
            for (std::size_t n = 0; n < contour.loop.size(); ++n)
                routed.vertices.push_back(contour.loop.corner(n).vertex);
        }
        stats.changed = std::move(changed_);
        return stats;
    }

  private:
    void route_all() {
        for (int round = 0; round < contour_rounds; ++round) {
            bool any = false;
            for (ReroutedContour& contour : contours_.contours()) any |= route(contour);
            if (!any) break;
        }
    }

    // Whether any of it was re-routed.
    bool route(ReroutedContour& contour) {
        bool any = false;
        for (std::size_t n = 0; n < contour.loop.size() && attempts_ < most_attempts; ++n) {
            if (context_.cancelled() || !contours_.is_missed(contour, n)) continue;
            const std::size_t before = contours_.count_missed(contour);
            const PathEnds here = search_.ends(contour, n, -1), there = search_.ends(contour, n, 1);
            if (is_known_to_fail(contour, n, here, there)) continue;
            if (std::none_of(nearness.begin(), nearness.end(), [&](double near) {
                    ++attempts_;
                    return attempt(contour, here, there, near);
                }))
                continue;
            contour.segments += before - std::min(before, contours_.count_missed(contour));
            contour.is_rerouted = any = true;
        }
        return any;
    }

    // Whether the segment was tried when no cell at its surroundings was another one; notes that it is tried.
    bool is_known_to_fail(const ReroutedContour& contour, std::size_t n, const PathEnds& here,
                          const PathEnds& there) {
        TriedSegment& tried =
            tried_[{contour.loop.corner(n).vertex, contour.loop.corner(n + 1).vertex, contour.number}];
        const bool fails =
            !tried.reach.empty() &&
            std::none_of(changed_.begin() + static_cast<std::ptrdiff_t>(tried.changed_before), changed_.end(),
                         [&](std::uint32_t c) {
                             const Cell& cell = edit_.mesh.cell(c);
                             return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) {
                                 return std::binary_search(tried.reach.begin(), tried.reach.end(), v);
                             });
                         });
        tried.changed_before = changed_.size();
        tried.reach.clear();
        for (const PathEnds* const ends : {&here, &there}) {
            for (const WayEnd& end : ends->ends) tried.reach.push_back(end.vertex);
        }
        sort_distinct(tried.reach);
        return fails;
    }

    bool attempt(ReroutedContour& contour, const PathEnds& here, const PathEnds& there, double near) {
        std::optional<SectionPath> path = search_.find(contour, here, there);
        if (!path) return false;
        const MeshImprovementStats stats = edit_.stats;
        edit_.mesh.begin_attempt();
        RerouteAttempt attempt(edit_, drawn_, constraint_limited_, contours_, least_sine_, improve_);
        while (path && attempt.move_near(*path, near)) path = search_.find(contour, here, there);
        ContourLoop loop = contour.loop;
        const bool good =
            path && attempt.make_edges(*path, contour.contour.structure) && attempt.settle(contour, *path) &&
            contours_.replace(contour, {path->from, path->to, attempt.vertices(), path->places()}, loop);
        edit_.mesh.end_attempt(good);
        if (!good) {
            attempt.take_back();
            edit_.stats = stats;
            return false;
        }
        contour.loop = std::move(loop);
        contour.farthest_mm = std::max(contour.farthest_mm, path->farthest_mm);
        changed_.insert(changed_.end(), attempt.changed().begin(), attempt.changed().end());
        attempt.keep(contour.contour);
        return true;
    }

    EditContext& edit_;
    const DrawnSlices& drawn_;
    std::span<std::uint8_t> constraint_limited_;
    ReroutedContours contours_;
    SectionPathSearch search_;
    double least_sine_, last_sine_;  // of cells inside that no contour forces
    const ImproveCells& improve_;
    const RunContext& context_;
    std::size_t attempts_ = 0;
    std::map<std::array<std::uint32_t, 3>, TriedSegment> tried_;  // by ends and contour
    std::vector<std::uint32_t> changed_;                          // cells
};

}  // namespace

RerouteStats reroute_on_section(EditContext& edit, const DrawnSlices& drawn,
                                std::span<std::uint8_t> constraint_limited, double least_sine,
                                double last_sine, const ImproveCells& improve, const RunContext& context) {
    if (!drawn.table || !drawn.owners || drawn.routable.contours.empty() || !(drawn.routable.most_mm > 0))
        return {};
    return SectionRerouting(edit, drawn, constraint_limited, least_sine, last_sine, improve, context).run();
}

}  // namespace anatomesh
