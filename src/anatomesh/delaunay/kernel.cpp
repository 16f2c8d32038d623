#include "anatomesh/delaunay/kernel.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/delaunay/spatial_order.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

namespace {

constexpr std::uint32_t removed = DelaunayKernel::removed;
constexpr std::uint32_t most_slots = 1u << 30;  // A link is 4 * slot + facet, in 32 bits. [slots; > 0; D]

// Space is parted for so many threads at most. [regions of space; 1 to 255; B]
constexpr int most_regions = 64;
// One thread inserts fewer points sooner than many do. [points; >= 0; B]
constexpr std::size_t least_for_threads = 4000;
// In a fine mesh fewer are enough: their cavities are small beside the regions. [points; >= 0; B]
constexpr std::size_t least_in_fine = 150;
constexpr std::size_t fine_mesh = 16;  // It has so many times as many vertices. [1; > 0; B]
// A point of many adds 6.8 cells to those that fill space. [slots a point; >= 1; B]
constexpr std::size_t slots_per_point = 8;

std::uint32_t vertex_of(const DelaunayKernel::KernelCell& cell, int place) {
    return cell.vertex[place] & ~removed;
}

Vec3 absolute(Vec3 v) {
    return {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
}

}  // namespace

// ---- What an insertion works with ----

struct DelaunayKernel::Corner {
    Vec3 place;      // relative to the new point; zero at infinity
    double squares;  // its squared length; the scale of ghosts at infinity
    std::uint32_t vertex;
};

// A list whose next value is written before it is known whether it stays: without a branch to mispredict.
template <class T>
class TentativeList {
  public:
    std::size_t size() const { return size_; }
    T& operator[](std::size_t n) { return items_[n]; }
    std::span<T> items() { return {items_.data(), size_}; }
    void clear() { size_ = 0; }
    void make_room(std::size_t count) {
        if (items_.size() < size_ + count) items_.resize(2 * (size_ + count));
    }
    // Requires: room for one more.
    T& next() { return items_[size_]; }
    void keep_if(bool wanted) { size_ += wanted; }

  private:
    std::vector<T> items_;
    std::size_t size_ = 0;
};

// One slot, at most, for each box of a grid: what is there may have changed since, but lies near.
struct DelaunayKernel::Anchors {
    Anchors() = default;
    explicit Anchors(const Box3& box) : low_(box.low), slots_(per_axis * per_axis * per_axis, no_cell) {
        const Vec3 extent = box.high - box.low;
        const auto scale = [](double length) { return length > 0 ? per_axis / length : 0; };
        scale_ = {scale(extent.x), scale(extent.y), scale(extent.z)};
    }

    std::uint32_t& at(Vec3 p) {
        const auto place = [](double x) {
            return static_cast<std::size_t>(std::clamp(x, 0.0, per_axis - 1.0));
        };
        return slots_[(place((p.x - low_.x) * scale_.x) * per_axis + place((p.y - low_.y) * scale_.y)) *
                          per_axis +
                      place((p.z - low_.z) * scale_.z)];
    }

  private:
    // The box has so many anchors along each axis: more need longer to be set than they save in walks.
    // [boxes; >= 1; B]
    static constexpr std::size_t per_axis = 32;
    Vec3 low_, scale_;
    std::vector<std::uint32_t> slots_;
};

struct DelaunayKernel::Worker {
    // A facet of the boundary of the cavity.
    struct Facet {
        std::uint32_t link;                   // the facet outside that it lies on
        std::array<std::uint32_t, 3> vertex;  // counter-clockwise from outside
        std::array<std::uint32_t, 3> corner;  // the same as places among the corners
        std::uint32_t slot;                   // of the new cell between it and the new point
    };

