#include "anatomesh/improve/improve_dihedrals.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <numbers>
#include <queue>
#include <utility>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/quality_gate.h"
#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/improve/reroute/reroute_on_section.h"
#include "anatomesh/improve/sections/detach_facets_from_plane.h"
#include "anatomesh/improve/sections/repair_section_locally.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/smooth/flip_surface_edges.h"
#include "anatomesh/improve/surgery/recover_on_surface.h"
#include "anatomesh/improve/surgery/remove_spikes.h"
#include "anatomesh/improve/surgery/remove_spurious_handles.h"
#include "anatomesh/improve/surgery/repair_section_patch.h"
#include "anatomesh/mesh/model/prefetch.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

constexpr double radians_per_degree = std::numbers::pi / 180;
constexpr double margin_degrees = 3;  // how far above the target operations aim

constexpr double listed_degrees =
    contract::bad_dihedral_degrees;        // an angle below it is a blemish: worth ratios above the bound
constexpr int radius_edge_steps = 3;       // from the bound to the last one
constexpr double most_for_segment = 1e-5;  // a share of the cells inside, to be above the bound for its sake
constexpr std::size_t few_high = 2000;     // one cell in so many may be above it to be worked on
constexpr std::size_t worth_a_pass = 20;   // another one: one cell in so many lowered

// Cells made for the sake of a subsegment: of ten thousand subsegments none that could be had took 1,800.
constexpr std::size_t most_raised = 2000;

// Tries on a bad cell that are evaluated speculatively beforehand: its edges, facets and vertices.
constexpr int edge_tries = 6, facet_tries = 10, speculative_tries = 14;
// All: then it is relabelled to the other side, an edge collapses from either end, an edge gets a vertex
// beside it.
constexpr int collapse_tries = 12, all_tries = speculative_tries + 1 + collapse_tries + 6;
constexpr double flat_sine = 1e-3;       // of a cell that no contours excuse: 0.06 degrees
constexpr std::size_t most_flat = 1000;  // cells between contours that are looked at
// So many cells at a time, or that part of those there are: more would change each other's surroundings.
constexpr std::size_t most_speculations = 1024, speculative_part = 8, least_speculations = 64;

// A cell and its sine when it was found bad: not up to date when the cell has another sine since.
struct BadCell {
    double sine;
    std::uint32_t cell;
    friend bool operator<(const BadCell& a, const BadCell& b) {  // the worst on top of the queue
        return a.sine != b.sine ? a.sine > b.sine : a.cell > b.cell;
    }
};

// What speculation found out about a bad cell: of the tries on it those before `first` fail; that one may
// succeed.
struct EvaluatedCell {
    BadCell bad;
    int first = 0;
    Proposal proposal;  // of the first
};

class HillClimber {
  public:
    HillClimber(EditContext& edit, const DrawnSlices& drawn)
        : edit_(edit),
          constraint_limited_(drawn.constraint_limited.begin(), drawn.constraint_limited.end()),
          drawn_(drawn),
          target_(std::sin(edit.options.target_degrees * radians_per_degree)) {
        drawn_.constraint_limited = constraint_limited_;
        if (drawn.least_wrong > 0) {
            drawn_.planes = {};
            drawn_.extents = {};
            drawn_.weights = {};
            at_last_ = drawn;
            at_last_.constraint_limited = constraint_limited_;
        }
        edit.drawn = &drawn_;
        edit.goal = std::sin((edit.options.target_degrees + margin_degrees) * radians_per_degree);
    }

