#include "anatomesh/reconcile/reconcile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/model/message_text.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/contour/walls/share_lines.h"
#include "anatomesh/contour/walls/slivers.h"
#include "anatomesh/reconcile/compare/contradictions.h"
#include "anatomesh/reconcile/compare/disagreement.h"
#include "anatomesh/reconcile/compare/isolated_slices.h"
#include "anatomesh/reconcile/compare/reconcile_warnings.h"
#include "anatomesh/reconcile/move/align_slices.h"
#include "anatomesh/reconcile/move/common_lines.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/reconcile/move/drawn_places.h"
#include "anatomesh/reconcile/move/lay_out_points.h"
#include "anatomesh/reconcile/move/movement.h"
#include "anatomesh/reconcile/move/shared_points.h"
#include "anatomesh/reconcile/move/snap_planes_to_axis.h"
#include "anatomesh/reconcile/move/split_at_ends.h"
#include "anatomesh/reconcile/regularize/enforce_clearance.h"
#include "anatomesh/reconcile/regularize/flatten_folds.h"
#include "anatomesh/reconcile/regularize/regularize_along_axis.h"
#include "anatomesh/reconcile/regularize/regularize_fans.h"
#include "anatomesh/reconcile/resolve/facing_stretch.h"
#include "anatomesh/reconcile/resolve/line_votes.h"
#include "anatomesh/reconcile/resolve/resolve_conflicting_intervals.h"
#include "anatomesh/slices/coverage/undrawn_structures.h"
#include "anatomesh/slices/lines/arc.h"
#include "anatomesh/slices/lines/line_ends.h"

namespace anatomesh {

namespace {

constexpr int most_rounds = 16;
constexpr int most_idle_rounds = 6;
constexpr int most_repetitions = 4;     // of all rounds, with more vertices
constexpr double least_split_mm = 0.1;  // of a segment that gets a vertex
constexpr double least_gain = 0.2;      // of a repetition: the share by which slices differ less
constexpr double joined_mm = 0.1;       // how far a vertex may have gone to a common point
constexpr int most_align_rounds = 12;
// Of a contour drawn back from another slice's plane, and of the mean distance between vertices: nearer to
// the line two planes are so close to each other that no cells of any shape fit between.
constexpr double least_clearance_mm = 0.1, clearance_share = 0.1;
constexpr double flattening = 0.2;          // what is left of the height of an arc that is drawn back
constexpr double normal_reach_mm = 1;       // contours' normals are taken over chords of this half length
constexpr int most_shortenings = 16;        // of a step, by half each
constexpr double shortening_reach_mm = 3;   // along the contour
constexpr double least_moved_share = 0.05;  // of the radius about poles: else the slices agreed as drawn
constexpr double pole_radius_share = 0.3;   // of the mean distance between vertices
constexpr double sharp_pole_degrees = 70;
constexpr double apart_share = 0.5;  // of the clearance, from one another
constexpr double parted_share = 2;   // of the mean distance between vertices: contours are parted or joined

class Reconciler {
  public:
    Reconciler(ContourSet set, const ReconcileOptions& options, RunContext& context)
        : set_(std::move(set)), options_(options), context_(context) {}

    Result<ReconcileResult> run() {
        stats_.movements.resize(set_.slices.size());
        measure_extents();
        if (context_.cancelled()) return cancelled_error();
        if (pairs_.empty()) {
            warn_of_reconciling(set_, options_, stats_, undrawn_, isolated_, context_);
            return finish();
        }
        if (options_.align) {
            ANATOMESH_CHECK_STATUS(align());
        }
        drawn_ = drawn_places(set_);
        if (options_.reconcile) {
            lead_along_lines();
            snap_planes_to_axis(set_);
        }
        compare();
        stats_.pairs = disagreements(comparisons_);
        summarize(comparisons_, stats_);
        if (options_.reconcile) {
            ANATOMESH_CHECK_STATUS(check_bound(set_, comparisons_, options_));
            ANATOMESH_CHECK_STATUS(make_agree());
        }
        if (context_.cancelled()) return cancelled_error();
        note_difference_after();
        warn_of_reconciling(set_, options_, stats_, undrawn_, isolated_, context_);
        return finish();
    }

