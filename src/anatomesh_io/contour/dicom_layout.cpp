#include "anatomesh_io/contour/dicom_layout.h"

#include <zlib.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

namespace anatomesh {

namespace {

constexpr const char* implicit_syntax = "1.2.840.10008.1.2";
constexpr const char* explicit_syntax = "1.2.840.10008.1.2.1";
constexpr const char* deflated_syntax = "1.2.840.10008.1.2.1.99";
constexpr const char* big_syntax = "1.2.840.10008.1.2.2";
// The File Meta Information begins after a preamble of 128 bytes and the four letters DICM.
// [bytes; 132; D DICOM PS3.10, section 7.1]
constexpr std::size_t meta_begin = 132;
// This length says that a delimiter ends the value. [bytes; 2^32 - 1; D DICOM PS3.5, section 7.1]
constexpr std::uint32_t undefined_length = 0xFFFFFFFFu;
// It stands for the end of a value of undefined length, which lies behind every offset. [bytes; 2^64 - 1; D]
constexpr std::uint64_t to_delimiter = ~std::uint64_t{0};

// VRs with two reserved bytes and a length of 32 bits, and those with a length of 16.
constexpr std::string_view long_vrs[] = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                         "SV", "UC", "UN", "UR", "UT", "UV"};
constexpr std::string_view short_vrs[] = {"AE", "AS", "AT", "CS", "DA", "DS", "DT", "FD", "FL", "IS", "LO",
                                          "LT", "PN", "SH", "SL", "SS", "ST", "TM", "UI", "UL", "US"};

template <std::size_t n>
bool contains(const std::string_view (&vrs)[n], std::string_view vr) {
    return std::find(std::begin(vrs), std::end(vrs), vr) != std::end(vrs);
}

constexpr DicomTag item{0xFFFE, 0xE000}, item_end{0xFFFE, 0xE00D}, sequence_end{0xFFFE, 0xE0DD},
    pixel_data{0x7FE0, 0x0010};

// What the walk is in: a sequence, whose content is items, an item (or the data set), whose content is
// elements, or compressed pixels, whose content is fragments.
enum class Holds : std::uint8_t { items, elements, fragments };

struct ItemLevel {
    std::uint64_t end;
    Holds holds;
    bool is_implicit;
    bool may_be_no_sequence;  // a private element that only looks like one: what is wrong in it is no error
};

class Walk {
  public:
    Walk(std::string_view bytes, std::uint64_t first, bool is_implicit, bool is_big,
         const std::string& file_name, const std::function<bool(std::uint16_t, std::uint16_t)>& is_sequence,
         const DicomLimits& limits, DicomEvents* events)
        : bytes_(bytes),
          at_(first),
          is_big_(is_big),
          file_name_(file_name),
          is_sequence_(is_sequence),
          limits_(limits),
          events_(events) {
        levels_.push_back({bytes.size(), Holds::elements, is_implicit, false});
    }

    // The whole data set; or, for the meta header, the elements of group 2, with `meta` called for each.
    template <class Meta>
    Status walk(Meta meta, bool only_meta) {
        while (true) {
            leave_what_has_ended();
            if (at_ >= bytes_.size()) return levels_.size() == 1 ? Status(Nothing{}) : cut_off();
            if (only_meta && levels_.size() == 1 && bytes_.size() - at_ >= 2 && number(at_, 2) != 2)
                return Nothing{};
            Status step = levels_.back().holds == Holds::elements ? step_in_item(meta) : step_in_sequence();
            if (step.ok()) continue;
            if (step.error().kind == ErrorKind::limit || !leave_private_element()) return step;
        }
    }

    std::uint64_t position() const { return at_; }

  private:
    void leave_what_has_ended() {
        while (levels_.size() > 1 && levels_.back().end != to_delimiter && at_ >= levels_.back().end) leave();
    }
    void leave() {
        levels_.pop_back();
        if (events_) events_->end();
    }

    // Goes on after the private element that turned out to be no sequence, when the walk is in one.
    bool leave_private_element() {
        for (std::size_t i = levels_.size(); i-- > 1;) {
            if (!levels_[i].may_be_no_sequence) continue;
            at_ = levels_[i].end;
            while (levels_.size() > i) leave();
            return true;
        }
        return false;
    }

