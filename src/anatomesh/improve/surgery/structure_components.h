// StructureComponents: by how many components an attempt at changing the mesh changes a structure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "anatomesh/base/disjoint_sets.h"
#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// Cells of a structure, or all others, that facets join are a connected component. Bare are those that no
// contour of the structure has a vertex of.
struct ComponentChange {
    std::ptrdiff_t all = 0, bare = 0;  // components after the attempt, less those before it
    // Cells of the small bare components after it that have a new vertex; both rising.
    std::vector<std::vector<std::uint32_t>> spurious;
    friend bool operator==(const ComponentChange&, const ComponentChange&) = default;
};

// Cells that stay connect each other before an attempt as they do after it. So the cells that changed are
// looked at, and which of the cells at their rim are connected by others that stay: from the rim one goes
// outwards in turns, until all ways but one have met or ended.
class StructureComponents {
  public:
    // Small: of at most `most_of_component` cells. Requires: both outlive this.
    StructureComponents(EditContext& edit, const ContourOwners& owners, std::size_t most_of_component)
        : edit_(edit), owners_(owners), most_of_component_(most_of_component) {}

    // Of the attempt that is going on, and the cells of a structure, or all others. New are vertices from
    // `first_new` on, added since the attempt began. Complexity: n log n in the changed cells, and linear in
    // what lies round them but for the largest component of it.
    ComponentChange change(std::uint32_t structure, bool inside, std::uint32_t first_new);

  private:
    static constexpr std::uint32_t none = 0xFFFFFFFFu;  // no group [1; -; D]

    // Cells that stay, found to be connected so far.
    struct Group {
        std::vector<std::uint32_t> cells;
        std::vector<std::uint32_t> front;  // of these, from `next` on, those whose neighbours are to be found
        std::size_t next = 0;
        bool has_drawn = false;  // vertices
        bool is_whole() const { return next == front.size(); }
    };
    struct Mark {  // of a cell
        std::uint32_t search = 0, group = none;
    };
    // Under the number of a changed cell, before the attempt or now.
    struct Node {
        Cell cell;
        bool is_in = false;  // whether there is a cell, one of those that are counted
        friend bool operator==(const Node&, const Node&) = default;
    };
    struct Components {
        std::ptrdiff_t all = 0, bare = 0;
        std::vector<std::vector<std::uint32_t>> spurious;
    };

    Node node_of(const Cell& cell, Region region) const {
        return {cell, cell[0] != no_cell && edit_.table->contains(region, structure_) == inside_};
    }
    bool has_drawn_vertex(const Cell& cell) const;
    void find_nodes();
    void start_groups();
    void grow_groups();
    void step(std::uint32_t group);
    void reach(std::uint32_t c, std::uint32_t group);
    void join_groups(std::uint32_t one, std::uint32_t other);
    // Sets of nodes and, after these, of groups.
    DisjointSets connected_by_groups();
    void connect_now(DisjointSets& sets) const;
    void connect_before(DisjointSets& sets) const;
    Components count(DisjointSets& sets, const std::vector<Node>& nodes, std::uint32_t first_new) const;

    EditContext& edit_;
    const ContourOwners& owners_;
    std::size_t most_of_component_;
    // Of the attempt that is looked at, or was last.
    std::uint32_t structure_ = 0;
    bool inside_ = false;
    std::vector<std::uint32_t> changed_;  // numbers of cells, rising; those at the rim are as they were
    std::vector<Node> before_, now_;      // of each
    std::uint32_t search_ = 0;
    std::vector<Mark> marks_;  // by cell: changed ones, but for the rim, have no group
    std::vector<Group> groups_;
    DisjointSets group_sets_{0};
};

}  // namespace anatomesh
