// EditMesh: a tetrahedral mesh with its adjacency, changed one small cavity at a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/model/prefetch.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// The other two corners of each of cell_edges, such that (i, j, k, l) is an even permutation: with a positive
// cell the vertices k, l run counter-clockwise seen against the direction from i to j.
inline constexpr std::array<std::array<int, 2>, 6> across_edges{
    {{2, 3}, {3, 1}, {1, 2}, {0, 3}, {2, 0}, {0, 1}}};

// The cells round an edge (a, b): cell n has the vertices a, b, ring[n], ring[n + 1], in positive order.
struct EdgeRing {
    std::uint32_t a = 0, b = 0;
    std::vector<std::uint32_t> cells, ring;
    bool closed = false;  // false when the edge lies on the hull of the mesh; then the ring is not complete
};

// Cells, and those to take their place.
struct CellExchange {
    std::vector<std::uint32_t> removed;
    std::vector<Cell> added;
    std::vector<Region> regions;       // of those added
    std::vector<std::uint32_t> slots;  // their numbers, once they are in the mesh
};

// Cells keep their numbers until they are removed; numbers of removed cells are used again.
// Memory: 40 bytes a cell beside the mesh. Not thread-safe: it keeps scratch space.
class EditMesh {
  public:
    // Requires: cells positive, `neighbors` theirs as cell_neighbors() gives them. Complexity: O(cells).
    EditMesh(TetMesh mesh, std::span<const std::uint32_t> neighbors);

    // The mesh without the removed cells, in the order of their numbers, and its `neighbors`. Points stay,
    // used or not. The same at any number of `threads`.
    TetMesh take(std::vector<std::uint32_t>& neighbors, int threads = 1) &&;

    std::size_t cell_count() const { return cells_.size(); }  // removed ones included
    std::size_t point_count() const { return points_.size(); }
    bool alive(std::uint32_t cell) const { return cells_[cell][0] != no_cell; }
    // Those not removed, rising. O(cells).
    std::vector<std::uint32_t> alive_cells() const {
        std::vector<std::uint32_t> alive_ones;
        for (std::uint32_t c = 0; c < cells_.size(); ++c) {
            if (alive(c)) alive_ones.push_back(c);
        }
        return alive_ones;
    }
    const Cell& cell(std::uint32_t c) const { return cells_[c]; }
    Region region(std::uint32_t c) const { return regions_[c]; }
    std::uint32_t neighbor(std::uint32_t c, int facet) const { return neighbors_[c][facet]; }
    Vec3 point(std::uint32_t v) const { return points_[v]; }

    void move_point(std::uint32_t v, Vec3 to) {
        if (noted_) notes_.push_back({Note::moved, v, points_[v], 0, {}, {}});
        points_[v] = to;
    }
    std::uint32_t add_point(Vec3 p);
    void set_region(std::uint32_t c, Region region) {
        if (noted_) notes_.push_back({Note::given, c, {}, regions_[c], {}, {}});
        regions_[c] = region;
    }

    // From begin_attempt() to end_attempt() changes are noted, and taken back at the end if they are not to
    // be kept: then points, cells, regions and the numbers of cells are what they were, but for points added,
    // which stay unused. Requires: no replace_apart() in between. Complexity: linear in what has changed.
    void begin_attempt() { noted_ = true; }
    void end_attempt(bool keep);
    // Cells that were made, reshaped, removed or given another region since begin_attempt(), and those that
    // share a facet with one of these now; rising. Only cells among them differ in shape, region or
    // neighbours from what they were. Complexity: n log n in them.
    std::vector<std::uint32_t> changed_cells();
    // What was under these numbers, rising, when the attempt began. Requires: the numbers are those of
    // changed_cells(). Complexity: n log n in them.
    struct CellState {
        Cell cell;  // [0] is no_cell where there was no cell
        Region region;
        friend bool operator==(const CellState&, const CellState&) = default;
    };
    std::vector<CellState> states_before(std::span<const std::uint32_t> cells) const;

