// Makes small JPEG and PNG images with valid pixels and hostile metadata.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "support/embedded_images.h"
#include "support/encoded_images.h"

namespace emberline::test {

using ByteList = std::vector<uint8_t>;

inline void put_u32(ByteList& out, uint32_t value) {  // writes in big-endian order
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(uint8_t(value >> shift));
}

inline ByteList bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

inline ByteList operator+(ByteList a, const ByteList& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Returns an ICC profile (ICC.1:2010, section 7) with a header, a tag table and some text. The
// profile declares that it has `tags` tags, and its tag table contains `offset` and `size`.
inline ByteList icc_profile(uint32_t tags, uint32_t offset, uint32_t size) {
  ByteList profile(128, 0);
  const std::string header[] = {"mntr", "RGB ", "XYZ "};
  for (size_t i = 0; i < 3; ++i)
    std::copy_n(header[i].begin(), 4, profile.begin() + 12 + 4 * long(i));
  std::copy_n("acsp", 4, profile.begin() + 36);
  put_u32(profile, tags);
  for (const char* name : {"desc", "cprt", "dmnd"}) {
    profile = profile + bytes_of(name);
    put_u32(profile, offset);
    put_u32(profile, size);
  }
  profile = profile + bytes_of("mluc") + ByteList(64, 0xff);
  const auto length = uint32_t(profile.size());
  for (size_t i = 0; i < 4; ++i) profile[i] = uint8_t(length >> (24 - 8 * i));
  return profile;
}

// Returns a JPEG segment with this marker.
inline ByteList jpeg_segment(uint8_t marker, const ByteList& content) {
  const size_t length = content.size() + 2;
  return ByteList{0xff, marker, uint8_t(length >> 8), uint8_t(length)} + content;
}

inline ByteList icc_segment(const ByteList& profile, uint8_t number, uint8_t of) {
  ByteList head = bytes_of("ICC_PROFILE");
  head.push_back(0);
  head.push_back(number);
  head.push_back(of);
  return jpeg_segment(0xe2, head + profile);
}

// Inserts segments into a JPEG where metadata usually is.
inline ByteList with_segments(const ByteList& jpeg, const ByteList& segments) {
  ByteList out(jpeg.begin(), jpeg.begin() + 2);
  out = out + segments;
  out.insert(out.end(), jpeg.begin() + 2, jpeg.end());
  return out;
}

inline ByteList png_chunk(const std::string& type, const ByteList& content) {
  ByteList chunk;
  put_u32(chunk, uint32_t(content.size()));
  chunk = chunk + bytes_of(type) + content;
  uint32_t crc = 0xffffffffu;
  for (size_t i = 4; i < chunk.size(); ++i) {
    crc ^= chunk[i];
    for (int k = 0; k < 8; ++k) crc = crc & 1 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
  }
  put_u32(chunk, ~crc);
  return chunk;
}

// Inserts chunks into a PNG after IHDR.
inline ByteList with_chunks(const ByteList& png, const ByteList& chunks) {
  ByteList out(png.begin(), png.begin() + 33);
  out = out + chunks;
  out.insert(out.end(), png.begin() + 33, png.end());
  return out;
}

// Returns a zlib stream of 1 + 258 * `runs` zeros. The stream is a thousand times shorter than its
// contents. It uses fixed codes (RFC 1951, section 3.2.6): one zero, and then copies of 258 bytes
// at distance 1.
inline ByteList zlib_zeros(size_t runs) {
  ByteList out = {0x78, 0x9c};
  uint32_t bits = 0;
  int count = 0;
  const auto put = [&](uint32_t code, int length, bool reversed) {
    for (int i = 0; i < length; ++i) {
      bits |= (code >> (reversed ? length - 1 - i : i) & 1) << count;
      if (++count < 8) continue;
      out.push_back(uint8_t(bits));
      bits = 0;
      count = 0;
    }
  };
  put(1, 1, false);    // this is the last block
  put(1, 2, false);    // it uses fixed codes
  put(0x30, 8, true);  // literal 0
  for (size_t i = 0; i < runs; ++i) {
    put(0xc5, 8, true);  // length 258
    put(0, 5, true);     // distance 1
  }
  put(0, 7, true);  // end of block
  if (count > 0) out.push_back(uint8_t(bits));
  put_u32(out, uint32_t((1 + 258 * runs) % 65521) << 16 | 1);  // Adler-32 of zeros
  return out;
}

// The JPEG images below have the pixels of this image.
inline ByteList small_jpeg() {
  ByteList pixels;
  for (int i = 0; i < 16 * 16 * 3; ++i) pixels.push_back(uint8_t(i));
  return encode_image<uint8_t>("jpg", OIIO::ImageSpec(16, 16, 3, OIIO::TypeDesc::UINT8), pixels);
}

inline std::vector<ByteList> images_with_hostile_metadata() {
  const ByteList jpeg = small_jpeg(), png = small_png();
  std::vector<ByteList> images;
  const uint32_t ends[] = {0, 128, 200, 0x7fffffff, 0x80000000, 0xfffffff0};
  for (const uint32_t offset : ends) {
    for (const uint32_t size : {0u, 16u, 0xffffffffu}) {
      images.push_back(with_segments(jpeg, icc_segment(icc_profile(3, offset, size), 1, 1)));
    }
  }
  for (const uint32_t tags : {0u, 1u, 1000u, 0x10000000u, 0xffffffffu}) {
    const ByteList profile = icc_profile(tags, 200, 16);
    images.push_back(with_segments(jpeg, icc_segment(profile, 1, 1)));
    images.push_back(with_chunks(png, png_chunk("iCCP", bytes_of("x") + ByteList{0, 0} + profile)));
  }
  for (const auto& [number, of] : {std::pair{1, 2}, {2, 2}, {0, 0}, {255, 255}, {3, 1}, {1, 0}}) {
    const ByteList profile = icc_profile(3, 200, 16);
    images.push_back(with_segments(jpeg, icc_segment(profile, uint8_t(number), uint8_t(of))));
    images.push_back(with_segments(jpeg, icc_segment(profile, 1, uint8_t(of)) +
                                             icc_segment(profile, uint8_t(number), 2) +
                                             icc_segment({}, 2, 2)));
  }
  std::mt19937 random(16);
  for (int i = 0; i < 10; ++i) {
    ByteList noise(200 + random() % 1000);
    for (uint8_t& byte : noise) byte = uint8_t(random());
    const ByteList exif = bytes_of("Exif") + ByteList{0, 0, 'M', 'M', 0, 42, 0, 0, 0, 8} + noise;
    images.push_back(with_segments(
        jpeg,
        jpeg_segment(0xe1, exif) +
            jpeg_segment(0xe1, bytes_of("http://ns.adobe.com/xap/1.0/") + ByteList{0} + noise) +
            jpeg_segment(0xed, bytes_of("Photoshop 3.0") + ByteList{0} + bytes_of("8BIM") + noise) +
            jpeg_segment(0xfe, noise)));
  }
  for (const size_t runs : {10u, 1000u, 400000u, 1000000u, 2000000u}) {
    const ByteList zeros = zlib_zeros(runs), name = bytes_of("x") + ByteList{0, 0};
    images.push_back(with_chunks(png, png_chunk("iCCP", name + zeros)));
    images.push_back(with_chunks(png, png_chunk("zTXt", name + zeros)));
  }
  return images;
}

}  // namespace emberline::test
