#include "anatomesh/field/stack/structure_stack.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "anatomesh/base/instruction_sets.h"

namespace anatomesh {

namespace {

// Takes the edges of a part out of those of its region, in which those of a hole run the other way.
void take_out(std::vector<Edge2>& region, const TerminatingComponent& part) {
    const auto key = [](const Edge2& edge) { return std::tuple(edge.a.x, edge.a.y, edge.b.x, edge.b.y); };
    const auto before = [&](const Edge2& e, const Edge2& f) { return key(e) < key(f); };
    std::vector<Edge2> edges = part.edges;
    if (part.is_void) {
        for (Edge2& edge : edges) std::swap(edge.a, edge.b);
    }
    std::sort(edges.begin(), edges.end(), before);
    std::erase_if(region, [&](const Edge2& edge) {
        return std::binary_search(edges.begin(), edges.end(), edge, before);
    });
}

}  // namespace

StructureStack::StructureStack(StructureKnots knots, const std::vector<std::int32_t>& map_of_slice,
                               bool rounded)
    : flat_(std::move(knots.flat)), rounded_(rounded) {
    for (const SliceKnot& knot : knots.knots) {
        knots_.push_back(
            {knot.low, knot.high, knot.slice == SliceKnot::no_slice ? empty_knot : map_of_slice[knot.slice]});
    }
    motions_.assign(knots_.size() - 1, std::make_shared<const SliceMotion>());
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) ends_.push_back(std::make_shared<GapEnds>());
    is_flat_ = std::any_of(flat_.begin(), flat_.end(), [](const auto& e) { return std::isfinite(e.low); });
    const double length = high() - low();
    buckets_.resize(4 * knots_.size());
    inverse_bucket_ = length > 0 ? static_cast<double>(buckets_.size()) / length : 0;
    std::uint32_t knot = 0;
    for (std::size_t b = 0; b < buckets_.size(); ++b) {
        // One bucket early, so that rounding never starts the search beyond the knot sought.
        const double start =
            low() + (static_cast<double>(b) - 1) * length / static_cast<double>(buckets_.size());
        while (knot + 1 < knots_.size() && knots_[knot + 1].low <= start) ++knot;
        buckets_[b] = knot;
    }
}

void StructureStack::find_terminations(std::size_t i, const Maps& maps, double clamp, bool paraboloids) {
    const DistanceMap *below = map_at(i, maps), *above = map_at(i + 1, maps);
    if (is_flat_ || below == nullptr || above == nullptr) return;
    for (const bool from_below : {true, false}) {
        std::vector<TerminatingComponent> parts = from_below ? terminating_components(*below, *above, gap(i))
                                                             : terminating_components(*above, *below, gap(i));
        if (paraboloids) add_paraboloid_caps(i, parts, from_below, maps, clamp);
        std::erase_if(parts, [](const TerminatingComponent& part) { return !part.is_sure; });
        add_terminations(i, parts, from_below, clamp);
    }
}

void StructureStack::add_paraboloid_caps(std::size_t i, std::vector<TerminatingComponent>& parts,
                                         bool from_below, const Maps& maps, double clamp) {
    if (from_below && i == 0) return;
    const DistanceMap *section = map_at(from_below ? i : i + 1, maps),
                      *before = map_at(from_below ? i - 1 : i + 2, maps);
    if (before == nullptr) return;
    const double gap_before = gap(from_below ? i - 1 : i + 1);
    std::vector<Termination> capped;
    std::vector<Edge2> rest(section->edges().begin(), section->edges().end());
    std::vector<bool> is_capped(parts.size(), false);
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const TerminatingComponent& part = parts[p];
        Box2 box;
        for (const Edge2& edge : part.edges) box.extend(edge.a);
        const Vec2 size = box.high - box.low;
        DistanceMap map(part.edges, std::max(clamp, 0.5 * std::min(size.x, size.y)));
        const std::optional<ParaboloidCap> paraboloid =
            paraboloid_cap_of(map, part.is_void, *before, gap_before, gap(i));
        is_capped[p] = paraboloid && (part.is_sure || paraboloid->is_whole());
        if (!is_capped[p]) continue;
        take_out(rest, part);
        capped.push_back({std::move(map), box.grown(clamp), from_below, part.is_void, paraboloid});
    }
    if (capped.empty() || rest.empty()) return;
    std::vector<TerminatingComponent> others;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        if (!is_capped[p]) others.push_back(std::move(parts[p]));
    }
    parts = std::move(others);
    std::move(capped.begin(), capped.end(), std::back_inserter(ends_[i]->terminations));
    ends_[i]->rest[from_below ? 0 : 1] = std::make_unique<DistanceMap>(std::move(rest), clamp);
}

