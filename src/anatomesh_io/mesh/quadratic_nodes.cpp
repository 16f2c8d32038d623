#include "anatomesh_io/mesh/quadratic_nodes.h"

#include "anatomesh_io/mesh/mesh_text.h"

namespace anatomesh {

Status split_mid_nodes(ModelFile& model, std::vector<std::array<std::uint32_t, 6>> six,
                       const std::string& path) {
    std::vector<Vec3>& points = model.mesh.points;
    std::vector<std::uint8_t> is_mid(points.size(), 0);
    for (const auto& mids : six) {
        for (const std::uint32_t n : mids) is_mid[n] = 1;
    }
    for (std::size_t c = 0; c < model.mesh.cells.size(); ++c) {
        for (const std::uint32_t n : model.mesh.cells[c]) {
            if (!is_mid[n]) continue;
            return mesh_error("E-MDL-015", "a node is a corner of one element and on an edge of another",
                              path, "element " + std::to_string(c + 1));
        }
    }
    std::vector<std::uint32_t> place(points.size());
    std::vector<Vec3> corners;
    for (std::size_t n = 0; n < points.size(); ++n) {
        std::vector<Vec3>& home = is_mid[n] ? model.mid_nodes.points : corners;
        place[n] = static_cast<std::uint32_t>(home.size());
        home.push_back(points[n]);
    }
    points = std::move(corners);
    for (PointArray& array : model.arrays) {
        std::vector<float> values;
        for (std::size_t n = 0; n < is_mid.size(); ++n) {
            if (!is_mid[n]) values.push_back(array.values[n]);
        }
        array.values = std::move(values);
    }
    for (Cell& cell : model.mesh.cells) {
        for (std::uint32_t& n : cell) n = place[n];
    }
    for (auto& mids : six) {
        for (std::uint32_t& n : mids) n = place[n];
    }
    model.mid_nodes.cells = std::move(six);
    return Nothing{};
}

Error mixed_orders(const std::string& path, std::string place) {
    Error error =
        mesh_error("E-MDL-006", "the file mixes tetrahedra of four and of ten nodes", path, std::move(place));
    error.next_step = "turn all elements into one kind first";
    return error;
}

}  // namespace anatomesh
