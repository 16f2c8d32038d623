// anatomesh segment: structures of a grey image, as a label map or as contours.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "anatomesh/base/plural.h"
#include "anatomesh/contour/trace/trace.h"
#include "anatomesh_io/contour/write_contours.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/image/tracked_frames.h"
#include "anatomesh_io/image/write_image.h"
#include "anatomesh_io/segment/segment_slices.h"
#include "answer.h"
#include "help_text.h"
#include "input_options.h"
#include "option_values.h"
#include "outputs.h"
#include "read_input.h"
#include "segment_task.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct SegmentVerbOptions {
    InputOptions input;  // of which threshold and keep_largest are used as well
    std::string output, recipe;
    SegmentTask task;
    double despeckle_mm = 0;
};

const std::vector<std::string> label_extensions{".nrrd", ".nii", ".nii.gz"};

Result<LoadedImage> open_grey(const SegmentVerbOptions& options, std::vector<InputReport>& files,
                              RunContext& context) {
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    ANATOMESH_CHECK_STATUS(check_outputs(names_of(opened.files), {options.output}));
    if (!opened.image)
        return Error{ErrorKind::input,
                     "E-SGM-008",
                     "the input holds no image to segment",
                     {options.input.input, "", "", "", ""},
                     "give a grey image; use contours and segmentations with anatomesh model"};
    files = std::move(opened.files);
    LoadedImage& image = *opened.image;
    if (!image.poses.empty()) {
        if (check_extension(options.output, label_extensions).ok())
            return Error{ErrorKind::usage,
                         "E-SGM-010",
                         "a tracked sequence of frames cannot become a label map",
                         {options.output, "", "", "", ""},
                         "choose an output for contours: .json, .vtp or .csl"};
        // Each slice is treated in its plane, by the size of its pixels.
        const FramePose& first = image.poses[0];
        image.image.geometry.step = {Vec3{length(first.step[0]), 0, 0}, Vec3{0, length(first.step[1]), 0},
                                     Vec3{0, 0, 1}};
    }
    if (!image.known_axes && check_extension(options.output, label_extensions).ok())
        return Error{ErrorKind::usage,
                     "E-CMD-018",
                     "the axes of the image are unknown, and label maps need them",
                     {options.input.input, "", "", "", ""},
                     "give --frame LPS or --frame RAS"};
    if (options.despeckle_mm > 0) {
        ANATOMESH_CHECK_STATUS(reduce_speckle(image.image, options.despeckle_mm, context));
    }
    return std::move(image);
}

LabelMap sorted_by_number(LabelMap labels) {
    std::vector<std::uint16_t> order(labels.structures.size()), new_label(labels.structures.size() + 1, 0);
    for (std::size_t s = 0; s < order.size(); ++s) order[s] = static_cast<std::uint16_t>(s);
    std::sort(order.begin(), order.end(),
              [&](auto a, auto b) { return labels.structures[a].number < labels.structures[b].number; });
    std::vector<Structure> sorted;
    for (std::size_t s = 0; s < order.size(); ++s) {
        sorted.push_back(labels.structures[order[s]]);
        new_label[order[s] + 1u] = static_cast<std::uint16_t>(s + 1);
    }
    labels.structures = std::move(sorted);
    for (std::uint16_t& voxel : labels.voxels) voxel = new_label[voxel];
    return labels;
}

// One label map of all; where two structures meet the voxel is that of the first, and the other has the
// fewer.
Result<LabelMap> joined(std::vector<TaskResult>& results, const std::vector<SegmentTask>& tasks,
                        const std::string& source, RunContext& context) {
    LabelMap all = std::move(results[0].segmentation.labels);
    for (std::size_t r = 1; r < results.size(); ++r) {
        const LabelMap& one = results[r].segmentation.labels;
        all.structures.push_back(one.structures[0]);
        const auto label = static_cast<std::uint16_t>(all.structures.size());
        std::uint64_t taken = 0;
        for (std::size_t n = 0; n < all.voxels.size(); ++n) {
            if (one.voxels[n] == 0) continue;
            if (all.voxels[n] == 0)
                all.voxels[n] = label;
            else
                ++taken;
        }
        if (taken == 0) continue;
        const std::string found = fmt::format("{} of {} voxels", taken, results[r].voxels);
        if (taken == results[r].voxels)
            return Error{ErrorKind::geometry,
                         "E-SGM-014",
                         "all of the structure belongs to earlier structures of the recipe",
                         {source, "", tasks[r].name, "", found},
                         "put it before them in the recipe, or give it another threshold, seed or box"};
        context.warn({"W-SGM-004",
                      "a part of the structure belongs to earlier structures of the recipe",
                      {source, "", tasks[r].name, "", found},
                      "the earlier structures keep it"});
        results[r].voxels -= taken;
    }
    constexpr std::array<std::array<std::uint8_t, 3>, 6> colors{
        {{230, 200, 120}, {200, 80, 60}, {90, 150, 210}, {120, 180, 90}, {190, 120, 200}, {220, 150, 70}}};
    for (std::size_t s = 0; s < all.structures.size(); ++s)
        all.structures[s].color = colors[s % colors.size()];
    return sorted_by_number(std::move(all));
}

