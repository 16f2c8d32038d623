// ReadingLog: what clean_contours() did to each raw contour, and what it warns about.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh/contour/resolve/resolve.h"

namespace anatomesh {

// The name of a structure for messages; its number if it has no name.
std::string structure_text(const Structure& structure);

// Where a raw contour is, for messages. The slice stays empty, because a contour has none before it is grouped.
Place place_of_contour(const RawContours& raw, std::uint32_t contour);

// Steps write entries as they read contours. Warnings of contours come out at the end, in the order of the input, so
// that they do not depend on how contours are grouped. Requires: `raw` outlives the log.
class ReadingLog {
  public:
    explicit ReadingLog(const RawContours& raw);

    ContourLog& of(std::uint32_t contour) { return entries_[contour]; }
    void note(std::uint32_t contour, std::string code, std::string message, std::string value,
              std::string what_was_done);
    void append(std::vector<RingNote> notes);
    // The whole rule of a contour that stays out of the set.
    void drop(std::uint32_t contour, const std::string& why) { of(contour).rule = "dropped: " + why; }
    // One more part of a rule, after a semicolon.
    void add_rule(std::uint32_t contour, const std::string& rule);
    void mark_repaired(std::uint32_t contour) { is_repaired_[contour] = 1; }

    // Gives all warnings of contours to the context, sorted by contour; those of one contour as they arose.
    void warn(RunContext& context);
    // The counts of the input, of repaired and of dropped contours, and the largest movement.
    CleanStats stats() const;
    const std::vector<ContourLog>& entries() const { return entries_; }

  private:
    const RawContours& raw_;
    std::vector<ContourLog> entries_;  // one per raw contour
    std::vector<std::uint8_t> is_repaired_;
    std::vector<RingNote> notes_;
};

}  // namespace anatomesh
