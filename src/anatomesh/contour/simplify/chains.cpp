#include "anatomesh/contour/simplify/chains.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "anatomesh/contour/simplify/segment_grid.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

bool within_box(Vec2 p, Vec2 a, Vec2 b) {
    return std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
           p.y <= std::max(a.y, b.y);
}

// Whether two segments without a common end point meet; exact.
bool meet(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    if (std::max(a.x, b.x) < std::min(c.x, d.x) || std::max(c.x, d.x) < std::min(a.x, b.x) ||
        std::max(a.y, b.y) < std::min(c.y, d.y) || std::max(c.y, d.y) < std::min(a.y, b.y)) {
        return false;
    }
    const int abc = orient2d(a, b, c), abd = orient2d(a, b, d);
    if (abc * abd > 0) return false;
    const int cda = orient2d(c, d, a), cdb = orient2d(c, d, b);
    if (abc * abd < 0 && cda * cdb < 0) return true;
    return (abc == 0 && within_box(c, a, b)) || (abd == 0 && within_box(d, a, b)) ||
           (cda == 0 && within_box(a, c, d)) || (cdb == 0 && within_box(b, c, d));
}

// The polygon of least cost along one chain.
class ShortestPath {
  public:
    ShortestPath(const ThinOptions& options)
        : epsilon_(options.epsilon * (1 - 1e-9)), spacing_(options.spacing) {}

    // Returns the kept indices into `chain`, first and last included. A loop (first and last equal) keeps at
    // least one other.
    const std::vector<std::uint32_t>& run(std::span<const Vec2> chain) {
        const std::size_t last = chain.size() - 1;
        const bool loop = chain.front() == chain.back();
        cost_.assign(chain.size(), infinity);
        from_.assign(chain.size(), 0);
        cost_[0] = 0;
        for (std::size_t i = 0; i < last; ++i) relax_from(chain, i, loop && i == 0 ? last - 1 : last);

        kept_.clear();
        for (std::size_t at = last; at != 0; at = from_[at]) kept_.push_back(static_cast<std::uint32_t>(at));
        kept_.push_back(0);
        std::reverse(kept_.begin(), kept_.end());
        return kept_;
    }

  private:
    // Visits all shortcuts from i, to `last` at most. The directions in which a ray from i passes within epsilon of all
    // points so far are a cone between `right` and `left`. Once the cone is empty it stays empty.
    void relax_from(std::span<const Vec2> chain, std::size_t i, std::size_t last) {
        Vec2 right, left;
        bool bounded = false;
        double reach = 0;  // largest squared distance of a point so far from i
        const std::size_t end = std::min(last, i + longest_shortcut);
        for (std::size_t j = i + 1; j <= end; ++j) {
            const Vec2 d = chain[j] - chain[i];
            const double square = squared_length(d);
            const bool inside = !bounded || (cross(right, d) >= 0 && cross(d, left) >= 0);
            if (j == i + 1 || (inside && (square >= reach || spans(chain, i, j))))
                relax(i, j, std::sqrt(square));

            reach = std::max(reach, square);
            if (square <= epsilon_ * epsilon_) continue;  // in reach of i itself: any direction will do
            const double along = std::sqrt(square - epsilon_ * epsilon_);
            const Vec2 l{along * d.x - epsilon_ * d.y, epsilon_ * d.x + along * d.y};
            const Vec2 r{along * d.x + epsilon_ * d.y, along * d.y - epsilon_ * d.x};
            if (!bounded) {
                right = r;
                left = l;
                bounded = true;
                continue;
            }
            if (cross(right, l) < 0 || cross(r, left) < 0) return;
            if (cross(right, r) > 0) right = r;
            if (cross(l, left) > 0) left = l;
        }
    }

    // Whether all points between stay within epsilon of the segment, checked one by one.
    bool spans(std::span<const Vec2> chain, std::size_t i, std::size_t j) const {
        for (std::size_t k = i + 1; k < j; ++k) {
            if (distance_to_segment(chain[k], chain[i], chain[j]) > epsilon_) return false;
        }
        return true;
    }

    void relax(std::size_t i, std::size_t j, double segment) {
        const double cost = cost_[i] + 1 + price(segment);
        if (cost < cost_[j]) {
            cost_[j] = cost;
            from_[j] = static_cast<std::uint32_t>(i);
        }
    }

    // Returns what a segment of this length costs beyond its vertex. A segment shorter than the spacing costs several
    // vertices. Else the cost grows with the square of its length, which makes neighbouring segments equally long.
    double price(double segment) const {
        if (spacing_ <= 0) return 0;
        const double ratio = segment / spacing_;
        if (ratio < 1) return 2 + 2 * (1 - ratio);
        return 0.0006 * ratio * ratio;
    }

    // A shortcut passes by fewer points than this: longer ones are not looked at. [points; > 1; B]
    static constexpr std::size_t longest_shortcut = 128;

