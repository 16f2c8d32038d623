#include "anatomesh_io/project/read_record.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh_io/project/record_words.h"

namespace anatomesh {

namespace {

using nlohmann::json;

Error bad_record(std::string message) {
    return {ErrorKind::input, "E-PRJ-004", std::move(message), {}, {}};
}

// Takes values out of parsed JSON. The first fault is kept, and everything after it gives a default.
class RecordReader {
  public:
    bool ok() const { return fault_.empty(); }
    const std::string& fault() const { return fault_; }
    void fail(std::string what) {
        if (ok()) fault_ = std::move(what);
    }

    // A member that must be there; a null value after a fault.
    const json& member(const json& object, const char* key) {
        static const json nothing;
        if (!ok()) return nothing;
        const auto found = object.is_object() ? object.find(key) : object.end();
        if (object.is_object() && found != object.end()) return *found;
        fail(std::string("`") + key + "` is missing");
        return nothing;
    }
    const json* optional_member(const json& object, const char* key) {
        const auto found = object.is_object() ? object.find(key) : object.end();
        return object.is_object() && found != object.end() ? &*found : nullptr;
    }

    double number(const json& value) {
        if (value.is_number()) return value.get<double>();
        fail("a number is expected");
        return 0;
    }
    // Within the range of T.
    template <class T>
    T integer(const json& value) {
        if (value.is_number_unsigned()) {
            const auto whole = value.get<std::uint64_t>();
            if (std::in_range<T>(whole)) return static_cast<T>(whole);
        } else if (value.is_number_integer()) {
            const auto whole = value.get<std::int64_t>();
            if (std::in_range<T>(whole)) return static_cast<T>(whole);
        }
        fail("a whole number within its range is expected");
        return 0;
    }
    bool boolean(const json& value) {
        if (value.is_boolean()) return value.get<bool>();
        fail("true or false is expected");
        return false;
    }
    std::string text(const json& value) {
        if (value.is_string()) return value.get<std::string>();
        fail("a text is expected");
        return {};
    }
    // An array of `count` values, or of any number of them; else an empty one.
    const json& array(const json& value, std::optional<std::size_t> count = {}) {
        static const json empty = json::array();
        if (value.is_array() && (!count || value.size() == *count)) return value;
        fail(count ? "an array of " + std::to_string(*count) + " is expected" : "an array is expected");
        return empty;
    }
    // How many points a list of them has, before any is read.
    std::size_t count_of_points(const json& value) {
        if (!value.is_string()) {
            fail("a text of numbers is expected");
            return 0;
        }
        const auto& list = value.get_ref<const std::string&>();
        if (list.empty()) return 0;
        return (static_cast<std::size_t>(std::count(list.begin(), list.end(), ' ')) + 1) / 3;
    }
    // Appends the points of such a list: numbers with one blank between them, three for each point.
    void append_points(const json& value, std::vector<Vec3>& points) {
        if (!value.is_string()) return fail("a text of numbers is expected");
        const auto& list = value.get_ref<const std::string&>();
        if (list.empty()) return;
        const char* at = list.data();
        const char* const end = at + list.size();
        for (;;) {
            double values[3];
            for (double& each : values) {
                const auto [next, failure] = std::from_chars(at, end, each);
                if (failure != std::errc() || !std::isfinite(each))
                    return fail("a number of a point is none");
                at = next;
                if (&each != values + 2 && (at == end || *at++ != ' '))
                    return fail("three numbers for each point are expected");
            }
            points.push_back({values[0], values[1], values[2]});
            if (at == end) return;
            if (*at++ != ' ') return fail("one blank between numbers is expected");
        }
    }
    Vec3 point(const json& value) {
        const json& all = array(value, 3);
        return all.empty() ? Vec3{} : Vec3{number(all[0]), number(all[1]), number(all[2])};
    }
    template <std::size_t N>
    std::size_t choice(const json& value, const std::array<std::string_view, N>& names) {
        const auto found = std::find(names.begin(), names.end(), text(value));
        if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
        fail("an unknown word");
        return 0;
    }

  private:
    std::string fault_;
};

// Reads rings of which some points are those of rings that stood there.
class RingsReader {
  public:
    RingsReader(RecordReader& reader, const DrawnRings* before, std::uint64_t& points_left)
        : reader_(reader), before_(before), points_left_(points_left) {
        if (!before_) return;
        for (const DrawnRing& ring : before_->rings) left_.push_back(ring.point_count);
    }

    // Whether the points are too many; else a fault is the reader's.
    bool is_over_limit() const { return is_over_limit_; }

    DrawnRings read(const json& value) {
        DrawnRings rings;
        for (const json& ring : reader_.array(value)) {
            if (!reader_.ok()) break;
            read_ring(ring, rings);
        }
        return rings;
    }