Result<std::string> file_of(const LabelMap& labels, const std::vector<TaskResult>& results,
                            const LoadedImage& image, const std::string& path, RunContext& context) {
    if (check_extension(path, label_extensions).ok()) {
        ANATOMESH_TRY(const ImageFormat format, image_format_of(path));
        std::string how = "version " ANATOMESH_VERSION ", segment";
        for (const TaskResult& result : results) how += " " + result.method;
        return format_label_map(labels, format, how);
    }
    ANATOMESH_TRY(const ContourFormat format, contour_format_of(path));
    // Where a threshold bounds the structure its contours follow the threshold within the pixels.
    const bool by_value = results.size() == 1 && results[0].by_value;
    const GreyImage* grey = by_value ? &image.image : nullptr;
    const double level = by_value ? results[0].segmentation.low.value_or(0) : 0;
    const Frame frame = image.known_axes ? Frame::lps : Frame::unknown;
    ANATOMESH_TRY(TraceResult traced, image.poses.empty() ? trace_contours(labels, grey, level, {}, context)
                                                          : trace_frames(labels, image.poses, frame, grey,
                                                                         level, 0, {}, context));
    traced.kept.frame = frame;
    return format_contours(traced.kept, format, context);
}

nlohmann::ordered_json json_of(const TaskResult& result, double voxel_mm3) {
    nlohmann::ordered_json json;
    json["method"] = result.method;
    const Segmentation& found = result.segmentation;
    if (found.low) json["low"] = *found.low;
    if (found.high && std::isfinite(*found.high)) json["high"] = *found.high;
    if (found.iterations > 0) json["iterations"] = found.iterations;
    json["voxels"] = result.voxels;
    if (voxel_mm3 > 0) json["volume_mm3"] = static_cast<double>(result.voxels) * voxel_mm3;
    return json;
}

Result<std::vector<SegmentTask>> tasks_of(const SegmentVerbOptions& options) {
    if (!options.recipe.empty()) return read_recipe(options.recipe, options.input.limits.input);
    SegmentTask task = options.task;
    task.threshold = options.input.prepare.label_maps.threshold;
    task.keep_largest = options.input.prepare.label_maps.keep_largest;
    return std::vector{task};
}

// Of several, errors and warnings name the structure.
Result<std::vector<TaskResult>> run_tasks(const std::vector<SegmentTask>& tasks, const LoadedImage& image,
                                          RunContext& context) {
    std::vector<TaskResult> results;
    for (const SegmentTask& task : tasks) {
        const std::size_t before = context.warnings.size();
        Result<TaskResult> result = run_task(task, image, context);
        const std::string name = tasks.size() > 1 ? task.name : "";
        for (std::size_t w = before; w < context.warnings.size(); ++w)
            if (context.warnings[w].place.structure.empty()) context.warnings[w].place.structure = name;
        if (!result.ok()) {
            Error error = result.error();
            if (error.place.structure.empty()) error.place.structure = name;
            return error;
        }
        results.push_back(std::move(result).value());
    }
    return results;
}

