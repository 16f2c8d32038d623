#include "anatomesh/pipeline/prepare_contours.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/standard_arithmetic.h"
#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/contour/model/find_structures.h"
#include "anatomesh/contour/model/one_space.h"
#include "anatomesh/contour/overlay/structure_overlap.h"
#include "anatomesh/contour/simplify/simplify.h"
#include "anatomesh/contour/trace/merge_layers.h"
#include "anatomesh/image/components.h"
#include "anatomesh/image/select.h"
#include "anatomesh/measure/contour_movement.h"
#include "anatomesh/measure/crossing_report.h"
#include "anatomesh/outliers/warn_about_outlying_slices.h"
#include "anatomesh/overlaps/outlines_between.h"
#include "anatomesh/reconcile/working_unit.h"

namespace anatomesh {

namespace {

// Seconds since it was made, or since the last lap.
class Stopwatch {
  public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

using Options = std::vector<std::pair<std::string, std::string>>;

std::string input_name(const PrepareOptions& options, const std::string& source) {
    return options.input.empty() ? source : options.input;
}

Error usage_error(std::string message, const std::string& file, std::string next_step) {
    return {ErrorKind::usage, "E-CMD-008", std::move(message), {file, "", "", "", ""}, std::move(next_step)};
}

Error does_not_apply(const std::string& option, const std::string& file, const std::string& why) {
    return usage_error(option + " does not apply: " + why, file, "leave out " + option);
}

std::string interval_text(const ThresholdOptions& threshold) {
    const std::string low = number_text(threshold.low);
    return std::isinf(threshold.high) ? low : low + ":" + number_text(threshold.high);
}

bool is_default(const PrepareOptions& options) {
    CleanOptions clean = options.clean;
    clean.without.clear();
    return clean == CleanOptions{} && options.walls == WallOptions{};
}

// The options that say which part of the input was taken.
Options choice_told(const PrepareOptions& options) {
    Options told;
    if (options.choice.structures.empty()) told.emplace_back("structure", "all");
    for (const std::string& name : options.choice.structures) told.emplace_back("structure", name);
    for (const std::string& name : options.choice.without) told.emplace_back("without", name);
    if (options.label_maps.threshold)
        told.emplace_back("threshold", interval_text(*options.label_maps.threshold));
    if (options.label_maps.keep_largest)
        told.emplace_back("keep_largest", std::to_string(*options.label_maps.keep_largest));
    if (options.label_maps.axis) told.emplace_back("axis", std::string(1, "xyz"[*options.label_maps.axis]));
    if (options.label_maps.between_sparse == BetweenSparse::interpolated)
        told.emplace_back("between_sparse", "interpolated");
    told.emplace_back("every", std::to_string(options.choice.every.value_or(1)));
    told.emplace_back("offset", std::to_string(options.choice.offset));
    if (options.name_cleaning || !is_default(options)) {
        const CleanOptions& clean = options.clean;
        told.emplace_back("holes", clean.rings.holes == HoleRule::united ? "filled" : "even-odd");
        told.emplace_back("unite_repeated_planes", clean.rings.unite_repeated_planes ? "yes" : "no");
        told.emplace_back("closing_gap_mm", number_text(clean.closing_gap_mm));
        told.emplace_back("plane_repair_mm", number_text(clean.planes.plane_repair_mm));
        told.emplace_back("close_loops_mm2", number_text(clean.rings.loop_mm2));
        told.emplace_back("max_repair_share", number_text(clean.rings.max_repair_area_share));
    }
    return told;
}

void tell_epsilon(PreparedContours& prepared, const PrepareOptions& options) {
    prepared.options.emplace_back("epsilon_mm", prepared.epsilon_mm > 0 ? number_text(prepared.epsilon_mm)
                                                : options.epsilon_mm    ? "exact"
                                                                        : "exact but for crowded points");
}

std::vector<ContourReport> contour_log(const RawContours& raw, const CleanResult& cleaned) {
    std::vector<ContourReport> log;
    log.reserve(cleaned.log.size());
    for (const ContourLog& entry : cleaned.log) {
        const RawContour& contour = raw.contours[entry.raw_contour];
        const Structure& structure = raw.structures[contour.structure];
        ContourReport line;
        line.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
        if (contour.plane >= 0 && static_cast<std::size_t>(contour.plane) < raw.plane_names.size()) {
            line.slice = raw.plane_names[static_cast<std::size_t>(contour.plane)];
        }
        line.name = contour.name;
        line.rule = entry.rule;
        line.points_in = entry.points_in;
        line.points_kept = entry.points_kept;
        line.max_displacement_mm = entry.max_displacement_mm;
        line.area_change_mm2 = entry.area_change_mm2;
        log.push_back(std::move(line));
    }
    return log;
}

// Gives the one structure the name that the options ask for.
Status rename_structure(PreparedContours& prepared, const PrepareOptions& options) {
    const std::string& name = options.choice.name;
    if (name.empty()) return Nothing{};
    std::vector<Structure>& structures = prepared.kept.structures;
    if (structures.size() != 1)
        return usage_error(
            "--name is for one structure, and " + std::to_string(structures.size()) + " are taken",
            input_name(options, prepared.kept.source), "choose one with --structure");
    structures[0].name = name;
    for (ContourReport& line : prepared.log) line.structure = name;
    prepared.options.emplace_back("name", name);
    return Nothing{};
}

// Leaves structures out that are drawn on none of the slices that are kept, and tells of each.
void leave_out_undrawn(ContourSet& kept, RunContext& context) {
    std::vector<bool> is_drawn(kept.structures.size(), false);
    for (const Contour& contour : kept.contours) is_drawn[contour.structure] = true;
    std::vector<std::uint32_t> drawn;
    for (std::uint32_t s = 0; s < is_drawn.size(); ++s) {
        if (is_drawn[s]) {
            drawn.push_back(s);
            continue;
        }
        context.warn({"W-CON-001",
                      "the structure has no contour on the slices that --every and --offset keep",
                      {kept.source, "", unique_text(kept.structures, s), "", ""},
                      "it was left out; choose other slices, or model it with all of them"});
    }
    if (drawn.size() < kept.structures.size()) kept = choose_structures(kept, drawn);
}

Status keep_every_nth(ContourSet& kept, const PrepareOptions& options, RunContext& context) {
    if (options.choice.every.value_or(1) == 1) return Nothing{};
    const std::string file = input_name(options, kept.source);
    if (!all_parallel(kept, parallel_tolerance_mm))
        return does_not_apply("--every", file, "the slices are not parallel and have no order");
    kept = every_nth_slice(kept, *options.choice.every, options.choice.offset);
    if (kept.contours.empty())
        return usage_error("--every and --offset leave no slice", file, "give a smaller --every or --offset");
    leave_out_undrawn(kept, context);
    return Nothing{};
}

// What is done to drawn contours once they are a kept set. Those of voxels were simplified as they were
// traced.
Status thin_and_share(PreparedContours& prepared, const PrepareOptions& options, RunContext& context) {
    ContourSet& kept = prepared.kept;
    ANATOMESH_CHECK_STATUS(keep_every_nth(kept, options, context));
    if (options.epsilon_mm.value_or(0) > 0) {
        SimplifyOptions simplifying;
        simplifying.epsilon_mm = *options.epsilon_mm;
        ANATOMESH_TRY(SimplifyResult simplified, simplify_contours(kept, simplifying, context));
        kept = std::move(simplified.kept);
        prepared.epsilon_mm = *options.epsilon_mm;
    }
    // Contours of a label map share their walls already.
    const bool asks_for_walls = !(options.walls == WallOptions{});
    if (options.until == PrepareUntil::chosen || (!kept.drawn && !asks_for_walls)) return Nothing{};
    if (options.walls.close_gaps_mm > 0 && kept.structures.size() == 1)
        return does_not_apply("--close-gaps", input_name(options, kept.source),
                              "there is only one structure");
    share_walls(kept, options.walls, context);
    kept.exclusive = kept.exclusive && !find_overlap(kept);
    prepared.options.emplace_back("same_line_mm", number_text(options.walls.same_line_mm));
    prepared.options.emplace_back("close_slivers_mm", number_text(options.walls.close_slivers_mm));
    prepared.options.emplace_back("close_gaps_mm", number_text(options.walls.close_gaps_mm));
    return Nothing{};
}

Result<PreparedContours> drawn_contours(const RawContours& all, const PrepareOptions& options,
                                        RunContext& context) {
    ANATOMESH_TRY(
        const std::vector<std::uint32_t> chosen,
        find_structures(all.structures, options.choice.structures, input_name(options, all.source)));
    std::optional<RawContours> part;
    if (chosen.size() < all.structures.size()) part = choose_structures(all, chosen);
    const RawContours& raw = part ? *part : all;
    ANATOMESH_CHECK_STATUS(check_one_space(raw, options.take_spaces_for_one, context));
    CleanOptions clean = options.clean;
    clean.without = options.choice.without;
    if (options.epsilon_mm == 0.0) clean.crowded_mm = 0;
    ANATOMESH_TRY(CleanResult cleaned, clean_contours(raw, clean, context));

    PreparedContours prepared;
    prepared.options = choice_told(options);
    prepared.log = contour_log(raw, cleaned);
    prepared.hole_rule = clean.rings.holes == HoleRule::united
                             ? "filled: a contour inside another of its structure adds nothing"
                             : "even-odd: a contour inside another of its structure is a hole";
    prepared.traced_points = cleaned.stats.points_in;
    prepared.kept = std::move(cleaned.kept);
    ANATOMESH_CHECK_STATUS(thin_and_share(prepared, options, context));
    tell_epsilon(prepared, options);
    return prepared;
}

Result<PreparedContours> traced_contours(std::vector<TraceResult> layers, const PrepareOptions& options) {
    PreparedContours prepared;
    prepared.options = choice_told(options);
    prepared.hole_rule = "a pixel of no structure inside one is a hole";
    std::vector<ContourSet> sets;
    for (TraceResult& layer : layers) {
        prepared.traced_points += layer.stats.points_traced;
        prepared.islands_left_out += layer.stats.islands_left_out;
        prepared.epsilon_mm = layer.stats.epsilon_mm;
        sets.push_back(std::move(layer.kept));
    }
    prepared.kept = merge_layers(std::move(sets));
    ANATOMESH_TRY(prepared.kept, without_slices(std::move(prepared.kept), options.choice.without));
    const double pixel = prepared.kept.pixel_mm;
    prepared.options.emplace_back("min_area_mm2",
                                  number_text(options.label_maps.min_area_mm2.value_or(4 * pixel * pixel)));
    tell_epsilon(prepared, options);
    return prepared;
}

Result<std::vector<TraceResult>> trace_layers(std::vector<LabelMap> layers, const GreyImage* grey,
                                              const PrepareOptions& options, RunContext& context) {
    std::vector<Structure> all;
    for (const LabelMap& map : layers) all.insert(all.end(), map.structures.begin(), map.structures.end());
    ANATOMESH_TRY(
        const std::vector<std::uint32_t> chosen,
        find_structures(all, options.choice.structures, input_name(options, layers.front().source)));
    const double level = options.label_maps.threshold ? options.label_maps.threshold->low : 0;
    std::vector<TraceResult> traced;
    std::uint32_t first = 0;
    for (LabelMap& map : layers) {
        std::vector<std::uint32_t> own;
        for (const std::uint32_t index : chosen)
            if (index >= first && index - first < map.structures.size()) own.push_back(index - first);
        first += static_cast<std::uint32_t>(map.structures.size());
        if (own.empty() && layers.size() > 1) continue;
        if (own.size() < map.structures.size()) select_structures(map, own);
        if (options.label_maps.keep_largest) keep_largest(map, *options.label_maps.keep_largest);
        if (context.cancelled()) return cancelled_error();
        ANATOMESH_TRY(TraceResult layer, trace_contours(map, grey, level, trace_options(options), context));
        layer.kept.frame = options.label_maps.frame;
        traced.push_back(std::move(layer));
    }
    return traced;
}

void warn_of_giving(const ContourSet& set, const PriorityResult& result, const std::string& file,
                    RunContext& context) {
    if (std::all_of(result.given.begin(), result.given.end(),
                    [](const GivenOverlap& given) { return given.slices == 0; }))
        context.warn({"W-CMD-007",
                      "--priority was given, but no structures overlap on any slice",
                      {file, "", "", "", ""},
                      "no contour was changed; between slices the structures do not overlap either"});
    for (std::size_t s = 0; s < result.given.size(); ++s) {
        const GivenOverlap& given = result.given[s];
        if (given.slices == 0 || given.all) continue;
        context.warn(
            {"W-CMD-006",
             "the structure overlaps others that have priority",
             {file, "", set.structures[s].name, "",
              significant_text(given.area_mm2, 4) + " mm2 on " + std::to_string(given.slices) + " slices"},
             "they keep the overlap; structures that --priority does not name go from small to large"});
    }
}

// Tubes that follow paths overlap between slices, where no contour can give the overlap to one of them; as structures
// that exclude each other they would lose their paths.
Error not_along_paths(const ContourSet& set, const std::string& file) {
    return {ErrorKind::geometry,
            "E-PRI-002",
            "--priority gives overlaps away on the slices that draw them, but these structures are tubes on "
            "slices "
            "across their own paths, and they overlap between slices",
            {file, "", "", "", std::to_string(set.structures.size()) + " structures"},
            "leave out --priority: each structure is modelled whole, and what they have in common is a "
            "region of its "
            "own in the mesh; or model them one by one with --separate"};
}

Status give_to_first(PreparedContours& prepared, const PrepareOptions& options, RunContext& context) {
    if (options.priority.empty()) return Nothing{};
    ContourSet& kept = prepared.kept;
    const std::string file = input_name(options, kept.source);
    ANATOMESH_TRY(const std::vector<std::uint32_t> order,
                  find_in_order(kept.structures, options.priority, file));
    const bool follows_paths = !arrangement_of(kept, options.field.max_gap_spacings).paths.empty();
    ANATOMESH_TRY(PriorityResult result, part_structures(kept, order, options.field, context));
    if (follows_paths && result.kept.structures.size() > 1 && !result.kept.overlapping)
        return not_along_paths(kept, file);
    for (const std::uint32_t s : result.order)
        prepared.options.emplace_back("priority", unique_text(kept.structures, s));
    warn_of_giving(kept, result, file, context);
    kept = std::move(result.kept);
    if (kept.overlapping) prepared.options.emplace_back("overlaps", "nested");
    if (has_interpolated(kept)) prepared.options.emplace_back("outlines_between", "interpolated");
    return Nothing{};
}

// Of the contours as they were drawn, after what crossing slices say of each other.
void warn_of_outliers(const ContourSet& drawn, const PrepareOptions& options, RunContext& context) {
    if (!drawn.drawn) return;
    warn_about_outlying_slices(drawn, arrangement_of(drawn, options.field.max_gap_spacings), options.field,
                               context);
}

// `watch`: begun with the preparing.
Result<PreparedContours> finished(PreparedContours prepared, const PrepareOptions& options, Stopwatch watch,
                                  RunContext& context, const ContoursCheck& check) {
    ANATOMESH_CHECK_STATUS(rename_structure(prepared, options));
    // What the user says of slices takes the place of what the source says, for measures and written contours, too.
    if (options.field.single_slice_mm > 0) prepared.kept.slice_thickness_mm = options.field.single_slice_mm;
    prepared.stages.push_back({"contours", watch.lap(), prepared.kept.points.size(), 0, {}});
    if (options.until != PrepareUntil::all) {
        warn_of_outliers(prepared.kept, options, context);
        return prepared;
    }
    if (check) {
        ANATOMESH_CHECK_STATUS(check(prepared.kept));
    }
    ANATOMESH_TRY(ReconcileResult reconciled,
                  reconcile_contours(prepared.kept, reconcile_options(options), context));
    const ContourSet drawn = std::exchange(prepared.kept, std::move(reconciled.kept));
    prepared.crossing = crossing_report(prepared.kept, reconciled.stats, options.reconcile.reconcile);
    if (!prepared.crossing.pairs.empty()) prepared.crossing.movement = contour_movement(drawn, prepared.kept);
    warn_of_outliers(drawn, options, context);
    ANATOMESH_CHECK_STATUS(give_to_first(prepared, options, context));
    prepared.stages.push_back({"reconcile", watch.lap(), prepared.kept.points.size(), 0, {}});
    return prepared;
}

[[maybe_unused]] bool is_choice_of_slices(const PrepareOptions& options) {
    return options.choice.every.value_or(1) >= 1 && options.choice.offset < options.choice.every.value_or(1);
}

}  // namespace

TraceOptions trace_options(const PrepareOptions& options) {
    TraceOptions tracing;
    tracing.every = options.choice.every.value_or(1);
    tracing.offset = options.choice.offset;
    if (options.label_maps.min_area_mm2) tracing.min_area_mm2 = *options.label_maps.min_area_mm2;
    if (options.epsilon_mm) tracing.epsilon_mm = *options.epsilon_mm;
    tracing.axis = options.label_maps.axis;
    tracing.between_sparse = options.label_maps.between_sparse;
    return tracing;
}

ReconcileOptions reconcile_options(const PrepareOptions& options) {
    return with_widths(options.reconcile, options.walls);
}

Result<PreparedContours> prepare_contours(const RawContours& raw, const PrepareOptions& options,
                                          RunContext& context, const ContoursCheck& check) {
    const StandardArithmetic arithmetic;
    assert(is_choice_of_slices(options));
    const Stopwatch watch;
    ANATOMESH_TRY(PreparedContours prepared, drawn_contours(raw, options, context));
    return finished(std::move(prepared), options, watch, context, check);
}

Result<PreparedContours> prepare_contours(std::vector<LabelMap> layers, const GreyImage* grey,
                                          const PrepareOptions& options, RunContext& context,
                                          const ContoursCheck& check) {
    const StandardArithmetic arithmetic;
    assert(!layers.empty() && is_choice_of_slices(options));
    const Stopwatch watch;
    ANATOMESH_TRY(std::vector<TraceResult> traced, trace_layers(std::move(layers), grey, options, context));
    ANATOMESH_TRY(PreparedContours prepared, traced_contours(std::move(traced), options));
    return finished(std::move(prepared), options, watch, context, check);
}

Result<PreparedContours> prepare_contours(std::vector<TraceResult> layers, const PrepareOptions& options,
                                          RunContext& context, const ContoursCheck& check) {
    const StandardArithmetic arithmetic;
    assert(!layers.empty());
    const Stopwatch watch;
    ANATOMESH_TRY(PreparedContours prepared, traced_contours(std::move(layers), options));
    return finished(std::move(prepared), options, watch, context, check);
}

Result<PreparedContours> prepare_contours(ContourSet kept, const PrepareOptions& options, RunContext& context,
                                          const ContoursCheck& check) {
    const StandardArithmetic arithmetic;
    assert(is_choice_of_slices(options));
    const Stopwatch watch;
    ANATOMESH_TRY(
        const std::vector<std::uint32_t> chosen,
        find_structures(kept.structures, options.choice.structures, input_name(options, kept.source)));
    PreparedContours prepared;
    prepared.options = choice_told(options);
    prepared.traced_points = kept.points.size();
    prepared.kept =
        chosen.size() < kept.structures.size() ? choose_structures(kept, chosen) : std::move(kept);
    ANATOMESH_TRY(prepared.kept, without_slices(std::move(prepared.kept), options.choice.without));
    ANATOMESH_CHECK_STATUS(thin_and_share(prepared, options, context));
    tell_epsilon(prepared, options);
    return finished(std::move(prepared), options, watch, context, check);
}

PreparedContours choose_structures(const PreparedContours& prepared, std::span<const std::uint32_t> chosen) {
    PreparedContours part{choose_structures(prepared.kept, chosen),
                          prepared.crossing,
                          prepared.log,
                          prepared.options,
                          prepared.hole_rule,
                          prepared.traced_points,
                          prepared.islands_left_out,
                          prepared.epsilon_mm,
                          prepared.stages};
    return part;
}

}  // namespace anatomesh
