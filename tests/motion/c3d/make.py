"""Writes the C3D files of this folder with the writers of ezc3d and c3d (PyPI), and the same motion in the byte orders that these do not write.

    pip install ezc3d==1.7.2 c3d==0.6.0 numpy
    python make.py

`values.csv` has the positions in millimetres as the reader of the package c3d returns them from `ezc3d_float.c3d`; empty cells are gaps. The script
ends with an error if a reader of the two packages that knows the byte order reads anything else from any of the files.
"""

import struct
import warnings

import c3d
import ezc3d
import numpy as np

warnings.filterwarnings("ignore")
LABELS = ["tip1", "tip2", "base 1"]
RATE, FRAMES = 120.0, 20
SCALE = 0.0625  # of integers; every value is a multiple


def motion():
    """[frame, marker, xyz] in mm, multiples of SCALE; not a number where a marker is not seen."""
    t = np.arange(FRAMES) / RATE
    points = np.empty((FRAMES, 3, 3))
    for k in range(3):
        points[:, k] = np.stack([100 + 10 * k + 0 * t, -20 * k + 500 * t, 5 - 8 * np.cos(40 * t + k)], axis=1)
    points = np.round(points / SCALE) * SCALE
    points[4:7, 1] = np.nan
    points[0, 2] = np.nan
    return points


def by_ezc3d(points):
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [RATE]
    file["parameters"]["POINT"]["LABELS"]["value"] = LABELS
    file["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    data = np.ones((4, 3, FRAMES))
    data[:3] = points.transpose(2, 1, 0)
    file["data"]["points"] = data
    seen = ~np.isnan(points[:, :, 0]).T
    file["data"]["meta_points"] = {
        "residuals": np.where(seen, 0.5, -1.0)[None],
        "camera_masks": np.zeros((7, 3, FRAMES), dtype=bool),
    }
    file.write("ezc3d_float.c3d")


def by_c3d(points):
    writer = c3d.Writer(point_rate=RATE, point_scale=-1.0)
    writer.set_point_labels(LABELS)
    seen = ~np.isnan(points[:, :, 0])
    for frame in range(FRAMES):
        row = np.zeros((3, 5), dtype=np.float32)
        row[:, :3] = np.nan_to_num(points[frame])
        row[:, 3] = np.where(seen[frame], 0.0, -1.0)
        writer.add_frames([(row, np.empty((0, 0)))])
    with open("c3d_float.c3d", "wb") as handle:
        writer.write(handle)


class Order:
    """Numbers of a processor, by the format's documentation."""

    def __init__(self, code):
        self.code, self.sign = code, ">" if code == 86 else "<"

    def word(self, n):
        return struct.pack(self.sign + "H", n & 0xFFFF)

    def float(self, x):
        if self.code != 85:
            return struct.pack(self.sign + "f", x)
        little = struct.pack("<f", 4 * x)  # VAX F_floating: two more in the exponent, words exchanged
        return little[2:] + little[:2]


def parameters(order, scale, start):
    out = bytearray([1, 80, 0, order.code])

    def group(number, name):
        out.extend(struct.pack("bb", len(name), -number) + name.encode() + order.word(3) + b"\0")

    def parameter(number, name, kind, dimensions, data):
        body = struct.pack("bB", kind, len(dimensions)) + bytes(dimensions) + data + b"\0"
        out.extend(struct.pack("bb", len(name), number) + name.encode() + order.word(2 + len(body)) + body)

    group(1, "POINT")
    parameter(1, "USED", 2, [], order.word(3))
    parameter(1, "FRAMES", 2, [], order.word(FRAMES))
    parameter(1, "SCALE", 4, [], order.float(scale))
    parameter(1, "RATE", 4, [], order.float(RATE))
    parameter(1, "DATA_START", 2, [], order.word(start))
    parameter(1, "UNITS", -1, [2], b"mm")
    parameter(1, "LABELS", -1, [8, 3], "".join(name.ljust(8) for name in LABELS).encode())
    group(2, "ANALOG")
    parameter(2, "USED", 2, [], order.word(2))
    parameter(2, "RATE", 4, [], order.float(2 * RATE))
    parameter(2, "GEN_SCALE", 4, [], order.float(1.0))
    parameter(2, "SCALE", 4, [2], order.float(1.0) + order.float(1.0))
    parameter(2, "OFFSET", 2, [2], order.word(0) + order.word(0))
    out.extend(b"\0\0")
    out[2] = -(-len(out) // 512)
    return bytes(out.ljust(512 * out[2], b"\0"))


def by_hand(name, code, floats, points):
    """Two analog channels with two samples of each frame lie between the points and are to be skipped."""
    order = Order(code)
    scale = -SCALE if floats else SCALE
    size = len(parameters(order, scale, 3)) // 512
    start = 2 + size
    head = bytearray([2, 80]) + order.word(3) + order.word(4) + order.word(1) + order.word(FRAMES) + order.word(10)
    head += order.float(scale) + order.word(start) + order.word(2) + order.float(RATE)
    data = bytearray()
    for frame in points:
        for point in frame:
            seen = not np.isnan(point[0])
            if floats:
                data += b"".join(order.float(x) for x in (*np.nan_to_num(point), 0.0 if seen else -1.0))
            else:
                data += b"".join(order.word(round(x / SCALE)) for x in np.nan_to_num(point))
                data += order.word(0 if seen else -1)
        data += b"".join((order.float(7.0 + k) if floats else order.word(7 + k)) for k in range(4))
    with open(name, "wb") as handle:
        whole = bytes(head).ljust(512, b"\0") + parameters(order, scale, start) + bytes(data)
        handle.write(whole.ljust(-(-len(whole) // 512) * 512, b"\0"))


def read_c3d(name):
    with open(name, "rb") as handle:
        rows = [points for _, points, _ in c3d.Reader(handle).read_frames()]
    rows = np.array(rows)
    return np.where(rows[:, :, 3:4] < 0, np.nan, rows[:, :, :3])


def read_ezc3d(name):
    file = ezc3d.c3d(name)
    points = file["data"]["points"][:3].transpose(2, 1, 0)
    return np.where(file["data"]["meta_points"]["residuals"][0].T[:, :, None] < 0, np.nan, points)


def main():
    points = motion()
    by_ezc3d(points)
    by_c3d(points)
    names = ["ezc3d_float.c3d", "c3d_float.c3d"]
    for code, word in ((84, "intel"), (85, "dec"), (86, "mips")):
        for floats, kind in ((True, "float"), (False, "integer")):
            names.append(f"{word}_{kind}.c3d")
            by_hand(names[-1], code, floats, points)
    differs = []
    for name in names:
        for reader in (read_c3d, read_ezc3d):
            try:
                found = reader(name)
            except Exception as error:  # a reader that does not know a byte order
                print(f"{name}: {reader.__name__} cannot read it: {error!r}")
                continue
            same = found.shape == points.shape and np.allclose(found, points, atol=1e-4, equal_nan=True)
            print(f"{name}: {reader.__name__} {'agrees' if same else 'differs'}")
            differs += [] if same else [name]
    if differs:
        raise SystemExit(f"differences in {differs}")
    expected = read_c3d("ezc3d_float.c3d")
    with open("values.csv", "w") as handle:
        for frame in expected:
            cells = ("" if np.isnan(x) else repr(float(x)) for x in frame.ravel())
            handle.write(",".join(cells) + "\n")


main()
