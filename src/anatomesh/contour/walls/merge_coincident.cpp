#include "anatomesh/contour/walls/merge_coincident.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/contour/walls/conflated_contours.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {
namespace {

// Points that contours of several slices have. What not all of these slices would do with a point is forbidden.
class CommonPoints {
  public:
    using Structure = std::uint32_t;
    using Number = std::uint32_t;  // of a common point; no_vertex: a point of one slice

    explicit CommonPoints(const ContourSet& set) {
        std::vector<std::pair<Vec3, std::uint32_t>> all;
        for (const Contour& contour : set.contours) {
            for (const Vec3& p : set.points_of(contour)) all.emplace_back(p, contour.slice);
        }
        std::sort(all.begin(), all.end(), [](const auto& p, const auto& q) {
            return p.first != q.first ? lexicographic_less(p.first, q.first) : p.second < q.second;
        });
        all.erase(std::unique(all.begin(), all.end()), all.end());
        for (auto first = all.begin(); first != all.end();) {
            const auto last =
                std::find_if(first, all.end(), [&](const auto& x) { return x.first != first->first; });
            if (last - first > 1) {
                points_.push_back(first->first);
                slices_.push_back(static_cast<std::uint32_t>(last - first));
            }
            first = last;
        }
        stays_.assign(points_.size(), 0);
    }

    Number number_of(Vec3 p) const {
        const auto found = std::lower_bound(points_.begin(), points_.end(), p,
                                            [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); });
        return found != points_.end() && *found == p ? static_cast<Number>(found - points_.begin())
                                                     : no_vertex;
    }
    std::uint32_t slices(Number c) const { return c == no_vertex ? 1 : slices_[c]; }
    void forbid_all() { all_forbidden_ = true; }
    bool may_move(Number c) const { return c == no_vertex || (stays_[c] == 0 && !all_forbidden_); }
    bool may_get(Structure structure, Number c) const {
        if (c == no_vertex) return true;
        return !all_forbidden_ &&
               !std::binary_search(closed_.begin(), closed_.end(), std::pair(structure, c));
    }

    // Forbids what some of a point's slices did and others not. Returns whether there was any.
    bool forbid_what_slices_differ_in(const std::vector<ConflatedContours>& led) {
        std::vector<std::pair<Number, Vec3>> ways;         // from where to where, by slice
        std::vector<std::array<std::uint32_t, 4>> having;  // structure, number, slice, 0: had it before
        for (std::uint32_t s = 0; s < led.size(); ++s) {
            std::vector<std::pair<Number, Vec3>> here;
            for (const ConflatedContour& loop : led[s].loops()) {
                for (std::size_t n = 0; n < loop.vertices.size(); ++n) {
                    const Vec3 now = led[s].point(loop.vertices[n]);
                    if (!loop.taken(n)) {
                        const Number from = number_of(led[s].point(loop.origin[n]));
                        if (from != no_vertex) here.emplace_back(from, now);
                    }
                    if (const Number to = number_of(now); to != no_vertex)
                        having.push_back({loop.structure, to, s, loop.changed(n)});
                }
            }
            std::sort(here.begin(), here.end(),
                      [](const auto& a, const auto& b) { return a.first < b.first; });
            here.erase(std::unique(here.begin(), here.end()), here.end());
            ways.insert(ways.end(), here.begin(), here.end());
        }
        const bool moving = hold(std::move(ways)), taking = close(std::move(having));
        return moving || taking;
    }

  private:
    bool hold(std::vector<std::pair<Number, Vec3>> ways) {
        std::sort(ways.begin(), ways.end(), [](const auto& a, const auto& b) {
            return a.first != b.first ? a.first < b.first : lexicographic_less(a.second, b.second);
        });
        bool any = false;
        for (std::size_t n = 1; n < ways.size(); ++n) {
            if (ways[n].first != ways[n - 1].first || ways[n].second == ways[n - 1].second) continue;
            stays_[ways[n].first] = 1;
            any = true;
        }
        return any;
    }

    bool close(std::vector<std::array<std::uint32_t, 4>> having) {
        std::sort(having.begin(), having.end());
        const std::size_t before = closed_.size();
        for (auto first = having.begin(); first != having.end();) {
            std::uint32_t slices = 0;
            bool any_new = false;
            auto last = first;
            for (; last != having.end() && (*last)[0] == (*first)[0] && (*last)[1] == (*first)[1]; ++last) {
                slices += last == first || (*last)[2] != (*(last - 1))[2];
                any_new = any_new || (*last)[3] != 0;
            }
            if (any_new && slices < slices_[(*first)[1]]) closed_.emplace_back((*first)[0], (*first)[1]);
            first = last;
        }
        std::sort(closed_.begin(), closed_.end());
        return closed_.size() > before;
    }

