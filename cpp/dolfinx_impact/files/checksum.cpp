// SPDX-License-Identifier: MIT
#include "checksum.h"
#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace dolfinx_impact::files
{
namespace
{
constexpr std::size_t block_size = 128; // bytes that are mixed in at once

/// The first 64 bits of the fractional parts of the square roots of the first eight primes.
constexpr std::array<std::uint64_t, 8> start{0x6a09e667f3bcc908, 0xbb67ae8584caa73b, 0x3c6ef372fe94f82b,
                                             0xa54ff53a5f1d36f1, 0x510e527fade682d1, 0x9b05688c2b3e6c1f,
                                             0x1f83d9abfb41bd6b, 0x5be0cd19137e2179};

/// Order of the words of a block in each round; the last two rounds have that of the first two.
constexpr std::uint8_t order[10][16] = {
    {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}, {14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3},
    {11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4}, {7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8},
    {9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13}, {2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9},
    {12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11}, {13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10},
    {6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5}, {10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0}};

std::uint64_t word(const std::byte* bytes)
{
  std::uint64_t out;
  std::memcpy(&out, bytes, sizeof out);
  if constexpr (std::endian::native == std::endian::big)
    out = __builtin_bswap64(out);
  return out;
}

inline void mix(std::uint64_t& a, std::uint64_t& b, std::uint64_t& c, std::uint64_t& d, std::uint64_t x,
                std::uint64_t y)
{
  a += b + x;
  d = std::rotr(d ^ a, 32);
  c += d;
  b = std::rotr(b ^ c, 24);
  a += b + y;
  d = std::rotr(d ^ a, 16);
  c += d;
  b = std::rotr(b ^ c, 63);
}

/// One round. The order is known at compile time, so that all 32 words stay in registers or on the stack.
template <int round>
inline void mix_round(std::uint64_t (&v)[16], const std::uint64_t (&m)[16])
{
  constexpr const std::uint8_t(&s)[16] = order[round % 10];
  mix(v[0], v[4], v[8], v[12], m[s[0]], m[s[1]]);
  mix(v[1], v[5], v[9], v[13], m[s[2]], m[s[3]]);
  mix(v[2], v[6], v[10], v[14], m[s[4]], m[s[5]]);
  mix(v[3], v[7], v[11], v[15], m[s[6]], m[s[7]]);
  mix(v[0], v[5], v[10], v[15], m[s[8]], m[s[9]]);
  mix(v[1], v[6], v[11], v[12], m[s[10]], m[s[11]]);
  mix(v[2], v[7], v[8], v[13], m[s[12]], m[s[13]]);
  mix(v[3], v[4], v[9], v[14], m[s[14]], m[s[15]]);
}

/// @param[in] so_far number of bytes up to the end of this block; files have less than 2^64
void compress(std::array<std::uint64_t, 8>& h, const std::byte* block, std::uint64_t so_far, bool last)
{
  std::uint64_t v[16], m[16];
  for (int i = 0; i < 8; ++i)
  {
    v[i] = h[i];
    v[i + 8] = start[i];
  }
  v[12] ^= so_far;
  v[14] = last ? ~v[14] : v[14];
  for (int i = 0; i < 16; ++i)
    m[i] = word(block + 8 * i);
  [&]<int... rounds>(std::integer_sequence<int, rounds...>)
  { (mix_round<rounds>(v, m), ...); }(std::make_integer_sequence<int, 12>());
  for (int i = 0; i < 8; ++i)
    h[i] ^= v[i] ^ v[i + 8];
}
} // namespace

Checksum checksum(std::span<const std::byte> data)
{
  Checksum out;
  std::array<std::uint64_t, 8> h = start;
  h[0] ^= 0x01010000 ^ out.size(); // no key, no tree, length of the digest
  std::size_t done = 0;
  for (; data.size() - done > block_size; done += block_size)
    compress(h, data.data() + done, done + block_size, false);
  std::byte rest[block_size] = {};
  std::copy(data.begin() + std::ptrdiff_t(done), data.end(), rest);
  compress(h, rest, data.size(), true);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = std::uint8_t(h[i / 8] >> (8 * (i % 8)));
  return out;
}
} // namespace dolfinx_impact::files
