// EditContext: the mesh under improvement, what must not change, and the rules by which a change is accepted.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/improve/core/acceptance_rule.h"
#include "anatomesh/improve/core/edit_constraints.h"
#include "anatomesh/improve/core/local_star.h"
#include "anatomesh/improve/core/mesh_improvement_options.h"
#include "anatomesh/mesh/edit/edit_mesh.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

// A change that an operation on a speculative context would make: cells exchanged, or a vertex moved.
struct Proposal {
    CellExchange cells;
    std::uint32_t vertex = no_cell;  // the vertex that moves, if any
    Vec3 to;                         // its new place
    // If any: a cell one edge of which must not be an edge of an interface. A local-only context cannot see
    // that.
    std::uint32_t lone = no_cell;
    int lone_edge = 0;
    std::uint64_t OperationCounts::*counter =
        nullptr;  // counts changes of this kind; null: there is no change
};

// How a context evaluates operations on one of several threads.
struct Speculation {
    // The context leaves the mesh as it is: removals and moves say true where they may succeed, and false
    // only where they would fail. Each thread may have one copy of a context.
    bool active = false;
    // Active, and the context looks at no cells but those with a vertex of the cell, or the vertex, in
    // question: what fails on it does so as long as these cells stay.
    bool local_only = false;
    Proposal proposal;  // the last change that would have been made
};

// Lists that operations fill anew each time, so that they allocate nothing.
struct EditScratch {
    LocalStar local;
    std::vector<std::uint32_t> others;  // a second star
    std::vector<Cell> cells;            // new cells
    std::vector<Region> regions;        // their regions
};

// The operations (operations.h) propose cavities; the edit context knows whether they gain and puts them in.
class EditContext {
  public:
    // Requires: mesh, field, and what the constraints refer to outlive this.
    EditContext(EditMesh& mesh, const EditConstraints& constraints, const StructureField& field,
                std::uint32_t structures, const MeshImprovementOptions& options);
    EditContext(EditMesh& mesh_in, std::vector<std::uint8_t>& fixed, std::span<const VertexPair> fixed_edges,
                const StructureField& field, std::uint32_t structures,
                const MeshImprovementOptions& options_in)
        : EditContext(mesh_in, EditConstraints(fixed, fixed_edges), field, structures, options_in) {}

    EditMesh& mesh;
    const RegionTable* table = nullptr;  // of the mesh's regions
    const DrawnSlices* drawn = nullptr;  // required where the rule guards sections or spares limited cells
    EditConstraints constraints;
    InterfaceProbe probe;
    MeshImprovementOptions options;
    AcceptanceRule rule;
    double goal = 0;  // a sine that is good enough: operations seek no better one
    MeshImprovementStats stats;
    Speculation speculation;
    std::vector<std::uint32_t> changed;  // cells that the last operation made or reshaped
    std::vector<std::uint32_t> star;     // of the vertex, and
    EdgeRing ring;                       // of the edge, that an operation looks at
    EditScratch scratch;

    std::uint32_t add_point(Vec3 p) {
        constraints.add_free_vertex();
        return mesh.add_point(p);
    }
    // Fixes a vertex on a fixed edge, which becomes two.
    void fix_on_edge(std::uint32_t v, std::uint32_t a, std::uint32_t b);
    // Whether the rule guards sections, and a facet between two regions lies in the plane of a slice, so that
    // the section there has the structures of both, and these are not what is drawn there.
    bool spoils_section(std::uint32_t a, std::uint32_t b, std::uint32_t c, Region above, Region below);

    double sine(const Cell& c) const;
    double sine(std::uint32_t c) const { return sine(mesh.cell(c)); }

    // Whether a cell of this region, and with these vertices among its own, is to be well shaped.
    bool counts(Region region, std::span<const std::uint32_t> vertices) const {
        return region != 0 && !(rule.spares_limited && drawn->are_constraint_limited(vertices));
    }

    QualityThreshold threshold_of(std::span<const std::uint32_t> cells) const;
    // The sine of a new cell, negative if it may not be; cells outside that may be count as perfect.
    double value(const Cell& c, Region region, const QualityThreshold& threshold) const;

    // Replaces cells by others of the same outer facets if all are positive, exactly, and all kept edges
    // stay.
    bool commit(std::span<const std::uint32_t> removed, std::span<const Cell> added,
                std::span<const Region> regions);

    // Puts a vertex, which it returns, on the edge of `ring`, near its line: each of the cells round it
    // becomes two. Returns no_cell if one of them would not be positive. A fixed edge becomes two.
    std::uint32_t split_ring(Vec3 at);

    // Moves a vertex, `star` the cells at it, if all of these stay positive, exactly.
    bool commit_move(std::uint32_t v, Vec3 to);
    // Makes the change that a speculative context proposed, if it may be. Requires: what that context looked
    // at is as it was.
    bool carry_out(const Proposal& change);
    void count(std::uint64_t OperationCounts::*counter) {
        ++(stats.operations.*counter);
        speculation.proposal.counter = counter;
    }

    bool positive(std::span<const std::uint32_t> cells) const;  // exactly

    // From now on the probe knows the surfaces between these regions alone.
    void look_between(Region here, Region there);
    // Distance of a facet's centroid from the surfaces that the probe knows, mm.
    double facet_distance(Vec3 a, Vec3 b, Vec3 c) { return probe.distance((1.0 / 3.0) * (a + b + c)); }

  private:
    SliceVertices slice_vertices_;
};

// The other two corners of a cell's facet at a vertex, in the facet's order.
std::array<std::uint32_t, 2> others_of_facet(const Cell& cell, int facet, std::uint32_t vertex);

// The facets of the only surface at a vertex, seen from the region of the first cell of `context.star`, which
// is the vertex's star: of each the two others, in its order; the context looks between the two regions.
// False where three or more regions meet, or the mesh ends.
bool surface_facets_at(EditContext& edit, std::uint32_t vertex,
                       std::vector<std::array<std::uint32_t, 2>>& facets);

}  // namespace anatomesh
