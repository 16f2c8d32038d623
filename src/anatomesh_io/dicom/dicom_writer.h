// DicomWriter: a DICOM file as bytes, element by element. The same calls give the same bytes.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh_io/contour/dicom_layout.h"

namespace anatomesh {

// Little endian, in implicit or explicit VR. Elements of a data set or item must be given in ascending order
// of their tags (asserted). Values are padded to even length. Sequences and items have undefined length.
class DicomWriter {
  public:
    enum class Syntax : std::uint8_t { implicit_little, explicit_little };
    explicit DicomWriter(Syntax syntax) : syntax_(syntax) {}

    // `vr` has two letters; texts are padded with a blank, UI and bytes with NUL.
    void element(DicomTag tag, const char* vr, std::string_view value);
    void unsigned_short(DicomTag tag, std::initializer_list<std::uint16_t> values);
    void unsigned_shorts(DicomTag tag, std::span<const std::uint16_t> values);
    void unsigned_long(DicomTag tag, std::initializer_list<std::uint32_t> values);
    void tag_value(DicomTag tag, DicomTag value);         // AT
    void whole_number(DicomTag tag, std::int64_t value);  // IS
    // DS: the shortest text of at most 16 characters nearest to each value.
    void decimals(DicomTag tag, std::initializer_list<double> values);

    // An element, whole sequences among them, that another writer of the same syntax has written.
    void append(DicomTag tag, std::string_view element);

    void begin_sequence(DicomTag tag);
    void end_sequence();
    void begin_item();
    void end_item();

    // The data set.
    const std::string& bytes() const { return bytes_; }
    // The file: preamble, meta header, data set. Requires: all sequences ended.
    std::string file(const std::string& sop_class, const std::string& sop_instance) const;

  private:
    void header(DicomTag tag, const char* vr, std::uint32_t length);
    void number(std::uint32_t value, int size);

    Syntax syntax_;
    std::string bytes_;
    std::vector<DicomTag> last_{{0, 0}};  // of the data set and of every open item
};

// A decimal string (DS): at most 16 characters, the value nearest to `value` that these can hold.
void append_decimal_string(std::string& text, double value);

// `text` within `longest` bytes, without control characters and backslashes, cut between characters of UTF-8.
std::string dicom_safe(std::string_view text, std::size_t longest);

}  // namespace anatomesh
