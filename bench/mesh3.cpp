#include "mesh3.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_3/Worksharing_data_structures.h>  // exude_mesh_3.h needs it and does not include it
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/exude_mesh_3.h>
#include <CGAL/perturb_mesh_3.h>
#include <CGAL/refine_mesh_3.h>

#include <array>
#include <chrono>
#include <map>
#include <mutex>
#include <unordered_map>
#include <utility>

namespace anatomesh {

namespace {

#ifdef ANATOMESH_MESH3_PARALLEL
using Concurrency = CGAL::Parallel_tag;
#else
using Concurrency = CGAL::Sequential_tag;
#endif
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, Concurrency>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

Vec3 to_vec(const Kernel::Point_3& p) {
    return {p.x(), p.y(), p.z()};
}

// The number of every set of structures that a point was found in.
class Labels {
  public:
    explicit Labels(std::size_t structures) : one_structure_(structures == 1) {
        if (one_structure_) table_.members.push_back({0});
    }

    int label(const StructureField& field, Vec3 p) {
        if (one_structure_) return field.value(0, p) < 0 ? 1 : 0;
        thread_local std::vector<std::uint32_t> members;
        field.members(p, members);
        if (members.empty()) return 0;
        const std::scoped_lock lock(mutex_);
        const auto [entry, added] = numbers_.try_emplace(members, static_cast<int>(table_.members.size()));
        if (added) table_.members.push_back(members);
        return entry->second;
    }
    const RegionTable& table() const { return table_; }

  private:
    bool one_structure_;
    std::mutex mutex_;
    std::map<std::vector<std::uint32_t>, int> numbers_;
    RegionTable table_;
};

class Stopwatch {
  public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

void insert_points(Complex& complex, const Domain& domain, const std::vector<Vec3>& points) {
    std::vector<Triangulation::Weighted_point> weighted;
    weighted.reserve(points.size());
    for (const Vec3& p : points) weighted.emplace_back(Kernel::Point_3(p.x, p.y, p.z), 0.0);
    complex.triangulation().insert(weighted.begin(), weighted.end());
    const auto index = domain.index_from_surface_patch_index({0, 1});
    for (const auto vertex : complex.triangulation().finite_vertex_handles()) {
        complex.set_dimension(vertex, 2);
        complex.set_index(vertex, index);
    }
}

void copy_cells(const Complex& complex, TetMesh& mesh) {
    std::unordered_map<const void*, std::uint32_t> numbers;
    for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
        Cell vertices;
        for (int i = 0; i < 4; ++i) {
            const auto vertex = cell->vertex(i);
            const auto [entry, added] =
                numbers.try_emplace(&*vertex, static_cast<std::uint32_t>(mesh.points.size()));
            if (added) mesh.points.push_back(to_vec(vertex->point().point()));
            vertices[static_cast<std::size_t>(i)] = entry->second;
        }
        mesh.cells.push_back(vertices);
        mesh.regions.push_back(static_cast<Region>(complex.subdomain_index(cell)));
    }
}

}  // namespace

Mesh3Result mesh3(const ContourSet& contours, const StructureField& field, const Mesh3Options& options) {
    Mesh3Result result;
    Labels labels(contours.structures.size());
    const Box3 box = field.box();
    const double margin = options.cell_radius_mm;
    const CGAL::Bbox_3 bounds(box.low.x - margin, box.low.y - margin, box.low.z - margin, box.high.x + margin,
                              box.high.y + margin, box.high.z + margin);
    const double diagonal = length(box.high - box.low + Vec3{2 * margin, 2 * margin, 2 * margin});
    const auto label = [&](const Kernel::Point_3& p) { return labels.label(field, to_vec(p)); };
    // The domain takes the error relative to half the diagonal of its box.
    const Domain domain(label, bounds, 2 * options.surface_error_mm / diagonal);
    const Criteria criteria(CGAL::parameters::facet_angle = options.facet_angle_deg,
                            CGAL::parameters::facet_size = options.facet_radius_mm,
                            CGAL::parameters::facet_distance = options.facet_distance_mm,
                            CGAL::parameters::cell_radius_edge_ratio = options.radius_edge,
                            CGAL::parameters::cell_size = options.cell_radius_mm);
    Complex complex;
    Stopwatch watch;
    insert_points(complex, domain, contours.points);
    result.insert_seconds = watch.lap();
    CGAL::refine_mesh_3(complex, domain, criteria, CGAL::parameters::no_perturb(),
                        CGAL::parameters::no_exude());
    result.refine_seconds = watch.lap();
    if (options.perturb_and_exude) {
        CGAL::perturb_mesh_3(complex, domain, CGAL::parameters::sliver_bound = options.sliver_angle_deg,
                             CGAL::parameters::time_limit = options.sliver_time_limit);
        CGAL::exude_mesh_3(complex, CGAL::parameters::sliver_bound = options.sliver_angle_deg,
                           CGAL::parameters::time_limit = options.sliver_time_limit);
        result.slivers_seconds = watch.lap();
    }
    copy_cells(complex, result.mesh);
    result.regions = labels.table();
    return result;
}

}  // namespace anatomesh
