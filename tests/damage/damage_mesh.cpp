// Damages the mesh of a finished run before the certificate measures it. ANATOMESH_DAMAGE names how; without it nothing
// is done. The linker sends calls of the two functions here (--wrap), and lets what is here call the true ones.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/geom/vec.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/mesh/edit/drop_outside.h"
#include "anatomesh/mesh/edit/facets.h"

namespace anatomesh {

void true_measure_model(const CertificateInput& input, const RunContext& context,
                        ModelReport& report) asm("__real_" MEASURE_MODEL);
void damage_and_measure_model(const CertificateInput& input, const RunContext& context,
                              ModelReport& report) asm("__wrap_" MEASURE_MODEL);
std::vector<std::uint32_t> true_drop_outside(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                             unsigned threads) asm("__real_" DROP_OUTSIDE);
std::vector<std::uint32_t> drop_outside_and_more(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                                 unsigned threads) asm("__wrap_" DROP_OUTSIDE);

namespace {

constexpr const char* hollow = "hollow";

// A test that damages nothing would show nothing.
[[noreturn]] void give_up(const std::string& what) {
    std::fprintf(stderr, "anatomesh_damaging: %s\n", what.c_str());
    std::abort();
}

std::string wanted_damage() {
    const char* kind = std::getenv("ANATOMESH_DAMAGE");
    return kind ? kind : "";
}

// Which facets count as surface: those of the outside, those between regions, or both.
enum class Walls : std::uint8_t { outside, between, all };

// Where a sound mesh has its surfaces.
class Surface {
  public:
    Surface(const TetMesh& mesh, std::span<const std::uint32_t> neighbors, Walls walls)
        : mesh_(mesh), neighbors_(neighbors), walls_(walls), has_(mesh.points.size()) {
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            for (std::size_t f = 0; f < 4; ++f) {
                if (!is_wall(c, f)) continue;
                for (const int v : facet_vertices[f]) has_[mesh.cells[c][static_cast<std::size_t>(v)]] = 1;
            }
        }
    }

    bool has(std::uint32_t vertex) const { return has_[vertex] != 0; }
    long vertices_of(std::size_t cell) const {
        return std::count_if(mesh_.cells[cell].begin(), mesh_.cells[cell].end(),
                             [&](std::uint32_t v) { return has(v); });
    }
    long facets_of(std::size_t cell) const {
        const std::array<std::size_t, 4> facets{0, 1, 2, 3};
        return std::count_if(facets.begin(), facets.end(), [&](std::size_t f) { return is_wall(cell, f); });
    }

  private:
    bool is_wall(std::size_t cell, std::size_t facet) const {
        const std::uint32_t other = neighbors_[4 * cell + facet];
        if (other == no_cell) return walls_ != Walls::between;
        return walls_ != Walls::outside && mesh_.regions[other] != mesh_.regions[cell];
    }

    const TetMesh& mesh_;
    std::span<const std::uint32_t> neighbors_;
    Walls walls_;
    std::vector<char> has_;
};

// The first cell with so many vertices and facets on surfaces.
std::uint32_t cell_with(const TetMesh& mesh, const Surface& surface, long vertices, long facets) {
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c)
        if (surface.vertices_of(c) == vertices && surface.facets_of(c) == facets) return c;
    give_up("the mesh has no such cell");
}

// What the finished mesh is made of.
struct Finished {
    TetMesh& mesh;
    const RegionTable& regions;
    const ContourSet& contours;
    std::span<const std::uint32_t> neighbors;
    const Surface surface{mesh, neighbors, Walls::all};

    std::uint32_t inner_cell() const { return cell_with(mesh, surface, 0, 0); }
    bool is_drawn(std::uint32_t vertex) const {
        return std::find(contours.points.begin(), contours.points.end(), mesh.points[vertex]) !=
               contours.points.end();
    }
    std::uint32_t vertex(bool on_surface, bool drawn) const {
        for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
            if (surface.has(v) == on_surface && is_drawn(v) == drawn) return v;
        give_up("the mesh has no such vertex");
    }
    Vec3 middle() const {
        Vec3 sum{};
        for (const Vec3& p : mesh.points) sum = sum + p;
        return (1.0 / static_cast<double>(mesh.points.size())) * sum;
    }
};

