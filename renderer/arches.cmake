# Builds the libraries of the packages for several instruction sets, so that packages run on old processors and use the
# instructions of new ones. The command's library and libemberline.so are built for EMBERLINE_ARCH, and once more for
# each of EMBERLINE_ARCHES. The further builds are installed in folders glibc-hwcaps/ARCH beside the build for
# EMBERLINE_ARCH. glibc's loader (2.33 and later) takes the best build for the processor.
if(NOT EMBERLINE_ARCHES)
  return()
endif()

include(ExternalProject)
include(GNUInstallDirs)
set(libraries ${CMAKE_INSTALL_LIBDIR})
set(command_libraries ${CMAKE_INSTALL_LIBDIR}/emberline)

file(RELATIVE_PATH from_program ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR}/emberline)
set_target_properties(emberline PROPERTIES INSTALL_RPATH "$ORIGIN/${from_program}")
install(TARGETS emberline_command LIBRARY DESTINATION ${command_libraries} COMPONENT command)

foreach(arch ${EMBERLINE_ARCHES})
  if(arch STREQUAL EMBERLINE_ARCH)
    continue()  # skips this build itself if it is one of the further builds
  endif()
  set(build ${CMAKE_BINARY_DIR}/${arch})
  ExternalProject_Add(emberline_${arch}
    SOURCE_DIR ${CMAKE_SOURCE_DIR} BINARY_DIR ${build}
    CMAKE_ARGS -DCMAKE_BUILD_TYPE=${CMAKE_BUILD_TYPE} -DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER}
               "-DCMAKE_CXX_FLAGS=${CMAKE_CXX_FLAGS}" "-DCMAKE_CXX_FLAGS_RELEASE=${CMAKE_CXX_FLAGS_RELEASE}"
               -DEMBERLINE_LTO=${EMBERLINE_LTO} -DEMBERLINE_LIBRARY_LTO=${EMBERLINE_LIBRARY_LTO}
               -DCMAKE_SHARED_LINKER_FLAGS=-s -DEMBERLINE_NATIVE=OFF -DEMBERLINE_TESTS=OFF -DEMBERLINE_PYTHON=OFF
               -DCMAKE_SKIP_BUILD_RPATH=ON
               -DEMBERLINE_ARCH=${arch} -DEMBERLINE_ARCHES=${arch}
    BUILD_COMMAND ${CMAKE_COMMAND} --build ${build} --target emberline_command emberline_shared
    INSTALL_COMMAND "" BUILD_ALWAYS ON USES_TERMINAL_BUILD ON
    DEPENDS emberline emberline_shared)  # starts after the main build, because each build uses all processors
  install(FILES ${build}/lib/libemberline_command.so
          DESTINATION ${command_libraries}/glibc-hwcaps/${arch} COMPONENT command)
  install(DIRECTORY ${build}/lib/ DESTINATION ${libraries}/glibc-hwcaps/${arch} COMPONENT library
          FILES_MATCHING PATTERN "libemberline.so.*")
endforeach()
