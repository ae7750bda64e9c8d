"""Compresses with Deflate (RFC 1951) in a zlib frame (RFC 1950). The scene files must have the same bytes everywhere,
but zlib guarantees only the decoded data: zlib-ng, zlib 1.3 and Debian's zlib write different bytes. Therefore this
module implements Deflate with greedy LZ77, short hash chains and dynamic Huffman codes. Its output is a few per cent
larger than that of zlib -9."""

import heapq
import zlib

_WINDOW = 32768
_LONGEST = 258
_CHAIN = 12  # candidates per position; more candidates would make our textures less than 1 % smaller
_BLOCK = 1 << 15  # tokens per Huffman block

_LENGTH_BASE = [3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163,
                195, 227, 258]
_LENGTH_EXTRA = [0] * 8 + [1] * 4 + [2] * 4 + [3] * 4 + [4] * 4 + [5] * 4 + [0]
_DISTANCE_BASE = [1, 2, 3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385, 513, 769, 1025, 1537, 2049,
                  3073, 4097, 6145, 8193, 12289, 16385, 24577]
_DISTANCE_EXTRA = [0, 0, 0, 0] + [n for e in range(1, 14) for n in (e, e)]
_CODE_LENGTH_ORDER = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15]


def _symbol_table(bases, size):
    table = [0] * (size + 1)
    for symbol, base in enumerate(bases):
        for value in range(base, size + 1):
            table[value] = symbol
    return table


_LENGTH_SYMBOL = _symbol_table(_LENGTH_BASE, _LONGEST)
_DISTANCE_SYMBOL = _symbol_table(_DISTANCE_BASE, _WINDOW)


class _Bits:
    """Packs bits into bytes, the lowest bit first."""

    def __init__(self):
        self.out = bytearray()
        self.held = 0
        self.count = 0

    def put(self, value, bits):
        self.held |= value << self.count
        self.count += bits
        while self.count >= 8:
            self.out.append(self.held & 255)
            self.held >>= 8
            self.count -= 8

    def flush(self):
        if self.count:
            self.out.append(self.held & 255)
        self.held = self.count = 0


def _tokens(data):
    """Returns the tokens of `data`: literals as ints, and matches as (length, distance)."""
    tokens = []
    chains = {}
    i, end = 0, len(data)
    while i < end:
        key = data[i:i + 3]
        best, distance = 2, 0
        chain = chains.get(key) if len(key) == 3 else None
        if chain:
            most = min(_LONGEST, end - i)
            for j in reversed(chain):
                if i - j > _WINDOW:
                    break
                if data[j:j + best + 1] != data[i:i + best + 1]:
                    continue
                n = best + 1
                while n < most and data[j + n] == data[i + n]:
                    n += 1
                if n > best:
                    best, distance = n, i - j
                    if n == most:
                        break
        step = best if distance else 1
        tokens.append((best, distance) if distance else data[i])
        for p in range(i, min(i + step, end - 2), 1 if step < 64 else 7):
            chain = chains.setdefault(data[p:p + 3], [])
            chain.append(p)
            if len(chain) > _CHAIN:
                del chain[0]
        i += step
    return tokens


def _code_lengths(frequencies, limit):
    """Returns Huffman code lengths of at most `limit` bits. Flattens the counts until the tree is shallow enough. This
    compresses slightly worse than package-merge, but needs only a quarter of the code."""
    counts = list(frequencies)
    used = [s for s, n in enumerate(counts) if n]
    while len(used) < 2:  # a decoder may reject a Huffman code with a single code word
        counts[0 if not counts[0] else 1] += 1
        used = [s for s, n in enumerate(counts) if n]
    while True:
        heap = [(counts[s], s, (s,)) for s in used]
        heapq.heapify(heap)
        lengths = [0] * len(counts)
        while len(heap) > 1:
            a, b = heapq.heappop(heap), heapq.heappop(heap)
            for s in a[2] + b[2]:
                lengths[s] += 1
            heapq.heappush(heap, (a[0] + b[0], min(a[1], b[1]), a[2] + b[2]))
        if max(lengths) <= limit:
            return lengths
        for s in used:
            counts[s] = (counts[s] >> 1) | 1