  private:
    void measure_extents() {
        patches_ = plane_patches(set_);
        clearance_mm_ = std::max(least_clearance_mm, clearance_share * mean_vertex_spacing(set_));
        margin_ = options_.margin_mm;
        if (margin_ == 0) margin_ = plane_spacings(set_, patches_).median;
        pairs_ = crossing_pairs(patches_, margin_);
        // Of what a slice leaves undrawn it says nothing, however the others come to lie.
        comparisons_ = compare_planes(set_, patches_, pairs_, margin_, context_);
        undrawn_ = find_undrawn_structures(set_, comparisons_, margin_);
        isolated_ = find_isolated_slices(set_, patches_, comparisons_, context_);
    }

    void lead_along_lines() {
        const ContourSet before = set_;
        const CommonLineOptions options;
        const CommonLineStats led = lead_along_common_lines(set_, pairs_, options);
        if (led.led_through + led.moved > 0) drawn_ = carry_over(before, drawn_, set_, options.width_mm);
    }

    void compare() {
        patches_ = plane_patches(set_);
        pairs_ = crossing_pairs(patches_, margin_);
        comparisons_ = compare_planes(set_, patches_, pairs_, margin_, context_);
        leave_out_undrawn(comparisons_);
    }
    void leave_out_undrawn(std::vector<LineComparison>& comparisons) const {
        std::erase_if(comparisons, [&](const LineComparison& c) {
            return is_undrawn(undrawn_, c.a, c.structure) || is_undrawn(undrawn_, c.b, c.structure);
        });
    }

    // Where slices do not agree on their common line, cutting a spike off may move an end there: those that
    // would be further apart keep theirs.
    FoldStats flatten(const std::vector<MovedPoint>& moved) {
        const ContourSet with_folds = set_;
        FoldOptions options{4 * options_.max_disagreement_mm, std::vector<bool>(set_.slices.size(), true)};
        FoldStats folds = flatten_folds(set_, moved, options);
        compare();
        const std::vector<PairDisagreement> least = disagreements(comparisons_);
        options.keeps_spikes.assign(set_.slices.size(), false);
        for (bool risen = true; risen;) {
            set_ = with_folds;
            folds = flatten_folds(set_, moved, options);
            compare();
            risen = false;
            for (const PairDisagreement& now : disagreements(comparisons_)) {
                const auto was = std::lower_bound(least.begin(), least.end(), now, before);
                const bool same =
                    was != least.end() && was->slice_a == now.slice_a && was->slice_b == now.slice_b;
                if (now.difference_mm <= (same ? was->difference_mm : 0)) continue;
                for (const std::uint32_t slice : {now.slice_a, now.slice_b}) {
                    risen = risen || !options.keeps_spikes[slice];
                    options.keeps_spikes[slice] = true;
                }
            }
        }
        return folds;
    }

    void shift_slices(const std::vector<Vec2>& shifts) {
        for (const Contour& contour : set_.contours) {
            const Plane& plane = set_.slices[contour.slice].plane;
            const Vec3 shift = shifts[contour.slice].x * plane.u + shifts[contour.slice].y * plane.v;
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k)
                set_.points[k] += shift;
        }
    }

    Status align() {
        std::vector<Vec2> total(set_.slices.size());
        const auto add = [&](const std::vector<Vec2>& shifts) {
            shift_slices(shifts);
            double largest = 0;
            for (std::size_t s = 0; s < shifts.size(); ++s) {
                total[s] = total[s] + shifts[s];
                largest = std::max(largest, length(shifts[s]));
            }
            return largest;
        };
        for (int round = 0; round < most_align_rounds; ++round) {
            compare();
            if (context_.cancelled()) return cancelled_error();
            if (add(estimate_shifts(set_, comparisons_, total)) < align_precision_mm) break;
        }
        const Vec3 common = common_translation(set_, total);
        std::vector<Vec2> back;
        for (const Slice& slice : set_.slices)
            back.push_back({-dot(common, slice.plane.u), -dot(common, slice.plane.v)});
        if (length(common) > 0) add(back);
        for (std::uint32_t s = 0; s < total.size(); ++s) {
            const Plane& plane = set_.slices[s].plane;
            stats_.movements[s].shift = total[s].x * plane.u + total[s].y * plane.v;
            if (length(total[s]) > options_.max_disagreement_mm) {
                return Error{
                    ErrorKind::geometry, "E-RCN-002",
                    "the slice agrees with those that it crosses only when it is shifted by more than " +
                        brief(options_.max_disagreement_mm) + " mm",
                    place_of_slice(set_, s, length(total[s])),
                    "leave the slice out with --without, or raise the bound with --max-disagreement"};
            }
        }
        return Nothing{};
    }

