// FEBio .feb, febio_spec 4.0, written only: nodes, a part per region and material, sets per structure and
// interface, materials, grey values. Follows: FEBio User Manual 4.0, "Free Format Input".
#include "anatomesh_io/mesh/description.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"
#include "anatomesh_io/mesh/model_sets.h"
#include "anatomesh_io/mesh/quadratic_nodes.h"

namespace anatomesh {

namespace {

// XML allows neither "--" nor control characters in a comment.
std::string comment(std::string_view content) {
    std::string text = "  <!-- ";
    for (const char c : content) {
        if (c == '-' && text.back() == '-') text += ' ';
        text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    return text + " -->\n";
}

std::string part_name(const ModelFile& model, const CellBlock& block) {
    std::string name = "REGION_" + std::to_string(block.region);
    if (!model.material.empty()) name += "_MATERIAL_" + std::to_string(block.material + 1);
    return name;
}

std::string material_name(const ModelFile& model, const CellBlock& block) {
    return model.material.empty() ? "REGION_" + std::to_string(block.region)
                                  : "MATERIAL_" + std::to_string(block.material + 1);
}

void append_material(std::string& text, std::size_t id, const std::string& name, const Material& material) {
    text +=
        "    <material id=\"" + std::to_string(id) + "\" name=\"" + name + "\" type=\"isotropic elastic\">\n";
    const auto value = [&](const char* tag, double number) {
        text += std::string("      <") + tag + ">";
        append_number(text, number);
        text += std::string("</") + tag + ">\n";
    };
    value("density", material.density_t_mm3);
    value("E", material.young_mpa);
    value("v", material.poisson);
    text += "    </material>\n";
}

void append_feb_materials(std::string& text, const std::string& path, const ModelFile& model,
                          const std::vector<CellBlock>& blocks, RunContext& context) {
    text += "  <Material>\n";
    if (model.material.empty()) {
        constexpr Material place_holder{1, 0.3, 0};
        Region last = 0;
        std::size_t id = 0;
        for (const CellBlock& block : blocks) {
            if (id > 0 && block.region == last) continue;
            last = block.region;
            append_material(text, ++id, material_name(model, block), place_holder);
        }
        Warning warning{"W-MDL-007",
                        "the model has no materials, and FEBio needs them",
                        {},
                        "1 MPa and 0.3 were written as placeholders; --material gives materials"};
        warning.place.file = path;
        context.warn(std::move(warning));
    }
    for (std::size_t m = 0; !model.material.empty() && m < model.description.materials.size(); ++m) {
        append_material(text, m + 1, "MATERIAL_" + std::to_string(m + 1), model.description.materials[m]);
    }
    text += "  </Material>\n";
}

void append_feb_nodes(std::string& text, const ModelFile& model) {
    text += "    <Nodes name=\"ALL\">\n";
    for (std::size_t n = 0; n < node_count(model); ++n) {
        const Vec3& point = node_at(model, n);
        text += "      <node id=\"";
        append_number(text, n + 1);
        text += "\">";
        append_number(text, point.x);
        text += ',';
        append_number(text, point.y);
        text += ',';
        append_number(text, point.z);
        text += "</node>\n";
    }
    text += "    </Nodes>\n";
}

// Numbers from 0, written from 1, with commas between.
template <class Numbers>
void append_list(std::string& text, const Numbers& numbers) {
    bool first = true;
    for (const std::uint64_t number : numbers) {
        if (!first) text += ',';
        first = false;
        append_number(text, number + 1);
    }
}

void append_parts(std::string& text, const ModelFile& model, const std::vector<CellBlock>& blocks) {
    const char* type = model.mid_nodes.empty() ? "tet4" : "tet10";
    for (const CellBlock& block : blocks) {
        text +=
            std::string("    <Elements type=\"") + type + "\" name=\"" + part_name(model, block) + "\">\n";
        for (const std::uint32_t c : block.cells) {
            text += "      <elem id=\"";
            append_number(text, std::uint64_t{c} + 1);
            text += "\">";
            std::vector<std::uint64_t> nodes;
            each_node(model, c, vtk_edge_order, [&](std::uint64_t node) { nodes.push_back(node); });
            append_list(text, nodes);
            text += "</elem>\n";
        }
        text += "    </Elements>\n";
    }
}

template <class Numbers>
void append_feb_set(std::string& text, const char* tag, const std::string& name, const Numbers& numbers) {
    if (numbers.empty()) return;
    text += std::string("    <") + tag + " name=\"" + name + "\">";
    append_list(text, numbers);
    text += std::string("</") + tag + ">\n";
}

void append_feb_surface(std::string& text, const ModelFile& model, const std::string& name,
                        const std::vector<std::uint64_t>& facets) {
    if (facets.empty()) return;
    const std::string tag = model.mid_nodes.empty() ? "tri3" : "tri6";
    text += "    <Surface name=\"" + name + "\">\n";
    for (std::size_t f = 0; f < facets.size(); ++f) {
        text += "      <" + tag + " id=\"";
        append_number(text, f + 1);
        text += "\">";
        append_list(text, nodes_of_facet(model, facets[f]));
        text += "</" + tag + ">\n";
    }
    text += "    </Surface>\n";
}

void append_sets(std::string& text, const ModelFile& model) {
    const std::vector<InterfaceFacet> facets = interface_facets(model.mesh);
    for (std::uint32_t s = 0; s < model.description.structures.size(); ++s) {
        std::vector<std::uint64_t> cells;
        for (std::size_t c = 0; c < model.mesh.cells.size(); ++c) {
            if (model.description.regions.contains(model.mesh.regions[c], s)) cells.push_back(c);
        }
        const std::string name = structure_set_name(model.description.structures[s].number);
        append_feb_set(text, "NodeSet", "NODES_" + name, structure_nodes(model, s));
        append_feb_set(text, "ElementSet", name, cells);
        append_feb_surface(text, model, "SURFACE_" + name,
                           structure_facets(facets, model.description.regions, s));
    }
    for (const Interface& interface : interfaces(facets)) {
        std::vector<std::uint64_t> inner, both;
        for (const InterfaceFacet& facet : interface.facets) {
            inner.push_back(facet.facet);
            both.push_back(facet.facet);
            if (facet.other != no_facet) both.push_back(facet.other);
        }
        append_feb_set(text, "NodeSet", "NODES_" + interface.name(), facet_nodes(model, inner));
        append_feb_set(text, "ElementSet", "ELEMENTS_" + interface.name(), cells_of_facets(both));
        append_feb_surface(text, model, interface.name(), inner);
    }
}

// A map needs a set of elements, and counts within it.
void append_grey(std::string& text, const ModelFile& model) {
    text += "  <MeshData>\n    <ElementData type=\"scalar\" name=\"grey\" elem_set=\"ALL_ELEMENTS\">\n";
    for (std::size_t c = 0; c < model.grey.size(); ++c) {
        text += "      <e lid=\"";
        append_number(text, c + 1);
        text += "\">";
        append_number(text, model.grey[c]);
        text += "</e>\n";
    }
    text += "    </ElementData>\n  </MeshData>\n";
}

}  // namespace

Result<std::string> format_febio(const std::string& path, const ModelFile& model, RunContext& context) {
    const std::vector<CellBlock> blocks = cell_blocks(model);
    std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<febio_spec version=\"4.0\">\n";
    for (const std::string& line : description_lines(model.description)) text += comment(line);
    text += "  <Module type=\"solid\"/>\n";
    append_feb_materials(text, path, model, blocks, context);
    text += "  <Mesh>\n";
    append_feb_nodes(text, model);
    append_parts(text, model, blocks);
    append_sets(text, model);
    if (!model.grey.empty()) {
        std::vector<std::uint64_t> all(model.mesh.cells.size());
        for (std::size_t c = 0; c < all.size(); ++c) all[c] = c;
        append_feb_set(text, "ElementSet", "ALL_ELEMENTS", all);
    }
    text += "  </Mesh>\n  <MeshDomains>\n";
    for (const CellBlock& block : blocks) {
        text += "    <SolidDomain name=\"" + part_name(model, block) + "\" mat=\"" +
                material_name(model, block) + "\"/>\n";
    }
    text += "  </MeshDomains>\n";
    if (!model.grey.empty()) append_grey(text, model);
    text += "</febio_spec>\n";
    return text;
}

}  // namespace anatomesh
