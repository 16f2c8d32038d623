#include "anatomesh/contour/walls/loop_meetings.h"

#include <algorithm>
#include <utility>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// The meetings of two segments. Their places are in rising order, as the segments are in the index.
void add_meetings(const std::vector<ConflatedContour>& loops, const std::vector<Vec2>& at,
                  ConflatedContours::Place p, ConflatedContours::Place q, std::vector<Meeting>& all) {
    const ConflatedContour &first = loops[p[0]], &second = loops[q[0]];
    const ConflatedContours::Edge own{first.vertices[p[1]], first.next_of(p[1])};
    const ConflatedContours::Edge other{second.vertices[q[1]], second.next_of(q[1])};
    bool common = false;
    for (std::uint32_t k = 0; k < 2; ++k) {
        for (std::uint32_t m = 0; m < 2; ++m) {
            if (own[k] != other[m]) continue;
            common = true;
            all.push_back({{p[0], q[0]},
                           static_cast<double>((p[1] + k) % first.vertices.size()),
                           static_cast<double>((q[1] + m) % second.vertices.size()),
                           own[k]});
        }
    }
    const Vec2 a = at[own[0]], b = at[own[1]], c = at[other[0]], d = at[other[1]];
    if (common || segment_contact(a, b, c, d) != SegmentContact::cross) return;
    const double across = cross(b - a, d - c);
    const auto share = [&](double part) { return across == 0 ? 0.5 : std::clamp(part / across, 0.0, 1.0); };
    all.push_back(
        {{p[0], q[0]}, p[1] + share(cross(c - a, d - c)), q[1] + share(cross(c - a, b - a)), no_vertex});
}

}  // namespace

std::vector<Meeting> find_meetings(const std::vector<ConflatedContour>& loops, const std::vector<Vec2>& at) {
    PlacedSegments placed = placed_segments(loops, at);
    const std::vector<ConflatedContours::Place>& places = placed.places;
    std::vector<Meeting> all;
    SegmentIndex(std::move(placed.segments)).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
        if (loops[places[i][0]].structure != loops[places[j][0]].structure)
            add_meetings(loops, at, places[i], places[j], all);
        return true;
    });
    std::sort(all.begin(), all.end(), [](const Meeting& p, const Meeting& q) { return p.key() < q.key(); });
    all.erase(std::unique(all.begin(), all.end(),
                          [](const Meeting& p, const Meeting& q) { return p.key() == q.key(); }),
              all.end());
    return all;
}

}  // namespace anatomesh
