#include "anatomesh_io/contour/json_reader.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

using nlohmann::json;

// Values nested deeper are refused, so that a hostile file takes no memory. [levels; >= 4; B]
constexpr std::size_t max_depth = 64;
// A longer text is refused, so that a hostile file takes no memory. [bytes; >= 64; B]
constexpr std::size_t max_string_bytes = std::size_t{1} << 20;
// It stands for the slice of a contour until all of the file is read. [index; 2^32 - 1; D]
constexpr std::uint32_t unresolved = 0xFFFFFFFFu;

// The objects and arrays of the format.
enum class Node : std::uint8_t {
    root,
    structures,
    structure,
    color,
    slices,
    slice,
    plane,
    vector,
    contours,
    contour,
    points,
    point,
    ignored
};

// What may stand in an object, and what a container holds. `object` says which of the two `child` is.
struct Member {
    Node parent;
    const char* key;  // nullptr: the elements of an array
    Node child;       // ignored: a plain value, not a container
    bool object;
    bool required;
    const char* wanted;
};

constexpr Member members[] = {
    {Node::root, "format", Node::ignored, false, true, "the text anatomesh-contours"},
    {Node::root, "version", Node::ignored, false, true, "the number 1"},
    {Node::root, "space", Node::ignored, false, false, "the text LPS, RAS or unknown"},
    {Node::root, "unit", Node::ignored, false, true, "the text mm"},
    {Node::root, "pixel_mm", Node::ignored, false, false, "a number"},
    {Node::root, "slice_thickness_mm", Node::ignored, false, false, "a number"},
    {Node::root, "coverage", Node::ignored, false, false, "the text complete or drawn"},
    {Node::root, "exclusive", Node::ignored, false, false, "true or false"},
    {Node::root, "structures", Node::structures, false, true, "an array of structures"},
    {Node::root, "slices", Node::slices, false, true, "an array of slices"},
    {Node::structures, nullptr, Node::structure, true, false, "a structure (an object)"},
    {Node::structure, "number", Node::ignored, false, true, "a whole number"},
    {Node::structure, "name", Node::ignored, false, false, "a text"},
    {Node::structure, "color", Node::color, false, false, "an array of three whole numbers"},
    {Node::color, nullptr, Node::ignored, false, false, "a whole number from 0 to 255"},
    {Node::slices, nullptr, Node::slice, true, false, "a slice (an object)"},
    {Node::slice, "name", Node::ignored, false, false, "a text"},
    {Node::slice, "plane", Node::plane, true, false, "a plane (an object)"},
    {Node::slice, "contours", Node::contours, false, true, "an array of contours"},
    {Node::plane, "origin", Node::vector, false, true, "an array of three numbers"},
    {Node::plane, "normal", Node::vector, false, true, "an array of three numbers"},
    {Node::vector, nullptr, Node::ignored, false, false, "a number"},
    {Node::contours, nullptr, Node::contour, true, false, "a contour (an object)"},
    {Node::contour, "structure", Node::ignored, false, true, "a whole number"},
    {Node::contour, "kind", Node::ignored, false, false, "the text closed, closed_xor, open or points"},
    {Node::contour, "points", Node::points, false, true, "an array of points"},
    {Node::points, nullptr, Node::point, false, false, "a point (an array of three numbers)"},
    {Node::point, nullptr, Node::ignored, false, false, "a number"},
};

const Member* member_of(Node parent, const std::string* key) {
    for (const Member& member : members)
        if (member.parent == parent && (key ? member.key && *key == member.key : !member.key)) return &member;
    return nullptr;
}

struct Level {
    Node node;
    bool is_array;
    std::uint64_t count = 0;         // of an array: values begun
    const Member* member = nullptr;  // of an object: what the last key names; of an array: its elements
    std::string key;                 // the last key
    std::set<std::string, std::less<>> keys;
};

// Takes the parser's events; the first error stops it.
class Handler final : public nlohmann::json_sax<json> {
  public:
    Handler(RawBuilder& builder, bool cut) : builder_(builder), cut_(cut) {}

    std::optional<Error> error;

