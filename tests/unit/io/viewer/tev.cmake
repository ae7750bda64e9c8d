emberline_test(tev_test OPTIMISED TIMED
  SOURCES io/viewer/tev_protocol_test.cpp io/viewer/tev_stream_test.cpp
  LINK emberline_io)
