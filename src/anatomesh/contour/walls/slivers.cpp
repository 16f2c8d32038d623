#include "anatomesh/contour/walls/slivers.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "anatomesh/contour/walls/conflated_contours.h"
#include "anatomesh/contour/walls/loop_meetings.h"
#include "anatomesh/contour/walls/loop_stretches.h"
#include "anatomesh/contour/walls/other_slices.h"
#include "anatomesh/contour/walls/sliver_between.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// So much of the slivers' area may change beyond each of their two ends. [1; 0 to 1; M 2026-11 random solids that touch]
constexpr double least_area = 0.1;
// A crossing so near to the end of its segment gets no vertex. [segment lengths; 0 to 0.5; M 2026-11 random solids that touch]
constexpr double beside_a_vertex = 0.1;

class SliceSlivers : public ConflatedContours {
  public:
    // `boxes`: boxes_of_slices().
    SliceSlivers(const ContourSet& set, std::uint32_t slice, const std::vector<Box3>& boxes,
                 const CloseSliversOptions& options)
        : ConflatedContours(set, set.slices[slice]),
          options_(options),
          plane_(set.slices[slice].plane),
          drawn_points_(points_.size()),
          stretches_(loops_, at_),
          other_slices_(set, slice, boxes) {}

    void close() {
        if (loops_.empty() || loops_.front().structure == loops_.back().structure) return;
        for (const ConflatedContour& loop : loops_) {
            std::vector<Vec2> polygon;
            for (const std::uint32_t v : loop.drawn) polygon.push_back(at_[v]);
            drawn_.add(std::move(polygon));
        }
        const std::vector<Meeting> all = find_meetings(loops_, at_);
        for (std::size_t first = 0, last = 0; first < all.size(); first = last) {
            while (last < all.size() && all[last].loops == all[first].loops) ++last;
            find_runs({all.begin() + static_cast<std::ptrdiff_t>(first),
                       all.begin() + static_cast<std::ptrdiff_t>(last)});
        }
        given_up_.assign(runs_.size(), 0);
        give_up_hidden();
        do {
            lead();
        } while (give_up_what_does_not_serve());
    }

  private:
    // Slivers that follow one another: what is put into which loop.
    using Run = Insertions;

    // Meetings of two loops, in their order along the first.
    void find_runs(const std::vector<Meeting>& all) {
        const std::size_t count = all.size();
        if (count < 2) return;
        std::vector<std::size_t> order(count), rank(count);
        for (std::size_t k = 0; k < count; ++k) order[k] = k;
        std::sort(order.begin(), order.end(), [&](std::size_t p, std::size_t q) {
            return std::tuple{all[p].along_second, p} < std::tuple{all[q].along_second, q};
        });
        for (std::size_t k = 0; k < count; ++k) rank[order[k]] = k;
        // From each meeting to the next one along the first loop: whether a sliver lies there.
        std::vector<std::uint8_t> closes(count, 0);
        std::vector<Run> slivers(count);
        std::vector<double> areas(count, 0);
        for (std::size_t k = 0; k < count; ++k) {
            const std::size_t next = (k + 1) % count;
            if ((rank[next] + 1) % count != rank[k]) continue;
            const Stretch first =
                              stretches_.between(all[k].loops[0], all[k].along_first, all[next].along_first),
                          second = stretches_.between(all[k].loops[1], all[next].along_second,
                                                      all[k].along_second);
            std::optional<Insertions> sliver = sliver_between(stretches_, first, second, options_);
            if (!sliver) continue;
            slivers[k] = std::move(*sliver);
            const std::vector<Vec2> ring = stretches_.ring_between(first, second);
            closes[k] = !other_slices_.cross(ring, {place_of(all[k].vertex), place_of(all[next].vertex)}) &&
                        !lies_in_a_third(slivers[k], {first.loop, second.loop});
            areas[k] = std::abs(signed_area(ring));
        }
        const auto open = std::find(closes.begin(), closes.end(), 0);
        const auto begin = static_cast<std::size_t>(open - closes.begin()) % count;
        for (std::size_t n = 0; n < count;) {
            const std::size_t first = (begin + n) % count;
            Run run;
            std::size_t length = 0;
            double area = 0;
            for (; n < count && closes[(begin + n) % count]; ++n, ++length) {
                const std::size_t k = (begin + n) % count;
                run.insert(run.end(), slivers[k].begin(), slivers[k].end());
                area += areas[k];
            }
            if (!run.empty()) {
                if (length < count) {
                    end_at(all[first], true, area, run);
                    end_at(all[(first + length) % count], false, area, run);
                }
                runs_.push_back(std::move(run));
            }
            if (length == 0) ++n;
        }
    }