    Status step_in_sequence() {
        tag_at_ = at_;
        if (!has(8)) return cut_off();
        read_tag();
        const auto length = static_cast<std::uint32_t>(number(at_, 4));
        at_ += 4;
        if (tag_ == sequence_end && levels_.back().end == to_delimiter) {
            leave();
            return Nothing{};
        }
        if (tag_ != item) return misplaced("an item is expected");
        if (levels_.back().holds == Holds::fragments) return skip(length, {});
        return enter(length, Holds::elements, levels_.back().is_implicit, false);
    }

    template <class Meta>
    Status step_in_item(Meta meta) {
        tag_at_ = at_;
        if (!has(8)) return cut_off();
        read_tag();
        if (tag_ == item_end && levels_.size() > 1 && levels_.back().end == to_delimiter) {
            at_ += 4;
            leave();
            return Nothing{};
        }
        if (tag_.group == 0xFFFE) return misplaced("an element is expected");
        const bool is_implicit = levels_.back().is_implicit;
        std::string_view vr;
        std::uint32_t length = 0;
        ANATOMESH_CHECK_STATUS(read_vr_and_length(is_implicit, vr, length));
        if (levels_.size() == 1 && length != undefined_length && length <= bytes_.size() - at_)
            meta(tag_, bytes_.substr(at_, length));
        return enter_or_skip(vr, length, is_implicit);
    }

    Status read_vr_and_length(bool is_implicit, std::string_view& vr, std::uint32_t& length) {
        if (is_implicit) {
            length = static_cast<std::uint32_t>(number(at_, 4));
            at_ += 4;
            return Nothing{};
        }
        vr = bytes_.substr(at_, 2);
        const bool is_long = contains(long_vrs, vr);
        if (!is_long && !contains(short_vrs, vr))
            return failure("E-DCL-006", "the value type (VR) of an element does not exist", {});
        if (is_long && !has(8)) return cut_off();
        length = static_cast<std::uint32_t>(is_long ? number(at_ + 4, 4) : number(at_ + 2, 2));
        at_ += is_long ? 8 : 4;
        return Nothing{};
    }

    Status enter_or_skip(std::string_view vr, std::uint32_t length, bool is_implicit) {
        // A sequence of VR UN holds implicit VRs.
        if (vr == "SQ") return enter(length, Holds::items, false, false);
        if (tag_ == pixel_data && length == undefined_length && levels_.size() == 1 && !is_implicit)
            return enter(length, Holds::fragments, false, false);
        if (is_implicit || vr == "UN") {
            if (length == undefined_length || is_sequence_(tag_.group, tag_.element))
                return enter(length, Holds::items, true, false);
            if (tag_.group % 2 == 1 && length >= 8 && has(length) && number(at_, 2) == item.group &&
                number(at_ + 2, 2) == item.element)
                return enter(length, Holds::items, true, true);
        }
        return skip(length, vr);
    }

    Status skip(std::uint32_t length, std::string_view vr) {
        if (length == undefined_length) return misplaced("an undefined length on what is no sequence");
        if (!has(length)) return too_long(length);
        if (events_) events_->element(tag_, vr, at_, length);
        at_ += length;
        return Nothing{};
    }

    Status enter(std::uint32_t length, Holds holds, bool is_implicit, bool may_be_no_sequence) {
        // A level each for a sequence and its item, and one for the data set.
        if (levels_.size() >= 2 * limits_.sequence_depth + 1)
            return Error{ErrorKind::limit, "E-DCL-005",
                         "sequences are nested deeper than " + std::to_string(limits_.sequence_depth),
                         place(), "do not use this file: it is damaged or malicious"};
        if (length != undefined_length && !has(length)) return too_long(length);
        levels_.push_back({length == undefined_length ? to_delimiter : at_ + length, holds, is_implicit,
                           may_be_no_sequence});
        if (events_) events_->begin(tag_, at_);
        return Nothing{};
    }

    // Whether so many bytes are left in everything that the walk is in. Only the innermost level of stated
    // length counts: it ends within all others.
    bool has(std::uint64_t count) const {
        std::uint64_t end = bytes_.size();
        for (std::size_t i = levels_.size(); i-- > 0;) {
            if (levels_[i].end == to_delimiter) continue;
            end = levels_[i].end;
            break;
        }
        return at_ <= end && count <= end - at_;
    }

    std::uint64_t number(std::uint64_t at, std::size_t size) const {
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const auto byte = static_cast<unsigned char>(bytes_[at + (is_big_ ? i : size - 1 - i)]);
            value = value << 8 | byte;
        }
        return value;
    }
    void read_tag() {
        tag_ = {static_cast<std::uint16_t>(number(at_, 2)), static_cast<std::uint16_t>(number(at_ + 2, 2))};
        at_ += 4;
    }

