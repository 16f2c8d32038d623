#include "anatomesh/contour/close_gaps.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include "anatomesh/contour/segment_index.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {
namespace {

using Edge = std::array<std::uint32_t, 2>;   // vertices
using Place = std::array<std::uint32_t, 2>;  // loop, number of a vertex or segment in it

constexpr std::uint32_t no_vertex = 0xFFFFFFFFu;

// A contour as vertices of its slice, with those taken from others; `drawn` as it came.
struct Loop {
    std::uint32_t structure = 0;
    std::vector<std::uint32_t> vertices, drawn;
    std::vector<std::uint8_t> taken;  // by position in `vertices`
};

// A vertex beside a segment of a loop: how far along it in lengths of the segment, and how far from it.
struct Beside {
    std::uint32_t vertex = 0, loop = 0, segment = 0;
    double along = 0, distance = 0;
};

class SliceGaps {
  public:
    SliceGaps(const ContourSet& set, const Slice& slice, double width) : width_(width) {
        for (const Contour& contour : set.contours_of(slice)) {
            for (const Vec3& p : set.points_of(contour)) points_.push_back(p);
        }
        std::sort(points_.begin(), points_.end(), [](Vec3 p, Vec3 q) { return lexicographic_less(p, q); });
        points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
        for (const Vec3& p : points_) at_.push_back(slice.plane.to_plane(p));
        for (const Contour& contour : set.contours_of(slice)) {
            Loop loop;
            loop.structure = contour.structure;
            for (const Vec3& p : set.points_of(contour)) loop.vertices.push_back(vertex_of(p));
            loop.drawn = loop.vertices;
            loop.taken.assign(loop.vertices.size(), 0);
            loops_.push_back(std::move(loop));
        }
    }

    void close() {
        if (loops_.empty() || loops_.front().structure == loops_.back().structure) return;
        // Later structures take the vertices of earlier ones; what these pass in between goes to the earlier;
        // then the other way round, where the earlier one's vertices are too far apart to be near to
        // anything.
        for (const bool to_later : {true, false}) {
            take_vertices(to_later);
            take_paths();
        }
        take_back();
    }

    const std::vector<Loop>& loops() const { return loops_; }
    Vec3 point(std::uint32_t vertex) const { return points_[vertex]; }

    // Between what was drawn of a loop and what it became.
    void measure(const Loop& loop, CloseGapsStats& stats, double& widest) const {
        std::size_t k = 0;  // along the new loop, from a drawn vertex to the next
        const std::size_t count = loop.vertices.size();
        while (loop.vertices[k] != loop.drawn[0]) ++k;
        for (std::size_t n = 0; n < loop.drawn.size(); ++n) {
            const std::uint32_t a = loop.drawn[n], b = loop.drawn[(n + 1) % loop.drawn.size()];
            // Both sides of the drawn segment count.
            const Vec2 way = at_[b] - at_[a];
            double changed = 0, last_height = 0, last_along = 0;
            const auto step_to = [&](Vec2 p) {
                const double height = cross(way, p - at_[a]) / dot(way, way), here = along(p, at_[a], at_[b]);
                const double sum = std::abs(height) + std::abs(last_height);
                const double mean =
                    height * last_height >= 0 ? sum : (height * height + last_height * last_height) / sum;
                changed += 0.5 * mean * std::abs(here - last_along) * dot(way, way);
                last_height = height;
                last_along = here;
            };
            for (k = (k + 1) % count; loop.vertices[k] != b; k = (k + 1) % count) {
                const Vec2 p = at_[loop.vertices[k]];
                ++stats.vertices_taken;
                widest = std::max(widest, distance(p, at_[a], at_[b]));
                step_to(p);
            }
            step_to(at_[b]);
            stats.area_mm2 += changed;
        }
    }

  private:
    std::uint32_t vertex_of(Vec3 p) const {
        const auto less = [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); };
        return static_cast<std::uint32_t>(std::lower_bound(points_.begin(), points_.end(), p, less) -
                                          points_.begin());
    }

    // The vertex after the n-th, and before it.
    static std::uint32_t next_of(const Loop& loop, std::size_t n) {
        return loop.vertices[(n + 1) % loop.vertices.size()];
    }
    static std::uint32_t last_of(const Loop& loop, std::size_t n) {
        return loop.vertices[(n + loop.vertices.size() - 1) % loop.vertices.size()];
    }

