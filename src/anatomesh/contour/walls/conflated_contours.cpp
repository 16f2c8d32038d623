#include "anatomesh/contour/walls/conflated_contours.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/point_triangle.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

ConflatedContours::ConflatedContours(const ContourSet& set, const Slice& slice) {
    for (const Contour& contour : set.contours_of(slice)) {
        for (const Vec3& p : set.points_of(contour)) points_.push_back(p);
    }
    std::sort(points_.begin(), points_.end(), [](Vec3 p, Vec3 q) { return lexicographic_less(p, q); });
    points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
    for (const Vec3& p : points_) at_.push_back(slice.plane.to_plane(p));
    for (const Contour& contour : set.contours_of(slice)) {
        ConflatedContour loop;
        loop.structure = contour.structure;
        for (const Vec3& p : set.points_of(contour)) loop.drawn.push_back(vertex_of(p));
        loop.vertices = loop.origin = loop.drawn;
        loops_.push_back(std::move(loop));
    }
}

void ConflationStats::add(const ConflatedContours& led, std::uint32_t slice) {
    bool any = false;
    for (const ConflatedContour& loop : led.loops()) {
        if (loop.vertices == loop.drawn) continue;
        const ConflatedContours::Change change = led.change_of(loop);
        any = true;
        ++contours_changed;
        vertices_taken += change.taken;
        vertices_moved += change.moved;
        area_mm2 += change.area_mm2;
        if (change.widest_mm > widest_mm) {
            widest_mm = change.widest_mm;
            worst_slice = slice;
        }
    }
    slices += any;
}

ConflatedContours::Change ConflatedContours::change_of(const ConflatedContour& loop) const {
    Change change;
    const std::size_t count = loop.vertices.size();
    std::size_t k = 0;  // along the loop, from where a drawn vertex is to where the next is
    while (loop.taken(k)) ++k;
    for (std::size_t n = 0; n < loop.drawn.size(); ++n) {
        const Vec2 a = at_[loop.origin[k]];
        std::size_t end = (k + 1) % count;
        while (loop.taken(end)) end = (end + 1) % count;
        const Vec2 b = at_[loop.origin[end]], way = b - a;
        // Areas on both sides of the drawn segment count.
        const Vec3 from = points_[loop.origin[k]], to = points_[loop.origin[end]];
        double changed = 0, last_height = 0, last_along = 0;
        const auto step_to = [&](Vec2 p) {
            const double height = cross(way, p - a) / dot(way, way), here = along(p, a, b);
            const double sum = std::abs(height) + std::abs(last_height);
            const double mean =
                height * last_height >= 0 ? sum : (height * height + last_height * last_height) / sum;
            changed += 0.5 * mean * std::abs(here - last_along) * dot(way, way);
            last_height = height;
            last_along = here;
        };
        if (loop.changed(k)) {
            ++change.moved;
            change.widest_mm = std::max(change.widest_mm, length(at_[loop.vertices[k]] - a));
            step_to(at_[loop.vertices[k]]);
        }
        for (k = (k + 1) % count; k != end; k = (k + 1) % count) {
            const Vec2 p = at_[loop.vertices[k]];
            ++change.taken;
            change.widest_mm =
                std::max(change.widest_mm, point_segment_distance(points_[loop.vertices[k]], from, to));
            step_to(p);
        }
        step_to(at_[loop.vertices[end]]);
        change.area_mm2 += changed;
    }
    return change;
}

void ConflatedContours::append_to(std::vector<Contour>& contours, std::vector<Vec3>& points,
                                  std::uint32_t slice) const {
    const auto before = [&](std::uint32_t v, std::uint32_t w) {
        return lexicographic_less(points_[v], points_[w]);
    };
    std::vector<std::pair<std::uint32_t, std::vector<std::uint32_t>>> loops;
    for (const ConflatedContour& loop : loops_) {
        std::vector<std::uint32_t> vertices = loop.vertices;
        std::rotate(vertices.begin(), std::min_element(vertices.begin(), vertices.end(), before),
                    vertices.end());
        loops.emplace_back(loop.structure, std::move(vertices));
    }
    std::sort(loops.begin(), loops.end(), [&](const auto& p, const auto& q) {
        if (p.first != q.first) return p.first < q.first;
        return std::lexicographical_compare(p.second.begin(), p.second.end(), q.second.begin(),
                                            q.second.end(), before);
    });
    for (const auto& [structure, vertices] : loops) {
        contours.push_back({structure, slice, static_cast<std::uint32_t>(points.size()),
                            static_cast<std::uint32_t>(vertices.size())});
        for (const std::uint32_t v : vertices) points.push_back(points_[v]);
    }
}

