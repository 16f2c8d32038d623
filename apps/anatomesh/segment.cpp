// anatomesh segment: one structure of a grey image, as a label map or as contours.
#include "anatomesh_io/segment/segment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "anatomesh/contour/trace.h"
#include "anatomesh/image/components.h"
#include "anatomesh_io/contour/write_contours.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/image/write_image.h"
#include "answer.h"
#include "input_options.h"
#include "option_values.h"
#include "outputs.h"
#include "plural.h"
#include "read_input.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct SegmentVerbOptions {
    InputOptions input;  // of which threshold and keep_largest are used as well
    std::string output, method, name = "structure";
    std::uint32_t number = 1;
    std::vector<Vec3> seeds;        // LPS mm
    std::vector<Vec3> voxel_seeds;  // whole numbers
    std::optional<double> radius_mm, spread, curvature;
    std::optional<std::uint32_t> iterations;
    CleanMaskOptions cleaning;
};

constexpr std::pair<const char*, SegmentMethod> methods[] = {
    {"threshold", SegmentMethod::threshold}, {"otsu", SegmentMethod::otsu},
    {"grow", SegmentMethod::grow},           {"confidence", SegmentMethod::confidence},
    {"region", SegmentMethod::region},       {"geodesic", SegmentMethod::geodesic}};

const std::vector<std::string> label_extensions{".nrrd", ".nii", ".nii.gz"};

Error usage_error(const char* code, std::string message, const SegmentVerbOptions& options, std::string value,
                  std::string next_step) {
    return {ErrorKind::usage,
            code,
            std::move(message),
            {options.input.input, "", "", "", std::move(value)},
            std::move(next_step)};
}

// The method, as given or as the other options imply it.
std::string method_of(const SegmentVerbOptions& options) {
    if (!options.method.empty()) return options.method;
    const bool seeded = !options.seeds.empty() || !options.voxel_seeds.empty();
    if (options.input.threshold) return seeded ? "grow" : "threshold";
    return seeded ? "geodesic" : "otsu";
}

// Options that the method cannot do without, or has no use for.
Status check_method(const SegmentVerbOptions& options, const std::string& name, SegmentMethod method) {
    const bool seeded = !options.seeds.empty() || !options.voxel_seeds.empty();
    const bool ranged = method == SegmentMethod::threshold || method == SegmentMethod::grow;
    const bool grows = method != SegmentMethod::threshold && method != SegmentMethod::otsu;
    const bool moves = method == SegmentMethod::region || method == SegmentMethod::geodesic;
    const bool spreads = moves || method == SegmentMethod::confidence;
    if (grows && !seeded)
        return usage_error("E-SGM-005", "this method grows from a seed, and there is none", options, name,
                           "give --seed X,Y,Z inside the structure, LPS mm");
    if (ranged && !options.input.threshold)
        return usage_error("E-SGM-006", "this method needs a range of values", options, name,
                           "give --threshold LO[:HI]");
    const std::pair<const char*, bool> useless[] = {{"--threshold", options.input.threshold && !ranged},
                                                    {"--seed", seeded && !grows},
                                                    {"--spread", options.spread && !spreads},
                                                    {"--seed-radius", options.radius_mm && !spreads},
                                                    {"--curvature", options.curvature && !moves},
                                                    {"--iterations", options.iterations && !moves}};
    for (const auto& [option, given] : useless) {
        if (given)
            return usage_error("E-CMD-008", fmt::format("{} does not apply to this method", option), options,
                               name, fmt::format("leave out {}, or choose another --method", option));
    }
    return Nothing{};
}

// The voxel, in fractions, that a position lies at.
Vec3 voxel_at(const ImageGeometry& geometry, Vec3 position) {
    const Vec3 w = position - geometry.origin, a = geometry.step[0], b = geometry.step[1],
               c = geometry.step[2];
    const double volume = dot(a, cross(b, c));
    return {dot(w, cross(b, c)) / volume, dot(a, cross(w, c)) / volume, dot(a, cross(b, w)) / volume};
}

Status add_seed(Vec3 voxel, const std::string& text, const SegmentVerbOptions& options,
                const ImageGeometry& geometry, SegmentOptions& segmenting) {
    const std::array<double, 3> at = {std::round(voxel.x), std::round(voxel.y), std::round(voxel.z)};
    std::array<std::uint32_t, 3> seed{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!(at[axis] >= 0 && at[axis] < geometry.size[axis]))
            return usage_error(
                "E-SGM-007", "a seed lies outside of the image", options,
                fmt::format("{}, which is voxel {:.0f}, {:.0f}, {:.0f} of {} x {} x {}", text, at[0], at[1],
                            at[2], geometry.size[0], geometry.size[1], geometry.size[2]),
                "--seed takes LPS mm (x to the left, y to the back), --seed-voxel indices from 0");
        seed[axis] = static_cast<std::uint32_t>(at[axis]);
    }
    segmenting.seeds.push_back(seed);
    return Nothing{};
}

