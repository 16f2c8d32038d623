// drawn_contours: what is drawn, as the pipeline and the writers of contours take it.
#pragma once

#include <string>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh/live/edit/drawing.h"

namespace anatomesh {

// The rings as contours, for a contour file: the planes with rings by id, the structures with rings by number, rings in
// their order, every point bit for bit. Planes on which nothing is accepted say nothing and are no slices; proposals and
// pins are no contours. Slices that are left out are there, because what they drew tells how far apart slices are: the names
// of slices_left_out() keep them out of a model. It is no kept set, because nothing was repaired yet. Complexity: O(points).
ContourSet drawn_contours(const Drawing& drawing);

// The same as the reader of JSON contours gives it of that file, field by field but for `source`: the axes of a plane follow
// from its normal alone. A model of these is the model of the saved contours. Complexity: O(points).
RawContours raw_contours(const Drawing& drawing);

// The names of the slices of drawn_contours() that are left out, as a model takes them: PrepareOptions::choice.without, and
// --without of the command. O(planes with rings).
std::vector<std::string> slices_left_out(const Drawing& drawing);

}  // namespace anatomesh
