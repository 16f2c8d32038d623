// How well the field of planes in any position gives back what it does not see, beside the nearest plane's
// region and the mean of the two nearest planes' distances, weighted with the nearness (shape-based
// interpolation: Raya and Udupa, IEEE Trans. Med. Imaging 9, 1990).
#pragma once

#include <cstdint>
#include <string>

#include "anatomesh/base/result.h"
#include "anatomesh/input_options.h"

namespace anatomesh {

struct CutOptions {
    std::string kind;           // fan: 90 degrees, apex 120 mm below the centre; axis; stacks; freehand
    std::uint32_t planes = 36;  // in all
    double spacing_mm = 1.5;    // of the points on a contour
};

// The input's own surface (the field of all its slices, which must be parallel) cut by planes, and what is
// made of the cuts compared with it: distances along the surface's normals, and of the whole model to the
// nearest point both ways. Prints a row of a Markdown table, and its head if wanted.
Status cut_planes(const InputOptions& options, const CutOptions& cut, bool header);

// Every n-th plane of the input left out, the rest reconciled as the options say, and how far from the
// vertices drawn on the left-out planes the region ends, across the contour in its plane. Prints a row.
Status leave_out_planes(const InputOptions& options, std::uint32_t every, bool header);

}  // namespace anatomesh