    // The ends of the drawn segment that this one is a part of, or was led away from.
    static Edge drawn_segment(const Loop& loop, std::size_t n) {
        const std::size_t count = loop.vertices.size();
        std::size_t a = n, b = (n + 1) % count;
        while (loop.taken[a]) a = (a + count - 1) % count;
        while (loop.taken[b]) b = (b + 1) % count;
        return {loop.vertices[a], loop.vertices[b]};
    }

    // In lengths of the segment, 0 at a and 1 at b, beyond them too.
    static double along(Vec2 p, Vec2 a, Vec2 b) { return dot(p - a, b - a) / dot(b - a, b - a); }
    static double distance(Vec2 p, Vec2 a, Vec2 b) {
        const double t = std::clamp(along(p, a, b), 0.0, 1.0);
        return length(p - (a + t * (b - a)));
    }

    // The loops' segments with whether another structure has them too, the other way round.
    struct Segments {
        std::vector<Edge> ends;
        std::vector<std::uint32_t> loop, number;
        std::vector<std::uint8_t> shared;
    };
    Segments segments() const {
        Segments all;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            for (std::uint32_t n = 0; n < loops_[l].vertices.size(); ++n) {
                all.ends.push_back({loops_[l].vertices[n], next_of(loops_[l], n)});
                all.loop.push_back(l);
                all.number.push_back(n);
            }
        }
        std::vector<Edge> sorted = all.ends;
        std::sort(sorted.begin(), sorted.end());
        for (const Edge& e : all.ends)
            all.shared.push_back(std::binary_search(sorted.begin(), sorted.end(), Edge{e[1], e[0]}));
        return all;
    }

    // (structure, vertex), sorted.
    std::vector<Edge> owned() const {
        std::vector<Edge> pairs;
        for (const Loop& loop : loops_) {
            for (const std::uint32_t v : loop.vertices) pairs.push_back({loop.structure, v});
        }
        std::sort(pairs.begin(), pairs.end());
        return pairs;
    }

    // Puts vertices of earlier structures, or of later ones, that lie beside a segment into it.
    void take_vertices(bool to_later) {
        const Segments all = segments();
        const std::vector<Edge> owners = owned();
        std::vector<Beside> found;
        const auto consider = [&](std::uint32_t i, std::uint32_t j) {
            // The first end of segment i beside segment j.
            const Loop &from = loops_[all.loop[i]], &to = loops_[all.loop[j]];
            if (all.shared[j] || (to_later ? from.structure >= to.structure : from.structure <= to.structure))
                return;
            const std::uint32_t v = all.ends[i][0];
            if (std::binary_search(owners.begin(), owners.end(), Edge{to.structure, v})) return;
            const Vec2 a = at_[all.ends[j][0]], b = at_[all.ends[j][1]];
            const double apart = distance(at_[v], a, b);
            const Edge drawn = drawn_segment(to, all.number[j]);
            if (!(apart < width_) || !(distance(at_[v], at_[drawn[0]], at_[drawn[1]]) < width_)) return;
            const Vec2 course = at_[all.ends[i][1]] - at_[last_of(from, all.number[i])];
            if (dot(course, b - a) >= 0) return;
            found.push_back({v, all.loop[j], all.number[j], along(at_[v], a, b), apart});
        };
        // Two boxes that are wider by half the width meet where segments are nearer than the width.
        std::vector<Segment2> boxes;
        for (const Edge& e : all.ends) {
            const Vec2 p = at_[e[0]], q = at_[e[1]], margin{0.5 * width_, 0.5 * width_};
            boxes.push_back({Vec2{std::min(p.x, q.x), std::min(p.y, q.y)} - margin,
                             Vec2{std::max(p.x, q.x), std::max(p.y, q.y)} + margin});
        }
        SegmentIndex(std::move(boxes)).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            consider(i, j);
            consider(j, i);
            return true;
        });
        found = nearest(std::move(found));
        const std::vector<std::uint8_t> unseen = hidden(found, all);
        std::size_t kept = 0;
        for (std::size_t n = 0; n < found.size(); ++n) {
            if (!unseen[n]) found[kept++] = found[n];
        }
        found.resize(kept);
        put_in(std::move(found));
    }

    // For each vertex and structure the nearest segment; at a corner the one that the vertex is less beyond.
    std::vector<Beside> nearest(std::vector<Beside> found) const {
        const auto beyond = [](const Beside& x) { return std::max({0.0, -x.along, x.along - 1}); };
        const auto key = [&](const Beside& x) { return Edge{x.vertex, loops_[x.loop].structure}; };
        std::sort(found.begin(), found.end(), [&](const Beside& x, const Beside& y) {
            if (key(x) != key(y)) return key(x) < key(y);
            if (x.distance != y.distance) return x.distance < y.distance;
            if (beyond(x) != beyond(y)) return beyond(x) < beyond(y);
            return x.loop != y.loop ? x.loop < y.loop : x.segment < y.segment;
        });
        found.erase(std::unique(found.begin(), found.end(),
                                [&](const Beside& x, const Beside& y) { return key(x) == key(y); }),
                    found.end());
        return found;
    }

    // From a point to the nearest one of a segment.
    struct Way {
        Vec2 from;
        Edge to;                // the ends of the segment
        std::vector<Edge> own;  // segments that it may meet: what it starts from, and that
        std::uint32_t vertex;   // those at this vertex too
    };

    // Whether each crosses one of these segments: what lies beyond another contour, or beyond the other side
    // of its own, is no neighbour.
    std::vector<std::uint8_t> hidden(const std::vector<Way>& ways, const std::vector<Edge>& segments) const {
        std::vector<std::uint8_t> result(ways.size(), 0);
        if (ways.empty()) return result;
        std::vector<Segment2> lines;
        for (const Edge& e : segments) lines.push_back({at_[e[0]], at_[e[1]]});
        std::vector<std::uint32_t> end;  // the vertex that the way ends at, if it does at one
        for (const Way& way : ways) {
            const Vec2 a = at_[way.to[0]], b = at_[way.to[1]];
            const double t = along(way.from, a, b);
            end.push_back(t <= 0 ? way.to[0] : t >= 1 ? way.to[1] : no_vertex);
            lines.push_back({way.from, a + std::clamp(t, 0.0, 1.0) * (b - a)});
        }
        const std::size_t first = segments.size();
        const SegmentIndex index(std::move(lines));
        index.for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            if (i >= first || j < first || result[j - first]) return true;
            const Way& way = ways[j - first];
            const Edge& e = segments[i];
            if (has(e, way.vertex) || has(e, end[j - first])) return true;
            if (std::find(way.own.begin(), way.own.end(), e) != way.own.end()) return true;
            const auto& [a, b] = index.segments()[i];
            const auto& [c, d] = index.segments()[j];
            result[j - first] = c != d && segment_contact(a, b, c, d) != SegmentContact::none;
            return true;
        });
        return result;
    }
    std::vector<std::uint8_t> hidden(const std::vector<Beside>& found, const Segments& all) const {
        std::vector<Way> ways;
        for (const Beside& x : found) {
            const Edge to{loops_[x.loop].vertices[x.segment], next_of(loops_[x.loop], x.segment)};
            ways.push_back({at_[x.vertex], to, {to}, x.vertex});
        }
        return hidden(ways, all.ends);
    }

    static bool has(const Edge& e, std::uint32_t v) { return e[0] == v || e[1] == v; }

    void put_in(std::vector<Beside> found) {
        std::sort(found.begin(), found.end(), [](const Beside& x, const Beside& y) {
            if (x.loop != y.loop) return x.loop < y.loop;
            if (x.segment != y.segment) return x.segment < y.segment;
            return x.along != y.along ? x.along < y.along : x.vertex < y.vertex;
        });
        auto next = found.begin();
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            Loop& loop = loops_[l];
            std::vector<std::uint32_t> vertices;
            std::vector<std::uint8_t> taken;
            for (std::uint32_t n = 0; n < loop.vertices.size(); ++n) {
                vertices.push_back(loop.vertices[n]);
                taken.push_back(loop.taken[n]);
                for (; next != found.end() && next->loop == l && next->segment == n; ++next) {
                    vertices.push_back(next->vertex);
                    taken.push_back(1);
                }
            }
            loop.vertices = std::move(vertices);
            loop.taken = std::move(taken);
        }
    }

    // Where both ends of a segment are vertices of another structure's loop, with a path beside the segment
    // between them, the segment becomes that path.
    void take_paths() {
        std::vector<std::array<std::uint32_t, 3>> places;  // vertex, loop, number
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            for (std::uint32_t n = 0; n < loops_[l].vertices.size(); ++n)
                places.push_back({loops_[l].vertices[n], l, n});
        }
        std::sort(places.begin(), places.end());
        const std::vector<Edge> owners = owned();
        std::vector<Beside> found;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            for (std::uint32_t n = 0; n < loops_[l].vertices.size(); ++n) {
                const std::uint32_t a = loops_[l].vertices[n], b = next_of(loops_[l], n);
                std::vector<Beside> best;
                for (auto p = std::lower_bound(places.begin(), places.end(),
                                               std::array<std::uint32_t, 3>{b, 0, 0});
                     p != places.end() && (*p)[0] == b; ++p) {
                    if (loops_[(*p)[1]].structure == loops_[l].structure) continue;
                    std::vector<Beside> path = path_beside(l, n, a, (*p)[1], (*p)[2], owners);
                    if (best.empty() || (!path.empty() && path.size() < best.size())) best = std::move(path);
                }
                found.insert(found.end(), best.begin(), best.end());
            }
        }
        // A path is taken whole or not at all.
        const std::vector<std::uint8_t> unseen = hidden(found, segments());
        const auto place = [](const Beside& x) { return Place{x.loop, x.segment}; };
        std::vector<Place> given_up;
        for (std::size_t n = 0; n < found.size(); ++n) {
            if (unseen[n]) given_up.push_back(place(found[n]));
        }
        std::sort(given_up.begin(), given_up.end());
        std::erase_if(found, [&](const Beside& x) {
            return std::binary_search(given_up.begin(), given_up.end(), place(x));
        });
        put_in(std::move(found));
    }

    // The vertices of `other` after b, its number `from`, up to a; none where one is too far from the
    // segment, or the structure's already.
    std::vector<Beside> path_beside(std::uint32_t l, std::uint32_t n, std::uint32_t a, std::uint32_t other,
                                    std::uint32_t from, const std::vector<Edge>& owners) const {
        std::vector<Beside> path;
        const Edge drawn = drawn_segment(loops_[l], n);
        const Loop& way = loops_[other];
        const Vec2 back = at_[a] - at_[next_of(loops_[l], n)];
        for (std::size_t k = 1; k < way.vertices.size(); ++k) {
            const std::uint32_t v = way.vertices[(from + k) % way.vertices.size()];
            const std::uint32_t last = way.vertices[(from + k - 1) % way.vertices.size()];
            if (dot(at_[v] - at_[last], back) < 0) return {};
            if (v == a) break;
            const double apart = distance(at_[v], at_[drawn[0]], at_[drawn[1]]);
            if (!(apart < width_) ||
                std::binary_search(owners.begin(), owners.end(), Edge{loops_[l].structure, v}) ||
                k + 1 == way.vertices.size()) {
                return {};
            }
            // In the order of the path: against that of the segment.
            path.push_back({v, l, n, -static_cast<double>(k), apart});
        }
        return path;
    }

    // Takes out again what does not serve: vertices that are not an end of a shared segment, and those at
    // which contours of a structure came to touch or cross one another.
    void take_back() {
        for (bool again = true; again;) {
            again = drop(lone());
            again = drop(out_of_sight()) || again;
            for (std::size_t first = 0; first < loops_.size();) {
                std::size_t last = first + 1;
                while (last < loops_.size() && loops_[last].structure == loops_[first].structure) ++last;
                again = drop(touching(first, last)) || again;
                if (!again) again = drop(turned_or_nested(first, last));
                first = last;
            }
        }
    }

    std::vector<Place> lone() const {
        const Segments all = segments();
        std::vector<Place> places;
        std::size_t first = 0;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            const std::size_t count = loops_[l].vertices.size();
            for (std::uint32_t n = 0; n < count; ++n) {
                const bool serves = all.shared[first + n] || all.shared[first + (n + count - 1) % count];
                if (loops_[l].taken[n] && !serves) places.push_back({l, n});
            }
            first += count;
        }
        return places;
    }

    // Ends of shared segments that something lies before, seen from where the contour was drawn.
    std::vector<Place> out_of_sight() const {
        std::vector<Edge> drawn;
        std::vector<std::pair<Edge, Place>> by_ends;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            const Loop& loop = loops_[l];
            for (std::size_t n = 0; n < loop.drawn.size(); ++n)
                drawn.push_back({loop.drawn[n], loop.drawn[(n + 1) % loop.drawn.size()]});
            for (std::uint32_t n = 0; n < loop.vertices.size(); ++n)
                by_ends.push_back({{loop.vertices[n], next_of(loop, n)}, {l, n}});
        }
        std::sort(by_ends.begin(), by_ends.end());
        std::vector<Way> ways;
        std::vector<Place> starts, places;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            const Loop& loop = loops_[l];
            for (std::uint32_t n = 0; n < loop.vertices.size(); ++n) {
                const std::uint32_t a = loop.vertices[n], b = next_of(loop, n);
                if (!loop.taken[n] && !loop.taken[(n + 1) % loop.taken.size()]) continue;
                const auto other =
                    std::lower_bound(by_ends.begin(), by_ends.end(), std::pair{Edge{b, a}, Place{0, 0}});
                if (other == by_ends.end() || other->first != Edge{b, a}) continue;
                const Edge to = drawn_segment(loop, n);
                const Edge partner = drawn_segment(loops_[other->second[0]], other->second[1]);
                ways.push_back({0.5 * (at_[a] + at_[b]), to, {to, partner}, no_vertex});
                starts.push_back({l, n});
            }
        }
        const std::vector<std::uint8_t> cut_off = hidden(ways, drawn);
        for (std::size_t k = 0; k < ways.size(); ++k) {
            const auto [l, n] = starts[k];
            const auto after = static_cast<std::uint32_t>((n + 1) % loops_[l].vertices.size());
            for (const std::uint32_t m : {n, after}) {
                if (cut_off[k] && loops_[l].taken[m]) places.push_back({l, m});
            }
        }
        return places;
    }

    // Of the loops of one structure.
    std::vector<Place> touching(std::size_t first, std::size_t last) const {
        std::vector<Segment2> segments;
        std::vector<Edge> ends;
        std::vector<Place> at, places;
        std::vector<std::pair<std::uint32_t, Place>> taken;  // by vertex
        for (std::size_t l = first; l < last; ++l) {
            const Loop& loop = loops_[l];
            for (std::uint32_t n = 0; n < loop.vertices.size(); ++n) {
                at.push_back({static_cast<std::uint32_t>(l), n});
                ends.push_back({loop.vertices[n], next_of(loop, n)});
                segments.push_back({at_[ends.back()[0]], at_[ends.back()[1]]});
                if (loop.taken[n]) taken.emplace_back(loop.vertices[n], at.back());
            }
        }
        if (taken.empty()) return places;
        std::sort(taken.begin(), taken.end());
        for (std::size_t k = 1; k < taken.size(); ++k) {
            if (taken[k].first == taken[k - 1].first)
                places.insert(places.end(), {taken[k - 1].second, taken[k].second});
        }
        SegmentIndex(std::move(segments)).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            if (!touch(ends[i], ends[j])) return true;
            // Of the vertices taken there, that which was taken from farthest.
            double most = -1;
            Place worst{};
            for (const std::uint32_t s : {i, j}) {
                const auto& [l, n] = at[s];
                const auto after = static_cast<std::uint32_t>((n + 1) % loops_[l].vertices.size());
                for (const std::uint32_t k : {n, after}) {
                    if (!loops_[l].taken[k]) continue;
                    const Edge drawn = drawn_segment(loops_[l], k);
                    const double far = distance(at_[loops_[l].vertices[k]], at_[drawn[0]], at_[drawn[1]]);
                    if (far <= most) continue;
                    most = far;
                    worst = {l, k};
                }
            }
            if (most >= 0) places.push_back(worst);
            return true;
        });
        return places;
    }

    // All that the loops of a structure took, if one was turned inside out or came to lie in another one, or
    // out of it.
    std::vector<Place> turned_or_nested(std::size_t first, std::size_t last) const {
        std::vector<Place> places;
        bool wrong = false;
        for (std::size_t l = first; l < last; ++l) {
            const Loop& loop = loops_[l];
            for (std::uint32_t n = 0; n < loop.vertices.size(); ++n) {
                if (loop.taken[n]) places.push_back({static_cast<std::uint32_t>(l), n});
            }
        }
        if (places.empty()) return places;
        for (std::size_t l = first; l < last && !wrong; ++l) {
            wrong = signed_area(polygon(loops_[l].vertices)) * signed_area(polygon(loops_[l].drawn)) <= 0;
            const Vec2 p = at_[loops_[l].drawn[0]];
            for (std::size_t m = first; m < last && !wrong; ++m)
                wrong = m != l && side_of_polygon(polygon(loops_[m].vertices), p) !=
                                      side_of_polygon(polygon(loops_[m].drawn), p);
        }
        if (!wrong) places.clear();
        return places;
    }

    std::vector<Vec2> polygon(const std::vector<std::uint32_t>& loop) const {
        std::vector<Vec2> points;
        for (const std::uint32_t v : loop) points.push_back(at_[v]);
        return points;
    }

    // Says whether there were any.
    bool drop(std::vector<Place> places) {
        std::sort(places.begin(), places.end());
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            Loop& loop = loops_[l];
            std::size_t kept = 0;
            for (std::uint32_t n = 0; n < loop.vertices.size(); ++n) {
                if (std::binary_search(places.begin(), places.end(), Place{l, n})) continue;
                loop.vertices[kept] = loop.vertices[n];
                loop.taken[kept++] = loop.taken[n];
            }
            loop.vertices.resize(kept);
            loop.taken.resize(kept);
        }
        return !places.empty();
    }

    // Of one structure: elsewhere than in a common end.
    bool touch(Edge p, Edge q) const {
        const SegmentContact contact = segment_contact(at_[p[0]], at_[p[1]], at_[q[0]], at_[q[1]]);
        const bool joined = has(q, p[0]) || has(q, p[1]);
        return joined ? contact == SegmentContact::overlap : contact != SegmentContact::none;
    }

    double width_;
    std::vector<Vec3> points_;  // of the slice, distinct, in lexicographic order
    std::vector<Vec2> at_;
    std::vector<Loop> loops_;
};

}  // namespace

