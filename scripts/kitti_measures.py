"""Measures of a street by LiDAR: points of its scans, and how an estimate has its moving objects."""
import csv
import math
import statistics
import struct

EVERY = 12  # of the scans is read
MAX_RANGE_M = 60  # the recording has no points beyond
RANGES_M = [(0, 10), (10, 20), (20, 40), (40, 60)]


def ranges(path):
    """Of the points of a binary PCD, within MAX_RANGE_M."""
    data = path.read_bytes()
    end = data.index(b"DATA binary\n") + len(b"DATA binary\n")
    header = dict(line.split(" ", 1) for line in data[:end].decode().splitlines() if " " in line and line[0] != "#")
    stride = sum(map(int, header["SIZE"].split()))
    count = int(header["POINTS"])
    distances = (math.hypot(*struct.unpack_from("<3f", data, end + i * stride)) for i in range(count))
    return [distance for distance in distances if distance <= MAX_RANGE_M]


def scan_metrics(folder):
    scans = [ranges(path) for path in sorted(folder.glob("*.pcd"))[::EVERY]]
    metrics = {f"points a scan within {MAX_RANGE_M} m": statistics.mean(map(len, scans))}
    for low, high in RANGES_M:
        metrics[f"points a scan at {low}-{high} m"] = statistics.mean(sum(low <= r < high for r in scan) for scan in scans)
    return metrics


def mover_metrics(evaluation):
    """Coverage of each mover, and the median error of its extents over the frames that have an estimate."""
    objects = {}
    for row in csv.DictReader((evaluation / "frames.csv").open()):
        objects.setdefault(row["name"], []).append(row)
    metrics = {}
    for name, rows in sorted(objects.items()):
        found = [row for row in rows if row["est_semi_axis_x_m"]]
        metrics[f"{name}: coverage [share]"] = len(found) / len(rows)
        for axis in "xyz" if found else "":
            errors = [2 * (float(row[f"est_semi_axis_{axis}_m"]) - float(row[f"true_semi_axis_{axis}_m"])) for row in found]
            metrics[f"{name}: error of extent {axis} [m]"] = statistics.median(errors)
    return metrics