  private:
    // The points of a ring that stood there of which this one has the first and the last.
    std::span<const Vec3> other_of(const json& ring, std::size_t& head, std::size_t& tail) {
        const json* from = reader_.optional_member(ring, "from");
        if (!from) return {};
        const auto place = reader_.integer<std::uint32_t>(*from);
        head = reader_.integer<std::uint32_t>(reader_.member(ring, "head"));
        tail = reader_.integer<std::uint32_t>(reader_.member(ring, "tail"));
        if (place >= left_.size() || head + tail > left_[place]) {
            reader_.fail("more points than stood there are taken from a ring");
            head = tail = 0;
            return {};
        }
        left_[place] -= head + tail;
        return before_->points_of(before_->rings[place]);
    }

    void read_ring(const json& ring, DrawnRings& rings) {
        const auto tool = static_cast<RingTool>(reader_.choice(reader_.member(ring, "tool"), tool_names));
        std::size_t head = 0, tail = 0;
        const std::span<const Vec3> other = other_of(ring, head, tail);
        const json& points = reader_.member(ring, "points");
        const json* control = reader_.optional_member(ring, "control");
        const std::uint64_t count =
            head + tail + reader_.count_of_points(points) + (control ? reader_.count_of_points(*control) : 0);
        if (!reader_.ok()) return;
        if (count > points_left_) {
            is_over_limit_ = true;
            return reader_.fail("too many points");
        }
        points_left_ -= count;
        DrawnRing drawn{tool, static_cast<std::uint32_t>(rings.points.size()), 0,
                        static_cast<std::uint32_t>(rings.control_points.size()), 0};
        rings.points.insert(rings.points.end(), other.begin(),
                            other.begin() + static_cast<std::ptrdiff_t>(head));
        reader_.append_points(points, rings.points);
        rings.points.insert(rings.points.end(), other.end() - static_cast<std::ptrdiff_t>(tail), other.end());
        if (control) reader_.append_points(*control, rings.control_points);
        drawn.point_count = static_cast<std::uint32_t>(rings.points.size()) - drawn.first_point;
        drawn.control_count = static_cast<std::uint32_t>(rings.control_points.size()) - drawn.first_control;
        rings.rings.push_back(drawn);
    }

    RecordReader& reader_;
    const DrawnRings* before_;
    std::vector<std::size_t> left_;  // as in the writer
    std::uint64_t& points_left_;
    bool is_over_limit_ = false;
};

// Reads the changes of one edit. A later change of a key finds what an earlier one left.
class ChangeReader {
  public:
    ChangeReader(RecordReader& reader, const Drawing& drawing, std::uint64_t& points_left)
        : reader_(reader), drawing_(drawing), points_left_(points_left) {}

    bool is_over_limit() const { return is_over_limit_; }

    Change read(const json& value) {
        Change change;
        change.key = key_of(value);
        const json& after = reader_.member(value, "to");
        if (!reader_.ok()) return change;
        const auto changed = changed_.find(change.key);
        change.before = changed != changed_.end() ? changed->second : drawing_.value(change.key);
        if (!after.is_null()) change.after = value_of(change, after);
        if (reader_.ok() && !is_of_kind(change.key, change.after)) reader_.fail("an order is expected");
        changed_[change.key] = change.after;
        return change;
    }

  private:
    DrawingKey key_of(const json& value) {
        for (std::size_t i = 0; i < subject_names.size(); ++i) {
            const json* key = reader_.optional_member(value, subject_names[i].data());
            if (!key) continue;
            const auto subject = static_cast<Subject>(i);
            if (subject == Subject::order) return DrawingKey::of_order();
            if (subject != Subject::rings && subject != Subject::proposal)
                return {subject, reader_.integer<std::int32_t>(*key), 0};
            const json& pair = reader_.array(*key, 2);
            if (pair.empty()) return {};
            return {subject, reader_.integer<std::int32_t>(pair[0]), reader_.integer<std::int32_t>(pair[1])};
        }
        reader_.fail("a change of nothing that the program knows");
        return {};
    }

    DrawingValue value_of(const Change& change, const json& value) {
        switch (change.key.subject) {
            case Subject::structure:
                return drawing_value(structure_of(change.key.first, value));
            case Subject::order:
                return drawing_value(order_of(value));
            case Subject::plane:
                return drawing_value(plane_of(value));
            case Subject::rings:
            case Subject::proposal: {
                const auto* before = std::get_if<std::shared_ptr<const DrawnRings>>(&change.before);
                RingsReader rings(reader_, before ? before->get() : nullptr, points_left_);
                DrawingValue read = drawing_value(rings.read(value));
                is_over_limit_ |= rings.is_over_limit();
                return read;
            }
            case Subject::pin:
                return drawing_value(pin_of(value));
        }
        return {};
    }

