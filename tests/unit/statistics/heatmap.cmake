emberline_test(heatmap_test OPTIMISED
  SOURCES
    statistics/colour_map_test.cpp
    statistics/heatmap_test.cpp
    statistics/heatmap_quantity_test.cpp
    statistics/pixel_text_test.cpp
    statistics/value_scale_test.cpp
  LINK emberline_statistics emberline_engine)
