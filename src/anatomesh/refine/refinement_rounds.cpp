#include "anatomesh/refine/refinement_rounds.h"

#include <algorithm>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/model/prefetch.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

// An edge across a surface with an end on another one counts from this length on.
// [sizes; >= 0; M 2026-11 22 random label maps]
constexpr double shortest_spike = 0.4;
// Points go where edges cross an interface so often. [rounds; >= 1; B]
constexpr int crossing_rounds = 3;
// Points go where facets deviate from the interface so often. [rounds; >= 1; B]
constexpr int deviation_rounds = 5;
// Points go into cells of bad shape so often. [rounds; >= 1; B]
constexpr int refinement_rounds = 12;
// So many of these keep out of the balls of contour segments, [rounds; >= 0; M 2026-11, set not recorded]
constexpr int protected_rounds = 4;
// of this share of the balls. [radii; 0 to 1; M 2026-11, set not recorded]
constexpr double protected_at_first = 0.5;
// Tiny segments need a round for each doubling of the size, [rounds; >= 1; B]
constexpr int small_mesh_rounds = 60;
// in meshes of fewer points than this. [points; >= 0; B]
constexpr std::size_t small_mesh = 20000;
// For the sake of the mean ratio the bound is lowered in steps of this share, [1; 0 to 0.2; M 2026-11 thigh and breast]
constexpr double bound_step = 0.05;
// so often, [steps; 0 to 10; M 2026-11 thigh and breast]
constexpr int bound_steps = 5;
// or so often for a mean below 1, [steps; 0 to 10; M 2026-11 models of few thick slices]
constexpr int bound_steps_below_1 = 8;
constexpr int even_rounds = 4;     // with each of these bounds. [rounds; >= 1; B]
constexpr int last_rounds = 1;     // After the last segments. [rounds; >= 1; B]
constexpr int changed_rounds = 4;  // Where something changes later on. [rounds; >= 1; B]
// Where freehand planes lie closer than the vertices along them, points at crossings keep this distance from others:
// contours show the surface without more points. [edges; 0 to 1; M 2026-11 dense freehand planes]
constexpr double crowded_crossing_spacing = 0.05;
// At reduced effort points go where facets deviate so often. [rounds; >= 1; B]
constexpr int dense_deviation_rounds = 2;
// Points go beside wrong cross-sections so often in one turn. [rounds; >= 1; B]
constexpr int section_rounds = 6;
// Rounds for cross-sections take turns with subsegments and shapes so often; five turns were no better.
// [turns; >= 1; M 2026-11 69 sets about an axis]
constexpr int section_times = 3;
// Sections keep this distance from where slices contradict each other: vertices there made fins and handles.
// [sizes; >= 0; M 2026-11 five sets of contradicting slices]
constexpr double contradicted_clearance = 0.25;

// Radius-edge ratio of the cells inside in the mean, each at most the bound. Pieces of a fixed size: the same
// at any number of threads.
double mean_ratio(const LabelledMesh& mesh, double bound, int threads) {
    struct Sum {
        double ratios = 0, cells = 0;
    };
    // So many cells are summed in one task; sums go by it, so it is the same for any number of threads.
    // [cells at a time; >= 1; B]
    constexpr std::size_t grain = 16384;
    const std::vector<Cell>& cells = mesh.cells().cells;
    std::vector<Sum> sums(cells.size() / grain + 1);
    parallel_for(cells.size(), grain, threads, [&](std::size_t first, std::size_t last) {
        Sum& sum = sums[first / grain];
        for (std::size_t c = first; c < last; ++c) {
            if (c + cells_ahead < last) prefetch_points(mesh.points(), cells[c + cells_ahead]);
            if (mesh.regions()[c] == 0) continue;
            const auto at = [&](std::size_t i) { return mesh.points()[cells[c][i]]; };
            sum.ratios += std::min(bound, radius_edge_ratio(at(0), at(1), at(2), at(3)));
            sum.cells += 1;
        }
    });
    Sum total;
    for (const Sum& sum : sums) total = {total.ratios + sum.ratios, total.cells + sum.cells};
    return total.cells > 0 ? total.ratios / total.cells : 0;
}

}  // namespace

RefinementRounds::RefinementRounds(LabelledMesh& mesh, ContourSubsegments& subsegments,
                                   const ProtectedSegments& protected_segments,
                                   std::span<const std::uint8_t> given, const RefinementOptions& options)
    : mesh_(mesh),
      subsegments_(subsegments),
      protected_segments_(protected_segments),
      given_(given),
      options_(options) {}

