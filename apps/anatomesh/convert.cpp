// anatomesh convert: a model in another format, or its surface.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "anatomesh/base/plural.h"
#include "anatomesh/element/quadratic.h"
#include "anatomesh_io/file/atomic_file.h"
#include "answer.h"
#include "element_options.h"
#include "help_text.h"
#include "mesh_input.h"
#include "option_values.h"
#include "outputs.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct ConvertOptions {
    std::string input, output;
    ElementOptions element;
};

// A surface has neither elements nor their values. Error: usage E-CMD-008.
Status check_element_options(const ConvertOptions& options, bool to_model) {
    if (to_model || (options.element.order == 0 && !options.element.wanted())) return Nothing{};
    return Error{ErrorKind::usage,
                 "E-CMD-008",
                 "--order, --grey and --material do not apply to a surface",
                 {options.output, "", "", "", ""},
                 "choose an output for models: .vtu, .msh, .mesh, .inp or .feb"};
}

// Brings the elements to the order asked for: mid-nodes in the middles of the edges, or none. Without --order
// as read.
void set_order(ModelFile& model, std::uint32_t order) {
    if (order == 1) model.mid_nodes = {};
    if (order == 2 && model.mid_nodes.empty()) model.mid_nodes = straight_mid_nodes(model.mesh);
}

Status run_convert(const ConvertOptions& options, Session& session) {
    const bool to_model = model_format_of(options.output).has_value();
    ANATOMESH_CHECK_STATUS(check_mesh_output(options.output, true));
    ANATOMESH_CHECK_STATUS(check_element_options(options, to_model));
    ANATOMESH_CHECK_STATUS(check_order(options.element, options.output));
    std::vector<std::string> inputs = options.element.inputs();
    inputs.push_back(options.input);
    ANATOMESH_CHECK_STATUS(check_outputs(inputs, {options.output}));
    ANATOMESH_TRY(MeshInput input, read_mesh(options.input, session.limits, session.context));
    nlohmann::ordered_json answer{{"input", options.input}, {"output", options.output}};
    if (to_model && !input.model) {
        return Error{ErrorKind::usage,
                     "E-CMD-008",
                     "the input is a surface, which has no tetrahedra for a model",
                     {options.input, "", "", "", ""},
                     "choose an output for surfaces: .vtp, .stl, .ply or .obj"};
    }
    if (session.context.cancelled()) return cancelled_error();
    std::string what, materials;
    AtomicFileSet files;
    if (to_model) {
        set_order(*input.model, options.element.order);
        ANATOMESH_TRY(const CellValues values,
                      add_cell_values(*input.model, options.element, nullptr, session));
        ANATOMESH_TRY(const std::string bytes, format_model(options.output, *input.model, session.context));
        ANATOMESH_CHECK_STATUS(files.add(options.output, bytes));
        answer["vertices"] = input.model->mesh.points.size();
        answer["mid_nodes"] = input.model->mid_nodes.points.size();
        answer["materials"] = input.model->description.materials.size();
        answer["tetrahedra"] = input.model->mesh.cells.size();
        what = counted(input.model->mesh.cells.size(), "tetrahedron", "tetrahedra");
        materials = materials_text(values.materials);
    } else {
        const SurfaceFile surface = surface_of(input);
        ANATOMESH_TRY(const std::string bytes, format_surface(options.output, surface, session.context));
        ANATOMESH_CHECK_STATUS(files.add(options.output, bytes));
        answer["vertices"] = surface.surface.points.size();
        answer["triangles"] = surface.surface.triangles.size();
        what = counted(surface.surface.triangles.size(), "triangle");
    }
    return files.commit([&] {
        return give_summary(session, answer, fmt::format("{}: {}\n{}", options.output, what, materials));
    });
}

}  // namespace

Work declare_convert(CLI::App& verb) {
    auto options = std::make_shared<ConvertOptions>();
    verb.add_option("MODEL", options->input, "Model or surface. The content tells the format.")
        ->type_name("FILE")
        ->required();
    add_text(verb, "-o,--output", options->output, "OTHER",
             "The file to write: .vtu, .msh, .mesh, .inp or .feb for a model, .vtp, .stl, .ply or .obj for "
             "its surface.")
        ->required();
    group_new_options(verb, option_group::outputs);
    add_element_options(verb, options->element);
    return [options](Session& session) { return run_convert(*options, session); };
}

}  // namespace anatomesh