    // Moves the contours until crossing slices agree, puts common points in and cuts folds off. Where slices
    // differ afterwards their contours get vertices at just those places and are moved again; then what a
    // slice lacks altogether is taken over the line.
    Status make_agree() {
        ANATOMESH_CHECK_STATUS(move());
        note_movements();
        join();
        for (const bool over : {false, true}) {
            ANATOMESH_CHECK_STATUS(repeat(over));
        }
        if (!stats_.taken_over.empty()) {
            ANATOMESH_CHECK_STATUS(repeat(false));
        }
        if (context_.cancelled()) return cancelled_error();
        ANATOMESH_CHECK_STATUS(check_what_is_left(set_, drawn_, comparisons_, options_));
        resolve_what_is_left();
        regularize();
        part();
        unite_walls();
        return Nothing{};
    }

    // What movement could not bring together.
    void resolve_what_is_left() {
        if (left_mm() <= line_in_plane_mm) return;
        const auto compare_set = [&](const ContourSet& set) {
            std::vector<LineComparison> comparisons =
                compare_planes(set, plane_patches(set), pairs_, margin_, context_);
            leave_out_undrawn(comparisons);
            return comparisons;
        };
        const ConflictingIntervalOptions options{clearance_mm_, options_.max_disagreement_mm,
                                                 parted_share * mean_vertex_spacing(set_)};
        stats_.resolved =
            resolve_conflicting_intervals(set_, drawn_, comparisons_, compare_set, options, context_);
        if (stats_.resolved.empty()) return;
        compare();
        share_again(state(), left_mm());
    }

    // With more vertices, and, where asked, with what slices lack altogether taken over the line. A time is
    // kept if slices differ by a fifth less and all that it took over came there; what did not is left out,
    // and the others are taken again.
    Status repeat(bool over) {
        takes_over_ = over;
        for (int n = 0; n < most_repetitions && left_mm() > line_in_plane_mm; ++n) {
            const State before = state();
            const double left = left_mm();
            taken_.clear();
            if (over && !split_stretches()) break;
            split_at_ends(set_, comparisons_, least_split_mm);
            drawn_ = carry_over(before.set, before.drawn, set_, joined_mm);
            compare();
            ANATOMESH_CHECK_STATUS(move());
            note_movements();
            join();
            const std::vector<PairOfSlices> failed = still_differing(before.comparisons);
            if (failed.empty() && left_mm() <= (1 - least_gain) * left) {
                note_taken_over();
                continue;
            }
            go_back_to(before);
            if (failed.empty()) break;
            given_up_.insert(given_up_.end(), failed.begin(), failed.end());
            std::sort(given_up_.begin(), given_up_.end());
        }
        takes_over_ = false;
        return Nothing{};
    }

    // Contours of different structures that came to lie on each other, or beside each other with a sliver in
    // between, but for what is left of the movement.
    void unite_walls() {
        if (stats_.max_movement_mm == 0 || set_.structures.size() < 2) return;
        ConflationStats slivers;
        const bool closed = lead([&] {
            slivers = close_slivers(set_, {.width_mm = options_.close_slivers_mm});
            return slivers.contours_changed;
        });
        if (closed) stats_.slivers = slivers;
        ConflationStats shared;
        const bool led = lead([&] {
            shared = share_lines(set_, {.width_mm = options_.same_line_mm});
            return shared.contours_changed;
        });
        if (led) stats_.shared_lines = shared;
    }

    // Lets `change` lead contours otherwise, and says how many; taken back where slices would agree less.
    template <class Change>
    bool lead(Change&& change) {
        const State before = state();
        const double left = left_mm();
        if (change() == 0) return false;
        const std::optional<ContourSet> same = in_order_of(set_, before.set);
        if (same) {
            drawn_ = carry_over(*same, before.drawn, set_, joined_mm);
            note_movements();
            compare();
        }
        const double most = std::max(before.stats.max_movement_mm, options_.max_disagreement_mm);
        if (same && left_mm() <= left && stats_.max_movement_mm <= most) return true;
        go_back_to(before);
        return false;
    }

