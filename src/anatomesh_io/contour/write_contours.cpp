#include "anatomesh_io/contour/write_contours.h"

#include <string_view>
#include <utility>

#include "anatomesh/base/text.h"
#include "anatomesh_io/contour/csl_writer.h"
#include "anatomesh_io/contour/json_writer.h"
#include "anatomesh_io/contour/vtp_contours.h"
#include "anatomesh_io/file/atomic_file.h"

namespace anatomesh {

Result<ContourFormat> contour_format_of(const std::string& path) {
    constexpr std::pair<std::string_view, ContourFormat> formats[] = {
        {".json", ContourFormat::json}, {".vtp", ContourFormat::vtp}, {".csl", ContourFormat::csl}};
    const std::size_t slash = path.find_last_of('/');
    const std::string name = path.substr(slash == std::string::npos ? 0 : slash + 1);
    const std::size_t dot = name.find_last_of('.');
    const std::string extension = dot == std::string::npos ? std::string{} : lower_case(name.substr(dot));
    for (const auto& [known, format] : formats)
        if (extension == known) return format;
    return Error{ErrorKind::usage,
                 "E-CIO-009",
                 "the extension of the output is no format for contours",
                 {path, {}, {}, {}, extension},
                 "use .json, .vtp or .csl"};
}

std::string format_contours(const ContourSet& set, ContourFormat format, RunContext& context) {
    if (format == ContourFormat::json) return format_json_contours(set);
    if (format == ContourFormat::vtp) return format_vtp_contours(set, context.threads);
    context.warn({"W-CIO-006",
                  "the CSL format holds no names, no colours and no axes",
                  {set.source, {}, {}, {}, {}},
                  set.frame == Frame::lps ? "they were left out; give --frame LPS when you read the file"
                                          : "they were left out"});
    return format_csl(set);
}

Status write_contours(const ContourSet& set, const std::string& path, RunContext& context) {
    ANATOMESH_TRY(const ContourFormat format, contour_format_of(path));
    return write_file_atomically(path, format_contours(set, format, context));
}

}  // namespace anatomesh
