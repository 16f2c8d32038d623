#include "anatomesh/field/motion/aligned_outlines.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/field/motion/outlines.h"

namespace anatomesh {

namespace {

// Outlines of which a motion carries a smaller share amiss move well as they are.
// [1, of the area; > 0; M 2026-11 oblique tubes, seven data sets with slices left out]
constexpr double least_amiss = 0.05;
// A map must leave less of what is amiss. [1, of what is amiss; 0 to 1; M 2026-11 as least_amiss]
constexpr double most_left = 0.5;
// Outlines that differ more after their map are not one shape: aligning them predicts slices left out worse.
// [1, of the area; > 0; M 2026-11 as least_amiss]
constexpr double most_unlike = 0.15;
// The usual search follows shorter moves. [gaps; > 0; M 2026-11 as least_amiss]
constexpr double least_move = 1.75;
// Sections of one tube are not much further apart than where they touch. [1, of the way; >= 1; M 2026-11 tubes]
constexpr double farthest_apart = 1.1;
// Sections of one tube do not become longer or shorter by more. [1, a factor; > 1; C]
constexpr double most_stretched = 2;

// Centre and second central moments of what an outline encloses, for a unit of area.
struct Moments {
    Vec2 centre;
    double xx = 0, xy = 0, yy = 0;

    double root_of_determinant() const { return std::sqrt(xx * yy - xy * xy); }
    // How far the ellipse of these moments reaches from its centre in a direction of unit length.
    double reach(Vec2 d) const { return 2 * std::sqrt(xx * d.x * d.x + 2 * xy * d.x * d.y + yy * d.y * d.y); }
};

Moments moments_of(const Outlines& outlines, const Outline& outline) {
    const Vec2 origin = 0.5 * (outline.box.low + outline.box.high);
    double area = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    outlines.each_piece(outline, [&](std::uint32_t, const BoundaryPiece& piece) {
        const Vec2 a = piece.a - origin, b = piece.b - origin;
        const double twice = cross(a, b);
        area += twice / 2;
        x += twice * (a.x + b.x) / 6;
        y += twice * (a.y + b.y) / 6;
        xx += twice * (a.x * a.x + a.x * b.x + b.x * b.x) / 12;
        yy += twice * (a.y * a.y + a.y * b.y + b.y * b.y) / 12;
        xy += twice * (2 * a.x * a.y + a.x * b.y + b.x * a.y + 2 * b.x * b.y) / 24;
    });
    x /= area;
    y /= area;
    return {origin + Vec2{x, y}, xx / area - x * x, xy / area - x * y, yy / area - y * y};
}

// Its matrix is the geometric mean of the inverse of the moments of `a` and of those of `b`.
OutlineMap map_between(const Moments& a, const Moments& b, std::uint32_t other) {
    const double alpha = 1 / a.root_of_determinant(), beta = b.root_of_determinant();
    const double xx = a.yy * alpha + b.xx / beta, xy = b.xy / beta - a.xy * alpha,
                 yy = a.xx * alpha + b.yy / beta;
    const double scale = std::sqrt(alpha * beta / (xx * yy - xy * xy));
    return {other, a.centre, b.centre, scale * xx, scale * xy, scale * yy};
}

// False as well where one has no area, and so no number.
bool stretches_little(const OutlineMap& map) {
    const double mean = 0.5 * (map.xx + map.yy), off = std::hypot(0.5 * (map.xx - map.yy), map.xy);
    return mean + off <= most_stretched && mean - off >= 1 / most_stretched;
}

double amiss_share(const Outlines& outlines, const Outline& outline, const DistanceMap& other,
                   const OutlineMap& map) {
    double sum = 0;
    outlines.each_piece(outline, [&](std::uint32_t, const BoundaryPiece& piece) {
        sum += piece.length * std::abs(other.value(map(piece.middle())));
    });
    return sum / std::abs(outline.area);
}

// Two outlines of one shape.
struct Partners {
    std::uint32_t below, above;
    double apart;  // the way between the centres as a share of that at which the two touch
    double move;   // that way, mm
    double unlike;
    OutlineMap up, down;
};

class Alignment {
  public:
    Alignment(const CarriedSlice& below, const CarriedSlice& above)
        : below_(below),
          above_(above),
          lower_(below.boundary),
          upper_(above.boundary),
          of_lower_(lower_.size(), no_piece),
          of_upper_(upper_.size(), no_piece) {
        find_pairs();
        for (std::uint32_t n = 0; n < pairs_.size(); ++n) {
            if (!is_nearest(pairs_[n])) continue;
            of_lower_[pairs_[n].below] = of_upper_[pairs_[n].above] = n;
        }
        while (part_at_branches()) {
        }
    }