    double epsilon_, spacing_;
    std::vector<double> cost_;
    std::vector<std::uint32_t> from_, kept_;
};

// A kept segment, by the positions of its ends in the chains' points. The chain from a to b is what it stands
// for.
struct Span {
    std::uint32_t a, b;
    bool fresh;  // not checked yet

    bool skips() const { return b - a > 1; }
};

class Thinner {
  public:
    Thinner(const ChainNetwork& network, const ThinOptions& options)
        : network_(network), options_(options), positions_(network.chain_points) {}

    ThinResult run() {
        for (std::size_t c = 0; c < network_.size(); ++c) thin_chain(c);
        for (int round = 0; mark_conflicts(); ++round) split_marked(round >= patient_rounds);
        return result();
    }

  private:
    Vec2 point(std::uint32_t position) const { return network_.points[positions_[position]]; }
    std::uint32_t vertex(std::uint32_t position) const { return positions_[position]; }

    void thin_chain(std::size_t c) {
        const std::uint32_t first = network_.first[c], count = network_.first[c + 1] - first;
        load(first, count);
        const bool loop = vertex(first) == vertex(first + count - 1);
        if (loop && !network_.has_junction[c]) {
            // A loop starts at a vertex that is worth keeping: the middle one of a first try.
            const std::vector<std::uint32_t>& tried = path_.run(chain_);
            const std::uint32_t start = tried[tried.size() / 2];
            const auto begin = positions_.begin() + first;
            if (start != 0 && start != count - 1) {
                std::rotate(begin, begin + start, begin + count - 1);
                positions_[first + count - 1] = positions_[first];
                load(first, count);
            }
        }
        const std::vector<std::uint32_t>& kept = path_.run(chain_);
        for (std::size_t k = 0; k + 1 < kept.size(); ++k) {
            spans_.push_back({first + kept[k], first + kept[k + 1], true});
        }
    }

    void load(std::uint32_t first, std::uint32_t count) {
        chain_.clear();
        for (std::uint32_t k = 0; k < count; ++k) chain_.push_back(point(first + k));
    }

    // Marks the spans that must be split. Returns whether there are any.
    bool mark_conflicts() {
        marked_.assign(spans_.size(), 0);
        seen_.assign(spans_.size(), std::numeric_limits<std::uint32_t>::max());
        grid_.build(static_cast<std::uint32_t>(spans_.size()),
                    [this](std::uint32_t s) { return std::pair(point(spans_[s].a), point(spans_[s].b)); });
        any_marked_ = false;
        for (std::uint32_t s = 0; s < spans_.size(); ++s) {
            if (!spans_[s].fresh) continue;
            Box2 box;
            box.extend(point(spans_[s].a));
            box.extend(point(spans_[s].b));
            // What a span stands for lies within epsilon of it, so does any vertex between the two.
            grid_.query(box.grown(options_.epsilon + options_.clearance), [&](std::uint32_t t) {
                if (t == s || seen_[t] == s) return;
                seen_[t] = s;
                if (spans_[s].skips() || spans_[t].skips()) check_pair(s, t);
            });
        }
        return any_marked_;
    }

    void mark(std::uint32_t s) {
        if (!spans_[s].skips()) return;
        marked_[s] = 1;
        any_marked_ = true;
    }

    void check_pair(std::uint32_t s, std::uint32_t t) {
        if (conflict(spans_[s].a, spans_[s].b, spans_[t].a, spans_[t].b) &&
            !conflict_before(spans_[s], spans_[t])) {
            mark(s);
            mark(t);
        }
        if (encloses_end(spans_[s], spans_[t])) mark(s);
        if (encloses_end(spans_[t], spans_[s])) mark(t);
        if (came_too_near(spans_[s], spans_[t])) mark(s);
        if (came_too_near(spans_[t], spans_[s])) mark(t);
    }

    // Whether the segments between these positions meet other than in a common end point.
    bool conflict(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
        const std::uint32_t va = vertex(a), vb = vertex(b), vc = vertex(c), vd = vertex(d);
        const int shared = (va == vc || va == vd) + (vb == vc || vb == vd);
        if (shared == 0) return meet(point(a), point(b), point(c), point(d));
        if (shared == 2) return true;
        const bool at_a = va == vc || va == vd;
        const Vec2 common = point(at_a ? a : b), end = point(at_a ? b : a);
        const Vec2 other = vertex(c) == (at_a ? va : vb) ? point(d) : point(c);
        return orient2d(common, end, other) == 0 && dot(end - common, other - common) > 0;
    }

    // Whether what the two spans stand for met already.
    bool conflict_before(const Span& s, const Span& t) const {
        for (std::uint32_t i = s.a; i < s.b; ++i) {
            for (std::uint32_t j = t.a; j < t.b; ++j) {
                if (conflict(i, i + 1, j, j + 1)) return true;
            }
        }
        return false;
    }

