# What `make install` puts where: program, libraries, headers, CMake package, manual page, shell completions.
include(CMakePackageConfigHelpers)

install(TARGETS anatomesh EXPORT anatomesh_core ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
# What a user of the library includes; these and what they include are installed, the rest is the house's own.
set(public_headers
  anatomesh/base/run_context.h             # threads, cancelling, progress, warnings; Result and Error
  anatomesh/contour/model/raw_contours.h         # contours as a file gives them, or a program makes them
  anatomesh/contour/model/contour_set.h          # contours that are cleaned
  anatomesh/image/image.h                  # grey images and label maps
  anatomesh/pipeline/make_model.h          # one call from contours to a model
  anatomesh/pipeline/prepare_contours.h    # its first half, also from label maps
  anatomesh/pipeline/build_model.h         # its second half
  anatomesh/pipeline/contours_in_planes.h  # the model's contours, for a file
  anatomesh/pipeline/model/quadratic_model.h     # elements of ten nodes
  anatomesh/mesh/check/topology.h                # surfaces of structures
  anatomesh/measure/report.h               # what is said of a model
  anatomesh/uncertainty/surface_uncertainty.h
  anatomesh/uncertainty/where_next.h)
set(public_io_headers
  anatomesh_io/contour/read_contours.h
  anatomesh_io/contour/write_contours.h
  anatomesh_io/image/read_image.h
  anatomesh_io/mesh/mesh_file.h
  anatomesh_io/provenance/model_description.h  # a model as a file to write
  anatomesh_io/report/report_json.h
  anatomesh_io/report/report_html.h)
if(TARGET anatomesh_io)
  list(APPEND public_headers ${public_io_headers})
endif()
install(CODE "set(SOURCE \"${PROJECT_SOURCE_DIR}/src\")
  set(DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}\")
  set(HEADERS \"${public_headers}\")
  include(\"${PROJECT_SOURCE_DIR}/cmake/install_headers.cmake\")")
install(DIRECTORY ${PROJECT_SOURCE_DIR}/schemas DESTINATION ${CMAKE_INSTALL_DATADIR}/anatomesh
        FILES_MATCHING PATTERN "*.json")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/anatomesh)
install(EXPORT anatomesh_core NAMESPACE anatomesh:: DESTINATION ${package_dir})
if(TARGET anatomesh_io)
  get_target_property(io_rooms anatomesh_io INTERFACE_LINK_LIBRARIES)
  install(TARGETS anatomesh_io ${io_rooms} EXPORT anatomesh_io ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(EXPORT anatomesh_io NAMESPACE anatomesh:: DESTINATION ${package_dir})
endif()
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/anatomesh-config.cmake.in
  ${PROJECT_BINARY_DIR}/anatomesh-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/anatomesh-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/anatomesh-config.cmake ${PROJECT_BINARY_DIR}/anatomesh-config-version.cmake
        DESTINATION ${package_dir})

if(TARGET anatomesh_program)
  install(TARGETS anatomesh_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  # The program writes its own manual page and completions, so that they cannot differ from its options.
  set(pages ${PROJECT_BINARY_DIR}/pages)
  add_custom_command(OUTPUT ${pages}/anatomesh.1
    COMMAND ${CMAKE_COMMAND} -E make_directory ${pages}
    COMMAND anatomesh_program manual > ${pages}/anatomesh.1
    COMMAND anatomesh_program completion bash > ${pages}/anatomesh.bash
    COMMAND anatomesh_program completion zsh > ${pages}/_anatomesh
    COMMAND anatomesh_program completion fish > ${pages}/anatomesh.fish
    DEPENDS anatomesh_program VERBATIM)
  add_custom_target(anatomesh_pages ALL DEPENDS ${pages}/anatomesh.1)
  install(FILES ${pages}/anatomesh.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${pages}/anatomesh.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
          RENAME anatomesh)
  install(FILES ${pages}/_anatomesh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
  install(FILES ${pages}/anatomesh.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endif()
