# Against the shared library, of which nothing but the interface can be seen.
emberline_test(library_test SOURCES api/library_test.cpp api/library_checkpoints_test.cpp api/library_heatmaps_test.cpp api/library_layers_test.cpp
  api/library_pictures_test.cpp LINK emberline_shared)
set_target_properties(library_test PROPERTIES DISABLE_PRECOMPILE_HEADERS ON)  # without fmt, as others' programs
target_compile_definitions(library_test PRIVATE EMBERLINE_SCENES="${CMAKE_SOURCE_DIR}/scenes")