void StructureStack::add_terminations(std::size_t i, const std::vector<TerminatingComponent>& parts,
                                      bool from_below, double clamp) {
    for (const bool is_void : {true, false}) {
        std::vector<Edge2> edges;
        for (const TerminatingComponent& part : parts) {
            if (part.is_void == is_void) edges.insert(edges.end(), part.edges.begin(), part.edges.end());
        }
        if (edges.empty()) continue;
        DistanceMap map(std::move(edges), clamp);
        const Box2 box = map.box();
        ends_[i]->terminations.push_back({std::move(map), box, from_below, is_void, {}});
    }
    sort_terminations(i);
}

void StructureStack::find_motion(std::size_t i, const Maps& maps) {
    const DistanceMap *below = map_at(i, maps), *above = map_at(i + 1, maps);
    if (below == nullptr || above == nullptr) return;
    SliceMotion::Beyond further_below, further_above;
    if (i > 0 && map_at(i - 1, maps)) further_below = {map_at(i - 1, maps), gap(i - 1), {}};
    if (map_at(i + 2, maps)) further_above = {map_at(i + 2, maps), gap(i + 1), {}};
    // Where what ends is the nearest, the slice beyond says nothing about how a path curves.
    const auto add_ends = [&](std::size_t pair, bool from_below, SliceMotion::Beyond& beyond) {
        for (const Termination& lone : ends_[pair]->terminations) {
            if (lone.from_below == from_below) beyond.ending.push_back(&lone.map);
        }
    };
    if (further_below.map != nullptr) add_ends(i - 1, false, further_below);
    if (further_above.map != nullptr) add_ends(i + 1, true, further_above);
    motions_[i] = std::make_shared<const SliceMotion>(*below, *above, gap(i), further_below, further_above);
}

// The knots of the gap and those beside them have the same maps, at the same distances.
bool StructureStack::has_surroundings_of(std::size_t i, const Maps& maps, const EarlierGap& earlier) const {
    const StructureStack& other = *earlier.stack;
    const std::size_t j = earlier.i;
    for (const std::ptrdiff_t step : {-1, 0, 1, 2}) {
        const std::size_t here = i + static_cast<std::size_t>(step),
                          there = j + static_cast<std::size_t>(step);
        if (map_at(here, maps) != other.map_at(there, *earlier.maps)) return false;
    }
    return is_flat_ == other.is_flat_ && gap(i) == other.gap(j) &&
           (map_at(i - 1, maps) == nullptr || gap(i - 1) == other.gap(j - 1)) &&
           (map_at(i + 2, maps) == nullptr || gap(i + 1) == other.gap(j + 1));
}

bool StructureStack::take_terminations(std::size_t i, const Maps& maps, const EarlierGap& earlier) {
    if (!has_surroundings_of(i, maps, earlier)) return false;
    ends_[i] = earlier.stack->ends_[earlier.i];
    return true;
}

bool StructureStack::take_motion(std::size_t i, const Maps& maps, const EarlierGap& earlier) {
    const StructureStack& other = *earlier.stack;
    const std::size_t j = earlier.i;
    // What ends in the gaps beside it has a say in its paths.
    if (!has_surroundings_of(i, maps, earlier) ||
        (map_at(i - 1, maps) != nullptr && ends_[i - 1] != other.ends_[j - 1]) ||
        (map_at(i + 2, maps) != nullptr && ends_[i + 1] != other.ends_[j + 1]))
        return false;
    motions_[i] = other.motions_[j];
    return true;
}

void StructureStack::add_unlike(const Maps& maps, const StructureStack& other, const Maps& other_maps,
                                std::vector<FieldStretch>& stretches) const {
    const bool same_ends = std::equal(flat_.begin(), flat_.end(), other.flat_.begin(), other.flat_.end(),
                                      [](const auto& a, const auto& b) {
                                          return a.low == b.low && a.high == b.high && a.until == b.until;
                                      });
    std::size_t j = 0;
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
        // Two empty knots may lie at one height.
        if (i > 0 && knots_[i].low == knots_[i - 1].low) ++j;
        while (j + 1 < other.knots_.size() && other.knots_[j].low < knots_[i].low) ++j;
        const auto same_knot = [&](std::size_t step) {
            const Known &here = knots_[i + step], &there = other.knots_[j + step];
            return here.low == there.low && here.high == there.high &&
                   map_at(i + step, maps) == other.map_at(j + step, other_maps);
        };
        const bool both = map_at(i, maps) != nullptr && map_at(i + 1, maps) != nullptr;
        if (same_ends && rounded_ == other.rounded_ && j + 1 < other.knots_.size() && same_knot(0) &&
            same_knot(1) && (!both || (motions_[i] == other.motions_[j] && ends_[i] == other.ends_[j])))
            continue;
        stretches.push_back({knots_[i].low, knots_[i + 1].high});
    }
}