void turn_cell(const Finished& finished) {
    Cell& cell = finished.mesh.cells[finished.inner_cell()];
    std::swap(cell[0], cell[1]);
}

void repeat_cell(const Finished& finished) {
    TetMesh& mesh = finished.mesh;
    const std::uint32_t c = finished.inner_cell();
    mesh.cells.push_back(Cell(mesh.cells[c]));
    mesh.regions.push_back(Region(mesh.regions[c]));
}

void move_inner_vertex_through_facet(const Finished& finished) {
    TetMesh& mesh = finished.mesh;
    const Cell& cell = mesh.cells[finished.inner_cell()];
    const Vec3 opposite = (1.0 / 3.0) * (mesh.points[cell[1]] + mesh.points[cell[2]] + mesh.points[cell[3]]);
    mesh.points[cell[0]] = mesh.points[cell[0]] + 2.0 * (opposite - mesh.points[cell[0]]);
}

// One vertex in the middle between two others.
void flatten_cell(const Finished& finished) {
    TetMesh& mesh = finished.mesh;
    const Cell& cell = mesh.cells[finished.inner_cell()];
    mesh.points[cell[0]] = 0.5 * (mesh.points[cell[1]] + mesh.points[cell[2]]);
}

void move_surface_vertex_through_model(const Finished& finished) {
    Vec3& point = finished.mesh.points[finished.vertex(true, false)];
    point = point + 2.5 * (finished.middle() - point);
}

void move_contour_vertex_by_one_unit_in_the_last_place(const Finished& finished) {
    Vec3& point = finished.mesh.points[finished.vertex(true, true)];
    point.x = std::nextafter(point.x, std::numeric_limits<double>::infinity());
}

void exchange_contour_vertices(const Finished& finished) {
    std::vector<Vec3>& points = finished.mesh.points;
    const std::uint32_t one = finished.vertex(true, true);
    for (std::uint32_t other = one + 1; other < points.size(); ++other)
        if (finished.is_drawn(other)) return std::swap(points[one], points[other]);
    give_up("there is one contour vertex alone");
}

void make_point_not_finite(const Finished& finished) {
    finished.mesh.points[finished.vertex(false, false)].y = std::numeric_limits<double>::quiet_NaN();
}

void point_beyond_the_points(const Finished& finished) {
    finished.mesh.cells[finished.inner_cell()][2] = static_cast<std::uint32_t>(finished.mesh.points.size());
}

// One corner of a cell becomes a vertex of its own, at the same place: the mesh is open there.
void part_a_corner(const Finished& finished) {
    TetMesh& mesh = finished.mesh;
    std::uint32_t& corner = mesh.cells[finished.inner_cell()][0];
    mesh.points.push_back(Vec3(mesh.points[corner]));
    corner = static_cast<std::uint32_t>(mesh.points.size() - 1);
}

// A small cell within another one.
void nest_cell(const Finished& finished) {
    TetMesh& mesh = finished.mesh;
    const std::uint32_t c = finished.inner_cell();
    const Cell around = mesh.cells[c];
    Vec3 centre{};
    for (const std::uint32_t v : around) centre = centre + 0.25 * mesh.points[v];
    Cell nested{};
    for (std::size_t i = 0; i < 4; ++i) {
        nested[i] = static_cast<std::uint32_t>(mesh.points.size());
        mesh.points.push_back(centre + 0.1 * (mesh.points[around[i]] - centre));
    }
    mesh.cells.push_back(nested);
    mesh.regions.push_back(Region(mesh.regions[c]));
}

// A cell that touches the surface between two regions in one vertex changes its region: that surface is no manifold there.
void move_cell_to_other_region(const Finished& finished) {
    TetMesh& mesh = finished.mesh;
    const Surface between(mesh, finished.neighbors, Walls::between);
    Region& region = mesh.regions[cell_with(mesh, between, 1, 0)];
    if (finished.regions.members.size() != 3) give_up("the model has not two regions");
    region = region == 1 ? Region{2} : Region{1};
}

