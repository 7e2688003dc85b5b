# Compiler settings, third-party packages and the three functions every folder uses.
include_guard(GLOBAL)

find_program(CCACHE ccache)
if(CCACHE)
  # What ccache asks for before it keeps objects made with precompiled headers; and warnings change no object.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_IGNOREOPTIONS=-W* ${CCACHE})
endif()

# What all our own sources are compiled with: findings are mended, not silenced. What clang's -Wconversion says about signs,
# g++'s leaves out: signed indices of Eigen meet unsigned sizes of the standard library everywhere. Errors (the preset
# "release") only with the compiler whose findings are known: another one's must not keep a release from being built.
# g++'s -Wshadow minds parameters of constructors that bear the names of the members they begin, clang's does not.
set(flexura_warnings -Wall -Wextra -Wconversion)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  list(APPEND flexura_warnings -Wshadow=local)
else()
  list(APPEND flexura_warnings -Wshadow)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  list(APPEND flexura_warnings -Wno-sign-conversion)
  if(FLEXURA_WERROR AND CMAKE_CXX_COMPILER_VERSION MATCHES "^16\\.")
    list(APPEND flexura_warnings -Werror)
  endif()
endif()
find_program(MOLD mold)
if(MOLD)
  # Each kind of segment on pages of its own: without it mold 1.10 begins the part that the loader makes read-only in
  # the page before its segment, where the code ends within 64 bytes of a page and the program has thread-local data,
  # and such a program does not start ("cannot apply additional memory protection", mold issue 1151).
  add_link_options(-fuse-ld=mold -Wl,-z,separate-code)
endif()
# -O2 without -g: decompositions dominate the build time, and debug information doubles it.  The presets take clang
# for it, which instantiates Eigen's templates in two thirds of g++'s time; the release archive is built by g++.
set(CMAKE_CXX_FLAGS_RELEASE "-O2")
if(FLEXURA_SANITIZE)
  # Without the checks of each pointer before use (the address sanitizer sees what they see): in Eigen's templates they
  # double the time to compile, 40 s against 20 s for a typical test.  Nor of sums of pointers: Eigen adds to that of an
  # empty matrix, which is null.
  set(CMAKE_CXX_FLAGS_RELEASE "-O1 -g1 -fno-omit-frame-pointer -fsanitize=address,undefined \
-fno-sanitize=null,alignment,vptr,object-size,nonnull-attribute,returns-nonnull-attribute,pointer-overflow -fno-sanitize-recover=undefined")
  if(FLEXURA_FUZZ)
    string(APPEND CMAKE_CXX_FLAGS_RELEASE " -fsanitize=fuzzer-no-link -Wno-deprecated-declarations")
  endif()
else()
  # Eigen's checks of sizes and indices run with the sanitizers; here they would cost the small products of every step.
  add_compile_definitions(EIGEN_NO_DEBUG)
