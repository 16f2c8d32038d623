#include "anatomesh/live/preview/preview_surface.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "anatomesh/geom/box.h"
#include "anatomesh/live/preview/node_lattice.h"

namespace anatomesh {

namespace {

// So many cells of a brick along each axis: an edit makes a few dozen bricks anew. [cells; 2 to 64; B]
constexpr std::int32_t brick_cells = 16;
// Contours are followed in steps of this share of the lattice's. [1; 0 to 1; B]
constexpr double seed_share = 0.5;

BrickPlace brick_of(Cell cell) {
    BrickPlace brick;
    for (std::size_t axis = 0; axis < 3; ++axis)
        brick[axis] = cell[axis] >= 0 ? cell[axis] / brick_cells : -((-cell[axis] - 1) / brick_cells) - 1;
    return brick;
}

// What a brick's surface depends on: its own cells, and those below it whose vertices its quadrilaterals have. One cell
// more, because heights over oblique planes round.
Box3 reach_of(BrickPlace brick, double step) {
    const auto at = [&](std::size_t axis, std::int32_t cells) {
        return step * static_cast<double>(brick[axis] * brick_cells + cells);
    };
    return {{at(0, -2), at(1, -2), at(2, -2)},
            {at(0, brick_cells + 2), at(1, brick_cells + 2), at(2, brick_cells + 2)}};
}

bool is_touched(const Box3& box, std::span<const ChangedStretch> changed) {
    const Vec3 middle = 0.5 * (box.low + box.high), half = 0.5 * (box.high - box.low);
    return std::any_of(changed.begin(), changed.end(), [&](const ChangedStretch& stretch) {
        const Vec3 n = stretch.plane.normal;
        const double at = stretch.plane.signed_distance(middle),
                     reach = std::abs(n.x) * half.x + std::abs(n.y) * half.y + std::abs(n.z) * half.z;
        return at + reach >= stretch.low && at - reach <= stretch.high;
    });
}

// Which bricks of a box are made anew.
class OpenBricks {
  public:
    OpenBricks() = default;
    // `changed`: null: all of them. Requires: a box that is not empty.
    OpenBricks(const Box3& box, double step, const std::span<const ChangedStretch>* changed)
        : low_(brick_of(cell_at(box.low, step))) {
        const BrickPlace high = brick_of(cell_at(box.high, step));
        for (std::size_t axis = 0; axis < 3; ++axis) size_[axis] = high[axis] - low_[axis] + 1;
        open_.reserve(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2]);
        for (std::int32_t k = 0; k < size_[2]; ++k) {
            for (std::int32_t j = 0; j < size_[1]; ++j) {
                for (std::int32_t i = 0; i < size_[0]; ++i) {
                    const Box3 reach = reach_of({low_[0] + i, low_[1] + j, low_[2] + k}, step);
                    open_.push_back(changed == nullptr || is_touched(reach, *changed));
                    if (open_.back() == 0) continue;
                    box_.extend(reach.low);
                    box_.extend(reach.high);
                }
            }
        }
    }

    bool is_open(BrickPlace brick) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            brick[axis] -= low_[axis];
            if (brick[axis] < 0 || brick[axis] >= size_[axis]) return false;
        }
        return open_[(static_cast<std::size_t>(brick[2]) * size_[1] + brick[1]) * size_[0] + brick[0]] != 0;
    }
    const Box3& box() const { return box_; }  // that they depend on; empty where none is open

  private:
    BrickPlace low_{}, size_{};
    std::vector<std::uint8_t> open_;
    Box3 box_;
};

// The surface of one structure, followed from cell to cell.
class SurfaceFollower {
  public:
    SurfaceFollower(const ContourSet& set, const StructureField& field, std::uint32_t structure, double step,
                    RunContext& context)
        : set_(set), field_(field), structure_(structure), step_(step), context_(context) {}

    // `earlier`: null, or what is taken over where bricks are not touched.
    Result<PreviewSurface::Patches> run(const PreviewSurface::Patches* earlier,
                                        std::span<const ChangedStretch> changed, std::uint64_t max_cells,
                                        PreviewStats& stats);

  private:
    std::vector<Cell> seeds(const PreviewSurface::Patches& kept, NodeLattice& nodes) const;
    void follow(std::vector<Cell> wave, NodeLattice& nodes);
    PreviewPatch patch(std::span<const Cell> cells, NodeLattice& nodes) const;

    const ContourSet& set_;
    const StructureField& field_;
    std::uint32_t structure_;
    double step_;
    RunContext& context_;
    OpenBricks open_;
    std::vector<Cell> crossed_;  // that the surface crosses, in bricks that are made
};

// The cells about those that contours run through, because the surface may pass beside them; and cells beside those of
// bricks that are kept.
std::vector<Cell> SurfaceFollower::seeds(const PreviewSurface::Patches& kept, NodeLattice& nodes) const {
    std::vector<Cell> found;
    const auto add = [&](Cell cell) {
        if (open_.is_open(brick_of(cell)) && nodes.visit(cell)) found.push_back(cell);
    };
    const Box3 box = open_.box().grown(2 * step_);
    Cell last{};
    for (const Contour& contour : set_.contours) {
        if (contour.structure != structure_) continue;
        const auto points = set_.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n) {
            const Vec3 from = points[n], way = points[(n + 1) % points.size()] - from;
            Box3 segment;
            segment.extend(from);
            segment.extend(from + way);
            if (!meet(box, segment)) continue;
            const double parts = std::ceil(length(way) / (seed_share * step_));
            for (double part = 0; part < parts; ++part) {
                const Cell cell = cell_at(from + (part / parts) * way, step_);
                if (n + part > 0 && cell == last) continue;
                last = cell;
                for (std::int32_t i = -1; i <= 1; ++i)
                    for (std::int32_t j = -1; j <= 1; ++j)
                        for (std::int32_t k = -1; k <= 1; ++k) add({cell[0] + i, cell[1] + j, cell[2] + k});
            }
        }
    }
    for (const auto& [brick, patch] : kept) {
        for (const Cell& cell : patch->cells) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                for (const int side : {-1, 1}) {
                    Cell beside = cell;
                    beside[axis] += side;
                    if (brick_of(beside) != brick) add(beside);
                }
            }
        }
    }
    return found;
}

