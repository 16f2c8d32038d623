#include "anatomesh/contour/walls/share_walls.h"

#include <cmath>
#include <string>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/plural.h"

namespace anatomesh {

namespace {

// How much a step changed, and where most.
template <class Stats>
std::string extent_of(const Stats& stats) {
    return counted(stats.contours_changed, "contour") + " on " + counted(stats.slices, "slice") + ", " +
           significant_text(stats.area_mm2, 3) + " mm2 changed";
}
template <class Stats>
Place worst_place(const ContourSet& kept, const Stats& stats, const char* measure) {
    return {kept.source, kept.slices[stats.worst_slice].name, "", "",
            "at most " + significant_text(stats.widest_mm, 3) + " " + measure};
}

// Shares lines that differ by what a hand or a file rounded away.
void share_copied_lines(ContourSet& kept, double width_mm, RunContext& context) {
    MergeCoincidentOptions sharing;
    sharing.width_mm = width_mm;
    const MergeCoincidentStats stats = merge_coincident(kept, sharing);
    if (!(stats.widest_mm > 0)) return;
    context.warn({"W-CON-027",
                  counted(stats.vertices_moved, "vertex", "vertices") +
                      " moved onto a neighbouring structure and " +
                      counted(stats.vertices_taken, "vertex", "vertices") +
                      " copied from one, where contours of different structures are less than " +
                      significant_text(stats.width_mm, 3) + " mm apart: " + extent_of(stats),
                  worst_place(kept, stats, "mm"),
                  "these structures share their boundary there; --same-line 0 keeps the contours as drawn"});
}

// Closes the slivers of walls that were drawn once for each of the structures that share them.
void close_slivers_between(ContourSet& kept, double width_mm, RunContext& context) {
    CloseSliversOptions closing;
    closing.width_mm = width_mm;
    const ConflationStats stats = close_slivers(kept, closing);
    if (stats.contours_changed == 0) return;
    context.warn(
        {"W-CON-028",
         "contours of neighbouring structures cross repeatedly, with gaps and overlaps narrower than " +
             plain_text(width_mm) + " mm and " + plain_text(std::round(100 * closing.share_of_segment)) +
             " % of their segments: " + extent_of(stats),
         worst_place(kept, stats, "mm wide"),
         "they share their boundary there, through the vertices of both; no vertex was moved; "
         "--close-slivers 0 "
         "keeps the contours as drawn"});
}

// Closes gaps of less than a pixel between neighbouring structures.
void close_narrow_gaps(ContourSet& kept, double width_mm, RunContext& context) {
    const ConflationStats stats = close_gaps(kept, {width_mm});
    if (stats.contours_changed == 0) return;
    context.warn({"W-CON-025",
                  "gaps and overlaps below " + plain_text(width_mm) +
                      " mm lie between contours of neighbouring structures: " + extent_of(stats),
                  worst_place(kept, stats, "mm wide"),
                  "they share their boundary there, through the vertices of both; crossing slices may then "
                  "disagree; without "
                  "--close-gaps the contours stay as drawn"});
}

}  // namespace

void share_walls(ContourSet& kept, const WallOptions& options, RunContext& context) {
    share_copied_lines(kept, options.same_line_mm, context);
    close_slivers_between(kept, options.close_slivers_mm, context);
    close_narrow_gaps(kept, options.close_gaps_mm, context);
}

}  // namespace anatomesh