    std::vector<Vec3> points_;           // in lexicographic order
    std::vector<std::uint32_t> slices_;  // how many have it
    std::vector<std::uint8_t> stays_;
    bool all_forbidden_ = false;
    std::vector<std::pair<Structure, Number>> closed_;  // sorted: contours that are not led there
};

// Segments that pass each other by less than this, in lengths of the shorter one, have a common point. It is a fifth
// of what a chain of edges may be off its segment. [1; > 0; D]
constexpr double least_skew = 2e-7;

// In so many rounds slices with common vertices come to agree; then such vertices stay as they are. [rounds; > 0; B]
constexpr int most_rounds = 16;

class SliceLines : public ConflatedContours {
  public:
    SliceLines(const ContourSet& set, const Slice& slice, double width, const CommonPoints& common)
        : ConflatedContours(set, slice), width_(width), common_(common) {
        for (const Vec3& p : points_) number_.push_back(common.number_of(p));
    }

    void share() {
        if (loops_.empty() || loops_.front().structure == loops_.back().structure) return;
        unite_vertices();
        take_vertices();
        take_back();
        if (meet_at_crossings()) take_back();
    }

  private:
    // The structures that have each vertex, rising.
    std::vector<std::vector<std::uint32_t>> structures_by_vertex() const {
        std::vector<std::vector<std::uint32_t>> all(points_.size());
        for (const auto& [structure, v] : owned()) all[v].push_back(structure);
        return all;
    }

    // Vertices of different structures within the width of each other become one, the nearest first. A vertex that
    // another one moved onto stays, and so does one that more slices have.
    void unite_vertices() {
        std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> pairs;  // squared distance
        PointGrid grid(2 * width_, points_.size());
        for (std::uint32_t v = 0; v < points_.size(); ++v) {
            grid.for_each_within(points_[v], width_, [&](std::uint32_t u, double squared) {
                if (squared < width_ * width_) pairs.emplace_back(squared, u, v);
            });
            grid.add(points_[v]);
        }
        if (pairs.empty()) return;
        std::sort(pairs.begin(), pairs.end());
        std::vector<std::vector<std::uint32_t>> owners = structures_by_vertex();
        std::vector<std::uint32_t> now(points_.size(), no_vertex);  // where a vertex moved; itself: it stays
        for (auto [squared, stays, moves] : pairs) {
            const auto slices = [&](std::uint32_t v) { return common_.slices(number_[v]); };
            if (slices(moves) > slices(stays) ||
                (slices(moves) == slices(stays) && owners[moves].front() < owners[stays].front()))
                std::swap(stays, moves);
            if (now[moves] == moves && slices(moves) == slices(stays)) std::swap(stays, moves);
            const bool free = now[moves] == no_vertex && (now[stays] == no_vertex || now[stays] == stays) &&
                              common_.may_move(number_[moves]) && may_get(owners[moves], stays);
            std::vector<std::uint32_t> both;
            std::set_union(owners[stays].begin(), owners[stays].end(), owners[moves].begin(),
                           owners[moves].end(), std::back_inserter(both));
            if (!free || both.size() < owners[stays].size() + owners[moves].size()) continue;
            owners[stays] = std::move(both);
            now[stays] = stays;
            now[moves] = stays;
        }
        for (ConflatedContour& loop : loops_) {
            for (std::uint32_t& v : loop.vertices)
                if (now[v] != no_vertex) v = now[v];
        }
    }

    bool may_get(const std::vector<std::uint32_t>& structures, std::uint32_t v) const {
        return std::all_of(structures.begin(), structures.end(),
                           [&](std::uint32_t structure) { return common_.may_get(structure, number_[v]); });
    }

