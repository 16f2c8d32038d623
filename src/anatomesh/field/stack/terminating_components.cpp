#include "anatomesh/field/stack/terminating_components.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <tuple>

#include "anatomesh/field/motion/boundary_pieces.h"

namespace anatomesh {

namespace {

// Of an outline this share must have a counterpart on the next slice for it to move there; else it ends.
// [1, of its length; 0 to 1; M 2026-11 lesion of one slice, skull with slices left out]
constexpr double least_matched = 0.5;
// If this share of an outline's area or more lies in the union on the next slice, the union goes on there.
// [1, of its area; 0 to 1; M 2026-11 lesion of one slice, skull with slices left out]
constexpr double most_covered = 0.5;
// So many chords across a hole say whether the other side of an outline alone is its counterpart.
// [chords; >= 2; B]
constexpr std::size_t few_chords = 8;
// The share of an outline's area is counted on a lattice of so many points a side. [points; >= 8; B]
constexpr int covered_lattice = 24;

// Edges of a region that close, by their numbers.
using Loop = std::vector<std::uint32_t>;

double twice_area(std::span<const Edge2> edges, const Loop& loop) {
    const Vec2 origin = edges[loop.front()].a;
    double sum = 0;
    for (const std::uint32_t e : loop) sum += cross(edges[e].a - origin, edges[e].b - origin);
    return sum;
}

// The largest first, so that no loop comes before one that it lies in.
std::vector<Loop> loops_of(std::span<const Edge2> edges) {
    const std::vector<std::uint32_t> next = following_edges(edges);
    std::vector<bool> taken(edges.size(), false);
    std::vector<Loop> loops;
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        Loop loop;
        std::uint32_t at = e;
        for (; at != no_piece && !taken[at]; at = next[at]) {
            taken[at] = true;
            loop.push_back(at);
        }
        if (at == e && loop.size() > 2) loops.push_back(std::move(loop));
    }
    std::stable_sort(loops.begin(), loops.end(), [&](const Loop& k, const Loop& l) {
        return std::abs(twice_area(edges, k)) > std::abs(twice_area(edges, l));
    });
    return loops;
}

// Even-odd, by the ray in +x.
bool is_within(Vec2 q, std::span<const Edge2> edges) {
    bool inside = false;
    for (const Edge2& edge : edges) {
        if ((edge.a.y > q.y) == (edge.b.y > q.y)) continue;
        const double x = edge.a.x + (q.y - edge.a.y) / (edge.b.y - edge.a.y) * (edge.b.x - edge.a.x);
        inside ^= q.x < x;
    }
    return inside;
}

// Whether all of a loop lies off the region `there` (in it, for a hole).
bool is_apart(std::span<const Edge2> edges, const Loop& loop, bool is_void, const DistanceMap& there) {
    return std::all_of(loop.begin(), loop.end(), [&](std::uint32_t e) {
        const double distance = there.value(edges[e].a);
        return is_void ? distance < 0 : distance > 0;
    });
}

// A loop with all that lies within it, the part on the left of the edges. Marks the loops within.
TerminatingComponent part_within(std::span<const Edge2> edges, const std::vector<Loop>& loops,
                                 std::size_t outer, bool is_void, std::vector<bool>& is_within_one) {
    TerminatingComponent part{{}, is_void, true};
    for (const std::uint32_t e : loops[outer]) part.edges.push_back(edges[e]);
    const std::vector<Edge2> outline = part.edges;
    Box2 box;
    for (const Edge2& edge : outline) box.extend(edge.a);
    for (std::size_t l = 0; l < loops.size(); ++l) {
        const Vec2 start = edges[loops[l].front()].a;
        if (l == outer || !box.contains(start) || !is_within(start, outline)) continue;
        is_within_one[l] = true;
        for (const std::uint32_t e : loops[l]) part.edges.push_back(edges[e]);
    }
    if (is_void) {
        for (Edge2& edge : part.edges) std::swap(edge.a, edge.b);
    }
    return part;
}

// Whether no outline of the other region runs in the part: with is_apart(), that the two share no point.
bool is_free_of(const TerminatingComponent& part, const DistanceMap& there) {
    Box2 box;
    for (const Edge2& edge : part.edges) box.extend(edge.a);
    return std::none_of(there.edges().begin(), there.edges().end(), [&](const Edge2& edge) {
        return box.contains(edge.a) && is_within(edge.a, part.edges);
    });
}

// The share of a part that lies in the region `there`, from a lattice of points.
double covered_share(const TerminatingComponent& part, const DistanceMap& there) {
    Box2 box;
    for (const Edge2& edge : part.edges) box.extend(edge.a);
    const Vec2 step = (1.0 / covered_lattice) * (box.high - box.low);
    std::size_t within = 0, covered = 0;
    for (int j = 0; j < covered_lattice; ++j) {
        for (int i = 0; i < covered_lattice; ++i) {
            const Vec2 q = box.low + Vec2{(i + 0.5) * step.x, (j + 0.5) * step.y};
            if (!is_within(q, part.edges)) continue;
            ++within;
            covered += there.value(q) < 0;
        }
    }
    return within > 0 ? static_cast<double>(covered) / static_cast<double>(within) : 1;
}

// Whether a hole lies mostly, but not wholly, in the other region: with nothing in it here, and no hole of
// the other one beginning in it.
bool is_mostly_covered(const DistanceMap& here, const Loop& loop, const TerminatingComponent& part,
                       const DistanceMap& there) {
    if (part.edges.size() != loop.size()) return false;
    // First the middles of a few chords: most holes go on as holes.
    const std::size_t half = loop.size() / 2, stride = std::max<std::size_t>(half / few_chords, 1);
    int tried = 0, covered = 0;
    for (std::size_t n = 0; n < half; n += stride) {
        const Vec2 middle = 0.5 * (here.edges()[loop[n]].a + here.edges()[loop[n + half]].a);
        if (here.value(middle) <= 0) continue;
        ++tried;
        covered += there.value(middle) < 0;
    }
    if (2 * covered < tried) return false;
    for (const Loop& other : loops_of(there.edges())) {
        if (twice_area(there.edges(), other) < 0 && is_within(there.edges()[other.front()].a, part.edges))
            return false;
    }
    return covered_share(part, there) >= most_covered;
}

// A region with its outlines and holes, ready to be matched with.
struct Matchable {
    std::vector<Loop> loops;
    BoundarySide side;
    std::vector<bool> of_hole;  // piece by piece