    std::uint8_t region = 0;
    std::uint32_t last_cell = 0;
    Anchors anchors;
    std::uint32_t random = 0x9E3779B9u;
    std::vector<std::uint32_t> free_slots;
    std::uint32_t next_slot = 0, end_slot = 0;  // fresh ones
    TentativeList<std::uint32_t> cavity;        // cells in conflict, as the facets by which they were reached
    TentativeList<Facet> facets;
    std::vector<Corner> corners;
    std::vector<std::uint32_t> table;  // of link_by_table
    std::vector<std::uint32_t> log;
    std::uint64_t cells_made = 0;

    unsigned random_facet() {
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        return random >> 30;
    }
    std::size_t slots_at_hand() const { return cavity.size() + free_slots.size() + (end_slot - next_slot); }
    // A slot for new cell `n`: those of the cavity first.
    std::uint32_t take_slot(std::size_t n) {
        if (n < cavity.size()) return cavity[n] >> 2;
        if (free_slots.empty()) return next_slot++;
        const std::uint32_t slot = free_slots.back();
        free_slots.pop_back();
        return slot;
    }
};

int DelaunayKernel::KernelCell::infinite_place() const {
    for (int i = 1; i < 4; ++i) {
        if (vertex[i] == infinite_vertex) return i;
    }
    return -1;
}

// ---- Conflict of a point with a cell ----

[[gnu::always_inline]] inline double DelaunayKernel::form_value(const KernelCell& cell, Vec3 q) const {
    const Vec3 d = q - vertices_[vertex_of(cell, 0)].position;
    return dot(cell.normal, d) + cell.lift * squared_length(d);
}

[[gnu::always_inline]] inline bool DelaunayKernel::conflicts(const KernelCell& cell, Vec3 q) const {
    const double value = form_value(cell, q);
    return std::abs(value) > conflict_bound_ ? value > 0 : conflicts_nearly(cell, q, value);
}

// Within the bound from the box: the same with the bound from the five points, then exactly.
bool DelaunayKernel::conflicts_nearly(const KernelCell& cell, Vec3 q, double value) const {
    const int infinite = cell.infinite_place();
    if (infinite < 0) {
        const Vec3 origin = vertices_[vertex_of(cell, 0)].position;
        Vec3 extent = absolute(q - origin);
        for (int i = 1; i < 4; ++i) {
            const Vec3 d = absolute(vertices_[cell.vertex[i]].position - origin);
            extent = {std::max(extent.x, d.x), std::max(extent.y, d.y), std::max(extent.z, d.z)};
        }
        if (std::abs(value) >
            in_sphere_rounding * extent.x * extent.y * extent.z * squared_length(extent) + underflow_bound_)
            return value > 0;
    }
    return conflicts_exactly(cell, q);
}

bool DelaunayKernel::conflicts_exactly(const KernelCell& cell, Vec3 q) const {
    const auto sphere = [&](const KernelCell& finite) {
        return in_perturbed_sphere(vertices_[vertex_of(finite, 0)].position,
                                   vertices_[finite.vertex[1]].position, vertices_[finite.vertex[2]].position,
                                   vertices_[finite.vertex[3]].position, q) > 0;
    };
    const int infinite = cell.infinite_place();
    if (infinite < 0) return sphere(cell);
    std::array<Vec3, 4> p;
    for (int i = 0; i < 4; ++i) p[i] = i == infinite ? q : vertices_[vertex_of(cell, i)].position;
    if (const int side = orient3d(p[0], p[1], p[2], p[3])) return side > 0;
    // In the plane of the hull facet the circle decides: the section of the sphere of the cell behind it.
    return sphere(cells_[cell.link[infinite] >> 2]);
}

// With |d| the extents of the box, the form of a cell is a determinant of degree five; that of a ghost one of
// degree three.
void DelaunayKernel::update_bounds() {
    const Vec3 extent = box_.high - box_.low;
    const RoundingBounds bounds = rounding_bounds(extent);
    orient_bound_ = bounds.orient3d;
    conflict_bound_ = bounds.in_sphere;
    underflow_bound_ = bounds.in_sphere_underflow;
    // A power of two, at most the quotient of the bounds without their parts for underflow. It grows with the
    // box, so that ghosts made before are within the bound as well. None when out of range: then exact tests
    // decide.
    const double squares = squared_length(extent);
    ghost_scale_ = squares >= 0x1p-300 && squares <= 0x1p398 ? std::ldexp(1.0, std::ilogb(squares) + 3) : 0;
}

[[gnu::always_inline]] inline DelaunayKernel::Corner DelaunayKernel::corner(std::uint32_t vertex,
                                                                            Vec3 origin) const {
    if (vertex == infinite_vertex) return {{}, ghost_scale_, vertex};
    const Vec3 place = vertices_[vertex].position - origin;
    return {place, squared_length(place), vertex};
}

// For the cell (origin, a, b, c) the determinant of the lifted points as a linear form of the lifted query;
// with a at infinity, as a corner of no place and unit lift, the same sum is the determinant of the hull
// facet.
[[gnu::always_inline]] inline void DelaunayKernel::set_form(KernelCell& cell, const Corner& a,
                                                            const Corner& b, const Corner& c) {
    const Vec3 bc = cross(b.place, c.place), ca = cross(c.place, a.place), ab = cross(a.place, b.place);
    cell.normal = a.squares * bc + b.squares * ca + c.squares * ab;
    cell.lift = -dot(a.place, bc);
}

// ---- The first cell ----

// Makes a cell of four points that span a volume, and its ghosts. The four are found again as equal points
// later.
bool DelaunayKernel::start(std::uint32_t first) {
    const std::uint32_t end = static_cast<std::uint32_t>(vertices_.size());
    std::array<std::uint32_t, 4> v{first, first, first, first};
    const auto p = [&](int i) { return vertices_[v[i]].position; };
    const auto advance = [&](int i, const auto& independent) {
        for (v[i] = v[i - 1]; v[i] < end && !independent(); ++v[i]) {
        }
        return v[i] < end;
    };
    const auto collinear = [](Vec3 a, Vec3 b, Vec3 c) {
        return orient2d({a.x, a.y}, {b.x, b.y}, {c.x, c.y}) == 0 &&
               orient2d({a.y, a.z}, {b.y, b.z}, {c.y, c.z}) == 0 &&
               orient2d({a.z, a.x}, {b.z, b.x}, {c.z, c.x}) == 0;
    };
    if (first == end || !advance(1, [&] { return p(0) != p(1); }) ||
        !advance(2, [&] { return !collinear(p(0), p(1), p(2)); }) ||
        !advance(3, [&] { return orient3d(p(0), p(1), p(2), p(3)) != 0; })) {
        return false;
    }
    if (orient3d(p(0), p(1), p(2), p(3)) < 0) std::swap(v[2], v[3]);

    cells_.resize(5);
    cells_[0].vertex = v;
    for (int i = 0; i < 4; ++i) {
        KernelCell& ghost = cells_[1 + i];
        cells_[0].link[i] = 4 * (1 + i) + 3;
        ghost.link[3] = i;
        ghost.vertex[3] = infinite_vertex;
        for (int j = 0; j < 3; ++j) {
            const int m = facet_vertices[i][j];
            ghost.vertex[j] = v[m];
            const auto& there = facet_vertices[m];
            ghost.link[j] = 4 * (1 + m) + static_cast<std::uint32_t>(
                                              std::find(there.begin(), there.end(), i) - there.begin());
        }
    }
    for (KernelCell& cell : cells_) {
        const Vec3 origin = vertices_[cell.vertex[0]].position;
        set_form(cell, corner(cell.vertex[1], origin), corner(cell.vertex[2], origin),
                 corner(cell.vertex[3], origin));
    }
    return true;
}

// ---- Insertion of one point ----

// Walks from a cell towards q, to a cell in conflict with it; `found` is that cell, or the vertex
// equal to q.
template <bool bounded>
DelaunayKernel::Outcome DelaunayKernel::locate(Worker& worker, Vec3 q, std::uint32_t from,
                                               std::uint32_t& found) const {
    found = from;
    for (unsigned entry = 4;;) {
        const KernelCell& cell = cells_[found];
        if (bounded && !in_region(cell, worker.region)) return Outcome::deferred;
        if (conflicts(cell, q)) return Outcome::inserted;
        std::uint32_t next = no_cell;
        if (const int infinite = cell.infinite_place(); infinite >= 0) {
            next = cell.link[infinite];
        } else {
            std::array<Vec3, 4> d;
            for (int i = 0; i < 4; ++i) d[i] = vertices_[cell.vertex[i]].position - q;
            for (unsigned n = 0, facet = worker.random_facet(); n < 4; ++n, facet = (facet + 1) & 3) {
                if (facet == entry) continue;
                const auto& f = facet_vertices[facet];
                const double outside = -dot(cross(d[f[0]], d[f[1]]), d[f[2]]);
                if (outside < -orient_bound_) continue;
                if (outside > orient_bound_ ||
                    orient3d(vertices_[cell.vertex[f[0]]].position, vertices_[cell.vertex[f[1]]].position,
                             vertices_[cell.vertex[f[2]]].position, q) > 0) {
                    next = cell.link[facet];
                    break;
                }
            }
        }
        if (next == no_cell) {
            // q is in the cell and not in conflict with it: one of its vertices.
            for (const std::uint32_t vertex : cell.vertex) {
                if (vertices_[vertex].position == q) found = vertex;
            }
            return Outcome::equal;
        }
        found = next >> 2;
        entry = next & 3;
    }
}

inline void DelaunayKernel::prefetch_neighbors(const KernelCell& cell) const {
    for (const std::uint32_t link : cell.link) __builtin_prefetch(&cells_[link >> 2]);
}

// From a cell in conflict with q to all of them, and the facets around them. False, and nothing changed, when
// one of them is not in the region.
template <bool bounded>
bool DelaunayKernel::find_cavity(Worker& worker, Vec3 q, std::uint32_t first) {
    auto& cavity = worker.cavity;
    auto& facets = worker.facets;
    const double bound = conflict_bound_;
    cavity.clear();
    facets.clear();
    cavity.make_room(1);
    cavity.next() = 4 * first;
    cavity.keep_if(true);
    cells_[first].vertex[0] |= removed;
    for (std::size_t n = 0; n < cavity.size(); ++n) {
        cavity.make_room(4);
        facets.make_room(4);
        const KernelCell& cell = cells_[cavity[n] >> 2];
        if (n + 1 < cavity.size()) prefetch_neighbors(cells_[cavity[n + 1] >> 2]);
        // All facets but the one it was reached by; all of the first.
        const int entry = static_cast<int>(cavity[n] & 3);
        for (int i = entry + (n > 0); i < entry + 4; ++i) {
            const std::uint32_t link = cell.link[i & 3];
            KernelCell& other = cells_[link >> 2];
            double value = form_value(other, q);
            if (!(std::abs(value) > bound)) [[unlikely]] {
                value = other.alive() && conflicts_nearly(other, q, value) ? 1 : -1;
            }
            const bool alive = other.alive(), conflict = alive & (value > 0);
            if (bounded && conflict && !in_region(other, worker.region)) {
                restore(worker);
                return false;
            }
            cavity.next() = link;
            cavity.keep_if(conflict);
            const auto& f = facet_vertices[i & 3];
            Worker::Facet& facet = facets.next();
            facet.link = link;
            facet.vertex = {vertex_of(cell, f[0]), vertex_of(cell, f[1]), vertex_of(cell, f[2])};
            facets.keep_if(alive & !conflict);
            // Other threads may read cells that this one does not change.
            if (!bounded || conflict) other.vertex[0] |= conflict ? removed : 0;
        }
    }
    return true;
}

// Gives back what find_cavity took.
void DelaunayKernel::restore(Worker& worker) {
    for (const std::uint32_t link : worker.cavity.items()) cells_[link >> 2].vertex[0] &= ~removed;
}

// The vertices of the boundary, each once, relative to q.
void DelaunayKernel::find_corners(Worker& worker, Vec3 q) {
    worker.corners.clear();
    std::uint32_t at_infinity = no_cell;
    for (Worker::Facet& facet : worker.facets.items()) {
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t vertex = facet.vertex[i];
            std::uint32_t& place = vertex == infinite_vertex ? at_infinity : vertices_[vertex].scratch;
            if (place >= worker.corners.size() || worker.corners[place].vertex != vertex) {
                place = static_cast<std::uint32_t>(worker.corners.size());
                worker.corners.push_back(corner(vertex, q));
            }
            facet.corner[i] = place;
        }
    }
}

