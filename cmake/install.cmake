# What `cmake --install` lays down: libraries, headers, package files for CMake and pkg-config.
# lua/CMakeLists.txt installs the program, the Lua module and its completions.
if(LIBRT_ROCK)
  return() # a tree of LuaRocks takes the module and the program, which hold the library
endif()
include(CMakePackageConfigHelpers)

install(TARGETS librt_shared EXPORT librtTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT development)
install(TARGETS librt_static EXPORT librtStaticTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(DIRECTORY librt/include/librt DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.h")

set(librt_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/librt)
install(EXPORT librtTargets NAMESPACE librt:: FILE librtTargets.cmake DESTINATION ${librt_cmake_dir} COMPONENT development)
install(EXPORT librtStaticTargets NAMESPACE librt:: FILE librtStaticTargets.cmake DESTINATION ${librt_cmake_dir} COMPONENT development)
configure_package_config_file(cmake/librtConfig.cmake.in ${CMAKE_BINARY_DIR}/librtConfig.cmake INSTALL_DESTINATION ${librt_cmake_dir}
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/librtConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/librtConfig.cmake ${CMAKE_BINARY_DIR}/librtConfigVersion.cmake
  DESTINATION ${librt_cmake_dir} COMPONENT development)

# librt.pc finds its prefix from where it lies, so an installed tree can be moved. Only absolute install directories tie it down.
if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}" OR IS_ABSOLUTE "${CMAKE_INSTALL_INCLUDEDIR}")
  set(librt_pc_prefix ${CMAKE_INSTALL_PREFIX})
  set(librt_pc_libdir ${CMAKE_INSTALL_FULL_LIBDIR})
  set(librt_pc_includedir ${CMAKE_INSTALL_FULL_INCLUDEDIR})
else()
  file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  string(REGEX REPLACE "/$" "" up "${up}")
  set(librt_pc_prefix "\${pcfiledir}/${up}")
  set(librt_pc_libdir "\${prefix}/${CMAKE_INSTALL_LIBDIR}")
  set(librt_pc_includedir "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
endif()
# By name, not Requires.private: who links the shared library need not have libpng's development files.
set(librt_pc_private "-lm -pthread")
if(LIBRT_HAVE_PNG)
  string(PREPEND librt_pc_private "-lpng -lz ")
endif()
configure_file(cmake/librt.pc.in ${CMAKE_BINARY_DIR}/librt.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/librt.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

install(FILES LICENSE CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)
install(FILES packaging/librt-${PROJECT_VERSION}-1.rockspec DESTINATION ${CMAKE_INSTALL_DATADIR}/librt COMPONENT development)
