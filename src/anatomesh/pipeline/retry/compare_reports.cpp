#include "anatomesh/pipeline/retry/compare_reports.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <string>

#include "anatomesh/base/contract.h"
#include "anatomesh/measure/certificate/certificate.h"

namespace anatomesh {

namespace {

// Kept, not met, broken: the order of ClauseState.
bool keeps_clauses(const ModelReport& report, const ModelReport& other) {
    assert(report.certificate.size() == other.certificate.size());
    for (std::size_t n = 0; n < report.certificate.size(); ++n) {
        if (report.certificate[n].state > other.certificate[n].state) return false;
    }
    return true;
}

bool has_same_surface(const StructureReport& structure, const StructureReport& other) {
    return structure.surface.components == other.surface.components &&
           structure.surface.genus == other.surface.genus && structure.pieces == other.pieces &&
           structure.shells.voids == other.shells.voids &&
           structure.shells.without_contour <= other.shells.without_contour &&
           structure.shells.parts_too_many <= other.shells.parts_too_many &&
           structure.fidelity.vertices_on_surface >= other.fidelity.vertices_on_surface &&
           structure.fidelity.segments_on_surface >= other.fidelity.segments_on_surface;
}

bool has_same_surfaces(const ModelReport& report, const ModelReport& other) {
    assert(report.structures.size() == other.structures.size());
    return std::equal(report.structures.begin(), report.structures.end(), other.structures.begin(),
                      has_same_surface);
}

struct WrongCuts {
    std::size_t count = 0;
    double worst = 0;  // as a share of what is drawn
};

WrongCuts wrong_cuts(const ModelReport& report) {
    WrongCuts wrong;
    for (const SliceSectionReport& cut : report.contours.sections) {
        if (!(cut.difference_mm2 > contract::section_tolerance * cut.drawn_mm2)) continue;
        ++wrong.count;
        if (cut.drawn_mm2 > 0) wrong.worst = std::max(wrong.worst, cut.difference_mm2 / cut.drawn_mm2);
    }
    return wrong;
}

bool keeps_cuts(const ModelReport& report, const ModelReport& other) {
    const WrongCuts wrong = wrong_cuts(report), before = wrong_cuts(other);
    return wrong.count <= before.count && wrong.worst <= before.worst;
}

bool stays_near_field(const ModelReport& report, const ModelReport& other, const CompareOptions& options) {
    const auto no_farther = [&](double mm, double before) {
        return mm <= std::max(options.farther * before, options.near_mm);
    };
    return no_farther(report.field.distance.max_mm, other.field.distance.max_mm) &&
           report.field.distance.at_least <= other.field.distance.at_least &&
           no_farther(report.field.distance.joined_mm, other.field.distance.joined_mm) &&
           no_farther(report.field.difference.max_mm, other.field.difference.max_mm);
}

bool keeps_shapes(const ModelReport& report, const ModelReport& other, const CompareOptions& options) {
    const QualityReport &quality = report.quality, &before = other.quality;
    const auto unforced = [](const ModelReport& of) {
        return static_cast<double>(of.listed_cells.total - of.listed_cells.forced);
    };
    const double few = options.over_bound * static_cast<double>(report.counts.tetrahedra);
    return quality.radius_edge.mean <= before.radius_edge.mean &&
           quality.radius_edge.share_over_2 <=
               std::max(before.radius_edge.share_over_2, options.over_bound) &&
           quality.radius_edge.max <= std::max(before.radius_edge.max, options.largest_ratio) &&
           quality.dihedral_deg.below_10 <= before.dihedral_deg.below_10 &&
           quality.dihedral_deg.min >= std::min(before.dihedral_deg.min, contract::bad_dihedral_degrees) &&
           unforced(report) <= std::max(unforced(other), few);
}

bool warns_no_more(std::span<const Warning> warnings, std::span<const Warning> others) {
    const auto count = [](std::span<const Warning> of, const std::string& code) {
        return std::count_if(of.begin(), of.end(),
                             [&](const Warning& warning) { return warning.code == code; });
    };
    return std::all_of(warnings.begin(), warnings.end(), [&](const Warning& warning) {
        return count(warnings, warning.code) <= count(others, warning.code);
    });
}

}  // namespace

bool is_no_worse(const ComparedModel& model, const ComparedModel& other, const CompareOptions& options) {
    const ModelReport &report = model.report, &before = other.report;
    return static_cast<double>(report.counts.tetrahedra) <=
               options.most_cells * static_cast<double>(before.counts.tetrahedra) &&
           keeps_clauses(report, before) && has_same_surfaces(report, before) && keeps_cuts(report, before) &&
           stays_near_field(report, before, options) && keeps_shapes(report, before, options) &&
           warns_no_more(model.warnings, other.warnings);
}

}  // namespace anatomesh
