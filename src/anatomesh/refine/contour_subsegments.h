// ContourSubsegments: the subsegments in a growing mesh, split until they are edges of it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/refine/labelled_mesh.h"
#include "anatomesh/refine/missing_segments.h"
#include "anatomesh/sample/contour_segments.h"
#include "anatomesh/sample/protected_segments.h"
#include "anatomesh/sample/segment_clusters.h"

namespace anatomesh {

struct ContourSubsegmentOptions {
    // The edge length aimed at: subsegments are split to 0.3 of it, the last few further. > 0.
    double size_mm = 0;
    bool spared = false;      // the last few are left, and those with other contours' vertices in their balls
    bool dense = false;       // the planes lie closer than the contours' vertices
    bool conforming = false;  // they were split beforehand as far as other contours ask: some are short
    bool graded = false;      // beforehand too, but in their slices alone
    bool to_short = true;     // finish() splits to short ones however many are missing, where it may help
    std::size_t last_few = 300;  // shorter ones are split where fewer than one in so many is missing. >= 1
};

// How far subsegments may be split.
struct SplitLimits {
    double shortest = 0;     // no subsegment below so many sizes
    double room = 1;         // a share of its length that other contour vertices keep from its middle
    double clearance = 0;    // and in sizes, its ends too
    bool at_feet = false;    // where such a vertex forbids it, at its foot (foot_on())
    bool few_alone = false;  // not where many are missing, or no fewer than in the round before

    static SplitLimits scaled(double scale);  // 1: wherever a subsegment is to be split; below, the last few
    // Shorter ones, however many are missing, if free vertices alone are in their way.
    static SplitLimits lone();
    // Where planes are dense other contours' vertices nearly always are.
    static SplitLimits among_others();
    static SplitLimits graded();        // those that are missing among short ones, however many
    static SplitLimits beside_short();  // those in whose balls circumcentres of cells at short ones lie
};

// Every insertion into the mesh goes through it, since a point beside a subsegment may ask for its split. A
// subsegment is not split where another contour's vertex lies near its middle: that contour would have to be
// split in its turn, and so on; but, where subsegments were split beforehand, at that vertex's foot
// (foot_on()). Subsegments that meet at acute angles are split on concentric shells. Same result at any
// number of threads. Errors of all that inserts: cancelled; limit E-PIP-003, more regions than there is room
// for. Follows: Shewchuk, Delaunay refinement mesh generation, 1997, chapter 3.
class ContourSubsegments {
  public:
    // `subsegments` between vertices of the mesh. Requires: mesh, protected_segments and field outlive this.
    ContourSubsegments(LabelledMesh& mesh, ProtectedSegments& protected_segments, const StructureField& field,
                       std::vector<Subsegment> subsegments, const ContourSubsegmentOptions& options);

    // Inserts the points, and splits the subsegments with these diametral balls (rising) that may be.
    // Complexity: that of the insertions, and linear in the subsegments.
    Status grow(std::vector<Vec3> found, const std::vector<std::uint32_t>& balls, RunContext& context,
                const SplitLimits& limits = SplitLimits::scaled(1));

    // Splits subsegments that are no edges until all are, or, with a share above 0, fewer than one in so many
    // is missing; a bounded number of rounds.
    Status recover(std::size_t share, RunContext& context,
                   const SplitLimits& limits = SplitLimits::scaled(1));

    // The last few: subsegments that only shorter ones resolve, and subsegments that are edges off their
    // structure's surface.
    Status finish(RunContext& context);

    // Puts points beside the subsegments that are edges off their structure's surface, whose ends are
    // appended to `ends`. Says whether there were any.
    Result<bool> open_sides(RunContext& context, std::vector<std::uint32_t>* ends = nullptr);

    // To be told where the regions of cells are changed from without.
    void regions_changed() { sides_search_ = {}; }

    // Whether there are, or finish() had to make, more than a few short ones: then what lies beside them must
    // follow.
    bool are_short() const { return are_short_; }

    const std::vector<Subsegment>& subsegments() const { return subsegments_; }
    // Where subsegments were split here.
    const std::vector<std::uint32_t>& vertices() const { return vertices_; }
    std::size_t side_points() const {
        return side_points_;
    }  // put beside subsegments off their structure's surface

  private:
    void add_halves(const std::vector<Subsegment>& split, const std::vector<std::uint32_t>& middles);
    // How near another vertex may be to where a subsegment is split.
    double room_of(const Subsegment& subsegment, const SplitLimits& limits) const;
    void keep_apart(std::vector<Subsegment>& split, std::vector<Subsegment>& kept,
                    const SplitLimits& limits) const;
    bool may_split(const Subsegment& subsegment, const SplitLimits& limits) const;
    // The vertex where subsegments meet at acute angles from which this one comes, if it comes from one.
    std::optional<Vec3> apex_of(const Subsegment& subsegment) const;
    Vec3 split_place(const Subsegment& subsegment) const;
    // Where the subsegment is split, if it may be.
    std::optional<Vec3> place_of_split(const Subsegment& subsegment, const SplitLimits& limits) const;
    Status recover_few(RunContext& context);

    LabelledMesh& mesh_;
    ProtectedSegments& protected_segments_;
    const StructureField& field_;
    ContourSubsegmentOptions options_;
    std::vector<Subsegment> subsegments_;
    std::vector<std::uint32_t> acute_;  // vertices where some of them meet at acute angles; rising
    SegmentClusters apexes_;            // of none where planes do not cross
    MissingSubsegments missing_;        // of them
    CellSearch search_;                 // the cells that missing_ has not seen
    SidesOfSubsegments sides_;
    CellSearch sides_search_;  // the cells that sides_ has not seen
    std::vector<std::uint32_t> vertices_;
    std::size_t side_points_ = 0;
    bool are_short_;
};

// Error limit E-PIP-003 where the mesh has as many regions as there is room for.
Status check_region_count(LabelledMesh& mesh);

}  // namespace anatomesh
