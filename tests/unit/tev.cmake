emberline_test(tev_test TIMED
  SOURCES tev_protocol_test.cpp tev_stream_test.cpp
  LINK emberline_io)