    // A crossing at which slivers end becomes a vertex of both loops; or a vertex of theirs beside it does,
    // where that changes little beyond them. `is_start`: along the first loop.
    void end_at(const Meeting& meeting, bool is_start, double area_mm2, Run& run) {
        if (meeting.vertex != no_vertex) return;
        const std::array<CrossingSide, 2> sides{side_at(meeting.loops[0], meeting.along_first, is_start),
                                                side_at(meeting.loops[1], meeting.along_second, !is_start)};
        std::uint32_t vertex = no_vertex;
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t n = 0; n < 2; ++n) {
            for (const std::uint32_t v : sides[n].ends) {
                const double apart = length(at_[v] - sides[n].crossing);
                if (apart >= std::min(nearest, beside_a_vertex * sides[n].length_mm)) continue;
                // The other loop is led to it, from its drawn vertex beyond the crossing.
                const CrossingSide& other = sides[1 - n];
                const double height =
                    std::abs(cross(at_[v] - other.crossing, at_[other.ends[1]] - at_[other.ends[0]])) /
                    other.length_mm;
                if (height * length(at_[other.beyond] - other.crossing) > 2 * least_area * area_mm2 ||
                    other_slices_.cross({at_[other.beyond], other.crossing, at_[v]}, {}))
                    continue;
                nearest = apart;
                vertex = v;
            }
        }
        if (vertex == no_vertex) vertex = made_at(sides[0].place, sides[0].share);
        for (const CrossingSide& side : sides) {
            const bool is_there =
                has(side.ends, vertex) || std::any_of(run.begin(), run.end(), [&](const Beside& x) {
                    return x.vertex == vertex && x.loop == side.place[0];
                });
            if (!is_there) run.push_back({vertex, side.place[0], side.place[1], side.share, 0});
        }
    }

    // Of a crossing, one of the two loops.
    struct CrossingSide {
        Place place{};
        double share = 0, length_mm = 0;  // of the segment there
        Edge ends{};
        std::uint32_t beyond = 0;  // the end that is not of the sliver
        Vec2 crossing;
    };
    CrossingSide side_at(std::uint32_t l, double along_loop, bool begins) const {
        const ConflatedContour& loop = loops_[l];
        const double whole = std::min(std::floor(along_loop), static_cast<double>(loop.vertices.size()) - 1);
        const auto n = static_cast<std::uint32_t>(whole);
        CrossingSide side{{l, n}, along_loop - whole, 0, {loop.vertices[n], loop.next_of(n)}, 0, {}};
        const Vec2 a = at_[side.ends[0]], b = at_[side.ends[1]];
        side.length_mm = length(b - a);
        side.beyond = side.ends[begins ? 0 : 1];
        side.crossing = a + side.share * (b - a);
        return side;
    }

    // Whether a third structure is drawn in the sliver but not on both sides of it, or beside it alone: what
    // is closed there would come to lie in it, or leave it.
    bool lies_in_a_third(const Run& sliver, Edge of_loops) const {
        for (const Beside& x : sliver) {
            const Vec2 a = at_[loops_[x.loop].vertices[x.segment]],
                       b = at_[loops_[x.loop].next_of(x.segment)];
            const Vec2 v = at_[x.vertex];
            const Vec2 way = a + std::clamp(along(v, a, b), 0.0, 1.0) * (b - a) - v;
            for (std::size_t first = 0; first < loops_.size(); first = end_of_structure(first)) {
                const std::uint32_t structure = loops_[first].structure;
                if (structure == loops_[of_loops[0]].structure || structure == loops_[of_loops[1]].structure)
                    continue;
                const auto is_inside = [&](double share) {
                    return drawn_.is_inside(first, end_of_structure(first), v + share * way);
                };
                const bool inside = is_inside(0.5);
                if (inside != is_inside(-0.25) || inside != is_inside(1.25)) return true;
            }
        }
        return false;
    }
    std::uint32_t made_at(Place place, double share) {
        const ConflatedContour& loop = loops_[place[0]];
        const Vec3 a = points_[loop.vertices[place[1]]], b = points_[loop.next_of(place[1])];
        const Vec3 p = a + share * (b - a);
        const auto same =
            std::find(points_.begin() + static_cast<std::ptrdiff_t>(drawn_points_), points_.end(), p);
        if (same != points_.end()) return static_cast<std::uint32_t>(same - points_.begin());
        points_.push_back(p);
        at_.push_back(plane_.to_plane(p));
        return static_cast<std::uint32_t>(points_.size() - 1);
    }

    // Runs in which a contour lies between a vertex and where it is put.
    void give_up_hidden() {
        std::vector<Edge> segments;
        for (const ConflatedContour& loop : loops_) {
            for (std::size_t n = 0; n < loop.vertices.size(); ++n)
                segments.push_back({loop.vertices[n], loop.next_of(n)});
        }
        std::vector<Way> ways;
        std::vector<std::size_t> run_of;
        for (std::size_t r = 0; r < runs_.size(); ++r) {
            for (const Beside& x : runs_[r]) {
                if (x.distance == 0) continue;
                const Edge to{loops_[x.loop].vertices[x.segment], loops_[x.loop].next_of(x.segment)};
                ways.push_back({at_[x.vertex], to, {to}, x.vertex});
                run_of.push_back(r);
            }
        }
        const std::vector<std::uint8_t> unseen = hidden(ways, segments);
        for (std::size_t n = 0; n < ways.size(); ++n) given_up_[run_of[n]] |= unseen[n];
    }

    // From the drawn loops, with all runs that are not given up.
    void lead() {
        for (ConflatedContour& loop : loops_) loop.vertices = loop.origin = loop.drawn;
        std::vector<Beside> all;
        for (std::size_t r = 0; r < runs_.size(); ++r) {
            if (!given_up_[r]) all.insert(all.end(), runs_[r].begin(), runs_[r].end());
        }
        put_in(std::move(all));
    }

    // Runs that made contours of a structure touch or cross one another, turn inside out or lie otherwise in
    // each other, go through a vertex twice, or change too much of an area. Says whether there were any.
    bool give_up_what_does_not_serve() {
        std::vector<std::array<std::uint32_t, 3>> takers;  // loop, vertex, run
        for (std::uint32_t r = 0; r < runs_.size(); ++r) {
            for (const Beside& x : runs_[r])
                if (!given_up_[r]) takers.push_back({x.loop, x.vertex, r});
        }
        std::sort(takers.begin(), takers.end());
        bool any = false;
        const auto give_up = [&](std::uint32_t loop, std::uint32_t v) {
            for (auto t = std::lower_bound(takers.begin(), takers.end(), std::array{loop, v, 0u});
                 t != takers.end() && (*t)[0] == loop && (*t)[1] == v; ++t) {
                any = any || !given_up_[(*t)[2]];
                given_up_[(*t)[2]] = 1;
            }
        };
        const auto give_up_all = [&](const std::vector<Place>& places) {
            for (const auto& [l, n] : places) give_up(l, loops_[l].vertices[n]);
        };
        for (std::size_t first = 0; first < loops_.size();) {
            const std::size_t last = end_of_structure(first);
            give_up_all(touching(first, last));
            if (!any) give_up_all(turned_or_nested(first, last));
            first = last;
        }
        for (std::size_t first = 0, last = 0; !any && first < loops_.size(); first = last) {
            last = end_of_structure(first);
            double area = 0, changed = 0;
            for (std::size_t l = first; l < last; ++l) {
                area += drawn_.area(l);
                if (loops_[l].vertices.size() > loops_[l].drawn.size())
                    changed += change_of(loops_[l]).area_mm2;
            }
            if (changed <= options_.most_of_area * std::abs(area)) continue;
            for (std::size_t l = first; l < last; ++l) {
                for (std::size_t n = 0; n < loops_[l].vertices.size(); ++n)
                    if (loops_[l].taken(n)) give_up(static_cast<std::uint32_t>(l), loops_[l].vertices[n]);
            }
        }
        return any;
    }

    std::optional<Vec2> place_of(std::uint32_t v) const {
        return v == no_vertex ? std::nullopt : std::optional(at_[v]);
    }

    const CloseSliversOptions& options_;
    const Plane plane_;
    const std::size_t drawn_points_;
    const LoopStretches stretches_;
    const OtherSlices other_slices_;
    DrawnPolygons drawn_;
    std::vector<Run> runs_;
    std::vector<std::uint8_t> given_up_;  // by run
};

}  // namespace

ConflationStats close_slivers(ContourSet& set, const CloseSliversOptions& options) {
    assert(options.width_mm >= 0 && options.width_mm <= 10);
    assert(options.share_of_segment >= 0 && options.share_of_segment <= 0.5);
    assert(options.most_of_area >= 0 && options.most_of_area <= 1);
    ConflationStats stats;
    if (options.width_mm == 0 || options.share_of_segment == 0 || set.structures.size() < 2) return stats;
    const std::vector<Box3> boxes = boxes_of_slices(set);
    lead_slices(set, stats, [&](std::uint32_t s) {
        SliceSlivers slivers(set, s, boxes, options);
        slivers.close();
        return static_cast<ConflatedContours>(std::move(slivers));
    });
    return stats;
}

}  // namespace anatomesh
