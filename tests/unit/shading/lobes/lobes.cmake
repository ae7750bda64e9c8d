foreach(part sheen_lobe thin_film anisotropic_ggx wavelength)
  emberline_test(${part}_test OPTIMISED
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/${part}_test.cpp LINK emberline_shading)
endforeach()