ConflatedContours::Edge ConflatedContours::drawn_segment(const ConflatedContour& loop, std::size_t n) {
    const std::size_t count = loop.vertices.size();
    std::size_t a = n, b = (n + 1) % count;
    while (loop.taken(a)) a = (a + count - 1) % count;
    while (loop.taken(b)) b = (b + 1) % count;
    return {loop.origin[a], loop.origin[b]};
}

PlacedSegments placed_segments(const std::vector<ConflatedContour>& loops, const std::vector<Vec2>& at) {
    PlacedSegments all;
    for (std::uint32_t l = 0; l < loops.size(); ++l) {
        for (std::uint32_t n = 0; n < loops[l].vertices.size(); ++n) {
            all.segments.push_back({at[loops[l].vertices[n]], at[loops[l].next_of(n)]});
            all.places.push_back({l, n});
        }
    }
    return all;
}

std::vector<ConflatedContours::Edge> ConflatedContours::owned() const {
    std::vector<Edge> pairs;
    for (const ConflatedContour& loop : loops_) {
        for (const std::uint32_t v : loop.vertices) pairs.push_back({loop.structure, v});
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

std::vector<std::uint8_t> ConflatedContours::hidden(const std::vector<Way>& ways,
                                                    const std::vector<Edge>& segments) const {
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

std::vector<ConflatedContours::Beside> ConflatedContours::nearest(std::vector<Beside> found) const {
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

void ConflatedContours::put_in(std::vector<Beside> found) {
    std::sort(found.begin(), found.end(), [](const Beside& x, const Beside& y) {
        if (x.loop != y.loop) return x.loop < y.loop;
        if (x.segment != y.segment) return x.segment < y.segment;
        return x.along != y.along ? x.along < y.along : x.vertex < y.vertex;
    });
    auto next = found.begin();
    for (std::uint32_t l = 0; l < loops_.size(); ++l) {
        ConflatedContour& loop = loops_[l];
        std::vector<std::uint32_t> vertices, origin;
        for (std::uint32_t n = 0; n < loop.vertices.size(); ++n) {
            vertices.push_back(loop.vertices[n]);
            origin.push_back(loop.origin[n]);
            for (; next != found.end() && next->loop == l && next->segment == n; ++next) {
                vertices.push_back(next->vertex);
                origin.push_back(no_vertex);
            }
        }
        loop.vertices = std::move(vertices);
        loop.origin = std::move(origin);
    }
}

std::vector<ConflatedContours::Place> ConflatedContours::touching(std::size_t first, std::size_t last) const {
    std::vector<Segment2> segments;
    std::vector<Edge> ends;
    std::vector<Place> at, places;
    std::vector<std::pair<std::uint32_t, Place>> by_vertex;
    bool any = false;
    for (std::size_t l = first; l < last; ++l) {
        const ConflatedContour& loop = loops_[l];
        for (std::uint32_t n = 0; n < loop.vertices.size(); ++n) {
            at.push_back({static_cast<std::uint32_t>(l), n});
            ends.push_back({loop.vertices[n], loop.next_of(n)});
            segments.push_back({at_[ends.back()[0]], at_[ends.back()[1]]});
            by_vertex.emplace_back(loop.vertices[n], at.back());
            any = any || loop.changed(n);
        }
    }
    if (!any) return places;
    std::sort(by_vertex.begin(), by_vertex.end());
    const auto changed = [&](Place p) { return loops_[p[0]].changed(p[1]); };
    for (std::size_t k = 1; k < by_vertex.size(); ++k) {
        if (by_vertex[k].first != by_vertex[k - 1].first) continue;
        for (const Place p : {by_vertex[k - 1].second, by_vertex[k].second})
            if (changed(p)) places.push_back(p);
    }
    SegmentIndex(std::move(segments)).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
        if (!touch(ends[i], ends[j])) return true;
        // The vertex goes that lies farthest from what was drawn, because it changes most.
        double most = -1;
        Place worst{};
        for (const std::uint32_t s : {i, j}) {
            const auto& [l, n] = at[s];
            const auto after = static_cast<std::uint32_t>((n + 1) % loops_[l].vertices.size());
            for (const std::uint32_t k : {n, after}) {
                if (!changed({l, k})) continue;
                const Edge drawn = drawn_segment(loops_[l], k);
                const double far =
                    distance_to_segment(at_[loops_[l].vertices[k]], at_[drawn[0]], at_[drawn[1]]);
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

std::vector<ConflatedContours::Place> ConflatedContours::turned_or_nested(std::size_t first,
                                                                          std::size_t last) const {
    std::vector<Place> places;
    std::vector<std::uint8_t> changed(last - first, 0);
    for (std::size_t l = first; l < last; ++l) {
        for (std::uint32_t n = 0; n < loops_[l].vertices.size(); ++n) {
            if (!loops_[l].changed(n)) continue;
            places.push_back({static_cast<std::uint32_t>(l), n});
            changed[l - first] = 1;
        }
    }
    bool wrong = false;
    for (std::size_t m = first; m < last && !wrong; ++m) {
        if (!changed[m - first]) continue;
        const std::vector<Vec2> now = polygon(loops_[m].vertices), drawn = polygon(loops_[m].drawn);
        wrong = signed_area(now) * signed_area(drawn) <= 0;
        for (std::size_t l = first; l < last && !wrong; ++l) {
            if (l == m) continue;
            const auto k =
                static_cast<std::size_t>(std::find_if(loops_[l].origin.begin(), loops_[l].origin.end(),
                                                      [](std::uint32_t v) { return v != no_vertex; }) -
                                         loops_[l].origin.begin());
            wrong = side_of_polygon(now, at_[loops_[l].vertices[k]]) !=
                    side_of_polygon(drawn, at_[loops_[l].origin[k]]);
        }
    }
    if (!wrong) places.clear();
    return places;
}

bool ConflatedContours::drop(std::vector<Place> places) {
    if (places.empty()) return false;
    std::sort(places.begin(), places.end());
    // A vertex that several loops share moves back in all of them.
    std::vector<std::uint32_t> back;
    for (const auto& [l, n] : places)
        if (!loops_[l].taken(n)) back.push_back(loops_[l].origin[n]);
    std::sort(back.begin(), back.end());
    for (std::uint32_t l = 0; l < loops_.size(); ++l) {
        ConflatedContour& loop = loops_[l];
        std::size_t kept = 0;
        for (std::uint32_t n = 0; n < loop.vertices.size(); ++n) {
            const bool listed = std::binary_search(places.begin(), places.end(), Place{l, n});
            if (listed && loop.taken(n)) continue;
            const bool moves_back = std::binary_search(back.begin(), back.end(), loop.origin[n]);
            loop.vertices[kept] = moves_back ? loop.origin[n] : loop.vertices[n];
            loop.origin[kept++] = loop.origin[n];
        }
        loop.vertices.resize(kept);
        loop.origin.resize(kept);
    }
    return true;
}

std::size_t ConflatedContours::end_of_structure(std::size_t first) const {
    std::size_t last = first + 1;
    while (last < loops_.size() && loops_[last].structure == loops_[first].structure) ++last;
    return last;
}

std::uint32_t ConflatedContours::vertex_of(Vec3 p) const {
    const auto less = [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); };
    return static_cast<std::uint32_t>(std::lower_bound(points_.begin(), points_.end(), p, less) -
                                      points_.begin());
}

std::vector<Vec2> ConflatedContours::polygon(const std::vector<std::uint32_t>& loop) const {
    std::vector<Vec2> points;
    for (const std::uint32_t v : loop) points.push_back(at_[v]);
    return points;
}

// Whether two segments of one structure meet elsewhere than in a common end.
bool ConflatedContours::touch(Edge p, Edge q) const {
    const SegmentContact contact = segment_contact(at_[p[0]], at_[p[1]], at_[q[0]], at_[q[1]]);
    const bool joined = has(q, p[0]) || has(q, p[1]);
    return joined ? contact == SegmentContact::overlap : contact != SegmentContact::none;
}

}  // namespace anatomesh
