// Livewire: the line along the edges of a picture from an anchor to wherever the pointer is.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/live/livewire/shortest_paths.h"

namespace anatomesh {

struct LivewireOptions {
    // The line is looked for in a window about anchor and pointer that has so many pixels, and in the whole picture if
    // that has no more. The default is a picture of 1024 x 1024: to find all paths in it takes about 60 ms, once for each
    // anchor. A window that has to grow finds many paths again, so a smaller one helps only where pointers jump far.
    // [pixels; 1 to 2^24]
    std::uint32_t window_pixels = 1 << 20;
    // The window reaches at least so far beyond anchor and pointer, whatever its size then is. [pixels; 1 to 16384]
    std::uint32_t margin = 64;
};

struct LivewireLine {
    // Centres of neighbouring pixels, mm in the picture's plane; the anchor first.
    std::vector<Vec2> points;
    // The length of a line that costs as much and has no edge along it; 0 for a straight segment. [mm; >= 0]
    double cost_mm = 0;
    // No line through the whole picture is cheaper. False where the window leaves that open.
    bool cheapest = true;
    // The pointer lies in the picture; else the line ends at the border pixel that is nearest to it.
    bool inside = true;
};

// An anchor is set, and lines are asked for as the pointer moves. Paths that were found are kept for the next pointer,
// and the window grows as the pointer leaves it.
//
// Guarantees. A line starts at the anchor's pixel and ends at the pointer's; neighbours on it are neighbours of the
// picture. No line within the window is cheaper. If `cheapest`, it is the line that a search of the whole picture finds,
// pixel by pixel; in a picture of window_pixels or fewer every line is. If not, a cheaper line may leave the window, and
// the line depends on how far the window has grown by earlier pointers. The same questions in the same order always
// give the same lines.
//
// Requires: the costs outlive the object, and their picture has a pixel. Memory: 12 bytes for each pixel of the picture.
// Complexity of a line: O(pixels that are cheaper to reach than the pointer's), which lie in the window; O(length) if
// the pointer's pixel is settled already.
// Sources: Mortensen and Barrett, SIGGRAPH 1995, section 3.2; Falcao et al., GMIP 60, 1998 (a lane about the pointer);
// Falcao, Udupa and Miyazawa, IEEE TMI 19, 2000 (paths are found on demand and kept).
class Livewire {
  public:
    explicit Livewire(const LivewireCosts& costs, const LivewireOptions& options = {});

    // Moves the anchor to the pixel nearest to a point (mm in the picture's plane), and returns that pixel.
    // Errors: input E-LIV-106 the point is not finite; the anchor then stays where it was. O(pixels of the window before).
    Result<NearestPixel> set_anchor(Vec2 point);

    // Errors: input E-LIV-106 the pointer is not finite. Requires: set_anchor() succeeded before.
    Result<LivewireLine> line_to(Vec2 pointer);

    // Finds paths to further pixels of the window, the cheapest first, for pointers to come: the use of idle time. It
    // changes no line. Returns whether there are none left. O(pixels). Requires: set_anchor() succeeded before.
    bool settle_ahead(std::uint32_t pixels);

    const PictureGrid& grid() const { return costs_->grid; }
    const PixelWindow& window() const { return paths_.window(); }

  private:
    const LivewireCosts* costs_;
    LivewireOptions options_;
    ShortestPaths paths_;
    Pixel anchor_;
    bool anchored_ = false;
};

}  // namespace anatomesh
