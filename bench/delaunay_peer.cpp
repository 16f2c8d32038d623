#include "delaunay_peer.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <vector>

std::size_t cells_by_cgal(std::span<const anatomesh::Vec3> points) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    std::vector<Kernel::Point_3> converted;
    converted.reserve(points.size());
    for (const anatomesh::Vec3& p : points) converted.emplace_back(p.x, p.y, p.z);
    return CGAL::Delaunay_triangulation_3<Kernel>(converted.begin(), converted.end())
        .number_of_finite_cells();
}
