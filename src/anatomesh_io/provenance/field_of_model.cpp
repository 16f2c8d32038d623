#include "anatomesh_io/provenance/field_of_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "anatomesh/base/contract.h"
#include "anatomesh/field/end_caps.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/measure/volume.h"
#include "anatomesh_io/provenance/model_description.h"

namespace anatomesh {

namespace {

// If one way of making the field comes this near to the model's volume, no other way is tried.
// [1, of the volume; 0 to volume_tolerance; D a tenth of clause 6]
constexpr double near_enough = contract::volume_tolerance / 10;

// Overlaps of a smaller share of the cells do not tell that structures were meant to overlap.
// [1, of the cells; 0 to 1; M 2026-11, set not recorded]
constexpr double hardly_any = 0.01;

// The contours' structure of each structure of the model; nothing where they are not the same.
std::optional<std::vector<std::size_t>> same_structures(const ModelFile& model, const ContourSet& contours) {
    const std::vector<Structure>& structures = model.description.structures;
    if (structures.size() != contours.structures.size()) return std::nullopt;
    std::vector<std::size_t> match(structures.size(), structures.size());
    for (std::size_t s = 0; s < structures.size(); ++s) {
        const std::size_t of_model = matching_structure(contours.structures, s, structures);
        if (of_model == structures.size()) return std::nullopt;
        match[of_model] = s;
    }
    return match;
}

// Whether the mesh can be measured at all: its faults are the certificate's to say.
bool has_volume(const TetMesh& mesh) {
    return std::all_of(mesh.cells.begin(), mesh.cells.end(), [&](const Cell& cell) {
        return *std::max_element(cell.begin(), cell.end()) < mesh.points.size();
    });
}

bool has_overlaps(const ModelFile& model) {
    const auto overlaps =
        std::count_if(model.mesh.regions.begin(), model.mesh.regions.end(),
                      [&](Region region) { return model.description.regions.members[region].size() > 1; });
    return static_cast<double>(overlaps) > hardly_any * static_cast<double>(model.mesh.regions.size());
}

// The largest relative difference of a structure's volume.
double worst_difference(const std::vector<double>& mesh, const std::vector<double>& field) {
    double worst = 0;
    for (std::size_t s = 0; s < mesh.size(); ++s) {
        const double difference = std::abs(mesh[s] - field[s]);
        if (difference > 0) worst = std::max(worst, field[s] > 0 ? difference / field[s] : HUGE_VAL);
    }
    return worst;
}

}  // namespace

FieldOptions field_rules_of(const MeshDescription& description) {
    FieldOptions rules;
    const auto in_range = [](std::optional<double> value, double low, double high, double otherwise) {
        return value && *value >= low && *value <= high ? *value : otherwise;
    };
    rules.max_gap_spacings =
        in_range(number_of(description, "max_gap_spacings"), 1, 1e6, rules.max_gap_spacings);
    rules.single_slice_mm = in_range(number_of(description, "slice_thickness_mm"), 0, 1000, 0);
    return rules;
}

Result<FieldOfModel> field_of_model(const ModelFile& model, const ContourSet& contours, RunContext& context) {
    const std::optional<std::string> told = option_of(model.description, "caps");
    std::vector<std::string> ways{"half", "flat", "rounded"};
    const bool known = told && std::find(ways.begin(), ways.end(), *told) != ways.end();
    if (known) ways = {*told};
    FieldOptions rules = field_rules_of(model.description);

    FieldOfModel best;
    if (option_of(model.description, "overlaps") && !contours.overlapping) {
        best.note =
            "the shape between slices follows from the contours as drawn, before overlaps were "
            "given to the first structure (priority); these are not";
        return best;
    }
    const std::optional<std::vector<std::size_t>> match = same_structures(model, contours);
    std::vector<double> by_mesh;
    if (has_volume(model.mesh))
        by_mesh = mesh_volumes(model.mesh, model.description.regions, model.description.structures.size());
    // Not every contour file tells whether structures exclude each other, as those of a label map do. A model
    // with overlaps knows that they do not.
    std::vector<bool> exclusions{false};
    const bool told_to_exclude = option_of(model.description, "priority").has_value();
    if (model.description.structures.size() > 1 && (told_to_exclude || !has_overlaps(model)))
        exclusions = {true, false};
    bool exclude = false;
    double least = HUGE_VAL;
    for (std::size_t n = 0; n < ways.size() * exclusions.size() && least > near_enough; ++n) {
        const std::string& way = ways[n / exclusions.size()];
        rules.caps = *end_caps_of(way);
        ContourSet set = contours;
        if (!option_of(model.description, "overlaps")) set.overlapping.reset();  // made by an earlier program
        set.exclusive = exclusions[n % exclusions.size()];
        // Its warnings were said when the model was made.
        RunContext apart;
        apart.threads = context.threads;
        apart.cancel = context.cancel;
        Result<ContourField> made = contour_field(set, rules, apart);
        if (!made.ok()) {
            if (made.error().kind == ErrorKind::cancelled) return made.error();
            best.note = "these contours give no field: " + made.error().message;
            return best;
        }
        std::vector<double> volumes;
        if (match) {
            for (const std::size_t s : *match) volumes.push_back(made.value().volumes_mm3[s]);
        }
        const double worst = volumes.size() == by_mesh.size() ? worst_difference(by_mesh, volumes) : HUGE_VAL;
        if (best.made.field && worst >= least) continue;
        least = worst;
        exclude = set.exclusive;
        best = {std::move(made).value(), std::move(volumes), way, ""};
    }
    best.note = fmt::format(
        "for the field of these contours with ends '{}' and gaps of up to {:.6g} spacings joined, {}",
        best.caps, rules.max_gap_spacings,
        known ? "as the model's file says" : "assumed, because the model's file does not state it");
    if (exclude) best.note += ", with structures that do not overlap, as in the model";
    if (!match) best.note += "; volumes are not compared, because the structures differ";
    return best;
}

}  // namespace anatomesh
