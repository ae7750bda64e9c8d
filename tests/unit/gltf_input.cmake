emberline_test(gltf_input_test
  SOURCES
    gltf_animation_test.cpp
    gltf_changes_test.cpp
    gltf_shutter_test.cpp
    gltf_compression_test.cpp
    gltf_containers_test.cpp
    gltf_coverage_test.cpp
    gltf_deform_test.cpp
    gltf_geometry_test.cpp
    gltf_scene_test.cpp
    gltf_tangents_test.cpp
    gltf_variants_test.cpp
    ${CMAKE_SOURCE_DIR}/tests/support/compressed_gltf.cpp
  LINK
    emberline_io
    emberline_scene
    draco::draco
    meshoptimizer::meshoptimizer
    nlohmann_json::nlohmann_json)

emberline_test(image_input_test
  SOURCES image_input_test.cpp image_colour_test.cpp gltf_material_fixture.cpp gltf_material_test.cpp
          gltf_material_layers_test.cpp ktx2_test.cpp png_jpeg_test.cpp
  LINK emberline_app emberline_io emberline_output OpenImageIO::OpenImageIO PNG::PNG JPEG::JPEG nlohmann_json::nlohmann_json)
emberline_ktx2_files(image_input_test)