    // Where the drawings agree a sharp edge is one, and stays; so it does where slices would agree less.
    void regularize() {
        const FanOptions options{pole_radius_share * mean_vertex_spacing(set_), sharp_pole_degrees,
                                 options_.max_disagreement_mm};
        if (stats_.max_movement_mm < least_moved_share * options.radius_mm) return;
        const State before = state();
        const double left = left_mm();
        stats_.poles = regularize_fans(set_, drawn_, options);
        if (stats_.poles.poles > 0) {
            note_movements();
            compare();
            if (left_mm() > left) go_back_to(before);
        }
        regularize_along({options.radius_mm, options.least_degrees, options.most_moved_mm});
    }

    // Contours that run along lines beside which many planes come near to each other.
    void regularize_along(const AlongAxisOptions& options) {
        const State before = state();
        const double left = left_mm();
        AlongAxisBounds most_mm;
        for (const SliceMovement& movement : stats_.movements) most_mm.push_back(movement.max_mm);
        stats_.flanks = regularize_along_axis(set_, drawn_, most_mm, options);
        if (stats_.flanks.points > 0) share_again(before, left);
    }

    // Contours that came to touch each other but for a hair.
    void part() {
        const State before = state();
        const double left = left_mm();
        stats_.clearance = enforce_clearance(set_, drawn_, apart_share * clearance_mm_);
        if (stats_.clearance.places > 0) share_again(before, left);
    }

    // What a step changes, to be taken back where it does not help.
    struct State {
        ContourSet set;
        DrawnPlaces drawn;
        std::vector<LineComparison> comparisons;
        ReconcileStats stats;
    };
    State state() const { return {set_, drawn_, comparisons_, stats_}; }
    void go_back_to(const State& before) {
        set_ = before.set;
        drawn_ = before.drawn;
        comparisons_ = before.comparisons;
        stats_ = before.stats;
    }

    // Common points once more, of contours that were changed; back to what was before where slices would
    // agree less than they did.
    void share_again(const State& before, double left) {
        compare();
        const ContourSet without = set_;
        std::vector<bool> is_moved(set_.points.size());
        for (std::size_t k = 0; k < is_moved.size(); ++k) is_moved[k] = set_.points[k] != drawn_.at[k];
        stats_.shared_points = insert_shared_points(set_, comparisons_, normal_reach_mm, is_moved).points;
        drawn_ = carry_over(without, drawn_, set_, joined_mm);
        note_movements();
        compare();
        if (left_mm() > left) go_back_to(before);
    }

    double left_mm() const {
        double left = 0;
        for (const LineComparison& comparison : comparisons_) left += comparison.difference_mm;
        return left;
    }

    // Common points where slices agree now; then without folds.
    void join() {
        const ContourSet before = set_;
        std::vector<MovedPoint> moved;
        std::vector<bool> is_moved(set_.points.size());
        for (std::size_t k = 0; k < is_moved.size(); ++k) {
            is_moved[k] = set_.points[k] != drawn_.at[k];
            if (drawn_.is_drawn[k]) moved.push_back({set_.points[k], drawn_.at[k]});
        }
        stats_.shared_points = insert_shared_points(set_, comparisons_, normal_reach_mm, is_moved).points;
        const FoldStats folds = flatten(moved);
        stats_.folds.folds += folds.folds;
        stats_.folds.spikes += folds.spikes;
        stats_.folds.vertices += folds.vertices;
        stats_.folds.highest_mm = std::max(stats_.folds.highest_mm, folds.highest_mm);
        drawn_ = carry_over(before, drawn_, set_, joined_mm);
    }

    Status move() {
        graph_ = make_contour_graph(set_);
        double best = std::numeric_limits<double>::infinity();
        int idle = 0;  // rounds without progress worth the name
        for (int round = 0; round < most_rounds; ++round, ++stats_.rounds) {
            if (round > 0) compare();
            if (context_.cancelled()) return cancelled_error();
            context_.report("reconcile", static_cast<double>(round) / most_rounds);
            if (!place_movements()) return Nothing{};
            idle = worst_mm_ < 0.9 * best ? 0 : idle + 1;
            // What has yet to come over a line is in no group.
            if (!takes_over_ || round > 0) best = std::min(best, worst_mm_);
            if (idle == most_idle_rounds) return Nothing{};
            apply(solve_movement(nodes_, edges_, usual_, options_.smoothing_mm));
        }
        compare();
        return Nothing{};
    }

