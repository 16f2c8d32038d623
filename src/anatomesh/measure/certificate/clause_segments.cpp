#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/number_text.h"
#include "anatomesh/measure/certificate/clauses.h"
#include "anatomesh/measure/certificate/count_text.h"

namespace anatomesh {

namespace {

std::string place_text(const SliceSectionReport& section) {
    return section.structure + ", slice " + section.slice;
}

// The first few of the cross-sections that `wanted` picks, those with the largest `value` first.
template <class Wanted, class Value, class Text>
std::string worst_places(const ModelReport& report, const Wanted& wanted, const Value& value,
                         const Text& text) {
    std::vector<const SliceSectionReport*> worst;
    for (const SliceSectionReport& section : report.contours.sections) {
        if (wanted(section)) worst.push_back(&section);
    }
    std::stable_sort(worst.begin(), worst.end(),
                     [&](const auto* a, const auto* b) { return value(*a) > value(*b); });
    std::string places;
    for (std::size_t n = 0; n < std::min(worst.size(), named_places); ++n)
        places += (n > 0 ? "; " : "") + place_text(*worst[n]) + ": " + text(*worst[n]);
    return places;
}

// The cross-sections of the model beside the drawn regions: the sum, the worst slices, and how many are not as drawn.
std::string cuts_text(const ModelReport& report, std::size_t& above) {
    const auto is_drawn = [](const SliceSectionReport& section) { return section.drawn_mm2 > 0; };
    const auto share = [](const SliceSectionReport& section) {
        return section.difference_mm2 / section.drawn_mm2;
    };
    const auto too_far = [&](const SliceSectionReport& section) {
        return is_drawn(section) && section.difference_mm2 > contract::section_tolerance * section.drawn_mm2;
    };
    double drawn = 0, difference = 0, worst = 0;
    std::size_t total = 0, far = 0, strange = 0;
    for (const SliceSectionReport& section : report.contours.sections) {
        far += too_far(section);
        if (!is_drawn(section)) {
            ++strange;
            continue;
        }
        ++total;
        drawn += section.drawn_mm2;
        difference += section.difference_mm2;
        worst = std::max(worst, share(section));
    }
    above = far + strange;
    std::string text =
        "on the slices where a structure is drawn: difference between the model's cross-sections and the "
        "drawn "
        "regions " +
        percent_text(difference, drawn, 4) + " of the area in all, at most " + percent_text(worst, 1, 3) +
        ", above " + percent_text(contract::section_tolerance, 1, 1) + " in " + count_of(far, total) +
        " cross-sections";
    if (far > 0) {
        text += " (" +
                worst_places(report, too_far, share,
                             [&](const SliceSectionReport& section) {
                                 return percent_text(share(section), 1, 3) + ", " +
                                        fixed_text(section.difference_mm2, 2) + " mm2";
                             }) +
                ")";
    }
    text += "; where it is not drawn: cross-sections in " +
            count_of(strange, report.contours.sections_not_drawn) + " slices";
    if (strange > 0) {
        text += " (" +
                worst_places(
                    report, [&](const SliceSectionReport& section) { return !is_drawn(section); },
                    [](const SliceSectionReport& section) { return section.difference_mm2; },
                    [](const SliceSectionReport& section) {
                        return fixed_text(section.difference_mm2, 2) + " mm2";
                    }) +
                ")";
    }
    return text;
}

std::string routed_text(const ModelReport& report) {
    if (report.contours.routed.empty()) return {};
    std::uint64_t segments = 0;
    double farthest_mm = 0;
    for (const RoutedContourReport& contour : report.contours.routed) {
        segments += contour.segments;
        farthest_mm = std::max(farthest_mm, contour.farthest_mm);
    }
    return ", " + std::to_string(report.contours.routed.size()) +
           " of the contours after they were moved to edges of the surface at " + std::to_string(segments) +
           " drawn segments, by at most " + fixed_text(farthest_mm, 3) + " mm";
}

std::string segments_text(const ContourFindings& findings, const ModelReport& report) {
    const StructureFidelity& all = findings.all;
    std::string text =
        count_of(all.segments_on_surface, all.segments) + " contour segments (" +
        percent_text(static_cast<double>(all.segments_on_surface), static_cast<double>(all.segments), 2) +
        ") are chains of surface edges" + routed_text(report);
    if (all.segments_on_surface == all.segments) return text;
    const auto missed = [](const SliceSectionReport& section) { return section.segments_missed; };
    text += " (missed most in " +
            worst_places(report, missed, missed,
                         [&](const SliceSectionReport& section) { return std::to_string(missed(section)); }) +
            ")";
    if (findings.contradicted > 0)
        text += ", " + std::to_string(findings.contradicted) +
                " of the others cross another slice where that slice contradicts them";
    return text;
}

// The structure whose cross-sections by all slices together are farthest from what is drawn, where that is gross.
// Several may have one name, so they go by their place among the contours' structures.
std::string gross_cuts_text(const ContourFindings& findings, const ModelReport& report) {
    const std::vector<SliceSectionReport>& sections = report.contours.sections;
    struct Areas {
        std::string name;
        double drawn = 0, amiss = 0;
    };
    std::map<std::uint32_t, Areas> areas;
    for (std::size_t n = 0; n < sections.size(); ++n) {
        Areas& area = areas[findings.structure_of[n]];
        area.name = sections[n].structure;
        area.drawn += sections[n].drawn_mm2;
        area.amiss += sections[n].difference_mm2;
    }
    std::string text;
    double worst = contract::gross_section_share;
    for (const auto& [structure, area] : areas) {
        if (area.amiss <= worst * area.drawn) continue;
        if (area.drawn > 0) worst = area.amiss / area.drawn;
        const auto of_it = [&, s = structure](const SliceSectionReport& section) {
            return findings.structure_of[static_cast<std::size_t>(&section - sections.data())] == s;
        };
        text = "of all slices together " + percent_text(area.amiss, area.drawn, 1) +
               " of the drawn area of " + area.name + " are wrong, more than " +
               percent_text(contract::gross_section_share, 1, 0) + " (most on " +
               worst_places(
                   report, of_it, [](const SliceSectionReport& section) { return section.difference_mm2; },
                   [](const SliceSectionReport& section) {
                       return fixed_text(section.difference_mm2, 2) + " of " +
                              fixed_text(section.drawn_mm2, 2) + " mm2";
                   }) +
               "); ";
    }
    return text;
}

}  // namespace

Clause clause_segments(const CertificateInput& input, const ContourFindings& findings,
                       const ModelReport& report) {
    Clause clause{
        2, ClauseState::not_promised_yet,
        "Every segment of a kept contour is a chain of surface edges; the cross-section of the model in the "
        "slice's plane is the drawn region, and empty where a structure is not drawn.",
        "not checked: no contours were given"};
    if (!input.contours) return clause;
    std::size_t above = 0;
    clause.evidence = segments_text(findings, report) + "; " + cuts_text(report, above);
    if (findings.all.segments_on_surface == findings.all.segments && above == 0) {
        clause.state = ClauseState::kept;
        return clause;
    }
    const std::string gross = gross_cuts_text(findings, report);
    if (!gross.empty()) clause.state = ClauseState::broken;
    clause.evidence = "measured, not met: " + gross + clause.evidence;
    return clause;
}

}  // namespace anatomesh
