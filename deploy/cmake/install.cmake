# What `cmake --install` copies, and the package that lets another project write
#   find_package(pliant REQUIRED)
#   target_link_libraries(solver PRIVATE pliant::core pliant::client)
# Included by the root, after all targets are known.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Libraries that others may link to, those that are part of this build.
set(exported_targets pliant_compile_options)
foreach(name IN ITEMS core proto columns client)
  if(TARGET pliant_${name})
    list(APPEND exported_targets pliant_${name})
    set_target_properties(pliant_${name} PROPERTIES EXPORT_NAME ${name})
    target_compile_features(pliant_${name} PUBLIC cxx_std_20)
    # Two roots: `#include <pliant/core/pliant/remesher.h>` for the user, and the path from the
    # repository's root that the headers themselves use.
    target_include_directories(pliant_${name} INTERFACE
      $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
      $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/pliant>)
  endif()
endforeach()
set_target_properties(pliant_compile_options PROPERTIES EXPORT_NAME compile_options)
install(TARGETS ${exported_targets} EXPORT pliantTargets)

foreach(program IN ITEMS pliantd pliant)
  if(TARGET ${program})
    install(TARGETS ${program})
  endif()
endforeach()

install(DIRECTORY ${PROJECT_SOURCE_DIR}/core/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pliant/core
        FILES_MATCHING PATTERN *.h)
if(TARGET pliant_client)
  # The other headers of client/cpp are its own affair: they show the wire.
  foreach(header IN ITEMS client.h job_types.h mesh_replica.h session.h subscription.h
          types.h)
    install(FILES ${PROJECT_SOURCE_DIR}/client/cpp/${header}
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pliant/client/cpp)
  endforeach()
endif()
if(TARGET pliant_proto)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/proto/
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pliant FILES_MATCHING PATTERN *.pb.h
          PATTERN CMakeFiles EXCLUDE)
  install(FILES ${PROJECT_SOURCE_DIR}/proto/columns.h
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pliant/proto)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/proto/pliant
          DESTINATION ${CMAKE_INSTALL_DATADIR}/pliant/proto FILES_MATCHING PATTERN *.proto)
endif()

set(pliant_exports_client OFF)
if(TARGET pliant_client)
  set(pliant_exports_client ON)
endif()
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/pliant)
install(EXPORT pliantTargets NAMESPACE pliant:: DESTINATION ${package_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/pliantConfig.cmake.in
  ${PROJECT_BINARY_DIR}/pliantConfig.cmake INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/pliantConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/pliantConfig.cmake
              ${PROJECT_BINARY_DIR}/pliantConfigVersion.cmake DESTINATION ${package_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