// Wave by wave, so that the values of a wave are asked for at once.
void SurfaceFollower::follow(std::vector<Cell> wave, NodeLattice& nodes) {
    while (!wave.empty() && !context_.cancelled()) {
        nodes.ask(wave, field_, structure_, context_.threads);
        std::vector<Cell> next;
        for (const Cell& cell : wave) {
            const unsigned inside = nodes.inside_corners(cell);
            if (inside == 0 || inside == 0xFF) continue;
            crossed_.push_back(cell);
            for (unsigned side = 0; side < 6; ++side) {
                const unsigned corners = inside & face_corners[side];
                if (corners == 0 || corners == face_corners[side]) continue;
                Cell beside = cell;
                beside[side / 2] += side % 2 ? 1 : -1;
                if (open_.is_open(brick_of(beside)) && nodes.visit(beside)) next.push_back(beside);
            }
        }
        wave = std::move(next);
    }
}

PreviewPatch SurfaceFollower::patch(std::span<const Cell> cells, NodeLattice& nodes) const {
    PreviewPatch made;
    made.cells.assign(cells.begin(), cells.end());
    std::map<Cell, std::uint32_t> vertex_of;
    const auto vertex = [&](Cell cell) {
        const auto [entry, is_new] =
            vertex_of.try_emplace(cell, static_cast<std::uint32_t>(made.points.size()));
        if (is_new) {
            const NodeLattice::Vertex found = nodes.vertex(cell, field_, structure_);
            made.points.push_back(found.at);
            made.normals.push_back(found.normal);
        }
        return entry->second;
    };
    for (const Cell& cell : cells) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            // From the cell's lowest corner along the axis.
            const unsigned inside = nodes.inside_corners(cell);
            const bool low = inside & 1u, high = inside & (1u << (1u << axis));
            if (low == high) continue;
            const std::size_t across = (axis + 1) % 3, up = (axis + 2) % 3;
            const auto around = [&](int right, int above) {
                Cell at = cell;
                at[across] -= 1 - right;
                at[up] -= 1 - above;
                return vertex(at);
            };
            std::array<std::uint32_t, 4> quad{around(0, 0), around(1, 0), around(1, 1), around(0, 1)};
            if (!low) std::swap(quad[1], quad[3]);
            made.triangles.push_back({quad[0], quad[1], quad[2]});
            made.triangles.push_back({quad[0], quad[2], quad[3]});
        }
    }
    return made;
}

Result<PreviewSurface::Patches> SurfaceFollower::run(const PreviewSurface::Patches* earlier,
                                                     std::span<const ChangedStretch> changed,
                                                     std::uint64_t max_cells, PreviewStats& stats) {
    PreviewSurface::Patches patches;
    // Beyond this box the structure is nowhere, but its contours may lie on the rim.
    Box3 box = field_.box_of(structure_);
    for (const Contour& contour : set_.contours) {
        if (contour.structure != structure_) continue;
        for (const Vec3& p : set_.points_of(contour)) box.extend(p);
    }
    if (box.empty()) return patches;
    ANATOMESH_CHECK_STATUS(NodeLattice::check_size(box.grown(2 * brick_cells * step_), step_, max_cells));
    open_ = OpenBricks(box.grown(step_), step_, earlier != nullptr ? &changed : nullptr);
    if (earlier != nullptr) {
        for (const auto& [brick, patch] : *earlier)
            if (!is_touched(reach_of(brick, step_), changed)) patches.emplace(brick, patch);
        stats.bricks_taken += patches.size();
    }
    if (open_.box().empty()) return patches;
    ANATOMESH_TRY(NodeLattice nodes, NodeLattice::over(open_.box(), step_, max_cells));
    follow(seeds(patches, nodes), nodes);
    if (context_.cancelled()) return cancelled_error();
    std::map<BrickPlace, std::vector<Cell>> by_brick;
    std::sort(crossed_.begin(), crossed_.end());
    for (const Cell& cell : crossed_) by_brick[brick_of(cell)].push_back(cell);
    for (const auto& [brick, cells] : by_brick)
        patches[brick] = std::make_shared<const PreviewPatch>(patch(cells, nodes));
    stats.bricks_made += by_brick.size();
    stats.values += nodes.values();
    return patches;
}

}  // namespace

Result<PreviewSurface> make_preview(const ContourSet& set, const StructureField& field,
                                    const PreviewOptions& options, RunContext& context, PreviewStats* stats,
                                    const PreviewSurface* earlier, std::span<const ChangedStretch> changed) {
    assert(options.step_mm >= 0.05 && options.step_mm <= 100 && options.max_cells >= 1);
    assert(earlier == nullptr ||
           (earlier->structures.size() == set.structures.size() && earlier->step_mm == options.step_mm));
    PreviewStats counted;
    PreviewSurface made;
    made.step_mm = options.step_mm;
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        SurfaceFollower follower(set, field, s, options.step_mm, context);
        ANATOMESH_TRY(PreviewSurface::Patches patches,
                      follower.run(earlier != nullptr ? &earlier->structures[s] : nullptr, changed,
                                   options.max_cells, counted));
        made.structures.push_back(std::move(patches));
    }
    if (stats != nullptr) *stats = counted;
    return made;
}

}  // namespace anatomesh
