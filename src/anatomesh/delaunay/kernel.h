// DelaunayKernel: the Delaunay tetrahedralization itself, of points that come in batches.
//
// Cells lie in one array, 64 bytes each: vertices, links, and the form that tells by one scalar product
// whether a point is in conflict with the cell. Every hull facet has a ghost cell, whose fourth vertex is at
// infinity: so every cell has four neighbours, and a point outside is inserted like any other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Guarantees: cells() holds the one Delaunay tetrahedralization of the perturbed points
// (in_perturbed_sphere): a function of the set of points, whatever their order, their batches and the number
// of threads. Which slot holds which cell depends on all of them. Complexity: expected O(n log n) for points
// that fill space, with O(1) tests a cell. Follows: Bowyer, Comput. J. 24, 1981; Watson, Comput. J. 24, 1981;
// Devillers, Pion and Teillaud, IJFCS 13, 2002 (walk); Marot, Pellerin and Remacle, IJNME 117, 2019 (forms
// kept with the cells; regions for threads); Devillers and Teillaud, Comput. Geom. 44, 2011 (ties).
class DelaunayKernel {
  public:
    // The vertex of all ghost cells. [index; 0x7FFFFFFF; D]
    // It is the vertex of all ghost cells. [index; 2^31 - 1; D]
    static constexpr std::uint32_t infinite_vertex = 0x7FFFFFFFu;
    // Set in vertex[0] of a slot that holds no cell. [bit; 0x80000000; D]
    static constexpr std::uint32_t removed = 0x80000000u;

    // Positive: finite vertices as in mesh/model/tet_mesh.h; a ghost cell would be positive with any point outside
    // the hull in the place of the infinite vertex. vertex[0] is finite.
    struct alignas(64) KernelCell {
        std::array<std::uint32_t, 4> vertex{removed, 0, 0, 0};
        std::array<std::uint32_t, 4> link;  // 4 * neighbour + its facet, across the facet opposite vertex i
        Vec3
            normal;  // q is in conflict where dot(normal, q - v0) + lift * |q - v0|^2 > 0, v0 being vertex[0]
        double lift;

        bool alive() const { return !(vertex[0] & removed); }
        int infinite_place() const;  // of the infinite vertex, -1 in a finite cell
    };

    // Adds points. vertices[i] is the vertex of points[i]; equal points have one vertex. Vertices are
    // numbered from 0 upwards over all batches; a number may remain unused. False, with nothing kept, while
    // all points so far lie in one plane. Requires: finite points; fewer than 2^31 - 1 over all batches.
    bool insert(std::span<const Vec3> points, int threads, std::vector<std::uint32_t>& vertices);

    std::uint32_t vertex_count() const {
        return static_cast<std::uint32_t>(vertices_.size());
    }  // unused numbers too
    std::span<const KernelCell> cells() const { return cells_; }
    // So many cells were made so far, those that went again included.
    std::uint64_t cells_made() const { return cells_made_; }

    // The slots whose cells were made or removed since start_log() was called last; a slot may come up more
    // than once. None before the first call.
    void start_log() {
        logs_ = true;
        log_.clear();
    }
    std::span<const std::uint32_t> log() const { return log_; }

  private:
    struct Worker;   // what one thread needs to insert points
    struct Anchors;  // cells of a region from which walks may start
    struct Regions;  // of space, one for each thread
    struct Corner;   // a vertex of a new cell as seen from the new point
    struct alignas(32) Vertex {
        Vec3 position;
        std::uint32_t representative;  // itself, or the vertex equal to it
        std::uint32_t scratch;         // its place among the corners of the cavity it was last on
    };
    enum class Outcome { inserted, equal, deferred };

    bool start(std::uint32_t first);
    void update_bounds();
    Corner corner(std::uint32_t vertex, Vec3 origin) const;
    static void set_form(KernelCell& cell, const Corner& a, const Corner& b, const Corner& c);

    double form_value(const KernelCell& cell, Vec3 q) const;
    bool conflicts(const KernelCell& cell, Vec3 q) const;
    bool conflicts_nearly(const KernelCell& cell, Vec3 q, double value) const;
    bool conflicts_exactly(const KernelCell& cell, Vec3 q) const;
    bool in_region(const KernelCell& cell, std::uint8_t region) const;

    // The steps of an insertion. One that `bounded` is true for stays in the worker's region and its slots,
    // or is deferred.
    template <bool bounded>
    Outcome insert(Worker& worker, std::uint32_t vertex);
    template <bool bounded>
    Outcome locate(Worker& worker, Vec3 q, std::uint32_t from, std::uint32_t& found) const;
    template <bool bounded>
    bool find_cavity(Worker& worker, Vec3 q, std::uint32_t first);
    void prefetch_neighbors(const KernelCell& cell) const;
    void restore(Worker& worker);
    void find_corners(Worker& worker, Vec3 q);
    void make_cells(Worker& worker, std::uint32_t vertex);
    void log_changes(Worker& worker) const;
    static void link_by_table(Worker& worker, std::vector<KernelCell>& cells);
    static void link_by_sorting(Worker& worker, std::vector<KernelCell>& cells);

    void insert_in_regions(Worker& main, std::vector<std::uint32_t>& vertices, int threads);
    void drop_anchors(std::vector<Worker>& workers, int threads) const;
    std::size_t find_start(Worker& main, Worker& worker, std::span<const std::uint32_t> vertices) const;

    std::vector<Vertex> vertices_;
    std::vector<KernelCell> cells_;
    std::vector<std::uint8_t> region_of_;  // of each vertex, while regions are in use
    std::vector<std::uint32_t> free_slots_;
    std::uint32_t last_cell_ = 0;  // where the next search starts
    std::uint64_t cells_made_ = 0;
    std::vector<std::uint32_t> log_;
    bool logs_ = false;
    Box3 box_;
    double orient_bound_ = 0, conflict_bound_ = 0, underflow_bound_ = 0;
    double ghost_scale_ = 0;  // of the forms of ghost cells, so that one bound serves both kinds
};

}  // namespace anatomesh
