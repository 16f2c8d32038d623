#include "anatomesh/pipeline/model/model_warnings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/number_text.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

// If more of a drawn region's area is amiss on its slice, W-PIP-003 names the worst slice.
// [1, of the area; 0 to 1; C W-PIP-003]
constexpr double widest_cut = 0.01;
// A surface further from the field than this is warned of: it is a spike, a crumb or a cavity.
// [edge lengths; > 0; C W-PIP-008]
constexpr double widest_distance = 0.5;
// A field whose volume differs from slice integration by a larger share is warned of.
// [1, of the volume; 0 to 1; C W-PIP-011]
constexpr double widest_volume_share = 0.05;
// An overlap below this share of the smaller structure is none: outlines that touch have some.
// [1, of the volume; 0 to 1; M 2026-11, set not recorded]
constexpr double least_overlap = 1e-3;
// Surfaces further apart in the field that meet in the mesh are warned of: a wall between them has a hole.
// [edge lengths; > 0; C W-PIP-009]
constexpr double widest_joint = 0.5;

std::string counted(std::uint64_t count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string at_text(const std::array<double, 3>& at) {
    return fixed_text(at[0], 1) + " " + fixed_text(at[1], 1) + " " + fixed_text(at[2], 1);
}

// The contours hold, and yet the model may leave them between their vertices and segments.
void warn_of_cuts(const ModelReport& report, const std::string& file, RunContext& context) {
    const SliceSectionReport* worst = nullptr;
    std::size_t count = 0;
    for (const SliceSectionReport& cut : report.contours.sections) {
        if (!(cut.difference_mm2 > widest_cut * cut.drawn_mm2)) continue;
        ++count;
        const bool worse =
            !worst || cut.difference_mm2 * worst->drawn_mm2 > worst->difference_mm2 * cut.drawn_mm2;
        if (worse) worst = &cut;
    }
    if (!worst) return;
    Place place;
    place.file = file;
    place.slice = worst->slice;
    place.structure = worst->structure;
    place.value = worst->drawn_mm2 > 0
                      ? brief(100 * worst->difference_mm2 / worst->drawn_mm2) + " % of the area"
                      : brief(worst->difference_mm2) + " mm2 where it is not drawn";
    context.warn({"W-PIP-003",
                  "on " + counted(count, "slice") +
                      " the cross-section of the model differs from the drawn area by more than " +
                      brief(100 * widest_cut) + " %; the worst slice is named",
                  place, "kept; a smaller --size follows small or thin parts more closely"});
}

// Where a mesh misses them it is mostly for the slivers between contours of two structures, or for slices
// that contradict each other.
void warn_of_segments(const ModelReport& report, const std::string& file, RunContext& context) {
    std::uint64_t missed = 0, all = 0, contradicted = 0;
    const StructureReport* worst = nullptr;
    const auto missed_of = [](const StructureReport& s) {
        return s.fidelity.segments - s.fidelity.segments_on_surface;
    };
    for (const StructureReport& structure : report.structures) {
        missed += missed_of(structure);
        all += structure.fidelity.segments;
        contradicted += structure.fidelity.segments_contradicted;
        if (!worst || missed_of(structure) > missed_of(*worst)) worst = &structure;
    }
    if (missed == 0) return;
    Place place;
    place.file = file;
    place.structure = worst->name.empty() ? std::to_string(worst->number) : worst->name;
    place.value = counted(missed_of(*worst), "segment");
    context.warn({"W-PIP-012",
                  std::to_string(missed) + " of " + std::to_string(all) +
                      " contour segments are not followed by edges of the surface" +
                      (contradicted > 0 ? ", and " + std::to_string(contradicted) +
                                              " of them cross another slice where that slice contradicts them"
                                        : std::string()) +
                      "; the structure with most of them is named",
                  place,
                  contradicted == missed         ? "kept; check the drawing where these slices cross"
                  : report.structures.size() > 1 ? "kept; where contours of neighbouring structures are "
                                                   "closer than a pixel, --close-gaps gives them a "
                                                   "common boundary"
                                                 : "kept; the report states the difference for every slice"});
}

void warn_of_routed(const ModelReport& report, const std::string& file, RunContext& context) {
    const std::vector<RoutedContourReport>& contours = report.contours.routed;
    if (contours.empty()) return;
    std::uint64_t segments = 0, left = 0;
    const RoutedContourReport* farthest = &contours.front();
    for (const RoutedContourReport& contour : contours) {
        segments += contour.segments;
        left += contour.vertices_left;
        if (contour.farthest_mm > farthest->farthest_mm) farthest = &contour;
    }
    Place place;
    place.file = file;
    place.slice = farthest->slice;
    place.structure = farthest->structure;
    place.value = brief(farthest->farthest_mm) + " mm";
    context.warn(
        {"W-PIP-013",
         counted(contours.size(), "contour") + " " + (contours.size() == 1 ? "was" : "were") +
             " moved to edges of the surface at " + counted(segments, "drawn segment") +
             ", where planes or contours are too close together" +
             (left > 0 ? ", without " + std::to_string(left) + " of the drawn vertices" : std::string()) +
             "; the contour moved farthest is named",
         place, "the report lists them as followed_contours; --reconcile 0 keeps all contours as drawn"});
}

void warn_of_shells(const StructureReport& structure, const std::string& file, RunContext& context) {
    const ShellReport& shells = structure.shells;
    Place place;
    place.file = file;
    place.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
    if (shells.without_contour > 0) {
        place.value = brief(shells.largest_without_contour_mm3) + " mm3 at " + at_text(shells.largest_at);
        context.warn({"W-PIP-006",
                      counted(shells.without_contour, "closed piece") + " of the surface, of " +
                          brief(shells.without_contour_mm3) +
                          " mm3 in all, have no contour vertex, so that no contour explains them; the "
                          "largest is named",
                      place, "kept; check this place, it may be an error of the mesh"});
    }
    if (shells.parts_too_many > 0) {
        place.slice = shells.worst_slice;
        place.value = counted(shells.contours_in_parts, "contour");
        context.warn(
            {"W-PIP-007",
             "the structure has more parts than are drawn: " +
                 counted(shells.parts_too_many, "closed piece") +
                 " of its surface too many, because single contours lie on several; the worst slice is named",
             place, "kept; a smaller --size resolves thin or narrow parts"});
    }
}

void warn_of_distance(const ModelReport& report, double size_mm, const std::string& file,
                      RunContext& context) {
    const FieldDistanceReport& distance = report.field.distance;
    if (distance.points == 0 || (distance.max_mm <= widest_distance * size_mm && !distance.at_least)) return;
    Place place;
    place.file = file;
    place.structure = distance.structure;
    place.value = std::string(distance.at_least ? "at least " : "") + brief(distance.max_mm) + " mm at " +
                  at_text(distance.at);
    context.warn({"W-PIP-008",
                  "the surface is away from the surface given by the contours by more than " +
                      (distance.max_mm > widest_distance * size_mm
                           ? "half the edge length of " + brief(size_mm) + " mm"
                           : std::string("can be measured")) +
                      "; the farthest point is named",
                  place, "kept; check this place, it may be a spike or a part that no contour shows"});
}

// Thinner than an edge is long, and yet not so thin that the mesh may leave it out.
void warn_of_joints(const ModelReport& report, double size_mm, const std::string& file, RunContext& context) {
    const FieldDistanceReport& distance = report.field.distance;
    if (distance.points == 0 || !(distance.joined_mm > widest_joint * size_mm)) return;
    Place place;
    place.file = file;
    place.structure = distance.joined_structure;
    place.value = brief(distance.joined_mm) + " mm at " + at_text(distance.joined_at);
    context.warn({"W-PIP-009",
                  "two surfaces touch that the contours keep apart, so that the wall between them has a "
                  "hole; the worst place is "
                  "named",
                  place, "kept; a smaller --size keeps thin walls whole"});
}

// What farthest_from_field() cannot see: of a part that is not there no vertex is far off.
void warn_of_difference(const ModelReport& report, double size_mm, const std::string& file,
                        RunContext& context) {
    const FieldDifferenceReport& difference = report.field.difference;
    if (difference.points == 0 || difference.max_mm <= widest_distance * size_mm) return;
    Place place;
    place.file = file;
    place.structure = difference.structure;
    place.value = brief(difference.max_mm) + " mm at " + at_text(difference.at);
    context.warn({"W-PIP-010",
                  std::string(difference.missing ? "a part that the contours show is missing in the model"
                                                 : "the model has a part that the contours do not show") +
                      ", thicker than half the edge length of " + brief(size_mm) +
                      " mm; the deepest point is named",
                  place, "kept; a smaller --size keeps thin parts"});
}

// Cells that contours force to be so flat that nobody can compute with them; those that nothing forces are
// refused.
void warn_of_flat_cells(const ModelReport& report, const std::string& file, RunContext& context) {
    std::size_t count = 0;
    const ListedCell* worst = nullptr;
    for (const ListedCell& cell : report.listed_cells.cells) {
        const bool flat = !(cell.value <= contract::gross_radius_edge) ||
                          cell.min_dihedral_deg < contract::gross_dihedral_degrees;
        if (!flat || cell.forced_by.empty()) continue;
        ++count;
        if (!worst || cell.min_dihedral_deg < worst->min_dihedral_deg) worst = &cell;
    }
    if (!worst) return;
    context.warn({"W-PIP-014",
                  std::to_string(count) + (count == 1 ? " tetrahedron has" : " tetrahedra have") +
                      " a radius-edge ratio above " + brief(contract::gross_radius_edge) +
                      " or an angle below " + brief(contract::gross_dihedral_degrees) +
                      " degrees, because contours leave no space for better ones; the flattest is named",
                  {file, "", "", worst->forced_by,
                   brief(worst->min_dihedral_deg) + " degrees at " + brief(worst->at[0]) + " " +
                       brief(worst->at[1]) + " " + brief(worst->at[2])},
                  "kept and listed in the report (listed_cells); most solvers refuse them; draw these "
                  "vertices farther apart, or as "
                  "one"});
}

}  // namespace

