#include "anatomesh_io/contour/rtstruct_reader.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcistrmb.h>
#include <dcmtk/dcmdata/dctk.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh_io/contour/dcmtk_set_up.h"
#include "anatomesh_io/contour/dicom_layout.h"
#include "anatomesh_io/contour/dicom_text.h"
#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

E_TransferSyntax syntax_of(DicomEncoding encoding) {
    switch (encoding) {
        case DicomEncoding::implicit_little:
            return EXS_LittleEndianImplicit;
        case DicomEncoding::explicit_big:
            return EXS_BigEndianExplicit;
        case DicomEncoding::explicit_little:
            break;
    }
    return EXS_LittleEndianExplicit;
}

// The characters of an element, whatever its VR says they are; valid as long as the element. Empty when there
// is none, or no value.
std::string_view text_of(DcmItem& item, const DcmTagKey& tag) {
    DcmElement* element = nullptr;
    if (item.findAndGetElement(tag, element).bad() || !element || element->getLength() == 0) return {};
    char* text = nullptr;
    Uint32 length = 0;
    if (element->getString(text, length).good() && text) return without_padding({text, length});
    Uint8* bytes = nullptr;
    if (element->getUint8Array(bytes).good() && bytes)
        return without_padding({reinterpret_cast<const char*>(bytes), element->getLength()});
    return {};
}

// The items of a sequence, one after another (DCMTK's access by index is linear in the index).
template <class Visit>
Status for_each_item(DcmItem& parent, const DcmTagKey& tag, Visit visit) {
    DcmSequenceOfItems* sequence = nullptr;
    if (parent.findAndGetSequence(tag, sequence).bad() || !sequence) return Nothing{};
    for (DcmObject* object = sequence->nextInContainer(nullptr); object;
         object = sequence->nextInContainer(object)) {
        auto* item = dynamic_cast<DcmItem*>(object);
        if (!item) continue;
        ANATOMESH_CHECK_STATUS(visit(*item));
    }
    return Nothing{};
}

// Points of one plane differ by less along its normal: files round to more.
// [mm; 0 to 1e-3; D digits of files]
constexpr double same_height_mm = 1e-6;
// Fewer slices say nothing of their usual distance. [slices; >= 2; D]
constexpr std::size_t fewest_slices = 3;
// Slices closer than this are unusual for a patient, so that the contours may be in centimetres.
// [mm; > 0; C W-RTS-006]
constexpr double closest_slices_mm = 0.45;
// No scanner takes slices of a patient that are closer than this. [mm; > 0; C E-RTS-011]
constexpr double impossible_slices_mm = 0.02;
// Contours that span more are no patient in centimetres. [mm; > 0; C W-RTS-006]
constexpr double smallest_patient_mm = 60;

class RtStructReader {
  public:
    explicit RtStructReader(RawBuilder& builder) : builder_(builder) {}

    Status read(std::string_view file) {
        set_up_dcmtk();
        if (!dcmDataDict.isDictionaryLoaded())
            return Error{ErrorKind::file,
                         "E-RTS-009",
                         "the DICOM dictionary was not found on this machine",
                         {},
                         "install the data files of DCMTK, or set DCMDICTPATH"};
        ANATOMESH_CHECK_STATUS(parse(file));
        ANATOMESH_CHECK_STATUS(check_class());
        builder_.frame = FileFrame::lps;
        ANATOMESH_CHECK_STATUS(for_each_item(data_set_, DCM_StructureSetROISequence,
                                             [&](DcmItem& item) { return read_declaration(item); }));
        ANATOMESH_CHECK_STATUS(
            for_each_item(data_set_, DCM_ROIContourSequence, [&](DcmItem& item) { return read_roi(item); }));
        // Where contours state different ones, none is that of all slices.
        if (thicknesses_.size() == 1) builder_.slice_thickness_mm = *thicknesses_.begin();
        return check_unit();
    }