Status add_seeds(const SegmentVerbOptions& options, const ImageGeometry& geometry,
                 SegmentOptions& segmenting) {
    const auto text = [](Vec3 v) { return fmt::format("{},{},{}", v.x, v.y, v.z); };
    for (const Vec3 seed : options.seeds) {
        ANATOMESH_CHECK_STATUS(add_seed(voxel_at(geometry, seed), text(seed), options, geometry, segmenting));
    }
    for (const Vec3 seed : options.voxel_seeds) {
        ANATOMESH_CHECK_STATUS(add_seed(seed, text(seed), options, geometry, segmenting));
    }
    return Nothing{};
}

Result<SegmentOptions> segmenting_of(const SegmentVerbOptions& options, SegmentMethod method,
                                     const ImageGeometry& geometry) {
    SegmentOptions segmenting;
    segmenting.method = method;
    if (options.input.threshold) {
        segmenting.low = options.input.threshold->low;
        segmenting.high = options.input.threshold->high;
    }
    if (options.radius_mm) segmenting.seed_radius_mm = *options.radius_mm;
    if (options.spread) segmenting.spread = *options.spread;
    if (options.curvature) segmenting.curvature = *options.curvature;
    if (options.iterations) segmenting.iterations = *options.iterations;
    ANATOMESH_CHECK_STATUS(add_seeds(options, geometry, segmenting));
    return segmenting;
}

Result<std::string> file_of(const Segmentation& segmentation, SegmentMethod method, const GreyImage& image,
                            const std::string& path, RunContext& context) {
    if (check_extension(path, label_extensions).ok()) {
        ANATOMESH_TRY(const ImageFormat format, image_format_of(path));
        return format_label_map(segmentation.labels, format);
    }
    ANATOMESH_TRY(const ContourFormat format, contour_format_of(path));
    // Where a threshold bounds the structure its contours follow the threshold within the pixels.
    const bool by_value =
        method == SegmentMethod::threshold || method == SegmentMethod::otsu || method == SegmentMethod::grow;
    ANATOMESH_TRY(const TraceResult traced,
                  trace_contours(segmentation.labels, by_value ? &image : nullptr,
                                 by_value ? segmentation.low.value_or(0) : 0, {}, context));
    return format_contours(traced.kept, format, context);
}

Result<OpenedInput> open_grey(const SegmentVerbOptions& options, RunContext& context) {
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    ANATOMESH_CHECK_STATUS(check_outputs(names_of(opened.files), {options.output}));
    if (opened.image) return opened;
    return Error{ErrorKind::input,
                 "E-SGM-008",
                 "there is no image to segment in the input",
                 {options.input.input, "", "", "", ""},
                 "give a grey image; contours and segmentations are inputs of contours and model"};
}

