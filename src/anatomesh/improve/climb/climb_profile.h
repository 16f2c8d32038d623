// ClimbProfile: what one pass of the hill climber works on, what it may do, and what must hold.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "anatomesh/improve/climb/cell_operations.h"
#include "anatomesh/improve/core/acceptance_rule.h"
#include "anatomesh/improve/core/mesh_improvement_options.h"

namespace anatomesh {

// Cells at vertices whose contours force ill shapes (DrawnSlices::constraint_limited) that a pass leaves
// alone.
enum class Exempt : std::uint8_t {
    none,
    limited,           // all of them
    limited_in_bounds  // those whose sine is not below least_limited_sine (quality_gate.h)
};

// What the cells of a change must be besides the acceptance rule.
enum class Condition : std::uint8_t {
    none,
    limited_in_bounds,  // limited cells keep within the bounds of forced ones; else the cell is given up
    all_good            // all pass the quality gate; else the next operation is tried
};

// Which of the changed cells a pass over a list visits too.
enum class Revisit : std::uint8_t { none, bad, all };

// The objective of a change follows from the cell: of one above `target_ratio` it is the ratio, else the
// sine.
struct ClimbProfile {
    double target_sine = 0;          // cells inside with a smaller least sine are worked on. 0 to 1
    double target_ratio = HUGE_VAL;  // and those with a larger radius-edge ratio. >= 0
    Exempt exempt = Exempt::none;    // but not these
    AcceptanceRule rule = {};        // the rest of what a change must keep; its objective is set by cell
    OperationSet operations = ordinary_operations;
    double relabels_above = 0;  // a cell is relabelled only if its ratio is larger. >= 0
    Condition condition = Condition::none;
    Revisit revisit = Revisit::none;
    // A pass ends when it has changed more cells than this.
    std::size_t most_changed = static_cast<std::size_t>(-1);
    bool lists_changes = false;  // a pass over the queue says which cells it made or reshaped
};

// The passes, in the order in which improve_mesh() makes them first.
enum class ClimbPass : std::uint8_t {
    surgery_angles,
    surgery_listed_angles,
    surgery_ratios,
    angles,
    last_angles,
    listed_angles_1,
    listed_angles_2,
    listed_angles_3,
    high_ratios,
    ratios,
    blemishes,
    flat_cells
};

// The table of all passes; climb_profile.cpp says why each is made, and why it is so.
class ClimbProfiles {
  public:
    explicit ClimbProfiles(const MeshImprovementOptions& options);
    const ClimbProfile& operator[](ClimbPass pass) const { return rows_[static_cast<std::size_t>(pass)]; }
    const auto& rows() const { return rows_; }

  private:
    std::array<ClimbProfile, 12> rows_;
};

// The sine of the angle below which the certificate lists a cell (contract.h).
double listed_sine();
// The sine of MeshImprovementOptions::target_degrees.
double target_sine(const MeshImprovementOptions& options);

}  // namespace anatomesh