    // Fills nodes_, edges_ and usual_; false when there is nothing left to move.
    bool place_movements() {
        const EndPlaces ends = place_ends(set_, graph_, comparisons_);
        const EndGroups groups = group_ends(set_, ends, comparisons_, normal_reach_mm);
        bool any = groups.worst_mm > joinable_mm;
        worst_mm_ = groups.worst_mm;
        const std::size_t own = graph_.point_of_node.size();
        nodes_.assign(own + ends.places.size() - ends.on_nodes, {});
        usual_ = groups.position;
        for (std::size_t p = 0; p < ends.places.size(); ++p) {
            MovementNode& node = nodes_[p < ends.on_nodes ? ends.places[p].node : own + p - ends.on_nodes];
            const EndGroups::Member& member = groups.members[p];
            if (member.group == no_node) continue;
            if (member.pinned) {
                node = {Hold::pinned, 0, 0, member.direction};
            } else {
                node = {Hold::anchor, member.group, member.place, member.direction};
            }
        }
        const LineVotes votes(comparisons_);
        for (const LineComparison& comparison : comparisons_) {
            any |= draw_back(comparison, votes);
            if (takes_over_) any |= pin_stretches(comparison, votes);
        }
        link_nodes(ends);
        return any;
    }

    // Pins the arcs of intervals and gaps that only one of the slices has to the other side of the line; not
    // where it is the other slice that most of those through that line contradict.
    bool draw_back(const LineComparison& comparison, const LineVotes& votes) {
        bool any = false;
        for (const bool of_a : {true, false}) {
            const auto& ends = of_a ? comparison.ends_a : comparison.ends_b;
            const std::uint32_t own = of_a ? comparison.a : comparison.b,
                                other = of_a ? comparison.b : comparison.a;
            for (const std::uint32_t i :
                 of_a ? comparison.matching.only_first : comparison.matching.only_second) {
                const Arc arc =
                    arc_between(set_, ends[i], ends[i + 1], set_.slices[own].plane, set_.slices[other].plane);
                if (arc.points.empty() || arc.height_mm > options_.max_disagreement_mm ||
                    votes.most_agree(comparison, own, 0.5 * (ends[i].t + ends[i + 1].t)))
                    continue;
                any = true;
                pin(arc.points, arc.heights_mm, arc.height_mm, arc.back);
            }
        }
        return any;
    }

    // How far a point at a height above a line is taken across it, one of those that reach up to another
    // height: those nearest to the line farthest beyond. A contour that is hardly beyond the line is not
    // taken far from where it was drawn.
    double way_across(double height_mm, double most_mm) const {
        const double clearance_mm = std::clamp(most_mm, least_clearance_mm, clearance_mm_);
        return height_mm + clearance_mm + flattening * (most_mm - height_mm);
    }

    void pin(const std::vector<std::uint32_t>& points, const std::vector<double>& heights_mm,
             double height_mm, Vec2 across) {
        for (std::size_t n = 0; n < points.size(); ++n) {
            const double distance = way_across(heights_mm[n], height_mm);
            MovementNode& node = nodes_[graph_.node_of_point[points[n]]];
            if (node.hold == Hold::anchor) continue;
            if (node.hold == Hold::pinned && squared_length(node.direction) > distance * distance) continue;
            node = {Hold::pinned, 0, 0, distance * across};
        }
    }

    // What a slice lacks altogether though most of those through the line have it.
    using PairOfSlices = std::array<std::uint32_t, 3>;  // a, b, structure of a comparison
    struct Lacking {
        PairOfSlices pair{};
        std::uint32_t slice = 0;  // that lacks it
        FacingStretch stretch;    // of its contours, that nearest to it
    };