    // Inserts vertices of other structures into the segments beside them; of one structure's, into the nearest.
    void take_vertices() {
        std::vector<Segment2> boxes;  // wider by half the width: they meet where segments are nearer than it
        std::vector<Place> at;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            for (std::uint32_t n = 0; n < loops_[l].vertices.size(); ++n) {
                const Vec2 p = at_[loops_[l].vertices[n]], q = at_[loops_[l].next_of(n)];
                const Vec2 margin{0.5 * width_, 0.5 * width_};
                boxes.push_back({Vec2{std::min(p.x, q.x), std::min(p.y, q.y)} - margin,
                                 Vec2{std::max(p.x, q.x), std::max(p.y, q.y)} + margin});
                at.push_back({l, n});
            }
        }
        const std::vector<Edge> owners = owned();
        std::vector<Beside> found;
        const auto consider = [&](Place from, Place to) {
            // This looks at the first end of one segment beside the other segment.
            const std::uint32_t v = loops_[from[0]].vertices[from[1]];
            const ConflatedContour& loop = loops_[to[0]];
            if (!common_.may_get(loop.structure, number_[v])) return;
            if (std::binary_search(owners.begin(), owners.end(), Edge{loop.structure, v})) return;
            const Vec2 a = at_[loop.vertices[to[1]]], b = at_[loop.next_of(to[1])];
            // A vertex near an end that it could not become would make an edge shorter than the width.
            for (const std::uint32_t end : {loop.vertices[to[1]], loop.next_of(to[1])}) {
                const bool common = number_[end] != no_vertex || number_[v] != no_vertex;
                if (common && length(at_[v] - at_[end]) < width_) return;
            }
            const double share = along(at_[v], a, b), apart = distance_to_segment(at_[v], a, b);
            const Edge drawn = drawn_segment(loop, to[1]);
            if (!(share > 0 && share < 1) || !(apart < width_)) return;
            if (!(distance_to_segment(at_[v], at_[drawn[0]], at_[drawn[1]]) < width_)) return;
            found.push_back({v, to[0], to[1], share, apart});
        };
        SegmentIndex(std::move(boxes)).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            if (loops_[at[i][0]].structure == loops_[at[j][0]].structure) return true;
            consider(at[i], at[j]);
            consider(at[j], at[i]);
            return true;
        });
        put_in(by_all(nearest(std::move(found))));
    }

    // Drops vertices that not all contours with the segment take, because these would leave each other.
    std::vector<Beside> by_all(std::vector<Beside> taken) const {
        const auto ends = [&](std::uint32_t l, std::uint32_t n) {
            const std::uint32_t a = loops_[l].vertices[n], b = loops_[l].next_of(n);
            return Edge{std::min(a, b), std::max(a, b)};
        };
        using Taking = std::array<std::uint32_t, 3>;  // a segment's ends, and what it takes
        std::vector<Edge> edges;
        std::vector<Taking> all;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            for (std::uint32_t n = 0; n < loops_[l].vertices.size(); ++n) edges.push_back(ends(l, n));
        }
        const auto taking = [&](const Beside& b) {
            const Edge edge = ends(b.loop, b.segment);
            return Taking{edge[0], edge[1], b.vertex};
        };
        for (const Beside& b : taken) all.push_back(taking(b));
        std::sort(edges.begin(), edges.end());
        std::sort(all.begin(), all.end());
        const auto count = [](const auto& sorted, const auto& value) {
            const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), value);
            return last - first;
        };
        std::erase_if(taken, [&](const Beside& b) {
            return count(all, taking(b)) < count(edges, ends(b.loop, b.segment));
        });
        return taken;
    }

    // Two segments, whose vertices are `edges`.
    struct Crossing {
        std::array<Edge, 2> edges;  // the smaller first, in both
        std::array<Beside, 2> sides;
        Vec3 middle;
        Vec2 at;
    };

    // Segments of different structures may cross in the plane and pass each other in space. Leads both through the
    // point in the middle between them, so that both can be edges of one mesh. Crossings beside their ends stay.
    // Returns whether there were any.
    bool meet_at_crossings() {
        PlacedSegments placed = placed_segments(loops_, at_);
        const std::vector<Place>& at = placed.places;
        std::vector<Crossing> found;
        SegmentIndex(std::move(placed.segments)).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            if (loops_[at[i][0]].structure == loops_[at[j][0]].structure) return true;
            if (const auto crossing = skew_crossing(at[i], at[j])) found.push_back(*crossing);
            return true;
        });
        std::sort(found.begin(), found.end(), [](const Crossing& x, const Crossing& y) {
            return std::tie(x.edges, x.sides[0].loop, x.sides[0].segment, x.sides[1].loop) <
                   std::tie(y.edges, y.sides[0].loop, y.sides[0].segment, y.sides[1].loop);
        });
        std::vector<Beside> taken;
        const auto first_made = static_cast<std::uint32_t>(points_.size());
        std::uint32_t vertex = no_vertex;
        for (std::size_t n = 0; n < found.size(); ++n) {
            // Loops that share a segment are led through the same point, and so are those that cross beside
            // each other.
            if (n == 0 || found[n].edges != found[n - 1].edges) vertex = made_near(found[n], first_made);
            for (Beside side : found[n].sides) {
                side.vertex = vertex;
                taken.push_back(side);
            }
        }
        const auto key = [](const Beside& b) { return std::tuple(b.loop, b.segment, b.vertex); };
        std::sort(taken.begin(), taken.end(), [&](const Beside& x, const Beside& y) {
            return std::tuple(key(x), x.along) < std::tuple(key(y), y.along);
        });
        taken.erase(std::unique(taken.begin(), taken.end(),
                                [&](const Beside& x, const Beside& y) { return key(x) == key(y); }),
                    taken.end());
        put_in(std::move(taken));
        return !found.empty();
    }

    // Returns the first made vertex that is nearer than the width, or a new one.
    std::uint32_t made_near(const Crossing& crossing, std::uint32_t first_made) {
        for (std::uint32_t v = first_made; v < points_.size(); ++v) {
            if (length(points_[v] - crossing.middle) < width_) return v;
        }
        points_.push_back(crossing.middle);
        at_.push_back(crossing.at);
        return static_cast<std::uint32_t>(points_.size() - 1);
    }

    std::optional<Crossing> skew_crossing(Place first, Place second) const {
        Crossing crossing;
        std::array<Vec3, 2> passing;
        double shortest = std::numeric_limits<double>::infinity();
        const std::array places{first, second};
        std::array<Edge, 2> ends;
        for (std::size_t k = 0; k < 2; ++k) {
            const ConflatedContour& loop = loops_[places[k][0]];
            ends[k] = {loop.vertices[places[k][1]], loop.next_of(places[k][1])};
        }
        const Vec2 a = at_[ends[0][0]], b = at_[ends[0][1]], c = at_[ends[1][0]], d = at_[ends[1][1]];
        if (segment_contact(a, b, c, d) != SegmentContact::cross) return {};
        const double area = cross(b - a, d - c);
        if (area == 0) return {};
        const std::array shares{cross(c - a, d - c) / area, cross(c - a, b - a) / area};
        for (std::size_t k = 0; k < 2; ++k) {
            const Vec3 p = points_[ends[k][0]], way = points_[ends[k][1]] - p;
            const double whole = length(way);
            if (std::min(shares[k], 1 - shares[k]) * whole < width_) return {};
            passing[k] = p + shares[k] * way;
            shortest = std::min(shortest, whole);
            crossing.edges[k] = {std::min(ends[k][0], ends[k][1]), std::max(ends[k][0], ends[k][1])};
            crossing.sides[k] = {no_vertex, places[k][0], places[k][1], shares[k], 0};
        }
        const double apart = length(passing[1] - passing[0]);
        if (!(apart > least_skew * shortest) || 0.5 * apart >= width_) return {};
        if (crossing.edges[1] < crossing.edges[0]) {
            std::swap(crossing.edges[0], crossing.edges[1]);
            std::swap(crossing.sides[0], crossing.sides[1]);
        }
        crossing.middle = 0.5 * (passing[0] + passing[1]);
        crossing.at = a + shares[0] * (b - a);
        return crossing;
    }

    // Takes back what made contours of a structure touch or cross one another.
    void take_back() {
        for (bool again = true; again;) {
            again = false;
            for (std::size_t first = 0; first < loops_.size(); first = end_of_structure(first)) {
                const std::size_t last = end_of_structure(first);
                again = drop(touching(first, last)) || again;
                if (!again) again = drop(turned_or_nested(first, last));
            }
        }
    }

    double width_;
    const CommonPoints& common_;
    std::vector<CommonPoints::Number> number_;  // of each vertex
};

