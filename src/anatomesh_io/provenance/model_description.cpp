#include "anatomesh_io/provenance/model_description.h"

#include <charconv>
#include <cmath>
#include <map>

#include "anatomesh_io/provenance/routed_contour_notes.h"

namespace anatomesh {

MeshDescription description_of(const Model& model) {
    const ModelReport& report = model.report;
    MeshDescription description;
    description.structures = model.structures;
    description.regions = model.regions;
    description.space = report.conventions.space;
    description.notes.emplace_back("version", report.provenance.version);
    for (const auto& [name, value] : report.provenance.options)
        description.notes.emplace_back("option", name + " " + value);
    std::map<std::string, int> warnings;
    for (const Warning& warning : report.warnings) ++warnings[warning.code];
    for (const auto& [code, times] : warnings)
        description.notes.emplace_back("warning", code + " " + std::to_string(times));
    add_routed_contour_notes(model, description);
    return description;
}

ModelFile model_file(const Model& model) {
    ModelFile file;
    file.mesh = model.mesh;
    file.description = description_of(model);
    return file;
}

std::vector<std::string> options_of(const MeshDescription& description, const std::string& name) {
    std::vector<std::string> values;
    for (const auto& [key, value] : description.notes) {
        if (key == "option" && value.starts_with(name + " ")) values.push_back(value.substr(name.size() + 1));
    }
    return values;
}

std::optional<std::string> option_of(const MeshDescription& description, const std::string& name) {
    const std::vector<std::string> values = options_of(description, name);
    return values.empty() ? std::nullopt : std::optional(values.front());
}

std::optional<double> number_of(const MeshDescription& description, const std::string& name) {
    const std::optional<std::string> text = option_of(description, name);
    if (!text) return std::nullopt;
    double value = 0;
    const auto [end, fault] = std::from_chars(text->data(), text->data() + text->size(), value);
    if (fault != std::errc{} || end != text->data() + text->size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::optional<double> size_of(const MeshDescription& description) {
    const std::optional<double> size = number_of(description, "size_mm");
    return size && *size > 0 ? size : std::nullopt;
}

}  // namespace anatomesh
