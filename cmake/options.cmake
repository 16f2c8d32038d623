# Compiler options shared by every target: warnings, and floating point that gives the same bytes everywhere.
add_library(anatomesh_options INTERFACE)
target_compile_options(anatomesh_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wimplicit-fallthrough
  -ffp-contract=off -fno-fast-math)

# Release: -O2 (the core library more, see there), asserts off. Asserts are on in the debug and sanitizer presets (CMAKE_BUILD_TYPE=Debug).
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
set(CMAKE_C_FLAGS_RELEASE "-O2 -DNDEBUG")
# Debug keeps some optimization: geometry code without it is too slow to test.
set(CMAKE_CXX_FLAGS_DEBUG "-Og -g1")
set(CMAKE_C_FLAGS_DEBUG "-Og -g1")
set(CGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE TRUE)

find_program(ANATOMESH_CCACHE ccache)
if(ANATOMESH_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${ANATOMESH_CCACHE})
endif()

# All libraries may become parts of a shared object (a module of Python, say). Calls inside one stay direct.
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
add_compile_options(-fno-semantic-interposition)

# anatomesh_thin(TARGET): code that reads options, calls and prints spends no time that an optimizer could save, but a third
# of the time that it takes to compile.
function(anatomesh_thin target)
  target_compile_options(${target} PRIVATE "$<$<CONFIG:Release>:-O1>")
endfunction()

option(ANATOMESH_ASAN "Address and undefined-behaviour sanitizers" OFF)
option(ANATOMESH_TSAN "Thread sanitizer" OFF)
option(ANATOMESH_FUZZ "Programs for libFuzzer (clang), with the sanitizers" OFF)
if(ANATOMESH_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-omit-frame-pointer
                      -fno-sanitize-recover=undefined)
  add_link_options(-fsanitize=address,undefined)
elseif(ANATOMESH_ASAN)
  add_compile_options(-fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  add_link_options(-fsanitize=address,undefined)
elseif(ANATOMESH_TSAN)
  add_compile_options(-fsanitize=thread -fno-omit-frame-pointer)
  add_link_options(-fsanitize=thread)
endif()

# Headers of the standard library and of others that most files of a target need, compiled once: a fifth of the time
# that the core and its tests take. Off in the debug presets, where a file has to include what it uses.
option(ANATOMESH_PRECOMPILED_HEADERS "Precompile the headers that most files need" ON)
function(anatomesh_precompile_headers target)
  if(ANATOMESH_PRECOMPILED_HEADERS)
    target_precompile_headers(${target} PRIVATE <algorithm> <array> <cmath> <cstdint> <optional> <span> <string> <utility>
                              <vector> ${ARGN})
    # Of what comes from there GCC 12 does not know that it is the system's, and warns of its own strings (its bug 105651).
    target_compile_options(${target} PRIVATE
      "$<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-restrict>")
  endif()
endfunction()

# Files of one folder are compiled together, a few at a time: the headers that they share are read once. Off in the
# debug presets, where a file has to include what it uses. A group is kept small, so that a changed file is compiled
# again within seconds: it holds at most so many bytes of source (measured: after a change in a full group the program is built
# again in 12 s on two cores).
option(ANATOMESH_COMPILE_TOGETHER "Compile the files of a folder together" ON)
set(ANATOMESH_GROUP_BYTES 100000 CACHE STRING "Most bytes of source that are compiled together")
mark_as_advanced(ANATOMESH_GROUP_BYTES)
function(anatomesh_compile_together target)
  if(NOT ANATOMESH_COMPILE_TOGETHER)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  set(folder "")
  set(number 0)
  set(bytes 0)
  foreach(source ${sources})
    get_filename_component(here ${source} DIRECTORY)
    file(SIZE ${source} size)
    math(EXPR bytes "${bytes} + ${size}")
    if(NOT here STREQUAL folder OR bytes GREATER ANATOMESH_GROUP_BYTES)
      math(EXPR number "${number} + 1")
      set(bytes ${size})
      set(folder ${here})
    endif()
    get_filename_component(name ${here} NAME)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${name}_${number}")
  endforeach()
endfunction()

# anatomesh_room_tests(NAME DIRECTORY LIBRARIES...): the *_test.cpp files of a room and its sub-rooms as one program; every TEST in
# it is a test of its own for ctest, so that a skipped one counts as skipped.
function(anatomesh_room_tests name directory)
  file(GLOB_RECURSE tests CONFIGURE_DEPENDS ${directory}/*_test.cpp)
  if(NOT tests OR NOT ANATOMESH_TESTS)
    return()
  endif()
  add_executable(${name}_test ${tests})
  target_link_libraries(${name}_test PRIVATE ${ARGN} anatomesh_options GTest::gtest_main)
  target_compile_definitions(${name}_test PRIVATE ANATOMESH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  list(LENGTH tests number)
  if(number GREATER 1)
    anatomesh_precompile_headers(${name}_test <gtest/gtest.h> <map> <numbers> <random> <set>)
  endif()
  anatomesh_compile_together(${name}_test)
  gtest_discover_tests(${name}_test TEST_PREFIX "unit_${name}." DISCOVERY_TIMEOUT 120
                       PROPERTIES TIMEOUT 300 LABELS unit)
endfunction()
