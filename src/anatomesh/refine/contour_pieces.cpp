#include "anatomesh/refine/contour_pieces.h"

#include <algorithm>
#include <array>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/refine/refine.h"

namespace anatomesh {

namespace {

constexpr int segment_rounds = 8;
constexpr int side_rounds = 2;    // of points beside pieces of contour segments off their structure's surface
constexpr std::size_t a_few = 8;  // so many may always be split further
constexpr double free_share =
    0.25;  // of a piece that is split: no other contour vertex is this near to its middle
constexpr double shortest_piece = 0.3;    // of a contour segment that is still split, in sizes
constexpr double dense_free_share = 0.5;  // the whole ball of a piece that is split
// Where more than a few are missing, as where planes cross: no other contour vertex, nor an end of the piece,
// is this near to its middle, in sizes.
constexpr double piece_clearance = 0.05;
constexpr double lone_room = 1.9;  // in shares as above: nearly the whole ball of the piece
constexpr double crowded_room = 0.3;
constexpr double shortest_graded = 0.01;  // as shortest_piece, where pieces were split beforehand

}  // namespace

SplitLimits SplitLimits::scaled(double scale) {
    return {scale * shortest_piece, scale, 0, false, scale < 1};
}

SplitLimits SplitLimits::lone() {
    return {0, lone_room, piece_clearance, false, false};
}

SplitLimits SplitLimits::among_others() {
    return {0, crowded_room, piece_clearance, false, false};
}

SplitLimits SplitLimits::graded() {
    return {shortest_graded, crowded_room, 0, true, false};
}

SplitLimits SplitLimits::beside_short() {
    return {0, 1, piece_clearance, false, false};
}

ContourPieces::ContourPieces(LabelledMesh& mesh, SegmentGuard& guard, const StructureField& field,
                             std::vector<SegmentPiece> pieces, const ContourPieceOptions& options)
    : mesh_(mesh),
      guard_(guard),
      field_(field),
      options_(options),
      pieces_(std::move(pieces)),
      acute_(acute_vertices(mesh.points(), pieces_)),
      are_short_(options.conforming) {
    // Contours that cross within a slice are split opposite each other instead.
    if (options.conforming) apexes_ = PieceApexes(mesh_.points(), pieces_, acute_);
}

Status ContourPieces::grow(std::vector<Vec3> found, const std::vector<std::uint32_t>& balls,
                           RunContext& context, const SplitLimits& limits) {
    if (context.cancelled()) return cancelled_error();
    std::vector<SegmentPiece> split;
    std::vector<SegmentPiece> kept;
    for (const SegmentPiece& piece : pieces_) {
        const bool wanted =
            std::binary_search(balls.begin(), balls.end(), piece.ball) && place_of_split(piece, limits);
        (wanted ? split : kept).push_back(piece);
    }
    std::stable_sort(split.begin(), split.end(), [](auto& x, auto& y) { return x.ball < y.ball; });
    keep_apart(split, kept, limits);
    const std::size_t others = found.size();
    for (const SegmentPiece& piece : split) found.push_back(*place_of_split(piece, limits));
    const std::vector<std::uint32_t> vertices = mesh_.insert(found, context.threads);
    pieces_ = std::move(kept);
    add_halves(split, {vertices.begin() + static_cast<std::ptrdiff_t>(others), vertices.end()});
    mesh_.update(context);
    return check_region_count(mesh_);
}

// Contours of two structures that run together want points at next to the same place: of those of one round
// the first has its way, the other piece stays as it is.
void ContourPieces::keep_apart(std::vector<SegmentPiece>& split, std::vector<SegmentPiece>& kept,
                               const SplitLimits& limits) const {
    PointGrid chosen(options_.size_mm, split.size() + 1);
    std::vector<SegmentPiece> apart;
    for (const SegmentPiece& piece : split) {
        const bool shares_ball = !apart.empty() && apart.back().ball == piece.ball;
        const Vec3 point = *place_of_split(piece, limits);
        const std::optional<Vec3> apex = apex_of(piece);
        bool taken = false;
        if (!shares_ball) {
            chosen.for_each_within(point, room_of(piece, limits), [&](std::uint32_t n, double) {
                taken = taken || !apex || !SegmentGuard::is_on_shell(chosen.point(n), point, *apex);
            });
        }
        if (taken) {
            kept.push_back(piece);
            continue;
        }
        if (!shares_ball) chosen.add(point);
        apart.push_back(piece);
    }
    split = std::move(apart);
}

// Pieces in the order of their balls; those of several structures with one ball share its halves too.
void ContourPieces::add_halves(const std::vector<SegmentPiece>& split,
                               const std::vector<std::uint32_t>& middles) {
    std::uint32_t low = 0, high = 0;
    for (std::size_t k = 0; k < split.size(); ++k) {
        const SegmentPiece& piece = split[k];
        if (k == 0 || split[k - 1].ball != piece.ball) {
            guard_.drop_ball(piece.ball);
            guard_.add_point(mesh_.points()[middles[k]]);
            const Vec3 middle = mesh_.points()[middles[k]];
            low = guard_.add_segment(mesh_.points()[piece.a], middle);
            high = guard_.add_segment(middle, mesh_.points()[piece.b]);
            apexes_.pass_on(piece, low, high);
            vertices_.push_back(middles[k]);
        }
        pieces_.push_back({piece.a, middles[k], piece.structure, low});
        pieces_.push_back({middles[k], piece.b, piece.structure, high});
    }
}

double ContourPieces::room_of(const SegmentPiece& piece, const SplitLimits& limits) const {
    const double span = length(mesh_.points()[piece.b] - mesh_.points()[piece.a]);
    const double room = limits.room * (options_.spared ? dense_free_share : free_share) * span;
    return std::max(room, limits.clearance * options_.size_mm);
}

// Not where a contour runs close beside it, which would have to be split in its turn, and so on.
bool ContourPieces::may_split(const SegmentPiece& piece, const SplitLimits& limits) const {
    const double span = length(mesh_.points()[piece.b] - mesh_.points()[piece.a]);
    if (!(span > limits.shortest * options_.size_mm)) return false;
    const Vec3 place = split_place(piece);
    const double room = room_of(piece, limits);
    const std::optional<Vec3> apex = apex_of(piece);
    return apex ? !guard_.any_point_within(place, room, *apex) : !guard_.any_point_within(place, room);
}

std::optional<Vec3> ContourPieces::apex_of(const SegmentPiece& piece) const {
    const std::optional<std::uint32_t> apex = apexes_.of(piece);
    if (!apex) return std::nullopt;
    return mesh_.points()[*apex];
}

Vec3 ContourPieces::split_place(const SegmentPiece& piece) const {
    if (const std::optional<Vec3> apex = apex_of(piece)) return shell_point(mesh_.points(), piece, *apex);
    return split_point(mesh_.points(), piece, acute_);
}

// Where others are too near, opposite to what lies in its ball, if the limits let it.
std::optional<Vec3> ContourPieces::place_of_split(const SegmentPiece& piece,
                                                  const SplitLimits& limits) const {
    if (may_split(piece, limits)) return split_place(piece);
    const Vec3 a = mesh_.points()[piece.a], b = mesh_.points()[piece.b];
    if (!limits.at_feet || !(length(b - a) > limits.shortest * options_.size_mm)) return std::nullopt;
    const std::optional<Vec3> beside = guard_.point_in_ball_of(a, b);
    if (!beside) return std::nullopt;
    const std::optional<Vec3> foot = foot_on(mesh_.points(), piece, *beside);
    if (!foot || guard_.any_point_within(*foot, foot_room * length(*beside - *foot))) return std::nullopt;
    return foot;
}

Status ContourPieces::recover(std::size_t share, RunContext& context, const SplitLimits& limits) {
    std::size_t last = pieces_.size();
    for (int round = 0; round < segment_rounds; ++round) {
        std::vector<std::uint32_t> balls;
        mesh_.look_again(search_);
        const std::vector<std::uint32_t> missing =
            missing_.find(mesh_.cells(), mesh_.points().size(), pieces_, search_.cells, context.threads);
        search_.cells.clear();
        for (const std::uint32_t n : missing) {
            if (place_of_split(pieces_[n], limits)) balls.push_back(pieces_[n].ball);
        }
        if (limits.few_alone && balls.size() > a_few &&
            (balls.size() >= last || balls.size() * options_.last_few > pieces_.size()))
            break;
        last = balls.size();
        if (balls.empty() || (share > 0 && balls.size() * share < pieces_.size())) break;
        std::sort(balls.begin(), balls.end());
        ANATOMESH_CHECK_STATUS(grow({}, balls, context, limits));
    }
    return Nothing{};
}

Status ContourPieces::finish(RunContext& context) {
    if (options_.spared) return recover(0, context);
    ANATOMESH_CHECK_STATUS(recover_few(context));
    if (options_.graded) {
        ANATOMESH_CHECK_STATUS(recover(0, context, SplitLimits::graded()));
    }
    if (options_.to_short) {
        const std::size_t before = pieces_.size();
        ANATOMESH_CHECK_STATUS(
            recover(0, context, options_.dense ? SplitLimits::among_others() : SplitLimits::lone()));
        if (pieces_.size() > before) {
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

Status ContourPieces::recover_few(RunContext& context) {
    for (const double scale : {1.0, 0.5, 0.25, 0.125}) {
        ANATOMESH_CHECK_STATUS(recover(0, context, SplitLimits::scaled(scale)));
    }
    return Nothing{};
}

Result<bool> ContourPieces::open_sides(RunContext& context, std::vector<std::uint32_t>* ends) {
    mesh_.look_again(sides_search_);
    const std::vector<PieceSides> sides =
        sides_.find(mesh_.cells(), mesh_.regions(), mesh_.registry().table(), mesh_.points().size(), pieces_,
                    sides_search_.cells, context.threads);
    sides_search_.cells.clear();
    std::vector<Vec3> found;
    find_side_points(mesh_.points(), pieces_, sides, field_, mesh_.grid(), {}, found, context);
    for (std::size_t n = 0; ends && n < pieces_.size(); ++n) {
        if (sides[n].inside != sides[n].outside) ends->insert(ends->end(), {pieces_[n].a, pieces_[n].b});
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
