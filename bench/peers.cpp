// Peers of the program on the same contours: meshes them with CGAL's Mesh_3, or takes a mesh that another
// mesher made of them, and measures the result with the program's own measures. One JSON object on standard
// output.
#include <fmt/format.h>
#include <fmt/os.h>
#include <sys/resource.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "anatomesh/field/volume.h"
#include "anatomesh/input_options.h"
#include "anatomesh/measure/certificate.h"
#include "anatomesh/measure/hausdorff.h"
#include "anatomesh/mesh/quality.h"
#include "anatomesh/mesh/region_registry.h"
#include "anatomesh/mesh/topology.h"
#include "anatomesh/option_values.h"
#include "anatomesh/read_input.h"
#include "anatomesh/reconcile_step.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "anatomesh_io/report/report_json.h"
#include "mesh3.h"

namespace anatomesh {

namespace {

using Json = nlohmann::ordered_json;

struct PeerOptions {
    InputOptions input;
    Mesh3Options mesh3;
    std::uint32_t threads = 1;
    std::string surface;   // PLC to write for meshers that start from a surface; empty: none
    std::string model;     // the mesh to measure
    bool relabel = false;  // regions by the field at the cells' centroids
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

// Of this process until now.
struct Usage {
    double cpu_seconds = 0, peak_memory_mb = 0;
};

Usage usage_until_now() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    return {seconds(usage.ru_utime) + seconds(usage.ru_stime), static_cast<double>(usage.ru_maxrss) / 1024.0};
}

struct Measured {
    const TetMesh& mesh;
    const RegionTable& regions;
    const std::vector<Structure>& structures;
};

// From contour vertices and the middles of their segments to the surface of their structure, mm.
Json contour_distance(const Measured& model, const ContourSet& contours) {
    double sum = 0, most = 0;
    std::uint64_t count = 0, without_surface = 0;
    for (std::uint32_t s = 0; s < contours.structures.size(); ++s) {
        const SurfaceMesh surface{model.mesh.points, structure_surface(model.mesh, model.regions, s), {}};
        std::optional<ClosestPoint> closest;
        if (!surface.triangles.empty()) closest.emplace(surface);
        for (const Contour& contour : contours.contours) {
            if (contour.structure != s) continue;
            const auto points = contours.points_of(contour);
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (!closest) {
                    ++without_surface;
                    continue;
                }
                for (const Vec3 p : {points[i], 0.5 * (points[i] + points[(i + 1) % points.size()])}) {
                    const double distance = closest->distance(p);
                    sum += distance;
                    most = std::max(most, distance);
                    ++count;
                }
            }
        }
    }
    return {{"mean", count > 0 ? sum / static_cast<double>(count) : 0},
            {"max", most},
            {"without_surface", without_surface}};
}

// The smallest dihedral angle that all cells but one in a thousand have.
double dihedral_per_mille(const TetMesh& mesh) {
    std::vector<double> smallest;
    for (const Cell& c : mesh.cells) {
        smallest.push_back(
            dihedral_range(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]])
                .smallest);
    }
    if (smallest.empty()) return 0;
    const auto place = smallest.begin() + static_cast<std::ptrdiff_t>(smallest.size() / 1000);
    std::nth_element(smallest.begin(), place, smallest.end());
    return *place;
}

Result<Json> measure(const Measured& model, const ContourSet& contours, const StructureField& field,
                     RunContext& context) {
    const auto count = static_cast<std::uint32_t>(contours.structures.size());
    ANATOMESH_TRY(const std::vector<StructureVolume> volumes, field_volumes(field, count, {}, context));
    std::vector<double> by_field;
    for (const StructureVolume& volume : volumes) by_field.push_back(volume.by_field);
    CertificateInput input{model.mesh, model.regions, model.structures};
    input.contours = &contours;
    input.field_volumes_mm3 = by_field;
    input.made_by_this_run = false;
    ModelReport report;
    measure_model(input, context, report);
    Json json = Json::parse(report_json(report));
    json["contour_distance_mm"] = contour_distance(model, contours);
    json["quality"]["dihedral_deg"]["p001_of_min"] = dihedral_per_mille(model.mesh);
    return json;
}

