// Peers of the program on the same contours: meshes them with CGAL's Mesh_3, or takes a mesh that another
// mesher made of them, and measures the result with the program's own measures. One JSON object on standard
// output.
#include <fmt/format.h>
#include <fmt/os.h>
#include <sys/resource.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "anatomesh/field/volume.h"
#include "anatomesh/measure/certificate.h"
#include "anatomesh/mesh/quality.h"
#include "anatomesh/mesh/topology.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "anatomesh_io/report/report_json.h"
#include "anatomesh/input_options.h"
#include "mesh3.h"
#include "anatomesh/option_values.h"
#include "anatomesh/read_input.h"

namespace anatomesh {

namespace {

using Json = nlohmann::ordered_json;

struct PeerOptions {
    InputOptions input;
    Mesh3Options mesh3;
    std::uint32_t threads = 1;
    std::string surface;  // PLC to write for TetGen; empty: none
    std::string model;    // the mesh to measure
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
    return Json::parse(report_json(report));
}

// The surface as a piecewise linear complex for TetGen, with a hole in every cavity.
void write_poly(const std::string& path, const Mesh3Result& result) {
    const SurfaceMesh surface = extract_interfaces(result.mesh);
    auto file = fmt::output_file(path);
    file.print("{} 3 0 0\n", surface.points.size());
    for (std::size_t v = 0; v < surface.points.size(); ++v) {
        const Vec3& p = surface.points[v];
        file.print("{} {} {} {}\n", v + 1, p.x, p.y, p.z);
    }
    file.print("{} 0\n", surface.triangles.size());
    for (const Triangle& t : surface.triangles) file.print("1\n3 {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    file.print("{}\n", result.cavities.size());
    for (std::size_t h = 0; h < result.cavities.size(); ++h) {
        const Vec3& p = result.cavities[h];
        file.print("{} {} {} {}\n", h + 1, p.x, p.y, p.z);
    }
    file.print("0\n");
}

Result<Json> run_cgal(const PeerOptions& options, RunContext& context) {
    Stopwatch watch;
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    const double read = watch.lap();
    ANATOMESH_TRY(const InputContours contours, contours_of(std::move(opened), options.input, context));
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
    if (!options.surface.empty()) write_poly(options.surface, result);
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

Result<Json> run_measure(const PeerOptions& options, RunContext& context) {
    ANATOMESH_TRY(ModelFile model, read_model(options.model, context));
    orient(model.mesh);
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    ANATOMESH_TRY(const InputContours contours, contours_of(std::move(opened), options.input, context));
    ANATOMESH_TRY(const auto field, make_structure_field(contours.kept, {}, context));
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
    add_count(*cgal, "--threads", options.threads, 1, 1024, "For the parallel variant");
    add_text(*cgal, "--surface", options.surface, "FILE", "Also write the surface as .poly for TetGen");
    add_text(*measuring, "--model", options.model, "MODEL", "The mesh")->required();
    CLI11_PARSE(program, argc, argv);

    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, options.threads);
    RunContext context;
    context.threads = static_cast<int>(options.threads);
    return finish(cgal->parsed() ? run_cgal(options, context) : run_measure(options, context));
}

}  // namespace

}  // namespace anatomesh

int main(int argc, char** argv) {
    return anatomesh::run(argc, argv);
}
