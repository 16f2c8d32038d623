// CGAL's Mesh_3 on the same contours and the same field as the program: writes the model, and its seconds and
// memory as one JSON object on standard output. Who measures the model is bench/measuring.py.
#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/input_options.h"
#include "anatomesh/option_values.h"
#include "anatomesh/read_input.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "mesh3.h"

namespace anatomesh {

namespace {

using Json = nlohmann::ordered_json;

struct PeerOptions {
    InputOptions input;
    Mesh3Options mesh3;
    std::uint32_t threads = 1;
    std::string model;  // written
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

Result<Json> run_cgal(const PeerOptions& options, RunContext& context) {
    Stopwatch watch;
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    const double read = watch.lap();
    ANATOMESH_TRY(const InputContours contours, contours_of(std::move(opened), options.input, context));
    const double traced = watch.lap();
    ANATOMESH_TRY(const auto field, make_structure_field(contours.kept, {}, context));
    const double made_field = watch.lap();
    Mesh3Result result = mesh3(contours.kept, *field, options.mesh3);
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
    const ModelFile model{std::move(result.mesh),
                          {contours.kept.structures, std::move(result.regions), "LPS", "mm", {}}};
    ANATOMESH_CHECK_STATUS(write_model(options.model, model, context));
    return answer;
}

int run(int argc, char** argv) {
    CLI::App program("CGAL's Mesh_3 on the contours of INPUT");
    PeerOptions options;
    add_reading_options(program, options.input);
    add_selection_options(program, options.input);
    const auto length_option = [&](const char* name, double& target, const char* description) {
        add_number(program, name, target, 1e-6, 1e6, "MM", description)->required();
    };
    length_option("--facet-radius", options.mesh3.facet_radius_mm,
                  "Bound on the circumradius of surface facets");
    length_option("--cell-radius", options.mesh3.cell_radius_mm, "Bound on the circumradius of cells");
    length_option("--facet-distance", options.mesh3.facet_distance_mm,
                  "Bound on the distance from the surface");
    length_option("--surface-error", options.mesh3.surface_error_mm, "How exactly points lie on the surface");
    program.add_flag("--perturb-exude", options.mesh3.perturb_and_exude, "Take out slivers");
    add_number(program, "--sliver-angle", options.mesh3.sliver_angle_deg, 0, 60, "DEG",
               "Smallest dihedral angle aimed at; 0: as large as it gets");
    add_number(program, "--sliver-time", options.mesh3.sliver_time_limit, 0, 1e6, "S",
               "Time for each of the two steps; 0: no limit");
    add_count(program, "--threads", options.threads, 1, 1024, "For the parallel variant");
    add_text(program, "--model", options.model, "MODEL", "The model to write")->required();
    CLI11_PARSE(program, argc, argv);

    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, options.threads);
    RunContext context;
    context.threads = static_cast<int>(options.threads);
    const Result<Json> answer = run_cgal(options, context);
    if (answer) {
        fmt::print("{}\n", answer.value().dump());
        return 0;
    }
    fmt::print(stderr, "{}\n", to_line(answer.error()));
    return static_cast<int>(answer.error().kind);
}

}  // namespace

}  // namespace anatomesh

int main(int argc, char** argv) {
    return anatomesh::run(argc, argv);
}
