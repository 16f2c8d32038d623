#include "anatomesh/improve/surgery/carve_cuts.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/cell_judge.h"
#include "anatomesh/improve/core/sides_at.h"
#include "anatomesh/improve/core/surface_count.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/surgery/section_patches.h"
#include "anatomesh/improve/surgery/thicken_sheet.h"

namespace anatomesh {

namespace {

constexpr double worth_a_patch = 5e-5;            // share of what is drawn that is wrong
constexpr double enough_less = 0.5;               // of a patch
constexpr std::size_t most_cuts = 60;             // where more are wrong, slices contradict each other
constexpr std::size_t most_carved_in_vain = 100;  // ways to carve whose cells are worked on in vain
// Cells worked on where planes cross, of one cut and of all: much more would be in vain.
constexpr std::size_t most_cells_of_cut = 5'000, most_cells_across = 20'000;
constexpr std::size_t most_tried = 1000;   // ways, sound or not
constexpr std::size_t most_of_crumb = 64;  // cells, as in crumbs.h
constexpr std::array nearness{0.25, 0.0};  // of a vertex that is taken for one of the patch, in edges
// Of a sheet, as shares of the edges that lead off it; the last one not where planes cross, for there all
// cuts together have only so many tries.
constexpr std::array carved_thicknesses{0.5, 0.3, 0.15, 0.7};

constexpr std::array carved_reaches{SheetReach::wide, SheetReach::joined, SheetReach::near,
                                    SheetReach::others};

class Carver {
  public:
    Carver(Workbench& bench, const DrawnSlices& drawn, double least_sine, const ImproveCells& improve,
           const RunContext& context)
        : bench_(bench),
          context_(context),
          drawn_(drawn),
          areas_(bench, drawn),
          sides_(bench),
          least_sine_(least_sine),
          improve_(improve) {}

    CarveStats run(const std::vector<std::uint32_t>* look) {
        if (look) {
            std::vector<std::uint32_t> cells = *look;
            std::erase_if(cells, [&](std::uint32_t c) { return !bench_.mesh.alive(c); });
            areas_.sum_cuts_round(cells);
            const auto is_fine = [](double sum) { return sum <= much_of_cut; };
            if (std::all_of(areas_.sums().begin(), areas_.sums().end(), is_fine)) return {};
        }
        sums_ = sums();
        std::vector<std::size_t> cuts;
        for (std::size_t cut = 0; cut < sums_.size(); ++cut) {
            if (sums_[cut] > much_of_cut) cuts.push_back(cut);
        }
        if (cuts.size() > most_cuts) return {};
        std::stable_sort(cuts.begin(), cuts.end(),
                         [&](std::size_t a, std::size_t b) { return sums_[a] > sums_[b]; });
        shapes_.emplace(bench_, drawn_, least_sine_);
        for (const std::size_t cut : cuts) carve_cut(cut);
        return std::move(stats_);
    }

  private:
    // Of a structure, or of what is outside it: of what a patch is of. Parts that facets join, and of these
    // such that no contour of the structure has a vertex of.
    struct Pieces {
        std::size_t all = 0, bare = 0;
        std::vector<std::vector<std::uint32_t>>
            crumbs;  // of the bare ones small ones with a new vertex: cells
    };

    // How a patch is carved: the share of edges within which a vertex is taken for one of the patch, and as
    // thicken_sheet() has it.
    struct Way {
        double near;
        SheetReach reach;
        double thickness;
    };

    enum class Outcome { done, unsound, bad };

    // What is wrong, by cuts.
    std::vector<double> sums() {
        areas_.sum_cuts(bench_.mesh.alive_cells());
        return {areas_.sums().begin(), areas_.sums().end()};
    }

    // First what leaves the structure in one part.
    void carve_cut(std::size_t cut) {
        pieces_ = {};
        before_cut_ = worked_on_;
        while (sums_[cut] > much_of_cut && carve_one(cut, false)) {
        }
        while (sums_[cut] > most_of_cut && carve_one(cut, true)) {
        }
    }

    // One patch: that changes the cells of others.
    bool carve_one(std::size_t cut, bool may_part) {
        const auto structure = static_cast<std::uint32_t>(cut / drawn_.planes.size()),
                   plane = static_cast<std::uint32_t>(cut % drawn_.planes.size());
        for (const SectionPatch& patch : find_patches(bench_, areas_, structure, plane)) {
            if (patch.wrong < worth_a_patch || is_enough()) break;
            ++stats_.patches_found;
            for (const bool has : {false, true}) pieces_before(patch, has);
            if (!carve(patch, cut, may_part)) continue;
            ++stats_.patches_carved;
            pieces_ = {};
            return true;
        }
        return false;
    }

    // Whether the patch is of the structure; it goes to the other side.
    bool is_inside(const SectionPatch& patch) const {
        return bench_.table->contains(patch.own, patch.structure);
    }

