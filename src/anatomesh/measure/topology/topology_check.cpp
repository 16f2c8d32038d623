#include "anatomesh/measure/topology/topology_check.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "anatomesh/base/disjoint_sets.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/measure/topology/drawn_parts.h"
#include "anatomesh/measure/topology/stacks_of_slices.h"
#include "anatomesh/mesh/model/buckets.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/slices/coverage/few_slices.h"

namespace anatomesh {

namespace {

// A vertex this near to a plane lies on it. [diagonals of the contours' box; 0 to 1e-6; D rounding of doubles]
constexpr double on_plane_share = 1e-9;
// Wider gaps may not be bridged. [median gaps; > 1; M 2026-11, set not recorded]
constexpr double widest_gap = 1.5;
constexpr double beyond_all = std::numeric_limits<double>::infinity();

// An open range of heights, with the two slices that it lies between; beyond all slices the last one twice.
struct Window {
    double low = 0, high = 0;
    std::uint32_t low_slice = 0, high_slice = 0;
    bool beyond_all_slices() const { return low_slice == high_slice; }
};

// A connected piece of a surface within a window.
struct Piece {
    std::int64_t euler = 0;
    std::vector<std::uint32_t> contours;  // whose vertices its triangles have; ascending
    std::vector<std::uint32_t> low_curves,
        high_curves;  // closed ones at the window's levels: the lowest triangle of each
};

// The surface of one structure, its triangles by their lowest height.
class LayeredSurface {
  public:
    // `contour_of` each vertex of the mesh: of the contour set, or no_cell.
    LayeredSurface(const std::vector<double>& heights, const std::vector<Triangle>& triangles,
                   const std::vector<std::uint32_t>& contour_of)
        : heights_(heights), contour_of_(contour_of) {
        struct Layered {
            double low;
            Triangle triangle;
        };
        std::vector<Layered> sorted;
        sorted.reserve(triangles.size());
        for (const Triangle& t : triangles)
            sorted.push_back({std::min({heights[t[0]], heights[t[1]], heights[t[2]]}), t});
        std::sort(sorted.begin(), sorted.end(), [](const Layered& s, const Layered& t) {
            return s.low != t.low ? s.low < t.low : s.triangle < t.triangle;
        });
        triangles_.reserve(sorted.size());
        lows_.reserve(sorted.size());
        for (const auto& [low, t] : sorted) {
            triangles_.push_back(t);
            lows_.push_back(low);
            tallest_ = std::max(tallest_, std::max({heights[t[0]], heights[t[1]], heights[t[2]]}) - low);
        }
    }

    std::size_t size() const { return triangles_.size(); }

    // Euler number by open cells: those of the surface that meet the open window.
    std::vector<Piece> pieces_within(const Window& window) const {
        std::vector<Triangle> here;
        std::vector<std::uint32_t> index;
        const auto first =
            std::lower_bound(lows_.begin(), lows_.end(), window.low - tallest_) - lows_.begin();
        for (auto n = static_cast<std::size_t>(first); n < lows_.size() && lows_[n] < window.high; ++n) {
            if (!meets(triangles_[n], window)) continue;
            here.push_back(triangles_[n]);
            index.push_back(static_cast<std::uint32_t>(n));
        }
        std::vector<EdgeUse> edges;
        std::vector<std::array<std::uint32_t, 2>> corners;  // a vertex within, and a triangle that has it
        for (std::uint32_t t = 0; t < here.size(); ++t) {
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t a = std::min(here[t][i], here[t][(i + 1) % 3]),
                                    b = std::max(here[t][i], here[t][(i + 1) % 3]);
                if (meets(std::array{a, b}, window)) edges.push_back({a, b, t});
                if (meets(std::array{here[t][i]}, window)) corners.push_back({here[t][i], t});
            }
        }
        std::sort(edges.begin(), edges.end(), [](const EdgeUse& x, const EdgeUse& y) {
            return std::array{x.a, x.b, x.triangle} < std::array{y.a, y.b, y.triangle};
        });
        DisjointSets joined(here.size());
        const auto repeats = [&](std::size_t e) {
            return e > 0 && edges[e].a == edges[e - 1].a && edges[e].b == edges[e - 1].b;
        };
        for (std::size_t e = 0; e < edges.size(); ++e) {
            if (repeats(e)) joined.join(edges[e].triangle, edges[e - 1].triangle);
        }
        std::vector<std::uint32_t> number(here.size(), no_cell);
        std::vector<Piece> pieces;
        const auto piece_of = [&](std::uint32_t t) -> Piece& {
            std::uint32_t& n = number[joined.root(t)];
            if (n == no_cell) {
                n = static_cast<std::uint32_t>(pieces.size());
                pieces.emplace_back();
            }
            return pieces[n];
        };
        for (std::uint32_t t = 0; t < here.size(); ++t) {
            Piece& piece = piece_of(t);
            ++piece.euler;
            for (const std::uint32_t v : here[t]) {
                if (contour_of_[v] != no_cell) piece.contours.push_back(contour_of_[v]);
            }
        }
        for (std::size_t e = 0; e < edges.size(); ++e) {
            if (!repeats(e)) --piece_of(edges[e].triangle).euler;
        }
        std::sort(corners.begin(), corners.end());
        for (std::size_t n = 0; n < corners.size(); ++n) {
            if (n == 0 || corners[n][0] != corners[n - 1][0]) ++piece_of(corners[n][1]).euler;
        }
        for (const std::uint32_t t : curves_at(window.low, here, edges))
            piece_of(t).low_curves.push_back(index[t]);
        for (const std::uint32_t t : curves_at(window.high, here, edges))
            piece_of(t).high_curves.push_back(index[t]);
        for (Piece& piece : pieces) {
            std::sort(piece.contours.begin(), piece.contours.end());
            piece.contours.erase(std::unique(piece.contours.begin(), piece.contours.end()),
                                 piece.contours.end());
        }
        return pieces;
    }

