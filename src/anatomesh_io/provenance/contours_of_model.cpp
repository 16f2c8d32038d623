#include "anatomesh_io/provenance/contours_of_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/contour/model/find_structures.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/measure/contour_fidelity.h"
#include "anatomesh/measure/contour_movement.h"
#include "anatomesh/measure/hausdorff.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/overlaps/outlines_between.h"
#include "anatomesh/overlaps/priority.h"
#include "anatomesh/reconcile/reconcile.h"
#include "anatomesh/reconcile/working_unit.h"
#include "anatomesh_io/provenance/field_of_model.h"
#include "anatomesh_io/provenance/model_description.h"
#include "anatomesh_io/provenance/routed_contour_notes.h"

namespace anatomesh {

namespace {

std::string named(const Structure& structure) {
    return structure.name.empty() ? fmt::format("{}", structure.number)
                                  : fmt::format("{} ({})", structure.name, structure.number);
}

// Those of the contours' structures that the model has.
std::vector<std::uint32_t> structures_of(const ContourSet& contours, const ModelFile& model) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t s = 0; s < contours.structures.size(); ++s) {
        if (matching_structure(contours.structures, s, model.description.structures) <
            model.description.structures.size())
            found.push_back(s);
    }
    return found;
}

ContourSet without_others(const ContourSet& contours, const ModelFile& model) {
    const std::vector<std::uint32_t> found = structures_of(contours, model);
    return found.empty() ? contours : choose_structures(contours, found);
}

// What `model` does to contours before it makes a model of them, by the options in the model's file; nothing
// where that cannot be done, or is nothing.
struct Prepared {
    ContourSet kept;
    std::vector<std::string> steps;
    bool gave_overlaps = false;
    ContourMovementReport movement{};
};

std::optional<Prepared> prepared(ContourSet kept, const MeshDescription& description, RunContext& apart) {
    Prepared done{std::move(kept), {}};
    const auto says = [&](const char* name, const char* value) {
        const std::vector<std::string> values = options_of(description, name);
        return !values.empty() && values.front() == value;
    };
    if (says("reconcile", "1") && !all_parallel(done.kept, parallel_tolerance_mm)) {
        ReconcileOptions options;
        const std::optional<double> bound = number_of(description, "max_disagreement_mm");
        if (bound && *bound >= 0.001 && *bound <= 1000) options.max_disagreement_mm = *bound;
        options.align = says("align", "yes");
        WallOptions walls;
        const auto take = [&](const char* name, double most, double& width) {
            const std::optional<double> told = number_of(description, name);
            if (told && *told >= 0 && *told <= most) width = *told;
        };
        take("same_line_mm", 0.1, walls.same_line_mm);
        take("close_slivers_mm", 10, walls.close_slivers_mm);
        Result<ReconcileResult> reconciled =
            reconcile_contours(done.kept, with_widths(options, walls), apart);
        if (!reconciled.ok()) return std::nullopt;
        done.movement = contour_movement(done.kept, reconciled.value().kept);
        done.kept = std::move(reconciled).value().kept;
        done.steps.emplace_back("slices that cross were made to agree (reconcile 1)");
    }
    if (const std::vector<std::string> names = options_of(description, "priority"); !names.empty()) {
        // Some may not be among these.
        std::vector<std::string> here;
        std::copy_if(names.begin(), names.end(), std::back_inserter(here), [&](const std::string& name) {
            return find_in_order(done.kept.structures, {name}, "").ok();
        });
        const auto order = find_in_order(done.kept.structures, here, "");
        if (here.empty() || !order.ok()) return std::nullopt;
        const bool has_outlines = !options_of(description, "outlines_between").empty();
        Result<PriorityResult> given =
            has_outlines ? part_structures(done.kept, order.value(), field_rules_of(description), apart)
                         : give_overlaps(done.kept, order.value(), apart);
        if (!given.ok()) return std::nullopt;
        const std::vector<GivenOverlap>& overlaps = given.value().given;
        done.gave_overlaps = std::any_of(overlaps.begin(), overlaps.end(),
                                         [](const GivenOverlap& each) { return each.slices > 0; });
        if (done.gave_overlaps) {
            done.kept = std::move(given).value().kept;
            done.steps.push_back(
                fmt::format("the first of {} got the overlaps (priority)", fmt::join(names, ", ")));
            if (has_interpolated(done.kept))
                done.steps.emplace_back(
                    "structures got interpolated outlines between their own slices (W-PRI-002)");
        }
    }
    if (done.steps.empty()) return std::nullopt;
    return done;
}

// Of contours: how many vertices are not on the model's surfaces, and how many segments no chains of its
// edges.
using Missed = std::pair<std::uint64_t, std::uint64_t>;

class Misses {
  public:
    explicit Misses(const ModelFile& model) : model_(model) {
        for (std::uint32_t s = 0; s < model.description.structures.size(); ++s)
            surfaces_.push_back(structure_surface(model.mesh, model.description.regions, s));
    }

