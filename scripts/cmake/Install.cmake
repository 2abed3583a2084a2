# What `cmake --install DIR` lays down, for any user and any prefix. Nothing in it knows the prefix: the programs read no
# file of their own, and vrda looks for vrda-player beside itself.
include(GNUInstallDirs)

# Libraries are looked for beside the programs first; DIR/lib is empty but in the tarball.
function(vrda_install program component)
  set_target_properties(${program} PROPERTIES INSTALL_RPATH "$ORIGIN/../lib")
  # As DT_RPATH, which holds for the libraries' own libraries too and goes before LD_LIBRARY_PATH: the modules of a
  # cluster often put another libstdc++ or HDF5 there.
  target_link_options(${program} PRIVATE LINKER:--disable-new-dtags)
  install(TARGETS ${program} RUNTIME COMPONENT ${component})
  install(FILES ${CMAKE_BINARY_DIR}/man/${program}.1 TYPE MAN RENAME man1/${program}.1 COMPONENT ${component})
endfunction()

if(VRDA_PIPELINE)
  vrda_install(vrda pipeline)
  foreach(folder jobs schemas)
    install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_DATADIR}/vrda COMPONENT pipeline
      FILES_MATCHING PATTERN *.toml PATTERN *.md PATTERN *.json PATTERN *.csv)
  endforeach()
endif()
if(VRDA_PLAYER)
  vrda_install(vrda-player player)
  # For who has no program, only a browser; vrda-player itself carries the page.
  install(FILES ${CMAKE_BINARY_DIR}/player/web/vrda-player.html DESTINATION ${CMAKE_INSTALL_DATADIR}/vrda COMPONENT player)
endif()
install(FILES README.md LICENSE CHANGELOG.md TYPE DOC COMPONENT pipeline)
