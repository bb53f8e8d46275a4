"""All runs of a sweep: one figure, and a table with a line a run."""
import tomllib
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

series = {}
for folder in Path("runs/modulus").iterdir():
    if not (folder / "summary.json").exists():  # no run, or none that has ended
        continue
    scene = tomllib.loads((folder / "scene.toml").read_text())  # with every default written out
    modulus = scene["membrane"][0]["area"]["linear"]["modulus"]
    series[modulus] = pd.read_csv(folder / "series.csv", index_col="time")
table = pd.concat(series, names=["modulus"]).sort_index()  # rows (modulus, time)

half_width = table["membrane.extent_x"].unstack("modulus")  # a column for each modulus
axes = half_width.plot(figsize=(5, 3), ylabel="half the width", style=["-", "--", "-.", ":"])
axes.figure.tight_layout()
axes.figure.savefig("runs/modulus/sweep.png", dpi=120)

balances = table[["energy_balance", "elastic_balance"]].abs().groupby("modulus").max()
least = half_width.min().rename("least half-width")
results = pd.concat([least, half_width.idxmin().rename("at"), balances], axis=1)
results.to_csv("runs/modulus/sweep.csv", float_format="%.4g")
