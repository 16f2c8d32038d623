// What of a model's measured figures its user should hear, whoever made it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/base/structure.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Of a report filled by measure_model(). Warnings: W-PIP-003 a cut that differs from what is drawn by more
// than 1 % of its area; W-PIP-012 contour segments that are not edges all along; per
// structure W-PIP-006 shells without a contour vertex, and W-PIP-007 contours whose vertices lie on several
// shells; W-PIP-008 a surface further from the field than half of `size_mm`, the model's edge length, or than
// the field tells distances; W-PIP-009 two surfaces in one that the field has more than half of it apart;
// W-PIP-010 a part in the field or the model alone, deeper than half of it; W-PIP-013 contours that follow
// the surface; W-PIP-014 cells that contours force to be beyond what the certificate calls gross. `file`: of
// the contours.
void warn_of_model(const ModelReport& report, double size_mm, const std::string& file, RunContext& context);

// Of the field alone, by structure. Warning: W-PIP-011 what lies between the slices has another volume than
// drawn areas times the thickness that each slice stands for, by more than 5 %: the field takes something
// from a structure there, or gives it more than is drawn. Not `exclusive`, structures are free to taper and to
// end as they do, and only what that does not explain counts. Nothing is said where planes are not parallel.
void warn_of_volumes(std::span<const StructureVolume> volumes, std::span<const Structure> structures,
                     bool exclusive, const std::string& file, RunContext& context);

// Of a model, W-PIP-015: structures that overlap by more than a thousandth of the smaller one, and what both
// have, as volumes of the mesh; the pair that has most is named. Requires: as measure_model(). O(cells)
void warn_of_overlaps(const TetMesh& mesh, const RegionTable& regions, std::span<const Structure> structures,
                      const std::string& file, RunContext& context);

// A structure whose mean thickness is below so many edge lengths is warned of: its walls may have holes.
// [edge lengths; > 0; C W-PIP-002]
inline constexpr double thin_sizes = 0.8;

// Of contours before a model is built, W-PIP-002: structures thinner than that. `thickness`: by structure, mm;
// 0: not known.
void warn_of_thin_structures(const ContourSet& contours, const std::vector<double>& thickness, double size_mm,
                             RunContext& context);

// What to try in place of a size with which a model broke its contract. `thickness`: as above.
std::string advice_on_size(const std::vector<double>& thickness, double size_mm, bool size_given);

// Of a model for the shapes of which less was done than can be, W-PIP-005: what that left.
void warn_of_constraint_limited_cells(const ModelReport& report, const std::string& file,
                                      RunContext& context);

}  // namespace anatomesh