void warn_of_model(const ModelReport& report, double size_mm, const std::string& file, RunContext& context) {
    warn_of_cuts(report, file, context);
    warn_of_segments(report, file, context);
    warn_of_routed(report, file, context);
    for (const StructureReport& structure : report.structures) warn_of_shells(structure, file, context);
    warn_of_distance(report, size_mm, file, context);
    warn_of_joints(report, size_mm, file, context);
    warn_of_difference(report, size_mm, file, context);
    warn_of_flat_cells(report, file, context);
}

void warn_of_overlaps(const TetMesh& mesh, const RegionTable& regions, std::span<const Structure> structures,
                      const std::string& file, RunContext& context) {
    std::vector<double> volumes(regions.members.size(), 0), of_structure(structures.size(), 0);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& v = mesh.cells[c];
        volumes[mesh.regions[c]] +=
            signed_volume(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> common;
    for (std::size_t r = 0; r < volumes.size(); ++r) {
        const std::vector<std::uint32_t>& members = regions.members[r];
        for (std::size_t n = 0; n < members.size(); ++n) {
            of_structure[members[n]] += volumes[r];
            for (std::size_t m = 0; m < n; ++m) common[{members[m], members[n]}] += volumes[r];
        }
    }
    std::erase_if(common, [&](const auto& pair) {
        const auto [s, t] = pair.first;
        return !(pair.second > least_overlap * std::min(of_structure[s], of_structure[t]));
    });
    if (common.empty()) return;
    const auto& [pair, volume] = *std::max_element(
        common.begin(), common.end(), [](const auto& p, const auto& q) { return p.second < q.second; });
    const auto name = [&](std::uint32_t s) {
        return structures[s].name.empty() ? std::to_string(structures[s].number) : structures[s].name;
    };
    const auto [smaller, larger] =
        of_structure[pair.second] < of_structure[pair.first] ? std::pair(pair.second, pair.first) : pair;
    context.warn(
        {"W-PIP-015",
         counted(common.size(), "pair") + " of structures " +
             (common.size() == 1 ? "overlaps" : "overlap; the pair with the largest overlap is named"),
         {file, "", name(smaller) + " and " + name(larger), "",
          brief(volume) + " mm3, " + brief(100 * volume / of_structure[smaller]) + " % of " + name(smaller)},
         "both were kept whole, and the overlap is a region of its own; --priority gives it to one of them"});
}

void warn_of_thin_structures(const ContourSet& contours, const std::vector<double>& thickness, double size_mm,
                             RunContext& context) {
    for (std::size_t s = 0; s < thickness.size(); ++s) {
        if (!(thickness[s] > 0) || thickness[s] >= thin_sizes * size_mm) continue;
        const Structure& structure = contours.structures[s];
        Place place;
        place.file = contours.source;
        place.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
        place.value = brief(thickness[s]) + " mm";
        context.warn(
            {"W-PIP-002",
             "the structure is thinner on average than the edge length of " + brief(size_mm) +
                 " mm, so that it may have holes",
             place, "kept; check its components and holes; --size " + brief(thickness[s]) + " resolves it"});
    }
}

std::string advice_on_size(const std::vector<double>& thickness, double size_mm, bool size_given) {
    if (!size_given) {
        return "edge lengths down to " + brief(size_mm) +
               " mm were tried: leave out thin or jagged structures (--structure, --min-area), or give a "
               "smaller --size";
    }
    double thinnest = size_mm;
    for (const double t : thickness) {
        if (t > 0) thinnest = std::min(thinnest, t);
    }
    if (!(thinnest < thin_sizes * size_mm)) return "give another --size";
    return "the thinnest structure is " + brief(thinnest) + " mm thick on average: give --size " +
           brief(thinnest) + ", or leave out --size";
}

void warn_of_constraint_limited_cells(const ModelReport& report, const std::string& file,
                                      RunContext& context) {
    const QualityReport& quality = report.quality;
    Place place;
    place.file = file;
    place.value = brief(100 * quality.radius_edge.share_over_2) +
                  " % of the tetrahedra above radius-edge ratio 2, " +
                  std::to_string(quality.dihedral_deg.below_10) + " with an angle below 10 degrees";
    context.warn({"W-PIP-005",
                  "the planes are closer together than the vertices of their contours; tetrahedra between "
                  "them were not improved "
                  "to save time, and the surface may have pits or spikes there",
                  place, "kept; give a --size to improve them, which takes several times as long"});
}

void warn_of_volumes(std::span<const StructureVolume> volumes, std::span<const Structure> structures,
                     bool exclusive, const std::string& file, RunContext& context) {
    for (std::size_t s = 0; s < volumes.size(); ++s) {
        const StructureVolume& volume = volumes[s];
        // False too where there is no slice integration.
        const double off = exclusive ? volume.by_field - volume.by_slices : volume.unexplained;
        if (!(std::abs(off) > widest_volume_share * volume.by_slices)) continue;
        Place place;
        place.file = file;
        place.structure =
            structures[s].name.empty() ? std::to_string(structures[s].number) : structures[s].name;
        place.value = brief(volume.by_field) + " of " + brief(volume.by_slices) + " mm3";
        context.warn(
            {"W-PIP-011",
             "the volume of the structure differs from the sum of its drawn areas times the slice thickness",
             place,
             exclusive
                 ? "kept; check the structure; beside or inside another one, a structure on few slices is "
                   "a guess between them"
                 : "kept; check the structure between its slices, or draw it on more of them; a thin part "
                   "that crosses them at a low angle may have necks"});
    }
}

}  // namespace anatomesh
