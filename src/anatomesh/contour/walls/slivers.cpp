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

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/contour/walls/conflated_contours.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_vertices = 3;    // of either contour in a sliver: more are no chords of one line
constexpr double on_other_slice_mm = 0.01;  // of another slice
constexpr double least_area = 0.1;          // of slivers: so much may change beyond each of their two ends
constexpr double beside_a_vertex = 0.1;     // of a segment: a crossing so near to its end gets no vertex

// Where two loops meet: how far along either, the n-th vertex at n.
struct Meeting {
    std::array<std::uint32_t, 2> loops{};
    double along_first = 0, along_second = 0;
    std::uint32_t vertex = no_vertex;  // the common one; none where they cross

    auto key() const { return std::tuple{loops, along_first, along_second}; }
};

// A part of a loop: segments from this number on, the first from a share of it on and the last to one, and
// the vertices between them.
struct Stretch {
    std::uint32_t loop = 0;
    std::size_t start = 0, segments = 0;
    double from = 0, to = 1;  // of the first and of the last segment
    std::size_t vertices() const { return segments - 1; }
};

// The stretches of a slice's loops, with the loops and the places of their vertices in the slice's plane.
class LoopStretches {
  public:
    LoopStretches(const std::vector<ConflatedContour>& loops, const std::vector<Vec2>& at)
        : loops_(loops), at_(at) {}

    // Between two places on a loop, over its start where the second is before the first.
    Stretch between(std::uint32_t loop, double from, double to) const {
        const double end = to < from ? to + static_cast<double>(loops_[loop].vertices.size()) : to;
        const double start = std::floor(from), behind = std::max(std::ceil(end), start + 1);
        return {loop, static_cast<std::size_t>(start), static_cast<std::size_t>(behind - start), from - start,
                1 - (behind - end)};
    }
    std::uint32_t number(const Stretch& part, std::size_t k) const {
        return static_cast<std::uint32_t>((part.start + k) % loops_[part.loop].vertices.size());
    }
    std::uint32_t vertex(const Stretch& part, std::size_t k) const {
        return loops_[part.loop].vertices[number(part, k + 1)];
    }
    Segment2 segment(const Stretch& part, std::size_t k) const {
        const std::uint32_t n = number(part, k);
        return {at_[loops_[part.loop].vertices[n]], at_[loops_[part.loop].next_of(n)]};
    }
    double length_of(const Stretch& part, std::size_t k) const {
        return length(segment(part, k).b - segment(part, k).a);
    }

    // Of the segments between its vertices; of those at its ends where there are no others.
    double mean_segment(const Stretch& part) const {
        const bool inner = part.segments > 2;
        double sum = 0;
        for (std::size_t k = inner; k + inner < part.segments; ++k) sum += length_of(part, k);
        return sum / static_cast<double>(part.segments - 2 * inner);
    }

    // The place on a stretch that is nearest to a point.
    struct PlaceOn {
        std::size_t segment = 0;
        double share = 0, apart = std::numeric_limits<double>::infinity();
    };
    PlaceOn nearest_place(const Stretch& part, Vec2 p) const {
        PlaceOn best;
        for (std::size_t k = 0; k < part.segments; ++k) {
            const auto [a, b] = segment(part, k);
            const double low = k == 0 ? part.from : 0, high = k + 1 == part.segments ? part.to : 1;
            const double share = std::clamp(ConflatedContours::along(p, a, b), low, high);
            const double apart = length(p - (a + share * (b - a)));
            if (apart < best.apart) best = {k, share, apart};
        }
        return best;
    }

    // Between two stretches that run against each other.
    std::vector<Vec2> ring_between(const Stretch& first, const Stretch& second) const {
        std::vector<Vec2> ring;
        for (const Stretch& part : {first, second}) {
            const Segment2 here = segment(part, 0);
            ring.push_back(here.a + part.from * (here.b - here.a));
            for (std::size_t k = 0; k < part.vertices(); ++k) ring.push_back(at_[vertex(part, k)]);
        }
        return ring;
    }

  private:
    const std::vector<ConflatedContour>& loops_;
    const std::vector<Vec2>& at_;
};

// The planes of a set beside that of one slice.
class OtherSlices {
  public:
    // `patches`: of all slices.
    OtherSlices(const ContourSet& set, std::uint32_t slice, const std::vector<Box3>& patches)
        : set_(set), slice_(slice), patches_(patches) {}

