// ModelReport: everything that is said about a model, as plain data; anatomesh_io/report writes it as JSON
// and HTML.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"

namespace anatomesh {

// `moved`: kept with regard to contours that stand farther from where they were drawn than slices are sharp.
enum class ClauseState : std::uint8_t { kept, moved, not_promised_yet, broken };

// One clause of the contract (docs/stages/11-certificate.md): 1 to 6.
struct Clause {
    int number = 0;
    ClauseState state = ClauseState::not_promised_yet;
    std::string statement;  // what is promised, one sentence
    std::string evidence;   // the measured figures, one sentence
};

// How many cells a report lists by number; the rest are counted. [cells; >= 1; B]
inline constexpr std::size_t max_listed_cells = 10'000;

// A cell that breaks a bound, with what forces it.
struct ListedCell {
    std::uint32_t cell = 0;
    double value = 0;  // its radius-edge ratio
    double min_dihedral_deg = 0;
    std::array<double, 3> at{};  // centroid, mm
    std::string forced_by;  // "contour vertices 12 and 13 0.21 mm apart in slice k = 7", "" when not known
};

// Counts of bins of equal width from low to high; values beyond are counted in the end bins.
struct Histogram {
    double low = 0, high = 1;
    std::vector<std::uint64_t> counts;
};

struct RadiusEdgeReport {
    double mean = 0, p99 = 0, max = 0;
    double share_over_2 = 0;
    std::uint64_t over_2 = 0;
    Histogram histogram;
};

// Of the smallest angle of every cell; `max`: of its largest one.
struct DihedralReport {
    double min = 0, p01 = 0, median_min = 0, max = 0;
    std::uint64_t below_10 = 0, below_15 = 0;
    Histogram histogram;
};

struct EdgeReport {
    double min = 0, mean = 0, max = 0;
};

// The shapes of all cells.
struct QualityReport {
    RadiusEdgeReport radius_edge;
    DihedralReport dihedral_deg;
    EdgeReport edge_mm;
};

// The shells of a structure's surface, and which of them the contours know of.
struct ShellReport {
    std::uint32_t voids = 0;  // shells that bound a cavity
    double smallest_mm3 = 0;  // volume that the smallest shell encloses
    // With contours: shells with no contour vertex on them, what they enclose in all, and the largest of
    // them.
    std::uint32_t without_contour = 0;
    double without_contour_mm3 = 0, largest_without_contour_mm3 = 0;
    std::array<double, 3> largest_at{};  // mm
    // With contours: a contour is one closed line, so its vertices belong on one shell. Those that lie on
    // several, by how many the shells are more than they could be, and the slice of the one on most.
    std::uint32_t contours_in_parts = 0, parts_too_many = 0;
    std::string worst_slice;
};

// A structure's surface: its size, and how it is connected.
struct SurfaceReport {
    std::uint64_t triangles = 0, vertices = 0;
    double area_mm2 = 0;
    std::uint32_t components = 0;  // its shells
    std::int64_t genus = 0;        // summed over these
    std::uint64_t open_edges = 0, nonmanifold_edges = 0, nonmanifold_vertices = 0;
};

// A structure's volume in three ways; 0: not known.
struct VolumeReport {
    double mesh_mm3 = 0;    // sum of its cells
    double field_mm3 = 0;   // integral of the field's cross-sections
    double slices_mm3 = 0;  // plain slice integration: area x spacing
};

// How many of a structure's contour vertices and segments its surface has; 0 without contours.
struct FidelityReport {
    std::uint64_t vertices = 0, vertices_on_surface = 0;
    std::uint64_t segments = 0, segments_on_surface = 0;  // chains of surface edges
    std::uint64_t segments_contradicted = 0;              // of the others, those of contradicted_segments.h
};

struct StructureReport {
    std::int32_t number = 0;
    std::string name;
    std::array<std::uint8_t, 3> color{200, 200, 200};
    std::uint64_t tetrahedra = 0;
    std::uint32_t pieces = 0;  // of its volume
    VolumeReport volume;
    SurfaceReport surface;
    ShellReport shells;
    FidelityReport fidelity;
};

// The cross-section of the model by a slice's plane beside what is drawn there, for one structure.
struct SliceSectionReport {
    std::string structure, slice;
    double drawn_mm2 = 0,               // area of the drawn region; 0: not drawn on this slice
        difference_mm2 = 0;             // of its symmetric difference with the cross-section
    std::uint32_t segments_missed = 0;  // of its contours: no chains of surface edges
};

// A contour that leaves what is drawn to lie on the surface, where no edges of that run along it.
struct RoutedContourReport {
    std::string structure, slice;
    std::uint64_t segments = 0,  // drawn, that were missed
        vertices_left = 0;       // drawn, that it passes by
    double farthest_mm = 0,      // of the contour from what is drawn, and of that from it
        difference_mm2 = 0;      // area of the symmetric difference of both regions
};

// How far the surfaces are from those of the field where that is most.
struct FieldDistanceReport {
    std::uint64_t points = 0;  // measured: vertices of the surface and middles of its facets; 0: no field
    double max_mm = 0;
    bool at_least = false;  // the field tells no larger distances
    std::array<double, 3> at{};
    std::string structure;  // on whose surface
    // Where facets lie on two surfaces at once which the field has apart: a hole through what is between
    // them. The widest such gap that a facet leaves no room for; 0: none.
    double joined_mm = 0;
    std::array<double, 3> joined_at{};
    std::string joined_structure;  // whose surface is not there
};

// Where the model and the field hold different space farthest from the model's surface.
struct FieldDifferenceReport {
    std::uint64_t points = 0, differing = 0;  // of lattices over all structures; 0: no field
    double max_mm = 0;
    std::array<double, 3> at{};
    std::string structure;
    bool missing = false;  // there: the field is inside and the model is not; else the other way round
};

struct StageReport {
    std::string name;
    double seconds = 0;                   // the only kind of figure that may differ between runs
    std::uint64_t points = 0, cells = 0;  // after the stage
    std::vector<std::pair<std::string, double>> figures;  // what the stage counted: "culled_share" -> 0.38
};

// How much was done, in numbers that are the same on every machine: what makes a run slower shows here first.
struct WorkReport {
    std::uint64_t meshings = 0;        // whole runs of the method, the one that made the model included
    std::uint64_t delaunay_cells = 0;  // made by the Delaunay kernel, those that went again included
    std::uint64_t edited_cells = 0;    // put in the place of others by improvement, those taken back included
    std::uint64_t field_values =
        0;  // places at which the field was asked; counted on one thread alone, else 0

