// EditContext: the mesh under improvement, what must not change, and the rules by which a change is accepted.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/improve/core/dihedral_options.h"
#include "anatomesh/improve/core/local_star.h"
#include "anatomesh/mesh/edit/edit_mesh.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

// What the cells of a cavity are now; their successors must be better.
struct QualityThreshold {
    double sine = 1;           // the worst inside
    double outside_sine = 1;   // the worst outside
    double squared_ratio = 0;  // the largest inside
};

// A change that an operation on a speculative context would make: cells exchanged, or a vertex moved.
struct Proposal {
    CellExchange cells;
    std::uint32_t vertex = no_cell;  // if any
    Vec3 to;                         // its new place
    std::uint32_t lone = no_cell;    // if any: a cell one edge of which must not be an edge of an interface;
    int lone_edge = 0;               // what a local-only context leaves to be looked at
    std::uint64_t DihedralStats::*counter = nullptr;
};

// The operations (operations.h) propose cavities; the edit context knows whether they gain and puts them in.
class EditContext {
  public:
    EditContext(EditMesh& mesh, std::vector<std::uint8_t>& fixed, std::span<const VertexPair> fixed_edges,
                const StructureField& field, std::uint32_t structures, const DihedralOptions& options);

    EditMesh& mesh;
    InterfaceProbe probe;
    DihedralOptions options;
    DihedralStats stats;
    const RegionTable* table = nullptr;   // of the mesh's regions
    const DrawnSlices* slices = nullptr;  // if any: no operation makes their cuts less like what is drawn
    // A copy of a context that is speculative leaves the mesh as it is: removals and moves say true where
    // they may succeed, false only where they would fail. Each thread may have one.
    bool speculative = false;
    // Speculative, and it looks at no cells but those with a vertex of the cell, or the vertex, in question:
    // what fails on such a context does so as long as these cells stay.
    bool local_only = false;
    Proposal proposal;             // if speculative: the last change that would have been made
    bool moves_junctions = false;  // vertices where three or more regions meet may move
    // If any: the shapes of cells at its constraint-limited vertices count as little as those of cells
    // outside.
    const DrawnSlices* spared = nullptr;
    bool lowers_ratios = false;  // operations are judged by the largest ratio, not by the least sine
    // The least sine of new cells; of those judged by ratio also the least there was, if that is not below
    // least_lowered_sine, and no ratio above most_lowered_ratio.
    double least_needed_sine = 0, least_lowered_sine = 0, most_lowered_ratio = HUGE_VAL;
    double goal = 0;                     // sine that is good enough
    std::vector<std::uint32_t> changed;  // cells that the last operation made or reshaped

    bool fixed(std::uint32_t v) const { return fixed_[v] != 0; }
    bool fixed_edge(std::uint32_t a, std::uint32_t b) const;
    std::uint32_t add_point(Vec3 p) {
        fixed_.push_back(0);
        return mesh.add_point(p);
    }

    void fix(std::uint32_t v) { fixed_[v] = 1; }
    void unfix(std::uint32_t v) { fixed_[v] = 0; }
    // Fixed too, but for repair_section_locally(), which may move it once more.
    void settle(std::uint32_t v) { fixed_[v] = settled_once; }
    bool settled(std::uint32_t v) const { return fixed_[v] == settled_once; }
    void fix_edge(std::uint32_t a, std::uint32_t b);
    // Takes one fix_edge() back.
    void unfix_edge(std::uint32_t a, std::uint32_t b);
    // A point on a fixed edge, which becomes two.
    void fix_on_edge(std::uint32_t v, std::uint32_t a, std::uint32_t b);

    void keep_edge(std::uint32_t a, std::uint32_t b);  // whole, wherever it lies, until it is released
    void release_edge(std::uint32_t a, std::uint32_t b);
    void release_edges() { kept_edges_.clear(); }  // all
    bool keeps_edge(std::uint32_t a, std::uint32_t b) const;
    // Whether a facet between two regions lies in the plane of one of `slices`, so that the cut there has the
    // structures of both, and these are not what is drawn there.
    bool spoils_cut(std::uint32_t a, std::uint32_t b, std::uint32_t c, Region above, Region below);

    double sine(const Cell& c) const;
    double sine(std::uint32_t c) const { return sine(mesh.cell(c)); }

