#include "anatomesh/pipeline/run/run_state.h"

#include <utility>

namespace anatomesh {

namespace {

std::vector<std::uint32_t> vertices_of_contours(const LabelledMesh& mesh, const PointSample& sample) {
    std::vector<std::uint32_t> vertices;
    vertices.reserve(sample.contour_vertices.size());
    for (const std::uint32_t n : sample.contour_vertices) vertices.push_back(mesh.first_vertices()[n]);
    return vertices;
}

std::vector<std::array<std::uint32_t, 2>> owners_of_vertices(const ContourSet& contours,
                                                             const std::vector<std::uint32_t>& vertices) {
    std::vector<std::array<std::uint32_t, 2>> owners;
    for (const Contour& contour : contours.contours) {
        for (std::uint32_t n = contour.first_point; n < contour.first_point + contour.point_count; ++n)
            owners.push_back({vertices[n], contour.structure});
    }
    return owners;
}

std::vector<std::uint8_t> given_vertices(const LabelledMesh& mesh, const PointSample& sample) {
    std::vector<std::uint8_t> given(mesh.points().size(), 0);
    for (std::size_t n = 0; n < sample.stats.contour_points; ++n) given[mesh.first_vertices()[n]] = 1;
    return given;
}

std::vector<Subsegment> subsegments_of(const LabelledMesh& mesh, const PointSample& sample) {
    const auto vertices = mesh.first_vertices();
    std::vector<Subsegment> subsegments;
    for (const Subsegment& subsegment : sample.subsegments)
        subsegments.push_back(
            {vertices[subsegment.a], vertices[subsegment.b], subsegment.structure, subsegment.ball});
    return subsegments;
}

ContourSubsegmentOptions subsegment_options(const Effort& effort, const PointSample& sample) {
    ContourSubsegmentOptions options;
    options.size_mm = sample.stats.size_mm;
    options.spared = effort.reduced;
    options.dense = effort.is_dense_in_full();
    options.conforming = effort.conforming;
    options.graded = sample.graded;
    options.to_short = effort.refinement.to_short;
    options.last_few = effort.refinement.last_few;
    return options;
}

}  // namespace

GrowingMesh::GrowingMesh(Tetrahedralization delaunay, const PreparedRun& run, PointSample& sample)
    : mesh(std::move(delaunay), *run.field, run.structures, sample.stats.size_mm,
           tolerance_at_vertices(run.effort, sample.stats.size_mm)),
      contour_vertices(vertices_of_contours(mesh, sample)),
      owner_pairs(owners_of_vertices(run.contours, contour_vertices)),
      given(given_vertices(mesh, sample)),
      subsegments(mesh, sample.protected_segments, *run.field, subsegments_of(mesh, sample),
                  subsegment_options(run.effort, sample)) {}

ContourOwners owners_of(const GrowingMesh& growing, const std::vector<Subsegment>& subsegments,
                        std::size_t point_count) {
    std::vector<std::array<std::uint32_t, 3>> ends;
    ends.reserve(subsegments.size());
    for (const Subsegment& subsegment : subsegments)
        ends.push_back({subsegment.a, subsegment.b, subsegment.structure});
    return {growing.owner_pairs, point_count, ends};
}

}  // namespace anatomesh
