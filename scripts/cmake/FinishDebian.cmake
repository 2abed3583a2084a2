# Run by cpack between staging and packing: changes for Debian packages relative to `cmake --install`.
if(CPACK_GENERATOR STREQUAL "DEB")
  foreach(component IN LISTS CPACK_COMPONENTS_ALL)
    string(TOUPPER ${component} upper)
    set(name ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
    set(stage ${CPACK_TEMPORARY_DIRECTORY}/${component})
    # Debian packages use the system's libraries: no RPATH.
    if(EXISTS ${stage}/usr/bin/${name})
      file(RPATH_REMOVE FILE ${stage}/usr/bin/${name})
    endif()
    execute_process(COMMAND ${CPACK_VRDA_FINISH} debian ${name} ${CPACK_PACKAGE_VERSION} ${stage} ${CPACK_PACKAGE_CONTACT}
      COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
endif()