// The new cells of the cavity: the new point and a facet each.
void DelaunayKernel::make_cells(Worker& worker, std::uint32_t vertex) {
    std::size_t n = 0;
    for (Worker::Facet& facet : worker.facets.items()) {
        facet.slot = worker.take_slot(n++);
        KernelCell& cell = cells_[facet.slot];
        cell.vertex = {vertex, facet.vertex[0], facet.vertex[1], facet.vertex[2]};
        cell.link[0] = facet.link;
        cells_[facet.link >> 2].link[facet.link & 3] = 4 * facet.slot;
        set_form(cell, worker.corners[facet.corner[0]], worker.corners[facet.corner[1]],
                 worker.corners[facet.corner[2]]);
    }
    for (; n < worker.cavity.size(); ++n) worker.free_slots.push_back(worker.cavity[n] >> 2);
    // Larger cavities are linked by sorting, because the table grows with the square of their vertices.
    // [vertices; >= 0; B]
    constexpr std::size_t most_in_table = 256;
    if (worker.corners.size() <= most_in_table) {
        link_by_table(worker, cells_);
    } else {
        link_by_sorting(worker, cells_);
    }
}

void DelaunayKernel::log_changes(Worker& worker) const {
    for (const Worker::Facet& facet : worker.facets.items()) worker.log.push_back(facet.slot);
    for (std::size_t n = worker.facets.size(); n < worker.cavity.size(); ++n) {
        worker.log.push_back(worker.cavity[n] >> 2);
    }
}