    // Of the structure, or of what is outside it.
    Pieces pieces_beside(const SectionPatch& patch, bool has, std::uint32_t first_new = no_cell) const {
        std::vector<std::uint8_t> seen(bench_.mesh.cell_count(), 0);
        const auto take = [&](std::uint32_t c) {
            if (c == no_cell || seen[c] || !bench_.mesh.alive(c) ||
                bench_.table->contains(bench_.mesh.region(c), patch.structure) != has)
                return false;
            seen[c] = 1;
            return true;
        };
        const auto is_drawn = [&](std::uint32_t v) { return drawn_.owners->has(v, patch.structure); };
        Pieces pieces;
        for (std::uint32_t seed = 0; seed < bench_.mesh.cell_count(); ++seed) {
            if (!take(seed)) continue;
            bool bare = true, made = false;
            std::vector<std::uint32_t> cells{seed};
            for (std::size_t n = 0; n < cells.size(); ++n) {
                const Cell& cell = bench_.mesh.cell(cells[n]);
                bare = bare && std::none_of(cell.begin(), cell.end(), is_drawn);
                made = made || std::any_of(cell.begin(), cell.end(), [&](auto v) { return v >= first_new; });
                for (int i = 0; i < 4; ++i) {
                    if (take(bench_.mesh.neighbor(cells[n], i)))
                        cells.push_back(bench_.mesh.neighbor(cells[n], i));
                }
            }
            ++pieces.all;
            pieces.bare += bare;
            if (bare && made && cells.size() <= most_of_crumb) pieces.crumbs.push_back(std::move(cells));
        }
        return pieces;
    }

    // Before the patch is carved.
    const Pieces& pieces_before(const SectionPatch& patch, bool has) {
        std::optional<Pieces>& known = pieces_[has];
        if (!known) known = pieces_beside(patch, has);
        return *known;
    }

    // Where the structure is not parted a handle went, or a tunnel. What came off and no contour has goes
    // too, if it is small, near the field's surface and of no other region; false where more came off than
    // may.
    bool may_be_parted(const SectionPatch& patch, bool may_part, std::uint32_t first_new,
                       std::vector<std::uint32_t>& changed, std::uint64_t& crumbs) {
        const bool has = is_inside(patch);
        Pieces after = pieces_beside(patch, has, first_new);
        const Pieces& before = pieces_before(patch, has);
        for (const std::vector<std::uint32_t>& crumb : after.crumbs) {
            if (after.bare <= before.bare) break;
            if (!give_crumb(crumb, patch)) return false;
            changed.insert(changed.end(), crumb.begin(), crumb.end());
            ++crumbs;
            --after.bare;
            --after.all;
        }
        return after.bare <= before.bare && (after.all <= before.all || may_part);
    }

    // Whether two parts of where it goes, apart before, are one by it: else it made a handle or a tunnel.
    bool joins_parts(const SectionPatch& patch) {
        const bool has = !is_inside(patch);
        return pieces_beside(patch, has).all + 1 == pieces_before(patch, has).all;
    }

    bool give_crumb(const std::vector<std::uint32_t>& crumb, const SectionPatch& patch) {
        const double most = bench_.options.apex_mm;
        bench_.look_between(patch.own, patch.to);
        for (const std::uint32_t c : crumb) {
            if (bench_.mesh.region(c) != patch.own) return false;
            for (const std::uint32_t v : bench_.mesh.cell(c)) {
                if (bench_.probe.distance(bench_.mesh.point(v), most) > most) return false;
            }
        }
        SurfaceCount count(bench_, *drawn_.owners, crumb, patch.to);
        for (const std::uint32_t c : crumb) bench_.mesh.set_region(c, patch.to);
        return count.figures().excess == 0 && count.newly_lost() == 0;
    }

    bool is_enough() const {
        return context_.cancelled() || improved_ >= most_carved_in_vain || tried_ >= most_tried ||
               (!drawn_.extents.empty() &&
                (worked_on_ >= most_cells_across || worked_on_ - before_cut_ >= most_cells_of_cut));
    }

    bool carve(const SectionPatch& patch, std::size_t cut, bool may_part) {
        const std::size_t count = carved_thicknesses.size() - (drawn_.extents.empty() ? 0 : 1);
        farthest_mm_ = farthest_round(patch);
        for (const double near : nearness) {
            for (const SheetReach reach : carved_reaches) {
                for (const double thickness : std::span(carved_thicknesses).first(count)) {
                    const Outcome outcome = attempt(patch, cut, {near, reach, thickness}, may_part);
                    ++tried_;
                    if (outcome == Outcome::done) return true;
                    improved_ += outcome == Outcome::bad;
                    if (is_enough()) return false;
                    if (outcome == Outcome::unsound) break;
                }
            }
        }
        return false;
    }

