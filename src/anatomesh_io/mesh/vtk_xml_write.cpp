#include <libdeflate.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <memory>
#include <new>

#include "anatomesh/base/parallel.h"
#include "anatomesh_io/mesh/vtk_xml.h"

namespace anatomesh {

namespace {

static_assert(std::endian::native == std::endian::little,
              "arrays are written in native order as LittleEndian");

// Arrays are packed in blocks of this size, each by itself, so that threads share them. [bytes; >= 4096; B]
constexpr std::size_t block_bytes = std::size_t{1} << 16;

const char* type_name(VtkType type) {
    constexpr const char* names[] = {"Int8",  "UInt8",  "Int16",   "UInt16",  "Int32", "UInt32",
                                     "Int64", "UInt64", "Float32", "Float64", "String"};
    return names[static_cast<std::size_t>(type)];
}

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '"':
                result += "&quot;";
                break;
            default:
                result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
        }
    }
    return result;
}

// XML allows neither "--" nor control characters in a comment.
std::string comment_text(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (c == '-' && !result.empty() && result.back() == '-') result += ' ';
        result += static_cast<unsigned char>(c) < 0x20 && c != '\n' ? ' ' : c;
    }
    return result;
}

// The XML head of a file, and the arrays that follow it, in order.
class DocumentWriter {
  public:
    void text(std::string_view line) { head_ += line; }

    void array(VtkArray array, bool with_tuples) {
        const bool is_string = array.type == VtkType::string;
        const std::size_t tuples =
            is_string ? static_cast<std::size_t>(std::count(array.bytes.begin(), array.bytes.end(), '\0'))
                      : array.tuples();
        head_ += is_string ? "        <Array type=\"" : "        <DataArray type=\"";
        head_ += type_name(array.type);
        head_ += "\" Name=\"" + escaped(array.name) + "\"";
        if (array.components != 1)
            head_ += " NumberOfComponents=\"" + std::to_string(array.components) + "\"";
        if (with_tuples) head_ += " NumberOfTuples=\"" + std::to_string(tuples) + "\"";
        head_ += " format=\"appended\" offset=\"";
        marks_.push_back(head_.size());  // the offset is known when the arrays before are compressed
        head_ += "\"/>\n";
        arrays_.push_back(std::move(array));
    }

    void section(const char* name, const std::vector<VtkArray>& arrays) {
        if (arrays.empty()) return;
        head_ += std::string("      <") + name + ">\n";
        for (const VtkArray& each : arrays) array(each, false);
        head_ += std::string("      </") + name + ">\n";
    }

    std::string bytes(const VtkWriteOptions& options) const;

  private:
    std::string head_;
    std::vector<std::size_t> marks_;  // positions in head_, one per array
    std::vector<VtkArray> arrays_;
};

void append_word(std::string& bytes, std::uint64_t word) {
    bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

// Doubles hardly ever repeat: Huffman codes alone give the same size in a third of the time. Where vertices
// repeat, libdeflate finds that in less than half of zlib's time; in what counts upwards it finds less.
enum class Coder { huffman, zlib, libdeflate };

Coder coder_of(const VtkArray& array) {
    if (array.type == VtkType::float64 || array.type == VtkType::float32) return Coder::huffman;
    return array.name == "connectivity" ? Coder::libdeflate : Coder::zlib;
}

struct Block {
    std::string_view data;
    Coder coder = Coder::zlib;
};

std::string compressed_by_libdeflate(std::string_view data, int level) {
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(level), &libdeflate_free_compressor);
    if (!compressor) throw std::bad_alloc();
    std::string result(libdeflate_zlib_compress_bound(compressor.get(), data.size()), '\0');
    result.resize(
        libdeflate_zlib_compress(compressor.get(), data.data(), data.size(), result.data(), result.size()));
    assert(!result.empty());
    return result;
}

// A zlib stream (RFC 1950).
std::string compressed(const Block& block, int level) {
    if (block.coder == Coder::libdeflate) return compressed_by_libdeflate(block.data, level);
    // zlib's largest window, 32 kB, packs best. [bits; 9 to 15; D zlib]
    constexpr int window_bits = 15;
    // This is zlib's own default of memory for its tables. [1; 1 to 9; D zlib]
    constexpr int memory_level = 8;
    const int strategy = block.coder == Coder::huffman ? Z_HUFFMAN_ONLY : Z_DEFAULT_STRATEGY;
    z_stream stream{};
    if (deflateInit2(&stream, level, Z_DEFLATED, window_bits, memory_level, strategy) != Z_OK)
        throw std::bad_alloc();  // its only reason here
    std::string result(deflateBound(&stream, static_cast<uLong>(block.data.size())), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(block.data.data()));
    stream.avail_in = static_cast<uInt>(block.data.size());
    stream.next_out = reinterpret_cast<Bytef*>(result.data());
    stream.avail_out = static_cast<uInt>(result.size());
    [[maybe_unused]] const int status = deflate(&stream, Z_FINISH);
    assert(status == Z_STREAM_END);
    result.resize(stream.total_out);
    deflateEnd(&stream);
    return result;
}

