#include "anatomesh_io/project/write_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "anatomesh/base/number_text.h"
#include "anatomesh_io/project/record_words.h"

namespace anatomesh {

namespace {

void append_text(std::string& out, const std::string& text) {
    out += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// Three numbers of each point as one text: a third of the time that an array of numbers takes to read.
void append_points(std::string& out, std::span<const Vec3> points) {
    out += '"';
    const char* separator = "";
    for (const Vec3& p : points) {
        for (const double value : {p.x, p.y, p.z}) {
            out += separator;
            separator = " ";
            append_number(out, value);
        }
    }
    out += '"';
}

void append_vector(std::string& out, Vec3 p) {
    out += '[';
    append_json_number(out, p.x);
    out += ',';
    append_json_number(out, p.y);
    out += ',';
    append_json_number(out, p.z);
    out += ']';
}

// What a ring has in common with one that stood there: its first `head` and its last `tail` points.
struct CommonPoints {
    std::size_t ring = 0, head = 0, tail = 0;
    std::size_t count() const { return head + tail; }
};

// Finds common points. Each point that stood there is named at most once, so that a value grows by no more than its record.
class CommonPointFinder {
  public:
    explicit CommonPointFinder(const DrawnRings* before) : before_(before) {
        if (!before_) return;
        for (const DrawnRing& ring : before_->rings) left_.push_back(ring.point_count);
    }

    CommonPoints find(std::span<const Vec3> points) {
        CommonPoints best;
        for (std::size_t b = 0; b < left_.size(); ++b) {
            const CommonPoints common = common_with(b, points);
            if (common.count() > best.count()) best = common;
        }
        if (best.count() > 0) left_[best.ring] -= best.count();
        return best;
    }

  private:
    CommonPoints common_with(std::size_t ring, std::span<const Vec3> points) const {
        const auto other = before_->points_of(before_->rings[ring]);
        const std::size_t most = std::min({points.size(), other.size(), left_[ring]});
        CommonPoints common{ring, 0, 0};
        while (common.head < most && same_bits(points[common.head], other[common.head])) ++common.head;
        while (common.count() < most &&
               same_bits(points[points.size() - 1 - common.tail], other[other.size() - 1 - common.tail]))
            ++common.tail;
        return common;
    }

    const DrawnRings* before_;
    std::vector<std::size_t> left_;  // of each ring that stood there: points that nobody named
};

void append_rings(std::string& out, const DrawnRings& rings, const DrawnRings* before) {
    CommonPointFinder finder(before);
    out += '[';
    const char* separator = "";
    for (const DrawnRing& ring : rings.rings) {
        out += separator;
        separator = ",";
        out += "{\"tool\":\"";
        out += name_of(ring.tool);
        out += '"';
        const auto points = rings.points_of(ring);
        const CommonPoints common = finder.find(points);
        if (common.count() > 0) {
            out += ",\"from\":";
            append_integer(out, common.ring);
            out += ",\"head\":";
            append_integer(out, common.head);
            out += ",\"tail\":";
            append_integer(out, common.tail);
        }
        out += ",\"points\":";
        append_points(out, points.subspan(common.head, points.size() - common.count()));
        if (ring.control_count > 0) {
            out += ",\"control\":";
            append_points(out, rings.control_points_of(ring));
        }
        out += '}';
    }
    out += ']';
}

void append_structure(std::string& out, const DrawnStructure& drawn) {
    out += "{\"name\":";
    append_text(out, drawn.structure.name);
    out += ",\"color\":[";
    for (std::size_t i = 0; i < 3; ++i) {
        if (i > 0) out += ',';
        append_integer(out, static_cast<int>(drawn.structure.color[i]));
    }
    out += drawn.locked ? "],\"locked\":true}" : "],\"locked\":false}";
}

void append_plane(std::string& out, const DrawnPlane& drawn) {
    const auto axis = [&](const char* name, Vec3 value) {
        out += name;
        append_vector(out, value);
    };
    axis("{\"origin\":", drawn.plane.origin);
    axis(",\"u\":", drawn.plane.u);
    axis(",\"v\":", drawn.plane.v);
    axis(",\"normal\":", drawn.plane.normal);
    out += ",\"name\":";
    append_text(out, drawn.name);
    out += ",\"thickness_mm\":";
    append_json_number(out, drawn.thickness_mm);
    out += drawn.left_out ? ",\"left_out\":true}" : ",\"left_out\":false}";
}

void append_contour_place(std::string& out, const ContourPlace& place) {
    out += "{\"plane\":";
    append_integer(out, place.key.plane);
    out += ",\"structure\":";
    append_integer(out, place.key.structure);
    out += ",\"point\":";
    append_vector(out, place.point);
    out += '}';
}

void append_pin(std::string& out, const TopologyPin& pin) {
    out += "{\"first\":";
    append_contour_place(out, pin.first);
    out += ",\"second\":";
    append_contour_place(out, pin.second);
    out += pin.joined ? ",\"joined\":true}" : ",\"joined\":false}";
}

void append_order(std::string& out, const StructureOrder& order) {
    out += '[';
    const char* separator = "";
    for (const std::int32_t number : order) {
        out += separator;
        separator = ",";
        append_integer(out, number);
    }
    out += ']';
}

void append_key(std::string& out, const DrawingKey& key) {
    out += "{\"";
    out += name_of(key.subject);
    out += "\":";
    if (key.subject == Subject::order) {
        out += "true";
    } else if (key.subject == Subject::rings || key.subject == Subject::proposal) {
        append_order(out, {key.first, key.second});
    } else {
        append_integer(out, key.first);
    }
}

const DrawnRings* rings_of(const DrawingValue& value) {
    const auto* rings = std::get_if<std::shared_ptr<const DrawnRings>>(&value);
    return rings ? rings->get() : nullptr;
}

void append_change(std::string& out, const Change& change) {
    append_key(out, change.key);
    out += ",\"to\":";
    if (const auto* structure = std::get_if<std::shared_ptr<const DrawnStructure>>(&change.after))
        append_structure(out, **structure);
    else if (const auto* order = std::get_if<std::shared_ptr<const StructureOrder>>(&change.after))
        append_order(out, **order);
    else if (const auto* plane = std::get_if<std::shared_ptr<const DrawnPlane>>(&change.after))
        append_plane(out, **plane);
    else if (const DrawnRings* rings = rings_of(change.after))
        append_rings(out, *rings, rings_of(change.before));
    else if (const auto* pin = std::get_if<std::shared_ptr<const TopologyPin>>(&change.after))
        append_pin(out, **pin);
    else
        out += "null";
    out += '}';
}

std::string begin_record(std::uint64_t number, const char* what, const std::string& name) {
    std::string out = "{\"n\":";
    append_integer(out, number);
    out += ",\"do\":\"";
    out += what;
    out += "\",\"name\":";
    append_text(out, name);
    return out;
}

}  // namespace

std::string head_record(const DrawingSource& source) {
    std::string out = "{\"n\":0,\"format\":\"";
    out += project_format;
    out += "\",\"version\":";
    append_integer(out, project_version);
    out += source.frame == Frame::lps ? ",\"space\":\"LPS\"" : ",\"space\":\"unknown\"";
    out += ",\"unit\":\"mm\",\"pixel_mm\":";
    append_json_number(out, source.pixel_mm);
    out += ",\"slice_thickness_mm\":";
    append_json_number(out, source.slice_thickness_mm);
    out += '}';
    return out;
}

std::string apply_record(std::uint64_t number, const Edit& edit) {
    std::string out = begin_record(number, "apply", edit.name);
    out += ",\"changes\":[";
    const char* separator = "";
    for (const Change& change : edit.changes) {
        out += separator;
        separator = ",";
        append_change(out, change);
    }
    out += "]}";
    return out;
}

std::string move_record(std::uint64_t number, const char* what, const std::string& name) {
    return begin_record(number, what, name) + "}";
}

}  // namespace anatomesh