    using Ends = std::array<std::optional<Vec2>, 2>;
    // Whether another slice passes through it: the two agree as drawn, or are made to. One that passes
    // through no more of it than common vertices at its ends, which stay as they are, does not.
    bool cross(const std::vector<Vec2>& ring, const Ends& ends) const {
        std::vector<Vec3> corners;
        Box3 box;
        for (const Vec2 p : ring) {
            corners.push_back(set_.slices[slice_].plane.to_space(p));
            box.extend(corners.back());
        }
        for (std::uint32_t s = 0; s < set_.slices.size(); ++s) {
            if (s == slice_ || !meet(box, patches_[s])) continue;
            const Plane& other = set_.slices[s].plane;
            double low = std::numeric_limits<double>::infinity(), high = -low;
            for (std::size_t k = 0; k < ring.size(); ++k) {
                const double height = other.signed_distance(corners[k]);
                const bool is_end = std::find(ends.begin(), ends.end(), ring[k]) != ends.end();
                if (is_end && std::abs(height) <= on_other_slice_mm) continue;
                low = std::min(low, height);
                high = std::max(high, height);
            }
            if (low <= on_other_slice_mm && high >= -on_other_slice_mm) return true;
        }
        return false;
    }

  private:
    const ContourSet& set_;
    const std::uint32_t slice_;
    const std::vector<Box3>& patches_;
};

// The loops of a slice as they are drawn.
class DrawnPolygons {
  public:
    void add(std::vector<Vec2> polygon) {
        Box2 box;
        for (const Vec2 p : polygon) box.extend(p);
        polygons_.push_back(std::move(polygon));
        boxes_.push_back(box);
    }
    double area(std::size_t loop) const { return signed_area(polygons_[loop]); }
    // Whether a point lies in the loops from the first on, up to the last, by the even-odd rule.
    bool is_inside(std::size_t first, std::size_t last, Vec2 p) const {
        bool inside = false;
        for (std::size_t l = first; l < last; ++l) {
            if (!boxes_[l].contains(p)) continue;
            inside ^= side_of_polygon(polygons_[l], p) == Side::inside;
        }
        return inside;
    }

  private:
    std::vector<std::vector<Vec2>> polygons_;
    std::vector<Box2> boxes_;
};

class SliceSlivers : public ConflatedContours {
  public:
    // `patches`: of all slices.
    SliceSlivers(const ContourSet& set, std::uint32_t slice, const std::vector<Box3>& patches,
                 const CloseSliversOptions& options)
        : ConflatedContours(set, set.slices[slice]),
          options_(options),
          plane_(set.slices[slice].plane),
          drawn_points_(points_.size()),
          stretches_(loops_, at_),
          other_slices_(set, slice, patches) {}