    // Of the two slices of a comparison; nothing that would have to move further than the bound.
    std::vector<Lacking> lacking_in(const LineComparison& comparison, const LineVotes& votes) const {
        std::vector<Lacking> all;
        const PairOfSlices pair{comparison.a, comparison.b, comparison.structure};
        if (std::binary_search(given_up_.begin(), given_up_.end(), pair)) return all;
        for (const bool of_a : {true, false}) {
            const auto& ends = of_a ? comparison.ends_a : comparison.ends_b;
            const std::uint32_t having = of_a ? comparison.a : comparison.b,
                                slice = of_a ? comparison.b : comparison.a;
            for (const std::uint32_t i :
                 of_a ? comparison.matching.only_first : comparison.matching.only_second) {
                const double low = ends[i].t, high = ends[i + 1].t;
                if (!votes.most_agree(comparison, having, 0.5 * (low + high))) continue;
                FacingStretch stretch = facing_stretch(set_, slice, comparison.structure, comparison.line,
                                                       set_.slices[having].plane, low, high);
                if (!stretch.empty() && is_within_bound(slice, stretch))
                    all.push_back({pair, slice, std::move(stretch)});
            }
        }
        return all;
    }
    // Whether none of its points comes further from where it was drawn, as it is taken over the line.
    bool is_within_bound(std::uint32_t slice, const FacingStretch& stretch) const {
        const double bound = options_.max_disagreement_mm;
        const Plane& plane = set_.slices[slice].plane;
        for (std::size_t n = 0; n < stretch.points.size(); ++n) {
            const std::uint32_t k = stretch.points[n];
            const Vec2 way = way_across(stretch.heights_mm[n], stretch.height_mm) * stretch.over;
            if (length(set_.points[k] + way.x * plane.u + way.y * plane.v - drawn_.at[k]) > bound)
                return false;
        }
        return way_across(stretch.height_mm, stretch.height_mm) <= bound;
    }

    // Pins the stretches of contours that have to come over the line.
    bool pin_stretches(const LineComparison& comparison, const LineVotes& votes) {
        bool any = false;
        for (const Lacking& lacking : lacking_in(comparison, votes)) {
            const FacingStretch& stretch = lacking.stretch;
            if (stretch.points.empty()) continue;
            pin(stretch.points, stretch.heights_mm, stretch.height_mm, stretch.over);
            taken_.push_back({{lacking.slice, lacking.pair[2], stretch.height_mm}, lacking.pair});
            any = true;
        }
        return any;
    }

    // Contours get vertices where a stretch of them has to come over a line. Says whether any has to.
    bool split_stretches() {
        const LineVotes votes(comparisons_);
        std::vector<LineEnd> places;
        bool any = false;
        for (const LineComparison& comparison : comparisons_) {
            for (const Lacking& lacking : lacking_in(comparison, votes)) {
                any = true;
                places.insert(places.end(), lacking.stretch.places.begin(), lacking.stretch.places.end());
            }
        }
        if (!places.empty()) {
            split_at_places(set_, places, least_split_mm);
            compare();
        }
        return any;
    }

    // Of what was taken over a line, the pairs of slices that differ there by more than half as before.
    std::vector<PairOfSlices> still_differing(const std::vector<LineComparison>& before) const {
        const auto difference = [](const std::vector<LineComparison>& all, const PairOfSlices& pair) {
            const auto at = std::lower_bound(all.begin(), all.end(), pair,
                                             [](const LineComparison& one, const PairOfSlices& key) {
                                                 return PairOfSlices{one.a, one.b, one.structure} < key;
                                             });
            const bool found = at != all.end() && PairOfSlices{at->a, at->b, at->structure} == pair;
            return found ? at->difference_mm : 0.0;
        };
        std::vector<PairOfSlices> failed;
        for (const Taken& taken : taken_) {
            if (difference(comparisons_, taken.pair) > 0.5 * difference(before, taken.pair))
                failed.push_back(taken.pair);
        }
        std::sort(failed.begin(), failed.end());
        failed.erase(std::unique(failed.begin(), failed.end()), failed.end());
        return failed;
    }

    // One entry a slice and structure, the farthest.
    void note_taken_over() {
        std::vector<TakenOver>& all = stats_.taken_over;
        for (const Taken& taken : taken_) all.push_back(taken.over);
        const auto key = [](const TakenOver& t) { return std::pair(t.slice, t.structure); };
        std::sort(all.begin(), all.end(), [&](const TakenOver& p, const TakenOver& q) {
            return key(p) != key(q) ? key(p) < key(q) : p.farthest_mm > q.farthest_mm;
        });
        all.erase(std::unique(all.begin(), all.end(),
                              [&](const TakenOver& p, const TakenOver& q) { return key(p) == key(q); }),
                  all.end());
    }

