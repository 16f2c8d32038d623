// Medit .mesh, as text: Frey, "MEDIT: an interactive mesh visualization software", INRIA RT-0253, 2001.
#include <array>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/description.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"

namespace anatomesh {

Result<std::string> format_medit(const std::string& path, const ModelFile& model, RunContext& context) {
    const TetMesh& mesh = model.mesh;
    if (!model.mid_nodes.empty()) {
        Error error = mesh_error("E-MDL-014", "a Medit file (.mesh) holds linear tetrahedra only", path);
        error.kind = ErrorKind::usage;
        error.next_step = "write .vtu, .msh, .inp or .feb, or linear tetrahedra";
        return error;
    }
    if (!model.grey.empty()) warn_cell_values("grey values", path, context);
    if (!model.material.empty()) warn_cell_values("materials", path, context);
    const std::vector<std::int32_t> numbers = region_numbers(model.description);
    MeshDescription described = model.description;
    described.materials.clear();  // no cell says which is its own
    std::string text = "MeshVersionFormatted 2\n";
    for (const std::string& line : description_lines(described)) text += "# " + line + "\n";
    text += "Dimension 3\nVertices\n";
    append_number(text, mesh.points.size());
    text += '\n';
    for (const Vec3& point : mesh.points) {
        for (const double coordinate : {point.x, point.y, point.z}) {
            append_number(text, coordinate);
            text += ' ';
        }
        text += "0\n";
    }
    text += "Tetrahedra\n";
    append_number(text, mesh.cells.size());
    text += '\n';
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        for (const std::uint32_t vertex : mesh.cells[c]) {
            append_number(text, std::uint64_t{vertex} + 1);
            text += ' ';
        }
        append_number(text, numbers[mesh.regions[c]]);
        text += '\n';
    }
    text += "End\n";
    return text;
}

namespace {

// The words of a Medit file; comment lines go to the description.
class MeditWords {
  public:
    MeditWords(std::string_view text, DescriptionReader& reader) : lines_(text), reader_(reader) {}

    // The next word; empty at the end.
    Result<std::string_view> next() {
        for (;;) {
            const std::string_view word = take_word(rest_);
            if (!word.empty() && word.front() != '#') return word;
            if (!word.empty()) {
                ANATOMESH_CHECK_STATUS(
                    reader_.take(std::string_view(word.data() + 1, rest_.data() + rest_.size())));
            }
            const auto line = lines_.next();
            if (!line) return std::string_view{};
            rest_ = *line;
        }
    }
    template <class T>
    Result<T> number(const std::string& path, const char* what) {
        ANATOMESH_TRY(const std::string_view word, next());
        const auto value = number_of<T>(word);
        if (!value) return expected(path, what, place());
        return *value;
    }
    std::string place() const { return lines_.place(); }
    std::size_t remaining() const { return rest_.size() + lines_.rest().size(); }

  private:
    Lines lines_;
    std::string_view rest_;
    DescriptionReader& reader_;
};

struct Section {
    const char* name;
    int numbers;  // per entry
};
// Sections that are passed over, with the kind of element they hold.
constexpr std::array<Section, 15> other_sections{{{"edges", 3},
                                                  {"triangles", 4},
                                                  {"quadrilaterals", 5},
                                                  {"corners", 1},
                                                  {"ridges", 1},
                                                  {"requiredvertices", 1},
                                                  {"requirededges", 1},
                                                  {"requiredtriangles", 1},
                                                  {"normals", 3},
                                                  {"tangents", 3},
                                                  {"normalatvertices", 2},
                                                  {"tangentatvertices", 2},
                                                  {"requiredtetrahedra", 1},
                                                  {"paralleltriangles", 1},
                                                  {"requiredquadrilaterals", 1}}};

class MeditReader {
  public:
    MeditReader(const std::string& path, std::string_view text)
        : path_(path), reader_(path), words_(text, reader_) {}
    Result<ModelFile> run(RunContext& context);

  private:
    // A count, held against what the rest of the file can hold: every number needs a digit and a blank.
    Result<std::size_t> count(std::size_t numbers_each) {
        ANATOMESH_TRY(const auto value, words_.number<std::uint64_t>(path_, "a count"));
        if (value > (words_.remaining() + 1) / (2 * numbers_each) || value >= no_cell) {
            return mesh_error("E-MDL-007", "the file is too short for the number of elements it states",
                              path_, words_.place());
        }
        return static_cast<std::size_t>(value);
    }
    Status vertices();
    Status tetrahedra();
    Status other(const std::string& name);

