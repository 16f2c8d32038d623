// QualityGate: whether cells that a change at the end made are good enough to stay.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// The largest ratio of cells at vertices that contours limit, below the 100 that the certificate allows
// there. [1; 3.9 to 100; M 2026-11, set not recorded]
inline constexpr double most_limited_ratio = 50;
// The least sine of their angles, 0.6 degrees, above the 0.05 degrees that the certificate allows there. [1;
// 0.001 to 0.17; M 2026-11, set not recorded]
inline constexpr double least_limited_sine = 0.01;

// Improves the shapes of these cells; returns the cells that it made or reshaped, some of which may be gone.
using ImproveCells = std::function<std::vector<std::uint32_t>(std::vector<std::uint32_t>)>;

class QualityGate {
  public:
    // `least_sine`: of cells inside, where contours do not limit them. Requires: both outlive this.
    QualityGate(EditContext& edit, const DrawnSlices& drawn, double least_sine)
        : edit_(edit), drawn_(drawn), least_sine_(least_sine) {}

    // Whether a cell inside has no angle whose sine is below the least and no ratio above the edit context's
    // last bound; where contours limit it, the bounds above. Others are.
    bool is_good(std::uint32_t c) const;
    // Whether what of the cell lies on interfaces lies within the edit context's `spike_mm` of the field's.
    bool is_near(std::uint32_t c) { return is_near(c, edit_.options.spike_mm); }
    // The same of another length, mm.
    bool is_near(std::uint32_t c, double most_mm);
    // How far from the field's what of these cells lies on interfaces, where that is above `spike_mm`; else
    // that. mm
    double farthest_of(std::span<const std::uint32_t> cells);
    double spike_mm() const { return edit_.options.spike_mm; }
    // Of the cells those inside above the edit context's first bound that contours do not limit.
    std::vector<std::uint32_t> those_above_bound(std::vector<std::uint32_t> cells) const;

  private:
    // Whether one of the distances is such: of the centres and free corners of a cell's facets on interfaces
    // from the field's, mm. One above the reach may be any above it.
    template <class Is>
    bool any_distance(std::uint32_t c, double reach_mm, const Is& is);

    EditContext& edit_;
    const DrawnSlices& drawn_;
    double least_sine_;
};

// How many cells inside are above the edit context's first bound, kept up to date while changes are made.
class QualityBudget {
  public:
    // As QualityGate. O(cells)
    QualityBudget(EditContext& edit, const DrawnSlices& drawn, double least_sine);

    // By how many such cells a change adds; nothing where a cell that it made or reshaped is not good, or not
    // within `most_mm` of the field's surfaces (QualityGate).
    std::optional<std::size_t> growth(std::span<const std::uint32_t> changed, double most_mm);
    // By how many they may grow: to 0.3 % of the cells that were inside at first.
    std::size_t allowance() const { return most_above_ - std::min(most_above_, above_bound_.size()); }
    // The change that growth() was asked about last stays.
    void keep() { above_bound_ = std::move(above_after_); }
    std::size_t cells_inside() const { return inside_; }  // at first

  private:
    QualityGate gate_;
    std::size_t inside_ = 0, most_above_ = 0;
    std::vector<std::uint32_t> above_bound_, above_after_;  // cells; rising
};

}  // namespace anatomesh