// New cells share a facet where theirs of the boundary share an edge: one has it forwards, the other
// backwards.
void DelaunayKernel::link_by_table(Worker& worker, std::vector<KernelCell>& cells) {
    const std::size_t width = worker.corners.size();
    if (worker.table.size() < width * width) worker.table.resize(width * width);
    for (const Worker::Facet& facet : worker.facets.items()) {
        const auto [a, b, c] = facet.corner;
        worker.table[b * width + c] = 4 * facet.slot + 1;
        worker.table[c * width + a] = 4 * facet.slot + 2;
        worker.table[a * width + b] = 4 * facet.slot + 3;
    }
    for (const Worker::Facet& facet : worker.facets.items()) {
        const auto [a, b, c] = facet.corner;
        KernelCell& cell = cells[facet.slot];
        cell.link[1] = worker.table[c * width + b];
        cell.link[2] = worker.table[a * width + c];
        cell.link[3] = worker.table[b * width + a];
    }
}

void DelaunayKernel::link_by_sorting(Worker& worker, std::vector<KernelCell>& cells) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> edges;
    edges.reserve(3 * worker.facets.size());
    for (const Worker::Facet& facet : worker.facets.items()) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint64_t b = facet.corner[(i + 1) % 3], c = facet.corner[(i + 2) % 3];
            edges.emplace_back(std::min(b, c) << 32 | std::max(b, c), 4 * facet.slot + 1 + i);
        }
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t n = 0; n < edges.size(); n += 2) {
        const std::uint32_t one = edges[n].second, two = edges[n + 1].second;
        assert(edges[n].first == edges[n + 1].first);
        cells[one >> 2].link[one & 3] = two;
        cells[two >> 2].link[two & 3] = one;
    }
}

