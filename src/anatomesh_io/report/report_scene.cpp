#include "anatomesh_io/report/report_scene.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh_io/report/html_text.h"

namespace anatomesh {

namespace {

// Indices of points are stored in 24 bits, so that a scene has no more. [points; 2^24; D]
constexpr std::size_t max_scene_points = std::size_t{1} << 24;

void put16(std::string& out, std::uint32_t value) {
    out += static_cast<char>(value & 255);
    out += static_cast<char>(value >> 8 & 255);
}

void put24(std::string& out, std::uint32_t value) {
    put16(out, value);
    out += static_cast<char>(value >> 16 & 255);
}

// The 16 bit grid over everything that is drawn.
struct Grid {
    std::array<double, 3> low{}, step{};

    explicit Grid(Box3 box) {
        if (box.empty()) box = {{0, 0, 0}, {1, 1, 1}};
        low = {box.low.x, box.low.y, box.low.z};
        const std::array<double, 3> high{box.high.x, box.high.y, box.high.z};
        for (std::size_t i = 0; i < 3; ++i) step[i] = std::max(high[i] - low[i], 1e-9) / 65535.0;
    }
    void put(std::string& out, Vec3 p) const {
        const std::array<double, 3> q{p.x, p.y, p.z};
        for (std::size_t i = 0; i < 3; ++i) {
            const double at = std::round((q[i] - low[i]) / step[i]);
            put16(out, static_cast<std::uint32_t>(std::clamp(at, 0.0, 65535.0)));
        }
    }
};

std::string element(const char* id, const std::string& bytes) {
    return std::string("<script type=\"application/octet-stream\" id=\"") + id + "\">" + base64(bytes) +
           "</script>\n";
}

std::string scene_json(const ModelReport& report, const RegionTable& regions, const Grid& grid) {
    nlohmann::ordered_json structures = nlohmann::ordered_json::array();
    for (const StructureReport& structure : report.structures)
        structures.push_back({{"color", structure.color}});
    const nlohmann::ordered_json json{{"low", grid.low},
                                      {"step", grid.step},
                                      {"patient", report.conventions.space == "LPS"},
                                      {"structures", std::move(structures)},
                                      {"regions", regions.members}};
    return "<script type=\"application/json\" id=\"scene\">" + json.dump() + "</script>\n";
}

// Facets between regions, as extract_interfaces() finds them, with the mesh's own point numbers.
std::string interface_elements(const TetMesh& mesh) {
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    std::string triangles, sides;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t other = neighbors[4 * c + i];
            const Region outer = other == no_cell ? Region{0} : mesh.regions[other];
            if (mesh.regions[c] <= outer) continue;
            for (const int v : facet_vertices[i])
                put24(triangles, mesh.cells[c][static_cast<std::size_t>(v)]);
            put16(sides, mesh.regions[c]);
            put16(sides, outer);
        }
    }
    return element("triangles", triangles) + element("sides", sides);
}

std::string cell_elements(const TetMesh& mesh, bool drawn) {
    std::string cells, cell_regions;
    if (drawn) {
        cells.reserve(12 * mesh.cells.size());
        for (const Cell& cell : mesh.cells) {
            for (const std::uint32_t v : cell) put24(cells, v);
        }
        for (const Region region : mesh.regions) put16(cell_regions, region);
    }
    return element("cells", cells) + element("cell-regions", cell_regions);
}

std::string contour_elements(const ContourSet* contours, std::size_t structure_count, const Grid& grid) {
    std::string points, sizes, structures;
    if (contours) {
        for (const Contour& contour : contours->contours) {
            if (contour.structure >= structure_count) continue;
            for (const Vec3& p : contours->points_of(contour)) grid.put(points, p);
            put24(sizes, contour.point_count);
            put16(structures, contour.structure);
        }
    }
    return element("contours", points) + element("contour-sizes", sizes) +
           element("contour-structures", structures);
}

}  // namespace

Scene make_scene(const ModelReport& report, const TetMesh& mesh, const RegionTable& regions,
                 const ContourSet* contours, const SceneOptions& options) {
    assert(mesh.points.size() <= max_scene_points);
    Scene scene;
    scene.cells_drawn = mesh.cells.size() <= options.max_cells;
    scene.has_contours = contours && !contours->contours.empty();
    Box3 box;
    for (const Vec3& p : mesh.points) box.extend(p);
    if (contours) {
        for (const Vec3& p : contours->points) box.extend(p);
    }
    const Grid grid(box);
    std::string points;
    points.reserve(6 * mesh.points.size());
    for (const Vec3& p : mesh.points) grid.put(points, p);
    scene.html = scene_json(report, regions, grid) + element("points", points) +
                 cell_elements(mesh, scene.cells_drawn) + interface_elements(mesh) +
                 contour_elements(contours, report.structures.size(), grid);
    return scene;
}

}  // namespace anatomesh