    // Segments cut at the places inside them.
    void link_nodes(const EndPlaces& ends) {
        edges_.clear();
        std::size_t next = ends.on_nodes;
        const auto link = [&](std::uint32_t a, std::uint32_t b, double length) {
            edges_.push_back({a, b, std::max(length, 10 * line_in_plane_mm)});
        };
        for (std::uint32_t s = 0; s < graph_.segments.size(); ++s) {
            const auto [low, high] = graph_.segments[s];
            std::uint32_t last = low;
            double reached = 0;
            for (; next < ends.places.size() && ends.places[next].segment == s; ++next) {
                const auto node =
                    static_cast<std::uint32_t>(graph_.point_of_node.size() + next - ends.on_nodes);
                link(last, node, ends.places[next].distance - reached);
                last = node;
                reached = ends.places[next].distance;
            }
            const double whole =
                length(set_.points[graph_.point_of_node[high]] - set_.points[graph_.point_of_node[low]]);
            link(last, high, whole - reached);
        }
    }

    // Where the contours of a slice come to with a share of the move for every point.
    std::vector<PlaneRing> rings_of(const Slice& slice, const std::vector<Vec2>& moves,
                                    const std::vector<double>& shares) const {
        std::vector<PlaneRing> rings;
        for (const Contour& contour : set_.contours_of(slice)) {
            PlaneRing ring{contour.structure, {}};
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
                ring.at.push_back(slice.plane.to_plane(moved(slice.plane, k, moves, shares)));
            }
            rings.push_back(std::move(ring));
        }
        return rings;
    }

    // Never further from where it was drawn than the bound.
    Vec3 moved(const Plane& plane, std::uint32_t point, const std::vector<Vec2>& moves,
               const std::vector<double>& shares) const {
        const std::uint32_t node = graph_.node_of_point[point];
        const Vec2 move = shares[node] * moves[node];
        if (move == Vec2{}) return set_.points[point];
        const Vec3 to = set_.points[point] + (move.x * plane.u + move.y * plane.v),
                   way = to - drawn_.at[point];
        const double distance = length(way);
        if (distance <= options_.max_disagreement_mm) return to;
        // As rounded, too.
        for (double less = 0;; less = std::max(2 * less, std::numeric_limits<double>::epsilon())) {
            const Vec3 at = drawn_.at[point] + ((1 - less) * options_.max_disagreement_mm / distance) * way;
            if (length(at - drawn_.at[point]) <= options_.max_disagreement_mm) return at;
        }
    }

