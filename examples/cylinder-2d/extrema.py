"""Extrema of drag and lift and the Strouhal number of the last time unit of a series, with errors against DFG 2D-2.

    python3 extrema.py runs/cylinder-2d/series.csv ... [--last 1.0]

An extremum is that of the parabola through its highest row and the two beside it; maxima and minima of the drag are means over the
periods, those of the lift are of the last one. `still` is the change of the lift's maximum from the last period but one to the last,
relative; times 1/(1 - q), q the ratio of two such changes, it is what the lift is still going to change (`limit`).
"""
import csv
import sys

PUBLISHED = {"c_D max": 3.2274, "c_D min": 3.1643, "c_L max": 0.9866, "c_L min": -1.0213, "St": 0.30184}


def peaks(t, y, sign):
    """Times and values of the maxima of sign * y."""
    found = []
    for i in range(1, len(y) - 1):
        a, b, c = (sign * v for v in y[i - 1 : i + 2])
        if a <= b > c:
            s = 0.5 * (a - c) / (a - 2 * b + c)
            found.append((t[i] + s * (t[i + 1] - t[i]), sign * (b - 0.25 * (a - c) * s)))
    return found


def extrema(path, last):
    with open(path) as file:
        rows = [r for r in csv.DictReader(file) if r["cylinder_drag"]]
    column = lambda name: [float(r[name]) for r in rows]
    t, drag, lift = column("time"), column("cylinder_drag"), column("cylinder_lift")
    late = lambda found: [p for p in found if p[0] > t[-1] - last]
    mean = lambda found: sum(p[1] for p in found) / len(found)
    high, low = peaks(t, lift, 1), late(peaks(t, lift, -1))
    ends = late(high)
    values = {
        "c_D max": mean(late(peaks(t, drag, 1))),
        "c_D min": mean(late(peaks(t, drag, -1))),
        "c_L max": ends[-1][1],
        "c_L min": low[-1][1],
        "St": 0.1 * (len(ends) - 1) / (ends[-1][0] - ends[0][0]),
    }
    a, b, c = (p[1] for p in high[-3:])
    q = (c - b) / (b - a) if b != a else 0.0
    limit = c + (c - b) * q / (1 - q) if 0 < q < 0.9 else c
    return values, c / b - 1, limit


def main():
    words = sys.argv[1:]
    last = 1.0
    if "--last" in words:
        i = words.index("--last")
        last = float(words[i + 1])
        del words[i : i + 2]
    for path in words:
        values, still, limit = extrema(path, last)
        print(path)
        for name, v in values.items():
            print(f"  {name:8} {v:9.5f}  {100 * (v / PUBLISHED[name] - 1):+7.2f} %")
        print(f"  c_L max still moves by {still:+.1e} a period; limit {limit:.5f}, {100 * (limit / 0.9866 - 1):+.2f} %")


main()
