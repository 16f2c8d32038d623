// The tags of DICOM elements that this room reads or writes.
#pragma once

#include "anatomesh_io/contour/dicom_layout.h"

namespace anatomesh::tags {

inline constexpr DicomTag media_sop_class{0x0002, 0x0002}, media_sop_instance{0x0002, 0x0003},
    transfer_syntax{0x0002, 0x0010}, implementation_class{0x0002, 0x0012},
    implementation_version{0x0002, 0x0013};
inline constexpr DicomTag character_set{0x0008, 0x0005}, image_type{0x0008, 0x0008},
    sop_class{0x0008, 0x0016}, sop_instance{0x0008, 0x0018}, study_date{0x0008, 0x0020},
    series_date{0x0008, 0x0021}, content_date{0x0008, 0x0023}, study_time{0x0008, 0x0030},
    series_time{0x0008, 0x0031}, content_time{0x0008, 0x0033}, accession_number{0x0008, 0x0050},
    modality{0x0008, 0x0060}, manufacturer{0x0008, 0x0070}, referring_physician{0x0008, 0x0090},
    code_value{0x0008, 0x0100}, coding_scheme{0x0008, 0x0102}, code_meaning{0x0008, 0x0104},
    study_description{0x0008, 0x1030}, series_description{0x0008, 0x103E}, manufacturer_model{0x0008, 0x1090},
    referenced_series_sequence{0x0008, 0x1115}, source_image_sequence{0x0008, 0x2112},
    derivation_image_sequence{0x0008, 0x9124}, referenced_instance_sequence{0x0008, 0x114A},
    other_studies_sequence{0x0008, 0x1200}, referenced_sop_class{0x0008, 0x1150},
    referenced_sop_instance{0x0008, 0x1155}, referenced_frame_number{0x0008, 0x1160};
inline constexpr DicomTag patient_name{0x0010, 0x0010}, patient_id{0x0010, 0x0020},
    patient_birth_date{0x0010, 0x0030}, patient_sex{0x0010, 0x0040}, patient_removed{0x0012, 0x0062},
    deidentification_method{0x0012, 0x0063};
inline constexpr DicomTag slice_thickness{0x0018, 0x0050}, echo_time{0x0018, 0x0081},
    echo_number{0x0018, 0x0086}, spacing_between_slices{0x0018, 0x0088}, device_serial{0x0018, 0x1000},
    software_versions{0x0018, 0x1020}, trigger_time{0x0018, 0x1060}, gantry_tilt{0x0018, 0x1120},
    imager_pixel_spacing{0x0018, 0x1164}, ultrasound_regions{0x0018, 0x6011},
    region_spatial_format{0x0018, 0x6012}, region_units_x{0x0018, 0x6024}, region_units_y{0x0018, 0x6026},
    region_delta_x{0x0018, 0x602C}, region_delta_y{0x0018, 0x602E}, b_value{0x0018, 0x9087},
    content_qualification{0x0018, 0x9004};
inline constexpr DicomTag study_instance{0x0020, 0x000D}, series_instance{0x0020, 0x000E},
    study_id{0x0020, 0x0010}, series_number{0x0020, 0x0011}, acquisition_number{0x0020, 0x0012},
    instance_number{0x0020, 0x0013}, image_position{0x0020, 0x0032}, image_orientation{0x0020, 0x0037},
    frame_of_reference{0x0020, 0x0052}, temporal_position{0x0020, 0x0100},
    images_in_acquisition{0x0020, 0x1002}, position_reference{0x0020, 0x1040},
    frame_content_sequence{0x0020, 0x9111}, plane_position_sequence{0x0020, 0x9113},
    plane_orientation_sequence{0x0020, 0x9116}, temporal_position_index{0x0020, 0x9128},
    dimension_index_values{0x0020, 0x9157}, concatenation{0x0020, 0x9161},
    dimension_organization_uid{0x0020, 0x9164}, dimension_index_pointer{0x0020, 0x9165},
    functional_group_pointer{0x0020, 0x9167}, dimension_organization_sequence{0x0020, 0x9221},
    dimension_index_sequence{0x0020, 0x9222}, concatenation_frame_offset{0x0020, 0x9228},
    image_position_volume{0x0020, 0x9301}, image_orientation_volume{0x0020, 0x9302},
    plane_position_volume_sequence{0x0020, 0x930E}, plane_orientation_volume_sequence{0x0020, 0x930F},
    volume_frame_of_reference{0x0020, 0x9312};
inline constexpr DicomTag samples_per_pixel{0x0028, 0x0002}, photometric{0x0028, 0x0004},
    number_of_frames{0x0028, 0x0008}, rows{0x0028, 0x0010}, columns{0x0028, 0x0011},
    pixel_spacing{0x0028, 0x0030}, bits_allocated{0x0028, 0x0100}, bits_stored{0x0028, 0x0101},
    high_bit{0x0028, 0x0102}, pixel_representation{0x0028, 0x0103}, burned_in_annotation{0x0028, 0x0301},
    lossy_compression{0x0028, 0x2110}, rescale_intercept{0x0028, 0x1052}, rescale_slope{0x0028, 0x1053},
    pixel_measures_sequence{0x0028, 0x9110}, pixel_transformation_sequence{0x0028, 0x9145};
inline constexpr DicomTag encapsulated_document{0x0042, 0x0011}, mime_type{0x0042, 0x0012},
    document_title{0x0042, 0x0010}, source_instance_sequence{0x0042, 0x0013},
    encapsulated_length{0x0042, 0x0015}, concept_name_sequence{0x0040, 0xA043},
    unit_code_sequence{0x0040, 0x08EA}, content_label{0x0070, 0x0080}, content_description{0x0070, 0x0081},
    content_creator{0x0070, 0x0084};
inline constexpr DicomTag segmentation_type{0x0062, 0x0001}, segment_sequence{0x0062, 0x0002},
    segmented_category_sequence{0x0062, 0x0003}, segment_number{0x0062, 0x0004},
    segment_label{0x0062, 0x0005}, segment_algorithm_type{0x0062, 0x0008},
    segment_algorithm_name{0x0062, 0x0009}, segment_identification_sequence{0x0062, 0x000A},
    referenced_segment_number{0x0062, 0x000B}, recommended_color{0x0062, 0x000D},
    maximum_fractional_value{0x0062, 0x000E}, segmented_type_sequence{0x0062, 0x000F},
    fractional_type{0x0062, 0x0010}, segments_overlap{0x0062, 0x0013};
inline constexpr DicomTag structure_set_label{0x3006, 0x0002}, structure_set_date{0x3006, 0x0008},
    structure_set_time{0x3006, 0x0009}, referenced_frame_sequence{0x3006, 0x0010},
    rt_referenced_study_sequence{0x3006, 0x0012}, rt_referenced_series_sequence{0x3006, 0x0014},
    contour_image_sequence{0x3006, 0x0016}, structure_set_roi_sequence{0x3006, 0x0020},
    roi_number{0x3006, 0x0022}, roi_frame_of_reference{0x3006, 0x0024}, roi_name{0x3006, 0x0026},
    roi_display_color{0x3006, 0x002A}, roi_generation_algorithm{0x3006, 0x0036},
    roi_contour_sequence{0x3006, 0x0039}, contour_sequence{0x3006, 0x0040},
    contour_geometric_type{0x3006, 0x0042}, contour_slab_thickness{0x3006, 0x0044},
    number_of_contour_points{0x3006, 0x0046}, contour_data{0x3006, 0x0050},
    roi_observations_sequence{0x3006, 0x0080}, observation_number{0x3006, 0x0082},
    referenced_roi_number{0x3006, 0x0084}, roi_interpreted_type{0x3006, 0x00A4},
    roi_interpreter{0x3006, 0x00A6};
inline constexpr DicomTag detector_information_sequence{0x0054, 0x0022}, slice_vector{0x0054, 0x0080};
inline constexpr DicomTag grid_frame_offset_vector{0x3004, 0x000C};
inline constexpr DicomTag shared_groups{0x5200, 0x9229}, per_frame_groups{0x5200, 0x9230};
inline constexpr DicomTag pixel_data{0x7FE0, 0x0010};

}  // namespace anatomesh::tags
