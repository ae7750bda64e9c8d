emberline_test(tev_test OPTIMISED TIMED
  SOURCES tev_protocol_test.cpp tev_stream_test.cpp
  LINK emberline_io)
