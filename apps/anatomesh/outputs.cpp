#include "outputs.h"

#include <filesystem>
#include <system_error>

#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

namespace fs = std::filesystem;

namespace {

// Whether two names mean one file, be it there already or not.
bool same_file(const std::string& a, const std::string& b) {
    std::error_code error;
    if (fs::equivalent(a, b, error)) return true;
    const fs::path canonical_a = fs::weakly_canonical(a, error);
    if (error) return a == b;
    const fs::path canonical_b = fs::weakly_canonical(b, error);
    return error ? a == b : canonical_a == canonical_b;
}

constexpr const char* model_extensions = ".vtu, .msh, .mesh, .inp";
constexpr const char* surface_extensions = ".vtp, .stl, .ply, .obj";

Error unknown_extension(const std::string& path, const std::string& known) {
    return {ErrorKind::usage,
            "E-CMD-004",
            "the extension names no format that can be written here",
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
            return Error{ErrorKind::file,
                         "E-CMD-006",
                         "the output is an input, or lies in one",
                         {outputs[i], "", "", "", ""},
                         "choose another name for the output"};
        }
        for (std::size_t j = 0; j < i; ++j) {
            if (!same_file(outputs[i], outputs[j])) continue;
            return Error{ErrorKind::file,
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
    if (model_format_of(path) || (surfaces_too && surface_format_of(path))) return Nothing{};
    return unknown_extension(path, std::string(model_extensions) + (surfaces_too ? ", " : "") +
                                       (surfaces_too ? surface_extensions : ""));
}

Status check_surface_output(const std::string& path) {
    if (surface_format_of(path)) return Nothing{};
    return unknown_extension(path, surface_extensions);
}

std::string with_ending(const std::string& path, const std::string& ending) {
    return fs::path(path).replace_extension().string() + ending;
}

}  // namespace anatomesh
