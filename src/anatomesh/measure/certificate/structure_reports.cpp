#include "anatomesh/measure/certificate/structure_reports.h"

#include <atomic>

#include "anatomesh/base/parallel.h"
#include "anatomesh/measure/shells.h"
#include "anatomesh/measure/volume.h"
#include "anatomesh/mesh/check/topology.h"

namespace anatomesh {

namespace {

double surface_area(const std::vector<Vec3>& points, const std::vector<Triangle>& surface) {
    double twice = 0;
    for (const Triangle& f : surface) {
        twice += length(cross(points[f[1]] - points[f[0]], points[f[2]] - points[f[0]]));
    }
    return twice / 2;
}

}  // namespace

ShellNumbers measure_structures(const CertificateInput& input, const Surfaces& surfaces,
                                std::span<const std::uint32_t> neighbors, int threads, ModelReport& report) {
    const TetMesh& mesh = input.mesh;
    std::vector<double> volumes;
    std::vector<SurfaceTopology> topologies(surfaces.size());
    ShellNumbers shells(surfaces.size());
    std::vector<std::uint64_t> pieces(surfaces.size());
    parallel_tasks(threads, {[&] { volumes = mesh_volumes(mesh, input.regions, input.structures.size()); },
                             [&] {
                                 parallel_for(
                                     surfaces.size(), 1, threads, [&](std::size_t first, std::size_t last) {
                                         for (std::size_t s = first; s < last; ++s)
                                             topologies[s] = surface_topology(surfaces[s], &shells[s]);
                                     });
                             },
                             [&] {
                                 for (std::uint32_t s = 0; s < surfaces.size(); ++s)
                                     pieces[s] = structure_pieces(mesh, neighbors, input.regions, s);
                             }});
    std::vector<std::uint64_t> cells_of_region(input.regions.members.size(), 0);
    for (const Region region : mesh.regions) ++cells_of_region[region];
    report.structures.clear();
    for (std::uint32_t s = 0; s < input.structures.size(); ++s) {
        const SurfaceTopology& topology = topologies[s];
        StructureReport structure;
        structure.number = input.structures[s].number;
        structure.name = input.structures[s].name;
        structure.color = input.structures[s].color;
        for (std::size_t r = 0; r < cells_of_region.size(); ++r) {
            if (input.regions.contains(static_cast<Region>(r), s)) structure.tetrahedra += cells_of_region[r];
        }
        structure.surface.triangles = topology.triangles;
        structure.surface.vertices = topology.vertices;
        structure.volume.mesh_mm3 = volumes[s];
        if (!input.field_volumes_mm3.empty()) structure.volume.field_mm3 = input.field_volumes_mm3[s];
        structure.surface.area_mm2 = surface_area(mesh.points, surfaces[s]);
        structure.surface.components = topology.components;
        structure.pieces = pieces[s];
        structure.shells = count_shells(mesh.points, surfaces[s], shells[s]);
        structure.surface.genus = topology.genus;
        structure.surface.open_edges = topology.open_edges;
        structure.surface.nonmanifold_edges = topology.nonmanifold_edges + topology.misoriented_edges;
        structure.surface.nonmanifold_vertices = topology.nonmanifold_vertices;
        report.structures.push_back(std::move(structure));
    }
    report.regions = input.regions.members;
    return shells;
}

std::uint64_t count_interface_facets(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                     int threads) {
    std::atomic<std::uint64_t> all = 0;
    parallel_for(neighbors.size(), 65536, threads, [&](std::size_t first, std::size_t last) {
        std::uint64_t count = 0;
        for (std::size_t facet = first; facet < last; ++facet) {
            const std::uint32_t other = neighbors[facet];
            count += mesh.regions[facet / 4] > (other == no_cell ? Region{0} : mesh.regions[other]);
        }
        all.fetch_add(count, std::memory_order_relaxed);
    });
    return all;
}

}  // namespace anatomesh
