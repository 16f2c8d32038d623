#include "anatomesh/refine/segment_vertices.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "anatomesh/geom/polygon.h"
#include "anatomesh/improve/core/drawn_slices.h"
#include "anatomesh/measure/slice_sections.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

std::vector<std::uint32_t> slices_of_vertices(const ContourSet& contours,
                                              std::span<const std::uint32_t> vertex_of,
                                              const std::vector<Subsegment>& subsegments,
                                              std::size_t vertex_count) {
    assert(vertex_of.size() == contours.points.size());
    // It stands for a vertex on contours of more than one slice. [index that no slice has; 0xFFFFFFFE; D]
    constexpr std::uint32_t several = no_slice - 1;
    std::vector<std::uint32_t> slice(vertex_count, no_slice);
    for (const Contour& contour : contours.contours) {
        for (std::uint32_t n = contour.first_point; n < contour.first_point + contour.point_count; ++n) {
            std::uint32_t& known = slice[vertex_of[n]];
            known = known == no_slice || known == contour.slice ? contour.slice : several;
        }
    }
    // The ends of subsegments at each vertex.
    std::vector<std::uint32_t> start(vertex_count + 1, 0), others(2 * subsegments.size());
    for (const Subsegment& subsegment : subsegments) {
        ++start[subsegment.a + 1];
        ++start[subsegment.b + 1];
    }
    for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1), queue;
    for (const Subsegment& subsegment : subsegments) {
        others[next[subsegment.a]++] = subsegment.b;
        others[next[subsegment.b]++] = subsegment.a;
    }
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
        if (slice[v] < several) queue.push_back(v);
    }
    for (std::size_t head = 0; head < queue.size(); ++head) {
        const std::uint32_t v = queue[head];
        for (std::uint32_t n = start[v]; n < start[v + 1]; ++n) {
            if (slice[others[n]] != no_slice) continue;
            slice[others[n]] = slice[v];
            queue.push_back(others[n]);
        }
    }
    std::replace(slice.begin(), slice.end(), several, no_slice);
    return slice;
}

std::vector<std::array<std::uint32_t, 2>> segment_ends(const ContourSet& contours,
                                                       std::span<const std::uint32_t> vertex_of) {
    std::vector<std::array<std::uint32_t, 2>> ends;
    for (const Contour& contour : contours.contours) {
        for (std::uint32_t n = 0; n < contour.point_count; ++n)
            ends.push_back({vertex_of[contour.first_point + n],
                            vertex_of[contour.first_point + (n + 1) % contour.point_count]});
    }
    return ends;
}

PlanesOfStack planes_of_stack(const ContourSet& contours, const SliceArrangement& arrangement,
                              std::span<const std::uint32_t> vertex_of,
                              const std::vector<Subsegment>& subsegments, std::size_t vertex_count) {
    if (!arrangement.is_parallel()) return {};
    PlanesOfStack stack{slices_of_vertices(contours, vertex_of, subsegments, vertex_count), {}};
    for (const Slice& slice : contours.slices) stack.planes.push_back(slice.plane);
    return stack;
}

namespace {

// Those of a stack may lean a little against each other: their heights are those where something is drawn.
void place_planes(const ContourSet& contours, bool parallel, SliceWeights& slices) {
    const Box3 box = contours.box();
    const Vec3 middle = 0.5 * (box.low + box.high);
    slices.on_plane_mm = on_plane_mm(contours);
    for (const Slice& slice : contours.slices) {
        slices.planes.push_back(slice.plane);
        if (parallel) {
            slices.planes.back().origin = middle - slice.plane.signed_distance(middle) * slice.plane.normal;
            continue;
        }
    }
    if (!parallel) slices.extents = frames_of_slices(contours);
}

// Areas drawn, at structure * slices + slice; mm^2.
std::vector<double> drawn_areas(const ContourSet& contours) {
    const std::size_t count = contours.slices.size();
    std::vector<double> areas(contours.structures.size() * count, 0);
    for (const Contour& contour : contours.contours) {
        std::vector<Vec2> ring;
        for (const Vec3& p : contours.points_of(contour))
            ring.push_back(contours.slices[contour.slice].plane.to_plane(p));
        areas[contour.structure * count + contour.slice] += signed_area(ring);
    }
    return areas;
}

// Whether something ends flat in a slice: one of the planes runs through its contours' points.
bool ends_flat(const ContourSet& contours, std::uint32_t slice, const std::vector<Plane>& ends,
               double tolerance) {
    return std::any_of(ends.begin(), ends.end(), [&](const Plane& end) {
        double low = 0, high = 0;
        bool any = false;
        for (const Contour& contour : contours.contours_of(contours.slices[slice])) {
            for (const Vec3& p : contours.points_of(contour)) {
                const double height = end.signed_distance(p);
                low = any ? std::min(low, height) : height;
                high = any ? std::max(high, height) : height;
                any = true;
            }
        }
        return any && low <= tolerance && high >= -tolerance;
    });
}

}  // namespace

SliceWeights weigh_slices(const ContourSet& contours, const SliceFacts& facts,
                          const std::vector<Plane>& ends) {
    SliceWeights slices;
    const bool parallel = facts.arrangement.is_parallel();
    place_planes(contours, parallel, slices);
    const std::vector<double> areas = drawn_areas(contours);
    const std::size_t count = slices.planes.size(), structures = contours.structures.size();
    slices.weights.assign(structures * count, 0);
    for (std::uint32_t s = 0; s < structures; ++s) {
        const auto first = areas.begin() + static_cast<std::ptrdiff_t>(s * count);
        const auto drawn = std::count_if(first, first + static_cast<std::ptrdiff_t>(count),
                                         [](double area) { return area > 0; });
        if (drawn == 0) continue;
        const double mean = std::accumulate(first, first + static_cast<std::ptrdiff_t>(count), 0.0) /
                            static_cast<double>(drawn);
        for (std::uint32_t k = 0; k < count; ++k) {
            const bool is_certain =
                (parallel || contours.slices[k].contour_count > 0) && facts.coverage.is_certain(k, s);
            const double area = areas[s * count + k];
            slices.weights[s * count + k] = area > 0 ? 1 / area : is_certain ? 1 / mean : 0;
        }
    }
    slices.sides.on_plane_mm = slices.on_plane_mm;
    const Plane& frame = contours.slices.front().plane;
    for (std::uint32_t k = 0; k < count; ++k) {
        if (ends_flat(contours, k, ends, slices.on_plane_mm)) {
            for (std::size_t s = 0; s < structures; ++s) slices.weights[s * count + k] = 0;
        } else if (parallel) {
            slices.sides.stack.heights.push_back(frame.signed_distance(slices.planes[k].origin));
        } else {
            slices.sides.planes.push_back(slices.planes[k]);
            slices.sides.extents.push_back(slices.extents[k]);
        }
    }
    slices.sides.stack.frame = frame;
    std::sort(slices.sides.stack.heights.begin(), slices.sides.stack.heights.end());
    return slices;
}

}  // namespace anatomesh
