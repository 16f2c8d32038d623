// Checks of the outputs of a command before its work begins.
#pragma once

#include <string>
#include <vector>

#include "anatomesh/base/result.h"

namespace anatomesh {

// Every output can be written, no two are the same file, none is an input, also by another name of it (a
// link), and none lies in an input that is a folder. Errors: usage E-CMD-006 an output is an input,
// E-FILE-012 two outputs are one; those of check_writable().
Status check_outputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

// The extension of the path is that of a model, or of a surface where those are allowed.
// Error: usage E-CMD-004, listing the extensions there are.
Status check_mesh_output(const std::string& path, bool surfaces_too);
Status check_surface_output(const std::string& path);
Status check_contour_output(const std::string& path);

// The path ends in one of `extensions`, in upper or lower case, and has a name before it. Error: usage
// E-CMD-004.
Status check_extension(const std::string& path, const std::vector<std::string>& extensions);

// The path without its extension, and `ending` instead.
std::string with_ending(const std::string& path, const std::string& ending);

}  // namespace anatomesh
