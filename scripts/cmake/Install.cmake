# Rules of `cmake --install DIR`, for any user and any prefix. The prefix is not compiled in: the programs read no file of
# their own, and vrda looks for vrda-player in its own folder.
include(GNUInstallDirs)

# Libraries are searched in ../lib of the programs first; DIR/lib is empty except in the tarball.
function(vrda_install program component)
  set_target_properties(${program} PROPERTIES INSTALL_RPATH "$ORIGIN/../lib")
  # DT_RPATH also applies to the libraries' own dependencies and precedes LD_LIBRARY_PATH: cluster modules often put
  # another libstdc++ or HDF5 there.
  target_link_options(${program} PRIVATE LINKER:--disable-new-dtags)
  install(TARGETS ${program} RUNTIME COMPONENT ${component})
  install(FILES ${CMAKE_BINARY_DIR}/man/${program}.1 TYPE MAN RENAME man1/${program}.1 COMPONENT ${component})
endfunction()

if(VRDA_PIPELINE)
  vrda_install(vrda pipeline)
  foreach(folder jobs schemas)
    install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_DATADIR}/vrda COMPONENT pipeline
      FILES_MATCHING PATTERN *.toml PATTERN *.md PATTERN *.json PATTERN *.csv PATTERN *.xml)
  endforeach()
endif()
if(VRDA_PLAYER)
  vrda_install(vrda-player player)
  # The web page for use without the program, with a sample inside, and lessons; vrda-player embeds the page too.
  install(FILES ${CMAKE_BINARY_DIR}/player/web/vrda-player.html DESTINATION ${CMAKE_INSTALL_DATADIR}/vrda COMPONENT player)
  install(DIRECTORY ${CMAKE_BINARY_DIR}/player/web/lessons DESTINATION ${CMAKE_INSTALL_DATADIR}/vrda COMPONENT player OPTIONAL)
endif()
if(TARGET vrda-webcam)
  vrda_install(vrda-webcam webcam)
endif()
if(VRDA_PYTHON)
  # Where Debian's Python looks for packages, for every minor version of Python 3.
  set(VRDA_PYTHON_FOLDER lib/python3/dist-packages/vrda)
  install(TARGETS vrda_python LIBRARY DESTINATION ${VRDA_PYTHON_FOLDER} COMPONENT python
    PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  foreach(file __init__.py _errors.py _core.pyi py.typed)
    install(FILES pipeline/python/vrda/${file} DESTINATION ${VRDA_PYTHON_FOLDER} COMPONENT python)
  endforeach()
  install(FILES pipeline/python/examples/knee.py pipeline/python/examples/knee.ipynb DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-vrda/examples COMPONENT python)
endif()
install(FILES README.md LICENSE CHANGELOG.md TYPE DOC COMPONENT pipeline)
