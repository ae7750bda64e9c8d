#include "io/image/ktx2/basis_lz.h"

#include <algorithm>

#include "io/files/byte_order.h"
namespace emberline::ktx2 {
namespace {

constexpr size_t kGlobalHeader = 20, kImageEntry = 20;
constexpr uint32_t kPFrame = 2;

// Reads a number in groups of `width` bits. The lowest group comes first. After each group, one
// more bit says whether another group follows.
uint64_t take_varint(BitReader& bits, int width) {
  uint64_t value = 0;
  for (int shift = 0; shift < 32; shift += width) {
    const uint32_t group = bits.take(width + 1);
    value |= uint64_t(group & ((1u << width) - 1)) << shift;
    if (group >> width == 0) return value;
  }
  throw_damaged(bits.place(), "has an unterminated number");
}

// Each value is stored as its difference from the previous value. Colour differences use one of
// three tables. The previous value decides which one.
std::vector<Endpoint> read_endpoints(const BasisLzHeader& header, const std::string& place) {
  BitReader bits(header.endpoint_data, place, "endpoints");
  std::array<HuffmanTable, 3> colour_delta;
  for (HuffmanTable& table : colour_delta) table = HuffmanTable::read(bits);
  const HuffmanTable intensity_delta = HuffmanTable::read(bits);
  const size_t channels = bits.take(1) != 0 ? 1 : 3;
  std::vector<Endpoint> endpoints(header.endpoints);
  Endpoint last{{16, 16, 16}, 0};
  for (Endpoint& endpoint : endpoints) {
    last.intensity = uint8_t((last.intensity + intensity_delta.decode(bits)) & 7);
    for (size_t c = 0; c < channels; ++c) {
      const uint8_t before = last.colour[c];
      const size_t table = before < 10 ? 0 : before < 22 ? 1 : 2;
      last.colour[c] = uint8_t((before + colour_delta[table].decode(bits)) & 31);
    }
    if (channels == 1) last.colour.fill(last.colour[0]);
    endpoint = last;
  }
  return endpoints;
}

std::vector<Selectors> read_selectors(const BasisLzHeader& header, const std::string& place) {
  BitReader bits(header.selector_data, place, "selectors");
  if (bits.take(2) != 0) throw_damaged(place, "has selectors of an unknown kind");
  const bool is_plain = bits.take(1) != 0;
  const HuffmanTable delta = is_plain ? HuffmanTable() : HuffmanTable::read(bits);
  std::vector<Selectors> selectors(header.selectors);
  for (size_t i = 0; i < selectors.size(); ++i) {
    for (size_t y = 0; y < selectors[i].size(); ++y) {
      selectors[i][y] = i == 0 || is_plain
                            ? uint8_t(bits.take(8))
                            : uint8_t(delta.decode(bits) ^ uint32_t(selectors[i - 1][y]));
    }
  }
  return selectors;
}

}  // namespace

BasisLzHeader read_basis_lz_header(const Container& container, const std::string& place) {
  const Bytes data = container.global_data;
  const size_t begin = kGlobalHeader + kImageEntry * size_t(container.levels);
  if (data.size() < begin) throw_damaged(place, "has truncated global data");
  const auto word = [&](size_t offset) { return little_endian(data, offset, 4); };
  const uint64_t endpoints = word(4), selectors = word(8), tables = word(12), extended = word(16);
  if (extended != 0 || data.size() - begin != endpoints + selectors + tables) {
    throw_damaged(place, "has global data whose size does not match its parts");
  }
  BasisLzHeader header;
  header.endpoints = little_endian(data, 0, 2);
  header.selectors = little_endian(data, 2, 2);
  if (header.endpoints == 0 || header.selectors == 0) throw_damaged(place, "has an empty palette");
  header.endpoint_data = data.subspan(begin, size_t(endpoints));
  header.selector_data = data.subspan(begin + size_t(endpoints), size_t(selectors));
  header.table_data = data.last(size_t(tables));
  for (size_t i = 0; i < size_t(container.levels); ++i) {
    const size_t entry = kGlobalHeader + i * kImageEntry;
    if ((word(entry) & kPFrame) != 0) {
      throw InputError(place, "KTX 2 with video frames is not supported");
    }
    for (const size_t slice : {size_t(0), size_t(1)}) {
      const uint64_t offset = word(entry + 4 + 8 * slice), length = word(entry + 8 + 8 * slice);
      const bool is_there = slice == 0 || container.has_second_slice;
      if ((length > 0) != is_there || offset + length > container.level_bytes[i]) {
        throw_damaged(place, "has a slice outside its level");
      }
      if (i > 0 || !is_there) continue;
      header.slices[slice] = container.level.subspan(size_t(offset), size_t(length));
    }
  }
  return header;
}

BasisLzTables read_basis_lz_tables(const BasisLzHeader& header, const std::string& place) {
  BasisLzTables tables;
  tables.endpoints = read_endpoints(header, place);
  tables.selectors = read_selectors(header, place);
  BitReader bits(header.table_data, place, "tables");
  tables.endpoint_prediction = HuffmanTable::read(bits);
  tables.endpoint_delta = HuffmanTable::read(bits);
  tables.selector = HuffmanTable::read(bits);
  tables.selector_run = HuffmanTable::read(bits);
  tables.history = bits.take(13);
  return tables;
}

SliceReader::SliceReader(const BasisLzTables& tables, Bytes slice, size_t blocks_across,
                         const std::string& place)
    : tables_(tables),
      bits_(slice, place, "slices"),
      row_(blocks_across),
      previous_endpoints_(blocks_across),
      predictions_((blocks_across + 1) / 2),
      history_(tables.history),
      rover_(tables.history / 2) {}

std::span<const SliceReader::Block> SliceReader::next_row() {
  for (size_t x = 0; x < row_.size(); ++x) previous_endpoints_[x] = row_[x].endpoint;
  uint32_t prediction = 0;
  for (size_t x = 0; x < row_.size(); ++x) {
    // An endpoint prediction covers 2 x 2 blocks, with two bits for each. The bits of the lower two
    // blocks are kept for the next row.
    if (x % 2 == 0) {
      uint8_t& stored_prediction = predictions_[x / 2];
      prediction = row_number_ % 2 == 0 ? next_prediction() : stored_prediction;
      stored_prediction = uint8_t(prediction >> 4);
    }
    row_[x].endpoint = next_endpoint(x, prediction & 3);
    row_[x].selector = next_selector();
    prediction >>= 2;
  }
  ++row_number_;
  return row_;
}

uint32_t SliceReader::next_prediction() {
  constexpr uint32_t kRepeat = 256, kShortestRun = 3;
  if (prediction_run_ > 0) {
    --prediction_run_;
    return last_prediction_;
  }
  const uint32_t symbol = tables_.endpoint_prediction.decode(bits_);
  if (symbol > kRepeat) throw_damaged(bits_.place(), "has an unknown prediction");
  if (symbol == kRepeat) {
    prediction_run_ = take_varint(bits_, 4) + kShortestRun - 1;
  } else {
    last_prediction_ = symbol;
  }
  return last_prediction_;
}

uint16_t SliceReader::next_endpoint(size_t x, uint32_t prediction) {
  const bool has_left = x > 0, has_above = row_number_ > 0;
  if ((prediction == 0 && !has_left) || (prediction == 1 && !has_above) ||
      (prediction == 2 && !(has_left && has_above))) {
    throw_damaged(bits_.place(), "has a block that refers outside the picture");
  }
  if (prediction == 1) {
    last_endpoint_ = previous_endpoints_[x];
  } else if (prediction == 2) {
    last_endpoint_ = previous_endpoints_[x - 1];
  } else if (prediction == 3) {
    const uint32_t count = uint32_t(tables_.endpoints.size());
    last_endpoint_ += tables_.endpoint_delta.decode(bits_);
    if (last_endpoint_ >= count) last_endpoint_ -= count;
    if (last_endpoint_ >= count) {
      throw_damaged(bits_.place(), "has an endpoint outside its palette");
    }
  }
  return uint16_t(last_endpoint_);
}

uint16_t SliceReader::next_selector() {
  constexpr uint32_t kShortestRun = 3, kLongRun = 63;
  const uint32_t count = uint32_t(tables_.selectors.size()), run = count + tables_.history;
  uint32_t symbol = count;  // means the front of the history, which a run repeats
  if (selector_run_ > 0) {
    --selector_run_;
  } else {
    symbol = tables_.selector.decode(bits_);
    if (symbol == run) {
      const uint32_t length = tables_.selector_run.decode(bits_);
      selector_run_ = (length == kLongRun ? take_varint(bits_, 7) : length) + kShortestRun - 1;
      symbol = count;
    }
  }
  if (symbol < count) {
    if (!history_.empty()) {
      history_[rover_++] = uint16_t(symbol);
      if (rover_ == history_.size()) rover_ = history_.size() / 2;
    }
    return uint16_t(symbol);
  }
  const size_t index = symbol - count;
  if (index >= history_.size()) throw_damaged(bits_.place(), "has a selector outside its palette");
  const uint16_t selector = history_[index];
  std::swap(history_[index], history_[index / 2]);
  return selector;
}

EtcPixels decode_etc1s(const Endpoint& endpoint, const Selectors& selectors) {
  // This is the table "Intensity modifier sets", with each row in selector order.
  constexpr std::array<std::array<int, 4>, 8> kModifiers = {{{-8, -2, 2, 8},
                                                             {-17, -5, 5, 17},
                                                             {-29, -9, 9, 29},
                                                             {-42, -13, 13, 42},
                                                             {-60, -18, 18, 60},
                                                             {-80, -24, 24, 80},
                                                             {-106, -33, 33, 106},
                                                             {-183, -47, 47, 183}}};
  std::array<std::array<uint8_t, 3>, 4> shades;
  for (size_t s = 0; s < shades.size(); ++s) {
    for (size_t c = 0; c < 3; ++c) {
      const int base = endpoint.colour[c] << 3 | endpoint.colour[c] >> 2;
      shades[s][c] = uint8_t(std::clamp(base + kModifiers[endpoint.intensity][s], 0, 255));
    }
  }
  EtcPixels pixels;
  for (size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = shades[selectors[i / kBlockSide] >> (2 * (i % kBlockSide)) & 3];
  }
  return pixels;
}

}  // namespace emberline::ktx2
