#include "anatomesh/contour/overlay/separate.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstddef>
#include <map>
#include <numeric>
#include <utility>

#include "anatomesh/contour/overlay/nesting.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// A part of a region narrower than this is a hair, which is rounding. [mm; > 0; D]
constexpr double hair_mm = 1e-6;
// Of vertices crowded within a corridor's width at most so many are looked at. [vertices; > 0; B]
constexpr std::size_t crowd = 64;
// A vertex so near to one that rings share leaves that one no room: it goes with the corner that is cut off.
// [distances of separation; 0 to 0.25; B]
constexpr double crowded_share = 0.1;

std::size_t following(const Ring& ring, std::size_t i) {
    return i + 1 < ring.size() ? i + 1 : 0;
}
std::size_t preceding(const Ring& ring, std::size_t i) {
    return i > 0 ? i - 1 : ring.size() - 1;
}

// Edges e and f (named by their first vertices) that run back along each other.
using EdgePair = std::pair<std::uint32_t, std::uint32_t>;

class CorridorFinder {
  public:
    CorridorFinder(const Ring& ring, double width) : ring_(ring), width_(width) {
        orientation_ = signed_area(ring.at) >= 0 ? 1 : -1;
    }

    // Returns the pairs (e, f), e < f, of all corridors.
    std::vector<EdgePair> run() {
        find_pairs([this](std::uint32_t e, std::uint32_t f) { return runs_back(e, f); });
        std::vector<EdgePair> kept;
        for (const EdgePair& pair : pairs_) {
            if (chain_length(pair) >= 10 * width_) kept.push_back(pair);
        }
        return kept;
    }

    // Returns the pairs of keyholes.
    std::vector<EdgePair> keyholes(double crossing) {
        // By vertex, this is twice the area between the first vertex and the ring up to it.
        std::vector<double> area(ring_.size() + 1, 0);
        for (std::size_t i = 0; i < ring_.size(); ++i)
            area[i + 1] =
                area[i] + cross(ring_.at[i] - ring_.at[0], ring_.at[following(ring_, i)] - ring_.at[0]);
        find_pairs([&](std::uint32_t e, std::uint32_t f) { return is_keyhole(e, f, crossing, area); });
        return std::move(pairs_);
    }

  private:
    double edge_length(std::size_t e) const { return length(ring_.at[following(ring_, e)] - ring_.at[e]); }

    // A long edge, in the cell of its last vertex.
    struct Entry {
        std::int64_t x, y;
        std::uint32_t edge;
        friend auto operator<=>(const Entry&, const Entry&) = default;
    };

    template <class IsPair>
    void find_pairs(const IsPair& is_pair) {
        std::vector<Entry> entries;
        for (std::uint32_t f = 0; f < ring_.size(); ++f) {
            if (edge_length(f) < 2 * width_) continue;
            const auto [x, y] = cell_of(ring_.at[following(ring_, f)]);
            entries.push_back({x, y, f});
        }
        std::sort(entries.begin(), entries.end());
        // The partner of an edge ends in the cell where the edge begins, or beside it.
        for (std::uint32_t e = 0; e < ring_.size(); ++e) {
            if (edge_length(e) < 2 * width_) continue;
            const auto [x, y] = cell_of(ring_.at[e]);
            for (std::int64_t column = x - 1; column <= x + 1; ++column) {
                auto entry = std::lower_bound(entries.begin(), entries.end(), Entry{column, y - 1, 0});
                for (std::size_t seen = 0; seen < crowd && entry != entries.end(); ++entry, ++seen) {
                    if (entry->x != column || entry->y > y + 1) break;
                    if (e < entry->edge && is_pair(e, entry->edge)) pairs_.push_back({e, entry->edge});
                }
            }
        }
        std::sort(pairs_.begin(), pairs_.end());
    }

    std::pair<std::int64_t, std::int64_t> cell_of(Vec2 p) const {
        const double size = std::max(width_, hair_mm);
        return {static_cast<std::int64_t>(std::floor(p.x / size)),
                static_cast<std::int64_t>(std::floor(p.y / size))};
    }

    // How far apart two edges are at their ends.
    double gap_between(std::uint32_t e, std::uint32_t f) const {
        return std::max(length(ring_.at[following(ring_, f)] - ring_.at[e]),
                        length(ring_.at[f] - ring_.at[following(ring_, e)]));
    }