    bool null() override { return arrive() && (ignoring() || fail_wanted("null")); }
    bool boolean(bool value) override { return arrive() && (ignoring() || take_boolean(value)); }
    bool number_integer(json::number_integer_t value) override {
        return number(static_cast<double>(value), std::to_string(value));
    }
    bool number_unsigned(json::number_unsigned_t value) override {
        return number(static_cast<double>(value), std::to_string(value));
    }
    bool number_float(json::number_float_t value, const std::string& text) override {
        return number(value, text);
    }
    bool string(std::string& value) override { return arrive() && (ignoring() || take_string(value)); }
    bool binary(json::binary_t&) override { return arrive() && fail_wanted("binary data"); }

    bool start_object(std::size_t) override { return open(true); }
    bool start_array(std::size_t) override { return open(false); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }

    bool key(std::string& name) override {
        Level& top = levels_.back();
        top.key = name;
        if (!top.keys.insert(name).second) return fail("E-JSN-005", "the member occurs twice", {});
        top.member = top.node == Node::ignored ? nullptr : member_of(top.node, &name);
        if (!top.member && top.node != Node::ignored && unknown_keys_.insert(name).second)
            builder_.context().warn({"W-JSN-001",
                                     path() + ": the program does not know a member of this name",
                                     {builder_.file(), {}, {}, {}, {}},
                                     "it was ignored everywhere"});
        return true;
    }

    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::detail::exception& reason) override {
        if (cut_)
            return fail("E-JSN-008", "a text is longer than " + std::to_string(max_string_bytes) + " bytes",
                        {});
        if (reason.id == 406) return fail("E-JSN-004", "the number is beyond what a double can hold", {});
        std::string_view what = reason.what();
        if (const auto bracket = what.find("] "); bracket != std::string_view::npos)
            what.remove_prefix(bracket + 2);
        bool changed = false;
        return fail("E-JSN-001",
                    "byte " + std::to_string(position) + ": the file is no valid JSON, or it is cut off: " +
                        valid_utf8(what.substr(0, 300), changed),
                    {});
    }

    // Contours name structures that may come after them.
    Status resolve_structures() {
        for (std::size_t i = 0; i < numbers_.size(); ++i) {
            const auto structure = builder_.find_structure(numbers_[i]);
            if (!structure) {
                return Error{
                    ErrorKind::input, "E-JSN-007",
                    "the contour names a structure that is not in `structures`",
                    Place{builder_.file(), {}, {}, builder_.contour(i).name, std::to_string(numbers_[i])},
                    "add the structure, or correct the number"};
            }
            builder_.set_structure(i, *structure);
        }
        return Nothing{};
    }

  private:
    bool ignoring() const { return levels_.back().node == Node::ignored || !levels_.back().member; }

    // A value begins.
    bool arrive() {
        if (levels_.empty()) return fail("E-JSN-003", "an object is expected", {});
        if (levels_.back().is_array) ++levels_.back().count;
        return true;
    }

    bool open(bool is_object) {
        Node node = Node::root;
        if (levels_.empty()) {
            if (!is_object) return fail("E-JSN-003", "an object is expected", "an array");
        } else {
            if (!arrive()) return false;
            const Member* member = levels_.back().member;
            if (ignoring())
                node = Node::ignored;
            else if (member->child == Node::ignored || member->object != is_object)
                return fail_wanted(is_object ? "an object" : "an array");
            else
                node = member->child;
        }
        if (levels_.size() >= max_depth)
            return fail("E-JSN-002", "the values are nested deeper than " + std::to_string(max_depth), {});
        if (node == Node::contour && !begin_contour()) return false;
        if (node == Node::slice) begin_slice();
        if (node == Node::structure) structure_ = {.number = 0, .name = {}};
        levels_.push_back({.node = node, .is_array = !is_object, .key = {}, .keys = {}});
        if (!is_object && node != Node::ignored) levels_.back().member = member_of(node, nullptr);
        return true;
    }

    bool close() {
        const Level& top = levels_.back();
        if (!top.is_array) {
            for (const Member& member : members)
                if (member.parent == top.node && member.required && !top.keys.contains(member.key))
                    return fail_missing(member);
        } else if ((top.node == Node::point || top.node == Node::vector || top.node == Node::color) &&
                   top.count != 3) {
            return fail_count(top.count);
        }
        const Node node = top.node;
        const bool done = node == Node::point       ? end_point()
                          : node == Node::vector    ? end_vector()
                          : node == Node::structure ? end_structure()
                          : node == Node::slice     ? end_slice()
                          : node == Node::color     ? end_color()
                          : node == Node::plane     ? end_plane()
                                                    : true;
        levels_.pop_back();
        return done;
    }

    bool number(double value, const std::string& text) {
        if (!arrive()) return false;
        if (ignoring()) return true;
        const Level& top = levels_.back();
        if (top.node == Node::point || top.node == Node::vector || top.node == Node::color) {
            if (top.count > 3) return true;  // the count is refused at the end
            triple_[top.count - 1] = value;
            return true;
        }
        if (top.key == "version") return value == 1 || fail("E-JSN-004", "this version is not known", text);
        if (top.key == "pixel_mm") {
            builder_.pixel_mm = value;
            return (value >= 0 && value <= 1e3) ||
                   fail("E-JSN-004", "the pixel size must be from 0 to 1000 mm", text);
        }
        if (top.key == "slice_thickness_mm") {
            builder_.slice_thickness_mm = value;
            return value == 0 || (value >= 1e-3 && value <= 1e3) ||
                   fail("E-JSN-004", "the slice thickness must be 0, or from 0.001 to 1000 mm", text);
        }
        if (top.key == "number" || top.key == "structure") return take_number(value, text);
        return fail_wanted(text);
    }

    bool take_number(double value, const std::string& text) {
        if (!(value >= -2147483648.0 && value <= 2147483647.0 && value == std::floor(value)))
            return fail("E-JSN-004", "a whole number of 32 bits is expected", text);
        const auto whole = static_cast<std::int32_t>(value);
        if (levels_.back().node == Node::structure) {
            structure_.number = whole;
            return !builder_.find_structure(whole) ||
                   fail("E-JSN-007", "two structures have the same number", text);
        }
        numbers_.back() = whole;
        if (const auto structure = builder_.find_structure(whole))
            builder_.set_structure(builder_.contour_count() - 1, *structure);
        return true;
    }

    bool take_boolean(bool value) {
        if (levels_.back().is_array || levels_.back().key != "exclusive")
            return fail_wanted(value ? "true" : "false");
        builder_.exclusive = value;
        return true;
    }

    bool take_string(const std::string& value) {
        const Level& top = levels_.back();
        if (top.is_array) return fail_wanted(value);
        if (top.key == "name") {
            (top.node == Node::structure ? structure_.name : slice_name_) = value;
            return true;
        }
        if (top.key == "format") return value == "anatomesh-contours" || fail_value(value);
        if (top.key == "unit") return value == "mm" || fail_value(value);
        if (top.key == "space") {
            builder_.frame = value == "LPS"   ? FileFrame::lps
                             : value == "RAS" ? FileFrame::ras
                                              : FileFrame::unknown;
            return builder_.frame != FileFrame::unknown || value == "unknown" || fail_value(value);
        }
        if (top.key == "coverage") {
            builder_.complete = value == "complete";
            return builder_.complete || value == "drawn" || fail_value(value);
        }
        if (top.key == "kind") return take_kind(value);
        return fail_wanted(value);
    }

    bool take_kind(const std::string& value) {
        constexpr std::pair<const char*, ContourKind> kinds[] = {
            {"closed", ContourKind::closed_planar},
            {"closed_xor", ContourKind::closed_planar_xor},
            {"open", ContourKind::open},
            {"points", ContourKind::point}};
        for (const auto& [name, kind] : kinds) {
            if (value != name) continue;
            builder_.set_kind(builder_.contour_count() - 1, kind);
            return true;
        }
        return fail_value(value);
    }

    bool begin_contour() {
        if (builder_.context().cancelled()) return stop(cancelled_error());
        numbers_.push_back(0);
        return check(builder_.begin_contour(unresolved, ContourKind::closed_planar, -1, path()));
    }
    void begin_slice() {
        slice_name_.clear();
        has_plane_ = false;
        first_contour_ = builder_.contour_count();
    }

    bool end_point() {
        Status added = builder_.add_point({triple_[0], triple_[1], triple_[2]});
        if (added.ok()) return true;
        Error reason = std::move(added).error();
        reason.place.contour = parent_path();
        return stop(std::move(reason));
    }
    bool end_vector() {
        const std::string& which = levels_[levels_.size() - 2].key;
        (which == "origin" ? origin_ : normal_) = {triple_[0], triple_[1], triple_[2]};
        return true;
    }
    bool end_color() {
        for (std::size_t i = 0; i < 3; ++i) {
            if (!(triple_[i] >= 0 && triple_[i] <= 255 && triple_[i] == std::floor(triple_[i])))
                return fail_value("");
            structure_.color[i] = static_cast<std::uint8_t>(triple_[i]);
        }
        return true;
    }
    bool end_structure() {
        auto added = builder_.add_structure(std::move(structure_));
        return added.ok() || stop(std::move(added).error());
    }
    bool end_plane() {
        has_plane_ = true;
        plane_path_ = parent_path();
        return true;
    }
    bool end_slice() {
        if (!has_plane_) return true;
        auto plane =
            builder_.add_plane(origin_, normal_, slice_name_, {builder_.file(), plane_path_, {}, {}, {}});
        if (!plane.ok()) return stop(std::move(plane).error());
        for (std::size_t i = first_contour_; i < builder_.contour_count(); ++i)
            builder_.set_plane(i, static_cast<std::int32_t>(plane.value()));
        return true;
    }

    // The path of the first `depth` levels: slices[3].contours[0].points[17].
    std::string path_of(std::size_t depth) const {
        std::string path;
        for (std::size_t i = 0; i < depth; ++i) {
            const Level& level = levels_[i];
            if (level.is_array) {
                if (level.count > 0) path += "[" + std::to_string(level.count - 1) + "]";
            } else if (!level.key.empty()) {
                path += (path.empty() ? "" : ".") + shown(level.key);
            }
        }
        return path;
    }
    std::string path() const { return path_of(levels_.size()); }
    std::string parent_path() const { return path_of(levels_.size() - 1); }

    bool stop(Error reason) {
        error = std::move(reason);
        return false;
    }
    bool check(Status status) { return status.ok() || stop(std::move(status).error()); }
    bool fail_at(const std::string& where, const char* code, const std::string& message,
                 std::string_view value) {
        bool changed = false;
        return stop({ErrorKind::input,
                     code,
                     (where.empty() ? "" : where + ": ") + message,
                     {builder_.file(), {}, {}, {}, valid_utf8(shown(value), changed)},
                     "correct the file; schemas/contours.schema.json describes it"});
    }
    bool fail(const char* code, const std::string& message, std::string_view value) {
        return fail_at(path(), code, message, value);
    }
    bool fail_wanted(std::string_view value) {
        return fail("E-JSN-003", std::string(levels_.back().member->wanted) + " is expected", value);
    }
    bool fail_value(std::string_view value) {
        const Level& top = levels_.back();
        const char* wanted = top.member ? top.member->wanted : "another value";
        return fail("E-JSN-004", std::string(wanted) + " is expected", value);
    }
    bool fail_count(std::uint64_t count) {
        return fail_at(parent_path(), "E-JSN-003", "three numbers are expected",
                       std::to_string(count) + " numbers");
    }
    bool fail_missing(const Member& member) {
        return fail_at(parent_path(), "E-JSN-006",
                       std::string("`") + member.key + "` is missing (" + member.wanted + ")", {});
    }

    RawBuilder& builder_;
    bool cut_;  // the text was cut within an overlong string
    std::vector<Level> levels_;
    std::set<std::string> unknown_keys_;
    std::vector<std::int32_t> numbers_;  // structure number of every contour
    std::array<double, 3> triple_{};
    Structure structure_;
    std::string slice_name_, plane_path_;
    Vec3 origin_, normal_;
    bool has_plane_ = false;
    std::size_t first_contour_ = 0;
};

// Where the first overlong string exceeds its limit, or the size of the text. The parser holds a string
// several times, so it must not meet one of a size that the file chooses.
std::size_t end_before_long_string(std::string_view text) {
    bool inside = false;
    std::size_t begin = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '"') {
            inside = !inside;
            begin = i;
        } else if (inside && text[i] == '\\') {
            ++i;
        }
        if (inside && i - begin > max_string_bytes) return i;
    }
    return text.size();
}

}  // namespace

Status read_json_contours(std::string_view text, RawBuilder& builder) {
    if (text.starts_with("\xEF\xBB\xBF"))
        return Error{ErrorKind::input,
                     "E-JSN-001",
                     "the file begins with a byte order mark",
                     {builder.file(), {}, {}, {}, {}},
                     "save the file as UTF-8 without a byte order mark"};
    const std::size_t end = end_before_long_string(text);
    Handler handler(builder, end < text.size());
    const bool whole = json::sax_parse(text.substr(0, end), &handler);
    if (!whole && handler.error) return *std::move(handler.error);
    return handler.resolve_structures();
}

}  // namespace anatomesh
