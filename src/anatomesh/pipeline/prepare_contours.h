// prepare_contours: from contours as a file gave them, or label maps, to the contours that a model is made
// of.
//
// Drawn contours (RawContours) are chosen, cleaned (clean.h), simplified if that is asked for, and get walls
// in common (share_walls.h). Label maps are chosen, traced (trace.h) and simplified: their structures share
// walls already. Then slices that cross are made to agree (reconcile.h), and where structures overlap the
// first keeps what they have in common (outlines_between.h). The program does the same by the same call.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh/contour/trace/trace.h"
#include "anatomesh/contour/walls/share_walls.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/image/image.h"
#include "anatomesh/image/threshold.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh {

enum class PrepareUntil : std::uint8_t {
    chosen,  // chosen, cleaned or traced, simplified: drawn contours as they were drawn
    walls,   // and walls of neighbouring structures are shared
    all      // and slices that cross agree, and overlaps are given to the first structure
};

// Which part of the input is taken.
struct ChoiceOptions {
    // Structures to take, by name or number (find_structures.h); empty: all.
    std::vector<std::string> structures;
    // The name that the one structure gets which is taken; empty: as the input calls it.
    std::string name;
    // Slices to leave out, by their names in messages (chosen_slices.h).
    std::vector<std::string> without;
    // Of slices that are parallel every n-th one, from the offset on. Slices; every: [1, 1e6], nothing: all
    // of them; offset: [0, every).
    std::optional<std::uint32_t> every;
    std::uint32_t offset = 0;
};

// How label maps are made and traced; drawn contours have no use for it.
struct LabelMapOptions {
    // Of a grey image the voxels from low to high, in its unit, were taken for the label map.
    std::optional<ThresholdOptions> threshold;
    // Of each structure so many of its largest pieces are kept (components.h). [1, 1e6]; nothing: all of
    // them.
    std::optional<std::uint32_t> keep_largest;
    // Islands of a slice below this area are left out, and counted. mm2, [0, 1e6]; nothing: 4 pixels.
    std::optional<double> min_area_mm2;
    // The patient's axis that slices follow: 0 x, 1 y, 2 z. Nothing: the voxel axis with the largest spacing.
    std::optional<std::uint32_t> axis;
    // Of a structure that is painted on every n-th slice alone.
    BetweenSparse between_sparse = BetweenSparse::nothing;
    Frame frame = Frame::lps;  // of the maps' geometry
};

struct PrepareOptions {
    ChoiceOptions choice;
    // Every traced or drawn point stays within this of the kept polygon. mm, 0 or [1e-6, 10]; 0: all points
    // stay; nothing: 0.15 of the pixel for traced contours, and all drawn points but crowded ones
    // (CleanOptions::crowded_mm).
    std::optional<double> epsilon_mm;
    LabelMapOptions label_maps;

    // Drawn contours. The `without` of `choice` takes the place of that of `clean`.
    CleanOptions clean;
    // Contours of different frames of reference are taken as they are (one_space.h).
    bool take_spaces_for_one = false;
    WallOptions walls;

    // The widths of `walls` take the place of those here.
    ReconcileOptions reconcile;
    // Structures by name or number, the first first: it keeps what it has in common with others; those that
    // are not named come after them (priority.h). Empty: structures may overlap. Texts, since cleaning leaves
    // out structures without contours, and so moves their indices.
    std::vector<std::string> priority;
    // How the field is made between slices and beyond the last ones: outlines that priority needs on slices
    // which say nothing of a structure follow it, and so does the model (make_model.h).
    FieldOptions field;

    PrepareUntil until = PrepareUntil::all;
    // What messages about these options call the input; empty: the source of the contours.
    std::string input;
    // PreparedContours::options names the options of cleaning also where these and `walls` are the defaults.
    bool name_cleaning = false;
};

struct PreparedContours {
    ContourSet kept;
    CrossingReport crossing;  // without pairs: no slices cross
    // For the report of a model, as in ModelReport.
    std::vector<ContourReport> log;                            // of every drawn contour
    std::vector<std::pair<std::string, std::string>> options;  // name, value as used
    std::string hole_rule;
    std::uint64_t traced_points = 0;  // before simplification; of drawn contours, the points of the file
    std::uint32_t islands_left_out = 0;
    double epsilon_mm = 0;            // 0: none
    std::vector<StageReport> stages;  // "contours", "reconcile"
};

// Called with the contours before slices are made to agree and overlaps are given: its error ends the run, so
// that a caller can refuse in time what does not suit them. Not called unless PrepareOptions::until is all.
using ContoursCheck = std::function<Status(const ContourSet& kept)>;

// Guarantees: a kept contour set (contour_set.h), the same at any thread count. Errors and warnings: those of
// the steps; usage E-CMD-005 no structure of such a name; E-CMD-008 an option that does not apply to these
// contours (choice.name of several structures; choice.every of slices that are not parallel, or leaving none; gaps closed of one structure
// alone); geometry E-PRI-002 priority of tubes along paths, which overlap between slices; E-RTS-010 (one_space.h);
// cancelled. Warnings of its own: W-CMD-006 what a structure gave to others,
// W-CMD-007 priority without overlaps. Complexity: that of the steps.
Result<PreparedContours> prepare_contours(const RawContours& raw, const PrepareOptions& options,
                                          RunContext& context, const ContoursCheck& check = {});

// The same of label maps, one or several that may overlap (of one geometry, no structure number in two of
// them). `grey`: the image that label_maps.threshold made the one label map of, for contours within its
// pixels; or null. Requires: at least one map.
Result<PreparedContours> prepare_contours(std::vector<LabelMap> layers, const GreyImage* grey,
                                          const PrepareOptions& options, RunContext& context,
                                          const ContoursCheck& check = {});

// The same of what was traced, one set a layer, of structures, slices of choice.every, and largest pieces
// that the caller chose. Requires: at least one.
Result<PreparedContours> prepare_contours(std::vector<TraceResult> layers, const PrepareOptions& options,
                                          RunContext& context, const ContoursCheck& check = {});

// The same of a kept contour set; what is drawn gets walls in common.
Result<PreparedContours> prepare_contours(ContourSet kept, const PrepareOptions& options, RunContext& context,
                                          const ContoursCheck& check = {});

// The options of the steps by these: for a caller that traces by itself, and of reconcile_contours(), with
// the widths of `walls`.
TraceOptions trace_options(const PrepareOptions& options);
ReconcileOptions reconcile_options(const PrepareOptions& options);

// Some of the prepared structures, with what is said of all. Requires: indices into kept.structures.
PreparedContours choose_structures(const PreparedContours& prepared, std::span<const std::uint32_t> chosen);

}  // namespace anatomesh
