// Reads BasisLZ, the supercompression of ETC1S images. An image has a palette of endpoints (colour
// and intensity), a palette of selectors (one of four modifiers per pixel), and slices that store
// an index into each palette for every block. See the KTX specification, appendices "BasisLZ Global
// Data" and "BasisLZ/ETC1S Bitstream".
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/image/ktx2/container.h"
#include "io/image/ktx2/huffman.h"

namespace emberline::ktx2 {

struct Endpoint {
  std::array<uint8_t, 3> colour = {};  // 5 bits each
  uint8_t intensity = 0;               // row of ETC1's modifier table, 0 to 7
};

// The selectors of a block: one byte per row, with two bits per pixel. The leftmost pixel is in the
// lowest bits. 0 is the most negative modifier.
using Selectors = std::array<uint8_t, kBlockSide>;

// The header of the global data, and the data itself, still encoded.
struct BasisLzHeader {
  uint32_t endpoints = 0, selectors = 0;
  Bytes endpoint_data, selector_data, table_data;
  std::array<Bytes, 2> slices;  // of level 0; the second may be empty

  uint64_t decoded_bytes() const {  // memory of the decoded palettes
    return uint64_t(endpoints) * sizeof(Endpoint) + uint64_t(selectors) * sizeof(Selectors);
  }
};

// Checks the slices of all levels and reads the header. Throws InputError.
BasisLzHeader read_basis_lz_header(const Container& container, const std::string& place);

// Decoded tables, which all slices share.
struct BasisLzTables {
  std::vector<Endpoint> endpoints;
  std::vector<Selectors> selectors;
  HuffmanTable endpoint_prediction, endpoint_delta, selector, selector_run;
  uint32_t history = 0;  // number of selectors in the history
};

// Throws InputError.
BasisLzTables read_basis_lz_tables(const BasisLzHeader& header, const std::string& place);

// Reads the blocks of a slice row by row, from the first row.
class SliceReader {
 public:
  struct Block {
    uint16_t endpoint = 0, selector = 0;  // always inside the palettes
  };

  // `tables` must outlive this reader.
  SliceReader(const BasisLzTables& tables, Bytes slice, size_t blocks_across,
              const std::string& place);

  // Returns the next row, which is valid until the next call. Throws InputError.
  std::span<const Block> next_row();

 private:
  uint32_t next_prediction();
  uint16_t next_endpoint(size_t x, uint32_t prediction);
  uint16_t next_selector();

  const BasisLzTables& tables_;
  BitReader bits_;
  uint64_t row_number_ = 0;
  std::vector<Block> row_;
  std::vector<uint16_t> previous_endpoints_;  // endpoints of the previous row
  std::vector<uint8_t> predictions_;  // per pair of blocks, the predictions for the next odd row
  uint32_t last_prediction_ = 0;
  uint64_t prediction_run_ = 0;
  uint32_t last_endpoint_ = 0;
  // The selector history, which is an approximate move-to-front list.
  std::vector<uint16_t> history_;
  size_t rover_ = 0;
  uint64_t selector_run_ = 0;
};

// Decodes a block to RGB, with rows from the top, as in Khronos Data Format Specification 1.4,
// "ETC1S".
using EtcPixels = std::array<std::array<uint8_t, 3>, kBlockPixels>;
EtcPixels decode_etc1s(const Endpoint& endpoint, const Selectors& selectors);

}  // namespace emberline::ktx2
