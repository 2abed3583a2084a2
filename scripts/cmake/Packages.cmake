# `cpack` in a build folder makes, for vrda and for vrda-player, a Debian package that depends on its libraries, and a
# tarball that includes them; for vrda-webcam and the Python module a Debian package. The player is separate since it
# depends on LLVM, vrda-webcam since it depends on OpenCV: 170 and 100 MB not needed on cluster nodes.
# scripts/package runs it and sets SOURCE_DATE_EPOCH, so that packages of one commit are reproducible byte for byte.
set(CPACK_GENERATOR DEB External)
set(CPACK_PACKAGE_VENDOR "The VRDA authors")
set(VRDA_MAINTAINER "The VRDA authors <authors@vrda.invalid>" CACHE STRING "Maintainer of the Debian packages")
set(CPACK_PACKAGE_CONTACT ${VRDA_MAINTAINER})
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL "")

# vrda_package(vrda COMPONENT pipeline SUGGESTS vrda-player SUMMARY ... TEXT ...)
function(vrda_package name)
  cmake_parse_arguments(PACKAGE "" "COMPONENT;SUGGESTS;SUMMARY;TEXT" "" ${ARGN})
  string(TOUPPER ${PACKAGE_COMPONENT} component)
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${PACKAGE_COMPONENT} PARENT_SCOPE)
  set(CPACK_COMPONENT_${component}_DESCRIPTION "${PACKAGE_SUMMARY}\n${PACKAGE_TEXT}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${component}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${component}_PACKAGE_SOURCE vrda PARENT_SCOPE)
  set(CPACK_DEBIAN_${component}_PACKAGE_SUGGESTS "${PACKAGE_SUGGESTS}" PARENT_SCOPE)
endfunction()

if(VRDA_PIPELINE)
  vrda_package(vrda COMPONENT pipeline SUGGESTS vrda-player
    SUMMARY "joint motion from the surfaces of bones"
    TEXT "From surface meshes of two bones, and ligament fibres where there are some,
vrda computes for every flexion and varus angle the equilibrium pose of the
moving bone in contact with the fixed one. It writes a motion model (HDF5),
reports, and files for OpenSim, ParaView and glTF viewers, on a workstation or
on a Slurm cluster.")
endif()
if(VRDA_PLAYER)
  vrda_package(vrda-player COMPONENT player SUGGESTS "vrda, ffmpeg"
    SUMMARY "shows the joint motion that vrda computed"
    TEXT "Shows the bones of a motion model that vrda wrote, at any flexion and varus
angle: in a window, in a browser, as images and as videos (through ffmpeg).
Images and videos need neither a display nor a graphics card.")
endif()
if(TARGET vrda-webcam)
  vrda_package(vrda-webcam COMPONENT webcam SUGGESTS vrda-player
    SUMMARY "webcam as the tracker of a vrda-player bench"
    TEXT "Finds printed bodies in the pictures of a webcam and sends their poses to
vrda-player. Also calibrates the camera and writes the sheets to print.")
endif()
if(VRDA_PYTHON)
  vrda_package(python3-vrda COMPONENT python SUGGESTS "vrda, python3-matplotlib"
    SUMMARY "joint motion from the surfaces of bones, Python module"
    TEXT "Solves jobs of vrda from Python: whole motions, and single attitudes under given
loads as NumPy arrays. Opens motion models as xarray data sets, smooths, compares
and exports them.")
  math(EXPR next "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-xarray, python3-h5netcdf")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # Byte code is written when the package is configured and removed with it, by Debian's own tools.
  file(WRITE ${CMAKE_BINARY_DIR}/debian-python/postinst
    "#!/bin/sh\nset -e\nif [ \"$1\" = configure ] && command -v py3compile >/dev/null; then\n  py3compile -p python3-vrda\nfi\n")
  file(WRITE ${CMAKE_BINARY_DIR}/debian-python/prerm
    "#!/bin/sh\nset -e\nif command -v py3clean >/dev/null; then\n  py3clean -p python3-vrda\nfi\n")
  file(CHMOD ${CMAKE_BINARY_DIR}/debian-python/postinst ${CMAKE_BINARY_DIR}/debian-python/prerm PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    "${CMAKE_BINARY_DIR}/debian-python/postinst;${CMAKE_BINARY_DIR}/debian-python/prerm")
endif()

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

# The tarballs: staged by CPack, packed by our script, since CPack's own archives contain the user and the time.
set(CPACK_EXTERNAL_ENABLE_STAGING ON)
set(CPACK_EXTERNAL_PACKAGE_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/PackTarballs.cmake)
string(TOLOWER "${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR}" CPACK_VRDA_SYSTEM)

set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/FinishDebian.cmake)
set(CPACK_VRDA_FINISH ${CMAKE_SOURCE_DIR}/scripts/finish_package)
set(CPACK_VERBATIM_VARIABLES ON)
include(CPack)
