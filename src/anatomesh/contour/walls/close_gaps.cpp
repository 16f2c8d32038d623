#include "anatomesh/contour/walls/close_gaps.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/contour/walls/conflated_contours.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {
namespace {

class SliceGaps : public ConflatedContours {
  public:
    SliceGaps(const ContourSet& set, const Slice& slice, double width)
        : ConflatedContours(set, slice), width_(width) {}

    void close() {
        if (loops_.empty() || loops_.front().structure == loops_.back().structure) return;
        // Later structures take the vertices of earlier ones, and earlier ones what these pass in between. Then
        // it goes the other way round, where the earlier one's vertices are too far apart to be near to anything.
        for (const bool to_later : {true, false}) {
            take_vertices(to_later);
            take_paths();
        }
        take_back();
    }

  private:
    // By segment of the loops, whether another structure has it too, the other way round.
    struct Segments {
        std::vector<Edge> ends;
        std::vector<std::uint32_t> loop, number;
        std::vector<std::uint8_t> shared;
    };
    Segments segments() const {
        Segments all;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            for (std::uint32_t n = 0; n < loops_[l].vertices.size(); ++n) {
                all.ends.push_back({loops_[l].vertices[n], loops_[l].next_of(n)});
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

    // Inserts vertices of earlier structures, or of later ones, into the segments beside them.
    void take_vertices(bool to_later) {
        const Segments all = segments();
        const std::vector<Edge> owners = owned();
        std::vector<Beside> found;
        const auto consider = [&](std::uint32_t i, std::uint32_t j) {
            // This looks at the first end of segment i beside segment j.
            const ConflatedContour &from = loops_[all.loop[i]], &to = loops_[all.loop[j]];
            if (all.shared[j] || (to_later ? from.structure >= to.structure : from.structure <= to.structure))
                return;
            const std::uint32_t v = all.ends[i][0];
            if (std::binary_search(owners.begin(), owners.end(), Edge{to.structure, v})) return;
            const Vec2 a = at_[all.ends[j][0]], b = at_[all.ends[j][1]];
            const double apart = distance_to_segment(at_[v], a, b);
            const Edge drawn = drawn_segment(to, all.number[j]);
            if (!(apart < width_) || !(distance_to_segment(at_[v], at_[drawn[0]], at_[drawn[1]]) < width_))
                return;
            const Vec2 course = at_[all.ends[i][1]] - at_[from.last_of(all.number[i])];
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

    using ConflatedContours::hidden;
    std::vector<std::uint8_t> hidden(const std::vector<Beside>& found, const Segments& all) const {
        std::vector<Way> ways;
        for (const Beside& x : found) {
            const Edge to{loops_[x.loop].vertices[x.segment], loops_[x.loop].next_of(x.segment)};
            ways.push_back({at_[x.vertex], to, {to}, x.vertex});
        }
        return hidden(ways, all.ends);
    }

    // A segment becomes the path beside it between its ends, where both are vertices of another structure's loop.
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
                const std::uint32_t a = loops_[l].vertices[n], b = loops_[l].next_of(n);
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

    // Returns the vertices of `other` from the one after number `from`, which is b, up to a. Returns none where one
    // is too far from the segment, or belongs to the structure already.
    std::vector<Beside> path_beside(std::uint32_t l, std::uint32_t n, std::uint32_t a, std::uint32_t other,
                                    std::uint32_t from, const std::vector<Edge>& owners) const {
        std::vector<Beside> path;
        const Edge drawn = drawn_segment(loops_[l], n);
        const ConflatedContour& way = loops_[other];
        const Vec2 back = at_[a] - at_[loops_[l].next_of(n)];
        for (std::size_t k = 1; k < way.vertices.size(); ++k) {
            const std::uint32_t v = way.vertices[(from + k) % way.vertices.size()];
            const std::uint32_t last = way.vertices[(from + k - 1) % way.vertices.size()];
            if (dot(at_[v] - at_[last], back) < 0) return {};
            if (v == a) break;
            const double apart = distance_to_segment(at_[v], at_[drawn[0]], at_[drawn[1]]);
            if (!(apart < width_) ||
                std::binary_search(owners.begin(), owners.end(), Edge{loops_[l].structure, v}) ||
                k + 1 == way.vertices.size()) {
                return {};
            }
            // The path runs against the segment.
            path.push_back({v, l, n, -static_cast<double>(k), apart});
        }
        return path;
    }

    // Takes back vertices that are no end of a shared segment, and those at which contours of a structure came to
    // touch or cross one another.
    void take_back() {
        for (bool again = true; again;) {
            again = drop(lone());
            again = drop(out_of_sight()) || again;
            for (std::size_t first = 0; first < loops_.size();) {
                const std::size_t last = end_of_structure(first);
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
                if (loops_[l].taken(n) && !serves) places.push_back({l, n});
            }
            first += count;
        }
        return places;
    }

    // Ends of shared segments that another contour hides, seen from where the contour was drawn.
    std::vector<Place> out_of_sight() const {
        std::vector<Edge> drawn;
        std::vector<std::pair<Edge, Place>> by_ends;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            const ConflatedContour& loop = loops_[l];
            for (std::size_t n = 0; n < loop.drawn.size(); ++n)
                drawn.push_back({loop.drawn[n], loop.drawn[(n + 1) % loop.drawn.size()]});
            for (std::uint32_t n = 0; n < loop.vertices.size(); ++n)
                by_ends.push_back({{loop.vertices[n], loop.next_of(n)}, {l, n}});
        }
        std::sort(by_ends.begin(), by_ends.end());
        std::vector<Way> ways;
        std::vector<Place> starts, places;
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            const ConflatedContour& loop = loops_[l];
            for (std::uint32_t n = 0; n < loop.vertices.size(); ++n) {
                const std::uint32_t a = loop.vertices[n], b = loop.next_of(n);
                if (!loop.taken(n) && !loop.taken((n + 1) % loop.vertices.size())) continue;
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
                if (cut_off[k] && loops_[l].taken(m)) places.push_back({l, m});
            }
        }
        return places;
    }

    double width_;
};

}  // namespace

ConflationStats close_gaps(ContourSet& set, const CloseGapsOptions& options) {
    assert(options.width_mm >= 0 && options.width_mm <= 10);
    ConflationStats stats;
    if (options.width_mm == 0 || set.structures.size() < 2) return stats;
    lead_slices(set, stats, [&](std::uint32_t s) {
        SliceGaps gaps(set, set.slices[s], options.width_mm);
        gaps.close();
        return static_cast<ConflatedContours>(std::move(gaps));
    });
    return stats;
}

}  // namespace anatomesh
