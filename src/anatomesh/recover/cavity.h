// Cavity: cells of a mesh that are to give way to those which one point makes with the facets round them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/mesh/edit/edit_mesh.h"
#include "anatomesh/sample/contour_segments.h"

namespace anatomesh {

using MeshEdge = std::array<std::uint32_t, 2>;  // the lower vertex first

// What must stay while cells are exchanged: vertices, and edges between such if they are there.
class KeptEdges {
  public:
    // `edges` in any order, repeats allowed. `fixed`: by vertex.
    KeptEdges(std::vector<std::uint8_t> fixed, std::vector<MeshEdge> edges);

    bool fixed(std::uint32_t v) const { return v < fixed_.size() && fixed_[v]; }
    bool has(std::uint32_t a, std::uint32_t b) const;
    void fix(std::uint32_t v);
    // Complexity: linear in the edges.
    void add(std::uint32_t a, std::uint32_t b);

  private:
    std::vector<std::uint8_t> fixed_;
    std::vector<MeshEdge> edges_;  // sorted
};

// Every facet must see the point, by exact orientation: then the cells that it makes with them fill the
// cavity exactly, and are all positive. The shape of a cell goes from 0 (flat) to 1 (good enough): the least
// sine of its dihedral angles against that of 15 degrees, or twice the shortest edge against the
// circumradius, whichever is less. Nothing of the mesh changes but by fill(). Follows: George, Hecht and
// Saltel, Comput. Methods Appl. Mech. Eng. 92, 1991; growing for shape: Klingner and Shewchuk, Proc. 16th
// International Meshing Roundtable, 2007.
class Cavity {
  public:
    // Requires: both outlive this.
    Cavity(EditMesh& mesh, const KeptEdges& kept) : mesh_(mesh), kept_(kept) {}

    // An apex that is a vertex already, or none yet (no_cell) and at p.
    struct Apex {
        std::uint32_t vertex = no_cell;
        Vec3 p{};
    };

    // Takes these cells. Requires: joined by facets; the apex in them or on their boundary.
    void reset(std::span<const std::uint32_t> cells, Apex apex);

    // Takes in cells until every facet sees the apex, then those behind facets that make bad cells with it
    // where that makes better ones. False where the first fails, or something kept would go. Complexity:
    // quadratic in the cells, of which there are at most 150.
    bool open();

    // The shape of the worst cell that it would make.
    double worst() const;

    // Exchanges the cells for new ones in undecided_region. Returns the apex's vertex. Requires: open().
    std::uint32_t fill();

    const std::vector<std::uint32_t>& cells() const { return cells_; }
    // The new ones, after fill().
    const std::vector<std::uint32_t>& filled() const { return slots_; }

  private:
    struct Facet {
        std::array<std::uint32_t, 3> v;  // counter-clockwise seen from outside
        std::uint32_t beyond;
        double value;  // of the cell with the apex; 2 where it has the apex as a corner
    };
    // A cavity takes no more cells, so that opening it takes little time. [cells; >= 1; B]
    static constexpr std::size_t most_cells = 150;

    bool holds(std::uint32_t c) const { return c != no_cell && c < stamp_.size() && stamp_[c] == now_; }
    Facet facet(std::uint32_t c, int i);
    double value(const std::array<std::uint32_t, 3>& v) const;
    bool sees(const Facet& f) const;
    void take(std::uint32_t c);
    bool take_better(const Facet& f);
    bool see_all();
    bool keeps(std::span<const std::uint32_t> cells) const;

    EditMesh& mesh_;
    const KeptEdges& kept_;
    Apex apex_;
    std::vector<std::uint32_t> cells_, slots_;
    std::vector<Facet> facets_;
    std::vector<std::uint32_t> stamp_;  // by cell; equal to now_: in the cavity
    std::uint32_t now_ = 0;
};

// New cells have it until they get their own. [region; 2^16 - 3; D]
inline constexpr Region undecided_region = 0xFFFD;

// Gives the mesh back; returns its cells that have no region yet, rising.
std::vector<std::uint32_t> take_with_undecided(EditMesh&& edited, TetMesh& mesh,
                                               std::vector<std::uint32_t>& neighbors);

// The subsegments, their ends, and `fixed` vertices (by number) besides.
KeptEdges kept_edges(const std::vector<std::uint8_t>& fixed, const std::vector<Subsegment>& subsegments);

}  // namespace anatomesh