  private:
    struct EdgeUse {
        std::uint32_t a, b, triangle;
    };

    // A triangle of each closed curve in which the surface crosses the level. The edges are sorted.
    std::vector<std::uint32_t> curves_at(double level, const std::vector<Triangle>& here,
                                         const std::vector<EdgeUse>& edges) const {
        const auto crosses = [&](std::uint32_t a, std::uint32_t b) {
            return (heights_[a] > level) != (heights_[b] > level);
        };
        DisjointSets joined(here.size());
        for (std::size_t e = 1; e < edges.size(); ++e) {
            const bool shared = edges[e].a == edges[e - 1].a && edges[e].b == edges[e - 1].b;
            if (shared && crosses(edges[e].a, edges[e].b))
                joined.join(edges[e].triangle, edges[e - 1].triangle);
        }
        std::vector<std::uint32_t> curves;
        for (std::uint32_t t = 0; t < here.size(); ++t) {
            const bool crossed = crosses(here[t][0], here[t][1]) || crosses(here[t][1], here[t][2]);
            if (crossed && joined.root(t) == t) curves.push_back(t);
        }
        return curves;
    }

    template <std::size_t count>
    bool meets(const std::array<std::uint32_t, count>& simplex, const Window& window) const {
        double low = beyond_all, high = -beyond_all;
        for (const std::uint32_t v : simplex)
            low = std::min(low, heights_[v]), high = std::max(high, heights_[v]);
        return high > window.low && low < window.high;
    }

    const std::vector<double>& heights_;
    const std::vector<std::uint32_t>& contour_of_;
    std::vector<Triangle> triangles_;
    std::vector<double> lows_;
    double tallest_ = 0;
};

// Compares the surface of one structure with its contours. Heights are parted just above the slices. What
// hangs together and goes on simply from window to window is a chain; the surface meets the levels in closed
// curves, whose Euler number is 0, so that the numbers of its windows add up, and a bump of the surface
// through a level cancels.
class StackTopology {
  public:
    // `turns`: by gap, where the surface may do more than go on; empty: nowhere.
    StackTopology(const ContourSet& contours, std::uint32_t structure, double tolerance,
                  const LayeredSurface& surface, const std::vector<std::uint8_t>& turns)
        : contours_(contours),
          structure_(structure),
          surface_(surface),
          last_(static_cast<std::uint32_t>(contours.slices.size() - 1)),
          chains_(contours.contours.size() + surface.size()),
          sides_(contours.contours.size() + surface.size(), 0),
          sums_(sides_.size()) {
        const std::vector<std::uint32_t> few = structures_on_few_slices(contours);
        const bool is_few = std::binary_search(few.begin(), few.end(), structure);
        const double spacing = is_few && contours.slice_thickness_mm > 0 ? contours.slice_thickness_mm
                                                                         : median_spacing(contours);
        for (std::uint32_t k = 0; k <= last_; ++k) {
            const double level =
                dot(contours.slices[k].plane.origin, contours.slices.front().plane.normal) + 2 * tolerance;
            const auto all = contours.contours_of(contours.slices[k]);
            const bool drawn = std::any_of(all.begin(), all.end(),
                                           [&](const Contour& c) { return c.structure == structure; });
            if (k > 0)
                joined_.push_back(drawn && drawn_.back() && level - levels_.back() <= widest_gap * spacing &&
                                  (turns.empty() || !turns[k - 1]));
            levels_.push_back(level);
            drawn_.push_back(drawn);
        }
    }

