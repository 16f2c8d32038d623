#include "anatomesh_io/contour/json_writer.h"

#include <nlohmann/json.hpp>

#include "anatomesh_io/contour/drawn_structures.h"
#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

void append_text(std::string& out, const std::string& text) {
    out += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void append_vector(std::string& out, Vec3 p) {
    out += '[';
    append_json_number(out, p.x);
    out += ", ";
    append_json_number(out, p.y);
    out += ", ";
    append_json_number(out, p.z);
    out += ']';
}

void append_structure(std::string& out, const Structure& structure) {
    out += "  {\"number\": ";
    append_integer(out, structure.number);
    out += ", \"name\": ";
    append_text(out, structure.name);
    out += ", \"color\": [";
    for (std::size_t i = 0; i < 3; ++i) {
        if (i > 0) out += ", ";
        append_integer(out, static_cast<int>(structure.color[i]));
    }
    out += "]}";
}

void append_contour(std::string& out, const ContourSet& set, const Contour& contour) {
    out += "    {\"structure\": ";
    append_integer(out, set.structures[contour.structure].number);
    out += ", \"kind\": \"closed\", \"points\": [";
    bool first = true;
    for (const Vec3& point : set.points_of(contour)) {
        if (!first) out += ", ";
        first = false;
        append_vector(out, point);
    }
    out += "]}";
}

void append_slice(std::string& out, const ContourSet& set, const Slice& slice) {
    out += "  {\"name\": ";
    append_text(out, slice.name);
    out += ", \"plane\": {\"origin\": ";
    append_vector(out, slice.plane.origin);
    out += ", \"normal\": ";
    append_vector(out, slice.plane.normal);
    out += "}, \"contours\": [";
    bool first = true;
    for (const Contour& contour : set.contours_of(slice)) {
        out += first ? "\n" : ",\n";
        first = false;
        append_contour(out, set, contour);
    }
    out += "]}";
}

}  // namespace

std::string format_json_contours(const ContourSet& set) {
    std::string out = "{\n \"format\": \"anatomesh-contours\",\n \"version\": 1,\n \"space\": ";
    out += set.frame == Frame::lps ? "\"LPS\"" : "\"unknown\"";
    out += ",\n \"unit\": \"mm\",\n";
    if (set.pixel_mm > 0) {
        out += " \"pixel_mm\": ";
        append_number(out, set.pixel_mm);
        out += ",\n";
    }
    if (set.slice_thickness_mm > 0) {
        out += " \"slice_thickness_mm\": ";
        append_number(out, set.slice_thickness_mm);
        out += ",\n";
    }
    if (set.complete) out += " \"coverage\": \"complete\",\n";
    if (set.complete && set.exclusive) out += " \"exclusive\": true,\n";
    out += " \"structures\": [";
    const char* separator = "\n";
    for (const std::uint32_t structure : drawn_structures(set)) {
        out += separator;
        separator = ",\n";
        append_structure(out, set.structures[structure]);
    }
    out += "\n ],\n \"slices\": [";
    separator = "\n";
    for (const Slice& slice : set.slices) {
        out += separator;
        separator = ",\n";
        append_slice(out, set, slice);
    }
    out += "\n ]\n}\n";
    return out;
}

}  // namespace anatomesh
