// LabelSingularities: the singularity counts of a mesh's vertices while cells change their regions.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/cut/relabel.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

// Cells that go to one region together, and what comes of it.
struct LabelMove {
    std::vector<std::uint32_t> cells;
    Region region = 0;
    int change = 0;     // of the weighted sum of singularity counts; negative is better
    int lost = 0;       // change of the number of ends of subsegments that are lost
    int misplaced = 0;  // change of the number of vertices, cell by cell, that the field has on another side
    int spikes = 0;     // change of the number of vertices deep in a region that have a cell of another one
    double spoiled =
        0;  // by how much more of the cross-sections is other than drawn: as DrawnSections::change()
};

// Counts are found when they are asked for and kept until a cell at the vertex changes: most are asked for again and
// again by moves that are not made. Requires: all of the mesh but its regions stays, and regions change through this
// class alone. Not thread-safe.
class LabelSingularities {
  public:
    // One surplus component weighs as much as so many ends of lost subsegments: a manifold comes first.
    // [1; > 1; D]
    static constexpr int weight = 256;

    explicit LabelSingularities(const RelabelledMesh& mesh);

    int singularity_count(std::uint32_t vertex) { return counts_at(vertex).singularity_count; }
    int lost_subsegments(std::uint32_t vertex) { return counts_at(vertex).lost_subsegments; }
    // The vertex's part of the weighted sum.
    int total(std::uint32_t vertex) { return weight * singularity_count(vertex) + lost_subsegments(vertex); }

    void relabel_cell(std::uint32_t cell, Region region);

    // Fills move.change and move.lost and returns the first. A change of `enough` or more may be a part of it.
    int change_of(LabelMove& move, int enough);

    StarAnalyzer& analyzer() { return analyzer_; }

  private:
    struct Counts {
        int singularity_count = -1, lost_subsegments = 0;  // singularity_count below 0: not known
    };
    const Counts& counts_at(std::uint32_t vertex);

    const RelabelledMesh& mesh_;
    StarAnalyzer analyzer_;
    std::vector<Counts> known_;          // by vertex
    std::vector<std::uint32_t> around_;  // scratch
    std::vector<Region> before_;         // scratch
};

// The vertices of the cells, rising and without repeats, replace `vertices`.
void vertices_of_cells(const std::vector<Cell>& cells, const std::vector<std::uint32_t>& chosen,
                       std::vector<std::uint32_t>& vertices);

}  // namespace anatomesh
