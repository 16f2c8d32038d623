#include "anatomesh/refine/contour_subsegments.h"

#include <algorithm>
#include <array>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/refine/refine.h"

namespace anatomesh {

namespace {

// Missing subsegments are looked for and split so often. [rounds; >= 1; B]
constexpr int segment_rounds = 8;
constexpr int side_rounds = 2;  // Points go beside subsegments off their surface so often. [rounds; >= 0; B]
constexpr std::size_t a_few = 8;  // So many may always be split further. [subsegments; >= 0; B]
// No other contour vertex is this near to the middle of a subsegment that is split.
// [its lengths; 0 to 0.5; M 2026-11, set not recorded]
constexpr double free_share = 0.25;
// Subsegments are split in rounds down to this length. [sizes; > 0; M 2026-11, set not recorded]
constexpr double shortest_subsegment = 0.3;
// The whole ball of a subsegment that is split. [its lengths; 0 to 0.5; D]
constexpr double dense_free_share = 0.5;
// Where more than a few are missing, as where planes cross: no other contour vertex, nor an end of the
// subsegment, is this near to its middle. [sizes; >= 0; M 2026-11, set not recorded]
constexpr double subsegment_clearance = 0.05;
// Nearly the whole ball of the subsegment. [free_share; 0 to 2; M 2026-11 fetal brain and crossing stacks]
constexpr double lone_room = 1.9;
// The same where planes are dense. [free_share; 0 to 2; M 2026-11 dense freehand planes]
constexpr double crowded_room = 0.3;
// As shortest_subsegment, where subsegments were split beforehand.
// [sizes; > 0; M 2026-11 16 structures of a head]
constexpr double shortest_graded = 0.01;

}  // namespace

SplitLimits SplitLimits::scaled(double scale) {
    return {scale * shortest_subsegment, scale, 0, false, scale < 1};
}

SplitLimits SplitLimits::lone() {
    return {0, lone_room, subsegment_clearance, false, false};
}

SplitLimits SplitLimits::among_others() {
    return {0, crowded_room, subsegment_clearance, false, false};
}

SplitLimits SplitLimits::graded() {
    return {shortest_graded, crowded_room, 0, true, false};
}

SplitLimits SplitLimits::beside_short() {
    return {0, 1, subsegment_clearance, false, false};
}

ContourSubsegments::ContourSubsegments(LabelledMesh& mesh, ProtectedSegments& protected_segments,
                                       const StructureField& field, std::vector<Subsegment> subsegments,
                                       const ContourSubsegmentOptions& options)
    : mesh_(mesh),
      protected_segments_(protected_segments),
      field_(field),
      options_(options),
      subsegments_(std::move(subsegments)),
      acute_(acute_vertices(mesh.points(), subsegments_)),
      are_short_(options.conforming) {
    // Contours that cross within a slice are split opposite each other instead.
    if (options.conforming) apexes_ = SegmentClusters(mesh_.points(), subsegments_, acute_);
}

Status ContourSubsegments::grow(std::vector<Vec3> found, const std::vector<std::uint32_t>& balls,
                                RunContext& context, const SplitLimits& limits) {
    if (context.cancelled()) return cancelled_error();
    std::vector<Subsegment> split;
    std::vector<Subsegment> kept;
    for (const Subsegment& subsegment : subsegments_) {
        const bool wanted = std::binary_search(balls.begin(), balls.end(), subsegment.ball) &&
                            place_of_split(subsegment, limits);
        (wanted ? split : kept).push_back(subsegment);
    }
    std::stable_sort(split.begin(), split.end(), [](auto& x, auto& y) { return x.ball < y.ball; });
    keep_apart(split, kept, limits);
    const std::size_t others = found.size();
    for (const Subsegment& subsegment : split) found.push_back(*place_of_split(subsegment, limits));
    const std::vector<std::uint32_t> vertices = mesh_.insert(found, context.threads);
    subsegments_ = std::move(kept);
    add_halves(split, {vertices.begin() + static_cast<std::ptrdiff_t>(others), vertices.end()});
    mesh_.update(context);
    return check_region_count(mesh_);
}

// Contours of two structures that run together want points at next to the same place: of those of one round
// the first has its way, the other subsegment stays as it is.
void ContourSubsegments::keep_apart(std::vector<Subsegment>& split, std::vector<Subsegment>& kept,
                                    const SplitLimits& limits) const {
    PointGrid chosen(options_.size_mm, split.size() + 1);
    std::vector<Subsegment> apart;
    for (const Subsegment& subsegment : split) {
        const bool shares_ball = !apart.empty() && apart.back().ball == subsegment.ball;
        const Vec3 point = *place_of_split(subsegment, limits);
        const std::optional<Vec3> apex = apex_of(subsegment);
        bool taken = false;
        if (!shares_ball) {
            chosen.for_each_within(point, room_of(subsegment, limits), [&](std::uint32_t n, double) {
                taken = taken || !apex || !ProtectedSegments::is_on_shell(chosen.point(n), point, *apex);
            });
        }
        if (taken) {
            kept.push_back(subsegment);
            continue;
        }
        if (!shares_ball) chosen.add(point);
        apart.push_back(subsegment);
    }
    split = std::move(apart);
}

// Subsegments in the order of their balls; those of several structures with one ball share its halves too.
void ContourSubsegments::add_halves(const std::vector<Subsegment>& split,
                                    const std::vector<std::uint32_t>& middles) {
    std::uint32_t low = 0, high = 0;
    for (std::size_t k = 0; k < split.size(); ++k) {
        const Subsegment& subsegment = split[k];
        if (k == 0 || split[k - 1].ball != subsegment.ball) {
            protected_segments_.drop_ball(subsegment.ball);
            protected_segments_.add_point(mesh_.points()[middles[k]]);
            const Vec3 middle = mesh_.points()[middles[k]];
            low = protected_segments_.add_segment(mesh_.points()[subsegment.a], middle);
            high = protected_segments_.add_segment(middle, mesh_.points()[subsegment.b]);
            apexes_.pass_on(subsegment, low, high);
            vertices_.push_back(middles[k]);
        }
        subsegments_.push_back({subsegment.a, middles[k], subsegment.structure, low});
        subsegments_.push_back({middles[k], subsegment.b, subsegment.structure, high});
    }
}

double ContourSubsegments::room_of(const Subsegment& subsegment, const SplitLimits& limits) const {
    const double span = length(mesh_.points()[subsegment.b] - mesh_.points()[subsegment.a]);
    const double room = limits.room * (options_.spared ? dense_free_share : free_share) * span;
    return std::max(room, limits.clearance * options_.size_mm);
}

// Not where a contour runs close beside it, which would have to be split in its turn, and so on.
bool ContourSubsegments::may_split(const Subsegment& subsegment, const SplitLimits& limits) const {
    const double span = length(mesh_.points()[subsegment.b] - mesh_.points()[subsegment.a]);
    if (!(span > limits.shortest * options_.size_mm)) return false;
    const Vec3 place = split_place(subsegment);
    const double room = room_of(subsegment, limits);
    const std::optional<Vec3> apex = apex_of(subsegment);
    return apex ? !protected_segments_.any_point_within(place, room, *apex)
                : !protected_segments_.any_point_within(place, room);
}

std::optional<Vec3> ContourSubsegments::apex_of(const Subsegment& subsegment) const {
    const std::optional<std::uint32_t> apex = apexes_.of(subsegment);
    if (!apex) return std::nullopt;
    return mesh_.points()[*apex];
}

Vec3 ContourSubsegments::split_place(const Subsegment& subsegment) const {
    if (const std::optional<Vec3> apex = apex_of(subsegment))
        return shell_point(mesh_.points(), subsegment, *apex);
    return split_point(mesh_.points(), subsegment, acute_);
}

// Where others are too near, opposite to what lies in its ball, if the limits let it.
std::optional<Vec3> ContourSubsegments::place_of_split(const Subsegment& subsegment,
                                                       const SplitLimits& limits) const {
    if (may_split(subsegment, limits)) return split_place(subsegment);
    const Vec3 a = mesh_.points()[subsegment.a], b = mesh_.points()[subsegment.b];
    if (!limits.at_feet || !(length(b - a) > limits.shortest * options_.size_mm)) return std::nullopt;
    const std::optional<Vec3> beside = protected_segments_.point_in_ball_of(a, b);
    if (!beside) return std::nullopt;
    const std::optional<Vec3> foot = foot_on(mesh_.points(), subsegment, *beside);
    if (!foot || protected_segments_.any_point_within(*foot, foot_room * length(*beside - *foot)))
        return std::nullopt;
    return foot;
}

Status ContourSubsegments::recover(std::size_t share, RunContext& context, const SplitLimits& limits) {
    std::size_t last = subsegments_.size();
    for (int round = 0; round < segment_rounds; ++round) {
        std::vector<std::uint32_t> balls;
        mesh_.look_again(search_);
        const std::vector<std::uint32_t> missing =
            missing_.find(mesh_.cells(), mesh_.points().size(), subsegments_, search_.cells, context.threads);
        search_.cells.clear();
        for (const std::uint32_t n : missing) {
            if (place_of_split(subsegments_[n], limits)) balls.push_back(subsegments_[n].ball);
        }
        if (limits.few_alone && balls.size() > a_few &&
            (balls.size() >= last || balls.size() * options_.last_few > subsegments_.size()))
            break;
        last = balls.size();
        if (balls.empty() || (share > 0 && balls.size() * share < subsegments_.size())) break;
        std::sort(balls.begin(), balls.end());
        ANATOMESH_CHECK_STATUS(grow({}, balls, context, limits));
    }
    return Nothing{};
}

Status ContourSubsegments::finish(RunContext& context) {
    if (options_.spared) return recover(0, context);
    ANATOMESH_CHECK_STATUS(recover_few(context));
    if (options_.graded) {
        ANATOMESH_CHECK_STATUS(recover(0, context, SplitLimits::graded()));
    }
    if (options_.to_short) {
        const std::size_t before = subsegments_.size();
        ANATOMESH_CHECK_STATUS(
            recover(0, context, options_.dense ? SplitLimits::among_others() : SplitLimits::lone()));
        if (subsegments_.size() > before) {
            are_short_ = true;
            ANATOMESH_CHECK_STATUS(recover_few(context));
        }
    }
    for (int round = 0; round < side_rounds; ++round) {
        ANATOMESH_TRY(const bool opened, open_sides(context));
        if (!opened) break;
    }
    return Nothing{};
}

Status ContourSubsegments::recover_few(RunContext& context) {
    for (const double scale : {1.0, 0.5, 0.25, 0.125}) {
        ANATOMESH_CHECK_STATUS(recover(0, context, SplitLimits::scaled(scale)));
    }
    return Nothing{};
}

Result<bool> ContourSubsegments::open_sides(RunContext& context, std::vector<std::uint32_t>* ends) {
    mesh_.look_again(sides_search_);
    const std::vector<SubsegmentSides> sides =
        sides_.find(mesh_.cells(), mesh_.regions(), mesh_.registry().table(), mesh_.points().size(),
                    subsegments_, sides_search_.cells, context.threads);
    sides_search_.cells.clear();
    std::vector<Vec3> found;
    find_side_points(mesh_.points(), subsegments_, sides, field_, mesh_.grid(), {}, found, context);
    for (std::size_t n = 0; ends && n < subsegments_.size(); ++n) {
        if (sides[n].inside != sides[n].outside)
            ends->insert(ends->end(), {subsegments_[n].a, subsegments_[n].b});
    }
    if (found.empty()) return false;
    side_points_ += found.size();
    ANATOMESH_CHECK_STATUS(grow(found, {}, context));
    for (const double scale : {1.0, 0.25}) {
        ANATOMESH_CHECK_STATUS(recover(0, context, SplitLimits::scaled(scale)));
    }
    if (options_.graded) {
        ANATOMESH_CHECK_STATUS(recover(0, context, SplitLimits::graded()));
    }
    return true;
}

Status check_region_count(LabelledMesh& mesh) {
    if (!mesh.registry().full()) return Nothing{};
    return Error{ErrorKind::limit,
                 "E-PIP-003",
                 "the structures overlap in more than " + std::to_string(RegionRegistry::max_regions) +
                     " different ways",
                 {},
                 "choose fewer structures with --structure"};
}

}  // namespace anatomesh