def _codes(lengths):
    """Returns the canonical codes (RFC 1951, 3.2.2), with their bits reversed for `_Bits.put`."""
    codes = [0] * len(lengths)
    code = 0
    for n in range(1, 16):
        for s, length in enumerate(lengths):
            if length == n:
                codes[s] = int(format(code, f"0{n}b")[::-1], 2)
                code += 1
        code <<= 1
    return codes


def _run_lengths(lengths):
    """Encodes the code lengths in the alphabet of RFC 1951, 3.2.7, as (symbol, extra value, extra bits)."""
    out = []
    i = 0
    while i < len(lengths):
        value, n = lengths[i], 1
        while i + n < len(lengths) and lengths[i + n] == value:
            n += 1
        i += n
        if value == 0:
            while n >= 11:
                out.append((18, min(n, 138) - 11, 7))
                n -= min(n, 138)
            if n >= 3:
                out.append((17, n - 3, 3))
                n = 0
        else:
            out.append((value, 0, 0))
            n -= 1
            while n >= 3:
                out.append((16, min(n, 6) - 3, 2))
                n -= min(n, 6)
        out.extend([(value, 0, 0)] * n)
    return out


def _write_block(bits, tokens, last):
    literal, distance = [0] * 286, [0] * 30
    literal[256] = 1
    for token in tokens:
        if isinstance(token, int):
            literal[token] += 1
        else:
            literal[257 + _LENGTH_SYMBOL[token[0]]] += 1
            distance[_DISTANCE_SYMBOL[token[1]]] += 1
    literal_lengths, distance_lengths = _code_lengths(literal, 15), _code_lengths(distance, 15)
    runs = _run_lengths(literal_lengths + distance_lengths)
    counts = [0] * 19
    for symbol, _, _ in runs:
        counts[symbol] += 1
    meta_lengths = _code_lengths(counts, 7)
    meta_codes = _codes(meta_lengths)
    sent = 19
    while sent > 4 and not meta_lengths[_CODE_LENGTH_ORDER[sent - 1]]:
        sent -= 1
    bits.put(1 if last else 0, 1)
    bits.put(2, 2)
    bits.put(286 - 257, 5)
    bits.put(30 - 1, 5)
    bits.put(sent - 4, 4)
    for symbol in _CODE_LENGTH_ORDER[:sent]:
        bits.put(meta_lengths[symbol], 3)
    for symbol, extra, width in runs:
        bits.put(meta_codes[symbol], meta_lengths[symbol])
        bits.put(extra, width)
    literal_codes, distance_codes = _codes(literal_lengths), _codes(distance_lengths)
    for token in tokens:
        if isinstance(token, int):
            bits.put(literal_codes[token], literal_lengths[token])
            continue
        s = _LENGTH_SYMBOL[token[0]]
        bits.put(literal_codes[257 + s], literal_lengths[257 + s])
        bits.put(token[0] - _LENGTH_BASE[s], _LENGTH_EXTRA[s])
        s = _DISTANCE_SYMBOL[token[1]]
        bits.put(distance_codes[s], distance_lengths[s])
        bits.put(token[1] - _DISTANCE_BASE[s], _DISTANCE_EXTRA[s])
    bits.put(literal_codes[256], literal_lengths[256])


def compress(data):
    """Compresses `data` (bytes) to a zlib stream and checks that it decodes to `data`."""
    bits = _Bits()
    tokens = _tokens(data)
    starts = range(0, max(len(tokens), 1), _BLOCK)
    for start in starts:
        _write_block(bits, tokens[start:start + _BLOCK], start == starts[-1])
    bits.flush()
    stream = b"\x78\xda" + bytes(bits.out) + zlib.adler32(data).to_bytes(4, "big")
    if zlib.decompress(stream) != data:
        raise AssertionError("deflate: the stream does not decode to its input")
    return stream
