// anatomesh compare: the two-sided distance of two surfaces or models.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "anatomesh/measure/hausdorff.h"
#include "answer.h"
#include "help_text.h"
#include "mesh_input.h"
#include "option_values.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct CompareOptions {
    std::string a, b;
    std::uint32_t samples = 100'000;
};

nlohmann::ordered_json distances_json(const DistanceStats& stats) {
    return {
        {"min", stats.min}, {"mean", stats.mean}, {"rms", stats.rms}, {"p95", stats.p95}, {"max", stats.max}};
}

std::string distances_text(const char* which, const DistanceStats& stats) {
    return fmt::format("{:<8} {:>10.4f} {:>10.4f} {:>10.4f} {:>10.4f} {:>10.4f}\n", which, stats.min,
                       stats.mean, stats.rms, stats.p95, stats.max);
}

Status run_compare(const CompareOptions& options, Session& session) {
    ANATOMESH_TRY(const MeshInput a, read_mesh(options.a, session.limits, session.context));
    ANATOMESH_TRY(const MeshInput b, read_mesh(options.b, session.limits, session.context));
    const SurfaceFile surface_a = surface_of(a), surface_b = surface_of(b);
    if (surface_a.description.space != surface_b.description.space) {
        session.context.warn({"W-CMD-001",
                              "the two files state different axes",
                              {options.b, "", "", "",
                               fmt::format("{} of {}, {} of {}", surface_a.description.space, options.a,
                                           surface_b.description.space, options.b)},
                              "the coordinates were compared as they are"});
    }
    SurfaceDistanceOptions measuring;
    measuring.samples = options.samples;
    ANATOMESH_TRY(const SurfaceDistance distance,
                  surface_distance(surface_a.surface, surface_b.surface, measuring, session.context));
    nlohmann::ordered_json answer;
    answer["a"] = options.a;
    answer["b"] = options.b;
    answer["unit"] = "mm";
    answer["samples"] = {distance.samples_a, distance.samples_b};
    answer["a_to_b"] = distances_json(distance.a_to_b);
    answer["b_to_a"] = distances_json(distance.b_to_a);
    answer["both"] = distances_json(distance.both);
    std::string text =
        fmt::format("{:<8} {:>10} {:>10} {:>10} {:>10} {:>10}\n", "mm", "min", "mean", "RMS", "95 %", "max");
    text += distances_text("A to B", distance.a_to_b) + distances_text("B to A", distance.b_to_a) +
            distances_text("both", distance.both);
    return give_answer(session, answer, text);
}

}  // namespace

Work declare_compare(CLI::App& verb) {
    auto options = std::make_shared<CompareOptions>();
    verb.add_option("A", options->a, "Model or surface.")->type_name("FILE")->required();
    verb.add_option("B", options->b, "Model or surface to compare with.")->type_name("FILE")->required();
    add_count(verb, "--samples", options->samples, 1, 100'000'000,
              "Points on each surface at which the distance is measured, besides the vertices, 1 to "
              "100000000. Default: 100000.");
    group_new_options(verb, option_group::method);
    return [options](Session& session) { return run_compare(*options, session); };
}

}  // namespace anatomesh