    DrawnStructure structure_of(std::int32_t number, const json& value) {
        DrawnStructure drawn{{number, reader_.text(reader_.member(value, "name")), {}},
                             reader_.boolean(reader_.member(value, "locked"))};
        const json& color = reader_.array(reader_.member(value, "color"), 3);
        for (std::size_t i = 0; i < color.size(); ++i)
            drawn.structure.color[i] = reader_.integer<std::uint8_t>(color[i]);
        return drawn;
    }

    StructureOrder order_of(const json& value) {
        StructureOrder order;
        for (const json& number : reader_.array(value))
            order.push_back(reader_.integer<std::int32_t>(number));
        return order;
    }

    DrawnPlane plane_of(const json& value) {
        const auto point = [&](const char* key) { return reader_.point(reader_.member(value, key)); };
        return {{point("origin"), point("u"), point("v"), point("normal")},
                reader_.text(reader_.member(value, "name")),
                reader_.number(reader_.member(value, "thickness_mm")),
                reader_.boolean(reader_.member(value, "left_out"))};
    }

    ContourPlace contour_place_of(const json& value) {
        return {{reader_.integer<std::int32_t>(reader_.member(value, "plane")),
                 reader_.integer<std::int32_t>(reader_.member(value, "structure"))},
                reader_.point(reader_.member(value, "point"))};
    }

    TopologyPin pin_of(const json& value) {
        return {contour_place_of(reader_.member(value, "first")),
                contour_place_of(reader_.member(value, "second")),
                reader_.boolean(reader_.member(value, "joined"))};
    }

    RecordReader& reader_;
    const Drawing& drawing_;
    std::uint64_t& points_left_;
    std::map<DrawingKey, DrawingValue> changed_;
    bool is_over_limit_ = false;
};

// Nothing where it is no JSON.
std::optional<json> parsed(std::string_view record) {
    json value = json::parse(record.begin(), record.end(), nullptr, false);
    if (value.is_discarded()) return std::nullopt;
    return value;
}

}  // namespace

Result<DrawingSource> read_head(std::string_view record) {
    const std::optional<json> head = parsed(record);
    RecordReader reader;
    const Error no_project{ErrorKind::input, "E-PRJ-001", "the file is no project of anatomesh", {}, {}};
    if (!head || !head->is_object()) return no_project;
    if (reader.text(reader.member(*head, "format")) != project_format) return no_project;
    const auto version = reader.integer<std::int64_t>(reader.member(*head, "version"));
    if (!reader.ok() || version < 1) return no_project;
    if (version > project_version) {
        Error newer{ErrorKind::input,
                    "E-PRJ-002",
                    "the project has version " + std::to_string(version) +
                        ", and this program knows versions up to " + std::to_string(project_version),
                    {},
                    "open it with a newer program"};
        newer.place.value = std::to_string(version);
        return newer;
    }
    constexpr std::array<std::string_view, 2> spaces{"LPS", "unknown"};
    constexpr std::array<std::string_view, 1> units{"mm"};
    DrawingSource source;
    source.frame = reader.choice(reader.member(*head, "space"), spaces) == 0 ? Frame::lps : Frame::unknown;
    reader.choice(reader.member(*head, "unit"), units);
    source.pixel_mm = reader.number(reader.member(*head, "pixel_mm"));
    source.slice_thickness_mm = reader.number(reader.member(*head, "slice_thickness_mm"));
    if (reader.ok() && (source.pixel_mm < 0 || source.slice_thickness_mm < 0))
        reader.fail("a size is negative");
    if (!reader.ok()) return bad_record(reader.fault());
    return source;
}

Result<ProjectRecord> read_record(std::string_view text, std::uint64_t number, const Drawing& drawing,
                                  std::uint64_t& points_left) {
    const std::optional<json> value = parsed(text);
    if (!value) return bad_record("it is no JSON");
    RecordReader reader;
    if (reader.integer<std::uint64_t>(reader.member(*value, "n")) != number && reader.ok())
        return bad_record("records are missing before it, or are there twice");
    constexpr std::array<std::string_view, 3> moves{"apply", "undo", "redo"};
    ProjectRecord record;
    record.move = static_cast<ProjectRecord::Move>(reader.choice(reader.member(*value, "do"), moves));
    record.edit.name = reader.text(reader.member(*value, "name"));
    if (reader.ok() && record.move == ProjectRecord::Move::apply) {
        ChangeReader changes(reader, drawing, points_left);
        for (const json& change : reader.array(reader.member(*value, "changes"))) {
            record.edit.changes.push_back(changes.read(change));
            if (!reader.ok()) break;
        }
        if (changes.is_over_limit())
            return Error{ErrorKind::limit,
                         "E-PRJ-011",
                         "the edits of the project hold too many points",
                         {},
                         "raise the limit with --limit project-points=N if the file is right"};
    }
    if (!reader.ok()) return bad_record(reader.fault());
    return record;
}

}  // namespace anatomesh
