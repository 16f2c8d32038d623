#include "anatomesh/recover/recovered_subsegments.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/measure/contour_fidelity.h"
#include "anatomesh/mesh/shape/cell_shape.h"
#include "anatomesh/recover/insert_keeping_segments.h"
#include "anatomesh/refine/missing_segments.h"
#include "anatomesh/refine/segment_vertices.h"

namespace anatomesh {

namespace {

// Least shapes of cells (cavity.h) that are asked for, one after the other: a contour that is a hundredth of a
// millimetre from itself has no better ones than the last. [shape, 1 for good cells; 0 to 1; M 2026-11 fetal brain and 61 labels]
constexpr std::array<double, 9> least_shapes{0.99, 0.8, 0.6, 0.4, 0.2, 0.1, 0.05, 0.02, 0.01};
// From the shape of that number on only few missing subsegments are recovered.
// [index of least_shapes; 0 to 9; M 2026-11 69 sets about an axis]
constexpr std::size_t for_few = 5;
// From this shape on subsegments are split that nothing else recovers,
// [shape; 0 to 1; M 2026-11 bone of a skull above 700 HU]
constexpr double worth_splits = 0.2;
constexpr int most_splits = 5;  // each no more often. [splits; >= 0; B]
// If no larger share of the subsegments is missing, they are few.
// [1; 0 to 1; M 2026-11 bone of a skull above 700 HU]
constexpr double worth_any_shape = 2e-4;
// Forced bad cells may become more by this share of the cells inside. [1; 0 to 1; M 2026-11 random sets about an axis]
constexpr double most_more_forced = 0.03;
// Cells above the bound of clause 4 for single ones may, by this share.
// [1; 0 to 1; M 2026-11 fetal brain and crossing stacks]
constexpr double most_more_far_above = 2e-5;
// A shape is tried so often, without the subsegments that cost too much. [attempts; >= 1; B]
constexpr int most_attempts = 3;
// The least shape of cells at points beside subsegments.
// [shape; 0 to 1; M 2026-11 fetal brain and crossing stacks]
constexpr double side_shape = 0.5;
// Points go beside lost subsegments so often. [rounds; >= 0; B]
constexpr int side_rounds = 2;
// So many cells are looked at in one task. [cells at a time; >= 1; B]
constexpr std::size_t grain = 16384;

}  // namespace

RecoveredSubsegments::RecoveredSubsegments(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                           LabelledMesh& delaunay, const StructureField& field,
                                           DrawnInMesh drawn, const RecoveryOptions& options)
    : mesh_(mesh),
      neighbors_(neighbors),
      registry_(delaunay.registry()),
      field_(field),
      drawn_(std::move(drawn)),
      options_(options),
      structures_(static_cast<std::uint32_t>(drawn_.contours.structures.size())),
      memberships_(delaunay.memberships()) {}

void RecoveredSubsegments::run(std::vector<std::uint32_t>& nonmanifold, RelabelStats& relabelled,
                               RunContext& context) {
    stats_.missing_before =
        missing_subsegments(mesh_.cells, mesh_.points.size(), drawn_.subsegments, context.threads).size();
    stats_.missing_after = stats_.missing_before;
    std::vector<std::uint32_t> look;
    if (stats_.missing_before > 0) recover(look, context);
    if (!look.empty()) relabel_at(look, nonmanifold, relabelled, context);
    for (int round = 0; round < side_rounds && relabelled.lost_subsegments_after > 0; ++round) {
        look.clear();
        if (!open_sides(look, context)) break;
        relabel_at(look, nonmanifold, relabelled, context);
    }
}

// Subsegments that cost too many cells are left, and the others tried again.
void RecoveredSubsegments::recover(std::vector<std::uint32_t>& look, RunContext& context) {
    const BadCells bad_before = find_bad(context.threads);
    RecoverOptions options;
    options.threads = context.threads;
    for (std::size_t n = 0; n < least_shapes.size() && stats_.missing_after > 0; ++n) {
        const bool few = stats_.missing_after <= options_.few_missing ||
                         static_cast<double>(stats_.missing_after) <=
                             worth_any_shape * static_cast<double>(drawn_.subsegments.size());
        if (least_shapes[n] < options_.least_shape || (n >= for_few && !few)) return;
        options.least_shape = least_shapes[n];
        options.most_splits = least_shapes[n] <= worth_splits ? most_splits : 0;
        const auto before = std::make_tuple(mesh_, neighbors_, drawn_.subsegments, memberships_);
        for (int attempt = 0;; ++attempt) {
            const RecoverResult recovered =
                recover_segments(mesh_, neighbors_, drawn_.subsegments, drawn_.held, options);
            std::vector<std::uint32_t> here;
            decide(recovered.undecided, here, context);
            const BadCells bad = find_bad(context.threads);
            const bool gains = recovered.stats.missing_after < stats_.missing_after;
            if (gains && !is_too_bad(bad, bad_before)) {
                look.insert(look.end(), here.begin(), here.end());
                vertices_.insert(vertices_.end(), recovered.vertices.begin(), recovered.vertices.end());
                stats_.missing_after = recovered.stats.missing_after;
                stats_.without_vertex += recovered.stats.without_vertex;
                stats_.vertices_added += recovered.stats.vertices_added;
                stats_.vertices_dropped += recovered.stats.vertices_dropped;
                break;
            }
            const std::vector<MeshEdge> dear = too_dear(bad, bad_before, recovered);
            std::tie(mesh_, neighbors_, drawn_.subsegments, memberships_) = before;
            if (!gains && dear.empty()) break;
            if (attempt == most_attempts || dear.empty()) return;
            options.left.insert(options.left.end(), dear.begin(), dear.end());
            sort_distinct(options.left);
        }
    }
}

std::array<RecoveredSubsegments::Excess, 3> RecoveredSubsegments::excesses(const BadCells& bad,
                                                                           const BadCells& before) const {
    const auto excess_of = [&](const std::vector<std::uint32_t>& cells,
                               const std::vector<std::uint32_t>& cells_before, double most_more) {
        const double share = static_cast<double>(cells_before.size()) / static_cast<double>(before.inside);
        return Excess{&cells, static_cast<double>(cells.size()) -
                                  (share + most_more) * static_cast<double>(bad.inside)};
    };
    return {excess_of(bad.far, before.far, most_more_far_above),
            excess_of(bad.unforced, before.unforced, options_.most_more_bad),
            excess_of(bad.forced, before.forced, most_more_forced)};
}

bool RecoveredSubsegments::is_too_bad(const BadCells& bad, const BadCells& before) const {
    const std::array<Excess, 3> all = excesses(bad, before);
    return std::any_of(all.begin(), all.end(), [](const Excess& excess) { return excess.count > 0; });
}

// The subsegments to leave so that bad cells become more by no more than they may: those that cost the most
// first.
std::vector<MeshEdge> RecoveredSubsegments::too_dear(const BadCells& bad, const BadCells& before,
                                                     const RecoverResult& recovered) const {
    std::vector<MeshEdge> dear;
    for (const auto& [cells, count] : excesses(bad, before)) {
        std::map<MeshEdge, std::size_t> costs;
        for (const std::uint32_t c : *cells) {
            const auto at = std::lower_bound(recovered.undecided.begin(), recovered.undecided.end(), c);
            if (at == recovered.undecided.end() || *at != c) continue;
            ++costs[recovered.made_for[static_cast<std::size_t>(at - recovered.undecided.begin())]];
        }
        std::vector<std::pair<MeshEdge, std::size_t>> dearest(costs.begin(), costs.end());
        std::stable_sort(dearest.begin(), dearest.end(),
                         [](const auto& x, const auto& y) { return x.second > y.second; });
        double left = count;
        for (std::size_t n = 0; n < dearest.size() && left > 0; ++n) {
            dear.push_back(dearest[n].first);
            left -= static_cast<double>(dearest[n].second);
        }
    }
    return dear;
}

RecoveredSubsegments::BadCells RecoveredSubsegments::find_bad(int threads) const {
    const auto squared_ratio = [&](std::uint32_t c) {
        const Cell& v = mesh_.cells[c];
        return squared_radius_edge(mesh_.points[v[0]], mesh_.points[v[1]], mesh_.points[v[2]],
                                   mesh_.points[v[3]]);
    };
    struct Part {
        std::vector<std::uint32_t> bad;
        std::size_t inside = 0;
        double edges = 0;
    };
    std::vector<Part> parts((mesh_.cells.size() + grain - 1) / grain);
    parallel_for(mesh_.cells.size(), grain, threads, [&](std::size_t begin, std::size_t end) {
        Part& part = parts[begin / grain];
        for (auto c = static_cast<std::uint32_t>(begin); c < end; ++c) {
            if (mesh_.regions[c] == 0) continue;
            const Cell& v = mesh_.cells[c];
            ++part.inside;
            part.edges += 0.5 * (length(mesh_.points[v[1]] - mesh_.points[v[0]]) +
                                 length(mesh_.points[v[3]] - mesh_.points[v[2]]));
            if (!(squared_ratio(c) <= options_.max_radius_edge * options_.max_radius_edge))
                part.bad.push_back(c);
        }
    });
    std::vector<std::uint32_t> bad;
    BadCells found;
    double edges = 0;
    for (const Part& part : parts) {
        bad.insert(bad.end(), part.bad.begin(), part.bad.end());
        found.inside += part.inside;
        edges += part.edges;
    }
    if (bad.empty()) return found;
    ForcedCells forced(mesh_, drawn_.contours, drawn_.vertex_of);
    forced.find_constraint_limited(bad, contract::forcing_share * edges / static_cast<double>(found.inside));
    for (const std::uint32_t c : bad) {
        if (!forced.reason(c).empty()) {
            found.forced.push_back(c);
            continue;
        }
        found.unforced.push_back(c);
        if (!(squared_ratio(c) <= contract::bad_radius_edge * contract::bad_radius_edge))
            found.far.push_back(c);
    }
    return found;
}

bool RecoveredSubsegments::open_sides(std::vector<std::uint32_t>& look, RunContext& context) {
    const std::vector<SubsegmentSides> all_sides =
        subsegment_sides(mesh_.cells, mesh_.regions, registry_.table(), mesh_.points.size(),
                         drawn_.subsegments, context.threads);
    PointGrid grid(options_.size_mm, mesh_.points.size());
    for (const Vec3& p : mesh_.points) grid.add(p);
    std::vector<Vec3> points;
    std::vector<std::uint32_t> beside;
    for (std::size_t n = 0; n < all_sides.size(); ++n) {
        if (all_sides[n].inside == all_sides[n].outside) continue;
        const Subsegment& subsegment = drawn_.subsegments[n];
        find_side_points(mesh_.points, {subsegment}, {all_sides[n]}, field_, grid, {}, points, context);
        beside.resize(points.size(), subsegment.a);
        look.insert(look.end(), {subsegment.a, subsegment.b});
    }
    const std::vector<std::uint32_t> undecided = insert_keeping_segments(
        mesh_, neighbors_, points, beside, drawn_.subsegments, drawn_.held, side_shape);
    decide(undecided, look, context);
    return !undecided.empty();
}

// Gives new cells their regions; their vertices are appended to `look`.
void RecoveredSubsegments::decide(const std::vector<std::uint32_t>& undecided,
                                  std::vector<std::uint32_t>& look, RunContext& context) {
    const ChosenCells chosen{mesh_.points, mesh_.cells, undecided};
    find_memberships(chosen, field_, structures_, options_.tolerance, memberships_, registry_, context);
    cull(chosen, memberships_, field_, structures_, mesh_.regions, registry_, context);
    for (const std::uint32_t c : undecided)
        look.insert(look.end(), mesh_.cells[c].begin(), mesh_.cells[c].end());
}

void RecoveredSubsegments::relabel_at(std::vector<std::uint32_t>& look,
                                      std::vector<std::uint32_t>& nonmanifold, RelabelStats& relabelled,
                                      RunContext& context) {
    look.insert(look.end(), nonmanifold.begin(), nonmanifold.end());
    std::sort(look.begin(), look.end());
    look.erase(std::unique(look.begin(), look.end()), look.end());
    std::vector<CellNeighbors> neighbors(mesh_.cells.size());
    for (std::size_t n = 0; n < neighbors_.size(); ++n) neighbors[n / 4][n % 4] = neighbors_[n];
    std::vector<std::array<std::uint32_t, 3>> subsegments;
    for (const Subsegment& subsegment : drawn_.subsegments)
        subsegments.push_back({subsegment.a, subsegment.b, subsegment.structure});
    const VertexStars stars(mesh_.cells, mesh_.points.size(), context.threads);
    const PlanesOfStack planes = planes_of_stack(drawn_.contours, drawn_.arrangement, drawn_.vertex_of,
                                                 drawn_.subsegments, mesh_.points.size());
    const ContourOwners owners(drawn_.owners, mesh_.points.size(), subsegments);
    relabelled.add(
        relabel({mesh_.points, mesh_.cells, neighbors, stars, owners, memberships_, mesh_.regions, registry_},
                {spike_share * options_.size_mm, options_.near_mm, options_.losses_wait}, nonmanifold, look,
                context.threads, {planes.slice_of, planes.planes, &field_, structures_}));
}

}  // namespace anatomesh