double median_segment(const ContourSet& set) {
    std::vector<double> lengths;
    for (const Contour& contour : set.contours) {
        const auto points = set.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n)
            lengths.push_back(length(points[(n + 1) % points.size()] - points[n]));
    }
    if (lengths.empty()) return 0;
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    return *middle;
}

}  // namespace

MergeCoincidentStats merge_coincident(ContourSet& set, const MergeCoincidentOptions& options) {
    assert(options.width_mm >= 0 && options.width_mm <= 0.1);
    assert(options.share_of_segment >= 0 && options.share_of_segment <= 0.5);
    MergeCoincidentStats stats;
    if (options.width_mm == 0 || set.structures.size() < 2) return stats;
    stats.width_mm = std::min(options.width_mm, options.share_of_segment * median_segment(set));
    if (!(stats.width_mm > 0)) return stats;
    CommonPoints common(set);
    std::vector<ConflatedContours> led;
    for (int round = 0;; ++round) {
        led.clear();
        for (const Slice& slice : set.slices) {
            SliceLines lines(set, slice, stats.width_mm, common);
            lines.share();
            led.push_back(static_cast<ConflatedContours>(std::move(lines)));
        }
        if (!common.forbid_what_slices_differ_in(led)) break;
        if (round == most_rounds) common.forbid_all();
    }
    lead_slices(set, stats, [&](std::uint32_t s) { return std::move(led[s]); });
    return stats;
}

}  // namespace anatomesh
