# One static library per room: USES links publicly (rooms), HIDES privately (third-party libraries).

add_library(vrda_flags INTERFACE)
target_compile_features(vrda_flags INTERFACE cxx_std_20)
# No fused multiply-adds: identical results on every x86-64 processor.
target_compile_options(vrda_flags INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Werror -ffp-contract=off
  # Unity sources include .cpp files, whose anonymous namespaces GCC would report as those of headers.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)

# The root of a room's includes: "core/mesh.hpp" for pipeline/core/mesh.hpp.
function(vrda_room_root out)
  file(RELATIVE_PATH relative ${CMAKE_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  string(REGEX MATCH "^[^/]+" program ${relative})
  set(${out} ${program} PARENT_SCOPE)
endfunction()

# Optimises for size rooms that are not time-critical: compiled in two thirds of the time, and the player stays small.
# Only in release builds; Eigen's assertions, whose texts contain whole template names, remain under the sanitizers.
function(vrda_small target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-Os>)
  target_compile_definitions(${target} PRIVATE $<$<CONFIG:Release>:EIGEN_NO_DEBUG>)
endfunction()

# Optimises rooms in which solving spends its time: a fifth less than with -O2, which calls most of Eigen's small products.
# GCC 12 reports the inlined concatenation of texts (its bug 105651).
function(vrda_fast target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O3> $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
  target_compile_definitions(${target} PRIVATE $<$<CONFIG:Release>:EIGEN_NO_DEBUG>)
endfunction()

# vrda_groups(target a.cpp b.cpp / c.cpp): adds the sources; those between slashes are one translation unit, in which names of
# anonymous namespaces must differ.
function(vrda_groups target)
  set(group 0)
  foreach(source ${ARGN})
    if(source STREQUAL "/")
      math(EXPR group "${group} + 1")
      continue()
    endif()
    target_sources(${target} PRIVATE ${source})
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()

# add_room(contact FAST SOURCES a.cpp / b.cpp SMALL c.cpp USES core HIDES PkgConfig::bullet): sources in groups of vrda_groups;
# FAST: compiled for speed, but for SMALL ones, for size.
function(add_room name)
  cmake_parse_arguments(ROOM "FAST" "" "SOURCES;SMALL;USES;HIDES" ${ARGN})
  vrda_room_root(program)
  set(target ${program}_${name})
  add_library(${target} STATIC)
  vrda_groups(${target} ${ROOM_SOURCES})
  set(parts ${target})
  if(ROOM_FAST)
    vrda_fast(${target})
  endif()
  if(ROOM_SMALL)
    add_library(${target}_small OBJECT)
    vrda_groups(${target}_small ${ROOM_SMALL})
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${target}_small>)
    vrda_small(${target}_small)
    list(APPEND parts ${target}_small)
  endif()
  add_library(${program}::${name} ALIAS ${target})
  foreach(part ${parts})
    target_include_directories(${part} PUBLIC ${CMAKE_SOURCE_DIR}/${program})
    foreach(used ${ROOM_USES})
      if(used MATCHES "::")
        target_link_libraries(${part} PUBLIC ${used})
      else()
        target_link_libraries(${part} PUBLIC ${program}_${used})
      endif()
    endforeach()
    target_link_libraries(${part} PRIVATE ${ROOM_HIDES} $<BUILD_INTERFACE:vrda_flags>)
    # The pipeline's rooms are linked into the program and into the Python module alike, so they are compiled once.
    if(program STREQUAL "pipeline")
      set_target_properties(${part} PROPERTIES POSITION_INDEPENDENT_CODE ON
        CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    endif()
    # One section per function, so that the linker can drop unused ones.
    target_compile_options(${part} PRIVATE -ffunction-sections -fdata-sections)
  endforeach()
endfunction()

# Addresses of tables as a bitmap: a hundredth of the player's size. Needs glibc 2.36 and GNU ld 2.38.
include(CheckLinkerFlag)
check_linker_flag(CXX LINKER:-z,pack-relative-relocs,--fatal-warnings vrda_has_short_relocations)
if(vrda_has_short_relocations)
  set(vrda_short_relocations LINKER:-z,pack-relative-relocs)
endif()

# add_schema(view lights): embeds schemas/lights.schema.json in the room, as lights_schema(); a third argument is the room's
# namespace if it has another name.
function(add_schema room kind)
  set(namespace ${room} ${ARGN})
  list(GET namespace -1 namespace)
  set(file ${CMAKE_SOURCE_DIR}/schemas/${kind}.schema.json)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(READ ${file} VRDA_SCHEMA)
  string(REGEX REPLACE "\n *" "" VRDA_SCHEMA "${VRDA_SCHEMA}")
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${kind}_schema_text.cpp)
  configure_file(${CMAKE_SOURCE_DIR}/pipeline/core/schema_text.cpp.in ${source} @ONLY)
  vrda_room_root(program)
  target_sources(${program}_${room} PRIVATE ${source})
endfunction()

# add_room_test(contact SOURCES a_test.cpp / b_test.cpp USES pipeline::contact): one test program per room, its sources in
# groups of vrda_groups, run as one process or as SHARDS parallel processes. TIMEOUT in seconds, for tests that may take
# longer than ten minutes under the sanitizers on a busy machine. Tests with a higher COST (roughly seconds) start
# earlier. LIGHT: compiled without optimisation, in half the time, since it computes little itself.
function(add_room_test name)
  cmake_parse_arguments(TEST "LIGHT" "TIMEOUT;SHARDS;COST" "SOURCES;USES" ${ARGN})
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 600)
  endif()
  if(NOT TEST_SHARDS)
    set(TEST_SHARDS 1)
  endif()
  if(NOT TEST_COST)
    set(TEST_COST 1)
  endif()
  set(target test_${name})
  add_executable(${target})
  vrda_groups(${target} ${TEST_SOURCES})
  target_link_libraries(${target} PRIVATE ${TEST_USES} test_support GTest::gmock GTest::gtest_main vrda_flags)
  if(TEST_LIGHT)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O0>)
    target_precompile_headers(${target} REUSE_FROM test_precompiled_light)
  else()
    target_precompile_headers(${target} REUSE_FROM test_precompiled)
  endif()
  foreach(shard RANGE 1 ${TEST_SHARDS})
    # scripts/count_tests replaces this test by the tests in its file.
    set(test room.${name}.${shard})
    add_test(NAME ${test} COMMAND ${SYSTEM_PYTHON} ${CMAKE_SOURCE_DIR}/scripts/run_room $<TARGET_FILE:${target}> ${name}
      ${CMAKE_BINARY_DIR}/rooms/${test}.xml --timeout ${TEST_TIMEOUT} --shard ${shard}/${TEST_SHARDS})
    set_tests_properties(${test} PROPERTIES TIMEOUT 5400 COST ${TEST_COST})
  endforeach()
endfunction()

# add_program(vrda SOURCES main.cpp USES pipeline::app CLI11::CLI11): a program and its manual page. SMALL as in add_room.
function(add_program name)
  cmake_parse_arguments(PROGRAM "SMALL" "" "SOURCES;USES" ${ARGN})
  add_executable(${name} ${PROGRAM_SOURCES})
  target_compile_definitions(${name} PRIVATE VRDA_VERSION="${PROJECT_VERSION}")
  target_link_libraries(${name} PRIVATE ${PROGRAM_USES} vrda_flags)
  target_link_options(${name} PRIVATE LINKER:--gc-sections LINKER:-z,noseparate-code ${vrda_short_relocations})
  if(PROGRAM_SMALL)
    vrda_small(${name})
  endif()
  set(page ${CMAKE_BINARY_DIR}/man/${name}.1)
  add_custom_command(TARGET ${name} POST_BUILD BYPRODUCTS ${page}
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${name}> -DVERSION=${PROJECT_VERSION} -DPAGE=${page}
      -P ${CMAKE_SOURCE_DIR}/scripts/cmake/ManPage.cmake)
endfunction()
