# Compiler options shared by every target: warnings, and floating point that gives the same bytes everywhere.
add_library(anatomesh_options INTERFACE)
target_compile_options(anatomesh_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wimplicit-fallthrough
  -ffp-contract=off -fno-fast-math)
find_program(ANATOMESH_CCACHE ccache)
if(ANATOMESH_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${ANATOMESH_CCACHE})
endif()
option(ANATOMESH_ASAN "Address and undefined-behaviour sanitizers" OFF)
option(ANATOMESH_TSAN "Thread sanitizer" OFF)
if(ANATOMESH_ASAN)
  add_compile_options(-fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  add_link_options(-fsanitize=address,undefined)
elseif(ANATOMESH_TSAN)
  add_compile_options(-fsanitize=thread -fno-omit-frame-pointer)
  add_link_options(-fsanitize=thread)
endif()

# anatomesh_room_tests(PREFIX ROOM LIBRARIES...): the *_test.cpp files of a room as one program and one test.
function(anatomesh_room_tests name directory)
  file(GLOB tests CONFIGURE_DEPENDS ${directory}/*_test.cpp)
  if(tests AND ANATOMESH_TESTS)
    add_executable(${name}_test ${tests})
    target_link_libraries(${name}_test PRIVATE ${ARGN} anatomesh_options GTest::gtest_main)
    target_compile_definitions(${name}_test PRIVATE ANATOMESH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
    add_test(NAME unit_${name} COMMAND ${name}_test)
  endif()
endfunction()