// The interfaces as a piecewise linear complex, with a hole in every cavity. The marker of a facet says its
// regions: 65536 inner + outer.
void write_poly(const std::string& path, const TetMesh& mesh, const std::vector<Vec3>& cavities) {
    const SurfaceMesh surface = extract_interfaces(mesh);
    auto file = fmt::output_file(path);
    file.print("{} 3 0 0\n", surface.points.size());
    for (std::size_t v = 0; v < surface.points.size(); ++v) {
        const Vec3& p = surface.points[v];
        file.print("{} {} {} {}\n", v + 1, p.x, p.y, p.z);
    }
    file.print("{} 1\n", surface.triangles.size());
    for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
        const Triangle& t = surface.triangles[f];
        const auto [inner, outer] = surface.sides[f];
        file.print("1 0 {}\n3 {} {} {}\n", 65536 * std::uint32_t{inner} + outer, t[0] + 1, t[1] + 1,
                   t[2] + 1);
    }
    file.print("{}\n", cavities.size());
    for (std::size_t h = 0; h < cavities.size(); ++h) {
        const Vec3& p = cavities[h];
        file.print("{} {} {} {}\n", h + 1, p.x, p.y, p.z);
    }
    file.print("0\n");
}

Result<Json> run_cgal(const PeerOptions& options, RunContext& context) {
    Stopwatch watch;
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    const double read = watch.lap();
    ANATOMESH_TRY(InputContours contours, contours_of(std::move(opened), options.input, context));
    ANATOMESH_TRY([[maybe_unused]] const CrossingReport crossing, reconcile_step(contours.kept, {}, context));
    const double traced = watch.lap();
    ANATOMESH_TRY(const auto field, make_structure_field(contours.kept, {}, context));
    const double made_field = watch.lap();
    const Mesh3Result result = mesh3(contours.kept, *field, options.mesh3);
    const Usage usage = usage_until_now();
    Json answer{{"seconds",
                 {{"read", read},
                  {"contours", traced},
                  {"field", made_field},
                  {"insert", result.insert_seconds},
                  {"refine", result.refine_seconds},
                  {"slivers", result.slivers_seconds}}},
                {"cpu_seconds", usage.cpu_seconds},
                {"peak_memory_mb", usage.peak_memory_mb}};
    if (!options.surface.empty()) write_poly(options.surface, result.mesh, result.cavities);
    ANATOMESH_TRY(answer["report"], measure({result.mesh, result.regions, contours.kept.structures},
                                            contours.kept, *field, context));
    return answer;
}

// Meshers differ in which orientation they call positive: that is no fault.
void orient(TetMesh& mesh) {
    for (Cell& cell : mesh.cells) {
        const auto& p = mesh.points;
        if (signed_volume(p[cell[0]], p[cell[1]], p[cell[2]], p[cell[3]]) < 0) std::swap(cell[0], cell[1]);
    }
}

// Regions of a mesh whose mesher knows none; cells outside are left out.
void relabel_by_field(TetMesh& mesh, const StructureField& field, RegionTable& regions) {
    RegionRegistry registry;
    std::vector<std::uint32_t> members;
    std::size_t kept = 0;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        Vec3 sum;
        for (const std::uint32_t v : mesh.cells[c]) sum += mesh.points[v];
        field.members(0.25 * sum, members);
        const Region region = registry.intern(members);
        if (region == 0) continue;
        mesh.cells[kept] = mesh.cells[c];
        mesh.regions[kept++] = region;
    }
    mesh.cells.resize(kept);
    mesh.regions.resize(kept);
    regions = registry.table();
}

