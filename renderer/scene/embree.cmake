# Uses Embree 4 if the system has it, otherwise 3.13 or later, and defines the target emberline_embree. Only
# renderer/scene/embree_api.h reads the macro EMBERLINE_EMBREE_MAJOR.
find_package(embree 4 QUIET)
if(NOT embree_FOUND)
  find_package(embree 3.13 REQUIRED)
endif()
add_library(emberline_embree INTERFACE)
target_link_libraries(emberline_embree INTERFACE embree)
target_compile_definitions(emberline_embree INTERFACE EMBERLINE_EMBREE_MAJOR=${EMBREE_VERSION_MAJOR})
set(EMBERLINE_EMBREE_LIB embree${EMBREE_VERSION_MAJOR} CACHE INTERNAL "for programs that link libemberline.a")
