#include "anatomesh/uncertainty/surface_uncertainty.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/uncertainty/evidence.h"

namespace anatomesh {

namespace {

// The errors of one structure's contour points, averaged about any point.
class ErrorsNear {
  public:
    ErrorsNear(const ContourSet& set, const LeftOut& errors, std::uint32_t structure)
        : cell_(0.25 * errors.reach_mm), reach_(errors.reach_mm), grid_(cell_, set.points.size()) {
        for (const Contour& contour : set.contours) {
            if (contour.structure != structure) continue;
            for (std::uint32_t n = contour.first_point; n < contour.first_point + contour.point_count; ++n) {
                grid_.add(set.points[n]);
                errors_.push_back(errors.points[n]);
            }
        }
    }

    LeftOutPoint at(Vec3 p, double evidence) const {
        const double soft = 0.01 * cell_ * cell_;
        // At least as far as the evidence: a segment's ends may be further than the segment.
        for (double radius = std::max(cell_, 1.5 * evidence); radius <= 2 * reach_; radius *= 2) {
            // What was found at an end counts where there is nothing else: beyond it.
            std::array<Mean, 2> means;
            grid_.for_each_within(p, radius, [&](std::uint32_t n, double square) {
                const double weight = 1 / (square + soft) - 1 / (radius * radius + soft);
                Mean& mean = means[errors_[n].is_end ? 1 : 0];
                mean.weights += weight;
                mean.error += weight * errors_[n].error_mm;
                mean.gap += weight * errors_[n].gap_mm;
            });
            for (const Mean& mean : means) {
                if (mean.weights > 0)
                    return {static_cast<float>(mean.error / mean.weights),
                            static_cast<float>(mean.gap / mean.weights)};
            }
        }
        return {};
    }

  private:
    struct Mean {
        double weights = 0, error = 0, gap = 0;
    };
    double cell_, reach_;
    PointGrid grid_;
    std::vector<LeftOutPoint> errors_;
};

std::vector<std::uint32_t> vertices_of(const std::vector<Triangle>& triangles) {
    std::vector<std::uint32_t> vertices;
    for (const Triangle& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

}  // namespace

SurfaceUncertainty surface_uncertainty(const ContourSet& set, const LeftOut& errors, const TetMesh& mesh,
                                       const RegionTable& regions, RunContext& context) {
    const std::size_t count = mesh.points.size();
    SurfaceUncertainty result{std::vector<float>(count), std::vector<float>(count),
                              std::vector<float>(count)};
    std::vector<float> surest(count, std::numeric_limits<float>::infinity());
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, count);
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        const ContourEvidence contours(set, s);
        if (contours.empty()) continue;
        const ErrorsNear nearby(set, errors, s);
        const std::vector<std::uint32_t> vertices =
            vertices_of(structure_surface(mesh, neighbors, regions, s));
        parallel_for(vertices.size(), 512, context.threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::uint32_t v = vertices[i];
                const double evidence = contours.distance(mesh.points[v], errors.reach_mm);
                const LeftOutPoint near = nearby.at(mesh.points[v], evidence);
                const double share = near.gap_mm > 0 ? std::min(1.0, evidence / near.gap_mm) : 1.0;
                const auto expected = static_cast<float>(share * near.error_mm);
                if (expected >= surest[v]) continue;
                surest[v] = expected;
                result.evidence[v] = static_cast<float>(evidence);
                result.left_out[v] = near.error_mm;
                result.expected[v] = expected;
            }
        });
    }
    return result;
}

}  // namespace anatomesh