    void run(RunContext& context) {
        for (const auto& [a, b, structure] : drawn_.subsegments_beside) edit_.constraints.keep_edge(a, b);
        drop_ears(context.threads);
        remove_far_spikes(context.threads);
        recover_subsegments(listed_degrees, 0);
        collect(edit_.mesh.alive_cells(), context.threads);
        edit_.stats.bad_before = queue_.size();
        edit_.stats.worst_before_degrees = worst_degrees();
        optimize(context);
        flip_edges(context.threads);
        // What is left may have more room.
        edit_.options.max_deviation_mm *= edit_.options.last_deviation;
        optimize(context);
        drop_ears(context.threads);
        DetachmentStats detached = detach_facets_from_plane(
            edit_, drawn_, std::sin(listed_degrees * radians_per_degree), context.threads);
        edit_.stats.facets_detached = detached.facets_detached;
        edit_.stats.facets_left = detached.facets_left;
        edit_.rule.moves_junctions = true;
        // Those that the optimization left are bad still; others may be where facets were detached.
        LocalRepairStats locally_repaired = repair_sections(context, nullptr);
        std::vector<std::uint32_t> left = std::move(locally_repaired.changed);
        left.insert(left.end(), detached.changed.begin(), detached.changed.end());
        for (; !queue_.empty(); queue_.pop()) left.push_back(queue_.top().cell);
        collect(std::move(left), context.threads);
        // From here on few cells change: those and the bad ones are all that may be bad in the end.
        for (auto queue = queue_; !queue.empty(); queue.pop()) watched_.push_back(queue.top().cell);
        optimize_at_last(context);
        lower_ratios(context);
        repair_blemishes(context);
        // Where nothing was changed since there is nothing new.
        locally_repaired.left.insert(locally_repaired.left.end(), watched_.begin(), watched_.end());
        locally_repaired = repair_sections(context, &locally_repaired.left);
        watched_.insert(watched_.end(), locally_repaired.changed.begin(), locally_repaired.changed.end());
        // What could not be recovered at first, for no angle below the least there is.
        collect(watched_, context.threads);
        const double least = worst_degrees();
        queue_ = {};
        recover_subsegments(std::max(least, listed_degrees), most_for_segment);
        remove_small_handles(std::max(least, listed_degrees), context);
        repair_worst_sections(context);
        locally_repaired.left.insert(locally_repaired.left.end(), watched_.begin(), watched_.end());
        edit_.constraints.release_edges();  // those that could not be recovered would be in the way of cuts
        repair_patch(std::max(least, listed_degrees), locally_repaired.left, context);
        reroute(std::max(least, listed_degrees), context);
        repair_flat_cells(context);
        collect(std::move(watched_), context.threads);
        edit_.stats.bad_after = queue_.size();
        edit_.stats.worst_after_degrees = worst_degrees();
    }

  private:
    void optimize(RunContext& context) {
        for (int pass = 0; pass < edit_.options.passes && !queue_.empty() && !context.cancelled(); ++pass) {
            const std::uint64_t gained = process_queue(context.threads);
            collect(std::move(left_), context.threads);
            if (gained * 50 < queue_.size() || gained == 0) break;
        }
    }

    // With the operations that only the few cells which nothing else helps are worth; at the end angles that
    // would be listed are raised above that at the price of ratios.
    void optimize_at_last(RunContext& context) {
        thorough_ = true;
        edit_.rule.guards_sections = true;
        optimize(context);
        const double target = std::exchange(target_, std::sin(listed_degrees * radians_per_degree));
        const double most = edit_.options.max_radius_edge, last = edit_.options.last_radius_edge;
        edit_.rule.least_sine = target_;
        for (int step = 1; step <= radius_edge_steps && last > most; ++step) {
            std::vector<std::uint32_t> left;
            for (; !queue_.empty(); queue_.pop()) left.push_back(queue_.top().cell);
            edit_.rule.max_radius_edge = most + step * (last - most) / radius_edge_steps;
            collect(std::move(left), context.threads);
            optimize(context);
        }
        edit_.rule.max_radius_edge = most;
        edit_.rule.least_sine = 0;
        target_ = target;
    }

