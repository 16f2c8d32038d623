#include "anatomesh/contour/overlay/nesting.h"

#include <algorithm>
#include <cstddef>

#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

std::vector<Segment2> segments_of(std::span<const Ring> rings) {
    std::size_t count = 0;
    for (const Ring& ring : rings) count += ring.size();
    std::vector<Segment2> segments;
    segments.reserve(count);
    for (const Ring& ring : rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            segments.push_back({ring.at[i], ring.at[i + 1 < ring.size() ? i + 1 : 0]});
        }
    }
    return segments;
}

}  // namespace

RingEdges::RingEdges(std::span<const Ring> rings) : index(segments_of(rings)) {
    ring_of.reserve(index.segments().size());
    for (std::size_t r = 0; r < rings.size(); ++r) {
        first.push_back(static_cast<std::uint32_t>(ring_of.size()));
        ring_of.insert(ring_of.end(), rings[r].size(), static_cast<std::uint32_t>(r));
    }
}

bool keep_apart(const RingEdges& edges, std::span<const Ring> rings) {
    bool apart = true;
    const std::vector<Segment2>& segments = edges.index.segments();
    edges.index.for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
        const SegmentContact contact =
            segment_contact(segments[i].a, segments[i].b, segments[j].a, segments[j].b);
        if (contact == SegmentContact::none) return true;
        const std::uint32_t ring = edges.ring_of[i];
        const bool consecutive = ring == edges.ring_of[j] &&
                                 (j == i + 1 || (i == edges.first[ring] && j + 1 == i + rings[ring].size()));
        apart = consecutive && contact == SegmentContact::touch;
        return apart;
    });
    return apart;
}

Nesting nest(const RingEdges& edges, std::span<const Ring> rings) {
    const std::size_t count = rings.size();
    std::vector<std::vector<std::uint32_t>> around(count);  // the rings that each ring lies in
    std::vector<std::uint32_t> hits;
    for (std::size_t r = 0; r < count; ++r) {
        hits.clear();
        edges.index.below(*std::min_element(rings[r].at.begin(), rings[r].at.end(),
                                            [](Vec2 p, Vec2 q) { return lexicographic_less(p, q); }),
                          hits);
        // Hits are ascending, so those of one ring are together: an odd number means inside it.
        for (std::size_t begin = 0, end = 0; begin < hits.size(); begin = end) {
            const std::uint32_t other = edges.ring_of[hits[begin]];
            while (end < hits.size() && edges.ring_of[hits[end]] == other) ++end;
            if (other != r && (end - begin) % 2 == 1) around[r].push_back(other);
        }
    }
    Nesting nesting;
    for (const auto& containers : around)
        nesting.depth.push_back(static_cast<std::uint32_t>(containers.size()));
    for (const auto& containers : around) {
        std::int32_t parent = -1;
        for (std::uint32_t other : containers) {
            if (parent < 0 || nesting.depth[other] > nesting.depth[parent])
                parent = static_cast<std::int32_t>(other);
        }
        nesting.parent.push_back(parent);
    }
    return nesting;
}

}  // namespace anatomesh
