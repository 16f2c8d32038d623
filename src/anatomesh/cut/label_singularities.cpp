#include "anatomesh/cut/label_singularities.h"

#include "anatomesh/base/sort_distinct.h"

namespace anatomesh {

LabelSingularities::LabelSingularities(const RelabelledMesh& mesh)
    : mesh_(mesh),
      analyzer_(mesh.cells, mesh.neighbors, mesh.stars, mesh.regions, mesh.registry.table(), mesh.owners),
      known_(mesh.points.size()) {}

const LabelSingularities::Counts& LabelSingularities::counts_at(std::uint32_t vertex) {
    Counts& known = known_[vertex];
    if (known.singularity_count < 0)
        known = {analyzer_.singularity_count(vertex), analyzer_.lost_subsegment_count(vertex)};
    return known;
}

void LabelSingularities::relabel_cell(std::uint32_t cell, Region region) {
    mesh_.regions[cell] = region;
    for (const std::uint32_t v : mesh_.cells[cell]) known_[v].singularity_count = -1;
}

int LabelSingularities::change_of(LabelMove& move, int enough) {
    vertices_of_cells(mesh_.cells, move.cells, around_);
    move.change = move.lost = 0;
    const auto add = [&](int count, int lost, int times) {
        move.lost += times * lost;
        move.change += times * (weight * count + lost);
    };
    for (const std::uint32_t v : around_) add(singularity_count(v), lost_subsegments(v), -1);
    before_.clear();
    for (const std::uint32_t c : move.cells) {
        before_.push_back(mesh_.regions[c]);
        mesh_.regions[c] = move.region;
    }
    for (const std::uint32_t v : around_) {
        if (move.change >= enough) break;  // it only rises from here on
        add(analyzer_.singularity_count(v), analyzer_.lost_subsegment_count(v), 1);
    }
    for (std::size_t n = 0; n < move.cells.size(); ++n) mesh_.regions[move.cells[n]] = before_[n];
    return move.change;
}

void vertices_of_cells(const std::vector<Cell>& cells, const std::vector<std::uint32_t>& chosen,
                       std::vector<std::uint32_t>& vertices) {
    vertices.clear();
    for (const std::uint32_t c : chosen) vertices.insert(vertices.end(), cells[c].begin(), cells[c].end());
    sort_distinct(vertices);
}

}  // namespace anatomesh