    std::vector<TopologyMismatch> find(bool whole_only, int threads) {
        if (!take_in_all(whole_only, threads)) return {};
        for (std::uint32_t n = 0; n < sums_.size(); ++n) {
            const std::uint32_t chain = chains_.root(n);
            // A chain ends in one curve for each contour there; others are bumps that have their rest
            // elsewhere.
            if (n >= contours_.contours.size()) {
                sums_[chain].euler += sides_[n] == from_below || sides_[n] == from_above;
            } else if (sides_[n] != 0) {
                const bool ends = sides_[n] != (from_below | from_above);
                sums_[chain].euler -= ends;
                sums_[chain].whole &= !ends;
            }
            if (chain != n) sums_[chain].add(sums_[n]);
        }
        std::vector<TopologyMismatch> tears;
        // What has no contour, bumps alone, is no chain.
        for (std::uint32_t n = 0; n < contours_.contours.size(); ++n) {
            const Sum& sum = sums_[n];
            if (chains_.root(n) != n || std::abs(sum.euler - sum.expected) < 2) continue;
            if (whole_only && !sum.whole) continue;
            tears.push_back({structure_, sum.low_slice, sum.high_slice, sum.euler, sum.expected, sum.whole});
        }
        return tears;
    }

  private:
    // A part of the surface reaches a slice from below if this bit is set. [bit; 1; D]
    static constexpr std::uint8_t from_below = 1;
    // It reaches the slice from above if this bit is set. [bit; 2; D]
    static constexpr std::uint8_t from_above = 2;

    std::vector<Window> all_windows() const {
        std::vector<Window> windows;
        if (drawn_.front()) windows.push_back({-beyond_all, levels_.front(), 0, 0});
        for (std::uint32_t k = 0; k < last_; ++k) {
            if (joined_[k]) windows.push_back({levels_[k], levels_[k + 1], k, k + 1});
        }
        if (drawn_.back()) windows.push_back({levels_.back(), beyond_all, last_, last_});
        return windows;
    }

    // Several windows are looked into at a time. False as soon as no run is left that is whole, if these
    // alone are asked for.
    bool take_in_all(bool whole_only, int threads) {
        // Fewer where those after the last run's end would be for nothing.
        const std::size_t windows_a_thread = whole_only ? 1 : 4;
        const std::vector<Window> windows = all_windows();
        const std::size_t at_once = threads > 1 ? windows_a_thread * static_cast<std::size_t>(threads) : 1;
        std::uint32_t slice = 1;
        for (std::size_t begin = 0; begin < windows.size(); begin += at_once) {
            std::vector<Sight> seen(std::min(at_once, windows.size() - begin));
            parallel_for(seen.size(), 1, threads, [&](std::size_t first, std::size_t last) {
                for (std::size_t n = first; n < last; ++n) seen[n] = look(windows[begin + n]);
            });
            for (std::size_t n = 0; n < seen.size(); ++n) {
                const Window& window = windows[begin + n];
                // Up to the slice below this window all has been taken in.
                for (; whole_only && slice <= window.low_slice; ++slice) {
                    if (!any_run_reaches(slice)) return false;
                }
                take_in(window, seen[n]);
            }
        }
        for (; whole_only && slice <= last_; ++slice) {
            if (!any_run_reaches(slice)) return false;
        }
        return true;
    }