    Place place() const { return {file_name_, {}, {}, {}, {}}; }
    Error failure(const char* code, const std::string& message, const std::string& value) const {
        Place where = place();
        where.value = value;
        return {ErrorKind::input, code,
                "tag " + text_of(tag_) + " at byte " + std::to_string(tag_at_) + ": " + message,
                std::move(where), "copy or export the file again"};
    }
    Error misplaced(const char* message) const { return failure("E-DCL-007", message, {}); }
    Error too_long(std::uint32_t length) const {
        return failure(
            "E-DCL-004",
            "the element is longer than the sequence or file around it, so that the file may be cut off",
            std::to_string(length) + " bytes");
    }
    Error cut_off() const {
        return failure("E-DCL-004", "the file or the item is cut off after this element", {});
    }

    std::string_view bytes_;
    std::uint64_t at_, tag_at_ = 0;
    bool is_big_;
    DicomTag tag_;
    const std::string& file_name_;
    const std::function<bool(std::uint16_t, std::uint16_t)>& is_sequence_;
    const DicomLimits& limits_;
    DicomEvents* events_;
    std::vector<ItemLevel> levels_;
};

Result<std::string> inflate_data_set(std::string_view deflated, const std::string& file_name,
                                     const DicomLimits& limits) {
    const auto corrupt = [&] {
        return Error{ErrorKind::input,
                     "E-DCL-008",
                     "the deflated data set is corrupt or cut off",
                     {file_name, {}, {}, {}, {}},
                     "copy or export the file again"};
    };
    z_stream stream{};
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return corrupt();
    struct End {
        z_stream& stream;
        ~End() { inflateEnd(&stream); }
    } end{stream};

    const std::uint64_t free_bytes = std::uint64_t{16} << 20;
    const std::uint64_t most =
        std::min(limits.inflated_bytes, std::max(free_bytes, limits.inflated_ratio * deflated.size()));
    std::string inflated;
    std::vector<unsigned char> chunk(std::size_t{1} << 18);
    int state = Z_OK;
    while (state != Z_STREAM_END) {
        if (stream.avail_in == 0 && !deflated.empty()) {
            const std::size_t size = std::min<std::size_t>(deflated.size(), std::size_t{1} << 30);
            stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(deflated.data()));
            stream.avail_in = static_cast<uInt>(size);
            deflated.remove_prefix(size);
        }
        stream.next_out = chunk.data();
        stream.avail_out = static_cast<uInt>(chunk.size());
        state = inflate(&stream, Z_NO_FLUSH);  // Z_BUF_ERROR when the input has ended too early
        if (state != Z_OK && state != Z_STREAM_END) return corrupt();
        const std::size_t made = chunk.size() - stream.avail_out;
        if (made > most - inflated.size())
            return Error{ErrorKind::limit,
                         "E-DCL-009",
                         "the deflated data set inflates to more than " + std::to_string(most) + " bytes",
                         {file_name, {}, {}, {}, {}},
                         "do not use this file: it is damaged or malicious"};
        inflated.append(reinterpret_cast<const char*>(chunk.data()), made);
    }
    return inflated;
}

std::uint64_t little_endian(std::string_view bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
}

std::string_view without_padding(std::string_view text) {
    while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.remove_suffix(1);
    return text;
}

// How a data set without meta header is written: by its first element, which must be one of group 8 up to
// the modality.
Result<DicomEncoding> guess_encoding(std::string_view data, const std::string& file_name) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(data[i]); };
    const auto is_capital = [&](std::size_t i) { return data[i] >= 'A' && data[i] <= 'Z'; };
    if (data.size() >= 8) {
        const bool has_vr = is_capital(4) && is_capital(5);
        if (byte(0) == 8 && byte(1) == 0 && byte(2) <= 0x70 && byte(3) == 0)
            return has_vr ? DicomEncoding::explicit_little : DicomEncoding::implicit_little;
        if (byte(0) == 0 && byte(1) == 8 && byte(2) == 0 && byte(3) <= 0x70 && has_vr)
            return DicomEncoding::explicit_big;
    }
    return Error{ErrorKind::input,
                 "E-DCL-001",
                 "the file is no DICOM file: it lacks the letters DICM at byte 128",
                 {file_name, {}, {}, {}, {}},
                 "give a DICOM file"};
}

