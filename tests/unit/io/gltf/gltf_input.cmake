emberline_test(gltf_input_test
  SOURCES
    io/gltf/animation/gltf_animation_test.cpp
    io/gltf/gltf_changes_test.cpp
    io/gltf/animation/gltf_shutter_test.cpp
    io/gltf/document/gltf_compression_test.cpp
    io/gltf/document/gltf_containers_test.cpp
    io/gltf/document/gltf_coverage_test.cpp
    io/gltf/animation/gltf_deform_test.cpp
    io/gltf/geometry/gltf_geometry_test.cpp
    io/gltf/gltf_scene_test.cpp
    io/gltf/geometry/gltf_tangents_test.cpp
    io/gltf/materials/gltf_variants_test.cpp
    ${CMAKE_SOURCE_DIR}/tests/support/compressed_gltf.cpp
  LINK
    emberline_io
    emberline_scene
    draco::draco
    meshoptimizer::meshoptimizer
    nlohmann_json::nlohmann_json)

emberline_test(image_input_test
  SOURCES io/image/image_input_test.cpp io/image/image_colour_test.cpp gltf_material_fixture.cpp io/gltf/materials/gltf_material_test.cpp
          io/gltf/materials/gltf_material_layers_test.cpp io/image/ktx2_test.cpp io/image/png_jpeg_test.cpp
  LINK emberline_app emberline_io emberline_output OpenImageIO::OpenImageIO PNG::PNG JPEG::JPEG nlohmann_json::nlohmann_json)
emberline_ktx2_files(image_input_test)
