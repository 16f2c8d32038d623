#include "anatomesh/field/slice/slice_regions.h"

#include <algorithm>
#include <tuple>

namespace anatomesh {

namespace {

auto key(const Edge2& edge) {
    return std::tuple(edge.a.x, edge.a.y, edge.b.x, edge.b.y);
}
bool edge_before(const Edge2& e, const Edge2& f) {
    return key(e) < key(f);
}
Edge2 reversed(const Edge2& edge) {
    return {edge.b, edge.a};
}

double twice_area(const std::vector<Edge2>& edges) {
    double sum = 0;
    for (const Edge2& edge : edges) sum += cross(edge.a - edges.front().a, edge.b - edges.front().a);
    return sum;
}

}  // namespace

std::vector<SliceRegion> slice_regions(const ContourSet& set, std::uint32_t slice, const Plane& frame) {
    std::vector<SliceRegion> regions;
    for (const Contour& contour : set.contours_of(set.slices[slice])) {
        auto found = std::find_if(regions.begin(), regions.end(), [&](const SliceRegion& region) {
            return region.structure == contour.structure;
        });
        if (found == regions.end()) found = regions.insert(regions.end(), {slice, contour.structure, {}});
        const auto points = set.points_of(contour);
        Vec2 previous = frame.to_plane(points.back());
        for (const Vec3& point : points) {
            const Vec2 next = frame.to_plane(point);
            if (!(previous == next)) found->edges.push_back({previous, next});
            previous = next;
        }
    }
    std::erase_if(regions,
                  [](const SliceRegion& r) { return r.edges.size() < 3 || twice_area(r.edges) == 0; });
    for (SliceRegion& region : regions) {
        // Seen against the frame's normal the contours run the other way round: then the area is negative.
        if (twice_area(region.edges) > 0) continue;
        for (Edge2& edge : region.edges) edge = reversed(edge);
    }
    std::sort(regions.begin(), regions.end(),
              [](const SliceRegion& a, const SliceRegion& b) { return a.structure < b.structure; });
    return regions;
}

std::vector<Edge2> union_boundary(const std::vector<SliceRegion>& regions) {
    std::vector<Edge2> all;
    for (const SliceRegion& region : regions) all.insert(all.end(), region.edges.begin(), region.edges.end());
    std::vector<Edge2> sorted = all;
    std::sort(sorted.begin(), sorted.end(), edge_before);
    std::erase_if(all, [&](const Edge2& edge) {
        return std::binary_search(sorted.begin(), sorted.end(), reversed(edge), edge_before);
    });
    return all;
}

}  // namespace anatomesh