    // Whether a cell inside has a ratio above it.
    bool is_above(double most, std::uint32_t c) const {
        if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) return false;
        const Cell& v = edit_.mesh.cell(c);
        return squared_radius_edge(edit_.mesh.point(v[0]), edit_.mesh.point(v[1]), edit_.mesh.point(v[2]),
                                   edit_.mesh.point(v[3])) > most * most;
    }

    // Of the few cells above what optimize_at_last() allows, at the price of angles above those listed; then
    // of all above the bound, for no angle below the target: what comes of cells that contours force is none
    // that they do not.
    void lower_ratios(RunContext& context) {
        const double most = edit_.options.max_radius_edge, last = edit_.options.last_radius_edge,
                     listed = std::sin(listed_degrees * radians_per_degree);
        if (last > most) lower_ratios_above(last, listed, edit_.mesh.cell_count() / few_high, context);
        edit_.rule.strict_least_sine = listed;
        edit_.rule.strict_max_ratio = last;
        for (int pass = 0; pass < edit_.options.ratio_passes; ++pass) {
            const LoweredRatios lowered =
                lower_ratios_above(most, std::max(target_, listed), edit_.mesh.cell_count(), context);
            if (lowered.changes == 0 || lowered.changes * worth_a_pass < lowered.found) break;
        }
        edit_.rule.strict_least_sine = 0;
        edit_.rule.strict_max_ratio = HUGE_VAL;
    }

    struct LoweredRatios {
        std::size_t found = 0, changes = 0;
    };

    // Those of all, rising.
    template <class Is>
    std::vector<std::uint32_t> cells_that(const Is& is, int threads) const {
        return parallel_collect<std::uint32_t>(
            edit_.mesh.cell_count(), 16384, threads,
            [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& found) {
                for (std::size_t c = first; c < last; ++c) {
                    if (c + cells_ahead < last)
                        edit_.mesh.prefetch_points(static_cast<std::uint32_t>(c + cells_ahead));
                    if (is(static_cast<std::uint32_t>(c))) found.push_back(static_cast<std::uint32_t>(c));
                }
            });
    }

    // Of all cells above it, if there are no more than `limit`.
    LoweredRatios lower_ratios_above(double most, double least_sine, std::size_t limit, RunContext& context) {
        const auto is_high = [&](std::uint32_t c) { return is_above(most, c); };
        std::vector<std::uint32_t> high = cells_that(is_high, context.threads);
        LoweredRatios lowered{high.size()};
        // Many are of planes that crowd each other: there the cells in their place spoil the rest.
        if (high.size() > limit) return lowered;
        const double before = std::exchange(edit_.rule.max_radius_edge, most);
        edit_.rule.objective = Objective::radius_edge;
        edit_.rule.least_sine = least_sine;
        for (std::size_t n = 0; n < high.size() && !context.cancelled(); ++n) {
            relabels_cells_ =
                edit_.options.relabels_for_ratio || is_above(edit_.options.last_radius_edge, high[n]);
            if (!is_high(high[n]) || !better(high[n], nullptr)) continue;
            ++lowered.changes;
            watched_.insert(watched_.end(), edit_.changed.begin(), edit_.changed.end());
            std::copy_if(edit_.changed.begin(), edit_.changed.end(), std::back_inserter(high), is_high);
        }
        edit_.rule.objective = Objective::least_sine;
        edit_.rule.least_sine = 0;
        edit_.rule.max_radius_edge = before;
        relabels_cells_ = true;
        return lowered;
    }

    // Whether it is a cell that clause 4 allows only where contours force it, and none that they limit.
    bool is_blemish(std::uint32_t c) const {
        if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) return false;
        const Cell& v = edit_.mesh.cell(c);
        const CellMeasures m = measure_cell(edit_.mesh.point(v[0]), edit_.mesh.point(v[1]),
                                            edit_.mesh.point(v[2]), edit_.mesh.point(v[3]));
        const double last = edit_.options.last_radius_edge;
        return (m.squared_ratio > last * last ||
                m.least_sine() < std::sin(listed_degrees * radians_per_degree)) &&
               !drawn_.are_constraint_limited(v);
    }

    // Single cells that are left ill-shaped beside those that contours force to be, at the price of these: as
    // long as they keep within the bounds of those forced.
    void repair_blemishes(RunContext& context) {
        if (drawn_.constraint_limited.empty()) return;
        std::vector<std::uint32_t> cells =
            cells_that([&](std::uint32_t c) { return is_blemish(c); }, context.threads);
        const double most = std::exchange(edit_.rule.max_radius_edge, edit_.options.last_radius_edge);
        edit_.rule.least_sine = std::sin(listed_degrees * radians_per_degree);
        edit_.rule.spares_limited = true;
        const std::size_t limit = 4 * cells.size();
        for (std::size_t n = 0; n < cells.size() && n < limit && !context.cancelled(); ++n) {
            if (!is_blemish(cells[n])) continue;
            edit_.rule.objective = is_above(edit_.options.last_radius_edge, cells[n]) ? Objective::radius_edge
                                                                                      : Objective::least_sine;
            const DihedralStats stats = edit_.stats;
            edit_.mesh.begin_attempt();
            const bool done = better(cells[n], nullptr) && keep_constraint_limited_bounds(edit_.changed);
            edit_.mesh.end_attempt(done);
            if (!done) {
                edit_.stats = stats;
                continue;
            }
            watched_.insert(watched_.end(), edit_.changed.begin(), edit_.changed.end());
            std::copy_if(edit_.changed.begin(), edit_.changed.end(), std::back_inserter(cells),
                         [&](std::uint32_t c) { return is_blemish(c); });
        }
        edit_.rule.objective = Objective::least_sine;
        edit_.rule.least_sine = 0;
        edit_.rule.spares_limited = false;
        edit_.rule.max_radius_edge = most;
    }

    // Whether no contours excuse a cell so flat.
    bool is_flat(std::uint32_t c) const {
        return edit_.mesh.alive(c) && edit_.mesh.region(c) != 0 && edit_.sine(c) < flat_sine;
    }

    // Cells that are left flat between contours that limit them - vertices of two segments that meet, split
    // alike, lie in one plane -, where others do that are as good as cells there must be.
    void repair_flat_cells(const RunContext& context) {
        if (drawn_.constraint_limited.empty()) return;
        const std::vector<std::uint32_t> flat =
            cells_that([&](std::uint32_t c) { return is_flat(c); }, context.threads);
        const double most = std::exchange(edit_.rule.max_radius_edge, most_limited_ratio);
        QualityGate gate(edit_, drawn_, std::sin(listed_degrees * radians_per_degree));
        thorough_ = edit_.rule.moves_junctions = true;
        edit_.rule.guards_sections = true;
        for (std::size_t n = 0; n < std::min(flat.size(), most_flat) && !context.cancelled(); ++n)
            repair_flat_cell(flat[n], gate);
        thorough_ = edit_.rule.moves_junctions = false;
        edit_.rule.guards_sections = false;
        edit_.rule.max_radius_edge = most;
    }

    // With the first operation that makes good cells alone.
    void repair_flat_cell(std::uint32_t cell, QualityGate& gate) {
        for (int n = 0; n < all_tries && is_flat(cell); ++n) {
            if (n == speculative_tries && !edit_.options.relabels_for_ratio) continue;  // relabel_cell()
            const DihedralStats stats = edit_.stats;
            edit_.mesh.begin_attempt();
            const auto is_good = [&](std::uint32_t c) { return gate.is_good(c) && gate.is_near(c); };
            const bool done =
                attempt_any(cell, n) && std::all_of(edit_.changed.begin(), edit_.changed.end(), is_good);
            edit_.mesh.end_attempt(done);
            if (done) {
                watched_.insert(watched_.end(), edit_.changed.begin(), edit_.changed.end());
            } else {
                edit_.stats = stats;
            }
        }
    }

    // Whether those of the cells that contours limit are within the bounds of forced ones.
    bool keep_constraint_limited_bounds(const std::vector<std::uint32_t>& cells) const {
        return std::all_of(cells.begin(), cells.end(), [&](std::uint32_t c) {
            if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) return true;
            if (!drawn_.are_constraint_limited(edit_.mesh.cell(c))) return true;
            return edit_.sine(c) >= least_limited_sine && !is_above(most_limited_ratio, c);
        });
    }

    // Subsegments that lie beside their structure's surface; those found at first are kept, so
    // that those which could not be recovered may be when the cells are better.
    void recover_subsegments(double least_degrees, double most_more_above_bound) {
        std::vector<std::uint32_t> watched = std::exchange(watched_, {});
        const SurfaceRecoveryStats recovered = recover_on_surface(
            edit_, drawn_, std::sin(least_degrees * radians_per_degree), most_more_above_bound,
            [&](std::vector<std::uint32_t> cells) { return optimize_cells(std::move(cells)); });
        edit_.stats.subsegments_found = std::max(edit_.stats.subsegments_found, recovered.found);
        edit_.stats.subsegments_recovered += recovered.recovered;
        watched_ = std::move(watched);
        watched_.insert(watched_.end(), recovered.changed.begin(), recovered.changed.end());
    }

    // Cuts of which more is wrong than may be, where cuts are not looked at before.
    void repair_worst_sections(const RunContext& context) {
        if (at_last_.planes.empty()) return;
        SectionAreas areas(edit_, at_last_);
        areas.sum_cuts(edit_.mesh.alive_cells(), context.threads);
        std::vector<double> weights(at_last_.weights.begin(), at_last_.weights.end());
        for (std::size_t cut = 0; cut < weights.size(); ++cut) {
            if (areas.sums()[cut] <= at_last_.least_wrong) weights[cut] = 0;
        }
        const std::span<const double> before = std::exchange(at_last_.weights, weights);
        const LocalRepairStats locally_repaired =
            repair_section_locally(edit_, at_last_, std::sin(listed_degrees * radians_per_degree), context);
        edit_.stats.cuts_found += locally_repaired.places_found;
        edit_.stats.sections_repaired += locally_repaired.vertices_moved + locally_repaired.cells_relabelled +
                                         locally_repaired.edges_flipped + locally_repaired.edges_collapsed +
                                         locally_repaired.vertices_inserted;
        watched_.insert(watched_.end(), locally_repaired.changed.begin(), locally_repaired.changed.end());
        at_last_.weights = before;
    }

    // Those of the mesh's own making.
    void remove_small_handles(double least_degrees, const RunContext& context) {
        if (!(edit_.options.handle_mm > 0)) return;
        std::vector<std::uint32_t> watched = std::exchange(watched_, {});
        const HandleRemovalStats removed = remove_spurious_handles(
            edit_, at_last_.planes.empty() ? drawn_ : at_last_, edit_.options.handle_mm,
            std::sin(least_degrees * radians_per_degree),
            [&](std::vector<std::uint32_t> cells) { return optimize_cells(std::move(cells)); }, context);
        edit_.stats.handles_found += removed.found;
        edit_.stats.handles_removed += removed.removed;
        watched_ = std::move(watched);
        watched_.insert(watched_.end(), removed.changed.begin(), removed.changed.end());
    }

    // What cuts that are still wrong have too much or too little: at these cells, where repair_sections()
    // looked at them.
    void repair_patch(double least_degrees, const std::vector<std::uint32_t>& look,
                      const RunContext& context) {
        std::vector<std::uint32_t> watched = std::exchange(watched_, {});
        const PatchRepairStats repaired = repair_section_patch(
            edit_, at_last_.planes.empty() ? drawn_ : at_last_, std::sin(least_degrees * radians_per_degree),
            [&](std::vector<std::uint32_t> cells) { return optimize_cells(std::move(cells)); }, context,
            at_last_.planes.empty() ? &look : nullptr);
        edit_.stats.cuts_found += repaired.patches_found;
        edit_.stats.sections_repaired += repaired.patches_repaired;
        edit_.stats.spurious_components_removed += repaired.spurious_components_removed;
        watched_ = std::move(watched);
        watched_.insert(watched_.end(), repaired.changed.begin(), repaired.changed.end());
    }

    // Contours whose segments no edges of the surface run along after all.
    void reroute(double least_degrees, const RunContext& context) {
        std::vector<std::uint32_t> watched = std::exchange(watched_, {});
        RerouteStats stats = reroute_on_section(
            edit_, drawn_, constraint_limited_, std::sin(least_degrees * radians_per_degree),
            std::sin(listed_degrees * radians_per_degree),
            [&](std::vector<std::uint32_t> cells) { return optimize_cells(std::move(cells)); }, context);
        edit_.stats.segments_missed = stats.missed;
        edit_.stats.routed = std::move(stats.routed);
        watched_ = std::move(watched);
        watched_.insert(watched_.end(), stats.changed.begin(), stats.changed.end());
    }

    // The shapes of these cells and of those that come of it, with the operations of the end; last their
    // ratios, for no angle that is listed. Ends where that makes ever more cells: what can be raised is with
    // some hundred. Returns what was made.
    std::vector<std::uint32_t> optimize_cells(std::vector<std::uint32_t> cells) {
        thorough_ = edit_.rule.moves_junctions = is_raising_ = true;
        edit_.rule.guards_sections = true;
        const double target = target_, most = edit_.options.max_radius_edge,
                     listed = std::sin(listed_degrees * radians_per_degree);
        std::vector<std::uint32_t> changed = optimize_angles(cells);
        target_ = edit_.rule.least_sine = listed;
        edit_.rule.max_radius_edge = edit_.options.last_radius_edge;
        cells.insert(cells.end(), changed.begin(), changed.end());
        const std::vector<std::uint32_t> more = optimize_angles(cells);
        changed.insert(changed.end(), more.begin(), more.end());
        cells.insert(cells.end(), more.begin(), more.end());
        target_ = target;
        edit_.rule.max_radius_edge = most;
        lower_ratios_of(cells, most, changed);
        edit_.rule.least_sine = 0;
        thorough_ = edit_.rule.moves_junctions = is_raising_ = false;
        edit_.rule.guards_sections = false;
        return changed;
    }

    std::vector<std::uint32_t> optimize_angles(std::vector<std::uint32_t> cells) {
        std::vector<std::uint32_t> changed;
        for (int pass = 0; pass < edit_.options.passes; ++pass) {
            collect(cells, 1);
            if (queue_.empty()) break;
            const std::uint64_t gained = process_queue(1);
            cells.insert(cells.end(), watched_.begin(), watched_.end());
            changed.insert(changed.end(), watched_.begin(), watched_.end());
            watched_.clear();
            if (gained == 0 || changed.size() > most_raised) break;
        }
        queue_ = {};
        left_.clear();
        return changed;
    }

    // Of those of the cells above `most`, and of cells that come of it, which `changed` gets.
    void lower_ratios_of(std::vector<std::uint32_t> cells, double most, std::vector<std::uint32_t>& changed) {
        edit_.rule.objective = Objective::radius_edge;
        sort_distinct(cells);
        for (std::size_t n = 0; n < cells.size() && changed.size() <= most_raised; ++n) {
            if (!is_above(most, cells[n]) || drawn_.are_constraint_limited(edit_.mesh.cell(cells[n])) ||
                !better(cells[n], nullptr))
                continue;
            changed.insert(changed.end(), edit_.changed.begin(), edit_.changed.end());
            cells.insert(cells.end(), edit_.changed.begin(), edit_.changed.end());
        }
        edit_.rule.objective = Objective::least_sine;
    }

    LocalRepairStats repair_sections(const RunContext& context, const std::vector<std::uint32_t>* look) {
        LocalRepairStats locally_repaired = repair_section_locally(
            edit_, drawn_, std::sin(listed_degrees * radians_per_degree), context, look);
        edit_.stats.cuts_found += locally_repaired.places_found;
        edit_.stats.sections_repaired += locally_repaired.vertices_moved + locally_repaired.cells_relabelled +
                                         locally_repaired.edges_flipped + locally_repaired.edges_collapsed +
                                         locally_repaired.vertices_inserted;
        return locally_repaired;
    }

    // Those of surfaces, for smaller angles between facets; cells that are bad now are queued.
    void flip_edges(int threads) {
        std::vector<std::uint32_t> changed;
        FlipOptions options;
        options.good_sine = target_;
        options.least_gain_degrees = edit_.options.flip_gain_degrees;
        flip_surface_edges(edit_, options, threads, changed);
        sort_distinct(changed, edit_.mesh.cell_count());
        for (const BadCell& bad : bad_of(changed, threads)) queue_.push(bad);
    }

    // Among all cells; then among those beside what was dropped, as long as there is something.
    void drop_ears(int threads) {
        std::vector<std::uint32_t> cells = parallel_collect<std::uint32_t>(
            edit_.mesh.cell_count(), 16384, threads,
            [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& ears) {
                for (std::size_t c = first; c < last; ++c) {
                    const auto cell = static_cast<std::uint32_t>(c);
                    if (edit_.mesh.alive(cell) && is_ear(edit_, cell)) ears.push_back(cell);
                }
            });
        while (!cells.empty()) {
            std::vector<std::uint32_t> next;
            for (const std::uint32_t c : cells) {
                if (!edit_.mesh.alive(c) || !drop_ear(edit_, c, target_)) continue;
                next.push_back(c);
                for (int i = 0; i < 4; ++i) next.push_back(edit_.mesh.neighbor(c, i));
            }
            sort_distinct(next);
            cells = std::move(next);
        }
    }

    void remove_far_spikes(int threads) {
        const double least_sine = std::sin(listed_degrees * radians_per_degree);
        edit_.stats.spikes_removed +=
            remove_spikes(edit_, edit_.options.spike_mm, least_sine, threads).removed;
    }

    // Queues those of the cells that are bad.
    void collect(std::vector<std::uint32_t> cells, int threads) {
        sort_distinct(cells);
        queue_ = std::priority_queue<BadCell>({}, bad_of(cells, threads));
    }

    // What contours force to be ill-shaped is not worked on for a subsegment's sake alone.
    double target_of(std::uint32_t c) const {
        return is_raising_ && drawn_.are_constraint_limited(edit_.mesh.cell(c))
                   ? std::min(target_, least_limited_sine)
                   : target_;
    }

    std::vector<BadCell> bad_of(const std::vector<std::uint32_t>& cells, int threads) const {
        return parallel_collect<BadCell>(cells.size(), 16384, threads,
                                         [&](std::size_t first, std::size_t last, std::vector<BadCell>& bad) {
                                             for (std::size_t n = first; n < last; ++n) {
                                                 const std::uint32_t c = cells[n];
                                                 if (n + cells_ahead < last)
                                                     edit_.mesh.prefetch_points(cells[n + cells_ahead]);
                                                 if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0)
                                                     continue;
                                                 if (const double sine = edit_.sine(c); sine < target_of(c))
                                                     bad.push_back({sine, c});
                                             }
                                         });
    }

    // Tries the worst in the queue beforehand while there are several threads to do so: what happens to the
    // mesh is the same without.
    void speculate(int threads) {
        const std::size_t part = std::max(queue_.size() / speculative_part, least_speculations);
        speculations_.resize(std::min({part, most_speculations, queue_.size()}));
        next_speculation_ = 0;
        for (EvaluatedCell& speculation : speculations_) {
            speculation = {queue_.top(), 0, {}};
            queue_.pop();
        }
        ++speculation_round_;
        changed_in_.resize(edit_.mesh.point_count(), 0);
        parallel_for(speculations_.size(), 16, threads, [&](std::size_t first, std::size_t last) {
            EditContext local_edit = edit_;
            local_edit.speculation.active = local_edit.speculation.local_only = true;
            for (std::size_t n = first; n < last; ++n) {
                EvaluatedCell& speculation = speculations_[n];
                if (!is_bad(speculation.bad)) continue;
                local_edit.speculation.proposal = {};
                while (speculation.first < speculative_tries &&
                       !attempt(local_edit, speculation.bad.cell, speculation.first)) {
                    ++speculation.first;
                    local_edit.speculation.proposal = {};
                }
                speculation.proposal = std::move(local_edit.speculation.proposal);
            }
        });
    }

    // Whether a cell with a vertex of this cell has changed since the speculation.
    bool touched(std::uint32_t cell) const {
        const Cell& c = edit_.mesh.cell(cell);
        return std::any_of(c.begin(), c.end(), [&](std::uint32_t v) {
            return v >= changed_in_.size() || changed_in_[v] == speculation_round_;
        });
    }

    void touch(const Cell& cell) {
        for (const std::uint32_t v : cell) {
            if (v < changed_in_.size()) changed_in_[v] = speculation_round_;
        }
    }

    double worst_degrees() const {
        return queue_.empty() ? edit_.options.target_degrees
                              : std::asin(std::max(0.0, queue_.top().sine)) / radians_per_degree;
    }

    bool is_bad(const BadCell& bad) const {
        return edit_.mesh.alive(bad.cell) && edit_.mesh.region(bad.cell) != 0 &&
               edit_.sine(bad.cell) == bad.sine;
    }

    // The worst cell of all that wait, and what speculation found out about it.
    EvaluatedCell take_worst(int threads) {
        if (next_speculation_ == speculations_.size() && threads > 1) speculate(threads);
        if (next_speculation_ < speculations_.size() &&
            (queue_.empty() || queue_.top() < speculations_[next_speculation_].bad))
            return std::move(speculations_[next_speculation_++]);
        const BadCell bad = queue_.top();
        queue_.pop();
        return {bad, 0, {}};
    }

    // Works through the queue; cells that nothing helps come to left_.
    std::uint64_t process_queue(int threads) {
        std::uint64_t gained = 0;
        left_.clear();
        while ((!queue_.empty() || next_speculation_ < speculations_.size()) && !has_raised_enough()) {
            const EvaluatedCell worst = take_worst(threads);
            const BadCell& bad = worst.bad;
            if (!queue_.empty()) edit_.mesh.prefetch_round(queue_.top().cell);
            if (!is_bad(bad)) continue;
            ++edit_.stats.tries;
            const Cell before = edit_.mesh.cell(bad.cell);
            if (!better(bad.cell, touched(bad.cell) ? nullptr : &worst)) {
                left_.push_back(bad.cell);
                continue;
            }
            ++gained;
            touch(before);
            if (thorough_) watched_.insert(watched_.end(), edit_.changed.begin(), edit_.changed.end());
            for (const std::uint32_t c : edit_.changed) {
                touch(edit_.mesh.cell(c));
                if (edit_.mesh.region(c) == 0) continue;
                if (const double sine = edit_.sine(c); sine < target_of(c)) queue_.push({sine, c});
            }
        }
        return gained;
    }

    bool has_raised_enough() const { return is_raising_ && watched_.size() > most_raised; }

    static bool attempt(EditContext& edit, std::uint32_t cell, int n) {
        if (n < edge_tries) return remove_edge(edit, cell, n);
        if (n < facet_tries) return remove_facet(edit, cell, n - edge_tries);
        return move_vertex(edit, edit.mesh.cell(cell)[static_cast<std::size_t>(n - facet_tries)]);
    }

    // All but those that are only for the last cells, in the order of their price.
    bool attempt_any(std::uint32_t cell, int n) {
        if (n < speculative_tries) return attempt(edit_, cell, n);
        if (n == speculative_tries) return relabel_cell(edit_, cell);
        n -= speculative_tries + 1;
        if (n < collapse_tries) return collapse_edge(edit_, cell, n / 2, n % 2 == 0);
        return insert_vertex(edit_, cell, n - collapse_tries);
    }

    // The operations in the order of their price; `speculation` tells of them, if nothing has changed there.
    bool better(std::uint32_t cell, const EvaluatedCell* speculation) {
        int first = speculation ? speculation->first : 0;
        if (speculation && speculation->proposal.counter) {
            if (edit_.carry_out(speculation->proposal)) return true;
            ++first;
        }
        for (int n = first; n < speculative_tries; ++n) {
            if (attempt(edit_, cell, n)) return true;
        }
        for (int n = relabels_cells_ ? speculative_tries : speculative_tries + 1; n < all_tries; ++n) {
            if (attempt_any(cell, n)) return true;
        }
        return thorough_ && better_at_last(cell);
    }

    // What only the few cells that nothing else helps are worth.
    bool better_at_last(std::uint32_t cell) {
        for (int e = 0; e < 6; ++e) {
            if (split_edge(edit_, cell, e)) return true;
        }
        for (int i = 0; i < 4; ++i) {
            if (split_facet(edit_, cell, i)) return true;
        }
        return split_cell(edit_, cell) || insert_beside(edit_, cell);
    }

    EditContext& edit_;
    // Those of drawn_, from which contours that are re-routed take some.
    std::vector<std::uint8_t> constraint_limited_;
    DrawnSlices drawn_;
    DrawnSlices at_last_;  // if any: of cuts that are looked at then alone
    double target_;
    bool thorough_ = false;       // the last optimization
    bool is_raising_ = false;     // for a subsegment
    bool relabels_cells_ = true;  // to the other side of an interface
    std::priority_queue<BadCell> queue_;
    std::vector<std::uint32_t> left_;
    std::vector<std::uint32_t> watched_;       // what may be bad in the end
    std::vector<EvaluatedCell> speculations_;  // that wait beside the queue, the worst first
    std::size_t next_speculation_ = 0;         // those before it do not wait any more
    std::uint32_t speculation_round_ = 0;      // number of the last one
    // By vertex: after which round of speculation a cell at it changed last.
    std::vector<std::uint32_t> changed_in_;
};

}  // namespace

DihedralStats improve_dihedrals(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                std::vector<std::uint8_t>& fixed, std::span<const VertexPair> fixed_edges,
                                const StructureField& field, std::uint32_t structures,
                                const DrawnSlices& drawn, const DihedralOptions& options,
                                RunContext& context) {
    assert(fixed.size() == mesh.points.size());
    assert(std::is_sorted(fixed_edges.begin(), fixed_edges.end()));
    EditMesh edited(std::move(mesh), neighbors);
    EditContext edit(edited, fixed, fixed_edges, field, structures, options);
    edit.table = drawn.table;
    HillClimber(edit, drawn).run(context);
    edit.stats.cells_made = edited.cells_made();
    mesh = std::move(edited).take(neighbors, context.threads);
    return edit.stats;
}

}  // namespace anatomesh
