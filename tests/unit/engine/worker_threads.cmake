emberline_test(worker_threads_test TIMED
  SOURCES engine/worker_threads_test.cpp
  LINK emberline_app TBB::tbb)
