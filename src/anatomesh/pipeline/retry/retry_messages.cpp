#include "anatomesh/pipeline/retry/retry_messages.h"

#include "anatomesh/base/number_text.h"

namespace anatomesh {

namespace {

// Whether segments were split and that left bumps alone, no bad cell.
bool has_bumps_alone(const RunOutcome& outcome) {
    return conformed_badly(outcome) && outcome.score.bad == 0;
}

}  // namespace

Warning built_again(NextRun next, const RunOutcome& outcome, const std::string& error, double size_mm) {
    // Of a message up to the figures, which are of a model that nobody gets.
    const std::string reason = !error.empty()             ? error.substr(0, error.find(" ("))
                               : outcome.score.torn       ? "a thin wall had holes"
                               : has_bumps_alone(outcome) ? "the surface had bumps between dense planes"
                               : conformed_badly(outcome)
                                   ? "a tetrahedron had a bad shape without a reason in the contours"
                                   : "too many tetrahedra had a radius-edge ratio above 2";
    return {"W-PIP-001",
            (next != NextRun::finer ? "the run before did not meet the certificate: "
                                    : "the default edge length was too long for the smallest parts: ") +
                reason,
            {},
            "the model was built again with edges of " + brief(size_mm) + " mm"};
}

std::string sought_by(NextRun next, const RunOutcome& outcome) {
    const char* sake = !outcome.score.kept_contract ? "the certificate"
                       : outcome.score.torn         ? "torn walls"
                       : has_bumps_alone(outcome)   ? "bumps between dense planes"
                                                    : "ill-shaped tetrahedra";
    return std::string(next != NextRun::same_size ? "a shorter edge length" : "another way to build it") +
           " for the sake of " + sake;
}

}  // namespace anatomesh
