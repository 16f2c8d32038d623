#include "anatomesh_io/contour/csl_reader.h"

#include <utility>
#include <vector>

#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

class CslReader {
  public:
    CslReader(std::string_view text, RawBuilder& builder) : text_(text), builder_(builder) {}

    Status read() {
        if (next_word() != "CSLC")
            return failure("E-CSL-001", "the file is no CSL file: its first word is not CSLC", word_);
        ANATOMESH_TRY(const auto planes, count("number of planes", 8));
        ANATOMESH_TRY([[maybe_unused]] const auto labels, integer("number of labels"));
        for (std::uint64_t i = 0; i < planes; ++i) {
            if (builder_.context().cancelled()) return cancelled_error();
            plane_name_ = std::to_string(i);
            ANATOMESH_CHECK_STATUS(read_plane());
        }
        plane_name_.clear();
        if (!next_word().empty())
            return failure("E-CSL-006",
                           "the file continues after the last of the planes that line 2 announces", word_);
        if (unused_vertices_ > 0)
            builder_.context().warn({"W-CSL-001",
                                     std::to_string(unused_vertices_) + " vertices belong to no component",
                                     {builder_.file(), {}, {}, {}, {}},
                                     "they were left out"});
        return Nothing{};
    }

  private:
    struct Component {
        bool is_hole = false;
        std::uint64_t parent = 0;
        std::int32_t label = 0;
        std::size_t contour = 0;  // index in the builder
    };

    Status read_plane() {
        ANATOMESH_TRY(const auto id, integer("plane id"));
        plane_name_ = std::to_string(id);
        ANATOMESH_TRY(const auto vertex_count, count("number of vertices", 6));
        ANATOMESH_TRY(const auto component_count, count("number of components", 4));
        double abcd[4];
        for (double& coefficient : abcd) {
            ANATOMESH_TRY(coefficient, number("coefficient of the plane"));
        }
        ANATOMESH_TRY(const auto plane, add_plane(abcd));
        ANATOMESH_CHECK_STATUS(read_vertices(vertex_count));
        components_.clear();
        for (std::uint64_t i = 0; i < component_count; ++i) {
            ANATOMESH_CHECK_STATUS(read_component(i, static_cast<std::int32_t>(plane)));
        }
        for (std::uint64_t i = 0; i < component_count; ++i) {
            ANATOMESH_CHECK_STATUS(settle_hole(i));
        }
        for (const bool used : used_) unused_vertices_ += used ? 0 : 1;
        return Nothing{};
    }

    // The origin on the axis that the normal leans to most: exact for planes across an axis, and the one
    // point from which a writer finds D again.
    Result<std::uint32_t> add_plane(const double (&abcd)[4]) {
        const Vec3 normal{abcd[0], abcd[1], abcd[2]};
        const double ax = std::abs(normal.x), ay = std::abs(normal.y), az = std::abs(normal.z);
        Vec3 origin;
        if (az >= ax && az >= ay && az > 0)
            origin.z = 0.0 - abcd[3] / normal.z;
        else if (ay >= ax && ay > 0)
            origin.y = 0.0 - abcd[3] / normal.y;
        else if (ax > 0)
            origin.x = 0.0 - abcd[3] / normal.x;
        return builder_.add_plane(origin, normal, plane_name_, place({}));
    }

    Status read_vertices(std::uint64_t vertex_count) {
        if (vertex_count > builder_.limits().points)
            return Error{ErrorKind::limit, "E-CIO-004",
                         "more than " + std::to_string(builder_.limits().points) + " points in all",
                         place(std::to_string(vertex_count)),
                         "raise the limit with --limit when the file is right (--limits lists them)"};
        vertices_.clear();
        vertices_.reserve(vertex_count);
        for (std::uint64_t i = 0; i < vertex_count; ++i) {
            Vec3 point;
            ANATOMESH_TRY(point.x, number("coordinate"));
            ANATOMESH_TRY(point.y, number("coordinate"));
            ANATOMESH_TRY(point.z, number("coordinate"));
            vertices_.push_back(point);
        }
        used_.assign(vertex_count, false);
        return Nothing{};
    }

