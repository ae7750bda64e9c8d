foreach(part bsdf layered_bsdf texture material material_layers shading_normal transmission)
  emberline_test(${part}_test OPTIMISED
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/${part}_test.cpp LINK emberline_shading)
endforeach()