Status RefinementRounds::run(RunContext& context) {
    CrossingOptions crossing;
    crossing.shortest_mm = shortest_spike * options_.size_mm;
    ANATOMESH_CHECK_STATUS(meet_crossings(crossing, context));
    ANATOMESH_CHECK_STATUS(meet_deviations(context));
    ANATOMESH_CHECK_STATUS(subsegments_.recover(500, context));
    ANATOMESH_CHECK_STATUS(improve_shapes(context));
    // Edges that came to cross an interface since the first rounds would end as spikes.
    if (!options_.conforming) crossing.protected_share = 0.5;
    ANATOMESH_CHECK_STATUS(meet_crossings(crossing, context));
    // Where contours crowd each other, what is left is met beside them as well: a surface without a vertex
    // there has a pit.
    if (options_.spared) {
        crossing.protected_share = 0;
        crossing.min_spacing = crowded_crossing_spacing;
        ANATOMESH_CHECK_STATUS(meet_crossings(crossing, context));
    }
    // Subsegments and shapes may spoil cross-sections again.
    for (int time = 0; time < section_times; ++time) {
        ANATOMESH_TRY(const bool met, meet_sections(crossing, context));
        if (time > 0 && !met) break;
        ANATOMESH_CHECK_STATUS(subsegments_.finish(context));
        ANATOMESH_CHECK_STATUS(mend_shapes(shapes_, true, context));
    }
    if (!options_.spared) return Nothing{};
    ANATOMESH_CHECK_STATUS(meet_crossings(crossing, context));
    return subsegments_.finish(context);
}

// Points where edges cross an interface; contour segments that keep them off are split instead.
Status RefinementRounds::meet_crossings(const CrossingOptions& options, RunContext& context) {
    for (int round = 0; round < crossing_rounds; ++round) {
        std::vector<Vec3> found;
        mesh_.look_again(crossings_);
        const CrossingStats stats =
            find_crossing_points(mesh_.view(), occupied(), options, crossings_.cells, found, context);
        if (found.empty() && (options.protected_share == 1 || stats.balls.empty())) break;
        stats_.crossing_points += found.size();
        ANATOMESH_CHECK_STATUS(subsegments_.grow(
            found, options.protected_share == 1 ? std::vector<std::uint32_t>{} : stats.balls, context));
    }
    return Nothing{};
}

Status RefinementRounds::meet_deviations(RunContext& context) {
    DeviationOptions options;
    options.max_deviation_mm = options_.max_deviation_mm;
    if (options_.conforming) options.protected_share = 1;
    CellSearch search;
    for (int round = 0; round < (options_.spared ? dense_deviation_rounds : deviation_rounds); ++round) {
        std::vector<Vec3> found;
        mesh_.look_again(search);
        find_deviation_points(mesh_.view(), occupied(), options, search.cells, found, context);
        if (not_worth_a_round(found.size(), 500)) break;
        stats_.deviation_points += found.size();
        ANATOMESH_CHECK_STATUS(subsegments_.grow(found, {}, context));
    }
    return Nothing{};
}

// Vertices beside the planes of slices where cross-sections are wrong, and where edges to these cross an interface.
Result<bool> RefinementRounds::meet_sections(const CrossingOptions& options, RunContext& context) {
    if (options_.slices.planes.empty()) return false;
    const std::uint64_t before = stats_.section_points;
    SectionPointOptions section;
    section.clearance_mm = contradicted_clearance * options_.size_mm;
    for (int round = 0; round < section_rounds; ++round) {
        std::vector<Vec3> found;
        mesh_.look_again(sections_);
        find_section_points(mesh_.view(), options_.slices, occupied(), section, sections_.cells, found,
                            context);
        if (found.empty()) break;
        stats_.section_points += found.size();
        ANATOMESH_CHECK_STATUS(subsegments_.grow(found, {}, context));
        ANATOMESH_CHECK_STATUS(meet_crossings(options, context));
    }
    return stats_.section_points > before;
}

