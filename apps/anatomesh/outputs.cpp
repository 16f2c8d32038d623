#include "outputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "anatomesh/base/text.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

namespace fs = std::filesystem;

namespace {

// The path with links followed, also one to a file that is not there yet.
fs::path followed(fs::path path) {
    // A chain of symbolic links is followed no further, as by the Linux kernel.
    // [links; 40; D Linux path_resolution]
    constexpr int most_links = 40;
    std::error_code error;
    for (int i = 0; i < most_links && fs::is_symlink(path, error); ++i) {
        const fs::path next = fs::read_symlink(path, error);
        if (error) break;
        path = path.parent_path() / next;
    }
    const fs::path canonical = fs::weakly_canonical(fs::absolute(path, error), error);
    return error ? path : canonical;
}

// Whether two names mean one file, be it there already or not.
bool same_file(const std::string& a, const std::string& b) {
    std::error_code error;
    return fs::equivalent(a, b, error) || followed(a) == followed(b);
}

constexpr const char* model_extensions = ".vtu, .msh, .mesh, .inp, .feb";
constexpr const char* surface_extensions = ".vtp, .stl, .ply, .obj";

// ".vtu" alone is a hidden file without an extension.
bool has_extension(const std::string& path) {
    return fs::path(path).has_extension();
}

Error unknown_extension(const std::string& path, const std::string& known) {
    return {ErrorKind::usage,
            "E-CMD-004",
            has_extension(path) ? "the extension of the output is no format that this command writes"
                                : "the name of the output has no extension, which chooses the format",
            {path, "", "", "", ""},
            "the extensions are " + known};
}

bool lies_in(const std::string& path, const std::string& folder) {
    std::error_code error;
    if (!fs::is_directory(folder, error)) return false;
    const fs::path outer = fs::weakly_canonical(folder, error);
    for (fs::path at = fs::weakly_canonical(path, error); at.has_relative_path(); at = at.parent_path()) {
        if (at == outer) return true;
    }
    return false;
}

}  // namespace

Status check_outputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        for (const std::string& input : inputs) {
            if (!same_file(outputs[i], input) && !lies_in(outputs[i], input)) continue;
            return Error{ErrorKind::usage,
                         "E-CMD-006",
                         "the output is the same file as an input, or lies in an input folder",
                         {outputs[i], "", "", "", ""},
                         "choose another name for the output"};
        }
        for (std::size_t j = 0; j < i; ++j) {
            if (!same_file(outputs[i], outputs[j])) continue;
            return Error{ErrorKind::usage,
                         "E-FILE-012",
                         "two outputs are the same file",
                         {outputs[i], "", "", "", ""},
                         "choose another name for one of them"};
        }
        ANATOMESH_CHECK_STATUS(check_writable(outputs[i]));
    }
    return Nothing{};
}

Status check_mesh_output(const std::string& path, bool surfaces_too) {
    const bool known = model_format_of(path) || (surfaces_too && surface_format_of(path));
    if (known && has_extension(path)) return Nothing{};
    return unknown_extension(path, std::string(model_extensions) + (surfaces_too ? ", " : "") +
                                       (surfaces_too ? surface_extensions : ""));
}

Status check_surface_output(const std::string& path) {
    if (surface_format_of(path) && has_extension(path)) return Nothing{};
    return unknown_extension(path, surface_extensions);
}

Status check_contour_output(const std::string& path) {
    return check_extension(path, {".json", ".vtp", ".csl"});
}

Status check_extension(const std::string& path, const std::vector<std::string>& extensions) {
    const std::string name = lower_case(fs::path(path).filename().string());
    for (const std::string& extension : extensions)
        if (name.size() > extension.size() && name.ends_with(extension)) return Nothing{};
    return unknown_extension(path, fmt::format("{}", fmt::join(extensions, ", ")));
}

std::string with_ending(const std::string& path, const std::string& ending) {
    return fs::path(path).replace_extension().string() + ending;
}

}  // namespace anatomesh
