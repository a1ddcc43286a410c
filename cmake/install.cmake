# cmake --install: the core library for other programs, as find_package(palpate) and palpate::core.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(palpate_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/palpate)
install(TARGETS palpate_core palpate_elastic palpate_moving palpate_whole_core EXPORT palpateTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT core)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/core/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/palpate/core COMPONENT core
        FILES_MATCHING PATTERN "*.h")
install(EXPORT palpateTargets NAMESPACE palpate:: DESTINATION ${palpate_package_dir} COMPONENT core)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/palpateConfig.cmake.in
                              ${CMAKE_CURRENT_BINARY_DIR}/palpateConfig.cmake
                              INSTALL_DESTINATION ${palpate_package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/palpateConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/palpateConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/palpateConfigVersion.cmake
        DESTINATION ${palpate_package_dir} COMPONENT core)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT core)