    // On which side of e the other lies: the outside of the ring, or the inside.
    bool has_outside_between(std::uint32_t e, std::uint32_t f) const {
        const Vec2 a = ring_.at[e], along = ring_.at[following(ring_, e)] - a;
        return orientation_ *
                   (cross(along, ring_.at[following(ring_, f)] - a) + cross(along, ring_.at[f] - a)) <=
               0;
    }

    bool runs_back(std::uint32_t e, std::uint32_t f) const {
        const double gap = gap_between(e, f);
        return gap <= width_ && gap > 0 && (gap <= hair_mm || has_outside_between(e, f));
    }

    bool is_keyhole(std::uint32_t e, std::uint32_t f, double crossing,
                    const std::vector<double>& area) const {
        const double gap = gap_between(e, f), shorter = std::min(edge_length(e), edge_length(f));
        // One width is the same on all slices, except for rounding.
        if (gap > 1.001 * width_ || gap == 0 || shorter < 10 * gap) return false;
        if (gap > crossing && !has_outside_between(e, f)) return false;
        // The ring from the end of e to the beginning of f, and the rest.
        const Vec2 first = ring_.at[0], from = ring_.at[e + 1], to = ring_.at[f];
        const double loop = orientation_ * 0.5 * (area[f] - area[e + 1] + cross(to - first, from - first));
        const double rest = orientation_ * 0.5 * area.back() - loop, corridor = gap * shorter;
        return (loop < -corridor && rest > corridor) || (rest < -corridor && loop > corridor);
    }

    bool contains(std::uint32_t e, std::uint32_t f) const {
        return std::binary_search(pairs_.begin(), pairs_.end(), EdgePair{std::min(e, f), std::max(e, f)});
    }

    // Length of the run of pairs that this one is part of.
    double chain_length(EdgePair pair) const {
        double sum = edge_length(pair.first);
        for (const bool forward : {true, false}) {
            std::size_t e = pair.first, f = pair.second;
            for (std::size_t steps = 0; steps < ring_.size() && sum < 10 * width_; ++steps) {
                e = forward ? following(ring_, e) : preceding(ring_, e);
                f = forward ? preceding(ring_, f) : following(ring_, f);
                if (!contains(static_cast<std::uint32_t>(e), static_cast<std::uint32_t>(f))) break;
                sum += edge_length(e);
            }
        }
        return sum;
    }

    const Ring& ring_;
    const double width_;
    double orientation_ = 1;
    std::vector<EdgePair> pairs_;
};

// A ring's vertex that another ring has too.
struct Shared {
    std::uint32_t ring = 0, position = 0;
    Vec2 from, inward;             // the vertex; unit bisector of the polygon's angle there
    Vec2 previous, next;           // those beside it
    Vec2 to_before, to_after;      // units, along the edges
    double before = 0, after = 0;  // their lengths
    int rank = 0;  // 0: no smaller ring there lies in its angle, 1: one does, in which none lies ...
};

// Unit bisector of the polygon's angle between two edges that leave a vertex.
Vec2 bisector(Vec2 to_before, Vec2 to_after, double orientation) {
    // The inner normals of both edges: their sum halves the angle, convex or not.
    Vec2 sum = orientation * (Vec2{to_before.y, -to_before.x} + Vec2{-to_after.y, to_after.x});
    if (length(sum) < 1e-6) sum = to_before + to_after;  // a needle: straight into it
    return (1 / length(sum)) * sum;
}

struct Parted {
    std::vector<Vec2> line;  // in the place of the vertex
    double displacement_mm;  // how far that is from it
};

// The line that takes the place of a shared vertex, in the ring's order. An acute corner is cut off at a depth, so that
// no more of the region goes than must. The vertex of an obtuse one goes in as far, and the edges bend where they are
// as far from lines of the other ring that run straight on.
Parted parted(const Shared& shared, double distance) {
    const double room = 0.25 * std::min(shared.before, shared.after),
                 cosine = dot(shared.inward, shared.to_before),
                 sine = std::abs(cross(shared.to_before, shared.to_after));
    if (cosine > 0.5) {
        const double along = std::min(distance / cosine, room);
        return {{shared.from + along * shared.to_before, shared.from + along * shared.to_after},
                along * cosine};
    }
    const double depth = std::min(distance, room);
    std::vector<Vec2> line{shared.from + depth * shared.inward};
    if (depth < 0.5 * sine * shared.before)
        line.insert(line.begin(), shared.from + (depth / sine) * shared.to_before);
    if (depth < 0.5 * sine * shared.after) line.push_back(shared.from + (depth / sine) * shared.to_after);
    return {std::move(line), depth};
}

