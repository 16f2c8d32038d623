#include "anatomesh/delaunay/tetrahedralize.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <numeric>

namespace anatomesh {

namespace {

using Geometry = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Geometry::Point_3;

// An index that a newly made vertex or cell starts without.
struct Index {
    std::uint32_t value = no_cell;
};

using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<Index, Geometry>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<Index, Geometry, CGAL::Delaunay_triangulation_cell_base_3<Geometry>>;
using Structure3 = CGAL::Triangulation_data_structure_3<VertexBase, CellBase>;
using Delaunay = CGAL::Delaunay_triangulation_3<Geometry, Structure3>;

// Indices of the points in an order in which neighbours in it are neighbours in space.
std::vector<std::size_t> insertion_order(const std::vector<Point>& points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    using Map = CGAL::Pointer_property_map<Point>::const_type;
    CGAL::spatial_sort(order.begin(), order.end(),
                       CGAL::Spatial_sort_traits_adapter_3<Geometry, Map>(CGAL::make_property_map(points)));
    return order;
}

}  // namespace

struct Tetrahedralization::Kernel {
    Delaunay delaunay;
    std::vector<Vec3> points;
    std::vector<std::uint32_t> first_vertices;
};

Tetrahedralization::Tetrahedralization(std::unique_ptr<Kernel> kernel) : kernel_(std::move(kernel)) {}
Tetrahedralization::Tetrahedralization(Tetrahedralization&&) noexcept = default;
Tetrahedralization& Tetrahedralization::operator=(Tetrahedralization&&) noexcept = default;
Tetrahedralization::~Tetrahedralization() = default;

Result<Tetrahedralization> Tetrahedralization::create(std::span<const Vec3> points) {
    Tetrahedralization made(std::make_unique<Kernel>());
    made.kernel_->first_vertices = made.insert(points);
    if (made.kernel_->delaunay.dimension() < 3) {
        return Error{ErrorKind::geometry, "E-DEL-001",
                     "the points span no volume: " + std::to_string(made.points().size()) +
                         " distinct points, all in one plane",
                     {}, "give contours on at least two slices, or a slice with thickness"};
    }
    return made;
}

std::vector<std::uint32_t> Tetrahedralization::insert(std::span<const Vec3> points) {
    std::vector<Point> cgal_points;
    cgal_points.reserve(points.size());
    for (const Vec3& p : points) cgal_points.emplace_back(p.x, p.y, p.z);

    // Insert in spatial order, each search starting at the vertex before it.
    std::vector<Delaunay::Vertex_handle> handles(points.size());
    Delaunay::Cell_handle hint;
    for (const std::size_t i : insertion_order(cgal_points)) {
        handles[i] = kernel_->delaunay.insert(cgal_points[i], hint);
        hint = handles[i]->cell();
    }
    // Number new vertices in the caller's order; equal points share a vertex.
    std::vector<std::uint32_t> vertices(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        Index& index = handles[i]->info();
        if (index.value == no_cell) {
            index.value = static_cast<std::uint32_t>(kernel_->points.size());
            kernel_->points.push_back(points[i]);
        }
        vertices[i] = index.value;
    }
    return vertices;
}

const std::vector<Vec3>& Tetrahedralization::points() const { return kernel_->points; }

std::span<const std::uint32_t> Tetrahedralization::first_vertices() const { return kernel_->first_vertices; }

void Tetrahedralization::snapshot(DelaunaySnapshot& snapshot) {
    const Delaunay& delaunay = kernel_->delaunay;
    snapshot.cells.clear();
    snapshot.previous.clear();
    std::vector<Delaunay::Cell_handle> handles;
    handles.reserve(delaunay.number_of_cells());
    for (auto cell = delaunay.all_cells_begin(); cell != delaunay.all_cells_end(); ++cell) {
        if (delaunay.is_infinite(cell)) {
            cell->info().value = no_cell;
            continue;
        }
        snapshot.previous.push_back(cell->info().value);
        cell->info().value = static_cast<std::uint32_t>(handles.size());
        handles.push_back(cell);
        snapshot.cells.push_back({cell->vertex(0)->info().value, cell->vertex(1)->info().value,
                                  cell->vertex(2)->info().value, cell->vertex(3)->info().value});
    }
    snapshot.neighbors.resize(handles.size());
    for (std::size_t c = 0; c < handles.size(); ++c) {
        for (int i = 0; i < 4; ++i) snapshot.neighbors[c][i] = handles[c]->neighbor(i)->info().value;
    }
}

}  // namespace anatomesh
