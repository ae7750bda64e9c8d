"""Reads and writes checkpoint files without the program's code. io/files/record_file.h describes the format, and
io/files/fingerprint.cpp and renderer/core/hash.h describe the checksum. This module unpacks bytes with the libzstd that
the program is linked to. It packs bytes without libzstd, as zstd frames of raw blocks."""

import ctypes
import ctypes.util
import dataclasses
import re
import struct
import subprocess

MASK = (1 << 64) - 1
FILE_START, RECORD_START = 24, 48
TILE, BLOCK, END = 1, 2, 3


def hash64(x):
    x ^= x >> 30
    x = x * 0xBF58476D1CE4E5B9 & MASK
    x ^= x >> 27
    x = x * 0x94D049BB133111EB & MASK
    return x ^ x >> 31


def combined(h, word):
    return hash64(h ^ (hash64((word + 0x9E3779B97F4A7C15) & MASK) + 0x9E3779B97F4A7C15 & MASK))


def fingerprint(data):
    h = combined(0, len(data))
    padded = data + bytes(-len(data) % 8)
    for (word,) in struct.iter_unpack("<Q", padded):
        h = combined(h, word)
    return h


def stored(data, declared=None):
    """Returns `data` as a zstd frame of raw blocks. If `declared` is given, the frame declares this unpacked size."""
    frame = bytearray(b"\x28\xb5\x2f\xfd\xe0" + struct.pack("<Q", len(data) if declared is None else declared))
    max_part_bytes = 1 << 17
    parts = [data[i : i + max_part_bytes] for i in range(0, len(data), max_part_bytes)] or [b""]
    for i, part in enumerate(parts):
        frame += (len(part) << 3 | (i == len(parts) - 1)).to_bytes(3, "little") + part
    return bytes(frame)


@dataclasses.dataclass
class Record:
    kind: int
    number: int
    data: bytes  # the unpacked contents
    size: int | None = None  # the size of `data` that the record declares; None: the true size
    packed: bytes | None = None  # the packed contents; None: stored(data)
    packed_size: int | None = None
    checksum: int | None = None
    own_checksum: int | None = None
    at: int = 0  # the record's offset in the file from which it was read

    def to_bytes(self):
        packed = stored(self.data) if self.packed is None else self.packed
        start = b"EMBR" + struct.pack(
            "<IQQQQ", self.kind, self.number & MASK, len(self.data) if self.size is None else self.size,
            len(packed) if self.packed_size is None else self.packed_size,
            fingerprint(packed) if self.checksum is None else self.checksum)
        own = fingerprint(start) if self.own_checksum is None else self.own_checksum
        return start + struct.pack("<Q", own) + packed


def file_start(head, form=1, size=None, checksum=None):
    head = head.encode() if isinstance(head, str) else head
    return b"EMBRECF\n" + struct.pack("<IIQ", form, len(head) if size is None else size,
                                      fingerprint(head) if checksum is None else checksum) + head


def packed_file(head, records):
    return file_start(head) + b"".join(record.to_bytes() for record in records)


def zstd_of(program):
    """Returns the zstd library that the program uses, or None."""
    listed = subprocess.run(["ldd", program], capture_output=True, text=True).stdout
    found = re.search(r"libzstd\S* => (\S+)", listed)
    name = found[1] if found else ctypes.util.find_library("zstd")
    try:
        library = ctypes.CDLL(name) if name else None
    except OSError:
        return None
    if library:
        library.ZSTD_decompress.restype = ctypes.c_size_t
        library.ZSTD_decompress.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t]
    return library


def parsed_file(data, zstd=None):
    """Returns a file's header and records, and checks their checksums. Unpacks the records if `zstd` is given."""
    assert data[:8] == b"EMBRECF\n"
    form, size, checksum = struct.unpack_from("<IIQ", data, 8)
    head = data[FILE_START : FILE_START + size]
    assert form == 1 and fingerprint(head) == checksum, "the checksum function has changed"
    records, at = [], FILE_START + size
    while at < len(data):
        kind, number, size, packed_size, checksum, own = struct.unpack_from("<IQQQQQ", data, at + 4)
        assert fingerprint(data[at : at + 40]) == own
        packed = data[at + RECORD_START : at + RECORD_START + packed_size]
        assert fingerprint(packed) == checksum
        unpacked = b""
        if zstd:
            room = ctypes.create_string_buffer(max(1, size))
            assert zstd.ZSTD_decompress(room, size, packed, packed_size) == size
            unpacked = room.raw[:size]
        records.append(Record(kind, number, unpacked, size, packed, packed_size, checksum, own, at))
        at += RECORD_START + packed_size
    return head, records