Status settle_syntax(DicomLayout& layout, const std::string& file_name) {
    const std::string& syntax = layout.transfer_syntax;
    if (syntax.empty())
        return Error{ErrorKind::input,
                     "E-DCL-002",
                     "the meta header does not name the transfer syntax",
                     {file_name, {}, {}, {}, {}},
                     "export the file again"};
    if (syntax == implicit_syntax)
        layout.encoding = DicomEncoding::implicit_little;
    else if (syntax == big_syntax)
        layout.encoding = DicomEncoding::explicit_big;
    else if (syntax != explicit_syntax && syntax != deflated_syntax &&
             !syntax.starts_with("1.2.840.10008.1.2.4.") && syntax != "1.2.840.10008.1.2.5")
        return Error{ErrorKind::input,
                     "E-DCL-003",
                     "the transfer syntax of the file is not known",
                     {file_name, {}, {}, {}, syntax.substr(0, 64)},
                     "export the file as Explicit VR Little Endian"};
    return Nothing{};
}

}  // namespace

std::string text_of(DicomTag tag) {
    char text[16];
    std::snprintf(text, sizeof text, "(%04X,%04X)", tag.group, tag.element);
    return text;
}

bool is_dicom(std::string_view file) {
    return file.size() >= meta_begin && file.substr(128, 4) == "DICM";
}

Result<DicomLayout> check_dicom_layout(std::string_view file, const std::string& file_name,
                                       const std::function<bool(std::uint16_t, std::uint16_t)>& is_sequence,
                                       const DicomLimits& limits, DicomEvents* events) {
    DicomLayout layout;
    layout.has_meta =
        is_dicom(file) || (file.size() >= 8 && file.substr(0, 2) == std::string_view("\2\0", 2));
    if (layout.has_meta) {
        const bool has_preamble = is_dicom(file);
        layout.is_guessed = !has_preamble;
        Walk meta(file, has_preamble ? meta_begin : 0, false, false, file_name, is_sequence, limits, nullptr);
        std::optional<std::uint64_t> stated_end;
        ANATOMESH_CHECK_STATUS(meta.walk(
            [&](DicomTag tag, std::string_view value) {
                if (tag == DicomTag{0x0002, 0x0010}) layout.transfer_syntax = without_padding(value);
                if (tag == DicomTag{0x0002, 0x0000} && value.size() == 4)
                    stated_end =
                        static_cast<std::uint64_t>(value.data() + 4 - file.data()) + little_endian(value);
            },
            true));
        layout.data_set = meta.position();
        layout.has_meta_length = stated_end == layout.data_set;
        ANATOMESH_CHECK_STATUS(settle_syntax(layout, file_name));
    } else {
        layout.is_guessed = true;
        ANATOMESH_TRY(layout.encoding, guess_encoding(file, file_name));
        layout.transfer_syntax = layout.encoding == DicomEncoding::implicit_little ? implicit_syntax
                                 : layout.encoding == DicomEncoding::explicit_big  ? big_syntax
                                                                                   : explicit_syntax;
    }
    std::string_view data = file;
    std::uint64_t first = layout.data_set;
    if (layout.transfer_syntax == deflated_syntax) {
        ANATOMESH_TRY(layout.inflated, inflate_data_set(file.substr(layout.data_set), file_name, limits));
        data = layout.inflated;
        first = 0;
    }
    Walk walk(data, first, layout.encoding == DicomEncoding::implicit_little,
              layout.encoding == DicomEncoding::explicit_big, file_name, is_sequence, limits, events);
    ANATOMESH_CHECK_STATUS(walk.walk([](DicomTag, std::string_view) {}, false));
    return layout;
}

void warn_of_guess(const DicomLayout& layout, const std::string& file_name, RunContext& context) {
    if (layout.has_meta && !layout.has_meta_length)
        context.warn({"W-DCL-002",
                      "the meta header does not state its length, or states a wrong one",
                      {file_name, {}, {}, {}, {}},
                      "the end of its elements was used instead"});
    if (!layout.is_guessed) return;
    context.warn({"W-DCL-001",
                  layout.has_meta ? "the file lacks the preamble of DICOM files"
                                  : "the file lacks the meta header of DICOM files",
                  {file_name, {}, {}, {}, {}},
                  "it was read with the transfer syntax " + layout.transfer_syntax +
                      (layout.has_meta ? ", which it states" : ", guessed from its first element")});
}

}  // namespace anatomesh