    Matchable(const DistanceMap& map, double gap) : loops(loops_of(map.edges())), side(map, gap) {
        of_hole.assign(side.boundary.pieces.size(), false);
        for (const Loop& loop : loops) {
            if (twice_area(map.edges(), loop) < 0) mark(loop, of_hole);
        }
    }
    void mark(const Loop& loop, std::vector<bool>& pieces) const {
        const std::vector<std::uint32_t>& first = side.boundary.first;
        for (const std::uint32_t e : loop)
            std::fill(pieces.begin() + first[e], pieces.begin() + first[e + 1], true);
    }
};

// The share of a loop that corresponds to an outline there which no other loop here is nearer to; and what is
// left of that without matches of a hole and an outline further than across half of the loop: a side of the
// one faces as the opposite side of the other does.
struct MatchedShare {
    double all = 0, likely = 0;
};
MatchedShare matched_share(const Loop& loop, double area, bool is_void, const Matchable& here,
                           const Matchable& there) {
    const double radius = std::sqrt(area / std::numbers::pi);
    const std::vector<std::uint32_t>& first = here.side.boundary.first;
    std::vector<bool> own(here.side.boundary.pieces.size(), false);
    here.mark(loop, own);
    double perimeter = 0;
    for (const std::uint32_t e : loop) {
        for (std::uint32_t p = first[e]; p < first[e + 1]; ++p)
            perimeter += here.side.boundary.pieces[p].length;
    }
    MatchedShare matched;
    for (const std::uint32_t e : loop) {
        for (std::uint32_t p = first[e]; p < first[e + 1]; ++p) {
            const BoundaryPiece& piece = here.side.boundary.pieces[p];
            if (piece.facing == Vec2{}) continue;
            const Vec2 start = piece.middle();
            const PieceIndex::Match match = there.side.index.nearest(start, piece.facing, start);
            if (match.piece == no_piece) continue;
            const PieceIndex::Match back = here.side.index.nearest(match.point, piece.facing, match.point);
            if (back.piece == no_piece || !own[back.piece]) continue;
            matched.all += piece.length / perimeter;
            if (there.of_hole[match.piece] == is_void || length(match.point - start) <= radius)
                matched.likely += piece.length / perimeter;
        }
    }
    return matched;
}

}  // namespace

