// RawBuilder: what every reader of contours does alike: limits before memory, structures by number, the
// frame, the order, and the warnings about what a file leaves unsaid.
//
// Errors: E-CIO-001 too many structures            E-CIO-005 a coordinate beyond the limit, or not finite
//         E-CIO-002 too many contours or slices    E-CIO-006 no contours (lists the structures there are)
//         E-CIO-003 too many points in a contour   E-CIO-007 a plane that is none
//         E-CIO-004 too many points in all
// Warnings: W-CIO-001 the file does not state its frame    W-CIO-003 a structure without contours is skipped
//           W-CIO-002 the frame asked for is not the one   W-CIO-004 structures whose names differ in nothing
//                     the file states; the file's holds              but case and blanks
//           W-CIO-005 a name with bytes that are not text
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh_io/contour/contour_limits.h"

namespace anatomesh {

// The axes of the numbers in a file: x to the left, y to the back, z up (LPS), or x to the right, y to the
// front, z up (RAS), which a reader turns.
enum class FileFrame : std::uint8_t { unknown, lps, ras };

// Not thread-safe. Order of use: structures and planes in any order, contours one after another
// (begin_contour, add_point ..., end_contour), then finish().
class RawBuilder {
  public:
    RawBuilder(std::string file, const ContourLimits& limits, RunContext& context);

    FileFrame frame = FileFrame::unknown;  // as the file states it
    double pixel_mm = 0;
    double slice_thickness_mm = 0;
    bool complete = false, exclusive = false;
    bool unit_is_given = false;  // by the user: what the numbers look like is no news then
    std::uint32_t space = 0;     // of the contours that are begun from now on

    const std::string& file() const { return raw_.source; }
    const ContourLimits& limits() const { return limits_; }
    RunContext& context() { return context_; }

    std::optional<std::uint32_t> find_structure(std::int32_t number) const;
    // Requires: no structure of this number yet.
    Result<std::uint32_t> add_structure(Structure structure);
    // The structure of this number, which comes to be without a name when there is none.
    Result<std::uint32_t> structure_of(std::int32_t number);
    // A normal within rounding of length 1 is kept to the last bit, any other is scaled to it.
    Result<std::uint32_t> add_plane(Vec3 origin, Vec3 normal, std::string name, const Place& place);

    // `slice`: what the file calls it, where it gives no plane.
    Status begin_contour(std::uint32_t structure, ContourKind kind, std::int32_t plane, std::string name,
                         std::string slice = {});
    // An error when the open contour may not have `count` further points.
    Status expect_points(std::uint64_t count);
    Status add_point(Vec3 point);
    void set_structure(std::size_t contour, std::uint32_t structure) {
        raw_.contours[contour].structure = structure;
    }
    void set_hole(std::size_t contour) { raw_.contours[contour].is_hole = true; }
    void set_plane(std::size_t contour, std::int32_t plane) { raw_.contours[contour].plane = plane; }
    void set_kind(std::size_t contour, ContourKind kind) { raw_.contours[contour].kind = kind; }

    void set_color(std::uint32_t structure, std::array<std::uint8_t, 3> color) {
        raw_.structures[structure].color = color;
    }

    std::size_t contour_count() const { return raw_.contours.size(); }
    const RawContour& contour(std::size_t index) const { return raw_.contours[index]; }
    const std::vector<Structure>& structures() const { return raw_.structures; }

    Error too_many_structures() const;
    // The open contour and its newest point (or the one after it), for messages.
    Place contour_place() const;
    Place point_place(std::uint64_t point) const;

    // Drops structures without contours, sorts structures by number, turns RAS to LPS. `asked` is the frame
    // the user named for a file that states none.
    Result<RawContours> finish(FileFrame asked);

  private:
    void settle_frame(FileFrame asked);
    void warn_about_names();
    void keep_structures_with_contours();

    RawContours raw_;
    ContourLimits limits_;
    RunContext& context_;
    std::map<std::int32_t, std::uint32_t> index_of_number_;
};

// `text` as valid UTF-8 without NUL; what is not becomes U+FFFD. `changed` is set when something did.
std::string valid_utf8(std::string_view text, bool& changed);

// How a structure is called in messages: its name, or "number 12" when it has none.
std::string label_of(const Structure& structure);

}  // namespace anatomesh