Status RefinementRounds::improve_shapes(RunContext& context) {
    const SplitLimits limits = options_.conforming ? SplitLimits::beside_short() : SplitLimits::scaled(1);
    for (int round = 0; round < rounds_in_small_meshes(refinement_rounds); ++round) {
        // Where contours meet at small angles, segments and shape cannot both have their way: shape has the
        // last word, but where segments were split for each other's sake.
        const double share = options_.conforming || options_.graded ? 1
                             : round < protected_rounds             ? protected_at_first
                                                                    : 0;
        std::vector<Vec3> found;
        const RefineStats stats = find_shape_points(options_.max_radius_edge, share, shapes_, found, context);
        if (round == 0) stats_.radius_edge_mean_before = stats.radius_edge_mean;
        stats_.circumcenters += stats.circumcenters;
        stats_.surface_points += stats.surface_points;
        const std::size_t count = found.size() + stats.balls.size();
        if (count == 0 || (round > 2 && not_worth_a_round(count, 800))) break;
        const std::size_t before = mesh_.points().size();
        ANATOMESH_CHECK_STATUS(subsegments_.grow(found, stats.balls, context, limits));
        // Balls that may not be split ask for it again and again.
        if (options_.conforming && not_worth_a_round(mesh_.points().size() - before, 800)) break;
    }
    return options_.spared ? Nothing{} : even_shapes(context);
}

// Where contour vertices lie many times closer than the slices, cells grow from their spacing to the size
// over all the way between, as fast as the bound lets them: most of them end near it. All of this out of the
// balls of segments.
Status RefinementRounds::even_shapes(RunContext& context) {
    const double first = options_.max_radius_edge;
    const auto mean = [&] { return mean_ratio(mesh_, first, context.threads); };
    const int steps = options_.target_mean_ratio < 1 ? bound_steps_below_1 : bound_steps;
    for (int step = 1; step <= steps; ++step) {
        const double bound = (1 - step * bound_step) * first;
        CellSearch search;
        for (int round = 0; round < even_rounds; ++round) {
            if (mean() <= options_.target_mean_ratio) return Nothing{};
            std::vector<Vec3> found;
            const RefineStats stats = find_shape_points(bound, 1, search, found, context);
            if (not_worth_a_round(found.size(), 800)) break;
            stats_.circumcenters += stats.circumcenters;
            stats_.surface_points += stats.surface_points;
            ANATOMESH_CHECK_STATUS(subsegments_.grow(found, {}, context));
        }
    }
    return Nothing{};
}

Status RefinementRounds::refine_changed(CellSearch search, RunContext& context) {
    return mend_shapes(search, false, context);
}

// What inserting and splitting for the subsegments' sake spoiled, out of the balls of the segments. With
// `finishing` the subsegments are finished after each round.
Status RefinementRounds::mend_shapes(CellSearch& search, bool finishing, RunContext& context) {
    for (int round = 0; round < (finishing ? rounds_in_small_meshes(last_rounds) : changed_rounds); ++round) {
        std::vector<Vec3> found;
        RefineStats stats = find_shape_points(options_.max_radius_edge, 1, search, found, context);
        if (!subsegments_.are_short()) stats.balls.clear();
        if (found.empty() && stats.balls.empty()) break;
        stats_.circumcenters += stats.circumcenters;
        stats_.surface_points += stats.surface_points;
        const std::size_t before = mesh_.points().size();
        ANATOMESH_CHECK_STATUS(subsegments_.grow(found, stats.balls, context, SplitLimits::beside_short()));
        if (finishing) {
            ANATOMESH_CHECK_STATUS(subsegments_.finish(context));
        }
        if (mesh_.points().size() == before) break;
    }
    return Nothing{};
}

RefineStats RefinementRounds::find_shape_points(double bound, double protected_share, CellSearch& search,
                                                std::vector<Vec3>& found, RunContext& context) const {
    RefineOptions options;
    options.max_radius_edge = bound;
    options.max_reach_mm = 3 * options_.size_mm;
    options.given = given_;
    options.crowded_mm = options_.crowded_mm;
    options.protected_share = protected_share;
    mesh_.look_again(search);
    return find_refinement_points(mesh_.view(), occupied(), options, search.cells, found, context);
}

int RefinementRounds::rounds_in_small_meshes(int otherwise) const {
    return mesh_.points().size() < small_mesh ? small_mesh_rounds : otherwise;
}

// The last few points.
bool RefinementRounds::not_worth_a_round(std::size_t count, std::size_t share) const {
    return count * share < mesh_.points().size();
}

}  // namespace anatomesh
