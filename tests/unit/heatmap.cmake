emberline_test(heatmap_test OPTIMISED
  SOURCES
    colour_map_test.cpp
    heatmap_test.cpp
    heatmap_quantity_test.cpp
    pixel_text_test.cpp
    value_scale_test.cpp
  LINK emberline_statistics emberline_engine)