std::string DocumentWriter::bytes(const VtkWriteOptions& options) const {
    // Blocks of all arrays in one list, compressed in any order, put together in theirs.
    std::vector<Block> blocks;
    std::vector<std::size_t> first_block{0};
    for (const VtkArray& array : arrays_) {
        const std::string_view all = array.bytes;
        for (std::size_t at = 0; at < all.size(); at += block_bytes)
            blocks.push_back({all.substr(at, block_bytes), coder_of(array)});
        first_block.push_back(blocks.size());
    }
    std::vector<std::string> packed(blocks.size());
    parallel_for(blocks.size(), 8, options.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            packed[i] = compressed(blocks[i], options.compression_level);
    });

    std::vector<std::uint64_t> offsets{0};
    for (std::size_t a = 0; a < arrays_.size(); ++a) {
        std::uint64_t size = 8 * (3 + first_block[a + 1] - first_block[a]);
        for (std::size_t b = first_block[a]; b < first_block[a + 1]; ++b) size += packed[b].size();
        offsets.push_back(offsets.back() + size);
    }
    std::string result;
    result.reserve(head_.size() + 20 * marks_.size() + offsets.back() + 100);
    std::size_t done = 0;
    for (std::size_t a = 0; a < marks_.size(); ++a) {
        result.append(head_, done, marks_[a] - done);
        result += std::to_string(offsets[a]);
        done = marks_[a];
    }
    result.append(head_, done, std::string::npos);
    result += "  <AppendedData encoding=\"raw\">\n   _";
    for (std::size_t a = 0; a < arrays_.size(); ++a) {
        append_word(result, first_block[a + 1] - first_block[a]);
        append_word(result, block_bytes);
        append_word(result, arrays_[a].bytes.size() % block_bytes);  // 0: the last block is full
        for (std::size_t b = first_block[a]; b < first_block[a + 1]; ++b)
            append_word(result, packed[b].size());
        for (std::size_t b = first_block[a]; b < first_block[a + 1]; ++b) result += packed[b];
    }
    result += "\n  </AppendedData>\n</VTKFile>\n";
    return result;
}

// 32 bits where they are enough: half the size.
VtkArray index_array(const char* name, const std::vector<std::int64_t>& values, bool wide) {
    if (wide) return VtkArray::of<std::int64_t>(name, values);
    std::vector<std::int32_t> narrow(values.size());
    std::transform(values.begin(), values.end(), narrow.begin(),
                   [](std::int64_t value) { return static_cast<std::int32_t>(value); });
    return VtkArray::of<std::int32_t>(name, narrow);
}

void put_cells(DocumentWriter& document, const char* name, const VtkCells& cells, std::size_t points,
               const std::vector<std::uint8_t>* types) {
    constexpr auto narrow = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
    const bool wide = points > narrow || cells.connectivity.size() > narrow;
    document.text(std::string("      <") + name + ">\n");
    document.array(index_array("connectivity", cells.connectivity, wide), false);
    document.array(index_array("offsets", cells.offsets, wide), false);
    if (types) document.array(VtkArray::of<std::uint8_t>("types", *types), false);
    document.text(std::string("      </") + name + ">\n");
}

std::string count_attribute(const char* name, std::size_t count) {
    return std::string(" NumberOf") + name + "=\"" + std::to_string(count) + "\"";
}

}  // namespace

std::string format_vtk_xml(const VtkFile& file, std::string_view comment, const VtkWriteOptions& options) {
    const bool grid = file.kind == VtkDataSet::unstructured_grid;
    const std::string kind = grid ? "UnstructuredGrid" : "PolyData";
    DocumentWriter document;
    document.text("<?xml version=\"1.0\"?>\n");
    if (!comment.empty()) document.text("<!-- " + comment_text(comment) + " -->\n");
    document.text("<VTKFile type=\"" + kind +
                  "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
                  "compressor=\"vtkZLibDataCompressor\">\n  <" +
                  kind + ">\n");
    if (!file.field_data.empty()) {
        document.text("      <FieldData>\n");
        for (const VtkArray& array : file.field_data) document.array(array, true);
        document.text("      </FieldData>\n");
    }
    document.text("    <Piece" + count_attribute("Points", file.points.size()));
    if (grid) {
        document.text(count_attribute("Cells", file.cells.size()));
    } else {
        document.text(
            count_attribute("Verts", file.verts.size()) + count_attribute("Lines", file.lines.size()) +
            count_attribute("Strips", file.strips.size()) + count_attribute("Polys", file.polys.size()));
    }
    document.text(">\n");
    document.section("PointData", file.point_data);
    document.section("CellData", file.cell_data);
    document.section("Points", {VtkArray::of_points(file.points)});
    if (grid) {
        put_cells(document, "Cells", file.cells, file.points.size(), &file.types);
    } else {
        put_cells(document, "Verts", file.verts, file.points.size(), nullptr);
        put_cells(document, "Lines", file.lines, file.points.size(), nullptr);
        put_cells(document, "Strips", file.strips, file.points.size(), nullptr);
        put_cells(document, "Polys", file.polys, file.points.size(), nullptr);
    }
    document.text("    </Piece>\n  </" + kind + ">\n");
    return document.bytes(options);
}

}  // namespace anatomesh