    // Moves every slice as far as it stays sound: round a fault the step is shortened by half, again and
    // again.
    void apply(const std::vector<Vec2>& moves) {
        std::vector<double> shares(nodes_.size(), 1.0);
        parallel_for(set_.slices.size(), 1, context_.threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t s = begin; s < end; ++s) shorten(set_.slices[s], moves, shares);
        });
        for (const Contour& contour : set_.contours) {
            const Plane& plane = set_.slices[contour.slice].plane;
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
                set_.points[k] = moved(plane, k, moves, shares);
            }
        }
    }

    void shorten(const Slice& slice, const std::vector<Vec2>& moves, std::vector<double>& shares) const {
        for (int n = 0; n < most_shortenings; ++n) {
            const std::vector<RingSegment> faults =
                slice_faults(rings_of(slice, moves, shares), set_.exclusive);
            if (faults.empty()) return;
            const double reach = shortening_reach_mm * (1 + n / 4);  // wider where that does not help
            for (const RingSegment fault : faults) {
                shorten_round(set_.contours[slice.first_contour + fault.ring], fault.place, reach, shares);
            }
        }
        for (const Contour& contour : set_.contours_of(slice)) {
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
                shares[graph_.node_of_point[k]] = 0;
            }
        }
    }

    // Halves the shares of the points within reach of a segment of a contour, and less further out.
    void shorten_round(const Contour& contour, std::uint32_t place, double reach,
                       std::vector<double>& shares) const {
        for (const bool forward : {false, true}) {
            std::uint32_t k = contour.first_point + place;
            if (forward) k = point_after(contour, k);
            double walked = 0;
            for (std::uint32_t n = 0; n < contour.point_count && walked < reach; ++n) {
                shares[graph_.node_of_point[k]] *= 0.5 + 0.5 * walked / reach;
                const std::uint32_t next = forward ? point_after(contour, k) : point_before(contour, k);
                walked += length(set_.points[next] - set_.points[k]);
                k = next;
            }
        }
    }

    // Of the drawn vertices, before they are joined.
    void note_movements() {
        double sum = 0;
        stats_.max_movement_mm = 0;
        std::size_t count = 0;
        for (std::uint32_t s = 0; s < set_.slices.size(); ++s) {
            SliceMovement& movement = stats_.movements[s];
            double of_slice = 0;
            movement.max_mm = 0;
            std::size_t vertices = 0;
            for (const Contour& contour : set_.contours_of(set_.slices[s])) {
                for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count;
                     ++k) {
                    if (!drawn_.is_drawn[k]) continue;
                    const double distance = length(set_.points[k] - drawn_.at[k]);
                    of_slice += distance;
                    movement.max_mm = std::max(movement.max_mm, distance);
                    ++vertices;
                }
            }
            movement.mean_mm = of_slice / static_cast<double>(std::max<std::size_t>(1, vertices));
            stats_.max_movement_mm = std::max(stats_.max_movement_mm, movement.max_mm);
            sum += of_slice;
            count += vertices;
        }
        stats_.mean_movement_mm = sum / static_cast<double>(std::max<std::size_t>(1, count));
    }

    void note_difference_after() {
        for (const PairDisagreement& after : disagreements(comparisons_)) {
            stats_.difference_after_mm += after.difference_mm;
            const auto at = std::lower_bound(stats_.pairs.begin(), stats_.pairs.end(), after, before);
            if (at != stats_.pairs.end() && at->slice_a == after.slice_a && at->slice_b == after.slice_b) {
                at->difference_after_mm = after.difference_mm;
            } else if (after.difference_mm > 0) {
                PairDisagreement added{after.slice_a, after.slice_b, 0, 0, 0, 0, 0, 0, after.difference_mm};
                stats_.pairs.insert(at, added);
            }
        }
    }
    static bool before(const PairDisagreement& p, const PairDisagreement& q) {
        return std::tie(p.slice_a, p.slice_b) < std::tie(q.slice_a, q.slice_b);
    }

    // Contours begin at their smallest point and stand in order, as in every kept set.
    ReconcileResult finish() {
        for (const Slice& slice : set_.slices) {
            const auto first = set_.contours.begin() + slice.first_contour,
                       last = first + slice.contour_count;
            for (auto contour = first; contour != last; ++contour) {
                const auto begin = set_.points.begin() + contour->first_point,
                           end = begin + contour->point_count;
                std::rotate(begin, std::min_element(begin, end, lexicographic_less_3), end);
            }
            std::stable_sort(first, last, [&](const Contour& p, const Contour& q) {
                if (p.structure != q.structure) return p.structure < q.structure;
                return lexicographic_less(set_.points[p.first_point], set_.points[q.first_point]);
            });
        }
        return {std::move(set_), std::move(stats_)};
    }
    static bool lexicographic_less_3(Vec3 a, Vec3 b) { return lexicographic_less(a, b); }

    ContourSet set_;
    const ReconcileOptions& options_;
    RunContext& context_;
    ReconcileStats stats_;
    DrawnPlaces drawn_;
    double margin_ = 0, clearance_mm_ = 0;
    // What is taken over lines, and the pairs of slices with which that failed.
    struct Taken {
        TakenOver over;
        PairOfSlices pair{};
    };
    bool takes_over_ = false;
    std::vector<Taken> taken_;
    std::vector<PairOfSlices> given_up_;  // sorted
    double worst_mm_ = 0;                 // of places from their groups' points, in this round
    std::vector<PlanePatch> patches_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs_;
    std::vector<LineComparison> comparisons_;
    std::vector<UndrawnStructure> undrawn_;
    std::vector<IsolatedSlice> isolated_;
    ContourGraph graph_;
    std::vector<MovementNode> nodes_;
    std::vector<MovementEdge> edges_;
    std::vector<double> usual_;
};

}  // namespace

Result<ReconcileResult> reconcile_contours(ContourSet set, const ReconcileOptions& options,
                                           RunContext& context) {
    assert(options.max_disagreement_mm > 0 && options.smoothing_mm > 0 && options.margin_mm >= 0);
    return Reconciler(std::move(set), options, context).run();
}

}  // namespace anatomesh