void (*damage_of(const std::string& kind))(const Finished&) {
    static const std::map<std::string, void (*)(const Finished&)> kinds{
        {"turned_cell", turn_cell},
        {"repeated_cell", repeat_cell},
        {"nested_cell", nest_cell},
        {"flat_cell", flatten_cell},
        {"parted_corner", part_a_corner},
        {"cell_in_other_region", move_cell_to_other_region},
        {"inner_vertex_through_facet", move_inner_vertex_through_facet},
        {"surface_vertex_through_model", move_surface_vertex_through_model},
        {"contour_vertex_off", move_contour_vertex_by_one_unit_in_the_last_place},
        {"contour_vertices_exchanged", exchange_contour_vertices},
        {"point_not_finite", make_point_not_finite},
        {"index_beyond", point_beyond_the_points},
    };
    const auto found = kinds.find(kind);
    if (found == kinds.end()) give_up("there is no damage " + kind);
    return found->second;
}

// A cell that is taken out, by how many vertices and facets it has on which surfaces; its neighbours know it.
struct Missing {
    long vertices = 0, facets = 0;
    Walls walls = Walls::outside;
};

const std::map<std::string, Missing>& missing_cells() {
    static const std::map<std::string, Missing> kinds{
        {"missing_cell_inside", {0, 0, Walls::all}},         // a void
        {"missing_cell_at_vertex", {1, 0, Walls::outside}},  // a void that touches the surface in a point
        {"missing_cell_at_edge",
         {2, 0, Walls::outside}},  // one that touches it along an edge, or in two points
        {"missing_cell_at_facet", {3, 1, Walls::outside}},  // a dent
    };
    return kinds;
}

void take_out(std::uint32_t cell, TetMesh& mesh, std::vector<std::uint32_t>& neighbors) {
    mesh.cells.erase(mesh.cells.begin() + cell);
    mesh.regions.erase(mesh.regions.begin() + cell);
    neighbors.erase(neighbors.begin() + 4 * cell, neighbors.begin() + 4 * cell + 4);
    for (std::uint32_t& other : neighbors) {
        if (other == no_cell) continue;
        if (other == cell)
            other = no_cell;
        else
            other -= other > cell;
    }
}

// Cells are left at surfaces alone, and one of them is turned over: much is amiss of every cross-section as well.
void hollow_out(TetMesh& mesh, std::vector<std::uint32_t>& neighbors) {
    const Surface surface(mesh, neighbors, Walls::all);
    std::vector<std::uint32_t> inside;
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c)
        if (surface.vertices_of(c) == 0) inside.push_back(c);
    for (std::size_t n = inside.size(); n > 0; --n) take_out(inside[n - 1], mesh, neighbors);
    std::swap(mesh.cells[0][0], mesh.cells[0][1]);
}

}  // namespace

std::vector<std::uint32_t> drop_outside_and_more(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                                 unsigned threads) {
    std::vector<std::uint32_t> vertex = true_drop_outside(mesh, neighbors, threads);
    const std::string kind = wanted_damage();
    if (kind == hollow) hollow_out(mesh, neighbors);
    const auto missing = missing_cells().find(kind);
    if (missing == missing_cells().end()) return vertex;
    const auto& [vertices, facets, walls] = missing->second;
    const Surface surface(mesh, neighbors, walls);
    take_out(cell_with(mesh, surface, vertices, facets), mesh, neighbors);
    return vertex;
}

void damage_and_measure_model(const CertificateInput& input, const RunContext& context, ModelReport& report) {
    const std::string kind = wanted_damage();
    if (!kind.empty() && kind != hollow && missing_cells().count(kind) == 0) {
        // The run's own model, which is no constant.
        auto& mesh = const_cast<TetMesh&>(input.mesh);
        const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
        damage_of(kind)({mesh, input.regions, *input.contours, neighbors});
    }
    true_measure_model(input, context, report);
}

}  // namespace anatomesh