// Whether a direction from the vertex lies in the polygon's angle there.
bool is_between(const Shared& shared, Vec2 direction) {
    return dot(shared.inward, direction) > dot(shared.inward, shared.to_before);
}

std::vector<Shared> find_shared(const std::vector<Ring>& rings) {
    struct Visit {
        Vec2 at;
        std::uint32_t ring, position;
    };
    std::vector<double> area;
    std::vector<Visit> visits;
    for (std::uint32_t r = 0; r < rings.size(); ++r) {
        area.push_back(signed_area(rings[r].at));
        for (std::uint32_t i = 0; i < rings[r].size(); ++i) visits.push_back({rings[r].at[i], r, i});
    }
    std::sort(visits.begin(), visits.end(), [&](const Visit& p, const Visit& q) {
        if (!(p.at == q.at)) return lexicographic_less(p.at, q.at);
        const double p_area = std::abs(area[p.ring]), q_area = std::abs(area[q.ring]);
        return p_area != q_area ? p_area > q_area : p.ring < q.ring;
    });
    std::vector<Shared> shared;
    for (std::size_t v = 1; v < visits.size(); ++v) {
        if (!(visits[v].at == visits[v - 1].at)) continue;
        const Ring& ring = rings[visits[v].ring];
        const std::size_t i = visits[v].position;
        Shared found{visits[v].ring, visits[v].position, ring.at[i], {}, {}, {}, {}, {}};
        found.previous = ring.at[preceding(ring, i)];
        found.next = ring.at[following(ring, i)];
        found.to_before = found.previous - ring.at[i];
        found.to_after = found.next - ring.at[i];
        found.before = length(found.to_before);
        found.after = length(found.to_after);
        found.to_before = (1 / found.before) * found.to_before;
        found.to_after = (1 / found.after) * found.to_after;
        found.inward = bisector(found.to_before, found.to_after, area[visits[v].ring] >= 0 ? 1.0 : -1.0);
        shared.push_back(found);
    }
    // The corners of one place come from the largest to the smallest.
    for (std::size_t s = shared.size(); s-- > 0;) {
        for (std::size_t t = s + 1; t < shared.size() && shared[t].from == shared[s].from; ++t) {
            if (is_between(shared[s], shared[t].inward))
                shared[s].rank = std::max(shared[s].rank, shared[t].rank + 1);
        }
    }
    return shared;
}

// Leaves out vertices nearer than `near` to shared ones that are to leave their place. Vertices that rings share stay,
// and so do three of each ring. Returns the distance of the farthest that went, by ring.
std::vector<double> leave_out_crowded_beside(const std::vector<Shared>& shared, double near,
                                             std::vector<Ring>& rings) {
    std::vector<Vec2> places;
    for (const Shared& s : shared) places.push_back(s.from);
    const auto less = [](Vec2 p, Vec2 q) { return lexicographic_less(p, q); };
    std::sort(places.begin(), places.end(), less);
    std::vector<std::vector<std::uint8_t>> crowded(rings.size());
    std::vector<double> farthest(rings.size(), 0);
    for (const Shared& s : shared) {
        const Ring& ring = rings[s.ring];
        crowded[s.ring].resize(ring.size(), 0);
        for (const bool forward : {true, false}) {
            std::size_t i = s.position;
            for (std::size_t steps = 0; steps < ring.size(); ++steps) {
                i = forward ? following(ring, i) : preceding(ring, i);
                if (!(length(ring.at[i] - s.from) < near) ||
                    std::binary_search(places.begin(), places.end(), ring.at[i], less))
                    break;
                crowded[s.ring][i] = 1;
                farthest[s.ring] = std::max(farthest[s.ring], length(ring.at[i] - s.from));
            }
        }
    }
    for (std::size_t r = 0; r < rings.size(); ++r) {
        const auto left = std::count(crowded[r].begin(), crowded[r].end(), 0);
        if (crowded[r].empty() || left < 3) {
            farthest[r] = 0;
            continue;
        }
        std::size_t i = 0, j = 0;
        std::erase_if(rings[r].at, [&](Vec2) { return crowded[r][i++] != 0; });
        std::erase_if(rings[r].points, [&](const Vec3&) { return crowded[r][j++] != 0; });
    }
    return farthest;
}

