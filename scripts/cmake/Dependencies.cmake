# All look-ups of third-party libraries. scripts/packages.txt lists the Debian packages.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(HDF5 1.10 REQUIRED COMPONENTS C HL)
find_package(ZLIB REQUIRED)
pkg_check_modules(seccomp REQUIRED IMPORTED_TARGET libseccomp)
find_package(CLI11 REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(tomlplusplus REQUIRED)
find_path(VALIJSON_INCLUDE_DIR valijson/validator.hpp REQUIRED)
add_library(vrda_valijson INTERFACE)
target_include_directories(vrda_valijson SYSTEM INTERFACE ${VALIJSON_INCLUDE_DIR})

# FindHDF5 of CMake 3.25 defines variables only; wrapped in one target.
add_library(vrda_hdf5 INTERFACE)
target_include_directories(vrda_hdf5 SYSTEM INTERFACE ${HDF5_INCLUDE_DIRS})
target_link_libraries(vrda_hdf5 INTERFACE ${HDF5_C_HL_LIBRARIES} ${HDF5_C_LIBRARIES})
target_compile_definitions(vrda_hdf5 INTERFACE ${HDF5_DEFINITIONS})

find_program(ESBUILD esbuild REQUIRED)
# The system's Python, which has Debian's fontTools, h5py and xarray.
find_program(SYSTEM_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)

# Font of images and of the user interface; embedded in each program.
find_file(VRDA_FONT DejaVuSans.ttf PATHS /usr/share/fonts/truetype/dejavu NO_DEFAULT_PATH REQUIRED)

if(VRDA_PIPELINE)
  find_package(pugixml REQUIRED)
  find_path(STB_INCLUDE_DIR stb/stb_truetype.h REQUIRED)
  add_library(vrda_stb INTERFACE)
  target_include_directories(vrda_stb SYSTEM INTERFACE ${STB_INCLUDE_DIR})
  pkg_check_modules(bullet REQUIRED IMPORTED_TARGET bullet-float64)
  find_package(assimp REQUIRED)
  find_package(OpenSSL REQUIRED COMPONENTS Crypto)
  # Plots of the report: plotly.js of python3-plotly, minified and bundled by esbuild.
  find_file(PLOTLY_JS plotly.js PATHS /usr/share/python3-plotly NO_DEFAULT_PATH REQUIRED)
endif()

if(VRDA_PLAYER OR VRDA_TESTS)
  find_package(PNG REQUIRED)
endif()

if(VRDA_PLAYER)
  pkg_check_modules(osmesa REQUIRED IMPORTED_TARGET osmesa)
  pkg_check_modules(egl REQUIRED IMPORTED_TARGET egl)
  pkg_check_modules(imgui REQUIRED IMPORTED_TARGET imgui)
  find_package(glfw3 3.3 REQUIRED)
  find_package(meshoptimizer REQUIRED)
  # Header-only use: Boost.Asio, Boost.Beast and Boost.Math.
  find_package(Boost 1.74 REQUIRED)
  # Not find_package: its CMake files contain paths of the machine that built it.
  find_path(OPENIGTLINK_INCLUDE_DIR igtlMessageHeader.h PATH_SUFFIXES openigtlink REQUIRED)
  find_library(OPENIGTLINK_LIBRARY OpenIGTLink REQUIRED)
  add_library(vrda_openigtlink INTERFACE)
  target_include_directories(vrda_openigtlink SYSTEM INTERFACE ${OPENIGTLINK_INCLUDE_DIR})
  target_link_libraries(vrda_openigtlink INTERFACE ${OPENIGTLINK_LIBRARY})
  # Bundles the web page; its npm packages are installed by scripts/setup.
  find_program(NODE NAMES node nodejs REQUIRED)
  find_program(ZOPFLI zopfli REQUIRED)
  find_file(VRDA_WEB_PACKAGES three/package.json PATHS ${CMAKE_SOURCE_DIR}/player/web/node_modules NO_DEFAULT_PATH)
  if(NOT VRDA_WEB_PACKAGES)
    message(FATAL_ERROR "player/web/node_modules: found no three, wanted the npm packages; run scripts/setup")
  endif()
endif()

find_package(NLopt REQUIRED)
if(VRDA_TESTS OR VRDA_BENCHMARKS)
  find_package(GTest REQUIRED)
endif()
if(VRDA_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
if(VRDA_TESTS AND VRDA_PIPELINE)
  # For tests of report pages.
  find_program(CHROMIUM chromium REQUIRED)
endif()
if(VRDA_BENCHMARKS OR (VRDA_TESTS AND VRDA_PIPELINE))
  find_package(fcl REQUIRED)
endif()
