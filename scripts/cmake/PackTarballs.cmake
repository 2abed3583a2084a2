# Run by cpack's External generator: packs the staged files of each component into a tarball.
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  if(component MATCHES "^(python|webcam)$") # Debian packages only
    continue()
  endif()
  string(TOUPPER ${component} upper)
  set(name ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(tarball ${CPACK_PACKAGE_DIRECTORY}/${name}-${CPACK_PACKAGE_VERSION}-${CPACK_VRDA_SYSTEM}.tar.gz)
  # All tarballs of a version unpack into the same folder, where vrda finds the player.
  execute_process(
    COMMAND ${CPACK_VRDA_FINISH} tarball ${name} ${CPACK_PACKAGE_VERSION} ${CPACK_TEMPORARY_DIRECTORY}/${component}
      ${tarball} vrda-${CPACK_PACKAGE_VERSION}-${CPACK_VRDA_SYSTEM}
    COMMAND_ERROR_IS_FATAL ANY)
  list(APPEND CPACK_EXTERNAL_BUILT_PACKAGES ${tarball})
endforeach()