    AlignedOutlines result(double gap) const {
        AlignedOutlines aligned;
        for (std::uint32_t n = 0; n < pairs_.size(); ++n) {
            const Partners& pair = pairs_[n];
            const double amiss = std::max(below_.amiss[pair.below], above_.amiss[pair.above]);
            const bool is_better = amiss > least_amiss && pair.unlike < most_left * amiss;
            if (of_lower_[pair.below] != n || !is_better || pair.move < least_move * gap) continue;
            aligned.below.resize(lower_.size());
            aligned.above.resize(upper_.size());
            aligned.below[pair.below] = pair.up;
            aligned.above[pair.above] = pair.down;
        }
        return aligned;
    }

  private:
    void find_pairs() {
        std::vector<Moments> lower, upper;
        for (std::uint32_t i = 0; i < lower_.size(); ++i) lower.push_back(moments_of(lower_, lower_[i]));
        for (std::uint32_t j = 0; j < upper_.size(); ++j) upper.push_back(moments_of(upper_, upper_[j]));
        for (std::uint32_t i = 0; i < lower_.size(); ++i) {
            for (std::uint32_t j = 0; j < upper_.size(); ++j) {
                if ((lower_[i].area > 0) != (upper_[j].area > 0)) continue;
                const Vec2 way = upper[j].centre - lower[i].centre;
                const double move = length(way);
                const Vec2 along = move > 0 ? (1 / move) * way : Vec2{1, 0};
                const double apart = move / (lower[i].reach(along) + upper[j].reach(along));
                if (!(apart <= farthest_apart)) continue;
                Partners pair{i,
                              j,
                              apart,
                              move,
                              0,
                              map_between(lower[i], upper[j], j),
                              map_between(upper[j], lower[i], i)};
                if (!stretches_little(pair.up)) continue;
                pair.unlike = std::max(amiss_share(lower_, lower_[i], above_.map, pair.up),
                                       amiss_share(upper_, upper_[j], below_.map, pair.down));
                if (pair.unlike < most_unlike) pairs_.push_back(pair);
            }
        }
    }

    bool is_nearest(const Partners& pair) const {
        return std::none_of(pairs_.begin(), pairs_.end(), [&](const Partners& other) {
            return &other != &pair && (other.below == pair.below || other.above == pair.above) &&
                   other.apart <= pair.apart;
        });
    }

    // Whether an outline of `others` without a partner overlaps this one.
    static bool is_shared(const Outlines& outlines, const Outline& outline, const Outlines& others,
                          const std::vector<std::uint32_t>& of_others) {
        for (std::uint32_t k = 0; k < others.size(); ++k) {
            if (of_others[k] != no_piece || !are_near(outline, others[k])) continue;
            if (share_within(outlines, outline, others, others[k]) != Share::none ||
                share_within(others, others[k], outlines, outline) != Share::none)
                return true;
        }
        return false;
    }

    // Parts what overlaps a third outline; then others may do.
    bool part_at_branches() {
        bool parted = false;
        for (std::uint32_t n = 0; n < pairs_.size(); ++n) {
            const Partners& pair = pairs_[n];
            if (of_lower_[pair.below] != n) continue;
            if (!is_shared(lower_, lower_[pair.below], upper_, of_upper_) &&
                !is_shared(upper_, upper_[pair.above], lower_, of_lower_))
                continue;
            of_lower_[pair.below] = of_upper_[pair.above] = no_piece;
            parted = true;
        }
        return parted;
    }

    const CarriedSlice &below_, &above_;
    Outlines lower_, upper_;
    std::vector<Partners> pairs_;
    std::vector<std::uint32_t> of_lower_, of_upper_;  // the pair of each outline; no_piece: none
};

}  // namespace

std::vector<double> amiss_shares(const Boundary& boundary, const DistanceMap& other,
                                 std::span<const Vec2> carried) {
    const Outlines outlines(boundary);
    std::vector<double> shares(boundary.outlines, 0);
    for (std::uint32_t p = 0; p < boundary.pieces.size(); ++p)
        shares[boundary.outline[p]] += boundary.pieces[p].length * std::abs(other.value(carried[p]));
    for (std::uint32_t n = 0; n < boundary.outlines; ++n) shares[n] /= std::abs(outlines[n].area);
    return shares;
}

AlignedOutlines aligned_outlines(const CarriedSlice& below, const CarriedSlice& above, double gap) {
    const auto any_amiss = [](const CarriedSlice& slice) {
        return std::any_of(slice.amiss.begin(), slice.amiss.end(),
                           [](double share) { return share > least_amiss; });
    };
    if (!any_amiss(below) && !any_amiss(above)) return {};
    return Alignment(below, above).result(gap);
}

}  // namespace anatomesh
