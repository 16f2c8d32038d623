#include <algorithm>
#include <array>
#include <vector>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/sections/section_operations.h"

namespace anatomesh {

namespace {

// Heights of a moved vertex over the plane, in mean lengths of the edges at it.
// [1; -1 to 1; M 2026-11, set not recorded]
constexpr std::array height_shares{0.05, -0.05, 0.1, -0.1, 0.2, -0.2, 0.35, -0.35};

class PlaneCrossingMove {
  public:
    PlaneCrossingMove(SectionEdit& section, std::uint32_t v)
        : section_(section), edit_(section.edit), v_(v), from_(edit_.mesh.point(v)) {}

    bool run(const CellBounds& bounds) {
        const bool again = edit_.constraints.settled(v_);
        if (edit_.constraints.fixed(v_) && !again) return false;
        edit_.mesh.star(v_, edit_.star);
        const double before = section_.areas.wrong_round(v_, edit_.star);
        if (!section_.is_worth_it(before)) return false;
        star_ = edit_.star;
        measure_star();
        const QualityThreshold threshold = edit_.threshold_of(star_);
        find_facets();
        begin_ascent(threshold, bounds);
        return section_.areas.any_plane_at(round_, [&](std::uint32_t k) {
            if (!section_.is_worth_it(section_.areas.wrong_round(v_, star_, k))) return false;
            if (!move_to(section_.areas.plane(k), before, bounds)) return false;
            again ? edit_.constraints.fix(v_) : edit_.constraints.settle(v_);
            return true;
        });
    }

  private:
    // A facet between regions at the vertex: its other corners, and how far it may be from the field's.
    struct Facet {
        Vec3 b, c;
        Region here, there;
        double most;
    };

    // The vertices of the star, and the mean length of the edges at the vertex.
    void measure_star() {
        double edges = 0;
        std::size_t count = 0;
        for (const std::uint32_t c : star_) {
            for (const std::uint32_t u : edit_.mesh.cell(c)) {
                round_.push_back(u);
                if (u == v_) continue;
                edges += length(edit_.mesh.point(u) - from_);
                ++count;
            }
        }
        sort_distinct(round_);
        edge_ = edges / static_cast<double>(count);
    }

    void find_facets() {
        for (const std::uint32_t c : star_) {
            const Cell& cell = edit_.mesh.cell(c);
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t n = edit_.mesh.neighbor(c, i);
                if (cell[i] == v_ || n == no_cell || n < c || edit_.mesh.region(n) == edit_.mesh.region(c))
                    continue;
                const auto [u, w] = others_of_facet(cell, i, v_);
                const Region here = edit_.mesh.region(c), there = edit_.mesh.region(n);
                edit_.look_between(here, there);
                const Vec3 b = edit_.mesh.point(u), d = edit_.mesh.point(w);
                facets_.push_back(
                    {b, d, here, there, std::max(edit_.facet_distance(from_, b, d), edit_.options.spike_mm)});
            }
        }
    }

    void begin_ascent(const QualityThreshold& threshold, const CellBounds& bounds) {
        edit_.scratch.local.reset(edit_.rule.needed_outside_sine(threshold), bounds.ratio * bounds.ratio);
        for (const std::uint32_t c : star_) {
            const Cell& cell = edit_.mesh.cell(c);
            const auto& f = facet_vertices[std::find(cell.begin(), cell.end(), v_) - cell.begin()];
            edit_.scratch.local.add(edit_.mesh.point(cell[f[0]]), edit_.mesh.point(cell[f[1]]),
                                    edit_.mesh.point(cell[f[2]]), edit_.mesh.region(c) != 0);
        }
    }

    bool move_to(const Plane& plane, double before, const CellBounds& bounds) {
        const auto near = [&](Vec3& q) { return keeps_near(q); };
        for (const double share : height_shares) {
            Vec3 p = from_ + (share * edge_ - plane.signed_distance(from_)) * plane.normal;
            if (!near(p)) continue;
            if (edit_.scratch.local.ascend(p, edit_.scratch.local.worst(p, -2), edit_.goal, plane.normal,
                                           near) < bounds.sine)
                continue;
            edit_.mesh.move_point(v_, p);
            if (edit_.positive(star_) &&
                SectionEdit::is_enough(section_.areas.wrong_round(v_, star_), before)) {
                edit_.changed = star_;
                return true;
            }
            edit_.mesh.move_point(v_, from_);
        }
        return false;
    }

    bool keeps_near(Vec3 q) {
        return std::all_of(facets_.begin(), facets_.end(), [&](const Facet& f) {
            edit_.look_between(f.here, f.there);
            return edit_.facet_distance(q, f.b, f.c) <= f.most;
        });
    }

    SectionEdit& section_;
    EditContext& edit_;
    std::uint32_t v_;
    Vec3 from_;
    double edge_ = 0;  // mean length of the edges at the vertex
    std::vector<std::uint32_t> star_, round_;
    std::vector<Facet> facets_;
};

}  // namespace

bool move_across_plane(SectionEdit& section, std::uint32_t v, const CellBounds& bounds) {
    return PlaneCrossingMove(section, v).run(bounds);
}

}  // namespace anatomesh
