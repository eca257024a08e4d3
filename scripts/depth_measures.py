"""Measures of 16-bit depth images, by the standard library alone: noise, its correlation, edges, holes, bias on a cube."""
import math
import statistics
import struct
import zlib

WINDOW = 20  # px, side of a plane fit
LAGS = range(1, 13)
MAX_TILT = 1.5  # of a plane: tangent of its angle to the image
STEP = 0.1  # relative difference of depth that makes an edge
LOOK_PX = 6  # half of what is counted about an edge


def read_png16(path):
    """Rows of a 16-bit grey PNG without interlace."""
    data = path.read_bytes()
    place, packed = 8, b""
    while place < len(data):
        size, kind = struct.unpack(">I4s", data[place:place + 8])
        body = data[place + 8:place + 8 + size]
        if kind == b"IHDR":
            width, height, bits, color, _, _, interlace = struct.unpack(">IIBBBBB", body)
            if (bits, color, interlace) != (16, 0, 0):
                raise ValueError(f"{path}: no 16-bit grey PNG")
        elif kind == b"IDAT":
            packed += body
        place += size + 12
    rows, above = [], bytes(2 * width)
    raw = zlib.decompress(packed)
    for v in range(height):
        start = v * (2 * width + 1)
        above = unfilter(raw[start], bytearray(raw[start + 1:start + 1 + 2 * width]), above)
        rows.append(struct.unpack(f">{width}H", above))
    return rows


def unfilter(kind, row, above):
    """PNG, section 9: the bytes of a row of two bytes a pixel."""
    if kind == 2:
        return bytes((a + b) & 255 for a, b in zip(row, above))
    for i in range(len(row) if kind else 0):
        left = row[i - 2] if i > 1 else 0
        if kind == 1:
            guess = left
        elif kind == 3:
            guess = (left + above[i]) // 2
        else:
            guess = paeth(left, above[i], above[i - 2] if i > 1 else 0)
        row[i] = (row[i] + guess) & 255
    return bytes(row)


def paeth(left, up, corner):
    to_left, to_up, to_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
    if to_left <= to_up and to_left <= to_corner:
        return left
    return up if to_up <= to_corner else corner


def holes(rows):
    return statistics.mean(row.count(0) / len(row) for row in rows)


def windows(rows):
    for v in range(0, len(rows) - WINDOW, WINDOW):
        for u in range(0, len(rows[0]) - WINDOW, WINDOW):
            patch = [rows[v + j][u:u + WINDOW] for j in range(WINDOW)]
            if all(map(all, patch)):
                yield patch


def plane_noise(rows, units_per_m, focal_px):
    """(range [m], standard deviation of inverse depth [1/m], correlations in x, in y) of each patch that is a plane."""
    middle = (WINDOW - 1) / 2
    ramp = [i - middle for i in range(WINDOW)]
    spread = WINDOW * sum(x * x for x in ramp)
    for patch in windows(rows):
        inverse = [[units_per_m / z for z in line] for line in patch]
        mean = sum(map(sum, inverse)) / WINDOW ** 2
        across = sum(x * value for line in inverse for x, value in zip(ramp, line)) / spread
        down = sum(y * sum(line) for y, line in zip(ramp, inverse)) / spread
        if math.hypot(across, down) * focal_px > MAX_TILT * mean:
            continue
        left = [[value - mean - across * x - down * y for x, value in zip(ramp, line)] for y, line in zip(ramp, inverse)]
        power = sum(r * r for line in left for r in line)
        if power > 0:
            columns = list(zip(*left))
            yield (1 / mean, math.sqrt(power / (WINDOW ** 2 - 3)), correlations(left, power), correlations(columns, power))


def correlations(lines, power):
    """Autocorrelation along the lines at each of LAGS."""
    result = []
    for lag in LAGS:
        products = sum(a * b for line in lines for a, b in zip(line, line[lag:]))
        result.append(products / (WINDOW - lag) * WINDOW / power)
    return result


def half_length(curves):
    """The lag [px] at which the median correlation falls to a half."""
    before = 1.0
    for lag, values in zip(LAGS, zip(*curves)):
        now = statistics.median(values)
        if now < 0.5:
            return lag - 1 + (before - 0.5) / (before - now)
        before = now
    return float(LAGS[-1])


def edges(rows):
    """(pixels off both sides, pixels without depth) about each step of depth in every seventh row."""
    for row in rows[4::7]:
        for u in range(12, len(row) - 12):
            left, right = row[u - 10:u - 6], row[u + 6:u + 10]
            if not (flat(left) and flat(right)):
                continue
            a, b = statistics.median(left), statistics.median(right)
            if abs(a - b) > STEP * min(a, b):
                near = row[u - LOOK_PX:u + LOOK_PX]
                yield sum(z > 0 and abs(z - a) > 0.02 * a and abs(z - b) > 0.02 * b for z in near), near.count(0)


def flat(values):
    return min(values) > 0 and max(values) - min(values) < 0.01 * max(values)


def cube_bias(rows, units_per_m, camera, cube):
    """Median of measured less true depth [m] on the inner parts of a cube's faces."""
    center, turn, half = cube["position_m"], rotation(cube["quaternion_xyzw"]), cube["size_m"] / 2
    eye = [-sum(turn[i][k] * center[i] for i in range(3)) for k in range(3)]
    errors = []
    for v, row in enumerate(rows):
        for u, z in enumerate(row):
            ray = ((u - camera["cx"]) / camera["fx"], (v - camera["cy"]) / camera["fy"], 1)
            if z and abs(ray[0] - center[0] / center[2]) < 0.2 and abs(ray[1] - center[1] / center[2]) < 0.2:
                depth = depth_of_cube(eye, [sum(turn[i][k] * ray[i] for i in range(3)) for k in range(3)], half)
                errors += [z / units_per_m - depth] if depth else []
    return statistics.median(errors)


def depth_of_cube(eye, ray, half):
    """Where the ray meets a face, if that is in its inner 80 %."""
    for k in range(3):
        if abs(eye[k]) > half and eye[k] * ray[k] < 0:
            depth = (math.copysign(half, eye[k]) - eye[k]) / ray[k]
            if all(abs(eye[i] + depth * ray[i]) < 0.8 * half for i in range(3) if i != k):
                return depth
    return None


def rotation(quaternion):
    x, y, z, w = quaternion
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
