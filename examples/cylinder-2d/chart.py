"""Work-precision chart of data/precision.csv: error of the largest lift of DFG 2D-2 against CPU seconds a unit of time.

    python3 chart.py          writes data/precision.png beside this file
"""
import csv
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

STYLE = {
    "immersa": ("tab:blue", "o"),
    "FreeFEM": ("tab:orange", "s"),
    "NGSolve": ("tab:green", "^"),
}
LINES = ["-", "--", ":", "-."]
data = Path(__file__).parent / "data"
curves = {}
with open(data / "precision.csv") as file:
    for row in csv.DictReader(file):
        error = row["c_L max limit"] or row["c_L max"]
        if error and row["cpu per time unit"]:
            point = (float(row["cpu per time unit"]), max(abs(float(error)), 0.02), row["step"])
            curves.setdefault((row["program"], row["scheme"]), []).append(point)
figure, axes = plt.subplots(figsize=(7.2, 4.6), dpi=140)
seen = {}
for (program, scheme), points in curves.items():
    colour, marker = STYLE[program]
    line = LINES[seen.setdefault(program, []).__len__() % len(LINES)]
    seen[program].append(scheme)
    points.sort(key=lambda p: p[0])
    x, y = [p[0] for p in points], [p[1] for p in points]
    axes.loglog(x, y, line, color=colour, marker=marker, label=f"{program}: {scheme}")
    for cpu, error, step in points:
        axes.annotate(step, (cpu, error), textcoords="offset points", xytext=(5, 4), fontsize=7, color=colour)
axes.set_xlabel("CPU seconds a unit of time (one thread)")
axes.set_ylabel("error of the largest lift in %")
axes.grid(True, which="both", linewidth=0.3)
axes.legend(fontsize=7)
figure.tight_layout()
figure.savefig(data / "precision.png")
