#include "element_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "anatomesh/base/plural.h"
#include "anatomesh/pipeline/grey_of_model.h"
#include "help_text.h"
#include "option_values.h"
#include "read_input.h"

namespace anatomesh {

namespace {

using Clock = std::chrono::steady_clock;

StageReport stage_of(const char* name, Clock::time_point start, const ModelFile& model) {
    StageReport stage;
    stage.name = name;
    stage.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    stage.points = model.mesh.points.size() + model.mid_nodes.points.size();
    stage.cells = model.mesh.cells.size();
    return stage;
}

// `again`: the image was read before in this run, which has said what there is to say of it.
Status add_grey(ModelFile& model, const InputOptions& image, bool again, Session& session, CellValues& done) {
    const auto start = Clock::now();
    const std::size_t said = session.context.warnings.size();
    ANATOMESH_TRY(const OpenedInput opened, open_input(image, session.context));
    if (again) session.context.warnings.resize(said);
    if (!opened.image || !opened.image->poses.empty()) {
        return Error{ErrorKind::input,
                     "E-CMD-012",
                     "the file holds no grey values",
                     {image.input, "", "", "", ""},
                     "give the image that the model was made from"};
    }
    ANATOMESH_TRY(GreyOfModel grey,
                  grey_of_model(model.mesh, opened.image->image, image.input, session.context));
    model.grey = std::move(grey.values);
    if (!again) done.files.insert(done.files.end(), opened.files.begin(), opened.files.end());
    StageReport stage = stage_of("grey", start, model);
    stage.figures = std::move(grey.stage.figures);
    done.stages.push_back(std::move(stage));
    return Nothing{};
}

Status add_materials(ModelFile& model, const MaterialFile& laws, std::span<const Structure> others,
                     CellValues& done) {
    const auto start = Clock::now();
    ANATOMESH_CHECK_STATUS(apply_materials(model, laws, others));
    const std::vector<Material>& materials = model.description.materials;
    double low = materials.empty() ? 0 : materials.front().young_mpa, high = low;
    for (const Material& material : materials) {
        low = std::min(low, material.young_mpa);
        high = std::max(high, material.young_mpa);
    }
    StageReport stage = stage_of("material", start, model);
    stage.figures = {{"materials", static_cast<double>(materials.size())},
                     {"young_low_mpa", low},
                     {"young_high_mpa", high}};
    done.stages.push_back(std::move(stage));
    done.materials = material_ranges(model);
    done.files.push_back({laws.path, "material laws", laws.sha256, laws.bytes});
    return Nothing{};
}

Error without_grey(const ElementOptions& options) {
    return {ErrorKind::usage,
            "E-CMD-008",
            "a material law needs grey values, and the model has none",
            {options.material, "", "", "", "--material"},
            "give the image with --grey"};
}

}  // namespace

std::vector<std::string> ElementOptions::inputs() const {
    std::vector<std::string> files;
    if (!grey.empty()) files.push_back(grey);
    if (!material.empty()) files.push_back(material);
    return files;
}

std::string materials_text(const std::vector<MaterialRange>& materials) {
    std::string text;
    for (const MaterialRange& range : materials)
        text += fmt::format("  material of {}: {}, {:.1f} mm3, E {:.4g} to {:.4g} MPa\n",
                            on_one_line(range.structure), counted(range.materials, "material"),
                            range.volume_mm3, range.young_low_mpa, range.young_high_mpa);
    return text;
}

void add_element_options(CLI::App& verb, ElementOptions& options) {
    add_count(verb, "--order", options.order, 1, 2,
              "Nodes per tetrahedron: 1 gives four, 2 gives ten, with the middle nodes of the surface on the "
              "smooth "
              "surface. Default: 1.");
    add_text(verb, "--grey", options.grey, "IMAGE",
             "Store in every tetrahedron its mean grey value in this image (HU in a CT).");
    add_text(verb, "--material", options.material, "FILE",
             "Store in every tetrahedron a material that follows from its grey value by the laws in this "
             ".json file.");
    group_new_options(verb, option_group::simulation);
}

Status check_order(const ElementOptions& options, const std::string& output) {
    const auto format = model_format_of(output);
    if (options.order != 2 || !format || holds_quadratic(*format)) return Nothing{};
    return Error{ErrorKind::usage,
                 "E-MDL-014",
                 "the format of the output holds linear tetrahedra only",
                 {output, "", "", "", "--order 2"},
                 "write .vtu, .msh, .inp or .feb"};
}

Status check_materials(const ElementOptions& options, std::span<const Structure> structures, bool has_grey,
                       const InputLimits& limits) {
    if (options.material.empty()) return Nothing{};
    ANATOMESH_TRY(const MaterialFile laws, read_material_file(options.material, limits));
    ANATOMESH_CHECK_STATUS(check_law_names(laws, structures));
    if (needs_grey(laws) && !has_grey && options.grey.empty()) return without_grey(options);
    return Nothing{};
}

Result<CellValues> add_cell_values(ModelFile& model, const ElementOptions& options, const InputOptions* own,
                                   Session& session, std::span<const Structure> others) {
    CellValues done;
    std::optional<MaterialFile> laws;
    if (!options.material.empty()) {
        ANATOMESH_TRY(laws, read_material_file(options.material, session.limits.input));
    }
    const bool wants_grey = laws && needs_grey(*laws);
    const bool again = own && (options.grey.empty() || options.grey == own->input);
    InputOptions image;
    if (again) {
        image = *own;
    } else {
        image.input = options.grey;
        image.limits = session.limits;
    }
    if (!options.grey.empty() || (wants_grey && again)) {
        ANATOMESH_CHECK_STATUS(add_grey(model, image, again, session, done));
    }
    if (wants_grey && model.grey.empty()) return without_grey(options);
    if (laws) {
        ANATOMESH_CHECK_STATUS(add_materials(model, *laws, others, done));
    }
    return done;
}

}  // namespace anatomesh