    // Whether a run from below the first slice comes up to a slice, and has ended nowhere.
    bool any_run_reaches(std::uint32_t slice) {
        std::vector<std::uint8_t> ended(sides_.size(), 0);
        const auto each_contour = [&](auto body) {
            for (std::uint32_t c = 0; c < contours_.contours.size(); ++c) {
                const Contour& contour = contours_.contours[c];
                if (contour.structure == structure_ && contour.slice <= slice) body(c, contour.slice);
            }
        };
        each_contour([&](std::uint32_t c, std::uint32_t at) {
            const std::uint8_t needed = at < slice ? from_below | from_above : from_below;
            if ((sides_[c] & needed) != needed) ended[chains_.root(c)] = 1;
        });
        bool reaches = false;
        each_contour(
            [&](std::uint32_t c, std::uint32_t at) { reaches |= at == slice && !ended[chains_.root(c)]; });
        return reaches;
    }

    // The slices are those of the window where the Euler number is farthest from what is expected.
    struct Sum {
        std::int64_t euler = 0, expected = 0, amiss = -1;
        std::uint32_t low_slice = 0, high_slice = 0;
        bool whole = true;
        void add(const Sum& other) {
            euler += other.euler, expected += other.expected;
            whole &= other.whole;
            if (other.amiss > amiss)
                amiss = other.amiss, low_slice = other.low_slice, high_slice = other.high_slice;
        }
    };

    // The parts drawn on the slices of a window, and which of them are known to go on simply.
    struct Parts {
        std::vector<DrawnPart> parts;
        std::vector<std::uint8_t> simple;
        std::vector<std::array<std::uint32_t, 2>> links;
        std::vector<std::uint32_t> holes_closed;  // per part, on the way to the next slice
    };

    // What there is in a window.
    struct Sight {
        std::vector<Piece> pieces;
        std::optional<Parts> drawn;  // unless all pieces are simple
    };

    // For several threads at a time.
    Sight look(const Window& window) const {
        Sight sight{surface_.pieces_within(window), std::nullopt};
        for (Piece& piece : sight.pieces) {
            // A tall triangle may have vertices of farther slices.
            std::erase_if(piece.contours, [&](std::uint32_t c) {
                const std::uint32_t slice = contours_.contours[c].slice;
                return slice != window.low_slice && slice != window.high_slice;
            });
        }
        if (!std::all_of(sight.pieces.begin(), sight.pieces.end(),
                         [&](const Piece& piece) { return as_simple(piece, window); }))
            sight.drawn = parts_of(window);
        return sight;
    }

    void take_in(const Window& window, const Sight& sight) {
        const std::vector<Piece>& pieces = sight.pieces;
        if (!sight.drawn) {
            for (const Piece& piece : pieces) join(window, piece, piece.contours.front());
            return;
        }
        const Parts& drawn = *sight.drawn;
        std::vector<std::uint32_t> part_of(contours_.contours.size(), no_cell);
        DisjointSets groups(drawn.parts.size());
        for (std::uint32_t n = 0; n < drawn.parts.size(); ++n) {
            for (const std::uint32_t c : drawn.parts[n].contours) part_of[c] = n;
        }
        for (const auto& [a, b] : drawn.links) groups.join(a, b);
        for (const Piece& piece : pieces) {
            for (const std::uint32_t c : piece.contours)
                groups.join(part_of[piece.contours.front()], part_of[c]);
        }
        std::vector<std::uint8_t> trusted(drawn.parts.size(), 1);
        for (std::uint32_t n = 0; n < drawn.parts.size(); ++n) trusted[groups.root(n)] &= drawn.simple[n];
        std::vector<Sum> sums(drawn.parts.size());
        for (std::uint32_t n = 0; n < drawn.parts.size(); ++n) {
            const std::uint32_t group = groups.root(n);
            if (!trusted[group]) continue;
            if (window.beyond_all_slices())
                sums[group].expected += 1 - static_cast<std::int64_t>(drawn.parts[n].holes());
            else
                sums[group].expected += drawn.holes_closed[n];  // each by a disc
            for (const std::uint32_t c : drawn.parts[n].contours) {
                chains_.join(drawn.parts[group].contours.front(), c);
                come_to(window, c);
            }
        }
        for (const Piece& piece : pieces) {
            if (piece.contours.empty()) {
                // A bump: of the chain that it is a bump of.
                const std::vector<std::uint32_t>& curves =
                    piece.low_curves.empty() ? piece.high_curves : piece.low_curves;
                if (curves.empty()) continue;
                const std::uint32_t curve = curve_node(curves.front());
                join(window, piece, curve);
                sums_[curve].euler += piece.euler;
                continue;
            }
            const std::uint32_t group = groups.root(part_of[piece.contours.front()]);
            if (!trusted[group]) continue;
            join(window, piece, piece.contours.front());
            sums[group].euler += piece.euler;
        }
        for (std::uint32_t n = 0; n < drawn.parts.size(); ++n) {
            if (groups.root(n) != n || !trusted[n]) continue;
            sums[n].amiss = std::abs(sums[n].euler - sums[n].expected);
            sums[n].low_slice = window.low_slice, sums[n].high_slice = window.high_slice;
            sums_[drawn.parts[n].contours.front()].add(sums[n]);
        }
    }