endif()
add_link_options(-Wl,--as-needed)

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(CLI11 REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(SUNDIALS 6.4 REQUIRED COMPONENTS ida nvecserial sunlinsolklu sunlinsoldense sunmatrixsparse sunmatrixdense)
if(FLEXURA_TESTS)
  find_package(GTest REQUIRED)
endif()
find_package(PkgConfig REQUIRED)
# Serial HDF5 on both sides, whatever flavour other packages drag in.
pkg_check_modules(HDF5_SERIAL REQUIRED IMPORTED_TARGET hdf5-serial)
# The sandbox of the programs in which gmsh and OpenCASCADE read.
pkg_check_modules(SECCOMP REQUIRED IMPORTED_TARGET libseccomp)

# Eigen, JSON, GoogleTest and the standard library's heavier headers, read once: 1 to 2.5 s less for each file.  Sources name
# what they use all the same; the sanitizers' build has no precompiled headers and notices when one does not.
# What the compiler cache asks for before it keeps objects made with precompiled headers.
set(flexura_precompile_options $<IF:$<CXX_COMPILER_ID:GNU>,-fpch-preprocess;-Wno-ignored-attributes,SHELL:-Xclang -fno-pch-timestamp;-fpch-instantiate-templates>)
function(flexura_precompile name from)
  target_compile_options(${name} PRIVATE ${flexura_precompile_options})
  target_link_libraries(${name} PRIVATE flexura_kernels fmt::fmt)
  target_precompile_headers(${name} REUSE_FROM ${from})
  if(from STREQUAL "flexura_precompiled_library")
    target_compile_options(${name} PRIVATE ${flexura_position_independent})
  endif()
endfunction()
# Of libraries: they go into shared objects, too (plugins of other programs, modules of Python). Programs that share their precompiled
# headers are compiled alike. g++ would else inline nothing that another library might replace.
set(flexura_position_independent -fPIC $<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>)
add_library(flexura_kernels STATIC ${CMAKE_SOURCE_DIR}/mbs/base/math/eigen_kernels.cpp)
target_compile_options(flexura_kernels PRIVATE ${flexura_position_independent})
target_link_libraries(flexura_kernels PRIVATE $<BUILD_INTERFACE:Eigen3::Eigen>)
target_include_directories(flexura_kernels PRIVATE ${CMAKE_SOURCE_DIR})
set(kinds library)
if(FLEXURA_TESTS)
  list(APPEND kinds test)
endif()
foreach(kind ${kinds})
  add_library(flexura_precompiled_${kind} OBJECT ${CMAKE_SOURCE_DIR}/tests/setup/precompiled.cpp)
  target_compile_options(flexura_precompiled_${kind} PRIVATE -Wall -Wextra ${flexura_precompile_options})
  target_link_libraries(flexura_precompiled_${kind} PRIVATE Eigen3::Eigen fmt::fmt)
  target_precompile_headers(flexura_precompiled_${kind} PRIVATE <Eigen/Dense> <Eigen/Sparse> <algorithm> <chrono> <cmath> <filesystem>
                            <fstream> <functional> <map> <memory> <numeric> <optional> <ranges> <set> <stdexcept> <string>
                            <string_view> <valarray> <variant> <vector> <fmt/format.h> <fmt/ranges.h> <nlohmann/json.hpp>
                            ${CMAKE_SOURCE_DIR}/mbs/base/math/eigen_kernels.hpp ${CMAKE_SOURCE_DIR}/mbs/base/math/spatial.hpp)
endforeach()
target_compile_options(flexura_precompiled_library PRIVATE ${flexura_position_independent})
if(FLEXURA_TESTS)
  target_compile_options(flexura_precompiled_test PRIVATE -O1)
  target_link_libraries(flexura_precompiled_test PRIVATE GTest::gtest GTest::gmock)
  target_precompile_headers(flexura_precompiled_test PRIVATE <gtest/gtest.h> <gmock/gmock.h>)
endif()

# flexura_library(name SOURCES ... LINKS ... [PRIVATE_LINKS ...]): one static library for each folder, alias
# flexura::name, included from the repository root as "folder/sub/header.hpp".
function(flexura_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(flexura_${name} STATIC ${ARG_SOURCES})
  add_library(flexura::${name} ALIAS flexura_${name})
  target_include_directories(flexura_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include/flexura>)
  target_compile_options(flexura_${name} PRIVATE ${flexura_warnings})
  target_link_libraries(flexura_${name} PUBLIC Eigen3::Eigen ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS})
  flexura_precompile(flexura_${name} flexura_precompiled_library)
endfunction()

# flexura_together(TARGET GROUP source...): compiled as one file, since most of their time goes into the headers that they share.
# What defines macros or the same name in its unnamed namespace stays apart, and what instantiates decompositions, so that
# several processors have something to do.
function(flexura_together target group)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  set_source_files_properties(${ARGN} PROPERTIES UNITY_GROUP ${group})
endfunction()

# Targets that read, write and describe, where -O2 is not felt: -O1 compiles a tenth faster (g++ wants its precompiled headers made
# with the same).
function(flexura_light)
  foreach(target ${ARGN})
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:Clang>:-O1>)
  endforeach()
endfunction()

# A program that says so in a sentence when memory runs out: mbs/base/math/eigen_memory.cpp.
function(flexura_survives_no_memory name)
  target_sources(${name} PRIVATE ${CMAKE_SOURCE_DIR}/mbs/base/math/eigen_memory.cpp)
  target_link_options(${name} PRIVATE -Wl,--wrap=malloc,--wrap=free)
endfunction()

# Target built not with everything but with the target of this name: what only the slow words of tests/run need.
function(flexura_only_with word name)
  set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
  if(NOT TARGET ${word})
    add_custom_target(${word})
  endif()
  add_dependencies(${word} ${name})
endfunction()

function(flexura_test_settings name)
  target_compile_options(${name} PRIVATE ${flexura_warnings} -O1)  # compiles a quarter faster; the libraries do the work
  target_compile_definitions(${name} PRIVATE FLEXURA_SOURCE_DIR="${CMAKE_SOURCE_DIR}"
                                             FLEXURA_BIN_DIR="${CMAKE_BINARY_DIR}/bin")
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARGN} GTest::gmock)
  flexura_precompile(${name} flexura_precompiled_test)
endfunction()

# flexura_test_library(name SOURCES ... LINKS ...): what several test programs share, compiled once.
function(flexura_test_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  flexura_test_settings(${name} ${ARG_LINKS} GTest::gtest)
endfunction()

# flexura_test(name SOURCES ... LINKS ... [WHOLE] [LABEL word] [ENVIRONMENT A=B ...]): one GoogleTest program. Each
# case is a ctest of its own, except with WHOLE (programs with a slow start, like PETSc's).
# Programs with a label other than "fast" are built when asked for: by the target of the label's name.
# Tests find data of the project through the macro FLEXURA_SOURCE_DIR and programs through FLEXURA_BIN_DIR.
function(flexura_test name)
  cmake_parse_arguments(ARG "WHOLE" "LABEL" "SOURCES;LINKS;ENVIRONMENT" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL fast)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  if(NOT ARG_LABEL STREQUAL "fast")
    flexura_only_with(${ARG_LABEL} ${name})
  endif()
  flexura_test_settings(${name} ${ARG_LINKS} GTest::gtest_main)
  if(ARG_WHOLE)
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} ENVIRONMENT "${ARG_ENVIRONMENT}")
  else()
    include(GoogleTest)
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST PROPERTIES LABELS ${ARG_LABEL}
                                                                    ENVIRONMENT "${ARG_ENVIRONMENT}")
  endif()
endfunction()
