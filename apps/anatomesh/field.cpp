// anatomesh field: the bit volume or the distance map of contours, as an image.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "anatomesh/base/plural.h"
#include "anatomesh/field/slice/slice_stack.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/image/write_image.h"
#include "anatomesh_io/report/options_json.h"
#include "answer.h"
#include "field_options.h"
#include "help_text.h"
#include "input_options.h"
#include "option_values.h"
#include "outputs.h"
#include "read_input.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct FieldVerbOptions {
    InputOptions input;
    std::string output, what = "distance";
    double pixel_mm = 0;  // 0: that of the source, or one found
    double slice_mm = 0;  // of one slice alone; 0: as the source states it
};

Result<std::string> distance_file(const ContourSet& contours, const SliceStack& stack, ImageFormat format,
                                  RunContext& context) {
    const std::vector<float> image = distance_image(contours, stack, 0, context);
    if (context.cancelled()) return cancelled_error();
    return format_image(stack.geometry, image, format, "version " ANATOMESH_VERSION ", distance map in mm");
}

Result<std::string> bits_file(const ContourSet& contours, const SliceStack& stack, ImageFormat format,
                              RunContext& context) {
    std::uint64_t overlaps = 0;
    const LabelMap bits = bit_image(contours, stack, context, &overlaps);
    if (context.cancelled()) return cancelled_error();
    if (overlaps > 0)
        context.warn({"W-CMD-004",
                      "some pixels lie in several structures, but the image holds one number per pixel",
                      {contours.source, "", "", "", fmt::format("{}", overlaps)},
                      "they hold the number of the last structure; --structure chooses one"});
    return format_label_map(bits, format, "version " ANATOMESH_VERSION ", bit volume");
}

// A distance map is of one structure.
Status check_structures(const ContourSet& contours, const FieldVerbOptions& options) {
    if (options.what != "distance" || contours.structures.size() == 1) return Nothing{};
    return Error{
        ErrorKind::usage,
        "E-CMD-019",
        fmt::format("a distance map shows one structure, but the input has {}", contours.structures.size()),
        {options.input.input, "", "", "", ""},
        "choose one with --structure, or give --what bits"};
}

Status run_field(FieldVerbOptions options, Session& session) {
    RunContext& context = session.context;
    options.input.limits = session.limits;
    options.input.prepare.until = PrepareUntil::walls;
    ANATOMESH_TRY(const ImageFormat format, image_format_of(options.output));
    ANATOMESH_CHECK_STATUS(check_extension(options.output, {".nrrd", ".nii", ".nii.gz"}));
    ANATOMESH_CHECK_STATUS(check_outputs({options.input.input}, {options.output}));
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    ANATOMESH_CHECK_STATUS(check_outputs(names_of(opened.files), {options.output}));
    ANATOMESH_TRY(const InputContours contours, contours_of(std::move(opened), options.input, context));
    ANATOMESH_CHECK_STATUS(check_structures(contours.kept, options));
    if (options.slice_mm > 0 && contours.kept.slices.size() > 1)
        return slice_thickness_without_use(options.input.input,
                                           "there are several slices, and an image takes their spacing");
    if (context.cancelled()) return cancelled_error();

    SliceStackOptions placing;
    placing.pixel_mm = options.pixel_mm;
    placing.slice_mm = options.slice_mm;
    placing.max_voxels = options.input.limits.voxels;
    ANATOMESH_TRY(const SliceStack stack, slice_stack(contours.kept, placing, context));
    const auto make = options.what == "bits" ? bits_file : distance_file;
    ANATOMESH_TRY(const std::string bytes, make(contours.kept, stack, format, context));
    AtomicFileSet files;
    ANATOMESH_CHECK_STATUS(files.add(options.output, bytes));

    const auto& size = stack.geometry.size;
    const double pixel = stack.grid.step.x, spacing = length(stack.geometry.step[2]);
    nlohmann::ordered_json answer;
    answer["version"] = ANATOMESH_VERSION;
    answer["output"] = options.output;
    answer["inputs"] = inputs_json(contours.files);
    answer["options"] = options_json(contours.options);
    answer["what"] = options.what;
    answer["size"] = size;
    answer["pixel_mm"] = pixel;
    answer["spacing_mm"] = spacing;
    return files.commit([&] {
        return give_summary(
            session, answer,
            fmt::format("{}: {} of {}, {} x {} x {} voxels of {:.6g} x {:.6g} x {:.6g} mm\n", options.output,
                        options.what == "bits" ? "bit volume" : "distance map",
                        counted(contours.kept.structures.size(), "structure"), size[0], size[1], size[2],
                        pixel, pixel, spacing));
    });
}

}  // namespace

Work declare_field(CLI::App& verb) {
    auto options = std::make_shared<FieldVerbOptions>();
    add_reading_options(verb, options->input);
    add_selection_options(verb, options->input);
    add_cleaning_options(verb, options->input);
    add_text(verb, "-o,--output", options->output, "OUT", "The image to write: .nrrd, .nii or .nii.gz.")
        ->required();
    add_choice(verb, "--what", options->what, {"bits", "distance"},
               "distance: distance from the contours in mm, negative inside, of one structure. bits: the "
               "number of the "
               "structure in every pixel. Default: distance.");
    add_number(verb, "--pixel", options->pixel_mm, 1e-3, 1e3, "MM",
               "Pixel size of the image, 0.001 to 1000 mm. Default: that of the source, otherwise chosen "
               "from the contours.");
    add_slice_thickness_option(verb, options->slice_mm,
                               "Thickness of a single slice. Default: as the source states it, else a pixel");
    group_new_options(verb, option_group::outputs);
    return [options](Session& session) { return run_field(*options, session); };
}

}  // namespace anatomesh