  private:
    // Patients are drawn on slices of about half a millimetre and more; what is small and on closer ones is
    // in centimetres.
    Status check_unit() {
        if (builder_.unit_is_given) return Nothing{};
        auto& heights = *std::max_element(heights_.begin(), heights_.end(),
                                          [](const auto& a, const auto& b) { return a.size() < b.size(); });
        std::sort(heights.begin(), heights.end());
        std::vector<double> gaps;
        for (std::size_t n = 1; n < heights.size(); ++n) {
            if (heights[n] - heights[n - 1] > same_height_mm) gaps.push_back(heights[n] - heights[n - 1]);
        }
        if (gaps.size() + 1 < fewest_slices) return Nothing{};
        std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2),
                         gaps.end());
        const double spacing = gaps[gaps.size() / 2], span = box_.diagonal();
        if (spacing < impossible_slices_mm)
            return Error{
                ErrorKind::input,
                "E-RTS-011",
                "the contours lie on slices " + rounded(spacing) + " mm apart and span " + rounded(span) +
                    " mm in all: no scanner takes such slices of a patient, so the coordinates are not in mm",
                {builder_.file(), {}, {}, {}, rounded(spacing) + " mm apart"},
                "say in what they are with --unit cm or --unit m; --unit mm takes them as they are"};
        if (spacing >= closest_slices_mm || span > smallest_patient_mm) return Nothing{};
        builder_.context().warn({"W-RTS-006",
                                 "the contours lie on slices " + rounded(spacing) + " mm apart and span " +
                                     rounded(span) + " mm in all, so that they may be in centimetres",
                                 {builder_.file(), {}, {}, {}, rounded(spacing) + " mm apart"},
                                 "they were read as mm, as DICOM requires; if they are not, give --unit cm"});
        return Nothing{};
    }
    static std::string rounded(double value) {
        std::array<char, 32> text{};
        const auto end =
            std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 3);
        return {text.data(), end.ptr};
    }
    // A contour in a plane of two axes lies at a height of the third.
    void note_place(const Box3& contour) {
        const Vec3 extent = contour.high - contour.low;
        if (extent.x < same_height_mm) heights_[0].push_back(contour.low.x);
        if (extent.y < same_height_mm) heights_[1].push_back(contour.low.y);
        if (extent.z < same_height_mm) heights_[2].push_back(contour.low.z);
        box_.extend(contour.low);
        box_.extend(contour.high);
    }

    Status parse(std::string_view file) {
        ANATOMESH_TRY(DicomLayout layout, check_dicom_layout(file, builder_.file(), is_sequence_tag));
        warn_of_guess(layout, builder_.file(), builder_.context());
        std::string_view data = file.substr(layout.data_set);
        if (!layout.inflated.empty()) data = layout.inflated;
        DcmInputBufferStream stream;
        stream.setBuffer(data.data(), static_cast<offile_off_t>(data.size()));
        stream.setEos();
        data_set_.transferInit();
        const OFCondition done = data_set_.read(stream, syntax_of(layout.encoding));
        data_set_.transferEnd();
        if (done.good() || done == EC_EndOfStream) return Nothing{};
        return Error{ErrorKind::input,
                     "E-RTS-001",
                     std::string("the file cannot be read as DICOM: ") + done.text(),
                     {builder_.file(), {}, {}, {}, {}},
                     "copy or export the file again"};
    }

    Status check_class() {
        const std::string_view class_uid = text_of(data_set_, DCM_SOPClassUID);
        const std::string_view modality = text_of(data_set_, DCM_Modality);
        if (class_uid == UID_RTStructureSetStorage || (class_uid.empty() && modality == "RTSTRUCT"))
            return Nothing{};
        bool changed = false;
        return Error{
            ErrorKind::input,
            "E-RTS-002",
            "this DICOM object is no structure set (RTSTRUCT)",
            {builder_.file(), {}, {}, {}, valid_utf8(shown("modality " + std::string(modality)), changed)},
            "give the RTSTRUCT of the study"};
    }

    Status read_declaration(DcmItem& item) {
        Structure structure;
        structure.name = name_of(item);
        ANATOMESH_TRY(structure.number, roi_number(item, DCM_ROINumber, structure.name));
        if (builder_.find_structure(structure.number))
            return Error{ErrorKind::input,
                         "E-RTS-004",
                         "two ROIs have the same number",
                         {builder_.file(), {}, label_of(structure), {}, std::to_string(structure.number)},
                         "give every ROI its own number"};
        if (const std::string_view uid = text_of(item, DCM_ReferencedFrameOfReferenceUID); !uid.empty()) {
            const auto next = static_cast<std::uint32_t>(spaces_.size() + 1);
            space_of_[structure.number] = spaces_.emplace(uid, next).first->second;
        }
        ANATOMESH_TRY([[maybe_unused]] const auto index, builder_.add_structure(std::move(structure)));
        return Nothing{};
    }

    Status read_roi(DcmItem& item) {
        ANATOMESH_TRY(const auto number, roi_number(item, DCM_ReferencedROINumber, {}));
        const bool is_declared = builder_.find_structure(number).has_value();
        ANATOMESH_TRY(const auto structure, builder_.structure_of(number));
        const Place place{builder_.file(), {}, label_of(builder_.structures()[structure]), {}, {}};
        if (!contours_of_.emplace(structure, 0).second)
            return Error{ErrorKind::input, "E-RTS-004", "the contours of one ROI occur in two items", place,
                         "export the file again"};
        if (!is_declared)
            builder_.context().warn({"W-RTS-001", "the ROI is not declared in StructureSetROISequence", place,
                                     "its contours were kept without a name"});
        read_color(item, structure, place);
        const auto space = space_of_.find(number);
        builder_.space = space == space_of_.end() ? 0 : space->second;
        if (builder_.context().cancelled()) return cancelled_error();
        return for_each_item(item, DCM_ContourSequence,
                             [&](DcmItem& contour) { return read_contour(contour, structure, number); });
    }

    Status read_contour(DcmItem& item, std::uint32_t structure, std::int32_t roi) {
        const std::uint64_t index = contours_of_[structure]++;
        // The point count of an error must name this contour: it is begun first.
        ANATOMESH_CHECK_STATUS(
            builder_.begin_contour(structure, ContourKind::closed_planar, -1,
                                   "ROI " + std::to_string(roi) + ", contour " + std::to_string(index)));
        ANATOMESH_TRY(const auto kind, kind_of(item));
        builder_.set_kind(builder_.contour_count() - 1, kind);
        if (const auto thickness =
                parse_number(without_padding(text_of(item, DCM_RETIRED_ContourSlabThickness)));
            thickness && *thickness > 0)
            thicknesses_.insert(*thickness);
        const std::string_view data = text_of(item, DCM_ContourData);
        if (data.empty())
            return failure("E-RTS-006", "ContourData is missing or empty", {}, builder_.contour_place());
        std::uint64_t values = 1;
        for (const char c : data) values += c == '\\';
        if (values % 3 != 0)
            return failure("E-RTS-006", "ContourData does not hold three numbers per point",
                           std::to_string(values) + " values", builder_.contour_place());
        ANATOMESH_CHECK_STATUS(builder_.expect_points(values / 3));
        ANATOMESH_CHECK_STATUS(read_points(data, values / 3));
        compare_count(item, values / 3);
        return Nothing{};
    }

    Status read_points(std::string_view data, std::uint64_t count) {
        Box3 box;
        for (std::uint64_t i = 0; i < count; ++i) {
            double xyz[3];
            for (double& value : xyz) {
                const std::size_t end = std::min(data.find('\\'), data.size());
                const std::string_view word = without_padding(data.substr(0, end));
                const auto number = parse_number(word);
                if (!number) {
                    bool changed = false;
                    return failure("E-RTS-007", "a coordinate is not a number",
                                   valid_utf8(shown(word), changed), builder_.point_place(i));
                }
                value = *number;
                data.remove_prefix(std::min(end + 1, data.size()));
            }
            ANATOMESH_CHECK_STATUS(builder_.add_point({xyz[0], xyz[1], xyz[2]}));
            box.extend({xyz[0], xyz[1], xyz[2]});
        }
        if (count > 2) note_place(box);
        return Nothing{};
    }

    Result<ContourKind> kind_of(DcmItem& item) {
        constexpr std::pair<std::string_view, ContourKind> kinds[] = {
            {"CLOSED_PLANAR", ContourKind::closed_planar},
            {"CLOSEDPLANAR_XOR", ContourKind::closed_planar_xor},
            {"OPEN_PLANAR", ContourKind::open},
            {"OPEN_NONPLANAR", ContourKind::open},
            {"POINT", ContourKind::point}};
        const std::string_view type = text_of(item, DCM_ContourGeometricType);
        for (const auto& [name, kind] : kinds)
            if (type == name) return kind;
        if (!type.empty()) {
            bool changed = false;
            return failure("E-RTS-008", "the contour has an unknown type", valid_utf8(shown(type), changed),
                           builder_.contour_place());
        }
        builder_.context().warn({"W-RTS-003", "the contour has no type", builder_.contour_place(),
                                 "it was read as CLOSED_PLANAR"});
        return ContourKind::closed_planar;
    }

    void compare_count(DcmItem& item, std::uint64_t count) {
        const std::string_view stated = text_of(item, DCM_NumberOfContourPoints);
        if (stated.empty() || parse_integer<std::uint64_t>(stated) == count) return;
        bool changed = false;
        Place place = builder_.contour_place();
        place.value = valid_utf8(shown(stated), changed);
        builder_.context().warn(
            {"W-RTS-002", "NumberOfContourPoints differs from the number of points in ContourData",
             std::move(place), "all " + std::to_string(count) + " points of ContourData were read"});
    }

    void read_color(DcmItem& item, std::uint32_t structure, const Place& place) {
        std::string_view data = text_of(item, DCM_ROIDisplayColor);
        if (data.empty()) return;
        std::array<std::uint8_t, 3> color{};
        std::string_view rest = data;
        bool is_color = std::count(data.begin(), data.end(), '\\') == 2;
        for (std::uint8_t& part : color) {
            const std::size_t end = std::min(rest.find('\\'), rest.size());
            const auto value = parse_integer<std::uint8_t>(without_padding(rest.substr(0, end)));
            is_color = is_color && value;
            part = value.value_or(0);
            rest.remove_prefix(std::min(end + 1, rest.size()));
        }
        if (is_color) {
            builder_.set_color(structure, color);
            return;
        }
        bool changed = false;
        Place where = place;
        where.value = valid_utf8(shown(data), changed);
        builder_.context().warn(
            {"W-RTS-005", "the colour of the ROI is not valid", std::move(where), "grey was used"});
    }

    Result<std::int32_t> roi_number(DcmItem& item, const DcmTagKey& tag, const std::string& name) {
        const std::string_view text = text_of(item, tag);
        if (const auto number = parse_integer<std::int32_t>(text)) return *number;
        bool changed = false;
        return failure("E-RTS-003", "the number of the ROI is missing or not a whole number",
                       valid_utf8(shown(text), changed), {builder_.file(), {}, name, {}, {}});
    }

    // The name as UTF-8.
    std::string name_of(DcmItem& item) {
        auto [name, is_exact] =
            dicom_text(text_of(item, DCM_ROIName), text_of(data_set_, DCM_SpecificCharacterSet));
        if (is_exact) return name;
        builder_.context().warn({"W-RTS-004",
                                 "the name does not fit the file's character set, or that set is unknown",
                                 {builder_.file(), {}, name, {}, {}},
                                 "unreadable letters were replaced by the sign U+FFFD"});
        return name;
    }

    static Error failure(const char* code, const char* message, std::string value, Place place) {
        place.value = std::move(value);
        return {ErrorKind::input, code, message, std::move(place),
                "correct the structure set, or export it again"};
    }

    RawBuilder& builder_;
    DcmDataset data_set_;
    std::map<std::uint32_t, std::uint64_t> contours_of_;        // contours read so far, by structure
    std::map<std::string, std::uint32_t, std::less<>> spaces_;  // frames of reference, from 1
    std::map<std::int32_t, std::uint32_t> space_of_;            // of the ROIs that name one, by number
    std::array<std::vector<double>, 3> heights_;                // of the contours normal to each axis
    std::set<double> thicknesses_;                              // that contours state
    Box3 box_;
};

}  // namespace

Status read_rtstruct(std::string_view file, RawBuilder& builder) {
    return RtStructReader(builder).read(file);
}

}  // namespace anatomesh