    void add(const WorkReport& other) {
        meshings += other.meshings;
        delaunay_cells += other.delaunay_cells;
        edited_cells += other.edited_cells;
        field_values += other.field_values;
    }
};

struct InputReport {
    std::string file, format, sha256;
    std::uint64_t bytes = 0;
};

struct ContourReport {
    std::string structure, slice, name, rule;
    std::uint32_t points_in = 0, points_kept = 0;
    double max_displacement_mm = 0, area_change_mm2 = 0;
};

// Two slices whose planes cross, on their common line; lengths in mm.
struct CrossingPairReport {
    std::string slice_a, slice_b;
    std::uint64_t ends = 0,
                  unmatched = 0;  // region ends that correspond; intervals and gaps of one slice only
    double median_mm = 0, p95_mm = 0, max_mm = 0;  // distances of corresponding ends, as drawn
    double difference_mm = 0,
           difference_after_mm = 0;  // length of the symmetric difference: as drawn, as kept
};

struct SliceMovementReport {
    std::string slice;
    double mean_mm = 0, max_mm = 0;  // of its drawn vertices, by reconciling
    std::array<double, 3> shift{};   // rigid, by --align
};

// How far the contours that a model is made of are from where they were drawn, because slices that cross were
// made to agree. A contour is moved if a vertex of it is farther than the bound.
struct ContourMovementReport {
    double bound_mm = 0;  // half a slice spacing; 0: not measured
    double farthest_mm = 0;
    std::uint64_t contours = 0, contours_moved = 0, vertices = 0, vertices_moved = 0;  // as drawn
    std::string structure, slice;                                                      // of the farthest
};

// How far crossing slices agreed, and what was moved. Without pairs: no planes cross.
struct CrossingReport {
    bool reconciled = false;
    std::uint64_t ends = 0, unmatched = 0, shared_points = 0;
    double median_mm = 0, p95_mm = 0, max_mm = 0, difference_mm = 0, difference_after_mm = 0;
    double mean_movement_mm = 0, max_movement_mm = 0;
    std::vector<CrossingPairReport> pairs;
    std::vector<SliceMovementReport> slices;
    ContourMovementReport movement;
};

// What a model was made of, by which program, and with which options.
struct ProvenanceReport {
    std::string version, command;
    std::vector<std::pair<std::string, std::string>> libraries;  // name, version: "CGAL" -> "5.5.1"
    std::vector<InputReport> inputs;
    std::vector<std::pair<std::string, std::string>> options;  // name, value as used (after defaults)
};

// How coordinates and contours are understood.
struct ConventionsReport {
    std::string space = "LPS", unit = "mm";
    std::string hole_rule, end_caps;
};

// How much there is of the model and of its contours.
struct CountsReport {
    std::uint64_t vertices = 0, tetrahedra = 0, surface_triangles = 0;  // of the model
    std::uint64_t slices = 0, contours = 0, contour_vertices = 0;       // as kept
    std::uint64_t traced_points = 0, islands_left_out = 0;              // before that
};

// The lengths that the run went by; 0: not known, or none.
struct LengthsReport {
    double epsilon_mm = 0, size_mm = 0, slice_spacing_mm = 0;
};

// The Delaunay mesh between the steps.
struct MeshingReport {
    double share_culled = 0;                        // of its cells
    double radius_edge_mean_before_refinement = 0;  // over the kept cells
};

// The cells beyond a bound: a radius-edge ratio above 2, or an angle below 10 degrees.
struct ListedCellsReport {
    std::vector<ListedCell> cells;  // worst ratios first, then angles; at most max_listed_cells
    std::uint64_t total = 0;        // beyond the bounds, listed or not
    std::uint64_t forced = 0;       // of these, by the input, with the reason known
    std::uint64_t bad = 0;          // beyond what clause 4 allows for a single cell, and nothing forces them
};

// What became of the contours: how each was read, and where the model is not as drawn.
struct ContoursReport {
    std::vector<ContourReport> log;
    // Those of slices on which a structure is drawn, and those where it is not but the model has it.
    std::vector<SliceSectionReport> sections;
    std::uint64_t sections_not_drawn = 0;  // measured on slices where a structure is not drawn
    std::vector<RoutedContourReport> routed;
};

// How far the model agrees with the field that it was made of.
struct FieldAgreementReport {
    FieldDistanceReport distance;
    FieldDifferenceReport difference;
};

// What the run did, stage by stage and in all.
struct RunReport {
    std::vector<StageReport> stages;
    WorkReport work;
};

// Every group says what one stage or measurement found; those of contours and of the field are empty without
// these.
struct ModelReport {
    ProvenanceReport provenance;
    ConventionsReport conventions;
    CountsReport counts;
    LengthsReport lengths;
    MeshingReport meshing;
    std::vector<StructureReport> structures;
    std::vector<std::vector<std::uint32_t>> regions;  // members by region, indices into structures; [0] empty
    QualityReport quality;
    std::vector<Clause> certificate;
    ListedCellsReport listed_cells;
    ContoursReport contours;
    FieldAgreementReport field;
    CrossingReport crossing;
    RunReport run;
    std::vector<Warning> warnings;
};

}  // namespace anatomesh