    // Its contours and curves are of one chain with `node`.
    void join(const Window& window, const Piece& piece, std::uint32_t node) {
        for (const std::uint32_t c : piece.contours) {
            chains_.join(node, c);
            come_to(window, c);
        }
        for (const std::uint32_t curve : piece.low_curves) {
            chains_.join(node, curve_node(curve));
            sides_[curve_node(curve)] |= from_above;
        }
        for (const std::uint32_t curve : piece.high_curves) {
            chains_.join(node, curve_node(curve));
            sides_[curve_node(curve)] |= from_below;
        }
    }
    void come_to(const Window& window, std::uint32_t contour) {
        const std::uint32_t slice = contours_.contours[contour].slice;
        if (slice == window.low_slice && !std::isinf(window.low)) sides_[contour] |= from_above;
        if (slice == window.high_slice && !std::isinf(window.high)) sides_[contour] |= from_below;
    }
    std::uint32_t curve_node(std::uint32_t curve) const {
        return static_cast<std::uint32_t>(contours_.contours.size()) + curve;
    }

    Parts parts_of(const Window& window) const {
        Parts drawn;
        drawn.parts = drawn_parts(contours_, window.low_slice, structure_);
        drawn.simple.assign(drawn.parts.size(), window.beyond_all_slices());
        if (window.beyond_all_slices()) return drawn;
        const std::vector<DrawnPart> high = drawn_parts(contours_, window.high_slice, structure_);
        const std::vector<Continuation> next = continued_by(contours_, drawn.parts, high);
        const auto first_high = static_cast<std::uint32_t>(drawn.parts.size());
        drawn.parts.insert(drawn.parts.end(), high.begin(), high.end());
        drawn.simple.resize(drawn.parts.size(), 0);
        drawn.holes_closed.resize(drawn.parts.size(), 0);
        for (std::uint32_t n = 0; n < next.size(); ++n) {
            if (next[n].part < 0) continue;
            const std::uint32_t other = first_high + static_cast<std::uint32_t>(next[n].part);
            drawn.holes_closed[n] = next[n].holes_closed;
            drawn.simple[n] = drawn.simple[other] = 1;
            drawn.links.push_back({n, other});
        }
        return drawn;
    }

    // An annulus from a contour to one of the next slice needs no comparison.
    bool as_simple(const Piece& piece, const Window& window) const {
        if (window.beyond_all_slices() || piece.euler != 0 || piece.contours.size() != 2) return false;
        return contours_.contours[piece.contours[0]].slice != contours_.contours[piece.contours[1]].slice;
    }

    const ContourSet& contours_;
    std::uint32_t structure_;
    const LayeredSurface& surface_;
    std::uint32_t last_;
    std::vector<double> levels_;                // just above each slice
    std::vector<std::uint8_t> drawn_, joined_;  // per slice; per gap
    // Nodes are the contours, then the curves by a triangle that stands for each.
    DisjointSets chains_;
    std::vector<std::uint8_t> sides_;
    std::vector<Sum> sums_;
};

}  // namespace