    void close() {
        if (loops_.empty() || loops_.front().structure == loops_.back().structure) return;
        for (const ConflatedContour& loop : loops_) {
            std::vector<Vec2> polygon;
            for (const std::uint32_t v : loop.drawn) polygon.push_back(at_[v]);
            drawn_.add(std::move(polygon));
        }
        const std::vector<Meeting> all = meetings();
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
    using Run = std::vector<Beside>;

    // Of loops of different structures, by loops and along the first, each once.
    std::vector<Meeting> meetings() const {
        PlacedSegments placed = segments_of_all();
        const std::vector<Place>& places = placed.places;
        std::vector<Meeting> all;
        SegmentIndex(std::move(placed.segments)).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            if (loops_[places[i][0]].structure != loops_[places[j][0]].structure)
                add_meetings(places[i], places[j], all);
            return true;
        });
        std::sort(all.begin(), all.end(),
                  [](const Meeting& p, const Meeting& q) { return p.key() < q.key(); });
        all.erase(std::unique(all.begin(), all.end(),
                              [](const Meeting& p, const Meeting& q) { return p.key() == q.key(); }),
                  all.end());
        return all;
    }

    // Places are in rising order, as their segments are in the index.
    void add_meetings(Place p, Place q, std::vector<Meeting>& all) const {
        const ConflatedContour &first = loops_[p[0]], &second = loops_[q[0]];
        const Edge own{first.vertices[p[1]], first.next_of(p[1])};
        const Edge other{second.vertices[q[1]], second.next_of(q[1])};
        bool common = false;
        for (std::uint32_t k = 0; k < 2; ++k) {
            for (std::uint32_t m = 0; m < 2; ++m) {
                if (own[k] != other[m]) continue;
                common = true;
                all.push_back({{p[0], q[0]},
                               static_cast<double>((p[1] + k) % first.vertices.size()),
                               static_cast<double>((q[1] + m) % second.vertices.size()),
                               own[k]});
            }
        }
        const Vec2 a = at_[own[0]], b = at_[own[1]], c = at_[other[0]], d = at_[other[1]];
        if (common || segment_contact(a, b, c, d) != SegmentContact::cross) return;
        const double across = cross(b - a, d - c);
        const auto share = [&](double part) {
            return across == 0 ? 0.5 : std::clamp(part / across, 0.0, 1.0);
        };
        all.push_back(
            {{p[0], q[0]}, p[1] + share(cross(c - a, d - c)), q[1] + share(cross(c - a, b - a)), no_vertex});
    }

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
            if (!close_between(first, second, slivers[k])) continue;
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

    // Whether what lies between two stretches that run against each other is a sliver; then what is to be put
    // into either is appended.
    bool close_between(const Stretch& first, const Stretch& second, Run& run) const {
        if (first.vertices() > most_vertices || second.vertices() > most_vertices) return false;
        const double width = std::min(
            options_.width_mm, options_.share_of_segment *
                                   std::min(stretches_.mean_segment(first), stretches_.mean_segment(second)));
        // The second's vertices from the first's start on, and where along the first they lie.
        std::vector<double> along_first;
        for (std::size_t k = second.vertices(); k-- > 0;) {
            const LoopStretches::PlaceOn place =
                stretches_.nearest_place(first, at_[stretches_.vertex(second, k)]);
            const double here = static_cast<double>(place.segment) + place.share;
            if (!(place.apart < width) || (!along_first.empty() && here < along_first.back())) return false;
            along_first.push_back(here);
        }
        for (std::size_t k = 0; k < first.vertices(); ++k)
            if (!(stretches_.nearest_place(second, at_[stretches_.vertex(first, k)]).apart < width))
                return false;
        // Both in one order, from the first's start on.
        std::vector<Shared> order;
        std::size_t own = 0;
        for (std::size_t m = 0; m < along_first.size(); ++m) {
            for (; own < first.vertices() && static_cast<double>(own + 1) < along_first[m]; ++own)
                order.push_back({stretches_.vertex(first, own), true});
            order.push_back({stretches_.vertex(second, second.vertices() - 1 - m), false});
        }
        for (; own < first.vertices(); ++own) order.push_back({stretches_.vertex(first, own), true});
        put_into(first, order, true, run);
        std::reverse(order.begin(), order.end());
        put_into(second, order, false, run);
        return true;
    }

    // Of the vertices of two stretches in one order: whether it is the first one's.
    struct Shared {
        std::uint32_t vertex = 0;
        bool of_first = false;
    };

    // Those of the other stretch into this one, evenly between its own.
    void put_into(const Stretch& part, const std::vector<Shared>& order, bool is_first, Run& run) const {
        std::size_t k = 0;  // the segment, by its own vertices so far
        for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end + 1, ++k) {
            for (end = begin; end < order.size() && order[end].of_first != is_first;) ++end;
            const double low = k == 0 ? part.from : 0, high = k + 1 == part.segments ? part.to : 1;
            const auto [a, b] = stretches_.segment(part, k);
            for (std::size_t n = begin; n < end; ++n) {
                const double share = low + (high - low) * static_cast<double>(n + 1 - begin) /
                                               static_cast<double>(end + 1 - begin);
                const std::uint32_t v = order[n].vertex;
                run.push_back(
                    {v, part.loop, stretches_.number(part, k), share, distance_to_segment(at_[v], a, b)});
            }
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
    std::vector<Box3> patches(set.slices.size());
    for (const Contour& contour : set.contours) {
        for (const Vec3& p : set.points_of(contour)) patches[contour.slice].extend(p);
    }
    lead_slices(set, stats, [&](std::uint32_t s) {
        SliceSlivers slivers(set, s, patches, options);
        slivers.close();
        return static_cast<ConflatedContours>(std::move(slivers));
    });
    return stats;
}

}  // namespace anatomesh
