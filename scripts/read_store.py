#!/usr/bin/env python3
"""Shows what a store holds: visibility, and how to read the cut of a receiver from it, or a prepared room. Needs h5py."""
import argparse
import sys
import zlib

try:
    import h5py
    import numpy
except ImportError:
    sys.exit("read_store.py: needs h5py; install it (Debian: python3-h5py)")


def check_envelope(path):
    """The first 512 bytes: magic, version, CRC-32 of all bytes but its own four, bytes behind the envelope, kind.
    Gives the kind: 0 for visibility, 1 for a room."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:16] != b"\x89COPPICE STORE\r\n":
        sys.exit(f"{path}: is no store")
    version, checksum, payload = (int.from_bytes(data[a:b], "little") for a, b in ((16, 20), (20, 24), (24, 32)))
    is_whole = payload == len(data) - 512 and checksum == zlib.crc32(data[24:], zlib.crc32(data[:20]))
    print(f"format version {version}, {len(data)} bytes, checksum {'matches' if is_whole else 'DOES NOT MATCH'}")
    return int.from_bytes(data[32:36], "little")


def settings(file):
    """Keys and values, each ended by a NUL."""
    texts = bytes(file["settings"][()]).decode("utf-8", "replace").split("\0")[:-1]
    return dict(zip(texts[::2], texts[1::2]))


def cut(file, receiver):
    """(first leaf, end, visibility) of each piece: bit k of the mask says that a piece ends behind granule k."""
    granule = 1 << int(file.attrs["granule_log2"])
    bits_of = lambda words: numpy.unpackbits(words.astype("<u4").view(numpy.uint8), bitorder="little")
    first = sum(int(bits_of(file["cuts/mask"][begin:min(begin + 1024, receiver)].ravel()).sum())
                for begin in range(0, receiver, 1024))
    ends = (numpy.flatnonzero(bits_of(file["cuts/mask"][receiver])) + 1) * granule
    values = file["cuts/value"][first:first + len(ends)] / (2.0 ** int(file.attrs["value_bits"]) - 1)
    return list(zip([0, *ends[:-1]], ends, values))


def print_datasets(file, what):
    receivers = max(1, int(file.attrs[f"{what}_count"]))
    print(f"\n{'dataset':24}{'shape':>16}  {'type':8}{'stored':>9}{'decoded':>9}  bytes a {what}")
    total = numpy.zeros(2)

    def print_dataset(name, item):
        if isinstance(item, h5py.Dataset):
            sizes = numpy.array([item.id.get_storage_size(), item.nbytes]) / receivers
            total[:] += sizes
            shape = " x ".join(map(str, item.shape))
            print(f"{name:24}{shape:>16}  {str(item.dtype):8}{sizes[0]:9.2f}{sizes[1]:9.2f}")

    file.visititems(print_dataset)
    print(f"{'all':24}{'':>16}  {'':8}{total[0]:9.2f}{total[1]:9.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("store")
    parser.add_argument("--receiver", type=int, default=0, help="whose cut is shown (0)")
    arguments = parser.parse_args()
    is_room = check_envelope(arguments.store) == 1
    with h5py.File(arguments.store, "r") as file:
        for key, value in sorted(file.attrs.items()):
            print(f"{key}: {value}")
        for key, value in settings(file).items():
            print(f"{key} = {value}")
        print_datasets(file, "sample" if is_room else "receiver")
        if not is_room and arguments.receiver < file.attrs["receiver_count"]:
            print(f"\nvisibility from receiver {arguments.receiver}")
            for begin, end, value in cut(file, arguments.receiver):
                print(f"leaves {begin} to {end}: {value:.4f}")


if __name__ == "__main__":
    main()