namespace {

// How far from its slice's plane a point of a contour may lie and is on it.
double on_plane_mm(const ContourSet& contours) {
    double tolerance = on_plane_share * contours.box().diagonal();
    for (const Contour& contour : contours.contours) {
        const Plane& plane = contours.slices[contour.slice].plane;
        for (const Vec3& p : contours.points_of(contour))
            tolerance = std::max(tolerance, 1.001 * std::abs(plane.signed_distance(p)));
    }
    return tolerance;
}

// Of slices side by side, in their order; `heights` of the points along the first one's normal; `turns` as
// turns_in_gaps() gives them, or empty.
std::vector<TopologyMismatch> tears_of_stack(const std::vector<double>& heights,
                                             std::span<const std::vector<Triangle>> surfaces,
                                             const ContourSet& contours,
                                             std::span<const std::uint32_t> vertex_of,
                                             std::span<const std::uint8_t> whole_only,
                                             const std::vector<std::vector<std::uint8_t>>& turns,
                                             int threads) {
    std::vector<TopologyMismatch> tears;
    const double tolerance = on_plane_mm(contours);
    const std::vector<std::uint8_t> no_turns;
    std::vector<std::uint32_t> contour_of(heights.size(), no_cell);
    for (std::uint32_t s = 0; s < surfaces.size(); ++s) {
        const auto mark = [&](bool on) {
            for (std::uint32_t c = 0; c < contours.contours.size(); ++c) {
                const Contour& contour = contours.contours[c];
                if (contour.structure != s) continue;
                for (std::uint32_t n = 0; n < contour.point_count; ++n) {
                    const std::uint32_t v = vertex_of[contour.first_point + n];
                    if (v != no_cell) contour_of[v] = on ? c : no_cell;
                }
            }
        };
        mark(true);
        const LayeredSurface surface(heights, surfaces[s], contour_of);
        const std::vector<TopologyMismatch> found =
            StackTopology(contours, s, tolerance, surface, turns.empty() ? no_turns : turns[s])
                .find(whole_only[s] != 0, threads);
        tears.insert(tears.end(), found.begin(), found.end());
        mark(false);
    }
    return tears;
}

// How much is amiss with one structure.
std::int64_t sum_amiss(const std::vector<TopologyMismatch>& tears, std::uint32_t structure) {
    std::int64_t sum = 0;
    for (const TopologyMismatch& tear : tears)
        sum += tear.structure == structure ? std::abs(tear.euler - tear.expected) : 0;
    return sum;
}

// Of several stacks that see the same surface, for every structure those of the one that sees most amiss.
std::vector<TopologyMismatch> most_amiss(const std::vector<std::vector<TopologyMismatch>>& by_stack,
                                         std::size_t structures) {
    std::vector<TopologyMismatch> tears;
    for (std::uint32_t s = 0; s < structures; ++s) {
        const auto less = [&](const auto& p, const auto& q) { return sum_amiss(p, s) < sum_amiss(q, s); };
        const auto most = std::max_element(by_stack.begin(), by_stack.end(), less);
        if (most == by_stack.end()) continue;
        std::copy_if(most->begin(), most->end(), std::back_inserter(tears),
                     [&](const TopologyMismatch& tear) { return tear.structure == s; });
    }
    return tears;
}

}  // namespace

std::vector<TopologyMismatch> topology_check(std::span<const Vec3> points,
                                             std::span<const std::vector<Triangle>> surfaces,
                                             const ContourSet& contours, const SliceArrangement& arrangement,
                                             std::span<const std::uint32_t> vertex_of,
                                             std::span<const std::uint8_t> whole_only, int threads) {
    assert(surfaces.size() == contours.structures.size() && vertex_of.size() == contours.points.size());
    assert(whole_only.size() == surfaces.size());
    const bool asked =
        std::any_of(surfaces.begin(), surfaces.end(), [](const auto& s) { return !s.empty(); });
    if (contours.slices.empty() || !asked) return {};
    std::vector<double> heights;
    if (all_parallel(contours, exactly_parallel_mm)) {
        for (const Vec3& p : points) heights.push_back(dot(p, contours.slices.front().plane.normal));
        return tears_of_stack(heights, surfaces, contours, vertex_of, whole_only, {}, threads);
    }
    std::vector<std::vector<TopologyMismatch>> by_stack;
    for (const StackOfSlices& stack : stacks_of_slices(contours, arrangement)) {
        heights.clear();
        for (const Vec3& p : points) heights.push_back(stack.sweep.to_chart(p).z);
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t s : stack.slices) {
            for (const Contour& contour : contours.contours_of(contours.slices[s])) {
                const auto first = vertex_of.begin() + contour.first_point;
                vertices.insert(vertices.end(), first, first + contour.point_count);
            }
        }
        const auto turns = turns_in_gaps(contours, stack, on_plane_mm(stack.charted));
        by_stack.push_back(
            tears_of_stack(heights, surfaces, stack.charted, vertices, whole_only, turns, threads));
        for (TopologyMismatch& tear : by_stack.back()) {
            tear.low_slice = stack.slices[tear.low_slice];
            tear.high_slice = stack.slices[tear.high_slice];
            tear.by_mesh = stack.leads;
        }
    }
    return most_amiss(by_stack, surfaces.size());
}

}  // namespace anatomesh
