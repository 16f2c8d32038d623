// ConflatedContours: the contours of one slice, led through vertices of one another; what close_gaps and
// merge_coincident have in common.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/contour/walls/conflation_stats.h"

namespace anatomesh {

// Marks what is no vertex. [vertex; largest number; D]
constexpr std::uint32_t no_vertex = 0xFFFFFFFFu;

// A contour as vertices of its slice: as drawn, and with those taken from others in between. A drawn vertex
// may have moved onto another one.
struct ConflatedContour {
    std::uint32_t structure = 0;
    std::vector<std::uint32_t> drawn;
    std::vector<std::uint32_t> vertices;
    std::vector<std::uint32_t> origin;  // by position in `vertices`: the drawn vertex, no_vertex: taken

    bool taken(std::size_t n) const { return origin[n] == no_vertex; }
    bool changed(std::size_t n) const { return origin[n] != vertices[n]; }
    // The vertex after the n-th, and before it.
    std::uint32_t next_of(std::size_t n) const { return vertices[(n + 1) % vertices.size()]; }
    std::uint32_t last_of(std::size_t n) const {
        return vertices[(n + vertices.size() - 1) % vertices.size()];
    }
};

class ConflatedContours {
  public:
    using Edge = std::array<std::uint32_t, 2>;   // vertices
    using Place = std::array<std::uint32_t, 2>;  // loop, number of a vertex or segment in it

    // A vertex beside a segment of a loop: how far along it in lengths of the segment, and how far from it.
    struct Beside {
        std::uint32_t vertex = 0, loop = 0, segment = 0;
        double along = 0, distance = 0;
    };

    // What a contour as led has more or elsewhere than as drawn.
    struct Change {
        std::uint64_t taken = 0, moved = 0;  // vertices
        double widest_mm = 0;                // of a vertex from the segment, or the place, it was drawn at
        double area_mm2 = 0;                 // between both, counted on either side
    };

    ConflatedContours(const ContourSet& set, const Slice& slice);

    // In lengths of the segment, 0 at a and 1 at b, beyond them too.
    static double along(Vec2 p, Vec2 a, Vec2 b) { return dot(p - a, b - a) / dot(b - a, b - a); }

    // Their order is that of the slice's contours.
    const std::vector<ConflatedContour>& loops() const { return loops_; }
    Vec3 point(std::uint32_t vertex) const { return points_[vertex]; }
    Change change_of(const ConflatedContour& loop) const;

    // Appends the contours to a set whose slice number this one gets, each from its smallest vertex on.
    void append_to(std::vector<Contour>& contours, std::vector<Vec3>& points, std::uint32_t slice) const;

  protected:
    // The drawn ends of the segment that this one is a part of, or was led away from.
    static Edge drawn_segment(const ConflatedContour& loop, std::size_t n);

    static bool has(const Edge& e, std::uint32_t v) { return e[0] == v || e[1] == v; }

    // Which structure has which vertex: (structure, vertex), sorted.
    std::vector<Edge> owned() const;

    // From a point to the nearest one of a segment.
    struct Way {
        Vec2 from;
        Edge to;                // the ends of the segment
        std::vector<Edge> own;  // segments that it may meet: what it starts from, and that
        std::uint32_t vertex;   // those at this vertex too
    };

    // Whether each crosses one of these segments: what lies beyond another contour, or beyond the other side
    // of its own, is no neighbour.
    std::vector<std::uint8_t> hidden(const std::vector<Way>& ways, const std::vector<Edge>& segments) const;

    // For each vertex and structure the nearest segment; at a corner the one that the vertex is less beyond.
    std::vector<Beside> nearest(std::vector<Beside> found) const;
    void put_in(std::vector<Beside> found);

    // Of a structure's loops first..last: the vertices at which they came to touch or cross one another.
    std::vector<Place> touching(std::size_t first, std::size_t last) const;
    // All that changed, if one was turned inside out or came to lie in another one, or out of it.
    std::vector<Place> turned_or_nested(std::size_t first, std::size_t last) const;
    // Leaves out what was taken there, and moves back what was moved, wherever it is. Says whether there were
    // any.
    bool drop(std::vector<Place> places);
    std::size_t end_of_structure(std::size_t first) const;

    std::vector<Vec3> points_;  // of the slice, distinct, in lexicographic order; then those that were made
    std::vector<Vec2> at_;
    std::vector<ConflatedContour> loops_;

  private:
    std::uint32_t vertex_of(Vec3 p) const;
    std::vector<Vec2> polygon(const std::vector<std::uint32_t>& loop) const;
    bool touch(Edge p, Edge q) const;
};

// Every segment of every loop, in their order, and where it is.
struct PlacedSegments {
    std::vector<Segment2> segments;
    std::vector<ConflatedContours::Place> places;
};
// `at`: the vertices' places in the slice's plane. Complexity: O(segments).
PlacedSegments placed_segments(const std::vector<ConflatedContour>& loops, const std::vector<Vec2>& at);

// The set with what `lead(slice number)` makes of the contours of each slice, if it changes any.
template <class Lead>
void lead_slices(ContourSet& set, ConflationStats& stats, Lead&& lead) {
    std::vector<Contour> contours;
    std::vector<Vec3> points;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        const ConflatedContours led = lead(s);
        stats.add(led, s);
        led.append_to(contours, points, s);
    }
    if (stats.contours_changed == 0) return;
    set.contours = std::move(contours);
    set.points = std::move(points);
}

}  // namespace anatomesh