// Whether any of the points, in order of x, lies in the corner that is cut off, or on its new line.
bool holds_any(const std::vector<Vec2>& points, const Shared& shared, const std::vector<Vec2>& line) {
    std::vector<Vec2> corner{shared.from, shared.previous};
    corner.insert(corner.end(), line.begin(), line.end());
    corner.push_back(shared.next);
    Box2 box;
    for (const Vec2 p : corner) box.extend(p);
    const auto before = [](Vec2 p, double x) { return p.x < x; };
    for (auto p = std::lower_bound(points.begin(), points.end(), box.low.x, before);
         p != points.end() && p->x <= box.high.x; ++p) {
        const bool is_own = *p == shared.from || *p == shared.previous || *p == shared.next;
        if (!is_own && box.contains(*p) && side_of_polygon(corner, *p) != Side::outside) return true;
    }
    return false;
}

// Puts vertices in the place of one of a ring.
void replace(Ring& ring, std::uint32_t position, const Plane& plane, const std::vector<Vec2>& line) {
    const auto at = [&](auto& list) { return list.begin() + static_cast<std::ptrdiff_t>(position); };
    ring.points.erase(at(ring.points));
    ring.at.erase(at(ring.at));
    for (std::size_t n = line.size(); n-- > 0;) {
        const Vec3 point = plane.to_space(line[n]);
        ring.points.insert(at(ring.points), point);
        ring.at.insert(at(ring.at), plane.to_plane(point));
    }
}

// Gives each second edge the vertices of its first; returns the largest move.
double close_pairs(Ring& ring, const std::vector<EdgePair>& pairs) {
    double most = 0;
    const auto take = [&](std::size_t to, std::size_t from) {
        most = std::max(most, length(ring.at[to] - ring.at[from]));
        ring.at[to] = ring.at[from];
        ring.points[to] = ring.points[from];
    };
    for (const auto& [e, f] : pairs) {
        take(following(ring, f), e);
        take(f, following(ring, e));
    }
    if (most > 0) remove_spikes(ring);
    return most;
}

}  // namespace

double close_corridors(Ring& ring, double width) {
    return ring.size() < 3 ? 0 : close_pairs(ring, CorridorFinder(ring, width).run());
}

double close_keyholes(Ring& ring, double width, double crossing) {
    return ring.size() < 3 ? 0 : close_pairs(ring, CorridorFinder(ring, width).keyholes(crossing));
}

bool separate_rings(std::vector<Ring>& rings, const Plane& plane, double distance,
                    std::vector<Separation>& done) {
    std::vector<Shared> shared = find_shared(rings);
    if (shared.empty()) return true;
    std::vector<Ring> roomy = rings;
    const std::vector<double> left_out = leave_out_crowded_beside(shared, crowded_share * distance, roomy);
    shared = find_shared(roomy);
    std::vector<Vec2> points;
    for (const Ring& ring : roomy) points.insert(points.end(), ring.at.begin(), ring.at.end());
    std::sort(points.begin(), points.end(), [](Vec2 p, Vec2 q) { return lexicographic_less(p, q); });
    // The back of each ring comes first, so that positions hold.
    std::sort(shared.begin(), shared.end(), [](const Shared& a, const Shared& b) {
        return a.ring != b.ring ? a.ring < b.ring : a.position > b.position;
    });
    // Where more than two meet, one inside the other, the larger must move less than the smaller. How much less depends
    // on the angles, so ever smaller shares and moves are tried.
    for (double share : {0.5, 0.05, 0.005}) {
        for (double scale = 1; scale > 1e-3; scale *= 0.5) {
            std::vector<Ring> apart = roomy;
            std::map<std::uint32_t, Separation> by_ring;
            bool jumps = false;  // over a ring that is smaller than what is cut off
            for (const Shared& s : shared) {
                const Parted by = parted(s, scale * std::pow(share, s.rank) * distance);
                jumps = jumps || holds_any(points, s, by.line);
                Separation& separation = by_ring[s.ring];
                separation.ring = s.ring;
                ++separation.vertices;
                separation.displacement_mm =
                    std::max({separation.displacement_mm, by.displacement_mm, left_out[s.ring]});
                replace(apart[s.ring], s.position, plane, by.line);
            }
            if (jumps || !keep_apart(RingEdges(apart), apart)) continue;
            for (const auto& [ring, separation] : by_ring) done.push_back(separation);
            rings = std::move(apart);
            return true;
        }
    }
    return false;
}

}  // namespace anatomesh