    bool is_end_of(const Span& span, std::uint32_t position) const {
        return vertex(position) == vertex(span.a) || vertex(position) == vertex(span.b);
    }

    // Whether an end of `other` lies between the span and what it stands for.
    bool encloses_end(const Span& span, const Span& other) const {
        return span.skips() && (encloses(span, other.a) || encloses(span, other.b));
    }

    bool encloses(const Span& span, std::uint32_t position) const {
        if (is_end_of(span, position)) return false;
        const Vec2 v = point(position);
        if (distance_to_segment(v, point(span.a), point(span.b)) > options_.epsilon) return false;
        bool inside = false;
        for (std::uint32_t k = span.a; k <= span.b; ++k) {
            const Vec2 p = point(k), q = point(k < span.b ? k + 1 : span.a);
            if ((p.y > v.y) == (q.y > v.y)) continue;
            if (orient2d(p, q, v) == (q.y > p.y ? 1 : -1)) inside = !inside;
        }
        return inside;
    }

    // Whether an end of `other` is nearer to the span than the clearance though the chain kept further away.
    bool came_too_near(const Span& span, const Span& other) const {
        if (!span.skips() || is_end_of(other, span.a) || is_end_of(other, span.b)) return false;
        for (const std::uint32_t position : {other.a, other.b}) {
            const Vec2 v = point(position);
            const double now = distance_to_segment(v, point(span.a), point(span.b));
            if (now >= options_.clearance) continue;
            double before = infinity;
            for (std::uint32_t k = span.a; k < span.b; ++k) {
                before = std::min(before, distance_to_segment(v, point(k), point(k + 1)));
            }
            if (before > 1.25 * now) return true;
        }
        return false;
    }

    // Splits every marked span at its farthest point, or at all its points.
    void split_marked(bool at_all) {
        std::vector<Span> split;
        split.reserve(spans_.size() + spans_.size() / 8);
        for (std::uint32_t s = 0; s < spans_.size(); ++s) {
            const Span& span = spans_[s];
            if (!marked_[s]) {
                split.push_back({span.a, span.b, false});
            } else if (at_all) {
                for (std::uint32_t k = span.a; k < span.b; ++k) split.push_back({k, k + 1, true});
            } else {
                split_within_bound(span, split);
            }
        }
        spans_.swap(split);
    }

    // Splits the span once, and its parts as long as they do not keep the bound: a part may lie farther from
    // its points than the whole did.
    void split_within_bound(const Span& span, std::vector<Span>& split) {
        std::uint32_t begin = span.a;
        ends_.assign({span.b, farthest(span).first});
        while (!ends_.empty()) {
            const Span part{begin, ends_.back(), true};
            if (part.skips()) {
                const auto [middle, distance] = farthest(part);
                if (distance > options_.epsilon) {
                    ends_.push_back(middle);
                    continue;
                }
            }
            split.push_back(part);
            begin = part.b;
            ends_.pop_back();
        }
    }

    // The skipped point farthest from the span, and how far it is.
    std::pair<std::uint32_t, double> farthest(const Span& span) const {
        std::pair<std::uint32_t, double> found{span.a + 1, -1.0};
        for (std::uint32_t k = span.a + 1; k < span.b; ++k) {
            const double distance = distance_to_segment(point(k), point(span.a), point(span.b));
            if (distance > found.second) found = {k, distance};
        }
        return found;
    }

    ThinResult result() const {
        ThinResult thin;
        thin.kept.assign(network_.points.size(), 0);
        for (const Span& span : spans_) {
            thin.kept[vertex(span.a)] = thin.kept[vertex(span.b)] = 1;
            if (span.skips()) thin.max_distance = std::max(thin.max_distance, farthest(span).second);
        }
        return thin;
    }

    // In so many rounds a span is split once; after them at all its points, so that the rounds end. [rounds; > 0; B]
    static constexpr int patient_rounds = 8;

    const ChainNetwork& network_;
    const ThinOptions& options_;
    std::vector<std::uint32_t> positions_;  // the chains' points, loops turned to their start
    std::vector<Vec2> chain_;
    ShortestPath path_{options_};
    std::vector<Span> spans_;
    SegmentGrid grid_;
    std::vector<std::uint32_t> ends_;  // of the parts of a span still to be looked at, the nearest last
    std::vector<std::uint8_t> marked_;
    std::vector<std::uint32_t> seen_;  // per span: the last one it was checked against
    bool any_marked_ = false;
};

}  // namespace

ThinResult thin_chains(const ChainNetwork& network, const ThinOptions& options) {
    assert(options.epsilon > 0 && options.spacing >= 0 && options.clearance >= 0);
    if (network.size() == 0) return {std::vector<std::uint8_t>(network.points.size(), 1), 0};
    return Thinner(network, options).run();
}

}  // namespace anatomesh
