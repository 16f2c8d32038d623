#include "anatomesh/contour/walls/sliver_between.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// A sliver has no more vertices of either contour: more are no chords of one line. [vertices; >= 1; M 2026-11 random solids that touch]
constexpr std::size_t most_vertices_of_sliver = 3;

// Of the vertices of two stretches in one order: whether it is the first one's.
struct Shared {
    std::uint32_t vertex = 0;
    bool of_first = false;
};

// Where the second stretch's vertices lie along the first, from the first's start on; nothing if one lies not within
// the width or they are out of order.
std::optional<std::vector<double>> places_along(const LoopStretches& stretches, const Stretch& first,
                                                const Stretch& second, double width_mm) {
    std::vector<double> along_first;
    for (std::size_t k = second.vertices(); k-- > 0;) {
        const LoopStretches::PlaceOn place =
            stretches.nearest_place(first, stretches.at(stretches.vertex(second, k)));
        const double here = static_cast<double>(place.segment) + place.share;
        if (!(place.apart < width_mm) || (!along_first.empty() && here < along_first.back()))
            return std::nullopt;
        along_first.push_back(here);
    }
    return along_first;
}

// The vertices of both in one order, from the first's start on.
std::vector<Shared> common_order(const LoopStretches& stretches, const Stretch& first, const Stretch& second,
                                 const std::vector<double>& along_first) {
    std::vector<Shared> order;
    std::size_t own = 0;
    for (std::size_t m = 0; m < along_first.size(); ++m) {
        for (; own < first.vertices() && static_cast<double>(own + 1) < along_first[m]; ++own)
            order.push_back({stretches.vertex(first, own), true});
        order.push_back({stretches.vertex(second, second.vertices() - 1 - m), false});
    }
    for (; own < first.vertices(); ++own) order.push_back({stretches.vertex(first, own), true});
    return order;
}

// Those of the other stretch into this one, evenly between its own.
void put_into(const LoopStretches& stretches, const Stretch& part, const std::vector<Shared>& order,
              bool is_first, Insertions& insertions) {
    std::size_t k = 0;  // the segment, by its own vertices so far
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end + 1, ++k) {
        for (end = begin; end < order.size() && order[end].of_first != is_first;) ++end;
        const double low = k == 0 ? part.from : 0, high = k + 1 == part.segments ? part.to : 1;
        const auto [a, b] = stretches.segment(part, k);
        for (std::size_t n = begin; n < end; ++n) {
            const double share = low + (high - low) * static_cast<double>(n + 1 - begin) /
                                           static_cast<double>(end + 1 - begin);
            const std::uint32_t v = order[n].vertex;
            insertions.push_back(
                {v, part.loop, stretches.number(part, k), share, distance_to_segment(stretches.at(v), a, b)});
        }
    }
}

}  // namespace

std::optional<Insertions> sliver_between(const LoopStretches& stretches, const Stretch& first,
                                         const Stretch& second, const CloseSliversOptions& options) {
    if (first.vertices() > most_vertices_of_sliver || second.vertices() > most_vertices_of_sliver)
        return std::nullopt;
    const double width = std::min(
        options.width_mm,
        options.share_of_segment * std::min(stretches.mean_segment(first), stretches.mean_segment(second)));
    const std::optional<std::vector<double>> along_first = places_along(stretches, first, second, width);
    if (!along_first) return std::nullopt;
    for (std::size_t k = 0; k < first.vertices(); ++k) {
        if (!(stretches.nearest_place(second, stretches.at(stretches.vertex(first, k))).apart < width))
            return std::nullopt;
    }
    std::vector<Shared> order = common_order(stretches, first, second, *along_first);
    Insertions insertions;
    put_into(stretches, first, order, true, insertions);
    std::reverse(order.begin(), order.end());
    put_into(stretches, second, order, false, insertions);
    return insertions;
}

}  // namespace anatomesh
