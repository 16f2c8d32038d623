#include "anatomesh_io/dicom/frame_groups.h"

#include <fmt/format.h>

#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

Error frame_error(const char* code, const DataSet& set, std::uint32_t frame, std::uint32_t frames,
                  const std::string& message, std::string value, const std::string& next_step) {
    return {ErrorKind::input,
            code,
            message,
            {set.name(), frames > 1 ? fmt::format("frame {}", frame + 1) : "", {}, {}, std::move(value)},
            next_step};
}

std::string vector_text(const std::vector<double>& values) {
    std::string text;
    for (const double value : values) {
        if (!text.empty()) text += ' ';
        append_number(text, value);
    }
    return text;
}

}  // namespace anatomesh