    Status read_component(std::uint64_t index, std::int32_t plane) {
        Component component;
        const std::string_view size_word = next_word();
        const std::size_t h = size_word.find('h');
        const auto size = parse_integer<std::uint64_t>(size_word.substr(0, h));
        if (size_word.empty()) return truncated();
        if (!size) return failure("E-CSL-003", "a component's number of vertices is expected", size_word);
        if (*size == 0 || *size > (text_.size() - position_) / 2)
            return failure("E-CSL-004", "a component has an impossible number of vertices", size_word);
        if (h != std::string_view::npos) {
            const auto parent = parse_integer<std::uint64_t>(size_word.substr(h + 1));
            if (!parent) return failure("E-CSL-003", "a hole's parent is expected after h", size_word);
            component.is_hole = true;
            component.parent = *parent;
        }
        ANATOMESH_TRY(component.label, integer("label"));
        ANATOMESH_TRY(const auto structure, builder_.structure_of(component.label));
        component.contour = builder_.contour_count();
        ANATOMESH_CHECK_STATUS(
            builder_.begin_contour(structure, ContourKind::closed_planar, plane,
                                   "plane " + plane_name_ + ", component " + std::to_string(index)));
        ANATOMESH_CHECK_STATUS(builder_.expect_points(*size));
        for (std::uint64_t i = 0; i < *size; ++i) {
            const std::string_view word = next_word();
            if (word.empty()) return truncated();
            const auto vertex = parse_integer<std::uint64_t>(word);
            if (!vertex || *vertex >= vertices_.size())
                return failure(
                    "E-CSL-005",
                    "component " + std::to_string(index) + " names a vertex that the plane does not have",
                    word);
            used_[*vertex] = true;
            ANATOMESH_CHECK_STATUS(builder_.add_point(vertices_[*vertex]));
        }
        components_.push_back(component);
        return Nothing{};
    }

    // A hole is of its parent's structure.
    Status settle_hole(std::uint64_t index) {
        const Component& hole = components_[index];
        if (!hole.is_hole) return Nothing{};
        if (hole.parent >= components_.size() || components_[hole.parent].is_hole)
            return failure(
                "E-CSL-007",
                "component " + std::to_string(index) + " is a hole without an outer contour as its parent",
                std::to_string(hole.parent));
        const Component& parent = components_[hole.parent];
        builder_.set_hole(hole.contour);
        if (parent.label == hole.label) return Nothing{};
        Place where = place(std::to_string(hole.label));
        where.contour = std::to_string(index);
        builder_.context().warn({"W-CSL-002", "the label of a hole differs from the label of its outline",
                                 std::move(where),
                                 "the hole was read with label " + std::to_string(parent.label)});
        builder_.set_structure(hole.contour, *builder_.find_structure(parent.label));
        return Nothing{};
    }

    std::string_view next_word() {
        while (position_ < text_.size() && is_blank(text_[position_])) line_ += text_[position_++] == '\n';
        const std::size_t begin = position_;
        while (position_ < text_.size() && !is_blank(text_[position_])) ++position_;
        return word_ = text_.substr(begin, position_ - begin);
    }

    Result<double> number(const char* what) {
        if (next_word().empty()) return truncated();
        const auto value = parse_number(word_);
        if (!value) return failure("E-CSL-003", std::string("a number is expected: ") + what, word_);
        return *value;
    }

    Result<std::int32_t> integer(const char* what) {
        if (next_word().empty()) return truncated();
        const auto value = parse_integer<std::int32_t>(word_);
        if (!value) return failure("E-CSL-003", std::string("a whole number is expected: ") + what, word_);
        return *value;
    }

    // A count of things of at least `bytes_each` characters, all of which are still to come.
    Result<std::uint64_t> count(const char* what, std::uint64_t bytes_each) {
        if (next_word().empty()) return truncated();
        const auto value = parse_integer<std::uint64_t>(word_);
        if (!value) return failure("E-CSL-003", std::string("a count is expected: ") + what, word_);
        if (*value > (text_.size() - position_ + 1) / bytes_each)
            return failure("E-CSL-004",
                           std::string("the rest of the file is too short for this number: ") + what, word_);
        return *value;
    }

    Place place(std::string_view value) const { return {builder_.file(), plane_name_, {}, {}, shown(value)}; }
    Error failure(const char* code, const std::string& message, std::string_view value) const {
        return {ErrorKind::input, code, "line " + std::to_string(line_) + ": " + message, place(value),
                "correct the file, or export it again"};
    }
    Error truncated() const { return failure("E-CSL-002", "the file ends too early", {}); }

    std::string_view text_, word_;
    std::size_t position_ = 0;
    std::uint64_t line_ = 1;
    RawBuilder& builder_;
    std::string plane_name_;
    std::vector<Vec3> vertices_;
    std::vector<bool> used_;
    std::vector<Component> components_;
    std::uint64_t unused_vertices_ = 0;
};

}  // namespace

Status read_csl(std::string_view text, RawBuilder& builder) {
    return CslReader(text, builder).read();
}

}  // namespace anatomesh
