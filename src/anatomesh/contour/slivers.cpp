#include "anatomesh/contour/slivers.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "anatomesh/contour/segment_index.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {
namespace {

using Pair = std::array<std::uint32_t, 2>;

// Where two loops meet: how far along either, the n-th vertex at n.
struct Meeting {
    Pair loops;
    double along_first = 0, along_second = 0;
};

class Slivers {
  public:
    Slivers(const std::vector<LedContour>& loops, const std::vector<Vec2>& at, double width,
            double share_of_segment)
        : loops_(loops), at_(at), width_(width), share_of_segment_(share_of_segment) {}

    std::vector<Pair> found() {
        std::vector<Meeting> all = meetings();
        for (std::size_t first = 0; first < all.size();) {
            std::size_t last = first;
            while (last < all.size() && all[last].loops == all[first].loops) ++last;
            between({all.begin() + static_cast<std::ptrdiff_t>(first),
                     all.begin() + static_cast<std::ptrdiff_t>(last)});
            first = last;
        }
        std::sort(beside_.begin(), beside_.end());
        beside_.erase(std::unique(beside_.begin(), beside_.end()), beside_.end());
        return std::move(beside_);
    }

  private:
    // Of loops of different structures, by loops and along the first, each once.
    std::vector<Meeting> meetings() const {
        std::vector<Segment2> segments;
        std::vector<Pair> places;  // loop, number
        for (std::uint32_t l = 0; l < loops_.size(); ++l) {
            for (std::uint32_t n = 0; n < loops_[l].vertices.size(); ++n) {
                segments.push_back({at_[loops_[l].vertices[n]], at_[loops_[l].next_of(n)]});
                places.push_back({l, n});
            }
        }
        std::vector<Meeting> all;
        SegmentIndex(std::move(segments)).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            if (loops_[places[i][0]].structure != loops_[places[j][0]].structure)
                meet(places[i], places[j], all);
            return true;
        });
        const auto key = [](const Meeting& m) { return std::tuple{m.loops, m.along_first, m.along_second}; };
        std::sort(all.begin(), all.end(),
                  [&](const Meeting& p, const Meeting& q) { return key(p) < key(q); });
        all.erase(std::unique(all.begin(), all.end(),
                              [&](const Meeting& p, const Meeting& q) { return key(p) == key(q); }),
                  all.end());
        return all;
    }

    // Places are in rising order, as their segments are in the index.
    void meet(Pair p, Pair q, std::vector<Meeting>& all) const {
        const LedContour &first = loops_[p[0]], &second = loops_[q[0]];
        const std::array<std::uint32_t, 2> own{first.vertices[p[1]], first.next_of(p[1])};
        const std::array<std::uint32_t, 2> other{second.vertices[q[1]], second.next_of(q[1])};
        bool common = false;
        for (std::uint32_t k = 0; k < 2; ++k) {
            for (std::uint32_t m = 0; m < 2; ++m) {
                if (own[k] != other[m]) continue;
                common = true;
                all.push_back({{p[0], q[0]},
                               static_cast<double>((p[1] + k) % first.vertices.size()),
                               static_cast<double>((q[1] + m) % second.vertices.size())});
            }
        }
        const Vec2 a = at_[own[0]], b = at_[own[1]], c = at_[other[0]], d = at_[other[1]];
        if (common || segment_contact(a, b, c, d) != SegmentContact::cross) return;
        const double across = cross(b - a, d - c);
        const auto share = [&](double part) {
            return across == 0 ? 0.5 : std::clamp(part / across, 0.0, 1.0);
        };
        all.push_back({{p[0], q[0]}, p[1] + share(cross(c - a, d - c)), q[1] + share(cross(c - a, b - a))});
    }

    // What lies between meetings of two loops that follow one another along both. They come in their order
    // along the first.
    void between(const std::vector<Meeting>& all) {
        const std::size_t count = all.size();
        if (count < 2) return;
        std::vector<std::size_t> order(count), rank(count);
        for (std::size_t k = 0; k < count; ++k) order[k] = k;
        std::sort(order.begin(), order.end(), [&](std::size_t p, std::size_t q) {
            return std::tuple{all[p].along_second, p} < std::tuple{all[q].along_second, q};
        });
        for (std::size_t k = 0; k < count; ++k) rank[order[k]] = k;
        for (std::size_t k = 0; k < count; ++k) {
            const std::size_t next = (k + 1) % count;
            if ((rank[next] + 1) % count != rank[k]) continue;
            const Stretch first = stretch(all[k].loops[0], all[k].along_first, all[next].along_first);
            const Stretch second = stretch(all[k].loops[1], all[next].along_second, all[k].along_second);
            const double width =
                std::min(width_, share_of_segment_ * std::min(mean_segment(first), mean_segment(second)));
            if (!is_near(first, second, width) || !is_near(second, first, width)) continue;
            for (const auto& [from, to] : {std::pair{first, second}, std::pair{second, first}}) {
                for (std::size_t n = 0; n < from.vertices; ++n) beside_.push_back({to.loop, vertex(from, n)});
            }
        }
    }

    // A part of a loop: segments from this number on, and the vertices between them.
    struct Stretch {
        std::uint32_t loop = 0;
        std::size_t start = 0, vertices = 0;
        std::size_t segments() const { return vertices + 1; }
    };

    // Between two places on a loop, over its start where the second is before the first.
    Stretch stretch(std::uint32_t loop, double from, double to) const {
        const double end = to < from ? to + static_cast<double>(loops_[loop].vertices.size()) : to;
        const auto start = static_cast<std::size_t>(from);
        const auto behind = static_cast<std::size_t>(std::ceil(end));
        return {loop, start, behind > start + 1 ? behind - start - 1 : 0};
    }
    std::size_t number(const Stretch& part, std::size_t k) const {
        return (part.start + k) % loops_[part.loop].vertices.size();
    }
    std::uint32_t vertex(const Stretch& part, std::size_t k) const {
        return loops_[part.loop].vertices[number(part, k + 1)];
    }
    Segment2 segment(const Stretch& part, std::size_t k) const {
        const std::size_t n = number(part, k);
        return {at_[loops_[part.loop].vertices[n]], at_[loops_[part.loop].next_of(n)]};
    }

    double mean_segment(const Stretch& part) const {
        double sum = 0;
        for (std::size_t k = 0; k < part.segments(); ++k)
            sum += length(segment(part, k).b - segment(part, k).a);
        return sum / static_cast<double>(part.segments());
    }

    // Whether each vertex of a stretch is nearer than the width to a segment of the other. Vertices that
    // follow one another are near the same segment or the one before it, so the search goes on where it
    // ended.
    bool is_near(const Stretch& part, const Stretch& other, double width) const {
        const std::size_t count = other.segments();
        std::size_t last = count - 1;
        for (std::size_t k = 0; k < part.vertices; ++k) {
            const auto near = [&](std::size_t n) {
                const auto [a, b] = segment(other, n);
                return distance_to_segment(at_[vertex(part, k)], a, b) < width;
            };
            std::size_t tried = 0;
            while (tried < count && !near((last + count - tried) % count)) ++tried;
            if (tried == count) return false;
            last = (last + count - tried) % count;
        }
        return true;
    }

    const std::vector<LedContour>& loops_;
    const std::vector<Vec2>& at_;
    double width_;
    double share_of_segment_;
    std::vector<Pair> beside_;
};

}  // namespace

std::vector<std::array<std::uint32_t, 2>> beside_in_slivers(const std::vector<LedContour>& loops,
                                                            const std::vector<Vec2>& at, double width_mm,
                                                            double share_of_segment) {
    return Slivers(loops, at, width_mm, share_of_segment).found();
}

}  // namespace anatomesh