    // All cells at a vertex, in an order that depends on the mesh alone. Complexity: linear in them.
    void star(std::uint32_t v, std::vector<std::uint32_t>& cells);
    // The same for several threads at a time, as long as nothing changes. Complexity: quadratic in them.
    void shared_star(std::uint32_t v, std::vector<std::uint32_t>& cells) const;

    // What is read of a cell, and of those beside it and its points, is brought into the cache. Changes
    // nothing.
    void prefetch(std::uint32_t c) const {
        __builtin_prefetch(&cells_[c]);
        __builtin_prefetch(&neighbors_[c]);
    }
    void prefetch_points(std::uint32_t c) const {
        if (alive(c)) anatomesh::prefetch_points(points_, cells_[c]);
    }
    void prefetch_round(std::uint32_t c) const {
        prefetch_points(c);
        for (const std::uint32_t n : neighbors_[c]) {
            if (n != no_cell) prefetch(n);
        }
    }

    // The cells round edge `e` of cell_edges of a cell.
    void ring(std::uint32_t c, int e, EdgeRing& ring) const;

    // Whether the cells at an edge, or at a vertex, lie in more than one region.
    bool edge_on_interface(std::uint32_t c, int e) const;
    bool vertex_on_interface(std::uint32_t v);

    // Puts `added` into the place of `removed`. Requires: the same outer facets. Complexity: k log k.
    // `slots` receives the numbers of the added cells.
    void replace(std::span<const std::uint32_t> removed, std::span<const Cell> added,
                 std::span<const Region> regions, std::vector<std::uint32_t>& slots);

    // Does the exchanges, several at the same time, but for those that share a vertex with one that is done
    // and comes before. Returns for each whether it was done. Guarantees: the same for any `threads`.
    // Requires: as replace(); the vertices of the cells removed are those of the cells added.
    std::vector<std::uint8_t> replace_apart(std::span<CellExchange> exchanges, int threads);

    // So many cells were put in the place of others so far, those taken back included.
    std::uint64_t cells_made() const { return cells_made_; }

  private:
    struct Side {
        std::array<std::uint32_t, 3> facet;  // sorted vertices
        std::uint32_t cell;
        int index;
    };
    // What was before a change: a point, a region, or the cells that others took the place of.
    struct Note {
        enum Kind : std::uint8_t { moved, given, replaced } kind;
        std::uint32_t index;
        Vec3 point;
        Region region;
        std::vector<std::uint32_t> slots;  // of the cells added
        CellExchange before;               // the cells removed, with their numbers and regions
    };
    void take_back(const Note& note);

    // The numbers that cells get which take the place of `removed`; those left over are free afterwards.
    void take_slots(std::span<const std::uint32_t> removed, std::size_t added,
                    std::vector<std::uint32_t>& slots);
    void free_slots(std::span<const std::uint32_t> removed, std::size_t added);
    // Writes to the cells in question and those beside them, and to nothing else.
    void put(std::span<const std::uint32_t> removed, std::span<const Cell> added,
             std::span<const Region> regions, std::span<const std::uint32_t> slots, std::vector<Side>& sides);
    std::uint32_t next_round(std::uint32_t c, std::uint32_t a, std::uint32_t b, std::uint32_t leave,
                             std::uint32_t keep, std::uint32_t& fresh) const;

    std::vector<Vec3> points_;
    std::vector<Cell> cells_;
    std::vector<Region> regions_;
    std::vector<std::array<std::uint32_t, 4>> neighbors_;
    std::vector<std::uint32_t> cell_of_;  // by vertex: one cell at it, no_cell if none
    std::vector<std::uint32_t> free_;     // numbers of removed cells
    std::vector<std::uint32_t> mark_;     // by cell; equal to stamp_ = seen
    std::uint32_t stamp_ = 0;
    std::uint64_t cells_made_ = 0;
    std::vector<std::uint32_t> scratch_;
    std::vector<Side> sides_;
    bool noted_ = false;
    std::vector<Note> notes_;
};

}  // namespace anatomesh