template <bool bounded>
DelaunayKernel::Outcome DelaunayKernel::insert(Worker& worker, std::uint32_t vertex) {
    const Vec3 q = vertices_[vertex].position;
    std::uint32_t found = 0;
    Outcome located = locate<bounded>(worker, q, worker.last_cell, found);
    if (bounded && located == Outcome::deferred) {
        // The way from there leads through another region: there may be one from a cell nearer to q.
        const std::uint32_t nearer = worker.anchors.at(q);
        if (nearer != no_cell && cells_[nearer].alive()) located = locate<bounded>(worker, q, nearer, found);
    }
    if (located == Outcome::equal) vertices_[vertex].representative = found;
    if (located != Outcome::inserted) return located;
    if (!find_cavity<bounded>(worker, q, found)) return Outcome::deferred;
    if (worker.slots_at_hand() < worker.facets.size()) {
        if (bounded) {
            restore(worker);
            return Outcome::deferred;
        }
        // Fresh slots follow the array's end: grow it.
        const std::size_t grown = cells_.size() + worker.facets.size() + 1024;
        if (grown > most_slots) throw std::bad_alloc();
        cells_.resize(grown);
        worker.end_slot = static_cast<std::uint32_t>(grown);
    }
    find_corners(worker, q);
    make_cells(worker, vertex);
    worker.cells_made += worker.facets.size();
    if (logs_) log_changes(worker);
    worker.last_cell = worker.facets[0].slot;
    if (bounded) worker.anchors.at(q) = worker.last_cell;
    return Outcome::inserted;
}