std::vector<TerminatingComponent> terminating_components(const DistanceMap& here, const DistanceMap& there,
                                                         double gap) {
    const std::span<const Edge2> edges = here.edges();
    const std::vector<Loop> loops = loops_of(edges);
    std::vector<bool> is_within_one(loops.size(), false);  // of the parts found
    std::vector<TerminatingComponent> parts;
    std::optional<Matchable> match_here, match_there;
    for (std::size_t l = 0; l < loops.size(); ++l) {
        const bool is_void = twice_area(edges, loops[l]) < 0;
        if (is_within_one[l]) continue;
        const bool apart = is_apart(edges, loops[l], is_void, there);
        if (!apart && !is_void) continue;
        std::vector<bool> within = is_within_one;
        TerminatingComponent part = part_within(edges, loops, l, is_void, within);
        const bool is_alone = apart && is_free_of(part, there);
        if (!is_alone && !(is_void && is_mostly_covered(here, loops[l], part, there))) continue;
        if (!match_here) {
            match_here.emplace(here, gap);
            match_there.emplace(there, gap);
        }
        const double area = 0.5 * std::abs(twice_area(edges, loops[l]));
        const MatchedShare matched = matched_share(loops[l], area, is_void, *match_here, *match_there);
        part.is_sure = is_alone && matched.all < least_matched;
        const bool is_simple = part.edges.size() == loops[l].size();
        if (part.is_sure || (is_simple && matched.likely < least_matched)) {
            parts.push_back(std::move(part));
            is_within_one = std::move(within);
        }
    }
    return parts;
}

std::vector<TerminatingComponent> terminating_components_of_union(const DistanceMap& here,
                                                                  const DistanceMap* there,
                                                                  const DistanceMap& all_here,
                                                                  const DistanceMap& all_there, double gap) {
    std::vector<TerminatingComponent> parts;
    if (there != nullptr) {
        parts = terminating_components(here, *there, gap);
        std::erase_if(parts, [](const TerminatingComponent& part) { return part.is_void || !part.is_sure; });
    } else {
        const std::vector<Loop> loops = loops_of(here.edges());
        std::vector<bool> is_within_one(loops.size(), false);
        for (std::size_t l = 0; l < loops.size(); ++l) {
            if (!is_within_one[l] && twice_area(here.edges(), loops[l]) > 0)
                parts.push_back(part_within(here.edges(), loops, l, false, is_within_one));
        }
    }
    if (parts.empty()) return parts;
    const auto key = [](const Edge2& edge) { return std::tuple(edge.a.x, edge.a.y, edge.b.x, edge.b.y); };
    const auto before = [&](const Edge2& e, const Edge2& f) { return key(e) < key(f); };
    std::vector<Edge2> free(all_here.edges().begin(), all_here.edges().end());  // what no two share
    std::sort(free.begin(), free.end(), before);
    std::erase_if(parts, [&](const TerminatingComponent& part) {
        const bool touches = std::any_of(part.edges.begin(), part.edges.end(), [&](const Edge2& edge) {
            return !std::binary_search(free.begin(), free.end(), edge, before);
        });
        return !touches || covered_share(part, all_there) >= most_covered;
    });
    return parts;
}

}  // namespace anatomesh
