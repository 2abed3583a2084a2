# `cpack` in a build folder: for vrda and for vrda-player each a Debian package, which names the libraries it needs, and
# a tarball, which carries them. Two pairs, since the player drags in LLVM: 170 MB that no cluster node wants.
# scripts/package is the one command; it also sets SOURCE_DATE_EPOCH, by which two packages of one commit are the same bytes.
set(CPACK_GENERATOR DEB External)
set(CPACK_PACKAGE_VENDOR "The VRDA authors")
set(VRDA_MAINTAINER "The VRDA authors <authors@vrda.invalid>" CACHE STRING "Who answers for the Debian packages")
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
vrda finds for every flexion and varus angle where the moving bone comes to
rest against the fixed one. It writes a motion model (HDF5), reports, and
files for OpenSim, ParaView and glTF viewers, on a workstation or on a Slurm
cluster.")
endif()
if(VRDA_PLAYER)
  vrda_package(vrda-player COMPONENT player SUGGESTS "vrda, ffmpeg"
    SUMMARY "shows the joint motion that vrda computed"
    TEXT "Shows the bones of a motion model that vrda wrote, at any flexion and varus
angle: in a window, in a browser, as pictures and as films (through ffmpeg).
Pictures and films need neither a display nor a graphics card.")
endif()

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

# The tarballs: staged by CPack, packed by our script, since CPack's own archives name their maker and the hour.
set(CPACK_EXTERNAL_ENABLE_STAGING ON)
set(CPACK_EXTERNAL_PACKAGE_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/PackTarballs.cmake)
string(TOLOWER "${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR}" CPACK_VRDA_SYSTEM)

set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/FinishDebian.cmake)
set(CPACK_VRDA_FINISH ${CMAKE_SOURCE_DIR}/scripts/finish_package)
set(CPACK_VERBATIM_VARIABLES ON)
include(CPack)