    // Whether a cell of this region, and with these vertices among its own, is to be well shaped.
    bool counts(Region region, std::span<const std::uint32_t> vertices) const {
        return region != 0 && !(spared && spared->are_constraint_limited(vertices));
    }

    QualityThreshold threshold_of(std::span<const std::uint32_t> cells) const;
    // What a new cell must reach.
    double needed_sine(const QualityThreshold& threshold) const {
        if (lowers_ratios) return std::max(std::min(threshold.sine, least_needed_sine), least_lowered_sine);
        return std::max(threshold.sine + min_gain * (0.02 + threshold.sine), least_needed_sine);
    }
    double needed_outside_sine(const QualityThreshold& threshold) const {
        return std::min(threshold.outside_sine, flat_outside);
    }
    double allowed_squared_ratio(const QualityThreshold& threshold) const {
        return allowed_squared_ratio(threshold, options.max_radius_edge);
    }
    double allowed_squared_ratio(const QualityThreshold& threshold, double most) const {
        if (!lowers_ratios) return std::max(threshold.squared_ratio, most * most);
        return std::max(
            std::min(lower_ratio * threshold.squared_ratio, most_lowered_ratio * most_lowered_ratio),
            most * most);
    }
    // The sine of a new cell, negative if it may not be; cells outside that may be count as perfect.
    double value(const Cell& c, Region region, const QualityThreshold& threshold) const;

    // Replaces cells by others of the same outer facets if all are positive, exactly, and all kept edges
    // stay.
    bool commit(std::span<const std::uint32_t> removed, std::span<const Cell> added,
                std::span<const Region> regions);

    // Puts a vertex, which it returns, on the edge of `ring`, near its line: each of the cells round it
    // becomes two. no_cell, if one of them would not be positive. What was fixed is fixed on.
    std::uint32_t split_ring(Vec3 at);

    // Moves a vertex, `star` the cells at it, if all of these stay positive, exactly.
    bool commit_move(std::uint32_t v, Vec3 to);
    // Makes the change that a speculative context proposed, if it may be; what it looked at is as it was.
    bool carry_out(const Proposal& change);
    void count(std::uint64_t DihedralStats::*counter) {
        ++(stats.*counter);
        proposal.counter = counter;
    }

    bool positive(std::span<const std::uint32_t> cells) const;  // exactly

    // From now on the probe knows the surfaces between these regions alone.
    void look_between(Region here, Region there);
    // Whether a facet of these surfaces lies near enough to the field's: its centroid within the bound, or
    // not farther than `before`.
    bool near_interface(std::uint32_t a, std::uint32_t b, std::uint32_t c, double before);
    double facet_distance(Vec3 a, Vec3 b, Vec3 c) { return probe.distance((1.0 / 3.0) * (a + b + c)); }

    // Scratch space of the operations.
    EdgeRing ring;
    LocalStar local;
    std::vector<std::uint32_t> star, cavity, others;
    std::vector<Cell> cells;
    std::vector<Region> regions;

  private:
    std::uint32_t slice_of(std::uint32_t v) const;
    bool loses_kept_edge(std::span<const std::uint32_t> removed, std::span<const Cell> added) const;

    static constexpr std::uint8_t settled_once = 2;
    static constexpr double min_gain = 0.02;
    static constexpr double flat_outside = 0.01;
    static constexpr double lower_ratio = 0.8;  // squared

    std::vector<std::uint8_t>& fixed_;
    std::span<const VertexPair> fixed_edges_;
    // Sorted: those that fixed edges were split into; those that stay, of which all ends are fixed; points on
    // fixed edges in a slice, and the slice.
    std::vector<VertexPair> split_edges_, kept_edges_, points_of_slices_;
};

// The other two corners of a cell's facet at a vertex, in the facet's order.
std::array<std::uint32_t, 2> others_of_facet(const Cell& cell, int facet, std::uint32_t vertex);

// The facets of the only surface at a vertex, seen from the region of the first cell of `context.star`, which
// is the vertex's star: of each the two others, in its order; the context looks between the two regions.
// False where three or more regions meet, or the mesh ends.
bool surface_facets_at(EditContext& edit, std::uint32_t vertex,
                       std::vector<std::array<std::uint32_t, 2>>& facets);

}  // namespace anatomesh
