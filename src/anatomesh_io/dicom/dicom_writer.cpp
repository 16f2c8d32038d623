#include "anatomesh_io/dicom/dicom_writer.h"

#include <cassert>
#include <charconv>
#include <cmath>
#include <string>

#include "anatomesh_io/contour/raw_builder.h"
#include "anatomesh_io/dicom/tags.h"

namespace anatomesh {

namespace {

// This length says that a delimiter ends the value. [bytes; 2^32 - 1; D DICOM PS3.5, section 7.1]
constexpr std::uint32_t undefined_length = 0xFFFFFFFFu;
constexpr DicomTag sequence_item_tag{0xFFFE, 0xE000}, item_end{0xFFFE, 0xE00D}, sequence_end{0xFFFE, 0xE0DD};
constexpr const char* implementation_uid = "2.25.231180546138466129170253893712506374981";

bool is_long(std::string_view vr) {
    return vr == "OB" || vr == "OW" || vr == "SQ" || vr == "UN" || vr == "UT" || vr == "OF" || vr == "UC";
}

void append_binary_number(std::string& bytes, std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i));
}

}  // namespace

void DicomWriter::number(std::uint32_t value, int size) {
    append_binary_number(bytes_, value, size);
}

void DicomWriter::header(DicomTag tag, const char* vr, std::uint32_t length) {
    assert(tag.group == 0xFFFE || last_.back() < tag);
    if (tag.group != 0xFFFE) last_.back() = tag;
    number(tag.group, 2);
    number(tag.element, 2);
    if (tag.group == 0xFFFE || syntax_ == Syntax::implicit_little) {
        number(length, 4);
        return;
    }
    bytes_ += vr;
    if (is_long(vr)) {
        number(0, 2);
        number(length, 4);
    } else {
        assert(length <= 0xFFFE);
        number(length, 2);
    }
}

void DicomWriter::element(DicomTag tag, const char* vr, std::string_view value) {
    const std::string_view kind(vr);
    header(tag, vr, static_cast<std::uint32_t>(value.size() + value.size() % 2));
    bytes_ += value;
    if (value.size() % 2 != 0)
        bytes_ += kind == "UI" || kind == "OB" || kind == "OW" || kind == "UN" ? '\0' : ' ';
}

void DicomWriter::unsigned_shorts(DicomTag tag, std::span<const std::uint16_t> values) {
    header(tag, "US", static_cast<std::uint32_t>(2 * values.size()));
    for (const std::uint16_t value : values) number(value, 2);
}
void DicomWriter::unsigned_short(DicomTag tag, std::initializer_list<std::uint16_t> values) {
    unsigned_shorts(tag, {values.begin(), values.size()});
}

void DicomWriter::unsigned_long(DicomTag tag, std::initializer_list<std::uint32_t> values) {
    header(tag, "UL", static_cast<std::uint32_t>(4 * values.size()));
    for (const std::uint32_t value : values) number(value, 4);
}

void DicomWriter::tag_value(DicomTag tag, DicomTag value) {
    header(tag, "AT", 4);
    number(value.group, 2);
    number(value.element, 2);
}

void DicomWriter::whole_number(DicomTag tag, std::int64_t value) {
    element(tag, "IS", std::to_string(value));
}

void DicomWriter::decimals(DicomTag tag, std::initializer_list<double> values) {
    std::string text;
    for (const double value : values) {
        if (!text.empty()) text += '\\';
        append_decimal_string(text, value);
    }
    element(tag, "DS", text);
}

void DicomWriter::append(DicomTag tag, std::string_view element) {
    assert(last_.back() < tag);
    last_.back() = tag;
    bytes_ += element;
}

void DicomWriter::begin_sequence(DicomTag tag) {
    header(tag, "SQ", undefined_length);
}
void DicomWriter::end_sequence() {
    header(sequence_end, "", 0);
}
void DicomWriter::begin_item() {
    header(sequence_item_tag, "", undefined_length);
    last_.push_back({0, 0});
}
void DicomWriter::end_item() {
    assert(last_.size() > 1);
    last_.pop_back();
    header(item_end, "", 0);
}

std::string DicomWriter::file(const std::string& sop_class, const std::string& sop_instance) const {
    assert(last_.size() == 1);
    DicomWriter meta(Syntax::explicit_little);
    meta.element({0x0002, 0x0001}, "OB", std::string_view("\0\1", 2));
    meta.element(tags::media_sop_class, "UI", sop_class);
    meta.element(tags::media_sop_instance, "UI", sop_instance);
    meta.element(tags::transfer_syntax, "UI",
                 syntax_ == Syntax::implicit_little ? "1.2.840.10008.1.2" : "1.2.840.10008.1.2.1");
    meta.element(tags::implementation_class, "UI", implementation_uid);
    meta.element(tags::implementation_version, "SH", "ANATOMESH");
    DicomWriter length(Syntax::explicit_little);
    length.unsigned_long({0x0002, 0x0000}, {static_cast<std::uint32_t>(meta.bytes().size())});
    return std::string(128, '\0') + "DICM" + length.bytes() + meta.bytes() + bytes_;
}

void append_decimal_string(std::string& text, double value) {
    // A decimal string has no more characters. [bytes; 16; D DICOM PS3.5, section 6.2]
    constexpr std::ptrdiff_t longest = 16;
    if (value == 0) value = 0;  // no minus sign
    char buffer[64];
    const auto shortest = std::to_chars(buffer, buffer + sizeof buffer, value);
    if (shortest.ptr - buffer <= longest) {
        text.append(buffer, shortest.ptr);
        return;
    }
    for (int digits = 15; digits > 0; --digits) {
        const auto end =
            std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, digits);
        if (end.ptr - buffer > longest) continue;
        text.append(buffer, end.ptr);
        return;
    }
}

std::string dicom_safe(std::string_view text, std::size_t longest) {
    bool changed = false;
    const std::string valid = valid_utf8(text, changed);
    std::string safe;
    for (const char c : valid) {
        const auto byte = static_cast<unsigned char>(c);
        safe += byte < 0x20 || byte == 0x7F || c == '\\' ? ' ' : c;
    }
    if (safe.size() > longest) {
        std::size_t end = longest;
        while (end > 0 && (static_cast<unsigned char>(safe[end]) & 0xC0) == 0x80) --end;
        safe.resize(end);
    }
    while (!safe.empty() && safe.back() == ' ') safe.pop_back();
    return safe;
}

}  // namespace anatomesh