Status run_segment(SegmentVerbOptions options, Session& session) {
    RunContext& context = session.context;
    options.input.limits = session.limits;
    ANATOMESH_CHECK_STATUS(
        check_extension(options.output, {".nrrd", ".nii", ".nii.gz", ".json", ".vtp", ".csl"}));
    std::vector<std::string> read{options.input.input};
    if (!options.recipe.empty()) read.push_back(options.recipe);
    ANATOMESH_CHECK_STATUS(check_outputs(read, {options.output}));
    ANATOMESH_TRY(const std::vector<SegmentTask> tasks, tasks_of(options));
    std::vector<InputReport> inputs;
    ANATOMESH_TRY(const LoadedImage image, open_grey(options, inputs, context));
    ANATOMESH_TRY(std::vector<TaskResult> results, run_tasks(tasks, image, context));
    ANATOMESH_TRY(const LabelMap labels, joined(results, tasks, image.image.source, context));
    const auto& step = image.image.geometry.step;
    const double voxel_mm3 = image.poses.empty() ? std::abs(dot(step[0], cross(step[1], step[2]))) : 0;
    nlohmann::ordered_json answer;
    answer["version"] = ANATOMESH_VERSION;
    answer["output"] = options.output;
    answer["inputs"] = inputs_json(inputs);
    std::string text;
    for (std::size_t r = 0; r < results.size(); ++r) {
        nlohmann::ordered_json one = json_of(results[r], voxel_mm3);
        text += fmt::format("{}: {} by {}, {}", options.output, on_one_line(tasks[r].name), results[r].method,
                            counted(results[r].voxels, voxel_mm3 > 0 ? "voxel" : "pixel"));
        text += voxel_mm3 > 0
                    ? fmt::format(", {:.6g} ml\n", static_cast<double>(results[r].voxels) * voxel_mm3 / 1000)
                    : std::string("\n");
        if (options.recipe.empty()) {
            answer.update(one);
            continue;
        }
        nlohmann::ordered_json named{{"name", tasks[r].name}, {"number", tasks[r].number}};
        named.update(one);
        answer["structures"].push_back(std::move(named));
    }
    ANATOMESH_TRY(const std::string bytes, file_of(labels, results, image, options.output, context));
    if (context.cancelled()) return cancelled_error();
    AtomicFileSet files;
    ANATOMESH_CHECK_STATUS(files.add(options.output, bytes));
    return files.commit([&] { return give_summary(session, answer, text); });
}

// Three numbers between commas.
Vec3 triple_of(const std::string& option, const std::string& text, double low, double high, bool whole) {
    std::array<double, 3> values{};
    std::size_t begin = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t comma = text.find(',', begin);
        if ((comma == std::string::npos) != (i == 2))
            throw CLI::ValidationError(option, fmt::format("'{}' is not three numbers as 1,2,3", text));
        const std::string part = text.substr(begin, comma - begin);
        values[i] = whole ? strict_count(option, part, 0, 1'000'000) : strict_number(option, part, low, high);
        begin = comma + 1;
    }
    return {values[0], values[1], values[2]};
}

void add_triples(CLI::App& verb, const std::string& name, std::vector<Vec3>& target, const std::string& type,
                 bool whole, const std::string& description) {
    const auto read = [name, &target, whole](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) target.push_back(triple_of(name, text, -1e7, 1e7, whole));
    };
    verb.add_option_function<std::vector<std::string>>(name, read, description)
        ->type_name(type)
        ->allow_extra_args(false);
}

void add_within(CLI::App& verb, std::vector<Vec3>& corners) {
    const auto read = [&corners](const std::string& text) {
        const std::size_t colon = text.find(':');
        if (colon == std::string::npos)
            throw CLI::ValidationError("--within",
                                       fmt::format("'{}' is not two corners as 1,2,3:4,5,6", text));
        corners = {triple_of("--within", text.substr(0, colon), -1e7, 1e7, false),
                   triple_of("--within", text.substr(colon + 1), -1e7, 1e7, false)};
    };
    verb.add_option_function<std::string>("--within", read,
                                          "Search only between these two corners of a box, in mm (LPS). The "
                                          "box is parallel to the image axes.")
        ->type_name("X,Y,Z:X,Y,Z");
}

void add_optional(CLI::App& verb, const std::string& name, std::optional<double>& target, double low,
                  double high, const std::string& unit, const std::string& description) {
    const auto read = [name, &target, low, high](const std::string& text) {
        target = strict_number(name, text, low, high);
    };
    verb.add_option_function<std::string>(name, read, description)->type_name(unit);
}