    const std::string& path_;
    DescriptionReader reader_;
    MeditWords words_;
    ModelFile model_;
    std::vector<std::int64_t> labels_;
    std::size_t left_out_ = 0;
};

Status MeditReader::vertices() {
    ANATOMESH_TRY(const std::size_t n, count(4));
    model_.mesh.points.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
        Vec3 point;
        for (double* coordinate : {&point.x, &point.y, &point.z}) {
            ANATOMESH_TRY(*coordinate, words_.number<double>(path_, "a coordinate"));
        }
        ANATOMESH_TRY([[maybe_unused]] const auto reference,
                      words_.number<std::int64_t>(path_, "a reference"));
        ANATOMESH_CHECK_STATUS(check_point(point, i, path_));
        model_.mesh.points.push_back(point);
    }
    return Nothing{};
}

Status MeditReader::tetrahedra() {
    ANATOMESH_TRY(const std::size_t n, count(5));
    model_.mesh.cells.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
        Cell cell;
        for (std::uint32_t& vertex : cell) {
            ANATOMESH_TRY(const auto number, words_.number<std::int64_t>(path_, "the number of a vertex"));
            if (number < 1 || static_cast<std::uint64_t>(number) > model_.mesh.points.size()) {
                return mesh_error("E-MDL-004",
                                  "a tetrahedron names vertex " + std::to_string(number) + " of " +
                                      std::to_string(model_.mesh.points.size()),
                                  path_, words_.place());
            }
            vertex = static_cast<std::uint32_t>(number - 1);
        }
        ANATOMESH_TRY(const auto label, words_.number<std::int64_t>(path_, "a reference"));
        model_.mesh.cells.push_back(cell);
        labels_.push_back(label);
    }
    return Nothing{};
}

Status MeditReader::other(const std::string& name) {
    for (const Section& section : other_sections) {
        if (name != section.name) continue;
        ANATOMESH_TRY(const std::size_t n, count(static_cast<std::size_t>(section.numbers)));
        for (std::size_t i = 0; i < n * static_cast<std::size_t>(section.numbers); ++i) {
            ANATOMESH_TRY([[maybe_unused]] const auto value, words_.number<double>(path_, "a number"));
        }
        if (name == "edges" || name == "triangles" || name == "quadrilaterals") left_out_ += n;
        return Nothing{};
    }
    return mesh_error("E-MDL-006", "the program does not read the section " + name.substr(0, 40), path_,
                      words_.place());
}

Result<ModelFile> MeditReader::run(RunContext& context) {
    for (;;) {
        ANATOMESH_TRY(const std::string_view word, words_.next());
        const std::string name = lower_case(word);
        if (name.empty() || name == "end") break;
        if (name == "meshversionformatted") {
            ANATOMESH_TRY(const auto version, words_.number<int>(path_, "a version"));
            if (version < 1 || version > 4) {
                return mesh_error("E-MDL-012", "the program reads versions 1 to 4 of the format only", path_,
                                  std::to_string(version));
            }
        } else if (name == "dimension") {
            ANATOMESH_TRY(const auto dimension, words_.number<int>(path_, "a dimension"));
            if (dimension != 3) {
                return mesh_error("E-MDL-012", "the program reads dimension 3 only", path_,
                                  std::to_string(dimension));
            }
        } else if (name == "vertices") {
            ANATOMESH_CHECK_STATUS(vertices());
        } else if (name == "tetrahedra") {
            ANATOMESH_CHECK_STATUS(tetrahedra());
        } else {
            ANATOMESH_CHECK_STATUS(other(name));
        }
    }
    if (model_.mesh.cells.empty()) return mesh_error("E-MDL-008", "the file has no tetrahedra", path_);
    warn_left_out(left_out_, "tetrahedra", path_, context);
    ANATOMESH_TRY(model_.mesh.regions, reader_.regions_of_labels(labels_, model_.mesh.cells.size()));
    model_.description = reader_.finish(context);
    return std::move(model_);
}

}  // namespace

Result<ModelFile> parse_medit(const std::string& path, Bytes content, RunContext& context) {
    return MeditReader(path, as_text(content)).run(context);
}

}  // namespace anatomesh