Status run_segment(SegmentVerbOptions options, Session& session) {
    RunContext& context = session.context;
    options.input.limits = session.limits;
    ANATOMESH_CHECK_STATUS(
        check_extension(options.output, {".nrrd", ".nii", ".nii.gz", ".json", ".vtp", ".csl"}));
    ANATOMESH_CHECK_STATUS(check_outputs({options.input.input}, {options.output}));
    const std::string name = method_of(options);
    const SegmentMethod method = std::find_if(std::begin(methods), std::end(methods), [&](const auto& entry) {
                                     return entry.first == name;
                                 })->second;
    ANATOMESH_CHECK_STATUS(check_method(options, name, method));
    ANATOMESH_TRY(const OpenedInput opened, open_grey(options, context));
    const GreyImage& image = opened.image->image;
    ANATOMESH_TRY(const SegmentOptions segmenting, segmenting_of(options, method, image.geometry));
    ANATOMESH_TRY(Segmentation segmentation, segment_image(image, segmenting, context));
    LabelMap& labels = segmentation.labels;
    labels.structures[0].name = options.name;
    labels.structures[0].number = static_cast<std::int32_t>(options.number);
    ANATOMESH_CHECK_STATUS(clean_mask(labels, options.cleaning, context));
    if (options.input.keep_largest) keep_largest(labels, *options.input.keep_largest);
    ANATOMESH_TRY(const std::string bytes, file_of(segmentation, method, image, options.output, context));
    if (context.cancelled()) return cancelled_error();
    AtomicFileSet files;
    ANATOMESH_CHECK_STATUS(files.add(options.output, bytes));

    const auto voxels = labels.voxels.size() -
                        static_cast<std::size_t>(std::count(labels.voxels.begin(), labels.voxels.end(), 0));
    const auto& step = labels.geometry.step;
    const double volume = static_cast<double>(voxels) * std::abs(dot(step[0], cross(step[1], step[2])));
    nlohmann::ordered_json answer;
    answer["version"] = ANATOMESH_VERSION;
    answer["output"] = options.output;
    answer["inputs"] = inputs_json(opened.files);
    answer["method"] = name;
    if (segmentation.low) answer["low"] = *segmentation.low;
    if (segmentation.high && std::isfinite(*segmentation.high)) answer["high"] = *segmentation.high;
    if (segmentation.iterations > 0) answer["iterations"] = segmentation.iterations;
    answer["voxels"] = voxels;
    answer["volume_mm3"] = volume;
    return files.commit([&] {
        return give_summary(session, answer,
                            fmt::format("{}: {} by {}, {}, {:.6g} ml\n", options.output, options.name, name,
                                        counted(voxels, "voxel"), volume / 1000));
    });
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

void add_optional(CLI::App& verb, const std::string& name, std::optional<double>& target, double low,
                  double high, const std::string& unit, const std::string& description) {
    const auto read = [name, &target, low, high](const std::string& text) {
        target = strict_number(name, text, low, high);
    };
    verb.add_option_function<std::string>(name, read, description)->type_name(unit);
}

void add_method_options(CLI::App& verb, SegmentVerbOptions& options) {
    add_choice(
        verb, "--method", options.method, {"threshold", "otsu", "grow", "confidence", "region", "geodesic"},
        "How: all voxels of a range; above Otsu's threshold; joined to a seed within a range, or within "
        "a range found there; active contour from a seed, by region or by edges (default: by the "
        "options given: threshold with --threshold, grow with --seed too, geodesic with --seed, else otsu)");
    add_threshold_option(verb, options.input);
    add_triples(verb, "--seed", options.seeds, "X,Y,Z", false,
                "A point inside the structure, LPS mm; may be repeated");
    add_triples(verb, "--seed-voxel", options.voxel_seeds, "I,J,K", true,
                "The same as voxel indices, from 0; may be repeated");
    const SegmentOptions defaults;
    add_optional(verb, "--seed-radius", options.radius_mm, 0.01, 1000, "MM",
                 fmt::format("Radius of the balls around seeds that confidence, region and geodesic begin "
                             "with, 0.01 to 1000 (default {})",
                             defaults.seed_radius_mm));
    add_optional(verb, "--spread", options.spread, 0.01, 100, "N",
                 fmt::format("Standard deviations of the values around the seeds that belong to the "
                             "structure, 0.01 to 100 (default {})",
                             defaults.spread));
    add_optional(verb, "--curvature", options.curvature, 0, 100, "W",
                 fmt::format("Smoothness of active contours, 0 to 100 (default {})", defaults.curvature));
    verb.add_option_function<std::string>(
            "--iterations",
            [&options](const std::string& text) {
                options.iterations = strict_count("--iterations", text, 1, 100000);
            },
            fmt::format("Steps of active contours, at most, 1 to 100000 (default {})", defaults.iterations))
        ->type_name("N");
}

}  // namespace

Work declare_segment(CLI::App& verb) {
    auto options = std::make_shared<SegmentVerbOptions>();
    add_reading_options(verb, options->input);
    add_method_options(verb, *options);
    add_number(verb, "--median", options->cleaning.median_mm, 0, 100, "MM",
               "Median filter of this radius on the result, 0 to 100 (default 0: none)");
    add_number(verb, "--open", options->cleaning.open_mm, 0, 100, "MM",
               "Opening by a ball of this radius: takes away what is thinner, 0 to 100 (default 0: none)");
    add_number(verb, "--close", options->cleaning.close_mm, 0, 100, "MM",
               "Closing by a ball of this radius: fills what is narrower, 0 to 100 (default 0: none)");
    verb.add_flag("--fill-holes", options->cleaning.fill_holes, "Fill what the structure encloses");
    add_keep_largest_option(verb, options->input);
    add_text(verb, "--name", options->name, "NAME", "Name of the structure (default structure)");
    add_count(verb, "--number", options->number, 1, 65535,
              "Number of the structure, its value in a label map (default 1)");
    add_text(verb, "-o,--output", options->output, "OUT",
             "File to write: .nrrd, .nii or .nii.gz (label map), or .json, .vtp or .csl (contours)")
        ->required();
    return [options](Session& session) { return run_segment(*options, session); };
}

}  // namespace anatomesh
