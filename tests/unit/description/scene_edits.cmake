emberline_test(scene_edits_test SOURCES description/scene_edits_test.cpp io/json/edits_file_test.cpp
  LINK emberline_scene emberline_io)
emberline_image_files(scene_edits_test)