    Outcome attempt(const SectionPatch& patch, std::size_t cut, const Way& way, bool may_part) {
        const DihedralStats stats = bench_.stats;
        bench_.mesh.begin_attempt();
        const Outcome outcome = change(patch, cut, way, may_part);
        bench_.mesh.end_attempt(outcome == Outcome::done);
        if (outcome != Outcome::done) bench_.stats = stats;
        return outcome;
    }

    Outcome change(const SectionPatch& patch, std::size_t cut, const Way& way, bool may_part) {
        std::uint64_t crumbs = 0;
        const auto first_new = static_cast<std::uint32_t>(bench_.mesh.point_count());
        const Sheet sheet = sheet_of_patch(bench_, areas_, patch, way.near);
        const std::optional<std::uint32_t> end = vertex_on_surface(sheet, patch.structure);
        if (!end) return Outcome::unsound;
        const Chain chain{{*end}, patch.structure};
        const SheetAcross across{SheetSides::both, areas_.plane(patch.plane).normal, patch.to};
        std::optional<ThickenedSheet> made = thicken_sheet(bench_, *drawn_.owners, chain, sheet, patch.own,
                                                           way.reach, way.thickness, nullptr, &across);
        if (!made) return Outcome::unsound;
        std::vector<std::uint32_t> changed = std::move(made->changed);
        if (!made->parted.empty() && !may_be_parted(patch, may_part, first_new, changed, crumbs))
            return Outcome::unsound;
        if (made->joins && (!may_part || !joins_parts(patch))) return Outcome::unsound;
        // Those round the edges that pass through the patch too.
        for (auto v = first_new; v < bench_.mesh.point_count(); ++v) {
            bench_.mesh.star(v, bench_.star);
            changed.insert(changed.end(), bench_.star.begin(), bench_.star.end());
        }
        sort_distinct(changed);
        const std::vector<std::uint32_t> improved = improve_(changed);
        changed.insert(changed.end(), improved.begin(), improved.end());
        sort_distinct(changed);
        worked_on_ += changed.size();
        if (!shapes_->allow(changed, farthest_mm_)) return Outcome::bad;
        std::vector<double> after = sums();
        for (std::size_t other = 0; other < after.size(); ++other) {
            const double gained = enough_less * patch.wrong;
            const double most = other == cut
                                    ? sums_[cut] - gained
                                    : std::max(sums_[other], std::min(sums_[other] + gained, much_of_cut));
            if (after[other] > most) return Outcome::bad;
        }
        stats_.crumbs_given += crumbs;
        shapes_->keep();
        sums_ = std::move(after);
        stats_.changed.insert(stats_.changed.end(), changed.begin(), changed.end());
        return Outcome::done;
    }

    // How far from the field's surfaces lie about the patch now: what is wrong there may be far off.
    double farthest_round(const SectionPatch& patch) {
        std::vector<std::uint32_t> vertices, cells;
        for (const SectionAreas::Section& section : patch.sections) {
            const Cell& cell = bench_.mesh.cell(section.cell);
            vertices.insert(vertices.end(), cell.begin(), cell.end());
        }
        sort_distinct(vertices);
        for (const std::uint32_t v : vertices) {
            bench_.mesh.star(v, bench_.star);
            cells.insert(cells.end(), bench_.star.begin(), bench_.star.end());
        }
        sort_distinct(cells);
        return shapes_->farthest_of(cells);
    }

    // One of the sheet's, of a contour if there is one.
    std::optional<std::uint32_t> vertex_on_surface(const Sheet& sheet, std::uint32_t structure) {
        std::optional<std::uint32_t> found;
        for (const std::uint32_t v : sheet.vertices()) {
            if (!sides_.on_surface(v, structure)) continue;
            if (drawn_.owners->has(v, structure)) return v;
            if (!found) found = v;
        }
        return found;
    }

    Workbench& bench_;
    const RunContext& context_;
    const DrawnSlices& drawn_;
    SectionAreas areas_;
    SidesAt sides_;
    double least_sine_;
    const ImproveCells& improve_;
    std::vector<double> sums_;
    std::array<std::optional<Pieces>, 2> pieces_;  // of what is outside, and of the structure, of this cut
    std::optional<ShapesKept> shapes_;
    double farthest_mm_ = 0;                      // from the field's, that surfaces of this patch may be
    std::size_t improved_ = 0, tried_ = 0;        // ways, the first in vain
    std::size_t worked_on_ = 0, before_cut_ = 0;  // cells; those before this cut
    CarveStats stats_;
};

}  // namespace

CarveStats carve_cuts(Workbench& bench, const DrawnSlices& drawn, double least_sine,
                      const ImproveCells& improve, const RunContext& context,
                      const std::vector<std::uint32_t>* look) {
    if (!drawn.table || !drawn.owners || drawn.planes.empty()) return {};
    return Carver(bench, drawn, least_sine, improve, context).run(look);
}

}  // namespace anatomesh