Result<Json> run_surface(const PeerOptions& options, RunContext& context) {
    ANATOMESH_TRY(const ModelFile model, read_model(options.model, context));
    write_poly(options.surface, model.mesh, {});
    return Json::object();
}

Result<Json> run_measure(const PeerOptions& options, RunContext& context) {
    ANATOMESH_TRY(ModelFile model, read_model(options.model, context));
    orient(model.mesh);
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    ANATOMESH_TRY(InputContours contours, contours_of(std::move(opened), options.input, context));
    ANATOMESH_TRY([[maybe_unused]] const CrossingReport crossing, reconcile_step(contours.kept, {}, context));
    ANATOMESH_TRY(const auto field, make_structure_field(contours.kept, {}, context));
    if (options.relabel) {
        relabel_by_field(model.mesh, *field, model.description.regions);
        model.description.structures = contours.kept.structures;
    }
    Json answer;
    ANATOMESH_TRY(answer["report"],
                  measure({model.mesh, model.description.regions, model.description.structures},
                          contours.kept, *field, context));
    return answer;
}

int finish(const Result<Json>& answer) {
    if (answer) {
        fmt::print("{}\n", answer.value().dump());
        return 0;
    }
    fmt::print(stderr, "{}\n", to_line(answer.error()));
    return static_cast<int>(answer.error().kind);
}

int run(int argc, char** argv) {
    CLI::App program("Peers of anatomesh on the same contours");
    program.require_subcommand(1);
    PeerOptions options;
    CLI::App* cgal = program.add_subcommand("cgal", "Mesh with CGAL's Mesh_3 and measure");
    CLI::App* measuring = program.add_subcommand("measure", "Measure a mesh that was made of these contours");
    for (CLI::App* verb : {cgal, measuring}) {
        add_reading_options(*verb, options.input);
        add_selection_options(*verb, options.input);
    }
    const auto length_option = [&](const char* name, double& target, const char* description) {
        add_number(*cgal, name, target, 1e-6, 1e6, "MM", description)->required();
    };
    length_option("--facet-radius", options.mesh3.facet_radius_mm,
                  "Bound on the circumradius of surface facets");
    length_option("--cell-radius", options.mesh3.cell_radius_mm, "Bound on the circumradius of cells");
    length_option("--facet-distance", options.mesh3.facet_distance_mm,
                  "Bound on the distance from the surface");
    length_option("--surface-error", options.mesh3.surface_error_mm, "How exactly points lie on the surface");
    cgal->add_flag("--perturb-exude", options.mesh3.perturb_and_exude, "Take out slivers");
    add_number(*cgal, "--sliver-angle", options.mesh3.sliver_angle_deg, 0, 60, "DEG",
               "Smallest dihedral angle aimed at; 0: as large as it gets");
    add_number(*cgal, "--sliver-time", options.mesh3.sliver_time_limit, 0, 1e6, "S",
               "Time for each of the two steps; 0: no limit");
    add_count(*cgal, "--threads", options.threads, 1, 1024, "For the parallel variant");
    add_text(*cgal, "--surface", options.surface, "FILE", "Also write the surface as .poly");
    add_text(*measuring, "--model", options.model, "MODEL", "The mesh")->required();
    measuring->add_flag("--relabel", options.relabel,
                        "The mesh has no regions: take them from the contours' field");
    CLI::App* surface = program.add_subcommand("surface", "Write the interfaces of a model as .poly");
    add_text(*surface, "--model", options.model, "MODEL", "The mesh")->required();
    add_text(*surface, "--surface", options.surface, "FILE", "The .poly file")->required();
    CLI11_PARSE(program, argc, argv);

    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, options.threads);
    RunContext context;
    context.threads = static_cast<int>(options.threads);
    if (surface->parsed()) return finish(run_surface(options, context));
    return finish(cgal->parsed() ? run_cgal(options, context) : run_measure(options, context));
}

}  // namespace

}  // namespace anatomesh

int main(int argc, char** argv) {
    return anatomesh::run(argc, argv);
}
