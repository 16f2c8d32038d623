#include "anatomesh/contour/walls/loop_stretches.h"

#include <algorithm>
#include <cmath>

namespace anatomesh {

Stretch LoopStretches::between(std::uint32_t loop, double from, double to) const {
    const double end = to < from ? to + static_cast<double>(loops_[loop].vertices.size()) : to;
    const double start = std::floor(from), behind = std::max(std::ceil(end), start + 1);
    return {loop, static_cast<std::size_t>(start), static_cast<std::size_t>(behind - start), from - start,
            1 - (behind - end)};
}

std::uint32_t LoopStretches::number(const Stretch& part, std::size_t k) const {
    return static_cast<std::uint32_t>((part.start + k) % loops_[part.loop].vertices.size());
}

std::uint32_t LoopStretches::vertex(const Stretch& part, std::size_t k) const {
    return loops_[part.loop].vertices[number(part, k + 1)];
}

Segment2 LoopStretches::segment(const Stretch& part, std::size_t k) const {
    const std::uint32_t n = number(part, k);
    return {at_[loops_[part.loop].vertices[n]], at_[loops_[part.loop].next_of(n)]};
}

double LoopStretches::mean_segment(const Stretch& part) const {
    const bool inner = part.segments > 2;
    double sum = 0;
    for (std::size_t k = inner; k + inner < part.segments; ++k) {
        const auto [a, b] = segment(part, k);
        sum += length(b - a);
    }
    return sum / static_cast<double>(part.segments - 2 * inner);
}

LoopStretches::PlaceOn LoopStretches::nearest_place(const Stretch& part, Vec2 p) const {
    PlaceOn best;
    for (std::size_t k = 0; k < part.segments; ++k) {
        const auto [a, b] = segment(part, k);
        const double low = k == 0 ? part.from : 0, high = k + 1 == part.segments ? part.to : 1;
        const double share = std::clamp(ConflatedContours::along(p, a, b), low, high);
        const double apart = length(p - (a + share * (b - a)));
        if (apart < best.apart) best = {k, share, apart};
    }
    return best;
}

std::vector<Vec2> LoopStretches::ring_between(const Stretch& first, const Stretch& second) const {
    std::vector<Vec2> ring;
    for (const Stretch& part : {first, second}) {
        const Segment2 here = segment(part, 0);
        ring.push_back(here.a + part.from * (here.b - here.a));
        for (std::size_t k = 0; k < part.vertices(); ++k) ring.push_back(at_[vertex(part, k)]);
    }
    return ring;
}

}  // namespace anatomesh