// ---- Insertion by many threads ----

// Space in boxes, about as many of the given points in each.
struct DelaunayKernel::Regions {
    // The points below `at` on `axis` are in the regions [begin, middle), the others in [middle, end).
    struct Cut {
        int axis;
        double at;
        std::uint8_t begin, middle, end;
    };
    std::vector<Cut> cuts;  // those of a part before those of its parts

    Regions(std::vector<Vec3> points, int count) { cut(points, 0, static_cast<std::uint8_t>(count)); }

    std::uint8_t region(Vec3 p) const {
        std::uint8_t begin = 0, end = cuts.front().end;
        for (const Cut& c : cuts) {
            if (c.begin != begin || c.end != end) continue;
            (coordinate(p, c.axis) < c.at ? end : begin) = c.middle;
        }
        return begin;
    }

  private:
    static double coordinate(Vec3 p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

    static Vec3 squared_spread(std::span<const Vec3> points) {
        Vec3 mean, sum;
        const double share = 1 / static_cast<double>(points.size());
        for (const Vec3& p : points) mean += share * p;
        for (const Vec3& p : points) {
            const Vec3 d = share * (p - mean);
            sum += {d.x * d.x, d.y * d.y, d.z * d.z};
        }
        return sum;
    }

    // Cuts across the axis along which the points spread most - not across the box's longest, or points that
    // a cut left over would be cut in two by the same one again -; as deep as the logarithm of the number of
    // threads.
    void cut(std::span<Vec3> points, std::uint8_t begin, std::uint8_t end) {
        if (end - begin < 2) return;
        const Vec3 spread = squared_spread(points);
        const int axis = spread.x >= spread.y && spread.x >= spread.z ? 0 : spread.y >= spread.z ? 1 : 2;
        const std::uint8_t middle = static_cast<std::uint8_t>((begin + end) / 2);
        const std::size_t share = points.size() * (middle - begin) / (end - begin);
        const auto less = [axis](Vec3 a, Vec3 b) { return coordinate(a, axis) < coordinate(b, axis); };
        std::nth_element(points.begin(), points.begin() + share, points.end(), less);
        cuts.push_back({axis, coordinate(points[share], axis), begin, middle, end});
        cut(points.first(share), begin, middle);
        cut(points.subspan(share), middle, end);
    }
};

bool DelaunayKernel::in_region(const KernelCell& cell, std::uint8_t region) const {
    return std::all_of(cell.vertex.begin(), cell.vertex.end(), [&](std::uint32_t vertex) {
        return vertex == infinite_vertex || region_of_[vertex] == region;
    });
}

// Every thread inserts the points of its region and changes cells with all vertices in it, nothing else. The
// neighbour of such a cell shares a vertex with it, so no other thread changes it but for its link to another
// cell: what a thread reads is its own or at rest. Insertions that need more are deferred: `vertices` becomes
// those.
void DelaunayKernel::insert_in_regions(Worker& main, std::vector<std::uint32_t>& vertices, int threads) {
    const int count = std::min(threads, most_regions);
    std::vector<Vec3> points(vertices.size());
    std::transform(vertices.begin(), vertices.end(), points.begin(),
                   [&](std::uint32_t v) { return vertices_[v].position; });
    const Regions regions(std::move(points), count);
    region_of_.resize(vertices_.size());
    parallel_for(vertices_.size(), 1 << 14, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) region_of_[v] = regions.region(vertices_[v].position);
    });
    std::vector<std::vector<std::uint32_t>> inside(count), deferred(count);
    for (const std::uint32_t v : vertices) inside[region_of_[v]].push_back(v);

    std::vector<Worker> workers(count);
    std::size_t fresh = main.next_slot;
    for (int r = 0; r < count; ++r) {
        Worker& worker = workers[r];
        worker.region = static_cast<std::uint8_t>(r);
        worker.last_cell = no_cell;
        const std::size_t share = main.free_slots.size() / (count - r);
        worker.free_slots.assign(main.free_slots.end() - share, main.free_slots.end());
        main.free_slots.resize(main.free_slots.size() - share);
        worker.next_slot = static_cast<std::uint32_t>(fresh);
        const std::size_t wanted = slots_per_point * inside[r].size();
        if (wanted > share) fresh += wanted - share;
        if (fresh > most_slots) throw std::bad_alloc();
        worker.end_slot = static_cast<std::uint32_t>(fresh);
    }
    cells_.resize(fresh);
    drop_anchors(workers, threads);
    std::vector<std::size_t> starts(count);
    for (int r = 0; r < count; ++r) starts[r] = find_start(main, workers[r], inside[r]);

    parallel_for(count, 1, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) {
            Worker& worker = workers[r];
            const std::uint32_t anchor = worker.last_cell;
            const auto attempt = [&](std::uint32_t v) {
                if (insert<true>(worker, v) == Outcome::deferred) deferred[r].push_back(v);
            };
            if (anchor == no_cell) {
                deferred[r] = inside[r];
                continue;
            }
            // Onwards from the start, then from there backwards: the slot that held the first cell holds one
            // near it.
            for (std::size_t n = starts[r]; n < inside[r].size(); ++n) attempt(inside[r][n]);
            if (cells_[anchor].alive()) worker.last_cell = anchor;
            for (std::size_t n = starts[r]; n-- > 0;) attempt(inside[r][n]);
        }
    });

    vertices.clear();
    for (int r = 0; r < count; ++r) {
        Worker& worker = workers[r];
        vertices.insert(vertices.end(), deferred[r].begin(), deferred[r].end());
        main.free_slots.insert(main.free_slots.end(), worker.free_slots.begin(), worker.free_slots.end());
        main.log.insert(main.log.end(), worker.log.begin(), worker.log.end());
        main.cells_made += worker.cells_made;
        for (std::uint32_t slot = worker.end_slot; slot-- > worker.next_slot;)
            main.free_slots.push_back(slot);
        if (worker.last_cell != no_cell) main.last_cell = worker.last_cell;
    }
    main.next_slot = main.end_slot = static_cast<std::uint32_t>(fresh);
}