    Missed of(const ContourSet& contours) const {
        std::vector<std::vector<Triangle>> surfaces;
        for (std::uint32_t s = 0; s < contours.structures.size(); ++s) {
            const std::size_t match =
                matching_structure(contours.structures, s, model_.description.structures);
            surfaces.push_back(match < surfaces_.size() ? surfaces_[match] : std::vector<Triangle>{});
        }
        Missed sum{0, 0};
        for (const StructureFidelity& each :
             contour_fidelity(model_.mesh.points, surfaces, contours).structures) {
            sum.first += each.vertices - each.vertices_on_surface;
            sum.second += each.segments - each.segments_on_surface;
        }
        return sum;
    }

  private:
    const ModelFile& model_;
    std::vector<std::vector<Triangle>> surfaces_;
};

// Of contours on more slices than the model was made of (--every, --offset) those on its own, if more of
// these are on its surfaces.
ContourSet on_slices_of_model(ContourSet kept, const ModelFile& model, const Misses& misses,
                              const std::string& file, RunContext& context) {
    const double every = number_of(model.description, "every").value_or(1),
                 offset = number_of(model.description, "offset").value_or(0);
    const auto slices = static_cast<double>(kept.slices.size());
    if (!(every >= 2 && every < slices && offset >= 0 && offset < slices) ||
        !all_parallel(kept, parallel_tolerance_mm))
        return kept;
    ContourSet own =
        every_nth_slice(kept, static_cast<std::uint32_t>(every), static_cast<std::uint32_t>(offset));
    if (own.contours.empty()) return kept;
    const std::uint64_t before = misses.of(kept).first, after = misses.of(own).first;
    if (after >= before) return kept;
    context.warn(
        {"W-CMD-011",
         fmt::format("the contours have more slices than the model was made of; its file says --every {:.0f} "
                     "--offset {:.0f}",
                     every, offset),
         {file, "", "", "", fmt::format("{} of {} slices", own.slices.size(), kept.slices.size())},
         "the model was checked against these slices only"});
    return own;
}

// Contours that a model may have been made of, and what there is to say of how they came about.
struct Candidate {
    ContourSet kept;
    std::vector<std::string> steps;
    std::vector<Warning> warnings;
    bool gave_overlaps = false;
    ContourMovementReport movement{};
};

// Those that follow from the contours given. Models of single structures are made of contours that all of
// them have been prepared with, others of those of their structures alone.
std::vector<Candidate> candidates(const ContourSet& given, const ModelFile& model, const WallOptions* walls,
                                  RunContext& context) {
    std::vector<Candidate> all;
    const ContourSet own = without_others(given, model);
    for (const bool all_together : {false, true}) {
        if (all_together && own.structures.size() == given.structures.size()) break;
        for (const bool shared : {false, true}) {
            if (shared && walls == nullptr) break;
            RunContext sharing, apart;  // the latter's warnings were said when the model was made
            apart.threads = context.threads;
            apart.cancel = context.cancel;
            ContourSet drawn = all_together ? given : own;
            if (shared) {
                share_walls(drawn, *walls, sharing);
                all.push_back({without_others(drawn, model), {}, sharing.warnings});
            }
            std::optional<Prepared> done = prepared(std::move(drawn), model.description, apart);
            if (done)
                all.push_back({without_others(done->kept, model), std::move(done->steps), sharing.warnings,
                               done->gave_overlaps, std::move(done->movement)});
        }
    }
    return all;
}

// Warns of what the two files say that cannot both be true.
void compare_names(const ContourSet& contours, const ModelFile& model, const std::string& file,
                   RunContext& context) {
    const std::vector<Structure>& structures = model.description.structures;
    if (const std::string& space = model.description.space;
        contours.frame == Frame::lps && space != "LPS" && space != "unknown") {
        context.warn({"W-CMD-001",
                      "the two files state different axes",
                      {file, "", "", "", fmt::format("{} of the model, LPS of the contours", space)},
                      "the coordinates were compared as they are"});
    }
    std::vector<std::string> other;
    std::vector<bool> drawn(structures.size(), false);
    for (std::size_t s = 0; s < contours.structures.size(); ++s) {
        const std::size_t match = matching_structure(contours.structures, s, structures);
        if (match == structures.size()) continue;
        drawn[match] = true;
        const Structure &here = contours.structures[s], &there = structures[match];
        const bool other_name = !here.name.empty() && !there.name.empty() && here.name != there.name;
        if (other_name || here.number != there.number)
            other.push_back(fmt::format("{} of the contours is {} of the model", named(here), named(there)));
    }
    if (!other.empty()) {
        context.warn({"W-CMD-008",
                      "structures of the model and of the contours have different names",
                      {file, "", "", "", fmt::format("{}", fmt::join(other, "; "))},
                      "they were compared by their numbers; check that they were not exchanged"});
    }
    std::vector<std::string> more;
    for (std::size_t s = 0; s < structures.size(); ++s) {
        if (!drawn[s]) more.push_back(named(structures[s]));
    }
    if (!more.empty()) {
        context.warn({"W-CMD-010",
                      "the model has structures that the contours do not have",
                      {file, "", "", "", fmt::format("{}", fmt::join(more, ", "))},
                      "their surfaces were not compared"});
    }
}

}  // namespace

