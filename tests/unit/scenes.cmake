# These tests check that scenes/make_scenes.py reproduces the files in scenes/ byte for byte.
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)
foreach(scene teapot spheres cornell_box roughness_spheres mis_plates checker_plane thin_wires glass_metal
              material_rows moving_blade shallow_focus night_street window_room caustics studio dusk)
  add_test(NAME scenes.${scene}
           COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/scenes/make_scenes.py --check ${scene})
  set_tests_properties(scenes.${scene} PROPERTIES TIMEOUT 120)
endforeach()