// Some of the cells in each worker's region, all over it.
void DelaunayKernel::drop_anchors(std::vector<Worker>& workers, int threads) const {
    // So many cells, all over the mesh, give the anchors of a worker. [cells; >= 1; B]
    constexpr std::size_t most_looked_at = 1 << 15;
    const std::size_t step = cells_.size() / most_looked_at + 1;
    parallel_for(workers.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) {
            Worker& worker = workers[r];
            worker.anchors = Anchors(box_);
            for (std::size_t slot = 0; slot < cells_.size(); slot += step) {
                const KernelCell& cell = cells_[slot];
                if (cell.alive() && in_region(cell, worker.region))
                    worker.anchors.at(vertices_[cell.vertex[0]].position) = static_cast<std::uint32_t>(slot);
            }
        }
    });
}

// A cell in the worker's region near one of its points, as its last cell; which point that is.
std::size_t DelaunayKernel::find_start(Worker& main, Worker& worker,
                                       std::span<const std::uint32_t> vertices) const {
    // So many of a worker's points are tried to find a cell in its region to start from. [points; >= 1; B]
    constexpr std::size_t tries = 32;
    for (std::size_t t = 0; t < tries; ++t) {
        const std::size_t n = vertices.size() * ((2 * t + tries) % (2 * tries) + 1) / (2 * tries);
        std::uint32_t found = 0;
        if (n >= vertices.size() ||
            locate<false>(main, vertices_[vertices[n]].position, main.last_cell, found) != Outcome::inserted)
            continue;
        main.last_cell = found;
        if (!in_region(cells_[found], worker.region)) continue;
        worker.last_cell = found;
        return n;
    }
    return 0;
}