// Holes before pieces, and their boxes.
void StructureStack::sort_terminations(std::size_t i) {
    std::vector<Termination>& ends = ends_[i]->terminations;
    std::stable_partition(ends.begin(), ends.end(), [](const Termination& lone) { return lone.is_void; });
    ends_[i]->boxes.clear();
    for (const Termination& lone : ends) ends_[i]->boxes.push_back(lone.box);
}

ANATOMESH_CLONES double StructureStack::blend(const Maps& maps, double clamp, Vec2 q, double z, double reach,
                                              double* end, bool terminations) const {
    if (knots_.empty() || !(z > low() && z < high())) return clamp;
    const auto bucket = static_cast<std::size_t>((z - low()) * inverse_bucket_);
    std::size_t i = buckets_[std::min(bucket, buckets_.size() - 1)];
    while (i + 1 < knots_.size() && knots_[i + 1].low <= z) ++i;
    const auto distance = [&](const Known& knot, Vec2 at) {
        return maps[static_cast<std::size_t>(knot.map)]->value(at);
    };
    const Known& below = knots_[i];
    if (z <= below.high) {
        if (below.map == empty_knot) return clamp;
        return maps[static_cast<std::size_t>(below.map)]->value_within(q, reach);
    }
    const Known& above = knots_[i + 1];
    const double gap = above.low - below.high, t = (z - below.high) / gap;
    if (below.map == empty_knot && above.map == empty_knot) return clamp;
    if (below.map == empty_knot || above.map == empty_knot) {
        const double away = above.map == empty_knot ? t : 1 - t;
        const double d = distance(above.map == empty_knot ? below : above, q);
        const double value = std::min(ending(d, away, gap, rounded_), clamp);
        if (end == nullptr || is_flat_) return value;
        *end = rounded_ ? value : std::max(d, (away - 0.5) * gap);
        // Beyond its half it has no claim to what is only beside it, so that two that end face to face do
        // not tie there.
        return *end > 0 ? std::max(value, *end) : value;
    }
    const SliceMotion::Path path = motions_[i]->at(q, t);
    const Vec2 from = q - t * path.move, to = q + (1 - t) * path.move;
    const GapEnds& ends = *ends_[i];
    const auto& rest = ends.rest;
    const DistanceMap &a = rest[0] ? *rest[0] : *maps[static_cast<std::size_t>(below.map)],
                      &b = rest[1] ? *rest[1] : *maps[static_cast<std::size_t>(above.map)];
    const std::uint32_t at_a = a.place(from), at_b = b.place(to);
    a.prefetch(at_a);
    b.prefetch(at_b);
    const std::size_t lone = first_termination(i, q), terminating_count = ends.boxes.size();
    if (reach < clamp && (lone == terminating_count || !is_near_termination(i, lone, q, clamp))) {
        // A weighted mean of two distances is not below the smaller one.
        const DistanceMap::Bound in_a = a.bound(at_a), in_b = b.bound(at_b);
        const double beyond =
            std::min(in_a.at_least, in_b.at_least) - std::abs(curvature_correction(t, path));
        if (in_a.sign == in_b.sign && in_a.sign != 0 && beyond > reach)
            return in_a.sign * std::min(beyond, clamp);
    }
    a.prefetch_edges(at_a);
    b.prefetch_edges(at_b);
    const double value = blend_distances(a.value(from, at_a), b.value(to, at_b), t, gap, 0.5 * clamp, path);
    const double clamped = std::clamp(value, -clamp, clamp);
    return terminations && lone != terminating_count ? with_terminations(i, lone, q, t, clamp, clamped, end)
                                                     : clamped;
}

bool StructureStack::is_near_termination(std::size_t i, std::size_t first, Vec2 q, double clamp) const {
    const std::vector<Box2>& boxes = ends_[i]->boxes;
    for (std::size_t n = first; n < boxes.size(); ++n) {
        if (!boxes[n].contains(q)) continue;
        const DistanceMap::Bound bound = ends_[i]->terminations[n].map.bound(q);
        if (bound.sign <= 0 || bound.at_least < clamp) return true;
    }
    return false;
}

// A value between knots i and i + 1 with the parts that end there, first the holes, then the pieces.
double StructureStack::with_terminations(std::size_t i, std::size_t first, Vec2 q, double t, double clamp,
                                         double value, double* end) const {
    const double gap = this->gap(i);
    const std::vector<Box2>& boxes = ends_[i]->boxes;
    for (std::size_t n = first; n < boxes.size(); ++n) {
        if (!boxes[n].contains(q)) continue;
        const Termination& lone = ends_[i]->terminations[n];
        const double away = lone.from_below ? t : 1 - t, d = lone.map.value(q);
        const double ends = std::clamp(lone.value(d, away, gap, rounded_), -clamp, clamp);
        value = lone.is_void ? std::max(value, -ends) : std::min(value, ends);
        if (end != nullptr && !lone.is_void)
            *end = std::min(*end, rounded_ ? ends : std::max(d, (away - 0.5) * gap));
    }
    return value;
}

}  // namespace anatomesh