void add_method_options(CLI::App& verb, SegmentVerbOptions& options) {
    add_choice(verb, "--method", options.task.method, segment_methods,
               "How the structure is found. Default: threshold with --threshold, grow with --threshold and "
               "--seed, geodesic "
               "with --seed alone, otherwise otsu.");
    group_new_options(verb, option_group::method);
    add_threshold_option(verb, options.input);
    verb.get_option("--threshold")->group(option_group::method);
    add_triples(verb, "--seed", options.task.seeds, "X,Y,Z", false,
                "A point inside the structure, in mm (LPS). Repeatable.");
    add_triples(verb, "--seed-voxel", options.task.voxel_seeds, "I,J,K", true,
                "A point inside the structure, as voxel indices from 0. Repeatable.");
    add_within(verb, options.task.within);
    const SegmentOptions defaults;
    add_optional(
        verb, "--seed-radius", options.task.radius_mm, 0.01, 1000, "MM",
        fmt::format(
            "Radius of the ball around each seed at which the methods confidence, region and geodesic "
            "start, 0.01 to 1000 mm. Default: {}.",
            defaults.seed_radius_mm));
    add_optional(
        verb, "--spread", options.task.spread, 0.01, 100, "N",
        fmt::format(
            "Voxels belong to the structure if they differ from the mean at the seeds by at most this "
            "many standard deviations, 0.01 to 100. Default: {}.",
            defaults.spread));
    add_optional(verb, "--curvature", options.task.curvature, 0, 100, "W",
                 fmt::format("Smoothness of active contours, 0 to 100. Default: {}.", defaults.curvature));
    verb.add_option_function<std::string>(
            "--iterations",
            [&options](const std::string& text) {
                options.task.iterations = strict_count("--iterations", text, 1, 100000);
            },
            fmt::format("Largest number of steps of active contours, 1 to 100000. Default: {}.",
                        defaults.iterations))
        ->type_name("N");
    group_new_options(verb, option_group::method);
}

}  // namespace

Work declare_segment(CLI::App& verb) {
    auto options = std::make_shared<SegmentVerbOptions>();
    add_reading_options(verb, options->input);
    add_method_options(verb, *options);
    add_number(verb, "--median", options->task.cleaning.median_mm, 0, 100, "MM",
               "Smooth the result by a median filter of this radius, 0 to 100 mm. Default: 0, none.");
    add_number(verb, "--open", options->task.cleaning.open_mm, 0, 100, "MM",
               "Remove parts thinner than a ball of this radius (opening), 0 to 100 mm. Default: 0, none.");
    add_number(verb, "--close", options->task.cleaning.close_mm, 0, 100, "MM",
               "Fill gaps narrower than a ball of this radius (closing), 0 to 100 mm. Default: 0, none.");
    verb.add_flag("--fill-holes", options->task.cleaning.fill_holes,
                  "Fill holes that the structure encloses on all sides.");
    group_new_options(verb, option_group::clean_up);
    add_keep_largest_option(verb, options->input);
    verb.get_option("--keep-largest")->group(option_group::clean_up);
    add_text(verb, "--name", options->task.name, "NAME", "Name of the structure. Default: structure.");
    add_count(verb, "--number", options->task.number, 1, 65535,
              "Number of the structure, which is its value in a label map, 1 to 65535. Default: 1.");
    group_new_options(verb, option_group::outputs);
    verb.add_flag("--per-slice", options->task.per_slice,
                  "Work slice by slice. With seeds the result of each slice starts the next one.");
    add_number(verb, "--despeckle", options->despeckle_mm, 0, 100, "MM",
               "First replace each pixel by the median within this radius in its slice, 0 to 100 mm. "
               "Default: 0, none.");
    add_text(verb, "--recipe", options->recipe, "FILE",
             "Find several structures in one run: a .json file with the options of each (docs/formats.md).")
        ->excludes("--method", "--threshold", "--seed", "--seed-voxel", "--within", "--seed-radius",
                   "--spread", "--curvature", "--iterations", "--median", "--open", "--close", "--fill-holes",
                   "--keep-largest", "--name", "--number", "--per-slice");
    group_new_options(verb, option_group::method);
    add_text(verb, "-o,--output", options->output, "OUT",
             "The result to write: .nrrd, .nii or .nii.gz for a label map, .json, .vtp or .csl for contours.")
        ->required();
    group_new_options(verb, option_group::outputs);
    return [options](Session& session) { return run_segment(*options, session); };
}

}  // namespace anatomesh