// ---- Insertion of many ----

bool DelaunayKernel::insert(std::span<const Vec3> points, int threads, std::vector<std::uint32_t>& vertices) {
    const std::uint32_t first = vertex_count();
    assert(first + points.size() < infinite_vertex);
    const SpatialOrder spatial = spatial_order(points, first, threads);
    std::vector<std::uint32_t> round_begins;
    vertices.resize(points.size());
    for (std::size_t n = 0, r = 0; n <= points.size(); ++n) {
        for (; r < spatial.round_begins.size() && spatial.round_begins[r] == n; ++r)
            round_begins.push_back(vertex_count());
        if (n == points.size()) break;
        const std::uint32_t point = spatial.order[n];
        if (n == 0 || points[point] != points[spatial.order[n - 1]]) {
            vertices_.push_back({points[point], vertex_count(), 0});
            box_.extend(points[point]);
        }
        vertices[point] = vertex_count() - 1;
    }
    update_bounds();
    if (cells_.empty()) {
        cells_.reserve(10 * points.size());  // with what refinement adds
        if (!start(first)) {
            *this = DelaunayKernel();
            return false;
        }
    }

    Worker worker;
    worker.last_cell = last_cell_;
    worker.free_slots.swap(free_slots_);
    worker.next_slot = worker.end_slot = static_cast<std::uint32_t>(cells_.size());
    std::vector<std::uint32_t> round;
    for (std::size_t r = 0; r + 1 < round_begins.size(); ++r) {
        round.resize(round_begins[r + 1] - round_begins[r]);
        std::iota(round.begin(), round.end(), round_begins[r]);
        const bool fine = round_begins[r] >= fine_mesh * round.size();
        for (int pass = 0;
             pass < 2 && threads > 1 && round.size() >= (fine ? least_in_fine : least_for_threads); ++pass) {
            insert_in_regions(worker, round, threads);
        }
        for (const std::uint32_t vertex : round) insert<false>(worker, vertex);
    }
    cells_.resize(worker.next_slot);
    free_slots_.swap(worker.free_slots);
    log_.insert(log_.end(), worker.log.begin(), worker.log.end());
    cells_made_ += worker.cells_made;
    last_cell_ = worker.last_cell;

    for (std::uint32_t& vertex : vertices) vertex = vertices_[vertex].representative;
    return true;
}

}  // namespace anatomesh