CloseGapsStats close_gaps(ContourSet& set, const CloseGapsOptions& options) {
    assert(options.width_mm >= 0 && options.width_mm <= 10);
    CloseGapsStats stats;
    if (options.width_mm == 0) return stats;
    std::vector<Contour> contours;
    std::vector<Vec3> points;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        SliceGaps gaps(set, set.slices[s], options.width_mm);
        gaps.close();
        const std::uint64_t changed_before = stats.contours_changed;
        double widest = 0;
        // The contours of a slice by structure, then by their smallest vertex, which comes first.
        std::vector<std::pair<std::uint32_t, std::vector<std::uint32_t>>> loops;
        for (const Loop& loop : gaps.loops()) {
            if (loop.vertices.size() > loop.drawn.size()) {
                ++stats.contours_changed;
                gaps.measure(loop, stats, widest);
            }
            std::vector<std::uint32_t> vertices = loop.vertices;
            std::rotate(vertices.begin(), std::min_element(vertices.begin(), vertices.end()), vertices.end());
            loops.emplace_back(loop.structure, std::move(vertices));
        }
        stats.slices += stats.contours_changed > changed_before;
        if (widest > stats.widest_mm) {
            stats.widest_mm = widest;
            stats.worst_slice = s;
        }
        std::sort(loops.begin(), loops.end());
        for (const auto& [structure, vertices] : loops) {
            contours.push_back({structure, s, static_cast<std::uint32_t>(points.size()),
                                static_cast<std::uint32_t>(vertices.size())});
            for (const std::uint32_t v : vertices) points.push_back(gaps.point(v));
        }
    }
    set.contours = std::move(contours);
    set.points = std::move(points);
    return stats;
}

}  // namespace anatomesh