Result<ContoursOfModel> contours_of_model(ContourSet kept, const ModelFile& model, const WallOptions& walls,
                                          bool share_first, const std::string& file, RunContext& context) {
    const Misses misses(model);
    kept = on_slices_of_model(std::move(kept), model, misses, file, context);
    if (share_first) share_walls(kept, walls, context);
    std::vector<std::string> left_out;
    const std::vector<std::uint32_t> found = structures_of(kept, model);
    for (std::uint32_t s = 0; s < kept.structures.size(); ++s) {
        if (std::find(found.begin(), found.end(), s) == found.end())
            left_out.push_back(named(kept.structures[s]));
    }
    if (found.empty()) left_out.clear();

    ContourSet best = without_others(kept, model);
    const auto missed_of = [&](const ContourSet& contours) {
        const std::optional<BothContours> both = both_contours(contours, model.description);
        return misses.of(both ? both->on_surface : contours);
    };
    const Missed before = missed_of(best);
    Missed least = before;
    const Candidate* taken = nullptr;
    std::vector<Candidate> others;
    // An outline in another one is all there as it was drawn, and still none of what the other became.
    const bool may_give = !options_of(model.description, "priority").empty();
    if (before > Missed{0, 0} || may_give)
        others = candidates(kept, model, share_first ? nullptr : &walls, context);
    if (context.cancelled()) return cancelled_error();
    for (const Candidate& other : others) {
        const Missed here = missed_of(other.kept);
        const bool gives_more = other.gave_overlaps && (taken == nullptr || !taken->gave_overlaps);
        // Of an outline in another one both have what is missed.
        const bool is_nested = gives_more && !options_of(model.description, "overlaps").empty();
        if (!is_nested && (here > least || (here == least && !gives_more))) continue;
        if (taken != nullptr && taken->gave_overlaps && !other.gave_overlaps) continue;
        least = here;
        taken = &other;
    }
    ContourMovementReport movement;
    if (taken != nullptr) {
        best = taken->kept;
        movement = taken->movement;
        for (const Warning& warning : taken->warnings) context.warn(warning);
        if (!taken->steps.empty()) {
            context.warn({"W-CMD-011",
                          "the contours are not yet those that the model was made of; these steps of its "
                          "file were repeated: " +
                              fmt::format("{}", fmt::join(taken->steps, ", then ")),
                          {file, "", "", "",
                           before == least
                               ? ""
                               : fmt::format("{} vertices and {} segments differed before, {} and {} after",
                                             before.first, before.second, least.first, least.second)},
                          "the model was checked against the moved contours; model --contours writes them"});
        }
    }
    compare_names(best, model, file, context);
    if (!left_out.empty()) {
        context.warn({"W-CMD-009",
                      "the model does not have all structures of the contours",
                      {file, "", "", "", fmt::format("{}", fmt::join(left_out, ", "))},
                      "they were not compared"});
    }
    std::optional<BothContours> both = both_contours(best, model.description);
    if (both)
        return ContoursOfModel{std::move(both->drawn), std::move(both->on_surface), std::move(both->routed),
                               std::move(movement)};
    return ContoursOfModel{std::move(best), std::nullopt, {}, std::move(movement)};
}

std::string distance_text(const ContourSet& contours, const ModelFile& model) {
    const std::vector<Structure>& structures = model.description.structures;
    double sum = 0, most = 0;
    std::size_t count = 0;
    Box3 drawn, made;
    for (const std::uint32_t s : structures_of(contours, model)) {
        const auto match = static_cast<std::uint32_t>(matching_structure(contours.structures, s, structures));
        SurfaceMesh surface;
        surface.points = model.mesh.points;
        surface.triangles = structure_surface(model.mesh, model.description.regions, match);
        if (surface.triangles.empty()) continue;
        const ClosestPoint closest(surface);
        for (const Triangle& triangle : surface.triangles) {
            for (const std::uint32_t v : triangle) made.extend(surface.points[v]);
        }
        for (const Contour& contour : contours.contours) {
            if (contour.structure != s) continue;
            for (const Vec3& p : contours.points_of(contour)) {
                const double distance = closest.distance(p);
                drawn.extend(p);
                sum += distance;
                most = std::max(most, distance);
                ++count;
            }
        }
    }
    if (count == 0) return "";
    const auto span = [](const Box3& box) {
        return fmt::format("x {:.1f} to {:.1f}, y {:.1f} to {:.1f}, z {:.1f} to {:.1f}", box.low.x,
                           box.high.x, box.low.y, box.high.y, box.low.z, box.high.z);
    };
    return fmt::format(
        "the contours' vertices are {:.3g} mm from the model's surface in the mean, {:.3g} mm at most "
        "(contours: "
        "{}; model: {})",
        sum / static_cast<double>(count), most, span(drawn), span(made));
}

}  // namespace anatomesh
