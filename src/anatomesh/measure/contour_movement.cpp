#include "anatomesh/measure/contour_movement.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <limits>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/point_triangle.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

// So many segments share a box, which tells whether one can be nearer. [segments; >= 1; B]
constexpr std::uint32_t block_size = 16;

struct Nearest {
    double distance_mm = std::numeric_limits<double>::infinity();
    std::uint32_t contour = 0;
};

double distance_from(const Box3& box, Vec3 p) {
    const auto beyond = [](double low, double high, double x) { return std::max({low - x, 0.0, x - high}); };
    return length(Vec3{beyond(box.low.x, box.high.x, p.x), beyond(box.low.y, box.high.y, p.y),
                       beyond(box.low.z, box.high.z, p.z)});
}

// The contours of one structure on one slice.
class Outlines {
  public:
    Outlines(const ContourSet& set, std::uint32_t slice, std::uint32_t structure) : set_(set) {
        const Slice& own = set.slices[slice];
        for (std::uint32_t c = own.first_contour; c < own.first_contour + own.contour_count; ++c) {
            const Contour& contour = set.contours[c];
            if (contour.structure != structure) continue;
            contours_.push_back(c);
            const std::uint32_t end = contour.first_point + contour.point_count;
            for (std::uint32_t first = contour.first_point; first < end; first += block_size) {
                Block block{c, first, std::min(block_size, end - first), {}};
                for (std::uint32_t k = first; k < first + block.count; ++k) {
                    block.box.extend(set.points[k]);
                    points_.push_back(set.points[k]);
                }
                block.box.extend(set.points[point_after(contour, first + block.count - 1)]);
                blocks_.push_back(block);
            }
        }
        std::sort(points_.begin(), points_.end(), LexicographicLess{});
    }

    const std::vector<std::uint32_t>& contours() const { return contours_; }

    bool has_vertex(Vec3 p) const {
        return std::binary_search(points_.begin(), points_.end(), p, LexicographicLess{});
    }

    Nearest nearest(Vec3 p) const {
        Nearest found;
        for (const Block& block : blocks_) {
            if (distance_from(block.box, p) >= found.distance_mm) continue;
            for (std::uint32_t k = block.first; k < block.first + block.count; ++k) {
                const std::uint32_t next = point_after(set_.contours[block.contour], k);
                const double distance = point_segment_distance(p, set_.points[k], set_.points[next]);
                if (distance < found.distance_mm) found = {distance, block.contour};
            }
        }
        return found;
    }

  private:
    struct Block {
        std::uint32_t contour, first, count;
        Box3 box;
    };

    const ContourSet& set_;
    std::vector<std::uint32_t> contours_;
    std::vector<Block> blocks_;
    std::vector<Vec3> points_;  // sorted
};

class Movement {
  public:
    Movement(const ContourSet& drawn, const ContourSet& kept)
        : drawn_(drawn), kept_(kept), is_moved_(drawn.contours.size(), false) {
        result_.bound_mm =
            contract::moved_share_of_spacing * plane_spacings(drawn, plane_patches(drawn)).median;
        result_.contours = drawn.contours.size();
        result_.vertices = drawn.points.size();
    }

    ContourMovementReport run() {
        for (std::uint32_t slice = 0; slice < drawn_.slices.size(); ++slice) {
            for (std::uint32_t s = 0; s < drawn_.structures.size(); ++s) {
                const Outlines before(drawn_, slice, s), after(kept_, slice, s);
                look_at(drawn_, before, after, true);
                look_at(kept_, after, before, false);
            }
        }
        result_.contours_moved +=
            static_cast<std::uint64_t>(std::count(is_moved_.begin(), is_moved_.end(), true));
        return std::move(result_);
    }

  private:
    // How far the contours of `set` are from the others.
    void look_at(const ContourSet& set, const Outlines& own, const Outlines& others, bool is_drawn) {
        for (const std::uint32_t c : own.contours()) {
            const auto points = set.points_of(set.contours[c]);
            Box3 box;
            for (const Vec3& p : points) box.extend(p);
            const bool is_alone = others.contours().empty();
            bool any = false;
            for (const Vec3& p : points) {
                if (others.has_vertex(p)) continue;
                const Nearest nearest = is_alone ? Nearest{0.5 * box.diagonal(), 0} : others.nearest(p);
                take(set, c, nearest.distance_mm);
                if (!(nearest.distance_mm > result_.bound_mm)) continue;
                any = true;
                if (is_drawn) {
                    ++result_.vertices_moved;
                    is_moved_[c] = true;
                } else if (!is_alone) {
                    is_moved_[nearest.contour] = true;
                }
            }
            // One that came is none of the drawn ones.
            if (!is_drawn && is_alone && any) ++result_.contours_moved;
        }
    }

    void take(const ContourSet& set, std::uint32_t contour, double distance_mm) {
        if (distance_mm <= result_.farthest_mm) return;
        result_.farthest_mm = distance_mm;
        const Structure& structure = set.structures[set.contours[contour].structure];
        result_.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
        result_.slice = set.slices[set.contours[contour].slice].name;
    }

    const ContourSet &drawn_, &kept_;
    std::vector<bool> is_moved_;  // by drawn contour
    ContourMovementReport result_;
};

}  // namespace

ContourMovementReport contour_movement(const ContourSet& drawn, const ContourSet& kept) {
    assert(drawn.slices.size() == kept.slices.size() && drawn.structures.size() == kept.structures.size());
    return Movement(drawn, kept).run();
}

}  // namespace anatomesh
